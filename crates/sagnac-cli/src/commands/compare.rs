//! `sagnac compare LOG… --with MODEL`: is this unit as its sheet says?

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::characterize::{Request, characterize};
use sagnac::compare::{compare_logs, compare_model};

use crate::commands::characterize::read_all;
use crate::context::Context;
use crate::inputs::LogOptions;
use crate::models;

/// Is this unit as its sheet says? Each noise term's ratio to a reference, with interval and verdict
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac compare (LOG… | MEASURED.toml) --with MODEL",
    after_help = "Example\n  sagnac compare static.csv --with catalog:ADIS16470"
)]
pub(crate) struct Args {
    /// Logs at rest, or the model that characterize wrote
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// The sheet: a model file, or catalog:NAME
    #[arg(long, value_name = "MODEL")]
    with: String,
    /// All logs are of one sensor: common terms, run-to-run bias
    #[arg(long)]
    one_sensor: bool,
    #[command(flatten)]
    log: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let reference = models::load(&args.with)?;
    let outcome = match args.logs.as_slice() {
        [one] if is_model(one) => {
            compare_model(&models::load(&one.display().to_string())?, &reference)?
        }
        logs => {
            let request = Request {
                one_sensor: args.one_sensor,
                ..Request::default()
            };
            compare_logs(
                &characterize(&read_all(logs, &args.log, context)?, &request)?,
                &reference,
            )?
        }
    };
    context.show(|| outcome.document(), || outcome.to_json())
}

fn is_model(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
        || path.to_str().is_some_and(|p| p.starts_with("catalog:"))
}
