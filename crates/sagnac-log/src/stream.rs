//! The traits that every format implements: a log comes and goes in blocks of rows.

use crate::{Cells, Error, Layout, Stamps};

/// A run of rows, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// Time stamps, empty where the log has none.
    pub stamps: Stamps,
    /// Values: a column a channel, in the order of [`Layout::channels`], all as long as [`Block::rows`].
    pub columns: Vec<Vec<f64>>,
    /// Cells: a column a column of [`Layout::texts`], all as long as [`Block::rows`].
    pub texts: Vec<Cells>,
    /// Rows in the block.
    pub rows: usize,
}

impl Block {
    /// An empty block of so many columns.
    pub fn with_columns(n: usize) -> Self {
        Self {
            stamps: Stamps::default(),
            columns: vec![Vec::new(); n],
            texts: Vec::new(),
            rows: 0,
        }
    }

    /// Empties the block, keeping its memory.
    pub fn clear(&mut self) {
        self.stamps.clear();
        for c in &mut self.columns {
            c.clear();
        }
        self.texts.iter_mut().for_each(Cells::clear);
        self.rows = 0;
    }

    /// Adds the rows of `more`.
    pub fn append(&mut self, more: &Self) {
        self.stamps.append(&more.stamps);
        for (all, part) in self.columns.iter_mut().zip(&more.columns) {
            all.extend_from_slice(part);
        }
        append_texts(&mut self.texts, &more.texts);
        self.rows += more.rows;
    }

    /// Keeps the rows that are marked.
    pub fn filter(&mut self, wanted: &[bool]) {
        let mark = |v: &mut Vec<f64>| {
            let mut i = 0;
            v.retain(|_| {
                i += 1;
                wanted.get(i - 1).copied().unwrap_or(false)
            });
        };
        self.columns.iter_mut().for_each(mark);
        self.texts.iter_mut().for_each(|t| t.filter(wanted));
        match &mut self.stamps {
            Stamps::Seconds(v) => mark(v),
            Stamps::Nanoseconds(v) => {
                let mut i = 0;
                v.retain(|_| {
                    i += 1;
                    wanted.get(i - 1).copied().unwrap_or(false)
                });
            }
        }
        self.rows = wanted.iter().take(self.rows).filter(|&&w| w).count();
    }

    /// Keeps rows `range` alone.
    pub fn keep(&mut self, range: std::ops::Range<usize>) {
        let range = range.start.min(self.rows)..range.end.min(self.rows);
        if !self.stamps.is_empty() {
            self.stamps.keep(range.clone());
        }
        for c in &mut self.columns {
            c.truncate(range.end);
            c.drain(..range.start);
        }
        self.texts.iter_mut().for_each(|t| t.keep(range.clone()));
        self.rows = range.len();
    }
}

/// Adds cells, column by column.
pub(crate) fn append_texts(all: &mut Vec<Cells>, more: &[Cells]) {
    all.resize_with(more.len().max(all.len()), Cells::default);
    for (all, part) in all.iter_mut().zip(more) {
        all.append(part);
    }
}

/// A log that is read block by block in bounded memory.
pub trait LogReader {
    /// What the log holds. Known before the first block; notes may be added while reading.
    fn layout(&self) -> &Layout;

    /// Reads the next rows into `block` (its old content is dropped). Returns `false`, with an empty block, at the end.
    ///
    /// # Errors
    /// The first unsound row, or what the operating system says.
    fn read_block(&mut self, block: &mut Block) -> Result<bool, Error>;
}

impl<R: LogReader + ?Sized> LogReader for Box<R> {
    fn layout(&self) -> &Layout {
        (**self).layout()
    }
    fn read_block(&mut self, block: &mut Block) -> Result<bool, Error> {
        (**self).read_block(block)
    }
}

/// A log that is written block by block in bounded memory.
pub trait LogWriter {
    /// Writes the rows of `block`, whose columns are those of the layout the writer was made with.
    ///
    /// # Errors
    /// What the operating system says.
    fn write_block(&mut self, block: &Block) -> Result<(), Error>;

    /// Completes the file (sizes, indexes, checksums) and returns what the user should be told.
    ///
    /// # Errors
    /// What the operating system says.
    fn finish(self: Box<Self>) -> Result<Vec<String>, Error>;
}
