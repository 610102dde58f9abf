//! Accuracy, precision, resolution, sensitivity and linearity of one axis from pairs of reference and output.
//!
//! y = a + S·x by least squares; everything else is measured from that line or from repeated readings.
//! Lecture slides S1–S3, terms of `[IEEE528]`.
//!
//! ```
//! use sagnac_calibrate::response::{Reading, Options, respond};
//! let readings: Vec<Reading> = [(-1.0, -0.9), (0.0, 0.1), (1.0, 1.1), (0.0, 0.1), (-1.0, -0.9)]
//!     .map(|(x, y)| Reading::new(x, y)).into();
//! let response = respond(&readings, &Options { nominal_sensitivity: Some(1.0), ..Options::default() })?;
//! assert!((response.sensitivity.value - 1.0).abs() < 1e-12);
//! assert!((response.accuracy.unwrap().mean - 0.1).abs() < 1e-12);
//! // What the record cannot give says why.
//! assert!(respond(&readings[..2], &Options::default()).is_err());
//! # Ok::<(), sagnac_calibrate::response::Error>(())
//! ```

mod minimax;
mod points;
mod repeat;
mod threshold;

use nalgebra::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF as _, StudentsT};

pub use points::{Direction, Point};
pub use repeat::{Precision, Resolution};
pub use threshold::Threshold;

/// One reading: a true input and the output to it, each in one unit throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// True input x.
    pub reference: f64,
    /// Sensor output y.
    pub output: f64,
    /// How the input was reached; `None` where it is not known.
    pub direction: Option<Direction>,
    /// Standard error of the output, where known.
    pub output_se: Option<f64>,
}

impl Reading {
    /// A reading of unknown direction.
    pub fn new(reference: f64, output: f64) -> Self {
        Self {
            reference,
            output,
            direction: None,
            output_se: None,
        }
    }
}

/// What is known besides the record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Full scale, in the unit of the reference; else the largest |x|.
    pub full_scale: Option<f64>,
    /// S₀ of the accuracy's error y − S₀·x; `None`: no accuracy.
    pub nominal_sensitivity: Option<f64>,
}

/// A value with its standard deviation and 95 % limits (Student).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Best estimate.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Lower 95 % limit.
    pub lower: f64,
    /// Upper 95 % limit.
    pub upper: f64,
}

impl Interval {
    /// Whether the 95 % interval leaves out 0.
    pub fn excludes_zero(&self) -> bool {
        self.lower > 0.0 || self.upper < 0.0
    }
}

/// Departure of the points' means from a line, in output units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearity {
    /// From the least-squares line.
    pub least_squares: f64,
    /// From the line (α, β) that makes it smallest.
    pub minimax: f64,
    /// α of that line.
    pub minimax_offset: f64,
    /// β of that line.
    pub minimax_slope: f64,
}

/// Error e = y − S₀·x of the readings, in output units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Mean error.
    pub mean: f64,
    /// Largest |error|.
    pub max_abs: f64,
    /// 95 % interval of the error of a single reading.
    pub single_reading: [f64; 2],
}

/// Largest difference of the means going up and going down at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hysteresis {
    /// |up − down|, in output units.
    pub value: f64,
    /// Where, in the unit of the reference.
    pub at: f64,
}

/// Everything that a record says about one axis. What it cannot say is an `Err` with the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Slope S of the least-squares line.
    pub sensitivity: Interval,
    /// Offset a of that line.
    pub offset: f64,
    /// Full scale, in the unit of the reference.
    pub full_scale: f64,
    /// Residual standard deviation s about the line.
    pub residual_sigma: f64,
    /// Linearity.
    pub linearity: Result<Linearity, &'static str>,
    /// Accuracy; only as true as the reference.
    pub accuracy: Result<Accuracy, &'static str>,
    /// Precision (repeatability).
    pub precision: Result<Precision, &'static str>,
    /// Resolution, in the unit of the reference.
    pub resolution: Result<Resolution, &'static str>,
    /// LSB of the output, where its values show a grid.
    pub lsb: Option<f64>,
    /// Hysteresis.
    pub hysteresis: Result<Hysteresis, &'static str>,
    /// Threshold and dead band, in the unit of the reference.
    pub threshold: Result<Threshold, &'static str>,
    /// (S⁺ − S⁻)/((S⁺ + S⁻)/2), the `asymmetry` of the sensor model.
    pub asymmetry: Result<Interval, &'static str>,
    /// Points of equal reference, ascending.
    pub points: Vec<Point>,
    /// The direction in which each reading's input was reached.
    pub directions: Vec<Option<Direction>>,
}

/// Why a record gives nothing at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Too few rows for a line with a scatter.
    #[error("a response needs at least 3 readings, the table has {found}")]
    TooFewReadings {
        /// Readings in the table.
        found: usize,
    },
    /// One input only.
    #[error("all readings are at one reference, so no slope can be found")]
    OnePoint,
    /// A value that is no number.
    #[error("reading {row} is not a finite number")]
    NotFinite {
        /// Row, from 1.
        row: usize,
    },
    /// A standard error that cannot be one.
    #[error("the standard error of reading {row} is not above zero")]
    StandardError {
        /// Row, from 1.
        row: usize,
    },
    /// The output never changes.
    #[error("all outputs are equal: the sensor is stuck or not connected")]
    Stuck,
    /// A full scale that cannot be one.
    #[error("the full scale must be positive, not {value}")]
    FullScale {
        /// What was given.
        value: f64,
    },
}

impl Error {
    /// What to do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::TooFewReadings { .. } => {
                "add readings at other inputs, for instance up and down through the range"
            }
            Self::OnePoint => "add readings at other inputs",
            Self::NotFinite { .. } => "repair the row or leave it out",
            Self::StandardError { .. } => {
                "write the standard error of the reading, or leave the cell empty where it is not known"
            }
            Self::Stuck => "check the wiring and the output column",
            Self::FullScale { .. } => "give the largest input of the sensor as --full-scale",
        }
    }
}

/// Works out the response of one axis from its readings, in the order in which they were taken.
///
/// Directions that no reading has are taken from the sign of the change of reference. Accuracy of the numbers: double
/// precision sums about the mean, 1e-12 relative for records of usual size (checked against the worked example of
/// `tests/worked_example.rs`).
///
/// # Errors
/// Fewer than 3 readings or 2 points, values that are not finite, equal outputs, a full scale that is not positive.
pub fn respond(readings: &[Reading], options: &Options) -> Result<Response, Error> {
    check(readings, options)?;
    let full_scale = options.full_scale.unwrap_or_else(|| {
        readings
            .iter()
            .fold(0.0, |m: f64, r| m.max(r.reference.abs()))
    });
    if full_scale <= 0.0 {
        return Err(Error::OnePoint);
    }
    let tolerance = 1e-9 * full_scale;
    let directions = points::directions(readings, tolerance);
    let mut points = points::gather(readings, &directions, tolerance);
    if points.len() < 2 {
        return Err(Error::OnePoint);
    }
    if readings.iter().all(|r| r.output == readings[0].output) {
        return Err(Error::Stuck);
    }
    let line = Line::fit(readings);
    for point in &mut points {
        point.residual = point.mean - line.offset - line.slope * point.reference;
    }
    let precision = repeat::precision(readings, &directions, &points, tolerance);
    let lsb = repeat::lsb(readings);
    Ok(Response {
        sensitivity: student(line.slope, line.slope_sigma, readings.len() - 2),
        offset: line.offset,
        full_scale,
        residual_sigma: line.residual_sigma,
        linearity: minimax::linearity(&points),
        accuracy: accuracy(readings, options.nominal_sensitivity),
        resolution: repeat::resolution(precision.as_ref().ok(), lsb, line.slope),
        precision,
        lsb,
        hysteresis: hysteresis(&points),
        threshold: threshold::threshold(&points, line.slope, tolerance),
        asymmetry: asymmetry(readings),
        points,
        directions,
    })
}

fn check(readings: &[Reading], options: &Options) -> Result<(), Error> {
    if readings.len() < 3 {
        return Err(Error::TooFewReadings {
            found: readings.len(),
        });
    }
    for (i, r) in readings.iter().enumerate() {
        let se = r.output_se.unwrap_or(1.0);
        if ![r.reference, r.output, se].iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite { row: i + 1 });
        }
        if se <= 0.0 {
            return Err(Error::StandardError { row: i + 1 });
        }
    }
    match options.full_scale {
        Some(value) if value.is_nan() || value <= 0.0 || value.is_infinite() => {
            Err(Error::FullScale { value })
        }
        _ => Ok(()),
    }
}

/// Least-squares line y = a + S·x over all rows.
struct Line {
    offset: f64,
    slope: f64,
    slope_sigma: f64,
    residual_sigma: f64,
}

impl Line {
    fn fit(readings: &[Reading]) -> Self {
        let n = readings.len() as f64;
        let mean_x = readings.iter().map(|r| r.reference).sum::<f64>() / n;
        let mean_y = readings.iter().map(|r| r.output).sum::<f64>() / n;
        let (mut sxx, mut sxy) = (0.0, 0.0);
        for r in readings {
            let dx = r.reference - mean_x;
            sxx += dx * dx;
            sxy += dx * (r.output - mean_y);
        }
        let slope = sxy / sxx;
        let offset = mean_y - slope * mean_x;
        let rss: f64 = readings
            .iter()
            .map(|r| (r.output - mean_y - slope * (r.reference - mean_x)).powi(2))
            .sum();
        let residual_sigma = (rss / (n - 2.0)).sqrt();
        Self {
            offset,
            slope,
            slope_sigma: residual_sigma / sxx.sqrt(),
            residual_sigma,
        }
    }
}

/// Quantile of Student's t.
fn t_quantile(p: f64, dof: usize) -> f64 {
    StudentsT::new(0.0, 1.0, dof as f64).map_or(f64::NAN, |t| t.inverse_cdf(p))
}

/// Quantile of χ².
fn chi2_quantile(p: f64, dof: usize) -> f64 {
    sagnac_analysis::confidence::chi_squared_quantile(p, dof as f64)
}

fn student(value: f64, sigma: f64, dof: usize) -> Interval {
    let half = t_quantile(0.975, dof) * sigma;
    Interval {
        value,
        sigma,
        lower: value - half,
        upper: value + half,
    }
}

fn accuracy(readings: &[Reading], nominal: Option<f64>) -> Result<Accuracy, &'static str> {
    let nominal = nominal.ok_or(
        "the output is not in the unit of the reference and no nominal sensitivity was given",
    )?;
    let n = readings.len() as f64;
    let errors: Vec<f64> = readings
        .iter()
        .map(|r| r.output - nominal * r.reference)
        .collect();
    let mean = errors.iter().sum::<f64>() / n;
    let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let half = t_quantile(0.975, readings.len() - 1) * (variance * (1.0 + 1.0 / n)).sqrt();
    Ok(Accuracy {
        mean,
        max_abs: errors.iter().fold(0.0, |m, e| m.max(e.abs())),
        single_reading: [mean - half, mean + half],
    })
}

fn hysteresis(points: &[Point]) -> Result<Hysteresis, &'static str> {
    points
        .iter()
        .filter_map(|p| {
            Some(Hysteresis {
                value: (p.up? - p.down?).abs(),
                at: p.reference,
            })
        })
        .reduce(|a, b| if b.value > a.value { b } else { a })
        .ok_or("no point was read both going up and going down")
}

/// Least squares y = a' + S⁺·max(x, 0) + S⁻·min(x, 0); A = (S⁺ − S⁻)/M, M the mean slope.
fn asymmetry(readings: &[Reading]) -> Result<Interval, &'static str> {
    let plus = readings.iter().any(|r| r.reference > 0.0);
    let minus = readings.iter().any(|r| r.reference < 0.0);
    if !plus || !minus {
        return Err("the readings are on one side of zero only");
    }
    if readings.len() < 4 {
        return Err("three readings leave no scatter for two slopes and an offset");
    }
    // Scaled inputs keep the normal equations well conditioned whatever the unit.
    let scale = readings
        .iter()
        .fold(0.0, |m: f64, r| m.max(r.reference.abs()));
    let n = readings.len() as f64;
    let mean_y = readings.iter().map(|r| r.output).sum::<f64>() / n;
    let row = |r: &Reading| {
        Vector3::new(
            1.0,
            r.reference.max(0.0) / scale,
            r.reference.min(0.0) / scale,
        )
    };
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for r in readings {
        let v = row(r);
        normal += v * v.transpose();
        right += v * (r.output - mean_y);
    }
    let inverse = normal
        .try_inverse()
        .ok_or("the readings do not tell an offset from two slopes")?;
    let solution = inverse * right;
    let rss: f64 = readings
        .iter()
        .map(|r| (r.output - mean_y - row(r).dot(&solution)).powi(2))
        .sum();
    let dof = readings.len() - 3;
    let m = 0.5 * (solution[1] + solution[2]);
    if m == 0.0 {
        return Err("the mean slope is zero");
    }
    let a = (solution[1] - solution[2]) / m;
    let gradient = Vector3::new(0.0, (1.0 - a / 2.0) / m, -(1.0 + a / 2.0) / m);
    let variance = gradient.dot(&(inverse * gradient)) * rss / dof as f64;
    Ok(student(a, variance.sqrt(), dof))
}
