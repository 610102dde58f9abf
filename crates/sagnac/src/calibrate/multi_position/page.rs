//! The page of `calibrate multi-position`: parameters, poses on the sphere, before and after, correlations.

use sagnac_core::Sensor;
use sagnac_report::html::{CalibrationPage, Input, ResultRow, ResultTable, Rich};
use sagnac_report::plots::{Color, CorrelationMap, Histogram, PoseSphere, StationResiduals};
use sagnac_report::text::significant;

use super::MultiPositionOutcome;
use crate::calibrate::PageFacts;
use crate::calibrate::certificate::{page_unit, page_words};
use crate::calibrate::text::{estimates, in_g, terms_in, title};
use crate::calibrate::units::shown;

/// °/h of a rate.
const DEG_H: f64 = 180.0 / std::f64::consts::PI * 3600.0;
/// mg of an acceleration.
const MG: f64 = 1e3 / 9.80665;

impl MultiPositionOutcome {
    /// The report.
    pub fn to_page(&self, facts: &PageFacts) -> CalibrationPage {
        let found = &self.found;
        let mut limits = vec![Rich::from(page_words(&self.not_determined()))];
        limits.extend(self.notes().into_iter().map(|n| Rich::from(page_words(&n))));
        limits.extend(
            self.advice()
                .into_iter()
                .map(|n| Rich::from(page_words(&n))),
        );
        limits.push(Rich::from(
            "What no hand-turned log tells: the Earth's rate, temperature, nonlinearity, axis offset, and the absolute \
             scale beyond the gravity that was assumed.",
        ));
        CalibrationPage {
            name: if self.request.name.is_empty() {
                "Hand-turned log".to_owned()
            } else {
                self.request.name.clone()
            },
            subtitle: "calibrated from still poses, no equipment".to_owned(),
            verdict: Rich::from(page_words(&self.verdict())),
            facts: self.facts(),
            results: [Sensor::Accel, Sensor::Gyro]
                .into_iter()
                .map(|sensor| self.results(sensor))
                .filter(|t| !t.rows.is_empty())
                .collect(),
            result_note: Rich::from(page_words(&format!(
                "± is half the 95 % interval. {}",
                self.remarks()
            ))),
            residuals: vec![self.residuals()],
            before_after: self.histograms(),
            poses: Some(PoseSphere {
                poses: found.poses.iter().map(|p| p.direction).collect(),
                next: found
                    .add_poses
                    .iter()
                    .take(6)
                    .map(|p| (p.up, p.words.clone()))
                    .collect(),
            }),
            correlation: Some(self.correlation()),
            figures: Vec::new(),
            limits,
            method: Rich::from(
                "Rests by windowed variance with a threshold between its two modes. Accelerometer: weighted least \
                 squares of |f| − g over the rests, Huber weights beyond 3 robust standard deviations. Gyro: rests and \
                 turns jointly, with the noise of the turn, of the directions before and after it and of the \
                 accelerometer's estimate in the covariance. Idea: Tedaldi, Pretto, Menegatti, ICRA 2014.",
            ),
            command: facts.command.clone(),
            version: facts.version.clone(),
            inputs: facts
                .inputs
                .iter()
                .map(|(name, sha256)| Input {
                    name: name.clone(),
                    sha256: sha256.clone(),
                })
                .collect(),
        }
    }

    fn facts(&self) -> Vec<(String, String)> {
        let found = &self.found;
        let mut out = vec![
            ("Poses".to_owned(), found.poses.len().to_string()),
            (
                "Sphere covered".to_owned(),
                format!("{:.0} %", 100.0 * found.covered),
            ),
            (
                "Gravity".to_owned(),
                page_words(&self.request.place.words(self.gravity_m_s2)),
            ),
            (
                "Rate".to_owned(),
                format!("{} Hz", significant(1.0 / self.dt_s, 4)),
            ),
        ];
        if !found.turns.is_empty() {
            out.insert(1, ("Turns".to_owned(), found.turns.len().to_string()));
        }
        out
    }

    fn results(&self, sensor: Sensor) -> ResultTable {
        let parameters = &self.found.parameters;
        ResultTable {
            heading: title(sensor).to_owned(),
            rows: terms_in(parameters, sensor)
                .into_iter()
                .map(|term| {
                    let shown = shown(sensor, term);
                    ResultRow {
                        name: shown.name,
                        cells: estimates(parameters, sensor, term, shown.per_si),
                        unit: page_unit(shown.unit),
                    }
                })
                .collect(),
        }
    }

    fn residuals(&self) -> StationResiduals {
        let found = &self.found;
        let none = vec![f64::NAN; found.poses.len()];
        StationResiduals {
            sensor: "accel".to_owned(),
            unit: "mg, |f| − g".to_owned(),
            word: "pose".to_owned(),
            labels: (1..=found.poses.len()).map(|i| i.to_string()).collect(),
            axes: [
                found.poses.iter().map(|p| p.residual * MG).collect(),
                none.clone(),
                none,
            ],
            band: 2.0 * found.accel_rms * MG,
        }
    }

    fn histograms(&self) -> Vec<Histogram> {
        let found = &self.found;
        let mut out: Vec<Histogram> = [
            (
                "calibration-before",
                "Before",
                found.before_rms,
                found.poses.iter().map(|p| p.before).collect::<Vec<f64>>(),
                Color::Fit,
            ),
            (
                "calibration-after",
                "After",
                found.accel_rms,
                found.poses.iter().map(|p| p.residual).collect(),
                Color::Data,
            ),
        ]
        .into_iter()
        .map(|(plot, caption, rms, values, color)| {
            let (unit, factor) = if rms > 1e-3 * 9.80665 {
                ("mg", MG)
            } else {
                ("µg", 1e3 * MG)
            };
            Histogram {
                plot: plot.to_owned(),
                caption: caption.to_owned(),
                caption_rest: format!(": |f| − g, {} rms", page_words(&in_g(rms))),
                x_title: format!("|f| − g, {unit}"),
                values: values.iter().map(|v| v * factor).collect(),
                color,
            }
        })
        .collect();
        let rest = |pick: &dyn Fn(&sagnac_calibrate::multi_position::Pose) -> Option<[f64; 3]>| {
            found
                .poses
                .iter()
                .filter_map(pick)
                .flatten()
                .map(|v| v * DEG_H)
                .collect::<Vec<f64>>()
        };
        for (plot, caption, values, color) in [
            (
                "calibration-before",
                "Before",
                rest(&|p| p.gyro_mean),
                Color::Fit,
            ),
            (
                "calibration-after",
                "After",
                rest(&|p| p.gyro_residual),
                Color::Data,
            ),
        ] {
            if found.gyro_rms.is_some() && !values.is_empty() {
                let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
                out.push(Histogram {
                    plot: plot.to_owned(),
                    caption: caption.to_owned(),
                    caption_rest: format!(
                        ": gyro at rest, all axes, {} °/h rms",
                        significant(rms, 3)
                    ),
                    x_title: "mean rate of a rest, °/h".to_owned(),
                    values,
                    color,
                });
            }
        }
        out
    }

    fn correlation(&self) -> CorrelationMap {
        let found = &self.found;
        let c = &found.covariance;
        CorrelationMap {
            names: found.parameters.iter().map(|p| p.name.clone()).collect(),
            matrix: (0..c.len())
                .map(|i| {
                    (0..c.len())
                        .map(|j| c[i][j] / (c[i][i] * c[j][j]).sqrt())
                        .collect()
                })
                .collect(),
        }
    }
}
