//! The beat of a log: its sampling interval and what happens between its rows.
//!
//! A step is off where it is more than 1.5·dt; a late stamp whose successors catch up is jitter, no gap: the stamps
//! less k·dt have to stay away. On a grid as coarse as dt, a step has to be longer than rounding makes it.

use crate::clock::{interval, median, steps};
use crate::coarse::Coarse;
use crate::{Log, Stamps, wild};

/// What the first stamps of a stream tell of all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cadence {
    /// The sampling interval, s.
    pub dt_s: f64,
    /// A longer step is a gap, unless later stamps catch up, s.
    pub longest_s: f64,
    /// True where equal stamps are those of a coarse grid, and no repeats.
    pub is_coarse: bool,
}

impl Cadence {
    /// That of some stamps in a row; `None` where time never advances.
    pub fn of(stamps: &Stamps) -> Option<Self> {
        let mut steps = steps(stamps);
        if is_doubled(&steps) {
            steps.retain(|s| *s != 0.0);
        }
        if let Some(coarse) = Coarse::of(&steps) {
            return Some(Self {
                dt_s: coarse.dt_s,
                longest_s: coarse.dt_s + 1.5 * coarse.grid_s,
                is_coarse: true,
            });
        }
        let dt_s = interval(&steps)?;
        Some(Self {
            dt_s,
            longest_s: pause(&steps, dt_s),
            is_coarse: false,
        })
    }
}

/// What happens between two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Event {
    /// So many samples are missing before this row.
    Gap(u64),
    /// This row has the time of the one before.
    Duplicate,
    /// Time goes back at this row.
    Backwards,
}

/// Robust scatter of the steps over dt beyond which the clock is uneven.
pub(crate) const SCATTERED: f64 = 0.05;

/// Counts of a counter of 32 bits until it begins again.
pub(crate) const COUNTS: f64 = 4_294_967_296.0;

/// Units that clocks of sensors count in, s.
const USUAL_UNITS_S: [f64; 3] = [1e-3, 1e-6, 1e-9];

/// The beat of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Beat {
    /// The stamps' own interval; `None` where time never advances.
    pub(crate) dt_s: Option<f64>,
    /// The stamps' grid, where it is about as coarse as the interval or coarser.
    pub(crate) grid_s: Option<f64>,
    /// Rows at which something happens, ascending.
    pub(crate) events: Vec<(usize, Event)>,
    /// Rows at which a counter wrapped, with what was added.
    pub(crate) wraps: Vec<(usize, f64)>,
    /// Rows with a single stamp that is wrong.
    pub(crate) wild: Vec<usize>,
    /// Steps off by more than 20 %, and the robust scatter of the steps over dt; `None` where the clock is even.
    pub(crate) jitter: Option<(u64, f64)>,
}

impl Beat {
    pub(crate) fn of(log: &Log) -> Self {
        let mut beat = Self::default();
        let mut steps = steps(&log.stamps);
        beat.undo_wraps(&mut steps, log.layout.time_unit_s);
        beat.wild = wild::rows(&log.stamps, &steps);
        let is_twice = repeats_rows(log, &steps) || is_doubled(&steps);
        let of_rows = |steps: &[f64]| {
            if is_twice {
                // Rows that share a stamp with the one before are dropped.
                let once: Vec<f64> = steps.iter().copied().filter(|s| *s != 0.0).collect();
                interval(&once)
            } else {
                interval(steps)
            }
        };
        let Some(first) = of_rows(&steps) else {
            return beat;
        };
        beat.bridge(&log.stamps, &mut steps, first);
        // Of a rate that was told the grid may be the interval itself: what is missing on it is lost.
        let told = |c: &Coarse| {
            log.layout
                .rate_hz
                .is_some_and(|rate| (1.0 / rate - c.grid_s).abs() < (1.0 / rate - c.dt_s).abs())
        };
        if let Some(coarse) = Coarse::of(&steps).filter(|c| !is_twice && !told(c)) {
            beat.grid_s = Some(coarse.grid_s);
            beat.dt_s = Some(coarse.dt_s);
            beat.find_coarse_gaps(&steps, coarse);
            return beat;
        }
        let mut dt = first;
        beat.judge_jitter(&steps, dt, resolution(&steps, dt));
        beat.find_events(&steps, dt);
        // Where stamps scatter, what is lost and the interval have to add up to the length.
        for _ in 0..4 {
            let Some(next) = beat.jitter.and_then(|_| beat.mean_interval(&steps, dt)) else {
                break;
            };
            let is_same = (next / dt - 1.0).abs() < 1e-9;
            // Far from the first guess, the gaps are no gaps: that one stands.
            if is_same || (next / first - 1.0).abs() > 0.25 {
                break;
            }
            dt = next;
            beat.find_events(&steps, dt);
        }
        beat.dt_s = Some(dt);
        beat
    }

    /// Undoes jumps back of 2³² of the unit of the stamps, and of a counter's usual unit that was written in another.
    fn undo_wraps(&mut self, steps: &mut [f64], unit_s: Option<f64>) {
        if !steps.iter().any(|s| *s < 0.0) {
            return;
        }
        let dt = interval(steps).unwrap_or(0.0);
        for (k, step) in steps.iter_mut().enumerate().filter(|(_, s)| **s < 0.0) {
            let undone_within =
                |turn: f64, most: f64| (*step + turn > 0.0 && *step + turn < most).then_some(turn);
            let own = unit_s.and_then(|unit_s| {
                let turn = unit_s * COUNTS;
                undone_within(turn, (100.0 * dt).min(0.01 * turn).max(2.0 * dt))
            });
            // Of a unit that is guessed the step has to be that of neighbors, and no jump of any length passes for it.
            let found = own.or_else(|| {
                let mut turns = USUAL_UNITS_S.iter().map(|unit_s| unit_s * COUNTS);
                turns.find_map(|turn| undone_within(turn, (2.5 * dt).min(0.01 * turn)))
            });
            if let Some(turn) = found {
                *step += turn;
                self.wraps.push((k + 1, turn));
            }
        }
    }

    /// Rows without a stamp that counts follow the last one that has one, `dt` apart.
    fn bridge(&self, stamps: &Stamps, steps: &mut [f64], dt: f64) {
        let counts = |row: usize| {
            stamps.get(row).is_some_and(|t| t.seconds().is_finite())
                && self.wild.binary_search(&row).is_err()
        };
        let mut known = None;
        for row in 0..=steps.len() {
            if !counts(row) {
                if row > 0 {
                    steps[row - 1] = dt;
                }
                continue;
            }
            if row > 0 && known != Some(row - 1) {
                let since = |k: usize| Some(stamps.get(row)?.since(stamps.get(k)?));
                steps[row - 1] = match known {
                    Some(k) => {
                        since(k).unwrap_or(f64::NAN) - (row - k - 1) as f64 * dt
                            + self.wrapped(k, row)
                    }
                    None => dt,
                };
            }
            known = Some(row);
        }
    }

    /// What wraps add between two rows.
    fn wrapped(&self, from: usize, to: usize) -> f64 {
        let inside = |w: &&(usize, f64)| w.0 > from && w.0 <= to;
        self.wraps.iter().filter(inside).map(|w| w.1).sum()
    }

    /// The length without steps back and repeats over the samples, lost ones among them.
    fn mean_interval(&self, steps: &[f64], dt: f64) -> Option<f64> {
        // Stamps that scatter may go back by less than an interval.
        let on = || steps.iter().filter(|s| **s > -dt && **s != 0.0);
        let lost: u64 = self
            .events
            .iter()
            .map(|(_, event)| match event {
                Event::Gap(lost) => *lost,
                _ => 0,
            })
            .sum();
        let count = on().count() as f64 + lost as f64;
        (count > 0.0).then(|| on().sum::<f64>() / count)
    }

    fn judge_jitter(&mut self, steps: &[f64], dt: f64, resolution: f64) {
        // What the stamps' resolution explains: their rounding moves a step by up to one unit.
        let slack = if resolution > 1e-9 * dt {
            resolution * 1.000_001
        } else {
            0.0
        };
        let near = |s: &&f64| **s > 0.0 && **s <= 1.5 * dt.max(slack + dt);
        let off: Vec<f64> = steps
            .iter()
            .filter(near)
            .map(|s| ((s - dt).abs() - slack).max(0.0))
            .collect();
        if off.len() < 10 {
            return;
        }
        // Late stamps beyond 1.5·dt that are no gaps count as off as well.
        let late = steps
            .iter()
            .filter(|s| **s > 1.5 * dt && **s > dt + slack)
            .count();
        // A step that rounding alone cannot make counts in full.
        let many = steps
            .iter()
            .filter(near)
            .filter(|s| (**s - dt).abs() > (0.2 * dt).max(slack))
            .count();
        let mut sorted = off;
        let n = sorted.len();
        let scatter = 1.4826 * median(&mut sorted).unwrap_or(0.0) / dt;
        if scatter > SCATTERED || (many as f64 > 0.01 * n as f64 && many > late / 4) {
            self.jitter = Some((many as u64, scatter));
        }
    }

    fn find_events(&mut self, steps: &[f64], dt: f64) {
        let pause = pause(steps, dt);
        self.events.clear();
        for (k, &s) in steps.iter().enumerate() {
            let event = if s < 0.0 {
                Event::Backwards
            } else if s == 0.0 {
                Event::Duplicate
            } else if s > pause {
                let lost = if self.jitter.is_some() {
                    // At an end few rows tell a late stamp from lost samples.
                    let is_edge = (k + 1).min(steps.len() - k) < NEAR / 2 && s < 3.0 * dt;
                    if is_edge {
                        0.0
                    } else {
                        (stay(steps, k, dt, NEAR) / dt).round()
                    }
                } else {
                    (s / dt).round() - 1.0
                };
                // What scatter makes of a few rows does not last.
                let lasts = || stay(steps, k, dt, WIDE) > 0.5 * dt;
                if self.jitter.is_some() && !(lost >= 1.0 && lasts()) {
                    continue;
                }
                Event::Gap(lost.clamp(1.0, 1e15) as u64)
            } else {
                continue;
            };
            self.events.push((k + 1, event));
        }
    }

    fn find_coarse_gaps(&mut self, steps: &[f64], coarse: Coarse) {
        let Coarse { grid_s, dt_s } = coarse;
        let window = ((4.0 * grid_s / dt_s).ceil() as usize).clamp(NEAR, 1 << 16);
        for (k, &s) in steps.iter().enumerate() {
            if s < 0.0 {
                self.events.push((k + 1, Event::Backwards));
            } else if s > dt_s + 1.5 * grid_s {
                let lost = (stay(steps, k, dt_s, window) / dt_s).round();
                if lost >= 1.0 {
                    self.events.push((k + 1, Event::Gap(lost.min(1e15) as u64)));
                }
            }
        }
    }
}

/// Rows on each side of a step by which it is judged.
const NEAR: usize = 9;
/// Rows on each side over which lost samples have to last.
const WIDE: usize = 32;

/// How far the stamps after step `k` stay away from those before it, beyond one dt.
fn stay(steps: &[f64], k: usize, dt: f64, rows: usize) -> f64 {
    // Levels count from the row before the step.
    let level = |part: &mut dyn Iterator<Item = f64>, start: f64| {
        let mut levels = vec![start];
        let mut at = start;
        for step in part.take(rows - 1) {
            at += step;
            levels.push(at);
        }
        if rows > NEAR {
            levels.iter().sum::<f64>() / levels.len() as f64
        } else {
            median(&mut levels).unwrap_or(f64::NAN)
        }
    };
    // Stamps that scatter may go back a little; further back another stretch begins.
    let forward = |s: &&f64| **s > -dt;
    let mut before = steps[..k].iter().rev().take_while(forward).map(|s| dt - s);
    let mut after = steps[k + 1..].iter().take_while(forward).map(|s| s - dt);
    level(&mut after, steps[k] - dt) - level(&mut before, 0.0)
}

/// True where most rows that share a stamp with the one before hold its values as well: they were written twice.
fn repeats_rows(log: &Log, steps: &[f64]) -> bool {
    let (mut shared, mut equal) = (0_usize, 0_usize);
    for (k, _) in steps.iter().enumerate().filter(|(_, s)| **s == 0.0) {
        shared += 1;
        equal += usize::from(log.columns.iter().all(|c| c.get(k) == c.get(k + 1)));
    }
    !log.columns.is_empty() && 2 * equal > shared
}

/// Rows from one repeated stamp to the next where a logger repeats them by count.
const BY_COUNT: std::ops::RangeInclusive<usize> = 10..=100;

/// True where stamps are repeated as no rounding repeats them: in one part of the log and not in the rest, or to the row
/// by count all along, where the rate would stand to the grid as n to n − 1. Rounding spreads them over the whole log,
/// and two clocks drift past each other.
fn is_doubled(steps: &[f64]) -> bool {
    let zeros: Vec<usize> = (0..steps.len()).filter(|k| steps[*k] == 0.0).collect();
    if zeros.len() < 30 {
        return false;
    }
    let Some(usual) = crate::clock::usual(steps) else {
        return false;
    };
    let is_even = |s: &&f64| **s == 0.0 || (**s - usual).abs() < 0.2 * usual;
    if 10 * steps.iter().filter(is_even).count() < 9 * steps.len() {
        return false;
    }
    let mut apart: Vec<f64> = zeros.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
    let period = apart[0];
    if BY_COUNT.contains(&(period as usize)) && apart.iter().all(|n| *n == period) {
        return true;
    }
    // What is free of them for longer than 64 rows is another part.
    let ends = [zeros[0], steps.len() - zeros[zeros.len() - 1]];
    let free: f64 = apart
        .iter()
        .copied()
        .chain(ends.map(|n| n as f64))
        .filter(|n| *n > 64.0)
        .sum();
    let is_dense = median(&mut apart).is_some_and(|n| n <= 3.0);
    is_dense && free > 0.1 * steps.len() as f64
}

/// The shortest step that may be a gap: 1.5·dt; where stamps arrive in bursts three times the usual pause between them.
fn pause(steps: &[f64], dt: f64) -> f64 {
    let mut positive: Vec<f64> = steps.iter().copied().filter(|s| *s > 0.0).collect();
    let middle = median(&mut positive).unwrap_or(dt);
    if middle > 0.75 * dt {
        return 1.5 * dt;
    }
    // Of 95 % of the steps none is longer.
    let at = (positive.len() - 1).min((0.95 * positive.len() as f64) as usize);
    let (_, &mut usual, _) = positive.select_nth_unstable_by(at, f64::total_cmp);
    (3.0 * usual).max(1.5 * dt)
}

/// The grid that all steps lie on, in seconds; 0 where there is none coarser than 1 ns.
fn resolution(steps: &[f64], dt: f64) -> f64 {
    let mut gcd: u64 = 0;
    for s in steps.iter().take(100_000) {
        let ns = s.abs() * 1e9;
        if !(ns.is_finite() && ns < 9e15) {
            continue;
        }
        let mut a = ns.round() as u64;
        while a != 0 {
            (gcd, a) = (a, gcd % a);
        }
        if gcd == 1 {
            return 1e-9;
        }
    }
    // A perfectly even clock has no resolution to explain anything with.
    let found = gcd as f64 * 1e-9;
    if found > 0.9 * dt {
        if found < 1.1 * dt { 0.0 } else { found }
    } else {
        found
    }
}
