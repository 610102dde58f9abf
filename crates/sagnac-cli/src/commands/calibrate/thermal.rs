//! `sagnac calibrate thermal`: bias and scale factor against temperature.

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::calibrate::{PageFacts, ThermalRequest, thermal};
use sagnac::model::units::Dimension;

use super::common::{Files, Place, Texts, hash_of, source};
use crate::commands::characterize::{command_line, read_all};
use crate::context::Context;
use crate::inputs::LogOptions;
use crate::outputs::publish_all;
use crate::quantities::quantity;

/// Bias (and scale factor) against temperature, with hysteresis, from a sensor at rest in a chamber
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate thermal up.csv down.csv --up +z,-z -o imu.toml"
)]
pub(super) struct Args {
    /// Logs of the sensor at rest, with a temperature channel
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// Body axis that points up, one a log: +z,-z
    #[arg(long, value_name = "AXES", allow_hyphen_values = true)]
    up: Option<String>,
    /// Where temperature terms are zero [default: 25 degC]
    #[arg(long, value_name = "TEMPERATURE", allow_hyphen_values = true)]
    reference_temperature: Option<String>,
    /// auto, polynomial or spline
    #[arg(long, value_name = "NAME", default_value = "auto")]
    form: String,
    /// Largest order of the polynomial
    #[arg(long, value_name = "0-8", default_value_t = 5, value_parser = clap::value_parser!(u8).range(0..=8))]
    max_order: u8,
    /// Use the second halves of the soaks alone
    #[arg(long)]
    soak_only: bool,
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    texts: Texts,
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    reading: LogOptions,
}

pub(super) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let (model_file, page_file) = args.files.claim()?;
    let place = args.place.to_place()?;
    let reference_temperature_c = args
        .reference_temperature
        .as_deref()
        .map(|text| quantity("--reference-temperature", text, Dimension::TEMPERATURE))
        .transpose()?;
    let logs = read_all(&args.logs, &args.reading, context)?;
    let mut hashes = Vec::new();
    if model_file.is_some() || page_file.is_some() {
        for path in &args.logs {
            if let Some(hash) = hash_of(path)? {
                hashes.push((path.clone(), hash));
            }
        }
    }
    let request = ThermalRequest {
        source: (!hashes.is_empty()).then(|| {
            let all: Vec<String> = hashes.iter().map(|(p, h)| source(p, h)).collect();
            all.join("; ")
        }),
        name: args
            .files
            .model_name(args.logs.first().map_or(Path::new("log"), |p| p.as_path())),
        up: args.up.clone(),
        reference_temperature_c,
        form: Some(args.form.clone()),
        max_order: Some(usize::from(args.max_order)),
        is_soak_only: args.soak_only,
        place,
        texts: args.texts.to_texts(),
    };
    let outcome = thermal(&logs, &request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = model_file {
        file.put(outcome.to_model()?.to_toml().as_bytes())?;
        outputs.push(file);
    }
    if let Some(mut file) = page_file {
        let facts = PageFacts {
            command: command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            inputs: hashes
                .into_iter()
                .map(|(path, hash)| (path.display().to_string(), hash))
                .collect(),
        };
        file.put(outcome.to_page(&facts).html().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}
