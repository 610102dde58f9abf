//! Stations out of a raw log: means and standard errors over time spans that are given or found.
//!
//! A dwell is cut in blocks of 1 s (of a fifth of the dwell where that is shorter); A = Allan variance of the block
//! means at lag one, pooled over the dwells of the log; se = √(A · block/(end − start)). One pass, constant memory.
//!
//! ```
//! use sagnac_calibrate::schedule::{Columns, Span, Spans};
//! let mut spans = Spans::new(&[Span { start_s: 0.0, end_s: 10.0, is_turn: false }]);
//! let times: Vec<f64> = (1..=1000).map(|k| f64::from(k) * 0.01).collect();
//! let up: Vec<f64> = (0..1000).map(|k| 9.8 + 1e-3 * f64::from(k % 2)).collect();
//! let columns: Columns = [None, None, None, None, None, Some(&up), None];
//! spans.push(&times, &columns);
//! let found = spans.finish();
//! assert!((found.rows[0].mean[5].unwrap() - 9.8005).abs() < 1e-9);
//! ```

mod dwells;
mod spans;

pub use dwells::Dwells;
pub use spans::Spans;

/// Channels of a log: gyro x, y, z, accelerometer x, y, z, temperature; those that it has.
pub type Columns<'a> = [Option<&'a [f64]>; CHANNELS];

/// Gyro, accelerometer, temperature.
pub const CHANNELS: usize = 7;
/// Channels whose noise counts.
pub(crate) const NOISY: usize = 6;

/// A span of a schedule: samples with start < t ≤ end belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Start \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Whether the sensor turns in it: it then tells nothing of the noise.
    pub is_turn: bool,
}

/// What a log holds over one span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduced {
    /// Start \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Samples in it.
    pub samples: u64,
    /// Means of the channels that the log has.
    pub mean: [Option<f64>; CHANNELS],
}

/// Every span, and the noise of the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reduction {
    /// Spans, in the order in which they were given or found.
    pub rows: Vec<Reduced>,
    /// Allan variance times block length of gyro and accelerometer channels; the square of a white noise density.
    pub density2: [Option<f64>; 6],
    /// First and last time of the log \[s\].
    pub extent_s: Option<[f64; 2]>,
}

impl Reduction {
    /// Standard errors of the means of a row's channels (three from `first`), where the noise is known.
    pub fn standard_errors(&self, row: &Reduced, first: usize) -> Option<[f64; 3]> {
        let mut out = [0.0; 3];
        for (k, se) in out.iter_mut().enumerate() {
            let density2 = self.density2.get(first + k).copied().flatten()?;
            *se = (density2 / (row.end_s - row.start_s)).sqrt();
        }
        out.iter().all(|se| *se > 0.0).then_some(out)
    }
}

/// Differences of neighboring block means, pooled.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pool {
    sum: [f64; NOISY],
    count: u64,
}

impl Pool {
    /// Adds the difference of two block means of a length.
    pub(crate) fn add(&mut self, before: &[f64; CHANNELS], after: &[f64; CHANNELS], block_s: f64) {
        for (k, sum) in self.sum.iter_mut().enumerate() {
            let step = after[k] - before[k];
            *sum += 0.5 * step * step * block_s;
        }
        self.count += 1;
    }

    pub(crate) fn density2(&self, has: [bool; CHANNELS]) -> [Option<f64>; 6] {
        std::array::from_fn(|k| (self.count > 0 && has[k]).then(|| self.sum[k] / self.count as f64))
    }
}

/// The length of the blocks of a dwell.
pub(crate) fn block_s(length_s: f64) -> f64 {
    (length_s / 5.0).min(1.0)
}
