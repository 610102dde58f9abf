//! `calibrate multi-position` on logs with faults: what is held at zero is named wherever the result is used, advice works
//! when it is followed, and faults of the log are told.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::path::Path;

use assert_cmd::Command;
use common::flat;

const G: f64 = 9.80665;
const DT_S: f64 = 0.01;
const GYRO_BIAS: [f64; 3] = [0.01, -0.02, 0.03];

type Vector = [f64; 3];

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn unit(v: Vector) -> Vector {
    let size = dot(v, v).sqrt();
    v.map(|x| x / size)
}

/// v turned by an angle about a unit vector.
fn turned(v: Vector, axis: Vector, angle: f64) -> Vector {
    let (s, c) = angle.sin_cos();
    let (side, along) = (cross(axis, v), dot(axis, v) * (1.0 - c));
    [0, 1, 2].map(|k| c * v[k] + s * side[k] + along * axis[k])
}

/// A reproducible number of variance about one.
fn noise(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    3.46 * ((*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
}

/// Directions well spread over the sphere.
fn spread(count: usize) -> Vec<Vector> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (s, c) = (golden * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * c, r * s, z]
        })
        .collect()
}

/// Rows of a log: time, specific force, rate; 2.5 s of rest a direction, shortest turns of 1.5 s between them.
fn rows(ups: &[Vector]) -> Vec<[f64; 7]> {
    let mut state = 11;
    let mut out: Vec<[f64; 7]> = Vec::new();
    let mut push = |up: Vector, rate: Vector| {
        let mut row = [(out.len() + 1) as f64 * DT_S, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for k in 0..3 {
            row[1 + k] = G * (1.0 + 0.004 * k as f64) * up[k] + 0.1 + 0.02 * noise(&mut state);
            row[4 + k] = rate[k] + GYRO_BIAS[k] + 1e-3 * noise(&mut state);
        }
        out.push(row);
    };
    for (i, up) in ups.iter().enumerate() {
        for _ in 0..250 {
            push(*up, [0.0; 3]);
        }
        let Some(next) = ups.get(i + 1) else { break };
        let mut axis = cross(*up, *next);
        if dot(axis, axis) < 1e-9 {
            axis = cross(
                *up,
                if up[0].abs() < 0.9 {
                    [1.0, 0.0, 0.0]
                } else {
                    [0.0, 1.0, 0.0]
                },
            );
        }
        let axis = unit(axis);
        let whole = dot(*up, *next).clamp(-1.0, 1.0).acos();
        let at = |t: f64| t * t * t * (10.0 - 15.0 * t + 6.0 * t * t) * whole;
        for k in 0..150 {
            let (a, b) = (at(f64::from(k) / 150.0), at(f64::from(k + 1) / 150.0));
            // What stands still in the world turns backward in the body.
            push(
                turned(*up, axis, f64::midpoint(a, b)),
                axis.map(|v| -v * (b - a) / DT_S),
            );
        }
    }
    out
}

fn text(rows: &[[f64; 7]]) -> String {
    let mut out = String::from(
        "time [s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n",
    );
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .map(|v| {
                if v.is_nan() {
                    "nan".to_owned()
                } else {
                    v.to_string()
                }
            })
            .collect();
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(line.split(' '))
        .output()
        .unwrap();
    (
        output.status.code(),
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

/// The command on a log: exit code, standard output, errors.
fn calibrated(rows: &[[f64; 7]], more: &str) -> (tempfile::TempDir, Option<i32>, String, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), text(rows)).unwrap();
    let (code, out, error) = run(
        folder.path(),
        &format!("calibrate multi-position log.csv -o m.toml{more}"),
    );
    (folder, code, out, error)
}

/// The vector of a direction in words: `-x+z`.
fn named(word: &str) -> Vector {
    let mut out = [0.0; 3];
    let letters: Vec<char> = word.chars().collect();
    for pair in letters.chunks(2) {
        let k = "xyz".find(pair[1]).unwrap();
        out[k] = if pair[0] == '-' { -1.0 } else { 1.0 };
    }
    unit(out)
}

#[test]
fn a_gyro_in_a_wrong_unit_is_named_as_held_wherever_the_result_is_used() {
    let mut log = rows(&spread(20));
    for row in &mut log {
        for v in &mut row[4..] {
            *v = v.to_degrees();
        }
    }
    let (folder, code, out, error) = calibrated(&log, "");
    assert_eq!(code, Some(0), "{error}");
    assert!(flat(&out).contains("gyro.scale_factor"), "{out}");
    assert!(
        !out.contains("Every term that was asked for is determined"),
        "{out}"
    );
    let model = std::fs::read_to_string(folder.path().join("m.toml")).unwrap();
    for name in [
        "gyro.bias.x",
        "gyro.g_sensitivity.zz",
        "accel.axis_offset.xy",
        "accel.scale_factor.cubic.y",
    ] {
        assert!(model.contains(&format!("\"{name}\"")), "{name}: {model}");
    }
    // By the frame these are zero, not held.
    assert!(!model.contains("accel.misalignment.xy"), "{model}");
    let (_, out, _) = run(folder.path(), "correct m.toml log.csv -o c.csv");
    assert!(
        flat(&out).contains("gyro.bias, gyro.scale_factor,"),
        "{out}"
    );
    let (code, _, error) = run(folder.path(), "correct m.toml --emit c -o source");
    assert_eq!(code, Some(0), "{error}");
    let header =
        std::fs::read_to_string(folder.path().join("source/sagnac_correct_f64.h")).unwrap();
    assert!(
        header.contains("held at zero") && header.contains("gyro.scale_factor.x"),
        "{header}"
    );
    let (_, out, _) = run(
        folder.path(),
        "calibrate multi-position log.csv --format json",
    );
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let held = json["unobservable"].as_array().unwrap();
    assert!(held.iter().any(|h| h == "gyro.misalignment.xy"), "{held:?}");
}

#[test]
fn a_whole_calibration_still_names_what_no_hand_turned_log_tells() {
    let (folder, code, out, error) = calibrated(
        &rows(&spread(20)),
        " --report r.html --item No.42 --customer ACME --certificate C-7",
    );
    assert_eq!(code, Some(0), "{error}");
    assert!(
        out.contains("Every term that was asked for is determined"),
        "{out}"
    );
    let model = std::fs::read_to_string(folder.path().join("m.toml")).unwrap();
    assert!(
        model.contains("\"gyro.scale_factor.temperature.1.x\""),
        "{model}"
    );
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    for part in [
        "<dt>Item</dt><dd>No.42</dd>",
        "<dt>Customer</dt><dd>ACME</dd>",
        "No. C-7",
        "k = 2",
        "name=\"units\"",
        "<caption>Gyro</caption>",
        "data-sensor=\"gyro\" data-term=\"g_sensitivity\"",
        "data-plot=\"poses\"",
        "Gyro, each turn",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_mounting_that_nobody_measured_is_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), text(&rows(&spread(20)))).unwrap();
    let model = "name = 'faces'\n[accel.bias]\nfixed = ['0 m/s^2', '0 m/s^2', '0 m/s^2']\n";
    std::fs::write(folder.path().join("faces.toml"), model).unwrap();
    let line = "calibrate multi-position log.csv --frame fixture --start faces.toml";
    let (code, out, error) = run(folder.path(), line);
    assert_eq!(code, Some(0), "{error}");
    assert!(flat(&out).contains("no mounting was measured"), "{out}");
    assert!(!flat(&out).contains("taken as exact"), "{out}");
}

#[test]
fn poses_that_are_added_as_advised_suffice() {
    let circle = |a: Vector, b: Vector| -> Vec<Vector> {
        (0..12)
            .map(|i| {
                let (s, c) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
                unit([0, 1, 2].map(|k| c * a[k] + s * b[k]))
            })
            .collect()
    };
    let tilted = unit([1.0, 1.0, 1.0]);
    let flat_sets = [
        circle([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        circle([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        circle(
            unit([1.0, -1.0, 0.0]),
            cross(unit([1.0, -1.0, 0.0]), tilted),
        ),
    ];
    for poses in flat_sets {
        let (_, code, _, error) = calibrated(&rows(&poses), "");
        assert_eq!(code, Some(1), "{error}");
        let error = flat(&error);
        let (_, list) = error.split_once("directions up:").expect(&error);
        let words: Vec<&str> = list
            .split([',', ' ', '\n'])
            .filter(|w| !w.is_empty())
            .collect();
        let mut more = poses.clone();
        more.extend(words.iter().map(|w| named(w)));
        let (_, code, _, error) = calibrated(&rows(&more), "");
        assert_eq!(code, Some(0), "{words:?}: {error}");
    }
}

#[test]
fn a_sensor_that_never_lies_still_is_told_so_at_any_rate() {
    for rate in [0.08, 0.3, 1.0, 2.0] {
        let mut state = 5;
        let (mut x, mut y) = (unit([1.0, 0.2, -0.4]), [0.0; 3]);
        let mut log = Vec::new();
        for k in 0..20_000 {
            let t = f64::from(k) * DT_S;
            let w = [
                rate * (0.9 + 0.5 * (0.37 * rate * t).sin()),
                rate * 0.6 * (1.0 + 0.5 * (0.5 * rate * t).cos()),
                -rate * 0.7,
            ];
            let size = dot(w, w).sqrt();
            x = turned(x, w.map(|v| v / size), -size * DT_S);
            let mut row = [t + DT_S, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            for k in 0..3 {
                y[k] = G * x[k] + 0.03 * noise(&mut state);
                row[1 + k] = y[k];
                row[4 + k] = w[k] + GYRO_BIAS[k] + 1e-3 * noise(&mut state);
            }
            log.push(row);
        }
        let (_, code, _, error) = calibrated(&log, "");
        assert_eq!(code, Some(1));
        assert!(
            flat(&error).contains("moves all the time"),
            "{rate} rad/s: {error}"
        );
    }
}

#[test]
fn faults_of_the_log_are_told_with_what_they_cost() {
    let whole = rows(&spread(20));
    // In the first turn.
    let mut log = whole.clone();
    log[320][1] = f64::NAN;
    let (_, code, out, error) = calibrated(&log, "");
    assert_eq!(code, Some(0), "{error}");
    assert!(
        flat(&out).contains("accel_x at 0:03.2: 1 sample is no number"),
        "{out}"
    );
    assert!(
        flat(&out).contains("is left out: a sample in it is no number"),
        "{out}"
    );
    // A stamp alone costs no turn.
    let mut log = whole.clone();
    log[320][0] = f64::NAN;
    let (_, _, out, _) = calibrated(&log, "");
    assert!(
        flat(&out).contains("the stamp is no number") && out.contains("19 turns"),
        "{out}"
    );
    // Time goes back in a rest: no knock.
    let mut log = whole;
    for row in log.iter_mut().skip(4130) {
        row[0] -= 20.0;
    }
    let (_, _, out, _) = calibrated(&log, "");
    assert!(flat(&out).contains("time goes back"), "{out}");
    assert!(!out.contains("knock"), "{out}");
}
