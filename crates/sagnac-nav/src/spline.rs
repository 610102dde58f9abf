//! Interpolating splines of degree five with the not-a-knot condition, on any increasing times: B-splines on the knots
//! t₀ (six times), t₃ … t_{n−4}, t_{n−1} (six times), their coefficients from the banded collocation system \[DEBOOR\].
//!
//! With fewer than six points the polynomial of degree n − 1.

/// Several components over the same times, as polynomials between knots.
#[derive(Debug, Clone)]
pub struct Spline<const D: usize> {
    /// Piece boundaries, s.
    knots_s: Vec<f64>,
    /// Taylor coefficients at each piece's middle.
    pieces: Vec<[[f64; 6]; D]>,
}

const DEGREE: usize = 5;

/// Values and derivatives: `out[order][component]`.
pub type Derivatives<const D: usize> = [[f64; D]; 4];

impl<const D: usize> Spline<D> {
    /// Through `points` at strictly increasing `times_s` (at least two; the caller has checked).
    pub fn new(times_s: &[f64], points: &[[f64; D]]) -> Self {
        let n = times_s.len().min(points.len());
        if n < 6 {
            return Self::polynomial(&times_s[..n], &points[..n]);
        }
        let mut knots = vec![times_s[0]; 6];
        knots.extend_from_slice(&times_s[3..n - 3]);
        knots.extend(std::iter::repeat_n(times_s[n - 1], 6));
        let coefficients = collocate(&knots, times_s, points);
        let knots_s: Vec<f64> = knots[5..=n].to_vec();
        let pieces = (0..knots_s.len() - 1)
            .map(|i| {
                let span = i + 5;
                let middle = 0.5 * (knots_s[i] + knots_s[i + 1]);
                let mut piece = [[0.0; 6]; D];
                let mut factorial = 1.0;
                for order in 0..6 {
                    if order > 0 {
                        factorial *= order as f64;
                    }
                    let value = derivative(&knots, &coefficients, span, middle, order);
                    for d in 0..D {
                        piece[d][order] = value[d] / factorial;
                    }
                }
                piece
            })
            .collect();
        Self { knots_s, pieces }
    }

    fn polynomial(times_s: &[f64], points: &[[f64; D]]) -> Self {
        let n = times_s.len();
        let (first, last) = (times_s[0], times_s[n - 1]);
        let middle = 0.5 * (first + last);
        let mut piece = [[0.0; 6]; D];
        for d in 0..D {
            // Newton's divided differences, then a change of base to powers of (t − middle).
            let mut divided: Vec<f64> = points.iter().map(|p| p[d]).collect();
            for level in 1..n {
                for i in (level..n).rev() {
                    divided[i] = (divided[i] - divided[i - 1]) / (times_s[i] - times_s[i - level]);
                }
            }
            let mut power = [0.0; 6];
            for i in (0..n).rev() {
                let shift = middle - times_s[i];
                for j in (0..6).rev() {
                    power[j] = power[j] * shift + if j > 0 { power[j - 1] } else { 0.0 };
                }
                power[0] += divided[i];
            }
            piece[d] = power;
        }
        Self {
            knots_s: vec![first, last],
            pieces: vec![piece],
        }
    }

    /// Inner and outer piece boundaries, s.
    pub fn knots_s(&self) -> &[f64] {
        &self.knots_s
    }

    /// Value and first three derivatives at `t_s`; outside the points the end pieces go on.
    pub fn at(&self, t_s: f64) -> Derivatives<D> {
        let last = self.pieces.len() - 1;
        let i = self
            .knots_s
            .partition_point(|k| *k <= t_s)
            .saturating_sub(1)
            .min(last);
        let x = t_s - 0.5 * (self.knots_s[i] + self.knots_s[i + 1]);
        let mut out = [[0.0; D]; 4];
        for d in 0..D {
            let c = &self.pieces[i][d];
            out[0][d] = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
            out[1][d] =
                c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4] + x * 5.0 * c[5])));
            out[2][d] = 2.0 * c[2] + x * (6.0 * c[3] + x * (12.0 * c[4] + x * 20.0 * c[5]));
            out[3][d] = 6.0 * c[3] + x * (24.0 * c[4] + x * 60.0 * c[5]);
        }
        out
    }
}

/// The six B-splines of degree five that do not vanish on [knots[span], knots[span + 1]] (Cox and de Boor).
fn basis(knots: &[f64], span: usize, t: f64) -> [f64; 6] {
    let mut b = [0.0; 6];
    b[0] = 1.0;
    for degree in 1..=DEGREE {
        let mut saved = 0.0;
        for r in 0..degree {
            let (right, left) = (knots[span + 1 + r], knots[span + 1 + r - degree]);
            let part = b[r] / (right - left);
            b[r] = saved + (right - t) * part;
            saved = (t - left) * part;
        }
        b[degree] = saved;
    }
    b
}

/// Solves B c = points; the matrix is totally positive, so elimination without exchanges is stable [DEBOOR].
fn collocate<const D: usize>(knots: &[f64], times_s: &[f64], points: &[[f64; D]]) -> Vec<[f64; D]> {
    let n = times_s.len();
    let mut rows: Vec<[f64; 11]> = vec![[0.0; 11]; n];
    for (i, &t) in times_s.iter().enumerate() {
        let span = (knots.partition_point(|k| *k <= t).saturating_sub(1)).clamp(5, n - 1);
        let b = basis(knots, span, t);
        for (j, value) in b.iter().enumerate() {
            // Column span − 5 + j, stored relative to the diagonal.
            let offset = span + j;
            if (i..=i + 10).contains(&offset) {
                rows[i][offset - i] = *value;
            }
        }
    }
    let mut c: Vec<[f64; D]> = points[..n].to_vec();
    for k in 0..n {
        let pivot = rows[k][5];
        for i in k + 1..(k + 6).min(n) {
            let factor = rows[i][5 + k - i] / pivot;
            if factor == 0.0 {
                continue;
            }
            for j in k..(k + 6).min(n) {
                rows[i][5 + j - i] -= factor * rows[k][5 + j - k];
            }
            for d in 0..D {
                c[i][d] -= factor * c[k][d];
            }
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..(k + 6).min(n) {
            for d in 0..D {
                c[k][d] -= rows[k][5 + j - k] * c[j][d];
            }
        }
        for d in 0..D {
            c[k][d] /= rows[k][5];
        }
    }
    c
}

/// The derivative of a given order at `t` inside a span, by de Boor's differences of the coefficients.
fn derivative<const D: usize>(
    knots: &[f64],
    coefficients: &[[f64; D]],
    span: usize,
    t: f64,
    order: usize,
) -> [f64; D] {
    let mut c = [[0.0; D]; 6];
    c.copy_from_slice(&coefficients[span - 5..=span]);
    for level in 1..=order {
        let degree = DEGREE + 1 - level;
        for j in (level..=DEGREE).rev() {
            let i = span - 5 + j;
            let width = knots[i + degree] - knots[i];
            for d in 0..D {
                c[j][d] = degree as f64 * (c[j][d] - c[j - 1][d]) / width;
            }
        }
    }
    let degree = DEGREE - order;
    for level in 1..=degree {
        for j in (order + level..=DEGREE).rev() {
            let i = span - 5 + j;
            let (left, right) = (knots[i], knots[i + degree + 1 - level]);
            let a = (t - left) / (right - left);
            for d in 0..D {
                c[j][d] = (1.0 - a) * c[j - 1][d] + a * c[j][d];
            }
        }
    }
    c[DEGREE]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quintic_is_reproduced() {
        let f = |t: f64| 1.0 + t * (0.3 + t * (-0.2 + t * (0.05 + t * (0.01 - 0.002 * t))));
        let df = |t: f64| 0.3 + t * (-0.4 + t * (0.15 + t * (0.04 - 0.01 * t)));
        for n in [6, 7, 9, 25] {
            let times: Vec<f64> = (0..n)
                .map(|i| f64::from(i) * 0.3 + 0.07 * (f64::from(i) * 1.7).sin())
                .collect();
            let points: Vec<[f64; 1]> = times.iter().map(|t| [f(*t)]).collect();
            let spline = Spline::new(&times, &points);
            for i in 0..100 {
                let t = times[0] + (times[times.len() - 1] - times[0]) * f64::from(i) / 99.0;
                let got = spline.at(t);
                // Condition of the collocation, about 1e3, times rounding.
                assert!(
                    (got[0][0] - f(t)).abs() < 1e-11 * (1.0 + f(t).abs()),
                    "{n} {t}"
                );
                assert!(
                    (got[1][0] - df(t)).abs() < 1e-10 * (1.0 + df(t).abs()),
                    "{n} {t}"
                );
            }
        }
    }

    #[test]
    fn few_points_give_the_polynomial() {
        let times = [0.0, 0.4, 1.0, 2.5];
        let points: Vec<[f64; 2]> = times
            .iter()
            .map(|t: &f64| [t * t * t - 1.0, 2.0 * t])
            .collect();
        let got = Spline::new(&times, &points).at(1.7);
        assert!((got[0][0] - (1.7f64.powi(3) - 1.0)).abs() < 1e-13);
        assert!((got[2][0] - 6.0 * 1.7).abs() < 1e-12);
        assert!((got[1][1] - 2.0).abs() < 1e-13 && got[3][1].abs() < 1e-12);
    }

    #[test]
    fn sine_converges_with_the_sixth_power() {
        let error = |n: u32| {
            let h = 6.0 / f64::from(n);
            let times: Vec<f64> = (0..=n).map(|i| f64::from(i) * h).collect();
            let points: Vec<[f64; 1]> = times.iter().map(|t| [t.sin()]).collect();
            let spline = Spline::new(&times, &points);
            (0..600)
                .map(|i| f64::from(i) * 0.01)
                .map(|t| (spline.at(t)[0][0] - t.sin()).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(20) / error(40);
        assert!((30.0..160.0).contains(&ratio), "{ratio}");
    }
}
