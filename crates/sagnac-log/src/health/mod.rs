//! Log health: what is wrong with a log, and the sound stretches that remain.
//!
//! Findings are those of the data-quality table that need no fitted noise model; the cleaned stretches follow from
//! them: short gaps filled by the line between their neighbors, long ones cutting the log, motion left out. A channel with
//! a value in every k-th row alone is taken at its own interval.

mod channel;
mod clean;
mod motion;
mod thin;
mod time;

pub use channel::mean_force;

use std::borrow::Cow;
use std::ops::Range;

use crate::clock::median;
use crate::{Error, Issue, IssueKind, Log, Quantity};

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

/// Listed of one kind at most; the last one of a channel says how many more it has.
const MOST_OF_A_KIND: usize = 100;

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
    let mut health = check_part(log, options)?;
    let (dt_s, first_s) = (health.dt_s, health.first_s);
    health.issues = listed(health.issues, dt_s, first_s);
    Ok(health)
}

/// The error of a log without numbers.
pub fn no_numbers() -> Error {
    Error::data("the log holds no numbers: every value is NaN or infinite")
        .advise("look at what recorded it")
}

/// Checks a part of a log: as [`check`], with every finding by itself, and with numbers or without.
///
/// # Errors
/// Stamps that never advance, and no rate.
pub fn check_part<'a>(log: &'a Log, options: &HealthOptions) -> Result<Health<'a>, Error> {
    let clock = time::Clock::of(log)?;
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
            thin::remark(&channel.name, thin, &clock, (&mut thinned, &mut notes));
            channel::lost_issues(&channel.name, thin, &clock, &mut issues);
        } else {
            channel::nan_issues(&channel.name, values, &clock, &facts, &mut issues);
        }
        let rows = |range: &Range<usize>| match &thin {
            Some(thin) => thin.rows_of(range),
            None => range.clone(),
        };
        let runs = if matches!(channel.quantity, Quantity::Other | Quantity::Temperature) {
            Vec::new()
        } else {
            let range = match channel.quantity {
                Quantity::AngularRate => options.gyro_range_rad_s,
                Quantity::SpecificForce => options.accel_range_m_s2,
                _ => None,
            };
            let place = channel::Place {
                name: &channel.name,
                clock: &clock,
                rows: &rows,
            };
            channel::saturation_issues(&place, values, &facts, range, &mut issues);
            let runs = channel::stuck_runs(values);
            channel::stuck_issues(&place, values.len(), &runs, &mut issues);
            channel::quantization_issue(&channel.name, &clock, &facts, &mut issues);
            runs.iter().map(rows).collect()
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
    if !options.moving {
        channel::units_issues(log, &clock, &mut issues);
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
        let is_sensor = !matches!(
            Quantity::of(&health.name),
            Quantity::Other | Quantity::Temperature
        );
        if is_sensor && !options.moving {
            channel::non_stationary_issues(health, &clock, &mut issues);
        }
    }
    let ends_s = [0, log.rows.saturating_sub(1)].map(|row| clock.absolute(row));
    issues.extend(short(log.rows, clock.duration_s(), ends_s.into()));
    issues.retain(|i| i.count > 0);
    // Where time goes back the last row need not be the latest.
    for i in issues.iter_mut().filter(|i| i.end_s < i.start_s) {
        (i.start_s, i.end_s) = (i.end_s, i.start_s);
    }
    issues.append(&mut thinned);
    Ok(Health {
        dt_s: dt,
        first_s: clock.absolute(0),
        duration_s: clock.duration_s(),
        stamp_step_s: clock.beat.grid_s,
        issues,
        channels,
        notes,
    })
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
        .map(|(channel, values)| match channel.quantity {
            Quantity::Other | Quantity::Temperature => Vec::new(),
            _ => channel::stuck_runs(values),
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

/// The finding of a log that is short as a whole; `ends_s` are the times of its first and last sample.
pub fn short(rows: usize, span_s: f64, ends_s: (f64, f64)) -> Option<Issue> {
    let text = if rows < FEWEST_NUMBERS {
        format!("{rows} samples: no parameters from fewer than {FEWEST_NUMBERS}")
    } else if span_s < 100.0 {
        format!("{span_s:.3} s: bias instability, walks and ramps only as upper limits under 100 s")
    } else {
        return None;
    };
    Some(Issue {
        kind: IssueKind::Short,
        channel: None,
        start_s: ends_s.0,
        end_s: ends_s.1,
        count: rows as u64,
        text,
    })
}

/// Findings as they are listed: neighbors joined, at most 100 of a kind, by kind, channel and time.
pub fn listed(issues: Vec<Issue>, dt_s: f64, first_s: f64) -> Vec<Issue> {
    // What is said of a channel as a whole is no neighbor of what is lost in places.
    let (whole, issues) = issues.into_iter().partition(thin::is_thin);
    let mut out = limit(&merge(issues, dt_s), first_s);
    for own in thin::joined(whole) {
        let place = (own.kind, own.channel.clone());
        let at = out.partition_point(|i| (i.kind, &i.channel) < (place.0, &place.1));
        out.insert(at, own);
    }
    out
}

/// Neighbors of one kind and channel, less than 1 s or 10 samples apart, become one.
fn merge(mut issues: Vec<Issue>, dt_s: f64) -> Vec<Issue> {
    issues.sort_by(|a, b| {
        (a.kind, &a.channel)
            .cmp(&(b.kind, &b.channel))
            .then(a.start_s.total_cmp(&b.start_s))
    });
    let near = (10.0 * dt_s).max(1.0);
    let mut out: Vec<Issue> = Vec::with_capacity(issues.len());
    let mut merged = 1_u64;
    for issue in issues {
        match out.last_mut() {
            Some(last)
                if last.kind == issue.kind
                    && last.channel == issue.channel
                    && issue.start_s - last.end_s < near =>
            {
                last.end_s = last.end_s.max(issue.end_s);
                last.count += issue.count;
                merged += 1;
                last.text = match (last.kind, last.channel.as_deref()) {
                    (IssueKind::Gap, _) => format!("{} samples lost in {merged} gaps", last.count),
                    (IssueKind::Duplicate, _) => {
                        format!("{} stamps equal to the one before; dropped", last.count)
                    }
                    (IssueKind::Nan, Some("time")) => {
                        format!(
                            "{} stamps are no numbers; taken as equally spaced",
                            last.count
                        )
                    }
                    (IssueKind::Nan, _) => format!("{} samples are no numbers", last.count),
                    _ => std::mem::take(&mut last.text),
                };
            }
            _ => {
                merged = 1;
                out.push(issue);
            }
        }
    }
    out
}

/// At most [`MOST_OF_A_KIND`] of a kind, shared among its channels so that each is named.
fn limit(issues: &[Issue], first_s: f64) -> Vec<Issue> {
    let mut out: Vec<Issue> = Vec::with_capacity(issues.len());
    // Sorted by kind and channel.
    for of_kind in issues.chunk_by(|a, b| a.kind == b.kind) {
        let channels: Vec<&[Issue]> = of_kind.chunk_by(|a, b| a.channel == b.channel).collect();
        let mut counts: Vec<usize> = channels.iter().map(|c| c.len()).collect();
        counts.sort_unstable();
        // Channels with few findings leave their share to the others.
        let (mut room, mut share) = (MOST_OF_A_KIND, usize::MAX);
        for (k, &count) in counts.iter().enumerate() {
            let each = (room / (counts.len() - k)).max(1);
            if count > each {
                share = each;
                break;
            }
            room = room.saturating_sub(count);
        }
        for channel in channels {
            let listed = channel.len().min(share);
            let (shown, rest) = channel.split_at(listed);
            out.extend_from_slice(shown);
            let end_s = rest.iter().map(|i| i.end_s - first_s).fold(0.0, f64::max);
            say_more(&mut out, (rest.len(), end_s));
        }
    }
    out
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

/// Robust standard deviation of values around zero: 1.4826·median|v|.
pub(crate) fn robust(values: &mut [f64]) -> f64 {
    for v in values.iter_mut() {
        *v = v.abs();
    }
    1.4826 * median(values).unwrap_or(f64::NAN)
}
