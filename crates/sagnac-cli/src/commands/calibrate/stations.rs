//! `sagnac calibrate stations`: one regression for every test with known inputs.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::calibrate::{PageFacts, StationsRequest, stations, stations_from_log};
use sagnac::model::units::Dimension;

use super::common::{Files, Place, Texts, hash_of, source};
use crate::context::Context;
use crate::inputs::{self, LogOptions};
use crate::outputs::publish_all;
use crate::quantities::{optional, quantity};

/// One regression for every test with known inputs: faces, tumbles, rate tables, chambers
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate stations tumble24.csv --latitude 46.52deg --height 405m -o imu.toml"
)]
pub(super) struct Args {
    /// CSV with a row a station: outputs, references, standard errors; with --schedule a log
    #[arg(value_name = "TABLE|LOG")]
    table: PathBuf,
    /// References of a log's dwells: time spans, or the dwells in order
    #[arg(long, value_name = "S.csv")]
    schedule: Option<PathBuf>,
    /// default, all, a list of groups of terms, or changes: +quadratic,-misalignment
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    terms: Option<String>,
    /// Powers of temperature of the bias
    #[arg(long, value_name = "0-5", default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..=5))]
    temperature_order: u8,
    /// Powers of temperature of the scale factor
    #[arg(long, value_name = "0-5", default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..=5))]
    scale_temperature_order: u8,
    /// Where temperature terms are zero [default: 25 degC]
    #[arg(long, value_name = "TEMPERATURE", allow_hyphen_values = true)]
    reference_temperature: Option<String>,
    /// Standard error of each station's levelling [default: 0.5 deg for `up` rows, else 0]
    #[arg(long, value_name = "ANGLE")]
    tilt: Option<String>,
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    texts: Texts,
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    log: LogOptions,
}

pub(super) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let (model_file, page_file) = args.files.claim()?;
    if args.schedule.is_none() && args.log.is_any() {
        return Err(Error::usage(
            "options for reading a log need --schedule: a table of stations has none",
        )
        .at("--columns, --rate, --topic, --start, --end, --axes")
        .advise("add --schedule S.csv with the references of the log's dwells"));
    }
    let rows = args.schedule.as_deref().unwrap_or(&args.table);
    let table = inputs::text(rows)?;
    let tilt = optional("--tilt", args.tilt.as_deref(), Dimension::ANGLE)?;
    if tilt.is_some_and(|t| t < 0.0) {
        return Err(Error::usage("--tilt must not be negative")
            .at("--tilt")
            .advise("write for instance --tilt 0.5deg"));
    }
    let request = StationsRequest {
        source: None,
        name: args.files.model_name(&args.table),
        table,
        label: rows.display().to_string(),
        terms: args.terms.clone(),
        temperature_order: Some(args.temperature_order),
        scale_temperature_order: Some(args.scale_temperature_order),
        reference_temperature_c: args
            .reference_temperature
            .as_deref()
            .map(|text| quantity("--reference-temperature", text, Dimension::TEMPERATURE))
            .transpose()?,
        latitude_rad: args.place.latitude_rad()?,
        height_m: args.place.height_m()?,
        gravity_m_s2: args.place.gravity_m_s2()?,
        tilt_rad: tilt,
        texts: args.texts.to_texts(),
    };
    let mut outcome = if args.schedule.is_some() {
        let mut reader = inputs::metered(&args.table, &args.log, context)?;
        stations_from_log(&request, &mut reader).map_err(|error| {
            if error.place.is_some() {
                error
            } else {
                error.at(args.table.display().to_string())
            }
        })?
    } else {
        stations(&request)?
    };
    let mut outputs = Vec::new();
    if model_file.is_some() || page_file.is_some() {
        let hash = |path| hash_of(path).map(|hash| hash.unwrap_or_else(|| "unknown".to_owned()));
        let mut read = vec![(args.table.as_path(), hash(&args.table)?)];
        if let Some(schedule) = &args.schedule {
            read.push((schedule, hash(schedule)?));
        }
        outcome.request.source = Some(source(read[0].0, &read[0].1));
        let facts = PageFacts {
            command: super::super::characterize::command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            inputs: read
                .iter()
                .map(|(path, hash)| (path.display().to_string(), hash.clone()))
                .collect(),
        };
        if let Some(mut file) = model_file {
            file.put(outcome.to_model()?.to_toml().as_bytes())?;
            outputs.push(file);
        }
        if let Some(mut file) = page_file {
            file.put(outcome.to_page(&facts).html().as_bytes())?;
            outputs.push(file);
        }
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}
