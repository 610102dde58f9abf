//! Several logs of one sensor: one likelihood with common noise terms, each log with its own regressors.

use super::coarse::Coarse;
use super::cumulant;
use super::estimate::{ActiveKind, Prepared, prepare};
use super::goodness::chi_squared_tail;
use super::likelihood::{B, K, N, Problem, Q, Solution};
use super::profile;
use super::results::{Units, gauss_markov_estimates, named_covariance};
use super::runs::{self, RunToRun, Slope};
use super::select;
use super::singles::Tested;
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

/// Pools logs of one axis, each at its own step; none where fewer than two give parameters.
pub fn estimate_pooled(logs: &[AxisData<'_>], options: &FitOptions) -> Option<PooledEstimate> {
    let prepared: Vec<(usize, Prepared)> = logs
        .iter()
        .enumerate()
        .filter_map(|(i, data)| prepare(data, options).ok().map(|p| (i, p)))
        .collect();
    let (first, rest) = prepared.split_first()?;
    if rest.is_empty() {
        return None;
    }
    let step_s = first.1.work.step_s;
    let units = Units::new(&first.1.work);
    let binned: Vec<_> = prepared
        .iter()
        .map(|(_, p)| {
            let columns: Vec<_> = p.active.iter().map(|a| a.column.clone()).collect();
            let mut log = p.work.layout.sum(&p.work.segments, &columns, p.work.cut);
            log.rescale(p.work.scale / first.1.work.scale);
            log.at_step(p.work.step_s / step_s);
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
        // Q of a log at another step has another variance.
        let own_theta = theta * (step_s / p.work.step_s).powi(2);
        excess += own as f64 * cumulant::excess(logs[*i].segments, own_theta);
    }
    let quantization = cumulant::apply(
        &mut covariance,
        best.parameters[Q],
        excess / samples.max(1) as f64,
        samples,
    );
    let alternative = tests.alternative(&problem, &candidates);
    let tested = Tested {
        problem: &problem,
        tests: &tests,
        best: &best,
        free: &free,
        covariance: covariance.as_ref(),
        alternative: alternative.as_ref(),
        units: &units,
    };
    let mut single = tested.singles(candidates.singles(), [false; 4], quantization);
    let mut gauss_markov = if candidates.gauss_markov == 0 {
        vec![GaussMarkovEstimate::ABSENT]
    } else {
        gauss_markov_estimates(&tested)
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
            let duration = p.work.samples as f64 * p.work.step_s;
            let rounding = coarse.map_or(0.0, |c| c.mean_variance());
            (
                p.work.mean,
                fitted.mean_variance(duration, p.work.step_s) + rounding,
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::fit::{Segment, Status};

    struct Normal(u64);

    impl Normal {
        /// The sum of twelve uniform numbers: its fourth cumulant is a tenth of a unit.
        fn next(&mut self) -> f64 {
            let mut sum = -6.0;
            for _ in 0..12 {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum
        }
    }

    /// Interval means of white noise N and a random walk K [per √s].
    fn samples(seed: u64, count: usize, step_s: f64, (white, walk): (f64, f64)) -> Vec<f64> {
        let mut normal = Normal(seed);
        let mut at = 0.0;
        (0..count)
            .map(|_| {
                let (a, b) = (normal.next(), normal.next());
                let root = walk * step_s.sqrt();
                let mean = at + root * (0.5 * a + b / 12.0_f64.sqrt());
                at += root * a;
                mean + white / step_s.sqrt() * normal.next()
            })
            .collect()
    }

    fn pooled(logs: &[(Vec<f64>, f64)]) -> PooledEstimate {
        let segments: Vec<[Segment<'_>; 1]> = logs
            .iter()
            .map(|(y, _)| {
                [Segment {
                    start_s: 0.0,
                    samples: y,
                    filled: &[],
                }]
            })
            .collect();
        let data: Vec<AxisData<'_>> = segments
            .iter()
            .zip(logs)
            .map(|(segments, (_, step_s))| AxisData {
                segments,
                temperature: None,
                step_s: *step_s,
                lsb: None,
            })
            .collect();
        estimate_pooled(&data, &FitOptions::default()).unwrap()
    }

    #[test]
    fn a_log_at_another_step_has_the_spectrum_that_it_has_alone() {
        let y = samples(1, 3000, 0.05, (1.0, 0.5));
        let segments = [Segment {
            start_s: 0.0,
            samples: &y,
            filled: &[],
        }];
        let data = AxisData {
            segments: &segments,
            temperature: None,
            step_s: 0.05,
            lsb: None,
        };
        let prepared = prepare(&data, &FitOptions::default())
            .map_err(|_| ())
            .unwrap();
        let own = prepared.work.layout.sum(&prepared.work.segments, &[], 0.5);
        let mut beside = own.clone();
        // Its step is 2.5 times that of the parameters, which stand at 0.02 s.
        let step = 2.5_f64;
        beside.at_step(step);
        let alone = Problem::new(&[&own], false);
        let problem = Problem::new(&[&own, &beside], false);
        // Q, N, B, K, and a process of 40 and of 16 steps.
        let there = [0.3, 2.0, 0.7, 0.01, 0.4, 40_f64.ln(), 0.0, 0.0];
        let mut here = there;
        here[Q] /= step * step;
        here[N] /= step;
        here[K] *= step;
        here[5] = (40.0 / step).ln();
        let bins = alone.u.len();
        let found = &problem.spectrum(&there)[bins..];
        for (a, b) in found.iter().zip(&alone.spectrum(&here)) {
            assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn logs_at_several_rates_give_the_terms_of_their_sensor() {
        // 0.2 % apart, and twice as fast; 40 seeds each, 95 % intervals: fewer than 33 of 40 come by chance in 0.4 %.
        for (rate_a, rate_b) in [(50.0, 49.9), (20.0, 40.0)] {
            let (white, walk) = (0.5, 0.05);
            let (mut white_held, mut walk_held) = (0, 0);
            for seed in 0..40 {
                let logs: Vec<(Vec<f64>, f64)> = [rate_a, rate_b]
                    .iter()
                    .enumerate()
                    .map(|(k, rate)| {
                        let count = (600.0 * rate) as usize;
                        let own = 1000 * seed + 7 * k as u64 + 1;
                        (samples(own, count, 1.0 / rate, (white, walk)), 1.0 / rate)
                    })
                    .collect();
                let found = pooled(&logs);
                let holds = |e: &Estimate, truth: f64| {
                    e.lower.unwrap_or(0.0) <= truth && truth <= e.upper.unwrap()
                };
                assert_eq!(found.white.status, Status::Detected);
                white_held += usize::from(holds(&found.white, white));
                walk_held += usize::from(holds(&found.random_walk, walk));
            }
            assert!(
                white_held >= 33 && walk_held >= 33,
                "{white_held} {walk_held}"
            );
        }
    }
}
