//! White noise behind a moving average: its level below the fall of the filter, no lines, nothing said of quantization.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use sagnac_analysis::fit::{FindingKind, Status};

/// Sum of twelve uniform numbers: Gaussian enough, variance 1.
fn noise(seed: &mut u64) -> f64 {
    (0..12).fold(-6.0, |sum, _| {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        sum + (*seed >> 11) as f64 / (1_u64 << 53) as f64
    })
}

#[test]
fn a_moving_average_biases_no_white_level_and_makes_no_lines() {
    let (mut seed, n, length) = (5, 60_000, 4);
    let (mut off, axes) = (0.0, 8);
    for _ in 0..axes {
        let white: Vec<f64> = (0..n + length).map(|_| noise(&mut seed)).collect();
        let samples: Vec<f64> = white
            .windows(length)
            .map(|w| w.iter().sum::<f64>() / length as f64)
            .collect();
        let axis = common::estimate_of_samples(&samples, 0.01);
        assert!(
            axis.findings
                .iter()
                .any(|f| f.kind == FindingKind::Filtered)
        );
        assert!(axis.sinusoids.is_empty(), "{:?}", axis.sinusoids);
        assert_eq!(axis.quantization.status, Status::Absent);
        off += (axis.white.value.unwrap() / 0.1 - 1.0) / f64::from(axes);
    }
    assert!(off.abs() < 0.015, "{off}");
}
