//! `characterize --follow`: a log that grows is read as it comes, with what is known of it and how long it must go on.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::flat;

/// Rows of three gyro axes with white noise, at 100 Hz, after the header.
fn rows(count: usize) -> String {
    let mut text = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n".to_owned();
    let mut state = 1_u64;
    let mut noise = || {
        // The sum of twelve uniform numbers.
        let uniform = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut state)).sum::<f64>() - 6.0
    };
    for k in 1..=count {
        let time = k as f64 / 100.0;
        let _ = writeln!(
            text,
            "{time},{},{},{}",
            1e-3 * noise(),
            1e-3 * noise(),
            1e-3 * noise()
        );
    }
    text
}

fn follow(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .arg("characterize")
        .args(arguments)
        .arg("--follow")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Exit code and both channels of a run that must end by itself.
fn ended(mut child: Child) -> (i32, String, String) {
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > Duration::from_mins(1) {
            let _ = child.kill();
            let mut said = String::new();
            child
                .stderr
                .take()
                .unwrap()
                .read_to_string(&mut said)
                .unwrap();
            panic!("it does not end: {said}");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let mut both = [String::new(), String::new()];
    child
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut both[0])
        .unwrap();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut both[1])
        .unwrap();
    let [out, said] = both;
    (status.code().unwrap_or(-1), out, flat(&said))
}

#[test]
fn a_wanted_precision_ends_a_pipe_that_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = follow(folder.path(), &["-", "--until", "angle_random_walk=5%"]);
    // 600 rows where 5 % need 200, and the pipe stays open.
    let mut pipe = child.stdin.take().unwrap();
    pipe.write_all(rows(600).as_bytes()).unwrap();
    let (code, out, said) = ended(child);
    drop(pipe);
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("Angle random walk"), "{out}");
    // Seen where it was reached, not where the input paused; the wanted value is said as it was given.
    assert!(said.contains("note: 2 s read; gyro"), "{said}");
    assert!(!said.contains("note: 3 s read"), "{said}");
    assert!(said.contains("1 sigma 8.9 % (5 % in "), "{said}");
}

#[test]
fn what_is_known_is_said_beside_what_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = follow(
        folder.path(),
        &[
            "-",
            "--until",
            "rate_random_walk=0.5%,angle_random_walk=0.125%",
        ],
    );
    child
        .stdin
        .take()
        .unwrap()
        .write_all(rows(2000).as_bytes())
        .unwrap();
    let (code, _, said) = ended(child);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("gyro K not seen yet"), "{said}");
    assert!(said.contains("(0.125 % in "), "{said}");
    assert!(!said.contains("nothing is known"), "{said}");
}

#[test]
fn a_term_that_cannot_come_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (list, terms, code, why) in [
        (
            "velocity_random_walk=5%",
            "all",
            1,
            "the log has no accelerometer, so velocity_random_walk can never be known",
        ),
        (
            "bias_instability=5%",
            "angle_random_walk",
            2,
            "bias_instability is not looked for",
        ),
        (
            "angle_random_walk=5%",
            "gauss_markov,bias_instability",
            2,
            "without white noise among the terms no noise is explained",
        ),
    ] {
        let mut child = follow(folder.path(), &["-", "--until", list, "--terms", terms]);
        // It may have refused before it read.
        let mut pipe = child.stdin.take().unwrap();
        let _ = pipe.write_all(rows(100).as_bytes());
        let (found, _, said) = ended(child);
        drop(pipe);
        assert_eq!(found, code, "{said}");
        assert!(said.contains(why), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_growing_file_is_read_on_until_an_interrupt() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let all = rows(500);
    let half = all.len() / 2;
    fs::write(&path, &all[..half]).unwrap();
    let child = follow(folder.path(), &["log.csv", "--format", "json"]);
    std::thread::sleep(Duration::from_secs(2));
    let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    // The last line is not whole yet.
    file.write_all(&all.as_bytes()[half..all.len() - 4])
        .unwrap();
    std::thread::sleep(Duration::from_secs(3));
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let (code, out, said) = ended(child);
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("\"samples\":499"), "{out}");
    assert!(
        said.contains("1 sigma") && said.contains("gyro B not seen yet"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_file_that_is_cut_replaced_or_removed_is_followed_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let all = rows(600);
    let place = |row: usize| all.match_indices('\n').nth(row).unwrap().0 + 1;
    fs::write(&path, &all[..place(300)]).unwrap();
    let child = follow(folder.path(), &["log.csv", "--format", "json"]);
    let wait = || std::thread::sleep(Duration::from_millis(1500));
    wait();
    // Cut and written on: the times go on.
    let header = &all[..place(0)];
    fs::write(&path, format!("{header}{}", &all[place(300)..])).unwrap();
    wait();
    // Another recording in its place.
    fs::write(folder.path().join("next.csv"), &all[..place(200)]).unwrap();
    fs::rename(folder.path().join("next.csv"), &path).unwrap();
    wait();
    fs::remove_file(&path).unwrap();
    wait();
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.unwrap().success());
    let (code, out, said) = ended(child);
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains("read from its start: its times go on, what was read before counts as well"),
        "{said}"
    );
    assert!(
        said.contains("log.csv was replaced, read from its start: its times begin again"),
        "{said}"
    );
    assert_eq!(said.matches("was removed").count(), 1, "{said}");
    assert!(said.contains("6 s read"), "{said}");
    assert!(out.contains("\"samples\":200"), "{said}");
}

#[test]
fn a_row_that_cannot_be_read_leaves_the_result_of_those_before() {
    let folder = tempfile::tempdir().unwrap();
    for (count, has_result) in [(500, true), (20, false)] {
        let mut child = follow(folder.path(), &["-"]);
        let text = rows(count) + "spoilt\n";
        let mut pipe = child.stdin.take().unwrap();
        pipe.write_all(text.as_bytes()).unwrap();
        drop(pipe);
        let (code, out, said) = ended(child);
        assert_eq!(code, 1, "{said}");
        assert_eq!(out.contains("Angle random walk"), has_result, "{out}");
        assert!(said.contains("has 1 cell"), "{said}");
    }
}
