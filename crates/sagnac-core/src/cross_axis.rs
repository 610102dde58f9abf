//! Cross-axis response: output caused by a stimulus orthogonal to the sense axis, x_jk u_k.
//!
//! Adds to misalignment in M; no input–output test tells the two apart, and only
//! misalignment varies from run to run. Lecture slide 7; IEEE Std 528, "cross-axis sensitivity".

use crate::OffDiagonal;

/// The cross-axis response of a triad, a fraction (0.1 % = 1e-3).
///
/// ```
/// use sagnac_core::{SensorModel, Truth, Measurement};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro.cross_axis.elements.xy = 1e-3;
/// let truth = Truth { angular_rate: [0.0, 2.0, 0.0], ..Truth::default() };
/// assert_eq!(Measurement::new(&model).corrupt(&truth).gyro, [0.002, 2.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct CrossAxis<T> {
    /// x_xy … x_zy.
    pub elements: OffDiagonal<T>,
}
