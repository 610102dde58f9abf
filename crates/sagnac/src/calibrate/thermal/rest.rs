//! Whether the sensor rests while its temperature is swept: what moved is left out, what was turned is refused.
//!
//! Motion is told as for logs at rest (statistics.md §3), of the samples less the line through the medians of blocks: what
//! temperature does is slow and no motion. It counts where two channels show it. A turn at an even rate has no scatter: it
//! is told by the level of a gyro, which no temperature moves by so much within minutes.

use sagnac_core::Sensor;
use sagnac_log::{Issue, IssueKind, Log, Quantity, health};
use sagnac_report::text::{clock, general};

use crate::Error;
use crate::calibrate::multi_position::triad;
use crate::characterize::NamedLog;

/// More of the log than this in motion is no rest.
const MOST_MOVING: f64 = 0.5;
/// What the median block of no sensor at rest shows \[rad/s\], \[m/s²\].
const LEAST_RAD_S: f64 = 0.05;
const LEAST_M_S2: f64 = 0.5;
/// Turns of the direction of gravity that count: beside a motion, and between neighbouring blocks of a rest.
const TURNED_RAD: f64 = 0.5 / 57.295_779_513_082_32;
const TURNED_AT_REST_RAD: f64 = 3.0 / 57.295_779_513_082_32;
/// Half the size of gravity \[m/s²\].
const LEAST_GRAVITY: f64 = 0.5 * 9.80665;
/// Samples off the level by so many robust deviations count, and so many of them are more than odd ones.
const OFF: f64 = 6.0;
const FEWEST_OFF: usize = 3;
/// A gyro's block this far from the median of those around it turns \[rad/s\], and how far these reach on either side \[s\].
const TURNS_RAD_S: f64 = 1.0 / 57.295_779_513_082_32;
const AROUND_S: f64 = 900.0;
/// Blocks whose mean tells the direction beside a motion.
const BESIDE: usize = 3;

/// A log without what moved.
pub(super) struct Rest {
    pub(super) log: Log,
    pub(super) issues: Vec<Issue>,
    /// Time of the first row on the log's clock \[s\].
    pub(super) first_s: f64,
    pub(super) duration_s: f64,
}

/// Leaves out what moved.
///
/// # Errors
/// A sensor that moves most of the time, or that does not point as before after it was moved.
pub(super) fn rest(named: &NamedLog, times_s: Option<&[f64]>) -> Result<Rest, Error> {
    let log = &named.log;
    let dt_s = log.dt_s()?;
    let time = |row: usize| match times_s.and_then(|t| t.get(row)) {
        Some(t) => *t,
        None => (row + 1) as f64 * dt_s,
    };
    let first_s = time(0);
    let size = ((1.0 / dt_s).round() as usize).max(50);
    let level = without_level(log, size);
    if let Some(what) = restless(&level, size) {
        return Err(moving(&named.name, "the sensor moves all the time", &what));
    }
    let mut out = Rest {
        log: log.clone(),
        issues: Vec::new(),
        first_s,
        duration_s: time(log.rows - 1) - first_s + dt_s,
    };
    let mut moved: Vec<health::Moved> = health::moved(&level)?
        .into_iter()
        .filter(|m| m.channels.len() > 1 && is_more_than_a_sample(&level, m))
        .collect();
    let around = (AROUND_S / (size as f64 * dt_s)).ceil() as usize;
    for turn in even_turns(log, size, around) {
        let overlaps =
            |m: &health::Moved| m.rows.start < turn.rows.end && turn.rows.start < m.rows.end;
        if !moved
            .iter()
            .any(|m| overlaps(m) && m.rows.len() >= turn.rows.len())
        {
            moved.retain(|m| !overlaps(m));
            moved.push(turn);
        }
    }
    moved.sort_by_key(|m| m.rows.start);
    let count: usize = moved.iter().map(|m| m.rows.len()).sum();
    let share = count as f64 / log.rows as f64;
    if share > MOST_MOVING {
        let what = format!("the sensor moves in {:.0} % of the log", 100.0 * share);
        return Err(moving(&named.name, &what, &moved[0].text));
    }
    for m in &moved {
        for (channel, column) in out.log.layout.channels.iter().zip(&mut out.log.columns) {
            if is_inertial(channel.quantity) {
                column[m.rows.clone()].fill(f64::NAN);
            }
        }
        out.issues.push(Issue {
            kind: IssueKind::Motion,
            channel: None,
            start_s: time(m.rows.start),
            end_s: time(m.rows.end - 1),
            count: m.rows.len() as u64,
            text: format!(
                "{}, seen on {}; left out of the curves",
                m.text,
                m.channels.join(", ")
            ),
        });
    }
    if let Some((row, angle_rad)) = turned(&out.log, &moved, size) {
        return Err(Error::data(format!(
            "the sensor was turned by {} deg at {}: it has another axis up before and after",
            general(angle_rad.to_degrees(), 2),
            clock(time(row) - first_s),
        ))
        .at(named.name.clone())
        .advise(
            "keep it as it is mounted through the whole sweep; cut the log there with --start and --end, and give \
             the parts as two logs",
        ));
    }
    Ok(out)
}

fn moving(name: &str, what: &str, seen: &str) -> Error {
    Error::data(format!("{what}: {seen}"))
        .at(name.to_owned())
        .advise("let the sensor rest in the chamber while its temperature is swept")
}

fn is_inertial(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::AngularRate | Quantity::SpecificForce)
}

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The samples less the line through the medians of their blocks.
fn without_level(log: &Log, size: usize) -> Log {
    let mut out = log.clone();
    for (channel, column) in log.layout.channels.iter().zip(&mut out.columns) {
        if !is_inertial(channel.quantity) {
            continue;
        }
        let mut levels: Vec<[f64; 2]> = Vec::new();
        for (number, part) in column.chunks(size).enumerate() {
            let mut there: Vec<f64> = part.iter().copied().filter(|v| v.is_finite()).collect();
            // A rest of a block at the end has a median that is too uncertain.
            let whole = part.len() == size || number == 0;
            if let Some(m) = median(&mut there).filter(|_| whole) {
                levels.push([(number * size) as f64 + 0.5 * (part.len() - 1) as f64, m]);
            }
        }
        let mut next = 1;
        for (k, v) in column.iter_mut().enumerate() {
            let at = k as f64;
            while next + 1 < levels.len() && levels[next][0] < at {
                next += 1;
            }
            *v -= match (levels.get(next - 1), levels.get(next)) {
                (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (at - a[0]) / (b[0] - a[0]),
                (Some(a), None) => a[1],
                _ => 0.0,
            };
        }
    }
    out
}

/// Stretches in which the level of a gyro lies far from what it is around them, a block on either side with them.
fn even_turns(log: &Log, size: usize, reach: usize) -> Vec<health::Moved> {
    let mut out: Vec<health::Moved> = Vec::new();
    for (channel, values) in log.channels() {
        if channel.quantity != Quantity::AngularRate {
            continue;
        }
        let level = |part: &[f64]| {
            let mut there: Vec<f64> = part.iter().copied().filter(|v| v.is_finite()).collect();
            median(&mut there).unwrap_or(f64::NAN)
        };
        let levels: Vec<f64> = values.chunks(size).map(level).collect();
        let mut run: Option<(usize, usize, f64)> = None;
        let mut runs = Vec::new();
        for (k, own) in levels.iter().enumerate() {
            let around = k.saturating_sub(reach)..(k + reach + 1).min(levels.len());
            let off = (own - level(&levels[around])).abs();
            if off <= TURNS_RAD_S || off.is_nan() {
                continue;
            }
            match &mut run {
                Some((_, last, most)) if k <= *last + 2 => (*last, *most) = (k, most.max(off)),
                _ => runs.extend(run.replace((k, k, off))),
            }
        }
        runs.extend(run);
        out.extend(runs.into_iter().map(|(first, last, most)| health::Moved {
            rows: first.saturating_sub(1) * size..((last + 2) * size).min(values.len()),
            channels: vec![channel.name.clone()],
            text: format!("turned at up to {} rad/s", general(most, 2)),
        }));
    }
    // Axes of one turn are one.
    out.sort_by_key(|m| m.rows.start);
    let mut joined: Vec<health::Moved> = Vec::new();
    for turn in out {
        match joined.last_mut() {
            Some(before) if turn.rows.start < before.rows.end => {
                before.rows.end = before.rows.end.max(turn.rows.end);
                before.channels.extend(turn.channels);
            }
            _ => joined.push(turn),
        }
    }
    joined
}

/// Whether more than a sample or two are off: these are no motion, and weigh nothing in the mean of a bin.
fn is_more_than_a_sample(level: &Log, moved: &health::Moved) -> bool {
    let mut off: Vec<usize> = Vec::new();
    for (channel, values) in level.channels() {
        if !moved.channels.contains(&channel.name) {
            continue;
        }
        let mut sizes: Vec<f64> = values
            .iter()
            .filter(|v| v.is_finite())
            .map(|v| v.abs())
            .collect();
        let Some(usual) = median(&mut sizes) else {
            continue;
        };
        let limit = OFF * 1.4826 * usual;
        off.extend(moved.rows.clone().filter(|k| values[*k].abs() > limit));
    }
    off.sort_unstable();
    off.dedup();
    off.len() >= FEWEST_OFF
}

/// What says that no block is at rest, where two channels or more say so.
fn restless(level: &Log, size: usize) -> Option<String> {
    let mut seen: Vec<String> = Vec::new();
    for (channel, values) in level.channels() {
        let (least, unit) = match channel.quantity {
            Quantity::AngularRate => (LEAST_RAD_S, "rad/s"),
            Quantity::SpecificForce => (LEAST_M_S2, "m/s^2"),
            _ => continue,
        };
        let mut scatters: Vec<f64> = values
            .chunks(size)
            .filter_map(|part| {
                let there = || part.iter().filter(|v| v.is_finite());
                let n = there().count();
                (2 * n > part.len())
                    .then(|| (there().map(|v| v * v).sum::<f64>() / n as f64).sqrt())
            })
            .collect();
        if let Some(usual) = median(&mut scatters).filter(|s| *s > least) {
            seen.push(format!(
                "{} on {}",
                general(usual, 2) + " " + unit,
                channel.name
            ));
        }
    }
    (seen.len() > 1).then(|| {
        format!(
            "its scatter within moments is {}, more than any sensor at rest shows",
            seen.join(", ")
        )
    })
}

/// Where the direction of the specific force changes as no temperature changes it: row and angle.
///
/// Outputs without gravity (taken off, or of a sensor in free fall) have no direction to turn.
fn turned(log: &Log, moved: &[health::Moved], size: usize) -> Option<(usize, f64)> {
    let accel = triad(log, Sensor::Accel)?;
    // Means of blocks that are at rest, with the row where they begin.
    let mut blocks: Vec<(usize, [f64; 3])> = Vec::new();
    for start in (0..log.rows).step_by(size) {
        let rows = start..(start + size).min(log.rows);
        let mut mean = [0.0; 3];
        let mut is_there = true;
        for (mean, values) in mean.iter_mut().zip(accel) {
            let there = || values[rows.clone()].iter().filter(|v| v.is_finite());
            let n = there().count();
            is_there &= 2 * n > rows.len().max(size / 2);
            *mean = there().sum::<f64>() / n as f64;
        }
        if is_there {
            blocks.push((start, mean));
        }
    }
    let size_of = |f: [f64; 3]| f.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut sizes: Vec<f64> = blocks.iter().map(|b| size_of(b.1)).collect();
    median(&mut sizes).filter(|f| *f > LEAST_GRAVITY)?;
    let mean = |part: &[(usize, [f64; 3])]| -> [f64; 3] {
        [0, 1, 2].map(|k| part.iter().map(|b| b.1[k]).sum::<f64>() / part.len() as f64)
    };
    for m in moved {
        let before = blocks.partition_point(|b| b.0 + size <= m.rows.start);
        let after = blocks.partition_point(|b| b.0 < m.rows.end);
        if before > 0 && after < blocks.len() {
            let from = mean(&blocks[before.saturating_sub(BESIDE)..before]);
            let to = mean(&blocks[after..(after + BESIDE).min(blocks.len())]);
            let angle = angle(from, to);
            if angle > TURNED_RAD {
                return Some((usize::midpoint(m.rows.start, m.rows.end), angle));
            }
        }
    }
    // A turn too quick for a motion lies within a block: neighbours but one.
    blocks.windows(3).find_map(|of| {
        let rows = of[0].0..of[2].0 + size;
        let is_rest = !moved
            .iter()
            .any(|m| m.rows.start < rows.end && rows.start < m.rows.end);
        let angle = angle(of[0].1, of[2].1);
        (is_rest && angle > TURNED_AT_REST_RAD).then_some((of[1].0, angle))
    })
}

/// Angle between two directions \[rad\].
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    cross.iter().map(|v| v * v).sum::<f64>().sqrt().atan2(dot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_change_is_no_motion_and_a_turn_is_one() {
        assert!((angle([0.0, 0.0, 9.8], [9.8, 0.0, 0.0]).to_degrees() - 90.0).abs() < 1e-9);
        assert!(angle([0.0, 0.0, 9.8], [0.0, 0.0, 9.1]) < 1e-12);
    }
}
