//! Overlapping Hadamard deviation: σ² = (1/6)τ⁻² mean over i = 0…N−3m of
//! (x_{i+3m} − 3x_{i+2m} + 3x_{i+m} − x_i)².
//!
//! Source `[SP1065]`, Stable32's OHDEV.

use rayon::prelude::*;

use super::kernel::third_differences;

/// Starts per tile.
const TILE: usize = 1024;
/// Starts that one thread takes at a time.
const CHUNK: usize = 1 << 16;

/// Σ of squares for each factor, ascending, each with 3m ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    let Some(&least) = factors.first() else {
        return Vec::new();
    };
    let starts = |m: usize| phase.len() - 3 * m;
    let partial: Vec<Vec<f64>> = (0..starts(least).div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut sums = vec![0.0; factors.len()];
            let mut first = chunk * CHUNK;
            let end = (first + CHUNK).min(starts(least));
            while first < end {
                tile(phase, first, TILE.min(end - first), factors, &mut sums);
                first += TILE;
            }
            sums
        })
        .collect();
    let mut sums = vec![0.0; factors.len()];
    for part in partial {
        for (sum, part) in sums.iter_mut().zip(part) {
            *sum += part;
        }
    }
    sums
}

/// Adds the starts first…first + count − 1 to the sums.
pub(crate) fn tile(phase: &[f64], first: usize, count: usize, factors: &[usize], sums: &mut [f64]) {
    for (&m, sum) in factors.iter().zip(sums) {
        let last = (first + count).min(phase.len().saturating_sub(3 * m));
        if first >= last {
            break;
        }
        *sum += third_differences(phase, first, last - first, m);
    }
}
