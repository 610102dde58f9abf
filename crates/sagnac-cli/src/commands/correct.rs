//! `sagnac correct MODEL LOG -o LOG`, or `--emit c|rust -o DIR`.

use std::path::PathBuf;

use clap::ValueEnum;
use sagnac::Error;
use sagnac::correct::{CorrectRequest, correct};
use sagnac::log::{Layout, LogWriter, WriteFormat};
use sagnac::model::emit::{self, EmitRequest, Precision};

use crate::context::Context;
use crate::inputs::LogOptions;
use crate::models;
use crate::outputs::{NewFolder, Output, publish_all};

/// Take the errors of a model out of a log, or write C or Rust source that does
#[derive(clap::Args)]
#[command(
    after_help = "Examples\n  sagnac correct imu.toml drive.csv -o corrected.csv\n  sagnac correct imu.toml --emit c --precision f32 -o firmware"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    /// The log; - is standard input
    #[arg(value_name = "LOG", required_unless_present = "emit")]
    log: Option<PathBuf>,
    /// The corrected log (.csv, .csv.gz, .csv.zst, .npy, .npz, .parquet, .mcap, .bag), or the folder of the source
    #[arg(short, long, value_name = "LOG|DIR")]
    output: PathBuf,
    /// Add the column flags: 1 gyro saturated, 2 accelerometer saturated, 4 temperature outside its range, 8 outside validity, 16 not finite
    #[arg(long)]
    flags: bool,
    /// Write source of the same compensation instead
    #[arg(long, value_enum, value_name = "c|rust", conflicts_with_all = ["log", "flags"])]
    emit: Option<Language>,
    /// Number type of the source [default: f64]
    #[arg(long, value_enum, value_name = "f64|f32")]
    precision: Option<NumberType>,
    /// Replace outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    reading: LogOptions,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    C,
    Rust,
}

#[derive(Clone, Copy, ValueEnum)]
enum NumberType {
    F64,
    F32,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    if args.precision.is_some() && args.emit.is_none() {
        return Err(
            Error::usage("--precision is the number type of emitted source")
                .at("--precision")
                .advise("add --emit c or --emit rust, or leave --precision out"),
        );
    }
    match (args.emit, &args.log) {
        (Some(language), _) => emit_source(args, language, context),
        (None, Some(log)) => correct_log(args, log, context),
        (None, None) => Err(Error::usage("a log is needed")
            .advise("sagnac correct imu.toml drive.csv -o corrected.csv")),
    }
}

fn correct_log(args: &Args, log: &std::path::Path, context: &Context) -> Result<(), Error> {
    let format = WriteFormat::of_name(&args.output.display().to_string())?;
    if args.flags && matches!(format, WriteFormat::Mcap | WriteFormat::Bag) {
        return Err(Error::usage("sensor_msgs/Imu has no room for flags")
            .at("--flags")
            .advise("write .csv, .npy, .npz or .parquet, or leave --flags out"));
    }
    let model = models::load(&args.model)?;
    let output = Output::claim(&args.output, "-o", args.force)?;
    let (mut reader, _) = args.reading.open_whole(log, format)?;
    let shared = std::sync::Arc::new(std::sync::Mutex::new(output));
    let mut create = |layout: &Layout| -> Result<Box<dyn LogWriter>, Error> {
        Ok(sagnac::log::create(
            format,
            Box::new(Shared(shared.clone())),
            layout,
        )?)
    };
    let outcome = correct(
        &model,
        &mut reader,
        &mut create,
        CorrectRequest { flags: args.flags },
    )
    .map_err(|error| {
        if error.what.starts_with("the log ") && error.place.is_none() {
            error.at(log.display().to_string())
        } else {
            error
        }
    })?;
    let output = std::sync::Arc::into_inner(shared)
        .and_then(|mutex| mutex.into_inner().ok())
        .ok_or_else(|| Error::data("the output was not completed"))?;
    let written = publish_all(vec![output])?;
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&written)
}

/// The output while the writer of the log holds it.
struct Shared(std::sync::Arc<std::sync::Mutex<Output>>);

impl Shared {
    fn with<R>(&self, work: impl FnOnce(&mut Output) -> std::io::Result<R>) -> std::io::Result<R> {
        match self.0.lock() {
            Ok(mut output) => work(&mut output),
            Err(_) => Err(std::io::Error::other("the output is in use")),
        }
    }
}

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.with(|output| output.write(bytes))
    }
    fn flush(&mut self) -> std::io::Result<()> {
        self.with(std::io::Write::flush)
    }
}

impl std::io::Seek for Shared {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.with(|output| output.seek(to))
    }
}

fn emit_source(args: &Args, language: Language, context: &Context) -> Result<(), Error> {
    if args.reading.is_any() {
        return Err(
            Error::usage("the options of reading a log have no meaning with --emit")
                .advise("leave --columns, --rate, --topic, --start, --end and --axes out"),
        );
    }
    let model = models::load(&args.model)?;
    let core = model.to_core()?;
    let held = sagnac::correct::held_at_zero(&model);
    let request = EmitRequest {
        held: &held,
        name: model.name(),
        model: &core,
        dt_s: 1.0 / model.sample_rate_hz().unwrap_or(100.0),
        precision: match args.precision {
            Some(NumberType::F32) => Precision::F32,
            _ => Precision::F64,
        },
    };
    let files = match language {
        Language::C => emit::c(&request),
        Language::Rust => emit::rust(&request),
    };
    let files = files.map_err(|error| Error::from(error).at(model.label()))?;
    if args.output.exists() && !args.output.is_dir() {
        return Err(
            Error::usage(format!("{} is a file, not a folder", args.output.display()))
                .at("-o")
                .advise("--emit writes several files: name a folder"),
        );
    }
    let folder = NewFolder::make(&args.output)?;
    let mut outputs = Vec::new();
    for file in &files {
        outputs.push(Output::claim(
            &args.output.join(&file.name),
            "-o",
            args.force,
        )?);
    }
    for (output, file) in outputs.iter_mut().zip(&files) {
        output.put(file.text.as_bytes())?;
    }
    let written = publish_all(outputs)?;
    folder.keep();
    context.print(String::new, || serde_json::json!({"files": written}))?;
    context.wrote(&written)
}
