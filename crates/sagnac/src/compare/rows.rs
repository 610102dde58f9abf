//! The terms of the two sides, matched: a row a number of the reference.

use super::{AXES, ComparedAxis, ComparedLog, ComparedTerm};
use crate::characterize::{dimension_of, key_of};
use sagnac_analysis::compare::{Comparison, Verdict, compare};
use sagnac_analysis::fit::{Estimate, GaussMarkovEstimate, Status, Term};
use sagnac_core::Sensor;
use sagnac_model::units::Dimension;
use sagnac_model::{Entry, Model, Process};

/// What is known of one axis.
pub(super) struct Measured {
    pub(super) terms: Vec<(Term, Estimate)>,
    /// Detected processes, or one with the limit of them all.
    pub(super) gauss_markov: Vec<GaussMarkovEstimate>,
    pub(super) stability: Option<Estimate>,
    /// The steps of the values hide the noise: what is not seen may be there.
    pub(super) is_coarse: bool,
}

/// Terms that a model names by one number each.
const SINGLE: [Term; 5] = [
    Term::Quantization,
    Term::White,
    Term::Flicker,
    Term::RandomWalk,
    Term::Ramp,
];

/// What a model says of one axis.
pub(super) fn of_model(model: &Model, sensor: Sensor, index: usize) -> Measured {
    let terms: Vec<(Term, Estimate)> = SINGLE
        .into_iter()
        .filter_map(|term| Some((term, from_entry(&entry_of(model, sensor, term, index)?))))
        .collect();
    let is_limit =
        |(term, e): &(Term, Estimate)| *term == Term::White && e.status == Status::UpperLimit;
    Measured {
        // Rounding is what leaves white noise without a value.
        is_coarse: model.under(sensor, "resolution", index).is_some() && terms.iter().any(is_limit),
        terms,
        gauss_markov: markov_entries(model, sensor, index)
            .iter()
            .map(|(sigma, time)| GaussMarkovEstimate {
                sigma: from_entry(sigma),
                correlation_time_s: from_entry(time),
            })
            .filter(|g| g.sigma.value != Some(0.0) && g.sigma.status != Status::Absent)
            .collect(),
        stability: model.under(sensor, "bias.stability", index).map(from_entry),
    }
}

/// Whether a model has any random term.
pub(super) fn has_terms(model: &Model) -> bool {
    axes().any(|(sensor, index)| {
        let own = of_model(model, sensor, index);
        own.terms.iter().any(|t| t.1.status != Status::Absent) || !own.gauss_markov.is_empty()
    })
}

fn axes() -> impl Iterator<Item = (Sensor, usize)> {
    Sensor::ALL
        .into_iter()
        .flat_map(|sensor| (0..3).map(move |index| (sensor, index)))
}

/// What the reference has and what is not compared: sensors that no log has, terms that are no noise parameters.
pub(super) fn left_out(reference: &Model, logs: &[ComparedLog]) -> Vec<String> {
    let mut out = Vec::new();
    for sensor in Sensor::ALL {
        let has = (0..3).any(|index| {
            let own = of_model(reference, sensor, index);
            own.terms.iter().any(|t| t.1.is_detected()) || !own.gauss_markov.is_empty()
        });
        let seen = logs
            .iter()
            .flat_map(|l| &l.axes)
            .any(|a| a.sensor == sensor);
        if has && !seen {
            out.push(format!("the {}", sensor.name()));
        }
        let lists = ["resonances", "sinusoids"];
        for list in lists {
            let path = format!("noise.{list}.1.frequency");
            if seen && (0..3).any(|k| reference.under(sensor, &path, k).is_some()) {
                out.push(format!("{list} of the {}", sensor.name()));
            }
        }
    }
    out
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
        Term::RandomWalk => walk_of(model, sensor, axis),
        _ => model
            .under(sensor, &format!("noise.{}", key_of(sensor, term)), axis)
            .cloned(),
    }
}

/// K of the noise and of a bias instability that is a random walk: one spectrum, so they add in quadrature.
fn walk_of(model: &Model, sensor: Sensor, axis: usize) -> Option<Entry> {
    let key = Model::walk_key(sensor);
    let of = |table: &str| {
        model
            .under(sensor, &format!("{table}.{key}"), axis)
            .cloned()
    };
    let noise = of("noise");
    let bias = of("bias.instability").filter(|_| model.process(sensor) == Process::RandomWalk);
    match (noise, bias) {
        (Some(a), Some(b)) => {
            let (u, v) = (a.value.unwrap_or(0.0), b.value.unwrap_or(0.0));
            let value = u.hypot(v);
            if value == 0.0 {
                return Some(a);
            }
            let part = |value: f64, e: &Entry| value * e.sigma.unwrap_or(0.0);
            let sigma = part(u, &a).hypot(part(v, &b)) / value;
            Some(Entry {
                value: Some(value),
                sigma: (sigma > 0.0).then_some(sigma),
                lower: None,
                upper: None,
                ..a
            })
        }
        (a, b) => a.or(b),
    }
}

/// σ and T_c of every Gauss–Markov process of an axis, that of the bias instability last.
fn markov_entries(model: &Model, sensor: Sensor, axis: usize) -> Vec<(Entry, Entry)> {
    let pair = |table: &str| {
        let of = |key: &str| {
            model
                .under(sensor, &format!("{table}.{key}"), axis)
                .cloned()
        };
        Some((of("sigma")?, of("correlation_time")?))
    };
    let mut out: Vec<(Entry, Entry)> = (1..)
        .map_while(|place| pair(&format!("noise.gauss_markov.{place}")))
        .collect();
    if model.process(sensor) == Process::GaussMarkov {
        out.extend(pair("bias.instability"));
    }
    out
}

pub(super) fn one_axis(
    reference: &Model,
    sensor: Sensor,
    index: usize,
    measured: &Measured,
) -> ComparedAxis {
    let mut out = ComparedAxis {
        axis: format!("{}_{}", sensor.key(), AXES[index]),
        sensor,
        terms: Vec::new(),
        extra: Vec::new(),
    };
    for term in SINGLE {
        let found = measured.terms.iter().find(|(own, _)| *own == term);
        let e = found.map_or(Estimate::ABSENT, |(_, e)| *e);
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
        out.terms.push(row(
            Row {
                name: name.to_owned(),
                unit: dimension_of(sensor, term).si_unit(),
                term,
                reference: value,
                sigma: entry.and_then(|e| e.sigma),
                is_density,
            },
            &e,
            measured.is_coarse,
        ));
    }
    markov_rows(reference, sensor, index, measured, &mut out);
    if let (Some(e), Some(entry)) = (
        measured.stability,
        reference.under(sensor, "bias.stability", index),
    ) && let Some(value) = entry.value.filter(|v| *v > 0.0)
    {
        out.terms.push(row(
            Row {
                name: "bias_stability".to_owned(),
                unit: dimension_of(sensor, Term::Flicker).si_unit(),
                term: Term::Flicker,
                reference: value,
                sigma: entry.sigma,
                is_density: false,
            },
            &e,
            false,
        ));
    }
    out
}

/// Each process of the reference beside the measured one of the nearest correlation time, or the limit of them all.
fn markov_rows(
    reference: &Model,
    sensor: Sensor,
    index: usize,
    measured: &Measured,
    out: &mut ComparedAxis,
) {
    let sheet: Vec<(usize, Entry, Entry)> = markov_entries(reference, sensor, index)
        .into_iter()
        .enumerate()
        .filter(|(_, (sigma, _))| sigma.value.is_some_and(|v| v > 0.0))
        .map(|(place, (sigma, time))| (place, sigma, time))
        .collect();
    let mut left: Vec<&GaussMarkovEstimate> = measured
        .gauss_markov
        .iter()
        .filter(|g| g.sigma.is_detected())
        .collect();
    let limit = measured
        .gauss_markov
        .iter()
        .find(|g| g.sigma.status == Status::UpperLimit);
    // The nearest pairs first.
    let mut pairs: Vec<Option<&GaussMarkovEstimate>> = vec![None; sheet.len()];
    while let Some((row, place)) = nearest(&sheet, &left, &pairs) {
        pairs[row] = Some(left.remove(place));
    }
    for ((place, sigma, time), own) in sheet.iter().zip(pairs) {
        let (found_sigma, found_time) = match own {
            Some(g) => (g.sigma, g.correlation_time_s),
            None => (
                limit.map_or(Estimate::ABSENT, |g| g.sigma),
                Estimate::ABSENT,
            ),
        };
        let is_seen = own.is_some();
        for (key, entry, found, unit) in [
            (
                "sigma",
                sigma,
                found_sigma,
                dimension_of(sensor, Term::GaussMarkov),
            ),
            ("correlation_time", time, found_time, Dimension::TIME),
        ] {
            let Some(value) = entry.value.filter(|v| *v > 0.0) else {
                continue;
            };
            let mut new = row(
                Row {
                    name: format!("gauss_markov.{}.{key}", place + 1),
                    unit: unit.si_unit(),
                    term: Term::GaussMarkov,
                    reference: value,
                    sigma: entry.sigma,
                    is_density: false,
                },
                &found,
                measured.is_coarse,
            );
            if !is_seen && key == "correlation_time" {
                "the process was not seen, so its time is not known".clone_into(&mut new.text);
            } else if !is_seen && found.status == Status::Absent {
                "no process was seen that it could be".clone_into(&mut new.text);
            }
            out.terms.push(new);
        }
    }
    for g in left {
        out.extra.push((key_of(sensor, Term::GaussMarkov), g.sigma));
    }
}

/// The row of the sheet and the measured process, of those without a partner, whose times are nearest.
fn nearest(
    sheet: &[(usize, Entry, Entry)],
    left: &[&GaussMarkovEstimate],
    pairs: &[Option<&GaussMarkovEstimate>],
) -> Option<(usize, usize)> {
    let open = (0..sheet.len()).filter(|&row| pairs[row].is_none());
    let all = open.flat_map(|row| (0..left.len()).map(move |place| (row, place)));
    let distance = |&(row, place): &(usize, usize)| {
        let (a, b) = (sheet[row].2.value, left[place].correlation_time_s.value);
        a.zip(b).map_or(f64::INFINITY, |(a, b)| (a / b).ln().abs())
    };
    all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

struct Row {
    name: String,
    unit: String,
    term: Term,
    reference: f64,
    sigma: Option<f64>,
    is_density: bool,
}

fn row(row: Row, measured: &Estimate, is_coarse: bool) -> ComparedTerm {
    let mut result = compare(row.term, measured, row.reference, row.sigma);
    let mut text = sentence(result.as_ref(), row.is_density);
    if is_coarse
        && measured.status == Status::UpperLimit
        && let Some(c) = &mut result
    {
        c.verdict = Verdict::Unclear;
        "only bounded, in values whose steps hide the noise".clone_into(&mut text);
    }
    ComparedTerm {
        name: row.name,
        unit: row.unit,
        measured: *measured,
        reference: row.reference,
        is_density: row.is_density,
        result,
        text,
    }
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
