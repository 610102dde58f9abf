//! `response`: accuracy, precision, resolution, sensitivity and linearity of one axis from a bench record.
//!
//! ```
//! use sagnac::response::{ResponseRequest, response};
//! let table = "reference [deg/s],output [V]\n-10,-0.9\n0,0.1\n10,1.1\n0,0.1\n-10,-0.9\n";
//! let request = ResponseRequest { table: table.into(), label: "bench.csv".into(), ..Default::default() };
//! let outcome = response(&request)?;
//! assert_eq!(outcome.to_json()["sensitivity"]["unit"], "V/(rad/s)");
//! # Ok::<(), sagnac::Error>(())
//! ```

mod json;
mod page;
mod text;

use sagnac_calibrate::response::{self as bench, Direction, Options, Reading};
use sagnac_model::units::{Dimension, Exponents, Unit};

use crate::Error;
use crate::table::{Column, Table};

/// A bench record and what is known besides.
#[derive(Clone, Debug, Default)]
pub struct ResponseRequest {
    /// The CSV text.
    pub table: String,
    /// What errors call it.
    pub label: String,
    /// `--full-scale`, with its unit.
    pub full_scale: Option<String>,
    /// `--nominal-sensitivity`, with its unit.
    pub nominal_sensitivity: Option<String>,
}

/// A unit of the record: one of ours, converted to SI, or a label that is kept.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordUnit {
    /// Converted to SI.
    Known(Unit),
    /// Any other text, for instance `V` or `LSB`.
    Label(String),
}

impl RecordUnit {
    fn parse(column: &Column) -> Self {
        match column.unit.as_deref().map(|text| (text, Unit::parse(text))) {
            Some((_, Ok(unit))) => Self::Known(unit),
            Some((text, Err(_))) => Self::Label(text.to_owned()),
            None => Self::Label(String::new()),
        }
    }

    fn factor(&self) -> f64 {
        match self {
            Self::Known(unit) => unit.factor(),
            Self::Label(_) => 1.0,
        }
    }

    fn exponents(&self) -> Option<Exponents> {
        match self {
            Self::Known(unit) => Some(unit.exponents()),
            Self::Label(_) => None,
        }
    }

    /// The unit of the numbers handed out: SI or the label.
    pub fn si(&self) -> String {
        match self {
            Self::Known(unit) => unit.exponents().si_unit(),
            Self::Label(text) => text.clone(),
        }
    }
}

/// What a bench record says.
#[derive(Clone, Debug)]
pub struct ResponseOutcome {
    /// The numbers, SI where the unit is known.
    pub response: bench::Response,
    /// The readings they come from, in SI, with the directions as given.
    pub readings: Vec<Reading>,
    /// Labels of repeats, where the table has them.
    pub repeats: Vec<String>,
    /// Unit of the reference.
    pub reference: RecordUnit,
    /// Unit of the output.
    pub output: RecordUnit,
    /// S₀ of the accuracy, SI.
    pub nominal_sensitivity: Option<f64>,
    /// What the record was called.
    pub label: String,
}

/// Reads a record and works out its response.
///
/// # Errors
/// A table without `reference` and `output`, of another sort, or that gives nothing (too few rows or points, equal
/// outputs); options of the wrong dimension.
pub fn response(request: &ResponseRequest) -> Result<ResponseOutcome, Error> {
    let table = Table::parse(&request.table, &request.label)?;
    let (reference, output) = columns(&table)?;
    let (x_unit, y_unit) = (RecordUnit::parse(reference), RecordUnit::parse(output));
    if let RecordUnit::Label(text) = &x_unit {
        let what = if text.is_empty() {
            "column `reference` has no unit".to_owned()
        } else {
            format!("the unit of column `reference` is not known: \"{text}\"")
        };
        return Err(Error::data(what)
            .at(format!("{}, line 1", table.label))
            .advise("write the true input with its unit, for instance reference [deg/s]"));
    }
    let readings = readings(&table, reference, output, &x_unit, &y_unit)?;
    let full_scale = request
        .full_scale
        .as_deref()
        .map(|text| full_scale(text, &x_unit))
        .transpose()?;
    let nominal = match &request.nominal_sensitivity {
        Some(text) => Some(nominal_sensitivity(text, &x_unit, &y_unit)?),
        None => (x_unit.exponents() == y_unit.exponents()).then_some(1.0),
    };
    let response = bench::respond(
        &readings,
        &Options {
            full_scale,
            nominal_sensitivity: nominal,
        },
    )
    .map_err(|error| {
        let out = if matches!(error, bench::Error::FullScale { .. }) {
            Error::usage(error.to_string()).at("--full-scale")
        } else {
            let row = match error {
                bench::Error::StandardError { row } | bench::Error::NotFinite { row } => Some(row),
                _ => None,
            };
            let line = row.and_then(|row| table.lines.get(row - 1));
            Error::data(error.to_string()).at(match line {
                Some(line) => format!("{}, line {line}", table.label),
                None => table.label.clone(),
            })
        };
        out.advise(error.advice())
    })?;
    let repeats = table
        .column("repeat")
        .map(|column| column.cells.iter().map(str::to_owned).collect())
        .unwrap_or_default();
    Ok(ResponseOutcome {
        response,
        readings,
        repeats,
        reference: x_unit,
        output: y_unit,
        nominal_sensitivity: nominal,
        label: table.label,
    })
}

/// The two columns that must be there; a table of another sort is named.
fn columns(table: &Table) -> Result<(&Column, &Column), Error> {
    if let (Some(reference), Some(output)) = (table.column("reference"), table.column("output")) {
        return Ok((reference, output));
    }
    let has = |name: &str| table.column(name).is_some();
    let sort = if has("f_x") || has("w_x") || has("up") || has("station") {
        Some(("a table of stations", "sagnac calibrate stations reads it"))
    } else if has("time") || has("gyro_x") || has("accel_x") {
        Some((
            "a log",
            "sagnac info reads it; a response needs true inputs beside the outputs",
        ))
    } else {
        None
    };
    let missing = if has("reference") {
        "output"
    } else {
        "reference"
    };
    Err(match sort {
        Some((sort, advice)) => Error::data(format!(
            "this is {sort}, not a record of reference and output"
        ))
        .at(table.label.clone())
        .advise(advice),
        None => Error::data(format!("the table has no column `{missing}`"))
            .at(format!("{}, line 1", table.label))
            .advise("name the columns for instance reference [deg/s],output [deg/s]"),
    })
}

fn readings(
    table: &Table,
    reference: &Column,
    output: &Column,
    x_unit: &RecordUnit,
    y_unit: &RecordUnit,
) -> Result<Vec<Reading>, Error> {
    let required = |column: &Column, factor: f64| -> Result<Vec<f64>, Error> {
        let numbers = table.numbers(column)?;
        numbers
            .iter()
            .zip(&table.lines)
            .map(|(value, line)| {
                value.map(|value| value * factor).ok_or_else(|| {
                    Error::data(format!("column `{}` has an empty cell", column.name))
                        .at(format!("{}, line {line}", table.label))
                        .advise("fill the cell or leave the row out")
                })
            })
            .collect()
    };
    let x = required(reference, x_unit.factor())?;
    let y = required(output, y_unit.factor())?;
    let directions = directions(table)?;
    let se = match table.column("output_se") {
        None => vec![None; x.len()],
        Some(column) => {
            let factor = match (&column.unit, y_unit) {
                (Some(text), RecordUnit::Known(unit)) => match Unit::parse(text) {
                    Ok(own) if own.exponents() == unit.exponents() => own.factor(),
                    _ => {
                        return Err(Error::data(
                            "column `output_se` is not in a unit of the output",
                        )
                        .at(format!("{}, line 1", table.label))
                        .advise(format!("write output_se [{}]", unit.text())));
                    }
                },
                _ => y_unit.factor(),
            };
            table
                .numbers(column)?
                .into_iter()
                .map(|v| v.map(|v| v * factor))
                .collect()
        }
    };
    Ok((0..x.len())
        .map(|i| Reading {
            reference: x[i],
            output: y[i],
            direction: directions[i],
            output_se: se[i],
        })
        .collect())
}

fn directions(table: &Table) -> Result<Vec<Option<Direction>>, Error> {
    let Some(column) = table.column("direction") else {
        return Ok(vec![None; table.rows()]);
    };
    column
        .cells
        .iter()
        .zip(&table.lines)
        .map(|(cell, line)| match cell {
            "" => Ok(None),
            "up" => Ok(Some(Direction::Up)),
            "down" => Ok(Some(Direction::Down)),
            _ => Err(Error::data(format!("`{cell}` is no direction"))
                .at(format!("{}, line {line}, column `direction`", table.label))
                .advise("write up, down or nothing")),
        })
        .collect()
}

/// A number and the text of its unit.
fn split_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let end = (1..=text.len())
        .rev()
        .filter(|&i| text.is_char_boundary(i))
        .find(|&i| {
            text[..i]
                .trim_end()
                .parse::<f64>()
                .is_ok_and(f64::is_finite)
        })?;
    Some((text[..end].trim_end().parse().ok()?, text[end..].trim()))
}

fn full_scale(text: &str, x_unit: &RecordUnit) -> Result<f64, Error> {
    let wrong = || {
        Error::usage(format!(
            "the full scale must be in the unit of the reference, {}",
            x_unit.si()
        ))
        .at(format!("--full-scale {text}"))
        .advise("write for instance --full-scale '450 deg/s'")
    };
    let (number, unit) = split_number(text).ok_or_else(wrong)?;
    let unit = Unit::parse(unit).map_err(|_| wrong())?;
    if Some(unit.exponents()) == x_unit.exponents() {
        Ok(number * unit.factor())
    } else {
        Err(wrong())
    }
}

fn nominal_sensitivity(text: &str, x_unit: &RecordUnit, y_unit: &RecordUnit) -> Result<f64, Error> {
    let wrong = || {
        Error::usage(format!(
            "the nominal sensitivity must be output over reference, {}",
            per(&y_unit.si(), &x_unit.si())
        ))
        .at(format!("--nominal-sensitivity {text}"))
        .advise("write for instance --nominal-sensitivity '16.4 1/(deg/s)'")
    };
    let (number, rest) = split_number(text).ok_or_else(wrong)?;
    let unit = if rest.is_empty() {
        Unit::plain()
    } else {
        Unit::parse(rest).map_err(|_| wrong())?
    };
    // The unit times the reference must be the output (a label counts as a plain number).
    let back =
        Unit::parse(&format!("({})*({})", unit_or_one(rest), x_unit.si())).map_err(|_| wrong())?;
    let wanted = y_unit
        .exponents()
        .unwrap_or_else(|| Dimension::RATIO.exponents());
    if back.exponents() == wanted && number != 0.0 {
        Ok(number * unit.factor())
    } else {
        Err(wrong())
    }
}

fn unit_or_one(text: &str) -> &str {
    if text.is_empty() { "1" } else { text }
}

/// The unit `a` over `b`.
fn per(a: &str, b: &str) -> String {
    let paren = |text: &str| {
        if text.contains(['/', '*', '·', ' ']) {
            format!("({text})")
        } else {
            text.to_owned()
        }
    };
    match (a, b) {
        (a, b) if a == b => "1".to_owned(),
        (a, "" | "1") => a.to_owned(),
        ("" | "1", b) => format!("1/{}", paren(b)),
        (a, b) => format!("{}/{}", paren(a), paren(b)),
    }
}
