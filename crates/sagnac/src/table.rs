//! Small tables as people write them: CSV with units in brackets, read whole, every cell with its line.

use sagnac_model::units::{Dimension, Unit};

use crate::Error;

/// A table of text cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What errors call it.
    pub label: String,
    /// Columns, in the order of the file.
    pub columns: Vec<Column>,
    /// Line of the file of each row.
    pub lines: Vec<u64>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name, without the unit.
    pub name: String,
    /// The text in its brackets.
    pub unit: Option<String>,
    /// Its cells, without surrounding space.
    pub cells: Cells,
}

/// The cells of a column, one text after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    text: String,
    ends: Vec<usize>,
}

impl Cells {
    fn push(&mut self, cell: &str) {
        self.text.push_str(cell);
        self.ends.push(self.text.len());
    }

    /// The cell of a row.
    pub fn get(&self, row: usize) -> Option<&str> {
        let end = *self.ends.get(row)?;
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.text.get(start..end)
    }

    /// All cells in turn.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        (0..self.ends.len()).filter_map(|row| self.get(row))
    }
}

impl Table {
    /// Reads CSV with a header; `#` begins a comment line.
    ///
    /// # Errors
    /// No header, no rows, rows of another length than the header, two columns of one name.
    pub fn parse(text: &str, label: &str) -> Result<Self, Error> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let header = reader
            .headers()
            .map_err(|error| unreadable(label, &error))?
            .clone();
        if header.iter().all(str::is_empty) {
            return Err(Error::data("the table is empty")
                .at(label.to_owned())
                .advise("write a header line with names and units, then a row a reading"));
        }
        let mut columns: Vec<Column> = Vec::with_capacity(header.len());
        for name in &header {
            let (name, unit) = split_unit(name);
            if !name.is_empty() && columns.iter().any(|column| column.name == name) {
                return Err(Error::data(format!("two columns are called `{name}`"))
                    .at(format!("{label}, line 1"))
                    .advise("rename one of them"));
            }
            columns.push(Column {
                name: name.to_owned(),
                unit: unit.map(str::to_owned),
                cells: Cells::default(),
            });
        }
        let mut lines = Vec::new();
        let mut record = csv::StringRecord::new();
        while reader
            .read_record(&mut record)
            .map_err(|error| unreadable(label, &error))?
        {
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != columns.len() {
                return Err(Error::data(format!(
                    "row {} has {} cells where the header has {}",
                    lines.len() + 1,
                    record.len(),
                    columns.len()
                ))
                .at(format!("{label}, line {line}"))
                .advise("repair the row"));
            }
            for (column, cell) in columns.iter_mut().zip(&record) {
                column.cells.push(cell);
            }
            lines.push(line);
        }
        if lines.is_empty() {
            return Err(Error::data("the table has a header and no rows")
                .at(label.to_owned())
                .advise("add a row a reading"));
        }
        Ok(Self {
            label: label.to_owned(),
            columns,
            lines,
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The cells of `column` as SI numbers of a dimension; `None` where a cell is empty.
    ///
    /// # Errors
    /// No unit or one of another dimension, cells that are not finite numbers.
    pub fn quantity(
        &self,
        column: &Column,
        dimension: Dimension,
    ) -> Result<Vec<Option<f64>>, Error> {
        let factor = match &column.unit {
            Some(text) => {
                let unit = self.unit(column, text, dimension)?;
                if dimension.is_absolute_temperature() && !unit.is_celsius() {
                    return Ok(self
                        .numbers(column)?
                        .into_iter()
                        .map(|v| v.map(|kelvin| kelvin - 273.15))
                        .collect());
                }
                unit.factor()
            }
            None if dimension.is_plain() => 1.0,
            None => {
                return Err(Error::data(format!("column `{}` has no unit", column.name))
                    .at(format!("{}, line 1", self.label))
                    .advise(format!(
                        "write it in brackets, for instance {} [{}]",
                        column.name,
                        dimension.field_unit()
                    )));
            }
        };
        Ok(self
            .numbers(column)?
            .into_iter()
            .map(|v| v.map(|v| v * factor))
            .collect())
    }

    fn unit(&self, column: &Column, text: &str, dimension: Dimension) -> Result<Unit, Error> {
        let place = format!("{}, line 1: {} [{text}]", self.label, column.name);
        let unit = Unit::parse_scaled(text)
            .map_err(|error| Error::data(error.to_string()).at(place.clone()))?;
        if unit.measures(dimension) {
            return Ok(unit);
        }
        Err(Error::data(format!(
            "expected {}, got {}",
            dimension.words(),
            unit.words()
        ))
        .at(place)
        .advise(format!(
            "write for instance {} [{}]",
            column.name,
            dimension.field_unit()
        )))
    }

    /// The cells of `column` as they are written; `None` where a cell is empty.
    ///
    /// # Errors
    /// Cells that are not finite numbers, with their line.
    pub fn numbers(&self, column: &Column) -> Result<Vec<Option<f64>>, Error> {
        column
            .cells
            .iter()
            .zip(&self.lines)
            .map(|(cell, line)| {
                if cell.is_empty() {
                    return Ok(None);
                }
                match cell.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(Some(value)),
                    _ => Err(Error::data(format!("`{cell}` is not a finite number"))
                        .at(format!(
                            "{}, line {line}, column `{}`",
                            self.label, column.name
                        ))
                        .advise("repair the cell or leave the row out")),
                }
            })
            .collect()
    }
}

/// `name [unit]` in its two parts.
fn split_unit(header: &str) -> (&str, Option<&str>) {
    match header
        .strip_suffix(']')
        .and_then(|body| body.rsplit_once('['))
    {
        Some((name, unit)) => (name.trim(), Some(unit.trim())),
        None => (header, None),
    }
}

fn unreadable(label: &str, error: &csv::Error) -> Error {
    let line = error.position().map_or(1, csv::Position::line);
    Error::data("the table is not readable as CSV")
        .at(format!("{label}, line {line}"))
        .advise("write comma-separated cells, one row a line, in UTF-8")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn units_and_empty_cells() {
        let table = Table::parse("a [deg/s],b,note\n180,1,x\n,2,y\n", "t.csv").unwrap();
        let a = table
            .quantity(table.column("a").unwrap(), Dimension::ANGULAR_RATE)
            .unwrap();
        assert_eq!(a, [Some(std::f64::consts::PI), None]);
        assert_eq!(table.lines, [2, 3]);
    }

    #[test]
    fn refusals_say_where() {
        let error = |text: &str| Table::parse(text, "t.csv").unwrap_err().to_string();
        assert!(error("").contains("empty"));
        assert!(error("a,b\n").contains("no rows"));
        assert!(error("a,b\n1\n").contains("t.csv, line 2"));
        assert!(error("a,a\n1,2\n").contains("two columns"));
        let table = Table::parse("a [deg/s]\nnan\n", "t.csv").unwrap();
        assert!(
            table
                .numbers(&table.columns[0])
                .unwrap_err()
                .to_string()
                .contains("line 2")
        );
        assert!(
            table
                .quantity(&table.columns[0], Dimension::LENGTH)
                .unwrap_err()
                .to_string()
                .contains("a length")
        );
    }
}
