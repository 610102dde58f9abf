//! Speed of the gaussian source and of each term's generator.
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sagnac_noise::{Normals, Purpose, StreamKey};

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

criterion_group!(benches, gaussian);
criterion_main!(benches);
