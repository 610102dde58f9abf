//! Paths and starts of `simulate` and `drift`: what is left out, beyond what holds, or would be ignored is said.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::{biased_part as folder, refused, sagnac, said};

const PATH: &str =
    "time [s],latitude [deg],longitude [deg],height [m],roll [deg],pitch [deg],heading [deg]\n";

/// A path of eleven rows, a row as the cells after the time.
fn path(folder: &Path, name: &str, row: impl Fn(i32) -> String) {
    let rows = (0..11).fold(String::from(PATH), |mut text, k| {
        let _ = writeln!(text, "{k},{}", row(k));
        text
    });
    fs::write(folder.join(name), rows).unwrap();
}

fn east(k: i32, height: &str, heading: &str) -> String {
    format!("45,{},{height},0,0,{heading}", 1e-4 * f64::from(k))
}

#[test]
fn rows_of_a_path_without_a_number_are_told() {
    let folder = folder();
    let at = folder.path();
    path(at, "holes.csv", |k| match k {
        3 => east(k, "", "0"),
        4 | 8 => east(k, "0", "nan"),
        _ => east(k, "0", "0"),
    });
    let go = ["simulate", "part.toml", "--trajectory"];
    let text = said(at, &[&go[..], &["holes.csv", "-o", "a.npy"]].concat());
    assert!(
        text.contains("warning: 3 of 11 rows of holes.csv are left out, the first is row 4 at 3 s, which has no number for the position: the points are up to 3 s apart"),
        "{text}"
    );
    let text = said(
        at,
        &["drift", "catalog:HG9900", "--trajectory", "holes.csv"],
    );
    assert!(text.contains("warning: 3 of 11 rows"), "{text}");
    let json = sagnac(
        at,
        &[&go[..], &["holes.csv", "-o", "b.npy", "--format", "json"]].concat(),
    );
    assert!(String::from_utf8_lossy(&json.stdout).contains("\"warnings\":[\"3 of 11 rows"));
    // One that is whole says nothing, one that has too little left is refused.
    path(at, "whole.csv", |k| east(k, "0", "0"));
    let text = said(at, &[&go[..], &["whole.csv", "-o", "c.npy"]].concat());
    assert!(!text.contains("warning"), "{text}");
    path(at, "none.csv", |k| {
        east(k, "0", if k == 6 { "0" } else { "nan" })
    });
    let text = refused(at, &[&go[..], &["none.csv", "-o", "d.npy"]].concat(), 1);
    assert!(
        text.contains("at least two points, and only one of its 11 rows")
            && text.contains("none.csv, row 1 at 0 s: no attitude"),
        "{text}"
    );
}

/// Replaces a cell of some rows of a CSV file, counted from 1 after the header, by `nan`.
fn spoil(folder: &Path, from: &str, to: &str, column: &str, rows: &[usize]) {
    let text = fs::read_to_string(folder.join(from)).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let place = header
        .split(',')
        .position(|cell| cell.trim().starts_with(column))
        .unwrap();
    let mut out = format!("{header}\n");
    for (k, line) in lines.enumerate() {
        let mut cells: Vec<&str> = line.split(',').collect();
        if rows.contains(&(k + 1)) {
            cells[place] = "nan";
        }
        let _ = writeln!(out, "{}", cells.join(","));
    }
    fs::write(folder.join(to), out).unwrap();
}

#[test]
fn rows_of_a_recording_without_a_number_are_told() {
    let folder = folder();
    let at = folder.path();
    let make = "simulate catalog:HG9900 --trajectory drive --duration 14s --rate 100Hz --seed 1 --truth truth.csv -o log.csv";
    said(at, &make.split(' ').collect::<Vec<_>>());
    spoil(at, "truth.csv", "holes.csv", "latitude", &[600, 601]);
    spoil(at, "log.csv", "bad.csv", "accel_y", &[1200]);
    let recording = |log: &str, reference: &str| {
        let command = [
            "drift",
            "catalog:HG9900",
            "--log",
            log,
            "--reference",
            reference,
        ];
        said(at, &command)
    };
    let text = recording("bad.csv", "holes.csv");
    for part in [
        "2 of 1400 rows of holes.csv are left out, the first is row 600 at 5.99 s, which has no number for the position",
        "1 of 1400 samples of bad.csv is left out, row 1200 at 11.99 s, where a value is not a finite number",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let go = |reference, to| ["strapdown", "log.csv", "--reference", reference, "-o", to];
    let text = said(at, &go("holes.csv", "a.csv"));
    assert!(
        text.contains("warning: 2 of 1400 rows of holes.csv are left out, the first is row 600"),
        "{text}"
    );
    // Whole files say nothing.
    let text = recording("log.csv", "truth.csv") + &said(at, &go("truth.csv", "b.csv"));
    assert!(!text.contains("left out"), "{text}");
}

#[test]
fn trajectories_beyond_what_holds_are_refused_or_warned_of() {
    let folder = folder();
    let at = folder.path();
    path(at, "jump.csv", |k| {
        east(k, if k == 5 { "1e6" } else { "0" }, "0")
    });
    path(at, "second.csv", |k| {
        east(k, if k == 1 { "1e6" } else { "0" }, "0")
    });
    path(at, "below.csv", |k| {
        east(k, &(-400 - 50 * k).to_string(), "0")
    });
    path(at, "beyond.csv", |k| format!("90.5,{k},0,0,0,0"));
    path(at, "far.csv", |k| format!("45,1e300,{k},0,0,0"));
    for (name, words) in [
        (
            "jump.csv",
            "goes 1000000 m in 1 s, faster than 12000 m/s jump.csv, time 5 s",
        ),
        ("second.csv", "faster than 12000 m/s second.csv, time 1 s"),
        (
            "below.csv",
            "below the ellipsoid: through the Earth below.csv, time 3 s",
        ),
        ("beyond.csv", "the latitude 90.5 deg lies beyond a pole"),
        ("far.csv", "the longitude 1e300 deg is none"),
    ] {
        let text = refused(
            at,
            &["simulate", "part.toml", "--trajectory", name, "-o", "a.npy"],
            1,
        );
        assert!(text.contains(words), "{name}: {text}");
    }
    for (options, words) in [
        (
            &["--rest", "1s", "--latitude", "90.1deg"][..],
            "latitude is 90.1 deg",
        ),
        (
            &["--rest", "1s", "--height", "1e300km"],
            "height is 1e303 m",
        ),
        (
            &["--rest", "1s", "--heading", "1e300deg"],
            "heading is 1e300 deg",
        ),
    ] {
        let text = refused(
            at,
            &[&["simulate", "part.toml", "-o", "a.npy"], options].concat(),
            2,
        );
        assert!(text.contains(words), "{text}");
    }
    // The pole itself, and hours of the rocket, are sound; its height is below what gravity's formula holds for.
    path(at, "pole.csv", |k| {
        let latitude = 90.0 - 1e-4 * f64::from((k - 5).abs());
        format!("{latitude},{},0,0,0,0", if k < 5 { 10 } else { 190 })
    });
    for options in [
        &["--trajectory", "pole.csv"][..],
        &[
            "--trajectory",
            "drive",
            "--latitude",
            "90deg",
            "--duration",
            "1min",
        ],
        &[
            "--trajectory",
            "rocket",
            "--duration",
            "5h",
            "--rate",
            "1Hz",
        ],
    ] {
        let text = said(
            at,
            &[
                &["simulate", "part.toml", "-o", "b.csv", "--force"],
                options,
            ]
            .concat(),
        );
        assert!(!text.contains("warning"), "{text}");
        let log = fs::read_to_string(at.join("b.csv")).unwrap();
        assert!(!log.contains("nan") && !log.contains("inf"), "{options:?}");
    }
    let text = said(
        at,
        &[
            "simulate",
            "part.toml",
            "--rest",
            "1s",
            "--height",
            "1000km",
            "-o",
            "c.csv",
        ],
    );
    assert!(
        text.contains("the motion goes up to 1000 km, where the formula of gravity, of second order in height, gives too much by 1.7 %"),
        "{text}"
    );
}

#[test]
fn a_trajectory_that_can_only_be_a_file_is_told_as_one() {
    let folder = folder();
    for command in ["simulate", "drift"] {
        let mut args = vec![command, "part.toml", "--trajectory", "./drive.csv"];
        if command == "simulate" {
            args.extend(["-o", "a.csv"]);
        }
        let text = refused(folder.path(), &args, 1);
        assert!(text.contains("there is no file ./drive.csv"), "{text}");
    }
}

#[test]
fn options_that_a_path_sets_itself_are_refused() {
    let folder = folder();
    let at = folder.path();
    path(at, "geodetic.csv", |k| east(k, "0", "0"));
    let local: String = (0..11)
        .map(|k| format!("{k},{},0,0,1,0,0,0\n", 10 * k))
        .collect();
    let header = "time [s],position_x [m],position_y [m],position_z [m],quaternion_w,quaternion_x,quaternion_y,quaternion_z";
    fs::write(at.join("local.csv"), format!("{header}\n{local}")).unwrap();
    for (name, option, words) in [
        (
            "geodetic.csv",
            "--latitude=10deg",
            "its own latitude, longitude and height",
        ),
        (
            "geodetic.csv",
            "--heading=10deg",
            "its own course and attitude",
        ),
        ("local.csv", "--roll=10deg", "its own course and attitude"),
    ] {
        for go in [
            &["simulate", "part.toml", "-o", "a.csv"][..],
            &["drift", "catalog:HG9900"],
        ] {
            let text = refused(at, &[go, &["--trajectory", name, option]].concat(), 2);
            assert!(
                text.contains("has no meaning") && text.contains(words),
                "{text}"
            );
        }
    }
    // Local axes begin where the start says.
    let go = [
        "simulate",
        "part.toml",
        "--trajectory",
        "local.csv",
        "--latitude",
        "10deg",
    ];
    said(
        at,
        &[&go[..], &["-o", "a.csv", "--truth", "t.csv"]].concat(),
    );
    assert!(
        fs::read_to_string(at.join("t.csv"))
            .unwrap()
            .contains(",10.0")
    );
    // How a file is read says nothing of a motion that is none.
    for motion in [
        &["simulate", "part.toml", "-o", "b.csv", "--rest", "1s"][..],
        &["simulate", "part.toml", "-o", "b.csv", "--inputs", "a.csv"],
        &["drift", "catalog:HG9900", "--trajectory", "drive"],
    ] {
        let text = refused(at, &[motion, &["--reference-rate", "10Hz"]].concat(), 2);
        assert!(
            text.contains("--reference-rate says how a file of way-points is read"),
            "{text}"
        );
    }
}

#[test]
fn a_profile_below_absolute_zero_and_a_truth_without_room_are_told() {
    let folder = folder();
    let at = folder.path();
    fs::write(
        at.join("t.csv"),
        "time [s],temperature [degC]\n0,20\n1,-400\n",
    )
    .unwrap();
    let go = ["simulate", "part.toml", "--rest", "1s"];
    let text = refused(
        at,
        &[&go[..], &["--temperature", "t.csv", "-o", "a.csv"]].concat(),
        1,
    );
    assert!(
        text.contains("-400 degC is below absolute zero t.csv, row 2"),
        "{text}"
    );
    let text = said(
        at,
        &[&go[..], &["-o", "a.csv", "--truth", "truth.mcap"]].concat(),
    );
    assert!(
        text.contains("the truth: sensor_msgs/Imu has no place for gyro_rate_x"),
        "{text}"
    );
}
