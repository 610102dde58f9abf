//! Thêo1, raw: σ² = (1/0.75)(m·dt)⁻²(N+1−m)⁻¹ Σ_i Σ_δ (m/2−δ)⁻¹
//! [(x_i − x_{i+m/2−δ}) + (x_{i+m} − x_{i+m/2+δ})]², i = 0…N−m, δ = 0…m/2−1, m even, ≥ 10.
//!
//! Source `[SP1065]`; its τ is 0.75·m·dt. TheoBR frees it of its bias by the mean ratio to the
//! overlapping Allan variance.

use rayon::prelude::*;

use super::{Curve, Deviation, variance};

/// The least factor.
pub(crate) const LEAST_FACTOR: usize = 10;

/// Starts that one thread takes at a time.
const CHUNK: usize = 1 << 12;

/// Σ of weighted squares for each factor, even, LEAST_FACTOR ≤ m ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    factors.par_iter().map(|&m| direct(phase, m)).collect()
}

/// The double sum as it is written, N·m/2 terms.
fn direct(phase: &[f64], m: usize) -> f64 {
    let starts = phase.len() - m;
    (0..starts.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let first = chunk * CHUNK;
            let count = CHUNK.min(starts - first);
            let at = |k: usize| &phase[first + k..][..count];
            let (near, far) = (at(0), at(m));
            (1..=m / 2)
                .map(|lag| {
                    let squares: f64 = near
                        .iter()
                        .zip(far)
                        .zip(at(lag).iter().zip(at(m - lag)))
                        .map(|((a, b), (c, d))| {
                            let difference = (a + b) - (c + d);
                            difference * difference
                        })
                        .sum();
                    squares / lag as f64
                })
                .sum()
        })
        .collect::<Vec<f64>>()
        .into_iter()
        .sum()
}

/// `TheoBR`: Thêo1² times mean_{i=0…q} oadev²(m = 9 + 3i)/theo1²(m = 12 + 4i),
/// q = ⌊(N+1)/30 − 3⌋, where q ≥ 0; N of the longest segment.
pub(crate) fn unbiased(curve: &Curve, phases: &[&[f64]]) -> Vec<Option<f64>> {
    let longest = phases.iter().map(|phase| phase.len()).max().unwrap_or(0);
    let ratio = (longest >= 90).then(|| {
        let q = longest / 30 - 3;
        let near: Vec<usize> = (0..=q).map(|i| 9 + 3 * i).collect();
        let far: Vec<usize> = (0..=q).map(|i| 12 + 4 * i).collect();
        let allan = super::pooled_sums(phases, Deviation::Oadev, &near);
        let theo = super::pooled_sums(phases, Deviation::Theo1, &far);
        let total: f64 = (0..=q)
            .map(|i| {
                variance(Deviation::Oadev, near[i], allan[i])
                    / variance(Deviation::Theo1, far[i], theo[i])
            })
            .sum();
        (total / (q as f64 + 1.0)).sqrt()
    });
    curve
        .deviation
        .iter()
        .map(|value| ratio.map(|ratio| value * ratio))
        .collect()
}
