//! `sagnac explain MODEL`: what each term adds for one input.

#![allow(
    clippy::case_sensitive_file_extension_comparisons,
    reason = "reads closest to its equation"
)]

use std::path::PathBuf;

use sagnac::Error;
use sagnac::explain::{explain, level_at_rest, parse_at};

use crate::commands::characterize::command_line;
use crate::context::Context;
use crate::models;
use crate::outputs::{Output, publish_all};

/// What each term adds to each axis for one input
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac explain imu.toml --at 'f=0 0 -9.81 m/s^2, w=10 0 0 deg/s, T=40 degC'"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    /// The input, 'f=…, w=…, wdot=…, T=…' [default: level at rest, at T0]
    #[arg(long, value_name = "INPUT", allow_hyphen_values = true)]
    at: Option<String>,
    /// A picture, .svg or .png
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// A page with the same panels
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Replace outputs that exist
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let picture = match &args.output {
        Some(path) => {
            let name = path.display().to_string().to_ascii_lowercase();
            if !(name.ends_with(".svg") || name.ends_with(".png")) {
                return Err(
                    Error::usage(format!("no picture is written as {}", path.display()))
                        .at("-o")
                        .advise("name it .svg or .png"),
                );
            }
            Some((
                Output::claim(path, "-o", args.force)?,
                name.ends_with(".png"),
            ))
        }
        None => None,
    };
    let page = match &args.report {
        Some(path) => Some(Output::claim_page(path, args.force)?),
        None => None,
    };
    let model = models::load(&args.model)?;
    let t0 = model.reference_temperature_c();
    let at = match &args.at {
        Some(text) => parse_at(text, t0)?,
        None => level_at_rest(t0),
    };
    let outcome = explain(&model, &at)?;
    let mut outputs = Vec::new();
    if let Some((mut output, is_png)) = picture {
        let svg = outcome.svg();
        if is_png {
            output.put(&svg.to_png().map_err(Error::data)?)?;
        } else {
            output.put(svg.standalone().as_bytes())?;
        }
        outputs.push(output);
    }
    if let Some(mut output) = page {
        let page = outcome.to_page(&command_line(), env!("CARGO_PKG_VERSION"));
        output.put(page.html().as_bytes())?;
        outputs.push(output);
    }
    let written = publish_all(outputs)?;
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&written)
}
