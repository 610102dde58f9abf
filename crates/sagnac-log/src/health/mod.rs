//! Log health: what is wrong with a log, and the sound stretches that remain.
//!
//! Findings are those of the data-quality table that need no fitted noise model; the cleaned stretches follow from
//! them: short gaps filled by the line between their neighbors, long ones cutting the log, motion left out. A channel with
//! a value in every k-th row alone is taken at its own interval.

mod channel;
mod clean;
mod found;
mod gathering;
mod listing;
mod moments;
mod motion;
mod thin;
mod time;

pub use channel::mean_force;
pub use gathering::{Gathering, InSections, SectionHealth, check_section};

use std::borrow::Cow;
use std::ops::Range;

use crate::clock::median;
use crate::{Error, Issue, IssueKind, Log, Quantity};
use found::Found;
use listing::Listing;
use time::Clock;

/// The health of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Health<'a> {
    /// Sampling interval: the median step of time, refined over stretches without gaps, or 1/rate where it was given.
    pub dt_s: f64,
    /// Time of the first row on the log's own clock: subtract it from the issues' times to count from the start.
    pub first_s: f64,
    /// Time from the first to the last row, plus dt; where time goes back, the sum over the stretches between.
    pub duration_s: f64,
    /// The grid that the stamps are rounded to, where it is about as coarse as dt or coarser.
    pub stamp_step_s: Option<f64>,
    /// Findings, by kind in the order of the table, then by channel and time.
    pub issues: Vec<Issue>,
    /// Statistics and cleaned samples of each channel, in the log's order.
    pub channels: Vec<ChannelHealth<'a>>,
    /// Sentences about how channels were taken.
    pub notes: Vec<String>,
}

/// The health of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelHealth<'a> {
    /// Its name.
    pub name: String,
    /// Mean of its finite values.
    pub mean: f64,
    /// Standard deviation of its finite values.
    pub std: f64,
    /// Smallest finite value.
    pub min: f64,
    /// Largest finite value.
    pub max: f64,
    /// Smallest step of the values' grid, or `None`.
    pub lsb: Option<f64>,
    /// Robust scatter of first differences over √2.
    pub sigma_w: f64,
    /// Interval of its samples: the log's, or k times that where only every k-th row has a value.
    pub step_s: f64,
    /// Samples on an even grid: the log's own where nothing had to be filled.
    pub values: Cow<'a, [f64]>,
    /// The stretches between gaps: what deviations are computed from.
    pub segments: Vec<Segment>,
    /// The same without motion: what parameters are estimated from. More is filled in them, see [`Segment::filled`].
    pub quiet: Vec<Segment>,
}

/// A stretch of evenly spaced samples without gap, or with short ones filled by lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Its samples, as a range of [`ChannelHealth::values`].
    pub range: Range<usize>,
    /// Time of its first sample, in seconds from the log's first sample.
    pub start_s: f64,
    /// Runs of lost samples that a line replaces, counted from the stretch's first sample, ascending.
    pub filled: Vec<Range<usize>>,
}

impl ChannelHealth<'_> {
    /// The stretches that parameters are estimated from, as slices.
    pub fn quiet_slices(&self) -> Vec<&[f64]> {
        self.quiet
            .iter()
            .filter_map(|s| self.values.get(s.range.clone()))
            .collect()
    }

    /// The stretches between gaps, as slices.
    pub fn slices(&self) -> Vec<&[f64]> {
        self.segments
            .iter()
            .filter_map(|s| self.values.get(s.range.clone()))
            .collect()
    }
}

/// What the health check may know besides the log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HealthOptions {
    /// Full range of the gyro in rad/s, where a model gives it.
    pub gyro_range_rad_s: Option<f64>,
    /// Full range of the accelerometer in m/s^2, where a model gives it.
    pub accel_range_m_s2: Option<f64>,
    /// True where the log is no recording at rest: motion, units and non-stationarity are then no findings.
    pub moving: bool,
}

/// Checks a log and cleans it.
///
/// # Errors
/// A log whose stamps never advance and that has no rate; one without a single number.
///
/// ```
/// use sagnac_log::{ReadOptions, Source, health, read};
/// let text: String = (0..200).map(|k| format!("{},{}\n", k + k / 100 * 9, k % 7)).collect();
/// let options = ReadOptions { columns: Some("time=0:ms, gyro_x=1:deg/s".into()), ..Default::default() };
/// let log = read(Source::memory("a.csv", text.into()), &options)?;
/// let health = health::check(&log, &health::HealthOptions::default())?;
/// assert_eq!((health.issues[0].kind.name(), health.issues[0].count), ("gap", 9));
/// assert_eq!(health.channels[0].slices().len(), 2);
/// # Ok::<(), sagnac_log::Error>(())
/// ```
pub fn check<'a>(log: &'a Log, options: &HealthOptions) -> Result<Health<'a>, Error> {
    if !log.columns.is_empty() && log.columns.iter().flatten().all(|v| !v.is_finite()) {
        return Err(no_numbers());
    }
    let rows = 0..log.rows;
    let (mut health, mut found, clock) = look(log, options, &rows, None)?;
    let mut whole = Vec::new();
    let mut push = |kind, channel: Option<&str>, text| {
        whole.push(Issue {
            kind,
            channel: channel.map(str::to_owned),
            start_s: clock.absolute(0),
            end_s: clock.absolute(log.rows.saturating_sub(1)),
            count: log.rows as u64,
            text,
        });
    };
    for (channel, own) in log.layout.channels.iter().zip(&health.channels) {
        if is_sensor(channel.quantity)
            && let Some(text) = channel::quantization(own.sigma_w, own.lsb)
        {
            push(IssueKind::Quantization, Some(&own.name), text);
        }
    }
    if !options.moving
        && let Some(text) = channel::units(channel::lengths(log, &rows))
    {
        push(IssueKind::Units, None, text);
    }
    if let Some(text) = short(log.rows as u64, health.duration_s) {
        push(IssueKind::Short, None, text);
    }
    if !options.moving {
        for (channel, own) in log.layout.channels.iter().zip(&health.channels) {
            if is_sensor(channel.quantity) {
                channel::non_stationary_issues(own, &clock, &mut whole);
            }
        }
    }
    found.extend(whole.into_iter().map(|i| Found::event(i, rows.clone())));
    let mut listing = Listing::default();
    listing.add(sound(found), health.dt_s);
    health.issues = listing.finish(health.first_s);
    Ok(health)
}

/// The error of a log without numbers.
fn no_numbers() -> Error {
    Error::data("the log holds no numbers: every value is NaN or infinite")
        .advise("look at what recorded it")
}

/// Whether a channel's values are those of a sensor's axis.
fn is_sensor(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::Other | Quantity::Temperature)
}

/// Findings that concern samples, each with its start before its end.
fn sound(mut found: Vec<Found>) -> Vec<Found> {
    found.retain(|f| f.issue.count > 0);
    // Where time goes back the last row need not be the latest.
    for Found { issue: i, .. } in found.iter_mut().filter(|f| f.issue.end_s < f.issue.start_s) {
        (i.start_s, i.end_s) = (i.end_s, i.start_s);
    }
    found
}

/// What can be told without the rest of the log: the channels, and every finding that is one of places; `own` are the rows
/// that count, `known_s` is the interval where the stamps may not tell it.
fn look<'a>(
    log: &'a Log,
    options: &HealthOptions,
    own: &Range<usize>,
    known_s: Option<f64>,
) -> Result<(Health<'a>, Vec<Found>, Clock<'a>), Error> {
    let clock = Clock::of_section(log, known_s)?;
    let dt = clock.dt_s;
    let mut issues = time::issues(&clock, &clean::gaps(&clock));
    let grid = clean::Grid::of(&clock);
    let mut channels = Vec::with_capacity(log.columns.len());
    let mut stuck = Vec::with_capacity(log.columns.len());
    let (mut notes, mut thinned) = (Vec::new(), Vec::new());
    let mut thins: Vec<Option<thin::Thin>> = Vec::with_capacity(log.columns.len());
    for (channel, all) in log.channels() {
        let mut thin = thin::Thin::of(all).filter(|_| !options.moving);
        if let Some(thin) = &mut thin {
            thin.is_joined = channel.quantity == Quantity::Temperature;
        }
        let values = thin.as_ref().map_or(all, |t| t.values.as_slice());
        let facts = channel::Facts::of(values);
        if let Some(thin) = &thin {
            let told = (&mut thinned, &mut notes);
            thin::remark(&channel.name, thin, (&clock, own), told);
            channel::lost_issues(&channel.name, thin, &clock, &mut issues);
        } else {
            channel::nan_issues(&channel.name, values, &clock, &facts, &mut issues);
        }
        let rows = |range: &Range<usize>| match &thin {
            Some(thin) => thin.rows_of(range),
            None => range.clone(),
        };
        let runs = if is_sensor(channel.quantity) {
            let range = match channel.quantity {
                Quantity::AngularRate => options.gyro_range_rad_s,
                Quantity::SpecificForce => options.accel_range_m_s2,
                _ => None,
            };
            let place = channel::Place {
                name: &channel.name,
                clock: &clock,
                rows: &rows,
                is_part: *own != (0..log.rows),
            };
            channel::saturation_issues(&place, values, &facts, range, &mut issues);
            let runs = channel::stuck_runs(values);
            channel::stuck_issues(&place, values.len(), &runs, &mut issues);
            runs.iter().map(rows).collect()
        } else {
            Vec::new()
        };
        stuck.push(runs);
        channels.push(ChannelHealth {
            name: channel.name.clone(),
            mean: facts.mean,
            std: facts.std,
            min: facts.min,
            max: facts.max,
            lsb: facts.lsb,
            sigma_w: facts.sigma_w,
            step_s: thin
                .as_ref()
                .filter(|t| !t.is_joined)
                .map_or(dt, |t| t.every as f64 * dt),
            values: Cow::Borrowed(all),
            segments: Vec::new(),
            quiet: Vec::new(),
        });
        thins.push(thin);
    }
    let motion = if options.moving {
        Vec::new()
    } else {
        motion::intervals(log, &clock, &stuck)
    };
    motion::issues(&motion, &clock, &mut issues);
    for (((health, values), stuck), thin) in channels
        .iter_mut()
        .zip(&log.columns)
        .zip(&stuck)
        .zip(&thins)
    {
        let own = clean::clean(values, &grid, &clock, (stuck, &motion), thin.as_ref());
        (health.values, health.segments, health.quiet) = (own.values, own.segments, own.quiet);
        let numbers: usize = health.segments.iter().map(|s| s.range.len()).sum();
        if numbers < FEWEST_NUMBERS {
            health.quiet.clear();
        }
    }
    issues.append(&mut thinned);
    let health = Health {
        dt_s: dt,
        first_s: clock.absolute(0),
        duration_s: clock.duration_s(),
        stamp_step_s: clock.beat.grid_s,
        issues: Vec::new(),
        channels,
        notes,
    };
    Ok((health, issues, clock))
}

/// Rows in which the sensor was moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// The rows.
    pub rows: Range<usize>,
    /// The channels that show it.
    pub channels: Vec<String>,
    /// What they show.
    pub text: String,
}

/// Where the sensor was moved, as in [`check`], ascending and apart: all of them, by rows.
///
/// # Errors
/// A log whose stamps never advance and that has no rate.
pub fn moved(log: &Log) -> Result<Vec<Moved>, Error> {
    let clock = time::Clock::of(log)?;
    let stuck: Vec<Vec<Range<usize>>> = log
        .channels()
        .map(|(channel, values)| {
            if is_sensor(channel.quantity) {
                channel::stuck_runs(values)
            } else {
                Vec::new()
            }
        })
        .collect();
    Ok(motion::intervals(log, &clock, &stuck)
        .into_iter()
        .map(|m| Moved {
            rows: m.rows,
            channels: m.channels,
            text: m.text,
        })
        .collect())
}

/// Fewer numbers than this give no parameters.
const FEWEST_NUMBERS: usize = 64;

/// What is said of a log that is short as a whole.
fn short(rows: u64, span_s: f64) -> Option<String> {
    if rows < FEWEST_NUMBERS as u64 {
        Some(format!(
            "{rows} samples: no parameters from fewer than {FEWEST_NUMBERS}"
        ))
    } else if span_s < 100.0 {
        Some(format!(
            "{span_s:.3} s: bias instability, walks and ramps only as upper limits under 100 s"
        ))
    } else {
        None
    }
}

/// Robust standard deviation of values around zero: 1.4826·median|v|.
pub(crate) fn robust(values: &mut [f64]) -> f64 {
    for v in values.iter_mut() {
        *v = v.abs();
    }
    1.4826 * median(values).unwrap_or(f64::NAN)
}
