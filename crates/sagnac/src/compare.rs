//! Is this unit as its sheet says? Every random term of a reference model against what was measured.
//!
//! Ratio, interval and verdict: [`sagnac_analysis::compare`]. The measured side is an outcome of `characterize`, or the
//! model file that it wrote.

mod page;

use crate::Error;
use crate::characterize::{Outcome, dimension_of, estimate_json, key_of};
use sagnac_analysis::compare::{Comparison, Verdict, compare as compare_one};
use sagnac_analysis::fit::{Estimate, Term};
use sagnac_core::Sensor;
use sagnac_model::{Entry, Model};
use sagnac_report::text::{Cell, Document, Estimate as Shown, Role, Table, Unit, term_symbol};
use serde_json::{Map, Value, json};

const AXES: [&str; 3] = ["x", "y", "z"];

/// One term of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedTerm {
    /// JSON name.
    pub name: &'static str,
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

/// What was compared, a log or a model file each.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonOutcome {
    /// Name of the reference.
    pub reference: String,
    /// Name and axes of each log.
    pub logs: Vec<(String, Vec<ComparedAxis>)>,
}

/// Compares what `characterize` found with a reference model.
///
/// # Errors
/// A reference without random terms.
pub fn compare_logs(outcome: &Outcome, reference: &Model) -> Result<ComparisonOutcome, Error> {
    let mut logs = Vec::new();
    if let Some(axes) = &outcome.sensor {
        let compared = axes
            .iter()
            .map(|axis| {
                let p = &axis.pooled;
                let measured = [
                    (Term::Quantization, p.quantization),
                    (Term::White, p.white),
                    (Term::Flicker, p.flicker),
                    (Term::RandomWalk, p.random_walk),
                ];
                one_axis(
                    reference,
                    axis.sensor,
                    axis.index,
                    &measured,
                    Some(&p.bias_stability),
                )
            })
            .collect();
        logs.push(("all logs".to_owned(), compared));
    } else {
        for log in &outcome.logs {
            let compared = log
                .axes
                .iter()
                .filter_map(|axis| {
                    let e = axis.estimate.as_ref()?;
                    let measured = [
                        (Term::Quantization, e.quantization),
                        (Term::White, e.white),
                        (Term::Flicker, e.flicker),
                        (Term::RandomWalk, e.random_walk),
                        (Term::Ramp, e.ramp),
                    ];
                    Some(one_axis(
                        reference,
                        axis.sensor,
                        axis.index,
                        &measured,
                        None,
                    ))
                })
                .collect();
            logs.push((log.name.clone(), compared));
        }
    }
    finish(reference, logs)
}

/// Compares a measured model, as `characterize` writes it, with a reference model.
///
/// # Errors
/// A reference without random terms.
pub fn compare_model(measured: &Model, reference: &Model) -> Result<ComparisonOutcome, Error> {
    let mut axes = Vec::new();
    for sensor in Sensor::ALL {
        for index in 0..3 {
            let list: Vec<(Term, Estimate)> = [
                Term::Quantization,
                Term::White,
                Term::Flicker,
                Term::RandomWalk,
                Term::Ramp,
            ]
            .into_iter()
            .filter_map(|term| Some((term, from_entry(&entry_of(measured, sensor, term, index)?))))
            .collect();
            let stability = measured
                .under(sensor, "bias.stability", index)
                .map(from_entry);
            if !list.is_empty() {
                axes.push(one_axis(
                    reference,
                    sensor,
                    index,
                    &list,
                    stability.as_ref(),
                ));
            }
        }
    }
    if axes.is_empty() {
        return Err(measured.missing("random terms", None).into());
    }
    finish(reference, vec![(measured.name().to_owned(), axes)])
}

fn finish(
    reference: &Model,
    logs: Vec<(String, Vec<ComparedAxis>)>,
) -> Result<ComparisonOutcome, Error> {
    if logs.iter().flat_map(|l| &l.1).all(|a| a.terms.is_empty()) {
        return Err(reference.missing("random terms", None).into());
    }
    Ok(ComparisonOutcome {
        reference: reference.name().to_owned(),
        logs,
    })
}

fn from_entry(entry: &Entry) -> Estimate {
    match (entry.value, entry.upper_limit) {
        (Some(value), _) => {
            let sigma = entry.sigma.unwrap_or(0.0);
            Estimate::detected(
                value,
                entry.lower.unwrap_or(value - 1.96 * sigma),
                entry.upper.unwrap_or(value + 1.96 * sigma),
                sigma,
            )
        }
        (None, Some(limit)) => Estimate::limit(limit),
        (None, None) => Estimate::ABSENT,
    }
}

fn entry_of(model: &Model, sensor: Sensor, term: Term, axis: usize) -> Option<Entry> {
    match term {
        Term::White => model.white_noise(sensor, axis),
        Term::Flicker => model.flicker(sensor, axis),
        _ => model
            .under(sensor, &format!("noise.{}", key_of(sensor, term)), axis)
            .cloned(),
    }
}

fn one_axis(
    reference: &Model,
    sensor: Sensor,
    index: usize,
    measured: &[(Term, Estimate)],
    stability: Option<&Estimate>,
) -> ComparedAxis {
    let mut out = ComparedAxis {
        axis: format!("{}_{}", sensor.key(), AXES[index]),
        sensor,
        terms: Vec::new(),
        extra: Vec::new(),
    };
    for &(term, e) in measured {
        let name = key_of(sensor, term);
        let entry = entry_of(reference, sensor, term, index);
        let value = entry
            .as_ref()
            .and_then(|e| e.value)
            .map(f64::abs)
            .filter(|v| *v > 0.0);
        let Some(value) = value else {
            if e.is_detected() {
                out.extra.push((name, e));
            }
            continue;
        };
        let is_density = term == Term::White
            && reference
                .under(sensor, &format!("noise.{name}"), index)
                .is_none();
        let result = compare_one(term, &e, value, entry.and_then(|e| e.sigma));
        out.terms.push(ComparedTerm {
            name,
            unit: dimension_of(sensor, term).si_unit(),
            measured: e,
            reference: value,
            is_density,
            text: sentence(result.as_ref(), is_density),
            result,
        });
    }
    if let (Some(e), Some(entry)) = (stability, reference.under(sensor, "bias.stability", index))
        && let Some(value) = entry.value.filter(|v| *v > 0.0)
    {
        let result = compare_one(Term::Flicker, e, value, entry.sigma);
        out.terms.push(ComparedTerm {
            name: "bias_stability",
            unit: dimension_of(sensor, Term::Flicker).si_unit(),
            measured: *e,
            reference: value,
            is_density: false,
            text: sentence(result.as_ref(), false),
            result,
        });
    }
    out
}

fn sentence(result: Option<&Comparison>, is_density: bool) -> String {
    let Some(c) = result else {
        return "not looked for".to_owned();
    };
    match (c.verdict, c.ratio.value) {
        (Verdict::Unclear, Some(ratio)) => {
            let (other, sides) = if ratio > 1.0 {
                (
                    ratio / std::f64::consts::SQRT_2,
                    "two-sided where it was taken as one-sided",
                )
            } else {
                (ratio * std::f64::consts::SQRT_2, "one-sided")
            };
            let what = if is_density || ratio < 1.0 {
                sides
            } else {
                "of another convention"
            };
            format!("the reference may be {what}; then the ratio is {other:.2}")
        }
        (Verdict::Unclear, None) => "only bounded from above, and not below 0.8".to_owned(),
        (Verdict::Better, None) => "the upper limit lies below 0.8 of the reference".to_owned(),
        (Verdict::Better, _) => "the whole interval lies below 0.8 of the reference".to_owned(),
        (Verdict::Worse, _) => "the whole interval lies above 1.25 of the reference".to_owned(),
        (Verdict::Within, _) => "as the reference says".to_owned(),
    }
}

impl ComparisonOutcome {
    /// Keys as scripts rely on them.
    pub fn to_json(&self) -> Value {
        let logs: Vec<Value> = self
            .logs
            .iter()
            .map(|(name, axes)| {
                let axes: Vec<Value> = axes.iter().map(axis_json).collect();
                json!({ "name": name, "axes": axes })
            })
            .collect();
        if let [only] = logs.as_slice() {
            return only.clone();
        }
        let mut out = Map::new();
        out.insert("logs".into(), logs.into());
        Value::Object(out)
    }

    /// As a terminal shows it.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        for (i, (name, axes)) in self.logs.iter().enumerate() {
            if i > 0 {
                out.blank();
            }
            if self.logs.len() > 1 {
                out.heading(name.clone());
            }
            one_document(axes, &mut out);
        }
        out
    }
}

fn axis_json(axis: &ComparedAxis) -> Value {
    let terms: Vec<Value> = axis
        .terms
        .iter()
        .map(|t| {
            let ratio = t.result.map_or(Estimate::ABSENT, |r| r.ratio);
            json!({
                "term": t.name,
                "measured": estimate_json(&t.measured, &t.unit),
                "reference": t.reference,
                "ratio": estimate_json(&ratio, "1"),
                "verdict": t.result.map_or("unclear", |r| r.verdict.name()),
                "text": t.text,
            })
        })
        .collect();
    json!({ "axis": axis.axis, "terms": terms })
}

/// The unit of a row, and what its numbers are multiplied with besides: densities of a sheet are one-sided.
fn shown_unit(sensor: Sensor, term: &ComparedTerm) -> (Unit, f64) {
    if !term.is_density {
        return (
            Unit::of_term(crate::characterize::shown_sensor(sensor), term.name),
            1.0,
        );
    }
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S_PER_SQRT_HZ,
        Sensor::Accel => Unit::MICRO_G_PER_SQRT_HZ,
    };
    (unit, std::f64::consts::SQRT_2)
}

fn one_document(axes: &[ComparedAxis], out: &mut Document) {
    let all = || {
        axes.iter()
            .flat_map(|a| a.terms.iter().map(move |t| (a, t)))
    };
    let with = |v: Verdict| {
        all()
            .filter(|(_, t)| t.result.is_some_and(|r| r.verdict == v))
            .map(|(a, t)| {
                format!(
                    "{} {}",
                    a.axis.replace('_', " "),
                    term_symbol(t.name).unwrap_or(t.name)
                )
            })
            .collect::<Vec<_>>()
    };
    let (worse, unclear) = (with(Verdict::Worse), with(Verdict::Unclear));
    if worse.is_empty() {
        out.verdict(Role::Good, "The unit is as its sheet says or better.");
    } else {
        out.verdict(
            Role::Bad,
            format!(
                "The unit is as its sheet says but for {}.",
                worse.join(", ")
            ),
        );
    }
    out.blank();
    let mut table = Table::new(
        &["", "measured", "sheet", "", "ratio", "verdict"],
        &[
            sagnac_report::text::Align::Left,
            sagnac_report::text::Align::PlusMinus,
            sagnac_report::text::Align::Right,
            sagnac_report::text::Align::Left,
            sagnac_report::text::Align::PlusMinus,
            sagnac_report::text::Align::Left,
        ],
    );
    for (axis, t) in all() {
        let (unit, factor) = shown_unit(axis.sensor, t);
        let label = if t.is_density {
            "density"
        } else if t.name == "bias_stability" {
            "run-to-run"
        } else {
            term_symbol(t.name).unwrap_or(t.name)
        };
        let role = match t.result.map(|r| r.verdict) {
            Some(Verdict::Worse) => Role::Bad,
            Some(Verdict::Better) => Role::Good,
            Some(Verdict::Unclear) => Role::Warning,
            _ => Role::Plain,
        };
        let verdict = t.result.map_or("-".to_owned(), |r| {
            if r.verdict == Verdict::Unclear && r.ratio.value.is_some() {
                "unclear: √2".to_owned()
            } else {
                r.verdict.name().to_owned()
            }
        });
        let ratio = t
            .result
            .map_or(Shown::Absent, |r| crate::characterize::shown(&r.ratio));
        let row: Vec<Cell> = vec![
            format!("{} {label}", axis.axis.replace('_', " ")).into(),
            crate::characterize::shown(&t.measured)
                .scaled(unit.per_si * factor)
                .into(),
            sagnac_report::text::general(t.reference * unit.per_si * factor, 3).into(),
            unit.text.into(),
            ratio.into(),
            Cell::from(verdict).with_role(role),
        ];
        table.row(row);
    }
    out.table(table);
    let extra: Vec<String> = axes
        .iter()
        .flat_map(|a| {
            a.extra.iter().map(|(name, _)| {
                format!(
                    "{} {}",
                    a.axis.replace('_', " "),
                    term_symbol(name).unwrap_or(name)
                )
            })
        })
        .collect();
    if !unclear.is_empty() || !extra.is_empty() {
        out.blank();
    }
    let mut said: Vec<&str> = Vec::new();
    for (_, t) in all() {
        if t.result.is_some_and(|r| r.verdict == Verdict::Unclear)
            && !said.contains(&t.text.as_str())
        {
            said.push(&t.text);
            out.hanging("unclear: ", t.text.clone());
        }
    }
    if !extra.is_empty() {
        out.paragraph(format!("Measured, not in the sheet: {}.", extra.join(", ")));
    }
}
