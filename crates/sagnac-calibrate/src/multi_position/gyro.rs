//! The gyro from rests and turns, jointly, with the whole covariance of both sensors' errors.
//!
//! Rests: mean_i = b + G f̂_i. Turns: e_i = B_i (u_{i+1} − R_i u_i). Covariance: gyro noise N² carried to the end
//! of the turn, direction noise of both rests, the accelerometer's estimate, bias drift, the Earth's rate.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::drift::{self, Axis, Drift, Span};
use super::rests::Rest;
use super::turns::{self, Correction, Swept, Turn, cross};
use super::{Error, Recording, accel};
use crate::interval::Scatter;
use crate::stations::Status;
use crate::stations::determine::{Candidate, admit};
use crate::stations::terms::{Group, Term};

/// The Earth's rate \[rad/s\].
const EARTH_RATE: f64 = 7.292_115e-5;

/// The terms in order: b, s, m (xy xz yx yz zx zy), G row by row.
pub(super) const TERMS: [(usize, Term); 21] = {
    const fn term(k: usize, group: Group, component: usize) -> (usize, Term) {
        (k, Term { group, component })
    }
    const G: Group = Group::GSensitivity;
    const M: Group = Group::Misalignment;
    [
        term(0, Group::Bias, 0),
        term(1, Group::Bias, 0),
        term(2, Group::Bias, 0),
        term(0, Group::ScaleFactor, 0),
        term(1, Group::ScaleFactor, 0),
        term(2, Group::ScaleFactor, 0),
        term(0, M, 1),
        term(0, M, 2),
        term(1, M, 0),
        term(1, M, 2),
        term(2, M, 0),
        term(2, M, 1),
        term(0, G, 0),
        term(0, G, 1),
        term(0, G, 2),
        term(1, G, 0),
        term(1, G, 1),
        term(1, G, 2),
        term(2, G, 0),
        term(2, G, 1),
        term(2, G, 2),
    ]
};

/// Plausible size of a term.
pub(super) fn plausible(j: usize) -> f64 {
    match j {
        0..3 => f64::INFINITY,
        3..12 => 0.05,
        _ => 1e-3,
    }
}

/// The present estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State(pub(super) [f64; 21]);

impl State {
    pub(super) fn bias(&self) -> Vector3<f64> {
        Vector3::new(self.0[0], self.0[1], self.0[2])
    }

    /// I + M.
    pub(super) fn response(&self) -> Matrix3<f64> {
        let p = &self.0;
        Matrix3::new(
            1.0 + p[3],
            p[6],
            p[7],
            p[8],
            1.0 + p[4],
            p[9],
            p[10],
            p[11],
            1.0 + p[5],
        )
    }

    pub(super) fn g(&self) -> Matrix3<f64> {
        Matrix3::from_row_slice(&self.0[12..21])
    }
}

/// What the gyro's estimate starts from.
pub(super) struct Input<'a> {
    pub(super) recording: &'a Recording<'a>,
    pub(super) gyro: &'a [&'a [f64]; 3],
    pub(super) rests: &'a [Rest],
    pub(super) turns: &'a [Turn],
    pub(super) accel: &'a accel::Fit,
    /// Standard deviations of a sample.
    pub(super) accel_sigma: [f64; 3],
    pub(super) gyro_sigma: [f64; 3],
    pub(super) asked: &'a [bool; 21],
    /// Latitude \[rad\].
    pub(super) latitude_rad: Option<f64>,
}

/// The estimate.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) state: State,
    pub(super) status: Vec<Status>,
    pub(super) estimated: Vec<usize>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) chi2: f64,
    pub(super) dof: usize,
    pub(super) scatter: Scatter,
    /// |e| of each turn.
    pub(super) errors: Vec<f64>,
    /// Its two components, and their standard deviations.
    pub(super) components: Vec<[f64; 2]>,
    pub(super) component_sigmas: Vec<[f64; 2]>,
    /// Weight of each turn, 1 where nothing is wrong.
    pub(super) weights: Vec<f64>,
    /// mean_i − b − G f̂_i.
    pub(super) rest_residuals: Vec<[f64; 3]>,
    pub(super) drift: Drift,
    /// Largest change of the bias from one rest to the next.
    pub(super) largest_change: [f64; 3],
    /// Whitened Jacobian of all terms.
    pub(super) design: DMatrix<f64>,
    /// Covariance of gyro and accelerometer estimates, a row a gyro parameter.
    pub(super) with_accel: DMatrix<f64>,
}

/// Two unit vectors across u.
fn across(u: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let k = u.iamin();
    let mut axis = Vector3::zeros();
    axis[k] = 1.0;
    let a = u.cross(&axis).normalize();
    [a, u.cross(&a)]
}

/// Rows of a turn: error, Jacobian, and the parts its covariance is made of.
pub(super) struct TurnRows {
    pub(super) error: [f64; 2],
    pub(super) jacobian: [[f64; 21]; 2],
    /// Covariance by gyro noise.
    pub(super) noise: [[f64; 2]; 2],
    /// ∂e/∂u before and after.
    pub(super) before: [Vector3<f64>; 2],
    pub(super) after: [Vector3<f64>; 2],
}

/// Error and derivatives of a turn between the directions `from` and `to`.
pub(super) fn turn_rows(
    swept: &Swept,
    inverse: &Matrix3<f64>,
    from: &Vector3<f64>,
    to: &Vector3<f64>,
) -> TurnRows {
    let arrived = swept.rotation * from;
    let basis = across(to);
    let lever = cross(&arrived);
    // ∂e/∂(a constant output error of each kind) = B [û×] Σ P dt (…) (I+M)⁻¹.
    let through = |m: &Matrix3<f64>| lever * m * inverse;
    let bias = through(&swept.bias);
    let rate = swept.rate.map(|m| through(&m));
    let force = swept.force.map(|m| through(&m));
    let noise = lever * swept.noise * lever.transpose();
    TurnRows {
        error: basis.map(|b| b.dot(&(to - arrived))),
        jacobian: basis.map(|b| {
            std::array::from_fn(|j| {
                let (k, term) = TERMS[j];
                b.dot(&match term.group {
                    Group::Bias => bias.column(k),
                    Group::ScaleFactor => rate[k].column(k),
                    Group::Misalignment => rate[term.component].column(k),
                    _ => force[term.component].column(k),
                })
            })
        }),
        noise: [0, 1].map(|i| [0, 1].map(|j| basis[i].dot(&(noise * basis[j])))),
        before: basis.map(|b| -(swept.rotation.transpose() * b)),
        after: basis,
    }
}

/// Everything at one state: residuals, Jacobian of all terms, covariance.
struct System {
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
    covariance: DMatrix<f64>,
    /// ∂residual/∂(mean of pose).
    lever: DMatrix<f64>,
}

impl Input<'_> {
    fn spans(&self) -> (Vec<Span>, Vec<bool>) {
        let dt = self.recording.dt_s;
        let mut all: Vec<(usize, usize, bool)> =
            self.rests.iter().map(|r| (r.first, r.end, true)).collect();
        all.extend(self.turns.iter().map(|t| (t.first, t.end, false)));
        (
            all.iter()
                .map(|(a, b, _)| [*a as f64 * dt, *b as f64 * dt])
                .collect(),
            all.iter().map(|(_, _, r)| *r).collect(),
        )
    }

    /// Size of the Earth's rate as an error: vertical, and each horizontal component.
    fn earth(&self) -> [f64; 2] {
        self.latitude_rad
            .map_or([EARTH_RATE / 3f64.sqrt(); 2], |phi| {
                [
                    EARTH_RATE * phi.sin().abs(),
                    EARTH_RATE * phi.cos() / 2f64.sqrt(),
                ]
            })
    }

    fn rows(&self, state: &State, inverse: &Matrix3<f64>) -> Result<Vec<TurnRows>, Error> {
        let accel_inverse = self.accel.state.inverse()?;
        let correction = Correction {
            bias: state.bias(),
            inverse: *inverse,
            g: state.g(),
            sigma: self.gyro_sigma,
        };
        Ok(self
            .turns
            .iter()
            .map(|turn| {
                let samples = turns::samples(
                    self.recording,
                    self.gyro,
                    *turn,
                    accel_inverse,
                    self.accel.state,
                );
                let swept = turns::sweep(samples, &correction, self.recording.dt_s);
                turn_rows(
                    &swept,
                    inverse,
                    &self.accel.forces[turn.rest].normalize(),
                    &self.accel.forces[turn.rest + 1].normalize(),
                )
            })
            .collect())
    }

    fn system(&self, state: &State, drift: &Drift, weights: &[f64]) -> Result<System, Error> {
        let inverse = state.response().try_inverse().ok_or(Error::Diverged)?;
        let rows = self.rows(state, &inverse)?;
        let n = self.rests.len();
        let m = 3 * n + 2 * rows.len();
        let mut residuals = DVector::zeros(m);
        let mut jacobian = DMatrix::zeros(m, 21);
        let mut covariance = DMatrix::zeros(m, m);
        for (i, rest) in self.rests.iter().enumerate() {
            let f = &self.accel.forces[i];
            let mean = Vector3::from(rest.gyro.unwrap_or_default());
            let r = mean - state.bias() - state.g() * f;
            for k in 0..3 {
                let at = 3 * i + k;
                residuals[at] = r[k];
                jacobian[(at, k)] = -1.0;
                for j in 0..3 {
                    jacobian[(at, 12 + 3 * k + j)] = -f[j];
                }
                covariance[(at, at)] = self.gyro_sigma[k].powi(2) / rest.samples();
            }
        }
        for (i, row) in rows.iter().enumerate() {
            for c in 0..2 {
                let at = 3 * n + 2 * i + c;
                residuals[at] = row.error[c];
                for j in 0..21 {
                    jacobian[(at, j)] = row.jacobian[c][j];
                }
                for d in 0..2 {
                    covariance[(at, 3 * n + 2 * i + d)] = row.noise[c][d];
                }
            }
        }
        let lever = self.lever(state, &rows)?;
        let mut spread = lever.clone();
        for (i, rest) in self.rests.iter().enumerate() {
            for k in 0..3 {
                let variance =
                    self.accel_sigma[k].powi(2) / rest.samples() * self.accel.scatter.factor;
                spread.column_mut(3 * i + k).scale_mut(variance.sqrt());
            }
        }
        covariance += &spread * spread.transpose();
        self.add_drift(&mut covariance, &jacobian, drift);
        if drift.has_earth {
            self.add_earth(&mut covariance);
        }
        for (i, w) in weights.iter().enumerate() {
            for c in 0..2 {
                let at = 3 * n + 2 * i + c;
                covariance[(at, at)] /= w * w;
            }
        }
        Ok(System {
            residuals,
            jacobian,
            covariance,
            lever,
        })
    }

    /// How the residuals depend on the accelerometer's mean of each pose, directly and through its parameters.
    fn lever(&self, state: &State, rows: &[TurnRows]) -> Result<DMatrix<f64>, Error> {
        let n = self.rests.len();
        let m = 3 * n + 2 * rows.len();
        let inverse = self.accel.state.inverse()?;
        let g = state.g();
        // ∂residual/∂f̂ of each pose, as rows of three.
        let mut by_force = DMatrix::zeros(m, 3 * n);
        for i in 0..n {
            by_force.view_mut((3 * i, 3 * i), (3, 3)).copy_from(&(-g));
        }
        for (t, (turn, row)) in self.turns.iter().zip(rows).enumerate() {
            for (pose, slopes) in [(turn.rest, &row.before), (turn.rest + 1, &row.after)] {
                let f = &self.accel.forces[pose];
                let u = f.normalize();
                for (c, slope) in slopes.iter().enumerate() {
                    let s = (slope - u * u.dot(slope)) / f.norm();
                    for j in 0..3 {
                        by_force[(3 * n + 2 * t + c, 3 * pose + j)] += s[j];
                    }
                }
            }
        }
        // f̂ = (I+M)⁻¹(y − b): directly …
        let mut out = DMatrix::zeros(m, 3 * n);
        for i in 0..n {
            let part = by_force.columns(3 * i, 3) * inverse;
            out.columns_mut(3 * i, 3).copy_from(&part);
        }
        // … and through b and M, which come from all the poses.
        let q = self.accel.estimated.len();
        let mut by_parameter = DMatrix::zeros(m, q);
        for (c, j) in self.accel.estimated.iter().enumerate() {
            let (k, term) = accel::TERMS[*j];
            for i in 0..n {
                let f = &self.accel.forces[i];
                let size = match term.group {
                    Group::Bias => 1.0,
                    Group::ScaleFactor => f[k],
                    _ => f[term.component],
                };
                let column = out.column(3 * i + k) * (-size);
                let mut target = by_parameter.column_mut(c);
                target += column;
            }
        }
        for (i, gain) in self.accel.gain.iter().enumerate() {
            let part = &by_parameter * gain;
            let mut target = out.columns_mut(3 * i, 3);
            target += part;
        }
        Ok(out)
    }

    fn add_drift(&self, covariance: &mut DMatrix<f64>, jacobian: &DMatrix<f64>, drift: &Drift) {
        if drift.rate == [0.0; 3] {
            return;
        }
        let (spans, is_rest) = self.spans();
        let walk = drift::centered(&spans, &is_rest);
        let n = self.rests.len();
        let rows_of = |i: usize| {
            if i < n {
                3 * i..3 * i + 3
            } else {
                n + 2 * i..n + 2 * i + 2
            }
        };
        for i in 0..spans.len() {
            for j in 0..spans.len() {
                for r in rows_of(i) {
                    for c in rows_of(j) {
                        covariance[(r, c)] += (0..3)
                            .map(|k| jacobian[(r, k)] * jacobian[(c, k)] * drift.rate[k].powi(2))
                            .sum::<f64>()
                            * walk[(i, j)];
                    }
                }
            }
        }
    }

    /// The Earth's rate: one vertical component for all, horizontal ones of unknown direction in each rest and turn.
    fn add_earth(&self, covariance: &mut DMatrix<f64>) {
        let [vertical, horizontal] = self.earth();
        let n = self.rests.len();
        let up: Vec<Vector3<f64>> = self.accel.forces.iter().map(Vector3::normalize).collect();
        for i in 0..n {
            for j in 0..n {
                let block = up[i] * up[j].transpose() * vertical.powi(2);
                for r in 0..3 {
                    for c in 0..3 {
                        covariance[(3 * i + r, 3 * j + c)] += block[(r, c)];
                    }
                }
            }
            let level = (Matrix3::identity() - up[i] * up[i].transpose()) * horizontal.powi(2);
            for r in 0..3 {
                for c in 0..3 {
                    covariance[(3 * i + r, 3 * i + c)] += level[(r, c)];
                }
            }
        }
        for (t, turn) in self.turns.iter().enumerate() {
            let length_s = (turn.end - turn.first) as f64 * self.recording.dt_s;
            for c in 0..2 {
                let at = 3 * n + 2 * t + c;
                covariance[(at, at)] += (horizontal * length_s).powi(2);
            }
        }
    }

    /// Drift from the rests, with the G of the present estimate free.
    fn drift(&self) -> Drift {
        let n = self.rests.len();
        let with_g = self.asked[12..].iter().any(|a| *a);
        let design = DMatrix::from_fn(n, if with_g { 4 } else { 1 }, |i, j| {
            if j == 0 {
                1.0
            } else {
                self.accel.forces[i][j - 1] / 9.8
            }
        });
        let axes = [0, 1, 2].map(|k| Axis {
            means: DVector::from_fn(n, |i, _| self.rests[i].gyro.unwrap_or_default()[k]),
            white: self
                .rests
                .iter()
                .map(|r| self.gyro_sigma[k].powi(2) / r.samples())
                .collect(),
        });
        let (spans, _) = self.spans();
        let [vertical, horizontal] = self.earth();
        let earth = (vertical.powi(2) + 2.0 * horizontal.powi(2)) / 3.0;
        // A latitude says that the log was taken on the turning Earth.
        drift::find(
            &axes,
            &design,
            &spans[..n],
            earth,
            self.latitude_rad.is_some(),
        )
    }
}

/// Jacobian, residuals and lever, whitened.
struct Whitened {
    x: DMatrix<f64>,
    y: DVector<f64>,
    z: DMatrix<f64>,
}

/// Whitens rows by a covariance.
fn whiten(system: &System) -> Result<Whitened, Error> {
    let l = system
        .covariance
        .clone()
        .cholesky()
        .ok_or(Error::Diverged)?
        .l();
    let x = l
        .solve_lower_triangular(&system.jacobian)
        .ok_or(Error::Diverged)?;
    let y = l
        .solve_lower_triangular(&system.residuals)
        .ok_or(Error::Diverged)?;
    let z = l
        .solve_lower_triangular(&system.lever)
        .ok_or(Error::Diverged)?;
    Ok(Whitened { x, y, z })
}

/// Which terms the rests and turns determine.
fn decide(design: &DMatrix<f64>, asked: &[bool; 21]) -> Vec<Status> {
    let mut groups = Vec::new();
    for wanted in [true, false] {
        for range in [0..3, 3..6, 6..12, 12..21] {
            groups.push(
                range
                    .filter(|j| asked[*j] == wanted)
                    .map(|j| Candidate {
                        column: j,
                        plausible: plausible(j),
                        weak: false,
                    })
                    .collect(),
            );
        }
    }
    admit(design, &groups, true)
}

/// (XᵀX)⁻¹ of some columns, by their norms.
fn inverse_normal(x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let q = x.ncols();
    let norms: Vec<f64> = (0..q).map(|j| x.column(j).norm()).collect();
    let normal = x.transpose() * x;
    let scaled = DMatrix::from_fn(q, q, |i, j| normal[(i, j)] / norms[i] / norms[j]);
    let inverse = scaled.try_inverse()?;
    Some(DMatrix::from_fn(q, q, |i, j| {
        inverse[(i, j)] / norms[i] / norms[j]
    }))
}

fn chosen(design: &DMatrix<f64>, columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(design.nrows(), columns.len(), |i, j| {
        design[(i, columns[j])]
    })
}

/// Weights of turns: Huber beyond three robust standard deviations of the two components together.
fn reweigh(system: &System, n: usize, weights: &mut [f64]) {
    let z: Vec<f64> = (0..weights.len())
        .map(|t| {
            let at = 3 * n + 2 * t;
            (0..2)
                .map(|c| {
                    let own = system.covariance[(at + c, at + c)] * weights[t].powi(2);
                    system.residuals[at + c].powi(2) / own
                })
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    // The median of √χ²₂ is 1.177; beyond 3.44 lies what a normal has beyond 3.
    let robust = crate::interval::median(z.clone()).unwrap_or(1.0) / 1.1774;
    let limit = 3.44 * robust.max(1.0);
    for (w, z) in weights.iter_mut().zip(z) {
        *w = if z > limit { (limit / z).sqrt() } else { 1.0 };
    }
}

/// Estimates bias, scale factor, misalignment and g-sensitivity of the gyro.
pub(super) fn fit(input: &Input) -> Result<Fit, Error> {
    let n = input.rests.len();
    let mut state = State([0.0; 21]);
    for k in 0..3 {
        let all: Vec<f64> = input
            .rests
            .iter()
            .filter_map(|r| r.gyro.map(|g| g[k]))
            .collect();
        state.0[k] = crate::interval::median(all).unwrap_or(0.0);
    }
    let mut weights = vec![1.0; input.turns.len()];
    let drift = input.drift();
    let mut status = vec![Status::NoInput; 21];
    let mut estimated: Vec<usize> = Vec::new();
    for round in 0..14 {
        let now = input.system(&state, &drift, &weights)?;
        let Whitened { x, y, .. } = whiten(&now)?;
        if round == 0 {
            status = decide(&x, input.asked);
            estimated = (0..21)
                .filter(|j| input.asked[*j] && status[*j] == Status::Admitted)
                .collect();
        }
        if estimated.is_empty() {
            break;
        }
        let part = chosen(&x, &estimated);
        let inverse = inverse_normal(&part).ok_or(Error::Diverged)?;
        let step = -(&inverse * (part.transpose() * &y));
        let mut moved = 0.0_f64;
        for (c, j) in estimated.iter().enumerate() {
            state.0[*j] += step[c];
            moved = moved.max(step[c].abs() / inverse[(c, c)].sqrt());
        }
        if state.0.iter().any(|v| !v.is_finite()) || state.0[3..12].iter().any(|v| v.abs() > 3.0) {
            return Err(Error::TurnsDisagree);
        }
        let before = weights.clone();
        if round >= 3 {
            reweigh(&now, n, &mut weights);
        }
        if moved < 1e-3 && before == weights && round >= 3 {
            break;
        }
    }
    finish(input, state, status, estimated, weights, drift)
}

fn finish(
    input: &Input,
    state: State,
    status: Vec<Status>,
    estimated: Vec<usize>,
    weights: Vec<f64>,
    drift: Drift,
) -> Result<Fit, Error> {
    let n = input.rests.len();
    let last = input.system(&state, &drift, &weights)?;
    let Whitened { x, y, z } = whiten(&last)?;
    let part = chosen(&x, &estimated);
    let unscaled = if estimated.is_empty() {
        DMatrix::zeros(0, 0)
    } else {
        inverse_normal(&part).ok_or(Error::Diverged)?
    };
    let chi2 = y.norm_squared();
    let dof = y.len().saturating_sub(estimated.len());
    let scatter = if dof == 0 {
        Scatter::of(0.0, 1)
    } else {
        Scatter::of(chi2, dof)
    };
    // ∂(gyro parameters)/∂(poses' means), times those of the accelerometer's parameters.
    let to_means = -(&unscaled * part.transpose() * z);
    let mut with_accel = DMatrix::zeros(estimated.len(), input.accel.estimated.len());
    for (i, (rest, gain)) in input.rests.iter().zip(&input.accel.gain).enumerate() {
        let mut left = to_means.columns(3 * i, 3).into_owned();
        for k in 0..3 {
            let variance =
                input.accel_sigma[k].powi(2) / rest.samples() * input.accel.scatter.factor;
            left.column_mut(k).scale_mut(variance);
        }
        with_accel += left * gain.transpose();
    }
    let g = state.g();
    let free: Vec<Vector3<f64>> = input
        .rests
        .iter()
        .zip(&input.accel.forces)
        .map(|(r, f)| Vector3::from(r.gyro.unwrap_or_default()) - g * f)
        .collect();
    let largest_change = [0, 1, 2].map(|k| {
        free.windows(2)
            .map(|w| (w[1][k] - w[0][k]).abs())
            .fold(0.0, f64::max)
    });
    let of_turn = |t: usize| [0, 1].map(|c| 3 * n + 2 * t + c);
    let components: Vec<[f64; 2]> = (0..input.turns.len())
        .map(|t| of_turn(t).map(|at| last.residuals[at]))
        .collect();
    Ok(Fit {
        errors: components.iter().map(|[a, b]| a.hypot(*b)).collect(),
        component_sigmas: (0..input.turns.len())
            .map(|t| of_turn(t).map(|at| last.covariance[(at, at)].sqrt() * weights[t]))
            .collect(),
        components,
        rest_residuals: (0..n)
            .map(|i| [0, 1, 2].map(|k| last.residuals[3 * i + k]))
            .collect(),
        covariance: unscaled * scatter.factor,
        state,
        status,
        estimated,
        chi2,
        dof,
        scatter,
        weights,
        drift,
        largest_change,
        design: x,
        with_accel,
    })
}
