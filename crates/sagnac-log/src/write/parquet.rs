//! Apache Parquet: a column of f8 a channel, its name the CSV header's; Zstandard. Time is i8 nanoseconds where the log
//! has whole ones.

use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::WriteSeek;
use crate::{Block, Error, Layout, LogWriter, Stamp, Stamps};

/// Rows of a group, which are held.
const GROUP: usize = 1 << 17;

/// Writes `.parquet`.
pub(crate) struct ParquetWriter {
    /// Not yet begun: the first block tells the kind of time.
    output: Option<Box<dyn WriteSeek>>,
    file: Option<SerializedFileWriter<Box<dyn WriteSeek>>>,
    names: Vec<String>,
    rate_hz: Option<f64>,
    rows: u64,
    stamps: Stamps,
    columns: Vec<Vec<f64>>,
    rounded: bool,
}

fn failed(error: ParquetError) -> Error {
    match error {
        // What the output said, without the words that wrap it.
        ParquetError::External(source) => Error::write(std::io::Error::other(source)),
        error => Error::write(std::io::Error::other(error)),
    }
}

impl ParquetWriter {
    pub(crate) fn new(output: Box<dyn WriteSeek>, layout: &Layout) -> Self {
        Self {
            output: Some(output),
            file: None,
            names: super::headers(layout),
            rate_hz: layout.rate_hz,
            rows: 0,
            stamps: Stamps::default(),
            columns: vec![Vec::new(); layout.channels.len()],
            rounded: false,
        }
    }

    /// Begins the file with the kind of time of the stamps held.
    fn begin(&mut self) -> Result<(), Error> {
        let Some(output) = self.output.take() else {
            return Ok(());
        };
        if matches!(self.stamps, Stamps::Nanoseconds(_)) {
            "time [ns]".clone_into(&mut self.names[0]);
        }
        let column = |name: &String| {
            let physical = if name == "time [ns]" {
                Physical::INT64
            } else {
                Physical::DOUBLE
            };
            Type::primitive_type_builder(name, physical)
                .with_repetition(Repetition::REQUIRED)
                .build()
                .map(Arc::new)
        };
        let columns = self.names.iter().map(column).collect::<Result<_, _>>();
        let schema = Type::group_type_builder("log")
            .with_fields(columns.map_err(failed)?)
            .build()
            .map_err(failed)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_created_by("sagnac".to_owned())
            .build();
        let file = SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties));
        self.file = Some(file.map_err(failed)?);
        Ok(())
    }

    /// Writes the rows held as a group.
    fn flush(&mut self) -> Result<(), Error> {
        if self.stamps.is_empty() {
            return Ok(());
        }
        self.begin()?;
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let mut group = file.next_row_group().map_err(failed)?;
        let is_whole = self.names[0] == "time [ns]";
        let mut columns = self.columns.iter();
        let mut first = true;
        while let Some(mut column) = group.next_column().map_err(failed)? {
            if first {
                match &self.stamps {
                    Stamps::Nanoseconds(v) if is_whole => {
                        column.typed::<Int64Type>().write_batch(v, None, None)
                    }
                    stamps => {
                        let seconds = (0..stamps.len())
                            .filter_map(|k| stamps.get(k))
                            .map(Stamp::seconds);
                        if is_whole {
                            self.rounded = true;
                            let ns: Vec<i64> = seconds.map(|s| (s * 1e9).round() as i64).collect();
                            column.typed::<Int64Type>().write_batch(&ns, None, None)
                        } else {
                            let seconds: Vec<f64> = seconds.collect();
                            column
                                .typed::<DoubleType>()
                                .write_batch(&seconds, None, None)
                        }
                    }
                }
                .map_err(failed)?;
                first = false;
            } else if let Some(values) = columns.next() {
                column
                    .typed::<DoubleType>()
                    .write_batch(values, None, None)
                    .map_err(failed)?;
            }
            column.close().map_err(failed)?;
        }
        group.close().map_err(failed)?;
        self.stamps.clear();
        self.columns.iter_mut().for_each(Vec::clear);
        Ok(())
    }
}

impl LogWriter for ParquetWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        if block.stamps.is_empty() {
            let rate = self.rate_hz.unwrap_or(1.0);
            for k in 1..=block.rows as u64 {
                self.stamps.push(Stamp::of_row(self.rows + k, rate));
            }
        } else {
            self.stamps.append(&block.stamps);
        }
        self.rows += block.rows as u64;
        for (all, part) in self.columns.iter_mut().zip(&block.columns) {
            all.extend_from_slice(part);
        }
        if self.stamps.len() >= GROUP {
            self.flush()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<String>, Error> {
        self.flush()?;
        self.begin()?;
        if let Some(file) = self.file.take() {
            file.close().map_err(failed)?;
        }
        let note = "time stamps were rounded to nanoseconds".to_owned();
        Ok(self.rounded.then_some(note).into_iter().collect())
    }
}
