//! Rules on the files alone: every source file says what it is, none grows too long, no machine's paths.

use std::fs;
use std::path::{Path, PathBuf};

use crate::steps::root;

/// A file above this wants splitting: it is named, not refused.
const COMFORTABLE: usize = 700;

pub(crate) fn run() -> Result<(), String> {
    let mut files = Vec::new();
    for folder in ["crates", "xtask", "tools"] {
        collect(&root().join(folder), &mut files);
    }
    let mut faults = Vec::new();
    for path in &files {
        let Ok(text) = fs::read_to_string(path) else {
            continue;
        };
        let name = path
            .strip_prefix(root())
            .unwrap_or(path)
            .display()
            .to_string();
        let is_rust = path.extension().is_some_and(|e| e == "rs");
        let lines = text.lines().count();
        if is_rust && !text.starts_with("//!") {
            faults.push(format!("{name} does not open with //!"));
        }
        if is_rust && lines > COMFORTABLE {
            println!("   note: {name} has {lines} lines, it wants splitting");
        }
        let unfinished = [
            concat!("todo", "!("),
            concat!("unimple", "mented!("),
            concat!("#[ig", "nore"),
        ];
        if is_rust && unfinished.iter().any(|word| text.contains(word)) {
            faults.push(format!("{name} holds an unfinished or ignored part"));
        }
        let paths = [
            concat!("/ro", "ot/"),
            concat!("/wo", "rk/"),
            concat!("/ho", "me/"),
        ];
        if paths.iter().any(|word| text.contains(word)) {
            faults.push(format!("{name} holds a machine's path"));
        }
    }
    if files.is_empty() {
        faults.push("no source files found".to_owned());
    }
    if faults.is_empty() {
        Ok(())
    } else {
        Err(faults.join("\n   "))
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            let skip = ["target", "node_modules", "__pycache__"];
            if !path
                .file_name()
                .is_some_and(|name| skip.iter().any(|s| name == *s))
            {
                collect(&path, files);
            }
        } else if path
            .extension()
            .is_some_and(|e| ["rs", "py", "mjs", "toml"].iter().any(|x| e == *x))
        {
            files.push(path);
        }
    }
}
