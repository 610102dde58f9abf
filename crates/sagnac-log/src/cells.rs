//! Columns that are kept as text: the cells of a row as CSV writes them, whatever they hold.

use std::ops::Range;

/// A column of cells, one after the other in one buffer.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells {
    bytes: Vec<u8>,
    /// Where each cell ends.
    ends: Vec<usize>,
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Cell `i` as it stands in a file parted by commas; empty where there is none.
    #[inline]
    pub fn get(&self, i: usize) -> &[u8] {
        let Some(&end) = self.ends.get(i) else {
            return &[];
        };
        let start = i.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.bytes[start..end]
    }

    /// Adds a cell.
    #[inline]
    pub fn push(&mut self, cell: &[u8]) {
        self.bytes.extend_from_slice(cell);
        self.ends.push(self.bytes.len());
    }

    /// Adds the cells of `other`.
    pub fn append(&mut self, other: &Self) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(&other.bytes);
        self.ends.extend(other.ends.iter().map(|end| start + end));
    }

    /// Drops all cells, keeping their memory.
    pub fn clear(&mut self) {
        self.bytes.clear();
        self.ends.clear();
    }

    /// Keeps the first `n` cells.
    pub(crate) fn truncate(&mut self, n: usize) {
        self.ends.truncate(n);
        self.bytes.truncate(self.ends.last().copied().unwrap_or(0));
    }

    /// Keeps cells `range` alone.
    pub fn keep(&mut self, range: Range<usize>) {
        self.truncate(range.end);
        let first = range.start.min(self.ends.len());
        let start = first.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.bytes.drain(..start);
        self.ends.drain(..first);
        for end in &mut self.ends {
            *end -= start;
        }
    }

    /// Keeps the cells that are marked.
    pub(crate) fn filter(&mut self, wanted: &[bool]) {
        let all = std::mem::take(self);
        for (i, _) in wanted.iter().enumerate().filter(|(_, wanted)| **wanted) {
            if i < all.len() {
                self.push(all.get(i));
            }
        }
    }

    /// Cells `range`.
    pub(crate) fn slice(&self, range: Range<usize>) -> Self {
        let mut out = Self::default();
        for i in range.start..range.end.min(self.len()) {
            out.push(self.get(i));
        }
        out
    }
}

/// A column that is kept as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextColumn {
    /// Its header, unit and all, as the source writes it.
    pub header: String,
    /// How many channels stand before it.
    pub place: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(of: &[&str]) -> Cells {
        let mut out = Cells::default();
        for cell in of {
            out.push(cell.as_bytes());
        }
        out
    }

    #[test]
    fn cells_are_cut_and_joined_as_a_list_is() {
        let mut some = cells(&["a", "", "ccc", "dd"]);
        some.append(&cells(&["e"]));
        assert_eq!(some.get(2), b"ccc");
        assert_eq!(some.slice(1..3), cells(&["", "ccc"]));
        some.keep(2..5);
        assert_eq!(some, cells(&["ccc", "dd", "e"]));
        some.filter(&[true, false, true]);
        assert_eq!(some, cells(&["ccc", "e"]));
        some.keep(1..2);
        some.append(&cells(&["", "f"]));
        assert_eq!(some, cells(&["e", "", "f"]));
        some.keep(7..9);
        assert!(some.is_empty());
    }
}
