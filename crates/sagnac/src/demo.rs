//! `demo`: the whole loop on one sensor: simulate at rest, characterize, compare with the truth, grade, drift, budget.

use sagnac_analysis::fit::Status;
use sagnac_core::Sensor;
use sagnac_log::Log;
use sagnac_model::{Catalogue, Model};
use sagnac_nav::{Earth, Start, Trajectory};
use sagnac_noise::TermSet;
use sagnac_report::text::{Align, Cell, Document, Table, significant};
use serde_json::{Value, json};

mod page;

use crate::Error;
use crate::budget::{BudgetOutcome, BudgetRequest, Figure, budget};
use crate::characterize::{NamedLog, Outcome, Request, characterize};
use crate::drift::{DriftOutcome, DriftRequest, drift};
use crate::grade::{GradeOutcome, GradeRequest, grade};
use crate::simulate::{MotionSource, SimulateOutcome, SimulateRequest, simulate_log};

/// Length of the simulated rest, s.
const REST_S: f64 = 7200.0;
/// Its rate, Hz.
const RATE_HZ: f64 = 100.0;
/// The requirement of the budget: CEP, m, after this time, s.
const REQUIREMENT: (f64, f64) = (1000.0, 600.0);

/// One estimate beside the number it was simulated from.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Channel: `gyro_x`.
    pub axis: String,
    /// Name of the term as in the JSON of `characterize`.
    pub term: &'static str,
    /// What was simulated, SI.
    pub truth: f64,
    /// The estimate and its 95 % interval, SI; of an upper limit only the upper end.
    pub found: [Option<f64>; 3],
    /// Whether the 95 % interval (or limit) holds it.
    pub is_held: bool,
}

/// The whole loop.
#[derive(Debug)]
pub struct DemoOutcome {
    /// The sensor that was simulated.
    pub model: Model,
    /// The simulation in words.
    pub simulated: SimulateOutcome,
    /// Its log.
    pub log: Log,
    /// What the log says.
    pub characterized: Outcome,
    /// Every random term of the model beside its estimate.
    pub checks: Vec<Check>,
    /// The grade of the sensor.
    pub grade: GradeOutcome,
    /// Its drift at rest.
    pub drift: DriftOutcome,
    /// Which sensors keep 1 km after 10 min in `drive`.
    pub budget: BudgetOutcome,
}

/// Runs the loop on a sensor of the catalogue; `log_name` is what results call the log.
///
/// # Errors
/// Those of the tasks.
pub fn demo(
    catalogue: &Catalogue,
    sensor: &str,
    log_name: &str,
    seed: u64,
) -> Result<DemoOutcome, Error> {
    let model = catalogue.find(sensor)?;
    let start = Start::default();
    let rest = Trajectory::named("rest", Earth::Wgs84, &start)?;
    let (simulated, log, _) = simulate_log(SimulateRequest {
        model: &model,
        motion: MotionSource::Trajectory {
            trajectory: &rest,
            start,
            duration_s: REST_S,
        },
        rate_hz: Some(RATE_HZ),
        terms: TermSet::ALL,
        seed,
        runs: 1,
        temperature: None,
        with_truth: false,
    })?;
    let logs = [NamedLog {
        name: log_name.to_owned(),
        log,
    }];
    let characterized = characterize(&logs, &Request::default())?;
    let checks = checks(&model, &characterized);
    let grade = grade(&GradeRequest::new(&model))?;
    let drift = drift(&DriftRequest {
        duration_s: Some(600.0),
        ..DriftRequest::new(&model, &rest)
    })?;
    let drive = Trajectory::named("drive", Earth::Wgs84, &Start::default())?;
    let (limit_m, after_s) = REQUIREMENT;
    let budget = budget(&BudgetRequest::new(
        catalogue,
        &drive,
        Figure::Cep,
        limit_m,
        after_s,
    ))?;
    let [NamedLog { log, .. }] = logs;
    Ok(DemoOutcome {
        model,
        simulated,
        log,
        characterized,
        checks,
        grade,
        drift,
        budget,
    })
}

/// The white noise, flicker and random walk of the model, where it has them, beside the estimates.
fn checks(model: &Model, outcome: &Outcome) -> Vec<Check> {
    let mut out = Vec::new();
    for axis in outcome.logs.iter().flat_map(|log| &log.axes) {
        let Some(estimate) = &axis.estimate else {
            continue;
        };
        let noise = model.axis_noise(axis.sensor, axis.index);
        let white = if axis.sensor == Sensor::Gyro {
            "angle_random_walk"
        } else {
            "velocity_random_walk"
        };
        for (term, truth, found) in [
            (white, noise.white.density, &estimate.white),
            (
                "bias_instability",
                noise.flicker.coefficient,
                &estimate.flicker,
            ),
        ] {
            if truth <= 0.0 {
                continue;
            }
            let above = found.lower.unwrap_or(0.0);
            let is_held = match found.status {
                Status::Absent => continue,
                Status::Detected | Status::UpperLimit => {
                    above <= truth && found.upper.is_some_and(|upper| truth <= upper)
                }
            };
            out.push(Check {
                axis: axis.axis.clone(),
                term,
                truth,
                found: [found.value, found.lower, found.upper],
                is_held,
            });
        }
    }
    out
}

impl DemoOutcome {
    /// Number of intervals that hold the truth.
    pub fn covered(&self) -> usize {
        self.checks.iter().filter(|check| check.is_held).count()
    }

    /// `{"files", "intervals", "covered", …}`.
    pub fn to_json(&self, files: &[String]) -> Value {
        json!({
            "files": files,
            "intervals": self.checks.len(),
            "covered": self.covered(),
            "checks": self.checks.iter().map(|check| json!({
                "axis": check.axis, "term": check.term, "truth": check.truth, "covered": check.is_held,
            })).collect::<Vec<_>>(),
            "grade": self.grade.to_json(),
            "cep_m": self.drift.covariance.cep_m().last(),
        })
    }

    /// The steps, a line each; `seconds` is what simulation and estimate took, where the caller measured it.
    pub fn document(&self) -> Document {
        let (n, held) = (self.checks.len(), self.covered());
        let mut table = Table::new(&["", "", ""], &[Align::Left, Align::Left, Align::Left]);
        let mut step = |number: &str, name: &str, text: String| {
            table.row([Cell::from(number), Cell::from(name), Cell::from(text)]);
        };
        step(
            "1",
            "simulate",
            format!(
                "{} of the catalogue at rest, 2 h at 100 Hz",
                self.model.name()
            ),
        );
        step(
            "2",
            "characterize",
            format!(
                "{} axes, every term with its 95 % interval",
                self.characterized
                    .logs
                    .iter()
                    .map(|log| log.axes.len())
                    .sum::<usize>()
            ),
        );
        step(
            "3",
            "compare",
            format!(
                "{held} of {n} intervals hold the truth (95 % would be {:.1})",
                0.95 * n as f64
            ),
        );
        let json = self.grade.to_json();
        let word = |key: &str| match json[key].as_str().unwrap_or("none") {
            "ahrs" => "AHRS".to_owned(),
            "gyro_bias" => "the gyro".to_owned(),
            "accel_bias" => "the accelerometer".to_owned(),
            "position" => "its position".to_owned(),
            other => other.replace('_', " "),
        };
        let kind = json["bias"].as_str().unwrap_or("mixed");
        step(
            "4",
            "grade",
            format!(
                "{} (table: lecture, {kind} bias), held back by {}",
                word("overall"),
                word("held_back_by")
            ),
        );
        let cep = self.drift.covariance.cep_m();
        let at = |time_s: f64| {
            self.drift
                .covariance
                .time_s
                .iter()
                .zip(&cep)
                .min_by(|a, b| (a.0 - time_s).abs().total_cmp(&(b.0 - time_s).abs()))
                .map_or(f64::NAN, |(_, cep)| *cep)
        };
        step(
            "5",
            "drift",
            format!(
                "CEP {} after 1 min at rest, {} after 10 min",
                distance(at(60.0)),
                distance(at(600.0))
            ),
        );
        let met = &self.budget.met_by;
        let cheapest = met
            .first()
            .map_or_else(String::new, |first| format!(", {} first", first.sensor));
        step(
            "6",
            "budget",
            format!(
                "{} sensors keep 1 km after 10 min in `drive`{cheapest}",
                met.len()
            ),
        );
        let mut document = Document::new();
        document.table(table).blank();
        document
    }
}

/// A distance in m or km.
pub(super) fn distance(m: f64) -> String {
    if m < 1000.0 {
        format!("{} m", significant(m, 2))
    } else {
        format!("{} km", significant(m / 1000.0, 2))
    }
}
