//! How long a log must be for a wanted precision, or what a length reaches, for each axis of a model.
//!
//! Relative σ = √(J⁻¹)_aa of every non-zero random term, all of them and the mean unknown: [`sagnac_analysis::plan`].

mod picture;

use crate::characterize::key_of;
use crate::{Error, noise_terms};
use sagnac_analysis::fit::{NoiseTerms, Term};
use sagnac_analysis::plan::{
    MOST_SAMPLES, PlannedTerm, Precision, duration_for, mean_error, mean_saturates, precision,
};
use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_report::text::{Cell, Document, Table, Unit, duration, general, significant};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// What is wanted.
#[derive(Debug, Clone)]
pub enum Wanted {
    /// What a log of this length, in s reaches.
    Duration(f64),
    /// The shortest log that reaches every precision: a list like `angle_random_walk=2%, bias_instability=10%`.
    Precision(String),
}

/// One axis with noise.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedAxis {
    /// Channel: `gyro_x`.
    pub axis: String,
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// Its terms.
    pub terms: NoiseTerms,
    /// What the planned length reaches.
    pub precision: Precision,
    /// Standard error of the mean over the planned length, in SI.
    pub mean_sigma: f64,
    /// Length, in s from which on doubling it never betters the mean by 10 %.
    pub mean_saturates_s: Option<f64>,
}

/// The plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Length, in s.
    pub duration_s: f64,
    /// Samples a second.
    pub rate_hz: f64,
    /// Every axis with noise.
    pub axes: Vec<PlannedAxis>,
    /// Other lengths, in s with what they reach, an entry an axis.
    pub curve: Vec<(f64, Vec<Precision>)>,
    /// Random terms of the model that are not planned: axis and names.
    pub not_planned: Vec<(String, Vec<&'static str>)>,
    /// The term that decides the length: axis, JSON name, and the length, in s that it alone needs.
    pub decides: Vec<(String, String, f64)>,
}

/// No inertial sensor is sampled faster.
const HIGHEST_RATE_HZ: f64 = 1e9;

/// Lengths of the curve, in s: 10 min to 1 day.
const CURVE_S: [f64; 9] = [
    600.0, 1800.0, 3600.0, 7200.0, 14_400.0, 28_800.0, 43_200.0, 64_800.0, 86_400.0,
];

/// Plans the length of a log of the model's sensor at `rate_hz` (none: the model's, else 100 Hz).
///
/// # Errors
/// A rate or length that no log has; a model without noise; a name that is no term or that no axis has; a precision that a year does not reach.
pub fn plan(model: &Model, wanted: &Wanted, rate_hz: Option<f64>) -> Result<Plan, Error> {
    let rate_hz = rate_hz.or_else(|| model.sample_rate_hz()).unwrap_or(100.0);
    if !(1e-6..=HIGHEST_RATE_HZ).contains(&rate_hz) {
        return Err(Error::usage("the rate must lie between 1e-6 Hz and 1e9 Hz")
            .at(format!("a rate of {} Hz", general(rate_hz, 3)))
            .advise("write for instance --rate 200Hz"));
    }
    if let Wanted::Duration(d) = wanted
        && d * rate_hz > MOST_SAMPLES
    {
        return Err(Error::usage("no log is that long")
            .at(format!(
                "{} s at {} Hz",
                general(*d, 3),
                general(rate_hz, 3)
            ))
            .advise("write for instance --duration 4h"));
    }
    let step_s = 1.0 / rate_hz;
    let mut axes = Vec::new();
    let mut not_planned = Vec::new();
    for sensor in Sensor::ALL {
        for index in 0..3 {
            let terms = noise_terms::of_axis(model, sensor, index);
            let any = terms.quantization > 0.0
                || terms.white > 0.0
                || terms.flicker > 0.0
                || terms.random_walk > 0.0
                || terms.gauss_markov.iter().any(|g| g.0 > 0.0);
            let axis = format!("{}_{}", sensor.key(), ["x", "y", "z"][index]);
            let mut others = Vec::new();
            // A ramp alone has no noise to be known against.
            if !any && terms.ramp != 0.0 {
                others.push(key_of(sensor, Term::Ramp));
            }
            let noise = model.axis_noise(sensor, index);
            if noise.resonance.iter().any(|r| r.sigma > 0.0) {
                others.push("resonances");
            }
            if !terms.sinusoids.is_empty() {
                others.push("sinusoids");
            }
            if !others.is_empty() {
                not_planned.push((axis.clone(), others));
            }
            if any {
                axes.push((axis, sensor, terms));
            }
        }
    }
    if axes.is_empty() {
        return Err(model.missing("random terms", None).into());
    }
    let mut decides = Vec::new();
    let duration_s = match wanted {
        Wanted::Duration(d) => *d,
        Wanted::Precision(list) => {
            let parsed = wanted_precisions(list)?;
            for (name, limit) in &parsed {
                let mut found = false;
                for (axis, sensor, terms) in &axes {
                    for term in planned(name, *sensor, terms) {
                        found = true;
                        let Some(d) = duration_for(terms, step_s, &[(term, *limit)]) else {
                            return Err(Error::data(format!(
                                "{name} of {axis} does not reach {} % in a year",
                                general(100.0 * limit, 3)
                            ))
                            .at(model.label().to_owned())
                            .advise("ask for less, or leave the term out"));
                        };
                        decides.push((axis.clone(), name.clone(), d));
                    }
                }
                if !found {
                    return Err(Error::data(format!("no axis of the model has {name}"))
                        .at(model.label().to_owned())
                        .advise("ask for a term that it has, or add the term to the model"));
                }
            }
            decides.sort_by(|a, b| b.2.total_cmp(&a.2));
            decides.first().map_or(0.0, |d| d.2)
        }
    };
    let curve = CURVE_S
        .iter()
        .map(|&d| {
            (
                d,
                axes.iter()
                    .map(|(_, _, t)| precision(t, d, step_s))
                    .collect(),
            )
        })
        .collect();
    let axes = axes
        .into_iter()
        .map(|(axis, sensor, terms)| PlannedAxis {
            axis,
            sensor,
            precision: precision(&terms, duration_s, step_s),
            mean_sigma: mean_error(&terms, duration_s, step_s),
            mean_saturates_s: mean_saturates(&terms, step_s),
            terms,
        })
        .collect();
    Ok(Plan {
        duration_s,
        rate_hz,
        axes,
        curve,
        not_planned,
        decides,
    })
}

/// Names and parts of a list like `angle_random_walk=2%, bias_instability=0.1`.
///
/// # Errors
/// A name that is no term, a precision that is no positive number.
pub fn wanted_precisions(list: &str) -> Result<Vec<(String, f64)>, Error> {
    let names = [
        "quantization",
        "angle_random_walk",
        "velocity_random_walk",
        "bias_instability",
        "rate_random_walk",
        "acceleration_random_walk",
        "rate_ramp",
        "acceleration_ramp",
        "gauss_markov",
        "correlation_time",
    ];
    let usage = |what: String| {
        Error::usage(what)
            .at(list.to_owned())
            .advise("write for instance 'angle_random_walk=2%, bias_instability=10%'")
    };
    let mut out = Vec::new();
    for part in list.split(',').map(str::trim).filter(|p| !p.is_empty()) {
        let Some((name, value)) = part.split_once('=') else {
            return Err(usage(format!("`{part}` names no precision")));
        };
        let (name, value) = (name.trim(), value.trim());
        if !names.contains(&name) {
            let error = Error::usage(format!("unknown term `{name}`")).at(list.to_owned());
            return Err(error.advise(match sagnac_model::suggest(name, names) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("terms are {}", names.join(", ")),
            }));
        }
        let (digits, unit) = match value.strip_suffix('%') {
            Some(digits) => (digits.trim(), 0.01),
            None => (value, 1.0),
        };
        match digits.parse::<f64>().map(|v| v * unit) {
            Ok(v) if v.is_finite() && v > 0.0 => out.push((name.to_owned(), v)),
            _ => return Err(usage(format!("`{value}` is no precision"))),
        }
    }
    if out.is_empty() {
        return Err(usage("no precision is named".to_owned()));
    }
    Ok(out)
}

/// The numbers of an axis that a name asks for; none where the axis has no such term.
pub fn planned(name: &str, sensor: Sensor, terms: &NoiseTerms) -> Vec<PlannedTerm> {
    for (term, planned, value) in [
        (
            Term::Quantization,
            PlannedTerm::Quantization,
            terms.quantization,
        ),
        (Term::White, PlannedTerm::White, terms.white),
        (Term::Flicker, PlannedTerm::Flicker, terms.flicker),
        (Term::RandomWalk, PlannedTerm::RandomWalk, terms.random_walk),
        (Term::Ramp, PlannedTerm::Ramp, terms.ramp),
    ] {
        if key_of(sensor, term) == name && value != 0.0 {
            return vec![planned];
        }
    }
    let markov = (0..terms.gauss_markov.len()).filter(|&i| terms.gauss_markov[i].0 > 0.0);
    match name {
        "gauss_markov" => markov.map(PlannedTerm::Sigma).collect(),
        "correlation_time" => markov.map(PlannedTerm::CorrelationTime).collect(),
        _ => Vec::new(),
    }
}

fn terms_json(sensor: Sensor, terms: &NoiseTerms, p: &Precision) -> Value {
    let mut out = Map::new();
    let relative = |v: Option<f64>| json!({ "relative_sigma": v });
    for (term, value, sigma) in [
        (Term::Quantization, terms.quantization, p.quantization),
        (Term::White, terms.white, p.white),
        (Term::Flicker, terms.flicker, p.flicker),
        (Term::RandomWalk, terms.random_walk, p.random_walk),
        (Term::Ramp, terms.ramp, p.ramp),
    ] {
        if value != 0.0 {
            out.insert(key_of(sensor, term).into(), relative(sigma));
        }
    }
    if terms.gauss_markov.iter().any(|g| g.0 > 0.0) {
        let list: Vec<Value> = p
            .gauss_markov
            .iter()
            .zip(&terms.gauss_markov)
            .filter(|(_, term)| term.0 > 0.0)
            .map(|(&(sigma, time), _)| {
                json!({ "sigma": relative(sigma), "correlation_time": relative(time) })
            })
            .collect();
        out.insert("gauss_markov".into(), list.into());
    }
    Value::Object(out)
}

impl Plan {
    /// Keys as scripts rely on them.
    pub fn to_json(&self) -> Value {
        let axes: Vec<Value> = self
            .axes
            .iter()
            .map(|a| {
                json!({
                    "axis": a.axis,
                    "terms": terms_json(a.sensor, &a.terms, &a.precision),
                    "mean_sigma": a.mean_sigma,
                    "mean_saturates_s": a.mean_saturates_s,
                })
            })
            .collect();
        let curve: Vec<Value> = self
            .curve
            .iter()
            .map(|(d, list)| {
                let axes: Vec<Value> = self
                    .axes
                    .iter()
                    .zip(list)
                    .map(|(a, p)| json!({ "axis": a.axis, "terms": terms_json(a.sensor, &a.terms, p) }))
                    .collect();
                json!({ "duration_s": d, "axes": axes })
            })
            .collect();
        json!({
            "duration_s": self.duration_s,
            "rate_hz": self.rate_hz,
            "axes": axes,
            "curve": curve,
            "not_planned": self.not_planned.iter()
                .map(|(axis, terms)| json!({ "axis": axis, "terms": terms }))
                .collect::<Vec<_>>(),
        })
    }

    /// The sentence about the terms of the model that are not planned.
    fn others(&self) -> Option<String> {
        let mut parts: Vec<String> = Vec::new();
        let mut names: Vec<&str> = Vec::new();
        for name in self.not_planned.iter().flat_map(|(_, terms)| terms) {
            if !names.contains(name) {
                names.push(name);
            }
        }
        for name in names {
            for sensor in Sensor::ALL {
                let own: Vec<&str> = self
                    .not_planned
                    .iter()
                    .filter(|(_, terms)| terms.contains(&name))
                    .filter_map(|(axis, _)| axis.strip_prefix(sensor.key())?.strip_prefix('_'))
                    .collect();
                let shown = match name {
                    "sinusoids" | "resonances" => name.to_owned(),
                    _ => sagnac_report::text::term_in_sentence(name),
                };
                match own.len() {
                    0 => {}
                    3 => parts.push(format!("{shown} of {}", sensor.key())),
                    _ => parts.push(format!("{shown} of {} {}", sensor.key(), own.join(", "))),
                }
            }
        }
        (!parts.is_empty()).then(|| {
            format!(
                "not planned: {}; the others are planned as if these were not there",
                parts.join("; ")
            )
        })
    }

    /// Axes that have the same numbers, under one name: `gyro`, `gyro x`.
    fn groups(&self) -> Vec<(String, usize)> {
        let mut out = Vec::new();
        for sensor in Sensor::ALL {
            let own: Vec<usize> = (0..self.axes.len())
                .filter(|&i| self.axes[i].sensor == sensor)
                .collect();
            let Some(&first) = own.first() else { continue };
            if own
                .iter()
                .all(|&i| self.axes[i].terms == self.axes[first].terms)
            {
                out.push((sensor.key().to_owned(), first));
            } else {
                out.extend(
                    own.iter()
                        .map(|&i| (self.axes[i].axis.replace('_', " "), i)),
                );
            }
        }
        out
    }

    /// As a terminal shows it.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.paragraph(self.answer());
        for (name, index) in self.groups() {
            out.blank();
            out.table(self.table(&name, index));
        }
        out.blank();
        for (name, index) in self.groups() {
            let never = self.not_observable(index);
            if !never.is_empty() {
                out.paragraph(format!(
                    "{} of {name}: not observable in this time.",
                    never.join(", ")
                ));
            }
        }
        for (name, index) in self.groups() {
            let axis = &self.axes[index];
            let unit = match axis.sensor {
                Sensor::Gyro => Unit::DEG_PER_H,
                Sensor::Accel => Unit::MICRO_G,
            };
            let mean = general(axis.mean_sigma * unit.per_si, 3);
            let mut text = format!(
                "The mean of {name} is known to {mean} {} (1 sigma) in this time",
                unit.text
            );
            match axis.mean_saturates_s {
                Some(s) if s < self.duration_s => {
                    let _ = write!(
                        text,
                        "; beyond {} more time no longer helps it, the other terms improve on.",
                        duration(rounded(s))
                    );
                }
                _ => text.push('.'),
            }
            out.paragraph(text);
        }
        if let Some(others) = self.others() {
            out.note(others);
        }
        out
    }

    fn answer(&self) -> String {
        let head = format!(
            "{} at {} Hz.",
            duration(rounded(self.duration_s)),
            general(self.rate_hz, 4)
        );
        let Some((axis, name, _)) = self.decides.first() else {
            return head;
        };
        let mut text = format!(
            "{head} {} of {} decides",
            sagnac_report::text::term_name(name),
            axis.replace('_', " ")
        );
        // The other term that was asked for, and what it alone needs.
        if let Some((_, other, need)) = self.decides.iter().find(|d| d.1 != *name) {
            let _ = write!(
                text,
                "; {} needs {}",
                sagnac_report::text::term_in_sentence(other),
                duration(rounded(*need))
            );
        }
        text.push('.');
        text
    }

    /// Letters of the terms whose bound stays above 100 % in the planned length.
    fn not_observable(&self, index: usize) -> Vec<String> {
        let axis = &self.axes[index];
        columns_of(&axis.terms)
            .into_iter()
            .filter(|(_, term)| axis.precision.of(*term).is_none())
            .map(|(symbol, _)| symbol)
            .collect()
    }

    fn table(&self, name: &str, index: usize) -> Table {
        let axis = &self.axes[index];
        let columns: Vec<(String, PlannedTerm)> = columns_of(&axis.terms)
            .into_iter()
            .map(|(symbol, term)| (format!("{symbol}, 1 sigma"), term))
            .collect();
        let first = format!("{name}, length");
        let mut heading: Vec<&str> = vec![&first];
        heading.extend(columns.iter().map(|c| c.0.as_str()));
        let mut table = Table::new(&heading, &[]);
        let mut lengths: Vec<(f64, &Precision)> = self
            .curve
            .iter()
            .filter(|(d, _)| [600.0, 3600.0, 14_400.0, 86_400.0].contains(d))
            .map(|(d, list)| (*d, &list[index]))
            .collect();
        if !lengths
            .iter()
            .any(|(d, _)| (d / self.duration_s - 1.0).abs() < 1e-6)
        {
            lengths.push((self.duration_s, &axis.precision));
        }
        lengths.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (d, p) in lengths {
            let mut row: Vec<Cell> = vec![duration(rounded(d)).into()];
            row.extend(columns.iter().map(|(_, term)| -> Cell {
                p.of(*term)
                    .map_or_else(|| "not yet".to_owned(), percent)
                    .into()
            }));
            table.row(row);
        }
        table
    }
}

/// Letters of the terms that an axis has, in the order of a table.
fn columns_of(terms: &NoiseTerms) -> Vec<(String, PlannedTerm)> {
    let mut out: Vec<(String, PlannedTerm)> = [
        ("Q", PlannedTerm::Quantization, terms.quantization),
        ("N", PlannedTerm::White, terms.white),
        ("B", PlannedTerm::Flicker, terms.flicker),
        ("K", PlannedTerm::RandomWalk, terms.random_walk),
        ("R", PlannedTerm::Ramp, terms.ramp),
    ]
    .into_iter()
    .filter(|t| t.2 != 0.0)
    .map(|t| (t.0.to_owned(), t.1))
    .collect();
    let markov: Vec<usize> = (0..terms.gauss_markov.len())
        .filter(|&i| terms.gauss_markov[i].0 > 0.0)
        .collect();
    for (place, &i) in markov.iter().enumerate() {
        let number = if markov.len() > 1 {
            format!(" {}", place + 1)
        } else {
            String::new()
        };
        out.push((format!("GM sigma{number}"), PlannedTerm::Sigma(i)));
        out.push((format!("GM time{number}"), PlannedTerm::CorrelationTime(i)));
    }
    out
}

/// A precision with two significant digits.
fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// A length to about one per cent, in whole minutes or seconds.
fn rounded(seconds: f64) -> f64 {
    let unit = if seconds > 36_000.0 {
        600.0
    } else if seconds > 3000.0 {
        60.0
    } else {
        1.0
    };
    if seconds < 60.0 {
        seconds
    } else {
        (seconds / unit).round() * unit
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn planned_for(body: &str, duration_s: f64, rate_hz: f64) -> Result<Plan, Error> {
        let text = format!("schema = 1\nname = \"a\"\n[gyro.noise]\n{body}");
        let model = Model::parse(&text, "a.toml").unwrap();
        plan(&model, &Wanted::Duration(duration_s), Some(rate_hz))
    }

    #[test]
    fn small_precisions_have_two_digits() {
        let plan = planned_for(
            "angle_random_walk = \"0.3 deg/sqrt(h)\"\n",
            86_400.0,
            2000.0,
        );
        let text = plan
            .unwrap()
            .document()
            .render(sagnac_report::text::Style::PLAIN);
        // 1/sqrt(2 n)
        assert!(text.contains("1 day           0.0054 %"), "{text}");
        assert_eq!(
            (percent(0.123), percent(0.999)),
            ("12 %".into(), "100 %".into())
        );
    }

    #[test]
    fn rates_and_lengths_that_no_log_has_are_refused() {
        let white = "angle_random_walk = \"0.3 deg/sqrt(h)\"\n";
        for (duration_s, rate_hz) in [(3600.0, 1e10), (3600.0, 1e-9), (1e30, 100.0)] {
            let error = planned_for(white, duration_s, rate_hz).unwrap_err();
            assert_eq!(error.kind, crate::Kind::Usage, "{error:?}");
        }
        assert!(planned_for(white, 3600.0, 1e9).is_ok());
    }

    #[test]
    fn terms_that_are_not_planned_are_named() {
        let white = "angle_random_walk = \"0.3 deg/sqrt(h)\"\n";
        let lines = "sinusoids = [{ amplitude = [\"10 deg/h\", \"0 deg/h\", \"0 deg/h\"], frequency = \"10 Hz\" }]\n\
                     resonances = [{ sigma = \"1 deg/s\", frequency = \"40 Hz\", damping = 0.1 }]\n";
        let plan = planned_for(&format!("{white}{lines}"), 3600.0, 100.0).unwrap();
        let text = plan.document().render(sagnac_report::text::Style::PLAIN);
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            words.contains("not planned: resonances of gyro; sinusoids of gyro x; the others"),
            "{text}"
        );
        assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
        assert_eq!(
            plan.to_json()["not_planned"][0],
            json!({ "axis": "gyro_x", "terms": ["resonances", "sinusoids"] })
        );
        let plain = planned_for(white, 3600.0, 100.0).unwrap();
        assert_eq!(plain.to_json()["not_planned"], json!([]));
        let text = plain.document().render(sagnac_report::text::Style::PLAIN);
        assert!(!text.contains("not planned"), "{text}");
        let ramp = "rate_ramp = [\"0 deg/h/h\", \"1 deg/h/h\", \"0 deg/h/h\"]\n\
                    angle_random_walk = [\"1 deg/sqrt(h)\", \"0 deg/sqrt(h)\", \"1 deg/sqrt(h)\"]\n";
        let plan = planned_for(ramp, 3600.0, 100.0).unwrap();
        assert_eq!(plan.not_planned, [("gyro_y".to_owned(), vec!["rate_ramp"])]);
    }

    #[test]
    fn a_gauss_markov_term_does_not_end_the_gain() {
        let markov = "gauss_markov = [{ sigma = \"60 deg/h\", correlation_time = \"30 s\" }]\n";
        let text = |body: &str| {
            let plan = planned_for(body, 57_600.0, 25.0).unwrap();
            plan.document().render(sagnac_report::text::Style::PLAIN)
        };
        assert!(
            !text(markov).contains("no longer helps"),
            "{}",
            text(markov)
        );
        let walk = format!("{markov}rate_random_walk = \"1 deg/h/sqrt(h)\"\n");
        assert!(text(&walk).contains("no longer"), "{}", text(&walk));
    }
}
