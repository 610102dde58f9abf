//! `correct`: a model's inverse applied to a log as a stream, in constant memory.
//!
//! Columns that are no gyro or accelerometer stay as they are. Where the log has no
//! `gyro_rate_*`, ω̇ is the slope of the parabola through three samples of the gyro that was
//! corrected without it; rows on either side of a gap are not joined.

#![allow(clippy::type_complexity, reason = "a tuple of one use")]
#![allow(clippy::large_types_passed_by_value, reason = "moved once")]

use sagnac_core::{Compensation, CorrectedBlock, ReadingBlock, Sensor, SensorModel, flags};
use sagnac_log::{Block, Channel, Layout, LogReader, LogWriter, Stamp};
use sagnac_model::Model;
use sagnac_report::text::{Document, Table, clock_span, duration, general, group_thousands};
use serde_json::{Value, json};

use crate::Error;

/// How a log is corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CorrectRequest {
    /// Writes the column `flags`.
    pub flags: bool,
}

/// What was changed on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// `gyro_x` … `accel_z`.
    pub axis: String,
    /// Mean of corrected − raw, rad/s or m/s².
    pub mean: f64,
    /// Largest |corrected − raw|.
    pub largest: f64,
}

/// Neighboring samples of an axis at the end of its range.
#[derive(Clone, Debug, PartialEq)]
struct Saturated {
    axis: String,
    start_s: f64,
    end_s: f64,
    count: u64,
    at: f64,
}

/// The answer of `correct`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CorrectOutcome {
    /// Rows corrected.
    pub samples: u64,
    /// From the first to the last row, and one interval, s.
    pub duration_s: f64,
    /// Axes that were corrected.
    pub changes: Vec<Change>,
    /// Samples with flag 1 or 2.
    pub saturated: u64,
    /// Samples with flag 4, 8 or 16.
    pub outside_validity: u64,
    /// Warnings about the model or the log.
    pub warnings: Vec<String>,
    /// What the user should know besides.
    pub notes: Vec<String>,
    spans: Vec<Saturated>,
    more_spans: usize,
}

/// Corrects all rows that `reader` gives and writes them to the writer that `create` makes.
///
/// # Errors
/// A model without an inverse, a log without gyro and accelerometer, those of reader and writer.
pub fn correct(
    model: &Model,
    reader: &mut dyn LogReader,
    create: &mut dyn FnMut(&Layout) -> Result<Box<dyn LogWriter>, Error>,
    request: CorrectRequest,
) -> Result<CorrectOutcome, Error> {
    let mut outcome = CorrectOutcome::default();
    let layout = reader.layout().clone();
    let triad = |prefix: &str| -> Option<[usize; 3]> {
        let at = |axis: &str| layout.index(&format!("{prefix}_{axis}"));
        Some([at("x")?, at("y")?, at("z")?])
    };
    let columns = Columns {
        gyro: triad("gyro"),
        accel: triad("accel"),
        rate: triad("gyro_rate"),
        temperature: layout.index("temperature"),
    };
    let core = usable(model, &columns, &layout, &mut outcome)?;
    let mut block = Block::with_columns(layout.channels.len());
    let mut is_more = reader.read_block(&mut block)?;
    if !is_more {
        return Err(Error::data("the log has no samples"));
    }
    let dt_s = interval(model, &layout, &block, &mut outcome)?;
    let inverse = Compensation::new(&core, dt_s).map_err(|error| {
        Error::data(error.to_string())
            .at(model.label().to_owned())
            .advise(
                "look for a wrong unit: scale_factor, misalignment and cross_axis are fractions",
            )
    })?;
    if let Some(bound) = inverse.bound().filter(|bound| !bound.is_inside()) {
        outcome.warnings.push(format!(
            "the model is outside the convergence bound (q = {}): every sample is flagged",
            general(bound.q, 3)
        ));
    }
    if request.flags && layout.index("flags").is_some() {
        return Err(Error::data("the log has a column `flags` already").advise("leave --flags out"));
    }
    let out_layout = written_layout(&layout, request);
    let mut writer = create(&out_layout)?;
    let mut work = Work::new(&core, inverse, columns, &layout, dt_s);
    let mut pending = Pending::new(layout.channels.len());
    while is_more {
        divide_increments(&layout, &mut block, dt_s);
        pending.push(&block);
        is_more = reader.read_block(&mut block)?;
        let ready = work.ready(&pending, !is_more);
        if ready > 0 {
            let mut out = work.rows(&pending, ready, request);
            work.count(&pending, &mut out, &mut outcome);
            writer.write_block(&out.block)?;
            pending.done(ready);
        }
    }
    outcome.notes.extend(reader.layout().notes.iter().cloned());
    outcome.notes.extend(writer.finish()?);
    work.finish(&mut outcome);
    Ok(outcome)
}

#[derive(Clone, Copy)]
struct Columns {
    gyro: Option<[usize; 3]>,
    accel: Option<[usize; 3]>,
    rate: Option<[usize; 3]>,
    temperature: Option<usize>,
}

/// The model without the terms for which the log lacks a channel; what that means is noted.
fn usable(
    model: &Model,
    columns: &Columns,
    layout: &Layout,
    outcome: &mut CorrectOutcome,
) -> Result<SensorModel<f64>, Error> {
    let mut core = model.to_core()?;
    if columns.gyro.is_none() && columns.accel.is_none() {
        let names: Vec<&str> = layout.channels.iter().map(|c| c.name.as_str()).collect();
        return Err(
            Error::data("the log has neither a gyro nor an accelerometer of three axes")
                .at(format!("channels {}", names.join(", ")))
                .advise("name them with --columns 'gyro=1,2,3:deg/s, accel=4,5,6:g'"),
        );
    }
    if columns.gyro.is_none() {
        if core.accel_axis_offset.is_present() {
            outcome.notes.push(
                "the log has no gyro: the accelerometer is corrected without its axis offset"
                    .to_owned(),
            );
        }
        core = core.without_gyro();
    }
    if columns.accel.is_none() {
        if core.gyro_g_sensitivity.is_present() || core.gyro_g2_sensitivity.is_present() {
            outcome.notes.push(
                "the log has no accelerometer: the gyro is corrected without its g-sensitivity"
                    .to_owned(),
            );
        }
        core = core.without_accel();
    }
    if columns.temperature.is_none() && core.depends_on_temperature() {
        outcome.notes.push(format!(
            "the log has no temperature: the model's temperature terms are taken at {} degC",
            general(core.reference_temperature_c, 4)
        ));
    }
    let mut not_undone = vec!["noise"];
    for sensor in Sensor::ALL {
        let triad = core.triad(sensor);
        let s = model.stability(sensor);
        let mut add = |has: bool, word: &'static str| {
            if has && !not_undone.contains(&word) {
                not_undone.push(word);
            }
        };
        add(s.bias.iter().any(|x| *x > 0.0), "run-to-run bias");
        add(
            s.scale_factor.iter().any(|x| *x > 0.0),
            "run-to-run scale factor",
        );
        add(
            s.misalignment.iter().any(|x| *x > 0.0),
            "run-to-run misalignment",
        );
        add(
            (0..3).any(|k| model.instability_floor(sensor, k).is_some_and(|x| x > 0.0)),
            "bias instability",
        );
        add(triad.bandwidth.is_present(), "the low-pass");
        add(triad.resolution.is_present(), "rounding");
        add(triad.range.is_present(), "saturation");
    }
    let list = match not_undone.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => "noise".to_owned(),
    };
    outcome
        .notes
        .push(format!("a model cannot take out {list}."));
    let mut held: Vec<&str> = Vec::new();
    for calibration in model.calibrations() {
        held.extend(calibration.held.iter().map(String::as_str));
    }
    if !held.is_empty() {
        outcome.notes.push(format!(
            "not corrected, held at zero in the calibration: {}",
            held.join(", ")
        ));
    }
    Ok(core)
}

/// dt: the log's, else the model's; a difference of more than 0.1 % is told.
fn interval(
    model: &Model,
    layout: &Layout,
    first: &Block,
    outcome: &mut CorrectOutcome,
) -> Result<f64, Error> {
    let of_log = layout.rate_hz.map(|rate| 1.0 / rate).or_else(|| {
        let mut steps: Vec<f64> = (1..first.rows)
            .filter_map(|k| Some(first.stamps.get(k)?.since(first.stamps.get(k - 1)?)))
            .filter(|step| *step > 0.0)
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied()
    });
    let of_model = model.sample_rate_hz().map(|rate| 1.0 / rate);
    if let (Some(log), Some(model)) = (of_log, of_model)
        && (log / model - 1.0).abs() > 1e-3
    {
        outcome.warnings.push(format!(
            "the log has {} Hz, the model {} Hz: the log's counts",
            general(1.0 / log, 5),
            general(1.0 / model, 5)
        ));
    }
    let dt_s = of_log.or(of_model).unwrap_or(0.01);
    if dt_s > 0.0 && dt_s.is_finite() {
        Ok(dt_s)
    } else {
        Err(Error::data("the log has no rate").advise("add --rate, for instance --rate 100Hz"))
    }
}

fn written_layout(layout: &Layout, request: CorrectRequest) -> Layout {
    let mut out = layout.clone();
    for channel in &mut out.channels {
        channel.is_increment = false;
    }
    if request.flags {
        out.channels.push(Channel::other("flags", ""));
    }
    out
}

fn divide_increments(layout: &Layout, block: &mut Block, dt_s: f64) {
    for (channel, column) in layout.channels.iter().zip(&mut block.columns) {
        if channel.is_increment {
            for value in column.iter_mut() {
                *value /= dt_s;
            }
        }
    }
}

/// Rows that are read and not yet written, and two written ones before them.
struct Pending {
    block: Block,
    /// Rows at the start that are written already.
    history: usize,
    /// Rows that left the start.
    gone: u64,
}

impl Pending {
    fn new(columns: usize) -> Self {
        Self {
            block: Block::with_columns(columns),
            history: 0,
            gone: 0,
        }
    }

    fn push(&mut self, more: &Block) {
        self.block.stamps.append(&more.stamps);
        for (all, part) in self.block.columns.iter_mut().zip(&more.columns) {
            all.extend_from_slice(part);
        }
        self.block.rows += more.rows;
    }

    fn done(&mut self, ready: usize) {
        let written = self.history + ready;
        let keep_from = written.saturating_sub(2);
        self.block.keep(keep_from..self.block.rows);
        self.history = written - keep_from;
        self.gone += keep_from as u64;
    }
}

struct Out {
    block: Block,
    flags: Vec<u32>,
}

struct Work {
    inverse: Compensation<f64>,
    columns: Columns,
    needs_slope: bool,
    rate_hz: Option<f64>,
    dt_s: f64,
    reference_c: f64,
    origin: Option<Stamp>,
    last_s: f64,
    sums: Vec<(String, f64, f64, u64)>,
    open: Vec<Option<Saturated>>,
}

impl Work {
    fn new(
        core: &SensorModel<f64>,
        inverse: Compensation<f64>,
        columns: Columns,
        layout: &Layout,
        dt_s: f64,
    ) -> Self {
        let mut sums = Vec::new();
        for (sensor, has) in [("gyro", columns.gyro), ("accel", columns.accel)] {
            if has.is_some() {
                for axis in ["x", "y", "z"] {
                    sums.push((format!("{sensor}_{axis}"), 0.0, 0.0, 0));
                }
            }
        }
        Self {
            inverse,
            columns,
            needs_slope: columns.gyro.is_some()
                && columns.accel.is_some()
                && columns.rate.is_none()
                && core.accel_axis_offset.is_present(),
            rate_hz: layout.rate_hz,
            dt_s,
            reference_c: core.reference_temperature_c,
            origin: None,
            last_s: 0.0,
            open: vec![None; sums.len()],
            sums,
        }
    }

    fn time_s(&self, pending: &Pending, row: usize) -> f64 {
        let origin = self.origin.or_else(|| pending.block.stamps.get(0));
        match (pending.block.stamps.get(row), origin) {
            (Some(stamp), Some(origin)) if self.rate_hz.is_none() => stamp.since(origin),
            _ => (pending.gone + row as u64) as f64 * self.dt_s,
        }
    }

    /// How many rows behind the written ones can be corrected.
    fn ready(&self, pending: &Pending, is_end: bool) -> usize {
        let waiting = pending.block.rows - pending.history;
        if is_end || !self.needs_slope {
            waiting
        } else {
            // A row at the start of a stretch waits for two more.
            waiting.saturating_sub(2)
        }
    }

    /// ω̇ at a row: slope of the parabola through it and its neighbors, or the nearest three.
    fn slope(&self, times_s: &[f64], w: &[Vec<f64>; 3], row: usize) -> [f64; 3] {
        let rows = times_s.len();
        let joined = |a: usize, b: usize| {
            b < rows && {
                let step = times_s[b] - times_s[a];
                step > 0.0 && step <= 1.5 * self.dt_s
            }
        };
        let before = row > 0 && joined(row - 1, row);
        let after = joined(row, row + 1);
        let (places, count) = match (before, after) {
            (true, true) => ([row - 1, row, row + 1], 3),
            (false, true) if joined(row + 1, row + 2) => ([row, row + 1, row + 2], 3),
            (false, true) => ([row, row + 1, row], 2),
            (true, false) if row > 1 && joined(row - 2, row - 1) => ([row - 2, row - 1, row], 3),
            (true, false) => ([row - 1, row, row], 2),
            (false, false) => ([row; 3], 0),
        };
        let points = &places[..count];
        let t = |i: usize| times_s[i] - times_s[row];
        let of = |k: usize| match points {
            [a, b] => (w[k][*b] - w[k][*a]) / (t(*b) - t(*a)),
            [a, b, c] => {
                let (ta, tb, tc) = (t(*a), t(*b), t(*c));
                // Slope at 0 of the parabola through three points.
                -w[k][*a] * (tb + tc) / ((ta - tb) * (ta - tc))
                    - w[k][*b] * (ta + tc) / ((tb - ta) * (tb - tc))
                    - w[k][*c] * (ta + tb) / ((tc - ta) * (tc - tb))
            }
            _ => 0.0,
        };
        [of(0), of(1), of(2)]
    }

    /// Corrects all rows that are held with a given ω̇.
    fn run(
        &self,
        pending: &Pending,
        rate: Option<&[Vec<f64>; 3]>,
    ) -> ([Vec<f64>; 3], [Vec<f64>; 3], Vec<u32>) {
        let n = pending.block.rows;
        let zero = vec![0.0; n];
        let column = |of: Option<[usize; 3]>| -> [&[f64]; 3] {
            match of {
                Some(at) => at.map(|i| {
                    pending
                        .block
                        .columns
                        .get(i)
                        .map_or(&zero[..], Vec::as_slice)
                }),
                None => [&zero; 3],
            }
        };
        let held = vec![self.reference_c; n];
        let temperature = self
            .columns
            .temperature
            .and_then(|i| pending.block.columns.get(i))
            .map_or(&held[..], Vec::as_slice);
        let gyro_rate = match (rate, self.columns.rate) {
            (Some(rate), _) => Some([&rate[0][..], &rate[1][..], &rate[2][..]]),
            (None, Some(at)) => Some(column(Some(at))),
            (None, None) => None,
        };
        let (mut w, mut f) = ([0; 3].map(|_| vec![0.0; n]), [0; 3].map(|_| vec![0.0; n]));
        let mut marks = vec![0; n];
        let ([wx, wy, wz], [fx, fy, fz]) = (&mut w, &mut f);
        self.inverse.correct_block(
            &ReadingBlock {
                gyro: column(self.columns.gyro),
                accel: column(self.columns.accel),
                gyro_rate,
                temperature_c: Some(temperature),
            },
            &mut CorrectedBlock {
                gyro: [wx, wy, wz],
                accel: [fx, fy, fz],
                flags: &mut marks,
            },
        );
        (w, f, marks)
    }

    fn rows(&mut self, pending: &Pending, ready: usize, request: CorrectRequest) -> Out {
        if self.origin.is_none() {
            self.origin = pending.block.stamps.get(0);
        }
        let (mut w, mut f, mut marks) = self.run(pending, None);
        if self.needs_slope {
            let mut rate = [0; 3].map(|_| vec![0.0; pending.block.rows]);
            let times_s: Vec<f64> = (0..pending.block.rows)
                .map(|row| self.time_s(pending, row))
                .collect();
            for row in pending.history..pending.history + ready {
                let slope = self.slope(&times_s, &w, row);
                for k in 0..3 {
                    rate[k][row] = slope[k];
                }
            }
            (w, f, marks) = self.run(pending, Some(&rate));
        }
        let span = pending.history..pending.history + ready;
        let mut block = pending.block.clone();
        for (of, values) in [(self.columns.gyro, &w), (self.columns.accel, &f)] {
            if let Some(at) = of {
                for k in 0..3 {
                    if let Some(column) = block.columns.get_mut(at[k]) {
                        column.clone_from(&values[k]);
                    }
                }
            }
        }
        if request.flags {
            block
                .columns
                .push(marks.iter().map(|&m| f64::from(m)).collect());
        }
        block.keep(span.clone());
        marks.drain(..span.start);
        marks.truncate(ready);
        Out {
            block,
            flags: marks,
        }
    }

    fn count(&mut self, pending: &Pending, out: &mut Out, outcome: &mut CorrectOutcome) {
        outcome.samples += out.block.rows as u64;
        for mark in &out.flags {
            outcome.saturated +=
                u64::from(mark & (flags::GYRO_SATURATED | flags::ACCEL_SATURATED) != 0);
            outcome.outside_validity += u64::from(
                mark & (flags::TEMPERATURE | flags::OUTSIDE_VALIDITY | flags::NOT_FINITE) != 0,
            );
        }
        let mut place = 0;
        for (sensor, of) in [
            (Sensor::Gyro, self.columns.gyro),
            (Sensor::Accel, self.columns.accel),
        ] {
            let Some(at) = of else { continue };
            let edges = self.inverse.saturation(sensor);
            for k in 0..3 {
                let raw = pending
                    .block
                    .columns
                    .get(at[k])
                    .map_or(&[][..], Vec::as_slice);
                let new = out.block.columns.get(at[k]).map_or(&[][..], Vec::as_slice);
                for (i, new) in new.iter().enumerate() {
                    let row = pending.history + i;
                    let Some(raw) = raw.get(row) else { continue };
                    let change = new - raw;
                    if change.is_finite()
                        && let Some(sum) = self.sums.get_mut(place)
                    {
                        sum.1 += change;
                        sum.2 = sum.2.max(change.abs());
                        sum.3 += 1;
                    }
                    if raw.abs() >= edges[k] {
                        let time_s = self.time_s(pending, row);
                        let axis = self
                            .sums
                            .get(place)
                            .map_or_else(String::new, |s| s.0.clone());
                        if let Some(open) = self.open.get_mut(place) {
                            match open {
                                Some(span) if time_s - span.end_s <= 1.0 => {
                                    span.end_s = time_s;
                                    span.count += 1;
                                }
                                _ => {
                                    let new = Saturated {
                                        axis,
                                        start_s: time_s,
                                        end_s: time_s,
                                        count: 1,
                                        at: edges[k],
                                    };
                                    if let Some(old) = open.replace(new) {
                                        close(old, outcome);
                                    }
                                }
                            }
                        }
                    }
                }
                place += 1;
            }
        }
        if out.block.rows > 0 {
            self.last_s = self.time_s(pending, pending.history + out.block.rows - 1);
        }
    }

    fn finish(self, outcome: &mut CorrectOutcome) {
        outcome.duration_s = self.last_s + self.dt_s;
        for span in self.open.into_iter().flatten() {
            close(span, outcome);
        }
        outcome.changes = self
            .sums
            .into_iter()
            .map(|(axis, sum, largest, count)| Change {
                axis,
                mean: if count > 0 {
                    sum / count as f64
                } else {
                    f64::NAN
                },
                largest: if count > 0 { largest } else { f64::NAN },
            })
            .collect();
    }
}

/// Spans that are listed; the rest is counted.
const LISTED: usize = 12;

fn close(span: Saturated, outcome: &mut CorrectOutcome) {
    if outcome.spans.len() < LISTED {
        outcome.spans.push(span);
    } else {
        outcome.more_spans += 1;
    }
}

impl CorrectOutcome {
    /// The JSON document.
    pub fn to_json(&self) -> Value {
        let changes: Vec<Value> = self
            .changes
            .iter()
            .map(|c| json!({"axis": c.axis, "mean": c.mean, "largest": c.largest}))
            .collect();
        json!({
            "samples": self.samples,
            "changes": changes,
            "saturated": self.saturated,
            "outside_validity": self.outside_validity,
            "warnings": self.warnings(),
            "notes": self.notes,
        })
    }

    /// Saturated spans, samples outside validity, and what else is to be known, a sentence each.
    fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        for span in &self.spans {
            let level = if span.axis.starts_with("gyro") {
                format!(
                    "{} deg/s",
                    general(span.at * 180.0 / core::f64::consts::PI, 5)
                )
            } else {
                format!("{} g", general(span.at / 9.80665, 5))
            };
            out.push(format!(
                "{}  saturated  {}  {} samples at {level}",
                span.axis,
                clock_span(span.start_s, span.end_s),
                span.count
            ));
        }
        if self.more_spans > 0 {
            out.push(format!("{} more spans are saturated", self.more_spans));
        }
        if self.outside_validity > 0 {
            out.push(format!(
                "{} samples are outside the model's validity (temperature, bound, or not finite); --flags marks them",
                group_thousands(&self.outside_validity.to_string())
            ));
        }
        out.extend(self.warnings.iter().cloned());
        out
    }

    /// The text for a terminal.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.paragraph(format!(
            "Corrected {} samples, {}.",
            group_thousands(&self.samples.to_string()),
            duration(self.duration_s)
        ));
        let mut table = Table::new(&["channel", "mean change", "largest change", "unit"], &[]);
        for change in &self.changes {
            let (per_si, unit) = if change.axis.starts_with("gyro") {
                (180.0 / core::f64::consts::PI, "deg/s")
            } else {
                (1000.0 / 9.80665, "mg")
            };
            let number = |x: f64| {
                if x.is_finite() {
                    general(x * per_si, 4)
                } else {
                    "-".to_owned()
                }
            };
            table.row([
                change.axis.clone(),
                number(change.mean),
                number(change.largest),
                unit.to_owned(),
            ]);
        }
        out.blank().table(table).blank();
        for warning in self.warnings() {
            out.warning(warning);
        }
        for note in &self.notes {
            out.note(note.clone());
        }
        out
    }
}
