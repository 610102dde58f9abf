//! `sagnac audit`: is somebody's noise file right?

use std::path::PathBuf;

use sagnac::Error;
use sagnac::audit::{AuditRequest, audit};
use sagnac::model::units::Dimension;

use crate::context::Context;
use crate::outputs::{Output, publish_all};
use crate::{inputs, models};

/// Is somebody's noise file right?
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac audit imu.yaml --model catalog:ADIS16448")]
pub(crate) struct Args {
    /// A noise file of Kalibr, OpenVINS, VINS, ORB-SLAM3, Kimera, basalt, …
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Its format [default: known by its keys]
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
    /// Sampling rate, where the file does not say it
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// A model to compare with: a file, or catalog:NAME
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Writes the file again with the reference's numbers
    #[arg(short, long, value_name = "CORRECTED")]
    output: Option<PathBuf>,
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
    if args.output.is_some() && args.model.is_none() {
        return Err(
            Error::usage("a corrected file needs something to correct by")
                .at("-o")
                .advise("add --model imu.toml"),
        );
    }
    let output = args
        .output
        .as_deref()
        .map(|path| Output::claim(path, "audit -o", args.force))
        .transpose()?;
    let reference = args.model.as_deref().map(models::load).transpose()?;
    let bytes = inputs::bytes(&args.file)?;
    let request = AuditRequest {
        from,
        rate_hz,
        reference: reference.as_ref(),
    };
    let outcome = audit(&bytes, &args.file.display().to_string(), &request)?;
    let mut names = Vec::new();
    if let Some(mut output) = output {
        let Some(corrected) = &outcome.audit.corrected else {
            return Err(Error::data("a binary file is not written again")
                .at(args.file.display().to_string())
                .advise("write it with sagnac export"));
        };
        output.put(corrected.as_bytes())?;
        names = publish_all(vec![output])?;
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&names)
}
