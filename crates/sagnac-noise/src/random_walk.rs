//! Random walk of the rate (acceleration): S(f) = K²/(2πf)², σ²(τ) = K²τ/3, `[IEEE952]` annex C.

use crate::frame::{Frame, Generator, OneNormal, Scratch};
use crate::math::sin2_pi;
use crate::stream::{Purpose, StreamKey};

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

/// Random walk samples with the joint law of b_{k−1} + K√dt(n₁/2 + n₂/(2√3)), b_k = b_{k−1} + K√dt·n₁.
///
/// The differences of the samples have the variance ⅔K²dt (the first ⅓K²dt, from b₀ = 0) and the
/// covariance K²dt/6 between neighbours: one normal number a sample by the innovations recursion.
#[derive(Debug, Clone)]
pub struct RandomWalkGenerator(OneNormal);

impl RandomWalkGenerator {
    /// Random walk at sampling interval `dt_s`; `place` 0 is the walk of `noise`, 1 that of
    /// `bias.instability`.
    pub fn new(term: RandomWalk, dt_s: f64, key: StreamKey, place: u32) -> Self {
        let step = term.coefficient * term.coefficient * dt_s;
        let stream = key.stream(Purpose::RandomWalk, place);
        Self(OneNormal::new(
            stream,
            1.0,
            step / 3.0,
            2.0 * step / 3.0,
            step / 6.0,
        ))
    }
}

impl Generator for RandomWalkGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        self.0.add_frame(frame, scratch);
    }
}
