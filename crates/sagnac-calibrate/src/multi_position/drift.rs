//! Drift of the gyro bias between rests, and the Earth's rate in them, as variances that the rests themselves show.
//!
//! mean_i = b + G f̂_i + walk + noise; Var = diag(se²) + θ I + K² C, C_ij the covariance of interval means of a unit
//! random walk; K² and θ by restricted maximum likelihood. `[HARVILLE1977]`.

use nalgebra::{DMatrix, DVector};

/// A stretch of time \[s\].
pub(super) type Span = [f64; 2];

/// Covariance of the means over two stretches of a random walk of unit rate that starts before both.
pub(super) fn walk_covariance(a: Span, b: Span) -> f64 {
    if a == b {
        return a[0] + (a[1] - a[0]) / 3.0;
    }
    let first = if a[0] <= b[0] { a } else { b };
    f64::midpoint(first[0], first[1])
}

/// Covariance of the means over `spans` about their mean over the rests.
pub(super) fn centered(spans: &[Span], is_rest: &[bool]) -> DMatrix<f64> {
    let n = spans.len();
    let origin = spans.first().map_or(0.0, |s| s[0]);
    let shifted: Vec<Span> = spans.iter().map(|s| s.map(|t| t - origin)).collect();
    let c = DMatrix::from_fn(n, n, |i, j| walk_covariance(shifted[i], shifted[j]));
    let rests = is_rest.iter().filter(|r| **r).count() as f64;
    let with_mean = DVector::from_fn(n, |i, _| {
        (0..n)
            .filter(|j| is_rest[*j])
            .map(|j| c[(i, j)])
            .sum::<f64>()
            / rests
    });
    let of_mean = (0..n)
        .filter(|i| is_rest[*i])
        .map(|i| with_mean[i])
        .sum::<f64>()
        / rests;
    DMatrix::from_fn(n, n, |i, j| {
        c[(i, j)] - with_mean[i] - with_mean[j] + of_mean
    })
}

/// What the rests of one axis tell.
pub(super) struct Axis {
    /// Means.
    pub(super) means: DVector<f64>,
    /// Variances of their white noise.
    pub(super) white: Vec<f64>,
}

/// Drift and Earth's rate as they were found.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(super) struct Drift {
    /// rad/s/√s, 0 where the intervals need none.
    pub(super) rate: [f64; 3],
    /// 95 % interval of each rate by the profile of the likelihood.
    pub(super) interval: [[f64; 2]; 3],
    /// Whether it is beyond what chance shows.
    pub(super) seen: [bool; 3],
    /// Whether the rests scatter as the Earth's rate would make them, or too much to tell.
    pub(super) has_earth: bool,
}

/// Gain of twice the logarithm of the likelihood above which a drift enters the intervals: 5 % on one side.
const COUNTED: f64 = 2.706;

/// The gain above which it is said that the bias drifted: 2.5 % for three axes together, and few rests find more than
/// a normal deviate does (`multi_position_coverage.py`, logs without drift).
const SEEN: f64 = 6.6;

/// Fall of twice the logarithm of the likelihood at the ends of a 95 % interval.
const FALL_95: f64 = 3.841;

/// The Earth's rate is counted unless the rests speak against it by this much of the logarithm of the likelihood.
const EARTH_DOUBT: f64 = 2.0;

/// Finds the drift of each axis; `design` has the columns 1 and f̂, `earth` the variance the Earth's rate would add.
/// `certain` counts it whatever they say.
pub(super) fn find(
    axes: &[Axis; 3],
    design: &DMatrix<f64>,
    spans: &[Span],
    earth: f64,
    certain: bool,
) -> Drift {
    let n = spans.len();
    if n < design.ncols() + 3 {
        return Drift {
            has_earth: true,
            ..Drift::default()
        };
    }
    let origin = spans[0][0];
    let shifted: Vec<Span> = spans.iter().map(|s| s.map(|t| t - origin)).collect();
    let walk = DMatrix::from_fn(n, n, |i, j| walk_covariance(shifted[i], shifted[j]));
    let step = (shifted[n - 1][1] / n as f64).max(1e-9);
    let mut best = [(Drift::default(), 0.0); 2];
    for (with, slot) in best.iter_mut().enumerate() {
        slot.0.has_earth = with == 1;
        for (k, axis) in axes.iter().enumerate() {
            let extra = if with == 1 { earth } else { 0.0 };
            let likelihood = |k2: f64| restricted(axis, design, &walk, extra, k2);
            let scale = axis.white.iter().sum::<f64>() / n as f64 / step;
            let (k2, gain) = largest(&likelihood, scale);
            let none = likelihood(0.0);
            if 2.0 * (gain - none) > COUNTED {
                slot.0.rate[k] = k2.sqrt();
                slot.0.seen[k] = 2.0 * (gain - none) > SEEN;
                slot.0.interval[k] = interval(&likelihood, k2, gain);
                slot.1 += gain;
            } else {
                slot.1 += none;
            }
        }
    }
    let has_earth = certain || best[1].1 >= best[0].1 - EARTH_DOUBT;
    best[usize::from(has_earth)].0
}

/// Where the likelihood falls by what bounds 95 %, below and above its largest value at K²; as rates.
fn interval(likelihood: &dyn Fn(f64) -> f64, k2: f64, top: f64) -> [f64; 2] {
    let inside = |x: f64| 2.0 * (top - likelihood(x)) < FALL_95;
    [-1.0, 1.0].map(|sign| {
        let (mut near, mut far) = (0.0, 40.0);
        if inside(k2 * f64::powf(2.0, sign * far)) {
            return if sign < 0.0 { 0.0 } else { f64::INFINITY };
        }
        for _ in 0..40 {
            let middle = f64::midpoint(near, far);
            if inside(k2 * f64::powf(2.0, sign * middle)) {
                near = middle;
            } else {
                far = middle;
            }
        }
        (k2 * f64::powf(2.0, sign * near)).sqrt()
    })
}

/// The largest value of a function of K² ≥ 0, on a grid of factors of two about `scale`, then refined.
fn largest(likelihood: &dyn Fn(f64) -> f64, scale: f64) -> (f64, f64) {
    let mut best = (0.0, likelihood(0.0));
    for i in -12..=24 {
        let k2 = scale * 2f64.powi(i);
        let l = likelihood(k2);
        if l > best.1 {
            best = (k2, l);
        }
    }
    if best.0 > 0.0 {
        for i in [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75] {
            let k2 = best.0 * 2f64.powf(i);
            let l = likelihood(k2);
            if l > best.1 {
                best = (k2, l);
            }
        }
    }
    best
}

/// Restricted log likelihood of an axis, without constants.
fn restricted(axis: &Axis, x: &DMatrix<f64>, walk: &DMatrix<f64>, extra: f64, k2: f64) -> f64 {
    let n = axis.white.len();
    let mut v = walk * k2;
    for i in 0..n {
        v[(i, i)] += axis.white[i] + extra;
    }
    let Some(cholesky) = v.cholesky() else {
        return f64::NEG_INFINITY;
    };
    let l = cholesky.l();
    let log_det: f64 = (0..n).map(|i| l[(i, i)].ln()).sum::<f64>() * 2.0;
    let (Some(wx), Some(wy)) = (
        l.solve_lower_triangular(x),
        l.solve_lower_triangular(&axis.means),
    ) else {
        return f64::NEG_INFINITY;
    };
    let normal = wx.transpose() * &wx;
    let Some(inner) = normal.cholesky() else {
        return f64::NEG_INFINITY;
    };
    let beta = inner.solve(&(wx.transpose() * &wy));
    let rest = wy - wx * beta;
    let m = inner.l();
    let inner_det: f64 = (0..m.nrows()).map(|i| m[(i, i)].ln()).sum::<f64>() * 2.0;
    -0.5 * (log_det + inner_det + rest.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_means_of_a_walk() {
        // Var of the mean over [0, T] is T/3; the mean over a later stretch correlates by T/2.
        assert!((walk_covariance([0.0, 3.0], [0.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!((walk_covariance([0.0, 3.0], [5.0, 6.0]) - 1.5).abs() < 1e-15);
        assert!((walk_covariance([5.0, 6.0], [0.0, 3.0]) - 1.5).abs() < 1e-15);
    }

    /// A number of unit variance.
    fn normal(state: &mut u64) -> f64 {
        (0..12)
            .map(|_| {
                *state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (*state >> 11) as f64 / (1u64 << 53) as f64
            })
            .sum::<f64>()
            - 6.0
    }

    /// What is found of rests of 4 s every 6 s: white noise of size one in their means, and a walk.
    fn found(seed: u64, count: usize, walk: f64) -> Drift {
        let mut state = seed;
        let spans: Vec<Span> = (0..count)
            .map(|i| [6.0 * i as f64, 6.0 * i as f64 + 4.0])
            .collect();
        let design = DMatrix::from_fn(count, 4, |i, j| match j {
            0 => 1.0,
            _ => (1.7 * (i + 1) as f64 * j as f64).sin(),
        });
        let axes = [0, 1, 2].map(|_| {
            let mut drift = 0.0;
            Axis {
                means: DVector::from_fn(count, |_, _| {
                    drift += walk * 6f64.sqrt() * normal(&mut state);
                    drift + normal(&mut state)
                }),
                white: vec![1.0; count],
            }
        });
        super::find(&axes, &design, &spans, 0.0, true)
    }

    #[test]
    fn a_drift_is_said_where_there_is_one_and_hardly_ever_else() {
        for count in [14, 24] {
            let false_ones = (0..200)
                .filter(|seed| found(1000 + seed, count, 0.0).seen.contains(&true))
                .count();
            // 2.5 % of 200 are 5; ten or more have a chance of 3 %.
            assert!(false_ones < 10, "{false_ones} of 200 at {count} rests");
        }
        let (mut seen, mut inside) = (0, 0);
        for seed in 0..40 {
            let drift = found(9000 + seed, 24, 1.0);
            for k in 0..3 {
                seen += usize::from(drift.seen[k]);
                let [low, high] = drift.interval[k];
                inside += usize::from(low <= 1.0 && 1.0 <= high);
            }
        }
        assert!(seen > 100 && inside > 105, "{seen} seen, {inside} inside");
    }
}
