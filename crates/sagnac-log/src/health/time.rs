//! The clock of a log: gaps, duplicates, jumps back, jitter.
//!
//! A step is off where it is more than 1.5·dt; a late stamp whose successors catch up is jitter, no gap: the stamps
//! less k·dt have to stay away.

use super::clean::Gap;
use super::found::{Found, Said};
use crate::beat::{Beat, COUNTS, Event, SCATTERED};
use crate::{Error, Issue, IssueKind, Log, Stamp};

/// The clock of a log.
pub(crate) struct Clock<'a> {
    pub(crate) log: &'a Log,
    pub(crate) dt_s: f64,
    pub(crate) beat: Beat,
    /// The first row whose stamp counts: times count from it.
    origin: usize,
}

impl<'a> Clock<'a> {
    pub(crate) fn of(log: &'a Log) -> Result<Self, Error> {
        Self::of_section(log, None)
    }

    /// The clock of a section whose stamps may never advance; `known_s` is the interval of the sections before.
    pub(super) fn of_section(log: &'a Log, known_s: Option<f64>) -> Result<Self, Error> {
        let beat = Beat::of(log);
        let own = log.dt_of(&beat);
        let mut clock = Self {
            log,
            dt_s: own.or_else(|error| known_s.ok_or(error))?,
            beat,
            origin: 0,
        };
        clock.origin = (0..log.stamps.len())
            .find(|&row| clock.counts(row))
            .unwrap_or(0);
        Ok(clock)
    }

    /// True where the stamp of a row is a number and no wrong one.
    fn counts(&self, row: usize) -> bool {
        let stamp = self.log.stamps.get(row);
        stamp.is_some_and(|t| t.seconds().is_finite())
            && self.beat.wild.binary_search(&row).is_err()
    }

    /// Time of a row from the first one, wraps undone.
    pub(crate) fn seconds(&self, row: usize) -> f64 {
        let added: f64 = self
            .beat
            .wraps
            .iter()
            .take_while(|w| w.0 <= row)
            .map(|w| w.1)
            .sum();
        self.plain_seconds(row) + added
    }

    /// The stamp of a row that is a number: its own, or one that follows the last before it on the grid.
    fn plain_seconds(&self, row: usize) -> f64 {
        let Some(origin) = self.log.stamps.get(self.origin) else {
            return self.log.time_s(row);
        };
        let before = (self.origin..=row).rev();
        let known = before
            .filter(|k| self.counts(*k))
            .find_map(|k| Some((k, self.log.stamps.get(k)?.since(origin))));
        let (at, seconds) = known.unwrap_or((self.origin, 0.0));
        seconds + self.dt_s * (self.origin as f64 + row as f64 - at as f64)
    }

    /// Time of a row on the log's own clock.
    pub(crate) fn absolute(&self, row: usize) -> f64 {
        match self.log.stamps.get(self.origin) {
            Some(_) if !self.counts(self.origin) => row as f64 * self.dt_s,
            Some(first) => first.seconds() - self.origin as f64 * self.dt_s + self.seconds(row),
            None => self.log.time_s(row),
        }
    }

    pub(crate) fn duration_s(&self) -> f64 {
        if self.log.stamps.is_empty() || self.log.layout.rate_hz.is_some() {
            return self.log.rows as f64 * self.dt_s;
        }
        self.span_s(0, self.log.rows.saturating_sub(1)) + self.dt_s
    }

    /// Time from row `from` to row `to`.
    pub(super) fn span_s(&self, from: usize, to: usize) -> f64 {
        if self.log.stamps.is_empty() || self.log.layout.rate_hz.is_some() {
            return (to - from) as f64 * self.dt_s;
        }
        // What lies between jumps back adds up, each stretch with its own last interval.
        let mut start = from;
        let mut span_s = 0.0;
        // Stamps that scatter may go back by less than an interval: the stretch goes on.
        let back = |e: &&(usize, Event)| {
            e.1 == Event::Backwards && self.seconds(e.0 - 1) - self.seconds(e.0) > self.dt_s
        };
        let inside = |row: &usize| (from + 1..=to).contains(row);
        let rows = self.beat.events.iter().filter(back).map(|e| e.0);
        for row in rows.filter(inside) {
            span_s += self.seconds(row - 1) - self.seconds(start) + self.dt_s;
            start = row;
        }
        span_s + self.seconds(to) - self.seconds(start)
    }
}

/// The findings about time; `gaps` says what becomes of each gap.
pub(super) fn issues(clock: &Clock<'_>, gaps: &[Gap]) -> Vec<Found> {
    let mut out = Vec::new();
    let mut gaps = gaps.iter();
    let last = clock.log.rows.saturating_sub(1);
    let issue = |kind, from: usize, to: usize, count, text| Issue {
        kind,
        channel: Some("time".to_owned()),
        start_s: clock.absolute(from),
        end_s: clock.absolute(to),
        count,
        text,
    };
    let mut push = |kind, from: usize, to: usize, count, text| {
        let issue = issue(kind, from, to, count, text);
        out.push(Found::event(issue, from..to + 1));
    };
    for &(row, event) in &clock.beat.events {
        match event {
            Event::Gap(lost) => {
                let what = match gaps.next() {
                    Some(Gap::Filled) => "filled by a line",
                    Some(Gap::FilledForParameters) => "filled by a line for parameters",
                    _ => "cut here",
                };
                let samples = if lost == 1 { "sample" } else { "samples" };
                push(
                    IssueKind::Gap,
                    row - 1,
                    row,
                    lost,
                    format!("{lost} {samples} lost; {what}"),
                );
            }
            Event::Duplicate => {
                push(
                    IssueKind::Duplicate,
                    row,
                    row,
                    1,
                    "a stamp equal to the one before; dropped".to_owned(),
                );
            }
            Event::Backwards => {
                let back = clock.seconds(row - 1) - clock.seconds(row);
                let text = format!("time goes back by {back:.6} s; cut here");
                push(IssueKind::Backwards, row, row, 1, text);
            }
        }
    }
    for &(row, turn) in &clock.beat.wraps {
        let unit = turn / COUNTS;
        let text = format!("the counter wraps at 2^32 of {unit:e} s ({turn:.6} s); undone");
        push(IssueKind::Backwards, row - 1, row, 1, text);
    }
    for &row in &clock.beat.wild {
        let stamp = clock.log.stamps.get(row).map_or(f64::NAN, Stamp::seconds);
        // The last stamp far ahead is the only one after which time does not go back.
        let is_ahead = row == last && clock.seconds(row) < stamp - clock.absolute(0);
        let kind = if is_ahead {
            IssueKind::Jitter
        } else {
            IssueKind::Backwards
        };
        let text = format!(
            "the stamp of row {} is {stamp:?} s, far from its neighbors: taken as one interval after the row before",
            row + 1
        );
        push(kind, row, row, 1, text);
    }
    if clock.beat.dt_s.is_none() && last > 0 && clock.counts(last) {
        let text = "time never advances: the rate that was given counts, nothing is dropped";
        let never = issue(IssueKind::Duplicate, 0, last, last as u64, text.to_owned());
        out.push(Found::run(never, 0..last + 1, Said::Once));
    }
    let is_none = |row: &usize| {
        let stamp = clock.log.stamps.get(*row);
        stamp.is_some_and(|t| !t.seconds().is_finite())
    };
    let none: Vec<usize> = (0..clock.log.rows).filter(is_none).collect();
    for run in none.chunk_by(|a, b| a + 1 == *b) {
        let (from, to, count) = (run[0], run[run.len() - 1], run.len() as u64);
        let none = issue(IssueKind::Nan, from, to, count, no_stamps(count));
        out.push(Found::run(none, from..to + 1, Said::Count(no_stamps)));
    }
    if let Some((many, scatter)) = clock.beat.jitter {
        // Scatter concerns every row, steps that are far off themselves alone.
        let count = if scatter > SCATTERED {
            clock.log.rows as u64
        } else {
            many.max(1)
        };
        let uneven = issue(IssueKind::Jitter, 0, last, count, uneven(many, scatter));
        out.push(Found::run(
            uneven,
            0..last + 1,
            Said::Jitter { many, scatter },
        ));
    }
    out
}

fn no_stamps(count: u64) -> String {
    match count {
        1 => "the stamp is no number; taken as equally spaced".to_owned(),
        n => format!("{n} stamps are no numbers; taken as equally spaced"),
    }
}

/// What is said of an uneven clock.
pub(super) fn uneven(many: u64, scatter: f64) -> String {
    format!(
        "steps scatter by {:.1} % of dt, {many} are off by more than 20 %; taken as equally spaced",
        100.0 * scatter
    )
}
