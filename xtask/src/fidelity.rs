//! `cargo xtask fidelity`: the joint estimate against known truth, with the independent generator under `tools/`.

use std::process::Command;

/// Builds the example and runs `tools/fidelity.py` with the arguments given (`--axes`, `--seed`, `--set`, `--json`).
///
/// Python with numpy and scipy is `$PYTHON`, else `python3`.
pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let step = |command: &mut Command, what: &str| match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{what} ended with {status}")),
        Err(error) => Err(format!("{what} could not be started: {error}")),
    };
    step(
        Command::new("cargo").args([
            "build",
            "--release",
            "-p",
            "sagnac-analysis",
            "--example",
            "fit_axes",
        ]),
        "cargo build",
    )?;
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    step(
        Command::new(python)
            .args(["tools/fidelity.py", "target/release/examples/fit_axes"])
            .args(arguments),
        "tools/fidelity.py",
    )
}
