//! The sensor model through the built program: bad input to `simulate` and `correct` (refused, warned of or
//! flagged in one sentence, nothing half written), the same bytes for any number of threads, the round trip.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use common::{flat, sentences};

const MODEL: &str = r#"name = "Part"
sample_rate = "100 Hz"
temperature_range = ["-20 degC", "70 degC"]
[gyro]
range = "100 deg/s"
[gyro.bias]
fixed = "0.1 deg/s"
temperature = [["0.01 deg/s/K", "0 deg/s/K", "0 deg/s/K"]]
stability = "10 deg/h"
[gyro.bias.instability]
coefficient = "8 deg/h"
[gyro.g_sensitivity]
matrix = [["1 deg/h/g", "0 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "1 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "0 deg/h/g", "1 deg/h/g"]]
[gyro.noise]
angle_random_walk = "0.3 deg/sqrt(h)"
rate_random_walk = "1.5 deg/h/sqrt(h)"
gauss_markov = [{ sigma = "3 deg/h", correlation_time = "30 s" }]
[accel]
range = "4 g"
[accel.scale_factor]
fixed = "1000 ppm"
[accel.noise]
velocity_random_walk = "0.05 m/s/sqrt(h)"
[accel.axis_offset]
x = ["10 mm", "0 mm", "0 mm"]
"#;

const HEADER: &str = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],\
accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],temperature [degC]";

fn sagnac(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(args)
        .timeout(std::time::Duration::from_mins(2))
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the model, and `log.csv` of 100 rows after a change by `edit` (row, cells).
fn folder(edit: impl Fn(usize, &mut Vec<String>)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.toml"), MODEL).unwrap();
    let mut text = format!("{HEADER}\n");
    for k in 0..100 {
        let time = (k + 1) as f64 / 100.0;
        let mut row = vec![time.to_string()];
        for value in [0.1, -0.2, 0.3, 1.0, 0.5, -9.8, 30.0] {
            row.push((value + 1e-4 * f64::from((k * 7 % 11) as u32)).to_string());
        }
        edit(k, &mut row);
        let _ = writeln!(text, "{}", row.join(","));
    }
    fs::write(folder.path().join("log.csv"), text).unwrap();
    folder
}

/// Refused with this exit code and word, on three lines at most, and no file is left.
fn refused(folder: &Path, args: &[&str], code: i32, word: &str) {
    let before = fs::read_dir(folder).unwrap().count();
    let output = sagnac(folder, args);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
    assert!(said.starts_with("error: "), "{args:?}: {said}");
    assert!(sentences(&said) <= 3, "{args:?}: {said}");
    assert!(flat(&said).contains(word), "{args:?}: {said}");
    assert_eq!(
        fs::read_dir(folder).unwrap().count(),
        before,
        "{args:?} leaves a file"
    );
}

/// Done; standard output and error together hold the word.
fn said(folder: &Path, args: &[&str], word: &str) {
    let output = sagnac(folder, args);
    let all = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        stderr(&output)
    );
    assert!(output.status.success(), "{args:?}: {all}");
    // Sentences are wrapped to the terminal.
    let all = all.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(all.contains(word), "{args:?} lacks `{word}`: {all}");
}

/// Column `flags` of a corrected log.
fn flags(path: &Path) -> Vec<u32> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let at = lines
        .next()
        .unwrap()
        .split(',')
        .position(|name| name.starts_with("flags"))
        .unwrap();
    lines
        .map(|line| line.split(',').nth(at).unwrap().parse::<f64>().unwrap() as u32)
        .collect()
}

const CORRECT: [&str; 6] = [
    "correct",
    "part.toml",
    "log.csv",
    "-o",
    "out.csv",
    "--flags",
];

#[test]
fn singular_and_wildly_wrong_matrices_are_refused() {
    let folder = folder(|_, _| {});
    for (name, table, word) in [
        (
            "singular.toml",
            "[accel.scale_factor]\nfixed = [\"-100 %\", \"0 %\", \"0 %\"]\n",
            "singular",
        ),
        (
            "wild.toml",
            "[gyro.scale_factor]\nfixed = \"300 %\"\n",
            "as large as the signal",
        ),
        (
            "lean.toml",
            "[gyro.misalignment]\nfixed = { xy = \"1200 mrad\", xz = \"0 mrad\", yx = \"0 mrad\", yz = \"0 mrad\", zx = \"0 mrad\", zy = \"0 mrad\" }\n",
            "as large as the signal",
        ),
    ] {
        fs::write(folder.path().join(name), format!("name = \"x\"\n{table}")).unwrap();
        refused(
            folder.path(),
            &["correct", name, "log.csv", "-o", "out.csv"],
            1,
            word,
        );
        refused(
            folder.path(),
            &["correct", name, "--emit", "c", "-o", "."],
            1,
            word,
        );
    }
}

#[test]
fn models_outside_the_bound_are_warned_of_flagged_and_not_emitted() {
    let folder = folder(|_, _| {});
    let text = format!("{MODEL}\n[gyro.scale_factor]\nfixed = \"40 %\"\n");
    fs::write(folder.path().join("part.toml"), text).unwrap();
    said(
        folder.path(),
        &CORRECT,
        "outside the convergence bound (q =",
    );
    assert!(
        flags(&folder.path().join("out.csv"))
            .iter()
            .all(|f| f & 8 == 8)
    );
    refused(
        folder.path(),
        &["correct", "part.toml", "--emit", "rust", "-o", "."],
        1,
        "bound",
    );
}

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
    said(folder.path(), &CORRECT, "outside the model's validity");
    let flags = flags(&folder.path().join("out.csv"));
    assert_eq!((flags[6], flags[7], flags[8]), (0, 4, 0));
}

#[test]
fn values_that_are_not_finite_are_refused_by_simulate_and_flagged_by_correct() {
    let folder = folder(|k, row| {
        if k == 41 {
            row[2] = "nan".to_owned();
        }
    });
    let inputs = [
        "simulate",
        "part.toml",
        "--inputs",
        "log.csv",
        "-o",
        "sim.csv",
    ];
    refused(folder.path(), &inputs, 1, "gyro_y");
    let output = sagnac(folder.path(), &inputs);
    assert!(
        stderr(&output).contains("42"),
        "names the row: {}",
        stderr(&output)
    );
    said(folder.path(), &CORRECT, "Corrected 100 samples");
    let flags = flags(&folder.path().join("out.csv"));
    assert_eq!(flags[41] & 16, 16);
    assert!(
        flags
            .iter()
            .enumerate()
            .all(|(k, f)| f & 16 == 0 || (40..=42).contains(&k))
    );
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
fn options_that_would_be_ignored_are_refused_or_told() {
    let folder = folder(|_, _| {});
    let of = |text: &str| -> Vec<String> { text.split(' ').map(str::to_owned).collect() };
    for (command, word) in [
        (
            "simulate part.toml --rest 1s --duration 2s -o a.csv",
            "--duration",
        ),
        (
            "simulate part.toml --inputs log.csv --duration 2s -o a.csv",
            "--duration",
        ),
        ("correct part.toml --emit c -o part.toml", "is a file"),
        ("correct part.toml --emit c --rate 9Hz -o source", "--emit"),
    ] {
        let args = of(command);
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        refused(folder.path(), &args, 2, word);
    }
    said(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--inputs",
            "log.csv",
            "--temperature",
            "40 degC",
            "-o",
            "warm.csv",
        ],
        "--temperature counts in place of the temperature in log.csv",
    );
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
fn trajectories_beyond_the_range_are_warned_of() {
    let folder = folder(|_, _| {});
    said(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--trajectory",
            "rocket",
            "--duration",
            "30 s",
            "-o",
            "sim.csv",
        ],
        "is saturated in",
    );
    refused(
        folder.path(),
        &[
            "simulate",
            "part.toml",
            "--trajectory",
            "rokcet",
            "-o",
            "sim2.csv",
        ],
        2,
        "rocket",
    );
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
fn a_disk_that_fills_up_leaves_nothing_behind() {
    let folder = folder(|_, _| {});
    for (name, simulate) in [
        ("big.npy", true),
        ("big.csv", true),
        ("big.csv.gz", true),
        ("out.csv", false),
    ] {
        let work = if simulate {
            format!("simulate part.toml --rest 10min -o {name}")
        } else {
            fs::copy(
                folder.path().join("log.csv"),
                folder.path().join("long.csv"),
            )
            .unwrap();
            let rows: String = (0..20_000)
                .map(|k| format!("{},0,0,0,0,0,-9.8,30\n", 2.0 + f64::from(k) / 100.0))
                .collect();
            fs::write(folder.path().join("long.csv"), format!("{HEADER}\n{rows}")).unwrap();
            format!("correct part.toml long.csv -o {name}")
        };
        let before = fs::read_dir(folder.path()).unwrap().count();
        let script = format!(
            "trap '' XFSZ; ulimit -f 200; exec {} {work}",
            env!("CARGO_BIN_EXE_sagnac")
        );
        let output = std::process::Command::new("bash")
            .current_dir(folder.path())
            .args(["-c", &script])
            .output()
            .unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        assert!(
            said.starts_with("error: ") && sentences(&said) <= 3,
            "{name}: {said}"
        );
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            before,
            "{name}: {said}"
        );
    }
}

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
fn models_beyond_every_number_are_refused_with_term_and_time() {
    let folder = folder(|k, row| {
        if k == 70 {
            row[1] = "0.9".to_owned();
        }
    });
    let at = folder.path();
    for (model, term) in [
        (
            "[gyro.scale_factor]\ncubic = \"1.7e308 s^2/rad^2\"\nfixed = 1.7e308\n",
            "at 0.71 s: gyro.scale_factor",
        ),
        (
            "[accel.noise]\nvelocity_random_walk = \"1e307 m/s/sqrt(s)\"\n",
            "accel.noise",
        ),
    ] {
        fs::write(at.join("huge.toml"), format!("name = \"Huge\"\n{model}")).unwrap();
        let output = sagnac(
            at,
            &[
                "simulate",
                "huge.toml",
                "--inputs",
                "log.csv",
                "-o",
                "out.csv",
            ],
        );
        let text = stderr(&output)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains("is beyond every number at"), "{text}");
        assert!(text.contains(term), "{text}");
        assert!(!at.join("out.csv").exists());
    }
}

#[test]
fn models_without_an_inverse_are_warned_of_before_they_are_used() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    for (model, why) in [
        ("fixed = -1", "the gyro matrix I + M is singular"),
        ("fixed = 30", "the gyro errors are as large as the signal"),
    ] {
        fs::write(
            at.join("no.toml"),
            format!("name = \"No\"\n[gyro.scale_factor]\n{model}\n"),
        )
        .unwrap();
        for args in [
            &[
                "simulate", "no.toml", "--rest", "1s", "-o", "out.csv", "--force",
            ][..],
            &["explain", "no.toml"],
        ] {
            said(at, args, why);
        }
    }
}

#[test]
fn runs_that_no_disk_holds_are_refused_before_they_begin() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    for (rate, what) in [("1e12 Hz", "samples"), ("1e7 Hz", "GB free")] {
        let args = [
            "simulate",
            "part.toml",
            "--rest",
            "27 h",
            "--rate",
            rate,
            "-o",
            "out.npy",
        ];
        let output = sagnac(at, &args);
        let text = stderr(&output)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert!(!output.status.success(), "{text}");
        assert!(
            text.contains(what) && text.contains("shorten the run"),
            "{text}"
        );
        assert!(!at.join("out.npy").exists());
    }
}

#[test]
fn a_precision_without_emitted_source_is_refused() {
    let folder = folder(|_, _| {});
    let args = [
        "correct",
        "part.toml",
        "log.csv",
        "--precision",
        "f32",
        "-o",
        "out.csv",
    ];
    let output = sagnac(folder.path(), &args);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("add --emit"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn wrong_signs_are_told_with_value_and_remedy() {
    let folder = folder(|_, _| {});
    let at = folder.path();
    fs::write(
        at.join("sign.toml"),
        "name = \"Sign\"\n[gyro.noise]\nangle_random_walk = \"-0.3 deg/sqrt(h)\"\n",
    )
    .unwrap();
    let text = stderr(&sagnac(at, &["explain", "sign.toml"]));
    for part in [
        "must not be negative, got -0.3 deg/sqrt(h)",
        "sign.toml, line 3: gyro.noise.angle_random_walk",
        "without the minus",
    ] {
        assert!(text.contains(part), "{text}");
    }
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
