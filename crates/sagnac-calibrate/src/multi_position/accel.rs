//! The accelerometer from poses of unknown direction: |f̂| is gravity in each.
//!
//! Σ (|f̂_i| − g)²/var_i, f̂ = (I+M)⁻¹(mean − b), var_i = n'(I+M)⁻¹ diag(se²) (I+M)⁻ᵀ n, n = f̂/|f̂|; M lower
//! triangular. `[TEDALDI2014]`, with weights, Huber's down-weighting and covariance.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{Error, Options};
use crate::interval::{Scatter, median};
use crate::stations::Status;
use crate::stations::determine::{Candidate, admit};
use crate::stations::terms::{Group, Term};

/// The terms in order: b, s, then m_yx, m_zx, m_zy.
pub(super) const TERMS: [(usize, Term); 9] = {
    const fn term(k: usize, group: Group, component: usize) -> (usize, Term) {
        (k, Term { group, component })
    }
    [
        term(0, Group::Bias, 0),
        term(1, Group::Bias, 0),
        term(2, Group::Bias, 0),
        term(0, Group::ScaleFactor, 0),
        term(1, Group::ScaleFactor, 0),
        term(2, Group::ScaleFactor, 0),
        term(1, Group::Misalignment, 0),
        term(2, Group::Misalignment, 0),
        term(2, Group::Misalignment, 1),
    ]
};

/// Plausible sizes.
pub(super) const PLAUSIBLE: [f64; 9] = [0.5, 0.5, 0.5, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05];

/// The present estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State(pub(super) [f64; 9]);

impl State {
    pub(super) fn bias(&self) -> Vector3<f64> {
        Vector3::new(self.0[0], self.0[1], self.0[2])
    }

    /// I + M.
    pub(super) fn response(&self) -> Matrix3<f64> {
        let p = &self.0;
        Matrix3::new(
            1.0 + p[3],
            0.0,
            0.0,
            p[6],
            1.0 + p[4],
            0.0,
            p[7],
            p[8],
            1.0 + p[5],
        )
    }

    pub(super) fn inverse(&self) -> Result<Matrix3<f64>, Error> {
        self.response().try_inverse().ok_or(Error::Diverged)
    }
}

/// Row of the Jacobian of |f̂| and the sensitivity of |f̂| to the mean.
pub(super) fn row(f: &Vector3<f64>, inverse: &Matrix3<f64>) -> ([f64; 9], Vector3<f64>) {
    let v = inverse.transpose() * f / f.norm();
    let d = TERMS.map(|(k, term)| {
        -v[k]
            * match term.group {
                Group::Bias => 1.0,
                Group::ScaleFactor => f[k],
                _ => f[term.component],
            }
    });
    (d, v)
}

/// The estimate.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) state: State,
    pub(super) status: [Status; 9],
    /// Which of the nine are estimated.
    pub(super) estimated: Vec<usize>,
    /// Covariance of those, scaled.
    pub(super) covariance: DMatrix<f64>,
    pub(super) chi2: f64,
    pub(super) dof: usize,
    pub(super) scatter: Scatter,
    /// |f̂| − g.
    pub(super) residuals: Vec<f64>,
    /// Their standard deviations by the sensor's noise.
    pub(super) sigmas: Vec<f64>,
    /// Weights of Huber, 1 where nothing is wrong.
    pub(super) weights: Vec<f64>,
    /// f̂ of each pose.
    pub(super) forces: Vec<Vector3<f64>>,
    /// Weighted Jacobian of all nine, for what is held.
    pub(super) design: DMatrix<f64>,
    /// ∂(estimated)/∂(mean of pose i).
    pub(super) gain: Vec<DMatrix<f64>>,
}

/// Weighted Jacobian of all nine terms and right-hand side at a state.
struct System {
    design: DMatrix<f64>,
    side: DVector<f64>,
    forces: Vec<Vector3<f64>>,
    residuals: Vec<f64>,
    roots: Vec<f64>,
    slopes: Vec<Vector3<f64>>,
}

fn system(
    state: &State,
    means: &[Vector3<f64>],
    se: &[[f64; 3]],
    weights: &[f64],
    g: f64,
) -> Result<System, Error> {
    let inverse = state.inverse()?;
    let n = means.len();
    let mut out = System {
        design: DMatrix::zeros(n, 9),
        side: DVector::zeros(n),
        forces: Vec::with_capacity(n),
        residuals: Vec::with_capacity(n),
        roots: Vec::with_capacity(n),
        slopes: Vec::with_capacity(n),
    };
    for i in 0..n {
        let f = inverse * (means[i] - state.bias());
        let (d, v) = row(&f, &inverse);
        let variance: f64 = (0..3).map(|k| (v[k] * se[i][k]).powi(2)).sum();
        let root = (weights[i] / variance).sqrt();
        let r = f.norm() - g;
        if !root.is_finite() || !r.is_finite() {
            return Err(Error::Diverged);
        }
        for (j, d) in d.into_iter().enumerate() {
            out.design[(i, j)] = d * root;
        }
        out.side[i] = -r * root;
        out.forces.push(f);
        out.residuals.push(r);
        out.roots.push(root);
        out.slopes.push(v);
    }
    Ok(out)
}

/// Which terms the poses determine.
pub(super) fn decide(design: &DMatrix<f64>, asked: &[bool; 9]) -> [Status; 9] {
    let mut groups = Vec::new();
    for wanted in [true, false] {
        for range in [0..3, 3..6, 6..9] {
            groups.push(
                range
                    .filter(|j| asked[*j] == wanted)
                    .map(|j| Candidate {
                        column: j,
                        plausible: PLAUSIBLE[j],
                        weak: false,
                    })
                    .collect(),
            );
        }
    }
    let found = admit(design, &groups, true);
    std::array::from_fn(|j| found[j])
}

/// Estimates bias, scale factor and misalignment from the means of poses.
pub(super) fn fit(
    means: &[Vector3<f64>],
    se: &[[f64; 3]],
    asked: &[bool; 9],
    options: &Options,
) -> Result<Fit, Error> {
    let g = options.gravity_m_s2;
    let mut state = State([0.0; 9]);
    let mut weights = vec![1.0; means.len()];
    let mut status = [Status::NoInput; 9];
    let mut estimated: Vec<usize> = Vec::new();
    let mut quiet = 0;
    for round in 0..60 {
        let now = system(&state, means, se, &weights, g)?;
        // What is determined is decided at the start, and once more at the first estimate.
        if round == 0 || round == 4 {
            status = decide(&now.design, asked);
            estimated = (0..9)
                .filter(|j| asked[*j] && status[*j] == Status::Admitted)
                .collect();
            for (j, value) in state.0.iter_mut().enumerate() {
                if !estimated.contains(&j) {
                    *value = 0.0;
                }
            }
            if round == 4 {
                continue;
            }
        }
        let step = solve(&now, &estimated).ok_or(Error::Diverged)?;
        let mut moved = 0.0_f64;
        for (j, d) in estimated.iter().zip(step.iter()) {
            state.0[*j] += d;
            moved = moved.max((d / PLAUSIBLE[*j]).abs());
        }
        if state.0.iter().any(|v| !v.is_finite()) || state.0[3..].iter().any(|v| v.abs() > 0.9) {
            return Err(Error::Diverged);
        }
        if round > 4 {
            reweigh(
                &system(&state, means, se, &vec![1.0; means.len()], g)?,
                estimated.len(),
                &mut weights,
            );
        }
        quiet = if moved < 1e-12 { quiet + 1 } else { 0 };
        if quiet > 1 && round > 6 {
            break;
        }
    }
    finish(&state, means, se, weights, status, estimated, g)
}

fn chosen(design: &DMatrix<f64>, columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(design.nrows(), columns.len(), |i, j| {
        design[(i, columns[j])]
    })
}

fn solve(system: &System, columns: &[usize]) -> Option<DVector<f64>> {
    let x = chosen(&system.design, columns);
    let (n, q) = x.shape();
    if n < q || q == 0 {
        return None;
    }
    let norms: Vec<f64> = (0..q).map(|j| x.column(j).norm()).collect();
    let mut scaled = x;
    for (j, norm) in norms.iter().enumerate() {
        if *norm == 0.0 {
            return None;
        }
        scaled.column_mut(j).scale_mut(1.0 / norm);
    }
    let qr = scaled.qr();
    let side = qr.q().transpose() * &system.side;
    let solution = qr.r().solve_upper_triangular(&side)?;
    Some(DVector::from_iterator(
        q,
        (0..q).map(|j| solution[j] / norms[j]),
    ))
}

/// Huber's weights beyond three robust standard deviations of the standardised residuals.
fn reweigh(plain: &System, parameters: usize, weights: &mut [f64]) {
    let n = plain.residuals.len();
    let z: Vec<f64> = plain.side.iter().map(|v| v.abs()).collect();
    let freedom = (n as f64 / (n.saturating_sub(parameters)).max(1) as f64).sqrt();
    let robust = 1.4826 * median(z.clone()).unwrap_or(1.0) * freedom;
    let limit = 3.0 * robust.max(1.0);
    for (w, z) in weights.iter_mut().zip(z) {
        *w = if z > limit { limit / z } else { 1.0 };
    }
}

fn finish(
    state: &State,
    means: &[Vector3<f64>],
    se: &[[f64; 3]],
    weights: Vec<f64>,
    status: [Status; 9],
    estimated: Vec<usize>,
    g: f64,
) -> Result<Fit, Error> {
    let last = system(state, means, se, &weights, g)?;
    let n = means.len();
    let x = chosen(&last.design, &estimated);
    let unscaled = (x.transpose() * &x).try_inverse().ok_or(Error::Diverged)?;
    let chi2 = last.side.norm_squared();
    let dof = n - estimated.len();
    let scatter = Scatter::of(chi2, dof);
    let gain = (0..n)
        .map(|i| {
            let to_residual = -(&unscaled * x.row(i).transpose()) * last.roots[i];
            DMatrix::from_fn(to_residual.len(), 3, |j, k| {
                to_residual[j] * last.slopes[i][k]
            })
        })
        .collect();
    Ok(Fit {
        state: *state,
        status,
        covariance: unscaled * scatter.factor,
        estimated,
        chi2,
        dof,
        scatter,
        residuals: last.residuals,
        sigmas: last
            .roots
            .iter()
            .zip(&weights)
            .map(|(root, weight)| weight.sqrt() / root)
            .collect(),
        weights,
        forces: last.forces,
        design: last.design,
        gain,
    })
}
