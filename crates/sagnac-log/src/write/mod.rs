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

use crate::{Error, Layout, LogWriter};

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
/// Logs without time get one that counts from 0 at the layout's rate.
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
    Ok(match format {
        WriteFormat::Csv => Box::new(csv::CsvWriter::new(csv::Packed::Plain(output), layout)?),
        WriteFormat::CsvGzip => Box::new(csv::CsvWriter::new(csv::Packed::gzip(output), layout)?),
        WriteFormat::CsvZstd => Box::new(csv::CsvWriter::new(csv::Packed::zstd(output)?, layout)?),
        WriteFormat::Npy => Box::new(npy::NpyWriter::new(output, layout)?),
        WriteFormat::Npz => Box::new(npz::NpzWriter::new(output, layout)?),
        #[cfg(feature = "parquet")]
        WriteFormat::Parquet => Box::new(parquet::ParquetWriter::new(output, layout)),
        WriteFormat::Mcap => Box::new(mcap::McapWriter::new(output, layout)?),
        WriteFormat::Bag => Box::new(bag::BagWriter::new(output, layout)?),
    })
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
