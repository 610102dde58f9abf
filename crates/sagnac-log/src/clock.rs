//! The sampling interval of a log from its stamps.
//!
//! dt is the median step, refined to (last − first)/(number of steps) over stretches without gaps. Stamps of arrival in
//! bursts have a median step that is no interval; then the mean step of most stretches of 64 is taken.

use crate::{Stamp, Stamps};

/// Steps between stamps, in seconds; NaN next to a stamp that is none.
pub(crate) fn steps(stamps: &Stamps) -> Vec<f64> {
    match stamps {
        Stamps::Nanoseconds(v) => v
            .windows(2)
            .map(|w| Stamp::Nanoseconds(w[1]).since(Stamp::Nanoseconds(w[0])))
            .collect(),
        Stamps::Seconds(v) => v.windows(2).map(|w| w[1] - w[0]).collect(),
    }
}

/// Median of the finite values for which `keep` holds; reorders them.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let mid = values.len() / 2;
    let (_, &mut m, _) = values.select_nth_unstable_by(mid, f64::total_cmp);
    Some(m)
}

/// The median of the positive steps, of a million of them at most.
pub(crate) fn usual(steps: &[f64]) -> Option<f64> {
    let every = steps.len().div_ceil(1 << 20).max(1);
    let mut positive: Vec<f64> = steps
        .iter()
        .copied()
        .filter(|s| *s > 0.0 && s.is_finite())
        .step_by(every)
        .collect();
    median(&mut positive)
}

/// The sampling interval; `None` where no step is positive.
pub(crate) fn interval(steps: &[f64]) -> Option<f64> {
    let mut positive: Vec<f64> = steps
        .iter()
        .copied()
        .filter(|s| *s > 0.0 && s.is_finite())
        .collect();
    let middle = median(&mut positive)?;
    if let Some(dt) = of_bursts(steps, middle) {
        return Some(dt);
    }
    let refine = |dt: f64| {
        // A step of k intervals with k beyond 1.5 is a gap; arrival times that jump and catch up are none.
        // Summed as differences from the median, so that an even clock gives its step to the last bit.
        let (mut excess_s, mut count) = (0.0, 0_u64);
        let mut k = 0;
        while k < steps.len() {
            let s = steps[k];
            if !s.is_finite() || s < 0.0 {
                k += 1;
                continue;
            }
            if s > 1.5 * dt {
                // What follows within a few samples tells a late stamp from a lost sample.
                let end = (k + 8).min(steps.len());
                let begin = k.saturating_sub(8);
                let window = &steps[begin..end];
                let excess: f64 = window
                    .iter()
                    .filter(|s| s.is_finite() && **s > 0.0)
                    .map(|s| s - dt)
                    .sum();
                if excess > 0.5 * dt {
                    k += 1;
                    continue;
                }
            }
            if s > 0.0 {
                excess_s += s - middle;
                count += 1;
            }
            k += 1;
        }
        (count > 0).then(|| middle + excess_s / count as f64)
    };
    let first = refine(middle)?;
    // Far from the median, the "stretches" are no stretches: the median stands.
    if (first / middle - 1.0).abs() < 0.25 {
        Some(first)
    } else {
        Some(middle)
    }
}

/// Steps of a stretch that evens bursts out.
const STRETCH: usize = 64;

/// The mean step where samples arrive in bursts: stretches agree with each other, but not with the median step.
fn of_bursts(steps: &[f64], middle: f64) -> Option<f64> {
    let means: Vec<f64> = steps
        .chunks_exact(STRETCH)
        .filter(|c| c.iter().all(|s| s.is_finite() && *s >= 0.0))
        .map(|c| c.iter().sum::<f64>() / STRETCH as f64)
        .collect();
    let usual = median(&mut means.clone())?;
    if means.len() < 4 || (usual / middle - 1.0).abs() < 0.25 {
        return None;
    }
    // Steps of one, two, three … intervals are those of a log with lost samples; pauses of bursts are long, or of any length.
    let is_lost = |s: &&f64| {
        let n = **s / middle;
        n < 0.5 || (n < 12.5 && (n - n.round()).abs() < 0.2)
    };
    let whole = steps.iter().filter(is_lost).count();
    if usual > middle && whole as f64 > 0.98 * steps.len() as f64 {
        return None;
    }
    let mut near = means;
    near.retain(|m| (m / usual - 1.0).abs() < 0.25);
    // A log with gaps everywhere has no such stretches.
    (2 * near.len() > steps.len() / STRETCH).then(|| near.iter().sum::<f64>() / near.len() as f64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn an_even_clock_with_a_gap_gives_its_interval() {
        let mut t: Vec<i64> = (0..1000).map(|k| k * 5_016_000).collect();
        for v in &mut t[500..] {
            *v += 3_000_000_000;
        }
        let dt = interval(&steps(&Stamps::Nanoseconds(t))).unwrap();
        assert_eq!(dt, 0.005016);
        assert_eq!(
            interval(&steps(&Stamps::Seconds(vec![1.0, 1.0, 1.0]))),
            None
        );
    }

    #[test]
    fn lost_samples_do_not_stretch_the_interval() {
        let mut state = 1_u64;
        for keep in [10, 12, 14] {
            let t: Vec<f64> = (0..30_000)
                .filter(|_| {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    state >> 60 < keep
                })
                .map(|k| f64::from(k) * 0.01)
                .collect();
            let dt = interval(&steps(&Stamps::Seconds(t))).unwrap();
            assert!((dt / 0.01 - 1.0).abs() < 1e-6, "{keep}: {dt}");
        }
    }

    #[test]
    fn stamps_of_arrival_in_bursts_give_the_mean_step() {
        // Nine samples 1 ms apart, then a pause: 100 Hz on average.
        let t: Vec<f64> = (0..3000)
            .map(|k| f64::from(k / 9) * 0.09 + f64::from(k % 9) * 1e-3)
            .collect();
        let dt = interval(&steps(&Stamps::Seconds(t))).unwrap();
        assert!((dt / 0.01 - 1.0).abs() < 0.01, "{dt}");
    }
}
