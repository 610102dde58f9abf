//! Columns of the regression in the cosine domain: line, exponential, step, temperature; closed forms where there are.
//!
//! With θ = πj/n: Σ(k+½) cos θ(k+½) = −cos(θ/2)/(2 sin²(θ/2)) for odd j, 0 for even; a step at sample p gives
//! −sin(πjp/n)/(2 sin(θ/2)); r^k gives Re e^{iθ/2}(1 − rⁿ(−1)^j)/(1 − r e^{iθ}). All times √(2/n).

use super::bins::{Column, SegmentSpectrum};
use super::dct::dct2;
use super::types::Segment;
use realfft::RealFftPlanner;
use std::f64::consts::PI;

/// Coefficients beyond this number carry nothing measurable of a smooth column.
pub(super) const SMOOTH_REACH: usize = 4096;

/// The line in time, slope 1 per sample.
pub(crate) fn line(segments: &[SegmentSpectrum]) -> Column {
    segments
        .iter()
        .map(|segment| {
            let n = segment.n as f64;
            (0..segment.n.min(SMOOTH_REACH))
                .map(|j| {
                    if j % 2 == 0 {
                        return 0.0;
                    }
                    let half = PI * j as f64 / (2.0 * n);
                    -(2.0 / n).sqrt() * half.cos() / (2.0 * half.sin() * half.sin())
                })
                .collect()
        })
        .collect()
}

/// Σ a_j²/S_j of a line of slope 1 a sample over `n` samples; `spectrum` per bin of `log`, as variance of a coefficient.
pub(crate) fn line_information(log: &super::bins::BinnedLog, n: usize, spectrum: &[f64]) -> f64 {
    // Odd coefficients alone, ∝ 1/j²: beyond the first thousand nothing is left.
    let mut sum = 0.0;
    let mut b = 0;
    for j in (1..n.min(1024)).step_by(2) {
        let u = j as f64 / (2.0 * n as f64);
        while b + 1 < log.u.len() && (log.u[b + 1] - u).abs() <= (log.u[b] - u).abs() {
            b += 1;
        }
        let half = PI * u;
        let a = half.cos() / (2.0 * half.sin() * half.sin());
        sum += 2.0 / n as f64 * a * a / spectrum[b];
    }
    sum
}

/// (sin, cos) of j·angle for j = 0, 1, …, by turning; `exact` gives every 64th anew.
fn turns(
    count: usize,
    angle: f64,
    exact: impl Fn(usize) -> f64,
) -> impl Iterator<Item = (f64, f64)> {
    const BLOCK: usize = 64;
    let (sin_step, cos_step) = angle.sin_cos();
    let (mut sin, mut cos) = (0.0, 1.0);
    (0..count).map(move |j| {
        if j % BLOCK == 0 {
            (sin, cos) = exact(j).sin_cos();
        } else {
            (sin, cos) = (
                sin * cos_step + cos * sin_step,
                cos * cos_step - sin * sin_step,
            );
        }
        (sin, cos)
    })
}

/// exp(−t/τ) from the log's start, averaged over each sample; τ in samples.
pub(crate) fn exponential(segments: &[SegmentSpectrum], step_s: f64, tau: f64) -> Column {
    let r = (-1.0 / tau).exp();
    let one_less = -(-1.0 / tau).exp_m1();
    let mean = tau * one_less;
    segments
        .iter()
        .map(|segment| {
            let n = segment.n as f64;
            let amplitude = mean * (-segment.start_s / step_s / tau).exp() * (2.0 / n).sqrt();
            let tail = (-n / tau).exp();
            let reach = SMOOTH_REACH + (40.0 * n / tau) as usize;
            let half = PI / (2.0 * n);
            turns(segment.n.min(reach), half, |j| half * j as f64)
                .enumerate()
                .map(|(j, (sin_half, cos_half))| {
                    if j == 0 {
                        return 0.0;
                    }
                    let end = if j % 2 == 0 { 1.0 - tail } else { 1.0 + tail };
                    // 1 − r e^{iθ}, θ twice the half angle
                    let (re, im) = (
                        one_less + 2.0 * r * sin_half * sin_half,
                        -2.0 * r * sin_half * cos_half,
                    );
                    // Re[e^{iθ/2}/(re + i·im)]
                    amplitude * end * (cos_half * re + sin_half * im) / (re * re + im * im)
                })
                .collect()
        })
        .collect()
}

/// A unit step before sample `at` of segment `which`.
pub(crate) fn step(segments: &[SegmentSpectrum], which: usize, at: usize, reach: usize) -> Column {
    segments
        .iter()
        .enumerate()
        .map(|(s, segment)| {
            if s != which {
                return Vec::new();
            }
            let n = segment.n as f64;
            let scale = -(2.0 / n).sqrt() * 0.5;
            let count = segment.n.min(reach);
            let half = PI / (2.0 * n);
            let place = turns(count, PI * at as f64 / n, |j| {
                let turn = (j as u128 * at as u128) % (2 * segment.n as u128);
                PI * turn as f64 / n
            });
            place
                .zip(turns(count, half, |j| half * j as f64))
                .enumerate()
                .map(|(j, (place, half))| {
                    if j == 0 {
                        0.0
                    } else {
                        scale * place.0 / half.0
                    }
                })
                .collect()
        })
        .collect()
}

/// Coefficients of a step of this height (over the root of the spectrum near the top) that stand out of the noise at all.
pub(crate) fn step_reach(n: usize, height: f64) -> usize {
    // a_j² ≈ 2n/(πj)² of a unit step falls to a thousandth of the noise.
    ((2000.0 * n as f64).sqrt() * height.abs() / PI).min(1e12) as usize + SMOOTH_REACH
}

/// (T − T0)^power as blocks of the temperature channel; sensor noise above their rate stays out.
pub(crate) fn temperature(
    segments: &[SegmentSpectrum],
    channel: &[Segment<'_>],
    reference: f64,
    power: usize,
    planner: &mut RealFftPlanner<f64>,
) -> Column {
    segments
        .iter()
        .zip(channel)
        .map(|(segment, temperature)| {
            let n = segment.n;
            let blocks = n.min(8192);
            let means: Vec<f64> = (0..blocks)
                .map(|i| {
                    let range = i * n / blocks..(i + 1) * n / blocks;
                    let length = range.len() as f64;
                    let mean = temperature.samples[range].iter().sum::<f64>() / length;
                    (mean - reference).powi(power as i32)
                })
                .collect();
            let center = means.iter().sum::<f64>() / blocks as f64;
            let coarse = dct2(&means, center, planner);
            let widen = (blocks as f64 / n as f64).sqrt();
            (0..=blocks / 2)
                .map(|j| {
                    if j == 0 || j >= blocks {
                        return 0.0;
                    }
                    let theta = PI * j as f64 / n as f64;
                    let m = n as f64 / blocks as f64;
                    coarse[j] * widen * (0.5 * m * theta).sin() / (0.5 * theta).sin()
                })
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn assert_column(column: &Column, values: impl Fn(f64) -> f64, n: usize) {
        let samples: Vec<f64> = (0..n).map(|k| values(k as f64)).collect();
        let mean = samples.iter().sum::<f64>() / n as f64;
        let want = dct2(&samples, mean, &mut RealFftPlanner::new());
        let size = want.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for (j, value) in column[0].iter().enumerate() {
            assert!(
                (value - want[j]).abs() < 1e-9 * size,
                "{j} {value} {}",
                want[j]
            );
        }
    }

    #[test]
    fn closed_forms_equal_transforms() {
        let n = 600;
        let segment = [SegmentSpectrum {
            start_s: 0.0,
            n,
            coefficients: Vec::new(),
            excluded: Vec::new(),
            leverage: Vec::new(),
        }];
        assert_column(&line(&segment), |k| k, n);
        assert_column(
            &step(&segment, 0, 217, n),
            |k| f64::from(u8::from(k >= 217.0)),
            n,
        );
        let tau = 73.0;
        assert_column(
            &exponential(&segment, 1.0, tau),
            |k| tau * ((-k / tau).exp() - (-(k + 1.0) / tau).exp()),
            n,
        );
        let channel: Vec<f64> = (0..n).map(|k| 20.0 + (k as f64 / 100.0).sin()).collect();
        let channel = [Segment {
            start_s: 0.0,
            samples: &channel,
            filled: &[],
        }];
        let column = temperature(&segment, &channel, 20.0, 2, &mut RealFftPlanner::new());
        assert_column(&column, |k| (k / 100.0).sin().powi(2), n);
    }
}
