//! The text, the picture and the page of `drift` on a recording.

use sagnac_report::html::{HtmlCell, HtmlTable, Opening, RecordingPage, Rich};
use sagnac_report::plots::{ChartCurve, Color, CurveChart, Figure};
use sagnac_report::text::{Align, Cell, Document, Style, Table, significant};
use serde_json::{Value, json};

use super::RecordingOutcome;

const HEADINGS: [&str; 5] = [
    "time",
    "starts",
    "recorded, m",
    "corrected, m",
    "predicted, m",
];

fn number(x: Option<f64>) -> String {
    x.map_or("-".to_owned(), |x| significant(x, 3))
}

impl RecordingOutcome {
    /// `{"horizon_s", "starts", "rms_raw_m", "rms_corrected_m", "rms_predicted_m"}`.
    pub fn to_json(&self) -> Value {
        json!({
            "sensor": self.sensor,
            "horizon_s": self.horizon_s,
            "starts": self.starts,
            "rms_raw_m": self.raw_m,
            "rms_corrected_m": self.corrected_m,
            "rms_predicted_m": self.predicted_m,
        })
    }

    /// The answer in a sentence.
    pub fn verdict(&self) -> String {
        let last = (0..self.horizon_s.len()).rfind(|&h| self.starts[h] > 0);
        last.map_or_else(
            || "No start counts: log and reference have gaps near every one of them.".to_owned(),
            |h| {
                let starts = match self.starts[h] {
                    1 => "one start".to_owned(),
                    n => format!("RMS over {n} starts"),
                };
                format!(
                    "After {} s the log as recorded is off by {} m ({starts}), corrected by the model by {} m; the model predicts {} m.",
                    self.horizon_s[h],
                    number(self.raw_m[h]),
                    number(self.corrected_m[h]),
                    number(self.predicted_m[h])
                )
            },
        )
    }

    /// The cells of a horizon's row.
    fn cells(&self, h: usize) -> [String; 5] {
        [
            format!("{} s", self.horizon_s[h]),
            self.starts[h].to_string(),
            number(self.raw_m[h]),
            number(self.corrected_m[h]),
            number(self.predicted_m[h]),
        ]
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut doc = Document::new();
        doc.paragraph(self.verdict()).blank();
        let mut aligns = [Align::Point; 5];
        aligns[..2].fill(Align::Right);
        let mut table = Table::new(&HEADINGS, &aligns);
        for h in 0..self.horizon_s.len() {
            table.row(self.cells(h).map(Cell::from));
        }
        doc.table(table);
        doc
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }

    /// Error against time since the start: as recorded, corrected, predicted.
    pub fn chart(&self) -> CurveChart {
        let curve = |label: &str, color, values: &[Option<f64>], dashed| {
            let drawn = |v: &Option<f64>| v.filter(|v| *v > 0.0);
            let (x, y) = self
                .horizon_s
                .iter()
                .zip(values)
                .filter_map(|(t, v)| Some((*t, drawn(v)?)))
                .unzip();
            ChartCurve {
                label: label.to_owned(),
                color,
                x,
                y,
                dashed,
                series: if dashed {
                    "fit".to_owned()
                } else {
                    String::new()
                },
                ..ChartCurve::default()
            }
        };
        CurveChart {
            id: "drift-growth".to_owned(),
            title: "Growth of the position error of a recording in time".to_owned(),
            x_title: "time since the start, s".to_owned(),
            y_title: "3-D position error, RMS, m".to_owned(),
            curves: vec![
                curve("as recorded", Color::Y, &self.raw_m, false),
                curve("corrected", Color::X, &self.corrected_m, false),
                curve("predicted", Color::Ink, &self.predicted_m, true),
            ],
            width: 860.0,
            height: 420.0,
            ..CurveChart::default()
        }
    }

    /// The page.
    pub fn page(&self, opening: Opening) -> RecordingPage {
        let wide = self.chart();
        let narrow = CurveChart {
            id: "drift-growth-narrow".to_owned(),
            width: 350.0,
            height: 320.0,
            ..wide.clone()
        };
        let figure = Figure::new(
            "drift-growth",
            "",
            "Growth in time",
            "; dashed: what the covariance of the model predicts",
            wide.draw(),
        )
        .with_narrow(narrow.draw());
        let mut table = HtmlTable::new("recording", &HEADINGS, &[1, 2, 3, 4]);
        for h in 0..self.horizon_s.len() {
            let [time, rest @ ..] = self.cells(h);
            let mut row = vec![HtmlCell::from(time)];
            row.extend(rest.map(HtmlCell::number));
            table.row(row);
        }
        let [log, reference] = &self.labels;
        let without: Vec<String> = (0..self.horizon_s.len())
            .filter(|&h| self.starts[h] == 0)
            .map(|h| format!("{} s", self.horizon_s[h]))
            .collect();
        let mut limits: Vec<Rich> = self
            .warnings
            .iter()
            .map(|warning| Rich::new().plain(format!("{warning}.")))
            .collect();
        if !without.is_empty() {
            limits.push(Rich::new().plain(format!(
                "No start counts for {}: log or reference is too short, or has a gap above 0.05 s near its ends or in between.",
                without.join(", ")
            )));
        }
        RecordingPage {
            opening: Opening {
                name: self.sensor.clone(),
                subtitle: format!("{log} integrated from many starts and compared with {reference}."),
                verdict: Rich::new().bold(self.verdict()),
                method: Rich::new().plain(
                    "A start every 10 s, with the position, velocity and attitude of the reference; the strapdown runs on with the height free. The error is the 3-D distance to the reference, RMS over the starts. Predicted: the covariance of the corrected sensor along the same paths, perfect start.",
                ),
                limits,
                ..opening
            },
            figure,
            table,
        }
    }
}
