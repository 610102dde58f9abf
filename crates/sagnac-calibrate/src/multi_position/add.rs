//! "Turn it so next": poses and turns that bring every term below a thirtieth of its plausible size.
//!
//! Greedy on the information matrix: Λ ← Λ + jᵀj of a pose (turn) with the median noise of those found.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::turns::{self, Correction};
use super::{PoseToAdd, TurnToAdd, accel, gyro};
use crate::stations::{Status, add::directions};

/// Most poses or turns that are proposed.
const MOST: usize = 20;

/// What is known of some terms, in units of their plausible sizes.
struct Belief {
    covariance: DMatrix<f64>,
    sizes: Vec<f64>,
}

/// A term is good enough below this part of its plausible size.
const GOOD: f64 = 1.0 / 30.0;

impl Belief {
    fn new(design: &DMatrix<f64>, sizes: Vec<f64>) -> Option<Self> {
        let q = sizes.len();
        let x = DMatrix::from_fn(design.nrows(), q, |i, j| design[(i, j)] * sizes[j]);
        let information = x.transpose() * &x + DMatrix::identity(q, q);
        Some(Self {
            covariance: information.try_inverse()?,
            sizes,
        })
    }

    fn sigma(&self, j: usize) -> f64 {
        self.covariance[(j, j)].max(0.0).sqrt()
    }

    fn after(&self, rows: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let x = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| {
            rows[(i, j)] * self.sizes[j]
        });
        let gain = &self.covariance * x.transpose();
        let inner = (&x * &gain + DMatrix::identity(x.nrows(), x.nrows())).try_inverse()?;
        Some(&self.covariance - &gain * inner * gain.transpose())
    }

    /// The candidate after which the terms still open are known best, and the term it helps most.
    fn best(
        &self,
        candidates: &[DMatrix<f64>],
        judged: &[usize],
    ) -> Option<(usize, usize, DMatrix<f64>)> {
        let open: Vec<usize> = judged
            .iter()
            .copied()
            .filter(|j| self.sigma(*j) > GOOD)
            .collect();
        if open.is_empty() {
            return None;
        }
        candidates
            .iter()
            .enumerate()
            .filter_map(|(i, rows)| {
                let after = self.after(rows)?;
                let fall = |j: usize| (self.covariance[(j, j)] / after[(j, j)].max(1e-300)).ln();
                let score: f64 = open.iter().map(|j| fall(*j)).sum();
                let helped = open
                    .iter()
                    .copied()
                    .max_by(|a, b| fall(*a).total_cmp(&fall(*b)))?;
                (score > 1e-6).then_some((score, i, helped, after))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, i, j, after)| (i, j, after))
    }
}

/// Poses to add to those found.
pub(super) fn poses(
    fit: &accel::Fit,
    asked: &[bool; 9],
    se: [f64; 3],
    gravity: f64,
) -> Vec<PoseToAdd> {
    let judged: Vec<usize> = (0..9).filter(|j| asked[*j]).collect();
    let Some(mut belief) = Belief::new(&fit.design, accel::PLAUSIBLE.to_vec()) else {
        return Vec::new();
    };
    let Ok(inverse) = fit.state.inverse() else {
        return Vec::new();
    };
    let all = directions();
    let candidates: Vec<DMatrix<f64>> = all
        .iter()
        .map(|(d, _)| {
            let (row, v) = accel::row(&(Vector3::from(*d) * gravity), &inverse);
            let sigma = (0..3).map(|k| (v[k] * se[k]).powi(2)).sum::<f64>().sqrt();
            DMatrix::from_fn(1, 9, |_, j| row[j] / sigma)
        })
        .collect();
    let mut out = Vec::new();
    while out.len() < MOST {
        let Some((i, j, after)) = belief.best(&candidates, &judged) else {
            break;
        };
        let size = belief.sizes[j];
        let (k, term) = accel::TERMS[j];
        out.push(PoseToAdd {
            up: all[i].0,
            words: all[i].1.clone(),
            improves: term.name(sagnac_core::Sensor::Accel, k),
            sigma_before: belief.sigma(j) * size,
            sigma_after: after[(j, j)].max(0.0).sqrt() * size,
        });
        belief.covariance = after;
    }
    out
}

/// Weighted row of all nine terms of a pose, before anything is known of them.
fn row_of(direction: &Vector3<f64>, se: [f64; 3]) -> [f64; 9] {
    const GRAVITY: f64 = 9.806_65;
    let (row, v) = accel::row(&(direction * GRAVITY), &Matrix3::identity());
    let sigma = (0..3).map(|k| (v[k] * se[k]).powi(2)).sum::<f64>().sqrt();
    row.map(|c| c / sigma)
}

/// Those of the biases and scale factors asked for that poses do not determine.
fn open(design: &DMatrix<f64>, asked: &[bool; 9]) -> Vec<usize> {
    let status = accel::decide(design, asked);
    (0..6)
        .filter(|j| asked[*j] && status[*j] != Status::Admitted)
        .collect()
}

fn stacked(directions: impl Iterator<Item = Vector3<f64>>, se: [f64; 3]) -> DMatrix<f64> {
    let rows: Vec<[f64; 9]> = directions.map(|d| row_of(&d, se)).collect();
    DMatrix::from_fn(rows.len(), 9, |i, j| rows[i][j])
}

/// Those of the biases and scale factors asked for that poses in these directions do not determine.
pub(super) fn missing(directions: &[Vector3<f64>], asked: &[bool; 9], se: [f64; 3]) -> Vec<usize> {
    open(&stacked(flattened(directions).into_iter(), se), asked)
}

/// Poses which, beside those in `directions`, make bias and scale factor of all axes determined, in words.
///
/// Chosen one by one by what they tell of the terms that are not, until [`accel::decide`] admits all of them; then
/// those are left out that are not needed.
pub(super) fn resolving(
    directions: &[Vector3<f64>],
    asked: &[bool; 9],
    se: [f64; 3],
) -> Vec<String> {
    let all = self::directions();
    let candidates: Vec<DMatrix<f64>> = all
        .iter()
        .map(|(d, _)| stacked(std::iter::once(Vector3::from(*d)), se))
        .collect();
    let directions = flattened(directions);
    let design = |chosen: &[usize]| {
        let more = chosen.iter().map(|i| Vector3::from(all[*i].0));
        stacked(directions.iter().copied().chain(more), se)
    };
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < MOST {
        let now = design(&chosen);
        let missing = open(&now, asked);
        if missing.is_empty() {
            break;
        }
        // A pose that is there already tells what another cannot: each is added once.
        let best = Belief::new(&now, accel::PLAUSIBLE.to_vec()).and_then(|belief| {
            (0..candidates.len())
                .filter(|i| !chosen.contains(i))
                .filter_map(|i| {
                    let after = belief.after(&candidates[i])?;
                    let fall = |j: &usize| {
                        (belief.covariance[(*j, *j)] / after[(*j, *j)].max(1e-300)).ln()
                    };
                    Some((missing.iter().map(fall).sum::<f64>(), i))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0))
        });
        let Some((_, i)) = best else { break };
        chosen.push(i);
    }
    for i in chosen.clone() {
        let fewer: Vec<usize> = chosen.iter().copied().filter(|c| *c != i).collect();
        if open(&design(&fewer), asked).is_empty() {
            chosen = fewer;
        }
    }
    chosen.into_iter().map(|i| all[i].1.clone()).collect()
}

/// Turns to add: a quarter turn about each of the 26 axes, gravity across it.
pub(super) fn turns(
    fit: &gyro::Fit,
    asked: &[bool; 21],
    correction: &Correction,
    length_s: f64,
    direction_sigma: f64,
    gravity: f64,
) -> Vec<TurnToAdd> {
    let judged: Vec<usize> = (3..21).filter(|j| asked[*j]).collect();
    // The bias has no plausible size: one larger than any that is met.
    let sizes = (0..21)
        .map(|j| if j < 3 { 1.0 } else { gyro::plausible(j) })
        .collect();
    let Some(mut belief) = Belief::new(&fit.design, sizes) else {
        return Vec::new();
    };
    let all = directions();
    let steps = 40;
    let dt = length_s.max(0.1) / f64::from(steps);
    let rate = std::f64::consts::FRAC_PI_2 / length_s.max(0.1);
    let candidates: Vec<DMatrix<f64>> = all
        .iter()
        .map(|(d, _)| {
            let axis = Vector3::from(*d);
            let mut helper = Vector3::zeros();
            helper[axis.iamin()] = 1.0;
            let up = axis.cross(&helper).normalize();
            let unit = Correction {
                bias: Vector3::zeros(),
                inverse: Matrix3::identity(),
                g: Matrix3::zeros(),
                sigma: correction.sigma,
            };
            let force = up * gravity;
            let swept = turns::sweep((0..steps).map(|_| (axis * rate, force)), &unit, dt);
            let to = swept.rotation * up;
            let rows = gyro::turn_rows(&swept, &Matrix3::identity(), &up, &to);
            DMatrix::from_fn(2, 21, |c, j| {
                let variance = rows.noise[c][c] + 2.0 * direction_sigma.powi(2);
                rows.jacobian[c][j] / variance.sqrt()
            })
        })
        .collect();
    let mut out = Vec::new();
    while out.len() < MOST {
        let Some((i, j, after)) = belief.best(&candidates, &judged) else {
            break;
        };
        let size = belief.sizes[j];
        let (k, term) = gyro::TERMS[j];
        out.push(TurnToAdd {
            axis: all[i].0,
            words: all[i].1.clone(),
            improves: term.name(sagnac_core::Sensor::Gyro, k),
            sigma_before: belief.sigma(j) * size,
            sigma_after: after[(j, j)].max(0.0).sqrt() * size,
        });
        belief.covariance = after;
    }
    out
}

/// The share of all directions that lie within 30° of a pose.
pub(super) fn covered(directions: &[Vector3<f64>]) -> f64 {
    const POINTS: u32 = 2000;
    let limit = 30f64.to_radians().cos();
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let near = (0..POINTS)
        .filter(|i| {
            let z = 1.0 - (2.0 * f64::from(*i) + 1.0) / f64::from(POINTS);
            let r = (1.0 - z * z).sqrt();
            let a = golden * f64::from(*i);
            let p = Vector3::new(r * a.cos(), r * a.sin(), z);
            directions.iter().any(|d| d.dot(&p) > limit)
        })
        .count();
    near as f64 / f64::from(POINTS)
}

/// How many of the directions are distinct: more than `apart` from all counted before.
pub(super) fn distinct(directions: &[Vector3<f64>], apart_rad: f64) -> Vec<Vector3<f64>> {
    let limit = apart_rad.cos();
    let mut out: Vec<Vector3<f64>> = Vec::new();
    for d in directions {
        if out.iter().all(|o| o.dot(d) < limit) {
            out.push(*d);
        }
    }
    out
}

/// The normal of the plane (through the origin) that all directions lie near, by the smallest principal spread.
fn plane_of(directions: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let n = directions.len().max(1) as f64;
    let mut sum = Matrix3::zeros();
    for d in directions {
        sum += d * d.transpose();
    }
    let spread = (sum / n).symmetric_eigen();
    let least = spread.eigenvalues.imin();
    (spread.eigenvalues[least] < 0.01).then(|| spread.eigenvectors.column(least).into_owned())
}

/// Whether all directions lie near one plane.
pub(super) fn in_a_plane(directions: &[Vector3<f64>]) -> bool {
    plane_of(directions).is_some()
}

/// Directions near a plane, in it: what lies across it is bias and noise, from which nothing is to be learned.
fn flattened(directions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let Some(normal) = plane_of(directions) else {
        return directions.to_vec();
    };
    directions
        .iter()
        .map(|d| (d - normal * normal.dot(d)).normalize())
        .collect()
}
