//! Bias (and scale factor) against temperature from a sensor at rest whose temperature is swept.
//!
//! output = b(T) + ½ s h(T), s = +1 heating, −1 cooling; order and form by 10-fold cross-validation over bins of the
//! branches, bands by Student's t with the correlation of neighbouring bins in them. `[STONE1974]`.
//!
//! ```
//! use sagnac_calibrate::thermal::{Options, Sweep, calibrate};
//! let t: Vec<f64> = (0..4000).map(|k| -20.0 + 80.0 * f64::from(k.min(3999 - k)) / 2000.0).collect();
//! // 0.01 rad/s at 25 °C and 2e-4 rad/s/K, with a wave that stands for noise.
//! let x: Vec<f64> = t.iter().zip(0..).map(|(t, k)| 0.01 + 2e-4 * (t - 25.0) + 1e-6 * f64::sin(1.7 * f64::from(k))).collect();
//! let zero = vec![0.0; 4000];
//! let sweep = Sweep { dt_s: 1.0, stamps_s: None, temperature_c: &t, gyro: Some([&x, &zero, &zero]), accel: None, up: None };
//! let found = calibrate(&[sweep], &Options::default())?;
//! let slope = found.parameters.iter().find(|p| p.name == "gyro.bias.temperature.1.x").unwrap();
//! assert!((slope.value - 2e-4).abs() < 1e-6);
//! # Ok::<(), sagnac_calibrate::thermal::Error>(())
//! ```

mod branches;
mod error;
mod fit;
mod walk;
mod write;

pub use error::Error;

use sagnac_core::Sensor;

use crate::stations::terms::AXES;
use branches::Bin;
use fit::{Basis, Design, Point};

/// A log of a sensor at rest, SI.
#[derive(Clone, Copy, Debug)]
pub struct Sweep<'a> {
    /// Sampling interval \[s\].
    pub dt_s: f64,
    /// Time stamps \[s\].
    pub stamps_s: Option<&'a [f64]>,
    /// Temperature \[°C\].
    pub temperature_c: &'a [f64],
    /// Gyro outputs \[rad/s\].
    pub gyro: Option<[&'a [f64]; 3]>,
    /// Accelerometer outputs \[m/s²\].
    pub accel: Option<[&'a [f64]; 3]>,
    /// Axis that points up and its sense: `(2, -1.0)` is −z.
    pub up: Option<(usize, f64)>,
}

impl<'a> Sweep<'a> {
    fn channels(&self) -> Vec<&'a [f64]> {
        self.gyro
            .iter()
            .chain(&self.accel)
            .flatten()
            .copied()
            .collect()
    }

    fn time_s(&self, k: usize) -> f64 {
        match self.stamps_s {
            Some(stamps) if k < stamps.len() => stamps[k],
            _ => (k + 1) as f64 * self.dt_s,
        }
    }

    fn start_s(&self, k: usize) -> f64 {
        match self.stamps_s {
            Some(stamps) if k > 0 && k <= stamps.len() => stamps[k - 1],
            Some(stamps) if !stamps.is_empty() => stamps[0] - self.dt_s,
            _ => k as f64 * self.dt_s,
        }
    }
}

/// Form of the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// A spline only where it beats the polynomial by two standard errors.
    #[default]
    Auto,
    /// Polynomial.
    Polynomial,
    /// Natural cubic spline.
    Spline,
}

/// What is known besides the logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// T0 \[°C\].
    pub reference_temperature_c: f64,
    /// Gravity \[m/s²\].
    pub gravity_m_s2: f64,
    /// Form of the curve.
    pub form: Form,
    /// Largest order of the polynomial.
    pub max_order: usize,
    /// Second halves of the soaks alone.
    pub is_soak_only: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reference_temperature_c: 25.0,
            gravity_m_s2: 9.80665,
            form: Form::Auto,
            max_order: 5,
            is_soak_only: false,
        }
    }
}

/// An estimated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its path.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Lower 95 % limit.
    pub lower: f64,
    /// Upper 95 % limit.
    pub upper: f64,
}

/// What a curve is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bias.
    Bias,
    /// Scale factor.
    ScaleFactor,
}

impl Kind {
    /// As scripts know it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::ScaleFactor => "scale_factor",
        }
    }
}

/// A stretch of time of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Number of the log, from 0.
    pub log: usize,
    /// Start \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Heating (branches).
    pub is_heating: bool,
    /// Mean temperature \[°C\].
    pub temperature_c: f64,
}

/// Largest hysteresis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hysteresis {
    /// Largest |heating − cooling|.
    pub largest: f64,
    /// Where \[°C\].
    pub at_c: f64,
    /// Heating − cooling at T0.
    pub at_reference: f64,
}

/// The curve of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Sensor.
    pub sensor: Sensor,
    /// Axis.
    pub axis: usize,
    /// What it is of.
    pub kind: Kind,
    /// Whether it is a spline.
    pub is_spline: bool,
    /// Order of the polynomial, or number of knots.
    pub order: usize,
    /// Temperatures \[°C\].
    pub temperature_c: Vec<f64>,
    /// Values, SI.
    pub value: Vec<f64>,
    /// Standard deviations.
    pub sigma: Vec<f64>,
    /// Lower 95 % limits.
    pub lower: Vec<f64>,
    /// Upper 95 % limits.
    pub upper: Vec<f64>,
    /// Heating − cooling at each; none where one direction was swept.
    pub heating_minus_cooling: Option<Vec<f64>>,
    /// The largest of it.
    pub hysteresis: Option<Hysteresis>,
    /// Root mean squared error of cross-validation of each order from 0 on; NaN where it cannot be fitted.
    pub cv_rms: Vec<f64>,
    /// The same of splines with 4, 5, … 12 knots.
    pub cv_rms_spline: Vec<f64>,
    /// Root mean square of all samples against b + ½ s h.
    pub residual_rms: f64,
    /// The same against b alone.
    pub residual_rms_single: f64,
    /// Correlation of neighbouring bins.
    pub correlation: f64,
    /// Means of the bins of every branch.
    pub bins: Vec<BinMean>,
}

/// What the samples of one bin of one branch say of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinMean {
    /// Number of the branch; the same number is the same branch of the same log.
    pub branch: usize,
    /// Whether it heats.
    pub is_heating: bool,
    /// Mean temperature \[°C\].
    pub temperature_c: f64,
    /// Mean output less known force, SI.
    pub value: f64,
    /// The same less b + ½ s h.
    pub residual: f64,
    /// The same less b alone, which is what a correction leaves.
    pub residual_single: f64,
}

/// A spline of a triad as the model holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct TriadSpline {
    /// Sensor.
    pub sensor: Sensor,
    /// What it is of.
    pub kind: Kind,
    /// Knots \[°C\].
    pub knots_c: Vec<f64>,
    /// Values of x, y, z at each, added to the fixed value.
    pub values: Vec<[f64; 3]>,
}

/// What a sweep gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Estimated terms.
    pub parameters: Vec<Parameter>,
    /// Covariance of all of them.
    pub covariance: Vec<Vec<f64>>,
    /// Terms that the logs do not determine.
    pub held: Vec<String>,
    /// Splines, where the form is one.
    pub splines: Vec<TriadSpline>,
    /// Swept range \[°C\].
    pub range_c: [f64; 2],
    /// Branches.
    pub branches: Vec<Stretch>,
    /// Soaks.
    pub soaks: Vec<Stretch>,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Root mean square over the axes of gyro and accelerometer of all samples.
    pub residual_rms: [Option<f64>; 2],
    /// Degrees of freedom, the smallest of the axes.
    pub dof: f64,
    /// What must be said.
    pub notes: Vec<String>,
}

/// One axis with its points and design.
struct Axis {
    sensor: Sensor,
    k: usize,
    points: Vec<Point>,
    with_scale: bool,
    /// Whether the level of the output is bias.
    has_level: bool,
    errors: Vec<Option<Vec<f64>>>,
    spline_errors: Vec<Option<Vec<f64>>>,
    design: Option<Design>,
}

/// Numbers of knots that are tried.
const KNOTS: std::ops::RangeInclusive<usize> = 4..=12;

/// Estimates the curves.
///
/// # Errors
/// See [`Error`].
pub fn calibrate(sweeps: &[Sweep], options: &Options) -> Result<Outcome, Error> {
    error::check(sweeps)?;
    let extremes = sweeps
        .iter()
        .map(|s| branches::range(s.temperature_c))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| {
            [a.min(c), b.max(d)]
        });
    let span = extremes[1] - extremes[0];
    error::spans(span, extremes)?;
    let mut found_branches = Vec::new();
    let mut soaks = Vec::new();
    let mut bins: Vec<Bin> = Vec::new();
    let mut all_branches = Vec::new();
    for (log, sweep) in sweeps.iter().enumerate() {
        let of_log = branches::branches(sweep.temperature_c, span);
        let of_soaks = branches::soaks(sweep.temperature_c, sweep.dt_s);
        let stretch = |first: usize, end: usize, is_heating: bool| {
            let part = &sweep.temperature_c[first..end];
            Stretch {
                log,
                start_s: sweep.start_s(first),
                end_s: sweep.time_s(end - 1),
                is_heating,
                temperature_c: part.iter().sum::<f64>() / part.len() as f64,
            }
        };
        found_branches.extend(of_log.iter().map(|b| stretch(b.first, b.end, b.sign > 0.0)));
        soaks.extend(of_soaks.iter().map(|(a, b)| stretch(*a, *b, false)));
        let only = options.is_soak_only.then_some(of_soaks.as_slice());
        branches::bins(log, sweep, &of_log, extremes[0], span, only, &mut bins);
        all_branches.push(of_log);
    }
    error::enough(&bins, options, soaks.len())?;
    let both = [1.0, -1.0]
        .iter()
        .all(|s| bins.iter().any(|b| b.sign == *s));
    let mut axes = axes(sweeps, options, &bins);
    let scale_k = (span / 2.0).max(1.0);
    choose(&mut axes, options, extremes, both, scale_k);
    let mut out = Outcome {
        parameters: Vec::new(),
        covariance: Vec::new(),
        held: Vec::new(),
        splines: Vec::new(),
        range_c: extremes,
        branches: found_branches,
        soaks,
        curves: Vec::new(),
        residual_rms: [None; 2],
        dof: f64::INFINITY,
        notes: Vec::new(),
    };
    for axis in &axes {
        write::axis(axis, sweeps, &all_branches, options, &mut out)?;
    }
    write::sensors(&axes, sweeps, &mut out);
    Ok(out)
}

/// The points of every axis that the logs have.
fn axes(sweeps: &[Sweep], options: &Options, bins: &[Bin]) -> Vec<Axis> {
    let g = options.gravity_m_s2;
    let mut place = 0;
    let mut out = Vec::new();
    for sensor in Sensor::ALL {
        let has = sweeps.first().is_some_and(|s| match sensor {
            Sensor::Gyro => s.gyro.is_some(),
            Sensor::Accel => s.accel.is_some(),
        });
        if !has {
            continue;
        }
        for k in 0..3 {
            let force = |log: usize| match (sensor, sweeps[log].up) {
                (Sensor::Accel, Some((axis, sense))) if axis == k => sense * g,
                _ => 0.0,
            };
            let mut points: Vec<Point> = bins
                .iter()
                .map(|bin| Point {
                    temperature_c: bin.temperature_c,
                    sign: bin.sign,
                    force: force(bin.log),
                    value: bin.outputs[place + k] - force(bin.log),
                    weight: bin.count,
                    log: bin.log,
                    elapsed_s: bin.elapsed_s,
                    branch: bin.log * 10_000 + bin.branch,
                    fold: 0,
                })
                .collect();
            points.sort_by(|a, b| a.temperature_c.total_cmp(&b.temperature_c));
            for (rank, p) in points.iter_mut().enumerate() {
                p.fold = rank % 10;
            }
            let forces = |sign: f64| points.iter().any(|p| p.force * sign > 0.0);
            out.push(Axis {
                sensor,
                k,
                with_scale: forces(1.0) && forces(-1.0),
                has_level: sensor == Sensor::Gyro || sweeps.iter().all(|s| s.up.is_some()),
                points,
                errors: Vec::new(),
                spline_errors: Vec::new(),
                design: None,
            });
        }
        place += 3;
    }
    out
}

/// Chooses form and order of every axis; a triad that takes a spline takes one set of knots.
fn choose(axes: &mut [Axis], options: &Options, range: [f64; 2], both: bool, scale_k: f64) {
    let zero_c = options.reference_temperature_c;
    let design = |basis: Basis, with_scale: bool| Design {
        basis,
        with_hysteresis: both,
        with_scale,
        zero_c,
        scale_k,
    };
    let mut knots: [Option<usize>; 2] = [None; 2];
    let mut chosen: Vec<Option<usize>> = Vec::new();
    for axis in axes.iter_mut() {
        axis.errors = (0..=options.max_order)
            .map(|order| {
                let d = design(Basis::polynomial(order, zero_c, scale_k), axis.with_scale);
                fit::cross_validate(&d, &axis.points)
            })
            .collect();
        if options.form != Form::Polynomial {
            axis.spline_errors = KNOTS
                .map(|count| {
                    let d = design(Basis::spline(count, range)?, axis.with_scale);
                    fit::cross_validate(&d, &axis.points)
                })
                .collect();
        }
        let order = fit::simplest(&axis.errors);
        let spline = fit::simplest(&axis.spline_errors);
        let wins = match (order, spline) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(o), Some(s)) => {
                let beats = match (&axis.errors[o], &axis.spline_errors[s]) {
                    (Some(p), Some(q)) => {
                        let (d, se) = fit::paired(p, q);
                        d > 2.0 * se
                    }
                    _ => false,
                };
                options.form == Form::Spline || beats
            }
        };
        if wins && let Some(s) = spline {
            let slot = &mut knots[axis.sensor.index()];
            *slot = (*slot).max(Some(s + KNOTS.start()));
        }
        chosen.push(order);
    }
    for (axis, order) in axes.iter_mut().zip(chosen) {
        let basis = match knots[axis.sensor.index()] {
            Some(count) => Basis::spline(count, range),
            None => None,
        };
        axis.design = basis
            .or_else(|| order.map(|o| Basis::polynomial(o, zero_c, scale_k)))
            .map(|basis| design(basis, axis.with_scale));
    }
}

/// `gyro_x`.
pub fn channel(sensor: Sensor, axis: usize) -> String {
    format!("{}_{}", sensor.key(), AXES[axis])
}
