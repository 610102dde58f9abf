//! Thêo1, raw: σ² = (1/0.75)(m·dt)⁻²(N+1−m)⁻¹ Σ_i Σ_δ (m/2−δ)⁻¹
//! [(x_i − x_{i+m/2−δ}) + (x_{i+m} − x_{i+m/2+δ})]², i = 0…N−m, δ = 0…m/2−1, m even, ≥ 10.
//!
//! Source `[SP1065]`; its τ is 0.75·m·dt. TheoBR frees it of its bias by the mean ratio to the
//! overlapping Allan variance.

use rayon::prelude::*;

use super::{Curve, Deviation, theo1_table, variance};

/// The least factor.
pub(crate) const LEAST_FACTOR: usize = 10;

/// Starts that one thread takes at a time.
const CHUNK: usize = 1 << 12;

/// Σ of weighted squares for each factor, even, LEAST_FACTOR ≤ m ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    let mut sums = Vec::with_capacity(factors.len());
    for octave in factors.chunk_by(|a, b| a.ilog2() == b.ilog2()) {
        let largest = octave[octave.len() - 1];
        let written: f64 = octave
            .iter()
            .map(|&m| (phase.len() - m) as f64 * m as f64 / 2.0)
            .sum();
        if largest >= LEAST_TABLE && written > theo1_table::cost(phase.len(), largest) {
            sums.extend(theo1_table::sums_of_squares(phase, octave));
        } else {
            sums.par_extend(octave.par_iter().map(|&m| direct(phase, m)));
        }
    }
    sums
}

/// Largest factor of an octave from which the table of lagged products may be cheaper.
const LEAST_TABLE: usize = 64;
/// Samples up to which `TheoBR`, a mean over N/30 ratios, is worked out: seconds at 10⁶.
const MOST_FOR_RATIO: usize = 1 << 21;

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
/// q = ⌊(N+1)/30 − 3⌋, where q ≥ 0 and N < 2²¹; N of the longest segment.
pub(crate) fn unbiased(curve: &Curve, phases: &[&[f64]]) -> Vec<Option<f64>> {
    let longest = phases.iter().map(|phase| phase.len()).max().unwrap_or(0);
    let ratio = (90..=MOST_FOR_RATIO).contains(&longest).then(|| {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_double_sum() {
        let mut state = 5_u64;
        let (mut x, mut y) = (0.0, 0.0);
        let mut white = vec![0.0];
        let mut walk = vec![0.0];
        for _ in 0..5000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let uniform = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            x += uniform;
            y += x;
            white.push(x);
            walk.push(y);
        }
        for phase in [&white, &walk] {
            for factors in [
                vec![64, 66, 100, 126],
                vec![258, 300, 510],
                vec![4200, 5000],
            ] {
                let got = theo1_table::sums_of_squares(phase, &factors);
                for (got, &m) in got.iter().zip(&factors) {
                    let want = direct(phase, m);
                    // 1e-9 is asked of every deviation.
                    assert!((got / want - 1.0).abs() < 1e-9, "{m}: {got} for {want}");
                }
            }
        }
    }
}
