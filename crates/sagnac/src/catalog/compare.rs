//! Sensors side by side, a row a parameter.

use super::{floor, letter, white_noise, words};
use crate::Error;
use sagnac_core::Sensor;
use sagnac_model::catalogue::technology;
use sagnac_model::units::{Dimension, Unit};
use sagnac_model::{Catalogue, Model, ParameterPath};
use sagnac_report::text::{Align, Cell, Document, Style, Table, general};
use serde_json::{Value, json};

/// A parameter of all sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareRow {
    /// The path without axis; `gyro.bias.instability` is the Allan floor.
    pub parameter: String,
    /// The unit in SI.
    pub unit: String,
    /// The largest of the axes in SI, a sensor each; none where absent.
    pub values: Vec<Option<f64>>,
    /// 1σ of the largest, where it is a tolerance.
    pub sigmas: Vec<Option<f64>>,
    words: String,
    letters: Vec<String>,
    field_unit: Unit,
}

/// Sensors side by side.
#[derive(Debug, Clone)]
pub struct CompareOutcome {
    /// Their names.
    pub sensors: Vec<String>,
    /// A row a parameter that one of them has.
    pub rows: Vec<CompareRow>,
    technologies: Vec<String>,
}

/// Puts sensors side by side.
///
/// # Errors
/// A name that is not in the catalogue; no name at all.
pub fn compare(catalogue: &Catalogue, names: &[String]) -> Result<CompareOutcome, Error> {
    if names.is_empty() {
        return Err(Error::usage("no sensor is named")
            .advise("write for instance sagnac catalog compare STIM300 LN-200"));
    }
    let models: Vec<Model> = names
        .iter()
        .map(|name| catalogue.find(name))
        .collect::<Result<_, _>>()?;
    Ok(side_by_side(&models))
}

/// Any models side by side.
pub(crate) fn side_by_side(models: &[Model]) -> CompareOutcome {
    let mut paths: Vec<ParameterPath> = models
        .iter()
        .flat_map(|model| model.parameters().map(|(path, _)| path.without_axis()))
        .collect();
    paths.sort_unstable();
    paths.dedup();
    let mut rows: Vec<CompareRow> = Vec::new();
    for path in paths {
        let row = row(models, path);
        if rows.iter().all(|other| other.parameter != row.parameter) {
            rows.push(row);
        }
    }
    CompareOutcome {
        sensors: models
            .iter()
            .map(|model| model.name().to_string())
            .collect(),
        technologies: models
            .iter()
            .map(|model| technology(model).unwrap_or("-").to_string())
            .collect(),
        rows,
    }
}

/// What stands for a key: both keys of the white noise and all of the instability are one row.
fn row(models: &[Model], path: ParameterPath) -> CompareRow {
    let sensor = path.sensor();
    let keys = path.file_keys();
    let instability = keys.starts_with(&["bias", "instability"]);
    let white = keys == ["noise", "noise_density_one_sided"]
        || keys.last() == Some(&Model::white_key(sensor));
    let parameter = if instability {
        format!("{}.bias.instability", sensor.key())
    } else if white {
        format!("{}.noise.{}", sensor.key(), Model::white_key(sensor))
    } else {
        path.to_string()
    };
    let dimension = match (instability, white, sensor) {
        (true, _, Sensor::Gyro) => Dimension::ANGULAR_RATE,
        (true, _, Sensor::Accel) => Dimension::ACCELERATION,
        (_, true, Sensor::Gyro) => Dimension::ANGLE_RANDOM_WALK,
        (_, true, Sensor::Accel) => Dimension::VELOCITY_RANDOM_WALK,
        _ => models
            .iter()
            .find(|model| model.at(path).is_some())
            .map_or_else(|| path.dimension(), |model| model.dimension(path)),
    };
    let same_dimension =
        |model: &&Model| model.dimension(path) == dimension || instability || white;
    let value = |model: &Model| match (instability, white) {
        (true, _) => floor(model, sensor),
        (_, true) => white_noise(model, sensor),
        _ => Some(model)
            .filter(same_dimension)
            .and_then(|model| model.largest(path)),
    };
    let entry = |model: &Model| {
        let of = |key: &str| model.under(sensor, key, 0).cloned();
        match (instability, white) {
            (true, _) => {
                of("bias.instability.coefficient").or_else(|| of("bias.instability.allan_minimum"))
            }
            (_, true) => model.white_noise(sensor, 0),
            _ => model.at(path).cloned(),
        }
    };
    let entries: Vec<_> = models.iter().map(entry).collect();
    let field_unit = if white {
        Unit::field(dimension)
    } else {
        let read = entries
            .iter()
            .flatten()
            .map(|entry| entry.unit.clone())
            .find(|unit| unit.measures(dimension));
        read.unwrap_or_else(|| Unit::field(dimension))
    };
    CompareRow {
        unit: dimension.si_unit(),
        values: models.iter().map(value).collect(),
        sigmas: entries.iter().map(|entry| entry.as_ref()?.sigma).collect(),
        words: format!(
            "{}, {}",
            if white {
                Model::white_key(sensor).replace('_', " ")
            } else {
                words(path)
            },
            sensor.key()
        ),
        letters: entries
            .iter()
            .map(|entry| {
                entry
                    .as_ref()
                    .map(|entry| letter(entry).to_string())
                    .unwrap_or_default()
            })
            .collect(),
        parameter,
        field_unit,
    }
}

impl CompareOutcome {
    /// `{"sensors": [names], "rows": [{"parameter", "unit", "values", "sigmas"}]}`, SI.
    pub fn to_json(&self) -> Value {
        let rows: Vec<Value> = self
            .rows
            .iter()
            .map(|row| json!({ "parameter": row.parameter, "unit": row.unit, "values": row.values, "sigmas": row.sigmas }))
            .collect();
        json!({ "sensors": self.sensors, "rows": rows })
    }

    /// The comparison as a document.
    pub fn document(&self) -> Document {
        let mut heading = vec![""];
        heading.extend(self.sensors.iter().map(String::as_str));
        heading.push("");
        let mut aligns = vec![Align::Right; heading.len()];
        aligns[0] = Align::Left;
        aligns[heading.len() - 1] = Align::Left;
        let mut table = Table::new(&heading, &aligns).keep_last_column();
        let mut first = vec![Cell::from("technology")];
        first.extend(
            self.technologies
                .iter()
                .map(|technology| Cell::from(sagnac_report::text::cut(technology, 13))),
        );
        first.push(Cell::from(""));
        table.row(first);
        for row in &self.rows {
            let mut cells = vec![Cell::from(&row.words)];
            for ((value, sigma), letter) in row.values.iter().zip(&row.sigmas).zip(&row.letters) {
                let number = |value: f64| general(value / row.field_unit.factor(), 4);
                let text = match (value, sigma) {
                    (None, _) => "-".to_string(),
                    (Some(0.0), Some(sigma)) => format!("± {}", number(*sigma)),
                    (Some(value), _) => number(*value),
                };
                cells.push(Cell::from(format!("{text} {letter:1}")));
            }
            cells.push(Cell::from(super::shown_unit(row.field_unit.text())));
            table.row(cells);
        }
        let mut document = Document::new();
        document.table(table).blank();
        document
            .line("D data sheet, S second hand, M measured on a unit; ± is 1 sigma of a tolerance");
        document
    }

    /// The comparison as text.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}
