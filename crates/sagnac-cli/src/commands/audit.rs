//! `sagnac audit`: is somebody's noise file right?

use std::path::PathBuf;

use sagnac::Error;
use sagnac::audit::{AuditRequest, audit};
use sagnac::characterize::{Request, characterize};

use crate::commands::characterize::read_all;
use crate::context::Context;
use crate::inputs::LogOptions;
use crate::outputs::{Output, publish_all};
use crate::{inputs, models};

/// Is somebody's noise file right?
#[derive(clap::Args)]
#[command(
    after_help = "Examples\n  sagnac audit imu.yaml --model catalog:ADIS16448\n  sagnac audit imu.yaml --log static.bag --topic /imu -o corrected.yaml"
)]
pub(crate) struct Args {
    /// A noise file of Kalibr, OpenVINS, VINS, ORB-SLAM3, Kimera, basalt, …
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Its format [default: known by its keys]
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
    /// A log at rest to compare with: what it shows is the reference
    #[arg(long, value_name = "LOG", conflicts_with = "model")]
    log: Option<PathBuf>,
    /// A model to compare with: a file, or catalog:NAME
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Writes the file again with the reference's numbers
    #[arg(short, long, value_name = "CORRECTED")]
    output: Option<PathBuf>,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    options: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let from = args
        .from
        .as_deref()
        .map(str::parse)
        .transpose()
        .map_err(|error| Error::from(error).at("--from"))?;
    // --rate is also that of a file which does not say its own.
    let options = args.options.read_options()?;
    if args.log.is_none() && args.options.is_beyond_rate() {
        return Err(Error::usage("options on reading need a log")
            .at("audit")
            .advise("add --log static.csv"));
    }
    if args.output.is_some() && args.model.is_none() && args.log.is_none() {
        return Err(
            Error::usage("a corrected file needs something to correct by")
                .at("-o")
                .advise("add --log static.csv or --model imu.toml"),
        );
    }
    let output = args
        .output
        .as_deref()
        .map(|path| Output::claim(path, "audit -o", args.force))
        .transpose()?;
    let reference = match (&args.log, &args.model) {
        (Some(log), _) => {
            let logs = read_all(std::slice::from_ref(log), &args.options, context)?;
            Some(characterize(&logs, &Request::default())?.to_model()?)
        }
        (None, Some(name)) => Some(models::load(name)?),
        (None, None) => None,
    };
    let bytes = inputs::bytes(&args.file)?;
    let request = AuditRequest {
        from,
        rate_hz: options.rate_hz,
        reference: reference.as_ref(),
    };
    let mut outcome = audit(&bytes, &args.file.display().to_string(), &request)?;
    outcome.is_written = output.is_some();
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
