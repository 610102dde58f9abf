//! Curves of an output against temperature: polynomial or natural cubic spline with hysteresis, by cross-validation.
//!
//! output = b(T) + ½ s h(T) (+ f s(T)), s = +1 heating, −1 cooling; least squares weighted by counts. `[STONE1974]`.

use nalgebra::{DMatrix, DVector};

/// The form of b.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Basis {
    /// Powers of (T − T0)/scale up to an order.
    Polynomial {
        order: usize,
        zero_c: f64,
        scale_k: f64,
    },
    /// Natural cubic spline by its values at knots.
    Spline {
        knots_c: Vec<f64>,
        second: DMatrix<f64>,
    },
}

impl Basis {
    pub(super) fn polynomial(order: usize, zero_c: f64, scale_k: f64) -> Self {
        Self::Polynomial {
            order,
            zero_c,
            scale_k,
        }
    }

    /// Knots at equal parts of a range; none where the system cannot be solved.
    pub(super) fn spline(count: usize, [low, high]: [f64; 2]) -> Option<Self> {
        let step = (high - low) / (count - 1) as f64;
        let knots_c: Vec<f64> = (0..count)
            .map(|i| {
                if i + 1 == count {
                    high
                } else {
                    low + step * i as f64
                }
            })
            .collect();
        // Second derivatives from values: h (M_{i−1} + 4 M_i + M_{i+1})/6 = (y_{i−1} − 2 y_i + y_{i+1})/h, 0 at the ends.
        let mut left = DMatrix::identity(count, count);
        let mut right = DMatrix::zeros(count, count);
        for i in 1..count - 1 {
            left[(i, i - 1)] = 1.0 / 6.0;
            left[(i, i)] = 4.0 / 6.0;
            left[(i, i + 1)] = 1.0 / 6.0;
            right[(i, i - 1)] = 1.0 / (step * step);
            right[(i, i)] = -2.0 / (step * step);
            right[(i, i + 1)] = 1.0 / (step * step);
        }
        Some(Self::Spline {
            second: left.try_inverse()? * right,
            knots_c,
        })
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Polynomial { order, .. } => order + 1,
            Self::Spline { knots_c, .. } => knots_c.len(),
        }
    }

    /// The row of b at a temperature.
    pub(super) fn row(&self, t: f64) -> Vec<f64> {
        match self {
            Self::Polynomial {
                order,
                zero_c,
                scale_k,
            } => {
                let u = (t - zero_c) / scale_k;
                (0..=*order).map(|i| u.powi(i as i32)).collect()
            }
            Self::Spline { knots_c, second } => {
                let n = knots_c.len();
                let step = knots_c[1] - knots_c[0];
                let held = t.clamp(knots_c[0], knots_c[n - 1]);
                let i = (((held - knots_c[0]) / step) as usize).min(n - 2);
                let b = (held - knots_c[i]) / step;
                let a = 1.0 - b;
                let (c, d) = (
                    (a * a * a - a) * step * step / 6.0,
                    (b * b * b - b) * step * step / 6.0,
                );
                (0..n)
                    .map(|j| {
                        f64::from(u8::from(j == i)) * a
                            + f64::from(u8::from(j == i + 1)) * b
                            + c * second[(i, j)]
                            + d * second[(i + 1, j)]
                    })
                    .collect()
            }
        }
    }

    /// Order of the hysteresis.
    fn hysteresis(&self) -> usize {
        match self {
            Self::Polynomial { order, .. } => (*order).min(2),
            Self::Spline { .. } => 2,
        }
    }
}

/// An observation: temperature, sense of the sweep, specific force on the axis, output less that force, weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) temperature_c: f64,
    pub(super) sign: f64,
    pub(super) force: f64,
    pub(super) value: f64,
    pub(super) weight: f64,
    pub(super) log: usize,
    /// Mean time since the start of the log \[s\].
    pub(super) elapsed_s: f64,
    pub(super) branch: usize,
    /// Rank in temperature modulo 10.
    pub(super) fold: usize,
}

/// What the columns are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Design {
    pub(super) basis: Basis,
    pub(super) with_hysteresis: bool,
    pub(super) with_scale: bool,
    pub(super) zero_c: f64,
    pub(super) scale_k: f64,
}

impl Design {
    /// Columns of b, of h, of the scale factor.
    pub(super) fn parts(&self) -> [usize; 3] {
        let b = self.basis.len();
        [
            b,
            if self.with_hysteresis {
                self.basis.hysteresis() + 1
            } else {
                0
            },
            if self.with_scale { b } else { 0 },
        ]
    }

    pub(super) fn columns(&self) -> usize {
        self.parts().iter().sum()
    }

    /// Powers of the hysteresis at a temperature.
    pub(super) fn hysteresis_row(&self, t: f64) -> Vec<f64> {
        let u = (t - self.zero_c) / self.scale_k;
        (0..self.parts()[1]).map(|i| u.powi(i as i32)).collect()
    }

    pub(super) fn row(&self, t: f64, sign: f64, force: f64) -> Vec<f64> {
        let b = self.basis.row(t);
        let mut out = b.clone();
        out.extend(self.hysteresis_row(t).into_iter().map(|v| 0.5 * sign * v));
        if self.with_scale {
            out.extend(b.iter().map(|v| v * force));
        }
        out
    }
}

/// A weighted least-squares solution.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub(super) values: DVector<f64>,
    /// (XᵀWX)⁻¹.
    pub(super) inverse: DMatrix<f64>,
    /// Σ weight residual².
    pub(super) sum: f64,
}

/// Solves a design over points (all, or those not in `without`).
pub(super) fn solve(design: &Design, points: &[Point], without: Option<usize>) -> Option<Solution> {
    let used: Vec<&Point> = points.iter().filter(|p| without != Some(p.fold)).collect();
    let (n, q) = (used.len(), design.columns());
    if n < q + 1 {
        return None;
    }
    let mut x = DMatrix::zeros(n, q);
    let mut y = DVector::zeros(n);
    for (i, p) in used.iter().enumerate() {
        let root = p.weight.sqrt();
        for (j, v) in design
            .row(p.temperature_c, p.sign, p.force)
            .into_iter()
            .enumerate()
        {
            x[(i, j)] = v * root;
        }
        y[i] = p.value * root;
    }
    let norms: Vec<f64> = (0..q).map(|j| x.column(j).norm()).collect();
    if norms.contains(&0.0) {
        return None;
    }
    for (j, norm) in norms.iter().enumerate() {
        x.column_mut(j).scale_mut(1.0 / norm);
    }
    let qr = x.clone().qr();
    let r = qr.r();
    // A column that the others make up to rounding is not determined.
    if (0..q).any(|j| r[(j, j)].abs() < 1e-9) {
        return None;
    }
    let scaled = r.solve_upper_triangular(&(qr.q().transpose() * &y))?;
    let inverse = r.try_inverse()?;
    let square = &inverse * inverse.transpose();
    let residual = y - x * &scaled;
    Some(Solution {
        values: DVector::from_fn(q, |j, _| scaled[j] / norms[j]),
        inverse: DMatrix::from_fn(q, q, |i, j| square[(i, j)] / norms[i] / norms[j]),
        sum: residual.norm_squared(),
    })
}

/// Mean squared error of each of ten folds by the fit of the other nine.
pub(super) fn cross_validate(design: &Design, points: &[Point]) -> Option<Vec<f64>> {
    let mut out = Vec::new();
    for fold in 0..10 {
        let (mut sum, mut weight) = (0.0, 0.0);
        let fit = solve(design, points, Some(fold))?;
        for p in points.iter().filter(|p| p.fold == fold) {
            let row = design.row(p.temperature_c, p.sign, p.force);
            let predicted: f64 = row.iter().zip(fit.values.iter()).map(|(a, b)| a * b).sum();
            sum += p.weight * (p.value - predicted).powi(2);
            weight += p.weight;
        }
        if weight > 0.0 {
            out.push(sum / weight);
        }
    }
    (!out.is_empty()).then_some(out)
}

/// Mean of paired differences and its standard error.
pub(super) fn paired(a: &[f64], b: &[f64]) -> (f64, f64) {
    let n = a.len().min(b.len()) as f64;
    let mean = a.iter().zip(b).map(|(x, y)| x - y).sum::<f64>() / n;
    let square = a
        .iter()
        .zip(b)
        .map(|(x, y)| (x - y - mean).powi(2))
        .sum::<f64>();
    (mean, (square / (n - 1.0).max(1.0) / n).sqrt())
}

/// The simplest of candidates (errors by fold, in order of size) that is within two standard errors of the best.
pub(super) fn simplest(errors: &[Option<Vec<f64>>]) -> Option<usize> {
    let mean = |v: &Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
    let best = errors
        .iter()
        .flatten()
        .min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    errors.iter().position(|e| {
        e.as_ref().is_some_and(|e| {
            let (d, se) = paired(e, best);
            d <= 2.0 * se
        })
    })
}

/// Correlation of neighbouring residuals along the branches.
pub(super) fn neighbours(design: &Design, fit: &Solution, points: &[Point]) -> f64 {
    let residual = |p: &Point| {
        let row = design.row(p.temperature_c, p.sign, p.force);
        p.value
            - row
                .iter()
                .zip(fit.values.iter())
                .map(|(a, b)| a * b)
                .sum::<f64>()
    };
    let mut ordered: Vec<&Point> = points.iter().collect();
    ordered.sort_by(|a, b| {
        a.branch
            .cmp(&b.branch)
            .then(a.temperature_c.total_cmp(&b.temperature_c))
    });
    let (mut product, mut square, mut pairs, mut n) = (0.0, 0.0, 0.0, 0.0);
    let mut last: Option<(usize, f64)> = None;
    for p in ordered {
        // Residuals in units of their standard deviations, so that bins of a few samples do not rule.
        let r = residual(p) * p.weight.sqrt();
        square += r * r;
        n += 1.0;
        if let Some((branch, before)) = last
            && branch == p.branch
        {
            product += r * before;
            pairs += 1.0;
        }
        last = Some((p.branch, r));
    }
    if pairs < 3.0 || square <= 0.0 {
        return 0.0;
    }
    ((product / pairs) / (square / n)).clamp(-1.0, 0.99)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_natural_spline_through_a_line_is_the_line() {
        let Some(basis) = Basis::spline(6, [-20.0, 70.0]) else {
            return;
        };
        let Basis::Spline { knots_c, .. } = &basis else {
            return;
        };
        let values: Vec<f64> = knots_c.iter().map(|t| 3.0 + 0.5 * t).collect();
        for t in [-20.0, -3.3, 17.0, 55.5, 70.0] {
            let y: f64 = basis.row(t).iter().zip(&values).map(|(a, b)| a * b).sum();
            assert!((y - (3.0 + 0.5 * t)).abs() < 1e-12, "{t} {y}");
        }
    }

    #[test]
    fn the_simplest_within_two_standard_errors() {
        let flat = Some(vec![1.0, 1.1, 0.9, 1.05, 0.95]);
        let better = Some(vec![0.99, 1.12, 0.88, 1.06, 0.94]);
        let far = Some(vec![3.0, 3.1, 2.9, 3.05, 2.95]);
        assert_eq!(simplest(&[far, flat, better]), Some(1));
    }
}
