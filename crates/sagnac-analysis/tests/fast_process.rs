//! Processes at ten samples and below beside white noise, and the filters that they must not be taken for.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::noise;
use sagnac_analysis::fit::{AxisEstimate, FindingKind};

const STEP_S: f64 = 0.1;
const SAMPLES: usize = 40_000;
const AXES: u32 = 10;

fn white(length: usize, seed: &mut u64) -> Vec<f64> {
    (0..length).map(|_| noise(seed) / STEP_S.sqrt()).collect()
}

fn has(axis: &AxisEstimate, kind: FindingKind) -> bool {
    axis.findings.iter().any(|f| f.kind == kind)
}

/// Axes of N = 1 and a process of so many samples with σ = 0.8, and the mean of N.
fn axes_with_process(samples: f64, mut seed: u64) -> (Vec<AxisEstimate>, f64) {
    let axes: Vec<AxisEstimate> = (0..AXES)
        .map(|_| {
            let mut values = white(SAMPLES, &mut seed);
            common::add_process(&mut values, STEP_S, (0.8, samples * STEP_S), &mut seed);
            common::estimate_of_samples(&values, STEP_S)
        })
        .collect();
    let sum: f64 = axes.iter().map(|a| a.white.value.unwrap()).sum();
    (axes, sum / f64::from(AXES))
}

#[test]
fn a_process_of_ten_samples_is_found_and_no_filter() {
    let (axes, mean) = axes_with_process(10.0, 310);
    let found = axes
        .iter()
        .filter(|a| a.gauss_markov[0].sigma.is_detected());
    assert!(found.count() >= 9);
    let wrong = |a: &&AxisEstimate| has(a, FindingKind::Filtered) || a.flicker.is_detected();
    assert!(axes.iter().filter(wrong).count() == 0);
    assert!((mean - 1.0).abs() < 0.005, "{mean}");
}

#[test]
fn a_process_of_three_samples_is_told_of_and_leaves_white_noise_as_it_is() {
    let (axes, mean) = axes_with_process(3.0, 303);
    for axis in &axes {
        assert!(has(axis, FindingKind::Misfit) && !has(axis, FindingKind::Filtered));
        assert!(!axis.gauss_markov[0].sigma.is_detected());
        assert!(axis.gauss_markov[0].sigma.upper.is_some());
    }
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}

/// Axes of white noise N = 1 behind a filter: all named so, and the mean of N.
fn white_behind(filter: impl Fn(&[f64]) -> Vec<f64>, mut seed: u64) -> f64 {
    let sum: f64 = (0..AXES)
        .map(|_| {
            let samples = filter(&white(SAMPLES, &mut seed));
            let axis = common::estimate_of_samples(&samples, STEP_S);
            assert!(has(&axis, FindingKind::Filtered));
            axis.white.value.unwrap()
        })
        .sum();
    sum / f64::from(AXES)
}

#[test]
fn a_low_pass_of_three_samples_is_a_filter() {
    let low_pass = |x: &[f64]| {
        let mut y = 0.0;
        let step = |&x: &f64| {
            y += (1.0 - (-1.0_f64 / 3.0).exp()) * (x - y);
            y
        };
        x.iter().map(step).collect()
    };
    let mean = white_behind(low_pass, 333);
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
}

#[test]
fn a_moving_average_of_three_is_a_filter() {
    let average = |x: &[f64]| x.windows(3).map(|w| w.iter().sum::<f64>() / 3.0).collect();
    let mean = white_behind(average, 343);
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
}
