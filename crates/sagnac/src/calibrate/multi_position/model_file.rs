//! The model of a hand-turned log: values with intervals, covariance and what was held at zero.

use sagnac_calibrate::stations::Group;
use sagnac_model::{Calibration, Entry, Model, ParameterPath};

use super::MultiPositionOutcome;
use crate::Error;

impl MultiPositionOutcome {
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
        for p in &found.parameters {
            let path: ParameterPath = p.name.parse()?;
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
            method: "multi-position".to_owned(),
            source: self.request.source.clone(),
            frame: Some(
                if self.request.fixture.is_some() {
                    "fixture"
                } else {
                    "accelerometer"
                }
                .to_owned(),
            ),
            names: found.parameters.iter().map(|p| p.name.clone()).collect(),
            covariance: Some(covariance),
            dof: Some(found.fits.iter().map(|f| f.dof as f64).sum()),
            held: found.held.iter().map(|h| h.name.clone()).collect(),
            note: None,
        });
        Ok(model)
    }
}
