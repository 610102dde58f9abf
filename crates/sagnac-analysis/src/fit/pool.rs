//! Several logs of one sensor: one likelihood with common noise terms, each log with its own regressors.

use super::coarse::Coarse;
use super::cumulant;
use super::estimate::{ActiveKind, Prepared, prepare};
use super::goodness::chi_squared_tail;
use super::likelihood::{B, K, N, Problem, Q, Solution};
use super::profile;

use super::results::{Units, gauss_markov_estimates, interval, limit, named_covariance, widened};
use super::runs::{self, RunToRun, Slope};
use super::select;
use super::types::{
    AxisData, Covariance, Estimate, FitOptions, GaussMarkovEstimate, NoiseTerms, Term,
};
use crate::compare::Outlier;

/// What several logs of one axis say together.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledEstimate {
    /// Q [unit·s].
    pub quantization: Estimate,
    /// N [unit·√s].
    pub white: Estimate,
    /// B, the coefficient [unit].
    pub flicker: Estimate,
    /// K [unit/√s].
    pub random_walk: Estimate,
    /// Gauss–Markov terms, as for one log.
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    /// Run-to-run standard deviation of the mean [unit], and what of it temperature explains.
    pub run_to_run: RunToRun,
    /// The logs that gave numbers, by their place.
    pub used: Vec<usize>,
    /// B and K cannot be told apart.
    pub confused: Vec<(Term, Term)>,
    /// Logs that do not fit the pooled terms (p < 0.001).
    pub outliers: Vec<Outlier>,
    /// The terms of the pooled fit.
    pub fitted: NoiseTerms,
    /// Covariance of the detected terms.
    pub covariance: Covariance,
}

/// Pools logs of one axis; none where fewer than two give parameters or their steps differ by more than 0.1 %.
pub fn estimate_pooled(logs: &[AxisData<'_>], options: &FitOptions) -> Option<PooledEstimate> {
    let prepared: Vec<(usize, Prepared)> = logs
        .iter()
        .enumerate()
        .filter_map(|(i, data)| prepare(data, options).ok().map(|p| (i, p)))
        .collect();
    let (first, rest) = prepared.split_first()?;
    let step_s = first.1.work.step_s;
    if rest.is_empty()
        || rest
            .iter()
            .any(|(_, p)| (p.work.step_s / step_s - 1.0).abs() > 1e-3)
    {
        return None;
    }
    let units = Units::new(&first.1.work);
    let binned: Vec<_> = prepared
        .iter()
        .map(|(_, p)| {
            let columns: Vec<_> = p.active.iter().map(|a| a.column.clone()).collect();
            let mut log = p.work.layout.sum(&p.work.segments, &columns, p.work.cut);
            log.rescale(p.work.scale / first.1.work.scale);
            log
        })
        .collect();
    let restricted = prepared.iter().any(|(_, p)| !p.active.is_empty());
    let problem = Problem::new(&binned.iter().collect::<Vec<_>>(), restricted);
    let mut candidates = options.candidates;
    candidates.gauss_markov = prepared
        .iter()
        .map(|(_, p)| p.candidates.gauss_markov)
        .max()
        .unwrap_or(0);
    let tests = select::test(&problem, &candidates, select::grow(&problem, &candidates));
    let (best, free) = tests.final_fit(&problem, &candidates);
    let mut covariance = profile::covariance(&problem, &best, &free);
    let theta = best.parameters[Q] * first.1.work.scale * first.1.work.scale;
    let (mut samples, mut excess) = (0, 0.0);
    for (i, p) in &prepared {
        let own = p.work.samples - p.work.filled;
        samples += own;
        excess += own as f64 * cumulant::excess(logs[*i].segments, theta);
    }
    let quantization = cumulant::apply(
        &mut covariance,
        best.parameters[Q],
        excess / samples.max(1) as f64,
        samples,
    );
    // Where two rivals are not told apart the intervals of the other terms hold with either.
    let alternative = tests.alternative(&problem, &candidates);
    let with_either = |own: Estimate, k: usize| match &alternative {
        Some((fit, free)) if free[k] && fit.parameters[k] > 0.0 => {
            let other = interval(&problem, fit, free, k, None, |v| units.root(k, v));
            widened(own, &other)
        }
        _ => own,
    };
    let allowed = [
        candidates.quantization,
        candidates.white,
        candidates.flicker,
        candidates.random_walk,
    ];
    let mut single = [Estimate::ABSENT; 4];
    for k in 0..4 {
        if !allowed[k] {
            continue;
        }
        let confused = tests.is_confused(k);
        single[k] = if tests.passed[k] && !confused && best.parameters[k] > 0.0 {
            let own = interval(&problem, &best, &free, k, covariance.as_ref(), |v| {
                units.root(k, v)
            });
            let own = with_either(own, k);
            if k == Q {
                cumulant::narrowed(own, quantization)
            } else {
                own
            }
        } else {
            Estimate::limit(units.root(k, limit(&problem, &tests, k)))
        };
    }
    let mut gauss_markov = if candidates.gauss_markov == 0 {
        vec![GaussMarkovEstimate {
            sigma: Estimate::ABSENT,
            correlation_time_s: Estimate::ABSENT,
        }]
    } else {
        gauss_markov_estimates(
            &problem,
            &tests,
            &best,
            &free,
            covariance.as_ref(),
            alternative.as_ref(),
            &units,
        )
    };
    // Of logs whose steps hide the noise the terms are bounded as those of one are.
    let coarse: Vec<Option<Coarse>> = prepared
        .iter()
        .map(|(i, _)| Coarse::of(&logs[*i]))
        .collect();
    for coarse in coarse.iter().flatten() {
        coarse.bound(&mut single, &mut gauss_markov);
    }
    let fitted = units.terms(&best.parameters);

    // Each log alone with the pooled terms free, against the pooled ones.
    let moving = free.iter().filter(|&&f| f).count();
    let mut outliers = Vec::new();
    for ((index, _), log) in prepared.iter().zip(&binned) {
        let mut own = Problem::new(&[log], restricted);
        own.log_time = problem.log_time;
        let ratio = own.objective(&best.parameters) - own.fit(&best.parameters, &free).objective;
        let p = chi_squared_tail(ratio, moving as f64);
        // Coarse steps make the spectrum of one sensor differ from log to log.
        if p < 1e-3 && coarse.iter().all(Option::is_none) {
            outliers.push(Outlier {
                log: *index,
                term: None,
                ratio: None,
                is_bound: false,
                p_value: Some(p),
            });
        }
    }

    let means: Vec<(f64, f64)> = prepared
        .iter()
        .zip(&coarse)
        .map(|((_, p), coarse)| {
            let duration = p.work.samples as f64 * step_s;
            let rounding = coarse.map_or(0.0, |c| c.mean_variance());
            (
                p.work.mean,
                fitted.mean_variance(duration, step_s) + rounding,
            )
        })
        .collect();
    let temperatures: Option<Vec<f64>> = prepared
        .iter()
        .map(|(i, _)| {
            let channel = logs[*i].temperature?;
            let count: usize = channel.iter().map(|s| s.samples.len()).sum();
            let sum: f64 = channel.iter().flat_map(|s| s.samples).sum();
            Some(sum / count.max(1) as f64)
        })
        .collect();
    let inside = slopes(
        &prepared,
        &best,
        first.1.work.scale,
        temperatures.as_deref(),
    );
    let run_to_run = runs::run_to_run(&means, temperatures.as_deref(), &inside);
    Some(PooledEstimate {
        quantization: single[Q],
        white: single[N],
        flicker: single[B],
        random_walk: single[K],
        covariance: named_covariance(
            covariance.as_ref(),
            &best.parameters,
            &units,
            &single,
            &gauss_markov,
        ),
        gauss_markov,
        run_to_run,
        used: prepared.iter().map(|(i, _)| *i).collect(),
        confused: tests.pairs(),
        outliers,
        fitted,
    })
}

/// The slopes with temperature inside those logs whose own fit has one, and no square, with the pooled terms.
fn slopes(
    prepared: &[(usize, Prepared)],
    best: &Solution,
    scale: f64,
    temperatures: Option<&[f64]>,
) -> Vec<Slope> {
    let Some(temperatures) = temperatures else {
        return Vec::new();
    };
    let logs = prepared.iter().zip(temperatures).enumerate();
    logs.filter_map(|(k, ((_, p), &temperature_c))| {
        let place = |power| {
            p.active
                .iter()
                .position(|a| a.kind == ActiveKind::Temperature(power))
        };
        let at = place(1).filter(|_| place(2).is_none())?;
        Some(Slope {
            temperature_c,
            value: best.beta[k][at] * scale,
            variance: best.beta_covariance[k][at * p.active.len() + at] * scale * scale,
        })
    })
    .collect()
}
