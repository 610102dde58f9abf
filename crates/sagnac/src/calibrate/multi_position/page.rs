//! The certificate of `calibrate multi-position`: parameters, poses on the sphere, before and after, correlations.

use sagnac_calibrate::multi_position::Pose;
use sagnac_core::Sensor;
use sagnac_report::html::{CertificatePage, Reference, Rich};
use sagnac_report::plots::{Color, Histogram, PoseSphere, StationResiduals};
use sagnac_report::text::significant;

use super::MultiPositionOutcome;
use crate::calibrate::PageFacts;
use crate::calibrate::certificate::fit_rows;
use crate::calibrate::sheet::{self, EXPANDED, page_words};
use crate::calibrate::text::{in_g, rows_of, title};

/// °/h of a rate.
const DEG_H: f64 = 180.0 / std::f64::consts::PI * 3600.0;
/// mg of an acceleration.
const MG: f64 = 1e3 / 9.80665;

impl MultiPositionOutcome {
    /// The certificate.
    pub fn to_page(&self, facts: &PageFacts) -> CertificatePage {
        let found = &self.found;
        let sensors: Vec<Sensor> = rows_of(&found.parameters)
            .into_iter()
            .map(|(sensor, _)| sensor)
            .collect();
        let names: Vec<String> = found.parameters.iter().map(|p| p.name.clone()).collect();
        let mut hints: Vec<Rich> = self
            .notes()
            .into_iter()
            .map(|n| Rich::from(page_words(&n)))
            .collect();
        hints.extend(self.advice().into_iter().map(|n| {
            Rich::new()
                .bold("Add.")
                .plain(format!(" {}", page_words(&n)))
        }));
        let mut residuals = vec![self.pose_residuals()];
        residuals.retain(|r| !r.labels.is_empty());
        CertificatePage {
            place: sheet::place(self.request.place.latitude_rad, self.request.place.height_m),
            gravity: page_words(&self.request.place.words(self.gravity_m_s2)),
            verdict: Rich::from(page_words(&self.verdict())),
            method: Rich::from(format!(
                "A log of {} Hz, turned by hand between {} still poses, which cover {:.0} % of the sphere. Rests by \
                 windowed variance, its threshold between the two modes. Accelerometer: weighted least squares of \
                 |f| − g over the rests, Huber's weights beyond 3 robust standard deviations. Gyro: rests and {} turns \
                 jointly, with the noise of the turn, of the directions before and after it and of the accelerometer's \
                 estimate in the covariance. Idea: Tedaldi, Pretto, Menegatti, ICRA 2014. Body axes: {}.",
                significant(1.0 / self.dt_s, 4),
                found.poses.len(),
                100.0 * found.covered,
                found.turns.len(),
                self.frame_words()
            )),
            references: self.references(&sensors),
            results: sheet::results(&found.parameters),
            result_note: Rich::from(page_words(&self.result_note())),
            residuals,
            before_after: sheet::magnitudes(
                &found.poses.iter().map(|p| p.before).collect::<Vec<f64>>(),
                &found.poses.iter().map(|p| p.residual).collect::<Vec<f64>>(),
            ),
            not_determined: Rich::from(format!(
                "{} Cross-axis response cannot be told from misalignment; the numbers above are their sum. No \
                 hand-turned log tells the Earth's rate, nor the absolute scale beyond the gravity that was assumed.",
                page_words(&self.not_determined())
            )),
            fits: fit_rows(&found.fits),
            wide: self.turn_residuals().into_iter().collect(),
            panels: self
                .gyro_histograms()
                .iter()
                .map(Histogram::figure)
                .collect(),
            poses: Some(PoseSphere {
                poses: found.poses.iter().map(|p| p.direction).collect(),
                next: found
                    .add_poses
                    .iter()
                    .take(6)
                    .map(|p| (p.up, p.words.clone()))
                    .collect(),
            }),
            correlation: sheet::correlations(&names, &found.covariance),
            hints,
            ..sheet::blank(&sensors, &self.request.texts, facts)
        }
    }

    fn references(&self, sensors: &[Sensor]) -> Vec<Reference> {
        let mut out = vec![Reference {
            quantity: "Size of gravity".to_owned(),
            standard: page_words(&self.request.place.words(self.gravity_m_s2)),
            uncertainty: "taken as exact".to_owned(),
            in_result: "its error adds to every accelerometer scale factor alike".to_owned(),
        }];
        let samples = self
            .found
            .poses
            .iter()
            .map(|p| (p.end_s - p.start_s) / self.dt_s);
        let mut samples: Vec<f64> = samples.collect();
        samples.sort_by(f64::total_cmp);
        let usual = samples.get(samples.len() / 2).copied().unwrap_or(1.0);
        for sensor in sensors {
            let Some(noise) = self.found.noise[usize::from(*sensor == Sensor::Gyro)] else {
                continue;
            };
            let se = noise.iter().copied().fold(0.0, f64::max) / usual.sqrt();
            out.push(Reference {
                quantity: format!("{} noise in a rest", title(*sensor)),
                standard: "scatter of the rests".to_owned(),
                uncertainty: match sensor {
                    Sensor::Accel => page_words(&in_g(se)),
                    Sensor::Gyro => sheet::rate_words(se),
                },
                in_result: "in every interval".to_owned(),
            });
        }
        out
    }

    fn result_note(&self) -> String {
        let mut out = format!("{EXPANDED}; it covers sensor noise, not the size of gravity.");
        if self.found.fits.iter().any(|f| f.scaled) {
            out.push_str(
                " The uncertainties of a sensor that scatters more than its noise says are enlarged by that scatter.",
            );
        }
        out
    }

    /// |f| − g of each pose.
    fn pose_residuals(&self) -> StationResiduals {
        let found = &self.found;
        let none = || vec![f64::NAN; found.poses.len()];
        let (unit, factor) = if found.accel_rms > 1e-2 {
            ("mg", MG)
        } else {
            ("µg", 1e3 * MG)
        };
        StationResiduals {
            sensor: "accel".to_owned(),
            unit: unit.to_owned(),
            word: "pose".to_owned(),
            labels: (1..=found.poses.len()).map(|i| i.to_string()).collect(),
            axes: [
                found.poses.iter().map(|p| p.residual * factor).collect(),
                none(),
                none(),
            ],
            band: 0.0,
            sigmas: [
                found.poses.iter().map(|p| p.sigma * factor).collect(),
                none(),
                none(),
            ],
            quantity: "|f| − g".to_owned(),
        }
    }

    /// The error of each turn; none without a gyro.
    fn turn_residuals(&self) -> Option<StationResiduals> {
        let turns = &self.found.turns;
        let of = |pick: &dyn Fn(&sagnac_calibrate::multi_position::TurnError) -> f64| -> Vec<f64> {
            turns.iter().map(|t| pick(t).to_degrees()).collect()
        };
        (!turns.is_empty()).then(|| StationResiduals {
            sensor: "gyro".to_owned(),
            unit: "°".to_owned(),
            word: "turn".to_owned(),
            labels: (1..=turns.len()).map(|i| i.to_string()).collect(),
            axes: [
                of(&|t| t.components_rad[0]),
                of(&|t| t.components_rad[1]),
                vec![f64::NAN; turns.len()],
            ],
            band: 0.0,
            sigmas: [
                of(&|t| t.sigma_rad[0]),
                of(&|t| t.sigma_rad[1]),
                vec![f64::NAN; turns.len()],
            ],
            quantity: "direction of gravity where the gyro leads to, less where the accelerometer says: ● and ■, two \
                       components across it"
                .to_owned(),
        })
    }

    /// The gyro at rest before and after.
    fn gyro_histograms(&self) -> Vec<Histogram> {
        let found = &self.found;
        let mut out = Vec::new();
        let rest = |pick: &dyn Fn(&Pose) -> Option<[f64; 3]>| {
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
}
