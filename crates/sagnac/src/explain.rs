//! `explain`: what each term of the measurement adds to each axis, for one input.
//!
//! The lecture's equations (1) and (2) with the user's numbers: accelerometer terms are
//! evaluated at f', so that `axis_offset` is f' − f and the sum of all is output − input.

#![allow(
    clippy::needless_pass_by_value,
    reason = "the caller has no more use for it"
)]

use sagnac_core::{Compensation, Measurement, Output, Sensor, SensorModel, Truth, vector};
use sagnac_model::Model;
use sagnac_model::units::{Dimension, parse_quantity};
use sagnac_report::html::{ExplainPage, Opening, RandomRow, Rich};
use sagnac_report::plots::{ExplainPanel, explain_panels};
use sagnac_report::svg::{Svg, page_number};
use sagnac_report::text::{Document, general};
use serde_json::{Value, json};

use crate::Error;

/// Standard gravity, m/s².
const G: f64 = 9.80665;
const DEG: f64 = core::f64::consts::PI / 180.0;

/// The input that is explained.
pub type At = Truth<f64>;

/// The default input: level at rest, f = (0, 0, −1 g), T = T0.
pub fn level_at_rest(reference_temperature_c: f64) -> At {
    Truth {
        specific_force: [0.0, 0.0, -G],
        temperature_c: reference_temperature_c,
        ..Truth::default()
    }
}

/// Reads `'f=0 0 -9.81 m/s^2, w=10 0 0 deg/s, wdot=0 0 0 rad/s^2, T=40 degC'`; what is not
/// named keeps its default.
///
/// # Errors
/// An unknown name, a wrong number of numbers, a wrong dimension: of kind usage.
pub fn parse_at(text: &str, reference_temperature_c: f64) -> Result<At, Error> {
    const ADVICE: &str = "write for instance --at 'f=0 0 -9.81 m/s^2, w=10 0 0 deg/s, T=40 degC'";
    let mut at = level_at_rest(reference_temperature_c);
    let mut named: Vec<&str> = Vec::new();
    for part in text
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
    {
        let wrong = |what: String| {
            Error::usage(what)
                .at(format!("--at, {part}"))
                .advise(ADVICE)
        };
        let (name, value) = part
            .split_once('=')
            .ok_or_else(|| wrong(format!("`{part}` is not NAME=VALUE")))?;
        let quantity = |text: &str, dimension| {
            parse_quantity(text, dimension).map_err(|error| wrong(error.to_string()))
        };
        let three = |dimension| -> Result<[f64; 3], Error> {
            let words: Vec<&str> = value.split_whitespace().collect();
            let [x, y, z, unit @ ..] = words.as_slice() else {
                return Err(wrong(format!(
                    "{} needs three numbers and a unit",
                    name.trim()
                )));
            };
            let unit = unit.join(" ");
            let one = |number: &str| quantity(&format!("{number} {unit}"), dimension);
            Ok([one(x)?, one(y)?, one(z)?])
        };
        if named.contains(&name.trim()) {
            return Err(wrong(format!("`{}` is given twice", name.trim())));
        }
        named.push(name.trim());
        match name.trim() {
            "f" => at.specific_force = three(Dimension::ACCELERATION)?,
            "w" => at.angular_rate = three(Dimension::ANGULAR_RATE)?,
            "wdot" => at.angular_acceleration = three(Dimension::ANGULAR_ACCELERATION)?,
            "T" => {
                at.temperature_c = quantity(value.trim(), Dimension::TEMPERATURE)?;
                if at.temperature_c < crate::simulate::ABSOLUTE_ZERO_C {
                    return Err(wrong(format!("{} is below absolute zero", value.trim())));
                }
            }
            other => return Err(wrong(format!("`{other}` is none of f, w, wdot, T"))),
        }
    }
    Ok(at)
}

/// What one axis shows.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisTerms {
    /// `gyro_x` … `accel_z`.
    pub axis: String,
    /// Which triad.
    pub sensor: Sensor,
    /// True value, rad/s or m/s².
    pub input: f64,
    /// What is read, without noise and draws.
    pub output: f64,
    /// Terms by key path with what they add, largest first.
    pub terms: Vec<(String, f64)>,
    /// Random terms with the σ that they give a sample.
    pub random: Vec<(String, f64)>,
}

/// The answer of `explain`.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainOutcome {
    /// The model's name.
    pub name: String,
    /// The input.
    pub at: At,
    /// Six axes.
    pub axes: Vec<AxisTerms>,
    /// Whether the temperature lies outside the range in which the terms are known.
    pub is_temperature_outside: bool,
    /// Why `correct` refuses the model, where it does.
    pub no_inverse: Option<String>,
}

/// What each term adds to each axis at one input.
///
/// # Errors
/// A model that the core cannot take.
pub fn explain(model: &Model, at: &At) -> Result<ExplainOutcome, Error> {
    let core = model.to_core()?;
    let forward = Measurement::new(&core);
    let dt_s = 1.0 / model.sample_rate_hz().unwrap_or(100.0);
    let mut axes = Vec::new();
    let mut is_temperature_outside = false;
    for sensor in Sensor::ALL {
        let terms = deterministic(&core, &forward, sensor, at, dt_s);
        let per_si = shown(sensor).per_si;
        let is_beyond = |v: &[f64; 3]| v.iter().any(|v| !(v * per_si).is_finite());
        if let Some((name, _)) = terms.iter().find(|(_, v)| is_beyond(v)) {
            return Err(Error::data(format!(
                "{}.{name} is beyond every number at this input",
                sensor.key()
            ))
            .at(model.label().to_owned())
            .advise("look for a wrong unit in the model or in --at"));
        }
        let triad = core.triad(sensor);
        for table in [&triad.bias.temperature, &triad.scale_factor.temperature] {
            if let Some([low, high]) = table.effective_range_c(core.temperature_range_c) {
                is_temperature_outside |=
                    table.is_present() && !(low..=high).contains(&at.temperature_c);
            }
        }
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let input = truth_of(sensor, at)[k];
            let mut of_axis: Vec<(String, f64)> = terms
                .iter()
                .map(|(name, values)| ((*name).to_owned(), values[k]))
                .filter(|(_, value)| *value != 0.0)
                .collect();
            of_axis.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let sum: f64 = of_axis.iter().map(|term| term.1).sum();
            axes.push(AxisTerms {
                axis: format!("{}_{axis}", sensor.key()),
                sensor,
                input,
                output: input + sum,
                terms: of_axis,
                random: random(model, sensor, k, dt_s, at),
            });
        }
    }
    Ok(ExplainOutcome {
        name: model.name().to_owned(),
        at: *at,
        axes,
        is_temperature_outside,
        no_inverse: no_inverse(&core, dt_s),
    })
}

/// Why the model cannot be inverted, where it cannot.
pub(crate) fn no_inverse(core: &SensorModel<f64>, dt_s: f64) -> Option<String> {
    let error = Compensation::new(core, dt_s).err()?;
    Some(format!("{error}: `correct` refuses this model"))
}

/// The term that takes the reading of a triad beyond every number: the first that is no finite
/// number, else the largest; `None` where all terms and their sum are finite.
pub(crate) fn beyond_every_number(
    core: &SensorModel<f64>,
    sensor: Sensor,
    at: &At,
    dt_s: f64,
) -> Option<&'static str> {
    let mut terms = deterministic(core, &Measurement::new(core), sensor, at, dt_s);
    // These follow from the sum.
    terms.retain(|(name, _)| !matches!(*name, "range" | "resolution"));
    let size = |v: &[f64; 3]| v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let is_finite = |v: &[f64; 3]| v.iter().all(|v| v.is_finite());
    if let Some((name, _)) = terms.iter().find(|(_, v)| !is_finite(v)) {
        return Some(name);
    }
    let sum = terms
        .iter()
        .fold(truth_of(sensor, at), |sum, (_, v)| vector::add(sum, *v));
    let largest = terms
        .iter()
        .max_by(|a, b| size(&a.1).total_cmp(&size(&b.1)));
    largest.filter(|_| !is_finite(&sum)).map(|(name, _)| *name)
}

fn truth_of(sensor: Sensor, at: &At) -> [f64; 3] {
    match sensor {
        Sensor::Gyro => at.angular_rate,
        Sensor::Accel => at.specific_force,
    }
}

/// The terms of one triad in the order of the physics.
fn deterministic(
    core: &SensorModel<f64>,
    forward: &Measurement<f64>,
    sensor: Sensor,
    at: &At,
    dt_s: f64,
) -> Vec<(&'static str, [f64; 3])> {
    let triad = core.triad(sensor);
    let errors = forward.errors(sensor);
    let t = at.temperature_c;
    let truth = truth_of(sensor, at);
    let u = match sensor {
        Sensor::Gyro => at.angular_rate,
        Sensor::Accel => forward.at_accelerometers(at),
    };
    let times = |a: [f64; 3]| [a[0] * u[0], a[1] * u[1], a[2] * u[2]];
    let scale_at_t = sagnac_core::Thermal::new(
        &triad.scale_factor.temperature,
        core.reference_temperature_c,
        core.temperature_range_c,
    )
    .at(t);
    let mut terms = vec![
        ("axis_offset", vector::sub(u, truth)),
        ("bias.fixed", triad.bias.fixed),
        (
            "bias.temperature",
            vector::sub(errors.bias(t), triad.bias.fixed),
        ),
        ("scale_factor.fixed", times(triad.scale_factor.fixed)),
        ("scale_factor.temperature", times(scale_at_t)),
        (
            "scale_factor.quadratic",
            triad.nonlinearity.quadratic_part(u),
        ),
        ("scale_factor.cubic", triad.nonlinearity.cubic_part(u)),
        ("scale_factor.asymmetry", triad.asymmetry.part(u)),
        ("misalignment.fixed", triad.misalignment.elements.part(u)),
        ("cross_axis.fixed", triad.cross_axis.elements.part(u)),
    ];
    if sensor == Sensor::Gyro {
        terms.push((
            "g_sensitivity.matrix",
            core.gyro_g_sensitivity.part(at.specific_force),
        ));
        terms.push((
            "g2_sensitivity.matrix",
            core.gyro_g2_sensitivity.part(at.specific_force),
        ));
    }
    let mut y = truth;
    for (_, values) in &terms {
        y = vector::add(y, *values);
    }
    let saturated = triad.range.saturate(y);
    terms.push(("range", vector::sub(saturated, y)));
    if triad.resolution.output == Output::Rate {
        let (rounded, _) = triad.resolution.round(saturated, [0.0; 3], dt_s);
        terms.push(("resolution", vector::sub(rounded, saturated)));
    }
    terms
}

/// The random terms of one axis with the σ that they give a sample.
pub(crate) fn random(
    model: &Model,
    sensor: Sensor,
    k: usize,
    dt_s: f64,
    at: &At,
) -> Vec<(String, f64)> {
    let noise = model.axis_noise(sensor, k);
    let stability = model.stability(sensor);
    let u = truth_of(sensor, at);
    let hour = 3600.0_f64.sqrt();
    let walk = Model::walk_key(sensor);
    let mut out = vec![
        (
            "noise.quantization".to_owned(),
            2.0_f64.sqrt() * noise.quantization.coefficient / dt_s,
        ),
        (
            format!("noise.{}", Model::white_key(sensor)),
            noise.white.density / dt_s.sqrt(),
        ),
        (
            "bias.instability".to_owned(),
            sagnac_model::FLICKER_FLOOR * noise.flicker.coefficient,
        ),
        (
            format!("noise.{walk}, after 1 h"),
            noise.random_walk.coefficient * hour,
        ),
        (
            format!("bias.instability.{walk}, after 1 h"),
            noise.instability_random_walk.coefficient * hour,
        ),
        (
            "bias.instability".to_owned(),
            noise.instability_gauss_markov.sigma,
        ),
    ];
    for (i, process) in noise.gauss_markov.iter().enumerate() {
        out.push((format!("noise.gauss_markov.{}", i + 1), process.sigma));
    }
    for (i, line) in noise.sinusoid.iter().enumerate() {
        out.push((
            format!("noise.sinusoids.{}", i + 1),
            line.amplitude / 2.0_f64.sqrt(),
        ));
    }
    for (i, process) in noise.resonance.iter().enumerate() {
        out.push((format!("noise.resonances.{}", i + 1), process.sigma));
    }
    out.push(("bias.stability".to_owned(), stability.bias[k]));
    out.push((
        "scale_factor.stability".to_owned(),
        stability.scale_factor[k] * u[k].abs(),
    ));
    let lean: f64 = sagnac_core::Element::ALL
        .iter()
        .filter(|element| element.row().index() == k)
        .map(|element| {
            (stability.misalignment[element.index()] * u[element.column().index()]).powi(2)
        })
        .sum();
    out.push(("misalignment.stability".to_owned(), lean.sqrt()));
    out.retain(|(_, sigma)| *sigma > 0.0);
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

/// Unit of contributions and of input and output: name and SI value, as text and as on a page.
struct Shown {
    term: &'static str,
    term_page: &'static str,
    per_si: f64,
    level: &'static str,
    level_page: &'static str,
    level_per_si: f64,
}

fn shown(sensor: Sensor) -> Shown {
    match sensor {
        Sensor::Gyro => Shown {
            term: "deg/h",
            term_page: "°/h",
            per_si: 3600.0 / DEG,
            level: "deg/s",
            level_page: "°/s",
            level_per_si: 1.0 / DEG,
        },
        Sensor::Accel => Shown {
            term: "mg",
            term_page: "mg",
            per_si: 1000.0 / G,
            level: "m/s^2",
            level_page: "m/s²",
            level_per_si: 1.0,
        },
    }
}

impl ExplainOutcome {
    /// The JSON document.
    pub fn to_json(&self) -> Value {
        let axes: Vec<Value> = self
            .axes
            .iter()
            .map(|axis| {
                let terms: Vec<Value> = axis
                    .terms
                    .iter()
                    .map(|(term, value)| json!({"term": term, "value": value}))
                    .collect();
                let random: Vec<Value> = axis
                    .random
                    .iter()
                    .map(|(term, sigma)| match term.strip_suffix(", after 1 h") {
                        Some(term) => json!({"term": term, "sigma": sigma, "after_s": 3600.0}),
                        None => json!({"term": term, "sigma": sigma}),
                    })
                    .collect();
                json!({
                    "axis": axis.axis,
                    "input": axis.input,
                    "output": axis.output,
                    "unit": if axis.sensor == Sensor::Gyro { "rad/s" } else { "m/s^2" },
                    "terms": terms,
                    "random": random,
                })
            })
            .collect();
        json!({"model": self.name, "axes": axes, "warnings": self.warnings()})
    }

    fn warnings(&self) -> Vec<String> {
        let outside = self.is_temperature_outside.then(|| {
            "the temperature is outside the model's range: the nearer end is taken".to_owned()
        });
        outside.into_iter().chain(self.no_inverse.clone()).collect()
    }

    /// The largest term of a sensor: axis, term, value.
    fn largest(&self, sensor: Sensor) -> Option<(&AxisTerms, &str, f64)> {
        self.axes
            .iter()
            .filter(|axis| axis.sensor == sensor)
            .filter_map(|axis| {
                axis.terms
                    .first()
                    .map(|(term, value)| (axis, term.as_str(), *value))
            })
            .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
    }

    fn verdict(&self, page: bool) -> String {
        let mut sentences = Vec::new();
        for sensor in Sensor::ALL {
            if let Some((axis, term, value)) = self.largest(sensor) {
                let unit = shown(sensor);
                sentences.push(format!(
                    "{} is the largest {} error here: {} {} on {}.",
                    capital(words(term)),
                    sensor.name(),
                    if page {
                        page_number(&general(value * unit.per_si, 4))
                    } else {
                        general(value * unit.per_si, 4)
                    },
                    if page { unit.term_page } else { unit.term },
                    axis.axis.rsplit('_').next().unwrap_or_default(),
                ));
            }
        }
        if sentences.is_empty() {
            "The model has no deterministic error at this input.".to_owned()
        } else {
            sentences.join(" ")
        }
    }

    /// The text for a terminal.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.paragraph(self.verdict(false));
        for warning in self.warnings() {
            out.warning(warning);
        }
        for sensor in Sensor::ALL {
            let unit = shown(sensor);
            let of_sensor = || self.axes.iter().filter(move |axis| axis.sensor == sensor);
            let sum = |axis: &AxisTerms| axis.terms.iter().map(|t| t.1).sum::<f64>() + 0.0;
            // Bars to the left have 18 columns, to the right 25, one scale for the sensor.
            let values = || {
                of_sensor()
                    .flat_map(move |axis| axis.terms.iter().map(|t| t.1).chain([sum(axis)]))
                    .map(|v| v * unit.per_si)
            };
            let room = |v: f64| if v < 0.0 { 18.0 } else { 25.0 };
            let per_column = values().fold(0.0_f64, |most, v| most.max(v.abs() / room(v)));
            for axis in of_sensor() {
                let level = |x: f64| general(x * unit.level_per_si, 6);
                let head = format!("{}, {}", axis.axis.replace('_', " "), unit.term);
                let tail = format!(
                    "in {} {u}, out {} {u}",
                    level(axis.input),
                    level(axis.output),
                    u = unit.level
                );
                let space = 78_usize.saturating_sub(head.len() + tail.len()).max(2);
                out.blank()
                    .heading(format!("{head}{}{tail}", " ".repeat(space)));
                for (term, value) in &axis.terms {
                    out.line(bar(term, value * unit.per_si, per_column));
                }
                out.line(bar("sum", sum(axis) * unit.per_si, per_column));
            }
            let random = self.random_rows(sensor);
            if !random.is_empty() {
                let mut table = sagnac_report::text::Table::new(
                    &[
                        &format!("{} noise, 1 sigma", sensor.key()),
                        "x",
                        "y",
                        "z",
                        "",
                    ],
                    &[],
                );
                for (term, sigma) in random {
                    let [x, y, z] = sigma;
                    table.row([term, x, y, z, unit.term.to_owned()]);
                }
                out.blank().table(table);
            }
        }
        out
    }

    /// Random terms of a sensor with σ on x, y, z in the unit of its terms.
    fn random_rows(&self, sensor: Sensor) -> Vec<(String, [String; 3])> {
        let per_si = shown(sensor).per_si;
        let axes: Vec<&AxisTerms> = self.axes.iter().filter(|a| a.sensor == sensor).collect();
        let mut names: Vec<&str> = Vec::new();
        for (term, _) in axes.iter().flat_map(|axis| &axis.random) {
            if !names.contains(&term.as_str()) {
                names.push(term);
            }
        }
        let cell = |k: usize, term: &str| {
            let found = axes
                .get(k)
                .and_then(|axis| axis.random.iter().find(|r| r.0 == term));
            found.map_or_else(|| "-".to_owned(), |r| general(r.1 * per_si, 4))
        };
        names
            .into_iter()
            .map(|term| (term.to_owned(), [0, 1, 2].map(|k| cell(k, term))))
            .collect()
    }

    /// The panels of a sensor, for pages and pictures.
    pub fn panels(&self, sensor: Sensor) -> Vec<ExplainPanel> {
        let unit = shown(sensor);
        self.axes
            .iter()
            .filter(|axis| axis.sensor == sensor)
            .map(|axis| ExplainPanel {
                axis: axis.axis.clone(),
                note: page_number(&format!(
                    "input {}, output {} {}",
                    general(axis.input * unit.level_per_si, 6),
                    // One line of a third of the page: m/s^2 takes more room than deg/s.
                    general(
                        axis.output * unit.level_per_si,
                        if sensor == Sensor::Gyro { 7 } else { 6 }
                    ),
                    unit.level_page
                )),
                unit: unit.term_page.to_owned(),
                terms: axis
                    .terms
                    .iter()
                    .map(|(term, value)| (term.clone(), value * unit.per_si))
                    .collect(),
                sum: (axis.terms.iter().map(|t| t.1).sum::<f64>() + 0.0) * unit.per_si,
            })
            .collect()
    }

    /// The page: verdict, input, a panel an axis; `command` is what was typed.
    pub fn to_page(&self, command: &str, version: &str) -> ExplainPage {
        let three = |v: [f64; 3], per_si: f64| {
            page_number(&v.map(|x| general(x * per_si + 0.0, 6)).join(", "))
        };
        let mut input = format!(
            "f = ({}) m/s², ω = ({}) °/s",
            three(self.at.specific_force, 1.0),
            three(self.at.angular_rate, 1.0 / DEG)
        );
        if self.at.angular_acceleration != [0.0; 3] {
            input += &format!(
                ", ω̇ = ({}) rad/s²",
                three(self.at.angular_acceleration, 1.0)
            );
        }
        input += &format!(
            ", T = {} °C",
            page_number(&general(self.at.temperature_c, 5))
        );
        let mut limits = Vec::new();
        if self.is_temperature_outside {
            limits.push(Rich::new().plain(
                "The temperature is outside the model’s range: the terms are taken at its nearer end.",
            ));
        }
        if let Some(why) = &self.no_inverse {
            limits.push(Rich::new().plain(format!("{}.", capital(why.replace('`', "")))));
        }
        ExplainPage {
            opening: Opening {
                name: self.name.clone(),
                subtitle: input,
                verdict: Rich::new().bold(self.verdict(true)),
                version: version.to_owned(),
                command: command.to_owned(),
                method: Rich::new().plain(
                    "The lecture’s equations (1) and (2) term by term; accelerometer terms at the force \
                     that each accelerometer feels where it sits, so that axis offset is that force less the one at the \
                     center. The bars are without run-to-run draws and noise.",
                ),
                limits,
                ..Opening::default()
            },
            gyro: self.panels(Sensor::Gyro),
            accel: self.panels(Sensor::Accel),
            random: Sensor::ALL.map(|sensor| {
                let rows = self.random_rows(sensor).into_iter();
                rows.map(|(term, sigma)| RandomRow {
                    term,
                    sigma: sigma.map(|text| page_number(&text)),
                    unit: shown(sensor).term_page.to_owned(),
                })
                .collect()
            }),
        }
    }

    /// The picture: a row of panels a sensor.
    pub fn svg(&self) -> Svg {
        let row = |sensor| -> Vec<Svg> {
            explain_panels(&self.panels(sensor))
                .iter()
                .map(|figure| figure.svg.captioned(&figure.caption, &figure.caption_rest))
                .collect()
        };
        Svg::sheet(
            &format!("{}: {}", self.name, self.verdict(true)),
            &[row(Sensor::Gyro), row(Sensor::Accel)],
        )
    }
}

/// A line of the text: name, value, and a bar to the left or right of its zero.
fn bar(term: &str, value: f64, per_column: f64) -> String {
    let length = if per_column > 0.0 && value != 0.0 {
        ((value.abs() / per_column).round() as usize).clamp(1, 25)
    } else {
        0
    };
    let marks = "#".repeat(length);
    let number = if value.abs() >= 0.005 || value == 0.0 {
        format!("{value:.2}")
    } else {
        general(value, 2)
    };
    let (left, right) = if value < 0.0 {
        (marks.as_str(), "")
    } else {
        ("", marks.as_str())
    };
    format!("{term:<24} {number:>8}{left:>20}|{right}")
        .trim_end()
        .to_owned()
}

/// A term in words: `g_sensitivity.matrix` is `g sensitivity`.
fn words(term: &str) -> String {
    match term {
        "bias.fixed" => "fixed bias".to_owned(),
        "bias.temperature" => "bias with temperature".to_owned(),
        "scale_factor.fixed" => "scale factor".to_owned(),
        "scale_factor.temperature" => "scale factor with temperature".to_owned(),
        "scale_factor.quadratic" => "quadratic nonlinearity".to_owned(),
        "scale_factor.cubic" => "cubic nonlinearity".to_owned(),
        "scale_factor.asymmetry" => "scale factor asymmetry".to_owned(),
        "cross_axis.fixed" => "cross-axis response".to_owned(),
        "g_sensitivity.matrix" => "g-sensitivity".to_owned(),
        "g2_sensitivity.matrix" => "g^2-sensitivity".to_owned(),
        "range" => "saturation".to_owned(),
        other => other.split('.').next().unwrap_or(other).replace('_', " "),
    }
}

fn capital(text: String) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(chars).collect()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn terms_sum_to_output_less_input() {
        let model = Model::parse(
            "name = \"t\"\n[gyro.bias]\nfixed = \"12 deg/h\"\n[gyro]\nresolution = \"0.01 deg/s\"\n[accel.axis_offset]\nx = [\"10 mm\", \"0 mm\", \"0 mm\"]\n",
            "t.toml",
        );
        let model = model.unwrap();
        let at = parse_at("f=1 0 -9.81 m/s^2, w=10 0 -5 deg/s, T=40 degC", 25.0).unwrap();
        let outcome = explain(&model, &at).unwrap();
        for axis in &outcome.axes {
            let sum: f64 = axis.terms.iter().map(|t| t.1).sum();
            assert!((sum - (axis.output - axis.input)).abs() < 1e-15);
        }
        assert!(
            outcome
                .document()
                .render(sagnac_report::text::Style::PLAIN)
                .lines()
                .all(|l| l.chars().count() <= 80)
        );
        // The sum's bar is in the unit of the terms' bars.
        for sensor in Sensor::ALL {
            for panel in outcome.panels(sensor) {
                let sum: f64 = panel.terms.iter().map(|t| t.1).sum();
                // Terms may cancel: their sizes, not their sum, set the rounding.
                let size: f64 = panel.terms.iter().map(|t| t.1.abs()).sum();
                assert!((panel.sum - sum).abs() <= 1e-12 * size);
            }
        }
        let page = outcome.to_page("explain t.toml", "0").html();
        assert!(page.contains("output less input"));
        assert!(parse_at("f=1 0 m/s^2", 25.0).is_err());
        assert!(parse_at("q=1", 25.0).is_err());
        let twice = parse_at("T=30 degC, T=40 degC", 25.0).unwrap_err();
        assert!(twice.to_string().contains("given twice"));
    }
}
