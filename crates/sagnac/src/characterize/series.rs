//! A channel over time in few pieces, each at its own time, gaps left open.

use sagnac_log::health::ChannelHealth;

/// Pieces that a channel is shown in.
const PIECES: usize = 720;

/// Time, smallest, mean, largest of at most [`PIECES`] pieces of equal length; what parts them has no numbers.
pub(super) fn pieces(own: &ChannelHealth<'_>, duration_s: f64) -> Vec<[f64; 4]> {
    let count = own.values.len().min(PIECES);
    let width_s = duration_s / count.max(1) as f64;
    // Less than a piece is no gap that shows.
    let gap_s = width_s.max(2.5 * own.step_s);
    let mut out: Vec<[f64; 4]> = Vec::with_capacity(count);
    let mut piece: Option<Piece> = None;
    let mut last_s = f64::NAN;
    for (time_s, y) in timed(own) {
        if !y.is_finite() {
            continue;
        }
        let place = (time_s / width_s).floor();
        let is_apart = time_s - last_s > gap_s || time_s < last_s;
        if piece.as_ref().is_some_and(|p| is_apart || p.place != place) {
            out.extend(piece.take().map(|p| p.numbers()));
        }
        if is_apart {
            out.push([0.5 * (time_s + last_s), f64::NAN, f64::NAN, f64::NAN]);
        }
        piece.get_or_insert(Piece::at(place)).add(time_s, y);
        last_s = time_s;
    }
    out.extend(piece.map(|p| p.numbers()));
    out
}

/// Samples with their times since the start: those between stretches follow the stretch before them.
fn timed<'a>(own: &'a ChannelHealth<'_>) -> impl Iterator<Item = (f64, f64)> + 'a {
    let mut segments = own.segments.iter().peekable();
    let mut base = segments.peek().map_or((0.0, 0.0), |first| {
        (first.range.start as f64, first.start_s)
    });
    own.values.iter().enumerate().map(move |(k, &y)| {
        while let Some(segment) = segments.next_if(|s| s.range.start <= k) {
            base = (segment.range.start as f64, segment.start_s);
        }
        (base.1 + (k as f64 - base.0) * own.step_s, y)
    })
}

struct Piece {
    place: f64,
    count: f64,
    time_s: f64,
    sum: f64,
    min: f64,
    max: f64,
}

impl Piece {
    fn at(place: f64) -> Self {
        Self {
            place,
            count: 0.0,
            time_s: 0.0,
            sum: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        }
    }

    fn add(&mut self, time_s: f64, y: f64) {
        self.count += 1.0;
        self.time_s += time_s;
        self.sum += y;
        self.min = self.min.min(y);
        self.max = self.max.max(y);
    }

    fn numbers(&self) -> [f64; 4] {
        [
            self.time_s / self.count,
            self.min,
            self.sum / self.count,
            self.max,
        ]
    }
}
