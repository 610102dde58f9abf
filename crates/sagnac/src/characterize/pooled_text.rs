//! The one sensor of several logs in a terminal: its table, what its runs know, and each log's findings under its name.

use super::text::{beside, rival, row, short_name, shown_sensor, temperature_row};
use super::{Outcome, SensorAxis, axis_names, key_of, pool};
use sagnac_analysis::fit::{Estimate, Term};
use sagnac_core::Sensor;
use sagnac_report::text::{Document, Table, Unit, general, term_in_sentence};

/// Runs that give numbers on some axis; none where the logs are not of one sensor.
pub(super) fn runs_with_numbers(outcome: &Outcome) -> Option<usize> {
    let axes = outcome.sensor.as_ref()?;
    let used = |log: &usize| axes.iter().any(|a| a.used.contains(log));
    Some((0..outcome.logs.len()).filter(used).count())
}

pub(super) fn add(outcome: &Outcome, axes: &[SensorAxis], out: &mut Document) {
    for sensor in Sensor::ALL {
        table(axes, sensor, out);
    }
    out.blank();
    if let Some(sentence) = run_to_run(axes) {
        out.note(sentence);
    }
    let follow = axes
        .iter()
        .filter_map(|a| Some((a, a.pooled.run_to_run.reference_c?)));
    let follow: Vec<_> = follow.collect();
    if let Some((_, reference_c)) = follow.first() {
        let names: Vec<&str> = follow.iter().map(|(a, _)| a.axis.as_str()).collect();
        out.note(format!(
            "{}: the runs' means follow their temperatures, counted from {} degC.",
            names.join(", "),
            general(*reference_c, 3)
        ));
    }
    for axis in axes {
        for &(a, b) in &axis.pooled.confused {
            let (other, which) = rival(axis.sensor, b, &axis.pooled.gauss_markov);
            out.note(format!(
                "{}: these logs cannot tell {} from {other}; {which} bounded from above.",
                axis.axis,
                term_in_sentence(key_of(axis.sensor, a)),
            ));
        }
    }
    for sentence in left_out(outcome, axes) {
        out.warning(sentence);
    }
    for log in &outcome.logs {
        let is_told = log.axes.iter().filter_map(|a| a.estimate.as_ref());
        let misfit = is_told.flat_map(|e| &e.findings).count() > 0;
        if log.issues.is_empty() && log.notes.is_empty() && !misfit {
            continue;
        }
        out.blank();
        out.heading(log.name.clone());
        beside(log, false, out);
    }
}

/// How well the runs know the bias from run to run: the axis that knows it worst.
fn run_to_run(axes: &[SensorAxis]) -> Option<String> {
    let axis = axes.iter().min_by_key(|a| a.pooled.run_to_run.freedom)?;
    let own = &axis.pooled.run_to_run;
    let taken = match axis.runs.saturating_sub(1 + own.freedom) {
        0 => String::new(),
        1 => ", one degree of freedom of which goes to the temperature,".to_owned(),
        n => format!(", {n} degrees of freedom of which go to the temperature,"),
    };
    let factor = match own.freedom {
        1 => "70",
        2 => "12",
        3 => "7",
        4 => "5",
        5 => "4",
        6 | 7 => "3",
        _ => return None,
    };
    Some(format!(
        "{} runs{taken} know a run-to-run bias to a factor of about {factor} only.",
        axis.runs
    ))
}

/// Axes that are not pooled, and logs that give no numbers for one that is.
fn left_out(outcome: &Outcome, axes: &[SensorAxis]) -> Vec<String> {
    let mut out = Vec::new();
    for name in axis_names(&outcome.logs) {
        if axes.iter().any(|a| a.axis == name) {
            continue;
        }
        let in_all = outcome
            .logs
            .iter()
            .all(|l| l.axes.iter().any(|a| a.axis == name));
        out.push(if in_all {
            format!("{name}: fewer than two of the logs give numbers; not pooled")
        } else {
            format!("{name}: not in every log; not pooled")
        });
    }
    for (place, log) in outcome.logs.iter().enumerate() {
        let none: Vec<&str> = axes
            .iter()
            .filter(|a| !a.used.contains(&place))
            .map(|a| a.axis.as_str())
            .collect();
        if let Some(first) = none.first() {
            out.push(format!(
                "{}: {} left out: {}",
                log.name,
                none.join(", "),
                pool::why_none(log, first)
            ));
        }
    }
    out
}

fn table(axes: &[SensorAxis], sensor: Sensor, out: &mut Document) {
    let axes: Vec<&SensorAxis> = axes.iter().filter(|a| a.sensor == sensor).collect();
    if axes.is_empty() {
        return;
    }
    let shown_as = shown_sensor(sensor);
    let mut heading = vec![shown_as.title()];
    heading.extend(axes.iter().map(|a| ["x", "y", "z"][a.index]));
    heading.push("");
    let mut table = Table::estimates(&heading);
    let pick = |f: &dyn Fn(&SensorAxis) -> Estimate| -> Vec<Estimate> {
        axes.iter().map(|a| f(a)).collect()
    };
    for (term, cells) in [
        (Term::Quantization, pick(&|a| a.pooled.quantization)),
        (Term::White, pick(&|a| a.pooled.white)),
        (Term::Flicker, pick(&|a| a.pooled.flicker)),
        (Term::RandomWalk, pick(&|a| a.pooled.random_walk)),
    ] {
        if term == Term::Quantization && !cells.iter().any(Estimate::is_detected) {
            continue;
        }
        let key = key_of(sensor, term);
        row(
            &mut table,
            short_name(key),
            Unit::of_term(shown_as, key),
            &cells,
        );
    }
    let most = axes.iter().map(|a| markov(a, 0).count()).max().unwrap_or(0);
    for place in 0..most {
        let cell = |time: bool| {
            pick(&|a| {
                markov(a, place).next().map_or(Estimate::ABSENT, |g| {
                    if time { g.correlation_time_s } else { g.sigma }
                })
            })
        };
        let name = if most > 1 {
            format!("Gauss-Markov {}", place + 1)
        } else {
            "Gauss-Markov sigma".to_owned()
        };
        let unit = Unit::of_term(shown_as, "gauss_markov");
        row(&mut table, &name, unit, &cell(false));
        row(&mut table, "  correlation time", Unit::S, &cell(true));
    }
    let stability = pick(&|a| a.pooled.run_to_run.stability);
    row(
        &mut table,
        "Bias stability",
        Unit::of_term(shown_as, "mean"),
        &stability,
    );
    for power in [1, 2] {
        let cells = pick(&|a| {
            let found = a.pooled.run_to_run.temperature.get(power - 1);
            found.map_or(Estimate::ABSENT, |&(value, lower, upper)| {
                Estimate::detected(value, lower, upper, (upper - lower) / 3.92)
            })
        });
        temperature_row(&mut table, power, shown_as, &cells);
    }
    out.blank();
    out.table(table);
}

/// The detected Gauss–Markov processes of an axis from the one at `place` on.
fn markov(
    axis: &SensorAxis,
    place: usize,
) -> impl Iterator<Item = &sagnac_analysis::fit::GaussMarkovEstimate> {
    let all = axis.pooled.gauss_markov.iter();
    all.filter(|g| g.sigma.is_detected()).skip(place)
}
