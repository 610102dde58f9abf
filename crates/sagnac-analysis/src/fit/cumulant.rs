//! How far quantization noise is from Gaussian, and what that changes in the standard deviation of Q.
//!
//! With κ₄ the fourth cumulant of q, an estimate of θ = Q²/dt² that is quadratic in the samples, θ̂ = Σ g_j c_j², has
//! Var θ̂ = (as for Gaussian noise) + κ₄ n (Σ g_j 4 sin²(πu_j)/n)², and Σ g_j 4 sin²(πu_j) = 1 where it is unbiased: κ₄/n
//! whatever stands beside it. An estimate of another term has Σ g_j 4 sin²(πu_j) = 0 and keeps its own. Rounding leaves
//! uniform q, κ₄ = −1.2 θ². Source: [Brillinger1981] for cumulants of quadratic forms.

use super::likelihood::Q;
use super::types::{Estimate, Segment};

/// κ₄/θ² of a uniform distribution, the flattest that rounding makes.
const UNIFORM: f64 = -1.2;
/// Σ of the fourth powers of the weights of q in y_k − y_{k−1} = (q_k − 2q_{k−1} + q_{k−2})/dt.
const WEIGHTS: f64 = 18.0;

/// κ₄/θ² of the end values q, from the differences of the samples, between the uniform −1.2 and the Gaussian 0.
///
/// `theta` is Q²/dt² in the samples' unit squared; spikes and changing scatter only move it towards 0.
pub(super) fn excess(segments: &[Segment<'_>], theta: f64) -> f64 {
    let (mut squares, mut fourths, mut count) = (0.0, 0.0, 0.0);
    for segment in segments {
        let mut add = |samples: &[f64]| {
            for pair in samples.windows(2) {
                let d2 = (pair[1] - pair[0]).powi(2) / theta;
                squares += d2;
                fourths += d2 * d2;
                count += 1.0;
            }
        };
        let mut from = 0;
        for run in segment.filled {
            add(&segment.samples[from..run.start]);
            from = run.end;
        }
        add(&segment.samples[from..]);
    }
    let excess = (fourths / count - 3.0 * (squares / count) * (squares / count)) / WEIGHTS;
    if excess.is_finite() {
        excess.clamp(UNIFORM, 0.0)
    } else {
        0.0
    }
}

/// Lets the variance of Q² in `covariance` be that of noise of this excess, from `samples`; the factor by which its
/// standard deviation changed.
pub(super) fn apply(
    covariance: &mut Option<(Vec<usize>, Vec<f64>)>,
    theta: f64,
    excess: f64,
    samples: usize,
) -> f64 {
    let Some((indices, matrix)) = covariance else {
        return 1.0;
    };
    let Some(place) = indices.iter().position(|&i| i == Q) else {
        return 1.0;
    };
    let variance = &mut matrix[place * indices.len() + place];
    let before = *variance;
    *variance += excess * theta * theta / samples.max(1) as f64;
    // Of uniform noise alone 0.4 is left.
    *variance = variance.max(0.35 * before);
    (*variance / before).sqrt()
}

/// The interval drawn towards its value, in the logarithm, by `factor`.
pub(super) fn narrowed(own: Estimate, factor: f64) -> Estimate {
    let Some(value) = own.value.filter(|v| *v > 0.0) else {
        return own;
    };
    let end = |end: Option<f64>| end.map(|e| value * (e / value).powf(factor));
    Estimate {
        lower: end(own.lower),
        upper: end(own.upper),
        ..own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(uniform: bool) -> f64 {
        let mut seed = 5_u64;
        let mut number = || {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let parts = if uniform { 1 } else { 40 };
        let q: Vec<f64> = (0..40_001)
            .map(|_| (0..parts).map(|_| number()).sum::<f64>())
            .collect();
        let y: Vec<f64> = q.windows(2).map(|p| p[1] - p[0]).collect();
        let segment = Segment {
            start_s: 0.0,
            samples: &y,
            filled: &[],
        };
        excess(&[segment], f64::from(parts) / 12.0)
    }

    #[test]
    fn uniform_and_gaussian_noise_are_told_apart() {
        assert!(draw(true) < -1.1);
        assert!(draw(false) > -0.15);
    }

    #[test]
    fn uniform_noise_alone_has_two_fifths_of_the_variance() {
        // Var θ̂ = 2θ²/n Gaussian, 0.8 θ²/n uniform.
        let mut covariance = Some((vec![Q], vec![2.0 * 9.0 / 1000.0]));
        let factor = apply(&mut covariance, 3.0, UNIFORM, 1000);
        assert!((factor * factor - 0.4).abs() < 1e-12);
        assert!((covariance.map_or(0.0, |c| c.1[0]) - 0.8 * 9.0 / 1000.0).abs() < 1e-15);
        let own = Estimate::detected(2.0, 1.0, 4.0, 0.1);
        let half = narrowed(own, 0.5);
        assert!((half.lower.unwrap_or(0.0) - 2f64.sqrt()).abs() < 1e-12);
        assert!((half.upper.unwrap_or(0.0) - 8f64.sqrt()).abs() < 1e-12);
    }
}
