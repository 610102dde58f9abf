//! Logs of one sensor pooled, and what is said of those that differ.
//!
//! One log that differs draws the pooled terms until no log fits them. The log farthest from the others is therefore
//! left out and the rest tested again, until the rest agree.

use super::{LogOutcome, Outcome, OutlierNote, SensorAxis, axis_of, segments_of, temperature_of};
use crate::Error;
use rayon::prelude::*;
use sagnac_analysis::compare::{self, Outlier};
use sagnac_analysis::fit::{
    AxisData, AxisEstimate, FitOptions, PooledEstimate, Term, estimate_pooled,
};
use sagnac_core::Sensor;
use sagnac_log::health::Health;
use sagnac_report::text::general;

/// The pooled estimate of the logs that agree on an axis, and how many they are.
///
/// Where fewer than half agree there is nobody to differ from: all logs are pooled and each that does not fit is named.
fn agreeing(
    data: &[AxisData<'_>],
    own: &[Option<&AxisEstimate>],
    options: &FitOptions,
) -> Option<(PooledEstimate, usize)> {
    let all = estimate_pooled(data, options)?;
    let used = all.used.clone();
    let mut left = used.clone();
    let mut found: Vec<Outlier> = all.outliers.clone();
    let mut pooled = all.clone();
    let mut outliers: Vec<Outlier> = Vec::new();
    while !found.is_empty() {
        let suspects: Vec<usize> = found.iter().map(|o| o.log).collect();
        let fits: Vec<(usize, &AxisEstimate)> =
            left.iter().filter_map(|&i| Some((i, own[i]?))).collect();
        if 2 * (left.len() - 1) <= used.len() {
            return Some((all, used.len()));
        }
        let Some(worst) = compare::farthest(&fits, &suspects) else {
            return Some((all, used.len()));
        };
        outliers.extend(found.iter().find(|o| o.log == worst).cloned());
        left.retain(|&i| i != worst);
        let rest: Vec<AxisData<'_>> = left.iter().map(|&i| data[i]).collect();
        let Some(next) = estimate_pooled(&rest, options) else {
            return Some((all, used.len()));
        };
        pooled = next;
        found.clone_from(&pooled.outliers);
        for outlier in &mut found {
            outlier.log = left[outlier.log];
        }
    }
    // How white noise, which every log tells best, compares with that of the logs that agree.
    for outlier in &mut outliers {
        let white = own[outlier.log].map(|e| e.white);
        if let (Some(value), Some(sigma), Some(others)) = (
            white.and_then(|w| w.value),
            white.and_then(|w| w.sigma),
            pooled.white.value,
        ) && (value - others).abs() > 5.0 * sigma
        {
            outlier.ratio = Some(value / others);
        }
    }
    outliers.sort_by_key(|o| o.log);
    pooled.outliers = outliers;
    pooled.used = used;
    Some((pooled, left.len()))
}

/// The axes of a log, `gyro_x, gyro_y`.
fn axes_of(log: &LogOutcome) -> String {
    let names: Vec<&str> = log.axes.iter().map(|a| a.axis.as_str()).collect();
    names.join(", ")
}

/// Why a log gives no numbers for an axis.
pub(super) fn why_none(log: &LogOutcome, axis: &str) -> String {
    let own = log.axes.iter().find(|a| a.axis == axis);
    let issue = || {
        let of =
            |channel: Option<&str>| log.issues.iter().rfind(|i| i.channel.as_deref() == channel);
        of(Some(axis)).or_else(|| of(None).filter(|i| i.kind == sagnac_log::IssueKind::Short))
    };
    match own {
        None => format!("it has no {axis}"),
        Some(a) => match (&a.estimate, issue()) {
            (Some(e), _) if !e.findings.is_empty() => e.findings[0].text.clone(),
            (_, Some(issue)) => issue.text.clone(),
            _ => "no samples are left".to_owned(),
        },
    }
}

pub(super) fn pooled(
    logs: &[LogOutcome],
    healths: &[Health<'_>],
    options: &FitOptions,
) -> Result<Vec<SensorAxis>, Error> {
    let names: Vec<(String, Sensor, usize)> = healths[0]
        .channels
        .iter()
        .filter_map(|c| axis_of(&c.name).map(|(s, a)| (c.name.clone(), s, a)))
        .filter(|(name, ..)| {
            healths
                .iter()
                .all(|h| h.channels.iter().any(|c| c.name == *name))
        })
        .collect();
    if names.is_empty() {
        let each = logs.iter().map(|l| format!("{}: {}", l.name, axes_of(l)));
        return Err(Error::data("the logs have no axis in common")
            .at(each.collect::<Vec<_>>().join("; "))
            .advise("characterize them without --one-sensor"));
    }
    let common: Vec<String> = names.iter().map(|n| n.0.clone()).collect();
    let mut axes: Vec<SensorAxis> = names
        .into_par_iter()
        .filter_map(|(axis, sensor, index)| {
            let places: Vec<usize> = healths
                .iter()
                .filter_map(|h| h.channels.iter().position(|c| c.name == axis))
                .collect();
            let segments: Vec<_> = healths
                .iter()
                .zip(&places)
                .map(|(h, &c)| segments_of(h, c))
                .collect();
            let temperatures: Vec<_> = healths
                .iter()
                .zip(&places)
                .map(|(h, &c)| temperature_of(h, c))
                .collect();
            let data: Vec<AxisData<'_>> = segments
                .iter()
                .zip(&temperatures)
                .zip(healths.iter().zip(&places))
                .map(|((segments, temperature), (h, &c))| AxisData {
                    segments,
                    temperature: temperature.as_deref(),
                    step_s: h.channels[c].step_s,
                    lsb: h.channels[c].lsb,
                })
                .collect();
            let own: Vec<Option<&AxisEstimate>> = logs
                .iter()
                .map(|log| log.axes.iter().find(|a| a.axis == axis)?.estimate.as_ref())
                .collect();
            let (pooled, runs) = agreeing(&data, &own, options)?;
            Some(SensorAxis {
                axis,
                sensor,
                index,
                runs,
                used: pooled.used.clone(),
                pooled,
            })
        })
        .collect();
    if axes.is_empty() {
        let gives = |log: &&LogOutcome| {
            let mut own = log.axes.iter().filter_map(|a| a.estimate.as_ref());
            !own.any(|e| e.p_value.is_some())
        };
        let none = logs.iter().filter(gives);
        let each = none.map(|l| format!("{}: {}", l.name, why_none(l, &common[0])));
        return Err(
            Error::data("fewer than two of the logs give numbers, so none can be pooled")
                .at(each.collect::<Vec<_>>().join("; "))
                .advise("give longer logs, or leave --one-sensor out"),
        );
    }
    axes.sort_by_key(|a| (a.sensor.index(), a.index));
    Ok(axes)
}

/// A probability far out in the tail: below 1e-300 an `f64` no longer tells it from zero.
fn tail(p: f64) -> String {
    if p < 1e-300 {
        "p < 1e-300".to_owned()
    } else {
        format!("p = {}", general(p, 2))
    }
}

/// A log that was left out of the pooled terms of an axis, or with no majority does not fit them.
pub(super) fn note(outlier: &Outlier, axis: &SensorAxis, logs: &[LogOutcome]) -> OutlierNote {
    let p = tail(outlier.p_value.unwrap_or(0.0));
    let remark = if axis.runs == axis.used.len() {
        format!("does not fit the terms of all logs ({p}), nor do others; all are pooled")
    } else if let Some(ratio) = outlier.ratio {
        format!("differs from the others ({p}; N is {ratio:.2} times theirs); left out")
    } else {
        format!("differs from the others ({p}); left out")
    };
    named(outlier.clone(), &axis.axis, remark, logs)
}

/// One of several sensors that differs from the median of the others.
pub(super) fn fleet_note(outlier: Outlier, axis: &str, logs: &[LogOutcome]) -> OutlierNote {
    let symbol = outlier.term.map_or("", Term::symbol);
    let ratio = outlier.ratio.unwrap_or(f64::NAN);
    let remark = if outlier.is_bound {
        format!("{symbol} is more than {ratio:.2} times that of the others")
    } else {
        format!("{symbol} is {ratio:.2} times that of the others")
    };
    named(outlier, axis, remark, logs)
}

fn named(outlier: Outlier, axis: &str, remark: String, logs: &[LogOutcome]) -> OutlierNote {
    OutlierNote {
        log: outlier.log,
        axis: axis.to_owned(),
        text: format!("{}: {axis} {remark}", logs[outlier.log].name),
        outlier,
        remark,
    }
}

/// A sentence a log: `run5.npy: gyro_x, gyro_y differ …`.
pub(super) fn sentences(outcome: &Outcome) -> Vec<String> {
    let mut out = Vec::new();
    for (log, of) in outcome.logs.iter().enumerate() {
        let own: Vec<&OutlierNote> = outcome.outliers.iter().filter(|o| o.log == log).collect();
        match own.as_slice() {
            [] => {}
            [one] => out.push(one.text.clone()),
            several if outcome.sensor.is_some() => {
                out.push(format!("{}: {}", of.name, together(several, outcome)));
            }
            several => out.push(format!("{}: {}", of.name, apart(several))),
        }
    }
    out
}

/// What is said of a log of the one sensor on several axes.
fn together(notes: &[&OutlierNote], outcome: &Outcome) -> String {
    let is_left_out = |note: &OutlierNote| {
        let axis = outcome
            .sensor
            .iter()
            .flatten()
            .find(|a| a.axis == note.axis);
        axis.is_some_and(|a| a.runs < a.used.len())
    };
    let mut out = Vec::new();
    for left_out in [true, false] {
        let own: Vec<&OutlierNote> = notes
            .iter()
            .copied()
            .filter(|n| is_left_out(n) == left_out)
            .collect();
        if own.is_empty() {
            continue;
        }
        let axes: Vec<&str> = own.iter().map(|n| n.axis.as_str()).collect();
        let axes = axes.join(", ");
        let largest = own
            .iter()
            .filter_map(|n| n.outlier.p_value)
            .fold(0.0, f64::max);
        let p = tail(largest);
        let ratios: Vec<String> = own
            .iter()
            .filter_map(|n| n.outlier.ratio.map(|r| format!("{r:.2}")))
            .collect();
        out.push(match (left_out, ratios.len() == own.len()) {
            (true, true) => format!(
                "{axes} differ from the others ({p}; N is {} times theirs); left out",
                ratios.join(", ")
            ),
            (true, false) => format!("{axes} differ from the others ({p}); left out"),
            (false, _) => format!(
                "{axes} do not fit the terms of all logs ({p}), nor do others; all are pooled"
            ),
        });
    }
    out.join("; ")
}

/// What is said of one of several sensors: a clause a term.
fn apart(notes: &[&OutlierNote]) -> String {
    let mut terms: Vec<Term> = Vec::new();
    for term in notes.iter().filter_map(|n| n.outlier.term) {
        if !terms.contains(&term) {
            terms.push(term);
        }
    }
    let clauses: Vec<String> = terms
        .iter()
        .map(|&term| {
            let own = notes.iter().filter(|n| n.outlier.term == Some(term));
            let (axes, ratios): (Vec<&str>, Vec<String>) = own
                .map(|n| {
                    let ratio = n.outlier.ratio.unwrap_or(f64::NAN);
                    let more = if n.outlier.is_bound { "more than " } else { "" };
                    (n.axis.as_str(), format!("{more}{ratio:.2}"))
                })
                .unzip();
            format!(
                "{} of {} is {} times that of the others",
                term.symbol(),
                axes.join(", "),
                ratios.join(", ")
            )
        })
        .collect();
    clauses.join("; ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_probability_that_no_number_holds_is_a_limit() {
        assert_eq!(super::tail(0.0), "p < 1e-300");
        assert_eq!(super::tail(3.06e-12), "p = 3.1e-12");
        assert_eq!(super::tail(0.000_42), "p = 0.00042");
    }
}
