//! `allan` from a log to its curves: laws that every estimate keeps.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac::allan::{AllanOutcome, AllanRequest, allan};
use sagnac::analysis::{Deviation, Estimate, TauGrid};
use sagnac::log::{ReadOptions, Source, open};

/// A log of one axis at 100 Hz: uniform noise of 1 rad/s; rows from `gap` on come `lost` samples later.
fn text(rows: usize, gap: usize, lost: usize) -> String {
    let mut state = 3_u64;
    let mut out = String::from("time [s],gyro_x [rad/s]\n");
    for k in 0..rows {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let y = ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt();
        let at = if k < gap { k } else { k + lost };
        out += &format!("{},{y}\n", at as f64 / 100.0);
    }
    out
}

fn run(text: String, request: &AllanRequest) -> Result<AllanOutcome, sagnac::Error> {
    let mut reader = open(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )?;
    allan(&mut *reader, request)
}

#[test]
fn white_noise_has_its_density_in_both_pictures() {
    // Two-sided N² = dt, hence a deviation √(dt/τ) and a one-sided density 2 dt.
    let curves = run(text(20_000, 20_000, 0), &AllanRequest::default()).unwrap();
    let curve = curves.axes[0].curve.as_ref().unwrap();
    for (k, tau_s) in curve.tau_s.iter().enumerate() {
        let (Some(lower), Some(upper)) = (curve.lower[k], curve.upper[k]) else {
            continue;
        };
        // Half as wide again as the 95 % limits: every one of the curve must hold.
        let truth = (0.01 / tau_s).sqrt();
        assert!(lower / 1.5 < truth && truth < 1.5 * upper, "{tau_s}");
    }
    let spectrum = AllanRequest {
        spectrum: true,
        ..AllanRequest::default()
    };
    let outcome = run(text(20_000, 20_000, 0), &spectrum).unwrap();
    let density = &outcome.axes[0].density.as_ref().unwrap().density;
    let mean = density.iter().sum::<f64>() / density.len() as f64;
    assert!((mean / 0.02 - 1.0).abs() < 0.05, "{mean}");
}

#[test]
fn a_gap_pools_two_stretches_and_is_told() {
    let outcome = run(text(4000, 1500, 50), &AllanRequest::default()).unwrap();
    assert_eq!(outcome.segments, 2);
    // First differences within the stretches alone.
    assert_eq!(
        outcome.axes[0].curve.as_ref().unwrap().samples_used[0],
        1499 + 2499
    );
    assert_eq!(
        (outcome.issues[0].kind.name(), outcome.issues[0].count),
        ("gap", 50)
    );
}

#[test]
fn strided_and_exact_agree_where_every_start_is_kept() {
    let of = |estimate| {
        let request = AllanRequest {
            taus: TauGrid::Octave,
            estimate: Some(estimate),
            ..AllanRequest::default()
        };
        run(text(4096, 4096, 0), &request)
            .unwrap()
            .axes
            .remove(0)
            .curve
            .unwrap()
    };
    let (exact, strided) = (of(Estimate::Exact), of(Estimate::Strided));
    assert!((strided.deviation[0] / exact.deviation[0] - 1.0).abs() < 1e-9);
    for (a, b) in exact.deviation.iter().zip(&strided.deviation).take(8) {
        assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
    }
}

#[test]
fn windows_tile_the_log_and_the_last_ends_with_it() {
    let request = AllanRequest {
        dynamic_s: Some(10.0),
        ..AllanRequest::default()
    };
    let outcome = run(text(3300, 3300, 0), &request).unwrap();
    let windows = outcome.axes[0].windows.as_ref().unwrap();
    assert!((windows[1].start_s - 2.5).abs() < 1e-9);
    assert!((windows[windows.len() - 1].end_s - 33.0).abs() < 1e-9);
}

#[test]
fn what_is_too_short_says_what_would_do() {
    for (deviation, needed) in [
        (Deviation::Mdev, "at least 3 samples"),
        (Deviation::Theo1, "at least 10 samples"),
    ] {
        let request = AllanRequest {
            deviation,
            ..AllanRequest::default()
        };
        let error = run(text(2, 2, 0), &request).unwrap_err();
        assert!(error.what.contains(needed), "{}", error.what);
        assert!(error.advice.is_some() && error.place.is_some());
    }
}

/// Rows at 100 Hz with two gyro axes and uniform noise, the cells as `cell(row, axis, noise)` gives them.
fn two_axes(rows: usize, cell: impl Fn(usize, usize, f64) -> String) -> String {
    let mut state = 5_u64;
    let mut out = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s]\n");
    for k in 0..rows {
        out += &format!("{}", k as f64 / 100.0);
        for axis in 0..2 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let y = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            out += &format!(",{}", cell(k, axis, y));
        }
        out.push('\n');
    }
    out
}

#[test]
fn an_axis_at_its_own_rate_has_numbers_in_the_table() {
    let every_second = |k: usize, axis: usize, y: f64| match (axis, k % 2) {
        (1, 1) => String::new(),
        _ => y.to_string(),
    };
    for taus in [TauGrid::Default, TauGrid::Decade, TauGrid::Octave] {
        let request = AllanRequest {
            taus: taus.clone(),
            ..AllanRequest::default()
        };
        let outcome = run(two_axes(20_000, every_second), &request).unwrap();
        assert_eq!(outcome.issues[0].kind.name(), "nan");
        assert_eq!(outcome.issues[0].count, 10_000);
        let words = outcome
            .document()
            .render(sagnac::report::text::Style::PLAIN);
        let table = words.lines().skip_while(|l| !l.starts_with("tau")).skip(2);
        let rows: Vec<Vec<&str>> = table
            .take_while(|l| !l.is_empty())
            .map(|l| l.split_whitespace().collect())
            .collect();
        for axis in [1, 2] {
            let filled = rows.iter().filter(|r| r[axis] != "-").count();
            assert!(filled >= 4, "{taus:?}: {words}");
        }
    }
}

#[test]
fn motion_is_said_to_be_in_the_curve() {
    let knock = |k: usize, _: usize, y: f64| {
        (y + if (9000..9300).contains(&k) { 30.0 } else { 0.0 }).to_string()
    };
    let outcome = run(two_axes(20_000, knock), &AllanRequest::default()).unwrap();
    let motion = outcome.issues.iter().find(|i| i.kind.name() == "motion");
    let text = &motion.unwrap().text;
    assert!(
        text.contains("the curve holds it") && !text.contains("; left out"),
        "{text}"
    );
}

#[test]
fn totdev_has_no_interval_for_noise_of_the_angle() {
    // Differences of white noise: noise of the angle, α = 2.
    let white = text(4001, 5000, 0);
    let rows: Vec<f64> = white
        .lines()
        .skip(1)
        .map(|row| row.split_once(',').unwrap().1.parse().unwrap())
        .collect();
    let mut angle = String::from("time [s],gyro_x [rad/s]\n");
    for (k, pair) in rows.windows(2).enumerate() {
        angle += &format!("{},{}\n", k as f64 / 100.0, pair[1] - pair[0]);
    }
    let request = AllanRequest {
        deviation: Deviation::Totdev,
        ..AllanRequest::default()
    };
    let run_of = |text: String| run(text, &request).unwrap();
    let said = |outcome: &AllanOutcome| {
        let text = outcome
            .document()
            .render(sagnac::report::text::Style::PLAIN);
        assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
        text.contains("no interval where the noise is that of the angle")
    };
    let outcome = run_of(angle);
    let curve = outcome.axes[0].curve.as_ref().unwrap();
    assert_eq!(curve.alpha[0], 2);
    let json = outcome.to_json();
    for key in ["lower", "upper", "edf"] {
        assert!(json["axes"][0][key][0].is_null(), "{key}");
    }
    assert!(json["axes"][0]["deviation"][0].is_f64());
    assert!(said(&outcome));
    let outcome = run_of(white);
    let curve = outcome.axes[0].curve.as_ref().unwrap();
    assert!(curve.lower[0].is_some() && curve.upper[0].is_some());
}
