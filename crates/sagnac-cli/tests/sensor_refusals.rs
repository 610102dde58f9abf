//! Bad models, options and places to write to `simulate`, `correct` and `explain`: refused or warned of in one
//! sentence, nothing half written.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fs;

use common::part::{CORRECT, HEADER, MODEL, flags, folder, refused, said, stderr};
use common::{sagnac, sentences};

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
