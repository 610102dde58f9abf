//! `sagnac calibrate`: deterministic errors from known inputs.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use sagnac::Error;
use sagnac::calibrate::{PageFacts, StationsRequest, stations};
use sagnac::model::units::Dimension;
use sha2::{Digest as _, Sha256};

use crate::context::Context;
use crate::inputs;
use crate::outputs::{Output, publish_all};
use crate::quantities::{optional, quantity};

/// Bias, scale factor, misalignment and every other deterministic error, with covariance
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac calibrate stations faces.csv -o imu.toml")]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    Stations(Box<Stations>),
}

/// One regression for every test with known inputs: faces, tumbles, rate tables, chambers
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac calibrate stations tumble24.csv --latitude 46.52deg --height 405m -o imu.toml"
)]
struct Stations {
    /// CSV with a row a station: outputs, references, standard errors
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// Options of calibrations.
#[derive(clap::Args)]
struct Common {
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
    /// Latitude of the laboratory, for gravity and the Earth's rate
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    latitude: Option<String>,
    /// Height of the laboratory, for gravity
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    height: Option<String>,
    /// Local gravity; wins over latitude and height [default: 9.80665 m/s^2]
    #[arg(long, value_name = "ACCELERATION")]
    gravity: Option<String>,
    /// Standard error of each station's levelling [default: 0.5 deg for `up` rows, else 0]
    #[arg(long, value_name = "ANGLE")]
    tilt: Option<String>,
    /// Item, for the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    item: String,
    /// Customer, for the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    customer: String,
    /// Number of the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    certificate: String,
    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Write the certificate
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    match &args.action {
        Action::Stations(args) => run_stations(args, context),
    }
}

fn run_stations(args: &Stations, context: &Context) -> Result<(), Error> {
    let common = &args.common;
    let claim = |path: &Option<PathBuf>, option: &str| {
        path.as_deref()
            .map(|p| Output::claim(p, option, common.force))
            .transpose()
    };
    let model_file = claim(&common.output, "-o")?;
    let page_file = claim(&common.report, "--report")?;
    let table = inputs::text(&args.table)?;
    let hash = sha256(table.as_bytes());
    let label = args.table.display().to_string();
    let tilt = optional("--tilt", common.tilt.as_deref(), Dimension::ANGLE)?;
    if tilt.is_some_and(|t| t < 0.0) {
        return Err(Error::usage("--tilt must not be negative")
            .at("--tilt")
            .advise("write for instance --tilt 0.5deg"));
    }
    let request = StationsRequest {
        source: Some(format!("{} sha256:{hash}", file_name(&args.table))),
        name: common
            .output
            .as_deref()
            .or(Some(&args.table))
            .and_then(Path::file_stem)
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
        table,
        label: label.clone(),
        terms: common.terms.clone(),
        temperature_order: Some(common.temperature_order),
        scale_temperature_order: Some(common.scale_temperature_order),
        reference_temperature_c: common
            .reference_temperature
            .as_deref()
            .map(|text| quantity("--reference-temperature", text, Dimension::TEMPERATURE))
            .transpose()?,
        latitude_rad: optional("--latitude", common.latitude.as_deref(), Dimension::ANGLE)?,
        height_m: optional("--height", common.height.as_deref(), Dimension::LENGTH)?,
        gravity_m_s2: optional(
            "--gravity",
            common.gravity.as_deref(),
            Dimension::ACCELERATION,
        )?,
        tilt_rad: tilt,
        item: common.item.clone(),
        customer: common.customer.clone(),
        certificate: common.certificate.clone(),
    };
    let outcome = stations(&request)?;
    let mut outputs = Vec::new();
    if let Some(mut file) = model_file {
        file.put(outcome.to_model()?.to_toml().as_bytes())?;
        outputs.push(file);
    }
    if let Some(mut file) = page_file {
        let facts = PageFacts {
            command: super::characterize::command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            inputs: vec![(label, hash)],
        };
        file.put(outcome.to_page(&facts).html().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

fn sha256(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    let mut out = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        let _ = write!(out, "{byte:02x}");
    }
    out
}
