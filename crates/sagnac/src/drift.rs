//! `drift`: position error against time, and what causes it.
//!
//! ```
//! use sagnac::drift::{DriftRequest, drift};
//! use sagnac::nav::{Earth, Start, Trajectory};
//! let model = sagnac::model::Catalogue::embedded().find("HG9900")?;
//! let rest = Trajectory::named("rest", Earth::Wgs84, &Start::default())?;
//! let outcome = drift(&DriftRequest::new(&model, &rest))?;
//! assert_eq!(outcome.to_json()["cep_m"].as_array().map(Vec::len), Some(60));
//! # Ok::<(), sagnac::Error>(())
//! ```

mod recording;
mod recording_view;
mod view;

use std::sync::Arc;

use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_nav::Trajectory;
use sagnac_nav::drift::{Alignment, CovarianceDrift, Doubt, Scene, Setting};
use sagnac_nav::earth::STANDARD_GRAVITY_M_S2;
use sagnac_nav::ellipse::Sampled;
use sagnac_nav::monte_carlo::{MonteCarloDrift, Request, monte_carlo};
use sagnac_nav::sensor::Calibration;
use sagnac_nav::strapdown::{Sculling, Vertical};
use sagnac_report::text::general;
use serde_json::{Value, json};

use crate::Error;
use crate::motion::sensor_errors;

pub use recording::{RecordingOutcome, RecordingRequest, recording};
pub(crate) use view::length as length_text;

/// A temperature against time, °C.
pub type TemperatureOf = Arc<dyn Fn(f64) -> f64 + Send + Sync>;

/// Which of the two ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// The error covariance along the true trajectory.
    #[default]
    Covariance,
    /// Many runs of the whole sensor and strapdown.
    MonteCarlo,
}

/// What to predict.
#[derive(Clone)]
pub struct DriftRequest<'a> {
    /// The sensor.
    pub model: &'a Model,
    /// The motion.
    pub trajectory: &'a Trajectory,
    /// Length, s; the trajectory's default where absent.
    pub duration_s: Option<f64>,
    /// Sampling rate, Hz; the model's, else 100 Hz, where absent.
    pub rate_hz: Option<f64>,
    /// Covariance or Monte Carlo.
    pub method: Method,
    /// Start attitude.
    pub alignment: Alignment,
    /// What is corrected.
    pub calibration: Calibration,
    /// Vertical channel.
    pub vertical: Vertical,
    /// Form of the strapdown.
    pub sculling: Sculling,
    /// Temperature of the sensor; T0 where absent.
    pub temperature: Option<TemperatureOf>,
    /// Seed of the Monte Carlo.
    pub seed: u64,
    /// Runs of the Monte Carlo.
    pub runs: u32,
}

impl<'a> DriftRequest<'a> {
    /// The defaults of the command: covariance, perfect alignment, height held, 200 runs if a Monte Carlo is asked for.
    pub fn new(model: &'a Model, trajectory: &'a Trajectory) -> Self {
        Self {
            model,
            trajectory,
            duration_s: None,
            rate_hz: None,
            method: Method::default(),
            alignment: Alignment::Perfect,
            calibration: Calibration::Model,
            vertical: Vertical::Fixed,
            sculling: Sculling::Five,
            temperature: None,
            seed: 0,
            runs: 200,
        }
    }

    pub(crate) fn setting(&self) -> Setting {
        let rate_hz = self
            .rate_hz
            .or_else(|| self.model.sample_rate_hz())
            .unwrap_or(100.0);
        Setting {
            duration_s: self
                .duration_s
                .unwrap_or_else(|| self.trajectory.default_duration_s()),
            dt_s: 1.0 / rate_hz,
            vertical: self.vertical,
            alignment: self.alignment,
            calibration: self.calibration,
        }
    }

    pub(crate) fn temperature(&self) -> TemperatureOf {
        let reference = self.model.reference_temperature_c();
        self.temperature
            .clone()
            .unwrap_or_else(|| Arc::new(move |_| reference))
    }
}

/// What was predicted.
#[derive(Debug, Clone)]
pub struct DriftOutcome {
    /// The covariance and its budget, always.
    pub covariance: CovarianceDrift,
    /// The runs, where a Monte Carlo was asked for.
    pub monte_carlo: Option<MonteCarloDrift>,
    /// As asked.
    pub setting: Setting,
    /// Runs asked for.
    pub runs: u32,
    /// Kinds of noise and bias that the model lacks.
    pub missing: Vec<&'static str>,
    /// The sensor's name.
    pub sensor: String,
    /// The trajectory's name.
    pub trajectory: String,
    /// Whether the motion is rest.
    pub at_rest: bool,
    /// The start or rate that nothing stated: `--rate` by default.
    pub notes: Vec<String>,
    /// Values of the terms in the model, for people.
    pub values: Vec<(String, String)>,
    /// What the sensor does here that no covariance holds.
    pub doubts: Vec<Doubt>,
}

/// Predicts the drift.
///
/// # Errors
/// A duration or rate that is not possible, zero runs, a self-alignment that cannot work, a model that cannot be inverted.
pub fn drift(request: &DriftRequest<'_>) -> Result<DriftOutcome, Error> {
    drift_with_progress(request, &mut |_, _| {})
}

/// The same, telling how far the Monte Carlo is (done, total).
///
/// # Errors
/// As [`drift`].
pub fn drift_with_progress(
    request: &DriftRequest<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<DriftOutcome, Error> {
    if request.runs == 0 {
        return Err(
            Error::usage("0 runs tell nothing").advise("use --runs 200, or --method covariance")
        );
    }
    let setting = request.setting();
    let sensor = sensor_errors(request.model)?;
    let temperature = request.temperature();
    let scene = Scene::new(request.trajectory, setting, &*temperature)?;
    let covariance = scene.covariance(&sensor)?;
    let found = match request.method {
        Method::Covariance => None,
        Method::MonteCarlo => Some(monte_carlo(
            &Request {
                trajectory: request.trajectory,
                setting,
                sculling: request.sculling,
                sensor: &sensor,
                runs: request.runs,
                seed: request.seed,
            },
            &*temperature,
            progress,
        )?),
    };
    let mut notes = Vec::new();
    if request.rate_hz.is_none() && request.model.sample_rate_hz().is_none() {
        notes.push("the model has no sample_rate: 100 Hz is taken".to_owned());
    }
    let doubts = scene.doubts(&sensor, &covariance, setting.dt_s);
    let values = covariance
        .terms()
        .iter()
        .filter_map(|(term, ..)| {
            crate::motion::value_text(request.model, term).map(|v| (term.clone(), v))
        })
        .collect();
    Ok(DriftOutcome {
        covariance,
        monte_carlo: found,
        setting,
        runs: if request.method == Method::MonteCarlo {
            request.runs
        } else {
            0
        },
        missing: sensor.missing(),
        sensor: request.model.name().to_owned(),
        trajectory: request.trajectory.name().to_owned(),
        at_rest: request.trajectory.is_rest(),
        notes,
        values,
        doubts,
    })
}

/// A curve of the result with its interval.
#[derive(Debug, Clone, Default)]
pub(crate) struct Curve {
    pub(crate) value: Vec<f64>,
    pub(crate) interval: Vec<[Option<f64>; 2]>,
}

impl Curve {
    fn linear(value: Vec<f64>) -> Self {
        let interval = vec![[None, None]; value.len()];
        Self { value, interval }
    }

    fn sampled(of: &[Sampled]) -> Self {
        Self {
            value: of.iter().map(|s| s.value_m).collect(),
            interval: of.iter().map(|s| s.interval_m).collect(),
        }
    }
}

const AXES: [&str; 9] = [
    "north_m",
    "east_m",
    "down_m",
    "velocity_north_m_s",
    "velocity_east_m_s",
    "velocity_down_m_s",
    "tilt_north_rad",
    "tilt_east_rad",
    "heading_rad",
];

impl DriftOutcome {
    pub(crate) fn cep(&self) -> Curve {
        self.monte_carlo.as_ref().map_or_else(
            || Curve::linear(self.covariance.cep_m()),
            |m| Curve::sampled(&m.cep(0.025)),
        )
    }

    pub(crate) fn r95(&self) -> Curve {
        self.monte_carlo.as_ref().map_or_else(
            || Curve::linear(self.covariance.r95_m()),
            |m| Curve::sampled(&m.r95(0.025)),
        )
    }

    pub(crate) fn rms(&self) -> Curve {
        self.monte_carlo.as_ref().map_or_else(
            || Curve::linear(self.covariance.rms_m()),
            |m| Curve::sampled(&m.rms(1.96)),
        )
    }

    /// Whether the covariance is a good number.
    pub fn is_valid(&self) -> bool {
        self.invalid_because().is_empty()
    }

    /// Why the covariance is none.
    pub fn invalid_because(&self) -> Vec<String> {
        let mut out: Vec<String> = self.doubts.iter().map(doubt_text).collect();
        if !self.covariance.is_valid() {
            out.push("the errors leave the linear range (attitude beyond 0.1 rad or position beyond 100 km): the covariance is an order of magnitude only".to_owned());
        }
        out
    }

    /// Warnings for standard error.
    pub fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        out.extend(warning_of_missing(&self.missing));
        out.extend(self.invalid_because());
        if let Some(m) = &self.monte_carlo {
            if m.clipped > 0 {
                out.push(format!(
                    "{} values were cut off by the range",
                    sagnac_report::text::group_thousands(&m.clipped.to_string())
                ));
            }
            if m.outside_validity > 0 {
                out.push(format!(
                    "{} samples were outside the validity of the correction",
                    sagnac_report::text::group_thousands(&m.outside_validity.to_string())
                ));
            }
        }
        out
    }

    /// Terms that pay most: (term, share, CEP if halved ÷ CEP).
    pub fn improve_first(&self) -> Vec<(String, f64, f64)> {
        let cep = self.covariance.end().radius_m(0.5);
        self.covariance
            .terms()
            .into_iter()
            .filter(|(_, share, _)| *share > 0.0)
            .take(3)
            .map(|(term, share, _)| {
                let halved = self.covariance.cep_with_m(&term, 0.5);
                (term, share, if cep > 0.0 { halved / cep } else { 1.0 })
            })
            .collect()
    }

    /// `{"method", "time_s", "cep_m", "r95_m", "rms_m", "cep_ci_m", …}` of interfaces.md §4 and navigation.md §3.2.
    pub fn to_json(&self) -> Value {
        let (cep, r95, rms) = (self.cep(), self.r95(), self.rms());
        let intervals = |c: &Curve| -> Vec<Value> {
            c.interval
                .iter()
                .map(|i| {
                    if self.monte_carlo.is_some() {
                        json!(i)
                    } else {
                        Value::Null
                    }
                })
                .collect()
        };
        let axes: serde_json::Map<String, Value> = AXES
            .iter()
            .enumerate()
            .map(|(i, name)| {
                (
                    (*name).to_owned(),
                    json!(
                        self.monte_carlo
                            .as_ref()
                            .map_or_else(|| self.covariance.rms_of(i), |m| m.rms_of(i))
                    ),
                )
            })
            .collect();
        let end = cep.value.last().copied().unwrap_or(0.0);
        json!({
            "sensor": self.sensor,
            "trajectory": self.trajectory,
            "method": if self.monte_carlo.is_some() { "monte-carlo" } else { "covariance" },
            "duration_s": self.setting.duration_s,
            "rate_hz": 1.0 / self.setting.dt_s,
            "time_s": self.covariance.time_s,
            "cep_m": cep.value,
            "r95_m": r95.value,
            "rms_m": rms.value,
            "cep_ci_m": intervals(&cep),
            "r95_ci_m": intervals(&r95),
            "rms_ci_m": intervals(&rms),
            "covariance": { "cep_m": self.covariance.cep_m(), "r95_m": self.covariance.r95_m(), "rms_m": self.covariance.rms_m() },
            "nmi_per_h": end / 1852.0 / (self.setting.duration_s / 3600.0),
            "axes": axes,
            "budget": self.covariance.budget.iter().map(|e| json!({ "term": e.term, "axis": e.axis, "share": e.share })).collect::<Vec<_>>(),
            "improve_first": self.improve_first().iter().map(|(term, share, factor)| json!({ "term": term, "share": share, "cep_factor_if_halved": factor })).collect::<Vec<_>>(),
            "runs": if self.monte_carlo.is_some() { json!(self.runs) } else { Value::Null },
            "alignment": alignment_json(&self.setting.alignment),
            "vertical": vertical_key(self.setting.vertical),
            "calibration": calibration_key(self.setting.calibration),
            "valid": self.is_valid(),
            "invalid_because": self.invalid_because(),
            "missing": self.missing,
            "clipped": self.monte_carlo.as_ref().map_or(0, |m| m.clipped),
            "warnings": self.warnings(),
        })
    }
}

/// A rate or a force with its unit.
fn output_text(sensor: Sensor, value: f64) -> String {
    match sensor {
        Sensor::Gyro => format!("{} deg/s", general(value.to_degrees(), 3)),
        Sensor::Accel => format!("{} g", general(value / STANDARD_GRAVITY_M_S2, 3)),
    }
}

/// A doubt as a warning.
pub(crate) fn doubt_text(doubt: &Doubt) -> String {
    match *doubt {
        Doubt::Clipped {
            sensor,
            axis,
            reaches,
            time_s,
            limit,
        } => format!(
            "the motion asks {} of {} {} at {} s, beyond its range of {}: the covariance does not know what is cut off, drift --method monte-carlo does",
            output_text(sensor, reaches),
            sensor.name(),
            axis.key(),
            general(time_s, 4),
            output_text(sensor, limit)
        ),
        Doubt::Sticks {
            sensor,
            axis,
            step,
            noise,
        } => format!(
            "the steps of {} {}, {}, are too coarse for its noise of {} steps (1 sigma, 0.35 are needed): the output sticks, and the covariance takes rounding for white noise; drift --method monte-carlo rounds",
            sensor.name(),
            axis.key(),
            output_text(sensor, step),
            general(noise, 2)
        ),
    }
}

/// What a model lacks that a drift needs, as a warning.
pub(crate) fn warning_of_missing(missing: &[&str]) -> Option<String> {
    let words: Vec<&str> = missing.iter().map(|key| describe_missing(key)).collect();
    (!words.is_empty()).then(|| {
        format!(
            "the model lacks {}: a term that is absent counts as zero, which no sensor has",
            words.join(", ")
        )
    })
}

fn describe_missing(key: &str) -> &'static str {
    match key {
        "gyro.noise" => "the gyro's white noise",
        "gyro.bias" => "every bias term of the gyro",
        "accel.noise" => "the accelerometer's white noise",
        _ => "every bias term of the accelerometer",
    }
}

pub(crate) fn alignment_json(alignment: &Alignment) -> Value {
    match alignment {
        Alignment::Perfect => json!("perfect"),
        Alignment::SelfAligned => json!("self"),
        Alignment::Given {
            roll_rad,
            pitch_rad,
            heading_rad,
        } => json!({ "roll_rad": roll_rad, "pitch_rad": pitch_rad, "heading_rad": heading_rad }),
    }
}

pub(crate) fn vertical_key(vertical: Vertical) -> &'static str {
    match vertical {
        Vertical::Fixed => "fixed",
        Vertical::Free => "free",
        Vertical::Baro => "baro",
    }
}

pub(crate) fn calibration_key(calibration: Calibration) -> &'static str {
    match calibration {
        Calibration::Model => "model",
        Calibration::Perfect => "perfect",
        Calibration::None => "none",
    }
}
