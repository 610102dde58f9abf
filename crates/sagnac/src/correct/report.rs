//! What `correct` says: JSON, warnings and the text for a terminal.

use sagnac_report::text::{Document, Table, clock_span, duration, general, group_thousands};
use serde_json::{Value, json};

use super::CorrectOutcome;

impl CorrectOutcome {
    /// The JSON document.
    pub fn to_json(&self) -> Value {
        let changes: Vec<Value> = self
            .changes
            .iter()
            .map(|c| json!({"axis": c.axis, "mean": c.mean, "largest": c.largest}))
            .collect();
        json!({
            "samples": self.samples,
            "changes": changes,
            "saturated": self.saturated,
            "outside_validity": self.outside_validity,
            "warnings": self.warnings(),
            "notes": self.notes,
        })
    }

    /// Saturated spans, samples outside validity, and what else is to be known, a sentence each.
    fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        for span in &self.spans {
            let level = if span.axis.starts_with("gyro") {
                format!(
                    "{} deg/s",
                    general(span.at * 180.0 / core::f64::consts::PI, 5)
                )
            } else {
                format!("{} g", general(span.at / 9.80665, 5))
            };
            out.push(format!(
                "{}  saturated  {}  {} {} at {level}",
                span.axis,
                clock_span(span.start_s, span.end_s),
                span.count,
                if span.count == 1 { "sample" } else { "samples" }
            ));
        }
        if self.more_spans > 0 {
            out.push(format!("{} more spans are saturated", self.more_spans));
        }
        out.extend(self.warnings.iter().cloned());
        out
    }

    /// The text for a terminal.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.paragraph(format!(
            "Corrected {} {}, {}.",
            group_thousands(&self.samples.to_string()),
            if self.samples == 1 {
                "sample"
            } else {
                "samples"
            },
            duration(self.duration_s)
        ));
        let mut table = Table::new(&["channel", "mean change", "largest change", "unit"], &[]);
        for change in &self.changes {
            let (per_si, unit) = if change.axis.starts_with("gyro") {
                (180.0 / core::f64::consts::PI, "deg/s")
            } else {
                (1000.0 / 9.80665, "mg")
            };
            let number = |x: f64| {
                if x.is_finite() {
                    general(x * per_si, 4)
                } else {
                    "-".to_owned()
                }
            };
            table.row([
                change.axis.clone(),
                number(change.mean),
                number(change.largest),
                unit.to_owned(),
            ]);
        }
        out.blank().table(table).blank();
        for warning in self.warnings() {
            out.warning(warning);
        }
        for note in &self.notes {
            out.note(note.clone());
        }
        out
    }
}
