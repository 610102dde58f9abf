//! Scale factor error: Δf_k = s_a,k f_k, Δω_k = s_g,k ω_k, with s(T) = s_0 + what temperature adds.
//!
//! s is the error (output over input is 1 + s), the diagonal of M. Lecture slide 5;
//! IEEE Std 528, "scale factor".

use crate::{Real, TemperatureDependence, vector::Vector};

/// The scale factor error of a triad, a fraction (300 ppm = 3e-4).
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro.scale_factor.fixed = [1e-3, 0.0, 0.0];
/// let truth = Truth { angular_rate: [2.0, 1.0, 0.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).gyro, [2.002, 1.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ScaleFactorError<T> {
    /// s_0 = s(T0): x, y, z.
    pub fixed: Vector<T>,
    /// What temperature adds, 1/K, 1/K² …
    pub temperature: TemperatureDependence<T>,
}

impl<T: Real> ScaleFactorError<T> {
    /// A scale factor error that is the same at every temperature.
    pub fn constant(fixed: Vector<T>) -> Self {
        Self {
            fixed,
            temperature: TemperatureDependence::default(),
        }
    }
}
