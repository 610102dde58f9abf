//! Where the truth of a run comes from: a trajectory, or a log of true specific force and rate.

use rayon::prelude::*;
use sagnac_core::Sensor;
use sagnac_log::{
    Block, Cadence, Cells, Channel, Layout, LogReader, Quantity, Stamp, Stamps, TextColumn,
};
use sagnac_nav::{Motion, Trajectory, TruthSample};

use super::slope::slopes;
use super::temperature::TemperatureProfile;
use crate::Error;
use crate::clock::RowClock;

/// Rows that are made at a time.
pub(super) const ROWS: usize = 8192;

/// Rows of truth, a column a channel; what a log lacks stays empty.
#[derive(Debug, Clone, Default)]
pub(super) struct TruthRows {
    pub(super) rows: usize,
    pub(super) stamps: Stamps,
    pub(super) rate: [Vec<f64>; 3],
    pub(super) force: [Vec<f64>; 3],
    pub(super) rate_dot: [Vec<f64>; 3],
    pub(super) temperature: Vec<f64>,
    pub(super) motion: Vec<Motion>,
    /// Columns of a log that are no sensor's, numbers and text.
    pub(super) others: Vec<Vec<f64>>,
    pub(super) texts: Vec<Cells>,
    /// All rows equal one another and those before.
    pub(super) is_constant: bool,
}

/// A run's truth, block by block.
pub(super) trait TruthSource {
    /// The next rows; `false` with no rows at the end.
    fn next_rows(&mut self, rows: &mut TruthRows) -> Result<bool, Error>;
}

/// What both sources need to know.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// The log that the truth comes from, as it was given.
    pub(super) label: String,
    pub(super) rate_hz: f64,
    /// `None` where the log does not tell its length before its end.
    pub(super) samples: Option<u64>,
    /// When the run ends, s, where that is known.
    pub(super) end_s: Option<f64>,
    pub(super) temperature: Option<TemperatureProfile>,
    pub(super) reference_temperature_c: f64,
    pub(super) with_motion: bool,
    /// Interval of a log's stamps, where a rate overrides them.
    pub(super) overridden_dt_s: Option<f64>,
    /// What a log's first stamps tell.
    pub(super) cadence: Option<Cadence>,
    /// Channels of a log that are no sensor's, with their places in it.
    pub(super) others: Vec<(usize, Channel)>,
    /// Its columns of text, likewise.
    pub(super) texts: Vec<(usize, TextColumn)>,
}

/// Whether a column tells of the run that wrote the log: in the output of another it would be untrue.
fn is_of_a_run(name: &str) -> bool {
    name == "flags"
        || ["bias_gyro_", "bias_accel_"]
            .iter()
            .any(|of| name.starts_with(of))
}

impl Plan {
    pub(super) fn dt_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// The clock of a log's rows.
    pub(super) fn clock(&self) -> RowClock {
        RowClock::new(self.dt_s(), self.overridden_dt_s, self.cadence)
    }

    /// Fixes the columns of a log that are handed on, and names those that are not: biases and flags of
    /// the run that wrote it.
    pub(super) fn keep_others(&mut self, layout: &Layout) -> Vec<String> {
        let mut left_out = Vec::new();
        let mut keeps = |name: &str| {
            let keeps = !is_of_a_run(name);
            if !keeps {
                left_out.push(name.to_owned());
            }
            keeps
        };
        let others = layout.channels.iter().enumerate();
        self.others = others
            .filter(|(_, channel)| channel.quantity == Quantity::Other && keeps(&channel.name))
            .map(|(at, channel)| (at, channel.clone()))
            .collect();
        let texts = layout.texts.iter().enumerate();
        self.texts = texts
            .filter(|(_, text)| {
                let name = text.header.split('[').next().unwrap_or_default();
                keeps(name.trim_matches([' ', '"']))
            })
            .map(|(at, text)| (at, text.clone()))
            .collect();
        left_out
    }

    fn stamp(&self, k: u64) -> Stamp {
        Stamp::of_row(k, self.rate_hz)
    }

    fn mean_temperature(&self, from_s: f64, to_s: f64, end_s: f64) -> f64 {
        self.temperature
            .as_ref()
            .map_or(self.reference_temperature_c, |profile| {
                profile.mean_c(from_s, to_s, end_s)
            })
    }
}

/// Interval means of a trajectory.
pub(super) struct TrajectorySource<'a> {
    trajectory: &'a Trajectory,
    plan: Plan,
    samples: u64,
    done: u64,
    buffer: Vec<TruthSample>,
}

impl<'a> TrajectorySource<'a> {
    pub(super) fn new(trajectory: &'a Trajectory, plan: Plan) -> Self {
        let samples = plan.samples.unwrap_or(0);
        Self {
            trajectory,
            plan,
            samples,
            done: 0,
            buffer: Vec::new(),
        }
    }
}

impl TruthSource for TrajectorySource<'_> {
    fn next_rows(&mut self, rows: &mut TruthRows) -> Result<bool, Error> {
        // The pieces are the same for any number of threads.
        const PIECE: usize = 512;
        let count = usize::try_from(self.samples - self.done)
            .unwrap_or(usize::MAX)
            .min(ROWS);
        rows.rows = count;
        if count == 0 {
            return Ok(false);
        }
        let dt = self.plan.dt_s();
        let end = self.plan.end_s.unwrap_or(self.samples as f64 * dt);
        rows.stamps.clear();
        for k in 1..=count as u64 {
            rows.stamps.push(self.plan.stamp(self.done + k));
        }
        let is_rest = self.trajectory.is_rest();
        let is_steady = self
            .plan
            .temperature
            .as_ref()
            .is_none_or(|t| t.constant().is_some());
        let same = is_rest && rows.force[0].len() == count;
        if !same {
            self.buffer.resize(count, TruthSample::default());
            let (trajectory, done) = (self.trajectory, self.done);
            self.buffer
                .par_chunks_mut(PIECE)
                .enumerate()
                .for_each(|(piece, part)| {
                    let mut samples = trajectory.samples(dt);
                    samples.seek(done + (piece * PIECE) as u64);
                    samples.fill(part);
                });
            for axis in 0..3 {
                let column = |to: &mut Vec<f64>, of: fn(&TruthSample) -> [f64; 3]| {
                    to.clear();
                    to.extend(self.buffer.iter().map(|sample| of(sample)[axis]));
                };
                column(&mut rows.force[axis], |s| s.force_m_s2);
                column(&mut rows.rate[axis], |s| s.rate_rad_s);
                column(&mut rows.rate_dot[axis], |s| s.rate_dot_rad_s2);
            }
        }
        rows.is_constant = is_rest && is_steady;
        let from = |k: usize| (self.done + k as u64) as f64 * dt;
        rows.temperature.clear();
        rows.temperature
            .extend((0..count).map(|k| self.plan.mean_temperature(from(k), from(k + 1), end)));
        rows.motion.clear();
        if self.plan.with_motion {
            let times: Vec<f64> = (1..=count).map(from).collect();
            times
                .par_iter()
                .map(|t| self.trajectory.motion(*t))
                .collect_into_vec(&mut rows.motion);
        }
        self.done += count as u64;
        Ok(true)
    }
}

/// Which channels a log of truth has.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Channels {
    pub(crate) rate: Option<[usize; 3]>,
    pub(crate) force: Option<[usize; 3]>,
    pub(crate) rate_dot: Option<[usize; 3]>,
    pub(crate) temperature: Option<usize>,
}

impl Channels {
    /// Finds the channels; a triad must be whole.
    pub(crate) fn of(layout: &sagnac_log::Layout) -> Result<Self, Error> {
        let triad = |name: &str| {
            let found = ["x", "y", "z"].map(|axis| layout.index(&format!("{name}_{axis}")));
            match found {
                [Some(x), Some(y), Some(z)] => Ok(Some([x, y, z])),
                [None, None, None] => Ok(None),
                _ => {
                    let missing = ["x", "y", "z"]
                        .into_iter()
                        .zip(found)
                        .find(|(_, at)| at.is_none())
                        .map_or("x", |(axis, _)| axis);
                    Err(Error::data(format!(
                        "the log has some of {name}_x, {name}_y, {name}_z, but no {name}_{missing}"
                    ))
                    .advise("give all three axes or none"))
                }
            }
        };
        let out = Self {
            rate: triad(Sensor::Gyro.key())?,
            force: triad(Sensor::Accel.key())?,
            rate_dot: triad("gyro_rate")?,
            temperature: layout.index("temperature"),
        };
        if out.rate.is_none() && out.force.is_none() {
            return Err(Error::data("the log has neither gyro nor accelerometer channels").advise(
                "name its columns, for instance --columns 'gyro=1,2,3:rad/s, accel=4,5,6:m/s^2'",
            ));
        }
        Ok(out)
    }
}

/// The truth of a log, in its own times.
pub(super) struct LogSource {
    reader: Box<dyn LogReader>,
    channels: Channels,
    plan: Plan,
    block: Block,
    /// Rows at hand: the last two given, and those to come.
    stamps: Stamps,
    time_s: Vec<f64>,
    columns: Vec<Vec<f64>>,
    texts: Vec<Cells>,
    next: usize,
    ended: bool,
    read: u64,
    pub(super) clock: RowClock,
}

impl LogSource {
    pub(super) fn new(reader: Box<dyn LogReader>, channels: Channels, plan: Plan) -> Self {
        let count = reader.layout().channels.len();
        let clock = plan.clock();
        Self {
            reader,
            channels,
            plan,
            block: Block::with_columns(count),
            stamps: Stamps::default(),
            time_s: Vec::new(),
            columns: vec![Vec::new(); count],
            texts: Vec::new(),
            next: 0,
            ended: false,
            read: 0,
            clock,
        }
    }

    /// What the reader said.
    pub(super) fn reader_notes(&self) -> Vec<String> {
        self.reader.layout().notes.clone()
    }

    /// Reads until `wanted` rows are at hand beyond the next one, or the log ends.
    fn read_ahead(&mut self, wanted: usize) -> Result<(), Error> {
        while !self.ended && self.time_s.len() < self.next + wanted {
            if !self.reader.read_block(&mut self.block)? {
                self.ended = true;
                break;
            }
            let dt = self.plan.dt_s();
            for k in 0..self.block.rows {
                self.read += 1;
                let stamp = self.block.stamps.get(k);
                let at_s = self.clock.next(stamp);
                self.time_s.push(at_s + dt);
                let written = stamp.and_then(|stamp| self.clock.written(Some(stamp), at_s));
                self.stamps
                    .push(written.unwrap_or_else(|| self.plan.stamp(self.read)));
            }
            if let Some(row) = self.clock.first_without_number() {
                return Err(no_time(row).at(self.plan.label.clone()));
            }
            self.texts
                .resize_with(self.block.texts.len(), Cells::default);
            for (all, part) in self.texts.iter_mut().zip(&self.block.texts) {
                all.append(part);
            }
            for (at, _) in &self.plan.others {
                self.columns[*at].extend_from_slice(&self.block.columns[*at]);
            }
            let used = self.channels.used();
            for (index, (all, part)) in self.columns.iter_mut().zip(&self.block.columns).enumerate()
            {
                if !used.contains(&index) {
                    continue;
                }
                let channel = &self.reader.layout().channels[index];
                let first = self.read - self.block.rows as u64;
                if let Some(bad) = part.iter().position(|value| !value.is_finite()) {
                    return Err(Error::data(format!(
                        "the truth in row {} is not a finite number",
                        first + bad as u64 + 1
                    ))
                    .at(format!(
                        "{}, row {}, column {}",
                        self.plan.label,
                        first + bad as u64 + 1,
                        channel.name
                    ))
                    .advise("repair the row or cut it out with --start or --end"));
                }
                // Terms go up to its cube, in units as small as deg/h.
                if let Some(bad) = part.iter().position(|v| !(v.powi(3) * 1e6).is_finite()) {
                    let row = first + bad as u64 + 1;
                    return Err(Error::data(format!(
                        "the truth in row {row}, {}, is too large to reckon with: its cube is beyond every number",
                        sagnac_report::text::general(part[bad], 3)
                    ))
                    .at(format!("{}, row {row}, column {}", self.plan.label, channel.name))
                    .advise("look for a wrong unit or power of ten of that column"));
                }
                if channel.is_increment {
                    all.extend(part.iter().map(|value| value / dt));
                } else {
                    all.extend_from_slice(part);
                }
            }
        }
        Ok(())
    }

    /// Forgets rows that nothing needs any more.
    fn forget(&mut self) {
        let old = self.next.saturating_sub(2);
        if old == 0 {
            return;
        }
        self.time_s.drain(..old);
        self.stamps.keep(old..self.stamps.len());
        for column in self.columns.iter_mut().filter(|c| !c.is_empty()) {
            column.drain(..old);
        }
        for text in &mut self.texts {
            text.keep(old..text.len());
        }
        self.next -= old;
    }
}

impl Channels {
    fn used(&self) -> Vec<usize> {
        [self.rate, self.force, self.rate_dot]
            .into_iter()
            .flatten()
            .flatten()
            .chain(self.temperature)
            .collect()
    }
}

impl TruthSource for LogSource {
    fn next_rows(&mut self, rows: &mut TruthRows) -> Result<bool, Error> {
        self.forget();
        self.read_ahead(ROWS + 2)?;
        let count = (self.time_s.len() - self.next).min(ROWS);
        rows.rows = count;
        if count == 0 {
            return Ok(false);
        }
        let range = self.next..self.next + count;
        rows.stamps = self.stamps.clone();
        rows.stamps.keep(range.clone());
        let dt = self.plan.dt_s();
        for axis in 0..3 {
            let copy = |to: &mut Vec<f64>, triad: Option<[usize; 3]>| {
                to.clear();
                match triad {
                    Some(triad) => {
                        to.extend_from_slice(&self.columns[triad[axis]][range.clone()]);
                    }
                    None => to.resize(count, 0.0),
                }
            };
            copy(&mut rows.rate[axis], self.channels.rate);
            copy(&mut rows.force[axis], self.channels.force);
            match (self.channels.rate_dot, self.channels.rate) {
                (None, Some(rate)) => {
                    rows.rate_dot[axis].clear();
                    slopes(
                        &self.time_s,
                        &self.columns[rate[axis]],
                        dt,
                        range.clone(),
                        &mut rows.rate_dot[axis],
                    );
                }
                (given, _) => copy(&mut rows.rate_dot[axis], given),
            }
        }
        rows.temperature.clear();
        if let (None, Some(column)) = (&self.plan.temperature, self.channels.temperature) {
            rows.temperature
                .extend_from_slice(&self.columns[column][range.clone()]);
        } else {
            let end = self.plan.end_s.unwrap_or(f64::INFINITY);
            let times = &self.time_s[range.clone()];
            rows.temperature.extend(
                times
                    .iter()
                    .map(|t| self.plan.mean_temperature(t - dt, *t, end)),
            );
        }
        rows.others.resize_with(self.plan.others.len(), Vec::new);
        for (to, (at, _)) in rows.others.iter_mut().zip(&self.plan.others) {
            to.clear();
            to.extend_from_slice(&self.columns[*at][range.clone()]);
        }
        rows.texts.clear();
        let texts = self.plan.texts.iter();
        rows.texts
            .extend(texts.filter_map(|(at, _)| self.texts.get(*at)).cloned());
        rows.texts.iter_mut().for_each(|t| t.keep(range.clone()));
        rows.motion.clear();
        rows.is_constant = false;
        self.next += count;
        Ok(true)
    }
}

/// A reader whose first block has been looked at.
pub(super) struct Peeked {
    reader: Box<dyn LogReader>,
    first: Option<Block>,
}

impl Peeked {
    /// The reader, and what the stamps of its first rows tell.
    pub(super) fn new(mut reader: Box<dyn LogReader>) -> Result<(Self, Option<Cadence>), Error> {
        let mut block = Block::with_columns(reader.layout().channels.len());
        if !reader.read_block(&mut block)? || block.rows == 0 {
            return Err(Error::data("the log has no samples"));
        }
        let cadence = Cadence::of(&block.stamps);
        Ok((
            Self {
                reader,
                first: Some(block),
            },
            cadence,
        ))
    }
}

impl LogReader for Peeked {
    fn layout(&self) -> &Layout {
        self.reader.layout()
    }

    fn read_block(&mut self, block: &mut Block) -> Result<bool, sagnac_log::Error> {
        match self.first.take() {
            Some(first) => {
                *block = first;
                Ok(true)
            }
            None => self.reader.read_block(block),
        }
    }
}

/// A row whose time is no finite number.
pub(super) fn no_time(row: u64) -> Error {
    Error::data(format!("the time of row {row} is not a finite number"))
        .at(format!("row {row}"))
        .advise("repair the row, cut it out with --start or --end, or give --rate")
}
