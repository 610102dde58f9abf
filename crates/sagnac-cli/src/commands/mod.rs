//! One file per command; each is thin: build the request, call the façade, print the outcome.

mod allan;
mod audit;
pub(crate) mod budget;
mod calibrate;
mod catalog;
mod characterize;
mod compare;
mod completions;
mod convert;
mod correct;
mod demo;
pub(crate) mod drift;
mod explain;
mod export;
pub(crate) mod grade;
mod import;
mod info;
mod man;
mod plan;
mod response;
mod simulate;
pub(crate) mod strapdown;

use clap::{CommandFactory as _, Subcommand};
use sagnac::Error;

use crate::args::Cli;
use crate::context::Context;

/// The commands, each with its own arguments.
#[derive(Subcommand)]
#[allow(clippy::large_enum_variant, reason = "made once")]
pub(crate) enum Command {
    Allan(allan::Args),
    Budget(budget::Args),
    Audit(audit::Args),
    Export(export::Args),
    Import(import::Args),
    Calibrate(calibrate::Args),
    Catalog(catalog::Args),
    Characterize(characterize::Args),
    Compare(compare::Args),
    Completions(completions::Args),
    Convert(convert::Args),
    Demo(demo::Args),
    Drift(drift::Args),
    Grade(grade::Args),
    Info(info::Args),
    #[command(hide = true)]
    Man(man::Args),
    Plan(plan::Args),
    Correct(correct::Args),
    Explain(explain::Args),
    Response(response::Args),
    Simulate(simulate::Args),
    Strapdown(strapdown::Args),
}

/// Runs one command.
pub(crate) fn run(command: Command, context: &Context) -> Result<(), Error> {
    match command {
        Command::Allan(args) => allan::run(&args, context),
        Command::Budget(args) => budget::run(&args, context),
        Command::Audit(args) => audit::run(&args, context),
        Command::Export(args) => export::run(&args, context),
        Command::Import(args) => import::run(&args, context),
        Command::Calibrate(args) => calibrate::run(&args, context),
        Command::Catalog(args) => catalog::run(&args, context),
        Command::Characterize(args) => characterize::run(&args, context),
        Command::Compare(args) => compare::run(&args, context),
        Command::Completions(args) => completions::run(&args, context),
        Command::Demo(args) => demo::run(&args, context),
        Command::Convert(args) => convert::run(&args, context),
        Command::Drift(args) => drift::run(&args, context),
        Command::Grade(args) => grade::run(&args, context),
        Command::Info(args) => info::run(&args, context),
        Command::Man(args) => man::run(&args, context),
        Command::Plan(args) => plan::run(&args, context),
        Command::Simulate(args) => simulate::run(&args, context),
        Command::Correct(args) => correct::run(&args, context),
        Command::Explain(args) => explain::run(&args, context),
        Command::Response(args) => response::run(&args, context),
        Command::Strapdown(args) => strapdown::run(&args, context),
    }
}

/// Whether `word` names a command.
pub(crate) fn is_command(word: &str) -> bool {
    Cli::command()
        .get_subcommands()
        .any(|command| command.get_name() == word)
}
