//! The command line that all commands share, and what is said when it is wrong.

use std::io::Write as _;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, Parser, ValueEnum};

use crate::commands::Command;

/// The screen of `sagnac --help`, grouped by what a user wants to do.
const SCREEN: &str = "\
sagnac - inertial-sensor errors: simulate, characterize, calibrate, compensate,
grade, drift

Usage: sagnac COMMAND [OPTIONS]

Start here
  demo          the whole loop on a catalogue IMU, with a report
  info          what is in a log
Learn a sensor's errors
  characterize  noise terms of each axis, with intervals
  allan         Allan deviation and its relatives
  calibrate     stations | multi-position | thermal | merge | plan
  response      accuracy, precision, resolution, sensitivity, linearity
  compare       is this unit as its sheet says?
  plan          how long must the log be?
Use them
  simulate      a log with every error of a model
  correct       take the errors out of a log; C or Rust source
  explain       what each term adds for one input
  drift         position error against time, and what causes it
  strapdown     position, velocity and attitude from a log
  grade         which grade, and what holds it back
  budget        which sensors meet a drift requirement
Exchange
  catalog       real sensors with sources: list | show | compare | search
  convert       logs between formats
  export        a model for another tool
  import        another tool's file as a model
  audit         is somebody's noise file right?
  completions   for your shell

Every command: --format text|json  --quiet  --threads N
               --color auto|always|never
sagnac COMMAND --help tells more. Numbers carry units: \"0.3 deg/sqrt(h)\".
";

/// How an option's help looks: usage line, then the text, then the options.
const HELP: &str = "{about-with-newline}\n{usage-heading} {usage}\n{after-help}\n{all-args}\n";

#[derive(Parser)]
#[command(
    name = "sagnac",
    version,
    override_help = SCREEN,
    disable_help_subcommand = true,
    subcommand_required = true,
    help_template = HELP,
    propagate_version = false,
    term_width = 80
)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Options of every command.
#[derive(Args, Clone)]
#[command(next_help_heading = "Every command")]
pub(crate) struct Common {
    /// How results are printed
    #[arg(long, global = true, value_enum, default_value_t = Format::Text, value_name = "text|json", hide_possible_values = true)]
    pub(crate) format: Format,
    /// Results and errors only
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
    /// Worker threads [default: all cores]; results do not depend on it
    #[arg(long, global = true, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Colors in a terminal
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "auto|always|never", hide_possible_values = true)]
    pub(crate) color: Color,
}

/// What standard output carries.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Tables and sentences of at most 80 columns.
    Text,
    /// One JSON document, SI units.
    Json,
}

/// When to color.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Color {
    /// On a terminal, unless `NO_COLOR` is set.
    Auto,
    /// Also into a pipe.
    Always,
    /// Not at all.
    Never,
}

/// Prints help, version or a usage error, and says which exit code that is.
pub(crate) fn explain(error: &clap::Error) -> ExitCode {
    let asked = matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    );
    if asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let printed = error.print().and_then(|()| std::io::stdout().flush());
        return match crate::context::printed(printed) {
            Err(error) if asked => crate::context::fail(&error, None),
            _ => ExitCode::from(if asked { 0 } else { 2 }),
        };
    }
    let error = whole_number(error)
        .or_else(|| negative_value(error))
        .unwrap_or_else(|| usage_error(error));
    crate::context::fail(&error, None)
}

/// Options whose values are rates or lengths of time.
const NEVER_NEGATIVE: [&str; 6] = [
    "--rate",
    "--resample",
    "--rest",
    "--duration",
    "--dynamic",
    "--taus",
];

/// Options that take a whole number: from where on, and an example.
const WHOLE_NUMBERS: [(&str, u64, u32); 4] = [
    ("--seed", 0, 1),
    ("--runs", 1, 100),
    ("--threads", 1, 4),
    ("--port", 1, 7700),
];

/// A value that is no whole number, or one that the option cannot take: `--seed=-1`, `--runs 1.5`.
fn whole_number(error: &clap::Error) -> Option<sagnac::Error> {
    let (option, value) = match error.kind() {
        ErrorKind::ValueValidation => {
            let text = |kind| match error.get(kind) {
                Some(ContextValue::String(text)) => Some(text.clone()),
                _ => None,
            };
            let option = text(ContextKind::InvalidArg)?;
            let option = option.split_whitespace().next()?.to_owned();
            (option, text(ContextKind::InvalidValue)?)
        }
        ErrorKind::UnknownArgument => negative_after_option(error)?,
        _ => return None,
    };
    let (option, least, example) = WHOLE_NUMBERS
        .into_iter()
        .find(|(name, ..)| *name == option)?;
    let is_whole = !value.is_empty() && value.bytes().all(|byte| byte.is_ascii_digit());
    let to = match option {
        _ if !is_whole => "on".to_owned(),
        "--seed" => format!("to {}", u64::MAX),
        "--port" => format!("to {}", u16::MAX),
        "--threads" => "to 1024".to_owned(),
        _ if std::env::args()
            .nth(1)
            .is_some_and(|command| command == "simulate") =>
        {
            "to 1000000".to_owned()
        }
        _ => format!("to {}", u32::MAX),
    };
    let shown: String = value.chars().take(40).collect();
    Some(
        sagnac::Error::usage(format!(
            "{option} takes a whole number from {least} {to}, not `{shown}`"
        ))
        .at(format!("{option} {shown}"))
        .advise(format!("write for instance {option} {example}")),
    )
}

/// A negative value that was taken for an option: `--start '-1 s'`, `--seed -1`.
fn negative_value(error: &clap::Error) -> Option<sagnac::Error> {
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let (option, value) = negative_after_option(error)?;
    let quoted = if value.contains(' ') {
        format!("'{value}'")
    } else {
        value.clone()
    };
    if NEVER_NEGATIVE.contains(&option.as_str()) {
        let error = sagnac::Error::usage(format!("{option} must not be negative"));
        return Some(
            error
                .at(format!("{option} {quoted}"))
                .advise("leave the minus out"),
        );
    }
    Some(
        sagnac::Error::usage(format!("`{value}` after {option} is read as an option"))
            .at(format!("{option} {quoted}"))
            .advise(format!(
                "write {option}={quoted} with =, or leave the minus out"
            )),
    )
}

/// The first option of the command line that a negative value follows.
fn negative_after_option(error: &clap::Error) -> Option<(String, String)> {
    // An option that the command does not have is another matter.
    if let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg)
        && unknown.starts_with("--")
    {
        return None;
    }
    let words: Vec<String> = std::env::args().collect();
    words.windows(2).find_map(|pair| {
        let is_negative = pair[1]
            .strip_prefix('-')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'));
        (is_negative && pair[0].starts_with("--") && pair[0].len() > 2)
            .then(|| (pair[0].clone(), pair[1].clone()))
    })
}

/// The three lines of a usage error from clap's report of several paragraphs.
fn usage_error(error: &clap::Error) -> sagnac::Error {
    let report = error.to_string();
    let mut what = String::new();
    let (mut usage, mut tips) = (None, Vec::new());
    let mut in_head = true;
    for line in report.lines() {
        let line = line.trim();
        if let Some(tip) = line.strip_prefix("tip:") {
            tips.push(tip.trim().to_owned());
        } else if let Some(line) = line.strip_prefix("Usage:") {
            usage = Some(line.trim().to_owned());
        } else if line.is_empty() || line.starts_with("For more information") {
            in_head = false;
        } else if in_head {
            if !what.is_empty() {
                what.push(' ');
            }
            let line = line.trim_start_matches("error: ");
            what.push_str(line);
        } else if let Some(values) = line.strip_prefix("[possible values:") {
            tips.push(format!(
                "write one of: {}",
                values.trim_end_matches(']').trim()
            ));
        }
    }
    let mut out = sagnac::Error::usage(what);
    if let Some(usage) = usage {
        out = out.at(format!("usage: {usage}"));
    }
    let command = std::env::args().nth(1).filter(|word| {
        word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-')
    });
    let known = command.filter(|word| crate::commands::is_command(word));
    out.advise(match (tips.is_empty(), known) {
        (false, _) => tips.join("; "),
        (true, Some(command)) => format!("sagnac {command} --help tells the options"),
        (true, None) => "sagnac --help lists the commands".to_owned(),
    })
}
