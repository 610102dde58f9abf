//! The text of `response`: the answer in words, then a row a term.

use sagnac_report::text::{Align, Cell, Document, Estimate, Table, significant};

use super::{RecordUnit, ResponseOutcome};

/// A unit that numbers of one kind are shown in.
pub(super) struct Shown {
    pub(super) name: String,
    pub(super) factor: f64,
}

/// A line of the results.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) value: String,
    pub(super) unit: String,
    pub(super) more: String,
}

impl Shown {
    /// The record's own unit, or a finer one of the same dimension where the numbers would be small.
    pub(super) fn of(unit: &RecordUnit, magnitude_si: f64) -> Self {
        let RecordUnit::Known(own) = unit else {
            let name = match unit {
                RecordUnit::Label(text) => text.clone(),
                RecordUnit::Known(_) => String::new(),
            };
            return Self { name, factor: 1.0 };
        };
        let finer: &[(&str, f64)] = match own.text() {
            "deg/s" | "dps" | "°/s" => &[("mdps", 1.0 / (1e-3f64).to_radians())],
            "m/s^2" | "m/s²" => &[("mm/s^2", 1e3)],
            "g" => &[("mg", 1e3 / 9.80665), ("ug", 1e6 / 9.80665)],
            "rad/s" => &[("mrad/s", 1e3)],
            _ => &[],
        };
        let mut shown = Self {
            name: own.text().to_owned(),
            factor: 1.0 / own.factor(),
        };
        for (name, factor) in finer {
            if magnitude_si * shown.factor >= 0.1 {
                break;
            }
            shown = Self {
                name: (*name).to_owned(),
                factor: *factor,
            };
        }
        shown
    }

    pub(super) fn number(&self, value_si: f64, digits: usize) -> String {
        significant(value_si * self.factor, digits)
    }
}

impl ResponseOutcome {
    /// The unit of small outputs: errors, repeatability, residuals.
    pub(super) fn shown_small(&self) -> Shown {
        let r = &self.response;
        let small = r
            .accuracy
            .as_ref()
            .map_or(0.0, |a| a.mean.abs())
            .max(r.precision.as_ref().map_or(0.0, |p| p.value));
        Shown::of(
            &self.output,
            if small > 0.0 { small } else { r.residual_sigma },
        )
    }

    /// The results, a line a term.
    pub(super) fn rows(&self) -> Vec<Row> {
        let r = &self.response;
        let y = self.shown_small();
        let x_fine = Shown::of(
            &self.reference,
            r.resolution.as_ref().map_or(r.full_scale, |s| s.value),
        );
        let x = Shown::of(&self.reference, r.full_scale);
        let full_output = r.sensitivity.value.abs() * r.full_scale;
        let percent = |value: f64| significant(100.0 * value / full_output, 3);
        let mut out = Vec::new();
        let mut row = |name: &'static str, value: String, unit: &str, more: String| {
            out.push(Row {
                name,
                value,
                unit: unit.to_owned(),
                more,
            });
        };
        if let Ok(a) = &r.accuracy {
            let [low, high] = a.single_reading;
            let more = format!(
                "mean error; one reading {} … {}",
                y.number(low, 2),
                y.number(high, 2)
            );
            row("Accuracy", y.number(a.mean, 3), &y.name, more);
        }
        if let Ok(p) = &r.precision {
            row(
                "Precision",
                y.number(p.value, 3),
                &y.name,
                format!("{} … {}", y.number(p.lower, 3), y.number(p.upper, 3)),
            );
        }
        if let Ok(s) = &r.resolution {
            let step = r
                .lsb
                .map_or("no rounding step in the data".to_owned(), |lsb| {
                    format!("rounding step {} {}", y.number(lsb, 3), y.name)
                });
            row("Resolution", x_fine.number(s.value, 3), &x_fine.name, step);
        }
        let (sensitivity, unit) = self.sensitivity_text();
        row(
            "Sensitivity",
            sensitivity.value,
            &unit,
            sensitivity.interval,
        );
        if let Ok(l) = &r.linearity {
            row(
                "Linearity",
                percent(l.least_squares),
                "% of FS",
                format!(
                    "{} {}; minimax {} {}",
                    y.number(l.least_squares, 3),
                    y.name,
                    y.number(l.minimax, 3),
                    y.name
                ),
            );
        }
        if let Ok(h) = &r.hysteresis {
            row(
                "Hysteresis",
                percent(h.value),
                "% of FS",
                format!(
                    "{} {}, at {} {}",
                    y.number(h.value, 3),
                    y.name,
                    x.number(h.at, 3),
                    x.name
                ),
            );
        }
        if let Ok(a) = &r.asymmetry {
            let text = Estimate::detected(a.value * 1e6, a.lower * 1e6, a.upper * 1e6).text();
            row("Asymmetry", text.value, "ppm", text.interval);
        }
        if let Ok(t) = &r.threshold {
            row(
                "Threshold",
                x.number(t.value, 3),
                &x.name,
                "the smallest input that is answered".to_owned(),
            );
            row(
                "Dead band",
                x.number(t.dead_band, 3),
                &x.name,
                "as fine as the points are".to_owned(),
            );
        }
        out
    }

    /// What the record cannot give, and why.
    pub(super) fn not_given(&self) -> Vec<(&'static str, &'static str)> {
        let r = &self.response;
        let mut out = Vec::new();
        let mut note = |name: &'static str, reason: Option<&&'static str>| {
            out.extend(reason.map(|reason| (name, *reason)));
        };
        note("accuracy", r.accuracy.as_ref().err());
        note("precision", r.precision.as_ref().err());
        note("resolution", r.resolution.as_ref().err());
        note("linearity", r.linearity.as_ref().err());
        note("hysteresis", r.hysteresis.as_ref().err());
        note("asymmetry", r.asymmetry.as_ref().err());
        note("threshold, dead band", r.threshold.as_ref().err());
        out
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let r = &self.response;
        let x = Shown::of(&self.reference, r.full_scale);
        let mut table = Table::new(
            &["", "", "", ""],
            &[Align::Left, Align::Point, Align::Left, Align::Left],
        );
        for row in self.rows() {
            table.row([
                Cell::from(row.name),
                Cell::from(row.value),
                Cell::from(row.unit),
                Cell::from(row.more),
            ]);
        }
        let mut document = Document::new();
        document
            .paragraph(self.verdict(&self.shown_small()))
            .blank()
            .table(table)
            .blank();
        let mut closing = format!("Full scale {} {}.", x.number(r.full_scale, 4), x.name);
        if r.accuracy.is_ok() {
            closing.push_str(" Accuracy holds only as far as the reference is true.");
        }
        document.paragraph(closing);
        for (name, reason) in self.not_given() {
            document.hanging("Not given: ", format!("{name}: {reason}"));
        }
        document
    }

    /// The same as plain text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(sagnac_report::text::Style::PLAIN)
    }

    /// S with its half interval, and its unit in the record's own units.
    pub(super) fn sensitivity_text(&self) -> (sagnac_report::text::EstimateText, String) {
        let s = &self.response.sensitivity;
        let (factor, unit) = match (&self.output, &self.reference) {
            (RecordUnit::Known(y), RecordUnit::Known(x)) if y.exponents() == x.exponents() => {
                (1.0, String::new())
            }
            (y, x) => (x.factor() / y.factor(), super::per(&own(y), &own(x))),
        };
        let mut text =
            Estimate::detected(s.value * factor, s.lower * factor, s.upper * factor).text();
        // Readings on a line have no scatter; the interval is said all the same.
        if text.interval.is_empty() {
            "± 0".clone_into(&mut text.interval);
        }
        (text, unit)
    }

    pub(super) fn verdict(&self, y: &Shown) -> String {
        let r = &self.response;
        match (&r.accuracy, &r.precision) {
            (Ok(a), Ok(p)) => {
                let word = if a.mean.abs() > p.value {
                    "More precise than accurate"
                } else {
                    "As accurate as it is precise"
                };
                format!(
                    "{word}: readings repeat to {} {} and are off by {} {} in the mean.",
                    y.number(p.value, 2),
                    y.name,
                    y.number(a.mean.abs(), 2),
                    y.name
                )
            }
            (Err(_), Ok(p)) => format!("Readings repeat to {} {}.", y.number(p.value, 2), y.name),
            (Ok(a), Err(_)) => format!(
                "Readings are off by {} {} in the mean; no point was read twice in one direction.",
                y.number(a.mean.abs(), 2),
                y.name
            ),
            (Err(_), Err(_)) => format!(
                "{} readings give a line with a scatter of {} {}.",
                self.readings.len(),
                y.number(r.residual_sigma, 2),
                y.name
            ),
        }
    }
}

pub(super) fn own(unit: &RecordUnit) -> String {
    match unit {
        RecordUnit::Known(unit) => unit.text().to_owned(),
        RecordUnit::Label(text) => text.clone(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use crate::response::{ResponseRequest, response};

    #[test]
    fn readings_on_a_line_have_an_interval_of_zero() {
        let table = "reference [deg/s],output [V]\n-10,-2\n0,0\n10,2\n0,0\n-10,-2\n10,2\n";
        let request = ResponseRequest {
            table: table.into(),
            label: "bench.csv".into(),
            ..ResponseRequest::default()
        };
        let (text, _) = response(&request).unwrap().sensitivity_text();
        assert!(text.interval.contains('±'), "{text:?}");
    }
}
