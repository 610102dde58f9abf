//! Channels with a value in every k-th row alone, as a slower sensor in a faster log leaves them.
//!
//! Such a channel is taken at its own interval k·dt: k is the usual distance between rows with a value.

use std::ops::Range;

use super::found::Found;
use super::time::Clock;
use crate::{Issue, IssueKind};

/// Longest distance that is looked for.
const MOST: usize = 1000;
/// Share of the distances that are k.
const USUAL: f64 = 0.75;
/// Fewest values.
const FEWEST: usize = 64;

/// The values of a channel that has one in every k-th row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Thin {
    /// k.
    pub(crate) every: usize,
    /// Whether lines join the values on the log's grid (a temperature), instead of a grid of their own.
    pub(crate) is_joined: bool,
    /// Rows with a value, and the values.
    pub(crate) rows: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

/// A thin channel's own grid: the log's positions that it has, stretch by stretch.
pub(crate) struct OwnGrid {
    every: usize,
    /// First index, first position of the log's grid and number of each stretch between cuts.
    stretches: Vec<(usize, usize, usize)>,
}

impl Thin {
    /// The values, where they come in every k-th row, k ≥ 2.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        if values.iter().take(4 * MOST).all(|v| v.is_finite()) {
            return None;
        }
        let rows: Vec<usize> = (0..values.len())
            .filter(|&k| values[k].is_finite())
            .collect();
        if rows.len() < FEWEST || 10 * rows.len() > 7 * values.len() {
            return None;
        }
        let mut count = vec![0_usize; MOST + 1];
        for pair in rows.windows(2) {
            count[(pair[1] - pair[0]).min(MOST)] += 1;
        }
        let every = (1..MOST).max_by_key(|&k| count[k])?;
        (every >= 2 && count[every] as f64 >= USUAL * (rows.len() - 1) as f64).then(|| Self {
            every,
            is_joined: false,
            values: rows.iter().map(|&k| values[k]).collect(),
            rows,
        })
    }

    /// Rows of a range of the values.
    pub(crate) fn rows_of(&self, range: &Range<usize>) -> Range<usize> {
        match (
            self.rows.get(range.start),
            self.rows.get(range.end.max(1) - 1),
        ) {
            (Some(&a), Some(&b)) => a..b + 1,
            _ => 0..0,
        }
    }

    /// Values that are missing at the channel's own interval, with the rows between which they are.
    pub(crate) fn lost(&self) -> impl Iterator<Item = (Range<usize>, usize)> + '_ {
        self.rows.windows(2).filter_map(|pair| {
            // A row that is missing is a gap, told by itself: it leaves less than two intervals.
            let steps = (pair[1] - pair[0]) / self.every;
            (steps > 1).then(|| (pair[0]..pair[1] + 1, steps - 1))
        })
    }

    /// Its own grid among the positions of the log's, which `cuts` part.
    pub(crate) fn on(&self, all: &[f64], cuts: &[usize]) -> OwnGrid {
        let mut stretches = Vec::new();
        let mut next = 0;
        let mut edges: Vec<usize> = cuts.iter().copied().filter(|c| *c > 0).collect();
        edges.push(all.len());
        let mut from = 0;
        for to in edges {
            // The phase that most values have.
            let mut count = vec![0_usize; self.every];
            for k in from..to {
                if all[k].is_finite() {
                    count[(k - from) % self.every] += 1;
                }
            }
            let phase = (0..self.every).max_by_key(|&p| (count[p], self.every - p));
            let first = from + phase.unwrap_or(0);
            let number = to.saturating_sub(first).div_ceil(self.every);
            stretches.push((next, first, number));
            next += number;
            from = to;
        }
        OwnGrid {
            every: self.every,
            stretches,
        }
    }
}

impl OwnGrid {
    /// Position in the log's grid of an index.
    pub(crate) fn place(&self, index: usize) -> usize {
        let k = self.stretches.partition_point(|s| s.0 <= index).max(1) - 1;
        let (next, first, _) = self.stretches[k];
        first + (index - next) * self.every
    }

    /// The first index at or after a position.
    fn index(&self, place: usize) -> usize {
        for &(next, first, number) in self.stretches.iter().rev() {
            if place + self.every > first || next == 0 {
                return next + place.saturating_sub(first).div_ceil(self.every).min(number);
            }
        }
        0
    }

    /// Indices of a range of positions.
    pub(crate) fn range(&self, places: &Range<usize>) -> Range<usize> {
        self.index(places.start)..self.index(places.end)
    }

    /// Where a stretch begins anew.
    pub(crate) fn cuts(&self) -> Vec<usize> {
        self.stretches
            .iter()
            .map(|s| s.0)
            .filter(|c| *c > 0)
            .collect()
    }

    /// The values at its positions.
    pub(crate) fn values(&self, all: &[f64]) -> Vec<f64> {
        self.stretches
            .iter()
            .flat_map(|&(_, first, number)| (0..number).map(move |i| first + i * self.every))
            .map(|k| all.get(k).copied().unwrap_or(f64::NAN))
            .collect()
    }
}

/// How the finding of a channel with a value in every k-th row begins.
const BEGINS: &str = "a value in every ";
/// How it ends.
const ENDS: &str = " rows have none";

/// Says that a channel is taken at its own interval: the rows without a value are a finding, those that lines join (a
/// temperature) lose nothing and are a note.
pub(super) fn remark(
    name: &str,
    thin: &Thin,
    (clock, own): (&Clock<'_>, &Range<usize>),
    (issues, notes): (&mut Vec<Found>, &mut Vec<String>),
) {
    let every = ordinal(thin.every);
    if thin.is_joined {
        notes.push(format!("{name}: {BEGINS}{every} row, joined by lines"));
        return;
    }
    let is_own = |row: &&usize| own.contains(row);
    let lost: usize = thin
        .lost()
        .filter(|(rows, _)| own.contains(&(rows.end - 1)))
        .map(|l| l.1)
        .sum();
    let empty = (own.len() - thin.rows.iter().filter(is_own).count()).saturating_sub(lost);
    let rate = format!("{:.6}", 1.0 / (clock.dt_s * thin.every as f64));
    let rate = rate.trim_end_matches('0').trim_end_matches('.');
    let issue = Issue {
        kind: IssueKind::Nan,
        channel: Some(name.to_owned()),
        start_s: clock.absolute(own.start),
        end_s: clock.absolute(own.end.saturating_sub(1)),
        count: empty as u64,
        text: format!("{BEGINS}{every} row alone, taken at {rate} Hz; {empty}{ENDS}"),
    };
    issues.push(Found::event(issue, own.clone()));
}

/// Whether a finding is that of a channel with a value in every k-th row.
pub(super) fn is_thin(issue: &Issue) -> bool {
    issue.text.starts_with(BEGINS) && issue.text.ends_with(ENDS)
}

/// Adds such a finding to those of other channels, or to that of its own channel in the sections before.
pub(super) fn join(known: &mut Vec<Issue>, issue: Issue) {
    let Some(known) = known.iter_mut().find(|o| o.channel == issue.channel) else {
        known.push(issue);
        return;
    };
    known.end_s = known.end_s.max(issue.end_s);
    known.count += issue.count;
    if let Some((begin, _)) = known.text.rsplit_once("; ") {
        known.text = format!("{begin}; {}{ENDS}", known.count);
    }
}

fn ordinal(n: usize) -> String {
    let end = match (n % 10, n % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{n}{end}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn every(k: usize, phase: usize, n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| if i % k == phase { i as f64 } else { f64::NAN })
            .collect()
    }

    #[test]
    fn every_kth_value_is_seen_and_scattered_losses_are_not() {
        for (k, phase) in [(2, 0), (2, 1), (5, 3)] {
            let mut values = every(k, phase, 1000);
            values[40 * k + phase] = f64::NAN;
            let thin = Thin::of(&values).unwrap();
            assert_eq!(thin.every, k);
            assert_eq!(thin.lost().map(|l| l.1).sum::<usize>(), 1);
            let own = thin.on(&values, &[]);
            assert_eq!(own.values(&values).len(), 1000 / k);
            assert_eq!(own.place(7), 7 * k + phase);
            assert_eq!(own.range(&(7 * k + phase..9 * k + phase)), 7..9);
        }
        let scattered: Vec<f64> = (0..1000_u32)
            .map(|i| if i * 7919 % 1009 < 500 { f64::NAN } else { 1.0 })
            .collect();
        assert!(Thin::of(&scattered).is_none());
        assert!(Thin::of(&vec![1.0; 5000]).is_none());
    }

    #[test]
    fn a_stretch_after_a_cut_has_its_own_phase() {
        let mut values = every(2, 0, 400);
        values.extend(every(2, 1, 401));
        let thin = Thin::of(&values).unwrap();
        let own = thin.on(&values, &[400]);
        assert_eq!(own.cuts(), [200]);
        assert_eq!((own.place(199), own.place(200)), (398, 401));
        assert!(own.values(&values).iter().all(|v| v.is_finite()));
    }
}
