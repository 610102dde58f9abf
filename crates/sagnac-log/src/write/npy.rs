//! A structured numpy array of f8, its field names the CSV's header.

use std::io::{Seek, SeekFrom, Write};

use super::WriteSeek;
use crate::{Block, Error, Layout, LogWriter, Stamp};

/// Writes `.npy`.
pub(crate) struct NpyWriter {
    output: Box<dyn WriteSeek>,
    header_length: usize,
    rows: Rows,
}

/// Rows of a structured array as bytes, time first.
pub(super) struct Rows {
    names: Vec<String>,
    rate_hz: Option<f64>,
    written: u64,
    buffer: Vec<u8>,
    clock: SecondsClock,
}

impl Rows {
    pub(super) fn new(layout: &Layout) -> Self {
        Self {
            names: super::headers(layout),
            rate_hz: layout.rate_hz,
            written: 0,
            buffer: Vec::new(),
            clock: SecondsClock::default(),
        }
    }

    /// The header for the rows so far.
    pub(super) fn header(&self) -> Vec<u8> {
        header(&self.names, self.written)
    }

    /// Bytes of the rows so far.
    pub(super) fn size(&self) -> u64 {
        self.written * self.names.len() as u64 * 8
    }

    /// The rows of a block as bytes.
    pub(super) fn bytes(&mut self, block: &Block) -> &[u8] {
        self.buffer.clear();
        for row in 0..block.rows {
            let counted = || Stamp::of_row(self.written + 1, self.rate_hz.unwrap_or(1.0));
            let stamp = block.stamps.get(row).unwrap_or_else(counted);
            let time = self.clock.seconds(stamp);
            self.buffer.extend_from_slice(&time.to_le_bytes());
            for column in &block.columns {
                self.buffer.extend_from_slice(&column[row].to_le_bytes());
            }
            self.written += 1;
        }
        &self.buffer
    }

    /// What the user has to be told.
    pub(super) fn notes(&self) -> Vec<String> {
        self.clock.note().into_iter().collect()
    }
}

/// Stamps as f64 seconds: counted from the first where an f64 would lose more than 1 ns.
#[derive(Debug, Default, Clone)]
struct SecondsClock {
    origin: Option<Stamp>,
    is_shifted: bool,
}

impl SecondsClock {
    /// The stamp in seconds of the column.
    fn seconds(&mut self, stamp: Stamp) -> f64 {
        if self.origin.is_none() {
            self.origin = Some(stamp);
            // Half an ulp of an f64 of 2^23 s is 0.93 ns.
            self.is_shifted = matches!(stamp, Stamp::Nanoseconds(ns) if ns.unsigned_abs() > 8_388_608_000_000_000);
        }
        match self.origin {
            Some(origin) if self.is_shifted => stamp.since(origin),
            _ => stamp.seconds(),
        }
    }

    /// What the user has to be told.
    fn note(&self) -> Option<String> {
        let mut text = Vec::new();
        super::csv::push_stamp(&mut text, self.origin?);
        self.is_shifted.then(|| {
            format!(
                "time counts from the first sample, {} s in the source",
                String::from_utf8_lossy(&text)
            )
        })
    }
}

/// The header with room for any number of rows.
fn header(names: &[String], rows: u64) -> Vec<u8> {
    let fields: Vec<String> = names
        .iter()
        .map(|n| format!("('{}', '<f8')", n.replace(['\'', '\\'], "_")))
        .collect();
    let dict = format!(
        "{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}",
        fields.join(", ")
    );
    // Version 2 takes headers beyond 64 KiB; the dict is padded so that 20 digits of rows would fit.
    let padded = (12 + dict.len() + 20 - rows.to_string().len() + 1).next_multiple_of(64) - 12;
    let mut out = b"\x93NUMPY\x02\x00".to_vec();
    out.extend_from_slice(&u32::try_from(padded).unwrap_or(u32::MAX).to_le_bytes());
    out.extend_from_slice(dict.as_bytes());
    out.resize(12 + padded - 1, b' ');
    out.push(b'\n');
    out
}

impl NpyWriter {
    pub(crate) fn new(mut output: Box<dyn WriteSeek>, layout: &Layout) -> Result<Self, Error> {
        let rows = Rows::new(layout);
        let head = rows.header();
        output.write_all(&head).map_err(Error::write)?;
        Ok(Self {
            output,
            header_length: head.len(),
            rows,
        })
    }
}

impl LogWriter for NpyWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        self.output
            .write_all(self.rows.bytes(block))
            .map_err(Error::write)
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<String>, Error> {
        let head = self.rows.header();
        debug_assert_eq!(head.len(), self.header_length);
        self.output.seek(SeekFrom::Start(0)).map_err(Error::write)?;
        self.output.write_all(&head).map_err(Error::write)?;
        self.output.seek(SeekFrom::End(0)).map_err(Error::write)?;
        self.output.flush().map_err(Error::write)?;
        Ok(self.rows.notes())
    }
}
