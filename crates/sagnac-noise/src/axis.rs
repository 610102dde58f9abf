//! All random terms of one axis: S(f) and σ²(τ) of their sum (independent terms add).

use alloc::vec::Vec;

use crate::{Flicker, GaussMarkov, Quantization, Ramp, RandomWalk, Resonance, Sinusoid, White};

/// The random terms of one axis in SI, two-sided; 0 (an empty list) where the axis lacks the term.
///
/// Unit u below is rad/s for a gyro and m/s² for an accelerometer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisNoise {
    /// Q, rad or m/s.
    pub quantization: Quantization,
    /// N, u·√s.
    pub white: White,
    /// B, u: the flicker process of `bias.instability`.
    pub flicker: Flicker,
    /// K, u/√s, of `noise.rate_random_walk` (`acceleration_random_walk`).
    pub random_walk: RandomWalk,
    /// K, u/√s, of `bias.instability` with `process = "random_walk"`: a second, independent walk.
    pub instability_random_walk: RandomWalk,
    /// R, u/s.
    pub ramp: Ramp,
    /// `noise.gauss_markov`; the place in the list chooses the stream, so keep entries of σ = 0.
    pub gauss_markov: Vec<GaussMarkov>,
    /// `bias.instability` with `process = "gauss_markov"`.
    pub instability_gauss_markov: GaussMarkov,
    /// `noise.resonances`; keep entries of σ = 0.
    pub resonance: Vec<Resonance>,
    /// `noise.sinusoids`; keep entries of amplitude 0.
    pub sinusoid: Vec<Sinusoid>,
}

impl AxisNoise {
    /// Two-sided PSD of the samples of all terms but ramp and sinusoids (which have lines, no
    /// density) at `frequency_hz`; averaging and aliasing included.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        self.quantization.psd(frequency_hz, dt_s)
            + self.white.psd(frequency_hz, dt_s)
            + self.flicker.psd(frequency_hz, dt_s)
            + self.random_walk.psd(frequency_hz, dt_s)
            + self.instability_random_walk.psd(frequency_hz, dt_s)
            + self.instability_gauss_markov.psd(frequency_hz, dt_s)
            + self
                .gauss_markov
                .iter()
                .map(|term| term.psd(frequency_hz, dt_s))
                .sum::<f64>()
            + self
                .resonance
                .iter()
                .map(|term| term.psd(frequency_hz, dt_s))
                .sum::<f64>()
    }

    /// Allan variance of the sum of all terms at τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        self.quantization.allan_variance(tau_s)
            + self.white.allan_variance(tau_s)
            + self.flicker.allan_variance(tau_s)
            + self.random_walk.allan_variance(tau_s)
            + self.instability_random_walk.allan_variance(tau_s)
            + self.ramp.allan_variance(tau_s)
            + self.instability_gauss_markov.allan_variance(tau_s)
            + self
                .gauss_markov
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
            + self
                .resonance
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
            + self
                .sinusoid
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
    }
}
