//! Range: y = max(−R, min(R, y)), the clamp of the output, after the low-pass and before rounding.
//!
//! Lecture slide 2 (terminology); IEEE Std 528, "input range".

use crate::{Real, vector::Vector};

/// The largest output of each axis, rad/s or m/s²; infinite where there is none.
///
/// ```
/// use sagnac_core::Range;
///
/// let range = Range { limit: [8.0, 8.0, f64::INFINITY] };
/// assert_eq!(range.saturate([9.0, -9.0, 9.0]), [8.0, -8.0, 9.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T> {
    /// R: x, y, z.
    pub limit: Vector<T>,
}

impl<T: Real> Default for Range<T> {
    fn default() -> Self {
        Self {
            limit: [T::INFINITY; 3],
        }
    }
}

impl<T: Real> Range<T> {
    /// The clamp of each axis; NaN stays NaN.
    #[inline(always)]
    pub fn saturate(&self, y: Vector<T>) -> Vector<T> {
        let r = self.limit;
        [
            y[0].held(-r[0], r[0]),
            y[1].held(-r[1], r[1]),
            y[2].held(-r[2], r[2]),
        ]
    }

    /// The largest finite limit of the three axes.
    pub fn largest(&self) -> Option<T> {
        let mut largest = None;
        for limit in self.limit {
            if limit.is_finite() {
                largest = Some(match largest {
                    Some(so_far) if so_far > limit => so_far,
                    _ => limit,
                });
            }
        }
        largest
    }

    /// Whether any axis has a limit.
    pub fn is_present(&self) -> bool {
        self.largest().is_some()
    }
}
