//! Logs on their way through `simulate`, `correct` and `convert`: what is left out, rounded, counted or
//! cannot be written is said, and nothing is half written.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::{BIASES, biased_part as folder, refused, said};

#[test]
fn biases_and_flags_of_another_run_do_not_reach_the_output() {
    let folder = folder();
    let at = folder.path();
    let simulate = ["simulate", "part.toml", "--force"];
    said(
        at,
        &[
            &simulate[..],
            &["--rest", "1s", "-o", "a.csv", "--truth", "t.csv"],
        ]
        .concat(),
    );
    let truth = fs::read_to_string(at.join("t.csv")).unwrap();
    // As a column of the user's would look.
    let mut rows = truth.lines();
    let mut text = format!("{},flags,lap\n", rows.next().unwrap());
    for row in rows {
        let _ = writeln!(text, "{row},1,7");
    }
    fs::write(at.join("t.csv"), text).unwrap();
    for out in ["b.csv", "b.npy"] {
        let text = said(
            at,
            &[
                &simulate[..],
                &["--inputs", "t.csv", "--seed", "5", "-o", out],
            ]
            .concat(),
        );
        assert!(
            text.contains("of t.csv tell of the run that wrote it: left out, and --truth writes those of this run"),
            "{text}"
        );
        let head = fs::read(at.join(out)).unwrap();
        let head = String::from_utf8_lossy(&head[..1500]).into_owned();
        assert!(!head.contains("bias_") && !head.contains("flags"), "{head}");
        // The motion is this run's as well, and a column of the user's stays.
        assert!(
            head.contains("latitude [deg]") && head.contains("lap"),
            "{head}"
        );
    }
    let out = fs::read_to_string(at.join("b.csv")).unwrap();
    let wide = |line: &str| line.split(',').count();
    let head = wide(out.lines().next().unwrap());
    assert!(
        out.lines()
            .all(|line| wide(line) == head && (line.ends_with(",7") || line.ends_with("lap")))
    );
}

#[test]
fn a_log_without_time_begins_at_one_interval_everywhere() {
    let folder = folder();
    let at = folder.path();
    let rows: String = (0..300)
        .map(|k| format!("{},0,0\n", f64::from(k) / 512.0))
        .collect();
    fs::write(
        at.join("bare.csv"),
        format!("gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n{rows}"),
    )
    .unwrap();
    let times = |name: &str| -> Vec<String> {
        said(at, &["convert", name, "-o", "times.csv", "--force"]);
        let text = fs::read_to_string(at.join("times.csv")).unwrap();
        let first = |line: &str| line.split(',').next().unwrap().to_owned();
        text.lines().skip(1).map(first).collect()
    };
    for command in [
        &["convert", "bare.csv"][..],
        &["correct", "part.toml", "bare.csv"],
        &["simulate", "part.toml", "--inputs", "bare.csv"],
    ] {
        for name in ["a.csv", "a.npy", "a.npz", "a.parquet", "a.mcap", "a.bag"] {
            said(
                at,
                &[command, &["--rate", "100Hz", "-o", name, "--force"]].concat(),
            );
            let times = times(name);
            assert_eq!(times.len(), 300, "{command:?} {name}");
            assert_eq!(
                [&times[0], &times[1], &times[6], &times[299]],
                ["0.01", "0.02", "0.07", "3"],
                "{command:?} {name}"
            );
        }
    }
    said(
        at,
        &[
            "convert",
            "bare.csv",
            "--rate",
            "100Hz",
            "--resample",
            "50Hz",
            "-o",
            "a.npy",
            "--force",
        ],
    );
    assert_eq!(times("a.npy")[..3], ["0.01", "0.03", "0.05"]);
}

#[test]
fn whole_numbers_that_a_float_rounds_are_told() {
    let folder = folder();
    let at = folder.path();
    let rows: String = (0..100)
        .map(|k| {
            format!(
                "{},0,0,0,{},{k}\n",
                f64::from(k) / 100.0,
                9_007_199_254_740_993_i64 + i64::from(k)
            )
        })
        .collect();
    let log = format!("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],id,lap\n{rows}");
    fs::write(at.join("ids.csv"), &log).unwrap();
    for name in ["a.npy", "a.npz", "a.parquet"] {
        let text = said(at, &["convert", "ids.csv", "-o", name]);
        assert!(
            text.contains(
                "column `id`: whole numbers beyond 2^53 are rounded to the 16 digits of a float"
            ),
            "{text}"
        );
        assert_eq!(text.matches("2^53").count(), 1, "{text}");
    }
    let text = said(at, &["convert", "ids.csv", "-o", "a.csv"]);
    assert!(!text.contains("2^53"), "{text}");
    assert_eq!(fs::read_to_string(at.join("a.csv")).unwrap(), log);
}

#[test]
fn lines_that_end_by_carriage_returns_are_lines() {
    let folder = folder();
    let at = folder.path();
    // Longer than what is looked at before the first row is read.
    let rows: String = (0..20_000)
        .map(|k| {
            format!(
                "{},{},0.5,-0.25\n",
                f64::from(k) / 100.0,
                f64::from(k % 64) / 64.0
            )
        })
        .collect();
    let log = format!("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n{rows}");
    for (name, end) in [("cr.csv", "\r"), ("crlf.csv", "\r\n")] {
        fs::write(at.join(name), log.replace('\n', end)).unwrap();
        said(at, &["convert", name, "-o", "out.csv", "--force"]);
        assert!(
            fs::read_to_string(at.join("out.csv")).unwrap() == log,
            "{name}"
        );
    }
}

/// A file system that is full (`/dev/full`), one that fills up half-way, and a place where there can be no folder.
#[cfg(unix)]
#[test]
fn emitted_source_that_cannot_be_written_leaves_nothing_behind() {
    let folder = folder();
    let at = folder.path();
    let names = |of: &Path| -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(of)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let emit = |language: &str, out: &str| {
        refused(
            at,
            &[
                "correct",
                "part.toml",
                "--emit",
                language,
                "-o",
                out,
                "--force",
            ],
            1,
        )
    };
    for (language, file) in [
        ("c", "sagnac_correct_f64.c"),
        ("c", "sagnac_correct_f64_example.c"),
        ("rust", "sagnac_correct.rs"),
    ] {
        let out = at.join("full");
        fs::create_dir(&out).unwrap();
        std::os::unix::fs::symlink("/dev/full", out.join(file)).unwrap();
        fs::write(out.join("sagnac_correct_f64.h"), "old").unwrap();
        let text = emit(language, "full");
        assert!(text.contains(file) && text.contains("no space"), "{text}");
        let mut left = vec![file.to_owned(), "sagnac_correct_f64.h".to_owned()];
        left.sort();
        assert_eq!(names(&out), left, "{language} {file}");
        assert_eq!(fs::read(out.join("sagnac_correct_f64.h")).unwrap(), b"old");
        fs::remove_dir_all(&out).unwrap();
    }
    let text = emit("c", "part.toml/source");
    assert!(text.contains("part.toml/source"), "{text}");
    // The first files fit, a later one does not.
    for language in ["c", "rust"] {
        let script = format!(
            "trap '' XFSZ; ulimit -f 2; exec {} correct part.toml --emit {language} -o new/deep",
            env!("CARGO_BIN_EXE_sagnac")
        );
        let output = std::process::Command::new("bash")
            .current_dir(at)
            .args(["-c", &script])
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.starts_with("error: new/deep/"), "{text}");
        assert_eq!(names(at), ["part.toml"], "{text}");
    }
}

#[test]
fn nonlinearity_between_the_bound_and_its_end_is_warned_of_and_beyond_it_refused() {
    let folder = folder();
    let at = folder.path();
    said(
        at,
        &["simulate", "part.toml", "--rest", "1s", "-o", "log.csv"],
    );
    let model = |quadratic: f64| {
        let text = format!(
            "name = \"bent\"\nsample_rate = \"100 Hz\"\n[gyro]\nrange = \"100 deg/s\"\n\
             [gyro.scale_factor]\nquadratic = \"{quadratic} s/rad\"\n[accel]\nrange = \"4 g\"\n"
        );
        fs::write(at.join("bent.toml"), text).unwrap();
    };
    let correct = [
        "correct",
        "bent.toml",
        "log.csv",
        "--flags",
        "--force",
        "-o",
        "out.csv",
    ];
    // mu + nu = 2 k2 U, U = 1.5 times the range: 0.26, 0.52, 0.79, 1.05.
    model(0.05);
    assert!(!said(at, &correct).contains("warning"));
    for quadratic in [0.1, 0.15] {
        model(quadratic);
        let text = said(at, &correct);
        let q = format!("q = {:.3}", quadratic * 3.0 * 100_f64.to_radians());
        assert!(
            text.contains(&q) && text.contains("every sample is flagged"),
            "{text}"
        );
        let out = fs::read_to_string(at.join("out.csv")).unwrap();
        assert!(out.lines().skip(1).all(|line| line.ends_with(",8")));
        let text = refused(at, &["correct", "bent.toml", "--emit", "c", "-o", "c"], 1);
        assert!(text.contains("outside the convergence bound"), "{text}");
    }
    model(0.2);
    let text = refused(at, &correct, 1);
    assert!(
        text.contains("mu + nu = 1.047")
            && text.contains("quadratic and cubic count at the end of the range"),
        "{text}"
    );
    let text = said(
        at,
        &["simulate", "bent.toml", "--rest", "1s", "-o", "s.csv"],
    );
    assert!(text.contains("`correct` refuses this model"), "{text}");
}

#[test]
fn numbers_beyond_the_largest_are_told_as_too_large() {
    let folder = folder();
    let at = folder.path();
    let with = |value: &str| {
        fs::write(
            at.join("m.toml"),
            format!("name = \"m\"\n[gyro.bias]\nfixed = \"{value}\"\n"),
        )
        .unwrap();
    };
    with("1e309 deg/h");
    let text = refused(at, &["explain", "m.toml"], 1);
    assert!(
        text.contains("too large: \"1e309 deg/h\" is beyond 1.8e308 in SI"),
        "{text}"
    );
    with("inf deg/h");
    let text = refused(at, &["explain", "m.toml"], 1);
    assert!(text.contains("not finite: \"inf deg/h\""), "{text}");
    with("1e300 deg/h");
    let text = said(at, &["explain", "m.toml"]);
    assert!(
        text.contains("a gyro parameter is too large to reckon with")
            && text.contains("bias.fixed 1.00e300"),
        "{text}"
    );
    let text = refused(at, &["explain", "m.toml", "--at", "w=0 0 1e200 deg/s"], 2);
    assert!(text.contains("w is too large to reckon with"), "{text}");
}

#[test]
fn convert_takes_the_rate_of_the_log_and_refuses_one_that_leaves_no_log() {
    let folder = folder();
    let at = folder.path();
    // 50 Hz; the model of the covariances has 2000 Hz.
    let rows: String = (1..=100)
        .map(|k| format!("{},0,0,0,0,0,-9.8\n", f64::from(k) / 50.0))
        .collect();
    let header = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]";
    fs::write(at.join("log.csv"), format!("{header}\n{rows}")).unwrap();
    let model = [
        "convert",
        "log.csv",
        "-o",
        "a.bag",
        "--model",
        "catalog:ADIS16470",
    ];
    let text = said(at, &model);
    assert!(
        text.contains("covariances are N² f of ADIS16470 at 50 Hz"),
        "{text}"
    );
    for (rate, words) in [
        ("1e-9Hz", "a log of 2 s has no two samples at 1e-9 Hz"),
        ("1e12Hz", "1e12 Hz would give 2e12 samples"),
    ] {
        let text = refused(
            at,
            &["convert", "log.csv", "-o", "b.csv", "--resample", rate],
            2,
        );
        assert!(text.contains(words) && text.contains("choose a"), "{text}");
    }
    let text = said(
        at,
        &["convert", "log.csv", "-o", "b.csv", "--resample", "25Hz"],
    );
    assert!(
        text.contains("resampled from 50 Hz to 25 Hz, low-passed at 11.25 Hz against aliases"),
        "{text}"
    );
}

#[test]
fn stamps_that_are_no_numbers_are_no_gaps_to_convert() {
    let folder = folder();
    let at = folder.path();
    let log = |bad: &[i32]| {
        let rows: String = (1..=100)
            .map(|k| {
                if bad.contains(&k) {
                    "nan,0,0,0\n".to_owned()
                } else {
                    format!("{},0,0,0\n", f64::from(k) / 100.0)
                }
            })
            .collect();
        let header = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]";
        fs::write(at.join("log.csv"), format!("{header}\n{rows}")).unwrap();
        said(at, &["convert", "log.csv", "-o", "a.csv", "--force"])
    };
    let text = log(&[40]);
    assert!(
        text.contains("the time stamp of row 40 is no finite number, and stays as it is")
            && !text.contains("gap"),
        "{text}"
    );
    let text = log(&[1, 60, 61]);
    assert!(
        text.contains("3 time stamps are no finite numbers, the first in row 1")
            && !text.contains("gap"),
        "{text}"
    );
    assert!(!log(&[]).contains("finite"));
    // Without two stamps there is no rate: as `info` refuses the log, what could not be read again is not written.
    for (numbers, words) in [
        (0, "no time stamp is a number"),
        (1, "one time stamp alone is a number"),
    ] {
        let rows: String = (0..100)
            .map(|k| if k < numbers { "0.5,0\n" } else { "nan,0\n" })
            .collect();
        fs::write(
            at.join("nan.csv"),
            format!("time [s],gyro_x [rad/s]\n{rows}"),
        )
        .unwrap();
        for line in ["info nan.csv", "convert nan.csv -o n.csv"] {
            let text = refused(at, &line.split(' ').collect::<Vec<_>>(), 1);
            assert!(
                text.contains(words) && text.contains("add --rate"),
                "{line}: {text}"
            );
        }
        let told = "convert nan.csv --rate 100Hz -o n.csv --force";
        said(at, &told.split(' ').collect::<Vec<_>>());
        fs::remove_file(at.join("n.csv")).unwrap();
    }
    // A lone row tells no rate; a triad that is not whole is told with its log.
    fs::write(
        at.join("one.csv"),
        "time [s],gyro_x [rad/s],gyro_y [rad/s]\n0.01,0,0\n",
    )
    .unwrap();
    let text = said(at, &["convert", "one.csv", "-o", "b.csv"]);
    assert!(text.contains("1 sample, too few for a rate"), "{text}");
    let text = refused(at, &["correct", "part.toml", "one.csv", "-o", "c.csv"], 1);
    assert!(text.contains("but no gyro_z one.csv"), "{text}");
}

#[test]
fn a_log_is_resampled_whatever_a_channel_holds() {
    let folder = folder();
    let at = folder.path();
    // Constant, with a long run of no numbers, and with noise; a gap of time.
    let rows: String = (1..=400)
        .map(|k: i32| {
            let time = f64::from(if k > 200 { k + 300 } else { k }) / 100.0;
            let second = if (50..90).contains(&k) {
                f64::NAN
            } else {
                f64::from(k * 7919 % 101)
            };
            format!("{time},0.5,{second},{}\n", f64::from(k * 104_729 % 97))
        })
        .collect();
    let header = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]";
    fs::write(at.join("log.csv"), format!("{header}\n{rows}")).unwrap();
    for columns in ["gyro=1,2,3", "gyro=2,1,3", "gyro_x=1"] {
        let columns = format!("time=0:s, {columns}:rad/s");
        said(
            at,
            &[
                "convert",
                "log.csv",
                "--columns",
                &columns,
                "--resample",
                "50Hz",
                "-o",
                "a.csv",
                "--force",
            ],
        );
        let out = fs::read_to_string(at.join("a.csv")).unwrap();
        let rows: Vec<Vec<f64>> = out
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows.len(), 200, "{columns}");
        assert_eq!(
            [rows[0][0], rows[99][0], rows[100][0]],
            [0.01, 1.99, 5.01],
            "{columns}"
        );
        let steady = rows
            .iter()
            .filter(|row| row[1..].iter().any(|v| (v - 0.5).abs() < 1e-12));
        assert_eq!(steady.count(), 200, "{columns}");
    }
}

#[test]
fn a_bandwidth_that_changes_nothing_is_told() {
    let folder = folder();
    let at = folder.path();
    let text = format!("{BIASES}[gyro]\nbandwidth = \"60 Hz\"\n");
    fs::write(at.join("wide.toml"), text).unwrap();
    for (rate, is_told) in [("100Hz", true), ("200Hz", false)] {
        let text = said(
            at,
            &[
                "simulate",
                "wide.toml",
                "--rest",
                "1s",
                "--rate",
                rate,
                "-o",
                "a.csv",
                "--force",
            ],
        );
        let note = "gyro.bandwidth is not below half the rate, 50 Hz: it changes nothing";
        assert_eq!(text.contains(note), is_told, "{text}");
    }
}
