//! What the fit took out of an axis beside its noise: rows of the page's table, and a sentence beside its Allan deviation.

use super::text::{shown, shown_sensor};
use super::{AxisOutcome, LogOutcome};
use sagnac_analysis::fit::{Estimate, Regressor, RegressorKind};
use sagnac_core::Sensor;
use sagnac_report::html::{ParameterRow, Rich};
use sagnac_report::text::{Estimate as Shown, Unit, clock};

fn regressors(axis: &AxisOutcome) -> impl Iterator<Item = &Regressor> {
    axis.estimate.iter().flat_map(|e| &e.regressors)
}

/// A regressor's value with its 95 % interval.
pub(super) fn estimate_of(r: &Regressor) -> Estimate {
    Estimate::detected(r.value, r.lower, r.upper, (r.upper - r.lower) / 3.92)
}

/// The coefficient of a power of the temperature, where the axis has one.
pub(super) fn temperature_of(axis: &AxisOutcome, power: usize) -> Estimate {
    let is_wanted =
        |r: &&Regressor| matches!(r.kind, RegressorKind::Temperature { power: p } if p == power);
    regressors(axis)
        .find(is_wanted)
        .map_or(Estimate::ABSENT, estimate_of)
}

/// Rows of what was taken out: temperature, warm-up with its time, steps; none where nothing was.
pub(super) fn rows(axes: &[&AxisOutcome], sensor: Sensor) -> Vec<ParameterRow> {
    let as_shown = shown_sensor(sensor);
    let mut out = Vec::new();
    let mut push =
        |term: &str, name: String, per: &'static str, of: &dyn Fn(&AxisOutcome) -> Shown| {
            let mut cells = [Shown::Absent; 3];
            for axis in axes {
                cells[axis.index] = of(axis);
            }
            if cells.iter().all(|c| *c == Shown::Absent) {
                return;
            }
            let mut row = ParameterRow::estimates(as_shown, term, cells);
            (row.name, row.per) = (name, per);
            if term == "warm_up_time" {
                row.unit = Some(Unit::S);
            }
            out.push(row);
        };
    for (power, name, per) in [(1, "Bias per K", "/K"), (2, "Bias per K²", "/K²")] {
        let of = |a: &AxisOutcome| shown(&temperature_of(a, power));
        push(&format!("temperature.{power}"), name.to_owned(), per, &of);
    }
    let warm_up = |a: &AxisOutcome| {
        regressors(a).find_map(|r| match r.kind {
            RegressorKind::WarmUp { time_constant_s } => Some((estimate_of(r), time_constant_s)),
            _ => None,
        })
    };
    let size = |a: &AxisOutcome| warm_up(a).map_or(Shown::Absent, |w| shown(&w.0));
    push("warm_up", "Warm-up, at the start".to_owned(), "", &size);
    let time = |a: &AxisOutcome| warm_up(a).map_or(Shown::Absent, |w| Shown::Value(w.1));
    push("warm_up_time", "Warm-up, its time".to_owned(), "", &time);
    for at in step_times(axes) {
        let of = |a: &AxisOutcome| {
            let own = regressors(a).find(|r| step_of(r).is_some_and(|t| clock(t) == at));
            own.map_or(Shown::Absent, |r| shown(&estimate_of(r)))
        };
        push("step", format!("Step at {at}"), "", &of);
    }
    out
}

fn step_of(r: &Regressor) -> Option<f64> {
    match r.kind {
        RegressorKind::Step { time_s } => Some(time_s),
        _ => None,
    }
}

/// Times of the steps of a sensor's axes as they are shown, ascending, each once.
fn step_times(axes: &[&AxisOutcome]) -> Vec<String> {
    let mut times: Vec<f64> = axes
        .iter()
        .flat_map(|a| regressors(a))
        .filter_map(step_of)
        .collect();
    times.sort_by(f64::total_cmp);
    let mut shown: Vec<String> = times.into_iter().map(clock).collect();
    shown.dedup();
    shown
}

/// Why a measured curve lies over the fitted one: what the curve holds and the fit took out. Empty where there is nothing.
pub(super) fn taken_out(log: &LogOutcome) -> Rich {
    type Is = fn(&RegressorKind) -> bool;
    let kinds: [(&str, Is); 3] = [
        ("Temperature", |k| {
            matches!(k, RegressorKind::Temperature { .. })
        }),
        ("warm-up", |k| matches!(k, RegressorKind::WarmUp { .. })),
        ("steps", |k| matches!(k, RegressorKind::Step { .. })),
    ];
    let mut told: Vec<String> = Vec::new();
    for (name, is) in kinds {
        let mut of: Vec<String> = Vec::new();
        for sensor in Sensor::ALL {
            let has = |a: &&AxisOutcome| a.sensor == sensor && regressors(a).any(|r| is(&r.kind));
            let axes: Vec<&str> = log
                .axes
                .iter()
                .filter(has)
                .map(|a| ["x", "y", "z"][a.index])
                .collect();
            if !axes.is_empty() {
                of.push(format!("{} {}", sensor.name(), axes.join(", ")));
            }
        }
        if !of.is_empty() {
            told.push(format!("{name} ({})", of.join("; ")));
        }
    }
    let Some((first, rest)) = told.split_first() else {
        return Rich::new();
    };
    let mut subject = first.clone();
    subject[..1].make_ascii_uppercase();
    let listed = match rest.split_last() {
        None => subject,
        Some((last, [])) => format!("{subject} and {last}"),
        Some((last, middle)) => format!("{subject}, {} and {last}", middle.join(", ")),
    };
    let was = if rest.is_empty() && !listed.starts_with("Steps") {
        "was"
    } else {
        "were"
    };
    Rich::new().bold(format!("{listed} {was} taken out by the fit")).plain(
        " and stand in the table; the measured curve still holds them. Where it lies over the orange one at long \
         averaging times, this is why: the noise terms do not carry it.",
    )
}
