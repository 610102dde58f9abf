//! Tables of calibrated parameters, in the units of the field and in SI, and the choice between them.

use core::fmt::Write as _;

use super::characterize::figures;
use crate::svg::{escape, page_number};
use crate::text::Estimate;

/// A row of results: one parameter of x, y, z in one unit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResultRow {
    /// Name: `Bias`, `Misalignment to x`.
    pub name: String,
    /// Name that scripts know: `bias`, `scale_factor.temperature.1`; empty: none.
    pub term: String,
    /// x, y, z in the unit shown, with the interval that is stated.
    pub cells: [Estimate; 3],
    /// Unit: `µg`.
    pub unit: String,
    /// The SI unit and how many of the unit shown make one of it; empty: the row has no other unit.
    pub si: (String, f64),
}

/// Results of one sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResultTable {
    /// Heading: `Accelerometer`; empty: none.
    pub heading: String,
    /// `gyro` or `accel`; empty: of no sensor.
    pub sensor: String,
    /// Its rows.
    pub rows: Vec<ResultRow>,
}

impl ResultRow {
    fn has_si(&self) -> bool {
        self.si.1 != 0.0 && self.si.1.is_finite()
    }

    fn write_cell(&self, axis: usize, out: &mut String) {
        let estimate = self.cells[axis];
        let _ = write!(
            out,
            "<td class=\"n\" data-axis=\"{}\" data-status=\"{}\">",
            ["x", "y", "z"][axis],
            estimate.status()
        );
        if matches!(estimate, Estimate::Absent) {
            out.push_str("—</td>");
            return;
        }
        let text = estimate.text();
        let class = if self.has_si() {
            " class=\"u-field\""
        } else {
            ""
        };
        let _ = write!(
            out,
            "<span{class}><b>{}</b><span class=\"i\">{}</span></span>",
            escape(&page_number(&text.value)),
            escape(&page_number(&text.interval))
        );
        if self.has_si() {
            let (value, interval) = figures(estimate.scaled(1.0 / self.si.1));
            let _ = write!(
                out,
                "<span class=\"u-si\"><b>{value}</b><span class=\"i\">{interval}</span></span>"
            );
        }
        out.push_str("</td>");
    }

    fn write(&self, sensor: &str, out: &mut String) {
        out.push_str("<tr");
        for (key, value) in [("sensor", sensor), ("term", self.term.as_str())] {
            if !value.is_empty() {
                let _ = write!(out, " data-{key}=\"{}\"", escape(value));
            }
        }
        let _ = write!(out, "><th scope=\"row\">{}</th>", escape(&self.name));
        for axis in 0..3 {
            self.write_cell(axis, out);
        }
        out.push_str("<td class=\"of\">");
        if self.has_si() {
            let si = if self.si.0 == "1" { "–" } else { &self.si.0 };
            let _ = write!(
                out,
                "<span class=\"u-field\">{}</span><span class=\"u-si\">{}</span>",
                escape(&self.unit),
                escape(si)
            );
        } else {
            out.push_str(&escape(&self.unit));
        }
        out.push_str("</td></tr>");
    }
}

impl ResultTable {
    /// The table as markup; `name` is the value of `data-table`.
    pub fn html(&self, name: &str) -> String {
        let mut out = format!("<table class=\"blocks\" data-table=\"{}\">", escape(name));
        // A caption stays where a narrow page hides the head of the table.
        if !self.heading.is_empty() {
            let _ = write!(out, "<caption>{}</caption>", escape(&self.heading));
        }
        out.push_str("<thead><tr><th scope=\"col\">Term</th>");
        for axis in ["x", "y", "z"] {
            let _ = write!(out, "<th scope=\"col\" class=\"n\">{axis}</th>");
        }
        out.push_str("<th scope=\"col\">Unit</th></tr></thead><tbody>");
        for row in &self.rows {
            row.write(&self.sensor, &mut out);
        }
        out.push_str("</tbody></table>");
        out
    }
}

/// The choice between the field's units and SI; nothing where no row has both.
pub(super) fn switch(tables: &[ResultTable]) -> String {
    if !tables.iter().flat_map(|t| &t.rows).any(ResultRow::has_si) {
        return String::new();
    }
    unit_switch(&[
        ("field", "pick-field", "u-field", "°/h, µg"),
        ("si", "pick-si", "u-si", "SI"),
    ])
}

/// A choice of units: value, class, id and label of each; the first is chosen. Styles alone make it work.
pub(super) fn unit_switch(choices: &[(&str, &str, &str, &str)]) -> String {
    let mut out = String::from("<fieldset class=\"units\"><legend>Units</legend>");
    for (i, (value, class, id, label)) in choices.iter().enumerate() {
        let checked = if i == 0 { " checked" } else { "" };
        let _ = write!(
            out,
            "<label><input type=\"radio\" name=\"units\" value=\"{value}\" id=\"{id}\" \
             class=\"{class}\"{checked} autocomplete=\"off\">{label}</label>"
        );
    }
    out.push_str("</fieldset>");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_names_its_sensor_its_terms_and_both_units() {
        let table = ResultTable {
            heading: "Gyro".to_owned(),
            sensor: "gyro".to_owned(),
            rows: vec![ResultRow {
                name: "Bias".to_owned(),
                term: "bias".to_owned(),
                cells: [
                    Estimate::plus_minus(412.53, 2.0),
                    Estimate::Absent,
                    Estimate::Absent,
                ],
                unit: "°/h".to_owned(),
                si: ("rad/s".to_owned(), 206_264.8),
            }],
        };
        let html = table.html("parameters");
        for part in [
            "<caption>Gyro</caption>",
            "<tr data-sensor=\"gyro\" data-term=\"bias\">",
            "data-axis=\"x\" data-status=\"detected\"",
            "data-axis=\"y\" data-status=\"absent\"",
            "<span class=\"u-si\"><b>0.002000</b>",
            "<span class=\"u-field\">°/h</span><span class=\"u-si\">rad/s</span>",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
        assert!(switch(&[table]).contains("name=\"units\" value=\"si\""));
    }
}
