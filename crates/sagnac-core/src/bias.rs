//! Fixed bias: Δf = b_a, Δω = b_g, with b(T) = c_0 + what temperature adds.
//!
//! The output at zero input. It is deterministic; what changes from run to run (bias
//! stability) is a draw added to it, what drifts in the run (bias instability) is noise.
//! Lecture slide 4; IEEE Std 528, "bias".

use crate::{Real, TemperatureDependence, vector::Vector};

/// The fixed bias of a triad, rad/s or m/s².
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro.bias.fixed = [0.01, 0.0, -0.02];
/// let reading = Measurement::new(&model).corrupt(&Truth::default());
/// assert_eq!(reading.gyro, [0.01, 0.0, -0.02]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Bias<T> {
    /// c_0 = b(T0): x, y, z.
    pub fixed: Vector<T>,
    /// What temperature adds, per K, K² …
    pub temperature: TemperatureDependence<T>,
}

impl<T: Real> Bias<T> {
    /// A bias that is the same at every temperature.
    pub fn constant(fixed: Vector<T>) -> Self {
        Self {
            fixed,
            temperature: TemperatureDependence::default(),
        }
    }
}
