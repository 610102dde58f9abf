//! numpy archives `.npz`: a zip of `.npy` arrays, stored or deflated, read side by side.
//!
//! Source: [ZIP].

use std::io::{BufReader, Read};

use super::arrays::{Arrays, Found, MOST_ARRAYS};
use super::part::Shared;
use super::scan::{u16_at, u32_at, u64_at};
use crate::Error;
use crate::input::InputBytes;
use crate::map::columns::clip;
use crate::npy::read_header_of_array;

pub(crate) const MAGIC: &[u8] = b"PK\x03\x04";
/// A directory of so many entries is smaller.
const LARGEST_DIRECTORY: u64 = 1 << 20;

/// An array in the archive.
#[derive(Debug, Clone)]
struct Entry {
    name: String,
    method: u16,
    packed: u64,
    head: u64,
    /// CRC-32 and number of the bytes unpacked.
    sum: u32,
    whole: u64,
}

/// The unpacked bytes of an entry, the last of which come with the proof that all are right.
struct Checked {
    reader: Box<dyn Read + Send>,
    name: String,
    found: flate2::Crc,
    seen: u64,
    sum: u32,
    whole: u64,
}

impl Read for Checked {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.reader.read(buffer)?;
        let ends = n == 0 && !buffer.is_empty() && self.seen < self.whole;
        self.found.update(buffer.get(..n).unwrap_or(&[]));
        let before = self.seen;
        self.seen += n as u64;
        let is_last = before < self.whole && self.seen >= self.whole;
        if ends || self.seen > self.whole || (is_last && self.found.sum() != self.sum) {
            let text = format!(
                "the archive's entry `{}` is damaged: it does not match its checksum",
                clip(&self.name)
            );
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, text));
        }
        Ok(n)
    }
}

/// The entries that the archive's directory lists.
fn entries(file: &Shared) -> Result<Vec<Entry>, Error> {
    let bad = || {
        Error::data("the zip archive is cut off or damaged: its directory cannot be read")
            .advise("copy it again: the directory stands at its end")
    };
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
        let mut whole = u64::from(u32_at(rest, 24).ok_or_else(bad)?);
        let mut head = u64::from(u32_at(rest, 42).ok_or_else(bad)?);
        let text = rest.get(46..46 + name).ok_or_else(bad)?;
        let mut extras = rest.get(46 + name..46 + name + extra).ok_or_else(bad)?;
        while let (Some(kind), Some(size)) = (u16_at(extras, 0), u16_at(extras, 2)) {
            let size = usize::from(size);
            if kind == 1 {
                // Numbers of 64 bits stand here in this order, each only where its place of 32 bits is full.
                let mut k = 4;
                if whole == u64::from(u32::MAX) {
                    whole = u64_at(extras, k).ok_or_else(bad)?;
                    k += 8;
                }
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
            sum: u32_at(rest, 16).ok_or_else(bad)?,
            whole,
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
    let bytes = BufReader::with_capacity(1 << 16, bytes);
    let reader: Box<dyn Read + Send> = match entry.method {
        0 => Box::new(bytes),
        8 => Box::new(flate2::read::DeflateDecoder::new(bytes)),
        other => return Err(Error::data(format!(
            "the archive's entry `{}` is packed by method {other}; stored and deflated ones are read",
            entry.name
        ))
        .advise("write it again by numpy.savez")),
    };
    Ok(Box::new(Checked {
        reader,
        name: entry.name.clone(),
        found: flate2::Crc::new(),
        seen: 0,
        sum: entry.sum,
        whole: entry.whole,
    }))
}

/// An archive as a log.
pub(crate) fn open(bytes: InputBytes, packed: &str) -> Result<Arrays, Error> {
    let InputBytes::File(file) = bytes else {
        return Err(super::arrays::no_pipe("an .npz archive", packed));
    };
    let file = Shared::new(file);
    let (mut found, mut notes) = (Vec::new(), Vec::new());
    for entry in entries(&file)? {
        let Some(name) = entry.name.strip_suffix(".npy").map(str::to_owned) else {
            continue;
        };
        let header = read_header_of_array(&mut unpack(&file, &entry)?);
        let file = file.clone();
        let open = move || -> Result<Box<dyn Read + Send>, Error> {
            let mut reader = unpack(&file, &entry)?;
            read_header_of_array(&mut reader)?;
            Ok(reader)
        };
        match header {
            Ok(header) => found.push(Found::new(name, header, open)),
            Err(_) => notes.push(super::arrays::no_table(&name)),
        }
    }
    Arrays::new(format!("numpy archive{packed}"), found, notes)
}
