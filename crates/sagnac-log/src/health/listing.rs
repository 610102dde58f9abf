//! Findings as they are listed: neighbors joined, at most 100 of a kind, by kind, channel and time.

use std::collections::BTreeMap;

use super::found::{Found, Said};
use super::{channel, thin};
use crate::{Issue, IssueKind};

/// Listed of one kind at most; the last one of a channel says how many more it has.
const MOST_OF_A_KIND: usize = 100;

/// The list as it grows, in memory that does not grow with the log.
#[derive(Debug, Default)]
pub(super) struct Listing {
    groups: BTreeMap<(IssueKind, Option<String>), Group>,
    /// What is said of a channel as a whole is no neighbor of what is lost in places.
    whole: Vec<Issue>,
}

/// Findings of one kind and channel.
#[derive(Debug, Default)]
struct Group {
    /// The first of them, as many as are ever listed.
    shown: Vec<Found>,
    /// Start and end of the last one, shown or not, and of how many it was made.
    last_s: (f64, f64),
    merged: u64,
    /// Those that are not shown, and where they end.
    more: usize,
    more_end_s: f64,
    /// The smallest and the largest value that is told of as saturated, and the samples that show it.
    limits: [Option<(f64, u64)>; 2],
}

impl Listing {
    /// Adds the findings of a log, or of its next section.
    pub(super) fn add(&mut self, mut found: Vec<Found>, dt_s: f64) {
        // Neighbors are less than 1 s or 10 samples apart.
        let near_s = (10.0 * dt_s).max(1.0);
        found.sort_by(|a, b| a.issue.start_s.total_cmp(&b.issue.start_s));
        for next in found {
            if thin::is_thin(&next.issue) {
                thin::join(&mut self.whole, next.issue);
                continue;
            }
            let key = (next.issue.kind, next.issue.channel.clone());
            self.groups.entry(key).or_default().push(next, near_s);
        }
    }

    /// Drops what is told of some kinds.
    pub(super) fn forget(&mut self, kinds: &[IssueKind]) {
        self.groups.retain(|(kind, _), _| !kinds.contains(kind));
    }

    /// Corrects what sections said of a channel without the others: its numbers, its smallest and largest value.
    pub(super) fn correct(&mut self, channel: &str, numbers: u64, extremes: [f64; 2]) {
        let of_channel = |(key, _): &(&(IssueKind, Option<String>), &mut Group)| {
            key.1.as_deref() == Some(channel)
        };
        for ((kind, _), group) in self.groups.iter_mut().filter(of_channel) {
            match kind {
                IssueKind::Saturation => group.keep_extremes(extremes),
                IssueKind::Stuck => {
                    for f in &mut group.shown {
                        if f.issue.count >= numbers {
                            channel::STUCK_ALWAYS.clone_into(&mut f.issue.text);
                        }
                    }
                }
                _ => {}
            }
        }
        self.groups.retain(|_, group| !group.shown.is_empty());
    }

    /// The list, which it takes; the times of what is not listed count from `first_s`.
    pub(super) fn finish(self, first_s: f64) -> Vec<Issue> {
        let groups: Vec<_> = self.groups.into_iter().collect();
        let mut out: Vec<Issue> = Vec::new();
        for of_kind in groups.chunk_by(|a, b| a.0.0 == b.0.0) {
            let share = share(of_kind.iter().map(|(_, group)| group.count()));
            for (_, group) in of_kind {
                let (shown, rest) = group.shown.split_at(group.shown.len().min(share));
                out.extend(shown.iter().map(|f| f.issue.clone()));
                let ends = rest.iter().map(|f| f.issue.end_s);
                let ends = ends.chain((group.more > 0).then_some(group.more_end_s));
                let end_s = ends.map(|end| end - first_s).fold(0.0, f64::max);
                say_more(&mut out, (rest.len() + group.more, end_s));
            }
        }
        for own in self.whole {
            let place = (own.kind, own.channel.clone());
            let at = out.partition_point(|i| (i.kind, &i.channel) < (place.0, &place.1));
            out.insert(at, own);
        }
        out
    }
}

impl Group {
    fn count(&self) -> usize {
        self.shown.len() + self.more
    }

    fn push(&mut self, next: Found, near_s: f64) {
        if let Said::Saturated { limit, is_largest } = next.said {
            let known = &mut self.limits[usize::from(is_largest)];
            let passed = known.is_some_and(|(k, _)| if is_largest { k > limit } else { k < limit });
            if passed {
                return;
            }
            match known {
                Some((k, count)) if *k == limit => *count += next.issue.count,
                _ => *known = Some((limit, next.issue.count)),
            }
        }
        let (start_s, end_s) = (next.issue.start_s, next.issue.end_s);
        let is_near =
            self.count() > 0 && start_s - self.last_s.1 < near_s && start_s >= self.last_s.0;
        if !is_near {
            self.last_s = (start_s, end_s);
            self.merged = 1;
            if self.shown.len() < MOST_OF_A_KIND {
                self.shown.push(next);
            } else {
                self.more_end_s = if self.more == 0 {
                    end_s
                } else {
                    self.more_end_s.max(end_s)
                };
                self.more += 1;
            }
            return;
        }
        self.last_s.1 = self.last_s.1.max(end_s);
        if self.more > 0 {
            self.more_end_s = self.more_end_s.max(end_s);
        } else if let Some(last) = self.shown.last_mut() {
            if next.continues && self.merged == 1 {
                last.go_on(&next);
                return;
            }
            self.merged += u64::from(!next.continues);
            last.issue.end_s = last.issue.end_s.max(end_s);
            last.issue.count += next.issue.count;
            say_merged(&mut last.issue, self.merged);
        }
    }

    /// Of saturated values those that are the channel's extremes.
    fn keep_extremes(&mut self, extremes: [f64; 2]) {
        let limits = self.limits;
        self.shown.retain_mut(|f| {
            let Said::Saturated { limit, is_largest } = f.said else {
                return true;
            };
            let side = usize::from(is_largest);
            let count = limits[side].map_or(0, |l| l.1);
            f.issue.text = channel::saturated(limit, is_largest, count);
            limit == extremes[side] && count >= channel::FEWEST_SATURATED as u64
        });
    }
}

/// What neighbors say together.
fn say_merged(last: &mut Issue, merged: u64) {
    let count = last.count;
    last.text = match (last.kind, last.channel.as_deref()) {
        (IssueKind::Gap, _) => format!("{count} samples lost in {merged} gaps"),
        (IssueKind::Duplicate, _) => format!("{count} stamps equal to the one before; dropped"),
        (IssueKind::Nan, Some("time")) => {
            format!("{count} stamps are no numbers; taken as equally spaced")
        }
        (IssueKind::Nan, _) => format!("{count} samples are no numbers"),
        _ => return,
    };
}

/// The most that a channel may list of a kind, so that each is named: those with few leave their share to the others.
fn share(counts: impl Iterator<Item = usize>) -> usize {
    let mut counts: Vec<usize> = counts.collect();
    counts.sort_unstable();
    let mut room = MOST_OF_A_KIND;
    for (k, &count) in counts.iter().enumerate() {
        let each = (room / (counts.len() - k)).max(1);
        if count > each {
            return each;
        }
        room = room.saturating_sub(count);
    }
    usize::MAX
}

fn say_more(out: &mut [Issue], (more, end_s): (usize, f64)) {
    if let (Some(last), true) = (out.last_mut(), more > 0) {
        use std::fmt::Write as _;
        let _ = write!(
            last.text,
            "; and {more} more of this kind up to {end_s:.3} s"
        );
    }
}
