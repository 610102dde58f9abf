//! Time stamps coarser than the sampling interval, through the built program: every command takes the same interval.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// Increments of 0.02 rad a sample at 100 Hz: 2 rad/s; stamps in whole steps of `grid_s`.
fn increments(grid_s: f64) -> String {
    let mut out = "time [s],gyro_x [rad],gyro_y [rad],gyro_z [rad]\n".to_owned();
    for k in 0..3000 {
        let stamp = (f64::from(k) * 0.01 / grid_s + 1e-9).floor() * grid_s;
        let _ = writeln!(out, "{stamp},{},-0.01,0", 0.02 + 1e-6 * f64::from(k % 7));
    }
    out
}

fn run(folder: &Path, args: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(args)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {said}");
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn increments_become_the_same_rates_in_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(
        at.join("m.toml"),
        "name = \"Part\"\n[gyro.bias]\nfixed = \"0 rad/s\"\n",
    )
    .unwrap();
    for grid_s in [0.1, 1.0] {
        fs::write(at.join("log.csv"), increments(grid_s)).unwrap();
        let said = run(
            at,
            &["correct", "m.toml", "log.csv", "-o", "c.csv", "--force"],
        );
        assert!(said.contains("coarser than its interval"), "{said}");
        assert!(!said.contains("equal to the one before"), "{said}");
        run(at, &["convert", "log.csv", "-o", "v.csv", "--force"]);
        for name in ["c.csv", "v.csv"] {
            let text = fs::read_to_string(at.join(name)).unwrap();
            let row: Vec<f64> = text
                .lines()
                .nth(1500)
                .unwrap()
                .split(',')
                .map(|cell| cell.parse().unwrap())
                .collect();
            assert!(
                (row[1] / 2.0 - 1.0).abs() < 0.01,
                "{grid_s} {name}: {row:?}"
            );
        }
    }
}

#[test]
fn a_change_of_rate_is_gaps_and_no_rate_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n".to_owned();
    for k in 0..9000 {
        let time_s = if k < 6000 {
            0.01 * f64::from(k)
        } else {
            60.0 + 0.02 * f64::from(k - 6000)
        };
        let _ = writeln!(text, "{time_s},{},0.1,0.2", k % 7);
    }
    fs::write(folder.path().join("log.csv"), text).unwrap();
    let said = run(folder.path(), &["info", "log.csv"]);
    assert!(said.contains("Rate 100 Hz"), "{said}");
    assert!(said.contains("gap"), "{said}");
}
