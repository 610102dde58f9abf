//! Evenly spaced stretches: short gaps filled by the line between their neighbors, long ones cutting the log.
//!
//! Up to 3 lost samples and 2 % of the log are filled for every use. Parameters know what filling does to the spectrum:
//! for them alone runs of up to 20 are filled, up to 70 % of the log; `DESIGN.md` has the reasons.

use std::borrow::Cow;
use std::ops::Range;

use super::Segment;
use super::motion::Motion;
use super::thin::Thin;
use super::time::Clock;
use crate::beat::Event;

/// Lost samples that a line may replace.
const LONGEST_FILL: u64 = 3;
/// Share of the log that may be filled.
const MOST_FILLED: f64 = 0.02;
/// The same where what filling does is known: for parameters.
const LONGEST_FOR_PARAMETERS: usize = 20;
const MOST_FOR_PARAMETERS: f64 = 0.7;

/// Where the rows stand on the even grid.
pub(crate) struct Grid {
    /// Runs of rows without event.
    pieces: Vec<Piece>,
}

struct Piece {
    rows: Range<usize>,
    /// Samples missing before it; `None`: the grid starts anew.
    lost: Option<u64>,
    /// What is missing is filled for parameters alone.
    is_wide: bool,
}

/// A channel's samples on the grid and its stretches.
pub(crate) struct Cleaned<'a> {
    pub(crate) values: Cow<'a, [f64]>,
    pub(crate) segments: Vec<Segment>,
    /// Those without motion, filled where only parameters allow it.
    pub(crate) quiet: Vec<Segment>,
}

/// What becomes of a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gap {
    Filled,
    FilledForParameters,
    Cut,
}

/// The longest run that is filled for parameters, so that no more than the share allows is.
fn longest_filled(runs: impl Iterator<Item = usize>, samples: usize) -> usize {
    let mut of_length = [0_usize; LONGEST_FOR_PARAMETERS + 1];
    for n in runs.filter(|n| *n <= LONGEST_FOR_PARAMETERS) {
        of_length[n] += n;
    }
    let budget = (MOST_FOR_PARAMETERS * samples as f64) as usize;
    let mut sum = 0;
    for (n, filled) in of_length.iter().enumerate() {
        sum += filled;
        if sum > budget {
            return n.saturating_sub(1);
        }
    }
    LONGEST_FOR_PARAMETERS
}

/// What becomes of each event of the clock that is a gap, in their order.
pub(crate) fn gaps(clock: &Clock<'_>) -> Vec<Gap> {
    let rows = clock.log.rows;
    let budget = (MOST_FILLED * rows as f64) as u64;
    let lost = || {
        clock.beat.events.iter().filter_map(|(_, e)| match e {
            Event::Gap(n) => Some(*n),
            _ => None,
        })
    };
    let short = lost().filter(|n| *n <= LONGEST_FOR_PARAMETERS as u64);
    let samples = rows + short.clone().sum::<u64>() as usize;
    let longest = longest_filled(short.map(|n| n as usize), samples) as u64;
    let mut filled = 0;
    lost()
        .map(|n| {
            if n <= LONGEST_FILL && filled + n <= budget {
                filled += n;
                Gap::Filled
            } else if n <= longest {
                Gap::FilledForParameters
            } else {
                Gap::Cut
            }
        })
        .collect()
}

impl Grid {
    pub(crate) fn of(clock: &Clock<'_>) -> Self {
        let rows = clock.log.rows;
        let mut pieces = Vec::new();
        let mut gaps = gaps(clock).into_iter();
        let mut start = 0;
        let (mut lost, mut is_wide) = (None, false);
        for &(row, event) in &clock.beat.events {
            pieces.push(Piece {
                rows: start..row,
                lost,
                is_wide,
            });
            start = row;
            (lost, is_wide) = match event {
                // The later of two equal stamps is dropped.
                Event::Duplicate => {
                    start = row + 1;
                    (Some(0), false)
                }
                Event::Gap(n) => match gaps.next() {
                    Some(Gap::Filled) => (Some(n), false),
                    Some(Gap::FilledForParameters) => (Some(n), true),
                    _ => (None, false),
                },
                Event::Backwards => (None, false),
            };
        }
        pieces.push(Piece {
            rows: start.min(rows)..rows,
            lost,
            is_wide,
        });
        pieces.retain(|p| !p.rows.is_empty() || p.lost.is_none());
        Self { pieces }
    }

    fn is_plain(&self) -> bool {
        self.pieces.len() == 1
    }
}

/// A channel's samples on the grid, its stretches, and those without motion.
pub(crate) fn clean<'a>(
    values: &'a [f64],
    grid: &Grid,
    clock: &Clock<'_>,
    (stuck, motion): (&[Range<usize>], &[Motion]),
    thin: Option<&Thin>,
) -> Cleaned<'a> {
    let is_sound = values.iter().all(|v| v.is_finite());
    // Grid position, row and length of every piece.
    let mut out: Cow<'a, [f64]> = Cow::Borrowed(values);
    let mut places: Vec<(usize, Range<usize>)> = Vec::new();
    let mut cuts: Vec<usize> = Vec::new();
    // Positions filled for parameters alone.
    let mut wide: Vec<Range<usize>> = Vec::new();
    if grid.is_plain() {
        places.push((0, 0..values.len()));
        if !is_sound {
            out = Cow::Owned(values.to_vec());
        }
    } else {
        let mut all = Vec::with_capacity(values.len() + values.len() / 50);
        for piece in &grid.pieces {
            match piece.lost {
                Some(n) => {
                    let from = all.len();
                    all.resize(from + n as usize, f64::NAN);
                    if piece.is_wide {
                        wide.push(from..all.len());
                    }
                }
                None => cuts.push(all.len()),
            }
            places.push((all.len(), piece.rows.clone()));
            all.extend_from_slice(&values[piece.rows.clone()]);
        }
        out = Cow::Owned(all);
    }
    let mut stuck: Vec<Range<usize>> = stuck.iter().flat_map(|r| to_grid(&places, r)).collect();
    let mut moved: Vec<Range<usize>> = motion
        .iter()
        .flat_map(|m| to_grid(&places, &m.rows))
        .collect();
    // One value in every k-th position: the grid is that of those positions, or lines join them.
    let own = thin.filter(|t| !t.is_joined).map(|t| t.on(&out, &cuts));
    let patience = thin.filter(|t| t.is_joined).map_or(0, |t| 2 * t.every);
    if let Some(own) = &own {
        out = Cow::Owned(own.values(&out));
        let narrow = |ranges: &mut Vec<Range<usize>>| {
            for r in ranges.iter_mut() {
                *r = own.range(r);
            }
            ranges.retain(|r| !r.is_empty());
        };
        narrow(&mut stuck);
        narrow(&mut moved);
        narrow(&mut wide);
        cuts = own.cuts();
    }
    let mut filled = Filled::default();
    if let Cow::Owned(all) = &mut out {
        filled = fill(all, &cuts, &wide, (values.len(), patience));
    }
    let mut bad = stuck;
    bad.extend(filled.left);
    let quiet_bad: Vec<Range<usize>> = bad.iter().cloned().chain(moved).collect();
    bad.extend(filled.for_parameters.iter().cloned());
    let segments = stretches(out.len(), &cuts, bad);
    let quiet = stretches(out.len(), &cuts, quiet_bad);
    let mut all_filled = filled.everywhere;
    let of = |ranges: Vec<Range<usize>>, filled: &[Range<usize>]| -> Vec<Segment> {
        ranges
            .into_iter()
            .filter_map(|range| Segment::of(range, filled))
            .map(|(range, filled)| Segment {
                start_s: time_of(
                    &places,
                    own.as_ref()
                        .map_or(range.start, |own| own.place(range.start)),
                    clock,
                ),
                range,
                filled,
            })
            .collect()
    };
    let segments = of(segments, &all_filled);
    all_filled.extend(filled.for_parameters);
    all_filled.sort_by_key(|r| r.start);
    let quiet = of(quiet, &all_filled);
    Cleaned {
        values: out,
        segments,
        quiet,
    }
}

impl Segment {
    /// A range without the filled samples at its ends, and the runs of filled ones within it; `None` where nothing is left.
    fn of(
        range: Range<usize>,
        filled: &[Range<usize>],
    ) -> Option<(Range<usize>, Vec<Range<usize>>)> {
        let Range { mut start, mut end } = range;
        let first = filled.partition_point(|r| r.end <= start);
        let last = filled.partition_point(|r| r.start < end);
        let mut inside = filled.get(first..last).unwrap_or(&[]);
        if let Some((run, rest)) = inside.split_first()
            && run.start <= start
        {
            (start, inside) = (run.end, rest);
        }
        if let Some((run, rest)) = inside.split_last()
            && run.end >= end
        {
            (end, inside) = (run.start, rest);
        }
        let runs = inside.iter().map(|r| r.start - start..r.end - start);
        (start < end).then(|| (start..end, runs.collect()))
    }
}

/// Time of a grid position from the first row.
fn time_of(places: &[(usize, Range<usize>)], at: usize, clock: &Clock<'_>) -> f64 {
    let k = places.partition_point(|p| p.0 <= at).saturating_sub(1);
    places.get(k).map_or(0.0, |(start, rows)| {
        let row = rows.start + (at - start.min(&at)).min(rows.len().saturating_sub(1));
        clock.seconds(row)
    })
}

/// Rows as ranges of the grid.
fn to_grid<'p>(
    places: &'p [(usize, Range<usize>)],
    rows: &Range<usize>,
) -> impl Iterator<Item = Range<usize>> + use<'p> {
    let rows = rows.clone();
    places.iter().filter_map(move |(start, piece)| {
        let (a, b) = (rows.start.max(piece.start), rows.end.min(piece.end));
        (a < b).then(|| start + a - piece.start..start + b - piece.start)
    })
}

/// Runs of missing samples: filled for every use, for parameters alone, not filled.
#[derive(Default)]
struct Filled {
    everywhere: Vec<Range<usize>>,
    for_parameters: Vec<Range<usize>>,
    left: Vec<Range<usize>>,
}

/// Fills short runs of missing samples by lines; those that meet `wide` count as filled for parameters. Runs up to
/// `patience` are filled in any case.
fn fill(
    all: &mut [f64],
    cuts: &[usize],
    wide: &[Range<usize>],
    (rows, patience): (usize, usize),
) -> Filled {
    let missing = super::channel::runs(all, |v| !v.is_finite());
    let longest = longest_filled(missing.iter().map(Range::len), all.len()).max(patience);
    let mut budget = (MOST_FILLED * rows as f64) as usize;
    let mut out = Filled::default();
    for run in missing {
        let (start, k, n) = (run.start, run.end, run.len());
        let at = cuts.partition_point(|c| *c < start.max(1));
        let crosses = cuts.get(at).is_some_and(|c| *c <= k);
        let met = wide.partition_point(|w| w.end <= start);
        let is_wide = wide.get(met).is_some_and(|w| w.start < k);
        let is_inside = start > 0 && k < all.len() && !crosses;
        let narrow = !is_wide && n as u64 <= LONGEST_FILL && n <= budget;
        // What joins the values of a temperature holds its first and its last beyond them.
        let end = match (start, all.get(k)) {
            (0, Some(&first)) => Some(first),
            (_, None) if start > 0 => Some(all[start - 1]),
            _ => None,
        };
        if let Some(value) = end.filter(|_| n <= patience) {
            all[run].fill(value);
            continue;
        }
        if !is_inside || !(narrow || n <= longest) {
            out.left.push(run);
            continue;
        }
        let (a, b) = (all[start - 1], all[k]);
        for (i, v) in all[run.clone()].iter_mut().enumerate() {
            *v = a + (b - a) * (i + 1) as f64 / (n + 1) as f64;
        }
        if narrow {
            budget -= n;
            out.everywhere.push(run);
        } else {
            out.for_parameters.push(run);
        }
    }
    out
}

/// What remains between cuts and bad ranges.
fn stretches(n: usize, cuts: &[usize], mut bad: Vec<Range<usize>>) -> Vec<Range<usize>> {
    bad.extend(cuts.iter().map(|&c| c..c));
    bad.sort_by_key(|r| (r.start, r.end));
    let mut out = Vec::new();
    let mut at = 0;
    for r in bad {
        if r.start > at {
            out.push(at..r.start.min(n));
        }
        at = at.max(r.end);
    }
    if at < n {
        out.push(at..n);
    }
    out
}
