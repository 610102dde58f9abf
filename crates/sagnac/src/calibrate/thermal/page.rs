//! The certificate of `calibrate thermal`: bias at temperatures, before and after, curves with bands and their residuals.

use sagnac_calibrate::thermal::{Curve, Kind, Parameter};
use sagnac_core::Sensor;
use sagnac_report::html::{CertificatePage, Reference, ResultRow, ResultTable, Rich};
use sagnac_report::plots::{Color, Histogram};
use sagnac_report::text::{Estimate, significant};

use super::ThermalOutcome;
use super::figures::{curve_figure, residual_figure};
use super::text::{degrees, shown};
use crate::calibrate::PageFacts;
use crate::calibrate::json::unit;
use crate::calibrate::sheet::{self, EXPANDED, page_unit, page_words};
use crate::calibrate::text::title;

/// Rows of a curve in the table of results, and of each of two.
const ROWS: usize = 5;
const ROWS_OF_TWO: usize = 3;

impl ThermalOutcome {
    /// The certificate.
    pub fn to_page(&self, facts: &PageFacts) -> CertificatePage {
        let found = &self.found;
        let sensors: Vec<Sensor> = [Sensor::Accel, Sensor::Gyro]
            .into_iter()
            .filter(|s| found.curves.iter().any(|c| c.sensor == *s))
            .collect();
        let [low, high] = found.range_c;
        let names: Vec<String> = found.parameters.iter().map(|p| p.name.clone()).collect();
        let curves = || found.curves.iter();
        let mut not_determined = format!(
            "Outside {low:.1} … {high:.1} °C nothing is known: the model holds the value of the nearer end, and \
             `correct` flags the samples."
        );
        if !found.held.is_empty() {
            not_determined = format!("Not determined: {}. {not_determined}", self.held());
        }
        CertificatePage {
            temperature: minus(&format!("{low:.1} … {high:.1} °C")),
            place: sheet::place(self.request.place.latitude_rad, self.request.place.height_m),
            gravity: if self.request.up.is_some() {
                page_words(&self.request.place.words(self.options.gravity_m_s2))
            } else {
                String::new()
            },
            verdict: Rich::from(minus(&page_words(&self.verdict()))),
            method: Rich::from(format!(
                "The sensor at rest while its temperature is swept; {} samples in bins of each branch between turning \
                 points. Output = b(T) ± ½ h(T); order and form by 10-fold cross-validation, the smallest order within two \
                 standard errors of the best. Covariance by the scatter of the bins and a random walk in time.",
                self.samples
            )),
            references: self.references(&sensors),
            results: sensors.iter().map(|s| self.results(*s)).collect(),
            result_note: Rich::from(format!(
                "{EXPANDED}; it covers the scatter of the bins about the curve. The curve is the middle between heating \
                 and cooling; half their difference is not in the ±."
            )),
            before_after: sensors
                .first()
                .map_or_else(Vec::new, |s| self.histograms(*s)),
            not_determined: Rich::from(minus(&page_words(&not_determined))),
            heading: "output and residuals against temperature".to_owned(),
            // One pair leaves the sheet one sheet.
            panels: sensors
                .iter()
                .skip(1)
                .flat_map(|s| self.histograms(*s))
                .map(|h| h.figure())
                .chain(curves().map(curve_figure))
                .chain(
                    curves()
                        .filter(|c| c.kind == Kind::Bias)
                        .map(residual_figure),
                )
                .collect(),
            coefficients: sensors.iter().map(|s| self.coefficients(*s)).collect(),
            correlation: sheet::correlations(&names, &found.covariance),
            hints: self.hints(),
            ..sheet::blank(&sensors, &self.request.texts, facts)
        }
    }

    fn references(&self, sensors: &[Sensor]) -> Vec<Reference> {
        let mut out = vec![Reference {
            quantity: "Temperature".to_owned(),
            standard: "the log's temperature channel".to_owned(),
            uncertainty: "taken as exact".to_owned(),
            in_result: "its error shifts the curves along temperature".to_owned(),
        }];
        if sensors.contains(&Sensor::Accel)
            && let Some(up) = &self.request.up
        {
            out.push(Reference {
                quantity: "Specific force".to_owned(),
                standard: format!("gravity, with {up} up"),
                uncertainty: "taken as exact".to_owned(),
                in_result: "a tilt adds to the bias of the level axes".to_owned(),
            });
        }
        if sensors.contains(&Sensor::Gyro) {
            out.push(Reference {
                quantity: "Inertial rate".to_owned(),
                standard: "zero: the sensor rests".to_owned(),
                uncertainty: "the Earth's 15 °/h".to_owned(),
                in_result: "it adds to the gyro's bias".to_owned(),
            });
        }
        out
    }

    fn curve(&self, sensor: Sensor, kind: Kind, axis: usize) -> Option<&Curve> {
        self.found
            .curves
            .iter()
            .find(|c| c.sensor == sensor && c.kind == kind && c.axis == axis)
    }

    /// Values of the curves at temperatures of the range.
    fn results(&self, sensor: Sensor) -> ResultTable {
        let mut rows = Vec::new();
        let is_two = (0..3).any(|k| self.curve(sensor, Kind::ScaleFactor, k).is_some());
        let most = if is_two { ROWS_OF_TWO } else { ROWS };
        for kind in [Kind::Bias, Kind::ScaleFactor] {
            let of = |k: usize| self.curve(sensor, kind, k);
            let Some(first) = (0..3).find_map(of) else {
                continue;
            };
            let (unit_shown, factor) = shown(first);
            let has_level = sensor == Sensor::Gyro || self.request.up.is_some();
            let word = match kind {
                Kind::Bias if has_level => "Bias",
                Kind::Bias => "Output",
                Kind::ScaleFactor => "Scale factor",
            };
            let n = first.temperature_c.len();
            for i in (0..n).step_by((n - 1) / (most - 1)) {
                let at = degrees(first.temperature_c[i]);
                rows.push(ResultRow {
                    name: minus(&format!("{word} at {at} °C")),
                    term: kind.key().to_owned(),
                    cells: [0, 1, 2].map(|k| {
                        of(k).map_or(Estimate::Absent, |c| {
                            let half = (2.0 * c.sigma[i]).max(c.upper[i] - c.value[i]);
                            Estimate::plus_minus(c.value[i], half).scaled(factor)
                        })
                    }),
                    unit: page_unit(unit_shown),
                    si: (
                        page_unit(&unit(&format!("{}.{}.x", sensor.key(), kind.key()))),
                        factor,
                    ),
                });
            }
        }
        ResultTable {
            heading: title(sensor).to_owned(),
            sensor: sensor.key().to_owned(),
            rows,
        }
    }

    /// The numbers that the model holds.
    fn coefficients(&self, sensor: Sensor) -> ResultTable {
        let mut terms: Vec<(String, [Option<&Parameter>; 3])> = Vec::new();
        for p in &self.found.parameters {
            let Some((of, rest)) = p.name.split_once('.') else {
                continue;
            };
            let Some((term, axis)) = rest.rsplit_once('.') else {
                continue;
            };
            let Some(k) = ["x", "y", "z"].iter().position(|a| *a == axis) else {
                continue;
            };
            if of != sensor.key() {
                continue;
            }
            let place = terms.iter().position(|(t, _)| t == term);
            let place = place.unwrap_or_else(|| {
                terms.push((term.to_owned(), [None; 3]));
                terms.len() - 1
            });
            terms[place].1[k] = Some(p);
        }
        terms.sort_by_key(|(term, _)| !term.starts_with("bias"));
        let rows = terms.into_iter().map(|(term, of)| {
            let si = of
                .iter()
                .flatten()
                .next()
                .map_or_else(String::new, |p| unit(&p.name));
            let (name, unit_shown, factor) = self.row_words(sensor, &term);
            ResultRow {
                name: minus(&name),
                term,
                cells: of.map(|p| {
                    p.map_or(Estimate::Absent, |p| {
                        let half = (2.0 * p.sigma).max(p.upper - p.value);
                        Estimate::plus_minus(p.value, half).scaled(factor)
                    })
                }),
                unit: page_unit(&unit_shown),
                si: (page_unit(&si), factor),
            }
        });
        ResultTable {
            heading: title(sensor).to_owned(),
            sensor: sensor.key().to_owned(),
            rows: rows.collect(),
        }
    }

    /// Name, unit and how many of it make the SI unit, of `bias.temperature.1` and its like.
    fn row_words(&self, sensor: Sensor, term: &str) -> (String, String, f64) {
        let kind = if term.starts_with("bias") {
            Kind::Bias
        } else {
            Kind::ScaleFactor
        };
        let word = if kind == Kind::Bias {
            "Bias"
        } else {
            "Scale factor"
        };
        let (base, factor) = (0..3)
            .find_map(|k| self.curve(sensor, kind, k))
            .map_or(("", 1.0), shown);
        let zero = degrees(self.options.reference_temperature_c);
        let number: Option<usize> = term.rsplit('.').next().and_then(|n| n.parse().ok());
        let knots = self
            .found
            .splines
            .iter()
            .find(|s| s.sensor == sensor && s.kind == kind);
        match (number, knots) {
            (Some(i), Some(spline)) if term.contains("temperature_spline") => {
                let at = spline.knots_c.get(i - 1).copied().unwrap_or(f64::NAN);
                (
                    format!("{word} at {at:.1} °C, less that at {zero} °C"),
                    base.to_owned(),
                    factor,
                )
            }
            (Some(1), _) => (format!("{word}, temperature"), format!("{base}/K"), factor),
            (Some(i), _) => (
                format!("{word}, temperature {i}"),
                format!("{base}/K^{i}"),
                factor,
            ),
            (None, _) => (format!("{word} at {zero} °C"), base.to_owned(), factor),
        }
    }

    /// Outputs of the bins less their value at T0, and less the curve of the model.
    fn histograms(&self, sensor: Sensor) -> Vec<Histogram> {
        let curves: Vec<&Curve> = (0..3)
            .filter_map(|k| self.curve(sensor, Kind::Bias, k))
            .collect();
        let Some(first) = curves.first() else {
            return Vec::new();
        };
        let (unit_shown, factor) = shown(first);
        let unit_shown = page_unit(unit_shown);
        let [low, high] = self.found.range_c;
        let zero_c = self.options.reference_temperature_c.clamp(low, high);
        let of = |pick: &dyn Fn(&Curve) -> Vec<f64>| -> Vec<f64> {
            curves
                .iter()
                .flat_map(|c| pick(c))
                .map(|v| v * factor)
                .collect()
        };
        let before = of(&|c| {
            let level = at(c, zero_c);
            c.bins.iter().map(|b| b.value - level).collect()
        });
        let after = of(&|c| c.bins.iter().map(|b| b.residual_single).collect());
        let name = title(sensor);
        let zero = degrees(zero_c);
        [
            (
                "calibration-before",
                format!("{name}, before"),
                format!("less its value at {zero} °C"),
                before,
                Color::Fit,
            ),
            (
                "calibration-after",
                format!("{name}, after"),
                "less the curve of the model".to_owned(),
                after,
                Color::Data,
            ),
        ]
        .into_iter()
        .map(|(plot, caption, what, values, color)| {
            let rms =
                (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt();
            Histogram {
                plot: plot.to_owned(),
                caption,
                caption_rest: format!(
                    ": output of each bin and axis, {what}; {} {unit_shown} rms",
                    significant(rms, 3)
                ),
                x_title: format!("output, {unit_shown}"),
                values,
                color,
            }
        })
        .collect()
    }

    /// What was left out, what must be said, what to add.
    fn hints(&self) -> Vec<Rich> {
        let mut out: Vec<Rich> = self
            .findings()
            .into_iter()
            .map(|f| {
                let when = f.span_s.map_or_else(String::new, |(a, b)| {
                    format!(
                        " {} – {}",
                        sagnac_report::text::clock(a),
                        sagnac_report::text::clock(b)
                    )
                });
                Rich::new()
                    .bold(format!("Motion{when}."))
                    .plain(format!(" {}", page_words(&f.text)))
            })
            .collect();
        out.extend(
            self.found
                .notes
                .iter()
                .map(|n| Rich::from(page_words(&sentence(n)))),
        );
        out.extend(self.advice().iter().map(|a| {
            Rich::new()
                .bold("Add.")
                .plain(format!(" {}", page_words(a).replace(" -> ", " → ")))
        }));
        out
    }
}

/// Negative numbers with the sign that a page has.
fn minus(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let is_sign = |i: usize| {
        letters[i] == '-'
            && (i == 0 || letters[i - 1] == ' ')
            && letters.get(i + 1).is_some_and(char::is_ascii_digit)
    };
    (0..letters.len())
        .map(|i| if is_sign(i) { '−' } else { letters[i] })
        .collect()
}

/// A note as a sentence of a page.
fn sentence(note: &str) -> String {
    let mut letters = note.chars();
    let first = letters.next().map(char::to_uppercase);
    let mut out: String = first.into_iter().flatten().chain(letters).collect();
    out.push('.');
    out
}

/// A curve at a temperature, between its points.
fn at(curve: &Curve, t_c: f64) -> f64 {
    let next = curve
        .temperature_c
        .partition_point(|t| *t < t_c)
        .clamp(1, curve.temperature_c.len() - 1);
    let (t, v) = (&curve.temperature_c, &curve.value);
    let share = (t_c - t[next - 1]) / (t[next] - t[next - 1]);
    v[next - 1] + share * (v[next] - v[next - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_numbers_have_the_sign_of_a_page() {
        assert_eq!(minus("-18 … 74 °C, at -0.5"), "−18 … 74 °C, at −0.5");
        assert_eq!(minus("--up +z,-z, in-run"), "--up +z,-z, in-run");
    }
}
