//! The `sagnac` command: arguments in, one façade task, results out.

mod args;
mod commands;
mod context;
mod inputs;
mod models;
mod motion;
mod outputs;
mod progress;
mod quantities;

use std::process::ExitCode;

use args::Cli;
use clap::Parser as _;
use context::Context;

fn main() -> ExitCode {
    outputs::remove_unfinished_when_interrupted();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return args::explain(&error),
    };
    let context = match Context::new(&cli.common) {
        Ok(context) => context,
        Err(error) => return context::fail(&error, None),
    };
    match commands::run(cli.command, &context) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => context::fail(&error, Some(&context)),
    }
}
