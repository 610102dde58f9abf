//! Samples at their stamps on an even grid: a cubic through the two samples before a place and the two after it.
//!
//! Where the stamps are even the grid is the samples themselves. Lagrange's cubic, with error h⁴ f⁗·9/384 at the middle.

use std::ops::Range;

use sagnac_log::{Cadence, Log};

use crate::Error;

/// The longest step, in samples, that is bridged: three are lost. Beyond it the log is cut, and a channel is no number.
pub(super) const LONGEST_BRIDGE: f64 = 4.5;
/// Stamps off the even grid by less, in samples, lie on it.
const ON_GRID: f64 = 0.02;

/// Rows without a gap and where each of them lies, in steps from the first.
pub(super) struct Stretch {
    rows: Vec<usize>,
    places: Vec<f64>,
    /// Of the first row, from the log's first.
    pub(super) start_s: f64,
    pub(super) step_s: f64,
    /// Points of the grid.
    pub(super) points: usize,
}

/// What the stamps are like.
#[derive(Default)]
pub(super) struct Clock {
    /// The largest distance of a stamp from the even grid, s.
    pub(super) jitter_s: f64,
    pub(super) is_coarse: bool,
    /// Samples missing in time that were bridged.
    pub(super) lost: u64,
}

/// The stretches of a log whose sampling interval is `dt_s`.
pub(super) fn stretches(log: &Log, dt_s: f64) -> Result<(Vec<Stretch>, Clock), Error> {
    let mut clock = Clock::default();
    let Some(origin) = log.stamps.get(0) else {
        let places = (0..log.rows).map(|k| k as f64).collect();
        let all = Stretch {
            rows: (0..log.rows).collect(),
            places,
            start_s: 0.0,
            step_s: dt_s,
            points: log.rows,
        };
        return Ok((vec![all], clock));
    };
    clock.is_coarse = Cadence::of(&log.stamps).is_some_and(|c| c.is_coarse);
    let origin = (0..log.rows)
        .filter_map(|k| log.stamps.get(k))
        .find(|t| t.seconds().is_finite())
        .unwrap_or(origin);
    let times = log.stamps.since(origin);
    let longest_s = LONGEST_BRIDGE * dt_s;
    let longest_s = match Cadence::of(&log.stamps) {
        Some(c) if c.is_coarse => longest_s.max(c.longest_s),
        _ => longest_s,
    };
    let mut cut = Vec::new();
    let mut rows: Vec<usize> = Vec::new();
    for (row, &t) in times.iter().enumerate().filter(|(_, t)| t.is_finite()) {
        if let Some(&last) = rows.last() {
            let step = t - times[last];
            if step < 0.0 {
                return Err(Error::data(format!(
                    "time runs back at row {}, and what lies between samples is asked for",
                    row + 1
                ))
                .at("--resample")
                .advise("sort the rows by time, or add --rate if they are evenly spaced"));
            }
            if step > longest_s {
                cut.push(std::mem::take(&mut rows));
            } else if step == 0.0 && !clock.is_coarse {
                continue;
            }
        }
        rows.push(row);
    }
    cut.push(rows);
    let stretches = cut.into_iter().filter(|rows| !rows.is_empty());
    let stretches = stretches
        .map(|rows| stretch(rows, &times, dt_s, &mut clock))
        .collect();
    Ok((stretches, clock))
}

fn stretch(rows: Vec<usize>, times: &[f64], dt_s: f64, clock: &mut Clock) -> Stretch {
    let of = |k: usize| rows.get(k).and_then(|&row| times.get(row)).copied();
    let start_s = of(0).unwrap_or(0.0);
    let span_s = of(rows.len() - 1).unwrap_or(0.0) - start_s;
    let mut steps = (span_s / dt_s).round().max(1.0);
    if clock.is_coarse {
        steps = (rows.len() - 1).max(1) as f64;
    }
    let step_s = if span_s > 0.0 { span_s / steps } else { dt_s };
    let exact: Vec<f64> = rows
        .iter()
        .map(|&row| (times[row] - start_s) / step_s)
        .collect();
    let furthest = exact
        .iter()
        .fold(0.0, |far: f64, p| far.max((p - p.round()).abs()));
    let places = if clock.is_coarse {
        (0..rows.len()).map(|k| k as f64).collect()
    } else if furthest < ON_GRID {
        exact.iter().map(|p| p.round()).collect()
    } else {
        clock.jitter_s = clock.jitter_s.max(furthest * step_s);
        exact
    };
    if !clock.is_coarse {
        clock.lost += (steps as u64 + 1).saturating_sub(rows.len() as u64);
    }
    Stretch {
        points: if span_s > 0.0 { steps as usize + 1 } else { 1 },
        rows,
        places,
        start_s,
        step_s,
    }
}

/// A channel on the grid of a stretch.
pub(super) struct OnGrid {
    pub(super) values: Vec<f64>,
    /// Points with no sample near: what stands there is for the filter alone.
    pub(super) holes: Vec<Range<usize>>,
    /// Samples that were no number.
    pub(super) missing: u64,
}

impl Stretch {
    /// A channel's values at the points of the grid.
    pub(super) fn on_grid(&self, column: &[f64]) -> OnGrid {
        let (mut places, mut samples) = (Vec::new(), Vec::new());
        for (&row, &place) in self.rows.iter().zip(&self.places) {
            let value = column.get(row).copied().unwrap_or(f64::NAN);
            if value.is_finite() {
                places.push(place);
                samples.push(value);
            }
        }
        let missing = (self.rows.len() - places.len()) as u64;
        let mut out = OnGrid {
            values: Vec::with_capacity(self.points),
            holes: Vec::new(),
            missing,
        };
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else {
            out.values = vec![0.0; self.points];
            out.holes.push(0..self.points);
            return out;
        };
        let mut after = 0;
        for point in 0..self.points {
            let at = point as f64;
            while places.get(after).is_some_and(|p| *p < at) {
                after += 1;
            }
            let near = |place: f64| (place - at).abs() < 0.5;
            let is_hole = if at < first || at > last {
                !near(if at < first { first } else { last })
            } else {
                after > 0
                    && places[after] > at
                    && places[after] - places[after - 1] > LONGEST_BRIDGE
            };
            out.values.push(if at <= first {
                samples[0]
            } else if at >= last {
                samples[samples.len() - 1]
            } else {
                through(&places, &samples, after, at, is_hole)
            });
            if is_hole {
                match out.holes.last_mut() {
                    Some(hole) if hole.end == point => hole.end += 1,
                    _ => out.holes.push(point..point + 1),
                }
            }
        }
        out
    }
}

/// The value at `at`, which lies before sample `after` and not before the one before it.
fn through(places: &[f64], samples: &[f64], after: usize, at: f64, is_line: bool) -> f64 {
    if places[after] == at {
        return samples[after];
    }
    let (from, to) = if is_line {
        (after - 1, after)
    } else {
        let from = after.saturating_sub(2).min(places.len().saturating_sub(4));
        (from, (from + 3).min(places.len() - 1))
    };
    (from..=to)
        .map(|j| {
            let weight: f64 = (from..=to)
                .filter(|&i| i != j)
                .map(|i| (at - places[i]) / (places[j] - places[i]))
                .product();
            weight * samples[j]
        })
        .sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_cubic_is_met_at_uneven_places_and_long_runs_are_holes() {
        let cubic = |t: f64| 2.0 - t + 0.25 * t * t - 0.01 * t.powi(3);
        let places: Vec<f64> = (0..40)
            .map(|k| f64::from(k) + 0.3 * f64::from((k * 7 % 5) - 2) / 2.0)
            .map(|p: f64| p.max(0.0))
            .collect();
        let stretch = Stretch {
            rows: (0..40).collect(),
            points: 39,
            start_s: 0.0,
            step_s: 1.0,
            places: places.clone(),
        };
        let mut column: Vec<f64> = places.iter().map(|&p| cubic(p)).collect();
        column[10] = f64::NAN;
        column[20..26].fill(f64::NAN);
        let grid = stretch.on_grid(&column);
        assert_eq!(grid.missing, 7);
        assert_eq!(grid.holes.len(), 1);
        let hole = grid.holes[0].clone();
        assert!(hole.start >= 19 && hole.end <= 27, "{hole:?}");
        for (k, v) in grid.values.iter().enumerate().skip(1) {
            let wanted = cubic(k as f64);
            assert!(hole.contains(&k) || (v - wanted).abs() < 1e-9, "{k}");
        }
    }
}
