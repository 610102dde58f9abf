//! `sagnac info LOG`: what is in a log, and is it sound?

use std::path::PathBuf;

use sagnac::Error;
use sagnac::info::{InfoRequest, info};

use crate::context::Context;
use crate::inputs::{self, LogOptions};

/// What is in a log: format, rate, channels, and whether it is sound
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac info counts.csv --rate 100Hz --columns 'gyro=0,1,2:0.05 deg/s, accel=3,4,5:3.33 mg'"
)]
pub(crate) struct Args {
    /// A log in any known format; - reads CSV from standard input
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The sensor's model: its ranges tell saturation
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    #[command(flatten)]
    options: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let model = args
        .model
        .as_deref()
        .map(|path| {
            let label = path.display().to_string();
            sagnac::model::Model::parse(&inputs::text(path)?, &label).map_err(Error::from)
        })
        .transpose()?;
    let (mut reader, _meter) = args.options.open_any(&args.log)?;
    let request = InfoRequest {
        model,
        section_rows: None,
    };
    let outcome = info(&mut *reader, &request).map_err(|e| e.at(args.log.display().to_string()))?;
    context.show(|| outcome.document(), || outcome.to_json())
}
