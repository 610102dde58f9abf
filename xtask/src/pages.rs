//! Opens pages and plots in a headless browser and measures them; shows that a spoilt page fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps;

/// Folder of the checks.
const TOOLS: &str = "tools/browser";

/// Draws every page and plot with made-up numbers, checks them, and checks that pages spoilt on purpose fail.
///
/// The pages of the static recordings, where the data folder is there, are written to `target/pages` and checked as well.
pub(crate) fn run() -> Result<(), String> {
    if !steps::exists("node") || !steps::exists("npm") {
        steps::debian("npm", &["nodejs", "npm"])?;
    }
    if std::env::var_os("SAGNAC_CHROMIUM").is_none() && !Path::new("/usr/bin/chromium").exists() {
        steps::debian("chromium", &["chromium"])?;
    }
    steps::command("npm", &["ci", "--silent", "--prefix", TOOLS])?;
    let gallery = "target/gallery";
    steps::command(
        "cargo",
        &[
            "run",
            "--quiet",
            "--package",
            "sagnac-report",
            "--example",
            "gallery",
            "--",
            gallery,
        ],
    )?;
    recordings()?;
    let gallery = steps::root().join(gallery);
    let mut files = drawings(&gallery)?;
    files.extend(drawings(&steps::root().join("target/pages")).unwrap_or_default());
    check(&[], &files)?;
    check(&["--expect-failure"], &spoilt(&gallery)?)
}

/// Characterizes every static recording from the command line; its numbers are compared on the way.
fn recordings() -> Result<(), String> {
    steps::command("cargo", &["build", "--release", "--quiet"])?;
    let python = crate::python::environment()?;
    steps::check(
        Command::new(python)
            .args(["tools/check_recordings.py", "target/release/sagnac"])
            .args(["--pages", "target/pages"]),
    )
}

fn check(flags: &[&str], files: &[PathBuf]) -> Result<(), String> {
    let script = format!("{TOOLS}/check.mjs");
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    let mut args = vec![script.as_str()];
    args.extend(flags);
    args.extend(names.iter().map(String::as_str));
    steps::command("node", &args)
}

/// Pages and drawings of a folder, by name.
fn drawings(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "html" || e == "svg"))
        .collect();
    files.sort();
    Ok(files)
}

/// The page of `characterize` with one fault each: what the checks must find.
fn spoilt(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let page = fs::read_to_string(folder.join("characterize.html")).map_err(|e| e.to_string())?;
    let into = folder.join("spoilt");
    fs::create_dir_all(&into).map_err(|e| e.to_string())?;
    let faults: [(&str, &str, &str); 7] = [
        // Two labels on one place.
        (
            "overlap",
            "</title><desc>",
            "</title><text x=\"60\" y=\"60\">one</text><text x=\"62\" y=\"61\">two</text><desc>",
        ),
        // A label beyond the edge.
        (
            "cut",
            "</title><desc>",
            "</title><text x=\"340\" y=\"60\">far too long a label</text><desc>",
        ),
        ("contrast", "--muted: #59616b", "--muted: #b9bfc6"),
        ("small", "font-size=\"11.5\"", "font-size=\"8\""),
        (
            "sideways",
            "<main>",
            "<main><div style=\"width:1500px\">wide</div>",
        ),
        (
            "request",
            "<main>",
            "<main><img src=\"https://example.invalid/a.png\" alt=\"\">",
        ),
        (
            "units",
            ":root:has(.pick-si:checked) .u-si{display:inline}",
            "",
        ),
    ];
    let mut files = Vec::new();
    for (name, from, to) in faults {
        if !page.contains(from) {
            return Err(format!("the fault `{name}` finds no place in the page"));
        }
        let path = into.join(format!("{name}.html"));
        fs::write(&path, page.replace(from, to)).map_err(|e| e.to_string())?;
        files.push(path);
    }
    Ok(files)
}
