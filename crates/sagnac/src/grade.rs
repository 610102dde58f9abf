//! `grade`: which grade a sensor is, by its biases and by the position it would keep, and what holds it back
//! (navigation.md §4).
//!
//! ```
//! use sagnac::grade::{GradeRequest, grade};
//! use sagnac::model::Model;
//! let text = "name = \"X\"\n[gyro.bias]\nstability = \"0.3 deg/h\"\n[accel.bias]\nstability = \"0.8 mg\"";
//! let model = Model::parse(text, "x.toml")?;
//! let outcome = grade(&GradeRequest::new(&model))?;
//! assert_eq!(outcome.to_json()["overall"], "tactical");
//! assert_eq!(outcome.to_json()["held_back_by"], "gyro_bias");
//! # Ok::<(), sagnac::Error>(())
//! ```

mod chart;
mod table;
mod view;

pub use chart::{area_charts, cost_chart, cost_page, grade_page};
pub use table::{GradeTable, Limit, Row};

use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_nav::drift::{Alignment, Scene, Setting};
use sagnac_nav::sensor::Calibration;
use sagnac_nav::strapdown::Vertical;
use sagnac_nav::{Earth, Start, Trajectory};
use serde_json::{Value, json};

use crate::Error;
use crate::motion::sensor_errors;

/// One nautical mile, m.
pub(crate) const NMI_M: f64 = 1852.0;

/// Which bias counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bias {
    /// The Allan floor of the in-run instability.
    InRun,
    /// `bias.stability`, 1σ.
    RunToRun,
}

impl Bias {
    /// `in-run`, `run-to-run`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::InRun => "in-run",
            Self::RunToRun => "run-to-run",
        }
    }

    const fn path(self) -> &'static str {
        match self {
            Self::InRun => "bias.instability",
            Self::RunToRun => "bias.stability",
        }
    }
}

/// What to grade.
#[derive(Debug, Clone, Copy)]
pub struct GradeRequest<'a> {
    /// The sensor.
    pub model: &'a Model,
    /// `--table`.
    pub table: GradeTable,
    /// `--bias`; chosen by what the model states where absent.
    pub bias: Option<Bias>,
}

impl<'a> GradeRequest<'a> {
    /// The lecture's table, the bias chosen by what the model states.
    pub fn new(model: &'a Model) -> Self {
        Self {
            model,
            table: GradeTable::Lecture,
            bias: None,
        }
    }
}

/// A quantity that misses the row above.
#[derive(Debug, Clone, PartialEq)]
pub struct Needed {
    /// Parameter path, or `position`.
    pub parameter: String,
    /// Its value, SI.
    pub now: f64,
    /// What the row above asks.
    pub needed: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// now ÷ needed.
    pub factor: f64,
    /// Whether the row asks for less than `needed`, not for at most that.
    pub is_strict: bool,
}

/// A sensor's grade.
#[derive(Debug, Clone, PartialEq)]
pub struct GradeOutcome {
    /// The sensor.
    pub sensor: String,
    /// The table.
    pub table: GradeTable,
    /// The bias of gyro and accelerometer that was graded: kind and value, SI.
    pub bias: [Option<(Bias, f64)>; 2],
    /// Row by gyro bias; `None`: no data or outside the table.
    pub by_gyro_bias: Option<usize>,
    /// Row by accelerometer bias.
    pub by_accel_bias: Option<usize>,
    /// Row by position.
    pub by_position: Option<usize>,
    /// CEP at rest after 1 h and, where asked for, 24 h, m.
    pub cep_m: [Option<f64>; 2],
    /// The worst of the rows.
    pub overall: Option<usize>,
    /// `gyro_bias`, `accel_bias`, `position`.
    pub held_back_by: Option<&'static str>,
    /// All that misses the row above.
    pub needed_for_next: Vec<Needed>,
    /// Why something is null.
    pub reasons: Vec<String>,
}

fn largest(of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    (0..3)
        .filter_map(of)
        .map(f64::abs)
        .filter(|b| *b > 0.0)
        .max_by(f64::total_cmp)
}

/// The bias of a kind that a model states, SI, the largest of the axes.
pub(crate) fn bias_of(model: &Model, sensor: Sensor, kind: Bias) -> Option<f64> {
    match kind {
        Bias::InRun => largest(|axis| model.instability_floor(sensor, axis)),
        Bias::RunToRun => largest(|axis| model.under(sensor, "bias.stability", axis)?.value),
    }
}

/// The bias of both sensors that counts.
pub(crate) fn chosen(model: &Model, wanted: Option<Bias>) -> [Option<(Bias, f64)>; 2] {
    let get = |kind: Bias| Sensor::ALL.map(|s| bias_of(model, s, kind).map(|v| (kind, v)));
    if let Some(kind) = wanted {
        return get(kind);
    }
    let (run, in_run) = (get(Bias::RunToRun), get(Bias::InRun));
    if run.iter().all(Option::is_some) {
        return run;
    }
    if in_run.iter().all(Option::is_some) {
        return in_run;
    }
    [in_run[0].or(run[0]), in_run[1].or(run[1])]
}

/// CEP at rest with the defaults of `drift`, perfectly calibrated, m.
fn rest_cep_m(model: &Model, bias: &[Option<(Bias, f64)>; 2], hours: f64) -> Result<f64, Error> {
    let mut sensor = sensor_errors(model)?;
    for (s, b) in bias.iter().enumerate() {
        if matches!(b, Some((Bias::InRun, _))) {
            sensor.bias_stability[s] = [0.0; 3];
        }
    }
    let trajectory = Trajectory::named("rest", Earth::Wgs84, &Start::default())?;
    let setting = Setting {
        duration_s: hours * 3600.0,
        dt_s: 1.0 / model.sample_rate_hz().unwrap_or(100.0),
        vertical: Vertical::Fixed,
        alignment: Alignment::Perfect,
        calibration: Calibration::Perfect,
    };
    let reference = model.reference_temperature_c();
    Ok(Scene::new(&trajectory, setting, &|_| reference)?
        .covariance(&sensor)?
        .end()
        .radius_m(0.5))
}

/// Grades a sensor.
///
/// # Errors
/// A model that cannot be made ready.
pub fn grade(request: &GradeRequest<'_>) -> Result<GradeOutcome, Error> {
    let model = request.model;
    let rows = request.table.rows();
    let bias = chosen(model, request.bias);
    let mut reasons = Vec::new();
    let mut by = [None, None];
    for sensor in Sensor::ALL {
        let i = sensor.index();
        by[i] = match bias[i] {
            None => {
                let kind = request
                    .bias
                    .map_or("bias.stability and no bias.instability".to_owned(), |b| {
                        b.path().to_owned()
                    });
                reasons.push(format!("the model has no {}.{kind}", sensor.key()));
                None
            }
            Some((_, value)) => {
                let row = rows.iter().position(|r| r.bias[i].is_met(value));
                if row.is_none() {
                    reasons.push(format!("the {} bias is outside the table", sensor.name()));
                }
                row
            }
        };
    }
    let outside = (0..2).any(|i| bias[i].is_some() && by[i].is_none());
    let complete = bias.iter().all(Option::is_some);
    let mut cep_m = [None, None];
    let mut by_position = None;
    if !complete {
        reasons.push("a position needs a bias of both gyro and accelerometer: what is absent would count as zero".to_owned());
    } else if rows.iter().any(|r| r.position.is_some()) {
        let hour = rest_cep_m(model, &bias, 1.0)?;
        cep_m[0] = Some(hour);
        if hour <= NMI_M
            && rows
                .iter()
                .any(|r| matches!(r.position, Some((h, _)) if h > 1.0))
        {
            cep_m[1] = Some(rest_cep_m(model, &bias, 24.0)?);
        }
        by_position = rows.iter().position(|r| {
            r.position.is_some_and(|(hours, limit)| {
                position_at(&cep_m, hours).is_some_and(|c| limit.is_met(c))
            })
        });
        if by_position.is_none() {
            reasons.push("the table gives no position figure below tactical".to_owned());
        }
    } else {
        reasons.push("the table has no position column".to_owned());
    }
    let overall = if outside {
        None
    } else {
        [by[0], by[1], by_position].into_iter().flatten().max()
    };
    let next = match overall {
        Some(0) => None,
        Some(row) => Some(row - 1),
        None if outside => Some(rows.len() - 1),
        None => None,
    };
    let mut needed_for_next = Vec::new();
    let mut held: Option<(&'static str, f64)> = None;
    if let Some(next) = next {
        let above = &rows[next];
        for (sensor, name) in Sensor::ALL.into_iter().zip(["gyro_bias", "accel_bias"]) {
            let i = sensor.index();
            let (Some((kind, value)), Some(limit)) = (bias[i], above.bias[i].value()) else {
                continue;
            };
            if !above.bias[i].is_met(value) {
                needed_for_next.push(Needed {
                    parameter: format!("{}.{}", sensor.key(), kind.path()),
                    now: value,
                    needed: limit,
                    unit: if sensor == Sensor::Gyro {
                        "rad/s"
                    } else {
                        "m/s^2"
                    },
                    factor: value / limit,
                    is_strict: matches!(above.bias[i], Limit::Below(_)),
                });
            }
            if by[i] == overall && overall.is_some() && held.is_none_or(|(_, f)| value / limit > f)
            {
                held = Some((name, value / limit));
            }
        }
        if let Some((hours, limit)) = above.position
            && let (Some(limit_m), Some(mut cep)) =
                (limit.value(), position_at(&cep_m, hours).or(cep_m[0]))
        {
            if hours > 1.0 && cep_m[1].is_none() && complete {
                cep = rest_cep_m(model, &bias, hours)?;
                cep_m[1] = Some(cep);
            }
            if !limit.is_met(cep) {
                needed_for_next.push(Needed {
                    parameter: "position".to_owned(),
                    now: cep,
                    needed: limit_m,
                    unit: "m",
                    factor: cep / limit_m,
                    is_strict: matches!(limit, Limit::Below(_)),
                });
            }
            if by_position.is_some()
                && by_position == overall
                && held.is_none_or(|(_, f)| cep / limit_m > f)
            {
                held = Some(("position", cep / limit_m));
            }
        }
    }
    Ok(GradeOutcome {
        sensor: model.name().to_owned(),
        table: request.table,
        bias,
        by_gyro_bias: by[0],
        by_accel_bias: by[1],
        by_position,
        cep_m,
        overall,
        held_back_by: held.map(|(name, _)| name),
        needed_for_next,
        reasons,
    })
}

fn position_at(cep_m: &[Option<f64>; 2], hours: f64) -> Option<f64> {
    if hours > 1.0 { cep_m[1] } else { cep_m[0] }
}

impl GradeOutcome {
    /// A row's name as scripts know it.
    fn key(&self, row: Option<usize>) -> Option<&'static str> {
        row.and_then(|r| self.table.rows().get(r).map(|r| r.name))
    }

    /// `run-to-run`, `in-run` or `mixed`; `None` without any bias.
    pub fn bias_kind(&self) -> Option<&'static str> {
        let kinds: Vec<Bias> = self.bias.iter().flatten().map(|(k, _)| *k).collect();
        match kinds.as_slice() {
            [] => None,
            [one] => Some(one.key()),
            [a, b, ..] if a == b => Some(a.key()),
            _ => Some("mixed"),
        }
    }

    /// `{"sensor", "table", "bias", "by_gyro_bias", …}` of navigation.md §4.
    pub fn to_json(&self) -> Value {
        let bias = |i: usize| {
            self.bias[i].map_or(Value::Null, |(kind, value)| json!({ "kind": kind.key(), "value": value, "unit": if i == 0 { "rad/s" } else { "m/s^2" } }))
        };
        json!({
            "sensor": self.sensor,
            "table": self.table.key(),
            "bias": self.bias_kind(),
            "by_gyro_bias": self.key(self.by_gyro_bias),
            "by_accel_bias": self.key(self.by_accel_bias),
            "by_position": self.key(self.by_position),
            "overall": self.key(self.overall),
            "held_back_by": self.held_back_by,
            "needed_for_next": self.needed_for_next.iter().map(|n| json!({ "parameter": n.parameter, "now": n.now, "needed": n.needed, "unit": n.unit, "factor": n.factor, "strict": n.is_strict })).collect::<Vec<_>>(),
            "gyro_bias": bias(0),
            "accel_bias": bias(1),
            "position": { "cep_1h_m": self.cep_m[0], "cep_24h_m": self.cep_m[1] },
            "reasons": self.reasons,
        })
    }
}
