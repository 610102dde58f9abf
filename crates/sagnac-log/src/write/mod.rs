//! Writers of logs, one file per format.

mod bag;
pub(crate) mod csv;
mod mcap;
pub(crate) mod npy;
mod npz;
#[cfg(feature = "parquet")]
mod parquet;
mod ros;

use std::io::{Seek, Write};

use crate::{Block, Error, Layout, LogWriter, Quantity};

/// A destination that can be completed afterwards (sizes in headers).
pub trait WriteSeek: Write + Seek + Send {}
impl<T: Write + Seek + Send> WriteSeek for T {}

/// The formats that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum WriteFormat {
    /// `.csv`.
    Csv,
    /// `.csv.gz`.
    CsvGzip,
    /// `.csv.zst`.
    CsvZstd,
    /// `.npy`, structured.
    Npy,
    /// `.npz`: one structured array, `log`.
    Npz,
    /// `.parquet`: a column a channel.
    #[cfg(feature = "parquet")]
    Parquet,
    /// `.mcap`: `sensor_msgs/msg/Imu` of ROS 2.
    Mcap,
    /// `.bag`: `sensor_msgs/Imu` of ROS 1.
    Bag,
}

impl WriteFormat {
    /// Whether it holds text beside numbers ([`crate::ReadOptions::keep_text`]).
    pub const fn is_text(self) -> bool {
        matches!(self, Self::Csv | Self::CsvGzip | Self::CsvZstd)
    }

    /// The format that the extension of a file name asks for.
    ///
    /// # Errors
    /// An extension that is none of ours, with the list of those that are.
    pub fn of_name(name: &str) -> Result<Self, Error> {
        let lower = name.to_ascii_lowercase();
        for (extension, format) in [
            (".csv", Self::Csv),
            (".csv.gz", Self::CsvGzip),
            (".csv.zst", Self::CsvZstd),
            (".npy", Self::Npy),
            (".npz", Self::Npz),
            #[cfg(feature = "parquet")]
            (".parquet", Self::Parquet),
            (".mcap", Self::Mcap),
            (".bag", Self::Bag),
        ] {
            if lower.ends_with(extension) {
                return Ok(format);
            }
        }
        Err(
            Error::usage(format!("no log format is written as `{name}`"))
                .advise("name it .csv, .csv.gz, .csv.zst, .npy, .npz, .parquet, .mcap or .bag"),
        )
    }
}

/// A writer of `format` for logs of `layout`.
///
/// Logs without time get one, [`crate::Stamp::of_row`]: the first row is at one interval of the layout's rate.
///
/// # Errors
/// What the operating system says; a layout without time and rate; increments that were not divided by dt.
pub fn create(
    format: WriteFormat,
    output: Box<dyn WriteSeek>,
    layout: &Layout,
) -> Result<Box<dyn LogWriter>, Error> {
    if !layout.has_time && layout.rate_hz.is_none() {
        return Err(Error::data("the log has no time and no rate")
            .advise("add --rate, for instance --rate 100Hz"));
    }
    if let Some(c) = layout.channels.iter().find(|c| c.is_increment) {
        return Err(Error::data(format!(
            "the increments of `{}` were not divided by dt",
            c.name
        )));
    }
    let writer: Box<dyn LogWriter> = match format {
        WriteFormat::Csv => Box::new(csv::CsvWriter::new(csv::Packed::Plain(output), layout)?),
        WriteFormat::CsvGzip => Box::new(csv::CsvWriter::new(csv::Packed::gzip(output), layout)?),
        WriteFormat::CsvZstd => Box::new(csv::CsvWriter::new(csv::Packed::zstd(output)?, layout)?),
        WriteFormat::Npy => Box::new(npy::NpyWriter::new(output, layout)?),
        WriteFormat::Npz => Box::new(npz::NpzWriter::new(output, layout)?),
        #[cfg(feature = "parquet")]
        WriteFormat::Parquet => Box::new(parquet::ParquetWriter::new(output, layout)),
        WriteFormat::Mcap => Box::new(mcap::McapWriter::new(output, layout)?),
        WriteFormat::Bag => Box::new(bag::BagWriter::new(output, layout)?),
    };
    // ROS messages have no room for further columns.
    Ok(match format {
        WriteFormat::Mcap | WriteFormat::Bag => writer,
        _ => BeyondDigits::watch(writer, layout),
    })
}

/// From here on a float no longer tells every whole number from the next.
const EVERY_WHOLE_NUMBER: f64 = 9_007_199_254_740_992.0;

/// A writer that says which columns that are no sensor's hold whole numbers beyond 2^53: counts, identities and
/// nanoseconds, of which a float keeps 16 digits.
struct BeyondDigits {
    writer: Box<dyn LogWriter>,
    /// Place, name, and whether it holds such a number.
    columns: Vec<(usize, String, bool)>,
}

impl BeyondDigits {
    fn watch(writer: Box<dyn LogWriter>, layout: &Layout) -> Box<dyn LogWriter> {
        let columns: Vec<_> = layout
            .channels
            .iter()
            .enumerate()
            .filter(|(_, channel)| channel.quantity == Quantity::Other)
            .map(|(at, channel)| (at, channel.name.clone(), false))
            .collect();
        if columns.is_empty() {
            return writer;
        }
        Box::new(Self { writer, columns })
    }
}

impl LogWriter for BeyondDigits {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        for (at, _, is_beyond) in self.columns.iter_mut().filter(|column| !column.2) {
            // Larger than any integer of 64 bits is no count.
            *is_beyond = block.columns.get(*at).is_some_and(|column| {
                let mut sizes = column.iter().map(|value| value.abs());
                sizes.any(|size| (EVERY_WHOLE_NUMBER..2e19).contains(&size))
            });
        }
        self.writer.write_block(block)
    }

    fn finish(self: Box<Self>) -> Result<Vec<String>, Error> {
        let mut notes = self.writer.finish()?;
        let beyond = self.columns.into_iter().filter(|column| column.2);
        let names: Vec<String> = beyond.map(|(_, name, _)| format!("`{name}`")).collect();
        if !names.is_empty() {
            let columns = if names.len() == 1 {
                "column"
            } else {
                "columns"
            };
            notes.push(format!(
                "{columns} {}: whole numbers beyond 2^53 are rounded to the 16 digits of a float; from CSV to CSV they stay as they are",
                names.join(", ")
            ));
        }
        Ok(notes)
    }
}

/// `name [unit]` of every column, time first.
pub(crate) fn headers(layout: &Layout) -> Vec<String> {
    let mut out = vec!["time [s]".to_owned()];
    out.extend(layout.channels.iter().map(|c| {
        if c.unit.is_empty() {
            c.name.clone()
        } else {
            format!("{} [{}]", c.name, c.unit)
        }
    }));
    out
}
