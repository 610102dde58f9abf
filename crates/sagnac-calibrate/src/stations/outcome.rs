//! The regression of a whole table: what is estimated, how well, and what the table cannot tell.

use nalgebra::DMatrix;
use sagnac_core::Sensor;
use statrs::distribution::{ChiSquared, ContinuousCDF as _, StudentsT};

use super::add::{self, Addition};
use super::check;
use super::determine::{Candidate, Status, admit};
use super::fit::{Problem, Solution, State, dot, solve};
use super::magnitude::magnitudes;
use super::tell::tell;
use super::terms::{AXES, Group, Term};
use super::{Error, Options, Station};

/// An estimated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its path.
    pub name: String,
    /// Sensor.
    pub sensor: Sensor,
    /// Axis.
    pub axis: usize,
    /// Group; `None` for the run-to-run bias.
    pub term: Option<Term>,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Lower 95 % limit.
    pub lower: f64,
    /// Upper 95 % limit.
    pub upper: f64,
    /// Held terms that would shift it by more than its sigma if they had their plausible size.
    pub assumes: Vec<String>,
}

/// A term held at zero because the table does not determine it.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Its path.
    pub name: String,
    /// Its group.
    pub group: Group,
    /// Why.
    pub status: Status,
    /// Its column by the admitted ones.
    pub aliases: Vec<(String, f64)>,
    /// Whether it was asked for.
    pub asked: bool,
}

/// A term that the table determines and nobody asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Available {
    /// Its path.
    pub name: String,
    /// Its group.
    pub group: Group,
    /// How probable the fall of χ² would be without it.
    pub p: Option<f64>,
}

/// Goodness of fit of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisFit {
    /// `accel_x`, …
    pub axis: String,
    /// Σ weighted residuals².
    pub chi2: f64,
    /// Rows − parameters.
    pub dof: usize,
    /// Probability of a larger χ²; `None` without standard errors or freedom.
    pub p: Option<f64>,
    /// Whether the covariance was multiplied by χ²/dof.
    pub scaled: bool,
}

/// Residuals of a station, output − fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualRow {
    /// The station.
    pub station: String,
    /// Accelerometer \[m/s²\].
    pub accel: [Option<f64>; 3],
    /// Gyro \[rad/s\].
    pub gyro: [Option<f64>; 3],
    /// Standard uncertainty of the accelerometer's: of the output and of the reference with its tilt; none without
    /// standard errors.
    pub accel_sigma: [Option<f64>; 3],
    /// The same of the gyro.
    pub gyro_sigma: [Option<f64>; 3],
}

/// What a table gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Estimated terms.
    pub parameters: Vec<Parameter>,
    /// Names of the covariance, in the order of [`Outcome::parameters`] without run-to-run terms.
    pub covariance_names: Vec<String>,
    /// Covariance, whole.
    pub covariance: Vec<Vec<f64>>,
    /// Terms not determined.
    pub held: Vec<Held>,
    /// Terms determined and not asked for.
    pub available: Vec<Available>,
    /// Pairs with |correlation| > 0.95, strongest first.
    pub confused: Vec<(String, String, f64)>,
    /// Goodness of fit by axis.
    pub fits: Vec<AxisFit>,
    /// Residuals by station.
    pub residuals: Vec<ResidualRow>,
    /// Root mean square residual of gyro and accelerometer.
    pub residual_rms: [Option<f64>; 2],
    /// |f̂| − |f| of each station with accelerometer outputs, before the correction.
    pub before_m_s2: Vec<f64>,
    /// The same after.
    pub after_m_s2: Vec<f64>,
    /// Stations to add.
    pub additions: Vec<Addition>,
    /// Terms asked for that no station of the list determines.
    pub hopeless: Vec<String>,
    /// Number of switch-ons.
    pub runs: usize,
    /// Whether standard errors were given, gyro and accelerometer.
    pub has_errors: [bool; 2],
}

impl Outcome {
    /// The parameter of a path.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// An axis with its decision.
pub(crate) struct Decided {
    pub(super) problem: Problem,
    /// Weighted columns of all terms at r = 0, triangular, right-hand side last.
    pub(super) factor: DMatrix<f64>,
    pub(super) status: Vec<Status>,
    pub(super) asked: Vec<bool>,
    pub(super) reach: f64,
    pub(super) warmth_k: f64,
    pub(super) slow: bool,
}

impl Decided {
    /// Columns that are estimated.
    pub(super) fn estimated(&self) -> Vec<usize> {
        (0..self.status.len())
            .filter(|i| self.asked[*i] && self.status[*i] == Status::Admitted)
            .collect()
    }

    pub(super) fn plausible(&self, term: usize) -> f64 {
        self.problem.terms[term].plausible(self.problem.sensor, self.reach, self.warmth_k)
    }

    /// The factor's columns of some terms, and its right-hand side.
    pub(super) fn columns(&self, chosen: &[usize]) -> DMatrix<f64> {
        let side = self.factor.ncols() - 1;
        DMatrix::from_fn(self.factor.nrows(), chosen.len() + 1, |i, j| {
            self.factor[(i, chosen.get(j).copied().unwrap_or(side))]
        })
    }

    /// The term of a parameter path, where it is of this axis.
    pub(crate) fn term_of(&self, name: &str) -> Option<usize> {
        (0..self.status.len()).find(|t| self.name(*t) == name)
    }

    pub(super) fn name(&self, term: usize) -> String {
        self.problem.terms[term].name(self.problem.sensor, self.problem.k)
    }

    /// Decides anew with a factor that may have further rows.
    pub(super) fn decide(
        &self,
        columns: &DMatrix<f64>,
        reach: f64,
        warmth_k: f64,
        slow: bool,
    ) -> Vec<Status> {
        let sensor = self.problem.sensor;
        let mut order: Vec<Vec<Candidate>> = Vec::new();
        for asked in [true, false] {
            let mut last: Option<Group> = None;
            for (i, term) in self.problem.terms.iter().enumerate() {
                if self.asked[i] != asked {
                    continue;
                }
                let weak = slow
                    && sensor == Sensor::Gyro
                    && matches!(
                        term.group,
                        Group::ScaleFactor
                            | Group::Misalignment
                            | Group::ScaleTemperature(_)
                            | Group::Quadratic
                            | Group::Asymmetry
                            | Group::Cubic
                    );
                let candidate = Candidate {
                    column: i,
                    plausible: term.plausible(sensor, reach, warmth_k),
                    weak,
                };
                match order.last_mut() {
                    Some(group) if last == Some(term.group) => group.push(candidate),
                    _ => order.push(vec![candidate]),
                }
                last = Some(term.group);
            }
        }
        admit(columns, &order, self.problem.has_errors)
    }
}

const NO_OFFSETS: [[f64; 3]; 3] = [[0.0; 3]; 3];

/// Estimates every term of a table that is asked for and determined.
///
/// # Errors
/// See [`Error`].
pub fn calibrate(stations: &[Station], options: &Options) -> Result<Outcome, Error> {
    check::check(stations, options)?;
    let (labels, _) = runs_of(stations);
    let decided = decide_all(stations, options);
    if decided.iter().all(|d| d.estimated().is_empty()) {
        return Err(Error::NothingDetermined);
    }
    let mut outcome = Outcome {
        parameters: Vec::new(),
        covariance_names: Vec::new(),
        covariance: Vec::new(),
        held: Vec::new(),
        available: Vec::new(),
        confused: Vec::new(),
        fits: Vec::new(),
        residuals: stations
            .iter()
            .map(|s| ResidualRow {
                station: s.label.clone(),
                accel: [None; 3],
                gyro: [None; 3],
                accel_sigma: [None; 3],
                gyro_sigma: [None; 3],
            })
            .collect(),
        residual_rms: [None; 2],
        before_m_s2: Vec::new(),
        after_m_s2: Vec::new(),
        additions: Vec::new(),
        hopeless: Vec::new(),
        runs: labels,
        has_errors: [Sensor::Gyro, Sensor::Accel].map(|sensor| {
            decided
                .iter()
                .any(|d| d.problem.sensor == sensor && d.problem.has_errors)
        }),
    };
    for axes in decided.chunks(3) {
        estimate(stations, axes, &mut outcome)?;
    }
    for d in &decided {
        tell(d, labels, &mut outcome);
    }
    outcome
        .confused
        .sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    let (additions, hopeless) = add::additions(stations, options, &decided);
    outcome.additions = additions;
    outcome.hopeless = hopeless;
    Ok(outcome)
}

/// What the table determines of every axis that it has.
pub(crate) fn decide_all(stations: &[Station], options: &Options) -> Vec<Decided> {
    let (labels, runs) = runs_of(stations);
    let mut out = Vec::new();
    for sensor in [Sensor::Accel, Sensor::Gyro] {
        out.extend(decide(stations, options, sensor, &runs, labels));
    }
    out
}

/// Standard errors of what a table determines, by the standard errors that it states.
pub(crate) fn sigmas(stations: &[Station], options: &Options) -> Vec<(String, f64)> {
    let mut out = Vec::new();
    for axis in decide_all(stations, options) {
        let chosen = axis.estimated();
        if let Some(solution) = solve(axis.columns(&chosen)) {
            for (i, t) in chosen.iter().enumerate() {
                out.push((axis.name(*t), solution.covariance[(i, i)].max(0.0).sqrt()));
            }
        }
    }
    out
}

/// How many switch-ons there are (1 where none is named), and that of each station.
fn runs_of(stations: &[Station]) -> (usize, Vec<usize>) {
    let mut labels: Vec<&str> = Vec::new();
    let runs = stations
        .iter()
        .map(|s| {
            let label = s.run.as_deref().unwrap_or("");
            labels.iter().position(|l| *l == label).unwrap_or_else(|| {
                labels.push(label);
                labels.len() - 1
            })
        })
        .collect();
    (labels.len().max(1), runs)
}

fn decide(
    stations: &[Station],
    options: &Options,
    sensor: Sensor,
    runs: &[usize],
    labels: usize,
) -> Vec<Decided> {
    let rows: Vec<usize> = (0..stations.len())
        .filter(|i| stations[*i].output(sensor).is_some())
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let temperatures = || rows.iter().filter_map(|i| stations[*i].temperature_c);
    let low = temperatures().fold(f64::INFINITY, f64::min);
    let high = temperatures().fold(f64::NEG_INFINITY, f64::max);
    let warm = temperatures().count() == rows.len() && high - low >= 5.0;
    let warmth_k = temperatures()
        .map(|t| (t - options.reference_temperature_c).abs())
        .fold(0.0, f64::max);
    let groups = Group::of(
        sensor,
        options.temperature_order,
        options.scale_temperature_order,
    );
    let has_errors = rows
        .iter()
        .all(|i| stations[*i].output_se(sensor).is_some());
    (0..3)
        .map(|k| {
            let terms = Term::of(&groups, k, labels);
            let problem = Problem {
                sensor,
                k,
                rows: rows.clone(),
                runs: rows.iter().map(|i| runs[*i]).collect(),
                has_errors,
                reference_c: options.reference_temperature_c,
                terms,
            };
            let count = problem.terms.len();
            let state: State = std::array::from_fn(|_| vec![0.0; count]);
            let all: Vec<usize> = (0..count).collect();
            let factor = problem.factor(stations, &all, &state, &NO_OFFSETS);
            let reach = rows
                .iter()
                .map(|i| stations[*i].input(sensor)[k].abs())
                .fold(0.0, f64::max);
            let slow = rows
                .iter()
                .all(|i| dot(stations[*i].w, stations[*i].w).sqrt() < 1e-3);
            let mut out = Decided {
                asked: problem
                    .terms
                    .iter()
                    .map(|t| options.asked.has(t.group, warm))
                    .collect(),
                factor,
                status: Vec::new(),
                problem,
                reach,
                warmth_k,
                slow,
            };
            let columns = out.factor.columns(0, count).into_owned();
            out.status = out.decide(&columns, reach, warmth_k, slow);
            out
        })
        .collect()
}

/// Solves the three axes of a sensor together and writes what came out.
fn estimate(stations: &[Station], axes: &[Decided], outcome: &mut Outcome) -> Result<(), Error> {
    let chosen: Vec<Vec<usize>> = axes.iter().map(Decided::estimated).collect();
    let mut state: State = std::array::from_fn(|k| vec![0.0; axes[k].problem.terms.len()]);
    let mut offsets = NO_OFFSETS;
    let mut solutions: Vec<Option<Solution>> = vec![None; 3];
    let curved = (0..3).any(|k| {
        chosen[k]
            .iter()
            .any(|t| axes[k].problem.terms[*t].group == Group::AxisOffset)
    });
    let fixed_weights = !axes
        .iter()
        .any(|axis| axis.problem.has_reference_errors(stations));
    for round in 0..30 {
        for (k, axis) in axes.iter().enumerate() {
            if chosen[k].is_empty() {
                continue;
            }
            // The factor at the start is known from the decision.
            let design = if round == 0 {
                axis.columns(&chosen[k])
            } else {
                axis.problem.factor(stations, &chosen[k], &state, &offsets)
            };
            solutions[k] = solve(design);
        }
        let before = offsets;
        for (k, solution) in solutions.iter().enumerate() {
            if let Some(solution) = solution {
                for (t, value) in chosen[k].iter().zip(&solution.values) {
                    state[k][*t] = *value;
                }
            }
        }
        for (k, axis) in axes.iter().enumerate() {
            if axis.problem.sensor == Sensor::Accel {
                offsets[k] = axis.problem.offset(&state);
            }
        }
        let moved = offsets
            .iter()
            .flatten()
            .zip(before.iter().flatten())
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        if !curved && fixed_weights || round >= 2 && (!curved || moved < 1e-12) {
            break;
        }
    }
    for (k, axis) in axes.iter().enumerate() {
        write_axis(
            stations,
            axis,
            &chosen[k],
            solutions[k].as_ref(),
            &state,
            &offsets,
            outcome,
        )?;
    }
    let sensor = axes[0].problem.sensor;
    let all: Vec<f64> = outcome
        .residuals
        .iter()
        .flat_map(|r| match sensor {
            Sensor::Gyro => r.gyro,
            Sensor::Accel => r.accel,
        })
        .flatten()
        .collect();
    outcome.residual_rms[sensor.index()] = Some(rms(&all));
    if sensor == Sensor::Accel {
        magnitudes(stations, axes, &state, &offsets, outcome);
    }
    Ok(())
}

/// Root of the mean square.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[allow(clippy::too_many_arguments, reason = "one axis of the outcome")]
fn write_axis(
    stations: &[Station],
    axis: &Decided,
    chosen: &[usize],
    solution: Option<&Solution>,
    state: &State,
    offsets: &[[f64; 3]; 3],
    outcome: &mut Outcome,
) -> Result<(), Error> {
    let problem = &axis.problem;
    let (sensor, k) = (problem.sensor, problem.k);
    let label = format!("{}_{}", sensor.key(), AXES[k]);
    let roots = problem.root_weights(stations, state);
    for ((row, residual), root) in problem
        .rows
        .iter()
        .zip(problem.residuals(stations, state, offsets))
        .zip(roots)
    {
        let sigma = problem.has_errors.then(|| 1.0 / root);
        let place = &mut outcome.residuals[*row];
        match sensor {
            Sensor::Gyro => (place.gyro[k], place.gyro_sigma[k]) = (Some(residual), sigma),
            Sensor::Accel => (place.accel[k], place.accel_sigma[k]) = (Some(residual), sigma),
        }
    }
    let Some(solution) = solution else {
        return Ok(());
    };
    let dof = problem.rows.len().saturating_sub(chosen.len());
    if dof == 0 && !problem.has_errors {
        return Err(Error::NoFreedom {
            axis: label,
            rows: problem.rows.len(),
        });
    }
    let p = (problem.has_errors && dof > 0)
        .then(|| ChiSquared::new(dof as f64).map_or(f64::NAN, |d| d.sf(solution.chi2)));
    let scaled = !problem.has_errors || p.is_some_and(|p| p < 0.01);
    let factor = if scaled {
        solution.chi2 / dof.max(1) as f64
    } else {
        1.0
    };
    let quantile = if scaled {
        student(dof as f64)
    } else {
        NORMAL_975
    };
    outcome.fits.push(AxisFit {
        axis: label,
        chi2: solution.chi2,
        dof,
        p,
        scaled,
    });
    let runs = chosen
        .iter()
        .filter(|t| problem.terms[**t].group == Group::Bias)
        .count();
    // One row of weights a parameter: the biases of several switch-ons are averaged.
    let mut rows: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
    for (i, t) in chosen.iter().enumerate() {
        if problem.terms[*t].group == Group::Bias {
            if problem.terms[*t].component == 0 || runs == 1 {
                let members = chosen
                    .iter()
                    .enumerate()
                    .filter(|(_, t)| problem.terms[**t].group == Group::Bias)
                    .map(|(i, _)| (i, 1.0 / runs as f64))
                    .collect();
                rows.push((*t, members));
            }
        } else {
            rows.push((*t, vec![(i, 1.0)]));
        }
    }
    let full = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
        let mut sum = 0.0;
        for (i, u) in a {
            for (j, v) in b {
                sum += u * v * solution.covariance[(*i, *j)] * factor;
            }
        }
        sum
    };
    let first = outcome.covariance_names.len();
    for (t, members) in &rows {
        let value: f64 = members.iter().map(|(i, w)| solution.values[*i] * w).sum();
        let mut sigma = full(members, members).max(0.0).sqrt();
        let mut q = quantile;
        let mut spread = None;
        if problem.terms[*t].group == Group::Bias && runs >= 2 {
            let biases: Vec<f64> = members.iter().map(|(i, _)| solution.values[*i]).collect();
            let n = runs as f64;
            let s2 = biases.iter().map(|b| (b - value).powi(2)).sum::<f64>() / (n - 1.0);
            let row_variance = members
                .iter()
                .map(|(i, _)| solution.covariance[(*i, *i)] * factor)
                .sum::<f64>()
                / n;
            spread = Some((s2, row_variance, n));
            let between = (s2 / n).sqrt();
            if between > sigma {
                sigma = between;
                q = student(n - 1.0);
            }
        }
        outcome.covariance_names.push(axis.name(*t));
        outcome.parameters.push(Parameter {
            name: axis.name(*t),
            sensor,
            axis: k,
            term: Some(problem.terms[*t]),
            value,
            sigma,
            lower: value - q * sigma,
            upper: value + q * sigma,
            assumes: Vec::new(),
        });
        if let Some((s2, row_variance, n)) = spread {
            outcome
                .parameters
                .push(stability(sensor, k, s2, row_variance, n));
        }
    }
    let size = first + rows.len();
    for row in &mut outcome.covariance {
        row.resize(size, 0.0);
    }
    for (i, (_, a)) in rows.iter().enumerate() {
        let mut row = vec![0.0; size];
        for (j, (_, b)) in rows.iter().enumerate() {
            row[first + j] = full(a, b);
        }
        // The bias of several switch-ons carries their spread.
        if let Some(parameter) = outcome.parameter(&outcome.covariance_names[first + i]) {
            row[first + i] = parameter.sigma.powi(2);
        }
        outcome.covariance.push(row);
    }
    Ok(())
}

/// The run-to-run standard deviation of a bias, with limits from χ².
fn stability(sensor: Sensor, k: usize, s2: f64, row_variance: f64, n: f64) -> Parameter {
    let root = |v: f64| (v - row_variance).max(0.0).sqrt();
    let (low, high) = ChiSquared::new(n - 1.0).map_or((0.0, f64::INFINITY), |d| {
        (
            s2 * (n - 1.0) / d.inverse_cdf(0.975),
            s2 * (n - 1.0) / d.inverse_cdf(0.025),
        )
    });
    Parameter {
        name: format!("{}.bias.stability.{}", sensor.key(), AXES[k]),
        sensor,
        axis: k,
        term: None,
        value: root(s2),
        sigma: s2.sqrt() / (2.0 * (n - 1.0)).sqrt(),
        lower: root(low),
        upper: root(high),
        assumes: Vec::new(),
    }
}

/// The 97.5 % point of the normal distribution.
pub(super) const NORMAL_975: f64 = 1.959_963_984_540_054;

/// The 97.5 % point of Student's t.
fn student(dof: f64) -> f64 {
    StudentsT::new(0.0, 1.0, dof).map_or(f64::INFINITY, |d| d.inverse_cdf(0.975))
}
