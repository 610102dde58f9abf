//! `sagnac simulate MODEL`: a log with every error of a model, at rest, on a trajectory or on a log of truth.

#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "reads closest to its equation"
)]

use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use sagnac::Error;
use sagnac::log::{WriteFormat, create};
use sagnac::model::units::Dimension;
use sagnac::nav::{Earth, Start, Trajectory, trajectory::NAMES};
use sagnac::noise::TermSet;
use sagnac::path::trajectory_of_log;
use sagnac::simulate::{MotionSource, SimulateRequest, Sinks, simulate as run_simulation};

use crate::context::Context;
use crate::inputs::{self, LogOptions};
use crate::motion::{ReferenceOptions, missing_path, refuse_start, temperature_profile};
use crate::outputs::{Output, publish_all, refuse_without_room, size};
use crate::quantities::{positive, quantity};

/// A log with every error of a sensor model: what it puts out at rest or in motion
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac simulate MODEL (--rest T | --trajectory F | --inputs LOG) -o LOG",
    after_help = "Example\n  sagnac simulate imu.toml --rest 2h --rate 100Hz --latitude 46.5deg -o rest.npy"
)]
pub(crate) struct Args {
    /// A model file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: String,
    #[command(flatten)]
    motion: MotionArgs,
    /// Length of the run on a trajectory [default: 1h, or the path's length]
    #[arg(long, value_name = "TIME")]
    duration: Option<String>,
    #[command(flatten)]
    start_at: StartArgs,
    /// Random terms: all, none, or a list of white, quantization, flicker, random_walk, ramp,
    /// gauss_markov, resonance, sinusoid, stability
    #[arg(long, value_name = "LIST", default_value = "all")]
    noise: String,
    /// Same seed, same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// So many runs with draws of their own, written as LOG-0001 …
    #[arg(long, value_name = "N")]
    runs: Option<u32>,
    /// '40 degC', 'ramp 20 degC 60 degC', 'cycle -20 degC 70 degC 2 h', or a file with time and temperature
    #[arg(long, value_name = "PROFILE", allow_hyphen_values = true)]
    temperature: Option<String>,
    /// Also writes the truth: inputs as the model saw them, biases, motion
    #[arg(long, value_name = "F")]
    truth: Option<PathBuf>,
    /// The log to write: .csv, .csv.gz, .csv.zst, .npy, .npz, .parquet, .mcap or .bag
    #[arg(short, long, value_name = "LOG")]
    output: PathBuf,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    reference: ReferenceOptions,
    #[command(flatten)]
    log: LogOptions,
}

/// Exactly one of these says how the sensor moves.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct MotionArgs {
    /// At rest for this time
    #[arg(long, value_name = "TIME")]
    rest: Option<String>,
    /// rest, turn, coning, figure-eight, drive, flight, walking, rocket, or a file of way-points
    #[arg(long, value_name = "NAME|F")]
    trajectory: Option<String>,
    /// A log of true gyro_*, accel_* (gyro_rate_*, temperature) to put the errors on
    #[arg(long, value_name = "LOG")]
    inputs: Option<PathBuf>,
}

/// Where a trajectory starts.
#[derive(clap::Args)]
struct StartArgs {
    /// Latitude of the start [default: 45deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    latitude: Option<String>,
    /// Longitude of the start [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    longitude: Option<String>,
    /// Height of the start [default: 0m]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    height: Option<String>,
    /// Heading of the start [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    heading: Option<String>,
    /// Roll at rest [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    roll: Option<String>,
    /// Pitch at rest [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    pitch: Option<String>,
}

impl StartArgs {
    fn start(&self) -> Result<Start, Error> {
        let mut start = Start::default();
        for (option, text, dimension, value) in [
            (
                "--latitude",
                &self.latitude,
                Dimension::ANGLE,
                &mut start.latitude_rad,
            ),
            (
                "--longitude",
                &self.longitude,
                Dimension::ANGLE,
                &mut start.longitude_rad,
            ),
            (
                "--height",
                &self.height,
                Dimension::LENGTH,
                &mut start.height_m,
            ),
            (
                "--heading",
                &self.heading,
                Dimension::ANGLE,
                &mut start.heading_rad,
            ),
            ("--roll", &self.roll, Dimension::ANGLE, &mut start.roll_rad),
            (
                "--pitch",
                &self.pitch,
                Dimension::ANGLE,
                &mut start.pitch_rad,
            ),
        ] {
            if let Some(text) = text {
                *value = quantity(option, text, dimension)?;
            }
        }
        Ok(start)
    }

    fn given(&self) -> Vec<&'static str> {
        [
            ("--latitude", &self.latitude),
            ("--longitude", &self.longitude),
            ("--height", &self.height),
            ("--heading", &self.heading),
            ("--roll", &self.roll),
            ("--pitch", &self.pitch),
        ]
        .into_iter()
        .filter(|(_, text)| text.is_some())
        .map(|(option, _)| option)
        .collect()
    }
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let began = Instant::now();
    let terms = terms(&args.noise)?;
    let rate_hz = args
        .log
        .rate
        .as_deref()
        .map(|text| positive("--rate", text, Dimension::FREQUENCY))
        .transpose()?;
    let runs = args.runs.unwrap_or(1);
    if runs == 0 || runs > 1_000_000 {
        return Err(Error::usage(format!(
            "the number of runs must be 1 to 1000000, not {runs}"
        ))
        .at(format!("--runs {runs}"))
        .advise("write for instance --runs 100"));
    }
    let start = args.start_at.start()?;
    let duration_s = match (&args.motion.rest, &args.duration) {
        (Some(text), _) => Some(positive("--rest", text, Dimension::TIME)?),
        (None, Some(text)) => Some(positive("--duration", text, Dimension::TIME)?),
        (None, None) => None,
    };
    if args.duration.is_some() && args.motion.trajectory.is_none() {
        let (option, advice) = match args.motion.rest {
            Some(_) => ("--rest", "give the length once: --rest 2h"),
            None => ("--inputs", "cut the input with --start and --end"),
        };
        return Err(Error::usage(format!(
            "--duration belongs to --trajectory, not to {option}"
        ))
        .at("--duration")
        .advise(advice));
    }
    check_log_options(args)?;
    let temperature = args
        .temperature
        .as_deref()
        .map(temperature_profile)
        .transpose()?;
    let format = WriteFormat::of_name(&args.output.display().to_string())?;
    let truth_format = args
        .truth
        .as_deref()
        .map(|path| WriteFormat::of_name(&path.display().to_string()))
        .transpose()?;
    let model = inputs::model(&args.model)?;
    let trajectory;
    let mut left_out = None;
    let motion = if let Some(path) = &args.motion.inputs {
        args.reference.refuse()?;
        if let Some(option) = args.start_at.given().first() {
            return Err(
                Error::usage(format!("{option} has no meaning with --inputs"))
                    .advise(format!("leave {option} out")),
            );
        }
        let options = args.log.clone();
        let path = path.clone();
        MotionSource::Log {
            label: label_of(&path),
            is_repeatable: path.is_file() || path.is_dir(),
            open: Box::new(move || Ok(options.open_whole(&path, format)?.0)),
        }
    } else {
        (trajectory, left_out) = trajectory_of(args, &start)?;
        MotionSource::Trajectory {
            trajectory: &trajectory,
            start,
            duration_s: duration_s.unwrap_or_else(|| trajectory.default_duration_s()),
        }
    };
    let request = SimulateRequest {
        model: &model,
        motion,
        rate_hz,
        terms,
        seed: args.seed,
        runs,
        temperature,
        with_truth: args.truth.is_some(),
    };
    // Every output is claimed before the work, so that what exists is refused at once.
    let mut logs = Vec::new();
    let mut truths = Vec::new();
    let numbered = args.runs.is_some();
    for run in 1..=runs {
        logs.push(claim(
            &args.output,
            numbered.then_some(run),
            "-o",
            args.force,
        )?);
        if let Some(path) = &args.truth {
            truths.push(claim(path, numbered.then_some(run), "--truth", args.force)?);
        }
    }
    let mut progress = None;
    let mut outcome = run_simulation(
        request,
        &mut |run, layouts| {
            let at = run as usize - 1;
            if run == 1 {
                let rows = layouts.log.samples.unwrap_or(0) as f64 * f64::from(runs);
                let columns = layouts.log.channels.len() + 1;
                refuse_without_room(&args.output, rows * least_row(format, columns))?;
            }
            Ok(Sinks {
                log: create(format, Box::new(logs[at].clone()), &layouts.log)?,
                truth: match (truth_format, truths.get(at)) {
                    (Some(format), Some(truth)) => {
                        Some(create(format, Box::new(truth.clone()), &layouts.truth)?)
                    }
                    _ => None,
                },
            })
        },
        &mut |done, total| {
            progress
                .get_or_insert_with(|| context.progress("simulating", total).with_rate("samples"))
                .set(done);
        },
    )?;
    drop(progress);
    outcome.warnings.splice(0..0, left_out);
    let name = |output: &SharedOutput| output.lock().as_ref().map(Output::name).unwrap_or_default();
    outcome.files = logs.iter().map(name).collect();
    outcome.truth_files = truths.iter().map(name).collect();
    let all: Vec<Output> = logs
        .iter()
        .chain(&truths)
        .filter_map(|shared| shared.lock().take())
        .collect();
    let names = publish_all(all)?;
    for warning in &outcome.warnings {
        context.warn(warning);
    }
    for note in &outcome.notes {
        context.note(note);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    let seconds = began.elapsed().as_secs_f64();
    let wrote: Vec<String> = names
        .iter()
        .map(|name| match std::fs::metadata(name) {
            Ok(file) if file.is_file() && names.len() == 1 => {
                format!("{name} ({}, {seconds:.2} s)", size(file.len() as f64))
            }
            Ok(file) if file.is_file() => format!("{name} ({})", size(file.len() as f64)),
            _ => name.clone(),
        })
        .collect();
    match wrote.as_slice() {
        [first, .., last] if wrote.len() > 8 => context.wrote(&[format!(
            "{first} … {last}: {} files, {seconds:.2} s",
            wrote.len()
        )]),
        _ => context.wrote(&wrote),
    }
}

/// The fewest bytes that a row takes.
fn least_row(format: WriteFormat, columns: usize) -> f64 {
    match format {
        WriteFormat::Npy | WriteFormat::Npz => 8.0 * columns as f64,
        WriteFormat::Csv => 2.0 * columns as f64,
        WriteFormat::Bag | WriteFormat::Mcap => 300.0,
        // Compressed: as good as nothing where nothing changes.
        _ => 0.01,
    }
}

fn label_of(path: &Path) -> String {
    if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    }
}

/// `--noise`.
fn terms(text: &str) -> Result<TermSet, Error> {
    match text.trim() {
        "all" => return Ok(TermSet::ALL),
        "none" => return Ok(TermSet::NONE),
        _ => {}
    }
    text.split(',')
        .map(str::trim)
        .try_fold(TermSet::NONE, |set, name| {
            if set.has(name) {
                return Err(Error::usage(format!("`{name}` stands twice"))
                    .at(format!("--noise {text}"))
                    .advise("name each random term once"));
            }
            set.with(name).ok_or_else(|| {
                let near = sagnac::model::suggest(name, TermSet::NAMES.iter().copied());
                Error::usage(format!("there is no random term `{name}`"))
                    .at(format!("--noise {text}"))
                    .advise(match near {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            format!("write all, none or a list of {}", TermSet::NAMES.join(", "))
                        }
                    })
            })
        })
}

/// Options of reading that would change nothing are refused.
fn check_log_options(args: &Args) -> Result<(), Error> {
    if args.motion.inputs.is_some() {
        return Ok(());
    }
    let log = &args.log;
    let unused = [
        ("--columns", &log.columns),
        ("--topic", &log.topic),
        ("--start", &log.start),
        ("--end", &log.end),
        ("--axes", &log.axes),
    ]
    .into_iter()
    .find(|(_, text)| text.is_some());
    match unused {
        Some((option, _)) => Err(Error::usage(format!("{option} belongs to --inputs"))
            .at(option)
            .advise(format!(
                "leave {option} out, or name a log of truth with --inputs"
            ))),
        None => Ok(()),
    }
}

/// `--rest`, or `--trajectory` by name or file, with the sentence on rows of the file that were left out.
fn trajectory_of(args: &Args, start: &Start) -> Result<(Trajectory, Option<String>), Error> {
    let name = args.motion.trajectory.as_deref().unwrap_or("rest");
    let path = Path::new(name);
    if let Some(error) = missing_path(name) {
        return Err(error);
    }
    if NAMES.contains(&name) {
        args.reference.refuse()?;
    }
    if NAMES.contains(&name) || !(path.exists() || name == "-") {
        let trajectory = Trajectory::named(name, Earth::Wgs84, start).map_err(|error| {
            let error = Error::from(error);
            Error {
                kind: sagnac::Kind::Usage,
                ..error
            }
        })?;
        return Ok((trajectory, None));
    }
    let log = args.reference.read(path)?;
    refuse_start(&args.start_at.given(), &log, name)?;
    trajectory_of_log(&log, name, Earth::Wgs84, start)
}

/// An output that both the writer of the format and the end of the command hold.
#[derive(Clone)]
struct SharedOutput(Arc<Mutex<Option<Output>>>);

impl SharedOutput {
    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Output>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for SharedOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock()
            .as_mut()
            .map_or(Ok(0), |output| output.write(bytes))
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.lock()
            .as_mut()
            .map_or(Ok(()), |output| output.write_all(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.lock().as_mut().map_or(Ok(()), Output::flush)
    }
}

impl Seek for SharedOutput {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.lock().as_mut().map_or(Ok(0), |output| output.seek(to))
    }
}

/// Claims `path`, with the number of the run before its extension.
fn claim(path: &Path, run: Option<u32>, option: &str, force: bool) -> Result<SharedOutput, Error> {
    let numbered;
    let path = match run {
        Some(run) => {
            numbered = with_number(path, run);
            &numbered
        }
        None => path,
    };
    let output = Output::claim(path, option, force)?;
    Ok(SharedOutput(Arc::new(Mutex::new(Some(output)))))
}

/// `out.csv.gz` → `out-0001.csv.gz`.
fn with_number(path: &Path, run: u32) -> PathBuf {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    let lower = name.to_ascii_lowercase();
    let extension = [".csv.gz", ".csv.zst"]
        .into_iter()
        .find(|extension| lower.ends_with(extension))
        .map_or_else(
            || lower.rfind('.').map_or(0, |dot| lower.len() - dot),
            str::len,
        );
    let (stem, extension) = name.split_at(name.len() - extension);
    path.with_file_name(format!("{stem}-{run:04}{extension}"))
}
