//! `sagnac export`: a model for another tool.

use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;

use sagnac::Error;
use sagnac::export::{ExportRequest, export};
use sagnac::model::export::Format;
use sagnac::model::units::Dimension;

use crate::context::{Context, write_stdout};
use crate::models;
use crate::outputs::{Output, publish_all};

/// A model for another tool, in its own keys, units and conventions
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac export imu.toml --to kalibr -o imu.yaml\n\nNames: kalibr kalibr-result openvins vins orbslam3 gtsam kimera basalt ros-imu\n       gazebo matlab px4 ardupilot imu-utils gnss-ins-sim navego pyins kf-gins"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    /// The tool
    #[arg(long, value_name = "NAME")]
    to: String,
    /// Where to write it [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Sampling rate, where the model does not say it or the tool runs at another
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// Factor on N, K and in-run bias sigmas; every comment says it
    #[arg(long, value_name = "X", default_value = "1")]
    inflate: String,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let format: Format = args
        .to
        .parse()
        .map_err(|error| Error::from(error).at("--to"))?;
    let inflate = sagnac::model::units::parse_plain(&args.inflate)
        .ok()
        .filter(|inflate| *inflate > 0.0)
        .ok_or_else(|| {
            Error::usage("the inflation must be a number above zero")
                .at(format!("--inflate {}", args.inflate))
                .advise("write for instance --inflate 5")
        })?;
    let request = ExportRequest { format, inflate };
    let output = args
        .output
        .as_deref()
        .map(|path| Output::claim(path, "export -o", args.force))
        .transpose()?;
    let mut model = models::load(&args.model)?;
    if let Some(rate) = &args.rate {
        let rate_hz = crate::quantities::positive("--rate", rate, Dimension::FREQUENCY)?;
        model.set_sample_rate_hz(rate_hz).map_err(Error::from)?;
    }
    let outcome = export(&model, &request)?;
    for remark in &outcome.remarks {
        context.note(remark);
    }
    if !outcome.limits.is_empty() {
        context.note(&format!(
            "only an upper limit is known and counts as absent: {}",
            outcome.limits.join(", ")
        ));
    }
    let Some(mut output) = output else {
        if context.is_json() {
            return context.print(String::new, || outcome.to_json());
        }
        if format.is_text() {
            return write_stdout(&outcome.to_text());
        }
        if std::io::stdout().is_terminal() {
            return Err(
                Error::usage(format!("{} is a binary format", format.name()))
                    .at("export")
                    .advise("name a file: -o imu.mat"),
            );
        }
        return match std::io::stdout().lock().write_all(&outcome.bytes) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(Error::data(format!(
                    "standard output cannot be written: {}",
                    crate::context::plain(&error)
                )))
            }
            _ => Ok(()),
        };
    };
    output.put(&outcome.bytes)?;
    let names = publish_all(vec![output])?;
    if context.is_json() {
        context.print(String::new, || outcome.to_json())?;
    }
    context.wrote(&names)
}
