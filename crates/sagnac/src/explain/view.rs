//! The answer of `explain` as text, JSON, picture and page.

use sagnac_core::Sensor;
use sagnac_report::html::{ExplainPage, Opening, RandomRow, Rich};
use sagnac_report::plots::{ExplainPanel, explain_panels};
use sagnac_report::svg::{Svg, page_number};
use sagnac_report::text::{Document, fixed, general};
use serde_json::{Value, json};

use super::{AxisTerms, DEG, ExplainOutcome, G};
use crate::allan::capitalized;

/// Unit of contributions and of input and output: name and SI value, as text and as on a page.
pub(super) struct Shown {
    term: &'static str,
    term_page: &'static str,
    pub(super) per_si: f64,
    level: &'static str,
    level_page: &'static str,
    level_per_si: f64,
}

pub(super) fn shown(sensor: Sensor) -> Shown {
    match sensor {
        Sensor::Gyro => Shown {
            term: "deg/h",
            term_page: "°/h",
            per_si: 3600.0 / DEG,
            level: "deg/s",
            level_page: "°/s",
            level_per_si: 1.0 / DEG,
        },
        Sensor::Accel => Shown {
            term: "mg",
            term_page: "mg",
            per_si: 1000.0 / G,
            level: "m/s^2",
            level_page: "m/s²",
            level_per_si: 1.0,
        },
    }
}

impl ExplainOutcome {
    /// The JSON document.
    pub fn to_json(&self) -> Value {
        let axes: Vec<Value> = self
            .axes
            .iter()
            .map(|axis| {
                let terms: Vec<Value> = axis
                    .terms
                    .iter()
                    .map(|(term, value)| json!({"term": term, "value": value}))
                    .collect();
                let random: Vec<Value> = axis
                    .random
                    .iter()
                    .map(|(term, sigma)| match term.strip_suffix(", after 1 h") {
                        Some(term) => json!({"term": term, "sigma": sigma, "after_s": 3600.0}),
                        None => json!({"term": term, "sigma": sigma}),
                    })
                    .collect();
                json!({
                    "axis": axis.axis,
                    "input": axis.input,
                    "output": axis.output,
                    "unit": if axis.sensor == Sensor::Gyro { "rad/s" } else { "m/s^2" },
                    "terms": terms,
                    "random": random,
                })
            })
            .collect();
        json!({"model": self.name, "axes": axes, "warnings": self.warnings()})
    }

    fn warnings(&self) -> Vec<String> {
        let outside = self.is_temperature_outside.then(|| {
            "the temperature is outside the model's range: the nearer end is taken".to_owned()
        });
        outside.into_iter().chain(self.no_inverse.clone()).collect()
    }

    /// The largest term of a sensor: axis, term, value.
    fn largest(&self, sensor: Sensor) -> Option<(&AxisTerms, &str, f64)> {
        self.axes
            .iter()
            .filter(|axis| axis.sensor == sensor)
            .filter_map(|axis| {
                axis.terms
                    .first()
                    .map(|(term, value)| (axis, term.as_str(), *value))
            })
            .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
    }

    fn verdict(&self, page: bool) -> String {
        let mut sentences = Vec::new();
        for sensor in Sensor::ALL {
            if let Some((axis, term, value)) = self.largest(sensor) {
                let unit = shown(sensor);
                sentences.push(format!(
                    "{} is the largest {} error here: {} {} on {}.",
                    capitalized(&words(term)),
                    sensor.name(),
                    if page {
                        page_number(&general(value * unit.per_si, 4))
                    } else {
                        general(value * unit.per_si, 4)
                    },
                    if page { unit.term_page } else { unit.term },
                    axis.axis.rsplit('_').next().unwrap_or_default(),
                ));
            }
        }
        if sentences.is_empty() {
            "The model has no deterministic error at this input.".to_owned()
        } else {
            sentences.join(" ")
        }
    }

    /// The text for a terminal.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.paragraph(self.verdict(false));
        for warning in self.warnings() {
            out.warning(warning);
        }
        for sensor in Sensor::ALL {
            let unit = shown(sensor);
            let of_sensor = || self.axes.iter().filter(move |axis| axis.sensor == sensor);
            let sum = |axis: &AxisTerms| axis.terms.iter().map(|t| t.1).sum::<f64>() + 0.0;
            // Bars to the left have 18 columns, to the right 25, one scale for the sensor.
            let values = || {
                of_sensor()
                    .flat_map(move |axis| axis.terms.iter().map(|t| t.1).chain([sum(axis)]))
                    .map(|v| v * unit.per_si)
            };
            let room = |v: f64| if v < 0.0 { 18.0 } else { 25.0 };
            let per_column = values().fold(0.0_f64, |most, v| most.max(v.abs() / room(v)));
            for axis in of_sensor() {
                let level = |x: f64| general(x * unit.level_per_si, 6);
                let head = format!("{}, {}", axis.axis.replace('_', " "), unit.term);
                let tail = format!(
                    "in {} {u}, out {} {u}",
                    level(axis.input),
                    level(axis.output),
                    u = unit.level
                );
                let space = 78_usize.saturating_sub(head.len() + tail.len()).max(2);
                out.blank()
                    .heading(format!("{head}{}{tail}", " ".repeat(space)));
                for (term, value) in &axis.terms {
                    out.line(bar(term, value * unit.per_si, per_column));
                }
                out.line(bar("sum", sum(axis) * unit.per_si, per_column));
            }
            let random = self.random_rows(sensor);
            if !random.is_empty() {
                let mut table = sagnac_report::text::Table::new(
                    &[
                        &format!("{} noise, 1 sigma", sensor.key()),
                        "x",
                        "y",
                        "z",
                        "",
                    ],
                    &[],
                );
                for (term, sigma) in random {
                    let [x, y, z] = sigma;
                    table.row([term, x, y, z, unit.term.to_owned()]);
                }
                out.blank().table(table);
            }
        }
        out
    }

    /// Random terms of a sensor with σ on x, y, z in the unit of its terms.
    fn random_rows(&self, sensor: Sensor) -> Vec<(String, [String; 3])> {
        let per_si = shown(sensor).per_si;
        let axes: Vec<&AxisTerms> = self.axes.iter().filter(|a| a.sensor == sensor).collect();
        let mut names: Vec<&str> = Vec::new();
        for (term, _) in axes.iter().flat_map(|axis| &axis.random) {
            if !names.contains(&term.as_str()) {
                names.push(term);
            }
        }
        let cell = |k: usize, term: &str| {
            let found = axes
                .get(k)
                .and_then(|axis| axis.random.iter().find(|r| r.0 == term));
            found.map_or_else(|| "-".to_owned(), |r| general(r.1 * per_si, 4))
        };
        names
            .into_iter()
            .map(|term| (term.to_owned(), [0, 1, 2].map(|k| cell(k, term))))
            .collect()
    }

    /// The panels of a sensor, for pages and pictures.
    pub fn panels(&self, sensor: Sensor) -> Vec<ExplainPanel> {
        let unit = shown(sensor);
        self.axes
            .iter()
            .filter(|axis| axis.sensor == sensor)
            .map(|axis| ExplainPanel {
                axis: axis.axis.clone(),
                note: page_number(&format!(
                    "input {}, output {} {}",
                    general(axis.input * unit.level_per_si, 6),
                    // One line of a third of the page: m/s^2 takes more room than deg/s.
                    general(
                        axis.output * unit.level_per_si,
                        if sensor == Sensor::Gyro { 7 } else { 6 }
                    ),
                    unit.level_page
                )),
                unit: unit.term_page.to_owned(),
                terms: axis
                    .terms
                    .iter()
                    .map(|(term, value)| (term.clone(), value * unit.per_si))
                    .collect(),
                sum: (axis.terms.iter().map(|t| t.1).sum::<f64>() + 0.0) * unit.per_si,
            })
            .collect()
    }

    /// The page: verdict, input, a panel an axis; `command` is what was typed.
    pub fn to_page(&self, command: &str, version: &str) -> ExplainPage {
        let three = |v: [f64; 3], per_si: f64| {
            page_number(&v.map(|x| general(x * per_si + 0.0, 6)).join(", "))
        };
        let mut input = format!(
            "f = ({}) m/s², ω = ({}) °/s",
            three(self.at.specific_force, 1.0),
            three(self.at.angular_rate, 1.0 / DEG)
        );
        if self.at.angular_acceleration != [0.0; 3] {
            input += &format!(
                ", ω̇ = ({}) rad/s²",
                three(self.at.angular_acceleration, 1.0)
            );
        }
        input += &format!(
            ", T = {} °C",
            page_number(&general(self.at.temperature_c, 5))
        );
        let mut limits = Vec::new();
        if self.is_temperature_outside {
            limits.push(Rich::new().plain(
                "The temperature is outside the model’s range: the terms are taken at its nearer end.",
            ));
        }
        if let Some(why) = &self.no_inverse {
            limits.push(Rich::new().plain(format!("{}.", capitalized(&why.replace('`', "")))));
        }
        ExplainPage {
            opening: Opening {
                name: self.name.clone(),
                subtitle: input,
                verdict: Rich::new().bold(self.verdict(true)),
                version: version.to_owned(),
                command: command.to_owned(),
                method: Rich::new().plain(
                    "The lecture’s equations (1) and (2) term by term; accelerometer terms at the force \
                     that each accelerometer feels where it sits, so that axis offset is that force less the one at the \
                     center. The bars are without run-to-run draws and noise.",
                ),
                limits,
                ..Opening::default()
            },
            gyro: self.panels(Sensor::Gyro),
            accel: self.panels(Sensor::Accel),
            random: Sensor::ALL.map(|sensor| {
                let rows = self.random_rows(sensor).into_iter();
                rows.map(|(term, sigma)| RandomRow {
                    term,
                    sigma: sigma.map(|text| page_number(&text)),
                    unit: shown(sensor).term_page.to_owned(),
                })
                .collect()
            }),
        }
    }

    /// The picture: a row of panels a sensor.
    pub fn svg(&self) -> Svg {
        let row = |sensor| -> Vec<Svg> {
            explain_panels(&self.panels(sensor))
                .iter()
                .map(|figure| figure.svg.captioned(&figure.caption, &figure.caption_rest))
                .collect()
        };
        Svg::sheet(
            &format!("{}: {}", self.name, self.verdict(true)),
            &[row(Sensor::Gyro), row(Sensor::Accel)],
        )
    }
}

/// A line of the text: name, value, and a bar to the left or right of its zero.
fn bar(term: &str, value: f64, per_column: f64) -> String {
    let length = if per_column > 0.0 && value != 0.0 {
        ((value.abs() / per_column).round() as usize).clamp(1, 25)
    } else {
        0
    };
    let marks = "#".repeat(length);
    let number = match value.abs() {
        size if size >= 999_999.5 => format!("{value:.2e}"),
        size if size >= 9_999.995 => fixed(value, 0),
        size if size >= 0.005 || value == 0.0 => format!("{value:.2}"),
        _ => general(value, 2),
    };
    let (left, right) = if value < 0.0 {
        (marks.as_str(), "")
    } else {
        ("", marks.as_str())
    };
    format!("{term:<24} {number:>8}{left:>20}|{right}")
        .trim_end()
        .to_owned()
}

/// A term in words: `g_sensitivity.matrix` is `g sensitivity`.
fn words(term: &str) -> String {
    match term {
        "bias.fixed" => "fixed bias".to_owned(),
        "bias.temperature" => "bias with temperature".to_owned(),
        "scale_factor.fixed" => "scale factor".to_owned(),
        "scale_factor.temperature" => "scale factor with temperature".to_owned(),
        "scale_factor.quadratic" => "quadratic nonlinearity".to_owned(),
        "scale_factor.cubic" => "cubic nonlinearity".to_owned(),
        "scale_factor.asymmetry" => "scale factor asymmetry".to_owned(),
        "cross_axis.fixed" => "cross-axis response".to_owned(),
        "g_sensitivity.matrix" => "g-sensitivity".to_owned(),
        "g2_sensitivity.matrix" => "g^2-sensitivity".to_owned(),
        "range" => "saturation".to_owned(),
        other => other.split('.').next().unwrap_or(other).replace('_', " "),
    }
}
