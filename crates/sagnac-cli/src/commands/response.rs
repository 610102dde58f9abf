//! `sagnac response TABLE`: the lecture's words S1–S3 as numbers.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::calibrate::PageFacts;
use sagnac::response::{ResponseRequest, response};

use crate::commands::drift::put_svg;
use crate::context::Context;
use crate::inputs;
use crate::outputs::{Output, publish_all};

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
    /// Write a page with residuals, hysteresis and the target
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// A picture of the plots, .svg or .png
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let picture = args
        .output
        .as_deref()
        .map(|path| Output::claim_picture(path, args.force))
        .transpose()?;
    let page = args
        .report
        .as_deref()
        .map(|path| Output::claim_page(path, args.force))
        .transpose()?;
    let request = ResponseRequest {
        table: inputs::text(&args.table)?,
        label: args.table.display().to_string(),
        full_scale: args.full_scale.clone(),
        nominal_sensitivity: args.nominal_sensitivity.clone(),
    };
    let outcome = response(&request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = picture {
        put_svg(&mut file, &outcome.svg())?;
        outputs.push(file);
    }
    if let Some(mut file) = page {
        let facts = PageFacts {
            command: super::characterize::command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            inputs: vec![(
                request.label.clone(),
                super::calibrate::sha256(request.table.as_bytes()),
            )],
        };
        file.put(outcome.to_page(&facts).html().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}
