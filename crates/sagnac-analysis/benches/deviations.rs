//! Speed of the deviations: 10⁷ samples of white noise, the default grid of 94 averaging times.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sagnac_analysis::deviation::deviations_alone;
use sagnac_analysis::{Deviation, TauGrid, deviations};

const SAMPLES: usize = 10_000_000;

fn white(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    (0..count)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
        .collect()
}

fn bench(criterion: &mut Criterion) {
    let samples = white(SAMPLES);
    let mut group = criterion.benchmark_group("deviations of 1e7 samples");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(SAMPLES as u64));
    for kind in [
        Deviation::Oadev,
        Deviation::Hdev,
        Deviation::Mdev,
        Deviation::Totdev,
    ] {
        let factors = TauGrid::Default.factors(kind, SAMPLES, 0.01);
        group.bench_function(format!("{} alone", kind.name()), |b| {
            b.iter(|| deviations_alone(&[black_box(&samples)], 0.01, kind, &factors));
        });
    }
    group.bench_function("oadev with noise types and intervals", |b| {
        b.iter(|| {
            deviations(
                &[black_box(&samples)],
                0.01,
                Deviation::Oadev,
                &TauGrid::Default,
            )
        });
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
