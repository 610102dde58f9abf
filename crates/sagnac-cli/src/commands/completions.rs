//! `sagnac completions SHELL`: a completion script on standard output.

use clap::CommandFactory as _;
use clap_complete::Shell;
use sagnac::Error;

use crate::args::Cli;
use crate::context::{Context, write_stdout};

/// Completions for your shell, on standard output
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac completions bash > ~/.local/share/bash-completion/completions/sagnac"
)]
pub(crate) struct Args {
    /// bash, elvish, fish, powershell or zsh
    #[arg(value_name = "SHELL", hide_possible_values = true)]
    shell: Shell,
}

pub(crate) fn run(args: &Args, _context: &Context) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "sagnac", &mut script);
    write_stdout(&String::from_utf8_lossy(&script))
}
