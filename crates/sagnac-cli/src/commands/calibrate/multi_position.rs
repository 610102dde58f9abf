//! `sagnac calibrate multi-position`: accelerometer and gyro from a log turned by hand.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::calibrate::{MultiPositionRequest, PageFacts, multi_position};
use sagnac::model::units::Dimension;

use super::common::{Files, Place, Texts, hash_of, source};
use crate::commands::characterize::{command_line, read_all};
use crate::context::Context;
use crate::inputs::LogOptions;
use crate::outputs::publish_all;
use crate::quantities::quantity;

/// Accelerometer and gyro from a log turned by hand between still poses, without equipment
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate multi-position turned.csv --gravity '9.81 m/s^2' -o imu.toml"
)]
pub(super) struct Args {
    /// The log: nine rests or more in different directions, turned by hand between them
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// bias, `scale_factor`, misalignment, `g_sensitivity`, or changes: -g_sensitivity
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    terms: Option<String>,
    /// accelerometer, or fixture: keep the frame of a stations model, given as --start MODEL
    #[arg(long, value_name = "NAME", default_value = "accelerometer", value_parser = ["accelerometer", "fixture"])]
    frame: String,
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
    let (mounting, reading) = mounting(args)?;
    let (fixture, unmeasured) = mounting.unzip();
    let logs = read_all(std::slice::from_ref(&args.log), &reading, context)?;
    let Some(log) = logs.first() else {
        return Err(Error::data("there is no log"));
    };
    let hash = match (&model_file, &page_file) {
        (None, None) => None,
        _ => hash_of(&args.log)?,
    };
    let request = MultiPositionRequest {
        label: log.name.clone(),
        source: hash.as_deref().map(|hash| source(&args.log, hash)),
        name: args.files.model_name(&args.log),
        terms: args.terms.clone(),
        place,
        fixture,
        unmeasured: unmeasured.unwrap_or_default(),
        texts: args.texts.to_texts(),
    };
    let outcome = multi_position(&log.log, &request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = model_file {
        file.put(outcome.to_model()?.to_toml().as_bytes())?;
        outputs.push(file);
    }
    if let Some(mut file) = page_file {
        let facts = PageFacts {
            command: command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            inputs: hash.into_iter().map(|h| (log.name.clone(), h)).collect(),
        };
        file.put(outcome.to_page(&facts).html().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}

/// Rows of a rotation.
type Rotation = [[f64; 3]; 3];

/// I + M, and the misalignments that the model has no value for.
type Mounting = (Rotation, Vec<String>);

/// I + M of the accelerometer of the model that `--start` names with `--frame fixture`, and how the log is read.
///
/// `--start` is a time for every command that reads a log; a value that is no time names the model here.
fn mounting(args: &Args) -> Result<(Option<Mounting>, LogOptions), Error> {
    let mut reading = args.reading.clone();
    if args.frame != "fixture" {
        return Ok((None, reading));
    }
    let name = reading
        .start
        .take_if(|text| quantity("--start", text, Dimension::TIME).is_err());
    let Some(name) = name else {
        return Err(
            Error::usage("--frame fixture needs the stations model of that fixture")
                .at("--frame")
                .advise("add --start MODEL.toml"),
        );
    };
    let model = crate::inputs::model(&name)?;
    let mut response = [[0.0; 3]; 3];
    let mut unmeasured = Vec::new();
    let value = |path: &str| {
        model
            .get(path)
            .map_or(0.0, |entry| entry.value.unwrap_or(0.0))
    };
    for (k, row) in response.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().enumerate() {
            let (a, b) = (["x", "y", "z"][k], ["x", "y", "z"][j]);
            *v = if k == j {
                1.0 + value(&format!("accel.scale_factor.{a}"))
            } else {
                let path = format!("accel.misalignment.{a}{b}");
                if model.get(&path).is_none() {
                    unmeasured.push(path.clone());
                }
                value(&path) + value(&format!("accel.cross_axis.{a}{b}"))
            };
        }
    }
    Ok((Some((response, unmeasured)), reading))
}
