//! `sagnac man DIR`: a manual page for every command, for packagers.

use std::path::PathBuf;

use clap::{Command, CommandFactory as _};
use clap_mangen::Man;
use sagnac::Error;

use crate::args::Cli;
use crate::context::Context;
use crate::outputs::{Output, cannot, publish_all};

/// Manual pages of every command, written to a folder
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac man target/man && man target/man/sagnac-characterize.1")]
pub(crate) struct Args {
    /// Where to write them; made if it is not there
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Overwrite pages that exist
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    std::fs::create_dir_all(&args.folder).map_err(|error| cannot(&args.folder, &error))?;
    let mut root = Cli::command();
    root.build();
    let mut outputs = Vec::new();
    for (name, page) in pages(&root, "")? {
        let path = args.folder.join(format!("{name}.1"));
        let mut output = Output::claim(&path, "DIR", args.force)?;
        output.put(&page)?;
        outputs.push(output);
    }
    context.wrote(&publish_all(outputs)?)
}

/// Name and page of a command and of all below it.
fn pages(command: &Command, above: &str) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let name = if above.is_empty() {
        command.get_name().to_owned()
    } else {
        format!("{above}-{}", command.get_name())
    };
    let mut page = Vec::new();
    Man::new(command.clone().display_name(&name))
        .render(&mut page)
        .map_err(|error| Error::data(format!("the page of {name} cannot be made: {error}")))?;
    let mut out = vec![(name.clone(), page)];
    for below in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        if below.get_name() != "help" {
            out.extend(pages(below, &name)?);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn every_command_has_a_page_that_names_it_and_its_options() {
        let mut root = Cli::command();
        root.build();
        let pages = pages(&root, "").unwrap();
        let page = |name: &str| {
            let found = pages.iter().find(|p| p.0 == name).unwrap();
            String::from_utf8(found.1.clone()).unwrap()
        };
        for command in root.get_subcommands().filter(|c| !c.is_hide_set()) {
            let name = format!("sagnac-{}", command.get_name());
            assert!(page(&name).contains(".SH NAME"), "{name}");
        }
        assert!(page("sagnac-convert").contains("resample"));
        assert!(page("sagnac-calibrate-stations").contains("schedule"));
    }
}
