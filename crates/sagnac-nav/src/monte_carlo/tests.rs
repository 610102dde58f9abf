//! Both methods agree, threads change no bit, and a self-alignment is what the covariance says.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;
use crate::drift::Alignment;
use crate::drift::Scene;
use crate::earth::Earth;
use crate::sensor::SensorErrors;
use crate::strapdown::Vertical;
use crate::trajectory::Start;
use sagnac_noise::{AxisNoise, Flicker, GaussMarkov, RandomWalk, White};

fn sensor() -> SensorErrors {
    let deg_h = std::f64::consts::PI / 648_000.0;
    let mut out = SensorErrors::default();
    for a in 0..3 {
        out.noise[0][a] = AxisNoise {
            white: White {
                density: 0.3 * deg_h * 60.0,
            },
            flicker: Flicker {
                coefficient: 8.0 * deg_h,
            },
            random_walk: RandomWalk {
                coefficient: 1.5 * deg_h / 60.0,
            },
            gauss_markov: vec![GaussMarkov {
                sigma: 3.0 * deg_h,
                correlation_time_s: 300.0,
            }],
            ..AxisNoise::default()
        };
        out.noise[1][a] = AxisNoise {
            white: White { density: 1e-3 },
            flicker: Flicker { coefficient: 4e-4 },
            ..AxisNoise::default()
        };
        out.bias_stability[0][a] = 5.0 * deg_h;
        out.bias_stability[1][a] = 2e-3;
        out.scale_factor_stability[0][a] = 1e-4;
        out.scale_factor_stability[1][a] = 3e-4;
    }
    out.misalignment_stability = [[5e-5; 6]; 2];
    out
}

fn setting(duration_s: f64, alignment: Alignment) -> Setting {
    Setting {
        duration_s,
        dt_s: 0.02,
        vertical: Vertical::Fixed,
        alignment,
        calibration: Calibration::Model,
    }
}

#[test]
fn both_methods_agree() {
    let given = Alignment::Given {
        roll_rad: 1e-3,
        pitch_rad: 1e-3,
        heading_rad: 1e-2,
    };
    for (name, alignment) in [
        ("rest", Alignment::Perfect),
        ("drive", given),
        ("flight", Alignment::Perfect),
        ("walking", Alignment::Perfect),
    ] {
        let trajectory = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
        let setting = setting(600.0, alignment);
        let sensor = sensor();
        let scene = Scene::new(&trajectory, setting, &|_| 25.0).unwrap();
        let linear = scene.covariance(&sensor).unwrap();
        let request = Request {
            trajectory: &trajectory,
            setting,
            sculling: Sculling::Five,
            sensor: &sensor,
            runs: 200,
            seed: 1,
        };
        let found = monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap();
        let (rms, cep) = (found.rms(3.29)[59], found.cep(0.0005)[59]);
        // The 99.9 % intervals of navigation.md §3.1.
        let within = |x: f64, s: Sampled| {
            s.interval_m[0].is_none_or(|l| x >= l) && s.interval_m[1].is_none_or(|u| x <= u)
        };
        assert!(
            within(linear.rms_m()[59], rms),
            "{name} rms {} {rms:?}",
            linear.rms_m()[59]
        );
        assert!(
            within(linear.cep_m()[59], cep),
            "{name} cep {} {cep:?}",
            linear.cep_m()[59]
        );
        assert!((linear.budget.iter().map(|e| e.share).sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let trajectory = Trajectory::named("drive", Earth::Wgs84, &Start::default()).unwrap();
    let setting = setting(20.0, Alignment::Perfect);
    let sensor = sensor();
    let request = Request {
        trajectory: &trajectory,
        setting,
        sculling: Sculling::Five,
        sensor: &sensor,
        runs: 19,
        seed: 7,
    };
    let run = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap())
    };
    assert_eq!(run(1), run(3));
    let fewer = monte_carlo(&Request { runs: 5, ..request }, &|_| 25.0, &mut |_, _| {}).unwrap();
    assert_eq!(fewer.errors[59][..5], run(2).errors[59][..5]);
    assert!(monte_carlo(&Request { runs: 0, ..request }, &|_| 25.0, &mut |_, _| {}).is_err());
}

#[test]
fn self_alignment_agrees_at_navigation_grade() {
    let deg_h = std::f64::consts::PI / 648_000.0;
    let mut sensor = SensorErrors::default();
    for a in 0..3 {
        sensor.noise[0][a].flicker.coefficient = 0.01 * deg_h;
        sensor.noise[0][a].white.density = 0.002 * deg_h * 60.0;
        sensor.bias_stability[0][a] = 0.01 * deg_h;
        sensor.bias_stability[1][a] = 5e-4;
    }
    let trajectory = Trajectory::named("rest", Earth::Wgs84, &Start::default()).unwrap();
    let setting = Setting {
        dt_s: 0.1,
        ..setting(3600.0, Alignment::SelfAligned)
    };
    let linear = Scene::new(&trajectory, setting, &|_| 25.0)
        .unwrap()
        .covariance(&sensor)
        .unwrap();
    let request = Request {
        trajectory: &trajectory,
        setting,
        sculling: Sculling::Five,
        sensor: &sensor,
        runs: 400,
        seed: 1,
    };
    let found = monte_carlo(&request, &|_| 25.0, &mut |_, _| {})
        .unwrap()
        .rms(3.29)[59];
    let x = linear.rms_m()[59];
    assert!(
        found.interval_m[0].is_none_or(|l| x >= l) && found.interval_m[1].is_none_or(|u| x <= u),
        "{x} {found:?}"
    );
}
