//! `info`: what is in a log, and is it sound?
//!
//! A log comes in sections, so that memory does not grow with it; one that is no longer than a section is judged as a
//! whole.
//!
//! ```
//! use sagnac::info::{InfoRequest, info};
//! use sagnac::log::{ReadOptions, Source, open};
//! let rows: String = (0..200).map(|k| format!("{},{}\n", k as f64 / 100.0, (k * 7919 % 13) as f64)).collect();
//! let text = format!("time [s],gyro_x [mdps]\n{rows}");
//! let mut reader = open(Source::memory("a.csv", text.into()), &ReadOptions::default()).map_err(sagnac::Error::from)?;
//! let outcome = info(&mut *reader, &InfoRequest::default())?;
//! assert_eq!(outcome.to_json()["samples"], 200);
//! # Ok::<(), sagnac::Error>(())
//! ```

mod quick;
mod sections;
mod text;

use sagnac_log::health::{self, ChannelHealth, Health, HealthOptions};
use sagnac_log::{Channel, Issue, IssueKind, Layout, Log, LogReader, Sections};
use sagnac_report::text::Document;
use serde_json::{Value, json};

use crate::Error;
use crate::findings::{issue_json, number};

/// What is known besides the log.
#[derive(Debug, Clone, Default)]
pub struct InfoRequest {
    /// The sensor's model: its ranges tell saturation.
    pub model: Option<sagnac_model::Model>,
    /// Rows of a section; by default 2²¹ or 2²⁴ values, whatever is less.
    pub section_rows: Option<usize>,
}

/// Rows and values of a section, where nothing else is asked for.
const SECTION_ROWS: usize = 1 << 21;
const SECTION_VALUES: usize = 1 << 24;

/// What is in a log.
#[derive(Debug, Clone)]
pub struct InfoOutcome {
    /// Format, channels, topics, notes.
    pub layout: Layout,
    /// Rows.
    pub samples: usize,
    /// 1/dt.
    pub rate_hz: f64,
    /// From the first to the last sample, and dt.
    pub duration_s: f64,
    /// The grid that the stamps are rounded to, where it is about as coarse as dt or coarser.
    pub stamp_step_s: Option<f64>,
    /// A line a channel.
    pub channels: Vec<ChannelInfo>,
    /// Mean of |f| over the log [m/s²], of an accelerometer with three axes.
    pub force_m_s2: Option<f64>,
    /// Findings.
    pub issues: Vec<Issue>,
    /// Time of the first sample on the log's clock.
    pub first_s: f64,
    /// Whether the sensor was carried about: findings about a log at rest were then not looked for.
    pub is_moving: bool,
}

/// One channel in numbers, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelInfo {
    /// Name.
    pub name: String,
    /// SI unit, or the source's own.
    pub unit: String,
    /// Mean of the finite values.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Step of the values' grid.
    pub lsb: Option<f64>,
}

impl ChannelInfo {
    fn new(channel: &Channel, [mean, std, min, max]: [f64; 4], lsb: Option<f64>) -> Self {
        Self {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            mean,
            std,
            min,
            max,
            lsb,
        }
    }
}

/// Says what is in the log that `reader` gives.
///
/// # Errors
/// Those of the reader; time that never advances without a rate; a log without samples or numbers.
pub fn info(reader: &mut dyn LogReader, request: &InfoRequest) -> Result<InfoOutcome, Error> {
    let columns = reader.layout().channels.len() + 1;
    let rows = SECTION_ROWS.min(SECTION_VALUES / columns);
    let mut sections = Sections::new(reader, request.section_rows.unwrap_or(rows));
    let mut outcome = None;
    while let Some(section) = sections.next()? {
        if section.is_whole() {
            return of_whole(section.log, request);
        }
        outcome
            .get_or_insert_with(|| sections::Course::new(request))
            .add(&section)?;
    }
    outcome
        .unwrap_or_else(|| sections::Course::new(request))
        .finish()
}

/// What the health check may know besides the log.
fn options_of(request: &InfoRequest) -> HealthOptions {
    let range = |path: &str| {
        request
            .model
            .as_ref()
            .and_then(|m| m.triad(path))
            .map(|r| r.iter().copied().fold(f64::INFINITY, f64::min))
    };
    HealthOptions {
        gyro_range_rad_s: range("gyro.range"),
        accel_range_m_s2: range("accel.range"),
        moving: false,
    }
}

/// Says what is in a log that is held as a whole.
fn of_whole(log: &Log, request: &InfoRequest) -> Result<InfoOutcome, Error> {
    let mut options = options_of(request);
    let mut health = health::check(log, &options)?;
    let has_motion = health.issues.iter().any(|i| i.kind == IssueKind::Motion);
    let is_moving = has_motion && is_carried(stillness(&health));
    if is_moving {
        options.moving = true;
        health = health::check(log, &options)?;
    }
    // What a fit has to tell is for `characterize`.
    let mut issues = health.issues.clone();
    issues.retain(|i| i.kind != IssueKind::NonStationary);
    if !is_moving {
        issues.extend(quick::issues(log, &health));
    }
    issues.sort_by_key(|a| a.kind.is_note());
    let channels = log
        .layout
        .channels
        .iter()
        .zip(&health.channels)
        .map(|(c, h)| {
            let is_stuck =
                |i: &&Issue| i.kind == IssueKind::Stuck && i.channel.as_deref() == Some(&c.name);
            // What a stuck sensor says is left out of the numbers, as the finding says.
            let sound = health.issues.iter().find(is_stuck).and_then(|_| sound(h));
            let numbers = sound.unwrap_or([h.mean, h.std, h.min, h.max]);
            ChannelInfo::new(c, numbers, h.lsb)
        })
        .collect();
    let mut layout = log.layout.clone();
    layout.notes.extend_from_slice(&health.notes);
    Ok(InfoOutcome {
        layout,
        samples: log.rows,
        rate_hz: 1.0 / health.dt_s,
        duration_s: health.duration_s,
        stamp_step_s: health.stamp_step_s,
        channels,
        force_m_s2: health::mean_force(log),
        issues,
        first_s: health.first_s,
        is_moving,
    })
}

/// Mean, standard deviation, smallest and largest of the stretches that are sound; none where there is none.
fn sound(channel: &ChannelHealth<'_>) -> Option<[f64; 4]> {
    let values = || channel.slices().into_iter().flatten().copied();
    let count = values().count();
    if count == 0 {
        return None;
    }
    let mean = values().sum::<f64>() / count as f64;
    let square = values().map(|y| (y - mean).powi(2)).sum::<f64>() / count as f64;
    let min = values().fold(f64::INFINITY, f64::min);
    let max = values().fold(f64::NEG_INFINITY, f64::max);
    Some([mean, square.sqrt(), min, max])
}

/// Samples without motion, and all of them.
fn stillness(health: &Health<'_>) -> (usize, usize) {
    let mut of = (0, 0);
    for channel in &health.channels {
        of.0 += channel.quiet.iter().map(|s| s.range.len()).sum::<usize>();
        of.1 += channel
            .segments
            .iter()
            .map(|s| s.range.len())
            .sum::<usize>();
    }
    of
}

/// A sensor that is carried about: motion leaves less than [`LEAST_REST`] of the log. A log too short for numbers has
/// nothing still either, but no motion.
fn is_carried((still, all): (usize, usize)) -> bool {
    (still as f64) < LEAST_REST * all as f64
}

/// Share of a log that has to lie still for findings about a log at rest.
const LEAST_REST: f64 = 0.25;

impl InfoOutcome {
    /// The JSON document.
    pub fn to_json(&self) -> Value {
        let channels: Vec<Value> = self
            .channels
            .iter()
            .map(|c| {
                json!({
                    "name": c.name, "unit": c.unit, "mean": number(c.mean), "std": number(c.std),
                    "min": number(c.min), "max": number(c.max), "lsb": c.lsb,
                })
            })
            .collect();
        let topics: Vec<Value> = self
            .layout
            .topics
            .iter()
            .map(|t| json!({"name": t.name, "type": t.kind, "messages": t.messages, "inertial": t.is_inertial}))
            .collect();
        json!({
            "format": self.layout.format,
            "samples": self.samples,
            "rate_hz": number(self.rate_hz),
            "duration_s": number(self.duration_s),
            "stamp_step_s": self.stamp_step_s,
            "channels": channels,
            "issues": self.issues.iter().map(issue_json).collect::<Vec<_>>(),
            "topic": self.layout.topic,
            "topics": topics,
            "frame": self.layout.frame,
            "notes": self.layout.notes,
            "moving": self.is_moving,
        })
    }

    /// The text.
    pub fn document(&self) -> Document {
        text::document(self)
    }
}
