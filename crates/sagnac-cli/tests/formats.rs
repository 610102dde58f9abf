//! Logs of other tools through the built program: folders, topics by number, names kept, and resampling by the stamps.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use common::{refused, said};

const SIX: &str = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]";

fn testdata(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../testdata")
        .join(name)
}

/// Rows of a CSV without its header.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let row = |line: &str| line.split(',').map(|c| c.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

fn sine(t: f64) -> f64 {
    (10.0 * std::f64::consts::PI * t).sin()
}

/// 10 s of a sine of 5 Hz at 200 Hz, its stamps and values as `change` leaves them.
fn log(at: &Path, change: impl Fn(i32, &mut f64, &mut f64)) {
    let mut text = format!("{SIX}\n");
    for k in 0..2000 {
        let (mut t, mut late) = (f64::from(k) / 200.0, 0.0);
        change(k, &mut t, &mut late);
        let value = if late.is_nan() { late } else { sine(t) };
        let _ = writeln!(text, "{t},{value},1,0");
    }
    fs::write(at.join("log.csv"), text).unwrap();
}

fn resampled(at: &Path, rate: &str) -> String {
    let words = ["convert", "log.csv", "-o", "out.csv", "--force"];
    said(at, &[&words[..], &["--resample", rate]].concat())
}

/// The largest distance from the sine, a second from the ends.
fn error(at: &Path) -> f64 {
    rows(&at.join("out.csv"))
        .iter()
        .filter(|row| (1.0..9.0).contains(&row[0]) && row[1].is_finite())
        .map(|row| (row[1] - sine(row[0])).abs())
        .fold(0.0, f64::max)
}

#[test]
fn samples_are_resampled_at_their_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    log(at, |_, _, _| {});
    let text = resampled(at, "50Hz");
    assert!(
        !text.contains("jitter") && !text.contains("bridged"),
        "{text}"
    );
    assert!(error(at) < 1e-4, "{}", error(at));
    // Stamps off by up to 2 ms of 5 ms: the sine is 0.06 off where they are ignored.
    log(at, |k, t, _| *t += 4e-6 * f64::from(k * 7919 % 1001 - 500));
    let text = resampled(at, "50Hz");
    assert!(
        text.contains("time stamps jitter by up to") && text.contains("taken at its stamp"),
        "{text}"
    );
    assert!(error(at) < 1e-3, "{}", error(at));
}

#[test]
fn what_resampling_bridges_or_cannot_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    log(at, |k, _, value| {
        if (600..603).contains(&k) || (1000..1040).contains(&k) {
            *value = f64::NAN;
        }
    });
    let text = resampled(at, "50Hz");
    assert!(
        text.contains("no finite numbers: 43 of gyro_x; up to 3 in a row were bridged"),
        "{text}"
    );
    let out = rows(&at.join("out.csv"));
    let nan: Vec<f64> = out.iter().filter(|r| r[1].is_nan()).map(|r| r[0]).collect();
    assert_eq!((nan.len(), nan[0], nan[9]), (10, 5.0, 5.18));
    assert!(out.iter().all(|r| (r[2] - 1.0).abs() < 1e-12));
    // Two seconds are missing.
    let text = fs::read_to_string(at.join("log.csv")).unwrap();
    let cut: String = text
        .lines()
        .enumerate()
        .filter(|(k, _)| !(1200..1600).contains(k))
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    fs::write(at.join("log.csv"), cut).unwrap();
    let text = resampled(at, "50Hz");
    assert!(
        text.contains("gap") && text.contains("nothing was filled in"),
        "{text}"
    );
    assert_eq!(rows(&at.join("out.csv")).len(), 401);
    // Time runs back.
    log(at, |k, t, _| {
        *t = f64::from(if k == 900 { 890 } else { k }) / 200.0;
    });
    let words = ["convert", "log.csv", "-o", "back.csv", "--resample", "50Hz"];
    let text = refused(at, &words, 1);
    assert!(
        text.contains("time runs back at row 901") && text.contains("sort the rows"),
        "{text}"
    );
    said(at, &[&words[..], &["--rate", "200Hz"]].concat());
}

#[test]
fn a_recording_is_opened_by_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let record = at.join("record");
    fs::create_dir(&record).unwrap();
    fs::write(
        record.join("metadata.yaml"),
        "rosbag2_bagfile_information:\n",
    )
    .unwrap();
    let text = refused(at, &["info", "record"], 1);
    assert!(text.contains("holds no .db3 or .mcap file"), "{text}");
    fs::copy(testdata("logs/none.mcap"), record.join("a_0.mcap")).unwrap();
    assert!(said(at, &["info", "record"]).contains("MCAP"));
    fs::copy(testdata("logs/none.mcap"), record.join("a_1.mcap")).unwrap();
    let text = refused(at, &["info", "record"], 1);
    assert!(
        text.contains("2 recordings: a_0.mcap, a_1.mcap") && text.contains("record/a_0.mcap"),
        "{text}"
    );
    // A drive of KITTI has dates of cameras as well.
    for part in ["image_00", "oxts"] {
        let data = at.join("drive").join(part).join("data");
        fs::create_dir_all(&data).unwrap();
        let dates: String = (0..5)
            .map(|k| format!("2011-09-26 13:02:25.{k}00000000\n"))
            .collect();
        fs::write(at.join("drive").join(part).join("timestamps.txt"), dates).unwrap();
        for k in 0..5 {
            let line = vec!["1.5"; 30].join(" ");
            fs::write(data.join(format!("{k:010}.txt")), line).unwrap();
        }
    }
    assert!(said(at, &["info", "drive"]).contains("KITTI oxts folder. 5 samples"));
}

#[test]
fn a_recordings_topic_and_frame_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let source = testdata("logs/none.bag").display().to_string();
    for (from, to) in [(source.as_str(), "a.bag"), ("a.bag", "b.mcap")] {
        let text = said(at, &["convert", from, "-o", to]);
        assert!(text.contains("written as /imu, frame_id \"imu\""), "{text}");
        let text = said(at, &["info", to]);
        assert!(
            text.contains(", /imu. 20 samples") && text.contains("frame_id \"imu\""),
            "{text}"
        );
    }
    // Turned axes are another frame's.
    let turned = [
        "convert",
        &source,
        "--axes",
        "x=-y, y=x, z=z",
        "-o",
        "t.bag",
    ];
    let text = said(at, &turned);
    assert!(
        text.contains("turned by --axes") && text.contains("frame_id \"imu\""),
        "{text}"
    );
    log(at, |_, t, _| *t += 1.7e9);
    let text = said(at, &["convert", "log.csv", "-o", "c.bag"]);
    assert!(text.contains("written as /imu/data"), "{text}");
}

#[test]
fn time_that_never_advances_is_refused_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    log(at, |_, t, _| *t = 0.0);
    for words in [
        &["info", "log.csv"][..],
        &["convert", "log.csv", "-o", "a.npy"],
    ] {
        let text = refused(at, words, 1);
        assert!(
            text.contains("time never advances") && text.contains("--rate"),
            "{text}"
        );
    }
}

#[test]
fn columns_are_found_where_other_tools_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // Every row ends by a comma, the header does not; before it stand words of the device.
    fs::write(
        at.join("a.csv"),
        "DEVICE\nSerial,7\n\nTOW,X Accel [x8004],Y Accel,Z Accel\n1,0,0,-1,\n2,0,0,-1,\n3,0,0,-1,\n4,0,0,-1,\n",
    )
    .unwrap();
    let columns = "time=TOW:s, accel=\"X Accel\",\"Y Accel\",\"Z Accel\":g";
    let text = said(at, &["info", "a.csv", "--columns", columns]);
    assert!(text.contains("CSV with a header. 4 samples"), "{text}");
    // Dates are told to be dates.
    let dates = "time,g\n2025-06-14 21:17:02+00:00,1\n2025-06-14 21:17:03+00:00,2\n";
    fs::write(at.join("d.csv"), dates).unwrap();
    for words in [&[][..], &["--columns", "time=0:s, gyro_x=1:deg/s"]] {
        let text = refused(at, &[&["info", "d.csv"][..], words].concat(), 1);
        assert!(text.contains("time=0:iso"), "{text}");
    }
    // Fields of a structure are the channels that they are called, and need a unit.
    fs::write(
        at.join("s.csv"),
        "time [s],gyro.x,gyro.y,gyro.z\n0,1,2,3\n1,1,2,4\n",
    )
    .unwrap();
    for words in [&["info", "s.csv"][..], &["convert", "s.csv", "-o", "o.csv"]] {
        let text = refused(at, words, 1);
        assert!(
            text.contains("the unit of column `gyro.x` is not known")
                && text.contains("gyro=1,2,3:deg/s"),
            "{text}"
        );
    }
}
