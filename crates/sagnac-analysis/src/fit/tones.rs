//! Neighboring lines of one segment fitted at once: amplitude, phase and frequency of each by least squares.
//!
//! Lines within some widths of each other share coefficients, so that each alone would be off by what the others leak. Here
//! Σ (c_j − Σ_i A_i [cos φ_i C_j(ν_i) + sin φ_i S_j(ν_i)])² over the coefficients around all of them is made smallest by
//! damped Gauss–Newton steps [Marquardt1963]; C and S are the closed forms of `lines`. The sum over the level of the noise
//! is −2 ln L, and intervals are those of its profile [CoxHinkley1974].

use super::linear::{cholesky, cholesky_solve, inverse};
use super::lines::{Line, columns};
use super::profile::{INTERVAL, Side, search};

/// Coefficients taken on either side of a line.
pub(super) const REACH: usize = 24;
/// Step of ν for the derivative.
const STEP: f64 = 1e-3;
/// Places of ν tried for two lines in place of one: from −`HALF` to `HALF` steps of half a coefficient.
const HALF: i32 = 8;

/// Coefficients of one segment around a few lines, the lines in them.
pub(super) struct Window {
    first: usize,
    n: usize,
    values: Vec<f64>,
}

/// Amplitude, phase (of the cosine at the segment's start) and ν of each line in turn.
pub(super) type Tones = Vec<f64>;

impl Window {
    /// The window around `lines`, which are no longer in `residual`.
    pub(super) fn around(residual: &[f64], lines: &[Line]) -> Self {
        let n = residual.len();
        let low = lines.iter().map(|l| l.nu).fold(f64::INFINITY, f64::min);
        let high = lines.iter().map(|l| l.nu).fold(0.0, f64::max);
        let first = (low.round() as usize).saturating_sub(REACH).max(1);
        let end = (high.round() as usize + REACH + 1).min(n);
        let values = (first..end)
            .map(|j| residual[j] + lines.iter().map(|l| l.at(j)).sum::<f64>())
            .collect();
        Self { first, n, values }
    }

    /// Misses of the model and their sum of squares.
    fn misses(&self, tones: &[f64]) -> (Vec<f64>, f64) {
        let mut out = self.values.clone();
        for tone in tones.chunks_exact(3) {
            let (a, b) = (tone[0] * tone[1].cos(), tone[0] * tone[1].sin());
            for (k, v) in out.iter_mut().enumerate() {
                let (c, s) = columns(tone[2], self.first + k, self.n);
                *v -= a * c + b * s;
            }
        }
        let sum = out.iter().map(|v| v * v).sum();
        (out, sum)
    }

    /// Derivatives of the model, a row a parameter.
    fn slopes(&self, tones: &[f64]) -> Vec<Vec<f64>> {
        let mut out = Vec::with_capacity(tones.len());
        for tone in tones.chunks_exact(3) {
            let (amplitude, nu) = (tone[0], tone[2]);
            let (sin, cos) = tone[1].sin_cos();
            let mut rows = [const { Vec::new() }; 3];
            for j in (0..self.values.len()).map(|k| self.first + k) {
                let (c, s) = columns(nu, j, self.n);
                let (before, after) =
                    (columns(nu - STEP, j, self.n), columns(nu + STEP, j, self.n));
                rows[0].push(cos * c + sin * s);
                rows[1].push(amplitude * (cos * s - sin * c));
                let slope = cos * (after.0 - before.0) + sin * (after.1 - before.1);
                rows[2].push(amplitude * slope / (2.0 * STEP));
            }
            out.extend(rows);
        }
        out
    }

    /// Improves `tones`, the parameter `held` left as it is; the sum of squares reached.
    pub(super) fn fit(&self, tones: &mut Tones, held: Option<usize>) -> f64 {
        let free: Vec<usize> = (0..tones.len()).filter(|i| Some(*i) != held).collect();
        let p = free.len();
        let (mut misses, mut sum) = self.misses(tones);
        let mut damping = 1e-4;
        for _ in 0..20 {
            let slopes = self.slopes(tones);
            let mut normal = vec![0.0; p * p];
            let mut right = vec![0.0; p];
            for (a, &i) in free.iter().enumerate() {
                right[a] = product(&slopes[i], &misses);
                for (b, &k) in free.iter().enumerate().take(a + 1) {
                    normal[a * p + b] = product(&slopes[i], &slopes[k]);
                    normal[b * p + a] = normal[a * p + b];
                }
            }
            let before = sum;
            while damping < 1e6 {
                let mut damped = normal.clone();
                for a in 0..p {
                    damped[a * p + a] *= 1.0 + damping;
                    damped[a * p + a] += f64::MIN_POSITIVE;
                }
                let Some(l) = cholesky(&damped, p) else {
                    damping *= 10.0;
                    continue;
                };
                let mut next = tones.clone();
                for (a, step) in cholesky_solve(&l, &right).into_iter().enumerate() {
                    // A frequency never moves by more than a coefficient at once.
                    let limit = if free[a] % 3 == 2 { 1.0 } else { f64::INFINITY };
                    next[free[a]] += step.clamp(-limit, limit);
                }
                let (misses_next, sum_next) = self.misses(&next);
                if sum_next < sum {
                    (*tones, misses, sum) = (next, misses_next, sum_next);
                    damping = (0.1 * damping).max(1e-9);
                    break;
                }
                damping *= 10.0;
            }
            if damping >= 1e6 || before - sum < 1e-7 * sum {
                break;
            }
        }
        sum
    }

    /// Two lines in place of one at `nu`: the best of all pairs of places around it.
    pub(super) fn pair(&self, nu: f64) -> Option<Tones> {
        let places: Vec<f64> = (-HALF..=HALF).map(|k| nu + 0.5 * f64::from(k)).collect();
        let mut all = Vec::with_capacity(2 * places.len());
        for &place in &places {
            let (c, s): (Vec<f64>, Vec<f64>) = (0..self.values.len())
                .map(|k| columns(place, self.first + k, self.n))
                .unzip();
            all.push(c);
            all.push(s);
        }
        let right: Vec<f64> = all.iter().map(|a| product(a, &self.values)).collect();
        let m = all.len();
        let products: Vec<f64> = (0..m * m)
            .map(|k| product(&all[k / m], &all[k % m]))
            .collect();
        let mut best: Option<(f64, [usize; 2], Vec<f64>)> = None;
        for i in 0..places.len() {
            for k in i + 1..places.len() {
                let index = [2 * i, 2 * i + 1, 2 * k, 2 * k + 1];
                let normal: Vec<f64> = (0..16)
                    .map(|e| products[index[e / 4] * m + index[e % 4]])
                    .collect();
                let h: Vec<f64> = index.iter().map(|&e| right[e]).collect();
                let Some(l) = cholesky(&normal, 4) else {
                    continue;
                };
                let x = cholesky_solve(&l, &h);
                let gain = product(&x, &h);
                if best.as_ref().is_none_or(|b| gain > b.0) {
                    best = Some((gain, [i, k], x));
                }
            }
        }
        let (_, at, x) = best?;
        let tone = |m: usize| {
            let (a, b) = (x[2 * m], x[2 * m + 1]);
            [a.hypot(b), b.atan2(a), places[at[m]]]
        };
        Some([tone(0), tone(1)].concat())
    }

    /// Covariance of all parameters, where they can be told apart.
    fn covariance(&self, tones: &[f64], level: f64) -> Option<Vec<f64>> {
        let slopes = self.slopes(tones);
        let p = slopes.len();
        let information: Vec<f64> = (0..p * p)
            .map(|m| product(&slopes[m / p], &slopes[m % p]) / level)
            .collect();
        inverse(&information, p)
    }

    /// Standard deviation and both ends of the profile's 95 % interval of a parameter.
    pub(super) fn interval(&self, tones: &Tones, index: usize, level: f64) -> Option<[f64; 3]> {
        let p = tones.len();
        let sigma = self.covariance(tones, level)?[index * p + index].sqrt();
        let (_, least) = self.misses(tones);
        let is_amplitude = index.is_multiple_of(3);
        let end = |side| {
            let mut warm = tones.clone();
            search(tones[index], sigma, side, INTERVAL, !is_amplitude, |x| {
                warm[index] = x;
                (self.fit(&mut warm, Some(index)) - least) / level
            })
        };
        Some([sigma, end(Side::Lower), end(Side::Upper)])
    }

    /// Sum of squares of what is left in `from..to`, and the number of coefficients there.
    pub(super) fn left(&self, tones: &[f64], from: f64, to: f64) -> (f64, f64) {
        let (misses, _) = self.misses(tones);
        misses
            .iter()
            .enumerate()
            .filter(|(k, _)| (from..=to).contains(&((self.first + k) as f64)))
            .fold((0.0, 0.0), |(sum, count), (_, v)| {
                (sum + v * v, count + 1.0)
            })
    }
}

fn product(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}
