//! Flicker (bias instability): S(f) = B²/(2π|f|), σ²(τ) = (2 ln2/π) B², `[IEEE952]` annex C.

use core::f64::consts::{LN_2, PI};

use crate::math::{hurwitz_zeta_3, sin2_pi};

/// Flicker noise of coefficient B (rad/s, or m/s²).
///
/// B is the coefficient; the floor of the Allan curve is 0.664 B ([`Flicker::floor`]).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flicker {
    /// B, so that S(f) = B²/(2π|f|).
    pub coefficient: f64,
}

impl Flicker {
    /// Two-sided PSD of interval means of ideal flicker at `frequency_hz`, averaging and aliasing
    /// included: B² (s² dt/2π³) [ζ(3, u) + ζ(3, 1 − u)], u = f·dt, s = sin πu.
    ///
    /// Infinite at f = 0 (and at the multiples of 1/dt).
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        if self.coefficient == 0.0 {
            return 0.0;
        }
        let turns = libm::fabs(frequency_hz * dt_s);
        let u = turns - libm::floor(turns);
        if u == 0.0 {
            return f64::INFINITY;
        }
        self.coefficient * self.coefficient * sin2_pi(u) * dt_s / (2.0 * PI * PI * PI)
            * (hurwitz_zeta_3(u) + hurwitz_zeta_3(1.0 - u))
    }

    /// Allan variance (2 ln2/π) B² at every τ.
    pub fn allan_variance(&self, _tau_s: f64) -> f64 {
        2.0 * LN_2 / PI * self.coefficient * self.coefficient
    }

    /// The floor √(2 ln2/π)·B = 0.66428 B of the Allan deviation.
    pub fn floor(&self) -> f64 {
        libm::sqrt(2.0 * LN_2 / PI) * libm::fabs(self.coefficient)
    }
}
