//! One run: truth through the sensor with its draws, noise and output stage, block by block.
//!
//! y = round(saturate(lowpass(b + (I + M)u + N(u) + random terms))) (model.md §2). Each axis has its
//! own generators, so that axes can be worked by several threads without a change of any sample.

#![allow(clippy::type_complexity, reason = "a tuple of one use")]
#![allow(clippy::large_stack_arrays, reason = "fixed scratch of a block")]

use rayon::prelude::*;
use sagnac_core::{
    Draw, Measurement, OffDiagonal, OutputBlock, OutputStage, Real as _, Sensor, SensorModel,
    Truth, TruthBlock,
};
use sagnac_model::Model;
use sagnac_noise::{AxisGenerator, Purpose, StreamKey, TermSet};

use super::source::TruthRows;
use crate::Error;

/// Rows to a piece of the deterministic part.
const PIECE: usize = 1024;

/// What a run is made of, the same for all runs.
pub(super) struct Recipe {
    pub(super) core: SensorModel<f64>,
    pub(super) terms: TermSet,
    pub(super) seed: u64,
    pub(super) dt_s: f64,
    pub(super) run_length_s: f64,
    /// Whether gyro and accelerometer are in the output.
    pub(super) present: [bool; 2],
    pub(super) with_drift: bool,
}

/// The samples of one axis.
struct AxisRun {
    noise: AxisGenerator,
    /// The draw of the bias, for `bias_*` of the truth.
    bias_draw: f64,
    total: Vec<f64>,
    drift: Vec<f64>,
}

/// One triad of a run.
struct SensorRun {
    sensor: Sensor,
    axes: [AxisRun; 3],
    /// Deterministic part, then the output.
    output: [Vec<f64>; 3],
    stage: Option<OutputStage<f64>>,
    limits: [f64; 3],
    clipped: [u64; 3],
    /// The random term with the largest sigma of a sample, for errors.
    loudest: [String; 3],
}

/// A run in progress.
pub(super) struct Run {
    sensors: Vec<SensorRun>,
    measurement: Measurement<f64>,
    core: SensorModel<f64>,
    dt_s: f64,
    with_drift: bool,
    /// Why a sample is no finite number.
    beyond: Option<Error>,
    /// The temperature ranges that count, and the samples outside each.
    pub(super) too_cold_or_hot: Vec<OutsideRange>,
}

/// Samples beyond one of the ranges of temperature, where the nearer end is taken.
pub(super) struct OutsideRange {
    pub(super) range_c: [f64; 2],
    /// `gyro.bias`, `accel.scale_factor` …: the terms for which it counts.
    pub(super) terms: Vec<String>,
    pub(super) count: u64,
}

/// Each range once: a term's own counts before that of the file, and that before a spline's knots.
fn ranges(core: &SensorModel<f64>) -> Vec<OutsideRange> {
    let mut out: Vec<OutsideRange> = Vec::new();
    for sensor in Sensor::ALL {
        let triad = core.triad(sensor);
        for (name, part) in [
            ("bias", &triad.bias.temperature),
            ("scale_factor", &triad.scale_factor.temperature),
        ] {
            let range = part.effective_range_c(core.temperature_range_c);
            let Some(range_c) = range.filter(|_| part.is_present()) else {
                continue;
            };
            let term = format!("{}.{name}", sensor.key());
            match out.iter_mut().find(|of| of.range_c == range_c) {
                Some(same) => same.terms.push(term),
                None => out.push(OutsideRange {
                    range_c,
                    terms: vec![term],
                    count: 0,
                }),
            }
        }
    }
    out
}

/// The draws of a run, from streams of their own.
pub(super) fn draw(model: &Model, sensor: Sensor, seed: u64, run: u32) -> Draw<f64> {
    let sigma = model.stability(sensor);
    let key = |axis: usize| StreamKey {
        seed,
        run,
        sensor: sensor.index() as u8,
        axis: axis as u8,
    };
    let scaled = |sigma: f64, axis: usize, purpose, place| {
        // A term that is zero must not turn into −0.
        if sigma == 0.0 {
            0.0
        } else {
            sigma * key(axis).draw(purpose, place)
        }
    };
    let three =
        |sigma: [f64; 3], purpose| [0, 1, 2].map(|axis| scaled(sigma[axis], axis, purpose, 0));
    let places = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
    let mut misalignment = [0.0; 6];
    for ((value, sigma), (row, column)) in
        misalignment.iter_mut().zip(sigma.misalignment).zip(places)
    {
        *value = scaled(sigma, row, Purpose::MisalignmentDraw, column);
    }
    Draw {
        bias: three(sigma.bias, Purpose::BiasDraw),
        scale_factor: three(sigma.scale_factor, Purpose::ScaleFactorDraw),
        misalignment: OffDiagonal::from_array(misalignment),
    }
}

impl Run {
    /// Run number `run`, from 1.
    pub(super) fn new(model: &Model, recipe: &Recipe, run: u32) -> Result<Self, Error> {
        let draws = Sensor::ALL.map(|sensor| {
            if recipe.terms.has("stability") {
                draw(model, sensor, recipe.seed, run)
            } else {
                Draw::default()
            }
        });
        let mut core = recipe.core.with_draws(&draws[0], &draws[1]);
        if !recipe.present[0] {
            core = core.without_gyro();
        }
        if !recipe.present[1] {
            core = core.without_accel();
        }
        let mut sensors = Vec::new();
        for (sensor, draw) in Sensor::ALL.into_iter().zip(&draws) {
            if !recipe.present[sensor.index()] {
                continue;
            }
            let triad = core.triad(sensor);
            let axis = |axis: usize| {
                let key = StreamKey {
                    seed: recipe.seed,
                    run,
                    sensor: sensor.index() as u8,
                    axis: axis as u8,
                };
                Ok::<_, Error>(AxisRun {
                    noise: AxisGenerator::new(
                        &model.axis_noise(sensor, axis),
                        recipe.terms,
                        recipe.dt_s,
                        recipe.run_length_s,
                        key,
                    )
                    .map_err(|error| {
                        Error::from(error).at(format!(
                            "{}, {} {}",
                            model.label(),
                            sensor.key(),
                            ["x", "y", "z"][axis]
                        ))
                    })?,
                    bias_draw: draw.bias[axis],
                    total: Vec::new(),
                    drift: Vec::new(),
                })
            };
            sensors.push(SensorRun {
                sensor,
                axes: [axis(0)?, axis(1)?, axis(2)?],
                output: Default::default(),
                stage: None,
                limits: [0, 1, 2].map(|axis| {
                    let limit = triad.range.limit[axis];
                    triad.resolution.largest_output(axis, limit, recipe.dt_s) * (1.0 - 1e-9)
                }),
                clipped: [0; 3],
                loudest: [0, 1, 2].map(|axis| {
                    let at = Truth::default();
                    let terms = crate::explain::random(model, sensor, axis, recipe.dt_s, &at);
                    let mut in_run = terms
                        .into_iter()
                        .filter(|(n, _)| !n.ends_with(".stability"));
                    let name = in_run
                        .next()
                        .map_or_else(|| "noise".to_owned(), |(name, _)| name);
                    name.trim_end_matches(", after 1 h").to_owned()
                }),
            });
        }
        Ok(Self {
            sensors,
            measurement: Measurement::new(&core),
            too_cold_or_hot: ranges(&core),
            core,
            dt_s: recipe.dt_s,
            with_drift: recipe.with_drift,
            beyond: None,
        })
    }

    /// The sensor's output for these rows.
    pub(super) fn advance(&mut self, truth: &TruthRows) {
        self.deterministic(truth);
        let with_drift = self.with_drift;
        self.sensors.par_iter_mut().for_each(|sensor| {
            sensor.axes.par_iter_mut().for_each(|axis| {
                axis.total.resize(truth.rows, 0.0);
                if with_drift {
                    axis.drift.resize(truth.rows, 0.0);
                    axis.noise.fill(&mut axis.total, Some(&mut axis.drift));
                } else {
                    axis.noise.fill(&mut axis.total, None);
                }
            });
        });
        let (core, dt_s) = (&self.core, self.dt_s);
        self.sensors
            .par_iter_mut()
            .for_each(|sensor| sensor.put_out(core, dt_s));
        if self.beyond.is_none() {
            self.beyond = self
                .sensors
                .iter()
                .find_map(|s| s.beyond(core, truth, dt_s));
        }
        for of in &mut self.too_cold_or_hot {
            let [low, high] = of.range_c;
            of.count += truth
                .temperature
                .iter()
                .filter(|t| !(low..=high).contains(*t))
                .count() as u64;
        }
    }

    /// Refuses samples that are no finite numbers.
    pub(super) fn check(&mut self) -> Result<(), Error> {
        self.beyond.take().map_or(Ok(()), Err)
    }

    /// b + (I + M)u + N(u) of every row.
    fn deterministic(&mut self, truth: &TruthRows) {
        let measurement = &self.measurement;
        if truth.is_constant {
            let reading = measurement.corrupt(&sample(truth, 0));
            for sensor in &mut self.sensors {
                let value = [reading.gyro, reading.accel][sensor.sensor.index()];
                for (column, value) in sensor.output.iter_mut().zip(value) {
                    column.clear();
                    column.resize(truth.rows, value);
                }
            }
            return;
        }
        for column in self
            .sensors
            .iter_mut()
            .flat_map(|sensor| &mut sensor.output)
        {
            column.resize(truth.rows, 0.0);
        }
        // A triad that is not in the output goes to room of its own.
        let mut spare: [Vec<f64>; 3] = Default::default();
        if self.sensors.len() < 2 {
            for column in &mut spare {
                column.resize(truth.rows, 0.0);
            }
        }
        let mut triads = [None, None];
        for sensor in &mut self.sensors {
            triads[sensor.sensor.index()] = Some(&mut sensor.output);
        }
        let [gyro, accel] = triads;
        let (gyro, accel) = match (gyro, accel) {
            (Some(gyro), Some(accel)) => (gyro, accel),
            (Some(gyro), None) => (gyro, &mut spare),
            (None, Some(accel)) => (&mut spare, accel),
            (None, None) => return,
        };
        let ([gx, gy, gz], [ax, ay, az]) = (gyro, accel);
        let gyro = [gx, gy, gz].map(|column| column.chunks_mut(PIECE));
        let accel = [ax, ay, az].map(|column| column.chunks_mut(PIECE));
        let [gx, gy, gz] = gyro;
        let [ax, ay, az] = accel;
        let pieces: Vec<_> = (gx.zip(gy).zip(gz))
            .zip(ax.zip(ay).zip(az))
            .map(|(((gx, gy), gz), ((ax, ay), az))| OutputBlock {
                gyro: [gx, gy, gz],
                accel: [ax, ay, az],
            })
            .collect();
        pieces
            .into_par_iter()
            .enumerate()
            .for_each(|(piece, mut output)| {
                let first = piece * PIECE;
                measurement.corrupt_block(
                    &TruthBlock {
                        specific_force: from(&truth.force, first),
                        angular_rate: from(&truth.rate, first),
                        angular_acceleration: Some(from(&truth.rate_dot, first)),
                        temperature_c: truth.temperature.get(first..),
                    },
                    &mut output,
                );
            });
    }

    /// Whether gyro and accelerometer are in it.
    pub(super) fn present(&self) -> [bool; 2] {
        Sensor::ALL.map(|sensor| self.sensors.iter().any(|run| run.sensor == sensor))
    }

    /// The output columns, gyro before accelerometer.
    pub(super) fn columns(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.sensors.iter().flat_map(|sensor| &sensor.output)
    }

    /// Draw plus in-run drift, gyro before accelerometer.
    pub(super) fn biases(&self) -> impl Iterator<Item = Vec<f64>> {
        self.sensors
            .iter()
            .flat_map(|sensor| &sensor.axes)
            .map(|axis| {
                axis.drift
                    .iter()
                    .map(|drift| axis.bias_draw + drift)
                    .collect()
            })
    }

    /// Samples at the end of the range, by channel.
    pub(super) fn clipped(&self) -> impl Iterator<Item = (String, u64, f64)> {
        self.sensors.iter().flat_map(|sensor| {
            (0..3).map(move |axis| {
                let name = format!("{}_{}", sensor.sensor.key(), ["x", "y", "z"][axis]);
                (name, sensor.clipped[axis], sensor.limits[axis])
            })
        })
    }
}

/// The rows of three channels from `first` on.
fn from(channels: &[Vec<f64>; 3], first: usize) -> [&[f64]; 3] {
    channels.each_ref().map(|c| c.get(first..).unwrap_or(&[]))
}

/// Adds the noise (none where it is empty), clamps to ±`range`, and counts samples from `limit` on.
fn add_and_clamp(column: &mut [f64], noise: &[f64], range: f64, limit: f64) -> u64 {
    for (value, noise) in column.iter_mut().zip(noise) {
        *value += noise;
    }
    let mut clipped = 0;
    if range.is_finite() {
        for value in column {
            *value = value.held(-range, range);
            clipped += u64::from(value.abs() >= limit);
        }
    }
    clipped
}

/// The truth of one row.
fn sample(truth: &TruthRows, k: usize) -> Truth<f64> {
    Truth {
        specific_force: [0, 1, 2].map(|axis| truth.force[axis][k]),
        angular_rate: [0, 1, 2].map(|axis| truth.rate[axis][k]),
        angular_acceleration: [0, 1, 2].map(|axis| truth.rate_dot[axis][k]),
        temperature_c: truth.temperature[k],
    }
}

/// Whether any value is infinite or NaN; without a jump, in vector instructions.
fn any_beyond(column: &[f64]) -> bool {
    column
        .iter()
        .fold(false, |any, value| any | !value.is_finite())
}

impl SensorRun {
    /// The first output that is no finite number, with its term.
    fn beyond(&self, core: &SensorModel<f64>, truth: &TruthRows, dt_s: f64) -> Option<Error> {
        let axis = self.output.iter().position(|column| any_beyond(column))?;
        let row = self.output[axis]
            .iter()
            .position(|value| !value.is_finite())?;
        let key = self.sensor.key();
        let at = sample(truth, row);
        let lsb = core.triad(self.sensor).resolution.lsb[axis];
        let term = crate::explain::beyond_every_number(core, self.sensor, &at, dt_s);
        // Steps so small that not even 1 rad/s or 1 m/s² of them can be counted.
        let (term, what) = if term.is_none() && lsb > 0.0 && !(1.0 / lsb).is_finite() {
            ("resolution", "small")
        } else {
            (term.unwrap_or(&self.loudest[axis]), "large")
        };
        let time_s = truth
            .stamps
            .get(row)
            .map_or(f64::NAN, sagnac_log::Stamp::seconds);
        Some(
            Error::data(format!(
                "{key}_{} is beyond every number at {} s: {key}.{term} is too {what}",
                ["x", "y", "z"][axis],
                sagnac_report::text::general(time_s, 9)
            ))
            .advise("look for a wrong unit of that term"),
        )
    }

    /// Adds the random terms and passes the sum through low-pass, saturation and rounding.
    fn put_out(&mut self, core: &SensorModel<f64>, dt_s: f64) {
        let [x, y, z] = &mut self.output;
        if x.is_empty() {
            return;
        }
        let triad = core.triad(self.sensor);
        if !triad.bandwidth.is_present() && !triad.resolution.is_present() {
            // A sample depends on no other one: axis by axis, in vector instructions.
            for (axis, column) in [x, y, z].into_iter().enumerate() {
                let (range, limit) = (triad.range.limit[axis], self.limits[axis]);
                let noise = &self.axes[axis].noise;
                let total: &[f64] = if noise.is_silent() {
                    &[]
                } else {
                    &self.axes[axis].total
                };
                self.clipped[axis] += add_and_clamp(column, total, range, limit);
            }
            return;
        }
        let stage = self
            .stage
            .get_or_insert_with(|| OutputStage::new(triad, dt_s, [x[0], y[0], z[0]]));
        for (column, axis) in [&mut *x, &mut *y, &mut *z].into_iter().zip(&self.axes) {
            if !axis.noise.is_silent() {
                for (value, noise) in column.iter_mut().zip(&axis.total) {
                    *value += noise;
                }
            }
        }
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            let out = stage.next_sample([*x, *y, *z]);
            [*x, *y, *z] = out;
            for axis in 0..3 {
                self.clipped[axis] += u64::from(out[axis].abs() >= self.limits[axis]);
            }
        }
    }
}
