//! The parameters of the whole sensor: two triads, and what couples them.
//!
//! Lecture slides 3–11; every value may differ by axis, because a triad is three
//! single-axis sensors (slide 11). SI throughout.

use crate::{
    Asymmetry, AxisOffset, Bandwidth, Bias, CrossAxis, G2Sensitivity, GSensitivity, Misalignment,
    Nonlinearity, OffDiagonal, Range, Real, Resolution, ScaleFactorError, Sensor,
    TemperatureDependence, TemperatureSpline, vector::Vector,
};

/// The reference temperature where a model has none, °C.
pub const DEFAULT_REFERENCE_C: f64 = 25.0;

/// The deterministic terms of three gyroscopes or three accelerometers.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Triad<T: Real> {
    /// b: rad/s or m/s².
    pub bias: Bias<T>,
    /// s: the diagonal of M.
    pub scale_factor: ScaleFactorError<T>,
    /// k2, k3.
    pub nonlinearity: Nonlinearity<T>,
    /// a.
    pub asymmetry: Asymmetry<T>,
    /// m_xy … m_zy.
    pub misalignment: Misalignment<T>,
    /// x_xy … x_zy.
    pub cross_axis: CrossAxis<T>,
    /// R.
    pub range: Range<T>,
    /// LSB.
    pub resolution: Resolution<T>,
    /// f_c.
    pub bandwidth: Bandwidth<T>,
}

/// The deterministic part of an inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel<T: Real> {
    /// The gyroscopes, rad/s.
    pub gyro: Triad<T>,
    /// The accelerometers, m/s².
    pub accel: Triad<T>,
    /// G_g.
    pub gyro_g_sensitivity: GSensitivity<T>,
    /// H_g.
    pub gyro_g2_sensitivity: G2Sensitivity<T>,
    /// r_x, r_y, r_z.
    pub accel_axis_offset: AxisOffset<T>,
    /// T0, °C.
    pub reference_temperature_c: T,
    /// Where the temperature terms hold, °C.
    pub temperature_range_c: Option<[T; 2]>,
}

impl<T: Real> Default for SensorModel<T> {
    /// The perfect sensor.
    fn default() -> Self {
        Self {
            gyro: Triad::default(),
            accel: Triad::default(),
            gyro_g_sensitivity: GSensitivity::default(),
            gyro_g2_sensitivity: G2Sensitivity::default(),
            accel_axis_offset: AxisOffset::default(),
            reference_temperature_c: T::from_f64(DEFAULT_REFERENCE_C),
            temperature_range_c: None,
        }
    }
}

/// One draw of the run-to-run terms of a triad (bias, scale factor and misalignment stability).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Draw<T> {
    /// Added to the bias: x, y, z.
    pub bias: Vector<T>,
    /// Added to the scale factor error: x, y, z.
    pub scale_factor: Vector<T>,
    /// Added to the misalignment: xy, xz, yx, yz, zx, zy.
    pub misalignment: OffDiagonal<T>,
}

impl<T: Real> Triad<T> {
    /// The triad of one run: its draw added to the fixed parts.
    #[must_use]
    pub fn with_draw(&self, draw: &Draw<T>) -> Self {
        let mut run = *self;
        run.bias.fixed = crate::vector::add(self.bias.fixed, draw.bias);
        run.scale_factor.fixed = crate::vector::add(self.scale_factor.fixed, draw.scale_factor);
        run.misalignment.elements = self.misalignment.elements.plus(&draw.misalignment);
        run
    }

    fn convert<S: Real>(&self) -> Triad<S> {
        let v = |v: Vector<T>| v.map(|x| S::from_f64(x.to_f64()));
        let off = |m: &OffDiagonal<T>| {
            OffDiagonal::from_array(m.to_array().map(|x| S::from_f64(x.to_f64())))
        };
        let thermal = |t: &TemperatureDependence<T>| TemperatureDependence {
            polynomial: t.polynomial.map(v),
            spline: t.spline.as_ref().map(TemperatureSpline::convert),
            range_c: t.range_c.map(|r| r.map(|x| S::from_f64(x.to_f64()))),
        };
        Triad {
            bias: Bias {
                fixed: v(self.bias.fixed),
                temperature: thermal(&self.bias.temperature),
            },
            scale_factor: ScaleFactorError {
                fixed: v(self.scale_factor.fixed),
                temperature: thermal(&self.scale_factor.temperature),
            },
            nonlinearity: Nonlinearity {
                quadratic: v(self.nonlinearity.quadratic),
                cubic: v(self.nonlinearity.cubic),
            },
            asymmetry: Asymmetry {
                difference: v(self.asymmetry.difference),
            },
            misalignment: Misalignment {
                elements: off(&self.misalignment.elements),
            },
            cross_axis: CrossAxis {
                elements: off(&self.cross_axis.elements),
            },
            range: Range {
                limit: v(self.range.limit),
            },
            resolution: Resolution {
                lsb: v(self.resolution.lsb),
                output: self.resolution.output,
            },
            bandwidth: Bandwidth {
                cutoff_hz: v(self.bandwidth.cutoff_hz),
            },
        }
    }
}

impl<T: Real> SensorModel<T> {
    /// One triad.
    pub const fn triad(&self, sensor: Sensor) -> &Triad<T> {
        match sensor {
            Sensor::Gyro => &self.gyro,
            Sensor::Accel => &self.accel,
        }
    }

    /// The sensor of one run: the draws of its gyroscopes and accelerometers added.
    #[must_use]
    pub fn with_draws(&self, gyro: &Draw<T>, accel: &Draw<T>) -> Self {
        Self {
            gyro: self.gyro.with_draw(gyro),
            accel: self.accel.with_draw(accel),
            ..*self
        }
    }

    /// The model for a log without gyro columns: the size effect, which needs ω, is left out.
    #[must_use]
    pub fn without_gyro(&self) -> Self {
        Self {
            gyro: Triad::default(),
            gyro_g_sensitivity: GSensitivity::default(),
            gyro_g2_sensitivity: G2Sensitivity::default(),
            accel_axis_offset: AxisOffset::default(),
            ..*self
        }
    }

    /// The model for a log without accelerometer columns: g- and g²-sensitivity, which need
    /// f, are left out.
    #[must_use]
    pub fn without_accel(&self) -> Self {
        Self {
            accel: Triad::default(),
            gyro_g_sensitivity: GSensitivity::default(),
            gyro_g2_sensitivity: G2Sensitivity::default(),
            accel_axis_offset: AxisOffset::default(),
            ..*self
        }
    }

    /// Whether any bias or scale factor depends on temperature.
    pub fn depends_on_temperature(&self) -> bool {
        self.gyro.bias.temperature.is_present()
            || self.gyro.scale_factor.temperature.is_present()
            || self.accel.bias.temperature.is_present()
            || self.accel.scale_factor.temperature.is_present()
    }

    /// The same model in the other precision (or this one): every number rounded to nearest.
    pub fn convert<S: Real>(&self) -> SensorModel<S> {
        let v = |v: Vector<T>| v.map(|x| S::from_f64(x.to_f64()));
        SensorModel {
            gyro: self.gyro.convert(),
            accel: self.accel.convert(),
            gyro_g_sensitivity: GSensitivity {
                matrix: self.gyro_g_sensitivity.matrix.map(v),
            },
            gyro_g2_sensitivity: G2Sensitivity {
                matrix: self
                    .gyro_g2_sensitivity
                    .matrix
                    .map(|row| row.map(|x| S::from_f64(x.to_f64()))),
            },
            accel_axis_offset: AxisOffset {
                position: self.accel_axis_offset.position.map(v),
            },
            reference_temperature_c: S::from_f64(self.reference_temperature_c.to_f64()),
            temperature_range_c: self
                .temperature_range_c
                .map(|r| r.map(|x| S::from_f64(x.to_f64()))),
        }
    }
}
