//! Intervals that allow for what may be there and was not taken in: quantization noise beside N, a line beside K; what a
//! covariance lists; terms that a caller leaves out.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::noise;
use sagnac_analysis::fit::{AxisEstimate, Candidates, Estimate, FitOptions};

const STEP_S: f64 = 0.02;
const SAMPLES: usize = 20_000;

/// N = 1, uniform quantization noise, a random walk and a line.
fn axis(quantization: f64, walk: f64, slope: f64, seed: &mut u64) -> Vec<f64> {
    let uniform = |seed: &mut u64| {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        3_f64.sqrt() * ((*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    let (mut bias, mut before) = (0.0, uniform(seed));
    (0..SAMPLES)
        .map(|k| {
            let (half, rest) = (0.5 * noise(seed), noise(seed) / 12_f64.sqrt());
            let mean = bias + walk * STEP_S.sqrt() * (half + rest);
            bias += 2.0 * walk * STEP_S.sqrt() * half;
            let q = uniform(seed);
            let step = quantization * (q - before) / STEP_S;
            before = q;
            noise(seed) / STEP_S.sqrt() + step + mean + slope * (k as f64 + 0.5) * STEP_S
        })
        .collect()
}

fn holds(e: &Estimate, truth: f64) -> bool {
    e.lower.is_none_or(|l| l <= truth) && e.upper.is_some_and(|u| u >= truth)
}

#[test]
fn intervals_of_white_noise_hold_beside_weak_quantization_noise() {
    let mut seed = 900;
    let (mut held, axes) = (0, 150);
    for _ in 0..axes {
        let found = common::estimate_of_samples(&axis(0.0156, 0.0, 0.0, &mut seed), STEP_S);
        held += usize::from(holds(&found.white, 1.0));
    }
    // With Q taken as zero they hold in half of the axes.
    assert!(100 * held >= 91 * axes, "{held} of {axes}");
}

#[test]
fn intervals_of_a_random_walk_hold_beside_a_line_that_may_be_missed() {
    let mut seed = 250;
    let (mut held, mut without, axes) = (0, 0, 150);
    let (walk, slope) = (0.5, 0.075);
    let mut blind = FitOptions::default();
    blind.candidates.ramp = false;
    for _ in 0..axes {
        let samples = axis(0.0, walk, slope, &mut seed);
        let walk_of = |options: &FitOptions| {
            common::estimate_of_samples_with(&samples, STEP_S, options).random_walk
        };
        held += usize::from(holds(&walk_of(&FitOptions::default()), walk));
        without += usize::from(holds(&walk_of(&blind), walk));
    }
    assert!(100 * held >= 92 * axes, "{held} of {axes}");
    assert!(held > without + 4, "{held}, {without} without a line");
}

/// The names that a covariance should have.
fn detected(axis: &AxisEstimate) -> Vec<String> {
    let singles = [
        ("Q", &axis.quantization),
        ("N", &axis.white),
        ("B", &axis.flicker),
        ("K", &axis.random_walk),
    ];
    let mut names: Vec<String> = singles
        .into_iter()
        .filter(|(_, e)| e.is_detected())
        .map(|(name, _)| name.to_owned())
        .collect();
    for (i, process) in axis.gauss_markov.iter().enumerate() {
        if process.sigma.is_detected() {
            names.extend([format!("sigma{}", i + 1), format!("Tc{}", i + 1)]);
        }
    }
    names
}

#[test]
fn a_covariance_lists_detected_terms_alone() {
    let mut seed = 1010;
    for k in 0..60 {
        let samples = axis(0.0, 0.05 + 0.005 * f64::from(k), 0.0, &mut seed);
        let found = common::estimate_of_samples(&samples, STEP_S);
        let names = &found.covariance.names;
        assert_eq!(names, &detected(&found));
        assert_eq!(found.covariance.matrix.len(), names.len() * names.len());
        if let Some(place) = names.iter().position(|n| n == "N") {
            let sigma = found.covariance.matrix[place * (names.len() + 1)].sqrt();
            assert!((sigma / found.white.sigma.unwrap() - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn a_term_that_is_left_out_makes_no_disturbance() {
    let mut seed = 77;
    let options = FitOptions {
        candidates: Candidates {
            white: true,
            ..Candidates::none()
        },
        ..FitOptions::default()
    };
    for _ in 0..20 {
        let samples = axis(0.0, 0.5, 0.0, &mut seed);
        let found = common::estimate_of_samples_with(&samples, STEP_S, &options);
        assert!(found.regressors.is_empty(), "{:?}", found.regressors);
        assert!(found.p_value.unwrap() < 1e-3 && found.white.is_detected());
        assert!(!found.random_walk.is_detected() && found.random_walk.upper.is_none());
    }
}
