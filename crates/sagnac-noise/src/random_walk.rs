//! Random walk of the rate (acceleration): S(f) = K²/(2πf)², σ²(τ) = K²τ/3, `[IEEE952]` annex C.

use crate::math::sin2_pi;

/// Rate (acceleration) random walk of coefficient K: rad/s/√s, or m/s²/√s. It starts at 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RandomWalk {
    /// K, the square root of the PSD of the rate's derivative.
    pub coefficient: f64,
}

impl RandomWalk {
    /// Two-sided PSD of interval means at `frequency_hz`: K² dt² [1/(4 sin²(πf dt)) − 1/6].
    ///
    /// Infinite at f = 0.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        if self.coefficient == 0.0 {
            return 0.0;
        }
        let s2 = sin2_pi(frequency_hz * dt_s);
        self.coefficient * self.coefficient * dt_s * dt_s * (0.25 / s2 - 1.0 / 6.0)
    }

    /// Allan variance K²τ/3, exact for interval means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        self.coefficient * self.coefficient * tau_s / 3.0
    }
}
