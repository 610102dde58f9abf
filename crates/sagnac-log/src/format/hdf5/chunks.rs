//! Chunked data sets, one stripe of chunks at a time: all chunks that hold the same span of time.

use std::io::Read;

use super::object::{Filter, Index, is_nowhere};
use super::{File, View};
use crate::Error;
use crate::text::grouped;

/// A stripe of more bytes is not held.
const LARGEST_STRIPE: u64 = 1 << 28;
/// Chunks of a data set, 24 bytes each in memory.
const MOST_CHUNKS: usize = 1 << 22;
/// Trees deeper than this do not come from a library.
const DEEPEST: u8 = 8;

/// A data set in chunks.
#[derive(Clone)]
pub(super) struct Chunked {
    file: File,
    rows: u64,
    columns: u64,
    /// Rows and columns of a chunk.
    chunk: (u64, u64),
    /// True where time is the second side.
    turned: bool,
    /// Sides of the data set: a key of its tree has one more.
    rank: usize,
    size: usize,
    filters: Vec<Filter>,
}

/// A chunk: its stripe, its place in the stripe, its bytes in the file and the filters it did not go through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Chunk {
    stripe: u32,
    place: u16,
    mask: u16,
    size: u32,
    at: u64,
}

impl Chunked {
    pub(super) fn new(
        file: &File,
        sides: &[u64],
        chunk: &[u64],
        size: usize,
        filters: Vec<Filter>,
    ) -> Option<Self> {
        let pair = |s: &[u64]| match s {
            [a] => Some((*a, 1)),
            [a, b] => Some((*a, *b)),
            _ => None,
        };
        let ((a, b), (ca, cb)) = (pair(sides)?, pair(chunk)?);
        if ca == 0 || cb == 0 || sides.len() != chunk.len() {
            return None;
        }
        let turned = b > a;
        let (rows, columns, chunk) = if turned {
            (b, a, (cb, ca))
        } else {
            (a, b, (ca, cb))
        };
        (columns <= 4096).then_some(())?;
        Some(Self {
            file: file.clone(),
            rows,
            columns,
            chunk,
            turned,
            rank: sides.len(),
            size,
            filters,
        })
    }

    fn chunk_bytes(&self) -> Option<u64> {
        self.chunk
            .0
            .checked_mul(self.chunk.1)?
            .checked_mul(self.size as u64)
    }

    /// The chunk at these offsets.
    fn place(&self, offsets: &[u64], at: u64, size: u64, mask: u32) -> Option<Chunk> {
        let (a, b) = (*offsets.first()?, offsets.get(1).copied().unwrap_or(0));
        let (row, column) = if self.turned { (b, a) } else { (a, b) };
        if row >= self.rows || column >= self.columns {
            return None;
        }
        Some(Chunk {
            stripe: u32::try_from(row / self.chunk.0).ok()?,
            place: u16::try_from(column / self.chunk.1).ok()?,
            mask: mask as u16,
            size: u32::try_from(size).ok()?,
            at,
        })
    }

    /// A stream of the rows from the first on.
    pub(super) fn open(&self, index: &Index) -> Result<Stripes, Error> {
        let damaged = || Error::data("the index of a data set's chunks is damaged");
        if let Some(Filter::Unknown(kind)) = self
            .filters
            .iter()
            .find(|f| matches!(f, Filter::Unknown(_)))
        {
            return Err(Error::data(format!(
                "the data set is packed by HDF5 filter {kind}, which is not read"
            ))
            .advise("repack it, for instance h5repack -f GZIP=4 in.h5 out.h5"));
        }
        let across = self.columns.div_ceil(self.chunk.1);
        let bytes = self.chunk_bytes().and_then(|n| n.checked_mul(across));
        if bytes.is_none_or(|n| n > LARGEST_STRIPE) {
            return Err(Error::data(format!(
                "the data set's chunks of {} × {} numbers are too large to be read in bounded memory",
                grouped(self.chunk.0),
                grouped(self.chunk.1)
            ))
            .advise("repack it in smaller chunks, for instance h5repack -l CHUNK=8192x3 in.h5 out.h5"));
        }
        let mut chunks = Vec::new();
        match index {
            Index::Tree(at) if is_nowhere(&self.file, *at) => {}
            Index::Tree(at) => {
                let mut nodes = 0;
                self.tree(*at, DEEPEST, &mut nodes, &mut chunks)
                    .ok_or_else(damaged)?;
            }
            Index::Single { at, size, mask } => {
                let size = size.or(self.chunk_bytes()).unwrap_or(0);
                chunks.extend(self.place(&[0, 0], *at, size, *mask));
            }
            Index::Implicit(at) => {
                self.ordered(&mut chunks, |k| {
                    let size = self.chunk_bytes()?;
                    Some((at.checked_add(k.checked_mul(size)?)?, size, 0))
                })
                .ok_or_else(damaged)?;
            }
            Index::FixedArray(at) => self.fixed(*at, &mut chunks).ok_or_else(damaged)?,
            Index::Other(kind) => {
                return Err(Error::data(format!(
                    "the data set's chunks are indexed by {kind}, which is not read"
                ))
                .advise("repack it for older libraries: h5repack --low=0 --high=0 in.h5 out.h5"));
            }
        }
        chunks.sort_unstable();
        Ok(Stripes {
            set: self.clone(),
            chunks,
            next: 0,
            stripe: 0,
            buffer: Vec::new(),
            at: 0,
        })
    }

    fn tree(&self, at: u64, depth: u8, nodes: &mut usize, out: &mut Vec<Chunk>) -> Option<()> {
        let file = &self.file;
        // A node holds two chunks at least, but for the last ones.
        *nodes += 1;
        (*nodes <= 1024 + 2 * out.len()).then_some(())?;
        let head = file.read(at, 8)?;
        let used = u64::from(u16::from_le_bytes(head.get(6..8)?.try_into().ok()?));
        let entry = 8 + 8 * (self.rank as u64 + 1) + file.address as u64;
        let raw = file.read(at, 8 + 2 * file.address as u64 + used * entry)?;
        let mut view = View::new(raw.strip_prefix(b"TREE")?);
        (view.byte()? == 1).then_some(())?;
        let level = view.byte()?;
        view.take(2 + 2 * file.address)?;
        for _ in 0..used {
            let (size, mask) = (view.number(4)?, view.number(4)? as u32);
            let mut offsets = [0; 2];
            for k in 0..=self.rank {
                let offset = view.number(8)?;
                if let Some(o) = offsets.get_mut(k).filter(|_| k < self.rank) {
                    *o = offset;
                }
            }
            let child = view.number(file.address)?;
            if level == 0 {
                (out.len() < MOST_CHUNKS).then_some(())?;
                out.extend(self.place(&offsets, child, size, mask));
            } else {
                self.tree(child, depth.checked_sub(1)?, nodes, out)?;
            }
        }
        Some(())
    }

    /// Chunks in the order of their offsets, by what `find` says of each: address, bytes, mask.
    fn ordered(
        &self,
        out: &mut Vec<Chunk>,
        mut find: impl FnMut(u64) -> Option<(u64, u64, u32)>,
    ) -> Option<()> {
        let (down, across) = (
            self.rows.div_ceil(self.chunk.0),
            self.columns.div_ceil(self.chunk.1),
        );
        let total = down.checked_mul(across)?;
        (total <= MOST_CHUNKS as u64).then_some(())?;
        // The last side runs fastest.
        let fast = if self.turned { down } else { across };
        for k in 0..total {
            let (at, size, mask) = find(k)?;
            let (slow, fast) = (k / fast, k % fast);
            let (i, j) = if self.turned {
                (slow * self.chunk.1, fast * self.chunk.0)
            } else {
                (slow * self.chunk.0, fast * self.chunk.1)
            };
            if !is_nowhere(&self.file, at) {
                out.extend(self.place(&[i, j], at, size, mask));
            }
        }
        Some(())
    }

    fn fixed(&self, at: u64, out: &mut Vec<Chunk>) -> Option<()> {
        let file = &self.file;
        let raw = file.read(at, 64)?;
        let mut view = View::new(raw.strip_prefix(b"FAHD")?);
        view.take(1)?;
        let is_filtered = view.byte()? == 1;
        let entry = usize::from(view.byte()?);
        let page = 1_u64.checked_shl(u32::from(view.byte()?))?;
        let count = view.number(file.length)?;
        let block = view.number(file.address)?;
        let head = 6 + file.address as u64;
        let mut bytes = head;
        // Large arrays stand in pages, each with a checksum, after a bitmap of those that are there.
        let pages = count.div_ceil(page);
        if count > page {
            bytes = head + pages.div_ceil(8) + 4;
        }
        let mut held = (u64::MAX, Vec::new());
        self.ordered(out, |k| {
            let inside = if count > page { k % page } else { k };
            let base = if count > page {
                bytes + (k / page) * (page * entry as u64 + 4)
            } else {
                bytes
            };
            let at = block
                .checked_add(base)?
                .checked_add(inside.checked_mul(entry as u64)?)?;
            // Some thousand entries at a time.
            if held.0 > at || at + entry as u64 > held.0.saturating_add(held.1.len() as u64) {
                held = (at, file.read(at, 1 << 16)?);
            }
            let mut view = View::new(held.1.get((at - held.0) as usize..)?);
            let address = view.number(file.address)?;
            if is_filtered {
                let size = view.number(entry.checked_sub(file.address + 4)?)?;
                Some((address, size, view.number(4)? as u32))
            } else {
                Some((address, self.chunk_bytes()?, 0))
            }
        })
    }

    /// A chunk's bytes before its filters.
    fn unpack(&self, chunk: Chunk) -> Option<Vec<u8>> {
        let want = self.chunk_bytes()?;
        let mut bytes = Vec::new();
        if u64::from(chunk.size) > LARGEST_STRIPE {
            return None;
        }
        self.file
            .bytes
            .part(
                self.file.start.checked_add(chunk.at)?,
                u64::from(chunk.size),
            )
            .read_to_end(&mut bytes)
            .ok()?;
        for (k, filter) in self.filters.iter().enumerate().rev() {
            if chunk.mask >> k & 1 == 1 {
                continue;
            }
            // Some bytes more than wanted: a checksum may still be on.
            let limit = want + 4;
            let mut out = Vec::new();
            bytes = match filter {
                Filter::Deflate => {
                    let decoder = flate2::read::ZlibDecoder::new(bytes.as_slice());
                    decoder.take(limit).read_to_end(&mut out).ok()?;
                    out
                }
                Filter::Zstd => {
                    let mut decoder = zstd::Decoder::new(bytes.as_slice()).ok()?;
                    decoder.window_log_max(27).ok()?;
                    decoder.take(limit).read_to_end(&mut out).ok()?;
                    out
                }
                Filter::Shuffle => unshuffle(&bytes, self.size),
                Filter::Fletcher32 => {
                    let end = bytes.len().checked_sub(4)?;
                    let stored = u32::from_le_bytes(bytes[end..].try_into().ok()?);
                    bytes.truncate(end);
                    let sum = fletcher32(&bytes);
                    // Libraries before 1.6.3 wrote the bytes of each half in the other order.
                    let old = (sum & 0x00FF_00FF) << 8 | (sum & 0xFF00_FF00) >> 8;
                    [sum, old].contains(&stored).then_some(())?;
                    bytes
                }
                Filter::Unknown(_) => return None,
            };
        }
        (bytes.len() as u64 == want).then_some(bytes)
    }
}

/// HDF5's sum of a chunk: words of two bytes, the higher first, each sum kept to 16 bits.
fn fletcher32(bytes: &[u8]) -> u32 {
    let fold = |sum: u32| (sum & 0xFFFF) + (sum >> 16);
    let (mut low, mut high) = (0_u32, 0_u32);
    // 360 words are the most that the sums of 32 bits hold.
    for part in bytes.chunks(720) {
        for word in part.chunks(2) {
            low += u32::from(word[0]) << 8 | word.get(1).map_or(0, |&b| u32::from(b));
            high += low;
        }
        (low, high) = (fold(low), fold(high));
    }
    fold(high) << 16 | fold(low)
}

/// First bytes of all numbers, then second bytes…: back to numbers.
fn unshuffle(bytes: &[u8], size: usize) -> Vec<u8> {
    let n = bytes.len() / size.max(1);
    let mut out = bytes.to_vec();
    for k in 0..size {
        for i in 0..n {
            out[i * size + k] = bytes[k * n + i];
        }
    }
    out
}

/// The rows of a chunked data set as a stream of bytes.
pub(super) struct Stripes {
    set: Chunked,
    chunks: Vec<Chunk>,
    next: usize,
    stripe: u64,
    buffer: Vec<u8>,
    at: usize,
}

impl Stripes {
    /// Fills the buffer with the next stripe; `false` at the end.
    fn fill(&mut self) -> std::io::Result<bool> {
        let set = &self.set;
        let first = self.stripe * set.chunk.0;
        if first >= set.rows {
            return Ok(false);
        }
        let rows = set.chunk.0.min(set.rows - first) as usize;
        let (columns, size) = (set.columns as usize, set.size);
        self.at = 0;
        self.buffer.clear();
        // Chunks that were never written hold zeros, the format's own default.
        self.buffer.resize(rows * columns * size, 0);
        while let Some(&chunk) = self.chunks.get(self.next) {
            if u64::from(chunk.stripe) != self.stripe {
                break;
            }
            self.next += 1;
            let bytes = set.unpack(chunk).ok_or_else(|| {
                let text = format!(
                    "the chunk at byte {} is damaged, or does not match its checksum",
                    grouped(chunk.at)
                );
                std::io::Error::new(std::io::ErrorKind::InvalidData, text)
            })?;
            let left = usize::from(chunk.place) * set.chunk.1 as usize;
            let (deep, wide) = (set.chunk.0 as usize, set.chunk.1 as usize);
            for j in 0..wide.min(columns.saturating_sub(left)) {
                for i in 0..rows {
                    let from = if set.turned {
                        j * deep + i
                    } else {
                        i * wide + j
                    } * size;
                    let to = (i * columns + left + j) * size;
                    self.buffer[to..to + size].copy_from_slice(&bytes[from..from + size]);
                }
            }
        }
        self.stripe += 1;
        Ok(true)
    }
}

impl Read for Stripes {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.at >= self.buffer.len() && !self.fill()? {
            return Ok(0);
        }
        let n = out.len().min(self.buffer.len() - self.at);
        out[..n].copy_from_slice(&self.buffer[self.at..self.at + n]);
        self.at += n;
        Ok(n)
    }
}
