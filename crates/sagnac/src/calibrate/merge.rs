//! `calibrate merge`: several calibrations, and the noise of a characterization, as one model with its covariance.

mod gather;
mod noise;
mod splines;
mod text;

use sagnac_calibrate::merge::{self, Conflict, Merged};
use sagnac_calibrate::stations::{Group, Parameter, Term};
use sagnac_core::Sensor;
use sagnac_model::{Calibration, Entry, Model, ParameterPath};
use serde_json::{Value, json};

use super::has_spline;
use crate::Error;

/// What `calibrate merge` is asked.
#[derive(Clone, Debug)]
pub struct MergeRequest {
    /// The models, in order: the first gives name and reference temperature.
    pub models: Vec<Model>,
    /// Name of the result; that of the first model where not given.
    pub name: Option<String>,
    /// Refuses conflicts.
    pub strict: bool,
}

/// A number that two models have and that cannot be weighed: noise, or a value without a standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Unequal {
    /// Parameter path.
    pub name: String,
    /// Models by place; the first of them is kept.
    pub models: [usize; 2],
    /// Their values; none where only a limit is known.
    pub values: [Option<f64>; 2],
    /// Their standard errors.
    pub sigmas: [Option<f64>; 2],
}

/// One model out of several.
#[derive(Clone, Debug)]
pub struct MergeOutcome {
    /// The model.
    pub model: Model,
    /// What was estimated together.
    pub merged: Merged,
    /// Estimates beyond three standard deviations of one another.
    pub conflicts: Vec<Conflict>,
    /// Numbers that differ and cannot be weighed.
    pub unequal: Vec<Unequal>,
    /// What no calibration determined.
    pub held: Vec<String>,
    /// The models by name.
    pub labels: Vec<String>,
    /// What each of them held at zero.
    pub held_by: Vec<Vec<String>>,
    /// What must be said.
    pub warnings: Vec<String>,
    /// What is said besides.
    pub notes: Vec<String>,
}

/// Merges models.
///
/// # Errors
/// Fewer than two models, a calibration that is in two of them, covariances that are none; with `strict` conflicts.
pub fn merge(request: &MergeRequest) -> Result<MergeOutcome, Error> {
    if request.models.len() < 2 {
        return Err(Error::usage("one model cannot be merged with itself alone")
            .at("calibrate merge")
            .advise(
                "name two or more: sagnac calibrate merge faces.toml ratetable.toml -o imu.toml",
            ));
    }
    let sources = sources(&request.models)?;
    let labels: Vec<String> = request
        .models
        .iter()
        .map(|m| m.label().to_owned())
        .collect();
    let gathered = gather::gather(&request.models)?;
    let mut merged = merge::merge(&gathered.parts, true)
        .map_err(|error| Error::data(error.to_string()).advise(error.advice()))?;
    gathered.splines.restore(&mut merged);
    let mut notes = gathered.notes;
    let own = gathered.parts.iter().any(|p| p.own_frame);
    if own && gathered.has_fixture && !merged.turned {
        notes.push(
            "the calibrations tell nothing of the turn between fixture and accelerometer axes: none was made".to_owned(),
        );
    }
    let first = &request.models[0];
    let mut model = Model::new(request.name.as_deref().unwrap_or(first.name()));
    let mut unequal = noise::copy(&request.models, &mut model)?;
    model.set_reference_temperature_c(first.reference_temperature_c());
    gather::thermal(&request.models, &mut model, &mut notes)?;
    let mut held: Vec<String> = Vec::new();
    for calibration in request.models.iter().flat_map(Model::calibrations) {
        for name in &calibration.held {
            if !held.contains(name)
                && !merged.names.contains(name)
                && !has_spline(&merged.names, name)
            {
                held.push(name.clone());
            }
        }
    }
    gathered.splines.write(&merged, &mut model)?;
    for (i, name) in merged.names.iter().enumerate() {
        if splines::is_row(name) {
            continue;
        }
        let path: ParameterPath = name.parse()?;
        let sigma = merged.covariance[i][i].sqrt();
        let value = merged.values[i];
        // A standard deviation is not negative, however wide its interval.
        let spread = name.contains(".stability.");
        let lower = value - NORMAL_975 * sigma;
        let interval = [
            if spread { lower.max(0.0) } else { lower },
            value + NORMAL_975 * sigma,
        ];
        let mut entry = Entry::estimate(value, sigma, interval, path.dimension());
        if name.contains(".misalignment.") {
            entry = entry.with_note("misalignment and cross-axis response together");
        }
        model.set_at(path, entry)?;
    }
    unequal.extend(gather::unweighed(
        &request.models,
        &merged.names,
        &mut model,
    )?);
    model.push_calibration(Calibration {
        method: "merge".to_owned(),
        source: Some(sources.join("; ")),
        frame: Some(
            if own && !merged.turned {
                "accelerometer"
            } else {
                "fixture"
            }
            .to_owned(),
        ),
        names: merged.names.clone(),
        covariance: Some(
            merged
                .covariance
                .iter()
                .enumerate()
                .map(|(i, row)| row[..=i].to_vec())
                .collect(),
        ),
        dof: Some(
            request
                .models
                .iter()
                .flat_map(Model::calibrations)
                .filter_map(|c| c.dof)
                .sum(),
        ),
        held: held.clone(),
        note: None,
    });
    let out = MergeOutcome {
        conflicts: merged.conflicts.clone(),
        model,
        merged,
        unequal,
        held,
        labels,
        held_by: request
            .models
            .iter()
            .map(|m| {
                m.calibrations()
                    .iter()
                    .flat_map(|c| c.held.iter().cloned())
                    .collect()
            })
            .collect(),
        warnings: gathered.warnings,
        notes,
    };
    if request.strict && !(out.conflicts.is_empty() && out.unequal.is_empty()) {
        return Err(Error::data(format!(
            "the models contradict each other: {}",
            out.conflict_words().join("; ")
        ))
        .at(out.labels.join(", "))
        .advise("repeat the test in doubt, or leave --strict out to keep the weighted mean"));
    }
    Ok(out)
}

/// The 97.5 % point of the normal distribution.
const NORMAL_975: f64 = 1.959_963_984_540_054;

/// The data that went in; each once.
fn sources(models: &[Model]) -> Result<Vec<String>, Error> {
    let mut out: Vec<String> = Vec::new();
    for (place, model) in models.iter().enumerate() {
        if let Some(other) = models[..place]
            .iter()
            .find(|m| m.to_toml() == model.to_toml())
        {
            return Err(twice(model.label(), other.label(), "the same model"));
        }
        let mut own: Vec<String> = Vec::new();
        for calibration in model.calibrations() {
            for source in calibration.source.iter().flat_map(|s| s.split("; ")) {
                // Two sensors of one log are two blocks of one model.
                if !own.iter().any(|s| s == source) {
                    own.push(source.to_owned());
                }
            }
        }
        for source in own {
            // Without its hash a name tells nothing.
            if source.contains("sha256:") && out.contains(&source) {
                return Err(twice(model.label(), "another of the models", &source));
            }
            out.push(source);
        }
    }
    Ok(out)
}

fn twice(label: &str, other: &str, what: &str) -> Error {
    Error::data(format!(
        "{what} is in {label} and in {other}: it would count twice"
    ))
    .at(label.to_owned())
    .advise("name each calibration once; one that was merged already is in the result")
}

/// By how much of `target` a term of size one shows in a test that does not determine it, at usual inputs: gravity, 20 K,
/// 100 deg/s, and the Earth's rate for the rate terms of a gyro, which a test with more of it would determine.
fn usual_input(sensor: Sensor, term: Term, target: Term) -> f64 {
    const G: f64 = 9.80665;
    const WARMTH_K: f64 = 20.0;
    const RATE: f64 = 1.745;
    const EARTH: f64 = 7.292e-5;
    let gyro = sensor == Sensor::Gyro;
    // What the term adds to the output.
    let (u, accel) = if gyro { (EARTH, 0.0) } else { (G, RATE * RATE) };
    let added = match term.group {
        Group::Bias => 1.0,
        Group::ScaleFactor | Group::Misalignment => u,
        Group::BiasTemperature(i) => WARMTH_K.powi(i32::from(i)),
        Group::GSensitivity => G,
        Group::G2Sensitivity => G * G,
        Group::AxisOffset => accel,
        Group::ScaleTemperature(i) => u * WARMTH_K.powi(i32::from(i)),
        Group::Quadratic => u * u,
        Group::Asymmetry => u / 2.0,
        Group::Cubic => u * u * u,
    };
    match target.group {
        Group::Bias => added,
        Group::ScaleFactor | Group::Misalignment => match term.group {
            Group::ScaleFactor | Group::Misalignment => 1.0,
            Group::ScaleTemperature(i) => WARMTH_K.powi(i32::from(i)),
            Group::Asymmetry => 0.5,
            _ if gyro => added / RATE,
            _ => added / G,
        },
        Group::GSensitivity => added / G,
        Group::BiasTemperature(i) => added / WARMTH_K.powi(i32::from(i)),
        _ => 0.0,
    }
}

impl MergeOutcome {
    /// The estimates as parameters of stations, those that are such.
    fn parameters(&self) -> Vec<Parameter> {
        self.merged
            .names
            .iter()
            .enumerate()
            .filter_map(|(i, name)| {
                let (sensor, axis, term) = Term::named(name)?;
                let (value, sigma) = (self.merged.values[i], self.merged.covariance[i][i].sqrt());
                Some(Parameter {
                    name: name.clone(),
                    sensor,
                    axis,
                    term: Some(term),
                    value,
                    sigma,
                    lower: value - NORMAL_975 * sigma,
                    upper: value + NORMAL_975 * sigma,
                    assumes: Vec::new(),
                })
            })
            .collect()
    }

    fn conflict_words(&self) -> Vec<String> {
        let mut out: Vec<String> = self
            .conflicts
            .iter()
            .map(|c| {
                let mut words = format!(
                    "{} of {} and {} differ by {:.1} sigma",
                    c.name, self.labels[c.parts[0]], self.labels[c.parts[1]], c.z
                );
                let why: Vec<String> = c
                    .parts
                    .into_iter()
                    .filter_map(|part| {
                        let apart = (c.values[0] - c.values[1]).abs();
                        let held = self.held_beside(part, &c.name, apart)?;
                        Some(format!(
                            "{} holds {held} at zero, which may be why",
                            self.labels[part]
                        ))
                    })
                    .collect();
                if !why.is_empty() {
                    words.push_str(&format!(": {}", why.join("; ")));
                }
                words
            })
            .collect();
        out.extend(self.unequal.iter().map(|u| {
            format!(
                "{} differs between {} and {}; the first is kept",
                u.name, self.labels[u.models[0]], self.labels[u.models[1]]
            )
        }));
        out
    }

    /// The term of the same axis that a model held at zero and whose size, as another determined it, makes the
    /// difference of two values or most of it at the input that tests usually have; of several the one that makes most.
    fn held_beside(&self, part: usize, name: &str, apart: f64) -> Option<&str> {
        let (sensor, axis, target) = Term::named(name)?;
        let effect = |held: &str| -> Option<f64> {
            let (s, k, term) = Term::named(held)?;
            let value = self.model.get(held)?.value?;
            (s == sensor && k == axis).then(|| (value * usual_input(sensor, term, target)).abs())
        };
        self.held_by
            .get(part)?
            .iter()
            .filter_map(|held| Some((effect(held)?, held.as_str())))
            .filter(|(effect, _)| *effect > apart / 2.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, held)| held)
    }

    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let (names, c) = (&self.merged.names, &self.merged.covariance);
        let parameters: Vec<Value> = names
            .iter()
            .enumerate()
            .map(|(i, name)| {
                let (value, sigma) = (self.merged.values[i], c[i][i].sqrt());
                json!({
                    "name": name, "value": value, "sigma": sigma,
                    "lower": value - NORMAL_975 * sigma, "upper": value + NORMAL_975 * sigma,
                    "unit": super::json::unit(name),
                })
            })
            .collect();
        let mut confused: Vec<(usize, usize, f64)> = Vec::new();
        for i in 0..names.len() {
            for j in 0..i {
                let r = c[i][j] / (c[i][i] * c[j][j]).sqrt();
                if r.abs() > 0.95 {
                    confused.push((j, i, r));
                }
            }
        }
        confused.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        let mut conflicts: Vec<Value> = self
            .conflicts
            .iter()
            .map(|x| {
                json!({
                    "name": x.name, "values": x.values, "sigmas": x.sigmas, "z": x.z,
                    "models": x.parts.map(|p| &self.labels[p]),
                })
            })
            .collect();
        conflicts.extend(self.unequal.iter().map(|u| {
            json!({
                "name": u.name, "values": u.values, "sigmas": u.sigmas, "z": null,
                "models": u.models.map(|p| &self.labels[p]),
            })
        }));
        json!({
            "model": self.model.to_json(),
            "parameters": parameters,
            "residual_rms": { "accel": null, "gyro": null },
            "unobservable": self.held,
            "confused": confused.iter().map(|(i, j, r)| json!([names[*i], names[*j], r])).collect::<Vec<_>>(),
            "conflicts": conflicts,
            "covariance": { "names": names, "matrix": c },
            "advice": self.conflict_words(),
            "warnings": self.warnings,
            "notes": self.notes,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn model(name: &str, bias: &str, more: &str, names: &str, held: &str) -> Model {
        let text = format!(
            "name = '{name}'\n[gyro.bias]\nfixed = [{{ value = '{bias} rad/s', sigma = '1e-6 rad/s' }}, \
             {{ value = '0 rad/s', sigma = '1 rad/s' }}, {{ value = '0 rad/s', sigma = '1 rad/s' }}]\n{more}\
             [[calibration]]\nmethod = 'stations'\nsource = '{name}.csv'\nframe = 'fixture'\nnames = [{names}]\n\
             held = [{held}]\n"
        );
        Model::parse(&text, name).unwrap()
    }

    #[test]
    fn of_what_a_model_held_the_term_that_makes_the_difference_is_named() {
        // The faces determine G and the temperature's part, which is small; the table held both.
        let faces = model(
            "faces",
            "0.010",
            "temperature = [['1e-7 rad/s/K', '0 rad/s/K', '0 rad/s/K']]\n[gyro.g_sensitivity]\n\
             matrix = [['0 rad*s/m', '1e-4 rad*s/m', '0 rad*s/m'], ['0 rad*s/m', '0 rad*s/m', '0 rad*s/m'], \
             ['0 rad*s/m', '0 rad*s/m', '0 rad*s/m']]\n",
            "'gyro.bias.x', 'gyro.bias.temperature.1.x', 'gyro.g_sensitivity.xy'",
            "'gyro.scale_factor.x'",
        );
        let table = model(
            "table",
            "0.0105",
            "[gyro.scale_factor]\nfixed = ['-2000 ppm', '0 ppm', '0 ppm']\n",
            "'gyro.bias.x', 'gyro.scale_factor.x'",
            "'gyro.bias.temperature.1.x', 'gyro.g_sensitivity.xy'",
        );
        let request = MergeRequest {
            models: vec![faces, table],
            name: None,
            strict: false,
        };
        let outcome = merge(&request).unwrap();
        let words = outcome.conflict_words().join("; ");
        assert!(
            words.contains("table holds gyro.g_sensitivity.xy at zero"),
            "{words}"
        );
        assert!(
            !words.contains("temperature") && !words.contains("scale_factor"),
            "{words}"
        );
    }
}
