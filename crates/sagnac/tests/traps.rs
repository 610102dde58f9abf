//! The traps of the sensor model that need more than one crate; 4, 7 and 9 stand beside core and noise.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;

use sagnac::analysis::fit::{AxisData, AxisEstimate, FitOptions, Segment, Term, estimate};
use sagnac::analysis::{Deviation, TauGrid, deviations};
use sagnac::core::Sensor;
use sagnac::log::{ReadOptions, Source, health, read};
use sagnac::model::Model;
use sagnac::noise::{AxisGenerator, AxisNoise, Flicker, RandomWalk, StreamKey, TermSet, White};

fn model(body: &str) -> Result<Model, sagnac::model::Error> {
    Model::parse(&format!("schema = 1\nname = \"a\"\n{body}"), "a.toml")
}

#[test]
fn trap_1_bias_instability_coefficient_and_allan_minimum_differ_by_0_664() {
    let b = |key: &str| {
        let text =
            format!("[gyro.bias.instability]\nprocess = \"flicker\"\n{key} = \"0.01 rad/s\"\n");
        model(&text)
            .unwrap()
            .axis_noise(Sensor::Gyro, 0)
            .flicker
            .coefficient
    };
    let floor = (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    assert!((floor - 0.66428).abs() < 1e-5);
    assert!((b("coefficient") - 0.01).abs() < 1e-16);
    assert!((b("allan_minimum") * floor - 0.01).abs() < 1e-15);
    let both = "[gyro.bias.instability]\nprocess = \"flicker\"\ncoefficient = \"1 deg/h\"\nallan_minimum = \"1 deg/h\"\n";
    assert!(model(both).is_err());
    assert!(model("[gyro.bias]\ninstability = \"1 deg/h\"\n").is_err());
}

#[test]
fn trap_2_one_sided_density_is_root_two_above_the_two_sided() {
    let n = |line: &str| {
        model(&format!("[gyro.noise]\n{line}\n"))
            .unwrap()
            .axis_noise(Sensor::Gyro, 1)
            .white
            .density
    };
    let one_sided = n("noise_density_one_sided = \"0.01 deg/s/sqrt(Hz)\"");
    let two_sided = n("angle_random_walk = \"0.6 deg/sqrt(h)\"");
    // 0.01 deg/s/√Hz is 0.6 deg/√h as a number; a one-sided density is N√2.
    assert!((one_sided * 2.0_f64.sqrt() / two_sided - 1.0).abs() < 1e-14);
    let both = "[gyro.noise]\nangle_random_walk = \"0.6 deg/sqrt(h)\"\nnoise_density_one_sided = \"0.01 deg/s/sqrt(Hz)\"\n";
    assert!(model(both).is_err());
}

const STEP_S: f64 = 0.02;

fn samples(noise: &AxisNoise, count: usize) -> Vec<f64> {
    let key = StreamKey {
        seed: 1,
        run: 1,
        sensor: 0,
        axis: 0,
    };
    let length_s = count as f64 * STEP_S;
    let mut x = vec![0.0; count];
    AxisGenerator::new(noise, TermSet::ALL, STEP_S, length_s, key)
        .unwrap()
        .fill(&mut x, None);
    x
}

fn joint(samples: &[f64]) -> AxisEstimate {
    let segments = [Segment {
        start_s: 0.0,
        samples,
        filled: &[],
    }];
    estimate(
        &AxisData {
            segments: &segments,
            temperature: None,
            step_s: STEP_S,
            lsb: None,
        },
        &FitOptions::default(),
    )
}

#[test]
fn trap_5_joint_fit_where_a_read_off_at_one_second_is_biased() {
    let x = samples(
        &AxisNoise {
            white: White { density: 1.0 },
            flicker: Flicker { coefficient: 1.0 },
            random_walk: RandomWalk { coefficient: 0.05 },
            ..AxisNoise::default()
        },
        50_000,
    );
    let grid = TauGrid::Times(vec![1.0]);
    let curve = deviations(&[&x], STEP_S, Deviation::Oadev, &grid).unwrap();
    let read_off = curve.deviation[0];
    // σ²(1 s) = N² + 0.44 B² + …: 20 % above N, with 2000 intervals of 1 s known to 2 %.
    assert!(read_off > 1.1, "{read_off}");
    let n = joint(&x).term(Term::White).unwrap().value.unwrap();
    assert!((n - 1.0).abs() < 0.05, "{n}");
}

#[test]
fn trap_6_absent_terms_are_limits_and_not_numbers() {
    let x = samples(
        &AxisNoise {
            white: White { density: 1.0 },
            ..AxisNoise::default()
        },
        30_000,
    );
    let axis = joint(&x);
    for term in [Term::Flicker, Term::RandomWalk, Term::Ramp] {
        let of = axis.term(term).unwrap();
        assert!(!of.is_detected() && of.value.is_none(), "{term:?}");
        assert!(of.upper.is_some_and(|limit| limit > 0.0), "{term:?}");
    }
    assert!(axis.term(Term::White).unwrap().is_detected());
}

#[test]
fn trap_8_unsound_timestamps_are_reported() {
    // 100 Hz with 40 rows lost, one row twice and a clock that starts again.
    let mut text = "time [ms],gyro_x [rad/s]\n".to_owned();
    let mut row = |ms: i64, k: i64| {
        let _ = writeln!(text, "{ms},{}", (k * 7919 % 101) as f64 * 1e-3);
    };
    for k in 0..900_i64 {
        let lost = if k >= 300 { 400 } else { 0 };
        let restart = if k >= 700 { -5000 } else { 0 };
        row(10 * k + lost + restart, k);
        if k == 500 {
            row(10 * k + lost, k);
        }
    }
    let log = read(
        Source::memory("a.csv", text.into_bytes()),
        &ReadOptions::default(),
    )
    .unwrap();
    let issues = health::check(&log, &health::HealthOptions::default())
        .unwrap()
        .issues;
    for kind in ["gap", "duplicate", "backwards"] {
        assert!(
            issues.iter().any(|issue| issue.kind.name() == kind),
            "{kind}: {issues:?}"
        );
    }
}
