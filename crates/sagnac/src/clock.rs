//! The time of every row of a log, and what is odd about its stamps: gaps, repeats, steps back.
//!
//! Where a rate was given that overrides the stamps, a row is one interval of that rate, and a gap
//! as many as it is long in the interval of the stamps; the times written are those then. Where stamps are coarser than the
//! interval, or come in bursts, a row is one interval as well, but the stamps are kept.

use sagnac_log::{Block, Cadence, Layout, Stamp, Stamps};
use sagnac_report::text::{clock, duration, general, group_thousands};

/// The interval of stamps that the rate given beside them overrides; dt itself where they never rise, `None` where the
/// stamps count.
pub(crate) fn overridden_dt_s(layout: &Layout, first: &Block) -> Option<f64> {
    let rate_hz = layout.rate_hz.filter(|_| layout.has_time)?;
    Some(Cadence::of(&first.stamps).map_or(1.0 / rate_hz, |cadence| cadence.dt_s))
}

/// Times of a log by the rate that was given beside its stamps.
pub(crate) struct GivenRate {
    rate_hz: f64,
    clock: Option<RowClock>,
    /// Of the last row, from the first.
    pub(crate) last_s: f64,
}

impl GivenRate {
    /// `None` where the stamps count, or there are none.
    pub(crate) fn of(layout: &Layout) -> Option<Self> {
        let rate_hz = layout.rate_hz.filter(|_| layout.has_time)?;
        Some(Self {
            rate_hz,
            clock: None,
            last_s: 0.0,
        })
    }

    /// The stamps of the next rows.
    pub(crate) fn stamps(&mut self, read: &Stamps) -> Stamps {
        let dt_s = 1.0 / self.rate_hz;
        let clock = self.clock.get_or_insert_with(|| {
            let cadence = Cadence::of(read);
            RowClock::new(dt_s, Some(cadence.map_or(dt_s, |c| c.dt_s)), cadence)
        });
        let mut out = Stamps::default();
        for k in 0..read.len() {
            let stamp = read.get(k);
            self.last_s = clock.next(stamp);
            if let Some(stamp) = clock.written(stamp, self.last_s) {
                out.push(stamp);
            }
        }
        out
    }

    /// The sentence on it.
    pub(crate) fn note(&self) -> Option<String> {
        self.clock.as_ref().and_then(RowClock::note)
    }
}

/// One kind of oddity: how often, and the first.
#[derive(Debug, Clone, Default, PartialEq)]
struct Odd {
    count: u64,
    /// Row from 1, time of the row before from the first one, and length, s.
    first: Option<(u64, f64, f64)>,
}

impl Odd {
    fn add(&mut self, row: u64, time_s: f64, length_s: f64) {
        self.count += 1;
        self.first.get_or_insert((row, time_s, length_s));
    }
}

/// Times of rows in their order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RowClock {
    dt_s: f64,
    /// Interval of stamps that a rate overrides.
    overridden_dt_s: Option<f64>,
    /// What the first stamps tell of all of them.
    cadence: Option<Cadence>,
    origin: Option<Stamp>,
    last_s: f64,
    was_back: bool,
    /// Rows in a row with the stamp of the one before, or none.
    repeated: f64,
    rows: u64,
    /// Intervals of dt in gaps, where the stamps are overridden.
    skipped: f64,
    gaps: Odd,
    repeats: Odd,
    back: Odd,
    no_number: Odd,
}

impl RowClock {
    pub(crate) fn new(dt_s: f64, overridden_dt_s: Option<f64>, cadence: Option<Cadence>) -> Self {
        Self {
            dt_s,
            overridden_dt_s,
            cadence,
            origin: None,
            last_s: 0.0,
            was_back: false,
            repeated: 0.0,
            rows: 0,
            skipped: 0.0,
            gaps: Odd::default(),
            repeats: Odd::default(),
            back: Odd::default(),
            no_number: Odd::default(),
        }
    }

    /// Whether stamps are too coarse, or too bunched, to tell when a row was measured.
    fn is_uneven(&self) -> bool {
        self.cadence
            .is_some_and(|c| c.is_coarse || c.longest_s > 1.6 * c.dt_s)
    }

    /// Time of the next row from the first one, s; it does not depend on dt where the stamps count.
    pub(crate) fn next(&mut self, stamp: Option<Stamp>) -> f64 {
        self.rows += 1;
        let counted = |rows: u64, skipped: f64| (rows as f64 + skipped) * self.dt_s;
        let Some(stamp) = stamp else {
            return counted(self.rows - 1, self.skipped);
        };
        let at_s = stamp.since(self.origin.unwrap_or(stamp));
        if !at_s.is_finite() {
            self.no_number.add(self.rows, self.last_s, 0.0);
            // It counts as one interval: the next stamp is so much later without a gap.
            self.repeated += f64::from(u8::from(self.origin.is_some()));
            return if self.is_counted() {
                counted(self.rows - 1, self.skipped)
            } else {
                self.last_s
            };
        }
        let is_first = self.origin.is_none();
        self.origin.get_or_insert(stamp);
        let unit_s = self.overridden_dt_s.unwrap_or(self.dt_s);
        let step_s = at_s - self.last_s;
        if !is_first {
            let (row, before_s) = (self.rows, self.last_s);
            let is_uneven = self.is_uneven();
            let longest_s = match self.cadence {
                Some(cadence) if is_uneven => cadence.longest_s,
                _ => (1.5 + self.repeated) * unit_s,
            };
            // The way forward after a step back, or after repeats, is no gap.
            if step_s > longest_s && !self.was_back {
                self.gaps.add(row, before_s, step_s);
                self.skipped = if is_uneven {
                    (at_s / unit_s - (self.rows - 1) as f64).max(self.skipped)
                } else {
                    self.skipped + step_s / unit_s - 1.0 - self.repeated
                };
            } else if step_s == 0.0 {
                if !is_uneven {
                    self.repeats.add(row, before_s, 0.0);
                }
            } else if step_s < 0.0 {
                self.back.add(row, before_s, -step_s);
            }
            self.was_back = step_s < 0.0;
            self.repeated = if step_s == 0.0 {
                self.repeated + 1.0
            } else {
                0.0
            };
        }
        self.last_s = at_s;
        if self.is_counted() {
            counted(self.rows - 1, self.skipped)
        } else {
            at_s
        }
    }

    /// Whether a row is one interval, whatever its stamp.
    fn is_counted(&self) -> bool {
        self.overridden_dt_s.is_some() || self.is_uneven()
    }

    /// The first row, from 1, whose stamp is no finite number, where the stamps count.
    pub(crate) fn first_without_number(&self) -> Option<u64> {
        let first = self.no_number.first.map(|(row, _, _)| row);
        first.filter(|_| self.overridden_dt_s.is_none())
    }

    /// The stamp to write for a row that was read with `stamp` and is `at_s` after the first.
    pub(crate) fn written(&self, stamp: Option<Stamp>, at_s: f64) -> Option<Stamp> {
        if self.overridden_dt_s.is_none() {
            return stamp;
        }
        let origin = self.origin.unwrap_or(Stamp::Nanoseconds(0));
        let ns = match origin {
            Stamp::Nanoseconds(ns) => Some(ns),
            Stamp::Seconds(s) => Some(s * 1e9)
                .filter(|ns| ns.abs() < 9e15)
                .map(|ns| ns as i64),
        };
        // Intervals that whole nanoseconds would show uneven stay in seconds.
        let is_fine = self.dt_s < 1e-6;
        Some(match ns.filter(|_| !is_fine && at_s < 9e9) {
            Some(ns) => Stamp::Nanoseconds(ns.saturating_add((at_s * 1e9).round() as i64)),
            None => Stamp::Seconds(origin.seconds() + at_s),
        })
    }

    /// The sentence on times that are written in place of the stamps.
    pub(crate) fn note(&self) -> Option<String> {
        self.overridden_dt_s.map(|_| {
            format!(
                "the times written count from the first time stamp at {} Hz, as --rate says",
                general(1.0 / self.dt_s, 6)
            )
        })
    }

    /// A sentence a kind of oddity; `goes_on` says what is done about it.
    pub(crate) fn sentences(&self, log: &str, goes_on: &str) -> Vec<String> {
        let many = |odd: &Odd, one: &str| match odd.count {
            1 => format!("1 {one}"),
            n => format!("{} {one}s", group_thousands(&n.to_string())),
        };
        let mut out = Vec::new();
        if let Some((_, time_s, length_s)) = self.gaps.first {
            let first = if self.gaps.count == 1 {
                ""
            } else {
                "the first "
            };
            out.push(format!(
                "{log} has {}, {first}of {} at {}: nothing is filled in, {goes_on}",
                many(&self.gaps, "gap"),
                duration(length_s),
                clock(time_s)
            ));
        }
        if self.overridden_dt_s.is_some() {
            return out;
        }
        if self.is_uneven() {
            let how = if self.cadence.is_some_and(|c| c.is_coarse) {
                "go in steps coarser than its interval"
            } else {
                "come in bursts"
            };
            out.push(format!(
                "the time stamps of {log} {how}: each row counts as one interval at {} Hz and keeps its stamp; give --rate if you know it",
                general(1.0 / self.dt_s, 5)
            ));
        }
        if let Some((row, time_s, _)) = self.no_number.first {
            let first = if self.no_number.count == 1 {
                ""
            } else {
                "the first "
            };
            out.push(format!(
                "{log} has {} no finite number, {first}in row {} after {}: {goes_on}",
                match self.no_number.count {
                    1 => "1 time stamp that is".to_owned(),
                    n => format!("{} time stamps that are", group_thousands(&n.to_string())),
                },
                group_thousands(&row.to_string()),
                clock(time_s)
            ));
        }
        for (odd, kind) in [(&self.repeats, "equal to"), (&self.back, "earlier than")] {
            if let Some((row, time_s, _)) = odd.first {
                let first = if odd.count == 1 { "" } else { "the first " };
                out.push(format!(
                    "{log} has {} {kind} the one before, {first}in row {} at {}: each row counts as one interval, {goes_on}",
                    many(odd, "time stamp"),
                    group_thousands(&row.to_string()),
                    clock(time_s)
                ));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(clock: &mut RowClock, times: &[f64]) -> Vec<f64> {
        times
            .iter()
            .map(|t| clock.next(Some(Stamp::Seconds(*t))))
            .collect()
    }

    #[test]
    fn gaps_repeats_and_steps_back_are_told_apart() {
        let mut rows = RowClock::new(1.0, None, None);
        let times = run(&mut rows, &[5.0, 6.0, 6.0, 8.0, 13.0, 4.0, 13.0, 14.0]);
        assert_eq!(times, [0.0, 1.0, 1.0, 3.0, 8.0, -1.0, 8.0, 9.0]);
        let said = rows.sentences("the log", "noise goes on");
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(said[0].starts_with("the log has 1 gap, of 5 s"), "{said:?}");
        assert!(said[1].contains("1 time stamp equal to the one before, in row 3"));
        assert!(said[2].contains("1 time stamp earlier than the one before, in row 6"));
    }

    #[test]
    fn coarse_stamps_are_neither_repeats_nor_gaps() {
        // 100 Hz in whole seconds, 500 samples lost.
        let times: Vec<f64> = (0..3000)
            .map(|k| if k < 2000 { k } else { k + 500 })
            .map(|k| f64::from(k / 100))
            .collect();
        let cadence = Cadence::of(&Stamps::Seconds(times[..1500].to_vec()));
        let dt_s = cadence.map_or(0.0, |c| c.dt_s);
        assert!((dt_s / 0.01 - 1.0).abs() < 1e-9, "{dt_s}");
        let mut rows = RowClock::new(dt_s, None, cadence);
        let found = run(&mut rows, &times);
        assert!((found[1999] - 19.99).abs() < 0.5 && (found[2999] - 34.99).abs() < 1.0);
        let said = rows.sentences("the log", "x");
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[0].contains("1 gap") && said[1].contains("coarser"),
            "{said:?}"
        );
        assert_eq!(
            rows.written(Some(Stamp::Seconds(7.0)), 7.5),
            Some(Stamp::Seconds(7.0))
        );
    }

    #[test]
    fn stamps_that_are_no_numbers_hide_no_gap() {
        let mut rows = RowClock::new(1.0, None, None);
        let times = run(&mut rows, &[f64::NAN, 5.0, 6.0, f64::NAN, 15.0]);
        assert_eq!(times, [0.0, 0.0, 1.0, 1.0, 10.0]);
        assert_eq!(rows.first_without_number(), Some(1));
        let said = rows.sentences("the log", "noise goes on");
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[1].contains("2 time stamps that are no finite number, the first in row 1"));
    }

    #[test]
    fn a_rate_overrides_the_stamps_but_not_their_gaps() {
        let mut rows = RowClock::new(0.1, Some(1.0), None);
        let times = run(&mut rows, &[0.0, 1.0, 2.0, 5.0, 6.0]);
        for (time, want) in times.iter().zip([0.0, 0.1, 0.2, 0.5, 0.6]) {
            assert!((time - want).abs() < 1e-12, "{times:?}");
        }
        assert_eq!(rows.sentences("x", "y").len(), 1);
        // A stamp that is no number, or repeated, is one interval and makes no gap.
        let mut rows = RowClock::new(0.1, Some(1.0), None);
        let times = run(&mut rows, &[0.0, f64::NAN, 2.0, 2.0, 4.0, 8.0]);
        for (time, want) in times.iter().zip([0.0, 0.1, 0.2, 0.3, 0.4, 0.8]) {
            assert!((time - want).abs() < 1e-12, "{times:?}");
        }
        assert_eq!(rows.sentences("x", "y").len(), 1);
        let written = rows.written(None, times[5]);
        assert_eq!(written, Some(Stamp::Nanoseconds(800_000_000)));
    }
}
