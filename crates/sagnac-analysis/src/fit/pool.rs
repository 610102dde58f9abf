//! Several logs of one sensor: one likelihood with common noise terms, each log with its own regressors.
//!
//! Bias stability s is the scatter of the runs' means beyond their in-run variances v_i: Q(s²) = Σ (m_i − μ̂)²/(s² + v_i)
//! is χ²_{n−1}; its interval inverts that, the value is the restricted likelihood's. Source: [Viechtbauer2007]. An upper
//! limit is at least the median one of runs without such scatter, v̄·(χ²_{0.5}/χ²_{0.05} − 1), v̄ the harmonic mean of v_i.

use super::cumulant;
use super::estimate::{Prepared, prepare};
use super::goodness::chi_squared_tail;
use super::likelihood::{B, K, N, Problem, Q};
use super::profile;
use super::results::{Units, gauss_markov_estimates, interval, limit, named_covariance, widened};
use super::select;
use super::types::{
    AxisData, Covariance, Estimate, FitOptions, GaussMarkovEstimate, NoiseTerms, Term,
};
use crate::compare::Outlier;
use statrs::distribution::{ChiSquared, ContinuousCDF};

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
    /// Run-to-run standard deviation of the mean [unit].
    pub bias_stability: Estimate,
    /// Slope of the runs' means with their temperatures [unit/K], value, lower, upper, where it shows.
    pub bias_temperature: Option<(f64, f64, f64)>,
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
    let free = tests.kept(&candidates);
    let best = select::final_fit(&problem, &tests.full, &free);
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
    let alternative = tests
        .alternative(&candidates)
        .map(|free| (select::final_fit(&problem, &tests.full, &free), free));
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
    let gauss_markov = if candidates.gauss_markov == 0 {
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
    let fitted = units.terms(&best.parameters);

    // Each log alone with the pooled terms free, against the pooled ones.
    let moving = free.iter().filter(|&&f| f).count();
    let mut outliers = Vec::new();
    for ((index, _), log) in prepared.iter().zip(&binned) {
        let mut own = Problem::new(&[log], restricted);
        own.log_time = problem.log_time;
        let ratio = own.objective(&best.parameters) - own.fit(&best.parameters, &free).objective;
        let p = chi_squared_tail(ratio, moving as f64);
        if p < 1e-3 {
            outliers.push(Outlier {
                log: *index,
                term: None,
                ratio: None,
                p_value: Some(p),
            });
        }
    }

    let means: Vec<(f64, f64)> = prepared
        .iter()
        .map(|(_, p)| {
            let duration = p.work.samples as f64 * step_s;
            (p.work.mean, fitted.mean_variance(duration, step_s))
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
    let (bias_stability, bias_temperature) = bias_stability(&means, temperatures.as_deref());
    Some(PooledEstimate {
        quantization: single[Q],
        white: single[N],
        flicker: single[B],
        random_walk: single[K],
        gauss_markov,
        bias_stability,
        bias_temperature,
        confused: tests.pairs(),
        outliers,
        covariance: named_covariance(covariance.as_ref(), &best.parameters, &units),
        fitted,
    })
}

/// Scatter of run means (mean, in-run variance) beyond their own variances, with a 95 % interval.
///
/// With temperatures that differ by more than 2 K among at least four runs a slope is taken out where it shows.
pub fn bias_stability(
    means: &[(f64, f64)],
    temperatures: Option<&[f64]>,
) -> (Estimate, Option<(f64, f64, f64)>) {
    if means.len() < 2 {
        return (Estimate::ABSENT, None);
    }
    let plain = Runs {
        means,
        regressor: None,
    };
    let mut runs = plain;
    let mut slope = None;
    if let Some(t) = temperatures
        && t.len() == means.len()
        && means.len() >= 4
    {
        let (low, high) = t
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
                (l.min(v), h.max(v))
            });
        if high - low > 2.0 {
            let with = Runs {
                means,
                regressor: Some(t),
            };
            let s2 = with.likeliest();
            let (value, sigma) = with.slope(s2);
            // Student's t would be wider; with the restricted variance 2.78 is the 95 % point of 4 runs' worth.
            if (value / sigma).abs() > 2.78 {
                runs = with;
                slope = Some((value, value - 2.78 * sigma, value + 2.78 * sigma));
            }
        }
    }
    let freedom = means.len() as f64 - if slope.is_some() { 2.0 } else { 1.0 };
    let Ok(law) = ChiSquared::new(freedom) else {
        return (Estimate::ABSENT, slope);
    };
    let (low, high) = (law.inverse_cdf(0.025), law.inverse_cdf(0.975));
    if runs.scatter(0.0) <= law.inverse_cdf(0.95) {
        // Runs closer than their own noise allows would give any limit, even zero: it is not told below the one that half
        // of the sets of such runs without run-to-run scatter give.
        let own = means.len() as f64 / means.iter().map(|m| 1.0 / m.1.max(1e-300)).sum::<f64>();
        let usual = own * (law.inverse_cdf(0.5) / law.inverse_cdf(0.05) - 1.0);
        let upper = runs.variance_where(law.inverse_cdf(0.05)).max(usual).sqrt();
        return (Estimate::limit(upper), slope);
    }
    let lower = runs.variance_where(high).sqrt();
    let upper = runs.variance_where(low).sqrt();
    let value = runs.likeliest().sqrt().clamp(lower, upper);
    let estimate = Estimate::detected(value, lower, upper, value / (2.0 * freedom).sqrt());
    (estimate, slope)
}

#[derive(Clone, Copy)]
struct Runs<'a> {
    means: &'a [(f64, f64)],
    regressor: Option<&'a [f64]>,
}

impl Runs<'_> {
    /// Weighted least squares at s²: (μ, slope, Σw, Σw(t−t̄)², Σ w r²).
    fn solve(&self, s2: f64) -> (f64, f64, f64, f64, f64) {
        let weight: Vec<f64> = self
            .means
            .iter()
            .map(|m| 1.0 / (s2 + m.1).max(1e-300))
            .collect();
        let sum: f64 = weight.iter().sum();
        let mean = self
            .means
            .iter()
            .zip(&weight)
            .map(|(m, w)| m.0 * w)
            .sum::<f64>()
            / sum;
        let (mut slope, mut spread, mut center) = (0.0, 0.0, 0.0);
        if let Some(t) = self.regressor {
            center = t.iter().zip(&weight).map(|(t, w)| t * w).sum::<f64>() / sum;
            spread = t
                .iter()
                .zip(&weight)
                .map(|(t, w)| w * (t - center).powi(2))
                .sum();
            let cross: f64 = t
                .iter()
                .zip(&weight)
                .zip(self.means)
                .map(|((t, w), m)| w * (t - center) * (m.0 - mean))
                .sum();
            slope = cross / spread;
        }
        let rest = self
            .means
            .iter()
            .zip(&weight)
            .enumerate()
            .map(|(i, (m, w))| {
                let t = self.regressor.map_or(0.0, |t| t[i] - center);
                w * (m.0 - mean - slope * t).powi(2)
            })
            .sum();
        (mean, slope, sum, spread, rest)
    }

    fn scatter(&self, s2: f64) -> f64 {
        self.solve(s2).4
    }

    fn slope(&self, s2: f64) -> (f64, f64) {
        let (_, slope, _, spread, _) = self.solve(s2);
        (slope, 1.0 / spread.sqrt())
    }

    /// s² at which the scatter falls to `level`.
    fn variance_where(&self, level: f64) -> f64 {
        if self.scatter(0.0) <= level {
            return 0.0;
        }
        let mut high = self.means.iter().map(|m| m.1).fold(1e-290, f64::max);
        while self.scatter(high) > level && high < 1e290 {
            high *= 4.0;
        }
        let mut low = 0.0;
        for _ in 0..200 {
            let middle = if low == 0.0 {
                high * 0.25
            } else {
                (low * high).sqrt()
            };
            if self.scatter(middle) > level {
                low = middle;
            } else {
                high = middle;
            }
            if low > 0.0 && high / low < 1.0 + 1e-10 {
                break;
            }
        }
        high
    }

    /// s² of the restricted likelihood, on a logarithmic grid refined.
    fn likeliest(&self) -> f64 {
        let objective = |s2: f64| {
            let (_, _, sum, spread, rest) = self.solve(s2);
            self.means
                .iter()
                .map(|m| (s2 + m.1).max(1e-300).ln())
                .sum::<f64>()
                + rest
                + sum.ln()
                + if self.regressor.is_some() {
                    spread.ln()
                } else {
                    0.0
                }
        };
        let n = self.means.len() as f64;
        let center = self.means.iter().map(|m| m.0).sum::<f64>() / n;
        let total = self
            .means
            .iter()
            .map(|m| (m.0 - center).powi(2))
            .sum::<f64>()
            / (n - 1.0);
        let mut best = (objective(0.0), 0.0);
        let mut at = total;
        let mut width = 1e4_f64;
        while width > 1.0 + 1e-9 {
            let mut moved = at;
            for i in -10..=10 {
                let s2 = at * width.powf(f64::from(i) / 10.0);
                let value = objective(s2);
                if value < best.0 {
                    best = (value, s2);
                    moved = s2;
                }
            }
            at = moved;
            width = width.powf(0.3);
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn three_exact_runs_span_a_factor_twelve() {
        let (e, _) = bias_stability(&[(1.0, 1e-12), (2.0, 1e-12), (4.0, 1e-12)], None);
        let ratio = e.upper.unwrap() / e.lower.unwrap();
        assert!((ratio / 12.07 - 1.0).abs() < 0.01, "{ratio}");
        // Restricted likelihood of equal tiny variances: the sample's standard deviation.
        assert!((e.value.unwrap() / (7.0_f64 / 3.0).sqrt() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn scatter_that_in_run_noise_explains_is_a_limit() {
        let (e, _) = bias_stability(&[(0.9, 1.0), (1.1, 1.0), (0.2, 1.0), (2.0, 1.0)], None);
        assert!(!e.is_detected() && e.upper.unwrap() > 0.0);
    }

    #[test]
    fn a_limit_is_never_below_what_such_runs_usually_give() {
        let (e, _) = bias_stability(&[(1.0, 4.0), (1.0, 4.0), (1.0, 4.0)], None);
        // Two degrees of freedom: 1.386/0.1026 − 1 = 12.51 times the variance.
        assert!((e.upper.unwrap() / (4.0_f64 * 12.514).sqrt() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_temperature_slope_is_taken_out() {
        let t = [10.0, 20.0, 30.0, 40.0, 50.0];
        let wobble = [0.1, -0.1, 0.05, -0.12, 0.07];
        let means: Vec<(f64, f64)> = t
            .iter()
            .zip(wobble)
            .map(|(t, w)| (0.5 * t + w, 1e-6))
            .collect();
        let (e, slope) = bias_stability(&means, Some(&t));
        let (value, lower, upper) = slope.unwrap();
        assert!(lower < 0.5 && 0.5 < upper && (value - 0.5).abs() < 0.02);
        assert!(e.value.unwrap() < 0.3);
    }
}
