//! Motion, gaps in time and their spans on logs whose faults are known to the sample.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_log::health::{Health, HealthOptions, check};
use sagnac_log::{Issue, IssueKind, Log, ReadOptions, Source, read};

const RATE: f64 = 50.0;

/// Uniform noise of unit variance.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }
}

/// Six axes at rest, `shape(second, axis)` times their noise plus `moved(second, axis)`.
fn log(seconds: f64, scale: impl Fn(f64, usize) -> f64, moved: impl Fn(f64, usize) -> f64) -> Log {
    let mut noise = Noise(7);
    let mut text = String::from(
        "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n",
    );
    for k in 0..(seconds * RATE) as usize {
        let t = k as f64 / RATE;
        text += &format!("{t}");
        for axis in 0..6 {
            let sigma = if axis < 3 { 1e-3 } else { 1e-2 };
            let level = if axis == 5 { 9.8 } else { 0.01 };
            let y = level + sigma * scale(t, axis) * noise.next() + moved(t, axis);
            text += &format!(",{y}");
        }
        text.push('\n');
    }
    read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap()
}

fn motion(log: &Log) -> (Vec<Issue>, Health<'_>) {
    let health = check(log, &HealthOptions::default()).unwrap();
    let found = health
        .issues
        .iter()
        .filter(|i| i.kind == IssueKind::Motion)
        .cloned()
        .collect();
    (found, health)
}

/// Samples of a burst that the estimate would still see.
fn left_in(health: &Health<'_>, start_s: f64, end_s: f64) -> usize {
    let inside = |k: &usize| (start_s..end_s).contains(&(*k as f64 / RATE));
    let quiet = health.channels[0].quiet.iter();
    quiet
        .flat_map(|s| s.range.clone())
        .filter(|k| inside(k))
        .count()
}

#[test]
fn a_burst_of_noise_is_one_finding_with_its_own_edges() {
    for start in [100.0, 100.37, 251.8] {
        let during = |t: f64| (start..start + 3.0).contains(&t);
        let log = log(400.0, |t, _| if during(t) { 10.0 } else { 1.0 }, |_, _| 0.0);
        let (found, health) = motion(&log);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            (found[0].start_s - start).abs() < 0.3 && (found[0].end_s - start - 3.0).abs() < 0.3,
            "{found:?}"
        );
        assert!(
            found[0].text.contains("the scatter bursts to 1"),
            "{}",
            found[0].text
        );
        assert!(left_in(&health, start, start + 3.0) <= 1);
    }
}

#[test]
fn a_strong_shake_is_motion_of_its_span() {
    let shake = |t: f64, a: usize| {
        if (200.4..203.4).contains(&t) {
            5.0 * (6.3 * 5.0 * t + a as f64).sin()
        } else {
            0.0
        }
    };
    let log = log(600.0, |_, _| 1.0, shake);
    let (found, health) = motion(&log);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        (found[0].start_s - 200.4).abs() < 0.3 && (found[0].end_s - 203.4).abs() < 0.3,
        "{found:?}"
    );
    assert!(left_in(&health, 200.4, 203.4) <= 1);
}

#[test]
fn a_log_that_moves_in_its_second_half_keeps_its_first() {
    let moved = |t: f64, a: usize| {
        if t >= 150.0 {
            (3.0 * t + a as f64).sin() + (7.1 * t).cos()
        } else {
            0.0
        }
    };
    let log = log(300.0, |_, _| 1.0, moved);
    let (found, health) = motion(&log);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        (found[0].start_s - 150.0).abs() < 0.5 && found[0].end_s > 299.5,
        "{found:?}"
    );
    assert_eq!(health.channels[0].quiet.len(), 1);
    assert!(left_in(&health, 0.0, 150.0) > 7400);
}

#[test]
fn time_that_goes_back_never_makes_a_negative_duration() {
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let mut noise = Noise(3);
    for k in 0..2000 {
        // The clock starts anew in the middle, long before where it began.
        let t = if k < 1000 {
            500.0 + f64::from(k) / 10.0
        } else {
            f64::from(k - 1000) / 10.0
        };
        text += &format!("{t},{}\n", noise.next());
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!(
        (health.duration_s - 200.0).abs() < 1e-6,
        "{}",
        health.duration_s
    );
    assert!(health.issues.iter().any(|i| i.kind == IssueKind::Backwards));
    assert!(health.issues.iter().all(|i| i.end_s >= i.start_s));
}

#[test]
fn stamps_that_are_no_numbers_are_told_and_leave_the_duration() {
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let mut noise = Noise(3);
    for k in 0..1000 {
        let t = if k < 3 || k == 999 {
            "nan".to_owned()
        } else {
            format!("{}", f64::from(k) / 10.0)
        };
        text += &format!("{t},{}\n", noise.next());
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!(
        (health.duration_s - 100.0).abs() < 1e-6,
        "{}",
        health.duration_s
    );
    let told: Vec<u64> = health
        .issues
        .iter()
        .filter(|i| i.kind == IssueKind::Nan)
        .map(|i| i.count)
        .collect();
    assert_eq!(told, [3, 1]);
    assert!(
        health
            .issues
            .iter()
            .all(|i| i.start_s.is_finite() && i.end_s.is_finite())
    );
}
