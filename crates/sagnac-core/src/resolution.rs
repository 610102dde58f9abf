//! Resolution: y = LSB·round(x/LSB), or of increments with the residue carried.
//!
//! `rate`: the output is rounded as it is; this adds white noise of variance LSB²/12 a
//! sample. `increment`: the sensor delivers angles (velocities): c = dt·x + e,
//! m = round(c/LSB), e ← c − LSB·m, y = LSB·m/dt; this is quantization noise Q = LSB/√12,
//! slope −1 in the Allan deviation. Halves go away from zero.
//! Lecture slides 2 and 8 ("may be due to LSB resolution in ADC's"); [IEEE952], "quantization noise".

use crate::{Real, vector::Vector};

/// What one count of the output stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Output {
    /// A rate or an acceleration: LSB in rad/s or m/s².
    #[default]
    Rate,
    /// An angle or a velocity gathered over the sampling interval: LSB in rad or m/s.
    Increment,
}

/// The least significant bit of each axis.
///
/// ```
/// use sagnac_core::{Output, Resolution};
///
/// let counts = Resolution { lsb: [0.1; 3], output: Output::Rate };
/// assert_eq!(counts.round([0.26, -0.04, 0.25], [0.0; 3], 0.01).0[0], 0.1 * 3.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Resolution<T> {
    /// LSB: x, y, z; 0 = not rounded.
    pub lsb: Vector<T>,
    /// What is rounded.
    pub output: Output,
}

impl<T: Real> Resolution<T> {
    /// The rounded outputs, and the residues to carry into the next sample (zero for rates).
    #[inline(always)]
    pub fn round(&self, x: Vector<T>, residue: Vector<T>, dt_s: T) -> (Vector<T>, Vector<T>) {
        let mut y = x;
        let mut carried = residue;
        for k in 0..3 {
            let lsb = self.lsb[k];
            if lsb > T::ZERO {
                match self.output {
                    Output::Rate => y[k] = lsb * (x[k] / lsb).rounded(),
                    Output::Increment => {
                        let gathered = dt_s * x[k] + residue[k];
                        let counts = (gathered / lsb).rounded();
                        carried[k] = gathered - lsb * counts;
                        y[k] = lsb * counts / dt_s;
                    }
                }
            }
        }
        (y, carried)
    }

    /// The largest output under a range: the range rounded to LSB, of increments range − LSB/dt.
    pub fn largest_output(&self, axis: usize, limit: T, dt_s: T) -> T {
        let lsb = self.lsb.get(axis).copied().unwrap_or(T::ZERO);
        if !(lsb > T::ZERO && limit.is_finite()) {
            return limit;
        }
        match self.output {
            Output::Rate => lsb * (limit / lsb).rounded(),
            Output::Increment => limit - lsb / dt_s,
        }
    }

    /// Whether any axis is rounded.
    pub fn is_present(&self) -> bool {
        self.lsb.iter().any(|lsb| *lsb > T::ZERO)
    }
}
