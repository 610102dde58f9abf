//! Apache Parquet: flat columns of numbers by name, a page of each at a time. Source: [PARQUET].
//!
//! Names may carry units as the CSV header's do (`gyro_x [rad/s]`); time stamps of the format's own kind have theirs.
//! A null is no number.

use std::cell::Cell;
use std::io::{BufReader, Read};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::part::{Part, Shared};
use super::table::{MOST_COLUMNS, ROWS, Sink, begin, left_out_note, lists_note, refuse_empty};
use crate::input::InputBytes;
use crate::map::columns::clip;
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::npy::half;
use crate::text::name_and_unit;
use crate::{Block, Error};

/// The file as the decoder asks for it.
struct Pieces {
    file: Shared,
    length: u64,
}

impl Length for Pieces {
    fn len(&self) -> u64 {
        self.length
    }
}

/// A part of the file that fails after some reads at its end: the decoder skips what a damaged header promises, up to 2^31
/// strings that are not there, one by one.
struct Ending {
    part: Part,
    reads_left: u32,
}

impl Read for Ending {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let got = self.part.read(buffer)?;
        if got == 0 && !buffer.is_empty() {
            self.reads_left = self
                .reads_left
                .checked_sub(1)
                .ok_or(std::io::ErrorKind::UnexpectedEof)?;
        }
        Ok(got)
    }
}

impl ChunkReader for Pieces {
    type T = BufReader<Ending>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        let ending = Ending {
            part: self.file.from(start),
            reads_left: 64,
        };
        Ok(BufReader::with_capacity(1 << 16, ending))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        let mut out = Vec::new();
        self.file
            .part(start, length as u64)
            .read_to_end(&mut out)
            .map_err(|e| ParquetError::External(Box::new(e)))?;
        if out.len() < length {
            return Err(ParquetError::EOF("the file ends before".to_owned()));
        }
        Ok(out.into())
    }
}

fn damaged(error: &ParquetError) -> Error {
    Error::data(format!(
        "the Parquet file is cut off or damaged: {}",
        clip(&error.to_string())
    ))
    .advise("copy it again, or write it anew")
}

/// IEEE 754 binary16 by the format's own definition.
fn is_half(column: &ColumnDescriptor) -> bool {
    matches!(column.logical_type_ref(), Some(LogicalType::Float16))
        && column.physical_type() == Type::FIXED_LEN_BYTE_ARRAY
        && column.type_length() == 2
}

/// Calls the decoder, some of whose assertions damaged files reach: such a panic is an error, and nothing is printed.
///
/// The first call wraps the panic hook of the process by one that keeps still inside the decoder alone.
fn guarded<T>(act: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    thread_local! {
        static INSIDE: Cell<bool> = const { Cell::new(false) };
    }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |about| {
            if !INSIDE.get() {
                before(about);
            }
        }));
    });
    INSIDE.set(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(act));
    INSIDE.set(false);
    outcome.unwrap_or_else(|_| {
        let text = "its pages contradict one another".to_owned();
        Err(ParquetError::General(text))
    })
}

/// Unit of a column of the format's own time stamps.
fn stamp_unit(column: &ColumnDescriptor) -> Option<&'static str> {
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(kind)), _) => Some(match kind.unit {
            TimeUnit::MILLIS => "ms",
            TimeUnit::MICROS => "us",
            TimeUnit::NANOS => "ns",
        }),
        (_, ConvertedType::TIMESTAMP_MILLIS) => Some("ms"),
        (_, ConvertedType::TIMESTAMP_MICROS) => Some("us"),
        _ => None,
    }
}

/// Refuses a file whose numbers are packed as this build does not unpack.
fn refuse_packing(file: &SerializedFileReader<Pieces>, places: &[usize]) -> Result<(), Error> {
    let metadata = file.metadata();
    let Some(group) = metadata.row_groups().first() else {
        return Ok(());
    };
    let codec = places
        .iter()
        .filter_map(|&place| group.columns().get(place))
        .find_map(|column| match column.compression() {
            Compression::BROTLI(_) => Some("Brotli"),
            Compression::LZO => Some("LZO"),
            _ => None,
        });
    codec.map_or(Ok(()), |codec| {
        Err(Error::data(format!(
            "the Parquet file is packed by {codec}, which is not read"
        ))
        .advise("write it again with another codec, for instance compression='zstd'"))
    })
}

/// A column that is wanted.
struct Wanted {
    /// Its place in the file.
    column: usize,
    most_defined: i16,
    unsigned: bool,
    reader: Option<ColumnReader>,
    levels: Vec<i16>,
}

/// A Parquet file as a log.
pub(crate) struct Parquet {
    layout: RawLayout,
    file: SerializedFileReader<Pieces>,
    /// Place in the file of every column of the log.
    places: Vec<usize>,
    plan: Plan,
    /// Time first, where there is one.
    wanted: Vec<Wanted>,
    group: usize,
    left: u64,
}

impl Parquet {
    pub(crate) fn open(bytes: InputBytes, packed: &str) -> Result<Self, Error> {
        let InputBytes::File(file) = bytes else {
            return Err(super::arrays::no_pipe("a Parquet file", packed));
        };
        let file = Shared::new(file);
        let length = file.length().map_err(Error::read)?;
        let file = guarded(|| SerializedFileReader::new(Pieces { file, length }))
            .map_err(|e| damaged(&e))?;
        let (mut places, mut columns, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        let mut lists = Vec::new();
        let metadata = file.metadata().file_metadata();
        for (place, column) in metadata.schema_descr().columns().iter().enumerate() {
            let path = column.path().string();
            let is_number = matches!(
                column.physical_type(),
                Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
            ) || is_half(column);
            if column.max_rep_level() > 0 {
                lists.push(clip(
                    column.path().parts().first().map_or("", String::as_str),
                ));
                continue;
            }
            if !is_number || places.len() >= MOST_COLUMNS {
                left_out.push(clip(&path));
                continue;
            }
            let (name, unit) = name_and_unit(&path);
            let own = stamp_unit(column);
            places.push(place);
            columns.push(RawColumn {
                name,
                unit: own.map(str::to_owned).or(unit),
                is_own_unit: own.is_some(),
                ..RawColumn::default()
            });
        }
        let rows = u64::try_from(metadata.num_rows()).unwrap_or(0);
        refuse_packing(&file, &places)?;
        let notes: Vec<String> = lists_note(lists)
            .into_iter()
            .chain(left_out_note(left_out))
            .collect();
        refuse_empty(rows, columns.is_empty(), &notes)?;
        Ok(Self {
            layout: RawLayout {
                format: format!("Parquet{packed}"),
                columns,
                has_names: true,
                samples: Some(rows),
                header_place: Some("schema".to_owned()),
                notes,
                ..RawLayout::default()
            },
            file,
            places,
            plan: Plan::default(),
            wanted: Vec::new(),
            group: 0,
            left: 0,
        })
    }

    /// Goes to the next group of rows; `false` where there is none.
    fn next_group(&mut self) -> Result<bool, Error> {
        while self.left == 0 {
            if self.group >= self.file.num_row_groups() {
                return Ok(false);
            }
            let group = self
                .file
                .get_row_group(self.group)
                .map_err(|e| damaged(&e))?;
            self.group += 1;
            self.left = u64::try_from(group.metadata().num_rows()).unwrap_or(0);
            for wanted in &mut self.wanted {
                let reader = guarded(|| group.get_column_reader(wanted.column));
                wanted.reader = Some(reader.map_err(|e| damaged(&e))?);
            }
        }
        Ok(true)
    }
}

impl RawReader for Parquet {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        let schema = self.file.metadata().file_metadata().schema_descr();
        let columns = plan.time.iter().map(|t| t.0).chain(plan.columns.clone());
        self.wanted = columns
            .filter_map(|c| self.places.get(c).copied())
            .map(|column| {
                let about = schema.column(column);
                Wanted {
                    column,
                    most_defined: about.max_def_level(),
                    unsigned: matches!(
                        about.converted_type(),
                        ConvertedType::UINT_8
                            | ConvertedType::UINT_16
                            | ConvertedType::UINT_32
                            | ConvertedType::UINT_64
                    ),
                    reader: None,
                    levels: Vec::new(),
                }
            })
            .collect();
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        begin(block, &self.plan);
        if !self.next_group()? {
            return Ok(false);
        }
        let n = self.left.min(ROWS as u64) as usize;
        for (k, wanted) in self.wanted.iter_mut().enumerate() {
            let place = || format!("column {}", wanted.column);
            let mut sink = Sink::new(block, &self.plan, k);
            let (levels, most) = (&mut wanted.levels, wanted.most_defined);
            let unsigned = wanted.unsigned;
            let result = guarded(|| match &mut wanted.reader {
                Some(ColumnReader::BoolColumnReader(r)) => take(r, n, levels, most, |v| {
                    sink.put(v.map(i64::from), f64::from(u8::from(v.unwrap_or(false))));
                }),
                Some(ColumnReader::Int32ColumnReader(r)) => take(r, n, levels, most, |v| {
                    sink.whole(v.map(|v| {
                        if unsigned {
                            i64::from(v as u32)
                        } else {
                            i64::from(v)
                        }
                    }));
                }),
                Some(ColumnReader::Int64ColumnReader(r)) => take(r, n, levels, most, |v| match v {
                    Some(v) if unsigned && v < 0 => sink.put(None, v as u64 as f64),
                    v => sink.whole(v),
                }),
                Some(ColumnReader::FloatColumnReader(r)) => take(r, n, levels, most, |v| {
                    sink.put(None, v.map_or(f64::NAN, f64::from));
                }),
                Some(ColumnReader::FixedLenByteArrayColumnReader(r)) => {
                    take(r, n, levels, most, |v| {
                        let bits = v.and_then(|v| v.data().try_into().ok());
                        let value = bits.map(|b: [u8; 2]| half(u16::from_le_bytes(b)));
                        sink.put(None, value.unwrap_or(f64::NAN));
                    })
                }
                Some(ColumnReader::DoubleColumnReader(r)) => take(r, n, levels, most, |v| {
                    sink.put(None, v.unwrap_or(f64::NAN));
                }),
                _ => Ok(0),
            });
            match result {
                Ok(got) if got == n => {}
                Ok(_) => {
                    return Err(
                        Error::data("a column of the Parquet file ends before the others")
                            .at(place()),
                    );
                }
                Err(e) => return Err(damaged(&e).at(place())),
            }
        }
        self.left -= n as u64;
        block.rows = n;
        Ok(true)
    }
}

/// Hands `n` values of a column on, `None` for nulls; returns how many there were.
fn take<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    n: usize,
    levels: &mut Vec<i16>,
    most_defined: i16,
    mut put: impl FnMut(Option<T::T>),
) -> Result<usize, ParquetError> {
    let mut values: Vec<T::T> = Vec::with_capacity(n);
    let mut done = 0;
    while done < n {
        values.clear();
        levels.clear();
        let nullable = most_defined > 0;
        let (records, _, _) = reader.read_records(
            n - done,
            nullable.then_some(&mut *levels),
            None,
            &mut values,
        )?;
        if records == 0 {
            break;
        }
        let mut values = values.drain(..);
        if nullable {
            for &level in levels.iter().take(records) {
                put(if level == most_defined {
                    values.next()
                } else {
                    None
                });
            }
        } else {
            values.by_ref().take(records).for_each(|v| put(Some(v)));
        }
        done += records;
    }
    Ok(done)
}
