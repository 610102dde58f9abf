//! G-sensitivity: Δω = G_g f, what specific force does to a gyroscope.
//!
//! Mostly of vibrating (Coriolis) gyroscopes, by mass asymmetry. f is the true specific
//! force at the IMU centre, without size effect. Lecture slide 9; [IEEE952], "acceleration-sensitive drift".

use crate::{Real, vector::Matrix, vector::Vector, vector::apply};

/// G_g, (rad/s)/(m/s²): row = gyro axis, column = axis of the specific force.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro_g_sensitivity.matrix[0][2] = 1e-4;
/// let truth = Truth { specific_force: [0.0, 0.0, -10.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).gyro, [-1e-3, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct GSensitivity<T> {
    /// The matrix.
    pub matrix: Matrix<T>,
}

impl<T: Real> GSensitivity<T> {
    /// G f.
    #[inline(always)]
    pub fn part(&self, f: Vector<T>) -> Vector<T> {
        apply(&self.matrix, f)
    }

    /// Whether any element is not zero.
    pub fn is_present(&self) -> bool {
        self.matrix.iter().flatten().any(|g| *g != T::ZERO)
    }
}
