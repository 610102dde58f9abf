//! One file per command; each is thin: build the request, call the façade, print the outcome.

pub(crate) mod budget;
mod allan;
mod catalog;
mod characterize;
mod compare;
mod completions;
pub(crate) mod drift;
pub(crate) mod grade;
mod plan;
mod convert;
mod info;
mod response;
pub(crate) mod strapdown;

use clap::{CommandFactory as _, Subcommand};
use sagnac::Error;

use crate::args::Cli;
use crate::context::Context;

/// The commands, each with its own arguments.
#[derive(Subcommand)]
#[allow(clippy::large_enum_variant, reason = "made once")]
pub(crate) enum Command {
    Catalog(catalog::Args),
    Allan(allan::Args),
    Completions(completions::Args),
    Strapdown(strapdown::Args),
    Grade(grade::Args),
    Drift(drift::Args),
    Budget(budget::Args),
    Characterize(characterize::Args),
    Compare(compare::Args),
    Completions(completions::Args),
    Plan(plan::Args),
    Convert(convert::Args),
    Info(info::Args),
    Response(response::Args),
}

/// Runs one command.
pub(crate) fn run(command: Command, context: &Context) -> Result<(), Error> {
    match command {
        Command::Catalog(args) => catalog::run(&args, context),
        Command::Budget(args) => budget::run(&args, context),
        Command::Drift(args) => drift::run(&args, context),
        Command::Grade(args) => grade::run(&args, context),
        Command::Strapdown(args) => strapdown::run(&args, context),
        Command::Allan(args) => allan::run(&args, context),
        Command::Characterize(args) => characterize::run(&args, context),
        Command::Compare(args) => compare::run(&args, context),
        Command::Plan(args) => plan::run(&args, context),
        Command::Completions(args) => completions::run(&args, context),
        Command::Convert(args) => convert::run(&args, context),
        Command::Info(args) => info::run(&args, context),
        Command::Response(args) => response::run(&args, context),
    }
}

/// Whether `word` names a command.
pub(crate) fn is_command(word: &str) -> bool {
    Cli::command()
        .get_subcommands()
        .any(|command| command.get_name() == word)
}
