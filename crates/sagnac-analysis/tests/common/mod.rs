//! What the tests share.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use sagnac_analysis::fit::{AxisData, AxisEstimate, FitOptions, Segment, estimate};
use std::path::{Path, PathBuf};

/// The estimate of an axis of segments, without temperature and steps of values.
pub(crate) fn estimate_of(segments: &[Segment<'_>], step_s: f64) -> AxisEstimate {
    estimate_with(segments, step_s, &FitOptions::default())
}

fn estimate_with(segments: &[Segment<'_>], step_s: f64, options: &FitOptions) -> AxisEstimate {
    let data = AxisData {
        segments,
        temperature: None,
        step_s,
        lsb: None,
    };
    estimate(&data, options)
}

/// The same of one stretch of samples.
pub(crate) fn estimate_of_samples(samples: &[f64], step_s: f64) -> AxisEstimate {
    estimate_of_samples_with(samples, step_s, &FitOptions::default())
}

/// The same with these options.
pub(crate) fn estimate_of_samples_with(
    samples: &[f64],
    step_s: f64,
    options: &FitOptions,
) -> AxisEstimate {
    let whole = Segment {
        start_s: 0.0,
        samples,
        filled: &[],
    };
    estimate_with(&[whole], step_s, options)
}

/// Sum of four uniform numbers: Gaussian enough, variance 1.
pub(crate) fn noise(seed: &mut u64) -> f64 {
    let sum = (0..4).fold(-2.0, |sum, _| {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        sum + (*seed >> 11) as f64 / (1_u64 << 53) as f64
    });
    sum * 3_f64.sqrt()
}

/// Adds a Gauss–Markov process, averaged over each sample, from its stationary law on.
pub(crate) fn add_process(
    samples: &mut [f64],
    step_s: f64,
    (sigma, time_s): (f64, f64),
    seed: &mut u64,
) {
    let h = step_s / time_s;
    let phi = (-h).exp();
    let end = 1.0 - phi * phi;
    let mean = if h < 0.01 {
        2.0 * h / 3.0 - h * h / 2.0 + 7.0 * h.powi(3) / 30.0
    } else {
        (2.0 * h - 3.0 + 4.0 * phi - phi * phi) / (h * h)
    };
    let both = (1.0 - phi).powi(2) / h;
    let rest = (mean - both * both / end).max(0.0).sqrt();
    let mut x = noise(seed);
    for y in samples {
        let kick = end.sqrt() * noise(seed);
        *y += sigma * (x * (1.0 - phi) / h + both / end * kick + rest * noise(seed));
        x = phi * x + kick;
    }
}

/// The generator of SP 1065: n_{i+1} = 16807·n_i mod 2147483647, y_i = n_i/2147483647.
pub(crate) fn generator(count: usize) -> Vec<f64> {
    let mut n: u64 = 1_234_567_890;
    (0..count)
        .map(|_| {
            let value = n as f64 / 2_147_483_647.0;
            n = 16_807 * n % 2_147_483_647;
            value
        })
        .collect()
}

/// Running sums.
pub(crate) fn cumulative(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .scan(0.0, |total, value| {
            *total += value;
            Some(*total)
        })
        .collect()
}

/// First differences, the first from zero.
pub(crate) fn differences(values: &[f64]) -> Vec<f64> {
    let mut before = 0.0;
    values
        .iter()
        .map(|&value| {
            let difference = value - before;
            before = value;
            difference
        })
        .collect()
}

/// A file of the recorded data, if it is there: `SAGNAC_DATA` or ../shared/data.
pub(crate) fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SAGNAC_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!(
        "skipped: no {name} in {} (set SAGNAC_DATA)",
        folder.display()
    );
    None
}

/// The numbers of a file, comment lines left out.
pub(crate) fn numbers(path: &Path) -> Vec<f64> {
    std::fs::read_to_string(path)
        .unwrap()
        .lines()
        .filter(|line| !line.trim_start().starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(|cell| cell.parse().unwrap())
        .collect()
}

/// Panics unless `got` is within `relative` of `want`.
pub(crate) fn assert_rel(got: f64, want: f64, relative: f64, what: &str) {
    assert!(
        (got - want).abs() <= relative * want.abs(),
        "{what}: {got:e} for {want:e}, off by {:e}",
        (got / want - 1.0).abs()
    );
}
