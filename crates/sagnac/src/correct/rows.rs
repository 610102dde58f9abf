//! The rows of a log on their way through the inverse, in constant memory.

#![allow(clippy::type_complexity, reason = "a tuple of one use")]
#![allow(clippy::large_types_passed_by_value, reason = "moved once")]

use sagnac_core::{Compensation, CorrectedBlock, ReadingBlock, Sensor, SensorModel, flags};
use sagnac_log::Block;
use sagnac_report::text::{general, group_thousands};

use super::{Change, Columns, CorrectOutcome, CorrectRequest, Saturated};
use crate::clock::RowClock;
use crate::simulate::slopes;

/// Rows that are read and not yet written, and two written ones before them.
pub(super) struct Pending {
    block: Block,
    times_s: Vec<f64>,
    clock: RowClock,
    /// Rows at the start that are written already.
    history: usize,
}

impl Pending {
    pub(super) fn new(columns: usize, clock: RowClock) -> Self {
        Self {
            block: Block::with_columns(columns),
            times_s: Vec::new(),
            clock,
            history: 0,
        }
    }

    pub(super) fn push(&mut self, more: &Block) {
        let written = self.block.stamps.len();
        for row in 0..more.rows {
            self.times_s.push(self.clock.next(more.stamps.get(row)));
        }
        self.block.append(more);
        if self.clock.note().is_some() {
            self.block.stamps.keep(0..written);
            let times_s = &self.times_s[self.times_s.len() - more.rows..];
            for (row, &at_s) in times_s.iter().enumerate() {
                if let Some(stamp) = self.clock.written(more.stamps.get(row), at_s) {
                    self.block.stamps.push(stamp);
                }
            }
        }
    }

    pub(super) fn done(&mut self, ready: usize) {
        let written = self.history + ready;
        let keep_from = written.saturating_sub(2);
        self.block.keep(keep_from..self.block.rows);
        self.times_s.drain(..keep_from);
        self.history = written - keep_from;
    }

    pub(super) fn clock(&self) -> &RowClock {
        &self.clock
    }
}

pub(super) struct Out {
    pub(super) block: Block,
    flags: Vec<u32>,
}

/// The flags of samples outside validity.
const KINDS: [u32; 3] = [
    flags::TEMPERATURE,
    flags::OUTSIDE_VALIDITY,
    flags::NOT_FINITE,
];

/// The inverse at work, and what it has met so far.
pub(super) struct Work {
    inverse: Compensation<f64>,
    columns: Columns,
    needs_slope: bool,
    dt_s: f64,
    reference_c: f64,
    last_s: f64,
    /// Samples with each of [`KINDS`].
    outside: [u64; 3],
    /// Largest |y| of gyro and accelerometer among samples outside validity.
    peaks: [f64; 2],
    sums: Vec<(String, f64, f64, u64)>,
    open: Vec<Option<Saturated>>,
}

impl Work {
    pub(super) fn new(
        core: &SensorModel<f64>,
        inverse: Compensation<f64>,
        columns: Columns,
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
            dt_s,
            reference_c: core.reference_temperature_c,
            last_s: 0.0,
            outside: [0; 3],
            peaks: [0.0; 2],
            open: vec![None; sums.len()],
            sums,
        }
    }

    /// Whether ω̇ is the slope of the corrected rates.
    pub(super) fn needs_slope(&self) -> bool {
        self.needs_slope
    }

    /// How many rows behind the written ones can be corrected.
    pub(super) fn ready(&self, pending: &Pending, is_end: bool) -> usize {
        let waiting = pending.block.rows - pending.history;
        if is_end || !self.needs_slope {
            waiting
        } else {
            // A row at the start of a stretch waits for two more.
            waiting.saturating_sub(2)
        }
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

    pub(super) fn rows(&self, pending: &Pending, ready: usize, request: CorrectRequest) -> Out {
        let (mut w, mut f, mut marks) = self.run(pending, None);
        if self.needs_slope {
            let span = pending.history..pending.history + ready;
            let rate = w.each_ref().map(|w| {
                let mut rate = vec![0.0; span.start];
                slopes(&pending.times_s, w, self.dt_s, span.clone(), &mut rate);
                rate.resize(pending.block.rows, 0.0);
                rate
            });
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

    pub(super) fn count(&mut self, pending: &Pending, out: &Out, outcome: &mut CorrectOutcome) {
        outcome.samples += out.block.rows as u64;
        for (i, mark) in out.flags.iter().enumerate() {
            outcome.saturated +=
                u64::from(mark & (flags::GYRO_SATURATED | flags::ACCEL_SATURATED) != 0);
            let outside = mark & (flags::TEMPERATURE | flags::OUTSIDE_VALIDITY | flags::NOT_FINITE);
            outcome.outside_validity += u64::from(outside != 0);
            for (count, bit) in self.outside.iter_mut().zip(KINDS) {
                *count += u64::from(mark & bit != 0);
            }
            if mark & flags::OUTSIDE_VALIDITY != 0 {
                let raw = [self.columns.gyro, self.columns.accel];
                for (peak, of) in self.peaks.iter_mut().zip(raw) {
                    for at in of.into_iter().flatten() {
                        let value = pending
                            .block
                            .columns
                            .get(at)
                            .map_or(0.0, |c| c[pending.history + i]);
                        if value.abs() > *peak && value.is_finite() {
                            *peak = value.abs();
                        }
                    }
                }
            }
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
                        let time_s = pending.times_s[row];
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
        // Where time only runs back, the first row is the last.
        let rows = pending.history..pending.history + out.block.rows;
        for time_s in pending.times_s.get(rows).unwrap_or(&[]) {
            self.last_s = self.last_s.max(time_s + self.dt_s);
        }
    }

    /// Why samples are outside validity, in one sentence; q where the bound was not known
    /// before the samples were.
    fn tell_outside(&self, outcome: &mut CorrectOutcome) {
        let [temperature, validity, not_finite] = self.outside;
        let mut why: Vec<(u64, String)> = Vec::new();
        if temperature > 0 {
            why.push((
                temperature,
                "outside the temperature range of the model: the nearer end is taken".to_owned(),
            ));
        }
        // A model outside at every sample is told before the first one.
        let always = self.inverse.bound().is_some_and(|bound| !bound.is_inside());
        if validity > 0 && !always {
            let [gyro, accel] = self.peaks;
            let bound = self.inverse.bound_at(
                self.inverse.range(Sensor::Gyro).unwrap_or(gyro),
                self.inverse.range(Sensor::Accel).unwrap_or(accel),
            );
            let reason = if self.inverse.bound().is_none() && !bound.is_inside() {
                let sum = (bound.mu[0] + bound.nu[0] + bound.delta).max(bound.mu[1] + bound.nu[1]);
                format!(
                    "outside the convergence bound ({}, {}), which a range in the model would tell before",
                    stated("q", "up to", bound.q),
                    stated("mu + nu", "up to", sum)
                )
            } else {
                "outside the validity of the model (its output range, or -40 to 85 degC where it states no temperature_range)".to_owned()
            };
            why.push((
                validity,
                format!("{reason}: no bound holds for the correction"),
            ));
        }
        if not_finite > 0 {
            why.push((
                not_finite,
                "without a number that is needed, or beyond every number: the result is not a number"
                    .to_owned(),
            ));
        }
        let samples = |count: u64| match count {
            1 => "1 sample is".to_owned(),
            n => format!("{} samples are", group_thousands(&n.to_string())),
        };
        let sentence = match why.as_slice() {
            [] => return,
            [(count, reason)] => format!("{} {reason}", samples(*count)),
            several => {
                let parts: Vec<String> = several
                    .iter()
                    .map(|(count, reason)| {
                        format!("{} {reason}", group_thousands(&count.to_string()))
                    })
                    .collect();
                format!(
                    "{} outside the model's validity: {}",
                    samples(outcome.outside_validity),
                    parts.join("; ")
                )
            }
        };
        outcome
            .warnings
            .push(format!("{sentence}; --flags marks them"));
    }

    pub(super) fn finish(mut self, outcome: &mut CorrectOutcome) {
        outcome.duration_s = self.last_s;
        for span in self.open.iter_mut().filter_map(Option::take) {
            close(span, outcome);
        }
        self.tell_outside(outcome);
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

/// `q up to 0.62`; what is beyond every number is said to be so.
pub(super) fn stated(name: &str, how: &str, value: f64) -> String {
    if value.is_finite() {
        format!("{name} {how} {}", general(value, 3))
    } else {
        format!("{name} not finite")
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
