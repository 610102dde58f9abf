//! `sagnac calibrate plan`: a table of stations to fill in.

use std::path::PathBuf;

use sagnac::Error;
use sagnac::calibrate::{PLAN_NAMES, PlanRequest, Tested, plan};
use sagnac::model::units::Dimension;

use super::common::Place;
use crate::context::Context;
use crate::models;
use crate::outputs::{Output, publish_all};
use crate::quantities::{optional, positive, quantity};

/// A table of stations to fill in, with the precision that each parameter will reach
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate plan tumble24 --precision 'accel.bias=0.1 mg' --model imu.toml -o stations.csv"
)]
pub(super) struct Args {
    /// six-position, tumble24, rate-table, centrifuge, chamber, or the model of a sensor
    #[arg(value_name = "NAME|MODEL")]
    name: String,
    /// Wanted standard errors: 'accel.bias=1 mg, gyro.scale_factor=50 ppm'
    #[arg(long, value_name = "LIST")]
    precision: Option<String>,
    /// A model whose noise counts: a file, or catalog:NAME
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Length of each dwell [default: 60s]
    #[arg(long, value_name = "TIME")]
    dwell: Option<String>,
    /// Standard error of an accelerometer mean [default: the model's, else 1e-3 m/s^2]
    #[arg(long, value_name = "ACCELERATION")]
    accel_se: Option<String>,
    /// Standard error of a gyro mean [default: the model's, else 1e-4 rad/s]
    #[arg(long, value_name = "RATE")]
    gyro_se: Option<String>,
    /// Largest rate of the rate table [default: 0.9 of the model's range, else 200 deg/s]
    #[arg(long, value_name = "RATE")]
    rate_max: Option<String>,
    /// Arm of the centrifuge [default: 1 m]
    #[arg(long, value_name = "LENGTH")]
    radius: Option<String>,
    /// Temperatures of the chamber [default: '-20, 0, 20, 40, 60 degC']
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    temperatures: Option<String>,
    /// default, all, a list of groups of terms, or changes: +quadratic,-misalignment
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    terms: Option<String>,
    /// Where temperature terms are zero [default: 25 degC]
    #[arg(long, value_name = "TEMPERATURE", allow_hyphen_values = true)]
    reference_temperature: Option<String>,
    /// Standard error of each station's levelling [default: 0 deg]
    #[arg(long, value_name = "ANGLE")]
    tilt: Option<String>,
    #[command(flatten)]
    place: Place,
    /// Write the table
    #[arg(short, long, value_name = "STATIONS.csv")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let file = args
        .output
        .as_deref()
        .map(|path| Output::claim(path, "-o", args.force))
        .transpose()?;
    let above = |option: &str, text: &Option<String>, dimension: Dimension| {
        text.as_deref()
            .map(|text| positive(option, text, dimension))
            .transpose()
    };
    let tilt = optional("--tilt", args.tilt.as_deref(), Dimension::ANGLE)?;
    if tilt.is_some_and(|t| t < 0.0) {
        return Err(Error::usage("--tilt must not be negative")
            .at("--tilt")
            .advise("write for instance --tilt 0.5deg"));
    }
    let tested = if PLAN_NAMES.contains(&args.name.as_str()) {
        Tested::Name(args.name.clone())
    } else if !args.name.contains(['.', '/', ':']) && !std::path::Path::new(&args.name).exists() {
        // Neither a file nor a catalogue entry: the façade tells the names.
        Tested::Name(args.name.clone())
    } else {
        Tested::Model(Box::new(models::load(&args.name)?))
    };
    let request = PlanRequest {
        tested,
        noise: args.model.as_deref().map(models::load).transpose()?,
        dwell_s: above("--dwell", &args.dwell, Dimension::TIME)?,
        accel_se_m_s2: above("--accel-se", &args.accel_se, Dimension::ACCELERATION)?,
        gyro_se_rad_s: above("--gyro-se", &args.gyro_se, Dimension::ANGULAR_RATE)?,
        precision: args.precision.clone(),
        rate_max_rad_s: above("--rate-max", &args.rate_max, Dimension::ANGULAR_RATE)?,
        radius_m: above("--radius", &args.radius, Dimension::LENGTH)?,
        temperatures_c: args.temperatures.as_deref().map(temperatures).transpose()?,
        terms: args.terms.clone(),
        reference_temperature_c: optional(
            "--reference-temperature",
            args.reference_temperature.as_deref(),
            Dimension::TEMPERATURE,
        )?,
        latitude_rad: args.place.latitude_rad()?,
        height_m: args.place.height_m()?,
        gravity_m_s2: args.place.gravity_m_s2()?,
        tilt_rad: tilt,
    };
    let outcome = plan(&request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = file {
        file.put(outcome.to_csv().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}

/// `-20, 0, 20 degC` or `-20 degC, 0 degC`: a number without a unit takes that of the last.
fn temperatures(text: &str) -> Result<Vec<f64>, Error> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let unit = parts
        .last()
        .and_then(|last| {
            last.find(|c: char| c.is_alphabetic() || c == '°')
                .map(|i| &last[i..])
        })
        .unwrap_or("");
    parts
        .iter()
        .map(|part| {
            let whole = if part.parse::<f64>().is_ok() {
                format!("{part} {unit}")
            } else {
                (*part).to_owned()
            };
            quantity("--temperatures", &whole, Dimension::TEMPERATURE)
        })
        .collect()
}
