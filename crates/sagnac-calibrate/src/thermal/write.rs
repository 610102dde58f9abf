//! Curves with bands, parameters with covariance, hysteresis and residuals of every axis.

use nalgebra::{DMatrix, DVector};
use sagnac_core::Sensor;

use super::branches::Branch;
use super::fit::{self, Basis, Design, Point, Solution};
use super::walk;
use super::{
    Axis, BinMean, Curve, Error, Hysteresis, Kind, Options, Outcome, Parameter, Sweep, TriadSpline,
    channel,
};
use crate::interval::student_975;
use crate::stations::terms::AXES;

/// Points of a curve.
const POINTS: usize = 41;
/// Correlation of neighbouring bins that counts.
const CORRELATED: f64 = 0.2;

/// Rows that give the parameters of a curve from the coefficients: fixed value at T0, then powers or knots.
fn transform(basis: &Basis, zero_c: f64) -> (DMatrix<f64>, Vec<String>) {
    match basis {
        Basis::Polynomial { order, scale_k, .. } => (
            DMatrix::from_fn(order + 1, order + 1, |i, j| {
                if i == j {
                    scale_k.powi(-(i as i32))
                } else {
                    0.0
                }
            }),
            (0..=*order)
                .map(|i| {
                    if i == 0 {
                        String::new()
                    } else {
                        format!("temperature.{i}")
                    }
                })
                .collect(),
        ),
        Basis::Spline { knots_c, .. } => {
            let n = knots_c.len();
            let at = basis.row(zero_c);
            (
                DMatrix::from_fn(n + 1, n, |i, j| {
                    if i == 0 {
                        at[j]
                    } else {
                        f64::from(u8::from(i == j + 1)) - at[j]
                    }
                }),
                (0..=n)
                    .map(|i| {
                        if i == 0 {
                            String::new()
                        } else {
                            format!("temperature_spline.{i}")
                        }
                    })
                    .collect(),
            )
        }
    }
}

/// An estimate with its inflated covariance and quantile.
struct Banded<'a> {
    design: &'a Design,
    fit: Solution,
    covariance: DMatrix<f64>,
    quantile: f64,
}

impl Banded<'_> {
    fn value(&self, first: usize, row: &[f64]) -> (f64, f64) {
        let part = self.fit.values.rows(first, row.len());
        let value = row.iter().zip(part.iter()).map(|(a, b)| a * b).sum();
        let r = DVector::from_row_slice(row);
        let c = self.covariance.view((first, first), (row.len(), row.len()));
        (value, (r.transpose() * c * &r)[(0, 0)].max(0.0).sqrt())
    }
}

/// Covariance of the coefficients: of white noise and a walk, and at least (1+ρ)/(1−ρ) times that of white noise alone
/// where neighbouring bins scatter together.
fn covariance(
    design: &Design,
    fit: &Solution,
    points: &[Point],
    correlation: f64,
    dof: f64,
) -> DMatrix<f64> {
    let inflation = if correlation > CORRELATED {
        (1.0 + correlation) / (1.0 - correlation)
    } else {
        1.0
    };
    let white = &fit.inverse * (fit.sum / dof * inflation);
    let Some(scatter) = walk::scatter(design, points) else {
        return white;
    };
    let walked = walk::covariance(design, fit, points, scatter);
    let short = (0..white.nrows()).fold(1.0, |m: f64, i| m.max(white[(i, i)] / walked[(i, i)]));
    walked * short
}

/// Writes curves and parameters of an axis.
pub(super) fn axis(
    axis: &Axis,
    sweeps: &[Sweep],
    branches: &[Vec<Branch>],
    options: &Options,
    out: &mut Outcome,
) -> Result<(), Error> {
    let singular = || Error::Singular {
        axis: channel(axis.sensor, axis.k),
    };
    let design = axis.design.as_ref().ok_or_else(singular)?;
    let fit = fit::solve(design, &axis.points, None).ok_or_else(singular)?;
    let correlation = fit::neighbours(design, &fit, &axis.points);
    let dof = (axis.points.len() - design.columns()).max(1) as f64;
    out.dof = out.dof.min(dof);
    let banded = Banded {
        covariance: covariance(design, &fit, &axis.points, correlation, dof),
        fit,
        design,
        quantile: student_975(dof),
    };
    let [residual, single] = residuals(axis, &banded, sweeps, branches, options);
    let parts = design.parts();
    let mut kinds = vec![(Kind::Bias, 0)];
    if parts[2] > 0 {
        kinds.push((Kind::ScaleFactor, parts[0] + parts[1]));
    }
    for (kind, first) in kinds {
        out.curves.push(curve(
            axis,
            kind,
            first,
            &banded,
            [residual, single, correlation],
            options,
            out.range_c,
        ));
        parameters(axis, kind, first, &banded, options, out);
    }
    Ok(())
}

fn curve(
    axis: &Axis,
    kind: Kind,
    first: usize,
    banded: &Banded,
    [residual_rms, residual_rms_single, correlation]: [f64; 3],
    options: &Options,
    [low, high]: [f64; 2],
) -> Curve {
    let temperature_c: Vec<f64> = (0..POINTS)
        .map(|i| low + (high - low) * i as f64 / (POINTS - 1) as f64)
        .collect();
    let design = banded.design;
    let (mut value, mut sigmas) = (Vec::new(), Vec::new());
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for t in &temperature_c {
        let (v, sigma) = banded.value(first, &design.basis.row(*t));
        value.push(v);
        sigmas.push(sigma);
        lower.push(v - banded.quantile * sigma);
        upper.push(v + banded.quantile * sigma);
    }
    let parts = design.parts();
    let of = |t: f64| banded.value(parts[0], &design.hysteresis_row(t)).0;
    let both = parts[1] > 0 && kind == Kind::Bias;
    let difference: Option<Vec<f64>> = both.then(|| temperature_c.iter().map(|t| of(*t)).collect());
    let hysteresis = difference.as_ref().and_then(|d| {
        let at = (0..d.len()).max_by(|a, b| d[*a].abs().total_cmp(&d[*b].abs()))?;
        Some(Hysteresis {
            largest: d[at].abs(),
            at_c: temperature_c[at],
            at_reference: of(options.reference_temperature_c.clamp(low, high)),
        })
    });
    let rms = |errors: &[Option<Vec<f64>>]| -> Vec<f64> {
        errors
            .iter()
            .map(|e| {
                e.as_ref().map_or(f64::NAN, |e| {
                    (e.iter().sum::<f64>() / e.len() as f64).sqrt()
                })
            })
            .collect()
    };
    let (is_spline, order) = match &design.basis {
        Basis::Polynomial { order, .. } => (false, *order),
        Basis::Spline { knots_c, .. } => (true, knots_c.len()),
    };
    Curve {
        sensor: axis.sensor,
        axis: axis.k,
        kind,
        is_spline,
        order,
        temperature_c,
        value,
        sigma: sigmas,
        lower,
        upper,
        heating_minus_cooling: difference,
        hysteresis,
        cv_rms: rms(&axis.errors),
        cv_rms_spline: rms(&axis.spline_errors),
        residual_rms,
        residual_rms_single,
        correlation,
        bins: axis.points.iter().map(|p| bin_mean(banded, p)).collect(),
    }
}

fn bin_mean(banded: &Banded, p: &Point) -> BinMean {
    let row = banded.design.row(p.temperature_c, p.sign, p.force);
    let parts = banded.design.parts();
    let sum = |range: std::ops::Range<usize>| -> f64 {
        range.map(|j| row[j] * banded.fit.values[j]).sum()
    };
    let hysteresis = sum(parts[0]..parts[0] + parts[1]);
    let residual = p.value - sum(0..row.len());
    BinMean {
        branch: p.branch,
        is_heating: p.sign > 0.0,
        temperature_c: p.temperature_c,
        value: p.value,
        residual,
        residual_single: residual + hysteresis,
    }
}

fn parameters(
    axis: &Axis,
    kind: Kind,
    first: usize,
    banded: &Banded,
    options: &Options,
    out: &mut Outcome,
) {
    let basis = &banded.design.basis;
    let [low, high] = out.range_c;
    let zero_c = match basis {
        Basis::Spline { .. } => options.reference_temperature_c.clamp(low, high),
        Basis::Polynomial { .. } => options.reference_temperature_c,
    };
    let (rows, suffixes) = transform(basis, zero_c);
    let n = basis.len();
    let values = &rows * banded.fit.values.rows(first, n);
    let covariance = &rows * banded.covariance.view((first, first), (n, n)) * rows.transpose();
    let has_level = axis.has_level || kind == Kind::ScaleFactor;
    let kept: Vec<usize> = (0..suffixes.len())
        .filter(|i| has_level || *i > 0)
        .collect();
    let stem = format!("{}.{}", axis.sensor.key(), kind.key());
    let letter = AXES[axis.k];
    for i in &kept {
        let sigma = covariance[(*i, *i)].max(0.0).sqrt();
        let suffix = &suffixes[*i];
        out.parameters.push(Parameter {
            name: if suffix.is_empty() {
                format!("{stem}.{letter}")
            } else {
                format!("{stem}.{suffix}.{letter}")
            },
            value: values[*i],
            sigma,
            lower: values[*i] - banded.quantile * sigma,
            upper: values[*i] + banded.quantile * sigma,
        });
    }
    if !has_level {
        out.held.push(format!("{stem}.{letter}"));
    }
    let before = out.covariance.len();
    for row in &mut out.covariance {
        row.extend(std::iter::repeat_n(0.0, kept.len()));
    }
    for i in &kept {
        let mut row = vec![0.0; before];
        row.extend(kept.iter().map(|j| covariance[(*i, *j)]));
        out.covariance.push(row);
    }
    if let Basis::Spline { knots_c, .. } = basis {
        let place = out
            .splines
            .iter()
            .position(|s| s.sensor == axis.sensor && s.kind == kind)
            .unwrap_or_else(|| {
                out.splines.push(TriadSpline {
                    sensor: axis.sensor,
                    kind,
                    knots_c: knots_c.clone(),
                    values: vec![[0.0; 3]; knots_c.len()],
                });
                out.splines.len() - 1
            });
        for (i, row) in out.splines[place].values.iter_mut().enumerate() {
            row[axis.k] = values[i + 1];
        }
    }
}

/// Root mean square of all samples against b + ½ s h, and against b alone.
fn residuals(
    axis: &Axis,
    banded: &Banded,
    sweeps: &[Sweep],
    branches: &[Vec<Branch>],
    options: &Options,
) -> [f64; 2] {
    let parts = banded.design.parts();
    let (mut with, mut alone, mut n) = (0.0, 0.0, 0.0);
    for (sweep, of_log) in sweeps.iter().zip(branches) {
        let Some(axes) = (match axis.sensor {
            Sensor::Gyro => sweep.gyro,
            Sensor::Accel => sweep.accel,
        }) else {
            continue;
        };
        let force = match (axis.sensor, sweep.up) {
            (Sensor::Accel, Some((k, sense))) if k == axis.k => sense * options.gravity_m_s2,
            _ => 0.0,
        };
        for branch in of_log {
            for k in branch.first..branch.end.min(axes[axis.k].len()) {
                let (t, y) = (sweep.temperature_c[k], axes[axis.k][k]);
                if !t.is_finite() || !y.is_finite() {
                    continue;
                }
                let row = banded.design.row(t, branch.sign, force);
                let sum = |range: std::ops::Range<usize>| -> f64 {
                    range.map(|j| row[j] * banded.fit.values[j]).sum()
                };
                let hysteresis = sum(parts[0]..parts[0] + parts[1]);
                let rest = sum(0..parts[0]) + sum(parts[0] + parts[1]..row.len());
                let r = y - force - rest;
                with += (r - hysteresis).powi(2);
                alone += r * r;
                n += 1.0;
            }
        }
    }
    [
        (with / f64::max(n, 1.0)).sqrt(),
        (alone / f64::max(n, 1.0)).sqrt(),
    ]
}

/// What concerns whole sensors: residuals, what is not determined, what must be said.
pub(super) fn sensors(axes: &[Axis], sweeps: &[Sweep], out: &mut Outcome) {
    for sensor in Sensor::ALL {
        let all: Vec<f64> = out
            .curves
            .iter()
            .filter(|c| c.sensor == sensor && c.kind == Kind::Bias)
            .map(|c| c.residual_rms)
            .collect();
        if !all.is_empty() {
            let mean = all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64;
            out.residual_rms[sensor.index()] = Some(mean.sqrt());
        }
    }
    let correlated: Vec<String> = out
        .curves
        .iter()
        .filter(|c| c.correlation > CORRELATED && c.kind == Kind::Bias)
        .map(|c| channel(c.sensor, c.axis))
        .collect();
    if !correlated.is_empty() {
        out.notes.push(format!(
            "neighbouring temperatures scatter together ({}): the bands are widened for it",
            correlated.join(", ")
        ));
    }
    let has_accel = axes.iter().any(|a| a.sensor == Sensor::Accel);
    if has_accel {
        for axis in axes
            .iter()
            .filter(|a| a.sensor == Sensor::Accel && !a.with_scale)
        {
            out.held
                .push(format!("accel.scale_factor.temperature.1.{}", AXES[axis.k]));
        }
        let known = sweeps.iter().all(|s| s.up.is_some());
        let apart: Vec<&str> = axes
            .iter()
            .filter(|a| a.with_scale)
            .map(|a| AXES[a.k])
            .collect();
        if !known {
            out.notes.push(
                "without --up the accelerometer's level is unknown: only its change with temperature is estimated"
                    .to_owned(),
            );
        } else if apart.is_empty() {
            out.notes.push(
                "one orientation gives bias and scale factor of the axis that points up as their sum, called bias: add a \
                 log with that axis down"
                    .to_owned(),
            );
        }
        out.notes.push(
            "what is sensor and what is tilt of the fixture with temperature cannot be told apart"
                .to_owned(),
        );
    }
    if !out.branches.iter().any(|b| b.is_heating) || out.branches.iter().all(|b| b.is_heating) {
        out.notes.push(
            "the temperature was swept in one direction alone: hysteresis is not known, add a sweep back".to_owned(),
        );
    }
}
