//! G²-sensitivity (anisoelasticity): Δω = H_g q(f), q = (fx², fy², fz², fx·fy, fx·fz, fy·fz).
//!
//! Products of forces along two axes bend an unequally stiff rotor or frame.
//! f is the true specific force at the IMU centre. Lecture slide 9; [IEEE952], "anisoelastic".

use crate::{Real, vector::Vector};

/// H_g, (rad/s)/(m/s²)²: row = gyro axis, columns xx, yy, zz, xy, xz, yz.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro_g2_sensitivity.matrix[0][5] = 1e-6; // gyro x, product fy·fz
/// let truth = Truth { specific_force: [0.0, 10.0, -10.0], ..Truth::default() };
/// assert!((Measurement::new(&model).corrupt(&truth).gyro[0] + 1e-4).abs() < 1e-18);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct G2Sensitivity<T> {
    /// The matrix.
    pub matrix: [[T; 6]; 3],
}

impl<T: Real> G2Sensitivity<T> {
    /// The six products q(f).
    #[inline(always)]
    pub fn products(f: Vector<T>) -> [T; 6] {
        [
            f[0] * f[0],
            f[1] * f[1],
            f[2] * f[2],
            f[0] * f[1],
            f[0] * f[2],
            f[1] * f[2],
        ]
    }

    /// H q(f).
    #[inline(always)]
    pub fn part(&self, f: Vector<T>) -> Vector<T> {
        let q = Self::products(f);
        let row = |h: &[T; 6]| {
            (h[0] * q[0] + h[1] * q[1]) + (h[2] * q[2] + h[3] * q[3]) + (h[4] * q[4] + h[5] * q[5])
        };
        [
            row(&self.matrix[0]),
            row(&self.matrix[1]),
            row(&self.matrix[2]),
        ]
    }

    /// The columns xx, yy, zz of H q(f).
    #[inline(always)]
    pub(crate) fn square_part(&self, f: Vector<T>) -> Vector<T> {
        let q = [f[0] * f[0], f[1] * f[1], f[2] * f[2]];
        let row = |h: &[T; 6]| h[0] * q[0] + h[1] * q[1] + h[2] * q[2];
        [
            row(&self.matrix[0]),
            row(&self.matrix[1]),
            row(&self.matrix[2]),
        ]
    }

    /// The columns xy, xz, yz of H q(f).
    #[inline(always)]
    pub(crate) fn product_part(&self, f: Vector<T>) -> Vector<T> {
        let q = [f[0] * f[1], f[0] * f[2], f[1] * f[2]];
        let row = |h: &[T; 6]| h[3] * q[0] + h[4] * q[1] + h[5] * q[2];
        [
            row(&self.matrix[0]),
            row(&self.matrix[1]),
            row(&self.matrix[2]),
        ]
    }

    pub(crate) fn has_squares(&self) -> bool {
        self.matrix
            .iter()
            .flat_map(|row| row.iter().take(3))
            .any(|h| *h != T::ZERO)
    }

    pub(crate) fn has_products(&self) -> bool {
        self.matrix
            .iter()
            .flat_map(|row| row.iter().skip(3))
            .any(|h| *h != T::ZERO)
    }

    /// Whether any element is not zero.
    pub fn is_present(&self) -> bool {
        self.matrix.iter().flatten().any(|h| *h != T::ZERO)
    }
}
