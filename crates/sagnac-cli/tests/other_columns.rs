//! Columns that are no sensor's, and a rate given beside time stamps, through the built program: from CSV to CSV
//! other columns stay as they are, cell by cell.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const MODEL: &str =
    "name = \"Part\"\nsample_rate = \"100 Hz\"\n[gyro.bias]\nfixed = \"0.25 rad/s\"\n";

/// What other columns hold, a row after the other.
const CELLS: [[&str; 4]; 5] = [
    ["00001", "", "9007199254740993", "\"a, \"\"b\"\"\""],
    ["00002", "x", "18446744073709551615", "plain"],
    ["1e3", " 5 ", "-0", "5\""],
    ["0x1f", "", "1.50", "ä"],
    ["00005", "nan", "+7", "\"\""],
];

fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(args)
        .timeout(std::time::Duration::from_mins(2))
        .output()
        .unwrap()
}

/// All that a command that ends well says.
fn said(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {text}");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `id` before the gyro, a column without a name and `big` behind it, `note` last; parted by `separator`.
fn log(separator: &str) -> String {
    let mut out = [
        "time [s]",
        "id",
        "gyro_x [rad/s]",
        "gyro_y [rad/s]",
        "gyro_z [rad/s]",
        "",
        "big",
        "",
        "note",
    ]
    .join(separator);
    for row in 0..2000 {
        let [id, blank, big, note] = CELLS[row % CELLS.len()];
        let cells = [
            &format!("{}", row as f64 / 100.0),
            id,
            "0.5",
            "0",
            "-1",
            blank,
            big,
            "",
            note,
        ];
        let _ = write!(out, "\n{}", cells.join(separator));
    }
    out + "\n"
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.toml"), MODEL).unwrap();
    fs::write(folder.path().join("log.csv"), log(",")).unwrap();
    folder
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn correct_and_convert_keep_other_cells_as_they_are_and_where_they_are() {
    let folder = folder();
    let at = folder.path();
    said(at, &["convert", "log.csv", "-o", "same.csv"]);
    assert_eq!(read(at, "same.csv"), log(","));
    let text = said(
        at,
        &[
            "correct",
            "part.toml",
            "log.csv",
            "-o",
            "out.csv",
            "--flags",
        ],
    );
    assert!(!text.contains("of text left out"), "{text}");
    let mut want = log(",")
        .replace(",0.5,0,-1,", ",0.25,-0.25,-1.25,")
        .replace('\n', ",0\n");
    want = want.replacen(",note,0\n", ",note,flags\n", 1);
    assert_eq!(read(at, "out.csv"), want);
    // The same for any number of threads, and compressed.
    said(
        at,
        &[
            "--threads",
            "1",
            "correct",
            "part.toml",
            "log.csv",
            "-o",
            "one.csv.gz",
            "--flags",
        ],
    );
    said(at, &["convert", "one.csv.gz", "-o", "one.csv"]);
    assert_eq!(read(at, "one.csv"), want);
}

#[test]
fn cells_of_tables_that_are_parted_otherwise_are_quoted_where_they_must_be() {
    let folder = folder();
    let at = folder.path();
    let text = log(";").replace("plain", "a,b");
    fs::write(at.join("semicolons.csv"), text).unwrap();
    said(at, &["convert", "semicolons.csv", "-o", "commas.csv"]);
    let want = log(",")
        .replace("plain", "\"a,b\"")
        .replace(",5\"\n", ",\"5\"\"\"\n");
    assert_eq!(read(at, "commas.csv"), want);
}

#[test]
fn a_quote_that_is_not_closed_does_not_run_on() {
    let folder = folder();
    let at = folder.path();
    let header = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],note";
    fs::write(
        at.join("open.csv"),
        format!("{header}\n0,1,2,3,\"a,b\n0.01,1,2,3,c\n"),
    )
    .unwrap();
    said(
        at,
        &[
            "correct",
            "part.toml",
            "open.csv",
            "-o",
            "out.csv",
            "--flags",
        ],
    );
    let want = format!("{header},flags\n0,0.75,1.75,2.75,\"a,b\",0\n0.01,0.75,1.75,2.75,c,0\n");
    assert_eq!(read(at, "out.csv"), want);
}

#[test]
fn columns_that_are_cut_or_named_by_columns_keep_their_cells() {
    let folder = folder();
    let at = folder.path();
    said(
        at,
        &[
            "correct",
            "part.toml",
            "log.csv",
            "--columns",
            "time=0:s, gyro=2,3,4:rad/s",
            "--start",
            "0.02 s",
            "--end",
            "0.04 s",
            "-o",
            "cut.csv",
        ],
    );
    let want = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],id,,big,,note\n\
                0.02,0.25,-0.25,-1.25,1e3, 5 ,-0,,5\"\n0.03,0.25,-0.25,-1.25,0x1f,,1.50,,ä\n";
    assert_eq!(read(at, "cut.csv"), want);
}

#[test]
fn simulate_hands_the_other_columns_of_its_input_on() {
    let folder = folder();
    let at = folder.path();
    let text = said(
        at,
        &[
            "simulate",
            "part.toml",
            "--inputs",
            "log.csv",
            "--noise",
            "none",
            "-o",
            "out.csv",
        ],
    );
    assert!(!text.contains("of text left out"), "{text}");
    let mut want =
        String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],id,,big,,note\n");
    for line in log(",").lines().skip(1) {
        let (time, rest) = line.split_once(',').unwrap();
        let (id, rest) = rest.split_once(",0.5,0,-1,").unwrap();
        let _ = writeln!(want, "{time},0.75,0.25,-0.75,{id},{rest}");
    }
    assert_eq!(read(at, "out.csv"), want);
}

#[test]
fn formats_of_numbers_take_the_numbers_and_name_the_rest() {
    let folder = folder();
    let at = folder.path();
    for command in [
        &["convert", "log.csv", "-o", "out.npy"][..],
        &["correct", "part.toml", "log.csv", "-o", "out.npy"],
        &[
            "simulate",
            "part.toml",
            "--inputs",
            "log.csv",
            "-o",
            "out.npy",
        ],
    ] {
        let text = said(at, &[command, &["--force"]].concat());
        assert!(text.contains("columns of text left out: note"), "{text}");
        assert!(
            text.contains("column `id`: 400 cells of text, read as nan"),
            "{text}"
        );
        let info = said(at, &["info", "out.npy"]);
        assert!(info.contains("column 7"), "{info}");
    }
}

#[test]
fn a_rate_given_beside_stamps_is_the_time_that_is_written() {
    let folder = folder();
    let at = folder.path();
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n");
    for row in 0..10 {
        // Stamps that jump about the interval of 0.01 s.
        let time = 5.0 + f64::from(row) * 0.01 + f64::from(row % 3) * 0.001;
        let _ = writeln!(text, "{time:.3},0,0,0");
    }
    fs::write(at.join("jumps.csv"), text).unwrap();
    for command in [
        &["convert", "jumps.csv"][..],
        &["correct", "part.toml", "jumps.csv"],
        &["simulate", "part.toml", "--inputs", "jumps.csv"],
    ] {
        let text = said(
            at,
            &[command, &["--rate", "50 Hz", "-o", "out.csv", "--force"]].concat(),
        );
        assert!(
            text.contains(
                "the times written count from the first time stamp at 50 Hz, as --rate says"
            ),
            "{command:?}: {text}"
        );
        let out = read(at, "out.csv");
        let times: Vec<&str> = out
            .lines()
            .skip(1)
            .map(|l| l.split(',').next().unwrap())
            .collect();
        let want = [
            "5", "5.02", "5.04", "5.06", "5.08", "5.1", "5.12", "5.14", "5.16", "5.18",
        ];
        assert_eq!(times, want, "{command:?}");
        // The stamps themselves stay where no rate is given.
        said(at, &[command, &["-o", "out.csv", "--force"]].concat());
        assert!(read(at, "out.csv").contains("\n5.011,"), "{command:?}");
    }
}
