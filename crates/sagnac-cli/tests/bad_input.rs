//! Bad input to the built program: one sentence on standard error, exit 1 or 2, nothing written, no panic.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use assert_cmd::Command;
use common::{flat, sentences};

const HEADER: &str = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n";

fn rows(from: usize, to: usize) -> String {
    (from..to).fold(String::new(), |mut text, k| {
        let v = |c: usize| ((k * 7919 + c * 104_729) % 1009) as f64 * 1e-6;
        let _ = writeln!(text, "{},{},{},{}", k as f64 / 100.0, v(0), v(1), v(2));
        text
    })
}

fn sagnac() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
}

fn is_one_refusal(output: &Output, what: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        matches!(output.status.code(), Some(1 | 2)),
        "{what}: {:?} {stderr}",
        output.status
    );
    assert!(stderr.starts_with("error: "), "{what}: {stderr}");
    assert!(sentences(&stderr) <= 3, "{what}: {stderr}");
    assert!(!stderr.contains("panicked"), "{what}: {stderr}");
    assert!(output.stdout.is_empty(), "{what} writes to standard output");
}

/// Every command that reads a log refuses `name`, with `word` in the sentence, and leaves nothing behind.
fn refused(folder: &Path, name: &str, options: &[&str], word: &str) {
    let commands: [&[&str]; 4] = [
        &["info"],
        &["allan", "-o", "out.csv"],
        &["characterize", "-o", "out.toml", "--report", "out.html"],
        &["convert", "-o", "out.npy"],
    ];
    let before = fs::read_dir(folder).unwrap().count();
    for command in commands {
        let output = sagnac()
            .current_dir(folder)
            .args([command[0], name])
            .args(&command[1..])
            .args(options)
            .timeout(std::time::Duration::from_mins(1))
            .output()
            .unwrap();
        let what = format!("{} {name}", command[0]);
        is_one_refusal(&output, &what);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(flat(&stderr).contains(word), "{what}: {stderr}");
        assert_eq!(
            fs::read_dir(folder).unwrap().count(),
            before,
            "{what} leaves a file"
        );
    }
}

#[test]
fn unsound_tables_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let good = format!("{HEADER}{}", rows(0, 200));
    let with = |row: &str| format!("{HEADER}{}{row}\n{}", rows(0, 50), rows(51, 100));
    let without_time: String = good
        .lines()
        .map(|l| format!("{}\n", l.split_once(',').unwrap().1))
        .collect();
    let cases: [(&str, String, &str); 10] = [
        ("empty.csv", String::new(), "empty"),
        ("header.csv", HEADER.to_owned(), "no rows"),
        ("text.csv", with("0.5,abc,1,2"), "line 52"),
        ("short.csv", with("0.5,1"), "row 51 has 2 cells"),
        ("long.csv", with("0.5,1,2,3,4,5"), "row 51 has 6 cells"),
        (
            "unit.csv",
            good.replace("gyro_x [rad/s]", "gyro_x [furlong/s]"),
            "gyro_x",
        ),
        (
            "dimension.csv",
            good.replace("gyro_x [rad/s]", "gyro_x [m/s^2]"),
            "angular rate",
        ),
        ("twice.csv", good.replace("gyro_y", "gyro_x"), "gyro_x"),
        ("timeless.csv", without_time, "no time and no rate"),
        ("endless.csv", "7".repeat(8 << 20), "no table"),
    ];
    for (name, text, word) in &cases {
        fs::write(folder.path().join(name), text).unwrap();
        refused(folder.path(), name, &[], word);
    }
    refused(folder.path(), "absent.csv", &[], "no such file");
    refused(folder.path(), ".", &[], "folder");
    fs::write(folder.path().join("good.csv"), &good).unwrap();
    refused(folder.path(), "good.csv", &["--rate", "200m"], "frequency");
    let columns = ["--columns", "gyro=9:deg/s"];
    refused(folder.path(), "good.csv", &columns, "column 9");
}

#[test]
fn tables_that_tell_nothing_are_refused_by_what_judges_them() {
    let folder = tempfile::tempdir().unwrap();
    let constant: String = (0..100).map(|k| format!("5,{k},1,2\n")).collect();
    let of = |v: &str| -> String {
        (0..100)
            .map(|k| format!("{},{v},{v},{v}\n", f64::from(k) / 100.0))
            .collect()
    };
    let cases = [
        ("one.csv", rows(0, 1), "one sample"),
        ("constant.csv", constant, "never advances"),
        ("nan.csv", of("nan"), "no numbers"),
        ("infinite.csv", of("-inf"), "no numbers"),
    ];
    for (name, body, word) in cases {
        fs::write(folder.path().join(name), format!("{HEADER}{body}")).unwrap();
        for command in ["info", "allan", "characterize"] {
            let output = sagnac()
                .current_dir(folder.path())
                .args([command, name])
                .output()
                .unwrap();
            is_one_refusal(&output, name);
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(flat(&stderr).contains(word), "{command} {name}: {stderr}");
        }
    }
}

#[test]
fn binary_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 1_u64;
    let garbage: Vec<u8> = std::iter::repeat_with(|| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 56) as u8
    })
    .take(300_000)
    .collect();
    fs::write(folder.path().join("garbage.csv"), &garbage).unwrap();
    refused(folder.path(), "garbage.csv", &[], "not known");

    for order in ["False", "True "] {
        let mut header =
            format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (1000000000000, 4), }}");
        while (10 + header.len() + 1) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend([0; 3200]);
        fs::write(folder.path().join("huge.npy"), &bytes).unwrap();
        let columns = ["--columns", "time=0:s, gyro=1,2,3:rad/s"];
        refused(folder.path(), "huge.npy", &columns, "promises");
    }
}

/// The bytes packed by the program itself.
fn packed(folder: &Path, name: &str) -> Vec<u8> {
    let path = folder.join("whole.csv");
    fs::write(&path, format!("{HEADER}{}", rows(0, 5000))).unwrap();
    sagnac()
        .current_dir(folder)
        .args(["convert", "whole.csv", "-o", name])
        .assert()
        .success();
    let bytes = fs::read(folder.join(name)).unwrap();
    fs::remove_file(folder.join(name)).unwrap();
    bytes
}

#[test]
fn cut_and_damaged_packed_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["whole.csv.gz", "whole.csv.zst"] {
        let bytes = packed(folder.path(), name);
        let cut = folder.path().join(format!("cut-{name}"));
        fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
        refused(folder.path(), &format!("cut-{name}"), &[], "cut off");
    }
}

#[test]
fn cut_text_tells_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = packed(folder.path(), "whole.csv.gz");
    fs::write(folder.path().join("cut.csv.gz"), &bytes[..bytes.len() / 2]).unwrap();
    refused(folder.path(), "cut.csv.gz", &[], "gzip -dc FILE");
}

#[test]
fn time_that_tells_no_rate_is_named_with_its_file() {
    let folder = tempfile::tempdir().unwrap();
    for (name, stamp, word) in [
        ("still.csv", "5", "time never advances"),
        ("none.csv", "nan", "no time stamp is a number"),
        ("back.csv", "", "time only runs backwards"),
    ] {
        let stamp = |k: i32| match stamp {
            "" => (500 - k).to_string(),
            same => same.to_owned(),
        };
        let body: String = (0..200)
            .map(|k| format!("{},{},1,2\n", stamp(k), k % 7))
            .collect();
        fs::write(folder.path().join(name), format!("{HEADER}{body}")).unwrap();
        for command in ["info", "allan"] {
            let output = sagnac()
                .current_dir(folder.path())
                .args([command, name])
                .output();
            let output = output.unwrap();
            is_one_refusal(&output, name);
            let stderr = String::from_utf8_lossy(&output.stderr);
            for word in [word, name, "add --rate"] {
                assert!(flat(&stderr).contains(word), "{command}: {stderr}");
            }
        }
    }
}

#[test]
fn negative_values_are_told_from_options() {
    for (arguments, words) in [
        (
            &["info", "a.csv", "--start", "-1 s"][..],
            "write --start='-1 s' with =, or leave the minus out",
        ),
        (
            &["info", "a.csv", "--rate", "-5 Hz"],
            "--rate must not be negative",
        ),
        // One that the command does not have.
        (&["info", "a.csv", "--seed", "-1"], "'--seed' found"),
    ] {
        let output = sagnac().args(arguments).output().unwrap();
        is_one_refusal(&output, words);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(
            stderr.contains(words) && !stderr.contains("-- -"),
            "{stderr}"
        );
        assert_eq!(output.status.code(), Some(2));
    }
}

#[test]
fn numbers_that_an_option_cannot_take_are_told_with_what_it_takes() {
    for (arguments, words) in [
        (
            &["--seed=-1"][..],
            "--seed takes a whole number from 0 on, not `-1`",
        ),
        (&["--seed", "-1"], "write for instance --seed 1"),
        (&["--seed", "1e9"], "from 0 on, not `1e9`"),
        (
            &["--seed", "99999999999999999999"],
            "from 0 to 18446744073709551615, not `99999999999999999999`",
        ),
        (
            &["--runs", "1.5"],
            "--runs takes a whole number from 1 on, not `1.5`",
        ),
        (&["--runs", "9999999999"], "from 1 to 1000000, not"),
        (&["--threads=many"], "write for instance --threads 4"),
        (&["--rate=-1Hz"], "--rate must be positive"),
    ] {
        let output = sagnac()
            .args([
                "simulate",
                "catalog:ADIS16470",
                "--rest",
                "1s",
                "-o",
                "a.csv",
            ])
            .args(arguments)
            .output()
            .unwrap();
        is_one_refusal(&output, words);
        let said = flat(&String::from_utf8_lossy(&output.stderr));
        assert!(
            said.contains(words) && !said.contains("invalid value"),
            "{said}"
        );
        assert_eq!(output.status.code(), Some(2), "{said}");
    }
}

#[test]
fn a_window_shorter_than_two_samples_is_a_wrong_request() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("a.csv");
    fs::write(&log, format!("{HEADER}{}", rows(0, 400))).unwrap();
    for (window, words) in [
        ("1us", "a window of 1 us is shorter than two samples"),
        ("1h", "does not fit a stretch of"),
    ] {
        let output = sagnac()
            .arg("allan")
            .arg(&log)
            .args(["--dynamic", window])
            .output()
            .unwrap();
        is_one_refusal(&output, words);
        let said = flat(&String::from_utf8_lossy(&output.stderr));
        assert!(said.contains(words), "{said}");
        assert_eq!(output.status.code(), Some(2), "{said}");
    }
}

#[test]
fn values_beyond_measure_keep_the_table_in_80_columns() {
    let folder = tempfile::tempdir().unwrap();
    let mut body = rows(0, 500);
    body += "5,1e308,-1e308,1e300\n5.01,-1e308,1e-300,1e300\n";
    fs::write(folder.path().join("a.csv"), format!("{HEADER}{body}")).unwrap();
    let output = sagnac()
        .current_dir(folder.path())
        .args(["info", "a.csv"])
        .output()
        .unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    assert!(text.contains("1e308") && !text.contains("inf"), "{text}");
}

#[cfg(unix)]
#[test]
fn an_unreadable_file_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("closed.csv");
    fs::write(&path, format!("{HEADER}{}", rows(0, 200))).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(&path).is_ok() {
        // This user reads everything: nothing to refuse.
        return;
    }
    refused(folder.path(), "closed.csv", &[], "cannot be read");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_a_closed_pipe_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("good.csv");
    let mut file = fs::File::create(&path).unwrap();
    file.write_all(format!("{HEADER}{}", rows(0, 5000)).as_bytes())
        .unwrap();
    let program = env!("CARGO_BIN_EXE_sagnac");
    let full = || {
        let disk = fs::OpenOptions::new().write(true).open("/dev/full");
        Stdio::from(disk.unwrap())
    };
    for word in ["--help", "--version", "allan --help"] {
        let output = std::process::Command::new(program)
            .args(word.split(' '))
            .stdout(full())
            .output()
            .unwrap();
        is_one_refusal(&output, word);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(1)
                && stderr.contains("standard output cannot be written: no space left"),
            "{word}: {stderr}"
        );
    }
    for format in ["text", "json"] {
        let output = std::process::Command::new(program)
            .args(["allan", "--format", format])
            .arg(&path)
            .stdout(full())
            .output()
            .unwrap();
        is_one_refusal(&output, "a full disk");

        let mut child = std::process::Command::new(program)
            .args(["allan", "--taus", "all", "--format", format])
            .arg(&path)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert!(matches!(output.status.code(), Some(0 | 1)), "{stderr}");
    }
}

/// A disk that takes 4 KiB of any file.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("good.csv"),
        format!("{HEADER}{}", rows(0, 20_000)),
    )
    .unwrap();
    fs::write(
        folder.path().join("m.toml"),
        "schema = 1\nname = \"m\"\n[gyro.noise]\nangle_random_walk = \"1 deg/sqrt(h)\"\n",
    )
    .unwrap();
    for words in [
        "convert good.csv -o out.npy",
        "convert good.csv -o out.csv.gz",
        "convert good.csv -o out.mcap",
        "convert good.csv -o out.bag",
        "convert good.csv -o out.npz",
        "characterize good.csv --report out.html",
        "allan good.csv -o out.csv --taus all",
        "allan good.csv -o out.png",
        "simulate m.toml --rest 10min --rate 100Hz -o out.csv",
        "correct m.toml good.csv -o out.csv",
    ] {
        let before = fs::read_dir(folder.path()).unwrap().count();
        let output = std::process::Command::new("sh")
            .current_dir(folder.path())
            .arg("-c")
            .arg(format!(
                "trap '' XFSZ; ulimit -f 8; exec {} {words}",
                env!("CARGO_BIN_EXE_sagnac")
            ))
            .output()
            .unwrap();
        is_one_refusal(&output, words);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{words}: {stderr}");
        assert!(
            stderr.contains("out.") && stderr.contains("file too large"),
            "{words}: {stderr}"
        );
        assert!(!stderr.contains(".sagnac-"), "{words}: {stderr}");
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            before,
            "{words} leaves a file"
        );
    }
}

/// What `demo` writes does not fit on a disk that takes 4 KiB of any file: a folder that it made goes, one that was there stays.
#[cfg(target_os = "linux")]
#[test]
fn a_demo_that_fails_leaves_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("mine")).unwrap();
    for name in ["mine", "new/inner"] {
        let output = std::process::Command::new("sh")
            .current_dir(folder.path())
            .arg("-c")
            .arg(format!(
                "trap '' XFSZ; ulimit -f 8; exec {} demo {name}",
                env!("CARGO_BIN_EXE_sagnac")
            ))
            .output()
            .unwrap();
        is_one_refusal(&output, name);
        assert_eq!(output.status.code(), Some(1), "{name}");
        let left: Vec<_> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        assert_eq!(left, ["mine"], "{name}");
    }
    assert_eq!(fs::read_dir(folder.path().join("mine")).unwrap().count(), 0);
}

/// A file that opens and cannot be read, whoever asks: the first page of a process is not there.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_fails_while_it_is_read_is_refused() {
    for command in ["info", "allan", "characterize"] {
        let output = sagnac().args([command, "/proc/self/mem"]).output().unwrap();
        is_one_refusal(&output, command);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(
            stderr.contains("cannot be read: input/output error"),
            "{command}: {stderr}"
        );
    }
}
