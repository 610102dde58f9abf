//! `budget`, and `catalog search`: which sensors, and which parameter values, meet a drift requirement (navigation.md §5).
//!
//! ```
//! use sagnac::budget::{BudgetRequest, Figure, budget};
//! use sagnac::model::Catalogue;
//! use sagnac::nav::{Earth, Start, Trajectory};
//! let rest = Trajectory::named("rest", Earth::Wgs84, &Start::default())?;
//! let catalogue = Catalogue::embedded();
//! let outcome = budget(&BudgetRequest::new(&catalogue, &rest, Figure::Cep, 1000.0, 600.0))?;
//! assert!(outcome.met_by.iter().any(|s| s.sensor == "HG9900"));
//! # Ok::<(), sagnac::Error>(())
//! ```

mod view;

use rayon::prelude::*;
use sagnac_core::{Axis, Element, Sensor};
use sagnac_model::catalogue::price_class;
use sagnac_model::{Catalogue, Model};
use sagnac_nav::Trajectory;
use sagnac_nav::covariance::{Kind, Parameter, Process, report_times_s};
use sagnac_nav::drift::{Alignment, Scene, Setting};
use sagnac_nav::ellipse::Horizontal;
use sagnac_nav::sensor::Calibration;
use sagnac_nav::strapdown::{Sculling, Vertical};

use crate::Error;
use crate::drift::{DriftRequest, Method, TemperatureOf, drift_with_progress};
use crate::motion::sensor_errors;

/// Which figure is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Half of all sensors within it.
    Cep,
    /// 95 % within it.
    R95,
}

impl Figure {
    const fn part(self) -> f64 {
        match self {
            Self::Cep => 0.5,
            Self::R95 => 0.95,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Cep => "CEP",
            Self::R95 => "R95",
        }
    }
}

/// A requirement.
#[derive(Clone)]
pub struct BudgetRequest<'a> {
    /// Sensors to choose from.
    pub catalogue: &'a Catalogue,
    /// A sensor whose parameters are asked for.
    pub model: Option<&'a Model>,
    /// The motion.
    pub trajectory: &'a Trajectory,
    /// CEP or R95.
    pub figure: Figure,
    /// The limit, m.
    pub limit_m: f64,
    /// When, s.
    pub after_s: f64,
    /// Sampling rate, Hz, of all; else each model's own.
    pub rate_hz: Option<f64>,
    /// Start attitude.
    pub alignment: Alignment,
    /// What is corrected.
    pub calibration: Calibration,
    /// Vertical channel.
    pub vertical: Vertical,
    /// Form of the strapdown, for `--confirm`.
    pub sculling: Sculling,
    /// Temperature; each model's T0 where absent.
    pub temperature: Option<TemperatureOf>,
    /// Whether the Monte Carlo checks the first three: runs and seed.
    pub confirm: Option<(u32, u64)>,
}

impl<'a> BudgetRequest<'a> {
    /// With the defaults of `drift`.
    pub fn new(
        catalogue: &'a Catalogue,
        trajectory: &'a Trajectory,
        figure: Figure,
        limit_m: f64,
        after_s: f64,
    ) -> Self {
        Self {
            catalogue,
            model: None,
            trajectory,
            figure,
            limit_m,
            after_s,
            rate_hz: None,
            alignment: Alignment::Perfect,
            calibration: Calibration::Model,
            vertical: Vertical::Fixed,
            sculling: Sculling::Five,
            temperature: None,
            confirm: None,
        }
    }
}

/// A sensor with its drift.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub sensor: String,
    /// CEP, m.
    pub cep_m: f64,
    /// R95, m.
    pub r95_m: f64,
    /// Price class and evidence.
    pub price: Option<(&'static str, String)>,
    rank: usize,
    /// CEP or R95 of the Monte Carlo with its 95 % interval.
    pub confirmed: Option<(f64, [Option<f64>; 2])>,
    /// Why its figures are not to be trusted on this trajectory.
    pub doubts: Vec<String>,
}

/// What a parameter may be.
#[derive(Debug, Clone, PartialEq)]
pub struct NeededValue {
    /// Parameter path.
    pub parameter: String,
    /// Value, SI; `None`: it has no effect, or the others alone exceed the limit.
    pub value: Option<f64>,
    /// Unit, SI.
    pub unit: &'static str,
}

/// The answer.
#[derive(Debug, Clone)]
pub struct BudgetOutcome {
    /// Sensors within the limit, cheapest first.
    pub met_by: Vec<Candidate>,
    /// The three next.
    pub nearest: Vec<Candidate>,
    /// Parameter values.
    pub needed: Vec<NeededValue>,
    /// With a model: limit ÷ figure.
    pub scale_all: Option<f64>,
    /// With a model: its CEP and R95, m.
    pub own: Option<(String, f64, f64)>,
    /// With a model: what it lacks of white noise and bias terms of gyro and accelerometer, `"gyro.noise"` …
    pub missing: Vec<&'static str>,
    /// Sensors that were asked.
    pub asked: usize,
    /// Sensors that lack a number the question needs.
    pub skipped: usize,
    /// The limit, as asked.
    pub figure: Figure,
    /// m.
    pub limit_m: f64,
    /// s.
    pub after_s: f64,
    /// Name of the trajectory.
    pub trajectory: String,
}

/// Answers a requirement.
///
/// # Errors
/// A limit or time that is not positive, a path that is too short, a model that cannot be read or self-aligned.
pub fn budget(request: &BudgetRequest<'_>) -> Result<BudgetOutcome, Error> {
    if request.limit_m.is_nan() || request.limit_m <= 0.0 {
        return Err(Error::usage("the limit must be a positive length")
            .advise("write for instance --cep '1 km'"));
    }
    let setting = |dt_s: f64| Setting {
        duration_s: request.after_s,
        dt_s,
        vertical: request.vertical,
        alignment: request.alignment,
        calibration: request.calibration,
    };
    let dt_of = |model: &Model| {
        1.0 / request
            .rate_hz
            .or_else(|| model.sample_rate_hz())
            .unwrap_or(100.0)
    };
    let temperature_of = |model: &Model| -> TemperatureOf {
        let reference = model.reference_temperature_c();
        request
            .temperature
            .clone()
            .unwrap_or_else(|| std::sync::Arc::new(move |_| reference))
    };
    let mut asked = Vec::new();
    let mut skipped = 0;
    for model in request.catalogue.models()? {
        let sensor = sensor_errors(&model)?;
        if sensor.missing().is_empty() {
            asked.push((model, sensor));
        } else {
            skipped += 1;
        }
    }
    // Sensors whose report times are the same share one scene and its unit responses.
    let mut scenes: Vec<(Vec<i64>, Scene)> = Vec::new();
    let key = |dt: f64, reference: f64| -> Vec<i64> {
        report_times_s(request.after_s, dt)
            .iter()
            .map(|t| (t * 1e7).round() as i64)
            .chain(std::iter::once((reference * 1e6) as i64))
            .collect()
    };
    let place_of = |scenes: &mut Vec<(Vec<i64>, Scene)>, model: &Model| -> Result<usize, Error> {
        let dt = dt_of(model);
        let k = key(
            dt,
            if request.temperature.is_some() {
                0.0
            } else {
                model.reference_temperature_c()
            },
        );
        if let Some(at) = scenes.iter().position(|(known, _)| *known == k) {
            return Ok(at);
        }
        scenes.push((
            k,
            Scene::new(
                request.trajectory,
                setting(dt.min(request.after_s)),
                &*temperature_of(model),
            )?,
        ));
        Ok(scenes.len() - 1)
    };
    let places: Vec<usize> = asked
        .iter()
        .map(|(model, _)| place_of(&mut scenes, model))
        .collect::<Result<_, _>>()?;
    let self_aligned = request.alignment == Alignment::SelfAligned;
    let found: Vec<Option<Candidate>> = asked
        .par_iter()
        .zip(&places)
        .map(|((model, sensor), place)| {
            let scene = &scenes[*place].1;
            let drift = match scene.covariance_at(sensor, dt_of(model)) {
                Ok(drift) => drift,
                // A gyro that cannot find north does not meet the requirement.
                Err(sagnac_nav::Error::Alignment { .. }) if self_aligned => return Ok(None),
                Err(error) => return Err(Error::from(error)),
            };
            let end = drift.end();
            let price = price_class(model);
            let doubts = scene.doubts(sensor, &drift, dt_of(model));
            Ok(Some(Candidate {
                doubts: doubts.iter().map(crate::drift::doubt_text).collect(),
                sensor: model.name().to_owned(),
                cep_m: end.radius_m(0.5),
                r95_m: end.radius_m(0.95),
                rank: price.as_ref().map_or(usize::MAX, sagnac_model_rank),
                price: price.map(|p| (p.class, p.evidence)),
                confirmed: None,
            }))
        })
        .collect::<Result<_, Error>>()?;
    skipped += found.iter().filter(|c| c.is_none()).count();
    let figure = |c: &Candidate| match request.figure {
        Figure::Cep => c.cep_m,
        Figure::R95 => c.r95_m,
    };
    let asked_count = found.iter().flatten().count();
    let (mut met_by, mut nearest): (Vec<Candidate>, Vec<Candidate>) = found
        .into_iter()
        .flatten()
        .partition(|c| figure(c) <= request.limit_m);
    met_by.sort_by(|a, b| a.rank.cmp(&b.rank).then(figure(a).total_cmp(&figure(b))));
    nearest.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
    nearest.truncate(3);
    if let Some((runs, seed)) = request.confirm {
        for candidate in met_by.iter_mut().take(3) {
            let model = request.catalogue.find(&candidate.sensor)?;
            let asked = DriftRequest {
                duration_s: Some(request.after_s),
                rate_hz: request.rate_hz,
                method: Method::MonteCarlo,
                alignment: request.alignment,
                calibration: request.calibration,
                vertical: request.vertical,
                sculling: request.sculling,
                temperature: request.temperature.clone(),
                seed,
                runs,
                ..DriftRequest::new(&model, request.trajectory)
            };
            let outcome = drift_with_progress(&asked, &mut |_, _| {})?;
            let curve = match request.figure {
                Figure::Cep => outcome.cep(),
                Figure::R95 => outcome.r95(),
            };
            candidate.confirmed = Some((curve.value[59], curve.interval[59]));
        }
    }
    let (needed, scale_all, own, missing) = match request.model {
        None => {
            let dt = 1.0 / request.rate_hz.unwrap_or(100.0);
            let temperature = request
                .temperature
                .clone()
                .unwrap_or_else(|| std::sync::Arc::new(|_| 25.0));
            let scene = Scene::new(
                request.trajectory,
                setting(dt.min(request.after_s)),
                &*temperature,
            )?;
            (needed_alone(&scene, request), None, None, Vec::new())
        }
        Some(model) => {
            let dt = dt_of(model);
            let scene = Scene::new(
                request.trajectory,
                setting(dt.min(request.after_s)),
                &*temperature_of(model),
            )?;
            let sensor = sensor_errors(model)?;
            let drift = scene.covariance(&sensor)?;
            let end = drift.end();
            let now = end.radius_m(request.figure.part());
            let needed = PARAMETERS
                .par_iter()
                .map(|p| {
                    let mut others = Horizontal {
                        mean: end.mean,
                        ..Horizontal::default()
                    };
                    for e in drift.budget.iter().filter(|e| e.term != p.term()) {
                        others = others.plus(&e.spread[59].horizontal, 1.0);
                    }
                    NeededValue {
                        parameter: p.path.to_owned(),
                        value: largest_value(&others, &p.unit(&scene), request),
                        unit: p.si,
                    }
                })
                .collect();
            let scale = (now > 0.0).then(|| request.limit_m / now);
            (
                needed,
                scale,
                Some((
                    model.name().to_owned(),
                    end.radius_m(0.5),
                    end.radius_m(0.95),
                )),
                sensor.missing(),
            )
        }
    };
    Ok(BudgetOutcome {
        met_by,
        nearest,
        needed,
        scale_all,
        own,
        missing,
        asked: asked_count,
        skipped,
        figure: request.figure,
        limit_m: request.limit_m,
        after_s: request.after_s,
        trajectory: request.trajectory.name().to_owned(),
    })
}

fn sagnac_model_rank(price: &sagnac_model::catalogue::PriceClass) -> usize {
    price.rank()
}

/// A parameter whose allowance is asked for.
struct Allowance {
    path: &'static str,
    si: &'static str,
    sensor: Sensor,
    what: What,
}

enum What {
    Bias,
    Flicker,
    White,
    ScaleFactor,
    Misalignment,
}

const PARAMETERS: [Allowance; 10] = [
    Allowance {
        path: "gyro.bias.stability",
        si: "rad/s",
        sensor: Sensor::Gyro,
        what: What::Bias,
    },
    Allowance {
        path: "gyro.bias.instability.coefficient",
        si: "rad/s",
        sensor: Sensor::Gyro,
        what: What::Flicker,
    },
    Allowance {
        path: "gyro.noise.angle_random_walk",
        si: "rad/s^0.5",
        sensor: Sensor::Gyro,
        what: What::White,
    },
    Allowance {
        path: "gyro.scale_factor.stability",
        si: "1",
        sensor: Sensor::Gyro,
        what: What::ScaleFactor,
    },
    Allowance {
        path: "gyro.misalignment.stability",
        si: "rad",
        sensor: Sensor::Gyro,
        what: What::Misalignment,
    },
    Allowance {
        path: "accel.bias.stability",
        si: "m/s^2",
        sensor: Sensor::Accel,
        what: What::Bias,
    },
    Allowance {
        path: "accel.bias.instability.coefficient",
        si: "m/s^2",
        sensor: Sensor::Accel,
        what: What::Flicker,
    },
    Allowance {
        path: "accel.noise.velocity_random_walk",
        si: "m/s^1.5",
        sensor: Sensor::Accel,
        what: What::White,
    },
    Allowance {
        path: "accel.scale_factor.stability",
        si: "1",
        sensor: Sensor::Accel,
        what: What::ScaleFactor,
    },
    Allowance {
        path: "accel.misalignment.stability",
        si: "rad",
        sensor: Sensor::Accel,
        what: What::Misalignment,
    },
];

impl Allowance {
    /// The term of the budget.
    fn term(&self) -> &'static str {
        self.path.trim_end_matches(".coefficient")
    }

    fn kinds(&self) -> Vec<Kind> {
        let sensor = self.sensor;
        match self.what {
            What::Misalignment => Element::ALL
                .into_iter()
                .map(|element| Kind::Constant(Parameter::OffDiagonal { sensor, element }))
                .collect(),
            _ => Axis::ALL
                .into_iter()
                .map(|axis| match self.what {
                    What::Bias => Kind::Constant(Parameter::Bias {
                        sensor,
                        axis,
                        power: 0,
                    }),
                    What::Flicker => Kind::Flicker { sensor, axis },
                    What::White => Kind::Process {
                        sensor,
                        axis,
                        process: Process::White,
                    },
                    _ => Kind::Constant(Parameter::ScaleFactor {
                        sensor,
                        axis,
                        power: 0,
                    }),
                })
                .collect(),
        }
    }

    /// Spread at the end per unit on all axes.
    fn unit(&self, scene: &Scene) -> Horizontal {
        self.kinds()
            .into_iter()
            .fold(Horizontal::default(), |sum, kind| {
                let end = scene
                    .unit(kind)
                    .spread
                    .last()
                    .map(|s| s.horizontal)
                    .unwrap_or_default();
                sum.plus(&end, 1.0)
            })
    }
}

/// A unit that moves the position by less than this has no effect here: rounding, m per SI unit of the parameter.
const NO_EFFECT_M: f64 = 1e-6;

fn needed_alone(scene: &Scene, request: &BudgetRequest<'_>) -> Vec<NeededValue> {
    PARAMETERS
        .par_iter()
        .map(|p| {
            let unit = p.unit(scene).radius_m(request.figure.part());
            NeededValue {
                parameter: p.path.to_owned(),
                value: (unit > NO_EFFECT_M).then(|| request.limit_m / unit),
                unit: p.si,
            }
        })
        .collect()
}

/// The largest x with figure(others + x²·unit) = limit; `None` where the others exceed it or the unit has no effect.
fn largest_value(
    others: &Horizontal,
    unit: &Horizontal,
    request: &BudgetRequest<'_>,
) -> Option<f64> {
    let figure = |x: f64| others.plus(unit, x * x).radius_m(request.figure.part());
    let alone = unit.radius_m(request.figure.part());
    if alone <= NO_EFFECT_M || figure(0.0) > request.limit_m {
        return None;
    }
    let (mut low, mut high) = (0.0, request.limit_m / alone);
    while figure(high) < request.limit_m {
        high *= 1.5;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if figure(middle) <= request.limit_m {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
