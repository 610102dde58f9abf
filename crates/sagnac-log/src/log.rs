//! A whole log in memory, column by column.

use crate::{Block, Channel, Error, Layout, LogReader, Stamps};

/// A whole log in memory. Known channels are in SI, increments are already divided by dt.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// What it holds.
    pub layout: Layout,
    /// Time stamps, empty where the log has none.
    pub stamps: Stamps,
    /// Values, a column a channel of [`Layout::channels`].
    pub columns: Vec<Vec<f64>>,
    /// Rows.
    pub rows: usize,
}

impl Log {
    /// Reads everything that `reader` gives.
    ///
    /// # Errors
    /// Those of the reader; no rows at all; no time and no rate.
    pub fn read(reader: &mut dyn LogReader) -> Result<Self, Error> {
        let n = reader.layout().channels.len();
        let mut log = Self {
            columns: vec![Vec::new(); n],
            ..Self::default()
        };
        if let Some(samples) = reader.layout().samples {
            // A header may promise anything: reserve no more than a modest log needs.
            let reserve = usize::try_from(samples).unwrap_or(usize::MAX).min(1 << 20);
            log.columns.iter_mut().for_each(|c| c.reserve(reserve));
        }
        let mut block = Block::with_columns(n);
        while reader.read_block(&mut block)? {
            log.stamps.append(&block.stamps);
            for (all, part) in log.columns.iter_mut().zip(&block.columns) {
                all.extend_from_slice(part);
            }
            log.rows += block.rows;
        }
        log.layout = reader.layout().clone();
        if log.rows == 0 {
            return Err(Error::data("the log has no samples"));
        }
        Ok(log)
    }

    /// The values of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f64]> {
        self.layout
            .index(name)
            .and_then(|i| self.columns.get(i))
            .map(Vec::as_slice)
    }

    /// Channels with their values.
    pub fn channels(&self) -> impl Iterator<Item = (&Channel, &[f64])> {
        self.layout
            .channels
            .iter()
            .zip(self.columns.iter().map(Vec::as_slice))
    }
}
