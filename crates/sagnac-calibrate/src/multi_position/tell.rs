//! Parameters with intervals, what is held at zero and why, and which estimates depend on it.

use nalgebra::{DMatrix, DVector};
use sagnac_core::Sensor;

use super::{Outcome, Told, accel, append, gyro};
use crate::stations::{Asked, Group, Held, Parameter, Status, Term};

/// Writes the accelerometer's estimate.
pub(super) fn accel(fit: &accel::Fit, asked: &[bool; 9], out: &mut Outcome) {
    append(&mut out.covariance, &fit.covariance, None);
    tell(
        &Told {
            sensor: Sensor::Accel,
            terms: &accel::TERMS,
            values: &fit.state.0,
            plausible: &|j| accel::PLAUSIBLE[j],
            status: &fit.status,
            estimated: &fit.estimated,
            asked,
            design: &fit.design,
            covariance: &fit.covariance,
            quantile: fit.scatter.quantile,
        },
        out,
    );
}

/// Writes the gyro's estimate.
pub(super) fn gyro(fit: &gyro::Fit, asked: &[bool; 21], out: &mut Outcome) {
    append(&mut out.covariance, &fit.covariance, Some(&fit.with_accel));
    tell(
        &Told {
            sensor: Sensor::Gyro,
            terms: &gyro::TERMS,
            values: &fit.state.0,
            plausible: &gyro::plausible,
            status: &fit.status,
            estimated: &fit.estimated,
            asked,
            design: &fit.design,
            covariance: &fit.covariance,
            quantile: fit.scatter.quantile,
        },
        out,
    );
}

/// Names every term of a sensor of the log that was not estimated: those that no hand-turned log tells, and all of a
/// gyro that was refused. The accelerometer's misalignments that the frame makes zero are none.
pub(super) fn rest(sensor: Sensor, asked: &Asked, out: &mut Outcome) {
    let groups = Group::of(sensor, 1, 1);
    for k in 0..3 {
        for term in Term::of(&groups, k, 1) {
            let name = term.name(sensor, k);
            let by_frame =
                sensor == Sensor::Accel && term.group == Group::Misalignment && term.component > k;
            let known = out.parameter(&name).is_some()
                || out.available.contains(&name)
                || out.held.iter().any(|h| h.name == name);
            if by_frame || known {
                continue;
            }
            out.held.push(Held {
                asked: super::GROUPS.contains(&term.group) && asked.has(term.group, false),
                name,
                group: term.group,
                status: Status::NoInput,
                aliases: Vec::new(),
            });
        }
    }
}

/// A column by others, least squares.
fn project(design: &DMatrix<f64>, held: usize, by: &[usize]) -> Vec<(usize, f64)> {
    let target = design.column(held).into_owned();
    if by.is_empty() || target.norm() == 0.0 {
        return Vec::new();
    }
    let norms: Vec<f64> = by.iter().map(|j| design.column(*j).norm()).collect();
    let x = DMatrix::from_fn(design.nrows(), by.len(), |i, c| {
        design[(i, by[c])] / norms[c]
    });
    let svd = x.svd(true, true);
    let solution: DVector<f64> = match svd.solve(&target, 1e-12) {
        Ok(solution) => solution,
        Err(_) => return Vec::new(),
    };
    by.iter()
        .enumerate()
        .map(|(c, j)| (*j, solution[c] / norms[c]))
        .collect()
}

fn tell(told: &Told, out: &mut Outcome) {
    let name = |j: usize| {
        let (k, term) = told.terms[j];
        term.name(told.sensor, k)
    };
    let first = out.parameters.len();
    for (c, j) in told.estimated.iter().enumerate() {
        let (axis, term) = told.terms[*j];
        let (value, sigma) = (told.values[*j], told.covariance[(c, c)].max(0.0).sqrt());
        out.parameters.push(Parameter {
            name: name(*j),
            sensor: told.sensor,
            axis,
            term: Some(term),
            value,
            sigma,
            lower: value - told.quantile * sigma,
            upper: value + told.quantile * sigma,
            assumes: Vec::new(),
        });
    }
    let admitted: Vec<usize> = (0..told.terms.len())
        .filter(|j| told.status[*j] == Status::Admitted)
        .collect();
    for j in 0..told.terms.len() {
        if told.estimated.contains(&j) {
            continue;
        }
        let p = (told.plausible)(j);
        for (t, coefficient) in project(told.design, j, told.estimated) {
            let place = told.estimated.iter().position(|e| *e == t);
            if let Some(parameter) = place.and_then(|c| out.parameters.get_mut(first + c))
                && p.is_finite()
                && (coefficient * p).abs() > parameter.sigma
            {
                parameter.assumes.push(name(j));
            }
        }
        if told.status[j] == Status::Admitted {
            out.available.push(name(j));
            continue;
        }
        let by = project(told.design, j, &admitted);
        let effect = |(t, c): &(usize, f64)| (c * told.design.column(*t).norm()).abs();
        let largest = by.iter().map(effect).fold(0.0, f64::max);
        out.held.push(Held {
            name: name(j),
            group: told.terms[j].1.group,
            status: told.status[j],
            aliases: by
                .iter()
                .filter(|entry| effect(entry) > 1e-6 * largest)
                .map(|(t, c)| (name(*t), *c))
                .collect(),
            asked: told.asked[j],
        });
    }
    for (a, i) in told.estimated.iter().enumerate() {
        for (b, j) in told.estimated.iter().enumerate().take(a) {
            let c = told.covariance;
            let r = c[(a, b)] / (c[(a, a)] * c[(b, b)]).sqrt();
            if r.abs() > 0.95 {
                out.confused.push((name(*j), name(*i), r));
            }
        }
    }
}
