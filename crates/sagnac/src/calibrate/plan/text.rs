//! `calibrate plan` in a terminal.

use sagnac_core::Sensor;
use sagnac_report::text::{Align, Cell, Document, Table, duration, significant};

use super::super::text::{not_determined, terms_of, title};
use super::super::units::shown;
use super::PlanOutcome;

impl PlanOutcome {
    /// The plan as a document.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        let count = |sensor: Sensor| {
            self.found
                .parameters
                .iter()
                .filter(|p| p.sensor == sensor)
                .count()
        };
        let mut words = format!("{}: {} stations", self.name, self.stations.len());
        if self.repeats > 1 {
            words.push_str(&format!(" ({} repeats)", self.repeats));
        }
        if let Some(dwell) = self.dwell_s {
            words.push_str(&format!(
                " of {}, {} in all",
                duration(dwell),
                duration(dwell * self.stations.len() as f64)
            ));
        }
        out.paragraph(format!(
            "{words}. They will determine {} parameters of the accelerometer and {} of the gyro, to these standard errors.",
            count(Sensor::Accel),
            count(Sensor::Gyro)
        ));
        for sensor in [Sensor::Accel, Sensor::Gyro] {
            let terms = terms_of(&self.found, sensor);
            if terms.is_empty() {
                continue;
            }
            let mut table = Table::new(
                &[title(sensor), "x", "y", "z", "1 sigma"],
                &[
                    Align::Left,
                    Align::Right,
                    Align::Right,
                    Align::Right,
                    Align::Left,
                ],
            );
            for term in terms {
                let shown = shown(sensor, term);
                let mut cells: Vec<Cell> = vec![shown.name.into()];
                for k in 0..3 {
                    let sigma = self
                        .found
                        .parameters
                        .iter()
                        .find(|p| p.sensor == sensor && p.axis == k && p.term == Some(term))
                        .map(|p| p.sigma * shown.per_si);
                    cells.push(
                        sigma
                            .map_or_else(|| "-".to_owned(), |s| significant(s, 2))
                            .into(),
                    );
                }
                cells.push(shown.unit.into());
                table.row(cells);
            }
            out.blank();
            out.table(table);
        }
        out.blank();
        out.paragraph(not_determined(&self.found));
        let mean = |e: [f64; 3]| e.into_iter().fold(0.0, f64::max);
        out.note(format!(
            "a mean is taken to be good to {} and {} deg/h{}.",
            super::super::text::in_g(mean(self.errors.accel)),
            significant(mean(self.errors.gyro).to_degrees() * 3600.0, 2),
            if self.errors.tilt_rad > 0.0 {
                format!(
                    ", the levelling to {} deg",
                    significant(self.errors.tilt_rad.to_degrees(), 2)
                )
            } else {
                ", the references to be exact".to_owned()
            }
        ));
        for note in &self.notes {
            out.note(note.clone());
        }
        for text in super::super::text::advice(&self.found) {
            out.hanging("add: ", text);
        }
        out
    }
}
