//! Speed of the gaussian source and of each term's generator.
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sagnac_noise::{
    AxisGenerator, AxisNoise, Flicker, GaussMarkov, Normals, Purpose, RandomWalk, StreamKey,
    TermSet, White,
};

fn gaussian(c: &mut Criterion) {
    let key = StreamKey {
        seed: 1,
        run: 1,
        sensor: 0,
        axis: 0,
    };
    let mut group = c.benchmark_group("gaussian");
    let mut out = vec![0.0; 4096];
    group.throughput(Throughput::Elements(out.len() as u64));
    group.bench_function("normal", |b| {
        let mut normals = Normals::new(key.stream(Purpose::White, 0));
        b.iter(|| normals.fill(black_box(&mut out)));
    });
    group.finish();
}

/// One axis at 100 Hz for 2 h: each term, and the four of the model of `simulate`'s benchmark.
fn terms(c: &mut Criterion) {
    let key = StreamKey {
        seed: 1,
        run: 1,
        sensor: 0,
        axis: 0,
    };
    let white = White { density: 1.0 };
    let flicker = Flicker { coefficient: 1.0 };
    let random_walk = RandomWalk { coefficient: 1.0 };
    let gauss_markov = vec![GaussMarkov {
        sigma: 1.0,
        correlation_time_s: 300.0,
    }];
    let none = AxisNoise::default;
    let mut group = c.benchmark_group("axis");
    let mut out = vec![0.0; 4096];
    group.throughput(Throughput::Elements(out.len() as u64));
    for (name, noise) in [
        ("white", AxisNoise { white, ..none() }),
        ("flicker", AxisNoise { flicker, ..none() }),
        (
            "random walk",
            AxisNoise {
                random_walk,
                ..none()
            },
        ),
        (
            "Gauss-Markov",
            AxisNoise {
                gauss_markov: gauss_markov.clone(),
                ..none()
            },
        ),
        (
            "all four",
            AxisNoise {
                white,
                flicker,
                random_walk,
                gauss_markov,
                ..none()
            },
        ),
    ] {
        let Ok(mut axis) = AxisGenerator::new(&noise, TermSet::ALL, 0.01, 7200.0, key) else {
            return;
        };
        group.bench_function(name, |b| b.iter(|| axis.fill(black_box(&mut out), None)));
    }
    group.finish();
}

criterion_group!(benches, gaussian, terms);
criterion_main!(benches);
