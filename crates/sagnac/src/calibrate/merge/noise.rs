//! Random terms and facts of the data sheet: each from the one model that has it.

use sagnac_core::{Output, Sensor};
use sagnac_model::{Entry, Model, ParameterPath};

use super::Unequal;
use crate::Error;

/// Random terms but the run-to-run ones.
pub(super) fn is_noise(path: ParameterPath) -> bool {
    let keys = path.file_keys();
    keys.first() == Some(&"noise") || keys.get(1) == Some(&"instability")
}

/// Range, resolution, bandwidth.
pub(super) fn is_fact(path: ParameterPath) -> bool {
    matches!(
        path.file_keys().first(),
        Some(&"range" | &"resolution" | &"bandwidth")
    )
}

/// What belongs together: a list of processes, or the number alone.
fn family(path: ParameterPath) -> String {
    let name = path.to_string();
    for list in ["gauss_markov", "sinusoids", "resonances"] {
        if let Some(at) = name.find(list) {
            return name[..at + list.len()].to_owned();
        }
    }
    name
}

/// Copies noise and facts into `out`, the first model that has each; returns what others say otherwise.
pub(super) fn copy(models: &[Model], out: &mut Model) -> Result<Vec<Unequal>, Error> {
    let mut unequal: Vec<Unequal> = Vec::new();
    if let Some(maker) = models.iter().find_map(Model::manufacturer) {
        out.set_manufacturer(maker);
    }
    if let Some(rate) = models.iter().find_map(Model::sample_rate_hz) {
        out.set_sample_rate_hz(rate)?;
    }
    for sensor in Sensor::ALL {
        if let Some(technology) = models.iter().find_map(|m| m.technology(sensor)) {
            out.set_technology(sensor, technology);
        }
        if models.iter().any(|m| m.output(sensor) == Output::Increment) {
            out.set_output(sensor, Output::Increment);
        }
        let instability = format!("{}.bias.instability", sensor.key());
        if let Some(model) = models.iter().find(|m| {
            m.parameters()
                .any(|(p, _)| p.to_string().starts_with(&instability))
        }) {
            out.set_process(sensor, model.process(sensor));
        }
    }
    let mut owners: Vec<(String, usize)> = Vec::new();
    for (number, model) in models.iter().enumerate() {
        let wanted = model
            .parameters()
            .filter(|(path, _)| is_noise(*path) || is_fact(*path));
        for (path, entry) in wanted {
            let family = family(path);
            let known = owners.iter().find(|(name, _)| *name == family);
            let owner = known.map_or(number, |(_, owner)| *owner);
            if known.is_none() {
                owners.push((family.clone(), number));
            }
            if owner == number {
                out.set_at(path, entry.clone())?;
                continue;
            }
            let kept = models[owner].at(path);
            let value = |entry: Option<&Entry>| entry.and_then(|e| e.value);
            if kept.is_some_and(Entry::is_limit) && !entry.is_limit() && family == path.to_string()
            {
                // One log was too short to see what the other saw.
                out.set_at(path, entry.clone())?;
                continue;
            }
            let differs = value(kept) != entry.value && !entry.is_limit();
            if differs
                && !unequal
                    .iter()
                    .any(|u| u.name == family && u.models == [owner, number])
            {
                unequal.push(Unequal {
                    name: family,
                    models: [owner, number],
                    values: [value(kept), entry.value],
                    sigmas: [kept.and_then(|e| e.sigma), entry.sigma],
                });
            }
        }
    }
    Ok(unequal)
}
