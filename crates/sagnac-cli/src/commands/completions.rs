//! `sagnac completions SHELL`: a completion script on standard output.

use clap::builder::PossibleValuesParser;
use clap::{Arg, Command, CommandFactory as _};
use clap_complete::Shell;
use sagnac::Error;
use sagnac::model::export::Format;
use sagnac::model::units::UNITS;

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
    let mut command = with_values(Cli::command(), args.shell);
    clap_complete::generate(args.shell, &mut command, "sagnac", &mut script);
    write_stdout(&String::from_utf8_lossy(&script))
}

/// The command with the values that a shell can offer: formats and units. Parsing has its own, since its errors say more.
fn with_values(command: Command, shell: Shell) -> Command {
    let names: Vec<String> = command
        .get_subcommands()
        .map(|command| command.get_name().to_owned())
        .collect();
    let command = names.into_iter().fold(command, |command, name| {
        command.mut_subcommand(name, |command| with_values(command, shell))
    });
    command.mut_args(|arg| with_units(with_formats(arg), shell))
}

fn with_formats(arg: Arg) -> Arg {
    if matches!(arg.get_id().as_str(), "to" | "from") && value_name(&arg) == "NAME" {
        return arg.value_parser(PossibleValuesParser::new(Format::ALL.map(Format::name)));
    }
    arg
}

fn with_units(arg: Arg, shell: Shell) -> Arg {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let of = match value_name(&arg) {
        "TIME" => "s",
        "ANGLE" => "deg",
        "LENGTH" => "m",
        "TEMPERATURE" => "degC",
        "ACCELERATION" => "g",
        "RATE" if help.contains("gyro") || help.contains("deg/s") => "dps",
        "RATE" => "Hz",
        _ => return arg,
    };
    let symbols = units_like(of);
    if shell == Shell::Bash {
        // Bash expands this within its double quotes: the number typed so far, with each unit. Leaked, since clap keeps
        // static texts and the process ends here.
        let typed = symbols
            .iter()
            .map(|symbol| -> &'static str { format!("${{cur%%[!0-9.e+-]*}}{symbol}").leak() });
        return arg.value_parser(PossibleValuesParser::new(typed));
    }
    arg.help(format!("{help}; units {}", symbols.join(" ")))
}

fn value_name(arg: &Arg) -> &str {
    arg.get_value_names()
        .and_then(<[_]>::first)
        .map_or("", |name| name.as_str())
}

/// The symbols of one dimension that every keyboard has.
fn units_like(symbol: &str) -> Vec<&'static str> {
    let like = UNITS.iter().find(|row| row.symbol == symbol);
    UNITS
        .iter()
        .filter(|row| like.is_some_and(|like| like.exponents() == row.exponents()))
        .map(|row| row.symbol)
        .filter(|symbol| symbol.is_ascii())
        .collect()
}
