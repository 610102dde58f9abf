//! The certificate of a table of stations: one sheet with expanded uncertainties.

use sagnac_calibrate::stations::AxisFit;
use sagnac_core::Sensor;
use sagnac_report::html::{CertificatePage, Reference, Rich};
use sagnac_report::plots::StationResiduals;
use sagnac_report::text::significant;

use super::StationsOutcome;
use super::sheet::{self, EXPANDED, PageFacts, page_words};
use super::text::{in_g, terms_of, title};

impl StationsOutcome {
    /// The certificate.
    pub fn to_page(&self, facts: &PageFacts) -> CertificatePage {
        let sensors: Vec<Sensor> = [Sensor::Accel, Sensor::Gyro]
            .into_iter()
            .filter(|s| !terms_of(&self.found, *s).is_empty())
            .collect();
        let temperatures: Vec<f64> = self
            .stations
            .iter()
            .filter_map(|s| s.temperature_c)
            .collect();
        let low = temperatures.iter().copied().fold(f64::INFINITY, f64::min);
        let high = temperatures
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        CertificatePage {
            temperature: if temperatures.is_empty() {
                String::new()
            } else if high - low < 0.05 {
                format!("{low:.1} °C")
            } else {
                format!("{low:.1} … {high:.1} °C")
            },
            place: sheet::place(self.request.latitude_rad, self.request.height_m),
            gravity: self.gravity_words().replace("m/s^2", "m/s²"),
            verdict: Rich::from(page_words(&self.verdict())),
            method: Rich::from(format!(
                "{} stations with known inputs. Weighted least squares of all stations at once, {} parameters, axis by \
                 axis. The body axes are those of the fixture. Terms and signs as in IEEE Std 1293, 1554 and 528.",
                self.stations.len(),
                self.found.parameters.len()
            )),
            references: self.references(&sensors),
            results: sheet::results(&self.found.parameters),
            result_note: Rich::from(self.result_note()),
            residuals: sensors.iter().map(|s| self.residual_plot(*s)).collect(),
            before_after: sheet::magnitudes(&self.found.before_m_s2, &self.found.after_m_s2),
            not_determined: Rich::from(format!(
                "{} Cross-axis response cannot be told from misalignment; the numbers above are their sum.",
                self.not_determined()
            )),
            fits: fit_rows(&self.found.fits),
            correlation: sheet::correlations(&self.found.covariance_names, &self.found.covariance),
            hints: self.hints(),
            ..sheet::blank(&sensors, &self.request.texts, facts)
        }
    }

    fn references(&self, sensors: &[Sensor]) -> Vec<Reference> {
        let mut out = Vec::new();
        let largest = |pick: &dyn Fn(&sagnac_calibrate::stations::Station) -> f64| {
            self.stations.iter().map(pick).fold(0.0, f64::max)
        };
        let top = |v: [f64; 3]| v.iter().copied().fold(0.0, f64::max);
        if sensors.contains(&Sensor::Accel) {
            let f = largest(&|s| top(s.f_sigma));
            out.push(Reference {
                quantity: "Specific force".to_owned(),
                standard: "as in the table of stations".to_owned(),
                uncertainty: if f > 0.0 {
                    page_words(&in_g(f))
                } else {
                    "taken as exact".to_owned()
                },
                in_result: if f > 0.0 {
                    "in every interval".to_owned()
                } else {
                    "none".to_owned()
                },
            });
            out.push(Reference {
                quantity: "Size of gravity".to_owned(),
                standard: self.gravity_words().replace("m/s^2", "m/s²"),
                uncertainty: "not in the table".to_owned(),
                in_result: "its error adds to every scale factor alike".to_owned(),
            });
        }
        if sensors.contains(&Sensor::Gyro) {
            let w = largest(&|s| top(s.w_sigma));
            out.push(Reference {
                quantity: "Inertial rate".to_owned(),
                standard: "as in the table of stations".to_owned(),
                uncertainty: if w > 0.0 {
                    sheet::rate_words(w)
                } else {
                    "taken as exact".to_owned()
                },
                in_result: if w > 0.0 {
                    "in every interval".to_owned()
                } else {
                    "none".to_owned()
                },
            });
        }
        let noise = |sensor: Sensor| {
            let mut all: Vec<f64> = self
                .stations
                .iter()
                .filter_map(|s| s.output_se(sensor))
                .flatten()
                .collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied()
        };
        for sensor in sensors {
            out.push(Reference {
                quantity: format!("{} noise in a dwell", title(*sensor)),
                standard: "scatter of the dwell".to_owned(),
                uncertainty: noise(*sensor).map_or("from the residuals".to_owned(), |se| {
                    match sensor {
                        Sensor::Accel => page_words(&in_g(se)),
                        Sensor::Gyro => sheet::rate_words(se),
                    }
                }),
                in_result: "in every interval".to_owned(),
            });
        }
        out
    }

    fn result_note(&self) -> String {
        let found = &self.found;
        let chi2: f64 = found.fits.iter().map(|f| f.chi2).sum();
        let dof: usize = found.fits.iter().map(|f| f.dof).sum();
        let mut out = format!(
            "{EXPANDED}; it covers sensor noise and the errors of the references above, not the size of gravity."
        );
        if found.fits.iter().any(|f| f.p.is_some()) {
            out.push_str(&format!(
                " Goodness of fit: χ² = {} at {dof} degrees of freedom, the worst axis has p = {}.",
                significant(chi2, 3),
                significant(found.fits.iter().filter_map(|f| f.p).fold(1.0, f64::min), 2)
            ));
        }
        if found.fits.iter().any(|f| f.scaled) {
            out.push_str(" The uncertainties of axes whose stations scatter more than stated are enlarged by that scatter.");
        }
        out
    }

    fn residual_plot(&self, sensor: Sensor) -> StationResiduals {
        let rms = self.found.residual_rms[sensor.index()].unwrap_or(0.0);
        let (unit, factor) = match sensor {
            Sensor::Accel if rms > 1e-2 => ("mg", 1e3 / 9.80665),
            Sensor::Accel => ("µg", 1e6 / 9.80665),
            Sensor::Gyro => ("°/h", 3600f64.to_degrees()),
        };
        let of = |k: usize| -> Vec<f64> {
            self.found
                .residuals
                .iter()
                .map(|r| match sensor {
                    Sensor::Accel => r.accel[k],
                    Sensor::Gyro => r.gyro[k],
                })
                .map(|v| v.map_or(f64::NAN, |v| v * factor))
                .collect()
        };
        let sigmas = |k: usize| -> Vec<f64> {
            self.found
                .residuals
                .iter()
                .map(|r| match sensor {
                    Sensor::Accel => r.accel_sigma[k],
                    Sensor::Gyro => r.gyro_sigma[k],
                })
                .map(|v| v.map_or(f64::NAN, |v| v * factor))
                .collect()
        };
        StationResiduals {
            sensor: sensor.key().to_owned(),
            unit: unit.to_owned(),
            word: "station".to_owned(),
            labels: self.stations.iter().map(|s| s.label.clone()).collect(),
            axes: [of(0), of(1), of(2)],
            band: 2.0 * rms * factor,
            sigmas: [sigmas(0), sigmas(1), sigmas(2)],
            quantity: String::new(),
        }
    }

    /// Estimates that are right only as far as held terms are zero, pairs that are hard to tell apart, what to add.
    fn hints(&self) -> Vec<Rich> {
        let mut out = Vec::new();
        let mut by_held: Vec<(String, Vec<String>)> = Vec::new();
        for p in &self.found.parameters {
            for held in p.assumes.iter().map(|h| super::text::stem(h)) {
                let name = super::text::stem(&p.name);
                match by_held.iter_mut().find(|(h, _)| *h == held) {
                    Some((_, names)) if names.contains(&name) => {}
                    Some((_, names)) => names.push(name),
                    None => by_held.push((held, vec![name])),
                }
            }
        }
        for (held, names) in by_held {
            out.push(
                Rich::new()
                    .bold(format!("{held} is held at zero."))
                    .plain(format!(
                        " {} would be shifted by more than the uncertainty if it had its usual size.",
                        names.join(", ")
                    )),
            );
        }
        for (a, b, r) in self.found.confused.iter().take(6) {
            out.push(Rich::new().plain(format!(
                "{a} and {b} can hardly be told apart (correlation {}).",
                significant(*r, 3)
            )));
        }
        for text in self.advice() {
            out.push(
                Rich::new()
                    .bold("Add.")
                    .plain(format!(" {}", page_words(&text))),
            );
        }
        out
    }
}

/// Goodness of fit by axis, as the second sheet shows it.
pub(super) fn fit_rows(fits: &[AxisFit]) -> Vec<[String; 4]> {
    fits.iter()
        .map(|fit| {
            let p = fit.p.map_or("—".to_owned(), |p| significant(p, 2));
            [
                match fit.axis.as_str() {
                    "gyro" => title(Sensor::Gyro).to_owned(),
                    "accel" => title(Sensor::Accel).to_owned(),
                    axis => axis
                        .replace("gyro_", "Gyro ")
                        .replace("accel_", "Accelerometer "),
                },
                significant(fit.chi2, 3),
                fit.dof.to_string(),
                if fit.scaled {
                    format!("{p}, enlarged")
                } else {
                    p
                },
            ]
        })
        .collect()
}
