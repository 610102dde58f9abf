//! NIST SP 1065, section 12: the 10-point and 1000-point test sets, every printed digit.
//!
//! Source `[SP1065]`, tables 31 and 32; Thêo1 by Stable32.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{assert_rel, generator};
use sagnac_analysis::{Deviation, TauGrid, deviations};

fn value(samples: &[f64], kind: Deviation, m: f64) -> f64 {
    let unit = kind.tau_per_factor();
    deviations(&[samples], 1.0, kind, &TauGrid::Times(vec![m * unit]))
        .unwrap()
        .deviation[0]
}

#[test]
fn thousand_points() {
    let samples = generator(1000);
    // Seven printed digits: half a unit of the last is at most 5e-7 of the value.
    let table = [
        (Deviation::Adev, [2.922319e-01, 9.965736e-02, 3.897804e-02]),
        (Deviation::Oadev, [2.922319e-01, 9.159953e-02, 3.241343e-02]),
        (Deviation::Mdev, [2.922319e-01, 6.172376e-02, 2.170921e-02]),
        (Deviation::Tdev, [1.687202e-01, 3.563623e-01, 1.253382e+00]),
        (Deviation::Hdev, [2.943883e-01, 9.581083e-02, 3.237638e-02]),
        (
            Deviation::Totdev,
            [2.922319e-01, 9.134743e-02, 3.406530e-02],
        ),
    ];
    for (kind, wanted) in table {
        for (m, want) in [1.0, 10.0, 100.0].into_iter().zip(wanted) {
            assert_rel(value(&samples, kind, m), want, 5e-7, kind.name());
        }
    }
}

#[test]
fn ten_points() {
    let samples = [
        892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0,
    ];
    let table = [
        (Deviation::Adev, [91.22945, 115.8082]),
        (Deviation::Oadev, [91.22945, 85.95287]),
        (Deviation::Mdev, [91.22945, 74.78849]),
        (Deviation::Tdev, [52.67135, 86.35831]),
        (Deviation::Hdev, [70.80607, 85.61487]),
        (Deviation::Totdev, [91.22945, 93.90379]),
    ];
    for (kind, wanted) in table {
        for (m, want) in [1.0, 2.0].into_iter().zip(wanted) {
            // Tdev's first value is printed as 52.67135 (52.6713...5): one unit of the last digit.
            assert_rel(value(&samples, kind, m), want, 1.5e-7, kind.name());
        }
    }
}

#[test]
fn theo1_of_the_thousand_points() {
    let samples = generator(1000);
    for (m, want) in [(10.0, 1.0757e-1), (100.0, 3.1789e-2), (1000.0, 5.0524e-3)] {
        // Five printed digits.
        assert_rel(value(&samples, Deviation::Theo1, m), want, 5e-5, "theo1");
    }
}
