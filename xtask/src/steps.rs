//! Runs the steps of a task one after the other, goes on after a failure, and sums up.

use std::process::{Command, ExitCode};
use std::time::Instant;

/// What has been run so far.
#[derive(Default)]
pub(crate) struct Steps {
    passed: usize,
    failed: Vec<String>,
}

impl Steps {
    /// Runs one step and notes how it ended.
    pub(crate) fn run(&mut self, name: &str, step: impl FnOnce() -> Result<(), String>) {
        println!("== {name}");
        let start = Instant::now();
        match step() {
            Ok(()) => {
                self.passed += 1;
                println!("   ok, {:.0} s", start.elapsed().as_secs_f64());
            }
            Err(why) => {
                println!("   FAILED: {why}");
                self.failed.push(name.to_owned());
            }
        }
    }

    /// A step that is one cargo command.
    pub(crate) fn cargo(&mut self, name: &str, args: &[&str]) {
        self.cargo_with(name, args, &[]);
    }

    /// The same with environment variables.
    pub(crate) fn cargo_with(&mut self, name: &str, args: &[&str], environment: &[(&str, &str)]) {
        self.run(name, || {
            let mut command = Command::new("cargo");
            command.args(args).envs(environment.iter().copied());
            check(&mut command)
        });
    }

    /// Prints the sum and turns it into an exit code.
    pub(crate) fn finish(self) -> ExitCode {
        for name in &self.failed {
            println!("failed: {name}");
        }
        println!("{} passed, {} failed", self.passed, self.failed.len());
        if self.failed.is_empty() {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }
}

/// Runs a program to its end; an exit code other than 0 is an error.
pub(crate) fn command(program: &str, args: &[&str]) -> Result<(), String> {
    check(Command::new(program).args(args))
}

/// Runs a prepared command in the workspace root.
pub(crate) fn check(command: &mut Command) -> Result<(), String> {
    let line = format!("{command:?}");
    let status = command
        .current_dir(root())
        .status()
        .map_err(|error| format!("{line}: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{line}: {status}"))
    }
}

/// The folder of the workspace.
pub(crate) fn root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .map_or_else(Default::default, Into::into)
}

/// Whether a program is on the path.
pub(crate) fn exists(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| {
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    })
}

/// Installs Debian packages that are missing (as root), so that a fresh machine can run the tests.
pub(crate) fn debian(program: &str, packages: &[&str]) -> Result<(), String> {
    if exists(program) {
        return Ok(());
    }
    if !exists("apt-get") {
        return Err(format!("{program} is not installed"));
    }
    let mut update = Command::new("apt-get");
    check(
        update
            .args(["update", "-qq"])
            .stdout(std::process::Stdio::null()),
    )?;
    let mut install = Command::new("apt-get");
    check(
        install
            .args(["install", "-y", "-qq"])
            .args(packages)
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdout(std::process::Stdio::null()),
    )
}
