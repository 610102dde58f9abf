//! The whole loop through the built program, a term at a time: simulate stations with one error, calibrate, correct
//! another run of the same sensor, and what is left is noise only.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Stations, and samples of each at 50 Hz.
const STATIONS: usize = 60;
const SAMPLES: usize = 250;
const G: f64 = 9.80665;

fn run(folder: &Path, words: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(words)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{words:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Numbers in (−1, 1), the same in every run.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Inputs of every station: specific force up to 3 g, rate up to 3 rad/s, temperature.
fn inputs() -> Vec<([f64; 3], [f64; 3], f64)> {
    let mut draws = Draws(1);
    (0..STATIONS)
        .map(|i| {
            let mut f = [0; 3].map(|_| draws.next());
            let size = f.iter().map(|v| v * v).sum::<f64>().sqrt();
            let wanted = if i % 3 == 0 { 3.0 * G } else { G };
            f = f.map(|v| v / size * wanted);
            let w = [0; 3].map(|_| 3.0 * draws.next());
            (f, w, 25.0 + 35.0 * draws.next())
        })
        .collect()
}

/// Writes the true inputs and the schedule.
fn write(folder: &Path) {
    let mut truth = String::from(
        "time [s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],temperature [degC]\n",
    );
    let mut schedule = String::from(
        "start [s],end [s],f_x [m/s^2],f_y [m/s^2],f_z [m/s^2],w_x [rad/s],w_y [rad/s],w_z [rad/s]\n",
    );
    for (i, (f, w, t)) in inputs().iter().enumerate() {
        // Between stations the rate jumps, and with it the size effect.
        let start = (i * SAMPLES) as f64 / 50.0 + 0.1;
        let end = ((i + 1) * SAMPLES) as f64 / 50.0 - 0.1;
        let cells = format!("{},{},{},{},{},{}", f[0], f[1], f[2], w[0], w[1], w[2]);
        let _ = writeln!(schedule, "{start},{end},{cells}");
        for k in 1..=SAMPLES {
            let _ = writeln!(truth, "{},{cells},{t}", (i * SAMPLES + k) as f64 / 50.0);
        }
    }
    fs::write(folder.join("truth.csv"), truth).unwrap();
    fs::write(folder.join("schedule.csv"), schedule).unwrap();
}

/// Mean square of (station mean − truth) over its standard error, gyro and accelerometer.
fn left(folder: &Path, log: &str, sigma: [f64; 2]) -> [f64; 2] {
    let text = fs::read_to_string(folder.join(log)).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| h.starts_with(name)).unwrap();
    let columns = [
        "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z",
    ]
    .map(column);
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|c| c.parse().unwrap()).collect())
        .collect();
    let mut sums = [0.0; 2];
    for ((f, w, _), rows) in inputs().iter().zip(rows.chunks(SAMPLES)) {
        for (c, column) in columns.iter().enumerate() {
            // The corrected slope of the rate jumps at the ends of a station.
            let inner = &rows[2..SAMPLES - 2];
            let mean = inner.iter().map(|r| r[*column]).sum::<f64>() / inner.len() as f64;
            let truth = if c < 3 { w[c] } else { f[c - 3] };
            let se = sigma[c / 3] / (inner.len() as f64).sqrt();
            sums[c / 3] += ((mean - truth) / se).powi(2);
        }
    }
    sums.map(|s| s / (3 * STATIONS) as f64)
}

/// A sensor with one error; `groups` is what is asked for.
fn check(error: &str, groups: &str) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // N √(rate) is σ of a sample.
    let (gyro, accel) = (1e-3, 1e-2);
    let rate: f64 = 50.0;
    let model = format!(
        "schema = 1\nname = \"one\"\nsample_rate = \"50 Hz\"\n{error}\n[gyro.noise]\nangle_random_walk = \"{} rad/sqrt(s)\"\n[accel.noise]\nvelocity_random_walk = \"{} m/s/sqrt(s)\"\n",
        gyro / rate.sqrt(),
        accel / rate.sqrt()
    );
    fs::write(folder.join("sensor.toml"), model).unwrap();
    write(folder);
    for (log, seed) in [("first.csv", "1"), ("second.csv", "2")] {
        run(
            folder,
            &[
                "simulate",
                "sensor.toml",
                "--inputs",
                "truth.csv",
                "--seed",
                seed,
                "-o",
                log,
            ],
        );
    }
    let json: serde_json::Value = serde_json::from_str(&run(
        folder,
        &[
            "calibrate",
            "stations",
            "first.csv",
            "--schedule",
            "schedule.csv",
            "--terms",
            groups,
            "-o",
            "calibrated.toml",
            "--format",
            "json",
        ],
    ))
    .unwrap();
    assert!(!json["parameters"].as_array().unwrap().is_empty());
    run(
        folder,
        &[
            "correct",
            "calibrated.toml",
            "second.csv",
            "-o",
            "corrected.csv",
        ],
    );
    let before = left(folder, "second.csv", [gyro, accel]);
    let after = left(folder, "corrected.csv", [gyro, accel]);
    assert!(
        before[0] > 10.0 || before[1] > 10.0,
        "{error}: the error does not show: {before:?}"
    );
    // 180 squares scatter by 0.11; up to 14 parameters of 60 stations an axis add a quarter.
    for chi2 in after {
        assert!(
            (0.6..1.7).contains(&chi2),
            "{error}: {before:?} -> {after:?}"
        );
    }
}

#[test]
fn bias() {
    check(
        "[gyro.bias]\nfixed = [\"500 deg/h\", \"-300 deg/h\", \"200 deg/h\"]\n[accel.bias]\nfixed = [\"8 mg\", \"-5 mg\", \"3 mg\"]",
        "bias",
    );
}

#[test]
fn scale_factor() {
    check(
        "[gyro.scale_factor]\nfixed = [\"3000 ppm\", \"-2000 ppm\", \"1500 ppm\"]\n[accel.scale_factor]\nfixed = [\"2000 ppm\", \"1000 ppm\", \"-3000 ppm\"]",
        "bias,scale_factor",
    );
}

#[test]
fn misalignment() {
    let m = "{ xy = \"2 mrad\", xz = \"-1 mrad\", yx = \"3 mrad\", yz = \"1 mrad\", zx = \"-2 mrad\", zy = \"1 mrad\" }";
    check(
        &format!("[gyro.misalignment]\nfixed = {m}\n[accel.misalignment]\nfixed = {m}"),
        "default",
    );
}

#[test]
fn cross_axis_response_as_misalignment() {
    let m = "{ xy = \"0.3 %\", xz = \"-0.2 %\", yx = \"0.1 %\", yz = \"0.2 %\", zx = \"-0.2 %\", zy = \"0.1 %\" }";
    check(
        &format!("[gyro.cross_axis]\nfixed = {m}\n[accel.cross_axis]\nfixed = {m}"),
        "default",
    );
}

#[test]
fn bias_temperature() {
    check(
        "[gyro.bias]\ntemperature = [[\"20 deg/h/K\", \"-10 deg/h/K\", \"15 deg/h/K\"]]\n[accel.bias]\ntemperature = [[\"0.2 mg/K\", \"-0.1 mg/K\", \"0.3 mg/K\"]]",
        "default",
    );
}

#[test]
fn scale_factor_temperature() {
    check(
        "[gyro.scale_factor]\ntemperature = [[\"100 ppm/K\", \"-80 ppm/K\", \"60 ppm/K\"]]\n[accel.scale_factor]\ntemperature = [[\"90 ppm/K\", \"70 ppm/K\", \"-60 ppm/K\"]]",
        "default",
    );
}

#[test]
fn g_sensitivity() {
    check(
        "[gyro.g_sensitivity]\nmatrix = [[\"100 deg/h/g\", \"50 deg/h/g\", \"0 deg/h/g\"], [\"0 deg/h/g\", \"-90 deg/h/g\", \"40 deg/h/g\"], [\"60 deg/h/g\", \"0 deg/h/g\", \"80 deg/h/g\"]]",
        "default",
    );
}

#[test]
fn axis_offset() {
    check(
        "[accel.axis_offset]\nx = [\"20 mm\", \"-5 mm\", \"3 mm\"]\ny = [\"4 mm\", \"-15 mm\", \"6 mm\"]\nz = [\"-7 mm\", \"2 mm\", \"25 mm\"]",
        "default",
    );
}

#[test]
fn quadratic() {
    check(
        "[gyro.scale_factor]\nquadratic = [\"2e-3 s/rad\", \"-1e-3 s/rad\", \"1.5e-3 s/rad\"]\n[accel.scale_factor]\nquadratic = [\"300 ppm/g\", \"-200 ppm/g\", \"250 ppm/g\"]",
        "default,+quadratic",
    );
}

#[test]
fn asymmetry() {
    check(
        "[gyro.scale_factor]\nasymmetry = [\"4000 ppm\", \"-3000 ppm\", \"2000 ppm\"]\n[accel.scale_factor]\nasymmetry = [\"2000 ppm\", \"-1500 ppm\", \"1800 ppm\"]",
        "default,+asymmetry",
    );
}

#[test]
fn cubic() {
    check(
        "[gyro.scale_factor]\ncubic = [\"1e-3 s^2/rad^2\", \"-1e-3 s^2/rad^2\", \"2e-3 s^2/rad^2\"]\n[accel.scale_factor]\ncubic = [\"3e-6 s^4/m^2\", \"-2e-6 s^4/m^2\", \"2e-6 s^4/m^2\"]",
        "default,+cubic",
    );
}

#[test]
fn g2_sensitivity() {
    let row = "[\"25 deg/h/g^2\", \"-20 deg/h/g^2\", \"0 deg/h/g^2\", \"40 deg/h/g^2\", \"-30 deg/h/g^2\", \"15 deg/h/g^2\"]";
    check(
        &format!("[gyro.g2_sensitivity]\nmatrix = [{row}, {row}, {row}]"),
        "default,+g2_sensitivity",
    );
}
