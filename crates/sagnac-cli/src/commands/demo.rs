//! `sagnac demo [DIR]`: the whole loop on a sensor of the catalogue, with a report.

use std::fmt::Write as _;
use std::path::PathBuf;

use sagnac::Error;
use sagnac::characterize::PageFacts;
use sagnac::demo::demo;
use sagnac::log::{Block, WriteFormat, create};
use sagnac::model::Catalogue;
use sha2::{Digest as _, Sha256};

use crate::commands::characterize::command_line;
use crate::commands::convert::SharedOutput;
use crate::context::Context;
use crate::outputs::{NewFolder, Output, publish_all};

/// A sensor whose sheet states white noise and bias instability of all axes.
const SENSOR: &str = "ADIS16470";

/// The whole loop on a catalogue IMU: simulate, characterize, compare with the truth, grade, drift, budget
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac demo")]
pub(crate) struct Args {
    /// Folder for the log, the model and the report; its own files are replaced
    #[arg(value_name = "DIR", default_value = "sagnac-demo")]
    folder: PathBuf,
    /// Same seed, same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let folder = NewFolder::make(&args.folder)?;
    let claim = |name: &str| Output::claim(&args.folder.join(name), "DIR", true);
    let (log_file, mut model_file, mut report) = (
        SharedOutput::new(claim("log.npy")?),
        claim("model.toml")?,
        claim("report.html")?,
    );
    let catalogue = Catalogue::embedded();
    let outcome = demo(&catalogue, SENSOR, "log.npy", args.seed)?;

    let mut writer = create(
        WriteFormat::Npy,
        Box::new(log_file.clone()),
        &outcome.log.layout,
    )?;
    writer.write_block(&Block {
        stamps: outcome.log.stamps.clone(),
        columns: outcome.log.columns.clone(),
        rows: outcome.log.rows,
        ..Block::default()
    })?;
    writer.finish()?;
    model_file.put(outcome.characterized.to_model()?.to_toml().as_bytes())?;
    let mut hash = Sha256::new();
    for column in &outcome.log.columns {
        for value in column {
            hash.update(value.to_le_bytes());
        }
    }
    let digest = hash
        .finalize()
        .iter()
        .fold(String::new(), |mut text, byte| {
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        });
    let facts = PageFacts {
        command: command_line(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        inputs: vec![("log.npy, its columns".to_owned(), digest)],
    };
    report.put(outcome.page(&catalogue, &facts)?.html().as_bytes())?;
    let files = publish_all(vec![log_file.into_output()?, model_file, report])?;
    folder.keep();
    context.show(|| outcome.document(), || outcome.to_json(&files))?;
    let named: Vec<String> = files
        .iter()
        .map(|f| {
            if f.ends_with("report.html") {
                format!("{f}    open this first")
            } else {
                f.clone()
            }
        })
        .collect();
    context.wrote(&named)
}
