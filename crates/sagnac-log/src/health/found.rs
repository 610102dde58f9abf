//! Findings with the rows that they are about, so that a section of a log tells of its own rows alone.

use std::ops::Range;

use super::time::Clock;
use crate::Issue;

/// A finding on its way to the list.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) issue: Issue,
    pub(crate) rows: Range<usize>,
    pub(crate) extent: Extent,
    pub(crate) said: Said,
    /// Whether it began in the section before.
    pub(crate) continues: bool,
}

/// What becomes of a finding of which a section owns a part of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// It happens at its last row and belongs to the section that owns that one.
    Event,
    /// All its rows are alike: each section tells of its own.
    Run,
}

/// How its sentence follows from its numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Said {
    /// Not at all: it stands.
    Once,
    /// From the samples concerned.
    Count(fn(u64) -> String),
    /// An extreme value of the channel, which a later section may pass.
    Saturated {
        /// The value.
        limit: f64,
        /// Whether it is the largest, or the smallest.
        is_largest: bool,
    },
    /// An uneven clock: steps that are far off, and the scatter of the steps over dt.
    Jitter {
        /// Steps off by more than 20 %.
        many: u64,
        /// Robust scatter over dt.
        scatter: f64,
    },
}

impl Found {
    /// What happens at the last of `rows`.
    pub(crate) fn event(issue: Issue, rows: Range<usize>) -> Self {
        Self {
            issue,
            rows,
            extent: Extent::Event,
            said: Said::Once,
            continues: false,
        }
    }

    /// What is the same on all of `rows`.
    pub(crate) fn run(issue: Issue, rows: Range<usize>, said: Said) -> Self {
        Self {
            extent: Extent::Run,
            said,
            ..Self::event(issue, rows)
        }
    }

    /// What of it lies in the rows `own`.
    pub(super) fn within(mut self, own: &Range<usize>, clock: &Clock<'_>) -> Option<Self> {
        if self.extent == Extent::Event {
            let last = self.rows.end.saturating_sub(1);
            return own.contains(&last).then_some(self);
        }
        let rows = self.rows.start.max(own.start)..self.rows.end.min(own.end);
        if rows.is_empty() {
            return None;
        }
        if rows != self.rows {
            // As many as there are rows, or one in every so many.
            let share = rows.len() as f64 / self.rows.len() as f64;
            let part = |count: u64| ((count as f64 * share).round() as u64).max(1);
            self.issue.count = part(self.issue.count);
            if let Said::Jitter { many, .. } = &mut self.said {
                *many = part(*many);
            }
            self.issue.start_s = clock.absolute(rows.start);
            self.issue.end_s = clock.absolute(rows.end - 1);
            self.continues = rows.start > self.rows.start;
            self.rows = rows;
            self.say();
        }
        Some(self)
    }

    /// Its sentence, after its count changed.
    pub(super) fn say(&mut self) {
        match self.said {
            Said::Count(text) => self.issue.text = text(self.issue.count),
            Said::Jitter { many, scatter } => self.issue.text = super::time::uneven(many, scatter),
            Said::Once | Said::Saturated { .. } => {}
        }
    }

    /// Takes in `next`, which goes on where this one stopped.
    pub(super) fn go_on(&mut self, next: &Self) {
        let (own, more) = (self.issue.count as f64, next.issue.count as f64);
        self.issue.end_s = self.issue.end_s.max(next.issue.end_s);
        self.issue.count += next.issue.count;
        if let (
            Said::Jitter { many, scatter },
            Said::Jitter {
                many: others,
                scatter: other,
            },
        ) = (&mut self.said, next.said)
        {
            *many += others;
            *scatter = (*scatter * own + other * more) / (own + more);
        }
        self.say();
    }
}
