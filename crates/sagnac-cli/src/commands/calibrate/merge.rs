//! `sagnac calibrate merge`: several calibrations as one model.

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::calibrate::{MergeRequest, merge};

use crate::context::Context;
use crate::models;
use crate::outputs::{Output, publish_all};

/// Several calibrations, and a characterization, as one model with its covariance
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate merge faces.toml ratetable.toml noise.toml -o imu.toml"
)]
pub(super) struct Args {
    /// Models that calibrate and characterize wrote
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<String>,
    /// Contradictions beyond 3 sigma are an error
    #[arg(long)]
    strict: bool,
    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let file = args
        .output
        .as_deref()
        .map(|path| Output::claim_model(path, "-o", args.force, ""))
        .transpose()?;
    let request = MergeRequest {
        models: args
            .models
            .iter()
            .map(|name| models::load(name))
            .collect::<Result<_, _>>()?,
        name: args
            .output
            .as_deref()
            .and_then(Path::file_stem)
            .map(|stem| stem.to_string_lossy().into_owned()),
        strict: args.strict,
    };
    let outcome = merge(&request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = file {
        file.put(outcome.model.to_toml().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}
