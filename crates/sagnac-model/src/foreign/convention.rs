//! What each tool's numbers mean: quantity, sensor, and the rule from the number as written to SI.

use super::flat::Flat;
use crate::error::Error;
use crate::export::Format;
use crate::units::{Dimension, Unit};
use sagnac_core::Sensor;

/// What a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// N, two-sided.
    White,
    /// K.
    Walk,
    /// σ of a correlated in-run bias.
    BiasSigma,
    /// 1σ of the run-to-run bias.
    RunToRun,
    /// The floor of the Allan deviation.
    AllanMinimum,
    /// The coefficient B.
    Coefficient,
    /// A constant bias.
    FixedBias,
}

impl Quantity {
    /// As in JSON.
    pub const fn key(self) -> &'static str {
        match self {
            Self::White => "white_noise",
            Self::Walk => "random_walk",
            Self::BiasSigma => "bias_sigma",
            Self::RunToRun => "bias_stability",
            Self::AllanMinimum => "allan_minimum",
            Self::Coefficient => "bias_instability",
            Self::FixedBias => "bias",
        }
    }

    /// The dimension for a sensor.
    pub const fn dimension(self, sensor: Sensor) -> Dimension {
        match (self, sensor) {
            (Self::White, Sensor::Gyro) => Dimension::ANGLE_RANDOM_WALK,
            (Self::White, Sensor::Accel) => Dimension::VELOCITY_RANDOM_WALK,
            (Self::Walk, Sensor::Gyro) => Dimension::RATE_RANDOM_WALK,
            (Self::Walk, Sensor::Accel) => Dimension::ACCELERATION_RANDOM_WALK,
            (_, Sensor::Gyro) => Dimension::ANGULAR_RATE,
            (_, Sensor::Accel) => Dimension::ACCELERATION,
        }
    }
}

/// The rule from a number as written to SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// Times a factor.
    Times(f64),
    /// Over √(n·f).
    PerSample(f64),
    /// √(value/f): the variance of a sample.
    SampleVariance,
    /// √value: a continuous-time covariance.
    Variance,
    /// A drive: σ = value·√(T_c/2).
    Drive(f64),
}

impl Rule {
    /// SI of a number as written; none without the rate that it needs.
    pub(crate) fn meaning(self, value: f64, rate_hz: Option<f64>) -> Option<f64> {
        Some(match self {
            Self::Times(factor) => value * factor,
            Self::PerSample(times) => value / (times * rate_hz?).sqrt(),
            Self::SampleVariance => signed_root(value / rate_hz?),
            Self::Variance => signed_root(value),
            Self::Drive(time_s) => value * (time_s / 2.0).sqrt(),
        })
    }

    /// The number to write for a value in SI.
    pub(crate) fn written(self, meaning: f64, rate_hz: Option<f64>) -> Option<f64> {
        Some(match self {
            Self::Times(factor) => meaning / factor,
            Self::PerSample(times) => meaning * (times * rate_hz?).sqrt(),
            Self::SampleVariance => meaning * meaning * rate_hz?,
            Self::Variance => meaning * meaning,
            Self::Drive(time_s) => meaning / (time_s / 2.0).sqrt(),
        })
    }
}

/// The root, negative of a negative variance: no sensor has that.
fn signed_root(variance: f64) -> f64 {
    variance.abs().sqrt().copysign(variance)
}

/// One number of a file and what it means.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) key: String,
    pub(crate) sensor: Sensor,
    /// The axis, where the file has one for each.
    pub(crate) axis: Option<usize>,
    pub(crate) quantity: Quantity,
    pub(crate) value: f64,
    pub(crate) rule: Rule,
    pub(crate) convention: &'static str,
    /// Correlation time of a bias sigma [s].
    pub(crate) time_s: Option<f64>,
    /// Its place in the flat list, and which number.
    pub(crate) place: (usize, usize),
}

/// A file understood: its format, rate and numbers.
#[derive(Debug, Clone)]
pub(crate) struct Foreign {
    pub(crate) format: Format,
    /// Another format that the file fits as well.
    pub(crate) also: Option<Format>,
    pub(crate) rate_hz: Option<f64>,
    pub(crate) flat: Flat,
    pub(crate) readings: Vec<Reading>,
    /// What the tool lacks or would not read, and what of the file is not read here.
    pub(crate) notes: Vec<String>,
}

/// The formats that a file fits, in the order in which they are tried.
fn fitting(text: Option<&str>, bytes: &[u8]) -> Vec<(Format, Flat)> {
    let Some(text) = text else {
        let fields = crate::export::read_mat(bytes);
        return fields
            .map(|fields| (Format::NaveGo, super::flat::fields(fields)))
            .into_iter()
            .filter(|(_, flat)| flat.has("arw") || flat.has("vrw"))
            .collect();
    };
    Format::ALL
        .into_iter()
        .filter(|format| hint(*format, text))
        .map(|format| (format, parse(format, text)))
        .filter(|(format, flat)| fits(*format, flat))
        .collect()
}

/// A quick look before parsing.
fn hint(format: Format, text: &str) -> bool {
    match format {
        Format::Gtsam => text.contains("Preintegration"),
        Format::Matlab => text.contains("gyroparams") || text.contains("accelparams"),
        Format::Pyins => text.contains("EstimationModel") || text.contains("Parameters("),
        Format::Gazebo => text.contains("<imu>"),
        Format::Basalt => text.trim_start().starts_with('{'),
        Format::NaveGo => false,
        _ => true,
    }
}

pub(crate) fn parse(format: Format, text: &str) -> Flat {
    match format {
        Format::Basalt => super::flat::assignments(text, &[]),
        Format::Gtsam => super::expression::gtsam(text),
        Format::GnssInsSim | Format::Pyins => super::flat::assignments(text, &['#']),
        Format::Matlab => super::flat::assignments(text, &['%']),
        Format::Gazebo => super::flat::xml(text),
        Format::Px4 | Format::ArduPilot => super::flat::parameters(text),
        _ => super::flat::yaml(text),
    }
}

fn fits(format: Format, flat: &Flat) -> bool {
    let any = |keys: &[&str]| keys.iter().any(|key| flat.has(key));
    let begins = |start: &str| flat.items.iter().any(|item| item.key.starts_with(start));
    let kalibr = any(&["accelerometer_noise_density", "gyroscope_noise_density"]);
    match format {
        Format::Kalibr => kalibr && !any(&["T_BS", "imu_bias_init_sigma", "rate_hz"]),
        Format::KalibrResult => {
            any(&[
                "imu0.accelerometer_noise_density",
                "imu0.gyroscope_noise_density",
            ]) && !any(&["imu0.Tw", "imu0.Ta"])
        }
        Format::OpenVins => {
            any(&[
                "imu0.accelerometer_noise_density",
                "imu0.gyroscope_noise_density",
            ]) && !any(&["imu0.accelerometers", "imu0.gyroscopes"])
        }
        Format::Kimera => kalibr && !flat.has("update_rate"),
        Format::Vins => any(&["acc_n", "gyr_n"]),
        Format::OrbSlam3 => any(&["IMU.NoiseGyro", "IMU.NoiseAcc"]),
        Format::Gtsam => !flat.items.is_empty() || !flat.problems.is_empty(),
        Format::Basalt => any(&["accel_noise_std", "gyro_noise_std"]),
        Format::RosImu => any(&[
            "angular_velocity_covariance",
            "linear_acceleration_covariance",
        ]),
        Format::Gazebo => flat.items.iter().any(|item| item.key.contains(".noise.")),
        Format::Matlab => any(&["gyro.NoiseDensity", "accel.NoiseDensity", "gyro", "accel"]),
        Format::Px4 => begins("CAL_ACC") || begins("CAL_GYRO") || begins("TC_A") || begins("TC_G"),
        Format::ArduPilot => begins("INS_"),
        Format::ImuUtils => begins("Gyr.") || begins("Acc."),
        Format::GnssInsSim => any(&["gyro_arw", "accel_vrw"]),
        Format::NaveGo => any(&["arw", "vrw"]),
        Format::Pyins => any(&[
            "gyro_model.noise",
            "accel_model.noise",
            "gyro_parameters.noise",
            "accel_parameters.noise",
        ]),
        Format::KfGins => any(&["imunoise.arw", "imunoise.vrw"]),
    }
}

/// Reads a file of another tool.
pub(crate) fn read(bytes: &[u8], label: &str, wanted: Option<Format>) -> Result<Foreign, Error> {
    let refuse = |what: String, advice: &str| Error::File {
        what,
        place: label.to_string(),
        advice: Some(advice.to_string()),
    };
    if bytes.len() > super::flat::LONGEST {
        return Err(refuse(
            format!("a file of {} MB is no configuration", bytes.len() >> 20),
            "name the configuration of the tool, not a log",
        ));
    }
    let binary = bytes.get(126..128) == Some(b"IM");
    let text = if binary {
        None
    } else {
        std::str::from_utf8(bytes).ok()
    };
    let (format, flat, also) = if let Some(format) = wanted {
        let flat = match (format.is_text(), text) {
            (true, Some(text)) => parse(format, text),
            (false, _) => crate::export::read_mat(bytes)
                .map(super::flat::fields)
                .unwrap_or_default(),
            _ => Flat::default(),
        };
        (format, flat, None)
    } else {
        let mut found = fitting(text, bytes).into_iter();
        let names = Format::ALL.map(Format::name).join(", ");
        let Some((format, flat)) = found.next() else {
            return Err(refuse(
                "the file is of no format that is known".into(),
                &format!("name it with --from: {names}"),
            ));
        };
        (format, flat, found.next().map(|(format, _)| format))
    };
    let rate_hz = rate(format, &flat).filter(|rate| *rate > 0.0);
    let (readings, problems) = super::readings::of(format, &flat);
    if let Some(problem) = problems.into_iter().min_by_key(|problem| problem.start) {
        let before = text.and_then(|text| text.get(..problem.start));
        let line = before.map_or(1, |before| before.matches('\n').count() + 1);
        return Err(Error::File {
            what: problem.what,
            place: format!("{label}:{line}"),
            advice: Some(problem.advice.to_string()),
        });
    }
    if readings.is_empty() && !matches!(format, Format::Px4 | Format::ArduPilot) {
        return Err(refuse(
            format!("the file has no number of a {}", format.title()),
            "is it the right file, and the right --from?",
        ));
    }
    Ok(Foreign {
        format,
        also,
        rate_hz,
        notes: super::notes::of(format, &flat),
        flat,
        readings,
    })
}

/// Where a format says its rate.
pub(super) fn rate_keys(format: Format) -> &'static [&'static str] {
    match format {
        Format::Kalibr => &["update_rate"],
        Format::KalibrResult | Format::OpenVins => &["imu0.update_rate"],
        Format::OrbSlam3 => &["IMU.Frequency"],
        Format::Kimera => &["rate_hz"],
        Format::Basalt => &["imu_update_rate"],
        Format::Matlab => &["SampleRate", "IMU.SampleRate"],
        Format::NaveGo => &["freq"],
        _ => &[],
    }
}

fn rate(format: Format, flat: &Flat) -> Option<f64> {
    if format == Format::Gazebo {
        let item = flat
            .items
            .iter()
            .find(|item| item.key.ends_with("update_rate"))?;
        return item.numbers.first().copied();
    }
    rate_keys(format).iter().find_map(|key| flat.one(key))
}

pub(crate) fn factor(unit: &str) -> f64 {
    Unit::parse(unit).map_or(1.0, |unit| unit.factor())
}
