//! Overlapping Allan deviation: σ² = ½τ⁻² mean over i = 0…N−2m of (x_{i+2m} − 2x_{i+m} + x_i)².
//!
//! Source `[SP1065]`. The sums are over the middle points j = i + m, tile by tile and several m
//! at once, so that the phase comes from the nearest cache that holds it.

use rayon::prelude::*;

use super::kernel::{GROUP, second_differences, second_differences_group};

/// Middle points of a tile: three of them fit the first-level cache.
const TILE: usize = 1024;
/// Middle points that one thread takes at a time.
const CHUNK: usize = 1 << 16;

/// Σ of squares for each factor, ascending, each with 2m ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    // Factors whose windows fit the caches go together in one pass; the largest go a few at a
    // time, so that the far windows of one are still cached when the next reads them.
    let near = factors.partition_point(|&m| m <= FAR);
    let mut sums = pass(phase, &factors[..near]);
    for group in factors[near..].chunks(GROUP) {
        sums.extend(pass(phase, group));
    }
    sums
}

/// Factors above this are passed over the phase on their own.
const FAR: usize = 1 << 16;

/// One pass over the phase for several factors.
fn pass(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    let Some(&least) = factors.first() else {
        return Vec::new();
    };
    let last = phase.len() - 1;
    let chunks = (last + 1).div_ceil(CHUNK);
    let partial: Vec<Vec<f64>> = (least / CHUNK..chunks)
        .into_par_iter()
        .map(|chunk| {
            let end = ((chunk + 1) * CHUNK).min(last + 1);
            let mut sums = vec![0.0; factors.len()];
            let mut start = chunk * CHUNK;
            while start < end {
                let count = TILE.min(end - start);
                tile(phase, start, count, factors, &mut sums);
                start += count;
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

/// Adds the middle points start…start + count − 1 to the sums.
pub(crate) fn tile(phase: &[f64], start: usize, count: usize, factors: &[usize], sums: &mut [f64]) {
    let last = phase.len() - 1;
    // A factor that reaches past neither end has the whole tile; ascending, so those come first.
    let whole = factors.partition_point(|&m| m <= start && start + count - 1 + m <= last);
    let groups = whole / GROUP * GROUP;
    let (grouped, sums_of_groups) = factors[..groups].as_chunks::<GROUP>();
    debug_assert!(sums_of_groups.is_empty());
    for (group, sums) in grouped.iter().zip(sums.as_chunks_mut::<GROUP>().0) {
        let added = second_differences_group(phase, start, count, *group);
        for (sum, added) in sums.iter_mut().zip(added) {
            *sum += added;
        }
    }
    for (&m, sum) in factors.iter().zip(sums).skip(groups) {
        let first = start.max(m);
        let end = (start + count).min((last + 1).saturating_sub(m));
        if first < end {
            *sum += second_differences(phase, first, end - first, m);
        }
    }
}
