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

/// The error at the end of one run, made sample by sample as `simulate`, `correct` and `strapdown` make it: no blocks, no
/// lanes, all terms of an axis from one generator.
fn run_alone(request: &Request<'_>, run: u32) -> [f64; 3] {
    use sagnac_core::{
        Draw, Element, Measurement, OffDiagonal, OutputStage, Reading, SensorModel, Truth,
    };
    use sagnac_noise::{AxisGenerator, Purpose, StreamKey, TermSet};
    let (sensor, setting) = (request.sensor, request.setting);
    let (dt, seed) = (setting.dt_s, request.seed);
    let key = |sensor: usize, axis: usize| StreamKey {
        seed,
        run,
        sensor: sensor as u8,
        axis: axis as u8,
    };
    let draw = |s: usize| Draw {
        bias: std::array::from_fn(|a| {
            sensor.bias_stability[s][a] * key(s, a).draw(Purpose::BiasDraw, 0)
        }),
        scale_factor: std::array::from_fn(|a| {
            sensor.scale_factor_stability[s][a] * key(s, a).draw(Purpose::ScaleFactorDraw, 0)
        }),
        misalignment: OffDiagonal::from_array(std::array::from_fn(|e| {
            let element = Element::ALL[e];
            sensor.misalignment_stability[s][e]
                * key(s, element.row().index())
                    .draw(Purpose::MisalignmentDraw, element.column().index() as u32)
        })),
    };
    let model: SensorModel<f64> = sensor.model.with_draws(&draw(0), &draw(1));
    let forward = Measurement::new(&model);
    let correct = Compensation::new(&sensor.model, dt).unwrap();
    let mut stages = [
        OutputStage::new(&model.gyro, dt, [0.0; 3]),
        OutputStage::new(&model.accel, dt, [0.0; 3]),
    ];
    let mut noise: Vec<AxisGenerator> = (0..6)
        .map(|c| {
            let of = &sensor.noise[c / 3][c % 3];
            AxisGenerator::new(of, TermSet::ALL, dt, setting.duration_s, key(c / 3, c % 3)).unwrap()
        })
        .collect();
    let trajectory = request.trajectory;
    let start: State = trajectory.at(0.0).into();
    let new = || {
        Strapdown::<1>::new(
            trajectory.earth(),
            request.sculling,
            setting.vertical,
            [start],
        )
    };
    let (mut nav, mut clean) = (new(), new());
    for s in trajectory
        .samples(dt)
        .take((setting.duration_s / dt).round() as usize)
    {
        let mut reading: Reading<f64> = forward.corrupt(&Truth {
            specific_force: s.force_m_s2,
            angular_rate: s.rate_rad_s,
            angular_acceleration: s.rate_dot_rad_s2,
            temperature_c: 25.0,
        });
        let mut value = [0.0];
        for (c, generator) in noise.iter_mut().enumerate() {
            generator.fill(&mut value, None);
            let triad = if c < 3 {
                &mut reading.gyro
            } else {
                &mut reading.accel
            };
            triad[c % 3] += value[0];
        }
        reading.gyro = stages[0].next_sample(reading.gyro);
        reading.accel = stages[1].next_sample(reading.accel);
        let corrected = correct.correct(&reading);
        let one = |v: [f64; 3]| v.map(|x| [x]);
        let truth = [s.height_m, s.climb_m_s];
        nav.push(dt, &one(corrected.gyro), &one(corrected.accel), truth);
        clean.push(dt, &one(s.rate_rad_s), &one(s.force_m_s2), truth);
    }
    nav.finish();
    clean.finish();
    let e_from_n = trajectory.at(setting.duration_s).place.e_from_n();
    mul_vec_t(
        &e_from_n,
        sub(nav.state(0).position_e, clean.state(0).position_e),
    )
}

#[test]
fn a_run_in_lanes_is_the_run_that_the_commands_make() {
    let mut sensor = sensor();
    let degree = std::f64::consts::PI / 180.0;
    sensor.model.gyro.bias.fixed = [0.01, -0.02, 0.005];
    sensor.model.gyro.scale_factor.fixed = [1e-3, -2e-3, 5e-4];
    sensor.model.gyro_g_sensitivity.matrix =
        [[1e-4, 2e-5, 0.0], [0.0, 1e-4, 0.0], [3e-5, 0.0, 1e-4]];
    sensor.model.gyro.range.limit = [300.0 * degree; 3];
    sensor.model.accel.scale_factor.fixed = [2e-3, 1e-3, -1e-3];
    sensor.model.accel.nonlinearity.quadratic = [1e-5; 3];
    sensor.model.accel.range.limit = [80.0; 3];
    for (output, lsb) in [
        (sagnac_core::Output::Rate, 1e-4),
        (sagnac_core::Output::Increment, 1e-5),
    ] {
        sensor.model.gyro.resolution.output = output;
        sensor.model.gyro.resolution.lsb = [lsb * degree; 3];
        sensor.model.accel.resolution.lsb = [1e-3; 3];
        for name in ["drive", "walking"] {
            let trajectory = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
            let request = Request {
                trajectory: &trajectory,
                setting: setting(60.0, Alignment::Perfect),
                sculling: Sculling::Five,
                sensor: &sensor,
                runs: 11,
                seed: 11,
            };
            let found = monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap();
            for run in [1, 6, 11] {
                let want = run_alone(&request, run);
                let got = found.errors[59][run as usize - 1];
                // Terms are summed in another order, an ulp of 10 m/s²; a sample that this moves over the edge of a count
                // of 1e-3 m/s² moves the position by 1e-3 · 0.02 s · 60 s.
                for i in 0..3 {
                    assert!(
                        (got[i] - want[i]).abs() < 2e-3 + 1e-6 * want[i].abs(),
                        "{name} {run}: {got:?} {want:?}"
                    );
                }
                assert!(want[0].hypot(want[1]) > 0.1, "{want:?}");
            }
        }
    }
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
