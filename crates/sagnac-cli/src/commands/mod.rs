//! One file per command; each is thin: build the request, call the façade, print the outcome.

mod catalog;
mod completions;
mod response;

use clap::{CommandFactory as _, Subcommand};
use sagnac::Error;

use crate::args::Cli;
use crate::context::Context;

/// The commands, each with its own arguments.
#[derive(Subcommand)]
pub(crate) enum Command {
    Catalog(catalog::Args),
    Completions(completions::Args),
    Response(response::Args),
}

/// Runs one command.
pub(crate) fn run(command: Command, context: &Context) -> Result<(), Error> {
    match command {
        Command::Catalog(args) => catalog::run(&args, context),
        Command::Completions(args) => completions::run(&args, context),
        Command::Response(args) => response::run(&args, context),
    }
}

/// Whether `word` names a command.
pub(crate) fn is_command(word: &str) -> bool {
    Cli::command()
        .get_subcommands()
        .any(|command| command.get_name() == word)
}
