//! What the tests of refusals share: an error is folded to 80 columns, its place and its advice begin with two blanks.
#![allow(dead_code, reason = "no test uses all of it")]
#![allow(clippy::unwrap_used, reason = "tests")]

pub(crate) mod part;

use std::fs;
use std::path::Path;

/// Lines of an error that are no continuation of the one before: what, where, what to do.
pub(crate) fn sentences(said: &str) -> usize {
    said.lines()
        .filter(|line| !line.starts_with("    "))
        .count()
}

/// Text as if it had not been folded.
pub(crate) fn flat(said: &str) -> String {
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The program, run in a folder.
pub(crate) fn sagnac(folder: &Path, args: &[&str]) -> std::process::Output {
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .current_dir(folder)
        .args(args)
        .timeout(std::time::Duration::from_mins(2))
        .output()
        .unwrap()
}

/// What is said on both channels where the command succeeds.
pub(crate) fn said(folder: &Path, args: &[&str]) -> String {
    let output = sagnac(folder, args);
    let both = [output.stdout, output.stderr].concat();
    let text = flat(&String::from_utf8_lossy(&both));
    assert!(output.status.success(), "{args:?}: {text}");
    text
}

/// The sentence where the command refuses, and leaves no file.
pub(crate) fn refused(folder: &Path, args: &[&str], code: i32) -> String {
    let before = fs::read_dir(folder).unwrap().count();
    let output = sagnac(folder, args);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    assert!(
        text.starts_with("error: ") && sentences(&text) <= 3,
        "{args:?}: {text}"
    );
    assert_eq!(
        fs::read_dir(folder).unwrap().count(),
        before,
        "{args:?} leaves a file"
    );
    flat(&text)
}

/// A model of biases alone.
pub(crate) const BIASES: &str = "name = \"part\"\nsample_rate = \"100 Hz\"\n[gyro.bias]\nfixed = \"1 deg/s\"\n\
[gyro.bias.instability]\ncoefficient = \"8 deg/h\"\n[accel.bias]\nstability = \"1 mg\"\n";

/// A folder with [`BIASES`] as `part.toml`.
pub(crate) fn biased_part() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.toml"), BIASES).unwrap();
    folder
}
