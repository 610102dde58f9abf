//! Nonlinearity: Δu_k = k2_k u_k² + k3_k u_k³, u = ω, or f' with the size effect in it.
//!
//! Acts on the true component along the body axis, before scale factor and misalignment.
//! Lecture slide 5 ("true sensor response may have some non-linear characteristics");
//! [IEEE1293], K2 and K3.

use crate::{Real, vector::Vector};

/// Quadratic and cubic coefficients of a triad.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.accel.nonlinearity.quadratic = [1e-3, 0.0, 0.0];
/// let truth = Truth { specific_force: [10.0, 10.0, 0.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).accel, [10.1, 10.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Nonlinearity<T> {
    /// k2: s/rad, or s²/m.
    pub quadratic: Vector<T>,
    /// k3: s²/rad², or s⁴/m².
    pub cubic: Vector<T>,
}

impl<T: Real> Nonlinearity<T> {
    /// k2 u² of each axis.
    #[inline(always)]
    pub fn quadratic_part(&self, u: Vector<T>) -> Vector<T> {
        let k = self.quadratic;
        [
            k[0] * (u[0] * u[0]),
            k[1] * (u[1] * u[1]),
            k[2] * (u[2] * u[2]),
        ]
    }

    /// k3 u³ of each axis.
    #[inline(always)]
    pub fn cubic_part(&self, u: Vector<T>) -> Vector<T> {
        let k = self.cubic;
        [
            k[0] * (u[0] * u[0]) * u[0],
            k[1] * (u[1] * u[1]) * u[1],
            k[2] * (u[2] * u[2]) * u[2],
        ]
    }

    /// Whether any coefficient is not zero.
    pub fn is_present(&self) -> bool {
        self.quadratic
            .iter()
            .chain(&self.cubic)
            .any(|k| *k != T::ZERO)
    }
}
