//! Text tables: our own CSV, anybody's CSV, EuRoC.

mod chunks;
mod dialect;
pub(crate) mod iso;
pub(crate) mod number;
mod rows;

use std::io::{Cursor, Read};

use self::chunks::Chunks;
pub(crate) use self::dialect::name_and_unit;
use self::dialect::{Dialect, Separator};
use self::rows::{RowError, RowPlan, RowProblem};
use crate::live::fill;
use crate::map::hints::describe;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::{Block, Error};

/// Bytes looked at before the first row is read.
const SAMPLE: usize = 256 * 1024;

/// A text table.
pub(crate) struct TextTable {
    layout: RawLayout,
    dialect: Dialect,
    plan: Plan,
    /// Notes that were known before the first row.
    notes: usize,
    start: Option<(Vec<u8>, Box<dyn Read + Send>)>,
    chunks: Option<Chunks>,
    threads: usize,
    is_live: bool,
}

impl TextTable {
    /// Looks at the first lines.
    pub(crate) fn open(
        mut reader: Box<dyn Read + Send>,
        threads: usize,
        is_live: bool,
        packed: &str,
    ) -> Result<Self, Error> {
        let mut sample = Vec::with_capacity(SAMPLE);
        let is_whole = fill(&mut reader, &mut sample, SAMPLE, is_live).map_err(Error::read)?;
        refuse_binary(&sample)?;
        if memchr::memchr(b'\n', &sample).is_none() && sample.contains(&b'\r') {
            ends_by_newline(&mut sample);
            reader = Box::new(LinesByReturn(reader));
        }
        let dialect = dialect::sniff(&sample, is_whole)?;
        let euroc = euroc_columns(&dialect);
        let mut layout = RawLayout {
            has_names: dialect.has_header,
            has_cells: true,
            header_place: dialect.header_line.map(|l| format!("line {l}")),
            ..RawLayout::default()
        };
        layout.columns.clone_from(&dialect.columns);
        if let Some(channels) = euroc {
            layout.format = format!("EuRoC data.csv{packed}");
            for (column, (channel, unit)) in layout.columns.iter_mut().zip(channels) {
                column.channel = Some(channel.to_owned());
                column.unit = Some(unit.to_owned());
            }
        } else {
            let parted = match dialect.separator {
                Separator::Byte(b';') => ", parted by semicolons",
                Separator::Byte(b'\t') => ", parted by tabs",
                Separator::Spaces => ", parted by spaces",
                Separator::Byte(_) => "",
            };
            let header = if dialect.has_header {
                "with a header"
            } else {
                "without a header"
            };
            layout.format = format!("CSV {header}{parted}{packed}");
        }
        if dialect.preamble > 0 {
            let (n, s) = (
                dialect.preamble,
                if dialect.preamble == 1 { "" } else { "s" },
            );
            layout
                .notes
                .push(format!("{n} line{s} before the table skipped"));
        }
        if is_whole && dialect.body_start >= sample.len() {
            let what = if dialect.has_header {
                "the log has a header and no rows"
            } else {
                "the log is empty"
            };
            return Err(Error::data(what).advise("look at what recorded it, or copy it again"));
        }
        let notes = layout.notes.len();
        Ok(Self {
            layout,
            dialect,
            plan: Plan::default(),
            notes,
            start: Some((sample, reader)),
            chunks: None,
            threads,
            is_live,
        })
    }
}

/// Text whose lines end by carriage returns alone (old Macs, terminal programs), with newlines in their place.
struct LinesByReturn<R>(R);

impl<R: Read> Read for LinesByReturn<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.0.read(buffer)?;
        ends_by_newline(&mut buffer[..n]);
        Ok(n)
    }
}

fn ends_by_newline(text: &mut [u8]) {
    for byte in text.iter_mut().filter(|byte| **byte == b'\r') {
        *byte = b'\n';
    }
}

impl TextTable {
    /// Says which columns that are no sensor's held text among their numbers.
    fn say_missing(&mut self, missing: &[u64]) {
        self.layout.notes.truncate(self.notes);
        for (&column, &count) in self.plan.columns.iter().zip(missing) {
            if count > 0 {
                let name = describe(&self.layout, column);
                let cells = if count == 1 {
                    "1 cell of text".to_owned()
                } else {
                    format!("{} cells of text", grouped(count))
                };
                self.layout
                    .notes
                    .push(format!("column {name}: {cells}, read as nan"));
            }
        }
    }
}

impl RawReader for TextTable {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        if let Some((mut sample, reader)) = self.start.take() {
            sample.drain(..self.dialect.body_start.min(sample.len()));
            let reader: Box<dyn Read + Send> = Box::new(Cursor::new(sample).chain(reader));
            let rows = RowPlan::new(&self.dialect, &plan);
            self.plan = plan;
            self.chunks = Some(Chunks::new(
                reader,
                rows,
                self.dialect.body_line,
                self.threads,
                self.is_live,
            ));
        }
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        let Some(chunks) = &mut self.chunks else {
            return Ok(false);
        };
        let more = chunks.next(block)?;
        let missing = chunks.missing().to_vec();
        self.say_missing(&missing);
        Ok(more)
    }
}

/// The columns of a EuRoC `imu0/data.csv`, if it is one.
fn euroc_columns(dialect: &Dialect) -> Option<[(&'static str, &'static str); 7]> {
    const NAMES: [&str; 7] = [
        "timestamp",
        "w_RS_S_x",
        "w_RS_S_y",
        "w_RS_S_z",
        "a_RS_S_x",
        "a_RS_S_y",
        "a_RS_S_z",
    ];
    let is_euroc = dialect.width == 7
        && dialect
            .columns
            .iter()
            .zip(NAMES)
            .all(|(c, n)| c.name.trim_start_matches('#') == n);
    is_euroc.then_some([
        ("time", "ns"),
        ("gyro_x", "rad/s"),
        ("gyro_y", "rad/s"),
        ("gyro_z", "rad/s"),
        ("accel_x", "m/s^2"),
        ("accel_y", "m/s^2"),
        ("accel_z", "m/s^2"),
    ])
}

fn refuse_binary(sample: &[u8]) -> Result<(), Error> {
    if sample.starts_with(b"\xFF\xFE") || sample.starts_with(b"\xFE\xFF") {
        return Err(Error::data("the text is in UTF-16").advise("save it as UTF-8"));
    }
    let odd = sample
        .iter()
        .filter(|&&c| c < 9 || (c > 13 && c < 32) || c == 127)
        .count();
    if sample.contains(&0) || odd * 100 > sample.len() {
        return Err(
            Error::data("the format is not known: neither text nor a known binary log")
                .advise("save it as CSV or .npy; the manual lists the formats"),
        );
    }
    Ok(())
}

/// The sentence of a row that cannot be read.
fn row_error(error: &RowError, plan: &RowPlan, rows_before: u64, lines_before: u64) -> Error {
    let width = plan.width();
    let table = if plan.has_header { "header" } else { "table" };
    let row = grouped(rows_before + error.rows + 1);
    let line = format!("line {}", grouped(lines_before + error.lines + 1));
    match &error.what {
        RowProblem::Width { found } => {
            let cells = if *found == 1 { "cell" } else { "cells" };
            Error::data(format!(
                "row {row} has {found} {cells} where the {table} has {width}"
            ))
            .at(line)
            .advise("mend or remove that row; a lost sample is written nan")
        }
        RowProblem::Text { column, cell, .. } if cell.is_empty() => {
            Error::data(format!("row {row} has no time"))
                .at(format!("{line}, column {column}"))
                .advise("remove that row, or leave the time out and give --rate")
        }
        RowProblem::Text {
            column,
            cell,
            is_date,
        } => {
            let what = if *is_date {
                "no ISO 8601 date"
            } else {
                "not a number"
            };
            Error::data(format!("`{cell}` in row {row} is {what}"))
                .at(format!("{line}, column {column}"))
                .advise("mend that cell; a lost sample is written nan")
        }
    }
}

/// A count with thousands parted by spaces from five digits on.
pub(crate) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(c);
    }
    out
}
