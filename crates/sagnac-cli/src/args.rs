//! The command line that all commands share, and what is said when it is wrong.

use std::process::ExitCode;

use clap::{Args, Parser, ValueEnum, error::ErrorKind};

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
        // Nothing is left to tell if even this cannot be printed.
        let _ = error.print();
        return ExitCode::from(if asked { 0 } else { 2 });
    }
    let error = negative_value(error).unwrap_or_else(|| usage_error(error));
    crate::context::fail(&error, None)
}

/// Options whose values are counts, rates or lengths of time.
const NEVER_NEGATIVE: [&str; 10] = [
    "--seed",
    "--runs",
    "--threads",
    "--port",
    "--rate",
    "--resample",
    "--rest",
    "--duration",
    "--dynamic",
    "--taus",
];

/// A negative value that was taken for an option: `--start '-1 s'`, `--seed -1`.
fn negative_value(error: &clap::Error) -> Option<sagnac::Error> {
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let words: Vec<String> = std::env::args().collect();
    let (option, value) = words.windows(2).find_map(|pair| {
        let is_negative = pair[1]
            .strip_prefix('-')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'));
        (is_negative && pair[0].starts_with("--") && pair[0].len() > 2)
            .then(|| (pair[0].clone(), pair[1].clone()))
    })?;
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
            what.push_str(&line.replace(
                "invalid digit found in string",
                "a whole number from 0 on is wanted",
            ));
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
