//! HDF5, netCDF-4 and MATLAB 7.3 files: numeric data sets of one or two sides, by their path.
//!
//! Read are contiguous, compact and chunked data sets (deflate, shuffle, Fletcher-32, Zstandard), groups of both
//! generations; of a chunked data set one stripe of chunks is held at a time. Source: [HDF5].

mod chunks;
mod groups;
mod object;

use std::io::{BufReader, Cursor, Read};

use super::arrays::{Arrays, Found, MOST_ARRAYS, no_pipe, no_table};
use super::part::Shared;
use crate::Error;
use crate::input::InputBytes;
use crate::npy::Header;
use crate::text::grouped;
use object::{Layout, Object};

const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";
/// The largest piece of a file's structure that is looked at at once.
const LARGEST: u64 = 1 << 20;
/// Groups in groups beyond this are no log.
const DEEPEST: usize = 8;
/// More objects than a log has; the walk ends there.
const MOST_OBJECTS: usize = 1 << 12;

/// Where the file proper begins, for the first bytes of such a file: MATLAB puts 512 bytes of its own before.
pub(crate) fn recognize(head: &[u8]) -> Option<u64> {
    [0, 512, 1024, 2048]
        .into_iter()
        .find(|&at| head.get(at..at + 8) == Some(MAGIC))
        .map(|at| at as u64)
}

/// A file: where it begins and how wide its addresses and lengths are.
#[derive(Clone)]
struct File {
    bytes: Shared,
    start: u64,
    address: usize,
    length: usize,
}

impl File {
    /// Up to `n` bytes at an address.
    fn read(&self, at: u64, n: u64) -> Option<Vec<u8>> {
        let mut out = Vec::new();
        self.bytes
            .part(self.start.checked_add(at)?, n.min(LARGEST))
            .read_to_end(&mut out)
            .ok()?;
        Some(out)
    }
}

/// A cursor over bytes that answers `None` beyond their end.
#[derive(Clone, Copy)]
struct View<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> View<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let out = self.bytes.get(self.at..self.at.checked_add(n)?)?;
        self.at += n;
        Some(out)
    }

    /// A little-endian number of up to eight bytes.
    fn number(&mut self, n: usize) -> Option<u64> {
        let mut raw = [0; 8];
        raw.get_mut(..n)?.copy_from_slice(self.take(n)?);
        Some(u64::from_le_bytes(raw))
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|b| b[0])
    }
}

/// Reads the superblock: the file, the address of its root group and the length that the file should have.
fn superblock(bytes: Shared, start: u64) -> Option<(File, u64, u64)> {
    let mut file = File {
        bytes,
        start,
        address: 8,
        length: 8,
    };
    let raw = file.read(0, 128)?;
    let mut view = View::new(raw.get(8..)?);
    let version = view.byte()?;
    let is_old = version < 2;
    if is_old {
        view.take(4)?;
    }
    file.address = usize::from(view.byte()?);
    file.length = usize::from(view.byte()?);
    if ![4, 8].contains(&file.address) || ![4, 8].contains(&file.length) || version > 3 {
        return None;
    }
    // Old: reserved, two tree sizes, flags; then four addresses and the root's entry, a name before its header.
    view.take(match version {
        0 => 9,
        1 => 13,
        _ => 1,
    })?;
    view.take(2 * file.address)?;
    let end = view.number(file.address)?;
    view.take(if is_old { 2 * file.address } else { 0 })?;
    let root = view.number(file.address)?;
    Some((file, root, end))
}

/// The walk over groups.
struct Walk {
    file: File,
    separator: char,
    objects: usize,
    found: Vec<Found>,
    notes: Vec<String>,
}

impl Walk {
    fn object(&mut self, at: u64, path: &str, depth: usize) {
        self.objects += 1;
        if self.objects > MOST_OBJECTS || self.found.len() >= MOST_ARRAYS {
            return;
        }
        let Some(object) = Object::read(&self.file, at) else {
            self.notes
                .push(format!("{} is damaged and left out", describe(path)));
            return;
        };
        if object.is_group() {
            if depth >= DEEPEST {
                return;
            }
            let Some(links) = groups::links(&self.file, &object) else {
                self.notes.push(format!(
                    "{} is damaged, or laid out in a way that is not read, and left out",
                    describe(path)
                ));
                return;
            };
            for (name, at) in links {
                // MATLAB keeps cells and objects there.
                if name.starts_with('#') {
                    continue;
                }
                let path = if path.is_empty() {
                    name
                } else {
                    format!("{path}{}{name}", self.separator)
                };
                self.object(at, &path, depth + 1);
            }
            return;
        }
        match found(&self.file, path, object) {
            Some(array) => self.found.push(array),
            None => self.notes.push(no_table(path)),
        }
    }
}

fn describe(path: &str) -> String {
    if path.is_empty() {
        "the root group".to_owned()
    } else {
        format!("`{}`", crate::map::columns::clip(path))
    }
}

/// A data set as an array, if it is a table of numbers.
fn found(file: &File, path: &str, object: Object) -> Option<Found> {
    let one = object.scalar?;
    let sides: Vec<u64> = match object.sides.as_slice() {
        [] => vec![1],
        [a] => vec![*a],
        [a, b] => vec![*a, *b],
        _ => return None,
    };
    if sides.contains(&0) {
        return None;
    }
    let numbers = sides.iter().try_fold(1_u64, |n, &s| n.checked_mul(s))?;
    let size = numbers.checked_mul(one.size() as u64)?;
    let path = path.to_owned();
    match object.layout? {
        Layout::Compact(data) => {
            let header = Header::of_table(one, sides, false).ok()?;
            let open = move || -> Result<Box<dyn Read + Send>, Error> {
                Ok(Box::new(Cursor::new(data.clone())))
            };
            Some(Found::new(path, header, open))
        }
        Layout::Contiguous(at) => {
            let header = Header::of_table(one, sides, false).ok()?;
            let (bytes, at) = (file.bytes.clone(), file.start.checked_add(at)?);
            if at.checked_add(size)? > bytes.length().ok()? {
                return None;
            }
            let open = move || -> Result<Box<dyn Read + Send>, Error> {
                let part = bytes.part(at, size);
                Ok(Box::new(BufReader::with_capacity(1 << 16, part)))
            };
            Some(Found::new(path, header, open))
        }
        Layout::Chunked {
            index,
            sides: chunk,
        } => {
            // Stripes are delivered row by row, whichever side is time.
            let mut rows_first = sides.clone();
            rows_first.sort_unstable_by(|a, b| b.cmp(a));
            let header = Header::of_table(one, rows_first, false).ok()?;
            let set = chunks::Chunked::new(file, &sides, &chunk, one.size(), object.filters?)?;
            let open =
                move || -> Result<Box<dyn Read + Send>, Error> { Ok(Box::new(set.open(&index)?)) };
            Some(Found::new(path, header, open))
        }
    }
}

/// Such a file as a log.
pub(crate) fn open(
    bytes: InputBytes,
    head: &[u8],
    start: u64,
    packed: &str,
) -> Result<Arrays, Error> {
    let is_matlab = head.starts_with(b"MATLAB 7.3");
    let InputBytes::File(bytes) = bytes else {
        let what = if is_matlab {
            "a MATLAB file"
        } else {
            "an HDF5 file"
        };
        return Err(no_pipe(what, packed));
    };
    let damaged = || {
        Error::data("the HDF5 file is cut off or damaged: its root cannot be read")
            .advise("copy it again")
    };
    let bytes = Shared::new(bytes);
    let length = bytes.length().map_err(Error::read)?;
    let (file, root, end) = superblock(bytes, start).ok_or_else(damaged)?;
    if end > length && !object::is_nowhere(&file, end) {
        return Err(Error::data(format!(
            "the HDF5 file is cut off: {} of its {} bytes are there",
            grouped(length),
            grouped(end)
        ))
        .advise("copy it again"));
    }
    let mut walk = Walk {
        file,
        separator: if is_matlab { '.' } else { '/' },
        objects: 0,
        found: Vec::new(),
        notes: Vec::new(),
    };
    walk.object(root, "", 0);
    if walk.found.is_empty() {
        return Err(match walk.notes.first() {
            None => Error::data("the file holds no table of numbers"),
            Some(note) => Error::data(format!("the file holds no table of numbers: {note}")),
        });
    }
    let name = if is_matlab {
        "MATLAB 7.3 (HDF5)"
    } else {
        "HDF5"
    };
    Arrays::new(format!("{name}{packed}"), walk.found, walk.notes)
}
