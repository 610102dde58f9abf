//! Evenly spaced stretches: short gaps filled by the line between their neighbors, long ones cutting the log.

use std::borrow::Cow;
use std::ops::Range;

use super::Segment;
use super::motion::Motion;
use super::time::Clock;
use crate::beat::Event;

/// Lost samples that a line may replace.
const LONGEST_FILL: u64 = 3;
/// Share of the log that may be filled.
const MOST_FILLED: f64 = 0.02;

/// Where the rows stand on the even grid.
pub(crate) struct Grid {
    /// Runs of rows without event.
    pieces: Vec<Piece>,
}

struct Piece {
    rows: Range<usize>,
    /// Samples missing before it; `None`: the grid starts anew.
    lost: Option<u64>,
}

impl Grid {
    pub(crate) fn of(clock: &Clock<'_>) -> Self {
        let rows = clock.log.rows;
        let mut pieces = Vec::new();
        let budget = (MOST_FILLED * rows as f64) as u64;
        let mut filled = 0;
        let mut start = 0;
        let mut lost = None;
        for &(row, event) in &clock.beat.events {
            pieces.push(Piece {
                rows: start..row,
                lost,
            });
            start = row;
            lost = match event {
                // The later of two equal stamps is dropped.
                Event::Duplicate => {
                    start = row + 1;
                    Some(0)
                }
                Event::Gap(n) if n <= LONGEST_FILL && filled + n <= budget => {
                    filled += n;
                    Some(n)
                }
                Event::Gap(_) | Event::Backwards => None,
            };
        }
        pieces.push(Piece {
            rows: start.min(rows)..rows,
            lost,
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
    stuck: &[Range<usize>],
    motion: &[Motion],
) -> (Cow<'a, [f64]>, Vec<Segment>, Vec<Segment>) {
    let is_sound = values.iter().all(|v| v.is_finite());
    // Grid position, row and length of every piece.
    let mut out: Cow<'a, [f64]> = Cow::Borrowed(values);
    let mut places: Vec<(usize, Range<usize>)> = Vec::new();
    let mut cuts: Vec<usize> = Vec::new();
    if grid.is_plain() {
        places.push((0, 0..values.len()));
        if !is_sound {
            out = Cow::Owned(values.to_vec());
        }
    } else {
        let mut all = Vec::with_capacity(values.len() + values.len() / 50);
        for piece in &grid.pieces {
            match piece.lost {
                Some(n) => all.resize(all.len() + n as usize, f64::NAN),
                None => cuts.push(all.len()),
            }
            places.push((all.len(), piece.rows.clone()));
            all.extend_from_slice(&values[piece.rows.clone()]);
        }
        out = Cow::Owned(all);
    }
    let mut bad: Vec<Range<usize>> = stuck.iter().flat_map(|r| to_grid(&places, r)).collect();
    if let Cow::Owned(all) = &mut out {
        bad.extend(fill(all, &cuts, values.len()));
    }
    let segments = stretches(out.len(), &cuts, bad.clone());
    let quiet = if motion.is_empty() {
        segments.clone()
    } else {
        bad.extend(motion.iter().flat_map(|m| to_grid(&places, &m.rows)));
        stretches(out.len(), &cuts, bad)
    };
    let time = |range: Range<usize>| Segment {
        start_s: time_of(&places, range.start, clock),
        range,
    };
    (
        out,
        segments.into_iter().map(time).collect(),
        quiet.into_iter().map(time).collect(),
    )
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

/// Fills short runs of missing samples by lines; returns the runs that stay.
fn fill(all: &mut [f64], cuts: &[usize], rows: usize) -> Vec<Range<usize>> {
    let mut budget = (MOST_FILLED * rows as f64) as usize;
    let mut left = Vec::new();
    let mut k = 0;
    while k < all.len() {
        if all[k].is_finite() {
            k += 1;
            continue;
        }
        let start = k;
        while k < all.len() && !all[k].is_finite() {
            k += 1;
        }
        let n = k - start;
        let crosses = cuts.iter().any(|c| *c >= start && *c <= k && *c > 0);
        if start > 0 && k < all.len() && n as u64 <= LONGEST_FILL && n <= budget && !crosses {
            budget -= n;
            let (a, b) = (all[start - 1], all[k]);
            for (i, v) in all[start..k].iter_mut().enumerate() {
                *v = a + (b - a) * (i + 1) as f64 / (n + 1) as f64;
            }
        } else {
            left.push(start..k);
        }
    }
    left
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
