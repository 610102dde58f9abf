//! Curves of fitted terms: two-sided density of the samples and Allan variance, exact for interval means.
//!
//! σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2 + Σ (2σ²T_c/τ)[1 − (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})]
//! + Σ A² (sin²(πfτ)/(πfτ))². Source: [IEEE952] annex C.

use super::spectra::{self, GaussMarkovShape};
use super::types::NoiseTerms;
use std::f64::consts::{LN_2, PI};

impl NoiseTerms {
    /// Two-sided power spectral density [unit²/Hz] of interval means at step `step_s`, at `frequency_hz` in (0, 1/(2dt)].
    ///
    /// Ramp and lines have no density and are left out.
    pub fn density(&self, frequency_hz: f64, step_s: f64) -> f64 {
        let u = frequency_hz * step_s;
        let four_s2 = spectra::quantization(u);
        let mut s = self.quantization.powi(2) / (step_s * step_s) * four_s2
            + self.white.powi(2) / step_s
            + self.flicker.powi(2) * spectra::flicker(u)
            + self.random_walk.powi(2) * step_s * spectra::random_walk(u);
        for &(sigma, time) in &self.gauss_markov {
            s += sigma * sigma * GaussMarkovShape::new(step_s / time).at(four_s2);
        }
        s * step_s
    }

    /// Allan variance \[unit²\] at `tau_s`.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        let t = tau_s;
        let mut v = 3.0 * (self.quantization / t).powi(2)
            + self.white.powi(2) / t
            + 2.0 * LN_2 / PI * self.flicker.powi(2)
            + self.random_walk.powi(2) * t / 3.0
            + 0.5 * (self.ramp * t).powi(2);
        for &(sigma, time) in &self.gauss_markov {
            v += gauss_markov_allan(sigma, t / time);
        }
        for &(amplitude, frequency) in &self.sinusoids {
            let x = PI * frequency * t;
            v += (amplitude * x.sin() * x.sin() / x).powi(2);
        }
        v
    }

    /// Variance of the mean of `duration_s` of samples at `step_s`.
    ///
    /// N²/T + 2Q²/T² + Gauss–Markov terms; for B and K the scatter about the bias at the start: (B²/π)(1 + ln n), K²T/3.
    pub fn mean_variance(&self, duration_s: f64, step_s: f64) -> f64 {
        let t = duration_s;
        let mut v = self.white.powi(2) / t
            + 2.0 * (self.quantization / t).powi(2)
            + self.flicker.powi(2) / PI * (1.0 + (t / step_s).max(1.0).ln())
            + self.random_walk.powi(2) * t / 3.0;
        for &(sigma, time) in &self.gauss_markov {
            let x = t / time;
            v += 2.0 * sigma * sigma * (x - 1.0 + (-x).exp()) / (x * x);
        }
        v
    }

    /// The lowest Allan deviation of the terms between `from_s` and `to_s`.
    pub fn floor(&self, from_s: f64, to_s: f64) -> f64 {
        let steps = 60;
        (0..=steps)
            .map(|i| {
                let tau = from_s * (to_s / from_s).powf(f64::from(i) / f64::from(steps));
                self.allan_variance(tau).sqrt()
            })
            .fold(f64::INFINITY, f64::min)
    }
}

fn gauss_markov_allan(sigma: f64, x: f64) -> f64 {
    if x < 1e-2 {
        // 3 − 4e⁻ˣ + e⁻²ˣ = 2x − (2/3)x³ + x⁴/2 − (7/30)x⁵…
        return sigma * sigma * x * (2.0 / 3.0 - 0.5 * x + 7.0 / 30.0 * x * x);
    }
    2.0 * sigma * sigma / x * (1.0 - 0.5 / x * (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn density_and_allan_variance_agree() {
        // σ²(m dt) = 4∫ S sin⁴(πfτ)/(m sin πf dt)² df
        let terms = NoiseTerms {
            quantization: 0.02,
            white: 0.5,
            flicker: 0.2,
            random_walk: 0.1,
            gauss_markov: vec![(0.3, 0.8)],
            ..NoiseTerms::default()
        };
        let step = 0.1;
        for m in [1_u32, 3, 8] {
            let tau = f64::from(m) * step;
            let n = 400_000;
            let width = 0.5 / step / f64::from(n);
            let sum: f64 = (0..n)
                .map(|i| {
                    let f = (f64::from(i) + 0.5) * width;
                    let ratio =
                        (PI * f * tau).sin().powi(2) / (f64::from(m) * (PI * f * step).sin());
                    4.0 * terms.density(f, step) * ratio * ratio * width
                })
                .sum();
            let want = terms.allan_variance(tau);
            assert!((sum / want - 1.0).abs() < 1e-5, "{m} {sum} {want}");
        }
    }

    #[test]
    fn gauss_markov_series_joins_its_closed_form() {
        let (a, b) = (
            gauss_markov_allan(1.0, 0.999_99e-2),
            gauss_markov_allan(1.0, 1.000_01e-2),
        );
        assert!((a / b - 1.0).abs() < 1e-4);
    }
}
