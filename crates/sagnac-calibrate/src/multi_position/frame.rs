//! The estimate in the frame of a fixture: A' = A Q, with the mounting Q of a stations model.
//!
//! I + M of that model is L Q, L lower triangular, Q a rotation (rows orthonormalised from the first on); what was
//! estimated in the accelerometer's own frame is turned by Q, with its covariance. Q is taken as exact.

use nalgebra::{DMatrix, Matrix3, Vector3};
use sagnac_core::Sensor;

use super::{Error, Outcome};
use crate::interval::NORMAL_975;
use crate::stations::{Group, Parameter, Term};

/// The rotation of I + M = L Q.
fn mounting(response: &[[f64; 3]; 3]) -> Option<Matrix3<f64>> {
    let row = |k: usize| Vector3::from(response[k]);
    let q0 = row(0).try_normalize(1e-6)?;
    let q1 = (row(1) - q0 * q0.dot(&row(1))).try_normalize(1e-6)?;
    Some(Matrix3::from_rows(&[
        q0.transpose(),
        q1.transpose(),
        q0.cross(&q1).transpose(),
    ]))
}

/// Place of element (k, j) of a triad's matrix among the outcome's parameters.
fn place(
    outcome: &Outcome,
    sensor: Sensor,
    group: Option<Group>,
    k: usize,
    j: usize,
) -> Option<usize> {
    let term = match group {
        Some(group) => Term {
            group,
            component: j,
        },
        None if k == j => Term {
            group: Group::ScaleFactor,
            component: 0,
        },
        None => Term {
            group: Group::Misalignment,
            component: j,
        },
    };
    let name = term.name(sensor, k);
    outcome.parameters.iter().position(|p| p.name == name)
}

/// Turns an outcome into the frame of a fixture whose stations model has this I + M of the accelerometer.
///
/// # Errors
/// [`Error::Diverged`] where that matrix is singular.
pub fn into_fixture(mut outcome: Outcome, response: &[[f64; 3]; 3]) -> Result<Outcome, Error> {
    let q = mounting(response).ok_or(Error::Diverged)?;
    let old = outcome.parameters.len();
    let mut rows: Vec<(Parameter, Vec<f64>)> = Vec::new();
    for p in outcome
        .parameters
        .iter()
        .filter(|p| p.term.is_some_and(|t| t.group == Group::Bias))
    {
        let at = outcome.parameters.iter().position(|o| o.name == p.name);
        let row = (0..old)
            .map(|i| f64::from(u8::from(Some(i) == at)))
            .collect();
        rows.push((p.clone(), row));
    }
    for (sensor, group) in [
        (Sensor::Accel, None),
        (Sensor::Gyro, None),
        (Sensor::Gyro, Some(Group::GSensitivity)),
    ] {
        let all: Vec<Option<usize>> = (0..9)
            .map(|i| place(&outcome, sensor, group, i / 3, i % 3))
            .collect();
        if all.iter().all(Option::is_none) {
            continue;
        }
        for k in 0..3 {
            for j in 0..3 {
                let mut row = vec![0.0; old];
                // The unit matrix is no parameter; it turns as well.
                let mut value = match group {
                    None => q[(k, j)] - f64::from(u8::from(k == j)),
                    Some(_) => 0.0,
                };
                for i in 0..3 {
                    if let Some(at) = all[3 * k + i] {
                        row[at] = q[(i, j)];
                        value += outcome.parameters[at].value * q[(i, j)];
                    }
                }
                let term = match group {
                    Some(group) => Term {
                        group,
                        component: j,
                    },
                    None if k == j => Term {
                        group: Group::ScaleFactor,
                        component: 0,
                    },
                    None => Term {
                        group: Group::Misalignment,
                        component: j,
                    },
                };
                rows.push((
                    Parameter {
                        name: term.name(sensor, k),
                        sensor,
                        axis: k,
                        term: Some(term),
                        value,
                        sigma: 0.0,
                        lower: value,
                        upper: value,
                        assumes: Vec::new(),
                    },
                    row,
                ));
            }
        }
    }
    // Quantiles as the sensors had them (Student's t where the scatter widened them).
    let quantile = |sensor: Sensor| {
        outcome
            .parameters
            .iter()
            .find(|p| p.sensor == sensor && p.sigma > 0.0)
            .map_or(NORMAL_975, |p| (p.upper - p.value) / p.sigma)
    };
    let quantiles = [quantile(Sensor::Gyro), quantile(Sensor::Accel)];
    let jacobian = DMatrix::from_fn(rows.len(), old, |i, j| rows[i].1[j]);
    let covariance = DMatrix::from_fn(old, old, |i, j| outcome.covariance[i][j]);
    let turned = &jacobian * covariance * jacobian.transpose();
    outcome.parameters = rows
        .into_iter()
        .enumerate()
        .map(|(i, (mut p, _))| {
            p.sigma = turned[(i, i)].max(0.0).sqrt();
            let half = quantiles[p.sensor.index()] * p.sigma;
            (p.lower, p.upper) = (p.value - half, p.value + half);
            p
        })
        .collect();
    outcome.covariance = (0..turned.nrows())
        .map(|i| turned.row(i).iter().copied().collect())
        .collect();
    outcome.confused.clear();
    for (i, a) in outcome.parameters.iter().enumerate() {
        for (j, b) in outcome.parameters.iter().enumerate().take(i) {
            let size = a.sigma * b.sigma;
            let r = turned[(i, j)] / size;
            if a.sensor == b.sensor && size > 0.0 && r.abs() > 0.95 {
                outcome.confused.push((b.name.clone(), a.name.clone(), r));
            }
        }
    }
    outcome
        .confused
        .sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    for pose in &mut outcome.poses {
        pose.direction = (q.transpose() * Vector3::from(pose.direction)).into();
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mounting_of_a_lower_triangular_matrix_is_none() {
        let q = mounting(&[[1.01, 0.0, 0.0], [0.002, 0.99, 0.0], [0.01, -0.003, 1.0]]);
        assert!(q.is_some_and(|q| (q - Matrix3::identity()).norm() < 1e-12));
    }

    #[test]
    fn a_turned_matrix_gives_its_rotation() {
        let l = Matrix3::new(1.01, 0.0, 0.0, 0.002, 0.99, 0.0, 0.01, -0.003, 1.0);
        let angle = 0.02_f64;
        let r = Matrix3::new(
            angle.cos(),
            angle.sin(),
            0.0,
            -angle.sin(),
            angle.cos(),
            0.0,
            0.0,
            0.0,
            1.0,
        );
        let a = l * r;
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[(i, j)]));
        assert!(mounting(&rows).is_some_and(|q| (q - r).norm() < 1e-12));
    }
}
