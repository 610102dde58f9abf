//! `sagnac import`: another tool's file as a model.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::import::{ImportRequest, import};
use sagnac::model::units::Dimension;

use crate::context::Context;
use crate::inputs;
use crate::outputs::{Output, publish_all};

/// Another tool's file as a model
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac import imu.yaml -o imu.toml")]
pub(crate) struct Args {
    /// A file of one of the tools that `sagnac export` writes for
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Its format [default: known by its keys]
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
    /// Sampling rate, where the file does not say it
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// The model file
    #[arg(short, long, value_name = "MODEL.toml", required = true)]
    output: PathBuf,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let from = args
        .from
        .as_deref()
        .map(str::parse)
        .transpose()
        .map_err(|error| Error::from(error).at("--from"))?;
    let rate_hz = args
        .rate
        .as_deref()
        .map(|text| crate::quantities::positive("--rate", text, Dimension::FREQUENCY))
        .transpose()?;
    let mut output = Output::claim_model(&args.output, "import -o", args.force, "")?;
    let bytes = inputs::bytes(&args.file)?;
    let outcome = import(
        &bytes,
        &args.file.display().to_string(),
        &ImportRequest { from, rate_hz },
    )?;
    output.put(outcome.model.to_toml().as_bytes())?;
    let names = publish_all(vec![output])?;
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&names)
}
