//! The model of a temperature sweep: curves about T0, where they hold, covariance.

use sagnac_calibrate::thermal::Kind;
use sagnac_core::Sensor;
use sagnac_model::{Calibration, Entry, Model, ParameterPath, ThermalTerm};

use super::ThermalOutcome;
use crate::Error;

impl ThermalOutcome {
    /// The curves as a model.
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
        let term = |kind: Kind| match kind {
            Kind::Bias => ThermalTerm::Bias,
            Kind::ScaleFactor => ThermalTerm::ScaleFactor,
        };
        for spline in &found.splines {
            model.set_spline(
                spline.sensor,
                term(spline.kind),
                &spline.knots_c,
                &spline.values,
            )?;
        }
        for p in &found.parameters {
            if !p.name.contains(".temperature_spline.") {
                let path: ParameterPath = p.name.parse()?;
                let entry = Entry::estimate(p.value, p.sigma, [p.lower, p.upper], path.dimension());
                model.set_at(path, entry)?;
            }
        }
        for sensor in Sensor::ALL {
            for kind in [Kind::Bias, Kind::ScaleFactor] {
                if found
                    .curves
                    .iter()
                    .any(|c| c.sensor == sensor && c.kind == kind)
                {
                    model.set_own_temperature_range_c(sensor, term(kind), found.range_c);
                }
            }
        }
        model.push_calibration(Calibration {
            method: "thermal".to_owned(),
            source: self.request.source.clone(),
            frame: None,
            names: found.parameters.iter().map(|p| p.name.clone()).collect(),
            covariance: Some(
                found
                    .covariance
                    .iter()
                    .enumerate()
                    .map(|(i, row)| row[..=i].to_vec())
                    .collect(),
            ),
            dof: found.dof.is_finite().then_some(found.dof),
            held: found.held.clone(),
            note: None,
        });
        Ok(model)
    }
}
