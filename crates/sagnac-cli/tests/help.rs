//! Help fits a terminal: no line of any command's help is longer than 80 columns, and the screen lists what exists.

#![allow(clippy::unwrap_used, reason = "tests")]

use assert_cmd::Command;

fn sagnac(args: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_sagnac"))
        .args(args)
        .output()
        .unwrap()
}

fn help(args: &[&str]) -> String {
    let output = sagnac(args);
    assert!(output.status.success(), "{args:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The commands that the screen of `sagnac --help` lists.
fn listed() -> Vec<String> {
    help(&["--help"])
        .lines()
        .filter_map(|line| line.strip_prefix("  "))
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split_whitespace().next().map(str::to_owned))
        .collect()
}

#[test]
fn every_listed_command_exists_and_its_help_fits() {
    let commands = listed();
    assert!(commands.len() > 15, "{commands:?}");
    for command in &commands {
        let text = help(&[command, "--help"]);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{command}: {line}");
        }
        assert!(text.contains("Usage: sagnac"), "{command} shows no usage");
    }
}

#[test]
fn usage_errors_exit_with_2_and_data_errors_with_1() {
    for (args, code) in [
        (&["characterise", "log.csv"][..], 2),
        (&["info", "log.csv", "--rate", "3 m"], 2),
        (&["info", "no-such-log.csv"], 1),
        (&["completions", "bash", "--threads", "0"], 2),
    ] {
        let output = sagnac(args);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {error}");
        assert!(error.starts_with("error: "), "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn completions_offer_formats_and_units() {
    for shell in ["bash", "zsh", "fish"] {
        let script = help(&["completions", shell]);
        for word in ["kalibr-result", "gnss-ins-sim", "kHz", "arcmin", "degC"] {
            assert!(script.contains(word), "{shell} lacks {word}");
        }
    }
    // Bash completes the number that was typed.
    let script = help(&["completions", "bash"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sagnac.bash");
    let call = "COMP_WORDS=(sagnac info log.csv --rate 200); COMP_CWORD=4; _sagnac sagnac 200 --rate; echo \"${COMPREPLY[*]}\"\n";
    std::fs::write(&path, script + call).unwrap();
    let output = Command::new("bash").arg(&path).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(said.trim(), "200Hz 200kHz");
    // What is refused is refused as before.
    let output = sagnac(&["export", "catalog:ADIS16448", "--to", "kalib"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("there is no format `kalib`"), "{error}");
    // A catalogue entry states no rate.
    let text = help(&[
        "export",
        "catalog:ADIS16448",
        "--to",
        "ros-imu",
        "--rate",
        "200Hz",
    ]);
    assert!(text.contains("angular_velocity_covariance"), "{text}");
}
