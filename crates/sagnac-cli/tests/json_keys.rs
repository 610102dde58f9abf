//! The keys of every command's JSON that scripts rely on, looked up in what the built program prints.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// What an estimate carries.
const ESTIMATE: &[&str] = &["status", "value", "lower", "upper", "sigma", "unit"];

fn json(folder: &Path, args: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(args)
        .args(["--format", "json"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {error}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{args:?}: {e}"))
}

/// All values at `path`: keys joined by dots, `[]` for every element of a list that must not be empty.
fn at<'a>(value: &'a Value, path: &str) -> Vec<&'a Value> {
    let mut found = vec![value];
    for part in path.split('.') {
        let (key, is_list) = part
            .strip_suffix("[]")
            .map_or((part, false), |key| (key, true));
        found = found
            .into_iter()
            .map(|v| match key {
                "" => v,
                key => v
                    .get(key)
                    .unwrap_or_else(|| panic!("no `{key}` of {path} in {v}")),
            })
            .collect();
        if is_list {
            found = found
                .into_iter()
                .flat_map(|v| v.as_array().unwrap_or_else(|| panic!("{path}: {v}")))
                .collect();
            assert!(!found.is_empty(), "{path} is empty");
        }
    }
    found
}

fn has(value: &Value, paths: &[&str]) {
    for path in paths {
        at(value, path);
    }
}

fn is_estimate(value: &Value, paths: &[&str]) {
    for path in paths {
        for found in at(value, path) {
            has(found, ESTIMATE);
            let status = found["status"].as_str().unwrap();
            let numbers = ["value", "lower", "upper"].map(|key| found[key].is_number());
            let wanted = match status {
                "detected" => [true; 3],
                "upper_limit" => [false, false, true],
                "absent" => [false; 3],
                other => panic!("{path}: {other}"),
            };
            assert_eq!(numbers, wanted, "{path}: {found}");
        }
    }
}

#[test]
fn logs_and_their_errors() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let simulated = json(
        folder,
        &[
            "simulate",
            "catalog:ADIS16470",
            "--rest",
            "5min",
            "--rate",
            "100Hz",
            "-o",
            "rest.csv",
        ],
    );
    has(
        &simulated,
        &["files[]", "samples", "rate_hz", "duration_s", "seed"],
    );
    assert_eq!(simulated["samples"], 30_000);

    let info = json(folder, &["info", "rest.csv"]);
    has(
        &info,
        &["format", "samples", "rate_hz", "duration_s", "issues"],
    );
    for key in ["name", "unit", "mean", "std", "min", "max", "lsb"] {
        has(&info, &[&format!("channels[].{key}")]);
    }
    assert_eq!(info["rate_hz"], 100.0);

    let log = json(folder, &["characterize", "rest.csv", "-o", "unit.toml"]);
    has(
        &log,
        &["log.samples", "log.rate_hz", "log.duration_s", "log.issues"],
    );
    has(
        &log,
        &[
            "axes[].axis",
            "axes[].lsb",
            "axes[].confused",
            "axes[].regressors",
        ],
    );
    has(&log, &["axes[].fit.deviation[]", "axes[].fit.p_value"]);
    for key in ["tau_s", "deviation", "lower", "upper"] {
        has(&log, &[&format!("axes[].allan.{key}[]")]);
    }
    is_estimate(&log, &["axes[].mean"]);
    for axis in at(&log, "axes[]") {
        let name = axis["axis"].as_str().unwrap();
        let own = if name.starts_with("gyro") {
            ["angle_random_walk", "rate_random_walk", "rate_ramp"]
        } else {
            [
                "velocity_random_walk",
                "acceleration_random_walk",
                "acceleration_ramp",
            ]
        };
        for term in ["quantization", "bias_instability"].into_iter().chain(own) {
            is_estimate(axis, &[&format!("terms.{term}")]);
        }
        is_estimate(
            axis,
            &[
                "terms.gauss_markov[].sigma",
                "terms.gauss_markov[].correlation_time",
            ],
        );
        has(axis, &["terms.sinusoids"]);
    }

    let allan = json(folder, &["allan", "rest.csv"]);
    for key in [
        "tau_s",
        "deviation",
        "lower",
        "upper",
        "alpha",
        "edf",
        "samples_used",
    ] {
        has(&allan, &[&format!("axes[].{key}[]")]);
    }
    has(&allan, &["axes[].axis", "axes[].deviation_kind"]);
    let spectrum = json(folder, &["allan", "rest.csv", "--spectrum"]);
    has(
        &spectrum,
        &[
            "axes[].axis",
            "axes[].frequency_hz[]",
            "axes[].density[]",
            "axes[].unit",
        ],
    );

    let corrected = json(
        folder,
        &["correct", "catalog:ADIS16470", "rest.csv", "-o", "c.csv"],
    );
    has(&corrected, &["samples", "saturated", "outside_validity"]);
    has(
        &corrected,
        &["changes[].axis", "changes[].mean", "changes[].largest"],
    );

    let converted = json(folder, &["convert", "rest.csv", "-o", "rest.npy"]);
    has(&converted, &["files[]", "samples", "rate_hz", "duration_s"]);

    let compared = json(
        folder,
        &["compare", "rest.csv", "--with", "catalog:ADIS16470"],
    );
    has(&compared, &["axes[].axis"]);
    for key in ["term", "reference", "verdict", "text"] {
        has(&compared, &[&format!("axes[].terms[].{key}")]);
    }
    is_estimate(&compared, &["axes[].terms[].measured"]);
    has(&compared, &["axes[].terms[].ratio"]);

    json(
        folder,
        &[
            "simulate",
            "catalog:ADIS16470",
            "--rest",
            "5min",
            "--rate",
            "100Hz",
            "--seed",
            "1",
            "-o",
            "again.csv",
        ],
    );
    let two = json(
        folder,
        &["characterize", "rest.csv", "again.csv", "--one-sensor"],
    );
    has(
        &two,
        &[
            "logs[].log.samples",
            "logs[].axes[].axis",
            "sensor.axes[].axis",
        ],
    );
    has(
        &two,
        &["sensor.axes[].terms", "sensor.axes[].bias_stability"],
    );
}

#[test]
fn models_and_what_they_mean() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sensor = "catalog:ADIS16470";
    let at_input = "f=0 0 -9.81 m/s^2, w=10 0 0 deg/s";
    let explained = json(folder, &["explain", sensor, "--at", at_input]);
    for axis in at(&explained, "axes[]") {
        has(
            axis,
            &[
                "axis",
                "input",
                "output",
                "unit",
                "terms",
                "random[].term",
                "random[].sigma",
            ],
        );
        let sum: f64 = axis["terms"]
            .as_array()
            .unwrap()
            .iter()
            .map(|term| term["value"].as_f64().unwrap())
            .sum();
        let change = axis["output"].as_f64().unwrap() - axis["input"].as_f64().unwrap();
        assert!((sum - change).abs() < 1e-12, "{axis}");
    }

    let plan = json(folder, &["plan", sensor, "--duration", "4h"]);
    has(
        &plan,
        &[
            "duration_s",
            "rate_hz",
            "axes[].axis",
            "curve[].duration_s",
            "curve[].axes[].axis",
        ],
    );
    has(&plan, &["axes[].terms.bias_instability.relative_sigma"]);

    let drift = json(
        folder,
        &["drift", sensor, "--duration", "5min", "--rate", "100Hz"],
    );
    has(
        &drift,
        &[
            "method",
            "time_s[]",
            "cep_m[]",
            "r95_m[]",
            "rms_m[]",
            "nmi_per_h",
        ],
    );
    has(
        &drift,
        &[
            "cep_ci_m",
            "r95_ci_m",
            "rms_ci_m",
            "runs",
            "alignment",
            "vertical",
        ],
    );
    has(&drift, &["calibration", "valid", "missing", "clipped"]);
    has(
        &drift,
        &["budget[].term", "budget[].axis", "budget[].share"],
    );
    for key in ["term", "share", "cep_factor_if_halved"] {
        has(&drift, &[&format!("improve_first[].{key}")]);
    }
    for key in [
        "north_m",
        "east_m",
        "down_m",
        "velocity_north_m_s",
        "velocity_east_m_s",
        "velocity_down_m_s",
        "tilt_north_rad",
        "tilt_east_rad",
        "heading_rad",
    ] {
        has(&drift, &[&format!("axes.{key}[]")]);
    }
    let shares: f64 = at(&drift, "budget[].share")
        .iter()
        .map(|s| s.as_f64().unwrap())
        .sum();
    assert!((shares - 1.0).abs() < 1e-6, "{shares}");

    let grade = json(folder, &["grade", sensor]);
    for key in [
        "sensor",
        "table",
        "bias",
        "by_gyro_bias",
        "by_accel_bias",
        "by_position",
    ] {
        has(&grade, &[key]);
    }
    has(&grade, &["overall", "held_back_by"]);
    for key in ["parameter", "now", "needed", "unit", "factor"] {
        has(&grade, &[&format!("needed_for_next[].{key}")]);
    }
    assert_eq!(
        json(folder, &["grade", sensor, sensor])
            .as_array()
            .unwrap()
            .len(),
        2
    );

    let budget = json(
        folder,
        &["budget", sensor, "--cep", "1 km", "--after", "10min"],
    );
    for key in ["sensor", "cep_m", "r95_m", "price_class"] {
        has(
            &budget,
            &[&format!("met_by[].{key}"), &format!("nearest[].{key}")],
        );
    }
    for key in ["parameter", "value", "unit"] {
        has(&budget, &[&format!("needed[].{key}")]);
    }

    json(
        folder,
        &["export", sensor, "--to", "kalibr", "-o", "imu.yaml"],
    );
    let audit = json(folder, &["audit", "imu.yaml"]);
    has(&audit, &["format"]);
    for key in [
        "key",
        "value",
        "convention",
        "possible",
        "log_ratio",
        "verdict",
        "text",
    ] {
        has(&audit, &[&format!("entries[].{key}")]);
    }
    has(&audit, &["entries[].meaning", "entries[].likely_mistake"]);
}
