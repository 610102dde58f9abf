//! Samples a second and core through the model and its inverse, in memory.
//!
//! `cargo bench -p sagnac-core --features simd`
#![allow(
    missing_docs,
    reason = "criterion's macros write undocumented functions"
)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sagnac_core::{
    Compensation, CorrectedBlock, Measurement, OutputBlock, ReadingBlock, Real, SensorModel,
    TruthBlock,
};

#[path = "../tests/common/models.rs"]
mod models;

const BLOCK: usize = 4096;

struct Channels<T> {
    w: [Vec<T>; 3],
    f: [Vec<T>; 3],
    wdot: [Vec<T>; 3],
    t: Vec<T>,
}

/// How the temperature goes through a block.
#[derive(Clone, Copy)]
enum Temperature {
    /// The same in all samples, as between two steps of a thermometer.
    Held,
    /// Another in every sample.
    Moving,
}

fn motion<T: Real>(temperature: Temperature) -> Channels<T> {
    let wave = |size: f64, rate: f64| -> Vec<T> {
        (0..BLOCK)
            .map(|i| T::from_f64(size * libm::sin(rate * i as f64)))
            .collect()
    };
    Channels {
        w: [wave(3.0, 0.01), wave(2.0, 0.013), wave(1.0, 0.017)],
        f: [wave(5.0, 0.011), wave(8.0, 0.007), wave(9.0, 0.003)],
        wdot: [wave(1.0, 0.01), wave(2.0, 0.02), wave(3.0, 0.03)],
        t: match temperature {
            Temperature::Held => vec![T::from_f64(31.5); BLOCK],
            Temperature::Moving => wave(20.0, 0.001),
        },
    }
}

fn three<T>(v: &[Vec<T>; 3]) -> [&[T]; 3] {
    [&v[0], &v[1], &v[2]]
}

fn run<T: Real>(c: &mut Criterion, name: &str, model: &SensorModel<f64>, of: Temperature) {
    let model = model.convert::<T>();
    let forward = Measurement::new(&model);
    let Ok(inverse) = Compensation::new(&model, T::from_f64(0.005)) else {
        return;
    };
    let input = motion::<T>(of);
    let (mut g, mut a) = (
        [0; 3].map(|_| vec![T::ZERO; BLOCK]),
        [0; 3].map(|_| vec![T::ZERO; BLOCK]),
    );
    let mut flags = vec![0; BLOCK];
    let mut group = c.benchmark_group("core");
    group.throughput(Throughput::Elements(BLOCK as u64));
    let label = format!(
        "{name} n={} {} {}",
        inverse.rounds(),
        match of {
            Temperature::Held => "held",
            Temperature::Moving => "moving",
        },
        core::any::type_name::<T>()
    );
    group.bench_function(BenchmarkId::new("correct", &label), |b| {
        b.iter(|| {
            let ([gx, gy, gz], [ax, ay, az]) = (&mut g, &mut a);
            inverse.correct_block(
                &ReadingBlock {
                    gyro: three(&input.w),
                    accel: three(&input.f),
                    gyro_rate: Some(three(&input.wdot)),
                    temperature_c: Some(&input.t),
                },
                &mut CorrectedBlock {
                    gyro: [gx, gy, gz],
                    accel: [ax, ay, az],
                    flags: &mut flags,
                },
            )
        });
    });
    group.bench_function(BenchmarkId::new("corrupt", &label), |b| {
        b.iter(|| {
            let ([gx, gy, gz], [ax, ay, az]) = (&mut g, &mut a);
            forward.corrupt_block(
                &TruthBlock {
                    specific_force: three(&input.f),
                    angular_rate: three(&input.w),
                    angular_acceleration: Some(three(&input.wdot)),
                    temperature_c: Some(&input.t),
                },
                &mut OutputBlock {
                    gyro: [gx, gy, gz],
                    accel: [ax, ay, az],
                },
            )
        });
    });
    group.finish();
}

fn all(c: &mut Criterion) {
    for of in [Temperature::Held, Temperature::Moving] {
        run::<f64>(c, "example", &models::example(), of);
        run::<f32>(c, "example", &models::example(), of);
    }
    run::<f64>(c, "consumer", &models::consumer(), Temperature::Held);
    run::<f32>(c, "consumer", &models::consumer(), Temperature::Held);
}

criterion_group!(benches, all);
criterion_main!(benches);
