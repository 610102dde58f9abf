//! What rounding hides where its step q is coarser than the noise: bounds that hold whatever lies within a step.
//!
//! Rounded noise of scatter σ has √(σ² + q²/12) for σ > 0.5 q; below σ = 0.7 q what the values show depends on where the
//! mean stands between two steps, and their likelihood is not that of the sensor. White noise may hide up to σ = 0.7 q. Of a
//! drift the values tell all but an error e, |e| ≤ q/2. By the triangle inequality of amplitudes a term is off by no more
//! than e can hold of it: the parameter whose process keeps within q over the log in 5 % of draws. The 5 % points of the
//! range, of flicker over n samples B (1.44 ln n − 2.3), of a walk 0.955 K √T, of a process with T_c = T/4 2.37 σ, are
//! simulated (200 to 2000 draws each).

use super::checks;
use super::likelihood::{B, K, N, Q};
use super::types::{AxisData, Estimate, GaussMarkovEstimate};

/// Scatter, in steps, below which rounding hides the noise.
const COARSE: f64 = 0.7;
/// Whether values of this scatter (as measured, so with the rounding's own q²/12), in steps, hide their noise.
pub(super) fn is_coarse(scatter_in_steps: f64) -> bool {
    scatter_in_steps.powi(2) - 1.0 / 12.0 < COARSE * COARSE
}

/// Rounding that hides what lies within its step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coarse {
    /// The step q [unit of the axis].
    pub step: f64,
    dt_s: f64,
    /// Samples of the longest stretch.
    longest: f64,
}

impl Coarse {
    /// Of the data, where their step is coarse.
    pub(super) fn of(data: &AxisData<'_>) -> Option<Self> {
        let step = data.lsb.filter(|q| *q > 0.0)?;
        let longest = data.segments.iter().map(|s| s.samples.len()).max()?;
        is_coarse(checks::scatter_in_steps(data)?).then_some(Self {
            step,
            dt_s: data.step_s,
            longest: longest as f64,
        })
    }

    /// The largest Q, N, B, K or σ (SI) that may hide within a step.
    fn hidden(&self, term: usize) -> f64 {
        match term {
            Q => COARSE * self.step * self.dt_s / std::f64::consts::SQRT_2,
            N => COARSE * self.step * self.dt_s.sqrt(),
            B => self.step / (1.44 * self.longest.ln() - 2.3).max(1.0),
            K => self.step / (0.955 * (self.longest * self.dt_s).sqrt()),
            _ => self.step / 2.37,
        }
    }

    /// An estimate as the step leaves it: of a drift known to what may hide, of white noise and Q never more than a limit.
    fn bounded(&self, e: Estimate, term: usize) -> Estimate {
        let hidden = self.hidden(term);
        let Some(upper) = e.upper else { return e };
        if matches!(term, Q | N) {
            return Estimate::limit(upper.max(hidden));
        }
        match (e.value, e.lower) {
            // What rounding makes of other drifts is no term: one is named that stands clear of all that may hide.
            (Some(value), Some(lower)) if lower > 2.0 * hidden => {
                let sigma = e.sigma.unwrap_or(0.0).hypot(hidden / 1.96);
                Estimate::detected(value, lower - hidden, upper + hidden, sigma)
            }
            _ => Estimate::limit(upper + hidden),
        }
    }

    /// Bounds the terms of a fit.
    pub(super) fn bound(
        &self,
        single: &mut [Estimate; 4],
        gauss_markov: &mut Vec<GaussMarkovEstimate>,
    ) {
        for (term, e) in single.iter_mut().enumerate() {
            *e = self.bounded(*e, term);
        }
        for process in gauss_markov.iter_mut() {
            process.sigma = self.bounded(process.sigma, super::likelihood::FIRST_GM);
            if !process.sigma.is_detected() {
                process.correlation_time_s = Estimate::ABSENT;
            }
        }
        // Of processes that are limits now the largest bounds them all; those that stand clear speak for themselves.
        let largest = |a: &GaussMarkovEstimate, b: &GaussMarkovEstimate| {
            let upper = |g: &GaussMarkovEstimate| g.sigma.upper.unwrap_or(0.0);
            upper(a).total_cmp(&upper(b))
        };
        if gauss_markov.iter().any(|g| g.sigma.is_detected()) {
            gauss_markov.retain(|g| g.sigma.is_detected());
        } else if let Some(limit) = gauss_markov.iter().copied().max_by(largest) {
            *gauss_markov = vec![limit];
        }
    }

    /// A slope over the log: rounding errors of q/2 tilt a line by at most 1.5 q/T.
    pub(super) fn slope(&self, e: Estimate) -> Estimate {
        let tilt = 1.5 * self.step / (self.longest * self.dt_s);
        let lower = e.lower.map(|l| l - tilt);
        let upper = e.upper.map(|u| u + tilt);
        match (lower, upper) {
            (Some(l), Some(u)) if l < 0.0 && u > 0.0 => Estimate::limit(u.max(-l)),
            _ => Estimate { lower, upper, ..e },
        }
    }

    /// Variance of the mean's rounding error.
    pub(super) fn mean_variance(&self) -> f64 {
        self.step.powi(2) / 12.0
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use crate::fit::{
        AxisData, AxisEstimate, FitOptions, Segment, Status, estimate, estimate_pooled,
    };

    /// Normals from sums of twelve uniform numbers.
    fn white(seed: u64, n: usize) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n)
            .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
            .collect()
    }

    /// White noise of 1 and a walk of `walk` a sample about `offset` steps, rounded to `step`.
    fn rounded(seed: u64, step: f64, offset: f64, walk: f64) -> Vec<f64> {
        let mut sum = 0.0;
        white(seed, 20_000)
            .iter()
            .zip(white(seed + 1000, 20_000))
            .map(|(y, e)| {
                sum += walk * e;
                ((y + sum) / step + offset).round() * step
            })
            .collect()
    }

    fn with_data<T>(samples: &[f64], step: f64, f: impl FnOnce(&AxisData<'_>) -> T) -> T {
        let segments = [Segment {
            start_s: 0.0,
            samples,
            filled: &[],
        }];
        f(&AxisData {
            segments: &segments,
            temperature: None,
            step_s: 0.01,
            lsb: Some(step),
        })
    }

    fn fit(samples: &[f64], step: f64) -> AxisEstimate {
        with_data(samples, step, |data| estimate(data, &FitOptions::default()))
    }

    #[test]
    fn limits_hold_whatever_stands_between_two_steps() {
        // N = 0.1 at 100 Hz, K = 0.002/√dt.
        let (n, k) = (0.1, 0.002 / 0.1);
        let (mut logs, mut covered) = (0, [0, 0]);
        for step in [1.5, 2.0, 3.0, 5.0, 8.0] {
            for offset in [0.0, 0.3, 0.5] {
                for seed in 1..4 {
                    let samples = rounded(seed, step, offset, 0.002);
                    if samples.iter().all(|y| *y == samples[0]) {
                        // One value: nothing is told, no limit either.
                        continue;
                    }
                    let e = fit(&samples, step);
                    assert_eq!(e.white.status, Status::UpperLimit, "{step} {offset}");
                    logs += 1;
                    covered[0] += usize::from(e.white.upper.unwrap() >= n);
                    covered[1] += usize::from(e.random_walk.upper.is_none_or(|u| u >= k));
                    let error = (e.mean.value.unwrap() - offset * step).abs();
                    assert!(
                        error < 3.0 * e.mean.sigma.unwrap(),
                        "{step} {offset}: mean off by {error}"
                    );
                }
            }
        }
        assert!(logs > 40);
        assert_eq!(covered, [logs, logs]);
    }

    #[test]
    fn coarse_logs_pooled_give_limits_as_one_does() {
        let (a, b) = (rounded(1, 5.0, 0.0, 0.0), rounded(2, 5.0, 0.3, 0.0));
        with_data(&a, 5.0, |first| {
            with_data(&b, 5.0, |second| {
                let p = estimate_pooled(&[*first, *second], &FitOptions::default()).unwrap();
                assert_eq!(p.white.status, Status::UpperLimit);
                assert!(
                    p.white.upper.unwrap() >= 0.35 - 1e-12,
                    "0.7 steps of 5 at 100 Hz"
                );
                assert!(p.outliers.is_empty());
                // Means that rounding alone may part are no bias stability.
                assert!(!p.run_to_run.stability.is_detected());
            });
        });
    }

    #[test]
    fn a_walk_over_many_steps_is_still_seen() {
        let e = fit(&rounded(7, 5.0, 0.0, 2.0), 5.0);
        assert!(e.random_walk.is_detected());
        let (lower, upper) = (e.random_walk.lower.unwrap(), e.random_walk.upper.unwrap());
        assert!(lower < 20.0 && 20.0 < upper, "{lower} {upper}");
    }
}
