//! The reader every command sees: chosen columns, SI units, remounted axes, cut to the wanted time.
//!
//! value_SI = value·factor + offset; increments are divided by dt, accumulated angles are differenced before.

use super::axes::{AxisMap, remount};
use super::choose::{
    Op, by_name, by_request, capital_hint, keep_others, say_increments, say_texts, take_texts,
};
use super::columns::{Scale, parse};
use super::hints::{another_sort, columns_place};
use super::raw::{Plan, RawReader};
use crate::{Block, Error, Layout, LogReader, ReadOptions, Stamp};

/// A format's columns as channels in SI.
pub(crate) struct Mapped {
    raw: Box<dyn RawReader>,
    layout: Layout,
    ops: Vec<Op>,
    /// Output k is `sign` times column `from` of the scaled block.
    mount: Vec<(usize, f64)>,
    label: String,
    start_s: Option<f64>,
    end_s: Option<f64>,
    first: Option<Stamp>,
    /// Last accumulated value of each op; `None` before the first row.
    last: Option<Vec<f64>>,
    rows_seen: u64,
    rows_kept: u64,
    done: bool,
    is_live: bool,
    scratch: Block,
    own_notes: Vec<String>,
}

impl Mapped {
    pub(crate) fn new(
        mut raw: Box<dyn RawReader>,
        options: &ReadOptions,
        label: &str,
    ) -> Result<Self, Error> {
        if let Some(rate) = options.rate_hz
            && !(1e-6..=1e12).contains(&rate)
        {
            return Err(
                Error::usage("the rate must lie between 1e-6 Hz and 1e12 Hz")
                    .at("--rate")
                    .advise("write for instance --rate 200Hz"),
            );
        }
        if let (Some(start), Some(end)) = (options.start_s, options.end_s)
            && start >= end
        {
            return Err(Error::usage("the end comes before the start")
                .at("--start, --end")
                .advise("both count from the first sample, for instance --start 30s --end 2h"));
        }
        let axes = options.axes.as_deref().map(AxisMap::parse).transpose()?;
        let with_text = options.keep_text && raw.raw().has_cells;
        let (time, mut ops) = match options.columns.as_deref() {
            Some(text) => by_request(&parse(text)?, raw.raw())?,
            None => by_name(raw.raw(), with_text)?,
        };
        let found = raw.raw().clone();
        let mut left_out = Vec::new();
        // Other formats hold arrays and messages beside one another, of any lengths.
        let is_table = ["CSV", "EuRoC", "Parquet", "numpy array", "numpy structured"]
            .iter()
            .any(|table| found.format.starts_with(table));
        if options.keep_others && is_table {
            left_out = keep_others(&found, time, &mut ops, with_text);
        }
        let mut texts = Vec::new();
        if with_text {
            texts = take_texts(&found, &mut ops);
        } else {
            left_out.extend(say_texts(&found, time));
        }
        if time.is_none() && options.rate_hz.is_none() && found.rate_hz.is_none() {
            if let Some((sort, advice)) = another_sort(&found) {
                return Err(Error::data(format!("this is {sort}, not a log"))
                    .at(columns_place(&found))
                    .advise(advice));
            }
            return Err(Error::data("the log has no time and no rate")
                .at(columns_place(&found))
                .advise(match capital_hint(&found) {
                    Some(hint) => format!("{hint}; or add --rate, for instance --rate 100Hz"),
                    None => "add --rate, for instance --rate 100Hz".to_owned(),
                }));
        }
        let plan = Plan {
            time,
            columns: ops.iter().map(|o| o.column).collect(),
            is_lenient: ops.iter().map(|o| o.is_other).collect(),
            texts: texts.iter().map(|(column, _)| *column).collect(),
        };
        raw.select(plan)?;
        let mut layout = Layout {
            format: found.format,
            channels: ops.iter().map(|o| o.channel.clone()).collect(),
            texts: texts.into_iter().map(|(_, text)| text).collect(),
            has_time: time.is_some(),
            rate_hz: options.rate_hz.or(found.rate_hz),
            time_unit_s: time.and_then(|(_, kind)| kind.unit_s()),
            topics: found.topics,
            topic: found.topic,
            frame: found.frame,
            frame_id: found.frame_id,
            covariances: found.covariances,
            samples: found.samples,
            notes: left_out,
        };
        say_increments(&ops, &mut layout);
        let mount = match axes {
            Some(map) => {
                // Turned axes are no longer those of the source's frame.
                layout.frame = layout.frame.map(|f| f + ", turned by --axes");
                layout.frame_id = layout.frame_id.map(|_| "imu".to_owned());
                remount(&map, &mut layout)?
            }
            None => (0..ops.len()).map(|k| (k, 1.0)).collect(),
        };
        if let Some(rate) = layout.rate_hz {
            for c in &mut layout.channels {
                c.is_increment = false;
            }
            if !(rate.is_finite() && rate > 0.0) {
                return Err(Error::data("the rate that the log states is not positive").at(label));
            }
        }
        let mut mapped = Self {
            raw,
            layout,
            ops,
            mount,
            label: label.to_owned(),
            start_s: options.start_s,
            end_s: options.end_s,
            first: None,
            last: None,
            rows_seen: 0,
            rows_kept: 0,
            done: false,
            is_live: options.is_live,
            scratch: Block::default(),
            own_notes: Vec::new(),
        };
        mapped.own_notes.clone_from(&mapped.layout.notes);
        mapped.refresh_notes();
        Ok(mapped)
    }

    fn refresh_notes(&mut self) {
        self.layout.notes.clone_from(&self.raw.raw().notes);
        self.layout.notes.extend_from_slice(&self.own_notes);
    }

    /// Scales the raw block and takes differences of accumulated columns.
    fn scale(&mut self, block: &mut Block) {
        let dt = self.layout.rate_hz.map(|r| 1.0 / r);
        let first_block = self.last.is_none();
        let mut last = self
            .last
            .take()
            .unwrap_or_else(|| vec![f64::NAN; self.ops.len()]);
        let any_accumulated = self.ops.iter().any(|o| o.accumulated);
        for ((op, column), last) in self.ops.iter().zip(&mut block.columns).zip(&mut last) {
            let Scale { factor, offset, .. } = op.scale;
            if factor != 1.0 || offset != 0.0 {
                for v in column.iter_mut() {
                    *v = *v * factor + offset;
                }
            }
            if op.accumulated {
                for v in column.iter_mut() {
                    let now = *v;
                    *v = now - *last;
                    *last = now;
                }
            }
            if let (true, Some(dt)) = (op.channel.from_increments, dt) {
                for v in column.iter_mut() {
                    *v /= dt;
                }
            }
        }
        if first_block && any_accumulated && block.rows > 0 {
            block.keep(1..block.rows);
        }
        self.last = Some(last);
    }

    /// Cuts the block to `--start` and `--end`; true where nothing later can be wanted.
    fn cut(&mut self, block: &mut Block) -> bool {
        let seen = self.rows_seen;
        self.rows_seen += block.rows as u64;
        if self.start_s.is_none() && self.end_s.is_none() || block.rows == 0 {
            return false;
        }
        let start = self.start_s.unwrap_or(f64::NEG_INFINITY);
        let end = self.end_s.unwrap_or(f64::INFINITY);
        let times: Vec<f64> = if block.stamps.is_empty() {
            let rate = self.layout.rate_hz.unwrap_or(f64::NAN);
            (0..block.rows as u64)
                .map(|k| (seen + k) as f64 / rate)
                .collect()
        } else {
            let origin = *self
                .first
                .get_or_insert_with(|| block.stamps.get(0).unwrap_or(Stamp::Seconds(0.0)));
            block.stamps.since(origin)
        };
        // A time that is no number belongs to its neighbors.
        let wanted: Vec<bool> = times
            .iter()
            .map(|&t| t.is_nan() || (t >= start && t < end))
            .collect();
        if wanted.iter().all(|&w| w) {
            return false;
        }
        block.filter(&wanted);
        times.iter().all(|&t| t >= end)
    }
}

impl LogReader for Mapped {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn read_block(&mut self, block: &mut Block) -> Result<bool, Error> {
        block.clear();
        let mut scratch = std::mem::take(&mut self.scratch);
        while !self.done {
            let more = self
                .raw
                .read_raw(&mut scratch)
                .map_err(|e| e.in_source(&self.label));
            let more = match more {
                Ok(more) => more,
                Err(e) => {
                    self.done = true;
                    return Err(e);
                }
            };
            if !more {
                self.done = true;
                self.refresh_notes();
                break;
            }
            self.scale(&mut scratch);
            if self.cut(&mut scratch) {
                self.done = true;
                self.refresh_notes();
            }
            if scratch.rows == 0 {
                continue;
            }
            self.rows_kept += scratch.rows as u64;
            block.rows = scratch.rows;
            std::mem::swap(&mut block.stamps, &mut scratch.stamps);
            std::mem::swap(&mut block.texts, &mut scratch.texts);
            let columns = &mut scratch.columns;
            block.columns.resize_with(self.mount.len(), Vec::new);
            for (out, &(from, sign)) in block.columns.iter_mut().zip(&self.mount) {
                // Every source is used once: its memory moves on.
                std::mem::swap(out, &mut columns[from]);
                if sign < 0.0 {
                    for v in out.iter_mut() {
                        *v = -*v;
                    }
                }
            }
            self.scratch = scratch;
            return Ok(true);
        }
        if self.rows_kept == 0
            && self.rows_seen > 0
            && (self.start_s.is_some() || self.end_s.is_some())
        {
            let what = format!(
                "no sample lies between --start and --end; the log has {} samples",
                self.rows_seen
            );
            return Err(Error::data(what)
                .at(self.label.clone())
                .advise("both count from the first sample"));
        }
        self.scratch = scratch;
        if self.rows_seen == 0 && !self.is_live {
            return Err(Error::data("the log has no samples")
                .at(self.label.clone())
                .advise("look at what recorded it, or copy it again"));
        }
        Ok(false)
    }
}
