//! Second-order resonance: ẍ + 2ζωẋ + ω²x = white, S(f) = σ²·4ζω³/[(ω² − Ω²)² + (2ζωΩ)²], Ω = 2πf.
//!
//! Its covariance is Re{σ²(1 − iκ)e^−λt} with λ = ω(ζ − i√(1 − ζ²)), κ = ζ/√(1 − ζ²): a
//! Gauss–Markov process of complex correlation time.

use core::f64::consts::PI;

use crate::math::{Complex, sin2_pi};

/// Resonance of standard deviation σ (rad/s, or m/s²), natural frequency f_r and damping ζ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Resonance {
    /// σ, standard deviation of the process.
    pub sigma: f64,
    /// f_r, natural frequency, Hz; positive where σ is not 0.
    pub frequency_hz: f64,
    /// ζ, damping ratio, 0 < ζ < 1.
    pub damping: f64,
}

impl Resonance {
    /// λ and 1 − iκ.
    pub(crate) fn poles(&self) -> (Complex, Complex) {
        let omega = 2.0 * PI * self.frequency_hz;
        let root = libm::sqrt((1.0 - self.damping) * (1.0 + self.damping));
        (
            Complex {
                re: omega * self.damping,
                im: -omega * root,
            },
            Complex {
                re: 1.0,
                im: -self.damping / root,
            },
        )
    }

    /// Two-sided PSD of interval means at `frequency_hz`, averaging and aliasing included.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        let (lambda, weight) = self.poles();
        let h = lambda.scale(dt_s);
        let phi = h.scale(-1.0).exp();
        let decay = h.mean_decay();
        let one_minus_phi = decay * h;
        let s2 = sin2_pi(frequency_hz * dt_s);
        let s2 = Complex { re: s2, im: 0.0 };
        let c0 = h.mean_of_mean_decay().scale(2.0);
        let c1 = decay * decay;
        let shape = c0
            + c1.scale(2.0)
                * (one_minus_phi - s2.scale(2.0))
                * (one_minus_phi * one_minus_phi + phi.scale(4.0) * s2).recip();
        self.sigma * self.sigma * dt_s * (weight * shape).re
    }

    /// PSD σ²·4ζω³/[(ω² − (2πf)²)² + (2ζω·2πf)²] of the process before averaging.
    pub fn process_psd(&self, frequency_hz: f64) -> f64 {
        let omega = 2.0 * PI * self.frequency_hz;
        let x = frequency_hz / self.frequency_hz;
        let d = 1.0 - x * x;
        let e = 2.0 * self.damping * x;
        4.0 * self.sigma * self.sigma * self.damping / (omega * (d * d + e * e))
    }

    /// Allan variance [4V(τ) − V(2τ)]/(2τ²), exact for interval means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        let (lambda, weight) = self.poles();
        self.sigma * self.sigma * (weight * lambda.scale(tau_s).bridged_variance()).re
    }
}
