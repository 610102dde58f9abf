//! The sensor model through the built program: samples that are flagged or told, columns that are kept, the same bytes
//! for any number of threads, the round trip.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::part::{CORRECT, flags, folder, said};
use common::sagnac;

#[test]
fn temperatures_outside_the_stated_range_are_told_and_flagged() {
    let folder = folder(|k, row| {
        if k == 7 {
            row[7] = "80".to_owned();
        }
    });
    said(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--rest",
            "10 s",
            "--temperature",
            "ramp 20 degC 90 degC",
            "-o",
            "hot.csv",
        ],
        "temperature",
    );
    said(
        folder.path(),
        &CORRECT,
        "outside the temperature range of the model",
    );
    let flags = flags(&folder.path().join("out.csv"));
    assert_eq!((flags[6], flags[7], flags[8]), (0, 4, 0));
}

#[test]
fn gaps_in_the_inputs_are_warned_of() {
    let folder = folder(|k, row| {
        if k >= 60 {
            row[0] = ((k + 51) as f64 / 100.0).to_string();
        }
    });
    said(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--inputs",
            "log.csv",
            "-o",
            "sim.csv",
        ],
        "gap",
    );
}

#[test]
fn repeated_and_backward_stamps_are_told_as_what_they_are() {
    let folder = folder(|k, row| match k {
        30 => row[0] = "0.3".to_owned(),
        60 => row[0] = "0.2".to_owned(),
        _ => {}
    });
    let inputs = [
        "simulate",
        "part.toml",
        "--inputs",
        "log.csv",
        "-o",
        "sim.csv",
    ];
    for args in [&inputs[..], &CORRECT] {
        for word in [
            "1 time stamp equal to the one before, in row 31",
            "1 time stamp earlier than the one before, in row 61",
        ] {
            said(folder.path(), args, word);
            for name in ["sim.csv", "out.csv"] {
                let _ = fs::remove_file(folder.path().join(name));
            }
        }
    }
}

#[test]
fn correct_keeps_the_columns_that_are_not_named() {
    let folder = folder(|_, _| {});
    let text = fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let mut lines = text.lines();
    let mut other = lines
        .next()
        .unwrap()
        .replace("temperature [degC]", "fan [Hz],note");
    for (k, line) in lines.enumerate() {
        let _ = write!(other, "\n{line},{}", if k % 2 == 0 { "on" } else { "off" });
    }
    fs::write(folder.path().join("other.csv"), other + "\n").unwrap();
    said(
        folder.path(),
        &[
            "correct",
            "part.toml",
            "other.csv",
            "--columns",
            "time=0:s, gyro=1,2,3:rad/s, accel=4,5,6:m/s^2",
            "-o",
            "kept.csv",
        ],
        "cannot take out",
    );
    let kept = fs::read_to_string(folder.path().join("kept.csv")).unwrap();
    let mut lines = kept.lines();
    assert!(lines.next().unwrap().ends_with("fan [Hz],note"));
    let first = lines.next().unwrap();
    assert!(first.ends_with(",30,on"), "{first}");
}

#[test]
fn samples_outside_a_bound_that_was_not_known_before_are_told_with_q() {
    let folder = folder(|k, row| {
        if k == 50 {
            row[1] = "60".to_owned();
        }
    });
    fs::write(
        folder.path().join("open.toml"),
        "name = \"Open\"\n[gyro.scale_factor]\nquadratic = \"0.005 s/rad\"\n",
    )
    .unwrap();
    let args = [
        "correct",
        "open.toml",
        "log.csv",
        "--flags",
        "-o",
        "out.csv",
    ];
    said(
        folder.path(),
        &args,
        "1 sample is outside the convergence bound (q up to 0.9",
    );
    let flags = flags(&folder.path().join("out.csv"));
    assert_eq!((flags[49] & 8, flags[50] & 8, flags[51] & 8), (0, 8, 0));
}

#[test]
fn saturated_samples_are_flagged_one_by_one() {
    let folder = folder(|k, row| match k {
        10 => row[1] = "1.7453292519943295".to_owned(),
        11 => row[6] = "-39.2266".to_owned(),
        12 => (row[3], row[4]) = ("-5".to_owned(), "60".to_owned()),
        _ => {}
    });
    said(folder.path(), &CORRECT, "saturated");
    let flags = flags(&folder.path().join("out.csv"));
    assert_eq!(
        [
            flags[9] & 3,
            flags[10] & 3,
            flags[11] & 3,
            flags[12] & 3,
            flags[13] & 3
        ],
        [0, 1, 2, 3, 0]
    );
}

#[test]
fn the_rate_of_the_log_wins_with_a_warning() {
    let folder = folder(|k, row| row[0] = ((k + 1) as f64 / 50.0).to_string());
    said(
        folder.path(),
        &CORRECT,
        "the log has 50 Hz, the model 100 Hz",
    );
    said(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--inputs",
            "log.csv",
            "-o",
            "sim.csv",
        ],
        "50 Hz",
    );
}

/// A limit on the size of files stands for a full disk: writing fails half-way.
#[cfg(unix)]
#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    for name in ["one.npy", "two.npy", "four.npy"] {
        let threads = match name {
            "one.npy" => "1",
            "two.npy" => "2",
            _ => "4",
        };
        let args = [
            "simulate",
            "part.toml",
            "--trajectory",
            "drive",
            "--duration",
            "5 min",
            "--seed",
            "7",
            "--threads",
            threads,
            "-o",
            name,
        ];
        assert!(sagnac(at, &args).status.success());
        let corrected = format!("corrected-{name}");
        let args = [
            "correct",
            "part.toml",
            name,
            "--flags",
            "--threads",
            threads,
            "-o",
            &corrected,
        ];
        assert!(sagnac(at, &args).status.success());
        for pair in [("one.npy", name), ("corrected-one.npy", corrected.as_str())] {
            assert!(
                fs::read(at.join(pair.0)).unwrap() == fs::read(at.join(pair.1)).unwrap(),
                "{name}"
            );
        }
    }
}

/// Run 1 of several is the run made alone, and another run has other draws.
#[test]
fn runs_have_draws_of_their_own_and_the_first_is_the_run_alone() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    let args = ["simulate", "part.toml", "--rest", "10 s", "-o"];
    assert!(
        sagnac(at, &[&args[..], &["a.csv"]].concat())
            .status
            .success()
    );
    assert!(
        sagnac(at, &[&args[..], &["b.csv", "--runs", "2"]].concat())
            .status
            .success()
    );
    let read = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(read("a.csv") == read("b-0001.csv"));
    assert!(read("a.csv") != read("b-0002.csv"));
}

/// correct ∘ simulate = identity on a log of truth, where the model has neither noise nor rounding.
#[test]
fn correct_undoes_simulate() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    let simulate = [
        "simulate",
        "part.toml",
        "--inputs",
        "log.csv",
        "--noise",
        "none",
        "-o",
        "sim.csv",
    ];
    assert!(sagnac(at, &simulate).status.success());
    assert!(
        sagnac(at, &["correct", "part.toml", "sim.csv", "-o", "back.csv"])
            .status
            .success()
    );
    let numbers = |name: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(at.join(name)).unwrap();
        text.lines()
            .skip(1)
            .map(|l| l.split(',').map(|c| c.parse().unwrap()).collect())
            .collect()
    };
    for (want, got) in numbers("log.csv").iter().zip(numbers("back.csv")) {
        for (column, (want, got)) in want.iter().zip(got).enumerate() {
            // Angular acceleration is a slope of samples: the accelerometer's size effect is exact to its error only.
            let allowed = if (4..7).contains(&column) {
                1e-6
            } else {
                1e-11
            };
            assert!(
                (want - got).abs() <= allowed,
                "column {column}: {want} {got}"
            );
        }
    }
}

#[test]
fn a_path_is_read_under_other_names_and_as_euroc_ground_truth() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| sagnac(folder.path(), args);
    let mut own = String::from("time [s],position_x [m],position_y [m],position_z [m]\n");
    let mut other = String::from("tt,a,b,c\n");
    let mut euroc = String::from(
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n",
    );
    for k in 0..40_u32 {
        let t = f64::from(k) * 0.25;
        let (x, y, z) = (3.0 * t, 0.1 * t * t, 0.0);
        let _ = writeln!(own, "{t},{x},{y},{z}");
        let _ = writeln!(other, "{t},{x},{y},{z}");
        let ns = 1_403_636_580_838_555_648_u64 + u64::from(k) * 250_000_000;
        let _ = writeln!(euroc, "{ns},{x},{y},{z},1,0,0,0");
    }
    for (name, text) in [("own.csv", own), ("other.csv", other), ("euroc.csv", euroc)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let model = "catalog:ADIS16470";
    let columns = "time=tt:s, position=a,b,c:m";
    for args in [
        &[
            "simulate",
            model,
            "--trajectory",
            "own.csv",
            "-o",
            "own-log.csv",
        ][..],
        &[
            "simulate",
            model,
            "--trajectory",
            "other.csv",
            "--reference-columns",
            columns,
            "-o",
            "other-log.csv",
        ],
        &[
            "simulate",
            model,
            "--trajectory",
            "euroc.csv",
            "-o",
            "euroc-log.csv",
        ],
    ] {
        let output = run(args);
        assert!(
            output.status.success(),
            "{args:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("own-log.csv"), read("other-log.csv"));

    let same = run(&[
        "simulate", model, "--rest", "1s", "-o", "k.csv", "--truth", "./k.csv",
    ]);
    assert_eq!(same.status.code(), Some(2));
    assert!(!folder.path().join("k.csv").exists());

    assert!(
        run(&["correct", model, "own-log.csv", "--flags", "-o", "once.csv"])
            .status
            .success()
    );
    let twice = run(&["correct", model, "once.csv", "--flags", "-o", "twice.csv"]);
    assert_eq!(twice.status.code(), Some(1));
}

#[test]
fn slopes_of_the_corrected_rates_are_told() {
    let folder = folder(|_, _| {});
    said(
        folder.path(),
        &["correct", "part.toml", "log.csv", "-o", "out.csv"],
        "the angular acceleration of the axis offset is the slope of the corrected rates",
    );
}

#[test]
fn the_page_of_explain_lists_the_random_terms() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    said(
        at,
        &["explain", "part.toml", "--report", "page.html"],
        "page.html",
    );
    let page = fs::read_to_string(at.join("page.html")).unwrap();
    let table = page.split("data-table=\"gyro-noise\"").nth(1).unwrap();
    let table = table.split("</table>").next().unwrap();
    for part in [
        "Noise, 1σ of a sample, °/h",
        "noise.angle_random_walk",
        "bias.stability",
    ] {
        assert!(table.contains(part), "{table}");
    }
}
