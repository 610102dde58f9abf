//! Total deviation, raw: σ² = ½τ⁻² mean over i = 1…N−1 of (x*_{i−m} − 2x*_i + x*_{i+m})².
//!
//! x* is the phase, reflected through its ends: x*_{−j} = 2x_0 − x_j, x*_{N+j} = 2x_N − x_{N−j}
//! `[SP1065]`. Its bias is known for white, flicker and random-walk noise of the rate.

use rayon::prelude::*;

use super::Curve;
use super::kernel::second_differences;

/// Middle points that one thread takes at a time.
const CHUNK: usize = 1 << 15;

/// Σ of squares for each factor, each with m + 1 ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    let last = phase.len() - 1;
    factors
        .par_iter()
        .map(|&m| {
            // Middle points whose both ends lie inside the phase, then those that do not.
            let (inner_start, inner_end) = if 2 * m <= last {
                (m, last - m + 1)
            } else {
                (last, last)
            };
            let inner = (inner_start.max(1), inner_end.min(last));
            let inside: f64 = if inner.0 < inner.1 {
                (0..(inner.1 - inner.0).div_ceil(CHUNK))
                    .into_par_iter()
                    .map(|chunk| {
                        let start = inner.0 + chunk * CHUNK;
                        second_differences(phase, start, CHUNK.min(inner.1 - start), m)
                    })
                    .collect::<Vec<f64>>()
                    .into_iter()
                    .sum()
            } else {
                0.0
            };
            let outside = |i: usize| {
                let before = if i >= m {
                    phase[i - m]
                } else {
                    2.0 * phase[0] - phase[m - i]
                };
                let after = if i + m <= last {
                    phase[i + m]
                } else {
                    2.0 * phase[last] - phase[2 * last - i - m]
                };
                let difference = (before + after) - 2.0 * phase[i];
                difference * difference
            };
            let (left_end, right_start) = if inner.0 < inner.1 {
                inner
            } else {
                (last, last)
            };
            let left: f64 = (1..left_end).map(outside).sum();
            let right: f64 = (right_start..last).map(outside).sum();
            left + inside + right
        })
        .collect()
}

/// Totdev freed of its bias: √(totdev²/(1 − a·m/N)), a = 0, 0.481, 0.750 for α ≥ 0, −1, −2.
pub(crate) fn unbiased(curve: &Curve, lengths: &[usize]) -> Vec<Option<f64>> {
    (0..curve.len())
        .map(|k| {
            let a = match curve.alpha[k] {
                -1 => 0.481,
                -2 => 0.750,
                _ => 0.0,
            };
            // Pooled segments: each carries its own bias, weighted as its terms are.
            let m = curve.factor[k];
            let terms = |n: usize| curve.kind.terms(n, m) as f64;
            let total: f64 = lengths.iter().map(|&n| terms(n)).sum();
            let kept: f64 = lengths
                .iter()
                .filter(|&&n| terms(n) > 0.0)
                .map(|&n| terms(n) / total * (1.0 - a * m as f64 / n as f64))
                .sum();
            Some(curve.deviation[k] / kept.sqrt())
        })
        .collect()
}
