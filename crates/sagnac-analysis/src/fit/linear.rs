//! Small dense algebra: Cholesky factors and least squares with non-negative variables (at most a dozen of them).
//!
//! Source of the active-set rule: [LawsonHanson1974] chapter 23, on the normal equations.

/// Lower Cholesky factor of a symmetric row-major matrix; none where it is not positive definite.
pub(crate) fn cholesky(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = matrix[i * n + j];
            for k in 0..j {
                sum -= l[i * n + k] * l[j * n + k];
            }
            if i == j {
                if sum.is_nan() || sum <= 0.0 {
                    return None;
                }
                l[i * n + i] = sum.sqrt();
            } else {
                l[i * n + j] = sum / l[j * n + j];
            }
        }
    }
    Some(l)
}

/// Solves L Lᵀ x = b.
pub(crate) fn cholesky_solve(l: &[f64], b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let mut x = b.to_vec();
    for i in 0..n {
        for k in 0..i {
            x[i] -= l[i * n + k] * x[k];
        }
        x[i] /= l[i * n + i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            x[i] -= l[k * n + i] * x[k];
        }
        x[i] /= l[i * n + i];
    }
    x
}

/// Inverse of a symmetric positive definite matrix, after scaling to a unit diagonal.
pub(crate) fn inverse(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let scale: Vec<f64> = (0..n).map(|i| matrix[i * n + i].sqrt()).collect();
    if scale.iter().any(|&s| s.is_nan() || s <= 0.0) {
        return None;
    }
    let mut unit = matrix.to_vec();
    for i in 0..n {
        for j in 0..n {
            unit[i * n + j] /= scale[i] * scale[j];
        }
    }
    let l = cholesky(&unit, n)?;
    let mut out = vec![0.0; n * n];
    for j in 0..n {
        let mut e = vec![0.0; n];
        e[j] = 1.0;
        let x = cholesky_solve(&l, &e);
        for i in 0..n {
            out[i * n + j] = x[i] / (scale[i] * scale[j]);
        }
    }
    Some(out)
}

/// Minimizes ½xᵀHx − cᵀx with x_i ≥ 0 for the `bounded` variables.
pub(crate) fn bounded_least_squares(h: &[f64], c: &[f64], bounded: &[bool]) -> Vec<f64> {
    let k = c.len();
    let scale: Vec<f64> = (0..k)
        .map(|i| {
            let d = h[i * k + i];
            if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }
        })
        .collect();
    let unit = |i: usize, j: usize| h[i * k + j] * scale[i] * scale[j];
    let target: Vec<f64> = (0..k).map(|i| c[i] * scale[i]).collect();
    let mut passive: Vec<bool> = (0..k).map(|i| !bounded[i] && scale[i] > 0.0).collect();
    let mut x = vec![0.0; k];
    let solve = |passive: &[bool]| -> Option<Vec<f64>> {
        let index: Vec<usize> = (0..k).filter(|&i| passive[i]).collect();
        let m = index.len();
        let mut a = vec![0.0; m * m];
        for (p, &i) in index.iter().enumerate() {
            for (q, &j) in index.iter().enumerate() {
                a[p * m + q] = unit(i, j);
            }
            a[p * m + p] *= 1.0 + 1e-11;
        }
        let b: Vec<f64> = index.iter().map(|&i| target[i]).collect();
        let part = cholesky_solve(&cholesky(&a, m)?, &b);
        let mut full = vec![0.0; k];
        for (p, &i) in index.iter().enumerate() {
            full[i] = part[p];
        }
        Some(full)
    };
    if passive.iter().any(|&p| p)
        && let Some(start) = solve(&passive)
    {
        x = start;
    }
    let mut barred = vec![false; k];
    for _ in 0..4 * k + 4 {
        let mut best: Option<(usize, f64)> = None;
        for i in 0..k {
            if passive[i] || barred[i] || scale[i] == 0.0 {
                continue;
            }
            let gradient = target[i] - (0..k).map(|j| unit(i, j) * x[j]).sum::<f64>();
            if gradient > 1e-10 * (1.0 + target[i].abs()) && best.is_none_or(|(_, g)| gradient > g)
            {
                best = Some((i, gradient));
            }
        }
        let Some((entering, _)) = best else { break };
        passive[entering] = true;
        loop {
            let Some(s) = solve(&passive) else {
                passive[entering] = false;
                barred[entering] = true;
                break;
            };
            let mut step = 1.0_f64;
            for i in 0..k {
                if passive[i] && bounded[i] && s[i] <= 0.0 {
                    let way = x[i] - s[i];
                    step = step.min(if way > 0.0 { x[i] / way } else { 0.0 });
                }
            }
            for i in 0..k {
                x[i] += step * (s[i] - x[i]);
            }
            if step >= 1.0 {
                break;
            }
            for i in 0..k {
                if passive[i] && bounded[i] && s[i] <= 0.0 && x[i] <= 1e-14 {
                    passive[i] = false;
                    x[i] = 0.0;
                }
            }
            if !passive[entering] {
                barred[entering] = true;
            }
            if !passive.iter().any(|&p| p) {
                break;
            }
        }
    }
    (0..k)
        .map(|i| {
            let value = x[i] * scale[i];
            if bounded[i] { value.max(0.0) } else { value }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn inverse_times_matrix_is_one() {
        let m = [4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2e-6];
        let m = [
            m[0],
            m[1],
            m[2] * 1e-3,
            m[3],
            m[4],
            m[5] * 1e-3,
            m[6] * 1e-3,
            m[7] * 1e-3,
            m[8],
        ];
        let inv = inverse(&m, 3).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                let sum: f64 = (0..3).map(|k| m[i * 3 + k] * inv[k * 3 + j]).sum();
                assert!((sum - f64::from(u8::from(i == j))).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn negative_solutions_stop_at_zero() {
        // Unbounded optimum (1, −1); with x₂ ≥ 0 it is (½, 0).
        let h = [2.0, 1.0, 1.0, 2.0];
        let c = [1.0, -1.0];
        assert_eq!(bounded_least_squares(&h, &c, &[false, false]).len(), 2);
        let free = bounded_least_squares(&h, &c, &[false, false]);
        assert!((free[0] - 1.0).abs() < 1e-9 && (free[1] + 1.0).abs() < 1e-9);
        let bound = bounded_least_squares(&h, &c, &[true, true]);
        assert!((bound[0] - 0.5).abs() < 1e-9 && bound[1] == 0.0);
    }
}
