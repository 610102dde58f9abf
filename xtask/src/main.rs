//! Project tasks: `cargo xtask test` runs everything that a change must pass.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a command for developers"
)]

mod elf;
mod embedded;
mod fidelity;
mod pages;
mod python;
mod steps;
mod tidy;

use std::process::ExitCode;

use steps::Steps;

const USAGE: &str = "\
cargo xtask TASK

  test      everything a change must pass; installs what the tests need
  tidy      the rules on files alone
  pages     pages and plots, measured in a headless browser
  fidelity  the joint estimate against known truth: [--axes N] [--seed S] [--set basic,wide,weak,corners]
  emitted   the emitted C, float and double, against the library: 20 models, a million readings each
  embedded  core and noise without std; the Cortex-M4's object without a panic path
  fuzz      mutated logs for every reader: [--inputs N, a million] [--reader NAME] [--seed S]
  python    the cross-checks against independent Python implementations
";

fn main() -> ExitCode {
    let task = std::env::args().nth(1).unwrap_or_default();
    let mut steps = Steps::default();
    match task.as_str() {
        "test" => test(&mut steps),
        "tidy" => steps.run("tidy", tidy::run),
        "fidelity" => steps.run("fidelity", || {
            fidelity::run(&std::env::args().skip(2).collect::<Vec<_>>())
        }),
        "fuzz" => {
            let more: Vec<String> = std::env::args().skip(2).collect();
            fuzz(&mut steps, "1000000", &more);
        }
        "emitted" => emitted(&mut steps),
        "embedded" => steps.run("without std", embedded::run),
        "pages" => steps.run("pages in a browser", pages::run),
        "python" => steps.run("python cross-checks", python::run),
        _ => {
            eprint!("{USAGE}");
            return ExitCode::from(2);
        }
    }
    steps.finish()
}

/// The whole gate, cheap steps first.
fn test(steps: &mut Steps) {
    steps.run("tidy", tidy::run);
    steps.cargo("formatting", &["fmt", "--all", "--check"]);
    steps.cargo(
        "lints",
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--quiet",
            "--",
            "-D",
            "warnings",
        ],
    );
    steps.run("licences, bans and sources of dependencies", deny);
    steps.cargo(
        "tests",
        &[
            "test",
            "--workspace",
            "--lib",
            "--bins",
            "--tests",
            "--quiet",
        ],
    );
    steps.cargo(
        "documentation tests",
        &["test", "--workspace", "--doc", "--quiet"],
    );
    steps.cargo_with(
        "documentation",
        &["doc", "--workspace", "--no-deps", "--quiet"],
        &[("RUSTDOCFLAGS", "-D warnings")],
    );
    emitted(steps);
    steps.cargo("release build", &["build", "--release", "--quiet"]);
    fuzz(steps, "3000", &[]);
    steps.run("without std", embedded::run);
    steps.run("pages in a browser", pages::run);
    steps.run("python cross-checks", python::run);
}

/// Mutated logs for every reader: no panic, no hang, bounded memory. FUZZ.md shows a long run.
fn fuzz(steps: &mut Steps, inputs: &str, more: &[String]) {
    let program = ["run", "--release", "--quiet", "-p", "sagnac-fuzz", "--"];
    let mut args: Vec<&str> = program.to_vec();
    args.extend(["--inputs", inputs]);
    args.extend(more.iter().map(String::as_str));
    steps.cargo("mutated logs", &args);
}

/// Compiles the C of 20 models with gcc and feeds each a million random readings.
fn emitted(steps: &mut Steps) {
    steps.cargo_with(
        "emitted C, a million readings a model",
        &[
            "test",
            "--release",
            "--quiet",
            "-p",
            "sagnac-model",
            "--test",
            "emitted_source",
            "emitted_c",
        ],
        &[("SAGNAC_EMIT_READINGS", "1000000")],
    );
}

fn deny() -> Result<(), String> {
    if !steps::exists("cargo-deny") {
        steps::command("cargo", &["install", "cargo-deny", "--locked", "--quiet"])?;
    }
    steps::command(
        "cargo",
        &[
            "deny",
            "--log-level",
            "error",
            "check",
            "bans",
            "licenses",
            "sources",
        ],
    )
}
