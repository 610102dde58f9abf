//! Modified Allan deviation: σ² = ½τ⁻² mean over j = 0…N−3m+1 of
//! [(1/m) Σ_{i=j}^{j+m−1} (x_{i+2m} − 2x_{i+m} + x_i)]², and with it the time deviation.
//!
//! Source `[SP1065]`. The inner sum slides: its next value differs by a third difference of the
//! phase. Each piece starts with the sum written out, so rounding does not pile up.

use rayon::prelude::*;

/// Least starts of a piece.
const PIECE: usize = 1 << 15;

/// Σ of [Σ_{i=j}^{j+m−1} …]² (without the 1/m) for each factor, each with 3m − 1 ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    factors
        .par_iter()
        .map(|&m| {
            let starts = phase.len() + 1 - 3 * m;
            // Writing out the first sum costs 3m points: no piece is shorter than m.
            let piece = PIECE.max(m);
            (0..starts.div_ceil(piece))
                .into_par_iter()
                .map(|number| {
                    let first = number * piece;
                    sliding_squares(phase, first, piece.min(starts - first), m)
                })
                .collect::<Vec<f64>>()
                .into_iter()
                .sum()
        })
        .collect()
}

/// Σ of squares of the sliding sum over j = first…first + count − 1.
fn sliding_squares(phase: &[f64], first: usize, count: usize, m: usize) -> f64 {
    let mut sliding: f64 = (first..first + m)
        .map(|i| (phase[i] + phase[i + 2 * m]) - 2.0 * phase[i + m])
        .sum();
    let steps = count - 1;
    let at = |k: usize| &phase[first + k * m..][..steps];
    let mut total = sliding * sliding;
    for (((a, b), c), d) in at(0).iter().zip(at(1)).zip(at(2)).zip(at(3)) {
        sliding += (d - a) + 3.0 * (b - c);
        total += sliding * sliding;
    }
    total
}
