//! Where the covariance of `drift` does not hold it says so, and rounded increments agree with the Monte Carlo.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{flat, sagnac};
use serde_json::Value;
use std::fs;

const QUIET: &str = "[gyro.bias]\nstability = \"0.01 deg/h\"\n[accel.bias]\nstability = \"1 ug\"\n[accel.noise]\nvelocity_random_walk = \"0.001 m/s/sqrt(h)\"\n[gyro.noise]\nangle_random_walk = \"0.005 deg/sqrt(h)\"\n";

/// The JSON of a drift of five minutes, and what is said on standard error.
fn drift(gyro: &str, options: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("name = \"part\"\nsample_rate = \"100 Hz\"\n[gyro]\n{gyro}\n{QUIET}");
    fs::write(folder.path().join("part.toml"), text).unwrap();
    let own = [
        "drift",
        "part.toml",
        "--duration",
        "5min",
        "--format",
        "json",
    ];
    let output = sagnac(folder.path(), &[&own[..], options].concat());
    let said = flat(&String::from_utf8_lossy(&output.stderr));
    (serde_json::from_slice(&output.stdout).expect(&said), said)
}

#[test]
fn temperature_terms_stay_at_the_end_of_their_range() {
    let slopes =
        "[gyro.bias]\ntemperature = [{ value = \"1 deg/h/K\", sigma = \"0.1 deg/h/K\" }]\n";
    let at = |range: &str, temperature: &str| {
        let folder = tempfile::tempdir().unwrap();
        let text = format!("name = \"slope\"\n{range}\n{slopes}");
        fs::write(folder.path().join("slope.toml"), text).unwrap();
        let words = [
            "drift",
            "slope.toml",
            "--duration",
            "3min",
            "--format",
            "json",
        ];
        let output = sagnac(
            folder.path(),
            &[&words[..], &["--temperature", temperature]].concat(),
        );
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let all = found["covariance"]["cep_m"].as_array().unwrap().clone();
        all.last().unwrap().as_f64().unwrap()
    };
    let range = "temperature_range = [\"0 degC\", \"50 degC\"]";
    let end = at(range, "50 degC");
    assert!(end > 0.0 && (at(range, "80 degC") / end - 1.0).abs() < 1e-9);
    assert!((at("", "80 degC") / end - 55.0 / 25.0).abs() < 1e-6);
}

#[test]
fn a_motion_beyond_the_range_is_said() {
    let (found, said) = drift("range = \"2 deg/s\"", &["--trajectory", "drive"]);
    assert_eq!(found["valid"], false);
    let why = found["invalid_because"][0].as_str().unwrap();
    assert!(
        why.contains("2.26 deg/s of gyro z") && why.contains("range of 2 deg/s"),
        "{why}"
    );
    assert!(said.contains(why), "{said}");
    let (found, _) = drift("range = \"3 deg/s\"", &["--trajectory", "drive"]);
    assert_eq!(found["valid"], true);
}

#[test]
fn a_rate_whose_steps_its_noise_does_not_wash_out_is_said() {
    // 0.005 deg/sqrt(h) is 8.3e-4 deg/s a sample at 100 Hz.
    let (found, said) = drift("resolution = \"0.01 deg/s\"", &[]);
    assert_eq!(found["valid"], false);
    assert!(
        said.contains("too coarse for its noise of 0.083 steps"),
        "{said}"
    );
    let (found, _) = drift("resolution = \"0.002 deg/s\"", &[]);
    assert_eq!(found["valid"], true, "0.42 steps");
    let (found, _) = drift("resolution = \"1e-9 deg/s\"", &[]);
    assert_eq!(
        found["valid"], true,
        "a step that is nothing beside the rest"
    );
}

#[test]
fn increments_begin_without_a_residue() {
    // With a random residue at the start the covariance would be half as large again: 9.5 m.
    let gyro = "output = \"increment\"\nresolution = \"10 arcsec\"";
    let (found, _) = drift(gyro, &["--trajectory", "drive", "--method", "monte-carlo"]);
    let linear = found["covariance"]["cep_m"][59].as_f64().unwrap();
    let ends = found["cep_ci_m"][59].as_array().unwrap();
    assert!(
        ends[0].as_f64() < Some(linear) && Some(linear) < ends[1].as_f64(),
        "{linear} not in {ends:?}"
    );
}

#[test]
fn a_requirement_says_whose_range_the_motion_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    let text = format!("name = \"narrow\"\n[gyro]\nrange = \"2 deg/s\"\n{QUIET}");
    fs::write(own.join("narrow.toml"), text).unwrap();
    let budget = |trajectory: &str| {
        let args = [
            "budget",
            "--cep",
            "1 km",
            "--after",
            "5min",
            "--catalog",
            "own",
            "--trajectory",
            trajectory,
        ];
        flat(&String::from_utf8_lossy(
            &sagnac(folder.path(), &args).stderr,
        ))
    };
    let said = budget("drive");
    assert!(
        said.contains("narrow: the motion asks 2.26 deg/s of gyro z"),
        "{said}"
    );
    assert!(!budget("rest").contains("narrow"), "nothing turns at rest");
}
