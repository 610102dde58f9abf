//! `sagnac response TABLE`: the lecture's words S1–S3 as numbers.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::response::{ResponseRequest, response};

use crate::context::Context;
use crate::inputs;

/// Accuracy, precision, resolution, sensitivity, linearity of one axis from a bench record
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac response ratetable.csv --full-scale '450 deg/s'")]
pub(crate) struct Args {
    /// CSV with columns reference and output; direction, repeat, output_se if known
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// The largest input of the sensor [default: the largest in the table]
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    full_scale: Option<String>,
    /// Output over input by the data sheet, for instance '16.4 1/(deg/s)'
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    nominal_sensitivity: Option<String>,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let request = ResponseRequest {
        table: inputs::text(&args.table)?,
        label: args.table.display().to_string(),
        full_scale: args.full_scale.clone(),
        nominal_sensitivity: args.nominal_sensitivity.clone(),
    };
    let outcome = response(&request)?;
    context.show(|| outcome.document(), || outcome.to_json())
}
