//! Orthonormal DCT-II, c_j = √(2/n) Σ_k y_k cos(πj(k + ½)/n), through one real FFT of the same length.
//!
//! Source: [Makhoul1980]: the even samples rising, the odd ones falling, then a quarter-sample turn.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use std::f64::consts::PI;
use std::sync::{Mutex, PoisonError};

/// The largest length ≤ n whose transform is fast: no prime factor above 13 where n is long.
///
/// Short logs keep every sample; long ones lose at most a few in ten thousand.
pub(crate) fn fast_length(n: usize) -> usize {
    if n < 20_000 {
        return n;
    }
    let smooth = |mut m: usize| {
        for p in [2, 3, 5, 7, 11, 13] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (1..=n).rev().find(|&m| smooth(m)).unwrap_or(n)
}

/// Turns made by recurrence between two exact ones.
const BLOCK: usize = 64;

/// Samples from which transforms wait for each other: one takes 28 bytes a sample for a moment, and leaves 8.
const LONG: usize = 1 << 22;

static LONG_ONE: Mutex<()> = Mutex::new(());

/// Coefficients c_0…c_{n−1} of the samples less `mean`.
///
/// c_0 is returned as zero: the mean is a regressor of its own.
pub(crate) fn dct2(samples: &[f64], mean: f64, planner: &mut RealFftPlanner<f64>) -> Vec<f64> {
    let n = samples.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let _alone = (n >= LONG).then(|| LONG_ONE.lock().unwrap_or_else(PoisonError::into_inner));
    let mut turned = vec![0.0; n];
    let half = n.div_ceil(2);
    let (rising, falling) = turned.split_at_mut(half);
    let mut pairs = samples.chunks_exact(2);
    for ((pair, up), down) in (&mut pairs)
        .zip(rising.iter_mut())
        .zip(falling.iter_mut().rev())
    {
        *up = pair[0] - mean;
        *down = pair[1] - mean;
    }
    if let [last] = pairs.remainder() {
        rising[half - 1] = last - mean;
    }
    let plan = planner.plan_fft_forward(n);
    let mut spectrum = plan.make_output_vec();
    // The lengths are the plan's own: this cannot fail.
    if plan.process(&mut turned, &mut spectrum).is_err() {
        return vec![0.0; n];
    }
    let mut coefficients = turned;
    let norm = (2.0 / n as f64).sqrt();
    let step = Complex::from_polar(1.0, -PI / (2.0 * n as f64));
    for start in (0..spectrum.len()).step_by(BLOCK) {
        let mut turn = Complex::from_polar(norm, -PI * start as f64 / (2.0 * n as f64));
        let end = (start + BLOCK).min(spectrum.len());
        for j in start..end {
            let value = spectrum[j] * turn;
            coefficients[j] = value.re;
            if j > 0 && 2 * j != n {
                coefficients[n - j] = -value.im;
            }
            turn *= step;
        }
    }
    coefficients[0] = 0.0;
    coefficients
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn transform_equals_its_definition() {
        let mut planner = RealFftPlanner::new();
        for n in [2_usize, 3, 7, 64, 135, 601] {
            let samples: Vec<f64> = (0..n)
                .map(|k| ((k * k) as f64 * 0.37).sin() + 0.01 * k as f64)
                .collect();
            let mean = samples.iter().sum::<f64>() / n as f64;
            let got = dct2(&samples, mean, &mut planner);
            for j in 1..n {
                let want = (2.0 / n as f64).sqrt()
                    * (0..n)
                        .map(|k| samples[k] * (PI * j as f64 * (k as f64 + 0.5) / n as f64).cos())
                        .sum::<f64>();
                assert!((got[j] - want).abs() < 1e-11, "{n} {j} {} {want}", got[j]);
            }
        }
    }

    #[test]
    fn long_lengths_become_smooth_and_hardly_shorter() {
        assert_eq!(fast_length(180_000), 180_000);
        assert_eq!(fast_length(1_440_000), 1_440_000);
        for n in [999_983, 214_933, 65_537] {
            let m = fast_length(n);
            assert!(m <= n && (n - m) as f64 / (n as f64) < 3e-3, "{n} {m}");
        }
    }
}
