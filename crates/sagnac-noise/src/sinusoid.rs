//! Sinusoid: lines A²/4 at ±f₀, σ²(τ) = A² (sin²(πf₀τ)/(πf₀τ))², `[IEEE952]` annex C.
//!
//! Sample = A·sinc(f₀dt)·sin(2πf₀(t_k − dt/2) + φ), φ uniform, drawn for every run and axis.

use core::f64::consts::PI;

use crate::math::{sin2_pi, sinc};

/// Sinusoid of amplitude A (rad/s, or m/s²) and frequency f₀.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sinusoid {
    /// A, amplitude before averaging.
    pub amplitude: f64,
    /// f₀, Hz.
    pub frequency_hz: f64,
}

impl Sinusoid {
    /// Amplitude A·sinc(f₀dt) of the interval means.
    pub fn sample_amplitude(&self, dt_s: f64) -> f64 {
        self.amplitude * sinc(self.frequency_hz * dt_s)
    }

    /// Allan variance A² (sin²(πf₀τ)/(πf₀τ))², the mean over all phases.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        let x = PI * self.frequency_hz * tau_s;
        if self.amplitude == 0.0 || x == 0.0 {
            return 0.0;
        }
        let shape = sin2_pi(self.frequency_hz * tau_s) / x;
        self.amplitude * self.amplitude * shape * shape
    }
}
