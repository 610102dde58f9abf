//! Values that the log repeats: a sensor that measures at a part of the log's rate, each value held until the next.
//!
//! Runs of equal values of one length k; those of a coarse grid have every length, and their steps few sizes.

use super::LogOutcome;
use sagnac_log::Log;
use sagnac_report::text::general;
use std::collections::HashMap;

/// Fewer runs tell nothing.
const FEWEST_RUNS: usize = 30;
/// More tell no more: a log that repeats its values does so from the start.
const MOST_RUNS: usize = 4096;
/// Sizes of steps that a grid which only looks held does not have.
const FEWEST_STEPS: usize = 16;

/// Samples that each value stands for; none where they do not all stand for as many.
fn held(values: &[f64]) -> Option<usize> {
    let mut runs: Vec<(f64, usize)> = Vec::new();
    for &y in values.iter().filter(|y| y.is_finite()) {
        let count = runs.len();
        match runs.last_mut() {
            Some((of, length)) if *of == y => *length += 1,
            _ if count == MOST_RUNS => break,
            _ => runs.push((y, 1)),
        }
    }
    // The ends are cut.
    let runs = runs.get(1..runs.len().saturating_sub(1))?;
    if runs.len() < FEWEST_RUNS {
        return None;
    }
    let mut count: HashMap<usize, usize> = HashMap::new();
    for (_, length) in runs {
        *count.entry(*length).or_default() += 1;
    }
    let (&length, &most) = count.iter().max_by_key(|(_, n)| **n)?;
    if length < 2 || 20 * most < 19 * runs.len() {
        return None;
    }
    let mut steps: Vec<f64> = runs.windows(2).map(|w| (w[1].0 - w[0].0).abs()).collect();
    steps.sort_by(f64::total_cmp);
    // Sums round: equal steps of a grid differ in their last bits.
    steps.dedup_by(|a, b| *a - *b <= 1e-6 * *a);
    (steps.len() >= FEWEST_STEPS).then_some(length)
}

/// Adds a note a length of the runs.
pub(super) fn add(outcome: &mut LogOutcome, log: &Log) {
    let mut found: Vec<(usize, Vec<String>)> = Vec::new();
    for axis in &outcome.axes {
        let Some(length) = log.channel(&axis.axis).and_then(held) else {
            continue;
        };
        match found.iter_mut().find(|(of, _)| *of == length) {
            Some((_, axes)) => axes.push(axis.axis.clone()),
            None => found.push((length, vec![axis.axis.clone()])),
        }
    }
    for (length, axes) in found {
        let of = if axes.len() == outcome.axes.len() {
            "every value".to_owned()
        } else {
            format!("every value of {}", axes.join(", "))
        };
        outcome.notes.push(format!(
            "{of} stands for {length} samples: the sensor measures at {} Hz and the log repeats it; \
             keep one row in {length}, and give that rate",
            general(outcome.rate_hz / length as f64, 6)
        ));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    /// Uniform noise of 1, rounded to `lsb`, each value `length` times.
    fn noise(count: usize, lsb: f64, length: usize) -> Vec<f64> {
        let mut state = 3_u64;
        let mut out = Vec::new();
        for _ in 0..count {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let y = (state >> 11) as f64 / (1_u64 << 53) as f64;
            out.extend(std::iter::repeat_n((y / lsb).round() * lsb, length));
        }
        out
    }

    #[test]
    fn held_values_are_told_from_a_coarse_grid() {
        assert_eq!(held(&noise(2000, 1e-4, 4)), Some(4));
        assert_eq!(held(&noise(2000, 0.01, 4)[1..7000]), Some(4));
        assert_eq!(held(&noise(2000, 1e-4, 1)), None);
        // Coarse steps: runs of every length; a slow ramp: runs of one, steps of one size.
        for lsb in [0.3, 0.5, 0.9, 1.5] {
            assert_eq!(held(&noise(20_000, lsb, 1)), None, "{lsb}");
        }
        let ramp: Vec<f64> = (0..20_000).map(|k| f64::from(k / 4) * 0.1).collect();
        assert_eq!(held(&ramp), None);
        assert_eq!(held(&noise(20, 1e-4, 4)), None);
    }
}
