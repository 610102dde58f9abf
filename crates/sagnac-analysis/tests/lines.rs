//! Lines close together, lines that wander, and lines above a filter's corner.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::estimate_of_samples;
use sagnac_analysis::fit::{AxisEstimate, FindingKind};
use std::f64::consts::TAU;

const SAMPLES: usize = 60_000;
const STEP_S: f64 = 0.01;
/// 1/T in Hz.
const BIN_HZ: f64 = 1.0 / (SAMPLES as f64 * STEP_S);

/// Sum of four uniform numbers: Gaussian enough, variance 1.
fn noise(seed: &mut u64) -> f64 {
    let sum = (0..4).fold(-2.0, |sum, _| {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        sum + (*seed >> 11) as f64 / (1_u64 << 53) as f64
    });
    sum * 3_f64.sqrt()
}

/// Variance 1 and a line of this amplitude and phase, in turns, at each sample.
fn with_line(amplitude: f64, phase: impl Fn(f64) -> f64, seed: &mut u64) -> Vec<f64> {
    (0..SAMPLES)
        .map(|k| noise(seed) + amplitude * (TAU * phase((k as f64 + 0.5) * STEP_S)).sin())
        .collect()
}

/// Interval of the frequency of each line, and of the amplitude.
fn intervals(axis: &AxisEstimate) -> Vec<[f64; 4]> {
    axis.sinusoids
        .iter()
        .map(|s| {
            let (f, a) = (s.frequency_hz, s.amplitude);
            [f.lower, f.upper, a.lower, a.upper].map(Option::unwrap)
        })
        .collect()
}

#[test]
fn two_lines_close_together_are_both_found_and_their_intervals_hold() {
    // A²n/4σ² = 60 each.
    let amplitude = (240.0 / SAMPLES as f64).sqrt();
    let (mut held, mut told, mut seed) = (0, 0, 4100);
    for apart in [1.5, 2.5, 7.0, 22.0] {
        for log in 0..10 {
            let f = [3.0, 3.0 + apart * BIN_HZ];
            let turn = f64::from(log) / 10.0;
            let mut samples = with_line(amplitude, |t| f[0] * t + 0.3, &mut seed);
            for (k, y) in samples.iter_mut().enumerate() {
                let t = (k as f64 + 0.5) * STEP_S;
                *y += amplitude * (TAU * (f[1] * t + turn)).sin();
            }
            let axis = estimate_of_samples(&samples, STEP_S);
            assert_eq!(axis.sinusoids.len(), 2, "{apart} {log}");
            for ([low, high, least, most], f) in intervals(&axis).into_iter().zip(f) {
                told += 2;
                held += i32::from(low <= f && f <= high);
                held += i32::from(least <= amplitude && amplitude <= most);
            }
        }
    }
    // 95 % of 160 are 152, give or take 2.8.
    assert_eq!(told, 160);
    assert!(held >= 144, "{held} of {told}");
}

#[test]
fn a_line_that_wanders_is_one() {
    let mut seed = 4200;
    for wander in [1.0, 2.0, 4.0, 8.0] {
        for _ in 0..3 {
            // Its frequency goes at random, by `wander` bins in the whole log.
            let step = wander * BIN_HZ / (SAMPLES as f64).sqrt();
            let (mut f, mut turns) = (20.0, 0.0);
            let phases: Vec<f64> = (0..SAMPLES)
                .map(|_| {
                    f += step * noise(&mut seed);
                    turns += f * STEP_S;
                    turns
                })
                .collect();
            let samples: Vec<f64> = phases
                .iter()
                .map(|turns| 0.7 * (TAU * turns).sin() + noise(&mut seed))
                .collect();
            let axis = estimate_of_samples(&samples, STEP_S);
            assert_eq!(axis.sinusoids.len(), 1, "{wander}: {:?}", axis.sinusoids);
        }
    }
}

/// A low-pass of the second order (Butterworth, bilinear) with its corner at u = f·dt.
fn filtered(samples: &[f64], u: f64) -> Vec<f64> {
    let k = (TAU * 0.5 * u).tan();
    let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
    let b = k * k * norm;
    let (a1, a2) = (
        2.0 * (k * k - 1.0) * norm,
        (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm,
    );
    let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
    samples
        .iter()
        .map(|&now| {
            let out = b * (now + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
            x = [now, x[0]];
            y = [out, y[0]];
            out
        })
        .collect()
}

#[test]
fn a_line_above_a_filters_corner_is_found_as_the_filter_has_left_it() {
    let mut seed = 4300;
    for (corner, f, left) in [(0.4, 15.3, 1.0), (0.1, 24.0, 0.13), (0.1, 35.0, 0.026)] {
        for _ in 0..4 {
            let samples = filtered(&with_line(2.0, |t| f * t, &mut seed), corner);
            let axis = estimate_of_samples(&samples, STEP_S);
            assert!(
                axis.findings
                    .iter()
                    .any(|f| f.kind == FindingKind::Filtered)
            );
            assert_eq!(
                axis.sinusoids.len(),
                1,
                "{corner} {f}: {:?}",
                axis.sinusoids
            );
            let line = &axis.sinusoids[0];
            assert!(line.is_filtered);
            assert!((line.frequency_hz.value.unwrap() - f).abs() < 0.1 * BIN_HZ);
            let ratio = line.amplitude.value.unwrap() / (2.0 * left);
            assert!((0.8..1.6).contains(&ratio), "{corner} {f}: {ratio}");
            let told = axis.findings.iter().find(|f| f.kind == FindingKind::Line);
            if corner > 0.3 {
                assert!(told.unwrap().text.contains("as the filter has left it"));
            }
        }
    }
}

#[test]
fn a_filtered_log_without_lines_has_none() {
    let mut seed = 4400;
    for corner in [0.03, 0.1, 0.2, 0.4] {
        for _ in 0..6 {
            let white: Vec<f64> = (0..20_000).map(|_| noise(&mut seed)).collect();
            // Twice: of the fourth order.
            let samples = filtered(&filtered(&white, corner), corner);
            let axis = estimate_of_samples(&samples[200..], STEP_S);
            assert!(axis.sinusoids.is_empty(), "{corner}: {:?}", axis.sinusoids);
        }
    }
}

#[test]
fn a_resonance_at_a_filters_corner_is_no_quantization_noise() {
    let mut seed = 4500;
    for _ in 0..4 {
        let white: Vec<f64> = (0..200_000).map(|_| noise(&mut seed)).collect();
        // Down by half above 20 Hz, with a hump at 19 Hz: x + a resonance, the sum of both smoothed.
        let (mut before, mut last) = ([0.0; 2], 0.0);
        let samples: Vec<f64> = white
            .iter()
            .map(|&x| {
                let (radius, turn) = (0.96_f64, TAU * 0.19);
                let y =
                    0.06 * x + 2.0 * radius * turn.cos() * before[0] - radius * radius * before[1];
                before = [y, before[0]];
                let out = 0.6 * (x + 0.6 * last) + y;
                last = x;
                out
            })
            .collect();
        let axis = estimate_of_samples(&samples, STEP_S);
        assert!(
            axis.findings
                .iter()
                .any(|f| f.kind == FindingKind::Filtered)
        );
        assert!(!axis.quantization.is_detected(), "{:?}", axis.quantization);
    }
}
