//! `sagnac characterize LOG…`: noise terms of each axis, with intervals.

mod follow;
mod growing;

use std::path::PathBuf;

use sagnac::Error;
use sagnac::analysis::fit::Candidates;
use sagnac::characterize::{NamedLog, Outcome, PageFacts, Request, candidates, characterize};
use sagnac::log::Log;
use sha2::{Digest as _, Sha256};

use crate::context::Context;
use crate::inputs::{self, Hashes, LogOptions, hexadecimal};
use crate::models;
use crate::outputs::{Output, publish_all};

/// Noise terms of each axis of a log at rest, with 95 % intervals, and whether the log is sound
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac characterize static.csv -o imu.toml --report imu.html")]
#[allow(clippy::struct_excessive_bools, reason = "switches of a command line")]
pub(crate) struct Args {
    /// Logs at rest; `-` is CSV from standard input
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// Write a page with curves, spectra, series and findings
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Write the estimates as a model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Any issue but quantization, line and earth_rate is an error
    #[arg(long)]
    strict: bool,
    /// All logs are of one sensor: common terms, run-to-run bias
    #[arg(long)]
    one_sensor: bool,
    /// The terms looked for, e.g. angle_random_walk,bias_instability [default: all]
    #[arg(long, value_name = "LIST")]
    terms: Option<String>,
    /// A model that gives range and bias: a file, or catalog:NAME
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Read on as the log grows, with the state on standard error
    #[arg(long)]
    follow: bool,
    /// With --follow: end at this precision, e.g. 'angle_random_walk=2%'
    #[arg(long, value_name = "LIST", requires = "follow")]
    until: Option<String>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    log: LogOptions,
}

/// What draws, where a picture is asked of the option of the model.
const PICTURES: &str = "sagnac allan LOG -o F.svg; every plot: --report F.html";

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let request = Request {
        candidates: args
            .terms
            .as_deref()
            .map(wanted_terms)
            .transpose()?
            .unwrap_or_default(),
        one_sensor: args.one_sensor,
        strict: args.strict,
        model: args.model.as_deref().map(models::load).transpose()?,
    };
    if args.follow && args.logs.len() > 1 {
        return Err(Error::usage("--follow reads one log")
            .at(format!("{} logs are named", args.logs.len()))
            .advise("name one, or leave --follow out"));
    }
    let model_file = args
        .output
        .as_deref()
        .map(|p| Output::claim_model(p, "-o", args.force, PICTURES))
        .transpose()?;
    let page_file = args
        .report
        .as_deref()
        .map(|p| Output::claim_page(p, args.force))
        .transpose()?;
    // A pipe is hashed as it goes by: it cannot be read again.
    let hashes = Hashes::default();
    let (outcome, ended_by) = if args.follow {
        follow::follow(args, &request, context)?
    } else {
        let mut reading = args.log.clone();
        reading.hashes = page_file.is_some().then(|| hashes.clone());
        let logs = read_all(&args.logs, &reading, context)?;
        (characterize(&logs, &request)?, None)
    };
    let mut outputs = Vec::new();
    if let Some(mut file) = model_file {
        file.put(outcome.to_model()?.to_toml().as_bytes())?;
        outputs.push(file);
    }
    if let Some(mut file) = page_file {
        file.put(page(args, &outcome, &hashes)?.as_bytes())?;
        outputs.push(file);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&publish_all(outputs)?)?;
    ended_by.map_or(Ok(()), Err)
}

/// The terms to look for; without white noise nothing has power at every frequency, and the rest would stand for it.
fn wanted_terms(list: &str) -> Result<Candidates, Error> {
    let wanted = candidates(list)?;
    if wanted.white {
        return Ok(wanted);
    }
    Err(Error::usage(
        "without white noise among the terms no noise is explained, and no interval holds",
    )
    .at(format!("--terms {list}"))
    .advise("add angle_random_walk (gyro) or velocity_random_walk (accelerometer)"))
}

/// Reads logs whole, with a progress bar over their bytes.
pub(crate) fn read_all(
    paths: &[PathBuf],
    options: &LogOptions,
    context: &Context,
) -> Result<Vec<NamedLog>, Error> {
    let mut logs = Vec::with_capacity(paths.len());
    for path in paths {
        let name = if path.as_os_str() == "-" {
            "standard input".to_owned()
        } else {
            path.display().to_string()
        };
        let mut reader = inputs::metered(path, options, context)?;
        let log = Log::read(&mut reader).map_err(|e| Error::from(e).at(name.clone()))?;
        logs.push(NamedLog { name, log });
    }
    Ok(logs)
}

/// Name and SHA-256 of each file among the inputs.
pub(crate) fn hashes_of(paths: &[PathBuf]) -> Result<Vec<(String, String)>, Error> {
    let mut out = Vec::new();
    for path in paths.iter().filter(|p| p.is_file()) {
        let mut file = std::fs::File::open(path).map_err(|e| crate::outputs::cannot(path, &e))?;
        let mut hash = Sha256::new();
        std::io::copy(&mut file, &mut hash).map_err(|e| crate::outputs::cannot(path, &e))?;
        out.push((path.display().to_string(), hexadecimal(&hash.finalize())));
    }
    Ok(out)
}

fn page(args: &Args, outcome: &Outcome, hashes: &Hashes) -> Result<String, Error> {
    let mut inputs = hashes_of(&args.logs)?;
    inputs.extend(hashes.finish());
    let facts = PageFacts {
        command: command_line(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        inputs,
    };
    Ok(outcome.to_page(&facts).html())
}

/// The command as it was typed, quoted where a shell needs it.
pub(crate) fn command_line() -> String {
    let mut out = String::from("sagnac");
    for word in std::env::args().skip(1) {
        out.push(' ');
        let plain = word
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c));
        if plain && !word.is_empty() {
            out.push_str(&word);
        } else {
            out.push('\'');
            out.push_str(&word.replace('\'', r"'\''"));
            out.push('\'');
        }
    }
    out
}
