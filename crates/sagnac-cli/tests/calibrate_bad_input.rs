//! Tables and schedules that no calibration can use: one sentence that says what to add, exit 1 or 2, nothing written.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{flat, sentences};
use std::fmt::Write as _;
use std::fs;
use std::process::Command;

const HEADER: &str = "station,up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n";
const FACES: [(&str, [f64; 3]); 6] = [
    ("+x", [9.83, 0.01, 0.02]),
    ("-x", [-9.79, 0.01, 0.02]),
    ("+y", [0.02, 9.81, 0.02]),
    ("-y", [0.02, -9.80, 0.02]),
    ("+z", [0.02, 0.01, 9.85]),
    ("-z", [0.02, 0.01, -9.79]),
];

fn faces() -> String {
    let mut out = HEADER.to_owned();
    for (i, (up, a)) in FACES.iter().enumerate() {
        let _ = writeln!(out, "{},{up},{},{},{}", i + 1, a[0], a[1], a[2]);
    }
    out
}

/// Runs `calibrate stations` on files and expects one refusal with a place or an advice that holds `word`.
fn refused(files: &[(&str, &str)], words: &[&str], code: i32, wanted: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder.path())
        .arg("calibrate")
        .args(words)
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{words:?}: {stderr}");
    assert!(stderr.starts_with("error: "), "{words:?}: {stderr}");
    assert!(sentences(&stderr) <= 3, "{words:?}: {stderr}");
    for word in wanted {
        assert!(
            flat(&stderr).contains(word),
            "{words:?} lacks {word}: {stderr}"
        );
    }
    assert!(output.stdout.is_empty());
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        files.len(),
        "{words:?} leaves a file"
    );
}

fn table(text: &str, wanted: &[&str]) {
    refused(
        &[("t.csv", text)],
        &[
            "stations", "t.csv", "-o", "out.toml", "--report", "out.html",
        ],
        1,
        wanted,
    );
}

#[test]
fn one_face_only() {
    let one = format!("{HEADER}1,-z,0.02,0.01,-9.79\n2,-z,0.02,0.01,-9.80\n3,-z,0.02,0.01,-9.79\n");
    table(
        &one,
        &[
            "one-face table cannot give the scale factor",
            "3 stations",
            "plan six-position",
        ],
    );
}

#[test]
fn too_few_stations_without_standard_errors() {
    // Four faces, four parameters on the axes that see them all.
    let text = "station,f_x [m/s^2],f_y [m/s^2],f_z [m/s^2],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n\
                1,9.8,0,0,9.8,0,0\n2,0,9.8,0,0,9.8,0\n3,0,0,9.8,0,0,9.8\n4,-9.8,0,0,-9.8,0,0\n";
    table(
        text,
        &[
            "as many parameters as stations",
            "add a station, or give standard errors",
        ],
    );
}

#[test]
fn units_of_g_taken_as_m_per_s2() {
    let mut text = HEADER.to_owned();
    for (i, (up, a)) in FACES.iter().enumerate() {
        let _ = writeln!(
            text,
            "{},{up},{},{},{}",
            i + 1,
            a[0] / 9.8,
            a[1] / 9.8,
            a[2] / 9.8
        );
    }
    table(&text, &["looks like g", "accel_x [g]"]);
}

#[test]
fn references_twice() {
    let text = "up,f_x [m/s^2],f_y [m/s^2],f_z [m/s^2],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n+x,9.8,0,0,9.8,0,0\n";
    table(text, &["two kinds of reference", "line 2"]);
    let text = "roll [deg],pitch [deg],up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n0,0,-z,0,0,-9.8\n";
    table(text, &["two kinds of reference"]);
}

#[test]
fn no_reference_and_no_output() {
    table(
        "accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n1,2,3\n",
        &["no reference", "f_x, f_y, f_z"],
    );
    table("up\n+x\n-x\n", &["no outputs", "accel_x"]);
    table(
        "up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n,9.8,0,0\n",
        &["station 1 has no reference"],
    );
}

#[test]
fn standard_errors_that_are_none() {
    let with = |se: &str| {
        let mut text = "up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],accel_x_se [m/s^2],accel_y_se [m/s^2],accel_z_se [m/s^2]\n".to_owned();
        for (up, a) in FACES {
            let _ = writeln!(text, "{up},{},{},{},{se}", a[0], a[1], a[2]);
        }
        text
    };
    table(
        &with("0,0,0"),
        &["standard error must be above zero", "line 2"],
    );
    table(&with("1e-3,1e-3,-1e-3"), &["standard error"]);
    table(&with("1e-3,,1e-3"), &["an axis without a value"]);
    let one =
        "up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],accel_x_se [m/s^2]\n+x,9.8,0,0,1e-3\n";
    table(one, &["column `accel_y_se` is missing"]);
}

#[test]
fn labels_that_the_outputs_contradict() {
    let wrong = faces().replacen("1,+x", "1,-x", 1);
    table(
        &wrong,
        &[
            "station 1 says -x up but accel_x reads 9.8",
            "wrong label, or a mirrored axis",
            "--axes",
        ],
    );
    let wrong = faces().replacen("3,+y", "3,+z", 1);
    table(&wrong, &["station 3"]);
    let turned = "up,turn_x [deg/s],turn_y [deg/s],turn_z [deg/s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n\
                  +z,0,0,100,0,0,-100\n+z,0,0,-100,0,0,100\n";
    table(
        turned,
        &["turns at 1.75 rad/s about z but gyro_z reads -1.75"],
    );
}

#[test]
fn turns_that_are_not_about_the_vertical() {
    let text = "up,turn_x [deg/s],turn_y [deg/s],turn_z [deg/s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n+z,100,0,0,100,0,0\n";
    table(text, &["not vertical", "give f_x, f_y, f_z"]);
}

#[test]
fn numbers_that_are_none() {
    table(
        &faces().replace("9.83", "nan"),
        &["not a finite number", "line 2"],
    );
    table(
        &faces().replace("9.83", ""),
        &["an axis without a value", "line 2"],
    );
    refused(
        &[("t.csv", &faces())],
        &["stations", "t.csv", "--latitude", "91deg", "-o", "out.toml"],
        1,
        &["latitude lies beyond 90 deg"],
    );
}

#[test]
fn tables_of_another_sort() {
    table(
        "time [s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n0.01,0,0,9.8\n",
        &["this is a log", "--schedule", "multi-position"],
    );
    table(
        "reference [deg/s],output [deg/s]\n1,1\n2,2\n",
        &["references and outputs", "sagnac response"],
    );
    table("", &["empty"]);
    table(HEADER, &["no rows"]);
}

#[test]
fn temperature_that_never_changes() {
    // Held and named, with what to add; the rest is estimated.
    let folder = tempfile::tempdir().unwrap();
    let mut text = HEADER.replace('\n', ",temperature [degC]\n");
    for (i, (up, a)) in FACES.iter().enumerate() {
        let _ = writeln!(text, "{},{up},{},{},{},25", i + 1, a[0], a[1], a[2]);
    }
    fs::write(folder.path().join("t.csv"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder.path())
        .args([
            "calibrate",
            "stations",
            "t.csv",
            "--terms",
            "+bias.temperature",
        ])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success());
    assert!(text.contains("accel.bias.temperature"), "{text}");
    assert!(text.contains("the six faces at"), "{text}");
}

#[test]
fn schedules() {
    let mut log = String::from("time [s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n");
    for k in 1..=1000 {
        let shake = f64::from(k * 7919 % 1009) / 1009.0;
        let _ = writeln!(
            log,
            "{},{},{},{}",
            f64::from(k) / 100.0,
            shake,
            3.0 * shake,
            9.8 - shake
        );
    }
    let words = [
        "stations",
        "log.csv",
        "--schedule",
        "s.csv",
        "-o",
        "out.toml",
    ];
    let schedule = |text: &str, wanted: &[&str]| {
        refused(&[("log.csv", &log), ("s.csv", text)], &words, 1, wanted);
    };
    schedule("up\n+x\n-x\n", &["dwells", "the schedule has 2"]);
    schedule(
        "start [s],end [s],up\n0,5,+z\n50,60,-z\n",
        &[
            "station 2 from 50 s to 60 s holds no samples",
            "0.01 s to 10 s",
        ],
    );
    schedule(
        "start [s],end [s],up\n5,0,+z\n",
        &["ends at 0 s, before it starts"],
    );
    schedule(
        "start [s],end [s],up\n0,5,+z\n,,-z\n",
        &["some rows have start and end"],
    );
    schedule(
        "up,accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n+z,0,0,9.8\n",
        &["a schedule has no outputs"],
    );
    schedule(
        "angle_x [deg],angle_y [deg],angle_z [deg]\n360,0,0\n",
        &["an angle and no start and end"],
    );
    refused(
        &[("t.csv", &faces())],
        &["stations", "t.csv", "--rate", "100Hz", "-o", "out.toml"],
        2,
        &["need --schedule"],
    );
}

#[test]
fn plans_and_merges() {
    refused(
        &[],
        &["plan", "five-position", "-o", "out.csv"],
        2,
        &["six-position, tumble24"],
    );
    refused(
        &[],
        &[
            "plan",
            "tumble24",
            "--precision",
            "accel.bias",
            "-o",
            "out.csv",
        ],
        2,
        &["accel.bias=1 mg"],
    );
    refused(
        &[],
        &["plan", "tumble24", "--precision", "accel.bias=1 deg/h"],
        2,
        &["accel"],
    );
    refused(
        &[],
        &[
            "plan",
            "tumble24",
            "--precision",
            "gyro.noise.angle_random_walk=1 deg/sqrt(h)",
        ],
        2,
        &["no test of stations"],
    );
    let model = "schema = 1\nname = \"a\"\n[accel.bias]\nfixed = { value = \"1 mg\", sigma = \"0.1 mg\" }\n";
    refused(
        &[("a.toml", model)],
        &["merge", "a.toml", "-o", "out.toml"],
        2,
        &["name two or more"],
    );
    refused(
        &[("a.toml", model), ("b.toml", model)],
        &["merge", "a.toml", "b.toml", "-o", "out.toml"],
        1,
        &["count twice"],
    );
    let other = model.replace("1 mg\", sigma", "3 mg\", sigma");
    refused(
        &[("a.toml", model), ("b.toml", &other)],
        &["merge", "a.toml", "b.toml", "--strict", "-o", "out.toml"],
        1,
        &["accel.bias.x of a.toml and b.toml differ by"],
    );
}
