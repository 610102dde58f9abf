//! The links of a group: a B-tree of symbol tables (first generation), links in the header, or a fractal heap.

use super::object::{Object, is_nowhere, link};
use super::{File, View};

/// More links than any log has.
const MOST: usize = 1 << 12;
/// Trees deeper than this do not come from a library.
const DEEPEST: u8 = 8;
/// Nodes of a group's tree.
const MOST_NODES: usize = 1 << 12;

/// Names and addresses of a group's objects, in the file's order.
pub(super) fn links(file: &File, object: &Object) -> Option<Vec<(String, u64)>> {
    let mut out = object.links.clone();
    if let Some((tree, heap)) = object.symbols {
        let raw = file.read(heap, 64)?;
        let mut view = View::new(raw.strip_prefix(b"HEAP")?);
        view.take(4)?;
        let size = view.number(file.length)?;
        view.number(file.length)?;
        let names = file.read(view.number(file.address)?, size)?;
        symbols(file, tree, &names, DEEPEST, &mut 0, &mut out)?;
    }
    if let Some((heap, names)) = object.dense {
        out.extend(dense(file, heap, names)?);
    }
    Some(out)
}

fn symbols(
    file: &File,
    at: u64,
    names: &[u8],
    depth: u8,
    nodes: &mut usize,
    out: &mut Vec<(String, u64)>,
) -> Option<()> {
    *nodes += 1;
    if out.len() > MOST || *nodes > MOST_NODES {
        return None;
    }
    let raw = file.read(at, 1 << 14)?;
    if let Some(raw) = raw.strip_prefix(b"SNOD") {
        let mut view = View::new(raw);
        view.take(2)?;
        for _ in 0..view.number(2)? {
            let name = view.number(file.address)? as usize;
            let object = view.number(file.address)?;
            let cache = view.number(4)?;
            view.take(20)?;
            let name = names.get(name..)?.split(|&b| b == 0).next()?;
            // 2: a symbolic link.
            if cache != 2 {
                out.push((String::from_utf8_lossy(name).into_owned(), object));
            }
        }
        return Some(());
    }
    let mut view = View::new(raw.strip_prefix(b"TREE")?);
    view.take(2)?;
    let used = view.number(2)?;
    view.take(2 * file.address)?;
    for _ in 0..used {
        view.number(file.length)?;
        symbols(
            file,
            view.number(file.address)?,
            names,
            depth.checked_sub(1)?,
            nodes,
            out,
        )?;
    }
    Some(())
}

/// A fractal heap of links, as far as it is needed to find one by its place.
struct Heap {
    width: u64,
    first: u64,
    largest: u64,
    root: u64,
    rows: u64,
    /// Bytes of an offset in the heap, and of a block's header.
    offset: usize,
    head: u64,
}

fn dense(file: &File, heap: u64, names: u64) -> Option<Vec<(String, u64)>> {
    let raw = file.read(heap, 256)?;
    let mut view = View::new(raw.strip_prefix(b"FRHP")?);
    view.take(1)?;
    let id = view.number(2)? as usize;
    let filtered = view.number(2)?;
    let checks = view.byte()? & 2 != 0;
    view.take(4 + 10 * file.length + 2 * file.address)?;
    let width = view.number(2)?;
    let (first, largest) = (view.number(file.length)?, view.number(file.length)?);
    let bits = view.number(2)? as usize;
    view.take(2)?;
    let (root, rows) = (view.number(file.address)?, view.number(2)?);
    let offset = bits.div_ceil(8);
    if filtered != 0 || !(1..=1024).contains(&width) || first == 0 || offset > 8 {
        return None;
    }
    let heap = Heap {
        width,
        first,
        largest,
        root,
        rows,
        offset,
        head: 5 + file.address as u64 + offset as u64 + if checks { 4 } else { 0 },
    };
    let raw = file.read(names, 64)?;
    let mut view = View::new(raw.strip_prefix(b"BTHD")?);
    view.take(2)?;
    view.take(4)?;
    let record = view.number(2)? as usize;
    let depth = view.number(2)?;
    view.take(2)?;
    let root = view.number(file.address)?;
    let count = view.number(2)? as usize;
    // Deeper trees hold some fifty links and more: no log.
    if depth != 0 || record < 4 + id || is_nowhere(file, root) {
        return None;
    }
    let raw = file.read(root, 1 << 16)?;
    let mut view = View::new(raw.strip_prefix(b"BTLF")?);
    view.take(2)?;
    let mut out = Vec::new();
    for _ in 0..count.min(MOST) {
        let mut entry = View::new(view.take(record)?);
        entry.take(4)?;
        // Managed objects: offset and length.
        if entry.byte()? & 0x30 != 0 {
            return None;
        }
        let at = entry.number(heap.offset)?;
        let bytes = file.read(heap.find(file, at)?, 1 << 16)?;
        out.extend(link(file, &mut View::new(&bytes)));
    }
    Some(out)
}

impl Heap {
    /// The address in the file of what stands at `at` in the heap.
    fn find(&self, file: &File, at: u64) -> Option<u64> {
        if self.rows == 0 {
            return self.root.checked_add(at);
        }
        let raw = file.read(self.root, 1 << 16)?;
        let mut view = View::new(raw.strip_prefix(b"FHIB")?);
        view.take(1 + file.address + self.offset)?;
        let (mut start, mut size) = (0_u64, self.first);
        for row in 0..self.rows {
            if row > 1 {
                size = size.checked_mul(2)?;
            }
            // Beyond this size the blocks are again tables of blocks.
            if size > self.largest {
                return None;
            }
            for _ in 0..self.width {
                let block = view.number(file.address)?;
                let end = start.checked_add(size)?;
                if (start..end).contains(&at) {
                    (at - start >= self.head).then_some(())?;
                    return block.checked_add(at - start);
                }
                start = end;
            }
        }
        None
    }
}
