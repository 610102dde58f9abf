//! `drift --log` and `strapdown`, to the built program: options that a recording settles are refused, the picture and the
//! page are written, and a free height returns where the reference states its velocity.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{refused, sagnac, said};
use std::fs;
use std::path::Path;

/// A minute of a drive with its truth.
fn recording() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("part.toml"),
        "name = \"part\"\n[gyro.bias]\nfixed = \"30 deg/h\"\nstability = \"5 deg/h\"\n[accel.bias]\nfixed = \"5 mg\"\nstability = \"1 mg\"\n",
    )
    .unwrap();
    simulate(folder.path(), "part.toml", "drive", "65s");
    folder
}

fn simulate(folder: &Path, model: &str, trajectory: &str, duration: &str) {
    let args = [
        "simulate",
        model,
        "--trajectory",
        trajectory,
        "--duration",
        duration,
        "--rate",
        "200Hz",
        "--noise",
        "none",
        "--truth",
        "truth.npy",
        "-o",
        "log.npy",
        "--force",
    ];
    said(folder, &args);
}

const DRIFT: [&str; 6] = [
    "drift",
    "part.toml",
    "--log",
    "log.npy",
    "--reference",
    "truth.npy",
];

#[test]
fn what_a_recording_settles_itself_is_refused() {
    let folder = recording();
    let options: [&[&str]; 13] = [
        &["--duration", "5s"],
        &["--method", "monte-carlo"],
        &["--runs", "5"],
        &["--seed", "1"],
        &["--trajectory", "drive"],
        &["--alignment", "self"],
        &["--calibration", "none"],
        &["--vertical", "fixed"],
        &["--sculling", "two"],
        &["--temperature", "40 degC"],
        &["--heading", "4deg"],
        &["--pitch", "4deg"],
        &["-o", "growth.pdf"],
    ];
    for option in options {
        let text = refused(folder.path(), &[&DRIFT[..], option].concat(), 2);
        assert!(text.contains(option[0]), "{option:?}: {text}");
    }
    // What says the same as the recording's own way is no contradiction.
    let same = [
        "--method",
        "covariance",
        "--vertical",
        "free",
        "--alignment",
        "perfect",
    ];
    said(folder.path(), &[&DRIFT[..], &same].concat());
}

#[test]
fn a_recording_has_its_picture_and_its_page() {
    let folder = recording();
    let outputs = ["-o", "growth.svg", "--report", "page.html"];
    let text = said(folder.path(), &[&DRIFT[..], &outputs].concat());
    assert!(
        text.contains("wrote growth.svg") && text.contains("wrote page.html"),
        "{text}"
    );
    let picture = fs::read_to_string(folder.path().join("growth.svg")).unwrap();
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    for curve in ["as recorded", "corrected", "predicted"] {
        assert!(picture.contains(curve), "the picture lacks {curve}");
    }
    for part in [
        "data-plot=\"drift-growth\"",
        "data-table=\"recording\"",
        "60 s",
        "sagnac drift part.toml --log log.npy",
    ] {
        assert!(page.contains(part), "the page lacks {part}");
    }
}

#[test]
fn a_picture_is_named_before_the_work() {
    let folder = recording();
    let commands: [&[&str]; 3] = [
        &["drift", "part.toml"],
        &["grade", "part.toml"],
        &["catalog", "list"],
    ];
    for command in commands {
        let output = sagnac(folder.path(), &[command, &["-o", "x.pdf"]].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{command:?}: {text}");
        assert!(
            output.stdout.is_empty(),
            "{command:?} answers before it refuses"
        );
        assert!(text.contains("F.svg or F.png"), "{command:?}: {text}");
    }
}

#[test]
fn a_free_height_returns_with_the_velocity_that_the_reference_states() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("none.toml"), "name = \"none\"\n").unwrap();
    // A velocity that is off by 1e-6 m/s is 1e-2 m after half an hour; the slope of the positions leaves such errors.
    simulate(folder.path(), "none.toml", "turn", "30min");
    let args = [
        "strapdown",
        "log.npy",
        "--reference",
        "truth.npy",
        "-o",
        "nav.npy",
        "--format",
        "json",
    ];
    let output = sagnac(folder.path(), &args);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["start_velocity"], "stated");
    let error_m = found["end_error_m"].as_f64().unwrap();
    assert!(error_m < 1e-4, "{error_m} m");
}
