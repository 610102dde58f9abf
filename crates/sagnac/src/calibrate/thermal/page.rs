//! The page of `calibrate thermal`: curves with bands, heating and cooling, parameters.

use sagnac_calibrate::thermal::{Curve, Kind, channel};
use sagnac_core::Sensor;
use sagnac_report::html::{CalibrationPage, Input, ResultRow, ResultTable, Rich};
use sagnac_report::plots::{ChartCurve, Color, CorrelationMap, CurveChart, Figure, axis_title};
use sagnac_report::text::{Estimate, significant};

use super::ThermalOutcome;
use super::text::{degrees, shown};
use crate::calibrate::PageFacts;
use crate::calibrate::sheet::{page_unit, page_words};
use crate::calibrate::text::title;

impl ThermalOutcome {
    /// The report.
    pub fn to_page(&self, facts: &PageFacts) -> CalibrationPage {
        let found = &self.found;
        let mut limits: Vec<Rich> = found
            .notes
            .iter()
            .map(|n| Rich::from(page_words(n)))
            .collect();
        if !found.held.is_empty() {
            limits.push(Rich::from(format!("Not determined: {}.", self.held())));
        }
        limits.push(Rich::from(format!(
            "Outside {:.1} … {:.1} °C nothing is known: the model holds the value of the nearer end, and `correct` flags \
             the samples.",
            found.range_c[0], found.range_c[1]
        )));
        limits.extend(
            self.advice()
                .into_iter()
                .map(|a| Rich::from(page_words(&a))),
        );
        CalibrationPage {
            name: if self.request.name.is_empty() {
                "Temperature sweep".to_owned()
            } else {
                self.request.name.clone()
            },
            subtitle: "output at rest against temperature".to_owned(),
            verdict: Rich::from(page_words(&self.verdict()).replace("degC", "°C")),
            facts: vec![
                ("Samples".to_owned(), self.samples.to_string()),
                (
                    "Temperature".to_owned(),
                    format!("{:.1} … {:.1} °C", found.range_c[0], found.range_c[1]),
                ),
                ("Branches".to_owned(), found.branches.len().to_string()),
                ("Soaks".to_owned(), found.soaks.len().to_string()),
            ],
            results: [Sensor::Accel, Sensor::Gyro]
                .into_iter()
                .map(|sensor| self.results(sensor))
                .filter(|t| !t.rows.is_empty())
                .collect(),
            result_note: Rich::from(
                "± is half the 95 % interval of the curve at that temperature, with the scatter of the bins about it. The \
                 curve is the middle between heating and cooling.",
            ),
            residuals: Vec::new(),
            before_after: Vec::new(),
            poses: None,
            correlation: Some(self.correlation()),
            figures: found.curves.iter().map(figure).collect(),
            limits,
            method: Rich::from(
                "Samples are averaged in bins of each branch between turning points of the temperature. Output = b(T) ± \
                 ½ h(T); order and form by 10-fold cross-validation over the bins: the smallest order within two standard \
                 errors of the best. Bands by Student's t, widened where neighbouring bins scatter together.",
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

    fn results(&self, sensor: Sensor) -> ResultTable {
        let mut rows = Vec::new();
        for kind in [Kind::Bias, Kind::ScaleFactor] {
            let of = |k: usize| {
                self.found
                    .curves
                    .iter()
                    .find(|c| c.sensor == sensor && c.kind == kind && c.axis == k)
            };
            let Some(first) = (0..3).find_map(of) else {
                continue;
            };
            let (unit, factor) = shown(first);
            let n = first.temperature_c.len();
            for i in (0..n).step_by((n - 1) / 4) {
                let word = match kind {
                    Kind::Bias => "Bias",
                    Kind::ScaleFactor => "Scale factor",
                };
                rows.push(ResultRow {
                    name: format!("{word} at {} °C", degrees(first.temperature_c[i])),
                    cells: [0, 1, 2].map(|k| {
                        of(k).map_or(Estimate::Absent, |c| {
                            Estimate::detected(c.value[i], c.lower[i], c.upper[i]).scaled(factor)
                        })
                    }),
                    unit: page_unit(unit),
                    ..ResultRow::default()
                });
            }
        }
        ResultTable {
            heading: title(sensor).to_owned(),
            sensor: sensor.key().to_owned(),
            rows,
        }
    }

    fn correlation(&self) -> CorrelationMap {
        let c = &self.found.covariance;
        CorrelationMap {
            names: self
                .found
                .parameters
                .iter()
                .map(|p| p.name.clone())
                .collect(),
            matrix: (0..c.len())
                .map(|i| {
                    (0..c.len())
                        .map(|j| {
                            let size = (c[i][i] * c[j][j]).sqrt();
                            if size > 0.0 { c[i][j] / size } else { 0.0 }
                        })
                        .collect()
                })
                .collect(),
        }
    }
}

/// The curve of one axis with its band, heating and cooling beside it.
fn figure(curve: &Curve) -> Figure {
    let (unit, factor) = shown(curve);
    let scaled = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| v * factor).collect() };
    let name = channel(curve.sensor, curve.axis);
    let word = match curve.kind {
        Kind::Bias => "output",
        Kind::ScaleFactor => "scale factor",
    };
    let mut curves = vec![ChartCurve {
        label: "middle".to_owned(),
        color: Color::Fit,
        x: curve.temperature_c.clone(),
        y: scaled(&curve.value),
        lower: scaled(&curve.lower),
        upper: scaled(&curve.upper),
        series: "fit".to_owned(),
        ..ChartCurve::default()
    }];
    if curve.kind == Kind::Bias {
        for (sign, label) in [(1.0, "heating"), (-1.0, "cooling")] {
            let mut points: Vec<[f64; 3]> = curve
                .bins
                .iter()
                .copied()
                .filter(|b| b[2] * sign > 0.0)
                .collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            if points.len() > 1 {
                curves.push(ChartCurve {
                    label: label.to_owned(),
                    color: Color::Data,
                    x: points.iter().map(|p| p[0]).collect(),
                    y: points.iter().map(|p| p[1] * factor).collect(),
                    dashed: sign < 0.0,
                    ..ChartCurve::default()
                });
            }
        }
    }
    let chart = CurveChart {
        id: format!("thermal-{name}-{}", curve.kind.key()),
        title: format!("{} against temperature", axis_title(&name)),
        x_title: "temperature, °C".to_owned(),
        y_title: format!("{word}, {}", page_unit(unit)),
        x_log: false,
        y_log: false,
        from_zero: false,
        curves,
        width: 360.0,
        height: 270.0,
    };
    let rest = curve.hysteresis.map_or(String::new(), |h| {
        format!(
            ": heating − cooling at most {} {} at {} °C",
            significant(h.largest * factor, 2),
            page_unit(unit),
            degrees(h.at_c)
        )
    });
    Figure::new(
        "thermal-curve",
        &name,
        &axis_title(&name),
        &rest,
        chart.draw(),
    )
}
