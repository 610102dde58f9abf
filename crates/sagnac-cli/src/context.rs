//! What a command knows of its surroundings: the terminal, the output format, how to print.

use std::io::{self, IsTerminal, Write as _};
use std::process::ExitCode;

use sagnac::report::text::{Document, Style, width};
use sagnac::{Error, Kind};

use crate::args::{Color, Common, Format};
use crate::progress::{Progress, Redrawn};

/// The surroundings of one run.
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent facts about the terminal"
)]
pub(crate) struct Context {
    format: Format,
    quiet: bool,
    color_out: bool,
    color_err: bool,
    /// Whether `±`, `√` and `━` can be shown.
    pub(crate) utf8: bool,
}

impl Context {
    /// Reads the environment once and starts the worker threads that were asked for.
    pub(crate) fn new(common: &Common) -> Result<Self, Error> {
        if let Some(threads) = common.threads {
            if threads == 0 || threads > 1024 {
                return Err(Error::usage(format!(
                    "the number of threads must be 1 to 1024, not {threads}"
                ))
                .at("--threads")
                .advise("leave --threads out to use all cores"));
            }
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()
                .map_err(|error| {
                    Error::data(format!("the worker threads could not be started: {error}"))
                })?;
        }
        let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty())
            || std::env::var_os("TERM").is_some_and(|v| v == "dumb");
        let color = |terminal: bool| match common.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => terminal && !plain,
        };
        Ok(Self {
            format: common.format,
            quiet: common.quiet,
            color_out: color(io::stdout().is_terminal()),
            color_err: color(io::stderr().is_terminal()),
            utf8: speaks_utf8(),
        })
    }

    /// Whether standard output is one JSON document.
    pub(crate) fn is_json(&self) -> bool {
        self.format == Format::Json
    }

    /// Prints a result as text or JSON; a reader that has gone away is no error.
    pub(crate) fn print(
        &self,
        text: impl FnOnce() -> String,
        json: impl FnOnce() -> serde_json::Value,
    ) -> Result<(), Error> {
        let mut out = if self.is_json() {
            serde_json::to_string(&json()).map_err(|error| {
                Error::data(format!("the result cannot be written as JSON: {error}"))
            })?
        } else {
            text()
        };
        if !out.is_empty() && !out.ends_with('\n') {
            out.push('\n');
        }
        write_stdout(&out)
    }

    /// Prints a result as a document, in the style of the terminal, or as JSON.
    pub(crate) fn show(
        &self,
        document: impl FnOnce() -> Document,
        json: impl FnOnce() -> serde_json::Value,
    ) -> Result<(), Error> {
        self.print(|| document().render(self.style()), json)
    }

    /// How text on standard output may look.
    pub(crate) fn style(&self) -> Style {
        Style {
            unicode: self.utf8,
            color: self.color_out,
        }
    }

    /// A text that is redrawn in place on standard error; none where that is no terminal, or nothing is to be said.
    pub(crate) fn redrawn(&self) -> Option<Redrawn> {
        let dumb = std::env::var_os("TERM").is_some_and(|v| v == "dumb");
        (!self.quiet && !dumb && io::stderr().is_terminal()).then(|| {
            let style = Style {
                unicode: self.utf8,
                color: self.color_err,
            };
            Redrawn::new(style)
        })
    }

    /// Says on the last lines of a text result which files were written.
    pub(crate) fn wrote(&self, names: &[String]) -> Result<(), Error> {
        if self.is_json() || self.quiet {
            return Ok(());
        }
        let mut lines = String::new();
        for name in names {
            lines.push_str("wrote ");
            lines.push_str(name);
            lines.push('\n');
        }
        write_stdout(&lines)
    }

    /// A remark about the work, on standard error.
    pub(crate) fn note(&self, text: &str) {
        self.remark("note", "\x1b[1m", text);
    }

    /// A warning about the work, on standard error.
    pub(crate) fn warn(&self, text: &str) {
        self.remark("warning", "\x1b[33m", text);
    }

    fn remark(&self, word: &str, color: &str, text: &str) {
        if self.quiet {
            return;
        }
        let head = if self.color_err {
            format!("{color}{word}:\x1b[0m")
        } else {
            format!("{word}:")
        };
        // Standard error is the last resort: if it is gone there is nobody to tell.
        let text = folded(text, word.len() + 2, word.len() + 2);
        let _ = writeln!(io::stderr(), "{head} {text}");
    }

    /// A bar for work that may take over a second; nothing is shown before, nor off a terminal.
    pub(crate) fn progress(&self, label: &str, total: Option<u64>) -> Progress {
        Progress::new(
            label,
            total,
            !self.quiet && io::stderr().is_terminal(),
            self.utf8,
        )
    }
}

fn speaks_utf8() -> bool {
    // The first of these that is set and not empty decides, as in setlocale(3); none: assume a modern terminal.
    ["LC_ALL", "LC_CTYPE", "LANG"]
        .iter()
        .find_map(|name| std::env::var(name).ok().filter(|value| !value.is_empty()))
        .is_none_or(|value| {
            let value = value.to_ascii_lowercase();
            value.contains("utf-8") || value.contains("utf8")
        })
}

/// Writes to standard output; a closed pipe ends the program quietly, a full disk is said.
pub(crate) fn write_stdout(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What became of text for standard output.
pub(crate) fn printed(result: io::Result<()>) -> Result<(), Error> {
    match result {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Error::data(format!(
            "standard output cannot be written: {}",
            plain(&error)
        ))),
    }
}

/// The system's words for an I/O error, without its number.
pub(crate) fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        first.to_lowercase().chain(chars).collect()
    })
}

/// Prints an error in its three lines and gives its exit code.
/// Text in lines of at most 80 columns, the first of which begins at column `first` and the others after `indent` blanks;
/// a word longer than a line stays whole, so that a path can be copied.
fn folded(text: &str, first: usize, indent: usize) -> String {
    let mut out = String::new();
    let mut column = first;
    for word in text.split(' ') {
        let wide = width(word);
        if column > indent.max(first) && column + 1 + wide > 80 {
            out.push('\n');
            out.push_str(&" ".repeat(indent));
            column = indent;
        } else if !out.is_empty() {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += wide;
    }
    out
}

pub(crate) fn fail(error: &Error, context: Option<&Context>) -> ExitCode {
    let color = context.map_or_else(
        || io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        |context| context.color_err,
    );
    if let (Some(found), true) = (&error.found, context.is_some_and(Context::is_json)) {
        // The error below is what counts where this cannot be written either.
        let _ = write_stdout(&format!("{found}\n"));
    }
    let head = if color {
        "\x1b[1;31merror:\x1b[0m"
    } else {
        "error:"
    };
    let mut lines = vec![folded(&error.what, 7, 7)];
    for line in [&error.place, &error.advice].into_iter().flatten() {
        lines.push(format!("  {}", folded(line, 2, 4)));
    }
    let _ = writeln!(io::stderr(), "{head} {}", lines.join("\n"));
    ExitCode::from(match error.kind {
        Kind::Data => 1,
        Kind::Usage => 2,
    })
}
