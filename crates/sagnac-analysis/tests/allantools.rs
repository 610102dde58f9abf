//! Deviations of allantools 2024.6 on three noise types: 1e-9 relative and equal counts.
//!
//! The table is written by `tools/allantools_reference.py`.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{assert_rel, cumulative, differences, generator};
use sagnac_analysis::{Deviation, TauGrid, deviations};

const TABLE: &str = include_str!("../../../testdata/reference/allantools_deviations.csv");

#[test]
fn every_deviation_agrees() {
    let white = generator(1500);
    let centered: Vec<f64> = white.iter().map(|y| y - 0.5).collect();
    let (walk, phase) = (cumulative(&centered), differences(&white));
    let dt_s = 0.25;
    let mut rows = 0;
    for line in TABLE.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let samples = match cells[0] {
            "white" => &white,
            "walk" => &walk,
            _ => &phase,
        };
        let kind = Deviation::from_name(cells[1]).unwrap();
        let m: usize = cells[2].parse().unwrap();
        let tau_s = m as f64 * kind.tau_per_factor() * dt_s;
        let curve = deviations(&[samples], dt_s, kind, &TauGrid::Times(vec![tau_s])).unwrap();
        assert_eq!(curve.factor, [m], "{line}");
        assert_rel(curve.deviation[0], cells[3].parse().unwrap(), 1e-9, line);
        assert_eq!(
            curve.samples_used[0],
            cells[4].parse::<u64>().unwrap(),
            "{line}"
        );
        rows += 1;
    }
    assert!(rows > 250, "{rows} rows");
}
