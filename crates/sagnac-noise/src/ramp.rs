//! Ramp: the straight line R·t, σ²(τ) = R²τ²/2, `[IEEE952]` annex C. It has no PSD.

use crate::frame::{FRAME, Frame, Generator, Scratch};

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

/// Ramp samples: R·(t_k − dt/2).
#[derive(Debug, Clone)]
pub struct RampGenerator {
    step: f64,
    count: f64,
}

impl RampGenerator {
    /// The ramp at sampling interval `dt_s`.
    pub fn new(term: Ramp, dt_s: f64) -> Self {
        Self {
            step: term.slope * dt_s,
            count: 0.0,
        }
    }
}

impl Generator for RampGenerator {
    fn add_frame(&mut self, frame: &mut Frame, _scratch: &mut Scratch) {
        for (k, sample) in frame.iter_mut().enumerate() {
            *sample += self.step * (self.count + k as f64 + 0.5);
        }
        self.count += FRAME as f64;
    }
}
