//! Samples a second and core of `simulate`, six axes, to memory: white noise, flicker, random walk,
//! Gauss–Markov and every deterministic term.
//!
//! `taskset -c 0 cargo bench -p sagnac --bench simulate`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "criterion's macros make public functions; a benchmark may stop"
)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sagnac::log::{Block, LogWriter};
use sagnac::model::Model;
use sagnac::nav::{Earth, Start, Trajectory};
use sagnac::noise::TermSet;
use sagnac::simulate::{MotionSource, SimulateRequest, Sinks, simulate};

const SAMPLES: u64 = 720_000;

const MODEL: &str = r#"name = "Bench"
sample_rate = "100 Hz"
temperature_range = ["-20 degC", "70 degC"]
[gyro]
range = "450 deg/s"
[gyro.bias]
fixed = ["12 deg/h", "-5 deg/h", "3 deg/h"]
temperature = [["0.4 deg/h/K", "-0.2 deg/h/K", "0.1 deg/h/K"]]
stability = "20 deg/h"
[gyro.bias.instability]
coefficient = "8 deg/h"
[gyro.scale_factor]
fixed = ["300 ppm", "-150 ppm", "80 ppm"]
temperature = [["10 ppm/K", "10 ppm/K", "10 ppm/K"]]
quadratic = "1e-5 s/rad"
cubic = "1e-5 s^2/rad^2"
asymmetry = "10 ppm"
[gyro.misalignment]
fixed = { xy = "0.5 mrad", xz = "-0.3 mrad", yx = "0.2 mrad", yz = "0.1 mrad", zx = "-0.4 mrad", zy = "0.6 mrad" }
[gyro.g_sensitivity]
matrix = [["10 deg/h/g", "1 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "10 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "0 deg/h/g", "10 deg/h/g"]]
[gyro.noise]
angle_random_walk = "0.3 deg/sqrt(h)"
rate_random_walk = "1.5 deg/h/sqrt(h)"
gauss_markov = [{ sigma = "3 deg/h", correlation_time = "300 s" }]
[accel]
range = "10 g"
[accel.bias]
fixed = ["1.2 mg", "-0.8 mg", "2.1 mg"]
temperature = [["0.05 mg/K", "0.02 mg/K", "-0.08 mg/K"]]
[accel.bias.instability]
coefficient = "20 ug"
[accel.scale_factor]
fixed = ["400 ppm", "-200 ppm", "350 ppm"]
quadratic = "1e-6 1/g"
[accel.axis_offset]
x = ["10 mm", "0 mm", "0 mm"]
y = ["0 mm", "10 mm", "0 mm"]
z = ["0 mm", "0 mm", "10 mm"]
[accel.noise]
velocity_random_walk = "0.05 m/s/sqrt(h)"
acceleration_random_walk = "50 ug/sqrt(h)"
gauss_markov = [{ sigma = "10 ug", correlation_time = "300 s" }]
"#;

/// Takes what is written and keeps the last block.
struct Memory(Vec<Vec<f64>>);

impl LogWriter for Memory {
    fn write_block(&mut self, block: &Block) -> Result<(), sagnac::log::Error> {
        self.0.resize(block.columns.len(), Vec::new());
        for (kept, column) in self.0.iter_mut().zip(&block.columns) {
            kept.clear();
            kept.extend_from_slice(column);
        }
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<Vec<String>, sagnac::log::Error> {
        black_box(&self.0);
        Ok(Vec::new())
    }
}

fn bench(c: &mut Criterion) {
    let model = Model::parse(MODEL, "bench.toml").unwrap();
    let start = Start::default();
    let trajectory = Trajectory::named("rest", Earth::Wgs84, &start).unwrap();
    let mut group = c.benchmark_group("simulate");
    group
        .sample_size(20)
        .throughput(Throughput::Elements(SAMPLES));
    group.bench_function("rest, six axes, four random terms each", |b| {
        b.iter(|| {
            let request = SimulateRequest {
                model: &model,
                motion: MotionSource::Trajectory {
                    trajectory: &trajectory,
                    start,
                    duration_s: SAMPLES as f64 / 100.0,
                },
                rate_hz: None,
                terms: TermSet::ALL,
                seed: 1,
                runs: 1,
                temperature: None,
                with_truth: false,
            };
            simulate(
                request,
                &mut |_, _| {
                    Ok(Sinks {
                        log: Box::new(Memory(Vec::new())),
                        truth: None,
                    })
                },
                &mut |_, _| {},
            )
            .unwrap()
            .samples
        });
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
