//! The deterministic part of a model as the core takes it.

use crate::error::Error;
use crate::model::{Model, ThermalTerm};
use sagnac_core::{
    OffDiagonal, Sensor, SensorModel, TemperatureDependence, TemperatureSpline, Triad,
};

impl Model {
    /// The deterministic terms in SI; what the file does not have is absent there.
    ///
    /// # Errors
    /// A spline whose knots and values do not go together, which no file that was read has.
    pub fn to_core(&self) -> Result<SensorModel<f64>, Error> {
        let mut core = SensorModel {
            gyro: self.core_triad(Sensor::Gyro)?,
            accel: self.core_triad(Sensor::Accel)?,
            reference_temperature_c: self.reference_temperature_c(),
            temperature_range_c: self.temperature_range_c(),
            ..SensorModel::default()
        };
        for (row, axis) in ["x", "y", "z"].iter().enumerate() {
            let offset = self.elements(Sensor::Accel, &format!("axis_offset.{axis}"), 3);
            core.accel_axis_offset.position[row].copy_from_slice(&offset);
        }
        let matrix = self.elements(Sensor::Gyro, "g_sensitivity", 9);
        for (row, values) in core
            .gyro_g_sensitivity
            .matrix
            .iter_mut()
            .zip(matrix.chunks(3))
        {
            row.copy_from_slice(values);
        }
        let matrix = self.elements(Sensor::Gyro, "g2_sensitivity", 18);
        for (row, values) in core
            .gyro_g2_sensitivity
            .matrix
            .iter_mut()
            .zip(matrix.chunks(6))
        {
            row.copy_from_slice(values);
        }
        Ok(core)
    }

    fn core_triad(&self, sensor: Sensor) -> Result<Triad<f64>, Error> {
        let axes = |key: &str| -> [f64; 3] {
            self.elements(sensor, key, 3).try_into().unwrap_or([0.0; 3])
        };
        let off = |key: &str| {
            OffDiagonal::from_array(self.elements(sensor, key, 6).try_into().unwrap_or([0.0; 6]))
        };
        let mut triad = Triad::default();
        triad.bias.fixed = axes("bias");
        triad.bias.temperature = self.core_temperature(sensor, ThermalTerm::Bias)?;
        triad.scale_factor.fixed = axes("scale_factor");
        triad.scale_factor.temperature = self.core_temperature(sensor, ThermalTerm::ScaleFactor)?;
        triad.nonlinearity.quadratic = axes("scale_factor.quadratic");
        triad.nonlinearity.cubic = axes("scale_factor.cubic");
        triad.asymmetry.difference = axes("scale_factor.asymmetry");
        triad.misalignment.elements = off("misalignment");
        triad.cross_axis.elements = off("cross_axis");
        for axis in 0..3 {
            let of = |key: &str| self.under(sensor, key, axis).and_then(|entry| entry.value);
            if let Some(range) = of("range") {
                triad.range.limit[axis] = range;
            }
            if let Some(lsb) = of("resolution") {
                triad.resolution.lsb[axis] = lsb;
            }
            if let Some(cutoff_hz) = of("bandwidth") {
                triad.bandwidth.cutoff_hz[axis] = cutoff_hz;
            }
        }
        triad.resolution.output = self.output(sensor);
        Ok(triad)
    }

    /// Polynomial or spline of a term, with its own range.
    fn core_temperature(
        &self,
        sensor: Sensor,
        term: ThermalTerm,
    ) -> Result<TemperatureDependence<f64>, Error> {
        let mut dependence = TemperatureDependence::default();
        for (row, coefficients) in dependence.polynomial.iter_mut().enumerate() {
            let key = format!("{}.temperature.{}", term.key(), row + 1);
            coefficients.copy_from_slice(&self.elements(sensor, &key, 3));
        }
        if let Some(knots_c) = self.knots_c(sensor, term) {
            let values: Vec<[f64; 3]> = (1..=knots_c.len())
                .map(|knot| {
                    let key = format!("{}.temperature_spline.{knot}", term.key());
                    self.elements(sensor, &key, 3)
                        .try_into()
                        .unwrap_or([0.0; 3])
                })
                .collect();
            let spline =
                TemperatureSpline::new(knots_c, &values).map_err(|error| Error::BadValue {
                    path: format!("{}.{}.temperature_spline", sensor.key(), term.key()),
                    problem: format!("cannot be used: {error}"),
                })?;
            dependence.spline = Some(spline);
        }
        dependence.range_c = self.own_temperature_range_c(sensor, term);
        Ok(dependence)
    }

    /// The simulated values of the elements of a key, zero where absent.
    fn elements(&self, sensor: Sensor, key: &str, count: usize) -> Vec<f64> {
        let values = format!("{}.{key}", sensor.key())
            .parse()
            .ok()
            .and_then(|path| self.values(path));
        values
            .filter(|values| values.len() == count)
            .unwrap_or_else(|| vec![0.0; count])
    }
}
