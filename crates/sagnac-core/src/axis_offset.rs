//! Axis offset, the size effect: f'_k = f_k + [ω × (ω × r_k) + ω̇ × r_k]_k.
//!
//! Accelerometer k sits at r_k *from the IMU centre* and feels the centripetal and the
//! tangential acceleration there: a pure spin gives Δf_x = −(ω_y² + ω_z²)·r_x,x. The
//! lecture measures Δx the other way (Δx = −r). Lecture slide 10; [IEEE1293], "size effect".

use crate::{Real, vector::Matrix, vector::Vector, vector::dot};

/// The positions of the three accelerometers, m: row k is r_k in body axes.
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.accel_axis_offset.position[0] = [0.01, 0.0, 0.0];
/// let truth = Truth { angular_rate: [0.0, 0.0, 10.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).accel, [-1.0, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct AxisOffset<T> {
    /// r_x, r_y, r_z.
    pub position: Matrix<T>,
}

impl<T: Real> AxisOffset<T> {
    /// [ω × (ω × r_k)]_k = ω_k (ω·r_k) − |ω|² r_k,k.
    #[inline(always)]
    pub fn centripetal(&self, w: Vector<T>) -> Vector<T> {
        let r = &self.position;
        let square = dot(w, w);
        [
            w[0] * dot(w, r[0]) - square * r[0][0],
            w[1] * dot(w, r[1]) - square * r[1][1],
            w[2] * dot(w, r[2]) - square * r[2][2],
        ]
    }

    /// What it takes off where each r_k lies along its own axis: (|ω|² − ω_k²) r_k,k.
    #[inline(always)]
    pub(crate) fn centrifugal_own(&self, w: Vector<T>) -> Vector<T> {
        let r = &self.position;
        let (x, y, z) = (w[0] * w[0], w[1] * w[1], w[2] * w[2]);
        [r[0][0] * (y + z), r[1][1] * (x + z), r[2][2] * (x + y)]
    }

    pub(crate) fn is_own(&self) -> bool {
        crate::vector::is_diagonal(&self.position)
    }

    /// [ω̇ × r_k]_k.
    #[inline(always)]
    pub fn tangential(&self, wdot: Vector<T>) -> Vector<T> {
        let r = &self.position;
        [
            wdot[1] * r[0][2] - wdot[2] * r[0][1],
            wdot[2] * r[1][0] - wdot[0] * r[1][2],
            wdot[0] * r[2][1] - wdot[1] * r[2][0],
        ]
    }

    /// Whether any accelerometer is off the centre.
    pub fn is_present(&self) -> bool {
        self.position.iter().flatten().any(|r| *r != T::ZERO)
    }
}
