//! compensate ∘ corrupt = identity over random models inside the convergence bound, and
//! flags outside it.
//!
//! Scale s = max(‖u‖∞, ‖y‖∞, ‖b‖∞) a triad. Bounds: 1e-12·s in `f64`; 2⁻¹⁸·s in `f32`, in
//! which every input is rounded to `f32` on its way in (the bound is 64 roundings).
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use common::models;
use common::random::{self, Rng, inside, random_model, truth_within};
use sagnac_core::{Compensation, Measurement, Real, Sensor, SensorModel, Truth, flags};

fn to<T: Real>(truth: &Truth<f64>) -> Truth<T> {
    let v = |v: [f64; 3]| v.map(T::from_f64);
    Truth {
        specific_force: v(truth.specific_force),
        angular_rate: v(truth.angular_rate),
        angular_acceleration: v(truth.angular_acceleration),
        temperature_c: T::from_f64(truth.temperature_c),
    }
}

/// The largest error of both triads in units of the allowed one, for truths given in `f64`.
fn worst<T: Real>(model: &SensorModel<f64>, truths: &[Truth<f64>], allowed: f64) -> (f64, u32) {
    let model = model.convert::<T>();
    let forward = Measurement::new(&model);
    let inverse = Compensation::new(&model, T::from_f64(0.01)).unwrap();
    let (mut worst, mut all_flags) = (0.0_f64, 0);
    for truth in truths {
        let truth = to::<T>(truth);
        let raw = forward.corrupt(&truth);
        let back = inverse.correct(&raw);
        all_flags |= back.flags;
        for (sensor, u, y, x) in [
            (Sensor::Gyro, truth.angular_rate, raw.gyro, back.gyro),
            (Sensor::Accel, truth.specific_force, raw.accel, back.accel),
        ] {
            let b = forward.errors(sensor).bias(truth.temperature_c);
            let size = |v: [T; 3]| v.iter().fold(0.0_f64, |m, x| m.max(x.to_f64().abs()));
            let s = size(u).max(size(y)).max(size(b));
            for k in 0..3 {
                let error = (x[k].to_f64() - u[k].to_f64()).abs();
                worst = worst.max(if s > 0.0 {
                    error / (s * allowed)
                } else {
                    error
                });
                assert!(error.is_finite());
            }
        }
    }
    (worst, all_flags)
}

#[test]
fn ten_thousand_models_inside_the_bound_come_back() {
    let mut rng = Rng::new(1);
    let (mut found, mut tried, mut q_max) = (0, 0, 0.0_f64);
    let (mut worst64, mut worst32) = (0.0_f64, 0.0_f64);
    while found < 10_000 {
        tried += 1;
        let model = random_model(&mut rng);
        if !inside(&model) {
            continue;
        }
        found += 1;
        let bound = *Compensation::new(&model, 0.01).unwrap().bound().unwrap();
        q_max = q_max.max(bound.q);
        let truths: Vec<_> = (0..20).map(|_| truth_within(&mut rng, &model)).collect();
        let (e64, f64_flags) = worst::<f64>(&model, &truths, 1e-12);
        assert!(e64 <= 1.0, "f64: {e64} of the bound, q = {}", bound.q);
        assert_eq!(f64_flags, 0);
        let (e32, _) = worst::<f32>(&model, &truths, 2.0_f64.powi(-18));
        assert!(e32 <= 1.0, "f32: {e32} of the bound, q = {}", bound.q);
        worst64 = worst64.max(e64);
        worst32 = worst32.max(e32);
    }
    println!(
        "10 000 models of {tried} drawn, q up to {q_max:.3}: {:.1e} s in f64, {:.1} of 64 roundings in f32",
        worst64 * 1e-12,
        worst32 * 64.0
    );
    assert!(q_max > 0.2, "the draw must reach the bound");
}

#[test]
fn consumer_parts_at_2000_degrees_a_second_come_back() {
    let model = models::consumer();
    let inverse = Compensation::new(&model, 0.01).unwrap();
    let bound = inverse.bound().unwrap();
    assert!(bound.is_inside());
    assert!((bound.q - 0.12).abs() < 0.005 && inverse.rounds() == 16);
    for s in 0..2 {
        assert!((bound.mu[s] + bound.nu[s] - 0.18).abs() < 0.01);
    }
    let mut rng = Rng::new(2);
    let truths: Vec<_> = (0..20_000)
        .map(|_| truth_within(&mut rng, &model))
        .collect();
    assert!(worst::<f64>(&model, &truths, 1e-12).0 <= 1.0);
    assert!(worst::<f32>(&model, &truths, 2.0_f64.powi(-18)).0 <= 1.0);
}

#[test]
fn outside_the_bound_every_sample_is_flagged_or_the_model_refused() {
    let mut rng = Rng::new(3);
    let (mut outside, mut refused) = (0, 0);
    while outside < 1_000 {
        let model = random::wild_model(&mut rng);
        match Compensation::new(&model, 0.01) {
            Err(_) => refused += 1,
            Ok(inverse) => {
                if inverse.bound().unwrap().is_inside() {
                    continue;
                }
                outside += 1;
                let truth = truth_within(&mut rng, &model);
                let raw = Measurement::new(&model).corrupt(&truth);
                let flagged = inverse.correct(&raw).flags;
                assert_ne!(flagged & flags::OUTSIDE_VALIDITY, 0);
            }
        }
    }
    assert!(refused > 10, "some are as large as the signal");
}

#[test]
fn without_a_range_each_sample_is_judged_by_itself() {
    let mut model = models::consumer();
    model.gyro.range.limit = [f64::INFINITY; 3];
    model.accel.range.limit = [f64::INFINITY; 3];
    let inverse = Compensation::new(&model, 0.01).unwrap();
    let forward = Measurement::new(&model);
    let mut rng = Rng::new(4);
    let (mut clear, mut flagged) = (0, 0);
    for _ in 0..20_000 {
        let size = 10.0_f64.powf(rng.uniform(-2.0, 2.5));
        let mut v = |size: f64| [0; 3].map(|_| rng.uniform(-size, size));
        let truth = Truth {
            specific_force: v(size * 5.0),
            angular_rate: v(size),
            angular_acceleration: v(size),
            temperature_c: 25.0,
        };
        let raw = forward.corrupt(&truth);
        let back = inverse.correct(&raw);
        if back.flags & flags::OUTSIDE_VALIDITY != 0 {
            flagged += 1;
            continue;
        }
        clear += 1;
        for (u, y, x) in [
            (truth.angular_rate, raw.gyro, back.gyro),
            (truth.specific_force, raw.accel, back.accel),
        ] {
            let s = u.iter().chain(&y).fold(0.0_f64, |m, x| m.max(x.abs()));
            for k in 0..3 {
                assert!((x[k] - u[k]).abs() <= 1e-12 * s, "{truth:?}");
            }
        }
    }
    assert!(clear > 1_000 && flagged > 1_000, "{clear} {flagged}");
}
