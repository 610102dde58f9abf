//! A log that goes by section by section, each with rows of its neighbors beside it, in memory that does not grow with it.

use std::ops::Range;

use crate::{Block, Error, Log, LogReader};

/// A section has one row of each neighbor beside it for so many of its own.
const BESIDE: usize = 16;

/// A part of a log.
#[derive(Debug)]
pub struct Section<'a> {
    /// Its rows, with those of its neighbors beside them.
    pub log: &'a Log,
    /// Its own rows among them.
    pub own: Range<usize>,
    /// Rows of the log before the first that is held.
    pub before: u64,
    /// Whether the log ends with it.
    pub is_last: bool,
}

impl Section<'_> {
    /// Whether it is all of the log.
    pub fn is_whole(&self) -> bool {
        self.before == 0 && self.own.start == 0 && self.is_last
    }
}

/// Reads a log in sections.
///
/// A log that is hardly longer than a section is one, as [`Log::read`] gives it. Increments are divided by the interval of
/// the first section.
///
/// ```
/// use sagnac_log::{ReadOptions, Sections, Source, open};
/// let rows: String = (0..100).map(|k| format!("{}.5,{}\n", k, k % 7)).collect();
/// let text = format!("time [s],gyro_x [rad/s]\n{rows}");
/// let mut reader = open(Source::memory("a.csv", text.into()), &ReadOptions::default())?;
/// let mut sections = Sections::new(&mut *reader, 32);
/// let mut own = Vec::new();
/// while let Some(section) = sections.next()? {
///     own.push((section.before, section.own));
/// }
/// assert_eq!(own, [(0, 0..32), (30, 2..34), (62, 2..34), (94, 2..6)]);
/// # Ok::<(), sagnac_log::Error>(())
/// ```
pub struct Sections<'r> {
    reader: &'r mut dyn LogReader,
    rows: usize,
    log: Log,
    /// Read, and not in the log yet.
    ahead: Block,
    before: u64,
    /// Where the next section's own rows begin.
    start: usize,
    is_end: bool,
    dt_s: Option<f64>,
}

impl<'r> Sections<'r> {
    /// Sections of so many rows of their own.
    pub fn new(reader: &'r mut dyn LogReader, rows: usize) -> Self {
        let columns = reader.layout().channels.len();
        Self {
            reader,
            rows: rows.max(1),
            log: Log::with_columns(columns),
            ahead: Block::with_columns(columns),
            before: 0,
            start: 0,
            is_end: false,
            dt_s: None,
        }
    }

    /// The next section.
    ///
    /// # Errors
    /// Those of the reader; no rows at all; increments with no time and no rate.
    #[allow(clippy::should_implement_trait, reason = "what it gives is held here")]
    pub fn next(&mut self) -> Result<Option<Section<'_>>, Error> {
        if self.is_end && self.start >= self.log.rows {
            return Ok(None);
        }
        let beside = self.rows / BESIDE;
        let done = self.start.saturating_sub(beside);
        self.log.forget(done);
        self.before += done as u64;
        self.start -= done;
        let known = self.log.rows;
        self.fill(self.start + self.rows + beside)?;
        self.log.layout = self.reader.layout().clone();
        if self.log.rows == 0 {
            return Err(Error::no_samples());
        }
        let dt_s = match self.dt_s {
            None if self.log.layout.channels.iter().any(|c| c.is_increment) => {
                Some(self.log.dt_s()?)
            }
            known => known,
        };
        if let Some(dt_s) = dt_s {
            self.log.divide_increments(known, dt_s);
        }
        self.dt_s = dt_s;
        let end = if self.is_end {
            self.log.rows
        } else {
            self.start + self.rows
        };
        let own = self.start..end;
        self.start = end;
        Ok(Some(Section {
            log: &self.log,
            own,
            before: self.before,
            is_last: self.is_end,
        }))
    }

    /// Reads until so many rows are held, or the log ends.
    fn fill(&mut self, rows: usize) -> Result<(), Error> {
        loop {
            let wanted = rows - self.log.rows.min(rows);
            self.log.append(&self.ahead, wanted);
            self.ahead.keep(wanted..self.ahead.rows);
            // One row more tells that the log goes on.
            if self.ahead.rows > 0 || self.is_end {
                return Ok(());
            }
            if !self.reader.read_block(&mut self.ahead)? {
                self.is_end = true;
            }
        }
    }
}
