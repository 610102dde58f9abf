//! Linearity: largest departure of the points from the least-squares line and from the best line of all.
//!
//! The width max(Y − βX) − min(Y − βX) is convex and piecewise linear in β; it is smallest at the slope of an edge of
//! the points' convex hull.

use super::{Linearity, Point};

pub(super) fn linearity(points: &[Point]) -> Result<Linearity, &'static str> {
    if points.len() < 3 {
        return Err("linearity needs readings at three inputs or more");
    }
    let slopes = hull_slopes(points);
    let width = |slope: f64| {
        let (low, high) = extremes(points, slope);
        high - low
    };
    let (mut a, mut b) = (0, slopes.len() - 1);
    while a < b {
        let middle = a.midpoint(b);
        if width(slopes[middle]) <= width(slopes[middle + 1]) {
            b = middle;
        } else {
            a = middle + 1;
        }
    }
    let slope = slopes[a];
    let (low, high) = extremes(points, slope);
    Ok(Linearity {
        least_squares: points.iter().fold(0.0, |m, p| m.max(p.residual.abs())),
        minimax: 0.5 * (high - low),
        minimax_offset: 0.5 * (high + low),
        minimax_slope: slope,
    })
}

fn extremes(points: &[Point], slope: f64) -> (f64, f64) {
    points
        .iter()
        .map(|p| p.mean - slope * p.reference)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        })
}

/// Slopes of all edges of the convex hull, ascending. The points ascend in x and differ in it.
fn hull_slopes(points: &[Point]) -> Vec<f64> {
    let mut slopes = Vec::new();
    for sign in [1.0, -1.0] {
        let mut hull: Vec<(f64, f64)> = Vec::new();
        for p in points {
            let q = (p.reference, sign * p.mean);
            while let [.., a, b] = hull[..] {
                if (b.0 - a.0) * (q.1 - a.1) - (b.1 - a.1) * (q.0 - a.0) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(q);
        }
        slopes.extend(
            hull.windows(2)
                .map(|w| sign * (w[1].1 - w[0].1) / (w[1].0 - w[0].0)),
        );
    }
    slopes.sort_by(f64::total_cmp);
    slopes
}
