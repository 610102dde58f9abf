//! The page of `compare`: term by term, and the measured Allan deviation over that of the sheet.

use super::text::headline;
use super::{ComparedAxis, ComparedTerm, ComparisonOutcome};
use crate::characterize::{AxisOutcome, Outcome, allan_panel, shown_sensor};
use crate::noise_terms;
use sagnac_analysis::compare::Verdict;
use sagnac_analysis::fit::NoiseTerms;
use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_report::html::{ComparePage, CompareRow, Opening, Rich};
use sagnac_report::plots::AllanPanel;
use sagnac_report::text::{Estimate as Shown, Unit, general, term_in_sentence};

impl ComparisonOutcome {
    /// The page of logs compared with a reference: `outcome` is what was measured.
    pub fn page(&self, opening: Opening, outcome: &Outcome, reference: &Model) -> ComparePage {
        let several = outcome.logs.len() > 1;
        let mut allan: Vec<Vec<AllanPanel>> = Vec::new();
        for log in &outcome.logs {
            for sensor in Sensor::ALL {
                let panels: Vec<AllanPanel> = log
                    .axes
                    .iter()
                    .filter(|a| a.sensor == sensor)
                    .filter_map(|a| self.measured_panel(a, reference))
                    .collect();
                if !panels.is_empty() {
                    allan.push(panels);
                }
            }
        }
        let subtitle = match outcome.logs.as_slice() {
            [one] => format!("{} against {}", one.name, self.reference),
            many => format!("{} logs against {}", many.len(), self.reference),
        };
        self.filled(opening, subtitle, several, allan)
    }

    /// The page of a measured model file compared with a reference.
    pub fn page_of_model(
        &self,
        opening: Opening,
        measured: &Model,
        reference: &Model,
    ) -> ComparePage {
        let mut allan = Vec::new();
        for sensor in Sensor::ALL {
            let panels: Vec<AllanPanel> = (0..3)
                .filter_map(|index| {
                    let terms = noise_terms::of_axis(measured, sensor, index);
                    let tau_s: Vec<f64> = (0..=60)
                        .map(|i| 0.01 * 10f64.powf(f64::from(i) / 10.0))
                        .collect();
                    let unit = unit_of(sensor);
                    let deviation = curve(&terms, &tau_s, unit)?;
                    let fit = curve(
                        &noise_terms::of_axis(reference, sensor, index),
                        &tau_s,
                        unit,
                    );
                    Some(AllanPanel {
                        axis: format!("{}_{}", sensor.key(), super::AXES[index]),
                        unit: unit.page.to_owned(),
                        deviation,
                        fit: fit.unwrap_or_default(),
                        fit_name: self.sheet_name(),
                        tau_s,
                        ..AllanPanel::default()
                    })
                })
                .collect();
            if !panels.is_empty() {
                allan.push(panels);
            }
        }
        let subtitle = format!("{} against {}", measured.name(), self.reference);
        self.filled(opening, subtitle, false, allan)
    }

    fn sheet_name(&self) -> String {
        format!("what {} says", self.reference)
    }

    /// The measured curve of an axis with that of the sheet in the place of the fit.
    fn measured_panel(&self, axis: &AxisOutcome, reference: &Model) -> Option<AllanPanel> {
        let mut panel = allan_panel(axis, axis.sensor)?;
        let terms = noise_terms::of_axis(reference, axis.sensor, axis.index);
        panel.fit = curve(&terms, &panel.tau_s, unit_of(axis.sensor)).unwrap_or_default();
        panel.fit_name = self.sheet_name();
        panel.terms.clear();
        Some(panel)
    }

    fn filled(
        &self,
        mut opening: Opening,
        subtitle: String,
        several: bool,
        allan: Vec<Vec<AllanPanel>>,
    ) -> ComparePage {
        let rows: Vec<CompareRow> = self
            .logs
            .iter()
            .flat_map(|log| log.axes.iter().map(move |a| (&log.name, a)))
            .flat_map(|(name, axis)| {
                axis.terms.iter().map(move |t| {
                    let label = format!("{}, {}", axis.axis.replace('_', " "), label_of(t));
                    let label = if several {
                        format!("{name}: {label}")
                    } else {
                        label
                    };
                    row(label, axis.sensor, t)
                })
            })
            .collect();
        let all: Vec<ComparedAxis> = self.logs.iter().flat_map(|l| l.axes.clone()).collect();
        let count = |verdict: Verdict| {
            let terms = all.iter().flat_map(|a| &a.terms);
            terms.filter(|t| t.verdict() == verdict).count()
        };
        opening.verdict = Rich::new().bold(headline(&all).1).plain(format!(
            " Of {} rows {} are worse than the sheet, {} better, {} unclear.",
            rows.len(),
            count(Verdict::Worse),
            count(Verdict::Better),
            count(Verdict::Unclear)
        ));
        for (name, issues) in self.logs.iter().flat_map(|l| &l.issues) {
            opening.limits.extend(issues.iter().map(|issue| {
                let channel = issue.channel.as_deref().unwrap_or("the log");
                let kind = issue.kind.name();
                Rich::new().plain(format!("{name}, {channel}, {kind}: {}", issue.text))
            }));
        }
        if !self.left_out.is_empty() {
            let list = self.left_out.join(", ");
            let text = format!("In the sheet, not compared: {list}.");
            opening.limits.push(Rich::new().plain(text));
        }
        opening.name.clone_from(&self.reference);
        opening.subtitle = subtitle;
        ComparePage {
            opening,
            rows,
            allan,
        }
    }
}

fn unit_of(sensor: Sensor) -> Unit {
    let term = if sensor == Sensor::Gyro {
        "mean"
    } else {
        "allan"
    };
    Unit::of_term(shown_sensor(sensor), term)
}

/// Allan deviation of the terms; none where there are none.
fn curve(terms: &NoiseTerms, tau_s: &[f64], unit: Unit) -> Option<Vec<f64>> {
    let values: Vec<f64> = tau_s
        .iter()
        .map(|&t| terms.allan_variance(t).sqrt() * unit.per_si)
        .collect();
    values.iter().all(|v| *v > 0.0).then_some(values)
}

fn label_of(term: &ComparedTerm) -> String {
    if term.is_density {
        "noise density".to_owned()
    } else if term.name == "bias_stability" {
        "run-to-run bias".to_owned()
    } else if term.name.ends_with("sigma") {
        "sigma of a Gauss-Markov process".to_owned()
    } else if term.name.ends_with(".correlation_time") {
        "correlation time of a Gauss-Markov process".to_owned()
    } else {
        term_in_sentence(&term.name)
    }
}

fn row(label: String, sensor: Sensor, t: &ComparedTerm) -> CompareRow {
    let (unit, factor) = super::text::shown_unit(sensor, t);
    let measured = crate::characterize::shown(&t.measured)
        .scaled(unit.per_si * factor)
        .text();
    let ratio = t
        .result
        .map_or(Shown::Absent, |r| crate::characterize::shown(&r.ratio))
        .text();
    CompareRow {
        term: label,
        measured: (measured.value, measured.interval),
        sheet: general(t.reference * unit.per_si * factor, 3),
        unit: unit.page.to_owned(),
        ratio: (ratio.value, ratio.interval),
        verdict: t.verdict().name().to_owned(),
        text: t.text.clone(),
    }
}
