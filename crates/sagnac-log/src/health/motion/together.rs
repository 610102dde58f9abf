//! Motion as a triad shows it: differences of averages judged together over its axes, √Σ(d/σ_A)² > 8.
//!
//! Two shapes are looked for, both free of what noise and temperature do. A stretch that leaves its neighbors on both
//! sides in one direction (moved and came back), at scales from one to sixty averages; and a jump so near an end of the
//! log that it is no step (less than 2 % of the log beyond it), steeper than what surrounds it, which a warm-up
//! (time constant 30 s or more) is not.

use std::ops::Range;

use super::{Averages, Motion, averages};
use crate::health::robust;
use crate::{Log, Quantity};

/// Scales of the stretches, in averages of max(1 s, 50 samples).
const SCALES: [usize; 6] = [1, 5, 10, 20, 40, 60];
/// Fewer averages than this give no σ_A.
const FEWEST: usize = 40;
/// What counts as off, in σ_A.
const OFF: f64 = 8.0;
/// The same over more than one average: the levels of real sensors wander more than their scatter tells.
const OFF_WIDE: f64 = 9.0;
/// A jump near an end stands out from the differences beside it by this factor; an exponential of 30 s gives 1.4.
const STEEPER: f64 = 1.8;
/// A step leaves at least this share of the log on both sides.
const STEP_SHARE: f64 = 0.02;
/// Averages beside a jump belong to it while they are off by so many σ_A.
const SETTLED: f64 = 3.3;

/// Axes of one triad at one scale.
struct Triad<'a> {
    axes: Vec<(&'a str, Averages, f64)>,
    size: usize,
    /// Rows between the starts of neighboring averages.
    hop: usize,
    blocks: usize,
}

impl<'a> Triad<'a> {
    /// Averages over `size` rows, a new one every `hop` rows.
    fn of(
        log: &'a Log,
        quantity: Quantity,
        size: usize,
        hop: usize,
        stuck: &[Vec<Range<usize>>],
    ) -> Option<Self> {
        if log.rows < FEWEST * size {
            return None;
        }
        let mut axes = Vec::new();
        for ((channel, values), stuck) in log.channels().zip(stuck) {
            if channel.quantity != quantity {
                continue;
            }
            let fine = averages(values, hop, stuck);
            let wide = size / hop;
            let mean: Vec<f64> = fine
                .mean
                .windows(wide)
                .map(|w| w.iter().sum::<f64>() / wide as f64)
                .collect();
            let mut steps: Vec<f64> = mean
                .windows(wide + 1)
                .map(|w| w[wide] - w[0])
                .filter(|d| d.is_finite())
                .collect();
            if steps.len() < FEWEST / 2 {
                continue;
            }
            let sigma = robust(&mut steps) / std::f64::consts::SQRT_2;
            if sigma > 0.0 {
                let a = Averages {
                    mean,
                    scatter: Vec::new(),
                };
                axes.push((channel.name.as_str(), a, sigma));
            }
        }
        let blocks = axes.first().map_or(0, |a| a.1.mean.len());
        (blocks > 0).then_some(Self {
            axes,
            size,
            hop,
            blocks,
        })
    }

    /// Differences of averages `j` from `i` in σ_A; 0 where there is none.
    fn differences(&self, i: usize, j: usize) -> impl Iterator<Item = f64> + '_ {
        self.axes.iter().map(move |(_, a, sigma)| {
            let d = match (a.mean.get(i), a.mean.get(j)) {
                (Some(a), Some(b)) => (b - a) / sigma,
                _ => 0.0,
            };
            if d.is_finite() { d } else { 0.0 }
        })
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        self.differences(i, j).map(|d| d * d).sum::<f64>().sqrt()
    }

    /// Rows of the averages `range`.
    fn rows(&self, range: &Range<usize>, log: &Log) -> Range<usize> {
        let last = range.end.saturating_sub(1);
        range.start * self.hop..(last * self.hop + self.size).min(log.rows)
    }

    fn motion(&self, range: &Range<usize>, text: String, log: &Log) -> Motion {
        Motion {
            rows: self.rows(range, log),
            channels: self.axes.iter().map(|a| a.0.to_owned()).collect(),
            text,
        }
    }

    /// The largest spread of levels over averages `range`, with its unit.
    fn spread(&self, range: Range<usize>) -> String {
        let mut largest = 0.0_f64;
        for (_, a, _) in &self.axes {
            let part = a.mean.get(range.clone()).unwrap_or(&[]);
            let (lo, hi) = part
                .iter()
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(*v), h.max(*v))
                });
            if hi > lo {
                largest = largest.max(hi - lo);
            }
        }
        if self.axes.iter().any(|a| a.0.starts_with("gyro")) {
            format!("levels move by up to {largest:.2e} rad/s")
        } else {
            format!("levels move by up to {:.0} mm/s^2", 1000.0 * largest)
        }
    }
}

/// Adds what a triad shows as a whole.
pub(super) fn intervals(
    log: &Log,
    size: usize,
    stuck: &[Vec<Range<usize>>],
    found: &mut Vec<Motion>,
) {
    for quantity in [Quantity::AngularRate, Quantity::SpecificForce] {
        let Some(fine) = Triad::of(log, quantity, size, size, stuck) else {
            continue;
        };
        let mut seen: Vec<(f64, Range<usize>)> = Vec::new();
        for scale in SCALES {
            // Half a stretch between starts: one that fits no grid is met as well.
            let (size, hop) = if scale == 1 {
                (size, size)
            } else {
                (2 * (scale * size / 2), scale * size / 2)
            };
            if let Some(triad) = Triad::of(log, quantity, size, hop, stuck) {
                came_back(&triad, log, &mut seen);
            }
        }
        // The scale that sees a motion best says where it is; others repeat it.
        seen.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<Range<usize>> = Vec::new();
        for (_, rows) in seen {
            let apart = |k: &Range<usize>| k.end + size <= rows.start || rows.end + size <= k.start;
            if kept.iter().all(apart) {
                kept.push(fine.sharpened(&rows));
            }
        }
        for rows in kept {
            let rows = rows.start..rows.end.min(log.rows);
            let mut m = fine.motion(&(0..1), "moved and came back".to_owned(), log);
            m.channels = fine.showing(&rows);
            m.rows = rows;
            found.push(m);
        }
        if let Some(triad) = Triad::of(log, quantity, 10 * size, 10 * size, stuck) {
            jumps_at_ends(&triad, log, found);
        }
    }
}

/// Averages that are off both neighbors in one direction, with how far in σ_A.
fn came_back(triad: &Triad<'_>, log: &Log, seen: &mut Vec<(f64, Range<usize>)>) {
    let wide = triad.size / triad.hop;
    // Beside a single average the level of five is taken: two that move together are met as well.
    let reach = if wide == 1 { 5 } else { 1 };
    let height = |k: usize| -> f64 {
        if k < wide * reach.min(2) || k + wide >= triad.blocks {
            return 0.0;
        }
        let mut sum = 0.0;
        for (_, a, sigma) in &triad.axes {
            let (before, after) = if wide == 1 {
                (
                    super::level(&a.mean, k.saturating_sub(reach)..k),
                    super::level(&a.mean, k + 1..k + 1 + reach),
                )
            } else {
                (a.mean.get(k - wide).copied(), a.mean.get(k + wide).copied())
            };
            let (Some(before), Some(after), Some(here)) = (before, after, a.mean.get(k)) else {
                continue;
            };
            // What is common to both sides; a step or a slope has nothing in common.
            let (l, r) = (here - before, here - after);
            if l * r > 0.0 {
                let d = l.abs().min(r.abs()) / sigma;
                sum += d * d;
            }
        }
        sum.sqrt()
    };
    for k in wide..triad.blocks {
        let h = height(k);
        if h > if wide == 1 { OFF } else { OFF_WIDE } {
            seen.push((h, triad.rows(&(k..k + 1), log)));
        }
    }
}

/// Jumps with less of the log beyond them than a step needs.
fn jumps_at_ends(triad: &Triad<'_>, log: &Log, found: &mut Vec<Motion>) {
    let n = triad.blocks;
    let near = (STEP_SHARE * n as f64).floor() as usize;
    let jump = |k: usize| triad.distance(k - 1, k);
    let stands_out = |k: usize| {
        let j = jump(k);
        j > OFF && (k < 2 || j > STEEPER * jump(k - 1)) && (k + 1 >= n || j > STEEPER * jump(k + 1))
    };
    if let Some(k) = (1..=near.min(n.saturating_sub(8)))
        .rev()
        .find(|&k| stands_out(k))
    {
        let mut end = k + 1;
        while end < k + 10 && end + 5 < n && triad.distance_to(end - 1, end + 1..end + 6) > SETTLED
        {
            end += 1;
        }
        let range = 0..(end - 1).max(k);
        let text = triad.spread(0..end);
        found.push(triad.motion(&range, text, log));
    }
    if let Some(k) = (n.saturating_sub(near).max(8)..n).find(|&k| stands_out(k)) {
        let text = triad.spread(k - 1..n);
        let mut m = triad.motion(&(k..n), text, log);
        m.rows.end = log.rows;
        found.push(m);
    }
}

impl Triad<'_> {
    /// Moves both ends of `rows` by up to half their length to where inside and outside differ most.
    fn sharpened(&self, rows: &Range<usize>) -> Range<usize> {
        let (a, b) = (rows.start / self.size, rows.end.div_ceil(self.size));
        let long = (b - a).max(1);
        let slack = long / 2 + 2;
        let from = a.saturating_sub(2 * slack + long);
        let to = (b + 2 * slack + long).min(self.blocks);
        // Sums of each axis from `from` on, in σ_A.
        let sums: Vec<Vec<f64>> = self
            .axes
            .iter()
            .map(|(_, x, sigma)| {
                let part = &x.mean[from.min(x.mean.len())..to.min(x.mean.len())];
                // A missing average counts as the level of those around it.
                let level = super::level(part, 0..part.len()).unwrap_or(0.0);
                let mut sum = 0.0;
                std::iter::once(0.0)
                    .chain(part.iter().map(|m| {
                        sum += if m.is_finite() {
                            (m - level) / sigma
                        } else {
                            0.0
                        };
                        sum
                    }))
                    .collect()
            })
            .collect();
        let contrast = |start: usize, end: usize| -> f64 {
            let (left, right) = (
                start.saturating_sub(slack + long / 2).max(from),
                (end + slack + long / 2).min(to),
            );
            let inside = (end - start) as f64;
            let outside = (start - left + right - end) as f64;
            if outside < 1.0 {
                return 0.0;
            }
            let weight = inside * outside / (inside + outside);
            sums.iter()
                .map(|s| {
                    let sum = |i: usize, j: usize| s[j - from] - s[i - from];
                    let d =
                        sum(start, end) / inside - (sum(left, start) + sum(end, right)) / outside;
                    d * d * weight
                })
                .sum()
        };
        let mut best = (f64::NEG_INFINITY, a, b.min(to));
        for start in a.saturating_sub(slack).max(from)..=(a + slack).min(to.saturating_sub(1)) {
            for end in (b.saturating_sub(slack)).max(start + 1)..=(b + slack).min(to) {
                let c = contrast(start, end);
                if c > best.0 {
                    best = (c, start, end);
                }
            }
        }
        best.1 * self.size..best.2 * self.size
    }

    /// The axes that are off their surroundings within `rows`, for the text; all where none is by itself.
    fn showing(&self, rows: &Range<usize>) -> Vec<String> {
        let (a, b) = (rows.start / self.size, rows.end / self.size);
        let long = b.saturating_sub(a).max(1);
        let names: Vec<String> = self
            .axes
            .iter()
            .filter(|(_, x, sigma)| {
                let mean = |r: Range<usize>| {
                    let part = x.mean.get(r.start..r.end.min(x.mean.len())).unwrap_or(&[]);
                    let finite = part.iter().filter(|m| m.is_finite());
                    finite.clone().sum::<f64>() / finite.count() as f64
                };
                let outside = 0.5 * (mean(a.saturating_sub(long)..a) + mean(b..b + long));
                (mean(a..b) - outside).abs() * (long as f64).sqrt() > 5.0 * sigma
            })
            .map(|a| a.0.to_owned())
            .collect();
        if names.is_empty() {
            self.axes.iter().map(|a| a.0.to_owned()).collect()
        } else {
            names
        }
    }

    /// Distance of average `k` from the level (median) of `others`, in σ_A.
    fn distance_to(&self, k: usize, others: Range<usize>) -> f64 {
        self.axes
            .iter()
            .filter_map(|(_, a, sigma)| {
                let level = super::level(&a.mean, others.clone())?;
                let d = (a.mean.get(k)? - level) / sigma;
                d.is_finite().then_some(d * d)
            })
            .sum::<f64>()
            .sqrt()
    }
}
