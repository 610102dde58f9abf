//! Rows of text to columns of numbers, a chunk at a time.

use super::dialect::{Dialect, Separator, closing_quote, raw_cells, unquoted};
use super::number::{TimeKind, parse_f64, whole_f64};
use crate::map::columns::clip;
use crate::map::raw::Plan;
use crate::{Block, Cells, Stamp};

/// What a column of the table is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Skip,
    Time,
    Value(usize),
    /// Kept as it is.
    Text(usize),
}

/// How rows are read: shared by all workers.
#[derive(Debug, Clone)]
pub(crate) struct RowPlan {
    separator: Separator,
    uses: Vec<Use>,
    names: Vec<String>,
    time: Option<TimeKind>,
    /// Of every value, whether a cell of text is a missing one.
    is_lenient: Vec<bool>,
    texts: usize,
    /// Last column that anybody wants.
    last: usize,
    /// For the wording of errors.
    pub(crate) has_header: bool,
}

/// A chunk read.
pub(crate) struct Chunk {
    pub(crate) block: Block,
    /// Lines in the chunk, comments and blank ones too.
    pub(crate) lines: u64,
    /// Cells of text that were taken for missing values, a count a column of values.
    pub(crate) missing: Vec<u64>,
}

/// A row that cannot be read, counted within its chunk.
#[derive(Debug)]
pub(crate) struct RowError {
    /// Rows and lines before it.
    pub(crate) rows: u64,
    pub(crate) lines: u64,
    pub(crate) what: RowProblem,
}

#[derive(Debug)]
pub(crate) enum RowProblem {
    Width {
        found: usize,
    },
    Text {
        column: String,
        cell: String,
        is_date: bool,
    },
}

impl RowPlan {
    pub(crate) fn new(dialect: &Dialect, plan: &Plan) -> Self {
        let mut uses = vec![Use::Skip; dialect.width];
        for (slot, &c) in plan.columns.iter().enumerate() {
            uses[c] = Use::Value(slot);
        }
        for (slot, &c) in plan.texts.iter().enumerate() {
            uses[c] = Use::Text(slot);
        }
        if let Some((c, _)) = plan.time {
            uses[c] = Use::Time;
        }
        let names = dialect
            .columns
            .iter()
            .enumerate()
            .map(|(k, c)| {
                if c.name.is_empty() {
                    k.to_string()
                } else {
                    c.name.clone()
                }
            })
            .collect();
        let last = uses.iter().rposition(|u| *u != Use::Skip).unwrap_or(0);
        Self {
            separator: dialect.separator,
            uses,
            names,
            time: plan.time.map(|t| t.1),
            is_lenient: plan.is_lenient.clone(),
            texts: plan.texts.len(),
            last,
            has_header: dialect.has_header,
        }
    }

    pub(crate) fn width(&self) -> usize {
        self.uses.len()
    }

    /// Reads whole lines.
    pub(crate) fn read(&self, text: &[u8], mut block: Block) -> Result<Chunk, RowError> {
        block.clear();
        block.columns.resize_with(self.is_lenient.len(), Vec::new);
        block.texts.resize_with(self.texts, Cells::default);
        // Short rows are rare: about the shortest sensible row, so that columns seldom grow.
        let guess = text.len() / (4 * self.width().max(1)) + 16;
        block
            .columns
            .iter_mut()
            .for_each(|c| c.reserve(guess.min(1 << 16)));
        let mut missing = vec![0; self.is_lenient.len()];
        let mut lines = 0;
        let mut at = 0;
        while at < text.len() {
            let end = memchr::memchr(b'\n', &text[at..]).map_or(text.len(), |i| at + i);
            let line = &text[at..end];
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            at = end + 1;
            let is_read = match self.separator {
                Separator::Byte(b) => self.fast(line, b, &mut block),
                Separator::Spaces => self.fast_spaces(line, &mut block),
            };
            if is_read {
                block.rows += 1;
            } else {
                Self::undo(&mut block);
                if self
                    .slow(line, &mut block, &mut missing)
                    .map_err(|what| RowError {
                        rows: block.rows as u64,
                        lines,
                        what,
                    })?
                {
                    block.rows += 1;
                }
            }
            lines += 1;
        }
        Ok(Chunk {
            block,
            lines,
            missing,
        })
    }

    /// One plain row; `false` where it needs a closer look (quotes, text, another width, a comment).
    #[inline]
    fn fast(&self, line: &[u8], separator: u8, block: &mut Block) -> bool {
        if line.is_empty() {
            return false;
        }
        let mut rest = line;
        let n = self.uses.len();
        for (k, u) in self.uses.iter().enumerate() {
            let cell = rest;
            while let [b' ', tail @ ..] = rest {
                rest = tail;
            }
            match *u {
                Use::Value(slot) => {
                    let v = match parse_f64(rest) {
                        Some((v, used)) => {
                            rest = &rest[used..];
                            v
                        }
                        None if rest.is_empty() || rest[0] == separator => f64::NAN,
                        None => return false,
                    };
                    block.columns[slot].push(v);
                    while let [b' ', tail @ ..] = rest {
                        rest = tail;
                    }
                }
                Use::Time => {
                    let end = memchr::memchr(separator, rest).unwrap_or(rest.len());
                    let Some(stamp) = self
                        .time
                        .and_then(|t| t.of_text(rest[..end].trim_ascii_end()))
                    else {
                        return false;
                    };
                    block.stamps.push(stamp);
                    rest = &rest[end..];
                }
                Use::Text(slot) => {
                    // Quotes may hide separators; the first cell may begin a comment.
                    if matches!(rest.first(), Some(b'"' | b'#' | b'%')) {
                        return false;
                    }
                    rest = &rest[memchr::memchr(separator, rest).unwrap_or(rest.len())..];
                    let cell = &cell[..cell.len() - rest.len()];
                    if separator != b',' && memchr::memchr2(b',', b'"', cell).is_some() {
                        return false;
                    }
                    block.texts[slot].push(cell);
                }
                Use::Skip => {
                    if k > self.last {
                        // Only the width is left to check.
                        if rest.contains(&b'"') {
                            return false;
                        }
                        return memchr::memchr_iter(separator, rest).count() == n - 1 - k;
                    }
                    if rest.first() == Some(&b'"') {
                        return false;
                    }
                    rest = &rest[memchr::memchr(separator, rest).unwrap_or(rest.len())..];
                }
            }
            if k + 1 < n {
                match rest {
                    [c, tail @ ..] if *c == separator => rest = tail,
                    _ => return false,
                }
            }
        }
        rest.is_empty()
    }

    #[inline]
    fn fast_spaces(&self, line: &[u8], block: &mut Block) -> bool {
        let mut rest = line.trim_ascii();
        if rest.is_empty() {
            return false;
        }
        let n = self.uses.len();
        for (k, u) in self.uses.iter().enumerate() {
            let end = memchr::memchr2(b' ', b'\t', rest).unwrap_or(rest.len());
            match *u {
                Use::Value(slot) => match whole_f64(&rest[..end]) {
                    Some(v) => block.columns[slot].push(v),
                    None => return false,
                },
                Use::Time => match self.time.and_then(|t| t.of_text(&rest[..end])) {
                    Some(stamp) => block.stamps.push(stamp),
                    None => return false,
                },
                Use::Skip if rest.first() == Some(&b'"') => return false,
                Use::Skip => {}
                Use::Text(slot) => {
                    let cell = &rest[..end];
                    if memchr::memchr3(b',', b'"', b'#', cell).is_some() || cell[0] == b'%' {
                        return false;
                    }
                    block.texts[slot].push(cell);
                }
            }
            rest = rest[end..].trim_ascii_start();
            if rest.is_empty() != (k + 1 == n) {
                return false;
            }
        }
        true
    }

    /// Takes back what a row that failed has left.
    fn undo(block: &mut Block) {
        let rows = block.rows;
        block.columns.iter_mut().for_each(|c| c.truncate(rows));
        block.texts.iter_mut().for_each(|t| t.truncate(rows));
        if block.stamps.len() > rows {
            block.stamps.keep(0..rows);
        }
    }

    /// A row that is not plain; `Ok(false)` where it is no row at all.
    #[cold]
    fn slow(
        &self,
        line: &[u8],
        block: &mut Block,
        missing: &mut [u64],
    ) -> Result<bool, RowProblem> {
        if line.trim_ascii().is_empty() || super::dialect::is_comment(line) {
            return Ok(false);
        }
        let row = raw_cells(line, self.separator);
        if row.len() != self.uses.len() {
            return Err(RowProblem::Width { found: row.len() });
        }
        let mut values = vec![f64::NAN; self.is_lenient.len()];
        let mut texts = vec![Vec::new(); self.texts];
        let mut stamp: Option<Stamp> = None;
        for ((u, raw), name) in self.uses.iter().zip(&row).zip(&self.names) {
            let cell = unquoted(raw);
            let text = |is_date| RowProblem::Text {
                column: clip(name),
                cell: clip(&String::from_utf8_lossy(cell)),
                is_date,
            };
            match *u {
                Use::Skip => {}
                Use::Value(slot) if cell.is_empty() => values[slot] = f64::NAN,
                Use::Value(slot) => match whole_f64(cell) {
                    Some(value) => values[slot] = value,
                    None if self.is_lenient[slot] => missing[slot] += 1,
                    None => return Err(text(false)),
                },
                Use::Text(slot) => texts[slot] = as_csv(raw, self.separator),
                Use::Time => {
                    let kind = self.time.unwrap_or(TimeKind::Iso);
                    stamp = Some(
                        kind.of_text(cell)
                            .ok_or_else(|| text(kind == TimeKind::Iso))?,
                    );
                }
            }
        }
        for (c, v) in block.columns.iter_mut().zip(values) {
            c.push(v);
        }
        for (t, cell) in block.texts.iter_mut().zip(texts) {
            t.push(&cell);
        }
        if let Some(stamp) = stamp {
            block.stamps.push(stamp);
        }
        Ok(true)
    }
}

/// A cell as it stands in a table that is parted by commas.
fn as_csv(raw: &[u8], separator: Separator) -> Vec<u8> {
    let quoted = raw.trim_ascii_start();
    if quoted.first() == Some(&b'"') {
        let mut out = raw.to_vec();
        if closing_quote(quoted).is_none() {
            // It would run on into the next column.
            out.push(b'"');
        }
        return out;
    }
    if separator == Separator::Byte(b',') || memchr::memchr2(b',', b'"', raw).is_none() {
        return raw.to_vec();
    }
    let mut out = vec![b'"'];
    for &c in raw {
        if c == b'"' {
            out.push(c);
        }
        out.push(c);
    }
    out.push(b'"');
    out
}
