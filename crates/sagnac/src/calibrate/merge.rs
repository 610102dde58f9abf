//! `calibrate merge`: several calibrations, and the noise of a characterization, as one model with its covariance.

mod gather;
mod noise;
mod splines;
mod text;

use sagnac_calibrate::merge::{self, Conflict, Merged};
use sagnac_calibrate::stations::{Parameter, Term};
use sagnac_model::{Calibration, Entry, Model, ParameterPath};
use serde_json::{Value, json};

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
            if !held.contains(name) && !merged.names.contains(name) {
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
                for part in c.parts {
                    if let Some(held) = self.held_beside(part, &c.name) {
                        words.push_str(&format!(
                            ": {} holds {held} at zero, which may be why",
                            self.labels[part]
                        ));
                    }
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

    /// A term of the same axis that a model held at zero and another determined.
    fn held_beside(&self, part: usize, name: &str) -> Option<&str> {
        let (sensor, axis, _) = Term::named(name)?;
        self.held_by
            .get(part)?
            .iter()
            .map(String::as_str)
            .find(|held| {
                Term::named(held).is_some_and(|(s, k, _)| s == sensor && k == axis)
                    && self.merged.names.iter().any(|n| n == held)
            })
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
