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

    /// G f where only the diagonal is not zero.
    #[inline(always)]
    pub(crate) fn diagonal_part(&self, f: Vector<T>) -> Vector<T> {
        let g = &self.matrix;
        [g[0][0] * f[0], g[1][1] * f[1], g[2][2] * f[2]]
    }

    pub(crate) fn is_diagonal(&self) -> bool {
        crate::vector::is_diagonal(&self.matrix)
    }

    /// Whether any element is not zero.
    pub fn is_present(&self) -> bool {
        self.matrix.iter().flatten().any(|g| *g != T::ZERO)
    }
}
