//! `explain`: what each term of the measurement adds to each axis, for one input.
//!
//! The lecture's equations (1) and (2) with the user's numbers: accelerometer terms are
//! evaluated at f', so that `axis_offset` is f' − f and the sum of all is output − input.

mod view;

use sagnac_core::{Compensation, Measurement, Output, Sensor, SensorModel, Truth, vector};
use sagnac_model::Model;
use sagnac_model::units::{Dimension, parse_quantity};

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
    // Commas part what is named, and may part its three numbers too.
    let mut parts: Vec<String> = Vec::new();
    for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
        match parts.last_mut().filter(|_| !part.contains('=')) {
            Some(last) => *last = format!("{last} {part}"),
            None => parts.push(part.to_owned()),
        }
    }
    for part in parts.iter().map(String::as_str) {
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
/// A model that the core cannot take; an input whose cube is beyond every number.
pub fn explain(model: &Model, at: &At) -> Result<ExplainOutcome, Error> {
    let core = model.to_core()?;
    for (name, input) in [
        ("f", at.specific_force),
        ("w", at.angular_rate),
        ("wdot", at.angular_acceleration),
    ] {
        // Terms go up to its cube, in units as small as deg/h.
        if input.iter().any(|x| !(x.powi(3) * 1e6).is_finite()) {
            return Err(Error::usage(format!(
                "{name} is too large to reckon with: its cube is beyond every number"
            ))
            .at("--at")
            .advise("look for a wrong power of ten"));
        }
    }
    let forward = Measurement::new(&core);
    let dt_s = 1.0 / model.sample_rate_hz().unwrap_or(100.0);
    let mut axes = Vec::new();
    let mut is_temperature_outside = false;
    for sensor in Sensor::ALL {
        let terms = deterministic(&core, &forward, sensor, at, dt_s);
        let per_si = view::shown(sensor).per_si;
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
        let parted = parse_at("f=1, 0, -9.81 m/s^2, w=10 0 -5 deg/s, T=40 degC", 25.0);
        assert_eq!(parted.unwrap(), at);
        let twice = parse_at("T=30 degC, T=40 degC", 25.0).unwrap_err();
        assert!(twice.to_string().contains("given twice"));
    }
}
