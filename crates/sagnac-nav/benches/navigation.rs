//! A strapdown step, the Monte Carlo of 100 runs × 1 h at 100 Hz, and the covariance with 60 states over 1 h of flight.
//!
//! `cargo bench -p sagnac-nav`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "criterion's macros write undocumented functions; a benchmark may stop"
)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sagnac_nav::drift::{Alignment, Scene, Setting};
use sagnac_nav::monte_carlo::{Request, monte_carlo};
use sagnac_nav::sensor::{Calibration, SensorErrors};
use sagnac_nav::strapdown::{LaneSample, Sculling, Strapdown, Vertical};
use sagnac_nav::{Earth, Start, Trajectory};
use sagnac_noise::{AxisNoise, Flicker, GaussMarkov, RandomWalk, White};

const DEG_H: f64 = std::f64::consts::PI / 648_000.0;
const MICRO_G: f64 = 9.806_65e-6;

fn trajectory(name: &str) -> Trajectory {
    Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap()
}

/// Steps of one run, and of eight in the lanes of a vector: nanoseconds a step and run.
fn strapdown(c: &mut Criterion) {
    const STEPS: usize = 20_000;
    let flight = trajectory("flight");
    let dt = 0.01;
    let samples: Vec<_> = flight.samples(dt).take(STEPS).collect();
    let truth: Vec<[f64; 2]> = samples.iter().map(|s| [s.height_m, s.climb_m_s]).collect();
    let lanes = |of: usize, s: &sagnac_nav::trajectory::TruthSample| {
        let v = if of < 3 { s.rate_rad_s } else { s.force_m_s2 };
        v[of % 3]
    };
    let one: Vec<LaneSample<1>> = samples
        .iter()
        .map(|s| std::array::from_fn(|k| [lanes(k, s)]))
        .collect();
    let eight: Vec<LaneSample<8>> = samples
        .iter()
        .map(|s| std::array::from_fn(|k| [lanes(k, s); 8]))
        .collect();
    let mut group = c.benchmark_group("strapdown");
    for (name, sculling) in [("five", Sculling::Five), ("two", Sculling::Two)] {
        group.throughput(Throughput::Elements(STEPS as u64));
        group.bench_function(format!("one run, {name}"), |b| {
            b.iter(|| {
                let start = [flight.at(0.0).into()];
                let mut nav = Strapdown::<1>::new(Earth::Wgs84, sculling, Vertical::Free, start);
                nav.feed_block(dt, &one, &truth);
                nav.finish();
                nav.state(0)
            });
        });
        group.throughput(Throughput::Elements(8 * STEPS as u64));
        group.bench_function(format!("eight runs, {name}"), |b| {
            b.iter(|| {
                let start = [flight.at(0.0).into(); 8];
                let mut nav = Strapdown::<8>::new(Earth::Wgs84, sculling, Vertical::Fixed, start);
                nav.feed_block(dt, &eight, &truth);
                nav.finish();
                nav.state(7)
            });
        });
    }
    group.finish();
}

fn setting(dt_s: f64) -> Setting {
    Setting {
        duration_s: 3600.0,
        dt_s,
        vertical: Vertical::Fixed,
        alignment: Alignment::Perfect,
        calibration: Calibration::Model,
    }
}

/// White noise alone, or with flicker, run-to-run bias and scale factor.
fn sensor(all: bool) -> SensorErrors {
    let mut out = SensorErrors::default();
    for a in 0..3 {
        for (s, white, flicker) in [(0, 0.15 * DEG_H * 60.0, 0.5 * DEG_H), (1, 1e-3, 5e-4)] {
            out.noise[s][a] = AxisNoise {
                white: White { density: white },
                flicker: Flicker {
                    coefficient: if all { flicker } else { 0.0 },
                },
                ..AxisNoise::default()
            };
        }
        out.bias_stability[0][a] = 4.0 * DEG_H;
        out.bias_stability[1][a] = 750.0 * MICRO_G;
        if all {
            out.scale_factor_stability[0][a] = 5e-4;
            out.scale_factor_stability[1][a] = 3e-4;
        }
    }
    out
}

/// 100 runs × 1 h at 100 Hz: 36 million samples of the whole chain.
fn runs(c: &mut Criterion) {
    let drive = trajectory("drive");
    let mut group = c.benchmark_group("monte carlo");
    group.sample_size(10);
    group.throughput(Throughput::Elements(36_000_000));
    for (name, all) in [("white and bias", false), ("flicker as well", true)] {
        let sensor = sensor(all);
        group.bench_function(format!("100 runs, 1 h, 100 Hz, {name}"), |b| {
            b.iter(|| {
                let request = Request {
                    trajectory: &drive,
                    setting: setting(0.01),
                    sculling: Sculling::Five,
                    sensor: &sensor,
                    runs: 100,
                    seed: 1,
                };
                monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap()
            });
        });
    }
    group.finish();
}

/// Nine error states, six flicker ladders of seven, three Gauss–Markov processes, six walks: 60 states, and the constants.
fn covariance(c: &mut Criterion) {
    let flight = trajectory("flight");
    let mut sensor = sensor(true);
    for a in 0..3 {
        sensor.noise[0][a].gauss_markov = vec![GaussMarkov {
            sigma: DEG_H,
            correlation_time_s: 300.0,
        }];
        for (s, k) in [(0, 0.1 * DEG_H / 60.0), (1, 1e-6)] {
            sensor.noise[s][a].random_walk = RandomWalk { coefficient: k };
        }
    }
    let mut group = c.benchmark_group("covariance");
    group.sample_size(10);
    group.bench_function("60 states, 1 h of flight", |b| {
        b.iter(|| {
            Scene::new(&flight, setting(0.01), &|_| 25.0)
                .unwrap()
                .covariance(&sensor)
                .unwrap()
        });
    });
    group.finish();
}

criterion_group!(benches, strapdown, runs, covariance);
criterion_main!(benches);
