//! First-order Gauss–Markov process: S(f) = 2σ²T_c/(1 + (2πf T_c)²), `[IEEE952]` annex C.
//!
//! With h = dt/T_c, φ = e^−h the interval means have c₀ = 2(h − 1 + φ)/h², c₁ = ((1 − φ)/h)² and
//! the covariance σ²c₀ at lag 0, σ²c₁φ^(m−1) at lag m.

use core::f64::consts::PI;

use crate::frame::{Frame, Generator, OneNormal, Scratch};
use crate::math::{bridged_variance, mean_decay, mean_of_mean_decay, sin2_pi};

use crate::stream::{Purpose, StreamKey};

/// Gauss–Markov process of standard deviation σ (rad/s, or m/s²) and correlation time T_c.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaussMarkov {
    /// σ, standard deviation of the process itself (not of its interval means).
    pub sigma: f64,
    /// T_c, correlation time, s; must be positive where σ is not 0.
    pub correlation_time_s: f64,
}

impl GaussMarkov {
    /// Two-sided PSD of interval means at `frequency_hz`, averaging and aliasing included:
    /// σ² dt [c₀ + 2c₁(cos 2πu − φ)/((1 − φ)² + 4φ sin²πu)], u = f·dt.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        let h = dt_s / self.correlation_time_s;
        let phi = libm::exp(-h);
        let one_minus_phi = -libm::expm1(-h);
        let s2 = sin2_pi(frequency_hz * dt_s);
        let c1 = mean_decay(h) * mean_decay(h);
        let c0 = 2.0 * mean_of_mean_decay(h);
        self.sigma
            * self.sigma
            * dt_s
            * (c0
                + 2.0 * c1 * (one_minus_phi - 2.0 * s2)
                    / (one_minus_phi * one_minus_phi + 4.0 * phi * s2))
    }

    /// PSD 2σ²T_c/(1 + (2πf T_c)²) of the process before averaging.
    pub fn process_psd(&self, frequency_hz: f64) -> f64 {
        let x = 2.0 * PI * frequency_hz * self.correlation_time_s;
        2.0 * self.sigma * self.sigma * self.correlation_time_s / (1.0 + x * x)
    }

    /// Allan variance (2σ²T_c/τ)[1 − (T_c/2τ)(3 − 4e^(−τ/T_c) + e^(−2τ/T_c))], exact for interval
    /// means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        self.sigma * self.sigma * bridged_variance(tau_s / self.correlation_time_s)
    }
}

/// Gauss–Markov samples with the joint law of the interval means of a stationary process.
///
/// With end values x_k = φx_{k−1} + e₁ and means y_k = (1−φ)/h·x_{k−1} + e₂ the φ-differences
/// y_k − φy_{k−1} are correlated between neighbours only: one normal number a sample by the
/// innovations recursion, from y₁ of variance σ²c₀ on.
#[derive(Debug, Clone)]
pub struct GaussMarkovGenerator(OneNormal);

impl GaussMarkovGenerator {
    /// Gauss–Markov process at sampling interval `dt_s`; `place` 0 is that of `bias.instability`,
    /// from 1 on the list of `noise`.
    pub fn new(term: GaussMarkov, dt_s: f64, key: StreamKey, place: u32) -> Self {
        let h = dt_s / term.correlation_time_s;
        let phi = libm::exp(-h);
        let decay = mean_decay(h);
        let power = term.sigma * term.sigma;
        // Variances of e₁, e₂ and their covariance.
        let end = -libm::expm1(-2.0 * h);
        let mean = bridged_variance(h);
        let both = h * decay * decay;
        let variance = decay * decay * end + (1.0 + phi * phi) * mean - 2.0 * decay * phi * both;
        let covariance = decay * both - phi * mean;
        let first = 2.0 * mean_of_mean_decay(h);
        let stream = key.stream(Purpose::GaussMarkov, place);
        Self(OneNormal::new(
            stream,
            phi,
            power * first,
            power * variance,
            power * covariance,
        ))
    }
}

impl Generator for GaussMarkovGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        self.0.add_frame(frame, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AxisGenerator, AxisNoise, TermSet};

    #[test]
    fn a_process_far_faster_than_its_samples_leaves_next_to_nothing() {
        let key = StreamKey {
            seed: 1,
            run: 1,
            sensor: 0,
            axis: 0,
        };
        for correlation_time_s in [1e-12, 1e-160, 1e-300, f64::MIN_POSITIVE] {
            let noise = AxisNoise {
                instability_gauss_markov: GaussMarkov {
                    sigma: 1.0,
                    correlation_time_s,
                },
                ..AxisNoise::default()
            };
            let made = AxisGenerator::new(&noise, TermSet::ALL, 0.01, 10.0, key);
            let mut samples = [0.0; 2000];
            if let Ok(mut generator) = made {
                generator.fill(&mut samples, None);
            }
            // The variance of a mean is 2σ²T_c/dt.
            let power = samples.iter().map(|x| x * x).sum::<f64>() / 2000.0;
            let ratio = power / (2.0 * correlation_time_s / 0.01);
            let is_right =
                (ratio - 1.0).abs() < 0.2 || correlation_time_s < 1e-290 && power < 1e-290;
            assert!(is_right, "{correlation_time_s}: {power}");
        }
    }
}
