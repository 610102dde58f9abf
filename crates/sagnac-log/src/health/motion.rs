//! Somebody moved the sensor: averages that leave their neighbors, or scatter that bursts.
//!
//! Averages over max(1 s, 50 samples), and over ten of them; σ_A is the robust scatter of the differences of
//! neighboring averages over √2. A sensor that moves shows it on all axes of a triad at once, so that the differences
//! are also judged together, as √Σ(d/σ_A)² over the axes, at more scales: `together`.

use std::ops::Range;

use super::found::{Found, Said};
use super::robust;
use super::time::Clock;

mod shaken;
mod together;

use crate::{Issue, IssueKind, Log, Quantity};

/// An interval of motion.
pub(crate) struct Motion {
    pub(crate) rows: Range<usize>,
    /// The channels that show it.
    pub(crate) channels: Vec<String>,
    pub(crate) text: String,
}

/// What no sensor at rest or in motion shows, also where its unit was mistaken.
const BEYOND_ANY_RATE_RAD_S: f64 = 1e8;
const BEYOND_ANY_FORCE_M_S2: f64 = 1e10;
/// Fewest values that an average is taken of.
const FEWEST_IN_AVERAGE: usize = 10;

/// Averages and scatters of one channel.
struct Averages {
    mean: Vec<f64>,
    scatter: Vec<f64>,
}

fn averages(values: &[f64], size: usize, stuck: &[Range<usize>]) -> Averages {
    let n = values.len() / size;
    // Values that a block has, as a rule: fewer in a channel with one in every k-th row.
    let finite = values.iter().filter(|v| v.is_finite()).count();
    let usual = (finite * size).div_ceil(values.len().max(1));
    let (mut mean, mut scatter) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for (b, part) in values.chunks_exact(size).enumerate() {
        let rows = b * size..(b + 1) * size;
        if stuck
            .iter()
            .any(|s| s.start < rows.end && rows.start < s.end)
        {
            mean.push(f64::NAN);
            scatter.push(f64::NAN);
            continue;
        }
        // The first value is taken out: equal values have no scatter at all.
        let m = part[0] + part.iter().map(|v| v - part[0]).sum::<f64>() / size as f64;
        if m.is_finite() {
            mean.push(m);
            let squares = part.iter().map(|v| (v - m) * (v - m)).sum::<f64>();
            scatter.push((squares / size as f64).sqrt());
            continue;
        }
        // Lost samples leave an average of the others, where there are enough.
        let there = || part.iter().filter(|v| v.is_finite());
        let n = there().count();
        if n < FEWEST_IN_AVERAGE || 2 * n < usual {
            mean.push(f64::NAN);
            scatter.push(f64::NAN);
            continue;
        }
        let m = there().sum::<f64>() / n as f64;
        mean.push(m);
        scatter.push((there().map(|v| (v - m) * (v - m)).sum::<f64>() / n as f64).sqrt());
    }
    Averages { mean, scatter }
}

/// The marks of one channel: how many σ_A an average is off, or `None`.
fn marks(a: &Averages) -> Vec<Option<f64>> {
    let n = a.mean.len();
    let mut steps: Vec<f64> = a
        .mean
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| d.is_finite())
        .collect();
    let mut out = vec![None; n];
    if steps.len() < 8 {
        return out;
    }
    let rms = (steps.iter().map(|d| d * d).sum::<f64>() / steps.len() as f64).sqrt();
    let mut sigma = robust(&mut steps) / std::f64::consts::SQRT_2;
    if sigma == 0.0 {
        sigma = rms / std::f64::consts::SQRT_2;
    }
    for k in 0..n {
        // An average between its neighbors is on its way, not off.
        let left = k.checked_sub(1).map(|j| a.mean[k] - a.mean[j]);
        let right = a.mean.get(k + 1).map(|m| a.mean[k] - m);
        let (left, right) = (
            left.filter(|d| d.is_finite()),
            right.filter(|d| d.is_finite()),
        );
        let off = match (left, right) {
            (Some(l), Some(r)) => {
                if l.abs() > r.abs() {
                    l
                } else {
                    r
                }
            }
            (Some(d), None) | (None, Some(d)) => d,
            (None, None) => 0.0,
        };
        if off.abs() > 8.0 * sigma && sigma > 0.0 {
            out[k] = Some(off);
        }
    }
    out
}

/// Intervals in which the sensor moved, ascending and apart.
pub(crate) fn intervals(log: &Log, clock: &Clock<'_>, stuck: &[Vec<Range<usize>>]) -> Vec<Motion> {
    let size = ((1.0 / clock.dt_s).round() as usize).max(50);
    // The clearest first: what they take leaves the judgement of the rest alone.
    let mut known = stuck.to_vec();
    let mut absurd = Vec::new();
    // A value that no sensor gives is left out of every average; an infinite one is a lost sample, as NaN is.
    for (known, (channel, values)) in known.iter_mut().zip(log.channels()) {
        let most = match channel.quantity {
            Quantity::AngularRate => BEYOND_ANY_RATE_RAD_S,
            Quantity::SpecificForce => BEYOND_ANY_FORCE_M_S2,
            _ => f64::MAX,
        };
        let runs = super::channel::runs(values, |v| v.is_finite() && v.abs() > most);
        // A channel of nothing else has no rest that they could be left out of.
        if 2 * runs.iter().map(Range::len).sum::<usize>() < values.len() {
            absurd.extend(runs.iter().map(|rows| Motion {
                rows: rows.clone(),
                channels: vec![channel.name.clone()],
                text: format!("a value no sensor gives: {:e}", values[rows.start]),
            }));
        }
        known.extend(runs);
    }
    let mut found = shaken::violent(log, size, &known);
    take(&found, &mut known);
    let bursts = shaken::bursts(log, size, &known);
    take(&bursts, &mut known);
    found.extend(bursts);
    let shaken = found.len();
    together::intervals(log, size, &known, &mut found);
    if log.rows / size >= 20 {
        jumps(log, size, &known, shaken, &mut found);
    }
    found.extend(absurd);
    found.sort_by_key(|m| m.rows.start);
    let mut out: Vec<Motion> = Vec::new();
    for m in found {
        match out.last_mut() {
            Some(last) if m.rows.start <= last.rows.end + size => {
                last.rows.end = last.rows.end.max(m.rows.end);
                for c in m.channels {
                    if !last.channels.contains(&c) {
                        last.channels.push(c);
                    }
                }
            }
            _ => out.push(m),
        }
    }
    out
}

/// Adds rows to what is no rest on any channel.
fn take(found: &[Motion], known: &mut [Vec<Range<usize>>]) {
    for ranges in known {
        ranges.extend(found.iter().map(|m| m.rows.clone()));
    }
}

/// Adds jumps on two channels or more, or on one that come back, apart from the motions known but the first `shaken`.
fn jumps(
    log: &Log,
    size: usize,
    stuck: &[Vec<Range<usize>>],
    shaken: usize,
    found: &mut Vec<Motion>,
) {
    let blocks = log.rows / size;
    let mut all: Vec<(&str, Averages, Vec<Option<f64>>)> = Vec::new();
    for ((channel, values), stuck) in log.channels().zip(stuck) {
        if matches!(
            channel.quantity,
            Quantity::AngularRate | Quantity::SpecificForce
        ) {
            let a = averages(values, size, stuck);
            let m = marks(&a);
            all.push((&channel.name, a, m));
        }
    }
    let marked: Vec<bool> = (0..blocks)
        .map(|k| all.iter().any(|c| c.2[k].is_some()))
        .collect();
    let mut k = 0;
    while k < blocks {
        if !marked[k] {
            k += 1;
            continue;
        }
        // Marks at most two averages apart are one event.
        let start = k;
        let mut end = k + 1;
        while end < blocks && (marked[end] || marked.get(end + 1) == Some(&true)) {
            end += 1;
        }
        k = end;
        let rows = start * size..(end * size).min(log.rows);
        // The edges of a known motion are jumps as well.
        if found[shaken..]
            .iter()
            .any(|m| m.rows.start < rows.end + size && rows.start < m.rows.end + size)
        {
            continue;
        }
        let names: Vec<&str> = all
            .iter()
            .filter(|c| c.2[start..end].iter().any(Option::is_some))
            .map(|c| c.0)
            .collect();
        let returns = names.len() == 1
            && all.iter().filter(|c| c.0 == names[0]).any(|(_, a, m)| {
                let before = level(&a.mean, start.saturating_sub(4)..start);
                let after = level(&a.mean, end..end + 4);
                let height = m[start..end]
                    .iter()
                    .flatten()
                    .map(|off| off.abs())
                    .fold(0.0, f64::max);
                matches!((before, after), (Some(b), Some(c)) if (b - c).abs() < 0.5 * height)
            });
        if names.len() < 2 && !returns {
            continue;
        }
        let largest = all
            .iter()
            .flat_map(|c| c.2[start..end].iter().flatten().map(move |off| (c.0, *off)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let text = match largest {
            Some((name, off)) if off != 0.0 => {
                let unit = if name.starts_with("gyro") {
                    "rad/s"
                } else {
                    "m/s^2"
                };
                format!("levels move by up to {:.2e} {unit} ({name})", off.abs())
            }
            _ => "levels move".to_owned(),
        };
        found.push(Motion {
            rows,
            channels: names.iter().map(|n| (*n).to_owned()).collect(),
            text,
        });
    }
}

fn level(means: &[f64], blocks: Range<usize>) -> Option<f64> {
    let mut part: Vec<f64> = means
        .get(blocks.start..blocks.end.min(means.len()))?
        .iter()
        .copied()
        .filter(|m| m.is_finite())
        .collect();
    crate::clock::median(&mut part)
}

/// The findings of motion.
pub(super) fn issues(motion: &[Motion], clock: &Clock<'_>, issues: &mut Vec<Found>) {
    for m in motion {
        let others = if m.channels.len() > 1 {
            format!(", seen on {}", m.channels.join(", "))
        } else {
            String::new()
        };
        let issue = Issue {
            kind: IssueKind::Motion,
            channel: (m.channels.len() == 1).then(|| m.channels[0].clone()),
            start_s: clock.absolute(m.rows.start),
            end_s: clock.absolute(m.rows.end.saturating_sub(1)),
            count: m.rows.len() as u64,
            text: format!("{}{others}; left out of the parameters", m.text),
        };
        issues.push(Found::run(issue, m.rows.clone(), Said::Once));
    }
}
