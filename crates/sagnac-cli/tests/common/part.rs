//! A part with most terms, a log of it, and what commands say of them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Output;

use super::{flat, sagnac, sentences};

pub(crate) const MODEL: &str = r#"name = "Part"
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

pub(crate) const HEADER: &str = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],\
accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],temperature [degC]";

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the model, and `log.csv` of 100 rows after a change by `edit` (row, cells).
pub(crate) fn folder(edit: impl Fn(usize, &mut Vec<String>)) -> tempfile::TempDir {
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
pub(crate) fn refused(folder: &Path, args: &[&str], code: i32, word: &str) {
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
pub(crate) fn said(folder: &Path, args: &[&str], word: &str) {
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
pub(crate) fn flags(path: &Path) -> Vec<u32> {
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

pub(crate) const CORRECT: [&str; 6] = [
    "correct",
    "part.toml",
    "log.csv",
    "-o",
    "out.csv",
    "--flags",
];
