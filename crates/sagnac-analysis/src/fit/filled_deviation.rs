//! What filling lost samples by lines does to the Allan deviation of the fitted terms, to be taken out of a measured curve.
//!
//! White and quantization noise have finite covariances r_l before and after, so that
//! m²·σ² = m·r_0 + 2 Σ_{l<m} (m − l)·r_l − Σ_{l<2m} min(l, 2m − l)·r_l is exact; slower terms hardly change.

use super::fill::Fill;
use super::types::{NoiseTerms, Segment};

/// Factors from the Allan deviation measured on filled segments to that of the same log whole, for each averaging factor.
///
/// `terms` are those of the fit in SI, `step_s` the interval; none where nothing was filled. `tests/lossy.rs` shows that
/// white noise comes out within its own scatter.
pub fn filled_deviation(
    segments: &[Segment<'_>],
    terms: &NoiseTerms,
    step_s: f64,
    factors: &[usize],
) -> Option<Vec<f64>> {
    let fill = Fill::of(segments)?;
    let white = terms.white.powi(2) / step_s;
    let quantization = (terms.quantization / step_s).powi(2);
    let before = [white + 2.0 * quantization, -quantization];
    let after = fill.white_covariances(white, quantization);
    let factor = |m: usize| {
        let whole = terms.allan_variance(m as f64 * step_s);
        let filled = whole + allan_variance(&after, m) - allan_variance(&before, m);
        if whole > 0.0 && filled > 0.0 {
            (whole / filled).sqrt()
        } else {
            1.0
        }
    };
    Some(factors.iter().map(|&m| factor(m)).collect())
}

/// The Allan variance at m samples of noise with these covariances, zero beyond them.
fn allan_variance(covariances: &[f64], m: usize) -> f64 {
    let mut sum = m as f64 * covariances[0];
    for (l, r) in covariances.iter().enumerate().skip(1) {
        sum += (2.0 * m.saturating_sub(l) as f64 - l.min((2 * m).saturating_sub(l)) as f64) * r;
    }
    sum / (m as f64).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_give_the_known_variances() {
        for m in [1, 2, 7] {
            let square = (m * m) as f64;
            assert!((allan_variance(&[1.0], m) - 1.0 / m as f64).abs() < 1e-12);
            assert!((allan_variance(&[2.0, -1.0], m) - 3.0 / square).abs() < 1e-12);
        }
    }
}
