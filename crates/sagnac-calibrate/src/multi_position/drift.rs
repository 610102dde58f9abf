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
    /// rad/s/√s, 0 where none is seen.
    pub(super) rate: [f64; 3],
    /// Whether the rests scatter as the Earth's rate would make them, or too much to tell.
    pub(super) has_earth: bool,
}

/// Gain of twice the logarithm of the likelihood that a drift must bring: 5 % on one side.
const SEEN: f64 = 2.706;

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
            rate: [0.0; 3],
            has_earth: true,
        };
    }
    let origin = spans[0][0];
    let shifted: Vec<Span> = spans.iter().map(|s| s.map(|t| t - origin)).collect();
    let walk = DMatrix::from_fn(n, n, |i, j| walk_covariance(shifted[i], shifted[j]));
    let step = (shifted[n - 1][1] / n as f64).max(1e-9);
    let mut best = [([0.0; 3], 0.0); 2];
    for (with, slot) in best.iter_mut().enumerate() {
        for (k, axis) in axes.iter().enumerate() {
            let extra = if with == 1 { earth } else { 0.0 };
            let likelihood = |k2: f64| restricted(axis, design, &walk, extra, k2);
            let scale = axis.white.iter().sum::<f64>() / n as f64 / step;
            let (k2, gain) = largest(&likelihood, scale);
            let none = likelihood(0.0);
            if 2.0 * (gain - none) > SEEN {
                slot.0[k] = k2.sqrt();
                slot.1 += gain;
            } else {
                slot.1 += none;
            }
        }
    }
    let has_earth = certain || best[1].1 >= best[0].1 - EARTH_DOUBT;
    Drift {
        rate: best[usize::from(has_earth)].0,
        has_earth,
    }
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
}
