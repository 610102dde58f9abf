//! Is this unit as its sheet says? Every random term of a reference model against what was measured.
//!
//! Ratio, interval and verdict: [`sagnac_analysis::compare`]. The measured side is an outcome of `characterize`, or the
//! model file that it wrote.

mod page;
mod rows;
mod text;

use crate::Error;
use crate::characterize::{LogOutcome, Outcome};
use rows::{Measured, has_terms, of_model, one_axis};
use sagnac_analysis::compare::{Comparison, Verdict};
use sagnac_analysis::fit::{Estimate, Term};
use sagnac_core::Sensor;
use sagnac_log::{Issue, IssueKind};
use sagnac_model::Model;
use sagnac_report::text::Document;

const AXES: [&str; 3] = ["x", "y", "z"];

/// One term of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedTerm {
    /// JSON name: `angle_random_walk`, `gauss_markov.1.sigma`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// What was measured.
    pub measured: Estimate,
    /// The reference, in SI.
    pub reference: f64,
    /// Whether the reference was given as a one-sided density.
    pub is_density: bool,
    /// Ratio and verdict; none where the term was not looked for.
    pub result: Option<Comparison>,
    /// One sentence.
    pub text: String,
}

impl ComparedTerm {
    /// The verdict; a term that was not looked for is unclear.
    pub fn verdict(&self) -> Verdict {
        self.result.map_or(Verdict::Unclear, |r| r.verdict)
    }
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedAxis {
    /// Channel.
    pub axis: String,
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// Its terms.
    pub terms: Vec<ComparedTerm>,
    /// Terms that were measured and that the reference does not have.
    pub extra: Vec<(&'static str, Estimate)>,
}

/// One log, the sensor of several, or a model file.
#[derive(Debug, Clone)]
pub struct ComparedLog {
    /// Its name.
    pub name: String,
    /// Its axes.
    pub axes: Vec<ComparedAxis>,
    /// What `characterize` found in the logs: name of the log, and its findings.
    pub issues: Vec<(String, Vec<Issue>)>,
    /// The findings as lines of text.
    pub remarks: Document,
}

/// What was compared, a log or a model file each.
#[derive(Debug, Clone)]
pub struct ComparisonOutcome {
    /// Name of the reference.
    pub reference: String,
    /// Each log.
    pub logs: Vec<ComparedLog>,
    /// What the reference has and no log can be compared with: `accel`, `resonances`.
    pub left_out: Vec<String>,
}

/// Compares what `characterize` found with a reference model.
///
/// # Errors
/// A reference without random terms, or with none that the logs tell of.
pub fn compare_logs(outcome: &Outcome, reference: &Model) -> Result<ComparisonOutcome, Error> {
    if !has_terms(reference) {
        return Err(reference.missing("random terms", None).into());
    }
    let mut logs = Vec::new();
    if let Some(axes) = &outcome.sensor {
        let compared = axes
            .iter()
            .map(|axis| {
                let p = &axis.pooled;
                let measured = Measured {
                    terms: vec![
                        (Term::Quantization, p.quantization),
                        (Term::White, p.white),
                        (Term::Flicker, p.flicker),
                        (Term::RandomWalk, p.random_walk),
                    ],
                    gauss_markov: p.gauss_markov.clone(),
                    stability: Some(p.run_to_run.stability),
                    is_coarse: !p.white.is_detected()
                        && outcome.logs.iter().any(|l| is_coarse(l, &axis.axis)),
                };
                one_axis(reference, axis.sensor, axis.index, &measured)
            })
            .collect();
        logs.push(gathered("all logs".to_owned(), compared, &outcome.logs));
    } else {
        for log in &outcome.logs {
            let compared = log
                .axes
                .iter()
                .filter_map(|axis| {
                    let e = axis.estimate.as_ref()?;
                    let measured = Measured {
                        terms: vec![
                            (Term::Quantization, e.quantization),
                            (Term::White, e.white),
                            (Term::Flicker, e.flicker),
                            (Term::RandomWalk, e.random_walk),
                            (Term::Ramp, e.ramp),
                        ],
                        gauss_markov: e.gauss_markov.clone(),
                        stability: None,
                        is_coarse: !e.white.is_detected() && is_coarse(log, &axis.axis),
                    };
                    Some(one_axis(reference, axis.sensor, axis.index, &measured))
                })
                .collect();
            logs.push(gathered(
                log.name.clone(),
                compared,
                std::slice::from_ref(log),
            ));
        }
    }
    if !logs.iter().flat_map(|l| &l.axes).any(tells) {
        return Err(nothing_told(&outcome.logs, reference));
    }
    Ok(finish(reference, logs))
}

/// Compares a measured model, as `characterize` writes it, with a reference model.
///
/// # Errors
/// A model without random terms, or two that have none in common.
pub fn compare_model(measured: &Model, reference: &Model) -> Result<ComparisonOutcome, Error> {
    for model in [measured, reference] {
        if !has_terms(model) {
            return Err(model.missing("random terms", None).into());
        }
    }
    let mut axes = Vec::new();
    for sensor in Sensor::ALL {
        for index in 0..3 {
            let own = of_model(measured, sensor, index);
            if !own.terms.is_empty() || !own.gauss_markov.is_empty() {
                axes.push(one_axis(reference, sensor, index, &own));
            }
        }
    }
    if !axes.iter().any(tells) {
        return Err(
            Error::data("the measured model tells of none of the sheet's random terms")
                .at(format!("{} with {}", measured.label(), reference.label()))
                .advise("measure the sensor that the sheet has: sagnac characterize LOG -o"),
        );
    }
    let log = gathered(measured.name().to_owned(), axes, &[]);
    Ok(finish(reference, vec![log]))
}

/// Whether any term of an axis was looked for.
fn tells(axis: &ComparedAxis) -> bool {
    axis.terms.iter().any(|t| t.result.is_some())
}

/// Whether a finding says that the steps of the values hide the noise.
fn is_coarse(log: &LogOutcome, axis: &str) -> bool {
    log.issues.iter().any(|i| {
        i.kind == IssueKind::Quantization && i.channel.as_deref().is_none_or(|c| c == axis)
    })
}

/// Why logs tell nothing of what the reference has.
fn nothing_told(logs: &[LogOutcome], reference: &Model) -> Error {
    let known = |log: &&LogOutcome| {
        let mut axes = log.axes.iter().filter_map(|a| a.estimate.as_ref());
        axes.any(|e| e.white.is_detected() || e.white.upper.is_some())
    };
    if let Some(log) = logs.iter().find(known) {
        let axes: Vec<String> = log.axes.iter().map(|a| a.axis.clone()).collect();
        return Error::data("the log tells of none of the sheet's random terms")
            .at(format!("{}: {}", log.name, axes.join(", ")))
            .advise(format!(
                "compare it with a sheet of that sensor, or add its terms to {}",
                reference.label()
            ));
    }
    let place = logs.first().map_or(String::new(), |log| {
        let why = log.issues.iter().find(|i| i.kind == IssueKind::Short);
        let why = why.or(log.issues.first()).map_or_else(
            || format!("{} samples", log.samples),
            |issue| issue.text.clone(),
        );
        format!("{}: {why}", log.name)
    });
    Error::data("the log gives no noise parameters to compare with the sheet")
        .at(place)
        .advise("sagnac plan with the sheet tells how long a log must be")
}

fn gathered(name: String, axes: Vec<ComparedAxis>, logs: &[LogOutcome]) -> ComparedLog {
    let mut remarks = Document::new();
    for log in logs {
        let mut own = Document::new();
        crate::characterize::remarks(log, &mut own);
        if logs.len() > 1 && !own.is_empty() {
            remarks.blank();
            remarks.heading(log.name.clone());
        }
        remarks.append(own);
    }
    ComparedLog {
        name,
        axes,
        issues: logs
            .iter()
            .map(|log| (log.name.clone(), log.issues.clone()))
            .collect(),
        remarks,
    }
}

fn finish(reference: &Model, logs: Vec<ComparedLog>) -> ComparisonOutcome {
    ComparisonOutcome {
        reference: reference.name().to_owned(),
        left_out: rows::left_out(reference, &logs),
        logs,
    }
}
