//! The certificate of a table of stations: one sheet with expanded uncertainties.

use sagnac_core::Sensor;
use sagnac_report::html::{CertificatePage, Input, Reference, ResultRow, ResultTable, Rich};
use sagnac_report::plots::{Color, CorrelationMap, Histogram, StationResiduals};
use sagnac_report::text::{Estimate, significant};

use super::StationsOutcome;
use super::json::rms;
use super::text::{in_g, terms_of, title};
use super::units::shown;

/// What only the caller knows of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PageFacts {
    /// The command as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Inputs with their hashes.
    pub inputs: Vec<(String, String)>,
}

pub(super) fn page_unit(unit: &str) -> String {
    let mut out = unit
        .replace("deg", "°")
        .replace("^2", "²")
        .replace("^3", "³");
    for (from, to) in [("ug", "µg"), ("urad", "µrad")] {
        if let Some(rest) = out.strip_prefix(from) {
            out = format!("{to}{rest}");
        }
    }
    out
}

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
        let place = match (self.request.latitude_rad, self.request.height_m) {
            (Some(phi), Some(h)) => format!("{} , {h:.0} m", latitude(phi)).replace(" ,", ","),
            (Some(phi), None) => latitude(phi),
            _ => String::new(),
        };
        CertificatePage {
            title: match sensors.as_slice() {
                [Sensor::Accel] => "Accelerometer triad".to_owned(),
                [Sensor::Gyro] => "Gyro triad".to_owned(),
                _ => "Inertial measurement unit".to_owned(),
            },
            number: self.request.certificate.clone(),
            issued: String::new(),
            item: self.request.item.clone(),
            customer: self.request.customer.clone(),
            temperature: if temperatures.is_empty() {
                String::new()
            } else if high - low < 0.05 {
                format!("{low:.1} °C")
            } else {
                format!("{low:.1} … {high:.1} °C")
            },
            calibrated: String::new(),
            place,
            gravity: self.gravity_words().replace("m/s^2", "m/s²"),
            verdict: Rich::from(page_words(&self.verdict())),
            method: Rich::from(format!(
                "{} stations with known inputs. Weighted least squares of all stations at once, {} parameters, axis by \
                 axis. The body axes are those of the fixture. Terms and signs as in IEEE Std 1293, 1554 and 528.",
                self.stations.len(),
                self.found.parameters.len()
            )),
            references: self.references(&sensors),
            results: sensors
                .iter()
                .map(|s| self.results(*s, sensors.len() > 1))
                .collect(),
            result_note: Rich::from(self.result_note()),
            residuals: sensors.iter().map(|s| self.residual_plot(*s)).collect(),
            before_after: self.histograms(),
            not_determined: Rich::from(format!(
                "{} Cross-axis response cannot be told from misalignment; the numbers above are their sum.",
                self.not_determined()
            )),
            statement: Rich::new(),
            fits: self.fit_rows(),
            correlation: self.correlations(),
            hints: self.hints(),
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
                    format!("{} °/h", significant(w.to_degrees() * 3600.0, 2))
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
                        Sensor::Gyro => {
                            format!("{} °/h", significant(se.to_degrees() * 3600.0, 2))
                        }
                    }
                }),
                in_result: "in every interval".to_owned(),
            });
        }
        out
    }

    fn results(&self, sensor: Sensor, named: bool) -> ResultTable {
        let rows = terms_of(&self.found, sensor)
            .into_iter()
            .map(|term| {
                let shown = shown(sensor, term);
                let cells = [0, 1, 2].map(|k| {
                    self.found
                        .parameters
                        .iter()
                        .find(|p| p.sensor == sensor && p.axis == k && p.term == Some(term))
                        .map_or(Estimate::Absent, |p| {
                            // Expanded uncertainty: k = 2, or Student's quantile where that is wider.
                            let half = (2.0 * p.sigma).max((p.upper - p.lower) / 2.0);
                            Estimate::plus_minus(p.value, half).scaled(shown.per_si)
                        })
                });
                ResultRow {
                    name: shown.name,
                    cells,
                    unit: page_unit(shown.unit),
                }
            })
            .collect();
        ResultTable {
            heading: if named {
                title(sensor).to_owned()
            } else {
                String::new()
            },
            rows,
        }
    }

    fn result_note(&self) -> String {
        let found = &self.found;
        let chi2: f64 = found.fits.iter().map(|f| f.chi2).sum();
        let dof: usize = found.fits.iter().map(|f| f.dof).sum();
        let mut out = "± is the expanded uncertainty, k = 2, for a coverage of about 95 %; it covers sensor noise and \
                       the errors of the references above, not the size of gravity."
            .to_owned();
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
        let (unit, factor) = match sensor {
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
        let mut se: Vec<f64> = self
            .stations
            .iter()
            .filter_map(|s| s.output_se(sensor))
            .flatten()
            .collect();
        se.sort_by(f64::total_cmp);
        let band = se.get(se.len() / 2).map_or_else(
            || 2.0 * self.found.residual_rms[sensor.index()].unwrap_or(0.0),
            |s| 2.0 * s,
        );
        StationResiduals {
            sensor: sensor.key().to_owned(),
            unit: unit.to_owned(),
            word: "station".to_owned(),
            labels: self.stations.iter().map(|s| s.label.clone()).collect(),
            axes: [of(0), of(1), of(2)],
            band: band * factor,
        }
    }

    fn fit_rows(&self) -> Vec<[String; 4]> {
        self.found
            .fits
            .iter()
            .map(|fit| {
                let p = fit.p.map_or("—".to_owned(), |p| significant(p, 2));
                [
                    fit.axis
                        .replace("gyro_", "Gyro ")
                        .replace("accel_", "Accelerometer "),
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

    fn correlations(&self) -> Option<CorrelationMap> {
        let (names, c) = (&self.found.covariance_names, &self.found.covariance);
        (!names.is_empty()).then(|| CorrelationMap {
            names: names.clone(),
            matrix: (0..names.len())
                .map(|i| {
                    (0..names.len())
                        .map(|j| c[i][j] / (c[i][i] * c[j][j]).sqrt())
                        .collect()
                })
                .collect(),
        })
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

    fn histograms(&self) -> Vec<Histogram> {
        let found = &self.found;
        [
            (
                "calibration-before",
                "Before",
                &found.before_m_s2,
                Color::Fit,
            ),
            ("calibration-after", "After", &found.after_m_s2, Color::Data),
        ]
        .into_iter()
        .filter_map(|(plot, caption, values, color)| {
            let rms = rms(values)?;
            let (unit, factor) = if rms > 1e-3 * 9.80665 {
                ("mg", 1e3 / 9.80665)
            } else {
                ("µg", 1e6 / 9.80665)
            };
            Some(Histogram {
                plot: plot.to_owned(),
                caption: caption.to_owned(),
                caption_rest: format!(": |f| − g, {} rms", page_words(&in_g(rms))),
                x_title: format!("|f| − g, {unit}"),
                values: values.iter().map(|v| v * factor).collect(),
                color,
            })
        })
        .collect()
    }
}

fn latitude(phi_rad: f64) -> String {
    let degrees = phi_rad.to_degrees();
    format!(
        "{:.2}° {}",
        degrees.abs(),
        if degrees < 0.0 { "S" } else { "N" }
    )
}

/// Terminal spelling as on a page.
pub(super) fn page_words(text: &str) -> String {
    text.replace(" ug", " µg")
        .replace(" - g", " − g")
        .replace("m/s^2", "m/s²")
}
