//! `calibrate thermal` and `--schedule` with logs that do not rest, overlap, or are none.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use common::flat;
use serde_json::Value;

const CHANNELS: &str =
    "gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]";

/// A reproducible number in (−0.5, 0.5).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

/// A sweep from −20 to 60 °C and back in 3000 s at 2 Hz; `motion` adds to gyro and accelerometer of sample k.
fn sweep(seed: u64, motion: impl Fn(usize, &mut Noise) -> ([f64; 3], [f64; 3])) -> String {
    let mut text = format!("time [s],{CHANNELS},temperature [degC]\n");
    let mut noise = Noise(seed);
    for k in 0..6000 {
        let t = -20.0 + 80.0 * (1.0 - (k as f64 / 3000.0 - 1.0).abs());
        let d = t - 25.0;
        let (w, f) = motion(k, &mut noise);
        let mut row = vec![0.5 * (k + 1) as f64];
        for (i, w) in w.iter().enumerate() {
            // A cubic, so that a spline has something to follow.
            row.push(w + 1e-5 * (i + 1) as f64 * d + 1e-8 * d.powi(3) + 3e-4 * noise.next());
        }
        for (i, f) in f.iter().enumerate() {
            row.push(f + 1e-3 * (i + 1) as f64 * d + 0.017 * noise.next());
        }
        row.push(t);
        let cells: Vec<String> = row.iter().map(|v| format!("{v:.9}")).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

const UP: [f64; 3] = [0.0, 0.0, 9.806];

fn run(folder: &Path, files: &[(&str, &str)], arguments: &[&str]) -> Output {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn refused(files: &[(&str, &str)], arguments: &[&str], wanted: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), files, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {error}");
    for word in wanted {
        assert!(flat(&error).contains(word), "{word}: {error}");
    }
}

fn json(output: &Output) -> Value {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_sweep_at_rest_has_no_findings() {
    let folder = tempfile::tempdir().unwrap();
    let text = sweep(1, |_, _| ([0.0; 3], UP));
    let found = json(&run(
        folder.path(),
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv", "--format", "json"],
    ));
    assert_eq!(found["issues"], Value::Array(Vec::new()));
}

#[test]
fn outputs_without_gravity_have_no_direction() {
    let folder = tempfile::tempdir().unwrap();
    let log = sweep(9, |_, _| ([0.0; 3], [0.02, -0.01, 0.03]));
    let output = run(
        folder.path(),
        &[("log.csv", &log)],
        &["calibrate", "thermal", "log.csv", "-o", "m.toml"],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn motion_all_through_is_refused() {
    let text = sweep(2, |k, _| {
        let a = 0.5 * k as f64;
        ([a.sin(); 3], UP.map(|v| v + 5.0 * a.cos()))
    });
    refused(
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv", "-o", "m.toml"],
        &["moves all the time", "t.csv", "let the sensor rest"],
    );
}

#[test]
fn motion_for_a_while_is_left_out_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let text = sweep(3, |k, noise| {
        if !(2000..2600).contains(&k) {
            return ([0.0; 3], UP);
        }
        let mut shake = |size: f64| [0; 3].map(|_| size * noise.next());
        let (w, f) = (shake(3.0), shake(9.0));
        (w, [UP[0] + f[0], UP[1] + f[1], UP[2] + f[2]])
    });
    let found = json(&run(
        folder.path(),
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv", "--format", "json"],
    ));
    let issues = found["issues"].as_array().unwrap();
    assert_eq!(issues.len(), 1, "{issues:?}");
    assert_eq!(issues[0]["kind"], "motion");
    let time = |key: &str| issues[0][key].as_f64().unwrap();
    assert!((time("start_s") - 1000.0).abs() < 30.0 && (time("end_s") - 1300.0).abs() < 30.0);
    // What is left gives the curve of a sweep at rest.
    for curve in found["curves"].as_array().unwrap() {
        let rms = curve["residual_rms"].as_f64().unwrap();
        let is_gyro = curve["axis"].as_str().unwrap().starts_with("gyro");
        assert!(rms < if is_gyro { 1e-4 } else { 6e-3 }, "{curve}");
    }
}

#[test]
fn a_turn_at_an_even_rate_is_left_out_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let log = sweep(8, |k, _| {
        let turns = (3000..3200).contains(&k);
        ([0.0, 0.0, if turns { 0.5 } else { 0.0 }], UP)
    });
    let output = run(
        folder.path(),
        &[("log.csv", &log)],
        &[
            "calibrate",
            "thermal",
            "log.csv",
            "--up",
            "+z",
            "--format",
            "json",
            "-o",
            "m.toml",
        ],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found = json(&output);
    let issues = found["issues"].as_array().unwrap();
    assert_eq!(issues.len(), 1, "{issues:?}");
    let text = issues[0]["text"].as_str().unwrap();
    assert!(
        text.contains("0.5 rad/s") && text.contains("gyro_z"),
        "{text}"
    );
    assert!((issues[0]["start_s"].as_f64().unwrap() - 1500.0).abs() < 60.0);
}

#[test]
fn another_pose_is_refused() {
    let text = sweep(4, |k, _| {
        ([0.0; 3], if k < 3000 { UP } else { [UP[2], 0.0, 0.0] })
    });
    refused(
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv"],
        &["deg at 25:00", "--start and --end"],
    );
}

#[test]
fn a_log_counts_once() {
    let text = sweep(5, |_, _| ([0.0; 3], UP));
    refused(
        &[("t.csv", &text), ("copy.csv", &text)],
        &["calibrate", "thermal", "t.csv", "copy.csv"],
        &["hold the same samples", "count twice"],
    );
}

#[test]
fn what_the_output_says_of_up_and_units() {
    let text = sweep(6, |_, _| ([0.0; 3], UP));
    refused(
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv", "--up", "-z"],
        &["-z is said to be up", "write --up +z"],
    );
    let in_g = sweep(7, |_, _| ([0.0; 3], [0.0, 0.0, 1.0]));
    refused(
        &[("t.csv", &in_g)],
        &["calibrate", "thermal", "t.csv"],
        &["looks like g", "accel_x", "[g] in the header"],
    );
}

#[test]
fn zero_degrees_have_no_sign() {
    let folder = tempfile::tempdir().unwrap();
    let text = sweep(8, |_, _| ([0.0; 3], UP));
    let output = run(
        folder.path(),
        &[("t.csv", &text)],
        &["calibrate", "thermal", "t.csv"],
    );
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("at 0 degC") && !text.contains("at -0 degC"),
        "{text}"
    );
}

#[test]
fn the_page_is_a_certificate_with_both_units() {
    let folder = tempfile::tempdir().unwrap();
    let text = sweep(12, |_, _| ([0.0; 3], UP));
    let output = run(
        folder.path(),
        &[("t.csv", &text)],
        &[
            "calibrate",
            "thermal",
            "t.csv",
            "--up",
            "+z",
            "--item",
            "IMU <7>",
            "--customer",
            "Laboratory",
            "--certificate",
            "T-1",
            "--report",
            "r.html",
        ],
    );
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    for wanted in [
        "IMU &lt;7&gt;",
        "Laboratory",
        "No. T-1",
        "k = 2",
        "name=\"units\" value=\"si\"",
        "<tr data-sensor=\"gyro\" data-term=\"bias\">",
        "<tr data-sensor=\"accel\" data-term=\"bias.temperature.1\">",
        "data-plot=\"calibration-before\"",
        "data-plot=\"calibration-after\"",
        "Bias at −20 °C",
    ] {
        assert!(page.contains(wanted), "{wanted}");
    }
    let residuals = page.matches("data-plot=\"calibration-residuals\"").count();
    assert_eq!(residuals, 6);
}

const OTHER: &str = "schema = 1\nname = \"faces\"\n[gyro.bias]\nfixed = { value = [\"0 rad/s\", \"0 rad/s\", \"0 rad/s\"], \
    sigma = [\"1 rad/s\", \"1 rad/s\", \"1 rad/s\"] }\n[gyro.scale_factor]\nfixed = { value = [\"10 ppm\", \"20 ppm\", \
    \"30 ppm\"], sigma = [\"1 ppm\", \"1 ppm\", \"1 ppm\"] }\n";

/// The gyro's bias of a model at temperatures, as `explain` has it.
fn bias_at(folder: &Path, model: &str, t_c: f64) -> Vec<f64> {
    let at = format!("f=0 0 9.8 m/s^2, w=0 0 0 deg/s, T={t_c} degC");
    let found = json(&run(
        folder,
        &[],
        &["explain", model, "--at", &at, "--format", "json"],
    ));
    let axes = found["axes"].as_array().unwrap();
    axes.iter()
        .filter(|a| a["axis"].as_str().unwrap().starts_with("gyro"))
        .map(|a| a["output"].as_f64().unwrap())
        .collect()
}

#[test]
fn a_spline_is_merged_whole() {
    let folder = tempfile::tempdir().unwrap();
    let text = sweep(9, |_, _| ([0.0; 3], UP));
    let thermal = |log: &str, more: &[&str]| {
        let mut words = vec!["calibrate", "thermal", log, "--force"];
        words.extend(more);
        let output = run(folder.path(), &[(log, &text)], &words);
        assert!(output.status.success(), "{output:?}");
    };
    thermal("a.csv", &["--form", "spline", "-o", "spline.toml"]);
    // T0 on a knot, where a row is exactly zero; and another T0 than that of the result.
    thermal(
        "a.csv",
        &[
            "--form",
            "spline",
            "--reference-temperature",
            "-20 degC",
            "-o",
            "knot.toml",
        ],
    );
    for (first, second) in [
        ("spline.toml", "faces.toml"),
        ("faces.toml", "knot.toml"),
        ("knot.toml", "faces.toml"),
    ] {
        let merged = run(
            folder.path(),
            &[("faces.toml", OTHER)],
            &[
                "calibrate",
                "merge",
                first,
                second,
                "-o",
                "m.toml",
                "--force",
            ],
        );
        assert!(
            merged.status.success(),
            "{}",
            String::from_utf8_lossy(&merged.stderr)
        );
        for t_c in [-20.0, 0.0, 25.0, 51.0] {
            let want = bias_at(folder.path(), "spline.toml", t_c);
            let got = bias_at(folder.path(), "m.toml", t_c);
            for (got, want) in got.iter().zip(&want) {
                // The other model weighs 1e-10 of this one.
                assert!(
                    (got - want).abs() < 1e-9,
                    "{first} {second} {t_c}: {got} {want}"
                );
            }
        }
    }
    // Of another log: other knots, or a polynomial.
    let other = sweep(10, |_, _| ([0.0; 3], UP));
    let words = [
        "calibrate",
        "thermal",
        "b.csv",
        "--end",
        "2000s",
        "-o",
        "other.toml",
    ];
    for (form, wanted) in [
        ("spline", "other knots"),
        ("polynomial", "a polynomial in another"),
    ] {
        let mut words = words.to_vec();
        words.extend(["--form", form, "--force"]);
        assert!(
            run(folder.path(), &[("b.csv", &other)], &words)
                .status
                .success()
        );
        let output = run(
            folder.path(),
            &[],
            &["calibrate", "merge", "spline.toml", "other.toml"],
        );
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1));
        assert!(flat(&error).contains(wanted), "{error}");
    }
}

/// Six faces of 10 s with 2 s of shaking between, 100 Hz.
fn faces() -> String {
    let mut text = format!("time [s],{CHANNELS}\n");
    let mut noise = Noise(11);
    let mut k = 0;
    for face in 0..6 {
        for part in 0..1200 {
            k += 1;
            let shaken = if part < 1000 { 0.0 } else { 1.0 };
            let mut row = vec![f64::from(k) / 100.0];
            row.extend([0; 3].map(|_| shaken * noise.next() + 1e-3 * noise.next()));
            for axis in 0..3 {
                let rest = if face / 2 == axis {
                    9.8 - 19.6 * f64::from(face % 2)
                } else {
                    0.0
                };
                row.push(rest + 5.0 * shaken * noise.next() + 0.01 * noise.next());
            }
            let cells: Vec<String> = row.iter().map(|v| format!("{v:.9}")).collect();
            let _ = writeln!(text, "{}", cells.join(","));
        }
    }
    text
}

/// A schedule whose spans start every 12 s and last `lengths`.
fn schedule(lengths: [f64; 6]) -> String {
    let mut text = "station,up,start [s],end [s]\n".to_owned();
    for (i, up) in ["+x", "-x", "+y", "-y", "+z", "-z"].iter().enumerate() {
        let start = 12.0 * i as f64;
        let _ = writeln!(text, "face{i},{up},{start},{}", start + lengths[i]);
    }
    text
}

#[test]
fn spans_that_overlap_or_move() {
    let log = faces();
    let words = ["calibrate", "stations", "l.csv", "--schedule", "s.csv"];
    refused(
        &[
            ("l.csv", &log),
            ("s.csv", &schedule([16.0, 10.0, 10.0, 10.0, 10.0, 10.0])),
        ],
        &words,
        &[
            "station face1 starts at 12 s, before station face0 ends at 16 s",
            "do not overlap",
        ],
    );
    let notes = |lengths: [f64; 6]| {
        let folder = tempfile::tempdir().unwrap();
        let output = run(
            folder.path(),
            &[("l.csv", &log), ("s.csv", &schedule(lengths))],
            &words,
        );
        assert!(output.status.success());
        flat(&String::from_utf8_lossy(&output.stdout))
    };
    assert!(!notes([10.0; 6]).contains("not steady"));
    let said = notes([10.0, 10.0, 11.5, 10.0, 10.0, 10.0]);
    assert!(
        said.contains("not steady all through its station (face2 at 33.")
            && !said.contains("face3 at"),
        "{said}"
    );
}

#[test]
fn dwells_are_in_the_json_also_where_they_do_not_match() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(
        folder.path(),
        &[("l.csv", &faces()), ("s.csv", "up\n+x\n-x\n")],
        &[
            "calibrate",
            "stations",
            "l.csv",
            "--schedule",
            "s.csv",
            "--format",
            "json",
        ],
    );
    assert_eq!(output.status.code(), Some(1));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let stations = found["stations"].as_array().unwrap();
    assert_eq!(stations.len(), 6);
    assert!((stations[1]["start_s"].as_f64().unwrap() - 12.15).abs() < 0.2);
    assert!(stations[1]["end_s"].as_f64().unwrap() < 22.0);
}

#[test]
fn tables_where_a_log_is_wanted_and_the_other_way_round() {
    let plan = "station,up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n1,+x,,,\n2,-x,,,\n";
    for words in [
        &["multi-position", "p.csv"][..],
        &["thermal", "p.csv"],
        &["stations", "p.csv", "--schedule", "p.csv"],
    ] {
        let mut all = vec!["calibrate"];
        all.extend(words);
        refused(
            &[("p.csv", plan)],
            &all,
            &[
                "a table of stations, not a log",
                "calibrate stations reads it",
            ],
        );
    }
    refused(
        &[("p.csv", plan)],
        &["calibrate", "stations", "p.csv"],
        &["outputs of all stations are empty", "fill in"],
    );
}

#[test]
fn a_standard_error_of_a_reading_is_above_zero() {
    for se in ["0", "-0.1"] {
        let text = format!(
            "reference [deg/s],output [deg/s],output_se [deg/s]\n1,1,0.1\n2,2.1,{se}\n3,3,0.1\n"
        );
        refused(
            &[("r.csv", &text)],
            &["response", "r.csv"],
            &[
                "standard error of reading 2 is not above zero",
                "r.csv, line 3",
            ],
        );
    }
}
