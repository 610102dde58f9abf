//! Which sensors meet a condition, sorted.

use super::{floor, stability, white_noise};
use crate::Error;
use sagnac_core::Sensor;
use sagnac_model::catalogue::{price_class, quality, technology};
use sagnac_model::{Catalogue, Filter, Model, SortKey};
use sagnac_report::text::{Align, COLUMNS, Cell, Document, Style, Table, Unit, general};
use serde_json::{Value, json};

/// What to list.
#[derive(Debug, Clone, Default)]
pub struct ListRequest {
    /// Which sensors; all where absent.
    pub filter: Option<Filter>,
    /// The order; by name where absent.
    pub sort: Option<SortKey>,
    /// Show the accelerometers' figures in the text, not the gyroscopes'.
    pub accelerometers: bool,
}

/// The sensors found.
#[derive(Debug, Clone)]
pub struct ListOutcome {
    /// In the order asked for.
    pub models: Vec<Model>,
    accelerometers: bool,
}

/// Lists the sensors of a catalogue.
///
/// # Errors
/// A file of the user's own that cannot be read.
pub fn list(catalogue: &Catalogue, request: &ListRequest) -> Result<ListOutcome, Error> {
    let models = catalogue.select(request.filter.as_ref(), request.sort.as_ref())?;
    Ok(ListOutcome {
        models,
        accelerometers: request.accelerometers,
    })
}

impl ListOutcome {
    /// `{"sensors": [{"name", "manufacturer", "technology", "quality", "price_class", "price_evidence", "conflicts"}]}`.
    pub fn to_json(&self) -> Value {
        let sensors: Vec<Value> = self
            .models
            .iter()
            .map(|model| {
                let price = price_class(model);
                json!({
                    "name": model.name(),
                    "manufacturer": model.manufacturer(),
                    "technology": technology(model),
                    "quality": quality(model),
                    "price_class": price.as_ref().map(|price| price.class),
                    "price_evidence": price.as_ref().map(|price| price.evidence.as_str()),
                    "conflicts": conflicts(model),
                })
            })
            .collect();
        json!({ "sensors": sensors })
    }

    /// The list as a document.
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        if self.models.is_empty() {
            document.line("No sensor of the catalogue meets the condition.");
            return document;
        }
        // Names are never cut: where the table is too wide the technology is, then it is left out.
        let table = [Kind::Whole, Kind::Short, Kind::Absent]
            .map(|kind| self.table(kind))
            .into_iter()
            .enumerate()
            .find(|(i, table)| *i == 2 || table.fits(COLUMNS));
        if let Some((_, table)) = table {
            document.table(table).blank();
        }
        let marked = self.models.iter().any(|model| conflicts(model) > 0);
        document.line(
            "D data sheet, M measured on a unit, S second hand; the worst of the numbers used",
        );
        if marked {
            document.line("* sources disagree or print several settings: sagnac catalog show NAME");
        }
        document
    }

    /// The table with the technology told in one of three ways.
    fn table(&self, kind: Kind) -> Table {
        let (sensor, white, units) = if self.accelerometers {
            let units = [Unit::M_PER_S_PER_SQRT_H, Unit::MICRO_G, Unit::MILLI_G];
            (Sensor::Accel, "VRW", units)
        } else {
            let units = [Unit::DEG_PER_SQRT_H, Unit::DEG_PER_H, Unit::DEG_PER_H];
            (Sensor::Gyro, "ARW", units)
        };
        let technology_heading = match kind {
            Kind::Whole => vec!["technology"],
            Kind::Short => vec!["type"],
            Kind::Absent => Vec::new(),
        };
        let numbers = [white, "in-run", "run-to-run"];
        let mut heading = vec!["sensor"];
        heading.extend(&technology_heading);
        heading.extend(numbers);
        heading.push("evidence");
        let mut aligns = vec![Align::Left; 1 + technology_heading.len()];
        aligns.extend([Align::Point; 3]);
        aligns.push(Align::Left);
        let mut table = Table::new(&heading, &aligns);
        let mut unit_row = vec![Cell::from(""); 1 + technology_heading.len()];
        unit_row.extend(units.map(|unit| Cell::from(unit.text)));
        table.row(unit_row);
        for model in &self.models {
            let values = [
                white_noise(model, sensor),
                floor(model, sensor),
                stability(model, sensor),
            ];
            let mut cells = vec![Cell::from(model.name())];
            let technology = technology(model).unwrap_or("-");
            match kind {
                Kind::Whole => cells.push(Cell::from(technology)),
                Kind::Short => {
                    let word = technology.split([' ', '+', ',']).next();
                    cells.push(Cell::from(word.unwrap_or_default()));
                }
                Kind::Absent => {}
            }
            for (value, unit) in values.into_iter().zip(units) {
                cells.push(value.map_or_else(
                    || Cell::from("-"),
                    |value| Cell::from(general(unit.from_si(value), 3)),
                ));
            }
            let mark = if conflicts(model) > 0 { " *" } else { "" };
            cells.push(Cell::from(format!(
                "{}{mark}",
                quality(model).unwrap_or_else(|| "-".to_string())
            )));
            table.row(cells);
        }
        table
    }

    /// The list as text.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}

/// How a list tells the technology.
#[derive(Clone, Copy)]
enum Kind {
    Whole,
    /// Its first word.
    Short,
    Absent,
}

fn conflicts(model: &Model) -> usize {
    model.catalog().map_or(0, |table| table.conflicts.len())
}
