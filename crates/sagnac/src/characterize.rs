//! From logs at rest to noise terms of each axis with intervals: health, Allan deviations, the joint estimate.
//!
//! Every axis goes through [`sagnac_analysis::fit`]; what health and fit find stands in `issues`; several logs are
//! different sensors, or with `one_sensor` one likelihood.

mod findings;
mod held;
mod json;
mod levels;
mod model_file;
mod once;
mod page;
mod page_regressors;
mod page_words;
mod pool;
mod pooled_text;
mod removed;
mod series;
mod terms;
mod text;

use crate::Error;
use rayon::prelude::*;
use sagnac_analysis::compare::Outlier;
use sagnac_analysis::fit::{
    AxisData, AxisEstimate, Candidates, FitOptions, PooledEstimate, Segment, estimate,
    filled_deviation,
};
use sagnac_analysis::{Curve, Deviation, TauGrid, compare, deviations};
use sagnac_core::Sensor;
use sagnac_log::health::{self, Health, HealthOptions};
use sagnac_log::{Issue, Layout, Log};
use sagnac_model::Model;
use sagnac_report::text::{duration, general};

pub use json::estimate_json;
pub(crate) use once::once;
pub use page::PageFacts;
pub(crate) use page::allan as allan_panel;
pub use terms::{TermKey, candidates, dimension_of, key_of};
pub(crate) use text::{remarks, shown, shown_sensor, table as estimates_table};

/// A log with the name that results call it by.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedLog {
    /// Name of the file, or `standard input`.
    pub name: String,
    /// The log.
    pub log: Log,
}

/// What is wanted.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The terms looked for.
    pub candidates: Candidates,
    /// All logs are of one sensor.
    pub one_sensor: bool,
    /// Any issue but notes is an error before numbers.
    pub strict: bool,
    /// A model that gives the range and the bias.
    pub model: Option<Model>,
}

/// One axis of one log.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisOutcome {
    /// Channel: `gyro_x`.
    pub axis: String,
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// 0, 1, 2 for x, y, z.
    pub index: usize,
    /// Step of the values' grid, in SI.
    pub lsb: Option<f64>,
    /// Whether the log held increments.
    pub from_increments: bool,
    /// The joint estimate; none where the channel gives no numbers.
    pub estimate: Option<AxisEstimate>,
    /// Measured overlapping Allan deviation.
    pub allan: Option<Curve>,
    /// Allan deviation of the fit at the same averaging times.
    pub fit_deviation: Vec<f64>,
    /// The channel in at most 720 pieces: time, smallest, mean, largest; pieces without numbers between them part what a
    /// gap parts.
    pub series: Vec<[f64; 4]>,
    /// Standard deviation of its samples.
    pub scatter: f64,
    /// Robust scatter of its noise from sample to sample, which findings about rounding speak of.
    pub noise_scatter: f64,
}

/// One log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogOutcome {
    /// Its name.
    pub name: String,
    /// The format in words.
    pub format: String,
    /// Rows.
    pub samples: usize,
    /// Samples a second.
    pub rate_hz: f64,
    /// Length, in s.
    pub duration_s: f64,
    /// Time of the first sample on the log's own clock, in s.
    pub first_s: f64,
    /// What was found, on the log's own clock.
    pub issues: Vec<Issue>,
    /// Sentences about reading it.
    pub notes: Vec<String>,
    /// Axes in the order gyro x, y, z, accel x, y, z.
    pub axes: Vec<AxisOutcome>,
    /// Mean temperature and its range [°C], where there is a channel.
    pub temperature_c: Option<(f64, f64, f64)>,
    /// Mean of |f| over the log [m/s²], of an accelerometer with three axes.
    pub force_m_s2: Option<f64>,
}

/// A log named because it differs from the others.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlierNote {
    /// Index of the log.
    pub log: usize,
    /// The axis.
    pub axis: String,
    /// What differs.
    pub outlier: Outlier,
    /// What is said of it, without log and axis.
    pub remark: String,
    /// The sentence.
    pub text: String,
}

/// One axis of the sensor that several logs are of.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorAxis {
    /// Channel.
    pub axis: String,
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// 0, 1, 2 for x, y, z.
    pub index: usize,
    /// The pooled estimate of the logs that agree; its outliers are the others, by their place in the outcome.
    pub pooled: PooledEstimate,
    /// Logs that are in it.
    pub runs: usize,
    /// Logs that give numbers for it, by their place in the outcome: those and the outliers left out.
    pub used: Vec<usize>,
}

/// What the logs say.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Each log.
    pub logs: Vec<LogOutcome>,
    /// The sensor of all logs, where asked for.
    pub sensor: Option<Vec<SensorAxis>>,
    /// Logs that differ from the others.
    pub outliers: Vec<OutlierNote>,
}

/// Characterizes logs at rest.
///
/// # Errors
/// No logs, no axes, a log without a rate, with `one_sensor` a log that is given twice; with `strict` the first issue that is more than a note.
pub fn characterize(logs: &[NamedLog], request: &Request) -> Result<Outcome, Error> {
    if logs.is_empty() {
        return Err(Error::usage("no log is named").advise("sagnac characterize static.csv"));
    }
    if request.one_sensor {
        once(logs)?;
    }
    let options = FitOptions {
        candidates: request.candidates,
        ..FitOptions::default()
    };
    let health_options = range_of(request.model.as_ref());
    let mut outcomes = Vec::with_capacity(logs.len());
    let mut healths = Vec::with_capacity(logs.len());
    for named in logs {
        let health = health::check(&named.log, &health_options)
            .map_err(|e| Error::from(e).at(&named.name))?;
        if request.strict {
            findings::refuse(&named.name, &health.issues, health.first_s)?;
        }
        let outcome = one_log(named, &health, &options, request.model.as_ref())?;
        if request.strict {
            findings::refuse(&named.name, &outcome.issues, outcome.first_s)?;
        }
        outcomes.push(outcome);
        healths.push(health);
    }
    let mut outliers = Vec::new();
    let sensor = if request.one_sensor && logs.len() > 1 {
        let axes = pool::pooled(&outcomes, &healths, &options)?;
        for axis in &axes {
            let own = axis.pooled.outliers.iter();
            outliers.extend(own.map(|o| pool::note(o, axis, &outcomes)));
        }
        Some(axes)
    } else {
        if logs.len() > 3 {
            for name in axis_names(&outcomes) {
                let estimates: Vec<Option<&AxisEstimate>> = outcomes
                    .iter()
                    .map(|log| {
                        let axis = log.axes.iter().find(|a| a.axis == name)?;
                        axis.estimate.as_ref()
                    })
                    .collect();
                for outlier in compare::fleet_outliers(&estimates) {
                    outliers.push(pool::fleet_note(outlier, &name, &outcomes));
                }
            }
        }
        None
    };
    Ok(Outcome {
        logs: outcomes,
        sensor,
        outliers,
    })
}

fn range_of(model: Option<&Model>) -> HealthOptions {
    let largest = |path: &str| {
        let path = path.parse().ok()?;
        model?.largest(path)
    };
    HealthOptions {
        gyro_range_rad_s: largest("gyro.range"),
        accel_range_m_s2: largest("accel.range"),
        ..HealthOptions::default()
    }
}

/// Sensor and axis of a channel name.
fn axis_of(name: &str) -> Option<(Sensor, usize)> {
    let (sensor, axis) = name.split_once('_')?;
    let sensor = Sensor::ALL.into_iter().find(|s| s.key() == sensor)?;
    let index = ["x", "y", "z"].iter().position(|a| *a == axis)?;
    Some((sensor, index))
}

/// Temperature over the same segments as a channel, on the channel's own grid.
fn temperature_of<'a>(health: &'a Health<'_>, channel: usize) -> Option<Vec<Segment<'a>>> {
    let temperature = health.channels.iter().find(|c| c.name == "temperature")?;
    let own = &health.channels[channel];
    if temperature.values.len() != own.values.len() {
        return None;
    }
    let mut out = Vec::with_capacity(own.quiet.len());
    for segment in &own.quiet {
        let samples = temperature.values.get(segment.range.clone())?;
        if samples.iter().any(|t| !t.is_finite()) {
            return None;
        }
        out.push(Segment {
            start_s: segment.start_s,
            samples,
            filled: &segment.filled,
        });
    }
    Some(out)
}

fn segments_of<'a>(health: &'a Health<'_>, channel: usize) -> Vec<Segment<'a>> {
    let own = &health.channels[channel];
    own.quiet
        .iter()
        .filter_map(|s| {
            let samples = own.values.get(s.range.clone())?;
            Some(Segment {
                start_s: s.start_s,
                samples,
                filled: &s.filled,
            })
        })
        .filter(|s| !s.samples.is_empty() && s.samples.iter().all(|y| y.is_finite()))
        .collect()
}

fn one_log(
    named: &NamedLog,
    health: &Health<'_>,
    options: &FitOptions,
    model: Option<&Model>,
) -> Result<LogOutcome, Error> {
    let mut places: Vec<(usize, Sensor, usize)> = health
        .channels
        .iter()
        .enumerate()
        .filter_map(|(i, c)| axis_of(&c.name).map(|(s, a)| (i, s, a)))
        .collect();
    places.sort_by_key(|&(_, sensor, axis)| (sensor.index(), axis));
    if places.is_empty() {
        return Err(Error::data("the log has no gyro and no accelerometer axis")
            .at(&named.name)
            .advise("name them, for instance --columns 'gyro=1,2,3:deg/s, accel=4,5,6:g'"));
    }
    let axes: Vec<AxisOutcome> = places
        .par_iter()
        .map(|&(channel, sensor, index)| one_axis(named, health, options, (channel, sensor, index)))
        .collect();
    let temperature_c = health
        .channels
        .iter()
        .find(|c| c.name == "temperature" && c.mean.is_finite())
        .map(|c| (c.mean, c.min, c.max));
    let mut outcome = LogOutcome {
        name: named.name.clone(),
        format: named.log.layout.format.clone(),
        samples: named.log.rows,
        rate_hz: 1.0 / health.dt_s,
        duration_s: health.duration_s,
        first_s: health.first_s,
        issues: health.issues.clone(),
        notes: notes(&named.log.layout, health),
        axes,
        temperature_c,
        force_m_s2: health::mean_force(&named.log),
    };
    findings::add(&mut outcome, health.dt_s, model);
    removed::add(&mut outcome, health);
    held::add(&mut outcome, &named.log);
    Ok(outcome)
}

/// What the reader and the health check said, and stamps too coarse to tell the rate by.
fn notes(layout: &Layout, health: &Health<'_>) -> Vec<String> {
    let mut notes = [layout.notes.as_slice(), &health.notes].concat();
    if let Some(step_s) = health.stamp_step_s.filter(|_| layout.rate_hz.is_none()) {
        notes.push(format!(
            "rate {} Hz from time stamps in coarse steps of {}; give --rate if you know it",
            general(1.0 / health.dt_s, 6),
            duration(step_s)
        ));
    }
    notes
}

fn one_axis(
    named: &NamedLog,
    health: &Health<'_>,
    options: &FitOptions,
    place: (usize, Sensor, usize),
) -> AxisOutcome {
    let (channel, sensor, index) = place;
    let own = &health.channels[channel];
    let segments = segments_of(health, channel);
    let temperature = temperature_of(health, channel);
    let estimate = (!segments.is_empty()).then(|| {
        estimate(
            &AxisData {
                segments: &segments,
                temperature: temperature.as_deref(),
                step_s: own.step_s,
                lsb: own.lsb,
            },
            options,
        )
    });
    let slices: Vec<&[f64]> = segments.iter().map(|s| s.samples).collect();
    let mut allan = deviations(&slices, own.step_s, Deviation::Oadev, &TauGrid::Default).ok();
    if let (Some(curve), Some(e)) = (&mut allan, &estimate)
        && let Some(factors) = filled_deviation(&segments, &e.fitted, own.step_s, &curve.factor)
    {
        unfill(curve, &factors);
    }
    let fit_deviation = match (&allan, &estimate) {
        (Some(curve), Some(e)) => curve
            .tau_s
            .iter()
            .map(|&tau| e.fitted.allan_variance(tau).sqrt())
            .collect(),
        _ => Vec::new(),
    };
    let from_increments = named
        .log
        .layout
        .channels
        .get(channel)
        .is_some_and(|c| c.from_increments);
    AxisOutcome {
        axis: own.name.clone(),
        sensor,
        index,
        lsb: own.lsb,
        from_increments,
        estimate,
        allan,
        fit_deviation,
        series: series::pieces(own, health.duration_s),
        scatter: own.std,
        noise_scatter: own.sigma_w,
    }
}

/// Takes out of a curve what filling lost samples by lines made of it.
fn unfill(curve: &mut Curve, factors: &[f64]) {
    for (k, factor) in factors.iter().enumerate() {
        curve.deviation[k] *= factor;
        for end in [&mut curve.lower[k], &mut curve.upper[k]] {
            *end = end.map(|v| v * factor);
        }
    }
}

fn axis_names(logs: &[LogOutcome]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for axis in logs.iter().flat_map(|l| &l.axes) {
        if !names.contains(&axis.axis) {
            names.push(axis.axis.clone());
        }
    }
    names
}

impl Outcome {
    /// As the command prints it: keys and units as scripts rely on.
    pub fn to_json(&self) -> serde_json::Value {
        json::outcome(self)
    }

    /// As a terminal shows it.
    pub fn document(&self) -> sagnac_report::text::Document {
        text::outcome(self)
    }

    /// The model of what was estimated, named after the log.
    ///
    /// # Errors
    /// Where a value cannot stand in a model.
    pub fn to_model(&self) -> Result<Model, Error> {
        model_file::model(self)
    }

    /// What is said of the logs that differ: a sentence a log, with the axes that it concerns.
    pub fn differences(&self) -> Vec<String> {
        pool::sentences(self)
    }

    /// The page of the report.
    pub fn to_page(&self, facts: &PageFacts) -> sagnac_report::html::CharacterizePage {
        page::page(self, facts)
    }
}
