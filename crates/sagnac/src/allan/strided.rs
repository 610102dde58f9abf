//! The strided estimate, and Welch's spectrum: one pass over a log of any length.

use sagnac_analysis::{Curve, Density, DeviationStream, Estimate, Transforms, WelchStream};
use sagnac_log::{Block, Issue, IssueKind, LogReader, Stamp};

use super::{AllanAxis, AllanOutcome, AllanRequest};
use crate::Error;

/// Samples lost in a row that are filled by a line.
const MOST_FILLED: usize = 3;

/// Estimates the curves while the log goes by.
pub(super) fn strided(
    reader: &mut dyn LogReader,
    axes: &[usize],
    request: &AllanRequest,
) -> Result<AllanOutcome, Error> {
    if request.dynamic_s.is_some() {
        return Err(Error::usage("--dynamic has no strided form")
            .at("--estimate strided, or a log of more than 1e8 values")
            .advise("add --estimate exact, or cut the log with --start and --end"));
    }
    let mut block = Block::with_columns(reader.layout().channels.len());
    let mut more = reader.read_block(&mut block)?;
    if !more {
        return Err(Error::data("the log has no samples")
            .at(request.label.clone())
            .advise("look at what recorded it, or at --start and --end"));
    }
    let mut clock = Clock::new(reader.layout().rate_hz, &block);
    let samples = reader
        .layout()
        .samples
        .and_then(|n| usize::try_from(n).ok());
    let step_s = clock.step_s.ok_or_else(|| {
        Error::data("time never advances")
            .at("time")
            .advise("add --rate, for instance --rate 100Hz")
    })?;
    let layout = reader.layout().clone();
    let stream = stream_of(request, samples, step_s)?;
    let mut streams: Vec<Axis> = axes.iter().map(|_| Axis::new(stream.clone())).collect();
    let mut transforms = Transforms::default();
    let mut rows = 0;
    while more {
        let marks = clock.marks(&block);
        for (axis, &column) in streams.iter_mut().zip(axes) {
            axis.push(&block.columns[column], &marks, &mut transforms);
        }
        rows += block.rows as u64;
        more = reader.read_block(&mut block)?;
    }
    let dt_s = clock.interval_s().unwrap_or(step_s);
    let mut outcome = AllanOutcome {
        request: request.clone(),
        samples: rows,
        dt_s,
        origin_s: clock.first.map_or(0.0, Stamp::seconds),
        segments: 1,
        // All pieces of a spectrum are in it.
        estimate: if request.spectrum {
            Estimate::Exact
        } else {
            Estimate::Strided
        },
        axes: Vec::new(),
        issues: clock.issues(),
        notes: reader.layout().notes.clone(),
    };
    let mut problem = None;
    for (axis, &k) in streams.into_iter().zip(axes) {
        let channel = &layout.channels[k];
        outcome.segments = outcome.segments.max(axis.segments);
        if axis.lost > 0 {
            outcome.issues.push(Issue {
                kind: IssueKind::Nan,
                channel: Some(channel.name.clone()),
                start_s: outcome.origin_s,
                end_s: outcome.origin_s + rows as f64 * dt_s,
                count: axis.lost,
                text: format!("{} samples are not numbers", axis.lost),
            });
        }
        // Increments become rates by one division, which a deviation passes through, and a density twice.
        let scale = if channel.is_increment {
            1.0 / dt_s
        } else {
            1.0
        };
        let (curve, density) = match axis.stream.finish(request, dt_s, scale) {
            Ok(found) => found,
            Err(error) => {
                problem.get_or_insert((channel.name.clone(), error));
                (None, None)
            }
        };
        outcome.axes.push(AllanAxis {
            axis: channel.name.clone(),
            quantity: channel.quantity,
            unit: channel.unit.clone(),
            curve,
            density,
            windows: None,
        });
    }
    match problem {
        Some((name, error)) if outcome.axes.iter().all(AllanAxis::is_empty) => {
            Err(Error::from(error).at(format!("{}, channel {name}", request.label)))
        }
        _ => Ok(outcome),
    }
}

/// An axis on its way to what is asked for.
#[derive(Clone)]
enum Stream {
    Deviation(DeviationStream),
    Spectrum(WelchStream),
}

/// A stream for an axis, before its length is known.
fn stream_of(request: &AllanRequest, samples: Option<usize>, step_s: f64) -> Result<Stream, Error> {
    if request.spectrum {
        return Ok(Stream::Spectrum(WelchStream::default()));
    }
    let factors = request
        .taus
        .factors_of_unknown_length(request.deviation, samples, step_s)
        .ok_or_else(|| {
            Error::usage("a strided estimate at every averaging factor would need the whole log")
                .at("--taus all")
                .advise("choose --taus octave, or add --estimate exact")
        })?;
    let stream = DeviationStream::new(request.deviation, factors).map_err(|error| Error {
        kind: crate::Kind::Usage,
        ..Error::from(error)
    })?;
    Ok(Stream::Deviation(stream))
}

impl Stream {
    fn push(&mut self, samples: &[f64], transforms: &mut Transforms) {
        match self {
            Self::Deviation(stream) => stream.push(samples),
            Self::Spectrum(stream) => stream.push(samples, transforms),
        }
    }

    fn end_segment(&mut self) {
        match self {
            Self::Deviation(stream) => stream.end_segment(),
            Self::Spectrum(stream) => stream.end_segment(),
        }
    }

    /// What it comes to, its values times `scale`.
    fn finish(
        self,
        request: &AllanRequest,
        dt_s: f64,
        scale: f64,
    ) -> Result<(Option<Curve>, Option<Density>), sagnac_analysis::Error> {
        match self {
            Self::Deviation(stream) => {
                let wanted = request
                    .taus
                    .factors(request.deviation, stream.longest(), dt_s);
                let mut curve = stream.finish_at(dt_s, &wanted)?;
                let limits = curve.lower.iter_mut().chain(&mut curve.upper).flatten();
                for value in curve.deviation.iter_mut().chain(limits) {
                    *value *= scale;
                }
                Ok((Some(curve), None))
            }
            Self::Spectrum(stream) => {
                let mut found = stream.finish(dt_s)?;
                found.density.iter_mut().for_each(|v| *v *= scale * scale);
                Ok((None, Some(found)))
            }
        }
    }
}

/// What comes before a row.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    /// The next sample.
    Next,
    /// So many lost samples, to be filled.
    Lost(usize),
    /// A longer gap, or time going backwards.
    Cut,
    /// The row repeats the time of the one before.
    Drop,
}

/// Follows the stamps.
struct Clock {
    fixed: bool,
    step_s: Option<f64>,
    first: Option<Stamp>,
    last: Option<Stamp>,
    regular_s: f64,
    regular: u64,
    /// Samples lost, duplicates, jumps back, with the time of the first and last of each.
    found: [Option<(u64, f64, f64)>; 3],
}

impl Clock {
    fn new(rate_hz: Option<f64>, block: &Block) -> Self {
        let step_s = rate_hz.map(|rate| 1.0 / rate).or_else(|| {
            let stamp = |k| block.stamps.get(k);
            let mut steps: Vec<f64> = (1..block.rows.min(100_000))
                .filter_map(|k| Some(stamp(k)?.since(stamp(k - 1)?)))
                .filter(|step| *step > 0.0)
                .collect();
            let middle = steps.len() / 2;
            (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
        });
        Self {
            fixed: rate_hz.is_some(),
            step_s,
            first: block.stamps.get(0),
            last: None,
            regular_s: 0.0,
            regular: 0,
            found: [None; 3],
        }
    }

    fn marks(&mut self, block: &Block) -> Vec<Mark> {
        let dt_s = self.step_s.unwrap_or(1.0);
        (0..block.rows)
            .map(|k| {
                let Some(now) = block.stamps.get(k) else {
                    return Mark::Next;
                };
                let Some(before) = self.last else {
                    self.last = Some(now);
                    return Mark::Next;
                };
                let step = now.since(before);
                if step == 0.0 {
                    self.note(1, 1, now);
                    return Mark::Drop;
                }
                self.last = Some(now);
                if step < 0.0 || step.is_nan() {
                    self.note(2, 1, now);
                    return Mark::Cut;
                }
                if step <= 1.5 * dt_s {
                    self.regular_s += step;
                    self.regular += 1;
                    return Mark::Next;
                }
                let lost = ((step / dt_s).round() - 1.0).max(1.0);
                self.note(0, lost as u64, now);
                if lost <= MOST_FILLED as f64 {
                    Mark::Lost(lost as usize)
                } else {
                    Mark::Cut
                }
            })
            .collect()
    }

    fn note(&mut self, which: usize, count: u64, now: Stamp) {
        let at = now.seconds();
        let (total, _, end) = self.found[which].get_or_insert((0, at, at));
        *total += count;
        *end = at;
    }

    fn interval_s(&self) -> Option<f64> {
        if self.fixed {
            return self.step_s;
        }
        (self.regular > 0).then(|| self.regular_s / self.regular as f64)
    }

    fn issues(&self) -> Vec<Issue> {
        let kinds = [
            (IssueKind::Gap, "samples lost in gaps"),
            (IssueKind::Duplicate, "rows repeat a time and were dropped"),
            (
                IssueKind::Backwards,
                "times go backwards; the log was cut there",
            ),
        ];
        kinds
            .into_iter()
            .zip(self.found)
            .filter_map(|((kind, text), found)| {
                let (count, start_s, end_s) = found?;
                Some(Issue {
                    kind,
                    channel: Some("time".to_owned()),
                    start_s,
                    end_s,
                    count,
                    text: format!("{count} {text}"),
                })
            })
            .collect()
    }
}

/// One axis on its way into a stream.
struct Axis {
    stream: Stream,
    /// Samples lost since the last good one.
    missing: usize,
    before: Option<f64>,
    lost: u64,
    segments: usize,
    ready: Vec<f64>,
}

impl Axis {
    fn new(stream: Stream) -> Self {
        Self {
            stream,
            missing: 0,
            before: None,
            lost: 0,
            segments: 1,
            ready: Vec::new(),
        }
    }

    fn push(&mut self, column: &[f64], marks: &[Mark], transforms: &mut Transforms) {
        for (&value, &mark) in column.iter().zip(marks) {
            match mark {
                Mark::Drop => continue,
                Mark::Cut => self.cut(transforms),
                Mark::Lost(count) => self.missing += count,
                Mark::Next => {}
            }
            if !value.is_finite() {
                self.lost += 1;
                self.missing += 1;
                continue;
            }
            if self.missing > MOST_FILLED {
                self.cut(transforms);
            }
            if let (Some(before), 1..) = (self.before, self.missing) {
                let parts = self.missing as f64 + 1.0;
                for k in 1..=self.missing {
                    self.ready
                        .push(before + (value - before) * k as f64 / parts);
                }
            }
            self.missing = 0;
            self.before = Some(value);
            self.ready.push(value);
        }
        self.stream.push(&self.ready, transforms);
        self.ready.clear();
    }

    fn cut(&mut self, transforms: &mut Transforms) {
        self.stream.push(&self.ready, transforms);
        self.ready.clear();
        if self.before.take().is_some() {
            self.segments += 1;
        }
        self.stream.end_segment();
        self.missing = 0;
    }
}
