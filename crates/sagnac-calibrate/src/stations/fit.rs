//! Weighted least squares of one axis by QR, and the axis offsets' product terms by Gauss–Newton.
//!
//! Weight of a row = 1/(se² + Σ_j A_kj² σ_j²), A = I + M at the present estimate.

use nalgebra::{DMatrix, DVector};
use sagnac_core::Sensor;

use super::Station;
use super::determine::triangle;
use super::terms::{Group, Inputs, Term, omega_row};

/// One axis of one sensor and the rows that have its output.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) sensor: Sensor,
    pub(super) k: usize,
    pub(super) terms: Vec<Term>,
    /// Rows of the table.
    pub(super) rows: Vec<usize>,
    /// Switch-on of each of these rows.
    pub(super) runs: Vec<usize>,
    pub(super) has_errors: bool,
    pub(super) reference_c: f64,
}

/// The present estimate of a sensor: a value for each term of each axis, zero where it is held.
pub(super) type State = [Vec<f64>; 3];

/// A solution of one axis over some of its columns.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub(super) values: Vec<f64>,
    /// (XᵀWX)⁻¹.
    pub(super) covariance: DMatrix<f64>,
    pub(super) chi2: f64,
}

impl Problem {
    fn value(&self, state: &State, group: Group, component: usize) -> f64 {
        self.terms
            .iter()
            .position(|t| t.group == group && t.component == component)
            .and_then(|i| state[self.k].get(i))
            .copied()
            .unwrap_or(0.0)
    }

    /// Position vector of this accelerometer.
    pub(super) fn offset(&self, state: &State) -> [f64; 3] {
        [0, 1, 2].map(|j| self.value(state, Group::AxisOffset, j))
    }

    /// Row of I + M.
    pub(super) fn response_row(&self, state: &State) -> [f64; 3] {
        [0, 1, 2].map(|j| {
            if j == self.k {
                1.0 + self.value(state, Group::ScaleFactor, 0)
            } else {
                self.value(state, Group::Misalignment, j)
            }
        })
    }

    /// The inputs of a row, with the size effect of `offsets` (all three axes).
    pub(super) fn inputs(
        &self,
        station: &Station,
        run: usize,
        state: &State,
        offsets: &[[f64; 3]; 3],
    ) -> Inputs {
        let mut u = station.input(self.sensor);
        let row = omega_row(self.k, station.w, station.wdot);
        if self.sensor == Sensor::Accel {
            for (j, value) in u.iter_mut().enumerate() {
                let omega = omega_row(j, station.w, station.wdot);
                *value += dot(omega, offsets[j]);
            }
        }
        let warmth_k = station.temperature_c.map_or(0.0, |t| t - self.reference_c);
        let uk = u[self.k];
        let mut slope = 1.0;
        for (term, value) in self.terms.iter().zip(&state[self.k]) {
            slope += value
                * match term.group {
                    Group::ScaleFactor => 1.0,
                    Group::ScaleTemperature(i) => warmth_k.powi(i32::from(i)),
                    Group::Quadratic => 2.0 * uk,
                    Group::Cubic => 3.0 * uk * uk,
                    Group::Asymmetry if uk != 0.0 => 0.5 * uk.signum(),
                    _ => 0.0,
                };
        }
        Inputs {
            u,
            f: station.f,
            omega_row: row,
            slope,
            warmth_k,
            run,
        }
    }

    /// The square roots of the rows' weights.
    pub(super) fn root_weights(&self, stations: &[Station], state: &State) -> Vec<f64> {
        let a = self.response_row(state);
        let variances: Vec<f64> = self
            .rows
            .iter()
            .map(|row| {
                let station = &stations[*row];
                let se = if self.has_errors {
                    station.output_se(self.sensor).map_or(0.0, |se| se[self.k])
                } else {
                    0.0
                };
                let sigma = station.input_sigma(self.sensor);
                se * se + (0..3).map(|j| (a[j] * sigma[j]).powi(2)).sum::<f64>()
            })
            .collect();
        if variances.iter().any(|v| *v <= 0.0) {
            return vec![1.0; self.rows.len()];
        }
        variances.iter().map(|v| 1.0 / v.sqrt()).collect()
    }

    /// The triangular factor of the weighted columns of `chosen` with the weighted right-hand side last; rows are
    /// taken in portions that stay in the cache, each beneath the factor of those before.
    pub(super) fn factor(
        &self,
        stations: &[Station],
        chosen: &[usize],
        state: &State,
        offsets: &[[f64; 3]; 3],
    ) -> DMatrix<f64> {
        const PORTION: usize = 192;
        let roots = self.root_weights(stations, state);
        let p = chosen.len();
        let mut factor = DMatrix::zeros(0, p + 1);
        for (portion, first) in self.rows.chunks(PORTION).zip((0..).step_by(PORTION)) {
            let above = factor.nrows();
            let mut work = factor.resize_vertically(above + portion.len(), 0.0);
            for (i, row) in portion.iter().enumerate() {
                let station = &stations[*row];
                let root = roots[first + i];
                let at = self.inputs(station, self.runs[first + i], state, offsets);
                for (c, t) in chosen.iter().enumerate() {
                    work[(above + i, c)] = self.terms[*t].column(self.k, &at) * root;
                }
                let output = station.output(self.sensor).map_or(0.0, |o| o[self.k]);
                let linear = at.slope * dot(at.omega_row, offsets[self.k]);
                work[(above + i, p)] = (output - at.u[self.k] + linear) * root;
            }
            factor = if work.nrows() > p + 1 {
                work.qr().unpack_r()
            } else {
                work
            };
        }
        triangle(factor)
    }

    /// Whether the weights change with the estimate.
    pub(super) fn has_reference_errors(&self, stations: &[Station]) -> bool {
        self.rows
            .iter()
            .any(|row| stations[*row].input_sigma(self.sensor) != [0.0; 3])
    }

    /// Output − fit of each row.
    pub(super) fn residuals(
        &self,
        stations: &[Station],
        state: &State,
        offsets: &[[f64; 3]; 3],
    ) -> Vec<f64> {
        self.rows
            .iter()
            .zip(&self.runs)
            .map(|(row, run)| {
                let station = &stations[*row];
                let at = self.inputs(station, *run, state, offsets);
                let fit: f64 = self
                    .terms
                    .iter()
                    .zip(&state[self.k])
                    .filter(|(t, _)| t.group != Group::AxisOffset)
                    .map(|(t, v)| t.column(self.k, &at) * v)
                    .sum();
                station.output(self.sensor).map_or(0.0, |o| o[self.k]) - at.u[self.k] - fit
            })
            .collect()
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Least squares of a matrix whose last column is the right-hand side.
pub(super) fn solve(design: DMatrix<f64>) -> Option<Solution> {
    let p = design.ncols() - 1;
    let norms: Vec<f64> = (0..p).map(|j| design.column(j).norm()).collect();
    if norms.contains(&0.0) {
        return None;
    }
    let factor = triangle_with_side(design);
    let mut r = factor.view((0, 0), (p, p)).into_owned();
    for (j, norm) in norms.iter().enumerate() {
        r.column_mut(j).scale_mut(1.0 / norm);
    }
    let side: DVector<f64> = factor.view((0, p), (p, 1)).column(0).into_owned();
    let inverse = r.clone().try_inverse()?;
    let scaled = &inverse * side;
    let covariance = &inverse * inverse.transpose();
    Some(Solution {
        values: (0..p).map(|j| scaled[j] / norms[j]).collect(),
        covariance: DMatrix::from_fn(p, p, |i, j| covariance[(i, j)] / norms[i] / norms[j]),
        chi2: factor[(p, p)].powi(2),
    })
}

/// As [`triangle`], truly triangular even where there are few rows.
fn triangle_with_side(design: DMatrix<f64>) -> DMatrix<f64> {
    let (n, p) = design.shape();
    if n < p {
        return triangle(design.resize_vertically(p + 1, 0.0));
    }
    design.qr().unpack_r()
}
