//! Thêo1 of every factor of an octave at once, from lagged products.
//!
//! With C_l = Σ z_i z_{i+l} over a stretch of starts and H_l(s) what a shift by s takes off it,
//! Σ_i of the squared difference of lag k is the sum of 4C_0, −H_0(m), −H_0(k), −H_0(m−k),
//! −4C_k, 2H_k(m−k), −4C_{m−k}, 2H_{m−k}(k), 2C_m, 2C_{m−2k}, −2H_{m−2k}(k). C comes from a
//! Fourier transform, H_l(s) from a running sum that serves every m at once (the idea of
//! `[LEWIS]`, on stretches of eight m whose line is taken out, so that nothing cancels).

use rayon::prelude::*;
use realfft::RealFftPlanner;

/// Starts of a stretch, in units of the largest factor.
const STARTS: usize = 8;
/// Parts of the lags, summed in order: fixed, for any number of threads the same bits.
const PARTS: usize = 16;
const LANES: usize = 8;

/// Products of pairs that the table costs for a largest factor `m` and `points` phase points.
pub(super) fn cost(points: usize, m: usize) -> f64 {
    let stretches = (points / (STARTS * m)) as f64 + 1.0;
    stretches * (m as f64) * (m as f64) / 2.0 + 40.0 * points as f64
}

/// Σ of weighted squares for each factor: even, of one octave, below the number of points.
pub(super) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    let mut sums = vec![0.0; factors.len()];
    let Some(&largest) = factors.last() else {
        return sums;
    };
    let count = STARTS * largest;
    let mut start = 0;
    while start + count + largest <= phase.len() {
        let points = &phase[start..start + count + largest];
        add(points, Some(count), factors, &mut sums);
        start += count;
    }
    add(&phase[start..], None, factors, &mut sums);
    sums
}

/// Adds one stretch: `count` starts, or where none is given all that its points allow.
fn add(points: &[f64], count: Option<usize>, factors: &[usize], sums: &mut [f64]) {
    let possible = factors.partition_point(|&m| m < points.len());
    let Some(&largest) = factors[..possible].last() else {
        return;
    };
    let last = points.len() - 1;
    let slope = (points[last] - points[0]) / last as f64;
    let z: Vec<f64> = points
        .iter()
        .enumerate()
        .map(|(i, x)| x - points[0] - slope * i as f64)
        .collect();
    let lagged = correlation(&z[..count.unwrap_or(z.len())], &z, largest);
    let padded = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut out: Vec<f64> = values.take(largest).collect();
        out.resize(largest + 2 * LANES, 0.0);
        out
    };
    let ends = Ends {
        head: padded(&mut z.iter().copied()),
        tail: match count {
            Some(count) => padded(&mut z[count..].iter().copied()),
            None => padded(&mut z.iter().rev().copied()),
        },
        sign: if count.is_some() { -1.0 } else { 1.0 },
        largest,
    };
    let table = ends.table();
    let squares = ends.squares();
    for (sum, &m) in sums.iter_mut().zip(&factors[..possible]) {
        let terms: f64 = (1..=m / 2)
            .map(|k| {
                let own = 4.0 * lagged[0] - squares[m] - squares[k] - squares[m - k];
                let cross =
                    2.0 * (lagged[m] + lagged[m - 2 * k]) - 4.0 * (lagged[k] + lagged[m - k]);
                (own + cross) / k as f64
            })
            .sum();
        *sum += terms + table[m];
    }
}

/// Σ_i a_i b_{i+l} for l = 0…largest.
fn correlation(a: &[f64], b: &[f64], largest: usize) -> Vec<f64> {
    let size = b.len().max(a.len() + largest).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(size),
        planner.plan_fft_inverse(size),
    );
    let transform = |values: &[f64]| {
        let mut input = forward.make_input_vec();
        input[..values.len()].copy_from_slice(values);
        let mut output = forward.make_output_vec();
        // The lengths are those of the plan: this cannot fail.
        let _ = forward.process(&mut input, &mut output);
        output
    };
    let mut product = transform(b);
    for (value, other) in product.iter_mut().zip(transform(a)) {
        *value *= other.conj();
    }
    // Real by construction; rounding must not say otherwise.
    product[0].im = 0.0;
    if let Some(nyquist) = product.last_mut() {
        nyquist.im = 0.0;
    }
    let mut output = inverse.make_output_vec();
    let _ = inverse.process(&mut product, &mut output);
    output
        .iter()
        .take(largest + 1)
        .map(|value| value / size as f64)
        .collect()
}

/// The points that a shift drops at the start and takes up at the end.
struct Ends {
    head: Vec<f64>,
    tail: Vec<f64>,
    sign: f64,
    largest: usize,
}

impl Ends {
    /// H_0(s), s = 0…largest.
    fn squares(&self) -> Vec<f64> {
        let mut total = 0.0;
        std::iter::once(0.0)
            .chain(self.head.iter().zip(&self.tail).map(|(a, b)| {
                total += a * a + self.sign * b * b;
                total
            }))
            .take(self.largest + 1)
            .collect()
    }

    /// Σ_k (1/k)·[2H_k(m−k) + 2H_{m−k}(k) − 2H_{m−2k}(k)] for every m up to the largest.
    fn table(&self) -> Vec<f64> {
        let parts: Vec<Vec<f64>> = (0..PARTS)
            .into_par_iter()
            .map(|part| {
                let mut out = vec![0.0; self.largest + 3 * LANES];
                for lag in (part * LANES..self.largest).step_by(PARTS * LANES) {
                    self.scan(lag, &mut out);
                }
                out
            })
            .collect();
        let mut total = vec![0.0; self.largest + 1];
        for part in parts {
            for (sum, value) in total.iter_mut().zip(part) {
                *sum += value;
            }
        }
        total
    }

    /// Adds eight lags from `lag` on.
    #[allow(
        unsafe_code,
        reason = "calls itself compiled for wider vectors: the whole time of long factors"
    )]
    fn scan(&self, lag: usize, out: &mut [f64]) {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx512f")]
            fn with_512(ends: &Ends, lag: usize, out: &mut [f64]) {
                ends.scan_plain(lag, out);
            }
            #[target_feature(enable = "avx2,fma")]
            fn with_256(ends: &Ends, lag: usize, out: &mut [f64]) {
                ends.scan_plain(lag, out);
            }
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the feature is there.
                return unsafe { with_512(self, lag, out) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the features are there.
                return unsafe { with_256(self, lag, out) };
            }
        }
        self.scan_plain(lag, out);
    }

    #[inline(always)]
    #[allow(
        clippy::inline_always,
        reason = "a function keeps its caller's vectors only where it is inlined"
    )]
    fn scan_plain(&self, lag: usize, out: &mut [f64]) {
        let mut shifted = [0.0; LANES];
        for s in 1..=self.largest - lag {
            let near = 2.0 / s as f64;
            let (a, b) = (self.head[s - 1], self.sign * self.tail[s - 1]);
            let head = &self.head[s - 1 + lag..][..LANES];
            let tail = &self.tail[s - 1 + lag..][..LANES];
            for lane in 0..LANES {
                shifted[lane] += a * head[lane] + b * tail[lane];
            }
            let at = &mut out[lag + s..][..LANES];
            if s < lag {
                for lane in 0..LANES {
                    at[lane] += near * shifted[lane];
                }
            } else {
                for lane in 0..LANES {
                    let own = lag + lane;
                    let weight = match own {
                        0 => 0.0,
                        _ if s < own => near,
                        _ if s == own => 2.0 * near,
                        _ => 2.0 / own as f64,
                    };
                    at[lane] += weight * shifted[lane];
                }
            }
            if lag + 2 * s <= self.largest {
                let at = &mut out[lag + 2 * s..][..LANES];
                for lane in 0..LANES {
                    at[lane] -= near * shifted[lane];
                }
            }
        }
    }
}
