//! Goodness of fit from the spectral deviance D = Σ_b n_b(r_b − 1 − ln r_b), r_b = measured mean/fit.
//!
//! Under the model D has mean Σ n_b[ln(n_b/2) − ψ(n_b/2)], less the fitted parameters, and variance
//! Σ n_b²[ψ'(n_b/2) − 2/n_b]; it is compared as a scaled χ². Source: [McCullaghNelder1989] chapter 8 for gamma deviances.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::gamma::digamma;

/// ψ'(x), the trigamma function, for x > 0; relative error below 1e-10.
pub(crate) fn trigamma(x: f64) -> f64 {
    let mut sum = 0.0;
    let mut x = x;
    while x < 12.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let r2 = 1.0 / (x * x);
    sum + (1.0 + 0.5 / x + r2 * (1.0 / 6.0 - r2 * (1.0 / 30.0 - r2 / 42.0))) / x
}

/// The probability of a deviance as large or larger under the model.
pub(crate) fn p_value(power: &[f64], fit: &[f64], count: &[f64], parameters: usize) -> Option<f64> {
    let (mut deviance, mut mean, mut variance) = (0.0, 0.0, 0.0);
    for ((p, s), &n) in power.iter().zip(fit).zip(count) {
        let r = (p / s).max(1e-12);
        deviance += n * (r - 1.0 - r.ln());
        if n > 1e4 {
            // ln x − ψ(x) = 1/(2x) + 1/(12x²), and likewise the variance: 2 + …
            mean += 1.0 + 1.0 / (3.0 * n);
            variance += 2.0 + 4.0 / (3.0 * n);
        } else {
            mean += n * ((0.5 * n).ln() - digamma(0.5 * n));
            variance += n * n * (trigamma(0.5 * n) - 2.0 / n);
        }
    }
    mean -= parameters as f64;
    if mean.is_nan() || mean <= 0.0 || variance <= 0.0 || !deviance.is_finite() {
        return None;
    }
    let scale = variance / (2.0 * mean);
    let freedom = 2.0 * mean * mean / variance;
    let distribution = ChiSquared::new(freedom).ok()?;
    Some(distribution.sf(deviance / scale))
}

/// Two-sided tail of χ² with `freedom` degrees of freedom.
pub(crate) fn chi_squared_tail(value: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |d| d.sf(value.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trigamma_has_its_known_values() {
        let pi2 = std::f64::consts::PI * std::f64::consts::PI;
        assert!((trigamma(1.0) - pi2 / 6.0).abs() < 1e-10);
        assert!((trigamma(0.5) - pi2 / 2.0).abs() < 1e-9);
    }
}
