//! `correct`: a model's inverse applied to a log as a stream, in constant memory.
//!
//! Columns that are no gyro or accelerometer stay as they are. Where the log has no
//! `gyro_rate_*`, ω̇ is the slope of the parabola through three samples of the gyro that was
//! corrected without it; rows on either side of a gap are not joined.

mod report;
mod rows;
mod usable;

use sagnac_core::Compensation;
use sagnac_log::{Block, Cadence, Channel, Layout, LogReader, LogWriter};
use sagnac_model::Model;
use sagnac_report::text::general;

use crate::Error;
use crate::clock::{RowClock, overridden_dt_s};
use crate::simulate::Channels;
use rows::{Pending, Work};
pub use usable::held_at_zero;
use usable::usable;

/// How a log is corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CorrectRequest {
    /// Writes the column `flags`.
    pub flags: bool,
}

/// What was changed on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// `gyro_x` … `accel_z`.
    pub axis: String,
    /// Mean of corrected − raw, rad/s or m/s².
    pub mean: f64,
    /// Largest |corrected − raw|.
    pub largest: f64,
}

/// Neighboring samples of an axis at the end of its range.
#[derive(Clone, Debug, PartialEq)]
struct Saturated {
    axis: String,
    start_s: f64,
    end_s: f64,
    count: u64,
    at: f64,
}

/// The answer of `correct`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CorrectOutcome {
    /// Rows corrected.
    pub samples: u64,
    /// From the first to the last row, and one interval, s.
    pub duration_s: f64,
    /// Axes that were corrected.
    pub changes: Vec<Change>,
    /// Samples with flag 1 or 2.
    pub saturated: u64,
    /// Samples with flag 4, 8 or 16.
    pub outside_validity: u64,
    /// Warnings about the model or the log.
    pub warnings: Vec<String>,
    /// What the user should know besides.
    pub notes: Vec<String>,
    spans: Vec<Saturated>,
    more_spans: usize,
}

/// Makes the writer of the corrected log, once its columns are known.
pub type MakeWriter<'a> = dyn FnMut(&Layout) -> Result<Box<dyn LogWriter>, Error> + 'a;

/// Corrects all rows that `reader` gives and writes them to the writer that `create` makes.
///
/// # Errors
/// A model without an inverse, a log without gyro and accelerometer, those of reader and writer.
pub fn correct(
    model: &Model,
    reader: &mut dyn LogReader,
    create: &mut MakeWriter,
    request: CorrectRequest,
) -> Result<CorrectOutcome, Error> {
    let mut outcome = CorrectOutcome::default();
    let layout = reader.layout().clone();
    let found = Channels::of(&layout)?;
    let columns = Columns {
        gyro: found.rate,
        accel: found.force,
        rate: found.rate_dot,
        temperature: found.temperature,
    };
    let core = usable(model, &columns, &mut outcome)?;
    let mut block = Block::with_columns(layout.channels.len());
    let mut is_more = reader.read_block(&mut block)?;
    if !is_more {
        return Err(Error::data("the log has no samples"));
    }
    let dt_s = interval(model, &layout, &block, &mut outcome)?;
    let inverse = Compensation::new(&core, dt_s).map_err(|error| {
        Error::data(error.to_string())
            .at(model.label().to_owned())
            .advise(
                "look for a wrong unit: scale_factor, asymmetry, misalignment and cross_axis are fractions, quadratic and cubic count at the end of the range",
            )
    })?;
    if let Some(bound) = inverse.bound().filter(|bound| !bound.is_inside()) {
        outcome.warnings.push(format!(
            "the model is outside the convergence bound ({}): every sample is flagged",
            rows::stated("q", "=", bound.q)
        ));
    }
    let has_flags =
        layout.index("flags").is_some() || layout.texts.iter().any(|text| text.header == "flags");
    if request.flags && has_flags {
        return Err(Error::data("the log has a column `flags` already")
            .advise("leave --flags out: the column is kept as it is"));
    }
    let out_layout = written_layout(&layout, request);
    let mut writer = create(&out_layout)?;
    let overridden_s = overridden_dt_s(&layout, &block);
    let mut work = Work::new(&core, inverse, columns, dt_s);
    if work.needs_slope() {
        outcome.notes.push(
            "the log has no gyro_rate_*: the angular acceleration of the axis offset is the slope of the corrected rates"
                .to_owned(),
        );
    }
    let clock = RowClock::new(dt_s, overridden_s, Cadence::of(&block.stamps));
    let mut pending = Pending::new(layout.channels.len(), clock);
    while is_more {
        divide_increments(&layout, &mut block, dt_s);
        pending.push(&block);
        is_more = reader.read_block(&mut block)?;
        let ready = work.ready(&pending, !is_more);
        if ready > 0 {
            let out = work.rows(&pending, ready, request);
            work.count(&pending, &out, &mut outcome);
            writer.write_block(&out.block)?;
            pending.done(ready);
        }
    }
    outcome.notes.extend(reader.layout().notes.iter().cloned());
    outcome.notes.extend(writer.finish()?);
    outcome.notes.extend(pending.clock().note());
    work.finish(&mut outcome);
    outcome.warnings.extend(
        pending
            .clock()
            .sentences("the log", "no slope is taken across"),
    );
    Ok(outcome)
}

#[derive(Clone, Copy)]
struct Columns {
    gyro: Option<[usize; 3]>,
    accel: Option<[usize; 3]>,
    rate: Option<[usize; 3]>,
    temperature: Option<usize>,
}

/// dt: the log's, else the model's; a difference of more than 0.1 % is told.
fn interval(
    model: &Model,
    layout: &Layout,
    first: &Block,
    outcome: &mut CorrectOutcome,
) -> Result<f64, Error> {
    let of_stamps = Cadence::of(&first.stamps).map(|cadence| cadence.dt_s);
    let of_log = layout.rate_hz.map(|rate| 1.0 / rate).or(of_stamps);
    if let (Some(rate), Some(step)) = (layout.rate_hz, of_stamps)
        && (step * rate - 1.0).abs() > 1e-3
    {
        outcome.warnings.push(format!(
            "the time stamps go at {} Hz: the rate of {} Hz counts in their place",
            general(1.0 / step, 5),
            general(rate, 5)
        ));
    }
    let of_model = model.sample_rate_hz().map(|rate| 1.0 / rate);
    if let (Some(log), Some(model)) = (of_log, of_model)
        && (log / model - 1.0).abs() > 1e-3
    {
        outcome.warnings.push(format!(
            "the log has {} Hz, the model {} Hz: the log's counts",
            general(1.0 / log, 5),
            general(1.0 / model, 5)
        ));
    }
    let dt_s = of_log.or(of_model).unwrap_or(0.01);
    if dt_s > 0.0 && dt_s.is_finite() {
        Ok(dt_s)
    } else {
        Err(Error::data("the log has no rate").advise("add --rate, for instance --rate 100Hz"))
    }
}

fn written_layout(layout: &Layout, request: CorrectRequest) -> Layout {
    let mut out = layout.clone();
    for channel in &mut out.channels {
        channel.is_increment = false;
    }
    if request.flags {
        out.channels.push(Channel::other("flags", ""));
    }
    out
}

fn divide_increments(layout: &Layout, block: &mut Block, dt_s: f64) {
    for (channel, column) in layout.channels.iter().zip(&mut block.columns) {
        if channel.is_increment {
            for value in column.iter_mut() {
                *value /= dt_s;
            }
        }
    }
}
