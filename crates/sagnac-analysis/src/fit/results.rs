//! From the fit's own units to estimates in SI: intervals, limits, lines, regressors, covariance and spectrum.
//!
//! A variance θ in units of scale² stands for Q = √θ·scale·dt, N = √θ·scale·√dt, B = √θ·scale, K = √θ·scale/√dt; intervals
//! and limits are those of the likelihood profile [CoxHinkley1974].

use super::bins::{BinnedLog, Column};
use super::estimate::{Active, ActiveKind, Work};
use super::likelihood::{B, FIRST_GM, Free, K, N, Parameters, Problem, Q, Solution};
use super::profile::{self, INTERVAL, LIMIT, Side};
use super::regress;
use super::select::Tests;
use super::singles::Tested;
use super::types::{
    Covariance, Estimate, GaussMarkovEstimate, NoiseTerms, Regressor, RegressorKind, SpectrumBin,
};

/// Scales from the fit's units to SI.
pub(super) struct Units {
    scale: f64,
    step_s: f64,
}

impl Units {
    pub(super) fn new(work: &Work) -> Self {
        Self {
            scale: work.scale,
            step_s: work.step_s,
        }
    }

    /// Root of a variance parameter in SI.
    pub(super) fn root(&self, index: usize, variance: f64) -> f64 {
        let root = variance.max(0.0).sqrt() * self.scale;
        match index {
            Q => root * self.step_s,
            N => root * self.step_s.sqrt(),
            K => root / self.step_s.sqrt(),
            _ => root,
        }
    }

    pub(super) fn time(&self, log_time: f64) -> f64 {
        log_time.exp() * self.step_s
    }

    pub(super) fn terms(&self, parameters: &Parameters) -> NoiseTerms {
        NoiseTerms {
            quantization: self.root(Q, parameters[Q]),
            white: self.root(N, parameters[N]),
            flicker: self.root(B, parameters[B]),
            random_walk: self.root(K, parameters[K]),
            ramp: 0.0,
            gauss_markov: (0..2)
                .map(|g| FIRST_GM + 2 * g)
                .filter(|&at| parameters[at] > 0.0)
                .map(|at| (self.root(at, parameters[at]), self.time(parameters[at + 1])))
                .collect(),
            sinusoids: Vec::new(),
        }
    }
}

/// Coefficients below the frequency down from which a term outweighs those that are flatter than it.
pub(super) fn coefficients_below_corner(
    problem: &Problem,
    parameters: &Parameters,
    index: usize,
) -> f64 {
    let flatter: &[usize] = match index {
        B => &[Q, N],
        K => &[Q, N, B],
        _ => return f64::INFINITY,
    };
    let mut order: Vec<usize> = (0..problem.u.len()).collect();
    order.sort_by(|&a, &b| problem.u[b].total_cmp(&problem.u[a]));
    let mut below = problem.coefficients();
    for b in order {
        let rest: f64 = flatter
            .iter()
            .map(|&k| parameters[k] * problem.basis(k)[b])
            .sum();
        if parameters[index] * problem.basis(index)[b] >= rest {
            return below;
        }
        below -= problem.count[b];
    }
    0.0
}

/// Value, profile interval and standard deviation of a detected variance.
pub(super) fn interval(
    problem: &Problem,
    best: &Solution,
    free: &Free,
    index: usize,
    covariance: Option<&(Vec<usize>, Vec<f64>)>,
    to_si: impl Fn(f64) -> f64,
) -> Estimate {
    let lower = profile::bound(problem, best, free, index, Side::Lower, INTERVAL);
    let upper = profile::bound(problem, best, free, index, Side::Upper, INTERVAL);
    let value = best.parameters[index];
    let root = value.sqrt();
    let sigma_root = covariance
        .and_then(|(indices, m)| {
            let place = indices.iter().position(|&i| i == index)?;
            Some(m[place * indices.len() + place].sqrt() / (2.0 * root))
        })
        .unwrap_or((upper.sqrt() - lower.sqrt()) / 3.92);
    let si = to_si(value);
    Estimate::detected(si, to_si(lower), to_si(upper), si * sigma_root / root)
}

/// An interval wide enough for a second one of the same number.
pub(super) fn widened(own: Estimate, other: &Estimate) -> Estimate {
    let both = |a: Option<f64>, b: Option<f64>, f: fn(f64, f64) -> f64| match (a, b) {
        (Some(a), Some(b)) => Some(f(a, b)),
        (a, b) => a.or(b),
    };
    Estimate {
        lower: both(own.lower, other.lower, f64::min),
        upper: both(own.upper, other.upper, f64::max),
        ..own
    }
}

/// The interval of K, wide enough for slow columns that are possible but were not taken in, a line and powers of the
/// temperature: that of the restricted likelihood, in which they may have any coefficients, counts as well.
pub(super) fn beside_columns(
    work: &Work,
    active: &[Active],
    possible: &[Column],
    best: &Solution,
    free: &Free,
    own: Estimate,
    units: &Units,
) -> Estimate {
    if !own.is_detected() || possible.is_empty() {
        return own;
    }
    let problem = with_columns(work, active, possible, true);
    let fit = problem.fit(&best.parameters, free);
    if fit.parameters[K] <= 0.0 {
        return own;
    }
    let other = interval(&problem, &fit, free, K, None, |v| units.root(K, v));
    widened(own, &other)
}

/// The bins with more columns after those taken in.
fn with_columns(work: &Work, active: &[Active], more: &[Column], restricted: bool) -> Problem {
    let mut columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
    columns.extend_from_slice(more);
    let log = work.layout.sum(&work.segments, &columns, work.cut);
    Problem::new(&[&log], restricted)
}

/// End of the interval of ln T_c of the process at `at`. Beyond the time of a rival the two would change places in the
/// profile: the rival's time is held there.
fn time_bound(
    problem: &Problem,
    tests: &Tests,
    fit: &Solution,
    free: &Free,
    at: usize,
    side: Side,
) -> f64 {
    let end = profile::bound(problem, fit, free, at + 1, side, INTERVAL);
    let Some(rival) = tests.time_of_rival().filter(|&r| r != at + 1 && free[r]) else {
        return end;
    };
    let own = fit.parameters[at + 1];
    let other = fit.parameters[rival];
    if (other - own) * (end - other) <= 0.0 {
        return end;
    }
    let mut held = *free;
    held[rival] = false;
    profile::bound(problem, fit, &held, at + 1, side, INTERVAL)
}

pub(super) fn gauss_markov_estimates(fit: &Tested<'_>) -> Vec<GaussMarkovEstimate> {
    let &Tested {
        problem,
        tests,
        best,
        free,
        covariance,
        alternative,
        units,
    } = fit;
    let mut out = Vec::new();
    let fast = problem.surely_fast(best, free);
    for g in 0..tests.gauss_markov {
        let at = FIRST_GM + 2 * g;
        // At an end of the range searched the process lies outside it, and so does its interval.
        let is_outside = problem.time_at_edge(best.parameters[at + 1]) || fast.contains(&at);
        if best.parameters[at] <= 0.0 || is_outside {
            continue;
        }
        if tests.last_is_rival() && g + 1 == tests.gauss_markov {
            continue;
        }
        let sigma = interval(problem, best, free, at, covariance, |v| units.root(at, v));
        let log_time = best.parameters[at + 1];
        let lower = time_bound(problem, tests, best, free, at, Side::Lower);
        let upper = time_bound(problem, tests, best, free, at, Side::Upper);
        let spread = covariance
            .and_then(|(indices, m)| {
                let place = indices.iter().position(|&i| i == at + 1)?;
                Some(m[place * indices.len() + place].sqrt())
            })
            .unwrap_or((upper - lower) / 3.92);
        let time = units.time(log_time);
        let mut found = GaussMarkovEstimate {
            sigma,
            correlation_time_s: Estimate::detected(
                time,
                units.time(lower),
                units.time(upper),
                time * spread,
            ),
        };
        // Which of two rivals stands beside it is not known: both intervals count.
        if let Some((fit, free)) = alternative
            && fit.parameters[at] > 0.0
        {
            let other = interval(problem, fit, free, at, None, |v| units.root(at, v));
            let end = |side| units.time(time_bound(problem, tests, fit, free, at, side));
            let times = Estimate::detected(time, end(Side::Lower), end(Side::Upper), 0.0);
            found = GaussMarkovEstimate {
                sigma: widened(found.sigma, &other),
                correlation_time_s: widened(found.correlation_time_s, &times),
            };
        }
        out.push(found);
    }
    if out.is_empty() {
        // The largest limit over the correlation times searched; a process that rivals a term may have all its power.
        // One that is too fast to be reported keeps its place.
        let at = FIRST_GM + if fast.is_empty() { 0 } else { 2 };
        let (low, high) = (problem.shortest, problem.log_time.1);
        let mut held = tests.full_free;
        if tests.last_is_rival() {
            for k in 0..4 {
                held[k] &= !tests.rivaled[k];
            }
        }
        held[at] = true;
        held[at + 1] = false;
        let mut worst = 0.0_f64;
        let points = 6;
        for i in 0..=points {
            let mut start = tests.full.parameters;
            for k in 0..4 {
                if !held[k] {
                    start[k] = 0.0;
                }
            }
            start[at] = 0.0;
            start[at + 1] = low + (high - low) * f64::from(i) / f64::from(points);
            let fit = problem.fit_limited(&start, &held, 8);
            worst = worst.max(profile::bound(problem, &fit, &held, at, Side::Upper, LIMIT));
        }
        out.push(GaussMarkovEstimate {
            sigma: Estimate::limit(units.root(at, worst)),
            correlation_time_s: Estimate::ABSENT,
        });
    }
    out.sort_by(|a, b| {
        let time = |e: &GaussMarkovEstimate| e.correlation_time_s.value.unwrap_or(0.0);
        time(a).total_cmp(&time(b))
    });
    out
}

/// The line in time: its slope where it was taken in, else a limit of |R|.
pub(super) fn ramp(
    work: &Work,
    active: &[Active],
    problem: &Problem,
    tests: &Tests,
    best: &Solution,
    free: &Free,
    wanted: bool,
) -> (Estimate, Option<f64>) {
    if !wanted {
        return (Estimate::ABSENT, None);
    }
    let unit = work.scale / work.step_s;
    let place = active.iter().position(|a| a.kind == ActiveKind::Ramp);
    let (extended, solution, free_set, at, found) = if let Some(place) = place {
        (problem.clone(), best.clone(), *free, place, true)
    } else {
        let extended = with_columns(work, active, &[regress::line(&work.segments)], false);
        let fit = extended.fit(&tests.full.parameters, &tests.full_free);
        (extended, fit, tests.full_free, active.len(), false)
    };
    // The profile of a coefficient of the mean: the plain likelihood, noise terms free.
    let plain_keep: Vec<usize> = (0..extended.columns()).collect();
    let plain = extended.with_columns(&plain_keep, false);
    let solution = if found {
        plain.fit(&solution.parameters, &free_set)
    } else {
        solution
    };
    let (lower, upper, sigma) = coefficient_interval(&plain, &solution, &free_set, at);
    let p = plain.columns();
    let without: Vec<usize> = (0..p).filter(|&i| i != at).collect();
    let ratio = plain
        .with_columns(&without, false)
        .fit(&solution.parameters, &free_set)
        .objective
        - solution.objective;
    let estimate = if found {
        let restricted = best.beta[0][at] * unit;
        Estimate::detected(restricted, lower * unit, upper * unit, sigma * unit)
    } else {
        Estimate::limit(lower.abs().max(upper.abs()) * unit)
    };
    (estimate, Some(ratio.max(0.0)))
}

/// Lower and upper end of the profile of a column's coefficient, noise terms refitted, and its spread given the noise.
///
/// `plain` is the unrestricted problem, `solution` its best fit.
fn coefficient_interval(
    plain: &Problem,
    solution: &Solution,
    free: &Free,
    at: usize,
) -> (f64, f64, f64) {
    let value = solution.beta[0][at];
    let p = plain.columns();
    let sigma = solution.beta_covariance[0][at * p + at].sqrt();
    let mut warm = solution.parameters;
    let mut rise = |x: f64| {
        let fit = plain.with_held_column(at, x).fit_limited(&warm, free, 25);
        warm = fit.parameters;
        fit.objective - solution.objective
    };
    let upper = profile::search(value, sigma, Side::Upper, INTERVAL, true, &mut rise);
    let lower = profile::search(value, sigma, Side::Lower, INTERVAL, true, &mut rise);
    (lower, upper, sigma)
}

/// The columns taken in, but for the line in time and steps. How a slow column's coefficient scatters hangs on a few coefficients of
/// the noise: its interval is that of the profile.
pub(super) fn describe(
    work: &Work,
    active: &[Active],
    problem: &Problem,
    best: &Solution,
    free: &Free,
) -> Vec<Regressor> {
    let keep: Vec<usize> = (0..active.len()).collect();
    let plain = problem.with_columns(&keep, false);
    let fit = plain.fit(&best.parameters, free);
    active
        .iter()
        .enumerate()
        .filter_map(|(i, a)| {
            let kind = match a.kind {
                ActiveKind::Ramp | ActiveKind::Step(..) => return None,
                ActiveKind::Temperature(power) => RegressorKind::Temperature { power },
                ActiveKind::WarmUp(tau) => RegressorKind::WarmUp {
                    time_constant_s: tau * work.step_s,
                },
            };
            let value = best.beta[0][i];
            let (lower, upper, sigma) = coefficient_interval(&plain, &fit, free, i);
            Some(Regressor {
                kind,
                value: value * work.scale,
                lower: lower.min(value - 1.96 * sigma) * work.scale,
                upper: upper.max(value + 1.96 * sigma) * work.scale,
            })
        })
        .collect()
}

/// Covariance of the terms reported as detected, `single` and `gauss_markov`, in their order.
pub(super) fn named_covariance(
    covariance: Option<&(Vec<usize>, Vec<f64>)>,
    parameters: &Parameters,
    units: &Units,
    single: &[Estimate; 4],
    gauss_markov: &[GaussMarkovEstimate],
) -> Covariance {
    let Some((indices, matrix)) = covariance else {
        return Covariance::default();
    };
    let singles = (0..4)
        .filter(|&k| single[k].is_detected())
        .map(|k| (k, ["Q", "N", "B", "K"][k].to_owned()));
    let place_of = |g: &GaussMarkovEstimate| {
        let time = g.correlation_time_s.value?;
        let is_it = |&at: &usize| units.time(parameters[at + 1]).to_bits() == time.to_bits();
        [FIRST_GM, FIRST_GM + 2].into_iter().find(is_it)
    };
    let processes = gauss_markov.iter().filter_map(place_of).enumerate();
    let times = processes.flat_map(|(i, at)| {
        [
            (at, format!("sigma{}", i + 1)),
            (at + 1, format!("Tc{}", i + 1)),
        ]
    });
    // Place in the matrix, name, and slope from a variance or ln T_c to the term itself.
    let reported: Vec<(usize, String, f64)> = singles
        .chain(times)
        .filter_map(|(i, name)| {
            let place = indices.iter().position(|&k| k == i)?;
            let slope = if super::likelihood::is_time(i) {
                units.time(parameters[i])
            } else {
                units.root(i, parameters[i]) / (2.0 * parameters[i])
            };
            Some((place, name, slope))
        })
        .collect();
    let n = indices.len();
    let row = |(a, _, s): &(usize, String, f64)| -> Vec<f64> {
        let of = |(b, _, t): &(usize, String, f64)| matrix[a * n + b] * s * t;
        reported.iter().map(of).collect()
    };
    Covariance {
        matrix: reported.iter().flat_map(row).collect(),
        names: reported.into_iter().map(|r| r.1).collect(),
    }
}

/// Measured and fitted densities of every bin, those above a filter's corner included.
pub(super) fn spectrum_bins(work: &Work, active: &[Active], best: &Solution) -> Vec<SpectrumBin> {
    let columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
    let log: BinnedLog = work.layout.sum(&work.segments, &columns, 0.5);
    let whole = Problem::new(&[&log], false);
    let power = whole.residual_power(best);
    let fit = whole.spectrum(&best.parameters);
    let unit = work.scale * work.scale * work.step_s;
    let count = whole.plain_count();
    let mut out: Vec<SpectrumBin> = (0..whole.u.len())
        .map(|b| SpectrumBin {
            frequency_hz: whole.u[b] / work.step_s,
            measured: power[b] * unit,
            fitted: fit[b] * unit,
            count: count[b],
            used: whole.u[b] <= work.cut,
        })
        .collect();
    out.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    out
}
