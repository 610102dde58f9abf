//! Terms that others hide: flicker below a strong slow process, white noise between quantization noise and flicker.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::noise;
use sagnac_analysis::fit::{AxisEstimate, Term};

const STEP_S: f64 = 0.1;
const SAMPLES: usize = 72_000;

/// N = 1 and B, a ladder of processes a factor 4 apart.
fn white_and_flicker(b: f64, seed: &mut u64) -> Vec<f64> {
    let mut samples: Vec<f64> = (0..SAMPLES).map(|_| noise(seed) / STEP_S.sqrt()).collect();
    let sigma = b * (4_f64.ln() / std::f64::consts::PI).sqrt();
    for i in 0..13 {
        let time_s = 8.0 * SAMPLES as f64 * STEP_S / 4_f64.powf(f64::from(i) + 0.5);
        common::add_process(&mut samples, STEP_S, (sigma, time_s), seed);
    }
    samples
}

/// N = 1, B = 0.5, and σ = 11.7 with 100 s.
fn axis(seed: &mut u64) -> Vec<f64> {
    let mut samples = white_and_flicker(0.5, seed);
    common::add_process(&mut samples, STEP_S, (11.667, 100.0), seed);
    samples
}

fn of(samples: &[f64]) -> AxisEstimate {
    common::estimate_of_samples(samples, STEP_S)
}

#[test]
fn white_noise_is_named_between_quantization_noise_and_flicker() {
    let mut seed = 8300;
    let mut named = 0;
    for _ in 0..20 {
        let mut samples = white_and_flicker(0.167, &mut seed);
        let mut before = noise(&mut seed);
        for y in &mut samples {
            let q = noise(&mut seed);
            *y += 8.33 * (q - before) / STEP_S;
            before = q;
        }
        let found = of(&samples);
        named += usize::from(found.white.is_detected());
    }
    assert!(named >= 18, "N named in {named} of 20");
}

#[test]
fn intervals_of_white_noise_hold_where_flicker_is_not_seen() {
    let mut seed = 8100;
    let (mut inside, mut unseen) = (0, 0);
    for _ in 0..80 {
        let samples = axis(&mut seed);
        let found = of(&samples);
        let (lower, upper) = (found.white.lower.unwrap(), found.white.upper.unwrap());
        inside += i32::from(lower < 1.0 && 1.0 < upper);
        unseen += i32::from(!found.flicker.is_detected());
    }
    assert!(unseen > 8, "flicker was to be hidden: {unseen}");
    // 95 % of 80 are 76, give or take 1.9; 64 held where unseen flicker was taken as none.
    assert!(inside >= 71, "{inside} of 80");
}

#[test]
fn a_process_of_a_twentieth_of_the_log_is_rarely_called_a_random_walk() {
    let mut seed = 8400;
    let mut walks = 0;
    for _ in 0..30 {
        let mut samples = white_and_flicker(0.0, &mut seed);
        common::add_process(&mut samples, STEP_S, (5.0, 360.0), &mut seed);
        walks += usize::from(of(&samples).random_walk.is_detected());
    }
    assert!(walks <= 12, "K named in {walks} of 30");
}

#[test]
fn a_process_keeps_its_time_where_another_may_stand_for_flicker() {
    let mut seed = 8500;
    for i in 0..80 {
        let mut samples = white_and_flicker(0.3, &mut seed);
        common::add_process(&mut samples, STEP_S, (1.0, 2.0), &mut seed);
        let found = of(&samples);
        let times: Vec<f64> = found
            .gauss_markov
            .iter()
            .filter_map(|g| g.correlation_time_s.value)
            .collect();
        assert!(
            times.iter().any(|t| (0.5..8.0).contains(t)) && times.iter().all(|&t| t < 100.0),
            "axis {i}: {times:?}"
        );
    }
}

#[test]
fn intervals_of_flicker_hold_beside_a_walk_that_is_not_named() {
    let mut seed = 8500;
    let (mut inside, mut alone) = (0, 0);
    for _ in 0..150 {
        let mut samples = white_and_flicker(0.35, &mut seed);
        let mut bias = 0.0;
        for y in &mut samples {
            let (half, rest) = (0.5 * noise(&mut seed), noise(&mut seed) / 12_f64.sqrt());
            *y += bias + 0.02 * STEP_S.sqrt() * (half + rest);
            bias += 0.04 * STEP_S.sqrt() * half;
        }
        let found = of(&samples);
        if found.flicker.is_detected() && !found.random_walk.is_detected() {
            alone += 1;
            let (lower, upper) = (found.flicker.lower.unwrap(), found.flicker.upper.unwrap());
            inside += usize::from(lower < 0.35 && 0.35 < upper);
        }
    }
    // Without the fit that has a walk they hold in four of five.
    assert!(
        alone > 40 && 100 * inside >= 90 * alone,
        "{inside} of {alone}"
    );
}

#[test]
fn the_mean_is_as_uncertain_as_the_slower_of_two_rivals() {
    let mut seed = 8700;
    let (mut rivals, mut others) = (Vec::new(), Vec::new());
    for _ in 0..60 {
        let found = of(&white_and_flicker(0.15, &mut seed));
        let sigma = found.mean.sigma.unwrap();
        if found.confused.contains(&(Term::Flicker, Term::GaussMarkov)) {
            rivals.push(sigma);
        } else if found.flicker.is_detected() {
            others.push(sigma);
        }
    }
    others.sort_by(f64::total_cmp);
    let least = rivals.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(
        rivals.len() > 3 && others.len() > 10,
        "{} {}",
        rivals.len(),
        others.len()
    );
    // Of the process alone it is a tenth.
    assert!(least > 0.4 * others[others.len() / 2], "{least} {others:?}");
}
