//! Our own CSV: a header with units, the shortest decimals that read back to the same bits.

use std::io::Write;

use super::WriteSeek;
use crate::{Block, Error, Layout, LogWriter, Stamp};

/// Where text goes.
pub(crate) enum Packed {
    Plain(Box<dyn WriteSeek>),
    Gzip(flate2::write::GzEncoder<Box<dyn WriteSeek>>),
    Zstd(zstd::Encoder<'static, Box<dyn WriteSeek>>),
}

impl Packed {
    pub(crate) fn gzip(output: Box<dyn WriteSeek>) -> Self {
        Self::Gzip(flate2::write::GzEncoder::new(
            output,
            flate2::Compression::new(6),
        ))
    }

    pub(crate) fn zstd(output: Box<dyn WriteSeek>) -> Result<Self, Error> {
        zstd::Encoder::new(output, 3)
            .map(Self::Zstd)
            .map_err(Error::write)
    }

    fn write_all(&mut self, bytes: &[u8]) -> Result<(), Error> {
        match self {
            Self::Plain(w) => w.write_all(bytes),
            Self::Gzip(w) => w.write_all(bytes),
            Self::Zstd(w) => w.write_all(bytes),
        }
        .map_err(Error::write)
    }

    fn finish(self) -> Result<(), Error> {
        let mut output = match self {
            Self::Plain(w) => w,
            Self::Gzip(w) => w.finish().map_err(Error::write)?,
            Self::Zstd(w) => w.finish().map_err(Error::write)?,
        };
        output.flush().map_err(Error::write)
    }
}

/// Writes CSV.
pub(crate) struct CsvWriter {
    output: Packed,
    buffer: Vec<u8>,
    rate_hz: Option<f64>,
    rows: u64,
    columns: Vec<Column>,
}

/// What stands in a column after the time.
#[derive(Clone, Copy)]
enum Column {
    Number(usize),
    Text(usize),
}

/// Channels with the columns of text at their places between them.
fn in_order(layout: &Layout) -> Vec<Column> {
    let mut out: Vec<Column> = Vec::new();
    for number in 0..=layout.channels.len() {
        let texts = layout.texts.iter().enumerate();
        out.extend(
            texts
                .filter(|(_, text)| text.place.min(layout.channels.len()) == number)
                .map(|(k, _)| Column::Text(k)),
        );
        if number < layout.channels.len() {
            out.push(Column::Number(number));
        }
    }
    out
}

impl CsvWriter {
    pub(crate) fn new(mut output: Packed, layout: &Layout) -> Result<Self, Error> {
        let columns = in_order(layout);
        let headers = super::headers(layout);
        let mut names = vec![quoted(&headers[0])];
        names.extend(columns.iter().map(|column| match *column {
            Column::Number(k) => quoted(&headers[k + 1]),
            Column::Text(k) => quoted(&layout.texts[k].header),
        }));
        output.write_all((names.join(",") + "\n").as_bytes())?;
        Ok(Self {
            output,
            buffer: Vec::new(),
            rate_hz: layout.rate_hz,
            rows: 0,
            columns,
        })
    }
}

/// A header cell, quoted where it holds a comma or a quote.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.starts_with(['#', '%']) {
        format!("\"{}\"", text.replace(['"', '\n', '\r'], "'"))
    } else {
        text.to_owned()
    }
}

impl LogWriter for CsvWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        let mut row = 0;
        while row < block.rows {
            self.buffer.clear();
            while row < block.rows && self.buffer.len() < 1 << 16 {
                let counted = || Stamp::of_row(self.rows + 1, self.rate_hz.unwrap_or(1.0));
                let stamp = block.stamps.get(row).unwrap_or_else(counted);
                push_stamp(&mut self.buffer, stamp);
                for column in &self.columns {
                    self.buffer.push(b',');
                    match *column {
                        Column::Number(k) => push_number(&mut self.buffer, block.columns[k][row]),
                        Column::Text(k) => self
                            .buffer
                            .extend_from_slice(block.texts.get(k).map_or(&[], |t| t.get(row))),
                    }
                }
                self.buffer.push(b'\n');
                row += 1;
                self.rows += 1;
            }
            self.output.write_all(&self.buffer)?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Vec<String>, Error> {
        self.output.finish()?;
        Ok(Vec::new())
    }
}

/// The shortest decimal that reads back to the same bits; a missing value is an empty cell.
#[inline]
pub(crate) fn push_number(out: &mut Vec<u8>, value: f64) {
    if value.is_finite() {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format_finite(value);
        out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    } else if value.is_nan() {
        out.extend_from_slice(b"nan");
    } else {
        out.extend_from_slice(if value > 0.0 { b"inf" } else { b"-inf" });
    }
}

/// A stamp in seconds with all its digits.
#[inline]
pub(crate) fn push_stamp(out: &mut Vec<u8>, stamp: Stamp) {
    match stamp {
        Stamp::Seconds(s) => push_number(out, s),
        Stamp::Nanoseconds(ns) => {
            if ns < 0 {
                out.push(b'-');
            }
            let all = ns.unsigned_abs();
            let (whole, mut part) = (all / 1_000_000_000, all % 1_000_000_000);
            let mut digits = [b'0'; 20];
            let mut at = digits.len();
            let mut rest = whole;
            loop {
                at -= 1;
                digits[at] = b'0' + (rest % 10) as u8;
                rest /= 10;
                if rest == 0 {
                    break;
                }
            }
            out.extend_from_slice(&digits[at..]);
            if part != 0 {
                out.push(b'.');
                let mut decimals = [b'0'; 9];
                for d in decimals.iter_mut().rev() {
                    *d = b'0' + (part % 10) as u8;
                    part /= 10;
                }
                let end = decimals
                    .iter()
                    .rposition(|&d| d != b'0')
                    .map_or(0, |i| i + 1);
                out.extend_from_slice(&decimals[..end]);
            }
        }
    }
}
