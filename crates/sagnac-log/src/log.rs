//! A whole log in memory, column by column.

use crate::beat::Beat;
use crate::stream::append_texts;
use crate::{Block, Cells, Channel, Error, Layout, LogReader, Stamps};

/// A whole log in memory. Known channels are in SI, increments are already divided by dt.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// What it holds.
    pub layout: Layout,
    /// Time stamps, empty where the log has none.
    pub stamps: Stamps,
    /// Values, a column a channel of [`Layout::channels`].
    pub columns: Vec<Vec<f64>>,
    /// Cells, a column a column of [`Layout::texts`].
    pub texts: Vec<Cells>,
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
        let mut log = Self::with_columns(n);
        if let Some(samples) = reader.layout().samples {
            // A header may promise anything: reserve no more than a modest log needs.
            let reserve = usize::try_from(samples).unwrap_or(usize::MAX).min(1 << 20);
            log.columns.iter_mut().for_each(|c| c.reserve(reserve));
        }
        let mut block = Block::with_columns(n);
        while reader.read_block(&mut block)? {
            log.append(&block, block.rows);
        }
        log.layout = reader.layout().clone();
        if log.rows == 0 {
            return Err(Error::no_samples());
        }
        if log.layout.channels.iter().any(|c| c.is_increment) {
            let dt_s = log.dt_s()?;
            log.divide_increments(0, dt_s);
        }
        Ok(log)
    }

    /// An empty log of so many columns.
    pub(crate) fn with_columns(n: usize) -> Self {
        Self {
            columns: vec![Vec::new(); n],
            ..Self::default()
        }
    }

    /// Adds the first rows of a block, all of them where it has fewer.
    pub(crate) fn append(&mut self, block: &Block, rows: usize) {
        let rows = rows.min(block.rows);
        if rows < block.rows {
            let mut part = block.clone();
            part.keep(0..rows);
            return self.append(&part, rows);
        }
        self.stamps.append(&block.stamps);
        for (all, part) in self.columns.iter_mut().zip(&block.columns) {
            all.extend_from_slice(part);
        }
        append_texts(&mut self.texts, &block.texts);
        self.rows += rows;
    }

    /// Drops the first rows.
    pub(crate) fn forget(&mut self, rows: usize) {
        self.stamps.keep(rows..self.stamps.len());
        for column in &mut self.columns {
            column.drain(..rows);
        }
        self.texts.iter_mut().for_each(|t| t.keep(rows..self.rows));
        self.rows -= rows;
    }

    /// The sampling interval: 1/rate where a rate was given, else from the stamps.
    ///
    /// # Errors
    /// Time that never advances, or a single stamp.
    pub fn dt_s(&self) -> Result<f64, Error> {
        if self.layout.rate_hz.is_some() {
            return self.dt_of(&Beat::default());
        }
        self.dt_of(&Beat::of(self))
    }

    /// As [`Log::dt_s`], of a beat that is known.
    pub(crate) fn dt_of(&self, beat: &Beat) -> Result<f64, Error> {
        if let Some(rate) = self.layout.rate_hz {
            return Ok(1.0 / rate);
        }
        beat.dt_s.ok_or_else(|| {
            let is_number = |k: &usize| {
                let stamp = self.stamps.get(*k);
                stamp.is_some_and(|t| t.seconds().is_finite())
            };
            let numbers = (0..self.stamps.len()).filter(is_number).take(2).count();
            let what = match (self.rows, numbers) {
                (0 | 1, _) => "the log has one sample, which has no rate",
                (_, 0) => "no time stamp is a number",
                (_, 1) => "one time stamp alone is a number",
                _ if crate::clock::steps(&self.stamps).iter().any(|s| *s < 0.0) => {
                    "time only runs backwards"
                }
                _ => "time never advances",
            };
            Error::data(what)
                .at("time")
                .advise(if what.ends_with("backwards") {
                    "sort the rows by time, or add --rate, for instance --rate 100Hz"
                } else {
                    "add --rate, for instance --rate 100Hz"
                })
        })
    }

    /// Time of row `k` in seconds from the first row; from the rate where there are no stamps.
    pub fn time_s(&self, k: usize) -> f64 {
        match (self.stamps.get(k), self.stamps.get(0)) {
            (Some(t), Some(origin)) => t.since(origin),
            _ => k as f64 / self.layout.rate_hz.unwrap_or(1.0),
        }
    }

    /// Increments to rates, from row `from` on.
    pub(crate) fn divide_increments(&mut self, from: usize, dt_s: f64) {
        for (channel, column) in self.layout.channels.iter_mut().zip(&mut self.columns) {
            if channel.is_increment {
                for v in column.iter_mut().skip(from) {
                    *v /= dt_s;
                }
                channel.is_increment = false;
            }
        }
    }

    /// Hands the log out again in blocks, as a reader does.
    pub fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        const ROWS: usize = 1 << 14;
        (0..self.rows.div_ceil(ROWS)).map(move |b| {
            let range = b * ROWS..((b + 1) * ROWS).min(self.rows);
            let mut stamps = Stamps::default();
            for k in range.clone() {
                if let Some(s) = self.stamps.get(k) {
                    stamps.push(s);
                }
            }
            let columns = self
                .columns
                .iter()
                .map(|c| c[range.clone()].to_vec())
                .collect();
            Block {
                stamps,
                columns,
                texts: self.texts.iter().map(|t| t.slice(range.clone())).collect(),
                rows: range.len(),
            }
        })
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
