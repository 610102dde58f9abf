//! Questions of navigation that cannot be answered, to the built program: one sentence on standard error, exit 1 or 2,
//! nothing written, no panic; and answers that must name what they lack.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{flat, sentences};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const PATH_HEADER: &str = "time [s],latitude [deg],longitude [deg],height [m]\n";

fn sagnac(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str, body: &str| {
        fs::write(
            folder.path().join(format!("{name}.toml")),
            format!("schema = 1\nname = \"{name}\"\n{body}"),
        )
        .unwrap();
    };
    model("bare", "");
    model(
        "noise",
        "[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\n",
    );
    model(
        "coarse",
        "[gyro.bias]\nstability = \"20 deg/h\"\n[accel.bias]\nstability = \"1 mg\"\n",
    );
    let path = |name: &str, rows: &str| {
        fs::write(folder.path().join(name), format!("{PATH_HEADER}{rows}")).unwrap();
    };
    let ahead =
        |of: u32, height: &str| format!("{of},{},0,{height}\n", 45.0 + 1e-4 * f64::from(of));
    let line: String = (0..9).map(|k| ahead(k, "0")).collect();
    path("line.csv", &line);
    path(
        "earth.csv",
        &(0..9)
            .map(|k| ahead(k, if k == 4 { "-10000" } else { "0" }))
            .collect::<String>(),
    );
    path("jump.csv", &line.replace("45.0004", "46.0004"));
    path("one.csv", "0,45,0,0\n");
    path("still.csv", "0,45,0,0\n1,45,0,0\n2,45,0,0\n");
    path("back.csv", &(line + "3,45.001,0,0\n"));
    fs::write(
        folder.path().join("foreign.csv"),
        "time [s],foo\n0,1\n1,2\n",
    )
    .unwrap();
    fs::write(folder.path().join("empty.csv"), "").unwrap();
    folder
}

#[test]
fn impossible_questions_are_refused() {
    let folder = folder();
    let files = fs::read_dir(folder.path()).unwrap().count();
    let fine = "catalog:HG9900";
    let cases: &[(&[&str], i32, &str)] = &[
        // Paths through the Earth, with jumps, too short, backwards, without positions.
        (
            &["drift", fine, "--trajectory", "earth.csv"],
            1,
            "through the Earth",
        ),
        (&["drift", fine, "--trajectory", "jump.csv"], 1, "12000 m/s"),
        (&["drift", fine, "--trajectory", "one.csv"], 1, "two points"),
        (&["drift", fine, "--trajectory", "still.csv"], 1, "attitude"),
        (&["drift", fine, "--trajectory", "back.csv"], 1, "back.csv"),
        (
            &["drift", fine, "--trajectory", "foreign.csv"],
            1,
            "no positions",
        ),
        (&["drift", fine, "--trajectory", "empty.csv"], 1, "empty"),
        (
            &[
                "drift",
                fine,
                "--trajectory",
                "line.csv",
                "--duration",
                "9s",
            ],
            2,
            "ends after 8 s",
        ),
        (
            &["drift", fine, "--trajectory", "dive"],
            2,
            "choose one of rest",
        ),
        (
            &["simulate", fine, "--trajectory", "earth.csv", "-o", "x.csv"],
            1,
            "through the Earth",
        ),
        // Self-alignment that cannot work, with its reason.
        (
            &["drift", "coarse.toml", "--alignment", "self"],
            1,
            "20.0 deg/h hides the 10.6 deg/h",
        ),
        (
            &["drift", fine, "--alignment", "self", "--latitude", "89deg"],
            1,
            "85 deg",
        ),
        (
            &["drift", fine, "--alignment", "rol=1deg"],
            2,
            "no alignment",
        ),
        // Durations, rates, runs.
        (&["drift", fine, "--duration", "0s"], 2, "ten years"),
        (&["drift", fine, "--duration", "-5s"], 2, "ten years"),
        (&["drift", fine, "--duration", "1e30s"], 2, "ten years"),
        (&["drift", fine, "--rate", "0Hz"], 2, "positive"),
        (
            &["drift", fine, "--rate", "1e-9Hz"],
            2,
            "shorter than one sample",
        ),
        (&["drift", fine, "--runs", "0"], 2, "0 runs tell nothing"),
        (
            &["drift", fine, "--method", "monte-carlo", "--runs", "0"],
            2,
            "0 runs tell nothing",
        ),
        (
            &[
                "drift",
                fine,
                "--method",
                "monte-carlo",
                "--runs",
                "4294967295",
            ],
            2,
            "would take days",
        ),
        (
            &[
                "drift",
                fine,
                "--method",
                "monte-carlo",
                "--rate",
                "1e12Hz",
                "--report",
                "x.html",
            ],
            2,
            "would take days",
        ),
        // Places.
        (&["drift", fine, "--latitude", "95deg"], 2, "-90 to 90 deg"),
        (&["drift", fine, "--height", "-10km"], 2, "-500 m"),
        (
            &["drift", fine, "--trajectory", "drive", "--roll", "5deg"],
            2,
            "sets its own attitude",
        ),
        // Requirements.
        (&["budget", "--cep", "0m", "--after", "1h"], 2, "positive"),
        (&["budget", "--cep", "1 kg", "--after", "1h"], 2, "kg"),
        (
            &[
                "budget",
                "--cep",
                "1km",
                "--after",
                "1h",
                "--trajectory",
                "line.csv",
            ],
            2,
            "ends after",
        ),
        (
            &["catalog", "search", "--drift", "1 km"],
            2,
            "no drift requirement",
        ),
        (
            &["catalog", "search", "--drift", "huge after never"],
            2,
            "huge",
        ),
        // The catalogue.
        (&["catalog", "show", "HG990"], 2, "HG9900"),
        (&["catalog", "compare", "HG9900", "NOPE"], 2, "NOPE"),
        (
            &[
                "catalog",
                "list",
                "--where",
                "gyro.angle_random_wlk < 0.1 deg/sqrt(h)",
            ],
            2,
            "gyro.noise.angle_random_walk",
        ),
        (
            &[
                "catalog",
                "list",
                "--where",
                "gyro.angle_random_walk < 0.1 m",
            ],
            2,
            "got a length",
        ),
        (&["catalog", "list", "--where", "((("], 2, "cannot be read"),
        (&["catalog", "list", "--sort", "nope"], 2, "nope"),
        (&["catalog", "list", "--catalog", "nowhere"], 1, "nowhere"),
        (
            &["grade", fine, "--table", "foo"],
            2,
            "lecture, groves or el-sheimy",
        ),
        // Recordings.
        (
            &[
                "strapdown",
                "empty.csv",
                "--reference",
                "line.csv",
                "-o",
                "n.csv",
            ],
            1,
            "empty",
        ),
        (
            &[
                "strapdown",
                "line.csv",
                "--reference",
                "line.csv",
                "-o",
                "n.csv",
            ],
            1,
            "gyro_x",
        ),
        (
            &[
                "drift",
                fine,
                "--log",
                "empty.csv",
                "--reference",
                "line.csv",
            ],
            1,
            "empty",
        ),
        (&["drift", fine, "--log", "line.csv"], 2, "--reference"),
    ];
    for (args, code, word) in cases {
        let output = sagnac(folder.path(), args);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{args:?}: {said}");
        assert!(said.starts_with("error: "), "{args:?}: {said}");
        assert!(sentences(&said) <= 3, "{args:?}: {said}");
        assert!(
            flat(&said).contains(word),
            "{args:?} lacks `{word}`: {said}"
        );
        assert!(
            output.stdout.is_empty(),
            "{args:?} writes to standard output"
        );
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            files,
            "{args:?} leaves a file"
        );
    }
}

#[test]
fn numbers_that_a_question_needs_and_the_model_lacks_are_named() {
    let folder = folder();
    let all = |args: &[&str]| {
        let output = sagnac(folder.path(), args);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(output.status.success(), "{args:?}: {said}");
        said
    };
    let drift = all(&["drift", "bare.toml"]);
    let budget = all(&["budget", "bare.toml", "--cep", "1 km", "--after", "10min"]);
    for word in [
        "the gyro's white noise",
        "every bias term of the accelerometer",
        "counts as zero",
    ] {
        assert!(drift.contains(word), "{drift}");
        assert!(budget.contains(word), "{budget}");
    }
    assert!(
        budget.contains("no error that moves the position"),
        "{budget}"
    );
    let noise = all(&["drift", "noise.toml"]);
    assert!(!noise.contains("the gyro's white noise"), "{noise}");
    let grade = all(&["grade", "bare.toml"]);
    assert!(
        grade.contains("No grade") && grade.contains("gyro.bias.stability"),
        "{grade}"
    );
}

#[test]
fn a_requirement_that_nothing_meets_shows_the_nearest_three() {
    let folder = folder();
    let args = [
        "budget", "--cep", "1mm", "--after", "24h", "--format", "json",
    ];
    let output = sagnac(folder.path(), &args);
    assert!(output.status.success());
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["met_by"].as_array().unwrap().len(), 0);
    let nearest = answer["nearest"].as_array().unwrap();
    assert_eq!(nearest.len(), 3);
    let cep: Vec<f64> = nearest
        .iter()
        .map(|s| s["cep_m"].as_f64().unwrap())
        .collect();
    assert!(cep.is_sorted() && cep[0] > 1e-3, "{cep:?}");
    let text = text(&sagnac(folder.path(), &args[..5]).stdout);
    assert!(
        text.contains("None of the catalogue") && text.contains("nearest"),
        "{text}"
    );
}

#[test]
fn a_path_with_positions_and_quaternions_of_other_names_is_read() {
    let folder = folder();
    let rows: String = (0..9)
        .map(|k| format!("{k},0,{},0,1,0,0,0\n", 10 * k))
        .collect();
    fs::write(
        folder.path().join("camera.csv"),
        format!("t,px,py,pz,qw,qx,qy,qz\n{rows}"),
    )
    .unwrap();
    let columns = "time=t:s, position_x=px:m, position_y=py:m, position_z=pz:m, quaternion_w=qw, \
                   quaternion_x=qx, quaternion_y=qy, quaternion_z=qz";
    let args = [
        "drift",
        "catalog:HG9900",
        "--trajectory",
        "camera.csv",
        "--reference-columns",
    ];
    let output = sagnac(folder.path(), &[&args[..], &[columns]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}
