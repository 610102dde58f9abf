//! The model of a calibration: values with intervals, covariance and what was held at zero.

use sagnac_calibrate::stations::Group;
use sagnac_model::{Calibration, Entry, Model};

use super::StationsOutcome;
use crate::Error;

impl StationsOutcome {
    /// The estimates as a model.
    ///
    /// # Errors
    /// A value that a model cannot hold.
    pub fn to_model(&self) -> Result<Model, Error> {
        let found = &self.found;
        let mut model = Model::new(if self.request.name.is_empty() {
            "calibrated"
        } else {
            &self.request.name
        });
        model.set_reference_temperature_c(self.options.reference_temperature_c);
        let warm = found.parameters.iter().any(|p| {
            p.term.is_some_and(|t| {
                matches!(
                    t.group,
                    Group::BiasTemperature(_) | Group::ScaleTemperature(_)
                )
            })
        });
        let temperatures: Vec<f64> = self
            .stations
            .iter()
            .filter_map(|s| s.temperature_c)
            .collect();
        let low = temperatures.iter().copied().fold(f64::INFINITY, f64::min);
        let high = temperatures
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        if warm && low < high {
            model.set_temperature_range_c([low, high]);
        }
        for p in &found.parameters {
            let path: sagnac_model::ParameterPath = p.name.parse()?;
            let mut entry = Entry::estimate(p.value, p.sigma, [p.lower, p.upper], path.dimension());
            if p.term.is_some_and(|t| t.group == Group::Misalignment) {
                entry = entry.with_note("misalignment and cross-axis response together");
            }
            model.set_at(path, entry)?;
        }
        let covariance = found
            .covariance
            .iter()
            .enumerate()
            .map(|(i, row)| row[..=i].to_vec())
            .collect();
        model.push_calibration(Calibration {
            method: "stations".to_owned(),
            source: self.request.source.clone(),
            frame: Some("fixture".to_owned()),
            names: found.covariance_names.clone(),
            covariance: Some(covariance),
            dof: Some(found.fits.iter().map(|f| f.dof as f64).sum()),
            held: found.held.iter().map(|h| h.name.clone()).collect(),
            note: None,
        });
        Ok(model)
    }
}
