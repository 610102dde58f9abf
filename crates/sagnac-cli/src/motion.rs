//! The options of a motion, shared by `drift`, `strapdown` and `budget`: trajectory, start, alignment, temperature.

use std::path::Path;
use std::sync::Arc;

use clap::ValueEnum;
use sagnac::Error;
use sagnac::drift::TemperatureOf;
use sagnac::log::{Log, ReadOptions};
use sagnac::model::units::Dimension;
use sagnac::nav::drift::Alignment;
use sagnac::nav::sensor::Calibration;
use sagnac::nav::trajectory::NAMES;
use sagnac::nav::{Earth, Start, Trajectory, strapdown};
use sagnac::simulate::TemperatureProfile;

use crate::context::Context;
use crate::inputs;
use crate::quantities::{optional, positive, quantity};

/// Where it starts.
#[derive(clap::Args, Clone, Default)]
#[command(next_help_heading = "The start")]
pub(crate) struct StartOptions {
    /// Latitude [default: 45deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    latitude: Option<String>,
    /// Longitude [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    longitude: Option<String>,
    /// Height [default: 0m]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    height: Option<String>,
    /// Heading [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    heading: Option<String>,
    /// Roll, at rest only [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    roll: Option<String>,
    /// Pitch, at rest only [default: 0deg]
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    pitch: Option<String>,
    /// The rotating ellipsoid, or a sphere that stands still
    #[arg(long, value_enum, default_value_t = EarthOption::Wgs84, value_name = "wgs84|sphere", hide_possible_values = true)]
    earth: EarthOption,
}

/// `--earth`.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum EarthOption {
    /// WGS 84.
    #[default]
    Wgs84,
    /// A sphere at rest.
    Sphere,
}

impl StartOptions {
    /// The start.
    pub(crate) fn start(&self) -> Result<Start, Error> {
        let base = Start::default();
        let get = |option: &str, text: &Option<String>, dimension, default: f64| {
            Ok::<f64, Error>(optional(option, text.as_deref(), dimension)?.unwrap_or(default))
        };
        Ok(Start {
            latitude_rad: get(
                "--latitude",
                &self.latitude,
                Dimension::ANGLE,
                base.latitude_rad,
            )?,
            longitude_rad: get("--longitude", &self.longitude, Dimension::ANGLE, 0.0)?,
            height_m: get("--height", &self.height, Dimension::LENGTH, 0.0)?,
            heading_rad: get("--heading", &self.heading, Dimension::ANGLE, 0.0)?,
            roll_rad: get("--roll", &self.roll, Dimension::ANGLE, 0.0)?,
            pitch_rad: get("--pitch", &self.pitch, Dimension::ANGLE, 0.0)?,
        })
    }

    /// The options that were given.
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

    /// The Earth.
    pub(crate) fn earth(&self) -> Earth {
        match self.earth {
            EarthOption::Wgs84 => Earth::Wgs84,
            EarthOption::Sphere => Earth::Sphere,
        }
    }
}

/// How a file of way-points or a reference is read.
#[derive(clap::Args, Clone, Default)]
#[command(next_help_heading = "Reading a path or reference")]
pub(crate) struct ReferenceOptions {
    /// What its columns are: 'position=opt_pos:m, quaternion=opt_quat'
    #[arg(long, value_name = "LIST")]
    reference_columns: Option<String>,
    /// Its rate, where it has no time
    #[arg(long, value_name = "RATE")]
    reference_rate: Option<String>,
}

impl ReferenceOptions {
    /// The first that was given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        if self.reference_columns.is_some() {
            Some("--reference-columns")
        } else {
            self.reference_rate.as_ref().map(|_| "--reference-rate")
        }
    }

    /// Refuses them where no file is read with them.
    pub(crate) fn refuse(&self) -> Result<(), Error> {
        match self.given() {
            Some(option) => Err(Error::usage(format!(
                "{option} says how a file of way-points is read"
            ))
            .at(option)
            .advise(format!(
                "leave {option} out, or name the file with --trajectory"
            ))),
            None => Ok(()),
        }
    }

    /// Reads it.
    pub(crate) fn read(&self, path: &Path) -> Result<Log, Error> {
        let rate_hz = self
            .reference_rate
            .as_deref()
            .map(|text| positive("--reference-rate", text, Dimension::FREQUENCY))
            .transpose()?;
        let options = ReadOptions {
            columns: self.reference_columns.clone(),
            rate_hz,
            threads: rayon::current_num_threads(),
            ..ReadOptions::default()
        };
        if path.is_file() && self.reference_columns.is_none() && is_ground_truth(path) {
            // EuRoC ground truth: the same columns under the names of a path.
            let text = inputs::text(path)?;
            let rest = text.split_once('\n').map_or("", |(_, rest)| rest);
            let names: Vec<String> = text
                .lines()
                .next()
                .unwrap_or_default()
                .trim_start_matches('#')
                .split(',')
                .map(own_name)
                .collect();
            let renamed = format!("{}\n{rest}", names.join(","));
            let source =
                sagnac::log::Source::memory(path.display().to_string(), renamed.into_bytes());
            return Ok(sagnac::log::read(source, &options)?);
        }
        let (source, _) = inputs::source(path)?;
        sagnac::log::read(source, &options).map_err(|error| of_reference(&error.into()))
    }
}

/// Refuses options of the start that a path from a file sets itself.
pub(crate) fn refuse_start(given: &[&'static str], log: &Log, name: &str) -> Result<(), Error> {
    let is_local = log.layout.index("latitude").is_none();
    let sets_place = ["--latitude", "--longitude", "--height"];
    match given
        .iter()
        .find(|option| !(is_local && sets_place.contains(*option)))
    {
        Some(option) => Err(Error::usage(format!(
            "{option} has no meaning with {name}, which has {}",
            if sets_place.contains(option) {
                "its own latitude, longitude and height"
            } else {
                "its own course and attitude"
            }
        ))
        .at(*option)
        .advise(format!("leave {option} out"))),
        None => Ok(()),
    }
}

/// An error of reading a log, with the options and roles of a path.
fn of_reference(error: &Error) -> Error {
    Error {
        kind: error.kind,
        what: of_a_path(&error.what),
        place: error.place.as_deref().map(of_a_path),
        advice: error.advice.as_deref().map(of_a_path),
        found: error.found.clone(),
    }
}

/// Words about a log's options as words about a path's.
fn of_a_path(text: &str) -> String {
    text.replace(
        "time=0:s, gyro=1,2,3:deg/s, accel=4,5,6:g",
        "time=0:s, position=1,2,3:m, quaternion=4,5,6,7",
    )
    .replace("--columns", "--reference-columns")
    .replace("--rate", "--reference-rate")
    .replace(
        "time, gyro, accel, gyro_rate, temperature, angle, speed, and one axis of them as gyro_x",
        "time, latitude, longitude, height, position, quaternion, roll, pitch, heading, and one axis of them as position_x",
    )
}

/// Whether the first line names the columns of EuRoC ground truth.
fn is_ground_truth(path: &Path) -> bool {
    use std::io::Read as _;
    let mut head = [0; 512];
    std::fs::File::open(path)
        .and_then(|mut file| file.read(&mut head))
        .is_ok_and(|n| {
            head[..n]
                .split(|b| *b == b'\n')
                .next()
                .is_some_and(|line| String::from_utf8_lossy(line).contains("p_RS_R_x"))
        })
}

/// `p_RS_R_x [m]` as `position_x [m]`, `q_RS_w []` as `quaternion_w`, `timestamp [ns]` as `time [ns]`.
fn own_name(column: &str) -> String {
    let column = column.trim();
    let name = column.split([' ', '[']).next().unwrap_or_default();
    match name {
        "timestamp" => "time [ns]".to_owned(),
        _ => match (name.strip_prefix("p_RS_R_"), name.strip_prefix("q_RS_")) {
            (Some(axis), _) => format!("position_{axis} [m]"),
            (_, Some(part)) => format!("quaternion_{part}"),
            _ => column.to_owned(),
        },
    }
}

/// A word that can only be a file's name, but there is no such file.
pub(crate) fn missing_path(name: &str) -> Option<Error> {
    let is_name = !name.contains(['/', '\\', '.']);
    (!is_name && !Path::new(name).exists()).then(|| {
        Error::data(format!("there is no file {name}"))
            .at(format!("--trajectory {name}"))
            .advise(format!(
                "check its name, or choose one of {}",
                NAMES.join(", ")
            ))
    })
}

/// The error of a named trajectory, at the option of the start that is wrong, else at its name.
pub(crate) fn named_error(error: sagnac::nav::Error, name: &str) -> Error {
    let error = Error::from(error);
    match error.place {
        Some(_) => error,
        None => error.at(format!("--trajectory {name}")),
    }
}

/// A named trajectory, or a file.
pub(crate) fn trajectory(
    name: &str,
    start: &StartOptions,
    reference: &ReferenceOptions,
    context: &Context,
) -> Result<Trajectory, Error> {
    let at = start.start()?;
    if let Some(error) = missing_path(name) {
        return Err(error);
    }
    if NAMES.contains(&name) || !Path::new(name).exists() {
        reference.refuse()?;
        return Trajectory::named(name, start.earth(), &at).map_err(|e| named_error(e, name));
    }
    let log = reference.read(Path::new(name))?;
    refuse_start(&start.given(), &log, name)?;
    let (trajectory, left_out) = sagnac::path::trajectory_of_log(&log, name, start.earth(), &at)?;
    if let Some(sentence) = left_out {
        context.warn(&sentence);
    }
    Ok(trajectory)
}

/// `--vertical`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Vertical {
    /// Height and down velocity are the truth's.
    Fixed,
    /// Nothing holds it.
    Free,
    /// A barometric loop.
    Baro,
}

impl From<Vertical> for strapdown::Vertical {
    fn from(v: Vertical) -> Self {
        match v {
            Vertical::Fixed => Self::Fixed,
            Vertical::Free => Self::Free,
            Vertical::Baro => Self::Baro,
        }
    }
}

/// `--sculling`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sculling {
    /// Two samples.
    Two,
    /// Five samples.
    Five,
}

impl From<Sculling> for strapdown::Sculling {
    fn from(s: Sculling) -> Self {
        match s {
            Sculling::Two => Self::Two,
            Sculling::Five => Self::Five,
        }
    }
}

/// `--calibration`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CalibrationOption {
    /// The model corrects.
    Model,
    /// Without its uncertainty.
    Perfect,
    /// Nothing corrects.
    None,
}

/// The error of an option that a recording settles itself.
fn beside_recording(option: &str, why: &str) -> Error {
    Error::usage(format!("{option} has no meaning with --log: {why}"))
        .at(option.to_owned())
        .advise(format!("leave {option} out, or leave out --log"))
}

/// Refuses the first option that was given: (option, whether it was, why a recording settles it).
pub(crate) fn refuse_first(options: &[(&str, bool, &str)]) -> Result<(), Error> {
    match options.iter().find(|(_, given, _)| *given) {
        Some((option, _, why)) => Err(beside_recording(option, why)),
        None => Ok(()),
    }
}

/// What `drift` and `budget` share.
#[derive(clap::Args, Clone)]
#[command(next_help_heading = "The run")]
pub(crate) struct RunOptions {
    /// A name (rest, turn, coning, figure-eight, drive, flight, walking, rocket), or a file
    #[arg(long, value_name = "NAME|F")]
    trajectory: Option<String>,
    /// Start attitude: perfect, self, or 'roll=0.1deg, pitch=0.1deg, heading=1deg' [default: perfect]
    #[arg(long, value_name = "HOW")]
    alignment: Option<String>,
    /// What is taken out before [default: model]
    #[arg(
        long,
        value_enum,
        value_name = "model|perfect|none",
        hide_possible_values = true
    )]
    calibration: Option<CalibrationOption>,
    /// What holds the height [default: fixed]
    #[arg(
        long,
        value_enum,
        value_name = "fixed|free|baro",
        hide_possible_values = true
    )]
    vertical: Option<Vertical>,
    /// Samples in the coning and sculling terms [default: five]
    #[arg(long, value_enum, value_name = "two|five", hide_possible_values = true)]
    sculling: Option<Sculling>,
    /// '40 degC', 'ramp 20 degC 60 degC', 'cycle -20 degC 70 degC 2 h', or a file with time and temperature
    #[arg(long, value_name = "PROFILE", allow_hyphen_values = true)]
    temperature: Option<String>,
    #[command(flatten)]
    pub(crate) start: StartOptions,
    #[command(flatten)]
    pub(crate) reference: ReferenceOptions,
}

impl RunOptions {
    /// The motion.
    pub(crate) fn trajectory(&self, context: &Context) -> Result<Trajectory, Error> {
        let name = self.trajectory.as_deref().unwrap_or("rest");
        trajectory(name, &self.start, &self.reference, context)
    }

    /// What holds the height.
    pub(crate) fn vertical(&self) -> strapdown::Vertical {
        self.vertical.unwrap_or(Vertical::Fixed).into()
    }

    /// Samples in the coning and sculling terms.
    pub(crate) fn sculling(&self) -> strapdown::Sculling {
        self.sculling.unwrap_or(Sculling::Five).into()
    }

    /// Refuses what a recording settles itself: its reference is the path and the start, it is integrated with five
    /// samples and a free height, and shown both as recorded and corrected (navigation.md §3.6).
    pub(crate) fn refuse_beside_recording(&self) -> Result<(), Error> {
        let settled = [
            (
                "--trajectory",
                self.trajectory.is_some(),
                "the recording has its own path, its --reference",
            ),
            (
                "--alignment",
                self.alignment
                    .as_deref()
                    .is_some_and(|how| how != "perfect"),
                "a recording starts from the attitude of its --reference",
            ),
            (
                "--calibration",
                !matches!(self.calibration, None | Some(CalibrationOption::Model)),
                "a recording is shown both as recorded and as corrected by the model",
            ),
            (
                "--vertical",
                !matches!(self.vertical, None | Some(Vertical::Free)),
                "a recording is integrated with the height free",
            ),
            (
                "--sculling",
                self.sculling == Some(Sculling::Two),
                "a recording is integrated with five samples",
            ),
            (
                "--temperature",
                self.temperature.is_some(),
                "a recording has its own temperature, the log's",
            ),
        ];
        refuse_first(&settled)?;
        let own_attitude = ["--heading", "--roll", "--pitch"];
        match self.start.given().iter().find(|o| own_attitude.contains(o)) {
            Some(option) => Err(beside_recording(
                option,
                "a recording starts from the attitude of its --reference",
            )),
            None => Ok(()),
        }
    }

    /// What is corrected.
    pub(crate) fn calibration(&self) -> Calibration {
        match self.calibration {
            None | Some(CalibrationOption::Model) => Calibration::Model,
            Some(CalibrationOption::Perfect) => Calibration::Perfect,
            Some(CalibrationOption::None) => Calibration::None,
        }
    }

    /// The start attitude.
    pub(crate) fn alignment(&self) -> Result<Alignment, Error> {
        let text = self.alignment.as_deref().unwrap_or("perfect");
        match text {
            "perfect" => return Ok(Alignment::Perfect),
            "self" => return Ok(Alignment::SelfAligned),
            _ => {}
        }
        let mut angles = [0.0; 3];
        for part in text.split(',') {
            let wrong = || {
                Error::usage(format!("\"{}\" is no alignment", part.trim()))
                    .at(format!("--alignment {text}"))
                    .advise("write perfect, self, or 'roll=0.1deg, pitch=0.1deg, heading=1deg'")
            };
            let (name, value) = part.split_once('=').ok_or_else(wrong)?;
            let place = ["roll", "pitch", "heading"]
                .iter()
                .position(|n| *n == name.trim())
                .ok_or_else(wrong)?;
            angles[place] = quantity("--alignment", value.trim(), Dimension::ANGLE)?;
            if angles[place] < 0.0 {
                return Err(wrong());
            }
        }
        let [roll_rad, pitch_rad, heading_rad] = angles;
        Ok(Alignment::Given {
            roll_rad,
            pitch_rad,
            heading_rad,
        })
    }

    /// T(t) of a run of this length.
    pub(crate) fn temperature(&self, duration_s: f64) -> Result<Option<TemperatureOf>, Error> {
        let Some(text) = self.temperature.as_deref() else {
            return Ok(None);
        };
        let profile = temperature_profile(text)?;
        Ok(Some(Arc::new(move |t| profile.mean_c(t, t, duration_s))))
    }
}

/// `--temperature`: words, or the name of a file.
pub(crate) fn temperature_profile(text: &str) -> Result<TemperatureProfile, Error> {
    let error = match TemperatureProfile::parse(text) {
        Ok(profile) => return Ok(profile),
        Err(error) => error,
    };
    let path = Path::new(text);
    if !path.is_file() && path.extension().is_some() && !text.contains(' ') {
        return Err(
            Error::data("the temperature profile cannot be read: there is no such file")
                .at(format!("--temperature {text}"))
                .advise("look for the file's name, or write '40 degC', 'ramp 20 degC 60 degC'"),
        );
    }
    if !path.is_file() {
        return Err(error.at(format!("--temperature {text}")).advise(
            "write '40 degC', 'ramp 20 degC 60 degC', 'cycle -20 degC 70 degC 2 h' or the name of a file",
        ));
    }
    let (source, _) = inputs::source(path)?;
    let log = sagnac::log::read(source, &ReadOptions::default())?;
    let Some(values) = log.channel("temperature") else {
        return Err(Error::data("the file has no column `temperature`")
            .at(text)
            .advise("its header should be: time [s],temperature [degC]"));
    };
    let time_s: Vec<f64> = (0..log.rows)
        .map(|k| {
            log.stamps
                .get(k)
                .map_or_else(|| log.time_s(k), sagnac::log::Stamp::seconds)
        })
        .collect();
    if let Some(row) = values.iter().position(|value| *value < -273.15) {
        return Err(
            Error::data(format!("{} degC is below absolute zero", values[row]))
                .at(format!("{text}, row {}", row + 1)),
        );
    }
    if let Some(row) = values.iter().position(|value| !value.is_finite()) {
        return Err(Error::data("a temperature is not a finite number")
            .at(format!("{text}, row {}", row + 1)));
    }
    if let Some(row) = time_s
        .windows(2)
        .position(|pair| pair[1].partial_cmp(&pair[0]) != Some(std::cmp::Ordering::Greater))
    {
        return Err(
            Error::data("the times of a temperature profile must increase")
                .at(format!("{text}, row {}", row + 2)),
        );
    }
    Ok(TemperatureProfile::Table {
        time_s,
        temperature_c: values.to_vec(),
    })
}
