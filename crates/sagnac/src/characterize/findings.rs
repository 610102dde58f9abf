//! What the fit found, as issues of the log in users' units; `--strict`; the checks that need all axes or a model.

use super::LogOutcome;
use crate::Error;
use sagnac_analysis::fit::{Finding, FindingKind};
use sagnac_core::Sensor;
use sagnac_log::{Issue, IssueKind};
use sagnac_model::Model;
use sagnac_report::text::{Unit, clock, general};

/// The Earth's rate, above which a mean rate at rest must be [rad/s].
pub(super) const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// Standard errors by which it must be missed: a rate 4.5 of them too small is found in 97 %, a right one named in 0.5 %.
const EARTH_RATE_ERRORS: f64 = 2.6;

fn kind_of(kind: FindingKind) -> Option<IssueKind> {
    Some(match kind {
        FindingKind::Step => IssueKind::Step,
        FindingKind::WarmUp => IssueKind::WarmUp,
        FindingKind::NonStationary => IssueKind::NonStationary,
        FindingKind::Filtered => IssueKind::Filtered,
        FindingKind::Quantization => IssueKind::Quantization,
        FindingKind::BiasRemoved => IssueKind::BiasRemoved,
        FindingKind::Line => IssueKind::Line,
        FindingKind::Short => IssueKind::Short,
        FindingKind::Misfit => return None,
    })
}

/// Adds what the axes' fits found to the issues of the log.
pub(super) fn add(outcome: &mut LogOutcome, dt_s: f64, model: Option<&Model>) {
    let mut new = Vec::new();
    let whole_short = outcome
        .issues
        .iter()
        .any(|i| i.kind == IssueKind::Short && i.channel.is_none());
    for axis in &outcome.axes {
        let Some(estimate) = &axis.estimate else {
            continue;
        };
        for finding in &estimate.findings {
            let Some(kind) = kind_of(finding.kind) else {
                continue;
            };
            // What health has told of this channel is not told twice.
            let known = outcome.issues.iter().any(|i| {
                i.kind == kind
                    && i.channel.as_deref() == Some(&axis.axis)
                    && !matches!(kind, IssueKind::Step)
            });
            let short = kind == IssueKind::Short
                && whole_short
                && estimate.duration_s.min(outcome.duration_s) < 100.0;
            if known || short {
                continue;
            }
            new.push(Issue {
                kind,
                channel: Some(axis.axis.clone()),
                start_s: outcome.first_s + finding.start_s,
                end_s: outcome.first_s + finding.end_s,
                count: finding.count as u64,
                text: sentence(axis.sensor, finding),
            });
        }
    }
    new.extend(bias_removed(outcome));
    new.extend(earth_rate(outcome, model));
    outcome.issues.extend(new);
    let _ = dt_s;
    sort(&mut outcome.issues);
}

/// In order of time, then of kind and channel.
pub(super) fn sort(issues: &mut [Issue]) {
    issues.sort_by(|a, b| {
        a.start_s
            .total_cmp(&b.start_s)
            .then(a.kind.cmp(&b.kind))
            .then(a.channel.cmp(&b.channel))
    });
}

/// The finding's sentence in users' units.
fn sentence(sensor: Sensor, finding: &Finding) -> String {
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_H,
        Sensor::Accel => Unit::MM_PER_S2,
    };
    let size = finding.size.unwrap_or(0.0);
    match finding.kind {
        FindingKind::Step => format!(
            "changes by {} {}",
            general(unit.from_si(size), 3),
            unit.text
        ),
        FindingKind::WarmUp => {
            let rest = finding
                .text
                .split_once(" with ")
                .map_or("", |(_, rest)| rest);
            format!(
                "settles by {} {} with {rest}",
                general(unit.from_si(size), 3),
                unit.text
            )
        }
        _ => finding.text.clone(),
    }
}

/// The mean of every gyro axis is far too small for its own noise: somebody took the bias out.
fn bias_removed(outcome: &LogOutcome) -> Option<Issue> {
    let gyro: Vec<_> = outcome
        .axes
        .iter()
        .filter(|a| a.sensor == Sensor::Gyro)
        .collect();
    if gyro.len() < 3 {
        return None;
    }
    let all = gyro.iter().all(|axis| {
        // A mean within a coarse step is zero by rounding.
        axis.estimate
            .as_ref()
            .filter(|e| !e.is_coarse())
            .is_some_and(|e| {
                e.mean
                    .value
                    .zip(e.mean.sigma)
                    .is_some_and(|(mean, sigma)| mean.abs() < 0.01 * sigma)
            })
    });
    all.then(|| Issue {
        kind: IssueKind::BiasRemoved,
        channel: Some("gyro".to_owned()),
        start_s: outcome.first_s,
        end_s: outcome.first_s + outcome.duration_s,
        count: outcome.samples as u64,
        text: "the means are zero: the bias was removed, slow terms are those of the remover"
            .to_owned(),
    })
}

/// With the bias known, the mean rate must show the Earth's.
fn earth_rate(outcome: &LogOutcome, model: Option<&Model>) -> Option<Issue> {
    let bias = model?.triad("gyro.bias")?;
    let mut square = 0.0;
    let mut variance = 0.0;
    let mut count = 0;
    for axis in outcome.axes.iter().filter(|a| a.sensor == Sensor::Gyro) {
        let e = axis.estimate.as_ref()?;
        let rate = e.mean.value? - bias[axis.index];
        square += rate * rate;
        variance += (rate * e.mean.sigma?).powi(2);
        count += 1;
    }
    if count < 3 {
        return None;
    }
    let rate: f64 = square.sqrt();
    let error = if rate > 0.0 {
        variance.sqrt() / rate
    } else {
        0.0
    };
    (rate + EARTH_RATE_ERRORS * error < EARTH_RATE_RAD_S).then(|| Issue {
        kind: IssueKind::EarthRate,
        channel: Some("gyro".to_owned()),
        start_s: outcome.first_s,
        end_s: outcome.first_s + outcome.duration_s,
        count: outcome.samples as u64,
        text: format!(
            "{} deg/h are left beside the model's bias, less than the Earth's 15.04",
            general(Unit::DEG_PER_H.from_si(rate), 3)
        ),
    })
}

/// With `--strict` the first issue that is more than a note is an error.
pub(super) fn refuse(name: &str, issues: &[Issue], first_s: f64) -> Result<(), Error> {
    let Some(issue) = issues.iter().find(|i| i.kind.is_strict_error()) else {
        return Ok(());
    };
    let channel = issue.channel.as_deref().unwrap_or("the log");
    Err(
        Error::data(format!("{channel}: {}: {}", issue.kind.name(), issue.text))
            .at(format!("{name}, {}", clock(issue.start_s - first_s)))
            .advise("repair the log, cut it with --start and --end, or leave --strict out"),
    )
}
