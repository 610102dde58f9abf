//! `sagnac plan MODEL`: how long must the log be?

use std::path::PathBuf;

use sagnac::Error;
use sagnac::model::units::Dimension;
use sagnac::plan::{Wanted, plan};

use crate::commands::drift::put_svg;
use crate::context::Context;
use crate::models;
use crate::outputs::{Output, publish_all};
use crate::quantities::positive;

/// How long must a log be for a wanted precision, or what does a length reach?
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac plan MODEL (--duration TIME | --precision LIST) [OPTIONS]",
    after_help = "Example\n  sagnac plan imu.toml --precision 'angle_random_walk=2%, bias_instability=10%'"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    #[command(flatten)]
    wanted: WantedArgs,
    /// Sampling rate [default: the model's, else 100 Hz]
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// Write a picture, precision against length: F.svg or F.png
    #[arg(short, long, value_name = "F.svg")]
    output: Option<PathBuf>,
    /// Overwrite an output that exists
    #[arg(long)]
    force: bool,
}

/// Exactly one of these is asked.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct WantedArgs {
    /// Length of the log, for instance 4h
    #[arg(long, value_name = "TIME")]
    duration: Option<String>,
    /// Wanted 1-sigma precision of terms, as parts of the value
    #[arg(long, value_name = "LIST")]
    precision: Option<String>,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let wanted = match (&args.wanted.duration, &args.wanted.precision) {
        (Some(text), _) => Wanted::Duration(positive("--duration", text, Dimension::TIME)?),
        (None, list) => Wanted::Precision(list.clone().unwrap_or_default()),
    };
    let rate = args
        .rate
        .as_deref()
        .map(|text| positive("--rate", text, Dimension::FREQUENCY))
        .transpose()?;
    let picture = args
        .output
        .as_deref()
        .map(|p| Output::claim_picture(p, args.force))
        .transpose()?;
    let outcome = plan(&models::load(&args.model)?, &wanted, rate)?;
    let mut outputs = Vec::new();
    if let Some(mut out) = picture {
        put_svg(&mut out, &outcome.to_svg())?;
        outputs.push(out);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}
