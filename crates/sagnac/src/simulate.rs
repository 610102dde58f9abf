//! `simulate`: a log with every error of a sensor model, at rest, on a trajectory or on a log of truth.
//!
//! Sample k is the mean over (t_{k−1}, t_k], t_k = k·dt; the model is that of [`sagnac_core`], the
//! random terms those of [`sagnac_noise`]. The samples depend on the request and the seed alone, not
//! on threads or blocks.

mod run;
mod slope;
mod source;
mod temperature;
mod words;

pub use slope::slopes;
pub(crate) use source::Channels;
pub(crate) use temperature::ABSOLUTE_ZERO_C;
pub use temperature::TemperatureProfile;

use sagnac_log::{Block, Cadence, Channel, Layout, Log, LogReader, LogWriter, TextColumn};
use sagnac_model::Model;
use sagnac_nav::{Start, Trajectory};
use sagnac_noise::TermSet;
use sagnac_report::text::{duration, general};
use serde_json::{Value, json};

use crate::Error;
use run::{OutsideRange, Recipe, Run};
use source::{LogSource, Peeked, Plan, TrajectorySource, TruthRows, TruthSource};

/// The flicker's slow end where the length of the input is not known: that of a day.
const UNKNOWN_LENGTH_S: f64 = 86_400.0;

/// More samples than a run of a day gives on any machine of today.
const MOST_SAMPLES: f64 = 1e12;

/// Samples further apart than this, s, are means over several steps of the motion.
const STEP_S: f64 = 0.02;

/// The steps of 100 days: minutes of work, in which a slow rate would show no progress.
const MOST_STEPS: f64 = 100.0 * 86_400.0 / STEP_S;

/// Gives the truth log from its start, every time it is called.
pub type OpenLog<'a> = Box<dyn FnMut() -> Result<Box<dyn LogReader>, Error> + 'a>;

/// Where the true motion comes from.
pub enum MotionSource<'a> {
    /// A trajectory (`rest` among them) for a time.
    Trajectory {
        /// The motion.
        trajectory: &'a Trajectory,
        /// Its start, for the words.
        start: Start,
        /// Length of the run, s; the samples are round(duration/dt).
        duration_s: f64,
    },
    /// A log of true specific force and rate.
    Log {
        /// What messages call it.
        label: String,
        /// Opens it.
        open: OpenLog<'a>,
        /// Whether it can be opened more than once (a file, not a pipe).
        is_repeatable: bool,
    },
}

/// What to simulate.
pub struct SimulateRequest<'a> {
    /// The sensor.
    pub model: &'a Model,
    /// The motion.
    pub motion: MotionSource<'a>,
    /// `--rate`, Hz.
    pub rate_hz: Option<f64>,
    /// `--noise`.
    pub terms: TermSet,
    /// The seed, which the caller chooses.
    pub seed: u64,
    /// `--runs`: runs 1 … n; run 1 is what one run alone is.
    pub runs: u32,
    /// `--temperature`.
    pub temperature: Option<TemperatureProfile>,
    /// Whether `--truth` is wanted.
    pub with_truth: bool,
}

/// Where the logs of a run go.
pub struct Sinks {
    /// The sensor's output.
    pub log: Box<dyn LogWriter>,
    /// The truth, where it was asked for.
    pub truth: Option<Box<dyn LogWriter>>,
}

/// The layouts of the two logs of a run.
pub struct Layouts {
    /// The sensor's output.
    pub log: Layout,
    /// The truth.
    pub truth: Layout,
}

/// What was simulated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimulateOutcome {
    /// Names of the logs that were written; the caller fills them in.
    pub files: Vec<String>,
    /// Names of the truth logs.
    pub truth_files: Vec<String>,
    /// Samples of a run.
    pub samples: u64,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Samples times dt, s.
    pub duration_s: f64,
    /// The seed.
    pub seed: u64,
    /// Runs.
    pub runs: u32,
    /// The sentence on sensor, motion and length.
    pub headline: String,
    /// Which terms are on and which are not.
    pub remarks: Vec<String>,
    /// Remarks about the work, for standard error.
    pub notes: Vec<String>,
    /// Warnings about the work, for standard error.
    pub warnings: Vec<String>,
}

impl SimulateOutcome {
    /// `{"files", "samples", "rate_hz", "duration_s", "seed", …}`.
    pub fn to_json(&self) -> Value {
        json!({
            "files": self.files,
            "truth": self.truth_files,
            "samples": self.samples,
            "rate_hz": self.rate_hz,
            "duration_s": self.duration_s,
            "seed": self.seed,
            "runs": self.runs,
            "notes": self.notes,
            "warnings": self.warnings,
        })
    }

    /// The result as a document for the terminal.
    pub fn document(&self) -> sagnac_report::text::Document {
        let mut out = sagnac_report::text::Document::new();
        out.paragraph(&self.headline);
        for remark in &self.remarks {
            out.paragraph(remark);
        }
        out
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(sagnac_report::text::Style::PLAIN)
    }
}

/// Simulates every run and streams it into the sinks that `open_sinks` gives for it.
///
/// `progress` is told the samples done over all runs and, where known, their total.
///
/// # Errors
/// A model the core cannot take, a truth that is not finite or lacks an axis, a run without
/// samples, what the writers say.
pub fn simulate(
    mut request: SimulateRequest<'_>,
    open_sinks: &mut dyn FnMut(u32, &Layouts) -> Result<Sinks, Error>,
    progress: &mut dyn FnMut(u64, Option<u64>),
) -> Result<SimulateOutcome, Error> {
    let model = request.model;
    let mut outcome = SimulateOutcome {
        seed: request.seed,
        runs: request.runs,
        ..SimulateOutcome::default()
    };
    let (plan, channels) = plan(&mut request, &mut outcome)?;
    let layouts = layouts(&plan, &channels, &request);
    let core = model.to_core()?;
    words::check_increments(model, &core, plan.dt_s())?;
    let recipe = Recipe {
        core,
        terms: request.terms,
        seed: request.seed,
        dt_s: plan.dt_s(),
        run_length_s: plan.end_s.unwrap_or(UNKNOWN_LENGTH_S),
        present: [channels.rate.is_some(), channels.force.is_some()],
        with_drift: request.with_truth,
    };
    words::warn_of_terms(model, &request, &recipe, &mut outcome);
    let total = plan
        .samples
        .map(|samples| samples * u64::from(request.runs));
    let mut clipped = std::collections::BTreeMap::<String, (u64, f64)>::new();
    let (mut done, mut outside, mut clock) = (0, Vec::<OutsideRange>::new(), None);
    for run in 1..=request.runs {
        let mut state = Run::new(model, &recipe, run)?;
        let mut sinks = open_sinks(run, &layouts)?;
        let mut log_source = None;
        let mut trajectory_source;
        let before = done;
        {
            let source: &mut dyn TruthSource = match &mut request.motion {
                MotionSource::Trajectory { trajectory, .. } => {
                    trajectory_source = TrajectorySource::new(trajectory, plan.clone());
                    &mut trajectory_source
                }
                MotionSource::Log { open, .. } => {
                    log_source.insert(LogSource::new(open()?, channels.clone(), plan.clone()))
                }
            };
            let with_temperature = layouts.log.index("temperature").is_some();
            stream(
                source,
                &mut state,
                &mut sinks,
                with_temperature,
                &mut |rows| {
                    done += rows;
                    progress(done, total);
                },
            )?;
        }
        if let Some(source) = &log_source {
            outcome.notes.extend(source.reader_notes());
            outcome.notes.extend(source.clock.note());
            clock = Some(source.clock.clone());
        }
        outcome.samples = done - before;
        if outcome.samples == 0 {
            return Err(Error::data("the log has no samples"));
        }
        outcome.notes.extend(sinks.log.finish()?);
        if let Some(truth) = sinks.truth {
            let said = truth.finish()?.into_iter();
            outcome
                .notes
                .extend(said.map(|note| format!("the truth: {note}")));
        }
        // Every run has the same ranges.
        if outside.is_empty() {
            outside.append(&mut state.too_cold_or_hot);
        } else {
            for (all, of_run) in outside.iter_mut().zip(&state.too_cold_or_hot) {
                all.count += of_run.count;
            }
        }
        for (name, count, limit) in state.clipped().filter(|(_, count, _)| *count > 0) {
            clipped.entry(name).or_insert((0, limit)).0 += count;
        }
    }
    outcome.notes.sort();
    outcome.notes.dedup();
    outcome.rate_hz = plan.rate_hz;
    outcome.duration_s = outcome.samples as f64 / plan.rate_hz;
    words::warn_of_samples(model, clipped, &outside, clock.as_ref(), &mut outcome);
    words::describe(&request, &recipe, &mut outcome);
    Ok(outcome)
}

/// Simulates the first run into memory: the log, and the truth where it was asked for.
///
/// # Errors
/// Those of [`simulate`].
pub fn simulate_log(
    request: SimulateRequest<'_>,
) -> Result<(SimulateOutcome, Log, Option<Log>), Error> {
    use std::sync::{Arc, Mutex};
    struct Keep(Arc<Mutex<Log>>);
    impl LogWriter for Keep {
        fn write_block(&mut self, block: &Block) -> Result<(), sagnac_log::Error> {
            if let Ok(mut log) = self.0.lock() {
                log.stamps.append(&block.stamps);
                for (all, part) in log.columns.iter_mut().zip(&block.columns) {
                    all.extend_from_slice(part);
                }
                log.rows += block.rows;
            }
            Ok(())
        }
        fn finish(self: Box<Self>) -> Result<Vec<String>, sagnac_log::Error> {
            Ok(Vec::new())
        }
    }
    let with_truth = request.with_truth;
    let request = SimulateRequest { runs: 1, ..request };
    let kept = [
        Arc::new(Mutex::new(Log::default())),
        Arc::new(Mutex::new(Log::default())),
    ];
    let start = |log: &Arc<Mutex<Log>>, layout: &Layout| {
        if let Ok(mut log) = log.lock() {
            log.columns = vec![Vec::new(); layout.channels.len()];
            log.layout = layout.clone();
        }
        Box::new(Keep(log.clone())) as Box<dyn LogWriter>
    };
    let outcome = simulate(
        request,
        &mut |_, layouts| {
            Ok(Sinks {
                log: start(&kept[0], &layouts.log),
                truth: with_truth.then(|| start(&kept[1], &layouts.truth)),
            })
        },
        &mut |_, _| {},
    )?;
    let [log, truth] = kept.map(|log| {
        log.lock()
            .map(|mut log| std::mem::take(&mut *log))
            .unwrap_or_default()
    });
    Ok((outcome, log, with_truth.then_some(truth)))
}

/// Fixes rate and length, and looks at a log of truth before anything is written.
fn plan(
    request: &mut SimulateRequest<'_>,
    outcome: &mut SimulateOutcome,
) -> Result<(Plan, Channels), Error> {
    let model_rate = request.model.sample_rate_hz();
    let asked_hz = request.rate_hz;
    let replaces_temperature = request.temperature.is_some();
    let mut plan = Plan {
        label: String::new(),
        rate_hz: 100.0,
        samples: None,
        end_s: None,
        temperature: request.temperature.clone(),
        reference_temperature_c: request.model.reference_temperature_c(),
        with_motion: request.with_truth,
        overridden_dt_s: None,
        cadence: None,
        others: Vec::new(),
        texts: Vec::new(),
    };
    match &mut request.motion {
        MotionSource::Trajectory {
            trajectory,
            duration_s,
            ..
        } => {
            plan.rate_hz = request.rate_hz.or(model_rate).unwrap_or_else(|| {
                outcome.notes.push(
                    "the model has no sample_rate and --rate is not given: 100 Hz is taken".into(),
                );
                100.0
            });
            trajectory.check_duration(*duration_s)?;
            words::warn_of_height(trajectory, *duration_s, outcome);
            let samples = (*duration_s * plan.rate_hz).round();
            if samples > MOST_SAMPLES {
                return Err(Error::usage(format!(
                    "{} at {} Hz make {} samples, {} TB as .npy",
                    duration(*duration_s),
                    general(plan.rate_hz, 6),
                    general(samples, 3),
                    general(samples * 7.0 * 8.0 / 1e12, 3)
                ))
                .advise("shorten the run or lower --rate"));
            }
            let steps = *duration_s / STEP_S;
            if samples < steps && steps > MOST_STEPS && !trajectory.is_rest() {
                return Err(Error::usage(format!(
                    "{} of `{}` are {} steps of {} ms, in which the motion is integrated whatever the rate: that would take too long",
                    duration(*duration_s),
                    trajectory.name(),
                    general(steps, 3),
                    general(STEP_S * 1e3, 3)
                ))
                .advise(format!("shorten the run to {}", duration(MOST_STEPS * STEP_S))));
            }
            if samples < 1.0 {
                return Err(Error::usage(format!(
                    "{duration_s} s at {} Hz make no sample",
                    plan.rate_hz
                ))
                .advise("lengthen the run or raise --rate"));
            }
            // A path that ends a part of an interval early: the last sample must lie within it.
            let most = trajectory.last_time_s().map_or(f64::INFINITY, |last| {
                (last * plan.rate_hz * (1.0 + 1e-12)).floor()
            });
            plan.samples = Some(samples.min(most.max(1.0)) as u64);
            plan.end_s = plan.samples.map(|samples| samples as f64 / plan.rate_hz);
            let all = Some([0, 1, 2]);
            let channels = Channels {
                rate: all,
                force: all,
                rate_dot: all,
                temperature: plan.temperature.is_some().then_some(0),
            };
            Ok((plan, channels))
        }
        MotionSource::Log {
            label,
            open,
            is_repeatable,
        } => {
            // The rate that counts, and what of the log it overrides.
            let mut look = |plan: &mut Plan,
                            log: &Peeked,
                            cadence: Option<Cadence>,
                            label: &str| {
                let own = log.layout().rate_hz;
                let stamps_dt_s = cadence.map(|cadence| cadence.dt_s);
                plan.cadence = cadence;
                label.clone_into(&mut plan.label);
                let asked = asked_hz.or(own.filter(|_| stamps_dt_s.is_some()));
                let own_dt = stamps_dt_s.or(own.map(|rate| 1.0 / rate));
                plan.rate_hz = log_rate(asked, model_rate, own_dt, label, outcome);
                plan.overridden_dt_s = asked
                    .filter(|_| log.layout().has_time)
                    .map(|rate| stamps_dt_s.unwrap_or(1.0 / rate));
                let left_out = plan.keep_others(log.layout());
                if !left_out.is_empty() {
                    outcome.notes.push(words::of_another_run(&left_out, label));
                }
                if log.layout().index("gyro_rate_x").is_some() {
                    outcome.notes.push(format!(
                            "gyro_rate_* of {label} are truth that the sensor does not measure: --truth writes them"
                        ));
                }
                if replaces_temperature && log.layout().index("temperature").is_some() {
                    outcome.warnings.push(format!(
                        "--temperature counts in place of the temperature in {label}"
                    ));
                }
            };
            if !*is_repeatable {
                if request.runs > 1 {
                    return Err(Error::usage(format!(
                        "{label} can be read only once, not for several runs"
                    ))
                    .advise("write it to a file first"));
                }
                if plan
                    .temperature
                    .as_ref()
                    .is_some_and(TemperatureProfile::needs_end)
                {
                    return Err(Error::usage(format!(
                        "a temperature ramp ends with the run, and the end of {label} is not known"
                    ))
                    .advise("write the log to a file first, or give the profile as a table"));
                }
                // What is read to look at it is kept and handed on.
                let reader = open()?;
                let (kept, cadence) = Peeked::new(reader)?;
                let channels =
                    Channels::of(kept.layout()).map_err(|error| error.at(label.clone()))?;
                look(&mut plan, &kept, cadence, label);
                let mut kept: Option<Box<dyn LogReader>> = Some(Box::new(kept));
                *open = Box::new(move || {
                    kept.take()
                        .ok_or_else(|| Error::data("the input can be read only once"))
                });
                return Ok((plan, channels));
            }
            let (mut kept, cadence) = Peeked::new(open()?)?;
            let channels = Channels::of(kept.layout()).map_err(|error| error.at(label.clone()))?;
            look(&mut plan, &kept, cadence, label);
            let mut block = Block::default();
            let (mut rows, mut clock) = (0, plan.clock());
            let mut end_s = None;
            while kept.read_block(&mut block)? {
                rows += block.rows as u64;
                for k in 0..block.rows {
                    end_s = Some(clock.next(block.stamps.get(k)) + plan.dt_s());
                }
            }
            if let Some(row) = clock.first_without_number() {
                return Err(source::no_time(row).at(label.clone()));
            }
            plan.samples = Some(rows);
            plan.end_s = end_s.filter(|end| *end > 0.0 && end.is_finite());
            Ok((plan, channels))
        }
    }
}

/// The rate of a log of truth: the user's, else the model's unless the log's own differs by more than 0.1 %.
fn log_rate(
    asked: Option<f64>,
    model: Option<f64>,
    own_dt: Option<f64>,
    label: &str,
    outcome: &mut SimulateOutcome,
) -> f64 {
    if let Some(rate) = asked {
        if let Some(dt) = own_dt.filter(|dt| (dt * rate - 1.0).abs() > 1e-3) {
            outcome.warnings.push(format!(
                "the time stamps of {label} go at {} Hz: the rate of {} Hz counts in their place",
                general(1.0 / dt, 6),
                general(rate, 6),
            ));
        }
        return rate;
    }
    match (model, own_dt.map(|dt| 1.0 / dt)) {
        (Some(model), Some(own)) if (own / model - 1.0).abs() > 1e-3 => {
            outcome.warnings.push(format!(
                "{label} has {} Hz, the model {} Hz: the log's rate is taken",
                general(own, 6),
                general(model, 6),
            ));
            own
        }
        (Some(model), _) => model,
        (None, Some(own)) => own,
        (None, None) => {
            outcome.notes.push(format!(
                "{label} has one sample and the model no sample_rate: 100 Hz is taken"
            ));
            100.0
        }
    }
}

/// Columns of the output and of the truth.
fn layouts(plan: &Plan, channels: &Channels, request: &SimulateRequest<'_>) -> Layouts {
    let mut log = Layout {
        has_time: true,
        rate_hz: None,
        samples: plan.samples,
        ..Layout::default()
    };
    let mut truth = log.clone();
    let named = |layout: &mut Layout, name: &str| layout.channels.push(Channel::named(name));
    let axes = ["x", "y", "z"];
    let sensors = [("gyro", channels.rate), ("accel", channels.force)];
    let present = || {
        sensors
            .into_iter()
            .filter(|(_, at)| at.is_some())
            .map(|(name, _)| name)
    };
    for sensor in present() {
        for axis in axes {
            named(&mut log, &format!("{sensor}_{axis}"));
            named(&mut truth, &format!("{sensor}_{axis}"));
        }
    }
    if channels.temperature.is_some() || plan.temperature.is_some() {
        named(&mut log, "temperature");
    }
    log.channels
        .extend(plan.others.iter().map(|(_, channel)| channel.clone()));
    let place = log.channels.len();
    log.texts
        .extend(plan.texts.iter().map(|(_, text)| TextColumn {
            place,
            ..text.clone()
        }));
    if channels.rate.is_some() {
        for axis in axes {
            named(&mut truth, &format!("gyro_rate_{axis}"));
        }
    }
    named(&mut truth, "temperature");
    let mut other = |name: &str, unit: &str| truth.channels.push(Channel::other(name, unit));
    for sensor in present() {
        let unit = if sensor == "gyro" { "rad/s" } else { "m/s^2" };
        for axis in axes {
            other(&format!("bias_{sensor}_{axis}"), unit);
        }
    }
    if matches!(request.motion, MotionSource::Trajectory { .. }) {
        for (name, unit) in [
            ("latitude", "deg"),
            ("longitude", "deg"),
            ("height", "m"),
            ("velocity_north", "m/s"),
            ("velocity_east", "m/s"),
            ("velocity_down", "m/s"),
            ("quaternion_w", ""),
            ("quaternion_x", ""),
            ("quaternion_y", ""),
            ("quaternion_z", ""),
            ("roll", "deg"),
            ("pitch", "deg"),
            ("heading", "deg"),
        ] {
            other(name, unit);
        }
    }
    Layouts { log, truth }
}

/// Passes all rows of a run through the sensor; the next rows are worked while the last are written.
fn stream(
    source: &mut dyn TruthSource,
    run: &mut Run,
    sinks: &mut Sinks,
    with_temperature: bool,
    done: &mut dyn FnMut(u64),
) -> Result<(), Error> {
    let mut truth = TruthRows::default();
    let (mut log, mut truth_log) = (Block::default(), Block::default());
    let mut more = source.next_rows(&mut truth)?;
    let at_once = rayon::current_num_threads() > 1;
    while more || log.rows > 0 {
        let write = |sinks: &mut Sinks| -> Result<(), Error> {
            if log.rows > 0 {
                sinks.log.write_block(&log)?;
                if let Some(writer) = &mut sinks.truth {
                    writer.write_block(&truth_log)?;
                }
            }
            Ok(())
        };
        if at_once {
            rayon::in_place_scope(|scope| {
                if more {
                    scope.spawn(|_| run.advance(&truth));
                }
                write(sinks)
            })?;
        } else {
            if more {
                run.advance(&truth);
            }
            write(sinks)?;
        }
        done(log.rows as u64);
        log.rows = 0;
        if more {
            run.check()?;
            log.rows = truth.rows;
            log.stamps.clone_from(&truth.stamps);
            let temperature = with_temperature.then_some(&truth.temperature);
            let columns = run.columns().chain(temperature).chain(&truth.others);
            copy_columns(&mut log.columns, columns);
            log.texts.clone_from(&truth.texts);
            if sinks.truth.is_some() {
                truth_block(&mut truth_log, &truth, run);
            }
            more = source.next_rows(&mut truth)?;
        }
    }
    Ok(())
}

/// Copies columns into a block, keeping its memory.
fn copy_columns<'a>(to: &mut Vec<Vec<f64>>, from: impl Iterator<Item = &'a Vec<f64>>) {
    let mut count = 0;
    for column in from {
        if to.len() == count {
            to.push(Vec::new());
        }
        to[count].clone_from(column);
        count += 1;
    }
    to.truncate(count);
}

/// The rows of `--truth`: what the model saw, its biases, and the motion where there is one.
fn truth_block(block: &mut Block, truth: &TruthRows, run: &Run) {
    block.rows = truth.rows;
    block.stamps.clone_from(&truth.stamps);
    block.columns.clear();
    let [gyro, accel] = run.present();
    let mut put = |wanted: bool, columns: &[Vec<f64>]| {
        if wanted {
            block.columns.extend_from_slice(columns);
        }
    };
    put(gyro, &truth.rate);
    put(accel, &truth.force);
    put(gyro, &truth.rate_dot);
    put(true, std::slice::from_ref(&truth.temperature));
    block.columns.extend(run.biases());
    if truth.motion.is_empty() {
        return;
    }
    let mut motion = |of: &dyn Fn(&sagnac_nav::Motion) -> f64| {
        block.columns.push(truth.motion.iter().map(of).collect());
    };
    motion(&|m| m.latitude_rad.to_degrees());
    motion(&|m| m.longitude_rad.to_degrees());
    motion(&|m| m.height_m);
    for axis in 0..3 {
        motion(&|m| m.velocity_n[axis]);
    }
    for part in 0..4 {
        motion(&|m| m.quaternion[part]);
    }
    motion(&|m| m.roll_rad.to_degrees());
    motion(&|m| m.pitch_rad.to_degrees());
    motion(&|m| m.heading_rad.to_degrees());
}
