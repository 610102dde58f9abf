//! What each model contributes: values with covariance at one reference temperature and with the run-to-run bias.

use sagnac_calibrate::merge::{Part, shift_matrix};
use sagnac_calibrate::stations::{Group, Term};
use sagnac_core::Sensor;
use sagnac_model::{Entry, Model, ParameterPath, ThermalTerm};

use super::Unequal;
use super::noise::{is_fact, is_noise};
use super::splines::{self, Splines};
use crate::Error;

/// Parts for the estimate, and what is to be said of them.
pub(super) struct Gathered {
    pub(super) parts: Vec<Part>,
    pub(super) has_fixture: bool,
    pub(super) splines: Splines,
    pub(super) warnings: Vec<String>,
    pub(super) notes: Vec<String>,
}

/// Whether a path is a deterministic number that a calibration may estimate.
fn is_estimate(path: ParameterPath) -> bool {
    !is_noise(path) && !is_fact(path)
}

pub(super) fn gather(models: &[Model]) -> Result<Gathered, Error> {
    let t0 = models.first().map_or(25.0, Model::reference_temperature_c);
    let mut out = Gathered {
        parts: Vec::new(),
        has_fixture: false,
        splines: Splines::of(models, t0)?,
        warnings: Vec::new(),
        notes: Vec::new(),
    };
    for model in models {
        let mut part = part(model)?;
        shift(&mut part, t0 - model.reference_temperature_c());
        out.splines.reduce(&mut part);
        let frames: Vec<&str> = model
            .calibrations()
            .iter()
            .filter_map(|c| c.frame.as_deref())
            .collect();
        part.own_frame = frames.contains(&"accelerometer") && !frames.contains(&"fixture");
        out.has_fixture |= frames.contains(&"fixture");
        out.parts.push(part);
    }
    stability(models, &mut out);
    Ok(out)
}

fn part(model: &Model) -> Result<Part, Error> {
    let mut names: Vec<String> = Vec::new();
    let mut values = Vec::new();
    let mut sigmas = Vec::new();
    let in_block = |name: &str| {
        model
            .calibrations()
            .iter()
            .find_map(|c| Some((c, c.names.iter().position(|n| n == name)?)))
    };
    for (path, entry) in model.parameters().filter(|(path, _)| is_estimate(*path)) {
        let name = path.to_string();
        let Some(value) = entry.value else { continue };
        let of_block = in_block(&name)
            .and_then(|(c, i)| c.covariance_of(i, i))
            .map(f64::sqrt);
        let Some(sigma) = of_block.or(entry.sigma) else {
            continue;
        };
        // A knot at T0 is exact by what it means.
        if sigma.is_nan() || sigma < 0.0 || (sigma == 0.0 && !splines::is_row(&name)) {
            return Err(
                Error::data(format!("the standard error of {name} is not above zero"))
                    .at(model.label().to_owned())
                    .advise("leave `sigma` out where nothing is known of the error"),
            );
        }
        names.push(name);
        values.push(value);
        sigmas.push(sigma);
    }
    let n = names.len();
    let mut covariance = vec![vec![0.0; n]; n];
    for i in 0..n {
        covariance[i][i] = sigmas[i] * sigmas[i];
        let Some((block, a)) = in_block(&names[i]) else {
            continue;
        };
        for j in 0..i {
            let same = in_block(&names[j]).filter(|(other, _)| std::ptr::eq(*other, block));
            if let Some(c) = same.and_then(|(_, b)| block.covariance_of(a, b)) {
                covariance[i][j] = c;
                covariance[j][i] = c;
            }
        }
    }
    Ok(Part {
        label: model.label().to_owned(),
        names,
        values,
        covariance,
        own_frame: false,
    })
}

/// Takes temperature polynomials from one reference temperature to another: x ← S x, C ← S C Sᵀ.
fn shift(part: &mut Part, by_k: f64) {
    if by_k == 0.0 {
        return;
    }
    let n = part.names.len();
    let mut whole: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for sensor in Sensor::ALL {
        for k in 0..3 {
            for bias in [true, false] {
                let place = |power: u8| {
                    let group = match (bias, power) {
                        (true, 0) => Group::Bias,
                        (true, i) => Group::BiasTemperature(i),
                        (false, 0) => Group::ScaleFactor,
                        (false, i) => Group::ScaleTemperature(i),
                    };
                    let name = Term {
                        group,
                        component: 0,
                    }
                    .name(sensor, k);
                    part.names.iter().position(|n| *n == name)
                };
                let powers: Vec<Option<usize>> = (0..=8).map(place).collect();
                let m = shift_matrix(8, by_k);
                for (j, row) in powers.iter().enumerate() {
                    for (i, column) in powers.iter().enumerate() {
                        if let (Some(row), Some(column)) = (row, column) {
                            whole[*row][*column] = m[j][i];
                        }
                    }
                }
            }
        }
    }
    splines::apply(part, &whole);
}

/// Adds the run-to-run variance to the biases: the models are of different switch-ons.
fn stability(models: &[Model], out: &mut Gathered) {
    let mut unknown: Vec<&str> = Vec::new();
    for sensor in Sensor::ALL {
        let shared = (0..3).any(|k| {
            let name = format!("{}.bias.{}", sensor.key(), ["x", "y", "z"][k]);
            out.parts.iter().filter(|p| p.names.contains(&name)).count() > 1
        });
        for k in 0..3 {
            let largest = models
                .iter()
                .filter_map(|m| m.under(sensor, "bias.stability", k)?.value)
                .fold(0.0, f64::max);
            if largest == 0.0 && shared && !unknown.contains(&sensor.key()) {
                unknown.push(sensor.key());
            }
            let name = format!("{}.bias.{}", sensor.key(), ["x", "y", "z"][k]);
            for part in &mut out.parts {
                if let Some(i) = part.names.iter().position(|n| *n == name) {
                    part.covariance[i][i] += largest * largest;
                }
            }
        }
    }
    if !unknown.is_empty() {
        out.warnings.push(format!(
            "no model has the run-to-run bias ({}): biases of different switch-ons count as one",
            unknown
                .iter()
                .map(|s| format!("{s}.bias.stability"))
                .collect::<Vec<_>>()
                .join(", ")
        ));
    }
}

/// Splines and temperature ranges: knots before values; a range is the one common to all that have the terms.
pub(super) fn thermal(
    models: &[Model],
    out: &mut Model,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    for sensor in Sensor::ALL {
        for (term, key) in [
            (ThermalTerm::Bias, "bias"),
            (ThermalTerm::ScaleFactor, "scale_factor"),
        ] {
            let stem = format!("{}.{key}.temperature", sensor.key());
            let has = |m: &Model| {
                m.parameters()
                    .any(|(path, _)| path.to_string().starts_with(&stem))
            };
            let mut range: Option<[f64; 2]> = None;
            for model in models.iter().filter(|m| has(m)) {
                let own = model
                    .own_temperature_range_c(sensor, term)
                    .or(model.temperature_range_c());
                range = match (range, own) {
                    (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].min(b[1])]),
                    (a, b) => a.or(b),
                };
            }
            if let Some(model) = models.iter().find(|m| m.knots_c(sensor, term).is_some())
                && let Some(knots) = model.knots_c(sensor, term)
            {
                let rows: Vec<[f64; 3]> = (1..=knots.len())
                    .map(|i| {
                        model
                            .triad(&format!("{stem}_spline.{i}"))
                            .unwrap_or_default()
                    })
                    .collect();
                out.set_spline(sensor, term, knots, &rows)?;
            }
            if let Some([low, high]) = range {
                if low < high {
                    out.set_own_temperature_range_c(sensor, term, [low, high]);
                } else {
                    notes.push(format!(
                        "the temperature ranges of {}.{key} have nothing in common: none is kept",
                        sensor.key()
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Deterministic numbers without a standard error: the first is kept where nothing was estimated.
pub(super) fn unweighed(
    models: &[Model],
    names: &[String],
    out: &mut Model,
) -> Result<Vec<Unequal>, Error> {
    let mut unequal = Vec::new();
    let mut owners: Vec<(ParameterPath, usize, Entry)> = Vec::new();
    for (number, model) in models.iter().enumerate() {
        for (path, entry) in model.parameters().filter(|(path, _)| is_estimate(*path)) {
            let name = path.to_string();
            if names.contains(&name) {
                continue;
            }
            match owners.iter().find(|(p, _, _)| *p == path) {
                Some((_, first, kept)) if kept.value != entry.value => unequal.push(Unequal {
                    name,
                    models: [*first, number],
                    values: [kept.value, entry.value],
                    sigmas: [kept.sigma, entry.sigma],
                }),
                Some(_) => {}
                None => {
                    owners.push((path, number, entry.clone()));
                    out.set_at(path, entry.clone())?;
                }
            }
        }
    }
    Ok(unequal)
}
