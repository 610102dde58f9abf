//! The clock of a log: gaps, duplicates, jumps back, jitter.
//!
//! A step is off where it is more than 1.5·dt; a late stamp whose successors catch up is jitter, no gap: the stamps
//! less k·dt have to stay away.

use crate::clock::{interval, median, steps};
use crate::{Error, Issue, IssueKind, Log};

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

/// The clock of a log.
pub(crate) struct Clock<'a> {
    pub(crate) log: &'a Log,
    pub(crate) dt_s: f64,
    /// Rows at which something happens, ascending.
    pub(crate) events: Vec<(usize, Event)>,
    /// Rows at which a counter wrapped, with what was added.
    wraps: Vec<(usize, f64)>,
    /// The first row whose stamp is a number: times count from it.
    origin: usize,
    /// Steps off by more than 20 %, and the robust scatter of the steps over dt; `None` where the clock is even.
    jitter: Option<(u64, f64)>,
}

impl<'a> Clock<'a> {
    pub(crate) fn of(log: &'a Log) -> Result<Self, Error> {
        let mut clock = Self {
            log,
            dt_s: 0.0,
            events: Vec::new(),
            wraps: Vec::new(),
            origin: 0,
            jitter: None,
        };
        if log.stamps.is_empty() {
            clock.dt_s = log.dt_s()?;
            return Ok(clock);
        }
        let is_number = |row: &usize| {
            let stamp = log.stamps.get(*row);
            stamp.is_some_and(|t| t.seconds().is_finite())
        };
        clock.origin = (0..log.rows).find(is_number).unwrap_or(0);
        let mut steps = steps(&log.stamps);
        clock.undo_wraps(&mut steps);
        clock.dt_s = match log.layout.rate_hz {
            Some(rate) => 1.0 / rate,
            None if clock.wraps.is_empty() => log.dt_s()?,
            None => interval(&steps).map_or_else(|| log.dt_s(), Ok)?,
        };
        // The stamps' own interval: a given rate may be another.
        let own = interval(&steps).unwrap_or(clock.dt_s);
        let resolution = resolution(&steps, own);
        clock.judge_jitter(&steps, own, resolution);
        clock.find_events(&steps, own);
        Ok(clock)
    }

    fn undo_wraps(&mut self, steps: &mut [f64]) {
        let Some(unit) = self.log.layout.time_unit_s else {
            return;
        };
        let turn = unit * 4_294_967_296.0;
        let dt = interval(steps).unwrap_or(0.0);
        for (k, step) in steps.iter_mut().enumerate() {
            let undone = *step + turn;
            if *step < 0.0 && undone > 0.0 && undone < (100.0 * dt).min(0.01 * turn).max(2.0 * dt) {
                *step = undone;
                self.wraps.push((k + 1, turn));
            }
        }
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
        if scatter > 0.05 || (many as f64 > 0.01 * n as f64 && many > late / 4) {
            self.jitter = Some((many as u64, scatter));
        }
    }

    fn find_events(&mut self, steps: &[f64], dt: f64) {
        let stays = |k: usize| -> f64 {
            // How far the stamps after row k stay away from those before it, beyond one dt.
            let level = |rows: std::ops::Range<usize>| {
                let mut e: Vec<f64> = rows
                    .map(|j| self.seconds(j) - j as f64 * dt)
                    .filter(|v| v.is_finite())
                    .collect();
                median(&mut e).unwrap_or(f64::NAN)
            };
            let n = steps.len() + 1;
            level(k + 1..(k + 10).min(n)) - level(k.saturating_sub(8)..k + 1)
        };
        let pause = pause(steps, dt);
        let mut events = Vec::new();
        for (k, &s) in steps.iter().enumerate() {
            let event = if s < 0.0 {
                Event::Backwards
            } else if s == 0.0 {
                Event::Duplicate
            } else if s.is_nan() {
                continue;
            } else if s > pause {
                let lost = if self.jitter.is_some() {
                    (stays(k) / dt).round()
                } else {
                    (s / dt).round() - 1.0
                };
                if self.jitter.is_some() && (lost < 1.0 || lost.is_nan()) {
                    continue;
                }
                Event::Gap(lost.clamp(1.0, 1e15) as u64)
            } else {
                continue;
            };
            events.push((k + 1, event));
        }
        self.events = events;
    }

    /// Time of a row from the first one, wraps undone.
    pub(crate) fn seconds(&self, row: usize) -> f64 {
        let added: f64 = self
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
            .filter_map(|k| Some((k, self.log.stamps.get(k)?.since(origin))))
            .find(|(_, t)| t.is_finite());
        let (at, seconds) = known.unwrap_or((self.origin, 0.0));
        seconds + self.dt_s * (self.origin as f64 + row as f64 - at as f64)
    }

    /// Time of a row on the log's own clock.
    pub(crate) fn absolute(&self, row: usize) -> f64 {
        match self.log.stamps.get(self.origin) {
            Some(first) => first.seconds() - self.origin as f64 * self.dt_s + self.seconds(row),
            None => self.log.time_s(row),
        }
    }

    pub(crate) fn duration_s(&self) -> f64 {
        let last = self.log.rows.saturating_sub(1);
        if self.log.stamps.is_empty() || self.log.layout.rate_hz.is_some() {
            return self.log.rows as f64 * self.dt_s;
        }
        // What lies between jumps back adds up, each stretch with its own last interval.
        let mut start = 0;
        let mut span_s = 0.0;
        let back = |e: &&(usize, Event)| e.1 == Event::Backwards;
        for row in self.events.iter().filter(back).map(|e| e.0) {
            span_s += self.seconds(row - 1) - self.seconds(start) + self.dt_s;
            start = row;
        }
        span_s + self.seconds(last) - self.seconds(start) + self.dt_s
    }
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

/// The findings about time.
pub(crate) fn issues(clock: &Clock<'_>) -> Vec<Issue> {
    let mut out = Vec::new();
    let last = clock.log.rows.saturating_sub(1);
    let mut push = |kind, from: usize, to: usize, count, text| {
        let (start_s, end_s) = (clock.absolute(from), clock.absolute(to));
        out.push(Issue {
            kind,
            channel: Some("time".to_owned()),
            start_s,
            end_s,
            count,
            text,
        });
    };
    for &(row, event) in &clock.events {
        match event {
            Event::Gap(lost) => {
                let what = if lost <= 3 {
                    "filled by a line"
                } else {
                    "cut here"
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
    let is_none = |row: &usize| {
        let stamp = clock.log.stamps.get(*row);
        stamp.is_some_and(|t| !t.seconds().is_finite())
    };
    let none: Vec<usize> = (0..clock.log.rows).filter(is_none).collect();
    for run in none.chunk_by(|a, b| a + 1 == *b) {
        let text = format!(
            "{} stamps are no numbers; taken as equally spaced",
            run.len()
        );
        push(
            IssueKind::Nan,
            run[0],
            run[run.len() - 1],
            run.len() as u64,
            text,
        );
    }
    for &(row, turn) in &clock.wraps {
        let unit = clock.log.layout.time_unit_s.unwrap_or(0.0);
        let text = format!("the counter wraps at 2^32 of {unit:e} s ({turn:.6} s); undone");
        push(IssueKind::Backwards, row - 1, row, 1, text);
    }
    if let Some((many, scatter)) = clock.jitter {
        let count = many.max(1);
        let text = format!(
            "steps scatter by {:.1} % of dt, {many} are off by more than 20 %; taken as equally spaced",
            100.0 * scatter
        );
        push(IssueKind::Jitter, 0, last, count, text);
    }
    out
}
