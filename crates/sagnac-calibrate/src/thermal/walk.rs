//! A random walk of the bias during the sweep, seen in the bins in the order of time.
//!
//! bin = row · coefficients + walk(t) + white/√count, the walk from zero at the start of each log. Both
//! variances by restricted maximum likelihood (`[PattersonThompson1971]`), where a walk is seen their means over it, flat in the
//! logarithm of their ratio: the largest likelihood alone is too sure of a walk of which a sweep shows little. The
//! likelihood comes through the innovations of the local-level model, so that its cost grows with the number of bins
//! alone.

use nalgebra::{DMatrix, DVector};

use super::fit::{Design, Point, Solution};

/// Variances of the scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scatter {
    /// White, of one sample.
    pub(super) white: f64,
    /// Of the walk, per second; zero where none is seen.
    pub(super) walk_per_s: f64,
}

/// Difference of −2 log likelihood from which a walk counts as seen: one sweep of white noise in four passes it, as the
/// curve itself takes up most of a weak walk.
const SEEN: f64 = 0.5;

/// Points in the order of time, log after log.
fn ordered(points: &[Point]) -> Vec<&Point> {
    let mut out: Vec<&Point> = points.iter().collect();
    out.sort_by(|a, b| a.log.cmp(&b.log).then(a.elapsed_s.total_cmp(&b.elapsed_s)));
    out
}

/// −2 × restricted log likelihood and the white variance at a ratio walk/white, less what does not depend on it.
fn likelihood(columns: &DMatrix<f64>, points: &[&Point], ratio_per_s: f64) -> Option<(f64, f64)> {
    let (n, q) = (columns.nrows(), columns.ncols() - 1);
    let mut innovations = columns.clone();
    let mut level = vec![0.0; q + 1];
    let (mut variance, mut determinant) = (0.0, 0.0);
    let mut last: Option<&Point> = None;
    for (i, p) in points.iter().enumerate() {
        match last {
            Some(before) if before.log == p.log => {
                variance += ratio_per_s * (p.elapsed_s - before.elapsed_s);
            }
            _ => {
                level.fill(0.0);
                variance = ratio_per_s * p.elapsed_s;
            }
        }
        let total = variance + 1.0 / p.weight;
        let gain = variance / total;
        for (j, level) in level.iter_mut().enumerate() {
            let innovation = columns[(i, j)] - *level;
            *level += gain * innovation;
            innovations[(i, j)] = innovation / total.sqrt();
        }
        variance *= 1.0 - gain;
        determinant += total.ln();
        last = Some(p);
    }
    let r = innovations.qr().r();
    if r.nrows() <= q || (0..q).any(|j| r[(j, j)] == 0.0) {
        return None;
    }
    determinant += 2.0 * (0..q).map(|j| r[(j, j)].abs().ln()).sum::<f64>();
    let white = r[(q, q)].powi(2) / (n - q) as f64;
    (white > 0.0).then(|| (determinant + (n - q) as f64 * white.ln(), white))
}

/// The variances, by the restricted likelihood; none where nothing scatters.
pub(super) fn scatter(design: &Design, points: &[Point]) -> Option<Scatter> {
    let points = ordered(points);
    let q = design.columns();
    let mut columns = DMatrix::zeros(points.len(), q + 1);
    for (i, p) in points.iter().enumerate() {
        let row = design.row(p.temperature_c, p.sign, p.force);
        row.iter()
            .chain([&p.value])
            .enumerate()
            .for_each(|(j, v)| columns[(i, j)] = *v);
    }
    let longest = points.iter().fold(0.0, |m: f64, p| m.max(p.elapsed_s));
    let count: f64 = points.iter().map(|p| p.weight).sum();
    // Variance of the walk over the longest log against that of the mean of all samples: a ninth of a decade apart.
    let candidates = std::iter::once(0.0).chain((-9..=63).map(|i| 10_f64.powf(f64::from(i) / 9.0)));
    let scored: Vec<(f64, f64, f64)> = candidates
        .filter_map(|v| {
            let ratio = v / (longest.max(f64::MIN_POSITIVE) * count);
            let (score, white) = likelihood(&columns, &points, ratio)?;
            Some((score, ratio, white))
        })
        .collect();
    let (best, ratio, white) = *scored.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let none = scored.first().map_or(best, |s| s.0);
    if none - best < SEEN {
        return Some(Scatter {
            white,
            walk_per_s: ratio * white,
        });
    }
    let (mut sum, mut white, mut walk_per_s) = (0.0, 0.0, 0.0);
    for (score, ratio, variance) in scored {
        let weight = (-0.5 * (score - best)).exp();
        sum += weight;
        white += weight * variance;
        walk_per_s += weight * variance * ratio;
    }
    Some(Scatter {
        white: white / sum,
        walk_per_s: walk_per_s / sum,
    })
}

/// Covariance of the least-squares coefficients (weights: counts) where the scatter is as given.
pub(super) fn covariance(
    design: &Design,
    fit: &Solution,
    points: &[Point],
    scatter: Scatter,
) -> DMatrix<f64> {
    let q = design.columns();
    let mut out = DMatrix::zeros(q, q);
    // Weight of every later bin: what a step of the walk before it does.
    let mut later = DVector::zeros(q);
    let points = ordered(points);
    for (i, p) in points.iter().enumerate().rev() {
        let row = DVector::from_vec(design.row(p.temperature_c, p.sign, p.force));
        let effect = &fit.inverse * row * p.weight;
        out.ger(scatter.white / p.weight, &effect, &effect, 1.0);
        later += effect;
        let before = i
            .checked_sub(1)
            .map(|b| points[b])
            .filter(|b| b.log == p.log);
        let step_s = p.elapsed_s - before.map_or(0.0, |b| b.elapsed_s);
        out.ger(scatter.walk_per_s * step_s, &later, &later, 1.0);
        if before.is_none() {
            later.fill(0.0);
        }
    }
    out
}
