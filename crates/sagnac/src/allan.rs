//! `allan`: the Allan deviation and its relatives of every axis of a log, or its spectrum.
//!
//! ```
//! use sagnac::allan::{AllanRequest, allan};
//! use sagnac::log::{ReadOptions, Source, open};
//! let text: String = (0..400).map(|k| format!("{},{}\n", k * 10, k * 7919 % 101)).collect();
//! let options = ReadOptions { columns: Some("time=0:ms, gyro_x=1:deg/h".into()), ..Default::default() };
//! let mut reader = open(Source::memory("a.csv", text.into()), &options)?;
//! let outcome = allan(&mut *reader, &AllanRequest::default())?;
//! assert_eq!(outcome.to_json()["axes"][0]["samples_used"][0], 399);
//! # Ok::<(), sagnac::Error>(())
//! ```

mod csv;
mod json;
mod plot;
mod strided;
mod text;
pub(crate) use text::capitalized;

use std::collections::VecDeque;

use sagnac_analysis::{
    Curve, Density, Deviation, Estimate, TauGrid, Window, deviations, dynamic, welch,
};
use sagnac_log::health::{self, ChannelHealth, HealthOptions};
use sagnac_log::{Block, Channel, Issue, IssueKind, Layout, Log, LogReader, Quantity};
use sagnac_report::text::duration;

use crate::Error;
use crate::error::Kind;

/// Values of all axes together from which the strided estimate is used where none is asked for.
pub const MOST_EXACT_VALUES: u64 = 100_000_000;

/// Values of all axes together from which a spectrum is taken from a stream: it is the same, with fewer findings.
pub const MOST_HELD_FOR_SPECTRUM: u64 = 1 << 22;

/// What to estimate.
#[derive(Clone, Debug, Default)]
pub struct AllanRequest {
    /// Which deviation.
    pub deviation: Deviation,
    /// At which averaging times.
    pub taus: TauGrid,
    /// Exact or strided; `None`: exact up to [`MOST_EXACT_VALUES`].
    pub estimate: Option<Estimate>,
    /// The spectrum instead.
    pub spectrum: bool,
    /// Overlapping Allan deviations on windows of this length, besides.
    pub dynamic_s: Option<f64>,
    /// What the log is called, for headings.
    pub label: String,
}

/// The curves of one axis.
#[derive(Clone, Debug)]
pub struct AllanAxis {
    /// Channel name.
    pub axis: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Unit of its values: SI, or the source's for other channels.
    pub unit: String,
    /// The deviation, unless the spectrum was asked for or the axis is too short.
    pub curve: Option<Curve>,
    /// The spectrum, where it was asked for.
    pub density: Option<Density>,
    /// The windows of `dynamic_s`.
    pub windows: Option<Vec<Window>>,
}

/// The curves of a log.
#[derive(Clone, Debug)]
pub struct AllanOutcome {
    /// What was asked for.
    pub request: AllanRequest,
    /// Rows of the log.
    pub samples: u64,
    /// Sampling step in seconds.
    pub dt_s: f64,
    /// Stamp of the first row, 0 where there is none: issues count from the log's time.
    pub origin_s: f64,
    /// Stretches without gaps that were pooled, of the axis with the most.
    pub segments: usize,
    /// Exact or strided.
    pub estimate: Estimate,
    /// The axes.
    pub axes: Vec<AllanAxis>,
    /// Findings about the log.
    pub issues: Vec<Issue>,
    /// What reading the log told.
    pub notes: Vec<String>,
}

impl AllanOutcome {
    /// Length of the log in seconds.
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 * self.dt_s
    }
}

/// Reads a log and estimates the curves of its axes.
///
/// Exact estimates hold the log in memory; strided ones read it once in memory that does not
/// grow with it.
///
/// # Errors
/// Those of the reader; a log without channels of numbers; a log too short for every averaging
/// time; a deviation, grid or option that has no strided form where that is asked for.
pub fn allan(reader: &mut dyn LogReader, request: &AllanRequest) -> Result<AllanOutcome, Error> {
    curves(reader, request).map_err(|error| match error.kind {
        Kind::Data if !request.label.is_empty() => error.at(request.label.clone()),
        _ => error,
    })
}

fn curves(reader: &mut dyn LogReader, request: &AllanRequest) -> Result<AllanOutcome, Error> {
    let axes = axes_of(reader.layout());
    if axes.is_empty() {
        return Err(Error::data("the log has no channel with numbers")
            .at(request.label.clone())
            .advise("name them, for instance --columns 'gyro=1,2,3:deg/s, accel=4,5,6:g'"));
    }
    let limit = match request.estimate {
        Some(Estimate::Exact) => u64::MAX,
        Some(Estimate::Strided) => 0,
        None if request.spectrum => MOST_HELD_FOR_SPECTRUM,
        None => MOST_EXACT_VALUES,
    };
    let width = axes.len() as u64;
    let promised = reader.layout().samples.unwrap_or(0);
    let mut replay = Replay {
        layout: reader.layout().clone(),
        blocks: VecDeque::new(),
        rest: reader,
    };
    // A promise is believed only as far as it makes the answer cheaper; the rows decide.
    let most = if request.spectrum {
        limit
    } else {
        limit.max(MOST_EXACT_VALUES)
    };
    if limit > 0 && promised.saturating_mul(width) <= most {
        let whole = replay.fill(limit / width)?;
        if whole {
            let log = Log::read(&mut replay)?;
            return exact(&log, &axes, request);
        }
    } else if limit == u64::MAX {
        let log = Log::read(&mut replay)?;
        return exact(&log, &axes, request);
    }
    strided::strided(&mut replay, &axes, request)
}

/// The channels that curves are made of: rates and forces, else whatever there is.
fn axes_of(layout: &Layout) -> Vec<usize> {
    let inertial = |channel: &Channel| {
        matches!(
            channel.quantity,
            Quantity::AngularRate | Quantity::SpecificForce | Quantity::AngularAcceleration
        )
    };
    let all = || layout.channels.iter().enumerate();
    let found: Vec<usize> = all()
        .filter(|(_, channel)| inertial(channel))
        .map(|(k, _)| k)
        .collect();
    if found.is_empty() {
        all().map(|(k, _)| k).collect()
    } else {
        found
    }
}

/// A log whose first blocks have been looked at already.
struct Replay<'a> {
    layout: Layout,
    blocks: VecDeque<Block>,
    rest: &'a mut dyn LogReader,
}

impl Replay<'_> {
    /// Reads blocks until there are more than `rows`; whether the log ended before.
    fn fill(&mut self, rows: u64) -> Result<bool, Error> {
        let mut total = 0;
        loop {
            let mut block = Block::with_columns(self.layout.channels.len());
            if !self.rest.read_block(&mut block)? {
                self.layout = self.rest.layout().clone();
                return Ok(true);
            }
            total += block.rows as u64;
            self.blocks.push_back(block);
            if total > rows {
                return Ok(false);
            }
        }
    }
}

impl LogReader for Replay<'_> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn read_block(&mut self, block: &mut Block) -> Result<bool, sagnac_log::Error> {
        if let Some(first) = self.blocks.pop_front() {
            *block = first;
            return Ok(true);
        }
        let more = self.rest.read_block(block)?;
        if !more {
            self.layout = self.rest.layout().clone();
        }
        Ok(more)
    }
}

/// The curves of a log in memory.
fn exact(log: &Log, axes: &[usize], request: &AllanRequest) -> Result<AllanOutcome, Error> {
    let health = health::check(log, &HealthOptions::default())?;
    let mut outcome = AllanOutcome {
        request: request.clone(),
        samples: log.rows as u64,
        dt_s: health.dt_s,
        origin_s: log.stamps.get(0).map_or(0.0, sagnac_log::Stamp::seconds),
        segments: 1,
        estimate: Estimate::Exact,
        axes: Vec::with_capacity(axes.len()),
        issues: health.issues.iter().map(as_of_curve).collect(),
        notes: [log.layout.notes.as_slice(), &health.notes].concat(),
    };
    if let Some(window_s) = request.dynamic_s
        && (window_s / health.dt_s).round() < 2.0
    {
        return Err(Error::usage(format!(
            "a window of {} is shorter than two samples, which are {} apart",
            duration(window_s),
            duration(health.dt_s)
        ))
        .at("--dynamic")
        .advise(format!(
            "choose a window of {} or longer",
            duration(100.0 * health.dt_s)
        )));
    }
    let mut problem = None;
    for &k in axes {
        let (Some(channel), Some(sound)) = (log.layout.channels.get(k), health.channels.get(k))
        else {
            continue;
        };
        let mut axis = AllanAxis {
            axis: channel.name.clone(),
            quantity: channel.quantity,
            unit: channel.unit.clone(),
            curve: None,
            density: None,
            windows: None,
        };
        outcome.segments = outcome.segments.max(sound.segments.len());
        if let Err(error) = fill(&mut axis, sound, sound.step_s, request) {
            problem.get_or_insert((channel.name.clone(), error));
        }
        outcome.axes.push(axis);
    }
    match problem {
        // One axis that gives nothing is no reason to withhold the others.
        Some((name, error)) if outcome.axes.iter().all(AllanAxis::is_empty) => {
            Err(Error::from(error).at(format!("{}, channel {name}", request.label)))
        }
        _ => Ok(outcome),
    }
}

/// A finding as it holds for a curve: what leaves the parameters alone is in the curve.
fn as_of_curve(issue: &Issue) -> Issue {
    let mut own = issue.clone();
    if own.kind == IssueKind::Motion {
        own.text = own.text.replace(
            "; left out of the parameters",
            "; the curve holds it, characterize leaves it out of the parameters alone",
        );
    }
    own
}

impl AllanAxis {
    fn is_empty(&self) -> bool {
        self.curve.is_none() && self.density.is_none()
    }
}

/// Estimates what is asked for on one axis.
fn fill(
    axis: &mut AllanAxis,
    sound: &ChannelHealth<'_>,
    dt_s: f64,
    request: &AllanRequest,
) -> Result<(), sagnac_analysis::Error> {
    let slices = sound.slices();
    if request.spectrum {
        axis.density = Some(welch(&slices, dt_s)?);
        return Ok(());
    }
    let curve = deviations(&slices, dt_s, request.deviation, &request.taus)?;
    if let Some(window_s) = request.dynamic_s {
        let mut windows = Vec::new();
        let mut problem = None;
        for segment in &sound.segments {
            let samples = sound.values.get(segment.range.clone()).unwrap_or(&[]);
            match dynamic(samples, dt_s, window_s, &request.taus) {
                Ok(found) => windows.extend(found.into_iter().map(|mut window| {
                    window.start_s += segment.start_s;
                    window.end_s += segment.start_s;
                    window
                })),
                Err(error) => problem = Some(error),
            }
        }
        if let (true, Some(problem)) = (windows.is_empty(), problem) {
            return Err(problem);
        }
        axis.windows = Some(windows);
    }
    axis.curve = Some(curve);
    Ok(())
}
