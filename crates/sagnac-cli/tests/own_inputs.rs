//! No command replaces what it reads, with or without `--force`, by whatever name.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fs;

use common::{refused, said};

const MODEL: &str = "name = \"part\"\nsample_rate = \"100 Hz\"\n[gyro.bias]\nfixed = \"1 deg/s\"\n";
const TEMPERATURE: &str = "time [s],temperature [degC]\n0,20\n10,30\n";

#[test]
fn an_output_that_is_an_input_is_refused_and_the_input_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("m.csv"), MODEL).unwrap();
    fs::write(at.join("m.toml"), MODEL).unwrap();
    fs::write(at.join("T.csv"), TEMPERATURE).unwrap();
    fs::create_dir(at.join("d")).unwrap();
    let log = ["simulate", "m.toml", "--rest", "1s", "-o", "log.csv"];
    said(at, &log);
    fs::copy(at.join("log.csv"), at.join("log.html")).unwrap();
    let kept = |name: &str| fs::read(at.join(name)).unwrap();
    let before = ["m.csv", "m.toml", "T.csv", "log.csv"].map(kept);
    for line in [
        "simulate m.csv --rest 1s -o m.csv",
        "simulate m.toml --rest 1s --temperature T.csv -o T.csv",
        "simulate m.toml --rest 1s --temperature T.csv -o new.csv --truth d/../T.csv",
        "simulate m.toml --inputs log.csv -o new.csv --truth log.csv",
        "correct m.toml log.csv -o d/../log.csv",
        "convert log.csv -o ./log.csv",
        "characterize log.html --report log.html",
        "export m.toml --to kalibr -o m.toml",
    ] {
        let words: Vec<&str> = line.split(' ').chain(["--force"]).collect();
        let text = refused(at, &words, 2);
        assert!(text.contains("is an input of this run"), "{line}: {text}");
    }
    assert!(before == ["m.csv", "m.toml", "T.csv", "log.csv"].map(kept));
    assert!(!at.join("new.csv").exists());
    said(at, &["convert", "log.csv", "-o", "again.csv"]);
    said(at, &["convert", "log.csv", "-o", "again.csv", "--force"]);
}
