//! numpy archives `.npz`: a zip of `.npy` arrays, stored or deflated, read side by side.
//!
//! Arrays as long as the longest are columns, `NAME[k]` (`NAME` alone where it has one); the longer side is time.
//! Source: [ZIP].

use std::io::{BufReader, Read};

use super::part::Shared;
use super::scan::{u16_at, u32_at, u64_at};
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::npy::{Header, Npy, read_header_of_array, row_size};
use crate::text::{grouped, name_and_unit};
use crate::{Block, Error};

pub(crate) const MAGIC: &[u8] = b"PK\x03\x04";
/// Archives of more arrays are no log.
const MOST_ARRAYS: usize = 256;
/// A directory of so many entries is smaller.
const LARGEST_DIRECTORY: u64 = 1 << 20;

/// An array in the archive.
#[derive(Debug, Clone)]
struct Entry {
    name: String,
    method: u16,
    packed: u64,
    head: u64,
}

/// The entries that the archive's directory lists.
fn entries(file: &Shared) -> Result<Vec<Entry>, Error> {
    let bad = || Error::data("the zip archive is cut off or damaged: its directory cannot be read");
    let length = file.length().map_err(Error::read)?;
    let tail_at = length.saturating_sub(65_557);
    let mut tail = Vec::new();
    file.from(tail_at)
        .read_to_end(&mut tail)
        .map_err(Error::read)?;
    let end = memchr::memmem::rfind(&tail, b"PK\x05\x06").ok_or_else(bad)?;
    let mut at = u64::from(u32_at(&tail, end + 16).ok_or_else(bad)?);
    if at == u64::from(u32::MAX) {
        // Beyond 4 GiB: the record of 64 bits stands before.
        let wide = memchr::memmem::rfind(&tail[..end], b"PK\x06\x06").ok_or_else(bad)?;
        at = u64_at(&tail, wide + 48).ok_or_else(bad)?;
    }
    let mut directory = Vec::new();
    file.part(at, LARGEST_DIRECTORY)
        .read_to_end(&mut directory)
        .map_err(Error::read)?;
    let mut out = Vec::new();
    let mut rest = directory.as_slice();
    while rest.starts_with(b"PK\x01\x02") && out.len() < MOST_ARRAYS {
        let n = |at| u16_at(rest, at).map(usize::from).ok_or_else(bad);
        let (name, extra, comment) = (n(28)?, n(30)?, n(32)?);
        let mut packed = u64::from(u32_at(rest, 20).ok_or_else(bad)?);
        let whole = u32_at(rest, 24).ok_or_else(bad)?;
        let mut head = u64::from(u32_at(rest, 42).ok_or_else(bad)?);
        let text = rest.get(46..46 + name).ok_or_else(bad)?;
        let mut extras = rest.get(46 + name..46 + name + extra).ok_or_else(bad)?;
        while let (Some(kind), Some(size)) = (u16_at(extras, 0), u16_at(extras, 2)) {
            let size = usize::from(size);
            if kind == 1 {
                // Numbers of 64 bits stand here in this order, each only where its place of 32 bits is full.
                let mut k = if whole == u32::MAX { 12 } else { 4 };
                if packed == u64::from(u32::MAX) {
                    packed = u64_at(extras, k).ok_or_else(bad)?;
                    k += 8;
                }
                if head == u64::from(u32::MAX) {
                    head = u64_at(extras, k).ok_or_else(bad)?;
                }
            }
            extras = extras.get(4 + size..).unwrap_or(&[]);
        }
        out.push(Entry {
            name: String::from_utf8_lossy(text).into_owned(),
            method: u16_at(rest, 10).ok_or_else(bad)?,
            packed,
            head,
        });
        rest = rest.get(46 + name + extra + comment..).unwrap_or(&[]);
    }
    Ok(out)
}

/// The unpacked bytes of an entry.
fn unpack(file: &Shared, entry: &Entry) -> Result<Box<dyn Read + Send>, Error> {
    let mut head = Vec::new();
    file.part(entry.head, 30)
        .read_to_end(&mut head)
        .map_err(Error::read)?;
    let skip = match (u16_at(&head, 26), u16_at(&head, 28)) {
        (Some(name), Some(extra)) if head.starts_with(MAGIC) => {
            30 + u64::from(name) + u64::from(extra)
        }
        _ => {
            return Err(Error::data(format!(
                "the archive's entry `{}` is damaged",
                entry.name
            )));
        }
    };
    let bytes = file.part(entry.head.saturating_add(skip), entry.packed);
    match entry.method {
        0 => Ok(Box::new(BufReader::with_capacity(1 << 16, bytes))),
        8 => Ok(Box::new(flate2::read::DeflateDecoder::new(
            BufReader::with_capacity(1 << 16, bytes),
        ))),
        other => Err(Error::data(format!(
            "the archive's entry `{}` is packed by method {other}; stored and deflated ones are read",
            entry.name
        ))),
    }
}

/// An array whose columns belong to the log.
struct Array {
    entry: Entry,
    header: Header,
    /// Its first column in the log.
    first: usize,
    columns: usize,
    /// Bytes of the entry's data before it.
    skip: u64,
    reader: Option<Npy>,
    /// What it has delivered and was not yet taken.
    held: Block,
    taken: usize,
    /// Columns of the block and the column of the array that each is.
    slots: Vec<(usize, usize)>,
}

/// An archive as a log.
pub(crate) struct Npz {
    layout: RawLayout,
    file: Shared,
    arrays: Vec<Array>,
    plan: Plan,
    time_array: Option<usize>,
}

impl Npz {
    pub(crate) fn open(bytes: InputBytes, packed: &str) -> Result<Self, Error> {
        let InputBytes::File(file) = bytes else {
            return Err(Error::data("an .npz archive cannot be read from a pipe")
                .advise("name the file itself, unpacked"));
        };
        let file = Shared::new(file);
        let mut notes = Vec::new();
        let mut found = Vec::new();
        for entry in entries(&file)? {
            let Some(name) = entry.name.strip_suffix(".npy").map(str::to_owned) else {
                continue;
            };
            let mut reader = unpack(&file, &entry)?;
            match read_header_of_array(&mut reader) {
                Ok(header) => found.push((name, entry, header)),
                Err(_) => notes.push(format!(
                    "array `{}` is no table of numbers and was left out",
                    crate::map::columns::clip(&name)
                )),
            }
        }
        let rows = found.iter().map(|f| f.2.shape[0]).max().unwrap_or(0);
        if rows == 0 {
            return Err(Error::data("the archive holds no array of a log"));
        }
        let (mut arrays, mut columns) = (Vec::new(), Vec::new());
        for (name, entry, header) in found {
            if header.shape[0] != rows {
                notes.push(format!(
                    "array `{}` has {} rows, not {}, and was left out",
                    crate::map::columns::clip(&name),
                    grouped(header.shape[0]),
                    grouped(rows)
                ));
                continue;
            }
            let first = columns.len();
            let n = header.fields.len();
            for (k, (field, _)) in header.fields.iter().enumerate() {
                let (field, unit) = name_and_unit(field);
                let name = match (header.is_structured, n) {
                    (true, _) => field,
                    (false, 1) => name.clone(),
                    _ => format!("{name}[{k}]"),
                };
                columns.push(RawColumn {
                    name,
                    unit,
                    ..RawColumn::default()
                });
            }
            // Columns one after another are as many arrays, each read from its own place.
            let split = header.fortran && n > 1;
            for k in 0..if split { n } else { 1 } {
                let mut header = header.clone();
                let mut skip = 0;
                if split {
                    header.fields.truncate(1);
                    header.fortran = false;
                    skip = (row_size(&header) as u64)
                        .saturating_mul(rows)
                        .saturating_mul(k as u64);
                }
                arrays.push(Array {
                    entry: entry.clone(),
                    columns: header.fields.len(),
                    header,
                    first: first + k,
                    skip,
                    reader: None,
                    held: Block::default(),
                    taken: 0,
                    slots: Vec::new(),
                });
            }
        }
        Ok(Self {
            layout: RawLayout {
                format: format!("numpy archive{packed}"),
                columns,
                has_names: true,
                samples: Some(rows),
                header_place: Some("arrays".to_owned()),
                notes,
                ..RawLayout::default()
            },
            file,
            arrays,
            plan: Plan::default(),
            time_array: None,
        })
    }
}

impl RawReader for Npz {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        for (i, array) in self.arrays.iter_mut().enumerate() {
            let own = array.first..array.first + array.columns;
            let time = plan.time.filter(|t| own.contains(&t.0));
            array.slots = plan
                .columns
                .iter()
                .enumerate()
                .filter(|(_, c)| own.contains(c))
                .map(|(slot, &c)| (slot, c - array.first))
                .collect();
            if time.is_some() {
                self.time_array = Some(i);
            }
            if time.is_none() && array.slots.is_empty() {
                continue;
            }
            let mut bytes = unpack(&self.file, &array.entry)?;
            read_header_of_array(&mut bytes)?;
            std::io::copy(&mut bytes.by_ref().take(array.skip), &mut std::io::sink())
                .map_err(Error::read)?;
            let mut reader = Npy::of_array(array.header.clone(), bytes);
            reader.select(Plan {
                time: time.map(|(c, kind)| (c - array.first, kind)),
                columns: array.slots.iter().map(|s| s.1).collect(),
            })?;
            array.reader = Some(reader);
        }
        self.arrays.retain(|a| a.reader.is_some());
        self.time_array = plan.time.and_then(|t| {
            self.arrays
                .iter()
                .position(|a| (a.first..a.first + a.columns).contains(&t.0))
        });
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        super::table::begin(block, &self.plan);
        let mut n = usize::MAX;
        for array in &mut self.arrays {
            if array.taken >= array.held.rows
                && let Some(reader) = &mut array.reader
            {
                array.taken = 0;
                let more = reader
                    .read_raw(&mut array.held)
                    .map_err(|e| e.at(format!("array {}", array.entry.name)))?;
                if !more {
                    return Ok(false);
                }
            }
            n = n.min(array.held.rows - array.taken);
        }
        if n == usize::MAX || n == 0 {
            return Ok(false);
        }
        for (i, array) in self.arrays.iter_mut().enumerate() {
            let range = array.taken..array.taken + n;
            for (&(slot, _), column) in array.slots.iter().zip(&array.held.columns) {
                block.columns[slot].extend_from_slice(column.get(range.clone()).unwrap_or(&[]));
            }
            if self.time_array == Some(i) {
                for k in range {
                    if let Some(stamp) = array.held.stamps.get(k) {
                        block.stamps.push(stamp);
                    }
                }
            }
            array.taken += n;
        }
        block.rows = n;
        Ok(true)
    }
}
