//! Quantisation noise: S(f) = (4Q²/dt) sin²(πf dt), σ²(τ) = 3Q²/τ², `[IEEE952]` annex C.
//!
//! Sample = (q_k − q_{k−1})/dt with q_k independent, uniform on ±√3·Q.

use crate::math::sin2_pi;

/// Quantisation noise of coefficient Q (rad, or m/s for an accelerometer).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quantization {
    /// Q, the standard deviation of the angle's (velocity's) error.
    pub coefficient: f64,
}

impl Quantization {
    /// Two-sided PSD of interval means at `frequency_hz`: 4Q² sin²(πf dt)/dt.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        4.0 * self.coefficient * self.coefficient * sin2_pi(frequency_hz * dt_s) / dt_s
    }

    /// Allan variance 3Q²/τ², exact at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        3.0 * self.coefficient * self.coefficient / (tau_s * tau_s)
    }

    /// Standard deviation √2·Q/dt of one sample.
    pub fn sample_sigma(&self, dt_s: f64) -> f64 {
        core::f64::consts::SQRT_2 * self.coefficient / dt_s
    }
}
