//! `calibrate merge` in a terminal.

use sagnac_report::text::{Cell, Document, Table};

use super::super::text::{estimates, rows_of, short_beside, stem, title};
use super::super::units::shown;
use super::MergeOutcome;

impl MergeOutcome {
    /// The result as a document.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        let parameters = self.parameters();
        let count = self.conflicts.len() + self.unequal.len();
        out.paragraph(format!(
            "{} models give {} parameters. {}",
            self.labels.len(),
            self.merged.names.len(),
            match count {
                0 => "None contradicts another (3 sigma).".to_owned(),
                1 => "One number contradicts another (3 sigma).".to_owned(),
                n => format!("{n} numbers contradict others (3 sigma)."),
            }
        ));
        for (sensor, terms) in rows_of(&parameters) {
            let mut table = Table::estimates(&[title(sensor), "x", "y", "z", ""]);
            for term in terms {
                let shown = shown(sensor, term);
                let mut cells: Vec<Cell> = vec![shown.name.into()];
                cells.extend(estimates(&parameters, sensor, term, shown.per_si).map(Cell::from));
                cells.push(shown.unit.into());
                table.row(cells);
            }
            out.blank();
            out.table(table);
        }
        out.blank();
        for words in self.conflict_words() {
            out.warning(words);
        }
        for warning in &self.warnings {
            out.warning(warning.clone());
        }
        if !self.held.is_empty() {
            out.paragraph(format!(
                "Not determined, held at zero: {}.",
                short_beside(&self.held, |s| self
                    .merged
                    .names
                    .iter()
                    .any(|n| stem(n) == s))
            ));
        }
        if self.merged.turned {
            out.note(
                "what was calibrated in the accelerometer's own axes was turned into those of the fixture",
            );
        }
        for note in &self.notes {
            out.note(note.clone());
        }
        out
    }
}
