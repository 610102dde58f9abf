//! Cross-checks against Python implementations that share no code with the product: every `tools/check_*.py`.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::steps::{check, root};

/// Runs all checks in an environment of their own under `target/`.
pub(crate) fn run() -> Result<(), String> {
    let python = environment()?;
    let mut checks: Vec<PathBuf> = fs::read_dir(root().join("tools"))
        .map_err(|error| format!("tools: {error}"))?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            let is_check = path
                .file_stem()
                .is_some_and(|stem| stem.to_string_lossy().starts_with("check_"));
            is_check && path.extension().is_some_and(|extension| extension == "py")
        })
        .collect();
    checks.sort();
    if checks.is_empty() {
        return Err("no tools/check_*.py found".to_owned());
    }
    let program = root().join("target/release/sagnac");
    let mut failed = Vec::new();
    for path in checks {
        println!(
            "   {}",
            path.file_name()
                .map(|n| n.to_string_lossy().into_owned())
                .unwrap_or_default()
        );
        // BLAS threads would compete with the program's own on small machines.
        if let Err(why) = check(
            Command::new(&python)
                .arg(&path)
                .arg(&program)
                .env("SAGNAC", &program)
                .env("OMP_NUM_THREADS", "1"),
        ) {
            failed.push(why);
        }
    }
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("; "))
    }
}

/// The interpreter of a virtual environment with `tools/requirements.txt`, made where absent or out of date.
pub(crate) fn environment() -> Result<PathBuf, String> {
    let folder = root().join("target/python");
    let python = folder.join("bin/python");
    let wanted = fs::read_to_string(root().join("tools/requirements.txt"))
        .map_err(|e| format!("tools/requirements.txt: {e}"))?;
    let stamp = folder.join("requirements.txt");
    if python.is_file() && fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    check(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    check(Command::new(&python).args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-r",
        "tools/requirements.txt",
    ]))?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}
