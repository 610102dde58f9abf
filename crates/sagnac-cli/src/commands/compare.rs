//! `sagnac compare LOG… --with MODEL`: is this unit as its sheet says?

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::characterize::{Request, characterize};
use sagnac::compare::{compare_logs, compare_model};
use sagnac::report::html::{Input, Opening, Rich};

use crate::commands::characterize::{command_line, hashes_of, read_all};
use crate::context::Context;
use crate::inputs::LogOptions;
use crate::models;
use crate::outputs::{Output, publish_all};

/// Is this unit as its sheet says? Each noise term's ratio to a reference, with interval and verdict
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac compare (LOG… | MEASURED.toml) --with MODEL [--report F.html]",
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
    /// Write a page with the Allan curves of both
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Overwrite an output that exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    log: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let reference = models::load(&args.with)?;
    let report = args
        .report
        .as_deref()
        .map(|p| Output::claim_page(p, args.force))
        .transpose()?;
    let (outcome, page) = match args.logs.as_slice() {
        [one] if is_model(one) => {
            let measured = models::load(&one.display().to_string())?;
            let outcome = compare_model(&measured, &reference)?;
            let page = report
                .is_some()
                .then(|| {
                    Ok::<_, Error>(outcome.page_of_model(opening(&[])?, &measured, &reference))
                })
                .transpose()?;
            (outcome, page)
        }
        logs => {
            let request = Request {
                one_sensor: args.one_sensor,
                ..Request::default()
            };
            let measured = characterize(&read_all(logs, &args.log, context)?, &request)?;
            let outcome = compare_logs(&measured, &reference)?;
            let page = report
                .is_some()
                .then(|| Ok::<_, Error>(outcome.page(opening(logs)?, &measured, &reference)))
                .transpose()?;
            (outcome, page)
        }
    };
    let mut outputs = Vec::new();
    if let (Some(mut file), Some(page)) = (report, page) {
        file.put(page.html().as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)
}

/// What the page says about how it was made.
fn opening(logs: &[PathBuf]) -> Result<Opening, Error> {
    let inputs = hashes_of(logs)?
        .into_iter()
        .map(|(name, sha256)| Input { name, sha256 })
        .collect();
    Ok(Opening {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: command_line(),
        method: Rich::new().plain(
            "Each term's ratio is the joint estimate over the sheet's value, its interval the measured one. White noise \
             within 4 % of √2 or 1/√2 is unclear: one of the two densities may be one-sided.",
        ),
        inputs,
        ..Opening::default()
    })
}

fn is_model(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
        || path.to_str().is_some_and(|p| p.starts_with("catalog:"))
}
