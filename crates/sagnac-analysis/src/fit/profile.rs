//! Intervals and limits from the likelihood profile: where 2 Δ ln L with everything else refitted reaches a level.
//!
//! The signed root √(2Δ ln L) is nearly straight in the term's own scale (√ of a variance, ln T_c), so a few refits
//! find the ends. Level 3.84 for 95 % intervals [CoxHinkley1974]; limits at 2.71, for B and K 3.84.

use super::likelihood::{Free, PARAMETERS, Problem, Solution, is_time};
use super::linear::inverse;

/// Level of a 95 % interval.
pub(crate) const INTERVAL: f64 = 3.841_458_820_694_124;
/// Level of a one-sided 95 % limit.
pub(crate) const LIMIT: f64 = 2.705_543_454_095_404;

/// Which way to go from the best value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Lower,
    Upper,
}

/// Covariance of the free parameters that are off zero: (indices, matrix), of variances and ln T_c.
pub(crate) fn covariance(
    problem: &Problem,
    solution: &Solution,
    free: &Free,
) -> Option<(Vec<usize>, Vec<f64>)> {
    let indices: Vec<usize> = (0..PARAMETERS)
        .filter(|&i| free[i] && solution.parameters[if is_time(i) { i - 1 } else { i }] > 0.0)
        .collect();
    let information = problem.information(&solution.parameters, &indices);
    inverse(&information, indices.len()).map(|m| (indices, m))
}

/// Standard deviation of one parameter in the scale of `to_scale`, given all others free.
fn spread(problem: &Problem, solution: &Solution, free: &Free, index: usize) -> f64 {
    let x = to_scale(index, solution.parameters[index]);
    let mut indices: Vec<usize> = (0..PARAMETERS)
        .filter(|&i| {
            i == index || (free[i] && solution.parameters[if is_time(i) { i - 1 } else { i }] > 0.0)
        })
        .collect();
    indices.sort_unstable();
    let information = problem.information(&solution.parameters, &indices);
    let place = indices.iter().position(|&i| i == index).unwrap_or(0);
    let variance = inverse(&information, indices.len())
        .map(|m| m[place * indices.len() + place])
        .or_else(|| Some(1.0 / information[place * indices.len() + place]))
        .filter(|v| v.is_finite() && *v > 0.0);
    let sigma = variance.map_or(1.0, f64::sqrt);
    if is_time(index) {
        sigma.min(1.0)
    } else {
        // In √v: σ_v/2√v, but at zero the root of the spread itself.
        (sigma / (2.0 * x).max(sigma.sqrt())).max(1e-12)
    }
}

fn to_scale(index: usize, value: f64) -> f64 {
    if is_time(index) {
        value
    } else {
        value.max(0.0).sqrt()
    }
}

fn from_scale(index: usize, x: f64) -> f64 {
    if is_time(index) { x } else { x * x }
}

/// The parameter's value on one side where the profile reaches `level`; a variance's lower end may be 0.
pub(crate) fn bound(
    problem: &Problem,
    solution: &Solution,
    free: &Free,
    index: usize,
    side: Side,
    level: f64,
) -> f64 {
    let mut held = *free;
    held[index] = false;
    let x0 = to_scale(index, solution.parameters[index]);
    let sigma = spread(problem, solution, free, index);
    let mut warm = solution.parameters;
    let evaluate = |x: f64, warm: &mut [f64; PARAMETERS]| {
        let mut start = *warm;
        start[index] = from_scale(index, x);
        let fit = problem.fit_limited(&start, &held, 25);
        *warm = fit.parameters;
        fit.objective - solution.objective
    };
    let end = search(x0, sigma, side, level, is_time(index), |x| {
        evaluate(x, &mut warm)
    });
    from_scale(index, end)
}

/// Finds x where ΔF(x) = level; `signed` quantities may go below zero.
pub(crate) fn search(
    x0: f64,
    sigma: f64,
    side: Side,
    level: f64,
    signed: bool,
    mut rise: impl FnMut(f64) -> f64,
) -> f64 {
    let target = level.sqrt();
    let direction = if side == Side::Upper { 1.0 } else { -1.0 };
    let reach = if side == Side::Lower && !signed {
        x0
    } else {
        f64::INFINITY
    };
    // Distances from x0 with the root of the rise.
    let (mut near, mut near_root) = (0.0, 0.0);
    let mut far: Option<(f64, f64)> = None;
    let mut distance = (target * sigma).min(reach);
    for _ in 0..24 {
        if distance <= 0.0 {
            return x0;
        }
        let root = rise(x0 + direction * distance).max(0.0).sqrt();
        if (root - target).abs() < 0.004 * target {
            return x0 + direction * distance;
        }
        if root < target {
            if distance >= reach {
                return x0 - reach;
            }
            near = distance;
            near_root = root;
        } else {
            far = Some((distance, root));
        }
        distance = match far {
            Some((far, far_root)) => {
                let share = ((target - near_root) / (far_root - near_root)).clamp(0.05, 0.95);
                near + share * (far - near)
            }
            None => (distance * (1.05 * target / root.max(1e-3)).clamp(1.2, 4.0)).min(reach),
        };
        if far.is_some_and(|(far, _)| (far - near) < 1e-5 * (x0.abs() + far)) {
            break;
        }
        if is_beyond(distance, sigma, signed) {
            break;
        }
    }
    x0 + direction * distance
}

/// A correlation time that the log does not bound.
fn is_beyond(distance: f64, sigma: f64, signed: bool) -> bool {
    signed && distance > 8.0 && distance > 30.0 * sigma
}
