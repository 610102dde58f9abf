//! Stamps on a grid as coarse as the sampling interval, or coarser: whole seconds at 100 Hz, 1/64 s at 100 Hz.
//!
//! Rounding moves a stamp by less than one step of its grid, however long the log: the stamps less k·dt stay within
//! one step. Lost and repeated samples make them wander.

use crate::clock::usual;

/// Coarser than this share of the sampling interval, the stamps' grid decides what their steps are.
const COARSE: f64 = 0.4;
/// Steps other than the usual one in a stretch: so many of lost samples make the stamps wander visibly.
const PER_STRETCH: usize = 16;
/// What the stamps of a stretch may span about their line, in steps of the grid, on either kind of stretch.
const SPAN: f64 = 1.6;

/// Stamps on a coarse grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coarse {
    /// The step of the grid, s.
    pub(crate) grid_s: f64,
    /// The sampling interval, s.
    pub(crate) dt_s: f64,
}

impl Coarse {
    /// The grid and the interval, where the grid explains the steps.
    pub(crate) fn of(steps: &[f64]) -> Option<Self> {
        // An even clock is told from a coarse one at a glance.
        let usual = usual(steps)?;
        let off = |s: &&f64| (**s - usual).abs() > 0.3 * usual;
        if steps.iter().filter(off).take(2 * PER_STRETCH).count() < 2 * PER_STRETCH {
            return None;
        }
        if let Some(few) = Self::of_few(steps) {
            return Some(few);
        }
        let grid_s = grid(steps)?;
        // Steps in units of the grid; what is longer than all rounding explains are gaps.
        let is_gap = |s: f64, dt: f64| s > dt + 1.5 * grid_s;
        // From one change of the stamp to another: how long the first and last stamps had stood is not known.
        let first = steps.iter().position(|s| *s != 0.0)?;
        let last = steps.iter().rposition(|s| *s != 0.0)?;
        let between = &steps[first + 1..=last];
        let mean = |dt: f64| {
            let (mut sum, mut count) = (0.0, 0_usize);
            for &s in between {
                if s.is_finite() && s >= 0.0 && !is_gap(s, dt) {
                    sum += s;
                    count += 1;
                }
            }
            (sum > 0.0).then(|| sum / count as f64)
        };
        // Between two kinds of step, the mean lies near the shorter one or below.
        let dt_s = mean(mean(grid_s)?)?;
        if grid_s < COARSE * dt_s {
            return None;
        }
        let nearest = (dt_s / grid_s).round() * grid_s;
        let unusual = steps
            .iter()
            .filter(|s| (**s - nearest).abs() > 0.5 * grid_s)
            .count();
        if unusual < 2 * PER_STRETCH {
            return None;
        }
        let long = (PER_STRETCH * steps.len()).div_ceil(unusual).max(32);
        let mut spans: Vec<f64> = steps
            .chunks_exact(long)
            .filter(|c| c.iter().all(|s| *s >= 0.0 && !is_gap(*s, dt_s)))
            .map(|c| span_about_line(c, grid_s, dt_s))
            .collect();
        if spans.len() < 2 {
            return None;
        }
        let usual_span = crate::clock::median(&mut spans)?;
        (usual_span < SPAN).then_some(Self { grid_s, dt_s })
    }

    /// Of a short stretch, in which the stamp changes a few times only: as many rows to each, and one step between most.
    fn of_few(steps: &[f64]) -> Option<Self> {
        let changes: Vec<usize> = (0..steps.len()).filter(|k| steps[*k] != 0.0).collect();
        if !(4..2 * PER_STRETCH).contains(&changes.len()) || 4 * changes.len() > steps.len() {
            return None;
        }
        let mut sizes: Vec<f64> = changes.iter().map(|k| steps[*k]).collect();
        let grid_s = crate::clock::median(&mut sizes)?;
        let is_grid = |s: f64| (s - grid_s).abs() < 1e-3 * grid_s;
        let shared: Vec<f64> = changes
            .windows(2)
            .filter(|pair| is_grid(steps[pair[1]]))
            .map(|pair| (pair[1] - pair[0]) as f64)
            .collect();
        let usual = crate::clock::median(&mut shared.clone())?;
        let alike: Vec<f64> = shared
            .iter()
            .copied()
            .filter(|n| (n - usual).abs() <= 1.0_f64.max(0.1 * usual))
            .collect();
        if grid_s <= 0.0 || 4 * alike.len() < 3 * (changes.len() - 1) {
            return None;
        }
        let rows = alike.iter().sum::<f64>() / alike.len() as f64;
        Some(Self {
            grid_s,
            dt_s: grid_s / rows,
        })
    }
}

/// The grid that the steps lie on, s; `None` where they lie on none.
fn grid(steps: &[f64]) -> Option<f64> {
    let mut positive: Vec<f64> = steps
        .iter()
        .copied()
        .filter(|s| *s > 0.0 && s.is_finite())
        .collect();
    if positive.len() < 2 * PER_STRETCH {
        return None;
    }
    // Of 1 % of the steps none is shorter.
    let at = positive.len() / 100;
    let (_, &mut least, _) = positive.select_nth_unstable_by(at, f64::total_cmp);
    let is_on = |unit: f64| {
        let off = positive
            .iter()
            .filter(|s| {
                let n = **s / unit;
                (n - n.round()).abs() > 0.02
            })
            .count();
        off * 100 < positive.len()
    };
    // The shortest step may be one, two or three of the grid.
    [1.0, 2.0, 3.0]
        .map(|n| least / n)
        .into_iter()
        .find(|u| is_on(*u))
}

/// How far the stamps of a stretch span about the line of the whole log's interval, in steps of the grid: a rate that
/// changes within the log is no rounding.
fn span_about_line(steps: &[f64], grid_s: f64, dt_s: f64) -> f64 {
    let (mut at, mut low, mut high) = (0.0_f64, 0.0_f64, 0.0_f64);
    for step in steps {
        at += (step - dt_s) / grid_s;
        low = low.min(at);
        high = high.max(at);
    }
    high - low
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn steps(stamps: impl Iterator<Item = f64>) -> Vec<f64> {
        let t: Vec<f64> = stamps.collect();
        t.windows(2).map(|w| w[1] - w[0]).collect()
    }

    #[test]
    fn rounded_stamps_give_their_grid_and_the_rate() {
        for (rate, grid, n) in [
            (100.0, 1.0, 30_000),
            (100.0, 1.0 / 64.0, 30_000),
            (1500.0, 1e-3, 150_000),
            (100.0, 0.1, 30_000),
            (128.0, 0.01, 30_000),
            (90.0, 0.01, 30_000),
            (100.5, 0.01, 30_000),
        ] {
            let steps = steps((0..n).map(|k| (f64::from(k) / rate / grid + 0.37).floor() * grid));
            let found = Coarse::of(&steps).unwrap();
            assert!((found.grid_s / grid - 1.0).abs() < 1e-6, "{rate} {found:?}");
            let long = f64::from(n) / rate;
            assert!(
                (found.dt_s * rate - 1.0).abs() < grid / long,
                "{rate} {found:?}"
            );
        }
    }

    #[test]
    fn a_rate_that_changes_is_no_rounding() {
        let (slow, fast) = (vec![0.02; 9_000], vec![0.01; 21_000]);
        assert_eq!(Coarse::of(&[fast.clone(), slow.clone()].concat()), None);
        assert_eq!(
            Coarse::of(&[slow.clone(), fast[..9_000].to_vec()].concat()),
            None
        );
    }

    #[test]
    fn a_few_changes_of_the_stamp_tell_the_rate() {
        for (rate, n) in [(100.0, 1500), (99.3, 2000), (1000.0, 8192)] {
            let steps = steps((0..n).map(|k| (f64::from(k) / rate + 0.37).floor()));
            let found = Coarse::of(&steps).unwrap();
            assert_eq!(found.grid_s, 1.0);
            assert!((found.dt_s * rate - 1.0).abs() < 0.01, "{rate} {found:?}");
        }
        // Groups that arrive together, each at another time, are bursts.
        let bursts = steps((0..1500).map(|k| f64::from(k / 100) + 0.1 * f64::from(k / 100 % 3)));
        assert_eq!(Coarse::of(&bursts), None);
    }

    #[test]
    fn lost_and_repeated_samples_are_no_rounding() {
        let mut state = 1_u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for share in [0.01, 0.05, 0.2, 0.3, 0.45] {
            let lost: Vec<f64> = (0..30_000)
                .filter(|_| draw() > share)
                .map(|k| f64::from(k) * 0.01)
                .collect();
            assert_eq!(Coarse::of(&steps(lost.into_iter())), None, "{share} lost");
            let twice: Vec<f64> = (0..30_000)
                .map(|k| (k, draw() < share))
                .map(|(k, again)| f64::from(k - i32::from(again)) * 0.01)
                .collect();
            let found = Coarse::of(&steps(twice.into_iter()));
            assert!(
                found.is_none_or(|c| (c.dt_s - 0.01).abs() < 1e-5),
                "{share} again"
            );
        }
        assert_eq!(Coarse::of(&vec![0.01; 1000]), None);
    }
}
