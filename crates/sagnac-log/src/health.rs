//! Log health: what is wrong with a log, and the sound stretches that remain.
//!
//! Findings are those of the data-quality table that need no fitted noise model; the cleaned stretches follow from
//! them: short gaps filled by the line between their neighbors, long ones cutting the log, motion left out.

use std::borrow::Cow;
use std::ops::Range;

use crate::Issue;

/// The health of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Health<'a> {
    /// Sampling interval: the median step of time, refined over stretches without gaps, or 1/rate where it was given.
    pub dt_s: f64,
    /// Findings, by kind in the order of the table, then by channel and time.
    pub issues: Vec<Issue>,
    /// Statistics and cleaned samples of each channel, in the log's order.
    pub channels: Vec<ChannelHealth<'a>>,
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
    /// Samples on an even grid: the log's own where nothing had to be filled.
    pub values: Cow<'a, [f64]>,
    /// Row of the log at every start of `segments`' time: see [`Segment`].
    pub segments: Vec<Segment>,
    /// The same without motion: what parameters are estimated from.
    pub quiet: Vec<Segment>,
}

/// A stretch of evenly spaced samples without gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Its samples, as a range of [`ChannelHealth::values`].
    pub range: Range<usize>,
    /// Time of its first sample, in seconds from the log's first sample.
    pub start_s: f64,
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
    /// True where the log is no recording at rest (info of a drive): motion and |w| are then no findings.
    pub moving: bool,
}
