//! MATLAB `.mat` files of version 5 (v6 uncompressed, v7 with zlib): numeric arrays by name, fields of structs as `s.f`.
//!
//! Elements of a tag (type, bytes) and data padded to eight; `miMATRIX` holds flags, dimensions, name and numbers,
//! column by column; `miCOMPRESSED` holds another element. Source: [MAT5].

use std::io::{BufReader, Read};

use super::arrays::{Arrays, Found, MOST_ARRAYS, no_pipe, no_table};
use super::part::Shared;
use crate::Error;
use crate::input::InputBytes;
use crate::map::columns::clip;
use crate::npy::{Header, Scalar};

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Structs in structs beyond this are no log.
const DEEPEST: usize = 8;
/// A name, or a list of fields, of more bytes is none.
const LARGEST_TEXT: u64 = 1 << 16;
/// More elements than a log has; the walk ends there.
const MOST_ELEMENTS: usize = 1 << 14;

/// True for the first bytes of such a file.
pub(crate) fn recognize(head: &[u8]) -> bool {
    matches!(
        head.get(124..128),
        Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])
    )
}

/// Where an element's bytes come from.
enum Bytes {
    /// The file itself, from this place on.
    Plain(Shared, u64),
    /// Unpacked, so many bytes so far.
    Packed(Box<dyn Read + Send>, u64),
}

impl Bytes {
    fn unpack(file: &Shared, at: u64, length: u64) -> Box<dyn Read + Send> {
        let part = BufReader::with_capacity(1 << 16, file.part(at, length));
        Box::new(flate2::read::ZlibDecoder::new(part))
    }

    fn at(&self) -> u64 {
        match self {
            Self::Plain(_, at) | Self::Packed(_, at) => *at,
        }
    }

    /// Up to `n` bytes; `None` where there are fewer.
    fn read(&mut self, n: u64) -> Option<Vec<u8>> {
        let mut out = Vec::new();
        match self {
            Self::Plain(file, at) => file.part(*at, n).read_to_end(&mut out),
            Self::Packed(reader, _) => reader.take(n).read_to_end(&mut out),
        }
        .ok()?;
        let (Self::Plain(_, at) | Self::Packed(_, at)) = self;
        *at += n;
        (out.len() as u64 == n).then_some(out)
    }

    /// Goes to `to`, which lies ahead.
    fn skip_to(&mut self, to: u64) -> Option<()> {
        let n = to.checked_sub(self.at())?;
        match self {
            Self::Plain(_, at) => *at = to,
            Self::Packed(reader, at) => {
                let there = std::io::copy(&mut reader.take(n), &mut std::io::sink()).ok()?;
                *at = to;
                (there == n).then_some(())?;
            }
        }
        Some(())
    }
}

/// A tag and where its data begins; small elements hold up to four bytes in the tag itself.
struct Tag {
    kind: u32,
    length: u64,
    small: Option<[u8; 4]>,
    data: u64,
}

/// A walk over the elements of a file.
struct Walk {
    file: Shared,
    length: u64,
    big: bool,
    /// The compressed element that the walk is in.
    packed: Option<(u64, u64)>,
    elements: usize,
    found: Vec<Found>,
    notes: Vec<String>,
}

impl Walk {
    fn word(&self, bytes: &[u8]) -> u32 {
        let mut raw = [0; 4];
        for (to, from) in raw.iter_mut().zip(bytes) {
            *to = *from;
        }
        if self.big {
            u32::from_be_bytes(raw)
        } else {
            u32::from_le_bytes(raw)
        }
    }

    fn tag(&self, bytes: &mut Bytes) -> Option<Tag> {
        let raw = bytes.read(8)?;
        let first = self.word(&raw);
        let (small, kind, length) = match first >> 16 {
            0 => (None, first, self.word(&raw[4..])),
            n if n <= 4 => (raw[4..].try_into().ok(), first & 0xFFFF, n),
            _ => return None,
        };
        Some(Tag {
            kind,
            length: u64::from(length),
            data: bytes.at() - if small.is_some() { 4 } else { 0 },
            small,
        })
    }

    /// The data of a short element.
    fn data(&self, bytes: &mut Bytes) -> Option<Vec<u8>> {
        let tag = self.tag(bytes)?;
        if let Some(small) = tag.small {
            return Some(small[..tag.length as usize].to_vec());
        }
        if tag.length > LARGEST_TEXT {
            return None;
        }
        let mut out = bytes.read(tag.length.next_multiple_of(8))?;
        out.truncate(tag.length as usize);
        Some(out)
    }

    /// The whole file; `None` where it is cut off or damaged.
    fn run(&mut self) -> Option<()> {
        let mut at = 128;
        while at < self.length && self.found.len() < MOST_ARRAYS {
            let mut bytes = Bytes::Plain(self.file.clone(), at);
            let tag = self.tag(&mut bytes)?;
            let end = tag.data.checked_add(tag.length)?;
            if tag.kind == COMPRESSED {
                let mut unpacked =
                    Bytes::Packed(Bytes::unpack(&self.file, tag.data, tag.length), 0);
                self.packed = Some((tag.data, tag.length));
                let inner = self.tag(&mut unpacked)?;
                if inner.kind == MATRIX {
                    self.matrix(&mut unpacked, inner.length, "", 0)?;
                }
                self.packed = None;
                at = end;
            } else {
                if tag.kind == MATRIX {
                    self.matrix(&mut bytes, tag.length, "", 0)?;
                }
                at = end.checked_next_multiple_of(8)?;
            }
        }
        (at <= self.length.next_multiple_of(8)).then_some(())
    }

    /// One array of `length` bytes, which begins here; leaves the reader where it stopped looking.
    fn matrix(&mut self, bytes: &mut Bytes, length: u64, prefix: &str, depth: usize) -> Option<()> {
        self.elements += 1;
        if length == 0 || self.elements > MOST_ELEMENTS {
            return Some(());
        }
        let end = bytes.at().checked_add(length)?;
        let flags = self.word(self.data(bytes)?.get(..4)?);
        let sides: Vec<u64> = self
            .data(bytes)?
            .chunks_exact(4)
            .map(|raw| u64::from(self.word(raw)))
            .collect();
        let own = self.data(bytes)?;
        let own = String::from_utf8_lossy(&own);
        let name = if prefix.is_empty() { &*own } else { prefix }.to_owned();
        let is_complex = flags & 0x800 != 0;
        match flags & 0xFF {
            2 if sides.iter().all(|&n| n == 1) && depth < DEEPEST => {
                let width = self.word(&self.data(bytes)?) as usize;
                let names = self.data(bytes)?;
                if width == 0 {
                    return None;
                }
                for field in names.chunks_exact(width) {
                    let field = field.split(|&b| b == 0).next().unwrap_or(&[]);
                    let tag = self.tag(bytes)?;
                    if tag.kind != MATRIX {
                        return None;
                    }
                    let next = tag.data.checked_add(tag.length)?;
                    let path = format!("{name}.{}", String::from_utf8_lossy(field));
                    self.matrix(bytes, tag.length, &path, depth + 1)?;
                    bytes.skip_to(next)?;
                }
            }
            6..=15 if !is_complex && sides.iter().filter(|&&n| n != 1).count() <= 2 => {
                let tag = self.tag(bytes)?;
                let (kind, size) = match tag.kind {
                    1 => ('i', 1),
                    2 => ('u', 1),
                    3 => ('i', 2),
                    4 => ('u', 2),
                    5 => ('i', 4),
                    6 => ('u', 4),
                    7 => ('f', 4),
                    9 => ('f', 8),
                    12 => ('i', 8),
                    13 => ('u', 8),
                    _ => return None,
                };
                let numbers = sides.iter().try_fold(1_u64, |n, &s| n.checked_mul(s))?;
                if numbers.checked_mul(size)? != tag.length || tag.data + tag.length > end {
                    return None;
                }
                if self.packed.is_none() && end > self.length {
                    return None;
                }
                let mut sides: Vec<u64> = sides.into_iter().filter(|&n| n != 1).collect();
                if sides.is_empty() {
                    sides.push(1);
                }
                let header = Scalar::of(kind, size, self.big)
                    .and_then(|one| Header::of_table(one, sides, true).ok());
                match header {
                    Some(header) if numbers > 0 => self.add(name, header, &tag),
                    _ => self.notes.push(no_table(&name)),
                }
            }
            _ => self.notes.push(no_table(&name)),
        }
        Some(())
    }

    fn add(&mut self, name: String, header: Header, tag: &Tag) {
        let (file, at, length) = (self.file.clone(), tag.data, tag.length);
        let packed = self.packed;
        self.found.push(Found::new(name, header, move || {
            let Some((start, size)) = packed else {
                let part = BufReader::with_capacity(1 << 16, file.part(at, length));
                return Ok(Box::new(part));
            };
            let mut bytes = Bytes::unpack(&file, start, size);
            std::io::copy(&mut bytes.by_ref().take(at), &mut std::io::sink())
                .map_err(|_| damaged())?;
            Ok(Box::new(Whole {
                reader: bytes,
                left: length,
            }))
        }));
    }
}

/// Part of a packed element, after which the rest is unpacked as well: the checksum stands at its end.
struct Whole {
    reader: Box<dyn Read + Send>,
    left: u64,
}

impl Read for Whole {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let damaged = |_| {
            let text = "the packed array is cut off or does not match its checksum";
            std::io::Error::new(std::io::ErrorKind::InvalidData, text)
        };
        if self.left == 0 {
            std::io::copy(&mut self.reader, &mut std::io::sink()).map_err(damaged)?;
            return Ok(0);
        }
        let n = self.reader.by_ref().take(self.left).read(buffer);
        let n = n.map_err(damaged)?;
        self.left -= n as u64;
        Ok(n)
    }
}

fn damaged() -> Error {
    Error::data("the MATLAB file is cut off or damaged").advise("copy it again, or save it anew")
}

/// A MATLAB file as a log.
pub(crate) fn open(bytes: InputBytes, head: &[u8], packed: &str) -> Result<Arrays, Error> {
    let InputBytes::File(file) = bytes else {
        return Err(no_pipe("a MATLAB file", packed));
    };
    let file = Shared::new(file);
    let mut walk = Walk {
        length: file.length().map_err(Error::read)?,
        file,
        big: head.get(126) == Some(&b'M'),
        packed: None,
        elements: 0,
        found: Vec::new(),
        notes: Vec::new(),
    };
    if walk.run().is_none() {
        if walk.found.is_empty() {
            return Err(damaged());
        }
        walk.notes.push(format!(
            "the file is cut off or damaged after array `{}`; the rest is left out",
            clip(
                &walk
                    .found
                    .last()
                    .map(|f| f.name.clone())
                    .unwrap_or_default()
            )
        ));
    }
    let order = if walk.big { ", big-endian" } else { "" };
    Arrays::new(format!("MATLAB 5{order}{packed}"), walk.found, walk.notes)
}
