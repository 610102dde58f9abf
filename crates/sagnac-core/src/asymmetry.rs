//! Asymmetry: Δu_k = ½ a_k |u_k|, the scale factor of positive input less that of negative.
//!
//! a = SF⁺ − SF⁻ as a fraction of the nominal scale factor, so that SF⁺ = 1 + s + a/2.
//! IEEE Std 528 divides by the measured mean instead: a/(1 + s). Lecture slide 5.

use crate::{Real, vector::Vector};

/// The scale factor asymmetry of a triad, a fraction.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro.asymmetry.difference = [0.02, 0.0, 0.0];
/// let gyro_x = |w| {
///     let truth = Truth { angular_rate: [w, 0.0, 0.0], ..Truth::default() };
///     Measurement::new(&model).corrupt(&truth).gyro[0]
/// };
/// assert_eq!((gyro_x(1.0), gyro_x(-1.0)), (1.01, -0.99));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Asymmetry<T> {
    /// a = SF⁺ − SF⁻: x, y, z.
    pub difference: Vector<T>,
}

impl<T: Real> Asymmetry<T> {
    /// ½ a |u| of each axis.
    #[inline(always)]
    pub fn part(&self, u: Vector<T>) -> Vector<T> {
        let a = self.difference;
        [
            T::HALF * a[0] * u[0].abs(),
            T::HALF * a[1] * u[1].abs(),
            T::HALF * a[2] * u[2].abs(),
        ]
    }

    /// Whether any axis has one.
    pub fn is_present(&self) -> bool {
        self.difference.iter().any(|a| *a != T::ZERO)
    }
}
