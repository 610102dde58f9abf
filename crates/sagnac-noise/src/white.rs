//! White noise (angle or velocity random walk): S(f) = N², σ²(τ) = N²/τ, `[IEEE952]` annex C.
//!
//! The mean of white noise over dt has the standard deviation N/√dt, never N, never N·√dt.

/// White noise of two-sided density N.
///
/// Unit of N: rad/√s (gyro, "angle random walk") or m/s/√s (accelerometer, "velocity random walk").
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct White {
    /// N, the square root of the two-sided PSD in rate (acceleration).
    pub density: f64,
}

impl White {
    /// Two-sided PSD of interval means at `frequency_hz`: N², at every frequency.
    pub fn psd(&self, _frequency_hz: f64, _dt_s: f64) -> f64 {
        self.density * self.density
    }

    /// Allan variance N²/τ, exact for interval means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        self.density * self.density / tau_s
    }

    /// Standard deviation N/√dt of one sample.
    pub fn sample_sigma(&self, dt_s: f64) -> f64 {
        self.density / libm::sqrt(dt_s)
    }
}
