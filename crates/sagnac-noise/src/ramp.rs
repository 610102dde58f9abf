//! Ramp: the straight line R·t, σ²(τ) = R²τ²/2, `[IEEE952]` annex C. It has no PSD.

/// Rate (acceleration) ramp of slope R: rad/s², or m/s³, with its sign.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ramp {
    /// R, the slope.
    pub slope: f64,
}

impl Ramp {
    /// Allan variance R²τ²/2.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        0.5 * self.slope * self.slope * tau_s * tau_s
    }
}
