//! numpy arrays: plain 1-D and 2-D (C or Fortran order) and structured ones, read in blocks of rows.
//!
//! Format: NEP 1. Magic `\x93NUMPY`, version, header length, a Python dict with `descr`, `fortran_order`, `shape`.

use std::io::{Cursor, Read, Seek, SeekFrom};

use crate::input::{InputBytes, remaining};
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::source::ReadSeek;
use crate::text::number::TimeKind;
use crate::text::{grouped, name_and_unit};
use crate::{Block, Error};

/// Bytes read at once.
const BLOCK: usize = 1 << 20;
/// A header of more columns or bytes is none of ours.
const MOST_COLUMNS: usize = 4096;
/// So few rows of so many values are channels, not samples.
const MOST_CHANNELS: u64 = 16;
const LEAST_SAMPLES: usize = 64;

/// A scalar of numpy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scalar {
    kind: u8,
    size: usize,
    big: bool,
}

impl Scalar {
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        let (order, rest) = match bytes.first()? {
            b'<' | b'>' | b'|' | b'=' => (bytes[0], &text[1..]),
            _ => (b'=', text),
        };
        let kind = *rest.as_bytes().first()?;
        let size: usize = rest.get(1..)?.parse().ok()?;
        let is_known = matches!(
            (kind, size),
            (b'f', 4 | 8 | 2) | (b'i' | b'u', 1 | 2 | 4 | 8) | (b'b', 1)
        );
        is_known.then_some(Self {
            kind,
            size,
            big: order == b'>',
        })
    }

    /// Its bytes.
    pub(crate) fn size(self) -> usize {
        self.size
    }

    /// A scalar of `kind` (`f`, `i`, `u`) in `size` bytes, where it is one that is read.
    pub(crate) fn of(kind: char, size: u64, big: bool) -> Option<Self> {
        Self::parse(&format!("{}{kind}{size}", if big { '>' } else { '<' }))
    }

    fn words(text: &str) -> String {
        crate::map::columns::clip(text)
    }

    /// The value, for integers also exactly.
    #[inline]
    fn value(self, bytes: &[u8]) -> (f64, Option<i64>) {
        let mut raw = [0_u8; 8];
        for (i, b) in bytes.iter().take(8).enumerate() {
            raw[if self.big { self.size - 1 - i } else { i }] = *b;
        }
        let bits = u64::from_le_bytes(raw);
        match (self.kind, self.size) {
            (b'f', 8) => (f64::from_bits(bits), None),
            (b'f', 4) => (f64::from(f32::from_bits(bits as u32)), None),
            (b'f', _) => (half(bits as u16), None),
            (b'i', size) => {
                let shift = 64 - 8 * size as u32;
                let v = ((bits << shift) as i64) >> shift;
                (v as f64, Some(v))
            }
            _ => (bits as f64, i64::try_from(bits).ok()),
        }
    }
}

/// IEEE 754 binary16.
pub(crate) fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> 10 & 31);
    let fraction = f64::from(bits & 1023) / 1024.0;
    sign * match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        e => (1.0 + fraction) * 2f64.powi(e - 15),
    }
}

/// A parsed header.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Name (empty in plain arrays) and scalar of every column, in the order of storage.
    pub(crate) fields: Vec<(String, Scalar)>,
    pub(crate) is_structured: bool,
    pub(crate) fortran: bool,
    pub(crate) shape: Vec<u64>,
}

impl Header {
    /// The header of another format's array of one or two sides, of which the longer is time; with `fortran` the first
    /// index runs fastest.
    pub(crate) fn of_table(one: Scalar, shape: Vec<u64>, fortran: bool) -> Result<Self, Error> {
        plain(one, shape, fortran, Sides::LongerIsTime)
    }
}

/// Reads magic and header; leaves the reader at the data.
pub(crate) fn read_header(reader: &mut dyn Read) -> Result<Header, Error> {
    parse_header(&header_text(reader)?, Sides::AsTheyAre)
}

/// As [`read_header`], for arrays whose longer side is time.
pub(crate) fn read_header_of_array(reader: &mut dyn Read) -> Result<Header, Error> {
    parse_header(&header_text(reader)?, Sides::LongerIsTime)
}

/// Which side of a table is time.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sides {
    AsTheyAre,
    LongerIsTime,
}

fn header_text(reader: &mut dyn Read) -> Result<String, Error> {
    let cut = |_| Error::data("the .npy header is cut off").advise("copy the file again");
    let mut start = [0_u8; 8];
    reader.read_exact(&mut start).map_err(cut)?;
    let length = if start[6] == 1 {
        let mut n = [0_u8; 2];
        reader.read_exact(&mut n).map_err(cut)?;
        usize::from(u16::from_le_bytes(n))
    } else {
        let mut n = [0_u8; 4];
        reader.read_exact(&mut n).map_err(cut)?;
        u32::from_le_bytes(n) as usize
    };
    if length > 1 << 20 {
        return Err(Error::data("the .npy header is longer than 1 MiB"));
    }
    let mut text = vec![0; length];
    reader.read_exact(&mut text).map_err(cut)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn parse_header(text: &str, sides: Sides) -> Result<Header, Error> {
    let bad = || {
        Error::data("the .npy header cannot be read")
            .advise("copy the file again, or save the array anew with numpy.save")
    };
    let after = |key: &str| {
        let at = text
            .find(&format!("'{key}'"))
            .or_else(|| text.find(&format!("\"{key}\"")))?;
        text[at + key.len() + 2..]
            .trim_start()
            .strip_prefix(':')
            .map(str::trim_start)
    };
    let fortran = after("fortran_order").ok_or_else(bad)?.starts_with("True");
    let shape_text = after("shape")
        .and_then(|s| s.strip_prefix('('))
        .and_then(|s| s.split(')').next())
        .ok_or_else(bad)?;
    let shape: Vec<u64> = shape_text
        .split(',')
        .map(|n| n.trim().trim_end_matches('L'))
        .filter(|n| !n.is_empty())
        .map(|n| n.parse::<u64>().map_err(|_| bad()))
        .collect::<Result<_, _>>()?;
    let descr = after("descr").ok_or_else(bad)?;
    let scalar = |t: &str| {
        Scalar::parse(t).ok_or_else(|| {
            Error::data(format!(
                "numbers of type `{}` are not read",
                Scalar::words(t)
            ))
            .advise("save floats or integers, for instance array.astype('f8')")
        })
    };
    if let Some(list) = descr.strip_prefix('[') {
        let mut strings = Vec::new();
        let mut rest = list;
        // ('name', '<f8'), …: quoted texts in pairs, up to the closing bracket.
        while let Some(open) = rest.find(['\'', '"', ']']) {
            let quote = rest.as_bytes()[open];
            if quote == b']' {
                break;
            }
            let body = &rest[open + 1..];
            let close = body.find(quote as char).ok_or_else(bad)?;
            strings.push(body[..close].to_owned());
            rest = &body[close + 1..];
            if strings.len() % 2 == 0 && !rest.trim_start().starts_with(')') {
                return Err(
                    Error::data("structured arrays with arrays inside are not read")
                        .advise("give each number a field of its own"),
                );
            }
            if strings.len() > 2 * MOST_COLUMNS {
                return Err(Error::data("the array has more than 4096 columns"));
            }
        }
        let fields = strings
            .chunks_exact(2)
            .map(|pair| Ok((pair[0].clone(), scalar(&pair[1])?)))
            .collect::<Result<Vec<_>, Error>>()?;
        if fields.is_empty() || strings.len() % 2 != 0 || shape.len() != 1 {
            return Err(bad());
        }
        return Ok(Header {
            fields,
            is_structured: true,
            fortran: false,
            shape,
        });
    }
    let quote = descr
        .chars()
        .next()
        .filter(|c| *c == '\'' || *c == '"')
        .ok_or_else(bad)?;
    let one = scalar(descr[1..].split(quote).next().ok_or_else(bad)?)?;
    plain(one, shape, fortran, sides)
}

/// The header of a plain array of one or two sides.
fn plain(
    one: Scalar,
    mut shape: Vec<u64>,
    mut fortran: bool,
    sides: Sides,
) -> Result<Header, Error> {
    if let (Sides::LongerIsTime, &[a, b]) = (sides, shape.as_slice())
        && b > a
    {
        shape.reverse();
        fortran = !fortran;
    }
    let columns = match shape.as_slice() {
        [_] => 1,
        [_, c] => *c,
        other => {
            return Err(Error::data(format!(
                "the array has {} dimensions, a log has one or two",
                other.len()
            ))
            .advise("save it as a table of rows, for instance array.reshape(len(array), -1)"));
        }
    };
    let columns = usize::try_from(columns)
        .ok()
        .filter(|&c| c > 0 && c <= MOST_COLUMNS)
        .ok_or_else(|| {
            Error::data(format!(
                "the array has {columns} columns, a log has 1 to {MOST_COLUMNS}"
            ))
            .advise("a row is a sample: if its rows are channels, save array.T")
        })?;
    if let (Sides::AsTheyAre, &[rows, _]) = (sides, shape.as_slice())
        && rows <= MOST_CHANNELS
        && columns >= LEAST_SAMPLES
    {
        return Err(Error::data(format!(
            "the array has {rows} rows of {columns} values, as if its rows were channels"
        ))
        .advise("a row is a sample: save array.T"));
    }
    Ok(Header {
        fields: vec![(String::new(), one); columns],
        is_structured: false,
        fortran,
        shape,
    })
}

/// A numpy array as a log.
pub(crate) struct Npy {
    layout: RawLayout,
    header: Header,
    data: Data,
    plan: Plan,
    rows: u64,
    done: u64,
    buffer: Vec<u8>,
}

enum Data {
    /// Rows one after another.
    Rows(Box<dyn Read + Send>),
    /// Columns one after another, from this offset.
    Columns(Box<dyn ReadSeek>, u64),
}

impl Npy {
    pub(crate) fn open(bytes: InputBytes, packed: &str) -> Result<Self, Error> {
        let (header, data) = match bytes {
            InputBytes::Stream(mut reader) => {
                let header = read_header(&mut reader)?;
                let size = row_size(&header);
                let data = if header.fortran && header.fields.len() > 1 {
                    // Columns one after another in a stream: they have to be held.
                    let total = header.shape[0].saturating_mul(size as u64);
                    let mut all = Vec::new();
                    reader
                        .take(total)
                        .read_to_end(&mut all)
                        .map_err(Error::read)?;
                    let have = all.len() as u64;
                    refuse_short(&header, have)?;
                    Data::Columns(Box::new(Cursor::new(all)), 0)
                } else {
                    Data::Rows(reader)
                };
                (header, data)
            }
            InputBytes::File(mut file) => {
                let header = read_header(&mut file)?;
                let have = remaining(&mut *file).map_err(Error::read)?;
                refuse_short(&header, have)?;
                let start = file.stream_position().map_err(Error::read)?;
                let data = if header.fortran && header.fields.len() > 1 {
                    Data::Columns(file, start)
                } else {
                    Data::Rows(Box::new(file))
                };
                (header, data)
            }
        };
        let rows = header.shape[0];
        if rows == 0 {
            return Err(Error::data("the array has no rows")
                .advise("look at what recorded it, or copy the file again"));
        }
        let columns = header
            .fields
            .iter()
            .map(|(text, _)| {
                let (name, unit) = name_and_unit(text);
                RawColumn {
                    name,
                    unit,
                    ..RawColumn::default()
                }
            })
            .collect();
        let mut layout = RawLayout {
            format: format!(
                "{}{packed}",
                if header.is_structured {
                    "numpy structured array"
                } else {
                    "numpy array"
                }
            ),
            columns,
            has_names: header.is_structured,
            samples: Some(rows),
            ..RawLayout::default()
        };
        layout.header_place = header.is_structured.then(|| "header".to_owned());
        Ok(Self {
            layout,
            header,
            data,
            plan: Plan::default(),
            rows,
            done: 0,
            buffer: Vec::new(),
        })
    }

    /// An array whose header was read, in a stream that stands at its data; not in Fortran order.
    pub(crate) fn of_array(header: Header, reader: Box<dyn Read + Send>) -> Self {
        Self {
            layout: RawLayout::default(),
            rows: header.shape.first().copied().unwrap_or(0),
            header,
            data: Data::Rows(reader),
            plan: Plan::default(),
            done: 0,
            buffer: Vec::new(),
        }
    }

    /// Reads what follows the last row of an array in an archive: its checksum stands at the end.
    pub(crate) fn drain(&mut self) -> std::io::Result<()> {
        if let Data::Rows(reader) = &mut self.data {
            std::io::copy(reader, &mut std::io::sink())?;
        }
        Ok(())
    }

    fn block_rows(&self) -> u64 {
        (BLOCK / row_size(&self.header).max(1)).max(1) as u64
    }
}

pub(crate) fn row_size(header: &Header) -> usize {
    header.fields.iter().map(|f| f.1.size).sum()
}

/// What to do with an array that ends after so many whole rows.
fn cut_short(rows: u64) -> String {
    match rows {
        0 => "the file is cut off: copy it again".to_owned(),
        n => format!("the file is cut off: copy it again, or save its first {n} rows with numpy"),
    }
}

fn refuse_short(header: &Header, have: u64) -> Result<(), Error> {
    let size = row_size(header) as u64;
    let rows = header.shape[0];
    if rows.checked_mul(size).is_none_or(|total| total > have) {
        return Err(Error::data(format!(
            "the header promises {} rows, the file holds {}",
            grouped(rows),
            grouped(have / size.max(1))
        ))
        .advise(cut_short(have / size.max(1))));
    }
    Ok(())
}

impl RawReader for Npy {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        block.clear();
        block.columns.resize_with(self.plan.columns.len(), Vec::new);
        let n = self.block_rows().min(self.rows - self.done) as usize;
        if n == 0 {
            return Ok(false);
        }
        let wanted: Vec<(usize, Option<TimeKind>)> = self
            .plan
            .time
            .iter()
            .map(|&(c, kind)| (c, Some(kind)))
            .chain(self.plan.columns.iter().map(|&c| (c, None)))
            .collect();
        let size = row_size(&self.header);
        match &mut self.data {
            Data::Rows(reader) => {
                self.buffer.clear();
                reader
                    .by_ref()
                    .take((n * size) as u64)
                    .read_to_end(&mut self.buffer)
                    .map_err(Error::read)?;
                let got = self.buffer.len() / size;
                if got < n {
                    return Err(Error::data(format!(
                        "the header promises {} rows, the stream ends after {}",
                        grouped(self.rows),
                        grouped(self.done + got as u64)
                    ))
                    .advise(cut_short(self.done + got as u64)));
                }
                let mut slot = 0;
                for (column, kind) in wanted {
                    let offset: usize = self.header.fields[..column].iter().map(|f| f.1.size).sum();
                    let scalar = self.header.fields[column].1;
                    let cells = self
                        .buffer
                        .chunks_exact(size)
                        .filter_map(|row| row.get(offset..offset + scalar.size));
                    fill(cells, scalar, kind, block, &mut slot);
                }
            }
            Data::Columns(file, start) => {
                let mut slot = 0;
                for (column, kind) in wanted {
                    let scalar = self.header.fields[column].1;
                    let at = *start + (column as u64 * self.rows + self.done) * scalar.size as u64;
                    file.seek(SeekFrom::Start(at)).map_err(Error::read)?;
                    self.buffer.resize(n * scalar.size, 0);
                    file.read_exact(&mut self.buffer).map_err(Error::read)?;
                    fill(
                        self.buffer.chunks_exact(scalar.size),
                        scalar,
                        kind,
                        block,
                        &mut slot,
                    );
                }
            }
        }
        self.done += n as u64;
        block.rows = n;
        Ok(true)
    }
}

/// Turns the cells of one column into stamps or values.
fn fill<'a>(
    cells: impl Iterator<Item = &'a [u8]>,
    scalar: Scalar,
    kind: Option<TimeKind>,
    block: &mut Block,
    slot: &mut usize,
) {
    if let Some(kind) = kind {
        for cell in cells {
            let (v, whole) = scalar.value(cell);
            block.stamps.push(match whole {
                Some(i) => kind.of_integer(i),
                None => kind.of_float(v),
            });
        }
        return;
    }
    let column = &mut block.columns[*slot];
    if (scalar.kind, scalar.size, scalar.big) == (b'f', 8, false) {
        column.extend(cells.map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default())));
    } else {
        column.extend(cells.map(|c| scalar.value(c).0));
    }
    *slot += 1;
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn headers_are_read() {
        let h = parse_header(
            "{'descr': '<f8', 'fortran_order': False, 'shape': (10, 7), }",
            Sides::AsTheyAre,
        )
        .unwrap();
        assert_eq!(
            (h.fields.len(), h.shape, h.fortran),
            (7, vec![10, 7], false)
        );
        let h = parse_header("{'descr': [('time [s]', '<f8'), ('gyro_x [rad/s]', '>f4')], 'fortran_order': False, 'shape': (3,), }", Sides::AsTheyAre).unwrap();
        assert!(h.is_structured);
        assert_eq!(h.fields[1].0, "gyro_x [rad/s]");
        assert!(h.fields[1].1.big);
        for bad in [
            "",
            "{}",
            "{'descr': '<c16', 'fortran_order': False, 'shape': (3,)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3,4,5)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': ()}",
            "{'descr': [('a', '<f8', (3,))], 'fortran_order': False, 'shape': (3,)}",
        ] {
            assert!(parse_header(bad, Sides::AsTheyAre).is_err(), "{bad}");
        }
    }

    #[test]
    fn scalars_are_exact() {
        assert_eq!(
            Scalar::parse(">i2").unwrap().value(&[0xFF, 0xFE]),
            (-2.0, Some(-2))
        );
        assert_eq!(
            Scalar::parse("<u4").unwrap().value(&[1, 0, 0, 128]).1,
            Some(0x8000_0001)
        );
        assert_eq!(Scalar::parse("<f2").unwrap().value(&[0x00, 0xC0]).0, -2.0);
        assert_eq!(
            Scalar::parse("<i8")
                .unwrap()
                .value(&1_520_530_308_181_901_469_i64.to_le_bytes())
                .1,
            Some(1_520_530_308_181_901_469)
        );
    }
}
