//! Bandwidth: a second-order Butterworth low-pass (ζ = 1/√2), exactly −3 dB at f_c, unity at DC.
//!
//! κ = tan(π f_c dt), D = 1 + √2κ + κ²,
//! y_k = [κ²(u_k + 2u_{k−1} + u_{k−2}) + 2(1 − κ²) y_{k−1} − (1 − √2κ + κ²) y_{k−2}]/D.
//! It acts on the samples of the sum of the deterministic part and all random terms;
//! f_c ≥ 1/(2dt) leaves them as they are. Lecture slide 2; bilinear transform with prewarping.

use crate::Real;

/// The −3 dB frequencies of a triad, Hz; infinite where the sensor is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth<T> {
    /// f_c: x, y, z.
    pub cutoff_hz: [T; 3],
}

impl<T: Real> Default for Bandwidth<T> {
    fn default() -> Self {
        Self {
            cutoff_hz: [T::INFINITY; 3],
        }
    }
}

impl<T: Real> Bandwidth<T> {
    /// Whether any axis has one.
    pub fn is_present(&self) -> bool {
        self.cutoff_hz.iter().any(|f| f.is_finite())
    }
}

/// The low-pass of one axis with its state.
///
/// ```
/// use sagnac_core::LowPass;
///
/// let mut filter = LowPass::new(10.0, 0.01, 1.0); // settled at 1
/// assert!((filter.next_sample(1.0) - 1.0_f64).abs() < 1e-15);
/// // At half the sampling rate it is a straight wire.
/// assert_eq!(LowPass::new(50.0, 0.01, 0.0).next_sample(3.0), 3.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass<T> {
    input: T,
    feedback_1: T,
    feedback_2: T,
    u1: T,
    u2: T,
    y1: T,
    y2: T,
    is_flat: bool,
}

impl<T: Real> LowPass<T> {
    /// A filter for samples `dt_s` apart that has rested at `settled` (the first sample
    /// without noise): u_0 = u_−1 = y_0 = y_−1 = `settled`.
    pub fn new(cutoff_hz: T, dt_s: T, settled: T) -> Self {
        let (cutoff, dt) = (cutoff_hz.to_f64(), dt_s.to_f64());
        let is_flat = cutoff.is_nan() || dt.is_nan() || cutoff * dt >= 0.5;
        let (mut input, mut feedback_1, mut feedback_2) = (1.0, 0.0, 0.0);
        if !is_flat {
            let k = libm::tan(core::f64::consts::PI * cutoff * dt);
            let s = core::f64::consts::SQRT_2 * k;
            let d = 1.0 + s + k * k;
            input = k * k / d;
            feedback_1 = 2.0 * (1.0 - k * k) / d;
            feedback_2 = (1.0 - s + k * k) / d;
        }
        Self {
            input: T::from_f64(input),
            feedback_1: T::from_f64(feedback_1),
            feedback_2: T::from_f64(feedback_2),
            u1: settled,
            u2: settled,
            y1: settled,
            y2: settled,
            is_flat,
        }
    }

    /// The filtered sample.
    #[inline(always)]
    pub fn next_sample(&mut self, u: T) -> T {
        if self.is_flat {
            return u;
        }
        let y = self.input * ((u + self.u2) + (self.u1 + self.u1)) + self.feedback_1 * self.y1
            - self.feedback_2 * self.y2;
        (self.u2, self.u1, self.y2, self.y1) = (self.u1, u, self.y1, y);
        y
    }

    /// Whether samples pass unchanged.
    pub fn is_flat(&self) -> bool {
        self.is_flat
    }
}
