//! `sagnac drift MODEL`: position error against time, and what causes it.

use std::path::PathBuf;

use clap::ValueEnum;
use sagnac::Error;
use sagnac::drift::{DriftRequest, Method, RecordingRequest, drift_with_progress, recording};
use sagnac::model::units::Dimension;
use sagnac::report::html::{Opening, Rich};

use crate::commands::characterize::command_line;
use crate::context::Context;
use crate::inputs::{self, LogOptions};
use crate::motion::{RunOptions, refuse_first};
use crate::outputs::{Output, publish_all};
use crate::quantities::optional;

/// How far off is a sensor after a while, and which of its errors makes it?
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac drift MODEL [--trajectory NAME|F] [OPTIONS]\n       sagnac drift MODEL --log LOG --reference F",
    after_help = "Example\n  sagnac drift imu.toml --trajectory drive --duration 10min --method monte-carlo"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    /// Length of the run [default: 1h, or the path's]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    duration: Option<String>,
    /// The covariance, or many runs of the whole sensor and strapdown [default: covariance]
    #[arg(
        long,
        value_enum,
        value_name = "covariance|monte-carlo",
        hide_possible_values = true
    )]
    method: Option<MethodOption>,
    /// Seed of the Monte Carlo [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Runs of the Monte Carlo [default: 200]
    #[arg(long, value_name = "N")]
    runs: Option<u32>,
    /// A recording to integrate instead
    #[arg(long, value_name = "LOG", requires = "reference_file")]
    log: Option<PathBuf>,
    /// Its truth: positions and attitudes
    #[arg(
        long = "reference",
        id = "reference_file",
        value_name = "F",
        requires = "log"
    )]
    reference: Option<PathBuf>,
    /// Write the page
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Draw the growth in time
    #[arg(short, long, value_name = "F.svg|F.png")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    run: RunOptions,
    #[command(flatten)]
    reading: LogOptions,
}

/// `--method`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodOption {
    /// Linear errors along the true path.
    Covariance,
    /// Runs.
    MonteCarlo,
}

impl Args {
    /// The outputs, page and picture.
    fn claim(&self) -> Result<(Option<Output>, Option<Output>), Error> {
        let report = self.report.as_deref();
        let report = report.map(|p| Output::claim_page(p, self.force));
        let picture = self.output.as_deref();
        let picture = picture.map(|p| Output::claim_picture(p, self.force));
        Ok((report.transpose()?, picture.transpose()?))
    }

    /// Refuses what a recording settles itself.
    fn refuse_beside_recording(&self) -> Result<(), Error> {
        refuse_first(&[
            (
                "--duration",
                self.duration.is_some(),
                "a recording is integrated over 1 s to 60 s from many starts",
            ),
            (
                "--method",
                self.method == Some(MethodOption::MonteCarlo),
                "beside a recording stands what the covariance predicts",
            ),
            (
                "--seed",
                self.seed.is_some(),
                "nothing is drawn, beside a recording stands what the covariance predicts",
            ),
            (
                "--runs",
                self.runs.is_some(),
                "nothing is drawn, beside a recording stands what the covariance predicts",
            ),
        ])?;
        self.run.refuse_beside_recording()
    }
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    if let (Some(log), Some(reference)) = (&args.log, &args.reference) {
        return on_recording(args, context, log, reference);
    }
    let duration_s = optional("--duration", args.duration.as_deref(), Dimension::TIME)?;
    let rate_hz = args.reading.read_options()?.rate_hz;
    let alignment = args.run.alignment()?;
    let (report, picture) = args.claim()?;
    let trajectory = args.run.trajectory(context)?;
    let model = inputs::model(&args.model)?;
    let temperature = args
        .run
        .temperature(duration_s.unwrap_or_else(|| trajectory.default_duration_s()))?;
    let request = DriftRequest {
        duration_s,
        rate_hz,
        method: match args.method {
            None | Some(MethodOption::Covariance) => Method::Covariance,
            Some(MethodOption::MonteCarlo) => Method::MonteCarlo,
        },
        alignment,
        calibration: args.run.calibration(),
        vertical: args.run.vertical(),
        sculling: args.run.sculling(),
        temperature,
        seed: args.seed.unwrap_or(0),
        runs: args.runs.unwrap_or(200),
        ..DriftRequest::new(&model, &trajectory)
    };
    let mut progress = None;
    let outcome = drift_with_progress(&request, &mut |done, total| {
        progress
            .get_or_insert_with(|| context.progress("Monte Carlo", Some(total)))
            .set(done);
    })?;
    drop(progress);
    for note in &outcome.notes {
        context.note(note);
    }
    for warning in outcome.warnings() {
        context.warn(&warning);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    let mut outputs = Vec::new();
    if report.is_some() || picture.is_some() {
        let page = outcome.page(Opening {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            method: Rich::new().plain(
                "Covariance: each independent source of error propagated alone along the true path; the shares sum to one. Monte Carlo: the whole sensor, its correction and the strapdown at full rate.",
            ),
            limits: outcome.warnings().into_iter().map(|w| Rich::new().plain(w)).collect(),
            ..Opening::default()
        });
        if let Some(mut out) = report {
            out.put(page.html().as_bytes())?;
            outputs.push(out);
        }
        if let Some(mut out) = picture {
            put_svg(&mut out, &page.growth.figure().svg)?;
            outputs.push(out);
        }
    }
    context.wrote(&publish_all(outputs)?)
}

/// Writes a drawing as SVG or PNG, by the name.
pub(crate) fn put_svg(out: &mut Output, svg: &sagnac::report::svg::Svg) -> Result<(), Error> {
    let extension = out
        .path()
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
        .to_ascii_lowercase();
    match extension.as_str() {
        "svg" => out.put(svg.standalone().as_bytes()),
        "png" => {
            let bytes = svg.to_png().map_err(Error::data)?;
            out.put(&bytes)
        }
        _ => Err(
            Error::usage(format!("a picture cannot be written as {}", out.name()))
                .at("-o")
                .advise("name it F.svg or F.png"),
        ),
    }
}

fn on_recording(
    args: &Args,
    context: &Context,
    log: &std::path::Path,
    reference: &std::path::Path,
) -> Result<(), Error> {
    args.refuse_beside_recording()?;
    let (report, picture) = args.claim()?;
    let model = inputs::model(&args.model)?;
    let (mut reader, _) = args.reading.open(log)?;
    let log_data = sagnac::log::Log::read(&mut reader).map_err(Error::from)?;
    let reference_data = args.run.reference.read(reference)?;
    let outcome = recording(&RecordingRequest {
        model: &model,
        log: &log_data,
        log_label: &log.display().to_string(),
        reference: &reference_data,
        reference_label: &reference.display().to_string(),
        start: args.run.start.start()?,
        earth: args.run.start.earth(),
    })?;
    for warning in &outcome.warnings {
        context.warn(warning);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    let mut outputs = Vec::new();
    if let Some(mut out) = picture {
        put_svg(&mut out, &outcome.chart().draw())?;
        outputs.push(out);
    }
    if let Some(mut out) = report {
        let page = outcome.page(Opening {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            ..Opening::default()
        });
        out.put(page.html().as_bytes())?;
        outputs.push(out);
    }
    context.wrote(&publish_all(outputs)?)
}
