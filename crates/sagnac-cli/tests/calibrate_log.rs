//! `calibrate multi-position` and `calibrate thermal` as commands: what they write, and what they refuse in one sentence.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::path::Path;

use assert_cmd::Command;
use common::{flat, sentences};

const G: f64 = 9.80665;
const RATE: usize = 100;

/// A reproducible number in (−0.5, 0.5).
fn noise(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// Directions that point up, one a rest.
fn directions(count: usize) -> Vec<[f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let r = (1.0 - z * z).sqrt();
            let a = golden * i as f64;
            [r * a.cos(), r * a.sin(), z]
        })
        .collect()
}

/// An accelerometer turned from direction to direction: 3 s of rest, 1.5 s of shaking between.
fn turned(ups: &[[f64; 3]], size: f64) -> String {
    let mut text = String::from("accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n");
    let mut state = 7;
    for (i, up) in ups.iter().enumerate() {
        let next = ups.get(i + 1).unwrap_or(up);
        for k in 0..3 * RATE + 3 * RATE / 2 {
            let turning = k >= 3 * RATE;
            let share = if turning {
                (k - 3 * RATE) as f64 / 150.0
            } else {
                0.0
            };
            let mut row = [0.0; 3];
            for (j, v) in row.iter_mut().enumerate() {
                let along = up[j] + (next[j] - up[j]) * share;
                let shake = if turning {
                    (k as f64 * (0.9 + 0.2 * j as f64)).sin()
                } else {
                    0.0
                };
                *v = size * ((1.0 + 0.004 * j as f64) * along + 0.01 + 0.003 * noise(&mut state))
                    + 0.1 * size * shake;
            }
            let _ = writeln!(text, "{},{},{}", row[0], row[1], row[2]);
        }
    }
    text
}

fn sagnac(folder: &Path, arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// The command refuses `text` with `word` in the sentence, exit 1, and writes nothing.
fn refused(text: &str, command: &str, word: &str) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), text).unwrap();
    let output = sagnac(
        folder.path(),
        &[
            "calibrate",
            command,
            "log.csv",
            "--rate",
            "100Hz",
            "-o",
            "m.toml",
            "--report",
            "r.html",
        ],
    );
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{word}: {error}");
    assert!(
        error.starts_with("error: ") && flat(&error).contains(word),
        "{word}: {error}"
    );
    assert!(sentences(&error) <= 3, "{error}");
    assert!(output.stdout.is_empty());
    assert!(!folder.path().join("m.toml").exists() && !folder.path().join("r.html").exists());
}

#[test]
fn a_turned_log_gives_a_model_a_page_and_json() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), turned(&directions(16), G)).unwrap();
    let output = sagnac(
        folder.path(),
        &[
            "calibrate",
            "multi-position",
            "log.csv",
            "--rate",
            "100Hz",
            "-o",
            "m.toml",
            "--report",
            "r.html",
            "--format",
            "json",
        ],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["poses"].as_array().unwrap().len(), 16);
    assert_eq!(json["parameters"].as_array().unwrap().len(), 9);
    assert_eq!(json["gyro_drift"], serde_json::Value::Null);
    assert_eq!(json["threshold"]["unit"], "m/s^2");
    for key in [
        "turns",
        "add_poses",
        "add_turns",
        "confused",
        "unobservable",
        "advice",
        "model",
        "gravity",
    ] {
        assert!(json.get(key).is_some(), "{key}");
    }
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let name = format!("accel.scale_factor.{axis}");
        let all = json["parameters"].as_array().unwrap();
        let p = all.iter().find(|p| p["name"] == name.as_str()).unwrap();
        let (lower, upper) = (p["lower"].as_f64().unwrap(), p["upper"].as_f64().unwrap());
        let (truth, half) = (0.004 * k as f64, (upper - lower) / 2.0);
        // Nine intervals of 95 %: twice as wide leaves none outside once in a thousand.
        assert!(
            (p["value"].as_f64().unwrap() - truth).abs() < 2.0 * half,
            "{name} {p}"
        );
    }
    let model = std::fs::read_to_string(folder.path().join("m.toml")).unwrap();
    assert!(
        model.contains("method = \"multi-position\"")
            && model.contains("frame = \"accelerometer\"")
    );
    assert!(
        std::fs::read_to_string(folder.path().join("r.html"))
            .unwrap()
            .contains("data-plot=\"poses\"")
    );
}

#[test]
fn what_is_no_turned_log_is_refused() {
    let faces: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    refused(&turned(&faces, G), "multi-position", "3 of them distinct");
    refused(
        &turned(&faces[..1], G),
        "multi-position",
        "1 of them distinct",
    );
    let circle: Vec<[f64; 3]> = (0..12)
        .map(|i| {
            let a = f64::from(i) * std::f64::consts::TAU / 12.0;
            [a.cos(), a.sin(), 0.0]
        })
        .collect();
    refused(&turned(&circle, G), "multi-position", "lie in one plane");
    refused(
        &turned(&directions(16), 1.0),
        "multi-position",
        "looks like g",
    );
    refused(
        &turned(&directions(16), 4.0 * G),
        "multi-position",
        "where gravity is",
    );
    let moving: String = (0..6000).fold(
        "accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n".to_owned(),
        |mut text, k| {
            let t = f64::from(k) * 0.01;
            let _ = writeln!(
                text,
                "{},{},{}",
                7.0 * (2.3 * t).sin(),
                7.0 * (3.1 * t).cos(),
                9.0 * (1.7 * t).sin()
            );
            text
        },
    );
    refused(&moving, "multi-position", "moves all the time");
    refused(
        "accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n0,0,9.8\n0,0,9.8\n",
        "multi-position",
        "too short",
    );
    refused(
        "gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n0,0,0\n0,0,0\n",
        "multi-position",
        "no accelerometer",
    );
}

/// A sweep of temperature with a gyro whose bias follows it.
fn sweep(from: f64, to: f64) -> String {
    let mut text =
        String::from("gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],temperature [degC]\n");
    let mut state = 3;
    for k in 0..8000 {
        let s = 1.0 - (f64::from(k) / 4000.0 - 1.0).abs();
        let t = from + (to - from) * s;
        let x = 1e-3 + 2e-5 * (t - 25.0);
        let mut v = || x + 1e-4 * noise(&mut state);
        let _ = writeln!(text, "{},{},{},{t}", v(), v(), v());
    }
    text
}

#[test]
fn a_sweep_gives_curves_and_a_constant_temperature_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), sweep(-20.0, 60.0)).unwrap();
    let output = sagnac(
        folder.path(),
        &[
            "calibrate",
            "thermal",
            "log.csv",
            "--rate",
            "2Hz",
            "-o",
            "m.toml",
            "--report",
            "r.html",
            "--format",
            "json",
        ],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["branches"].as_array().unwrap().len(), 2);
    assert_eq!(json["branches"][0]["direction"], "heating");
    let curve = &json["curves"][0];
    assert_eq!(curve["axis"], "gyro_x");
    assert_eq!(curve["order"], 1);
    assert!(curve["temperature"].as_array().unwrap().len() >= 21);
    let model = std::fs::read_to_string(folder.path().join("m.toml")).unwrap();
    assert!(model.contains("temperature_range") && model.contains("method = \"thermal\""));
    refused(
        &sweep(25.0, 25.5),
        "thermal",
        "tells nothing about its effect",
    );
    refused(
        &turned(&directions(3), G),
        "thermal",
        "no temperature channel",
    );
}
