//! What `simulate` and `correct` say of numbers beyond what a model or its reader can hold.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fs;
use std::path::Path;

use common::{refused, said};

const LOG: &str = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]";

fn write(at: &Path, name: &str, text: &str) {
    fs::write(at.join(name), text).unwrap();
}

fn model(at: &Path, body: &str) {
    write(
        at,
        "m.toml",
        &format!("name = \"part\"\nsample_rate = \"100 Hz\"\n{body}"),
    );
}

const REST: [&str; 6] = ["simulate", "m.toml", "--rest", "1 s", "-o", "new.csv"];

#[test]
fn a_result_beyond_every_number_is_flagged_and_told_in_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    model(at, "[gyro.scale_factor]\ncubic = \"1e-4 s^2/rad^2\"\n");
    write(
        at,
        "log.csv",
        &format!("{LOG}\n0.01,0.1,0,0,0,0,-9.8\n0.02,1e200,0,0,0,0,-9.8\n0.03,0.1,0,0,0,0,-9.8\n"),
    );
    let text = said(
        at,
        &["correct", "m.toml", "log.csv", "--flags", "-o", "out.csv"],
    );
    assert!(
        text.contains("warning: 1 sample is outside the model's validity: 1 outside the convergence bound (q not finite, mu + nu not finite)"),
        "{text}"
    );
    assert!(
        text.contains("beyond every number: the result is not a number; --flags marks them"),
        "{text}"
    );
    assert_eq!(text.matches("warning:").count(), 1, "{text}");
    let out = fs::read_to_string(at.join("out.csv")).unwrap();
    let row = out.lines().nth(2).unwrap();
    assert!(
        row.contains("nan,nan,nan,") && row.ends_with(",24"),
        "{row}"
    );
}

#[test]
fn the_nearer_end_of_a_terms_own_range_is_told_by_simulate() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    model(
        at,
        "temperature_range = [\"-40 degC\", \"85 degC\"]\n[gyro.bias]\ntemperature = [[\"0.01 deg/s/K\", \"0 deg/s/K\", \"0 deg/s/K\"]]\n\
         temperature_range = [\"0 degC\", \"50 degC\"]\n[accel.scale_factor]\ntemperature = [[\"10 ppm/K\", \"10 ppm/K\", \"10 ppm/K\"]]\n",
    );
    let hot = ["--temperature", "60 degC"];
    let text = said(at, &[&REST[..], &hot].concat());
    assert!(
        text.contains("warning: the temperature is outside 0 to 50 degC, the range of gyro.bias, in 100 samples: the nearer end is taken"),
        "{text}"
    );
    let hotter = ["--temperature", "90 degC", "--force"];
    let text = said(at, &[&REST[..], &hotter].concat());
    assert!(
        text.contains("outside 0 to 50 degC, the range of gyro.bias,")
            && text.contains("outside -40 to 85 degC in 100 samples"),
        "{text}"
    );
}

#[test]
fn steps_that_no_output_can_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let range = "[gyro]\nrange = \"100 deg/s\"\noutput = \"increment\"\n";
    model(at, &format!("{range}resolution = \"2 deg\"\n"));
    let text = refused(at, &REST, 1);
    assert!(
        text.contains("the resolution is coarser than the range at the model's sample_rate: every output would be 0"),
        "{text}"
    );
    model(at, &format!("{range}resolution = \"0.5 deg\"\n"));
    let text = refused(at, &[&REST[..], &["--rate", "500Hz"]].concat(), 1);
    assert!(
        text.contains("gyro.resolution is coarser than the range at 500 Hz"),
        "{text}"
    );
    said(at, &REST);
    model(at, "[gyro]\nresolution = \"0 deg/s\"\n");
    let text = refused(at, &["explain", "m.toml"], 1);
    assert!(
        text.contains("the value must be above zero, got 0 deg/s m.toml, line 4: gyro.resolution"),
        "{text}"
    );
    model(at, "[gyro]\nresolution = \"1e-320 deg/s\"\n");
    let mut again = REST;
    again[5] = "other.csv";
    let text = refused(at, &again, 1);
    assert!(text.contains("gyro.resolution is too small"), "{text}");
}

#[test]
fn inputs_too_large_to_reckon_with_are_named_by_row() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    model(at, "[gyro.scale_factor]\nquadratic = \"1e-4 s/rad\"\n");
    write(
        at,
        "in.csv",
        &format!("{LOG}\n0.01,0.1,0,0,0,0,-9.8\n0.02,1e200,0,0,0,0,-9.8\n0.03,0.1,0,0,0,0,-9.8\n"),
    );
    let text = refused(
        at,
        &["simulate", "m.toml", "--inputs", "in.csv", "-o", "new.csv"],
        1,
    );
    assert!(
        text.contains("the truth in row 2, 1e200, is too large to reckon with")
            && text.contains("in.csv, row 2, column gyro_x"),
        "{text}"
    );
}

#[test]
fn what_would_take_too_long_or_stands_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    model(at, "[gyro.bias]\nfixed = \"1 deg/s\"\n");
    let long = [
        "simulate",
        "m.toml",
        "--trajectory",
        "rocket",
        "--duration",
        "3000d",
        "--rate",
        "0.001Hz",
        "-o",
        "new.csv",
    ];
    let text = refused(at, &long, 2);
    assert!(
        text.contains("1.3e10 steps of 20 ms") && text.contains("shorten the run to 100 days"),
        "{text}"
    );
    let text = refused(at, &[&REST[..], &["--noise", "white,white"]].concat(), 2);
    assert!(text.contains("`white` stands twice"), "{text}");
}

#[test]
fn a_name_that_would_rule_the_terminal_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "m.toml", "name = \"a\\u001b[31mb\"\n");
    let text = refused(at, &["explain", "m.toml"], 1);
    assert!(
        text.contains("the name holds a control character, U+001B m.toml, line 1: name"),
        "{text}"
    );
}

#[test]
fn an_empty_log_and_one_whose_time_runs_back_are_told_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    model(at, "[gyro.bias]\nfixed = \"1 deg/s\"\n");
    write(at, "none.csv", "");
    let text = refused(at, &["correct", "m.toml", "none.csv", "-o", "new.csv"], 1);
    assert!(text.contains("the log is empty"), "{text}");
    write(
        at,
        "back.csv",
        &format!("{LOG}\n0.03,0,0,0,0,0,-9.8\n0.02,0,0,0,0,0,-9.8\n0.01,0,0,0,0,0,-9.8\n"),
    );
    let text = said(at, &["correct", "m.toml", "back.csv", "-o", "new.csv"]);
    assert!(text.contains("Corrected 3 samples, 10 ms."), "{text}");
}
