//! Object headers of both generations and the messages in them that matter for numbers.

use super::{File, View};
use crate::npy::Scalar;

/// More messages or continuations than any object has.
const MOST: usize = 1 << 10;

/// How a chunked data set's chunks are found.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Index {
    /// A B-tree of the first generation at this address.
    Tree(u64),
    /// One chunk of so many bytes, by its filters' mask.
    Single {
        at: u64,
        size: Option<u64>,
        mask: u32,
    },
    /// Chunks one after another, none filtered.
    Implicit(u64),
    /// A fixed array at this address.
    FixedArray(u64),
    /// An index that is not read, by its name.
    Other(&'static str),
}

/// Where a data set's numbers stand.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Layout {
    Compact(Vec<u8>),
    Contiguous(u64),
    /// Sides of a chunk in numbers, without that of the element.
    Chunked {
        index: Index,
        sides: Vec<u64>,
    },
}

/// A filter that a chunk went through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filter {
    Deflate,
    Shuffle,
    Fletcher32,
    Zstd,
    Unknown(u16),
}

/// What an object's header says.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) sides: Vec<u64>,
    pub(super) scalar: Option<Scalar>,
    pub(super) layout: Option<Layout>,
    pub(super) filters: Option<Vec<Filter>>,
    /// B-tree and heap of a group of the first generation.
    pub(super) symbols: Option<(u64, u64)>,
    /// Links that stand in the header.
    pub(super) links: Vec<(String, u64)>,
    /// Heap and name index of a group with many links.
    pub(super) dense: Option<(u64, u64)>,
    has_links: bool,
}

impl Object {
    pub(super) fn is_group(&self) -> bool {
        self.layout.is_none() && (self.symbols.is_some() || self.has_links)
    }

    /// Reads the header at an address.
    pub(super) fn read(file: &File, at: u64) -> Option<Self> {
        let mut object = Self {
            filters: Some(Vec::new()),
            ..Self::default()
        };
        let start = file.read(at, 64)?;
        // Pieces of the header: where its messages stand and how many bytes they take.
        let mut pieces: Vec<(u64, u64)> = Vec::new();
        let is_new = start.starts_with(b"OHDR");
        let mut order = false;
        let mut view = View::new(&start);
        if is_new {
            view.take(5)?;
            let flags = view.byte()?;
            order = flags & 4 != 0;
            view.take(if flags & 32 != 0 { 16 } else { 0 })?;
            view.take(if flags & 16 != 0 { 4 } else { 0 })?;
            let size = view.number(1 << (flags & 3))?;
            pieces.push((at.checked_add(view.at as u64)?, size));
        } else {
            if view.byte()? != 1 {
                return None;
            }
            view.take(7)?;
            pieces.push((at.checked_add(16)?, view.number(4)?));
        }
        let (mut k, mut messages) = (0, 0);
        while let Some(&(at, size)) = pieces.get(k) {
            k += 1;
            let raw = file.read(at, size)?;
            let mut view = View::new(&raw);
            loop {
                let head = if is_new {
                    (|| {
                        let kind = u16::from(view.byte()?);
                        let head = (kind, view.number(2)? as usize, view.byte()?);
                        view.take(if order { 2 } else { 0 })?;
                        Some(head)
                    })()
                } else {
                    (|| {
                        let kind = view.number(2)? as u16;
                        let head = (kind, view.number(2)? as usize, view.byte()?);
                        view.take(3)?;
                        Some(head)
                    })()
                };
                let Some((kind, size, flags)) = head else {
                    break;
                };
                let Some(body) = view.take(size) else { break };
                messages += 1;
                if messages > MOST {
                    return None;
                }
                if kind == 0x10 && pieces.len() < MOST {
                    let mut body = View::new(body);
                    let (at, size) = (body.number(file.address)?, body.number(file.length)?);
                    // The new generation's pieces begin with a signature and end with a checksum.
                    pieces.push(if is_new {
                        (at.checked_add(4)?, size.checked_sub(8)?)
                    } else {
                        (at, size)
                    });
                } else if flags & 2 == 0 {
                    object.message(file, kind, body);
                }
            }
        }
        Some(object)
    }

    /// Takes what a message says; one that is damaged says nothing.
    fn message(&mut self, file: &File, kind: u16, body: &[u8]) {
        let mut view = View::new(body);
        match kind {
            0x1 => self.sides = sides(file, view).unwrap_or_else(|| vec![0; 3]),
            0x2 => {
                self.has_links = true;
                self.dense = dense(file, view);
            }
            0x3 => self.scalar = scalar(view),
            0x6 => {
                self.has_links = true;
                self.links.extend(link(file, &mut view));
            }
            0x8 => self.layout = layout(file, view),
            0xB => self.filters = filters(view),
            0x11 => {
                self.symbols =
                    (|| Some((view.number(file.address)?, view.number(file.address)?)))();
            }
            _ => {}
        }
    }
}

fn sides(file: &File, mut view: View) -> Option<Vec<u64>> {
    let version = view.byte()?;
    let rank = view.byte()?;
    view.take(if version == 1 { 6 } else { 2 })?;
    (0..rank).map(|_| view.number(file.length)).collect()
}

/// Numbers of the two classes, and the numbers below an enumeration (how booleans are kept).
fn scalar(mut view: View) -> Option<Scalar> {
    let class = view.byte()?;
    let bits = view.number(3)?;
    let size = view.number(4)?;
    let big = bits & 1 != 0;
    match class & 15 {
        0 => Scalar::of(if bits & 8 != 0 { 'i' } else { 'u' }, size, big),
        1 if bits & 64 == 0 => Scalar::of('f', size, big),
        8 => {
            // The base type stands next; an enumeration of enumerations there is not.
            (view.bytes.get(view.at)? % 16 == 0).then_some(())?;
            scalar(view)
        }
        _ => None,
    }
}

fn layout(file: &File, mut view: View) -> Option<Layout> {
    let version = view.byte()?;
    if version < 3 {
        // The oldest: rank, class, reserved, address, sides.
        let rank = usize::from(view.byte()?);
        let class = view.byte()?;
        view.take(5)?;
        return match class {
            1 => Some(Layout::Contiguous(view.number(file.address)?)),
            2 => {
                let at = view.number(file.address)?;
                let sides = (0..rank)
                    .map(|_| view.number(4))
                    .collect::<Option<Vec<_>>>()?;
                Some(Layout::Chunked {
                    index: Index::Tree(at),
                    sides: sides.split_last()?.1.to_vec(),
                })
            }
            _ => None,
        };
    }
    match (version, view.byte()?) {
        (_, 0) => {
            let n = view.number(2)? as usize;
            Some(Layout::Compact(view.take(n)?.to_vec()))
        }
        (_, 1) => {
            let at = view.number(file.address)?;
            (!is_nowhere(file, at)).then_some(Layout::Contiguous(at))
        }
        (3, 2) => {
            let rank = usize::from(view.byte()?).checked_sub(1)?;
            let at = view.number(file.address)?;
            let sides = (0..rank).map(|_| view.number(4)).collect::<Option<_>>()?;
            Some(Layout::Chunked {
                index: Index::Tree(at),
                sides,
            })
        }
        (4 | 5, 2) => {
            let flags = view.byte()?;
            let rank = usize::from(view.byte()?).checked_sub(1)?;
            let width = usize::from(view.byte()?);
            let sides = (0..rank)
                .map(|_| view.number(width))
                .collect::<Option<_>>()?;
            view.number(width)?;
            let index = match view.byte()? {
                1 => {
                    let (mut size, mut mask) = (None, 0);
                    if flags & 2 != 0 {
                        size = Some(view.number(file.length)?);
                        mask = view.number(4)? as u32;
                    }
                    Index::Single {
                        at: view.number(file.address)?,
                        size,
                        mask,
                    }
                }
                2 => Index::Implicit(view.number(file.address)?),
                3 => {
                    view.take(1)?;
                    Index::FixedArray(view.number(file.address)?)
                }
                4 => Index::Other("an extensible array"),
                _ => Index::Other("a B-tree of version 2"),
            };
            Some(Layout::Chunked { index, sides })
        }
        _ => None,
    }
}

/// The address that stands for none.
pub(super) fn is_nowhere(file: &File, at: u64) -> bool {
    at == if file.address == 8 {
        u64::MAX
    } else {
        u64::from(u32::MAX)
    }
}

fn filters(mut view: View) -> Option<Vec<Filter>> {
    let version = view.byte()?;
    let n = view.byte()?;
    view.take(if version == 1 { 6 } else { 0 })?;
    (0..n)
        .map(|_| {
            let kind = view.number(2)? as u16;
            let name = if version == 1 || kind >= 256 {
                view.number(2)? as usize
            } else {
                0
            };
            view.take(2)?;
            let values = view.number(2)? as usize;
            let padded = if version == 1 {
                name.next_multiple_of(8)
            } else {
                name
            };
            view.take(padded)?;
            let odd = version == 1 && values % 2 == 1;
            view.take(4 * (values + usize::from(odd)))?;
            Some(match kind {
                1 => Filter::Deflate,
                2 => Filter::Shuffle,
                3 => Filter::Fletcher32,
                32015 => Filter::Zstd,
                other => Filter::Unknown(other),
            })
        })
        .collect()
}

/// A hard link: name and address.
pub(super) fn link(file: &File, view: &mut View) -> Option<(String, u64)> {
    view.byte()?;
    let flags = view.byte()?;
    let kind = if flags & 8 != 0 { view.byte()? } else { 0 };
    view.take(if flags & 4 != 0 { 8 } else { 0 })?;
    view.take(usize::from(flags & 16 != 0))?;
    let n = view.number(1 << (flags & 3))? as usize;
    let name = String::from_utf8_lossy(view.take(n)?).into_owned();
    (kind == 0).then_some(())?;
    Some((name, view.number(file.address)?))
}

fn dense(file: &File, mut view: View) -> Option<(u64, u64)> {
    view.byte()?;
    let flags = view.byte()?;
    view.take(if flags & 1 != 0 { 8 } else { 0 })?;
    let (heap, names) = (view.number(file.address)?, view.number(file.address)?);
    (!is_nowhere(file, heap) && !is_nowhere(file, names)).then_some((heap, names))
}
