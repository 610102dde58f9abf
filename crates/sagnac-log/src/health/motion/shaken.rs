//! Motion as scatter shows it: a sensor that is shaken, knocked or carried, with the samples at which that starts and ends.
//!
//! Over averages' blocks of max(1 s, 50 samples): *violent* where the scatter within a block or the step of neighboring
//! averages is beyond what any sensor at rest does and ten times that of the log's quiet blocks, so that a log of which
//! most is motion is told as well; a *burst* where the scatter is three times the usual one of the rest. Edges are where
//! the likelihood of the larger variance, Σ [d²/v₀ − d²/v₁ − ln(v₁/v₀)], is largest.

use std::f64::consts::SQRT_2;
use std::ops::Range;

use super::{Averages, Motion, averages};
use crate::health::channel::short;
use crate::health::robust;
use crate::{Log, Quantity};

/// Violent motion is so many times the quiet scatter.
const VIOLENT: f64 = 10.0;
/// A scatter off the usual one by so many robust deviations of its logarithm (and three times it) bursts.
const BURST_SPREAD: f64 = 6.0;
/// Fewest blocks that know a usual scatter.
const FEWEST: usize = 20;
/// Marks so many blocks apart are one event.
const APART: usize = 2;
/// Share of a block that is left out beside both ends of an event: nothing starts at once.
const MARGIN: f64 = 0.1;

/// The channels that motion is looked for in: name, what it measures, samples, stuck rows.
fn inertial<'a>(
    log: &'a Log,
    stuck: &'a [Vec<Range<usize>>],
) -> impl Iterator<Item = (&'a str, Quantity, &'a [f64], &'a [Range<usize>])> {
    log.channels()
        .zip(stuck)
        .filter(|((c, _), _)| matches!(c.quantity, Quantity::AngularRate | Quantity::SpecificForce))
        .map(|((c, values), s)| (c.name.as_str(), c.quantity, values, s.as_slice()))
}

/// What no sensor at rest shows within a second.
fn least(quantity: Quantity) -> f64 {
    if quantity == Quantity::AngularRate {
        0.05
    } else {
        0.5
    }
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut v: Vec<f64> = values.filter(|s| s.is_finite()).collect();
    if v.is_empty() {
        return f64::NAN;
    }
    let at = ((v.len() - 1) as f64 * share) as usize;
    *v.select_nth_unstable_by(at, f64::total_cmp).1
}

/// One channel by blocks.
struct Blocks<'a> {
    name: &'a str,
    values: &'a [f64],
    quantity: Quantity,
    means: Averages,
    /// Usual scatter within a block.
    usual: f64,
    marked: Vec<bool>,
}

/// Rows in which the sensor was moved violently, on any channel.
pub(super) fn violent(log: &Log, size: usize, stuck: &[Vec<Range<usize>>]) -> Vec<Motion> {
    let channels: Vec<Blocks<'_>> = inertial(log, stuck)
        .map(|(name, quantity, values, stuck)| {
            let means = averages(values, size, stuck);
            // Samples far apart tell motion, neighbors noise: the quieter of the two is the sensor's own.
            let neighbors = values.chunks_exact(size).map(|part| {
                let sum: f64 = part.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
                (0.5 * sum / (size - 1) as f64).sqrt()
            });
            let usual =
                quantile(neighbors, 0.25).min(quantile(means.scatter.iter().copied(), 0.25));
            let limit = (VIOLENT * usual).max(least(quantity));
            let mut marked: Vec<bool> = means.scatter.iter().map(|s| *s > limit).collect();
            for k in 1..marked.len() {
                if (means.mean[k] - means.mean[k - 1]).abs() > SQRT_2 * limit {
                    (marked[k - 1], marked[k]) = (true, true);
                }
            }
            Blocks {
                name,
                values,
                quantity,
                means,
                usual,
                marked,
            }
        })
        .collect();
    events(&channels, size, log.rows, |c, rows| {
        let largest = peak(c, rows, size);
        format!("moved: the scatter is up to {} on {}", largest.1, largest.0)
    })
}

/// Rows in which the scatter bursts, on any channel.
pub(super) fn bursts(log: &Log, size: usize, known: &[Vec<Range<usize>>]) -> Vec<Motion> {
    if log.rows / size < FEWEST {
        return Vec::new();
    }
    let channels: Vec<Blocks<'_>> = inertial(log, known)
        .map(|(name, quantity, values, known)| {
            let means = averages(values, size, known);
            let usual = quantile(means.scatter.iter().copied(), 0.5);
            // Smoothed samples leave few independent ones in a block: its scatter then varies by itself.
            let mut spread: Vec<f64> = means
                .scatter
                .iter()
                .map(|s| (s / usual).ln())
                .filter(|l| l.is_finite())
                .collect();
            let limit = usual * (BURST_SPREAD * robust(&mut spread)).exp().max(3.0);
            let is_known = spread.len() >= FEWEST / 2 && usual > 0.0;
            let marked = means
                .scatter
                .iter()
                .map(|s| is_known && *s > limit)
                .collect();
            Blocks {
                name,
                values,
                quantity,
                means,
                usual,
                marked,
            }
        })
        .collect();
    events(&channels, size, log.rows, |c, rows| {
        let (name, _, ratio) = peak(c, rows, size);
        format!("the scatter bursts to {ratio:.0} times the usual on {name}")
    })
}

/// The channel of the largest scatter over its usual one, that scatter in its unit, and the ratio.
fn peak<'a>(channels: &[Blocks<'a>], rows: &Range<usize>, size: usize) -> (&'a str, String, f64) {
    let mut best = ("", String::new(), 0.0);
    for c in channels {
        let (a, b) = (rows.start / size, rows.end.div_ceil(size));
        // A change between two blocks shows in their means alone.
        let change = |k: usize| match k.checked_sub(1).filter(|&before| before >= a) {
            Some(before) => (c.means.mean[k] - c.means.mean[before]).abs() / SQRT_2,
            None => 0.0,
        };
        let largest = (a..b.min(c.means.scatter.len()))
            .flat_map(|k| [c.means.scatter[k], change(k)])
            .filter(|s| s.is_finite())
            .fold(0.0, f64::max);
        let ratio = largest / c.usual;
        if ratio.is_finite() && ratio > best.2 {
            let unit = if c.quantity == Quantity::AngularRate {
                "rad/s"
            } else {
                "m/s^2"
            };
            best = (c.name, format!("{} {unit}", short(largest)), ratio);
        }
    }
    best
}

/// Runs of marks on any channel, with their edges.
fn events(
    channels: &[Blocks<'_>],
    size: usize,
    rows: usize,
    text: impl Fn(&[Blocks<'_>], &Range<usize>) -> String,
) -> Vec<Motion> {
    let blocks = channels.iter().map(|c| c.marked.len()).max().unwrap_or(0);
    let marked: Vec<usize> = (0..blocks)
        .filter(|&k| channels.iter().any(|c| c.marked.get(k) == Some(&true)))
        .collect();
    marked
        .chunk_by(|a, b| b - a <= APART)
        .map(|run| {
            let (first, last) = (run[0], run[run.len() - 1]);
            let names = channels
                .iter()
                .filter(|c| c.marked[first..=last].contains(&true))
                .map(|c| c.name.to_owned())
                .collect();
            let whole = first * size..((last + 1) * size).min(rows);
            let text = text(channels, &whole);
            Motion {
                rows: edges(channels, first, last, size, rows),
                channels: names,
                text,
            }
        })
        .collect()
}

/// The rows between which blocks `first` to `last` scatter more.
fn edges(
    channels: &[Blocks<'_>],
    first: usize,
    last: usize,
    size: usize,
    rows: usize,
) -> Range<usize> {
    let margin = (MARGIN * size as f64) as usize;
    let edge = |block: usize, forward: bool| -> usize {
        // The mark may be that of a step to its neighbor: both are looked at, and a block beyond; the sum runs from
        // inside outwards.
        let inner = if forward {
            (block + 1).min(last)
        } else {
            block.saturating_sub(1).max(first)
        };
        let window = if forward {
            block.saturating_sub(1) * size..((inner + 1) * size).min(rows)
        } else {
            inner * size..((block + 2) * size).min(rows)
        };
        let mut gain = vec![0.0; window.len()];
        for c in channels {
            if !(c.marked[block] || c.marked[inner]) {
                continue;
            }
            let quiet = if forward {
                block.checked_sub(1)
            } else {
                Some(block + 1)
            };
            let level = quiet
                .and_then(|k| c.means.mean.get(k))
                .copied()
                .filter(|m| m.is_finite())
                .unwrap_or(c.means.mean[block]);
            let largest = |k: usize| {
                let (scatter, off) = (c.means.scatter[k], c.means.mean[k] - level);
                scatter.max(off.abs()).powi(2)
            };
            let (v0, v1) = (c.usual * c.usual, largest(block).max(largest(inner)));
            if !(v0 > 0.0 && v1 > v0) {
                continue;
            }
            for (g, y) in gain.iter_mut().zip(&c.values[window.clone()]) {
                let d = (y - level) * (y - level);
                if d.is_finite() {
                    *g += d / v0 - d / v1 - (v1 / v0).ln();
                }
            }
        }
        let (mut sum, mut best) = (0.0, (0.0, usize::MAX));
        let mut look = |k: usize| {
            sum += gain[k];
            if sum > best.0 {
                best = (sum, k);
            }
        };
        if forward {
            (0..gain.len()).rev().for_each(&mut look);
        } else {
            (0..gain.len()).for_each(&mut look);
        }
        match (best.1, forward) {
            (usize::MAX, true) => block * size,
            (usize::MAX, false) => ((block + 1) * size).min(rows),
            (k, true) => window.start + k,
            (k, false) => window.start + k + 1,
        }
    };
    let start = edge(first, true).saturating_sub(margin);
    // The last rows make no whole block: what goes on to the last one goes on to the end.
    let is_end = (last + 2) * size > rows;
    let end = match edge(last, false) + margin {
        _ if is_end && edge(last, false) + size / 2 >= (last + 1) * size => rows,
        end => end.min(rows),
    };
    start..end.max(start + 1)
}
