//! One run of a Monte Carlo: a sensor with its own draws, its noise, output stage and correction, y = c(q(s(m(u) + n))).
//!
//! Run r uses the streams of run r of `simulate --runs`.

use super::Request;
use super::stage::Stage;
use super::truth::Channels;
use crate::Error;
use crate::sensor::{Calibration, Correlated};
use sagnac_core::{
    Axis, Compensation, CorrectedBlock, Draw, Measurement, OffDiagonal, OutputBlock, ReadingBlock,
    Sensor, SensorModel, TruthBlock, flags,
};
use sagnac_noise::{AxisGenerator, FlickerGenerator, Purpose, Ramp, StreamKey, TermSet};

/// Samples worked at once, a frame of the generators: a block of all channels stays in the second cache.
pub(super) const BLOCK: usize = sagnac_noise::FRAME;
/// Room for one channel of a block; a little more than its samples, so that channels do not all fall on the same places
/// of the first cache.
const ROW: usize = BLOCK + 8;

/// Corrected output of one run: gyro x, y, z, accelerometer x, y, z.
pub(super) type Rows = [[f64; ROW]; 6];
pub(super) const EMPTY: Rows = [[0.0; ROW]; 6];

/// One run's sensor.
pub(super) struct Unit {
    forward: Measurement<f64>,
    stages: [Stage; 2],
    /// Terms that are stationary, and those that start from zero at t = 0.
    stationary: Vec<AxisGenerator>,
    growing: Vec<AxisGenerator>,
    ramp: [f64; 6],
    time_s: f64,
}

#[repr(align(64))]
pub(super) struct Scratch {
    output: Rows,
    noise: sagnac_noise::Scratch,
    flags: [u32; BLOCK],
}

impl Scratch {
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            output: EMPTY,
            noise: sagnac_noise::Scratch::default(),
            flags: [0; BLOCK],
        })
    }
}

fn set(names: &[&str]) -> TermSet {
    names
        .iter()
        .fold(TermSet::NONE, |s, n| s.with(n).unwrap_or(s))
}

impl Unit {
    pub(super) fn new(
        request: &Request<'_>,
        run: u32,
        factors: &[Vec<f64>],
        flicker: &mut Option<FlickerGenerator>,
    ) -> Result<Self, Error> {
        let sensor = request.sensor;
        let key = |s: usize, a: usize| StreamKey {
            seed: request.seed,
            run,
            sensor: s as u8,
            axis: a as u8,
        };
        let mut model = sensor.model;
        if request.setting.calibration != Calibration::Perfect {
            let general = key(0, 0);
            for (i, u) in sensor.uncertain.iter().enumerate() {
                shift(
                    &mut model,
                    u.parameter,
                    u.sigma * general.draw(Purpose::Other, 100 + i as u32),
                );
            }
            let mut place = 10_000;
            for (block, factor) in sensor.correlated.iter().zip(factors) {
                let n = block.parameters.len();
                let draws: Vec<f64> = (0..n)
                    .map(|i| general.draw(Purpose::Other, place + i as u32))
                    .collect();
                place += n as u32;
                for (i, (_, parameter)) in block.parameters.iter().enumerate() {
                    let value: f64 = (0..=i).map(|j| factor[i * n + j] * draws[j]).sum();
                    shift(&mut model, *parameter, value);
                }
            }
        }
        let draw = |s: usize| Draw {
            bias: std::array::from_fn(|a| {
                sensor.bias_stability[s][a] * key(s, a).draw(Purpose::BiasDraw, 0)
            }),
            scale_factor: std::array::from_fn(|a| {
                sensor.scale_factor_stability[s][a] * key(s, a).draw(Purpose::ScaleFactorDraw, 0)
            }),
            misalignment: OffDiagonal::from_array(std::array::from_fn(|e| {
                let element = sagnac_core::Element::ALL[e];
                sensor.misalignment_stability[s][e]
                    * key(s, element.row().index())
                        .draw(Purpose::MisalignmentDraw, element.column().index() as u32)
            })),
        };
        model = model.with_draws(&draw(0), &draw(1));
        let (mut stationary, mut growing, mut ramp) = (Vec::new(), Vec::new(), [0.0; 6]);
        for s in 0..2 {
            for a in 0..3 {
                let mut noise = sensor.noise[s][a].clone();
                ramp[3 * s + a] = noise.ramp.slope.abs() * key(s, a).draw(Purpose::Other, 1);
                noise.ramp = Ramp::default();
                let mut make = |terms: TermSet| {
                    AxisGenerator::with_flicker(
                        &noise,
                        terms,
                        request.setting.dt_s,
                        request.setting.duration_s,
                        key(s, a),
                        flicker,
                    )
                    .map_err(|e| Error::Request {
                        what: e.to_string(),
                        advice: String::new(),
                    })
                };
                stationary.push(make(set(&[
                    "white",
                    "quantization",
                    "flicker",
                    "gauss_markov",
                    "resonance",
                    "sinusoid",
                ]))?);
                growing.push(make(set(&["random_walk"]))?);
            }
        }
        let dt_s = request.setting.dt_s;
        let stages = [
            Stage::new(&model.gyro, dt_s),
            Stage::new(&model.accel, dt_s),
        ];
        Ok(Self {
            forward: Measurement::new(&model),
            stages,
            stationary,
            growing,
            ramp,
            time_s: 0.0,
        })
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "a place in the truth, what corrects it, and where the results go"
    )]
    /// Corrected output of one block; returns how many values were clipped and how many samples are not valid.
    pub(super) fn block(
        &mut self,
        truth: &Channels,
        from: usize,
        count: usize,
        correct: Option<&Compensation<f64>>,
        dt_s: f64,
        prelude: bool,
        scratch: &mut Scratch,
        corrected: &mut Rows,
    ) -> (u64, u64) {
        let to = from + count;
        let [gx, gy, gz, ax, ay, az] = &mut scratch.output;
        self.forward.corrupt_block(
            &TruthBlock {
                specific_force: std::array::from_fn(|i| &truth.force[i][from..to]),
                angular_rate: std::array::from_fn(|i| &truth.rate[i][from..to]),
                angular_acceleration: Some(std::array::from_fn(|i| &truth.rate_dot[i][from..to])),
                temperature_c: Some(&truth.temperature[from..to]),
            },
            &mut OutputBlock {
                gyro: [&mut gx[..count], &mut gy[..count], &mut gz[..count]],
                accel: [&mut ax[..count], &mut ay[..count], &mut az[..count]],
            },
        );
        for channel in 0..6 {
            let out = &mut scratch.output[channel][..count];
            let growing = (!prelude).then_some(&mut self.growing[channel]);
            for generator in std::iter::once(&mut self.stationary[channel]).chain(growing) {
                if !generator.is_silent() {
                    generator.add_to(out, &mut scratch.noise);
                }
            }
            if !prelude && self.ramp[channel] != 0.0 {
                for (i, o) in out.iter_mut().enumerate() {
                    *o += self.ramp[channel] * (self.time_s + (i as f64 + 0.5) * dt_s);
                }
            }
        }
        if !prelude {
            self.time_s += count as f64 * dt_s;
        }
        let mut clipped = 0;
        for (s, stage) in self.stages.iter_mut().enumerate() {
            if let Some([x, y, z]) = scratch.output.get_mut(3 * s..3 * s + 3) {
                clipped += stage.block([&mut x[..count], &mut y[..count], &mut z[..count]]);
            }
        }
        let Some(correct) = correct else {
            for (to, from) in corrected.iter_mut().zip(&scratch.output) {
                to[..count].copy_from_slice(&from[..count]);
            }
            return (clipped, 0);
        };
        let raw = &scratch.output;
        let [gx, gy, gz, ax, ay, az] = corrected;
        correct.correct_block(
            &ReadingBlock {
                gyro: [&raw[0][..count], &raw[1][..count], &raw[2][..count]],
                accel: [&raw[3][..count], &raw[4][..count], &raw[5][..count]],
                gyro_rate: Some(std::array::from_fn(|i| &truth.rate_dot[i][from..to])),
                temperature_c: Some(&truth.temperature[from..to]),
            },
            &mut CorrectedBlock {
                gyro: [&mut gx[..count], &mut gy[..count], &mut gz[..count]],
                accel: [&mut ax[..count], &mut ay[..count], &mut az[..count]],
                flags: &mut scratch.flags[..count],
            },
        );
        let invalid = scratch.flags[..count]
            .iter()
            .filter(|f| **f & (flags::OUTSIDE_VALIDITY | flags::NOT_FINITE) != 0)
            .count();
        (clipped, invalid as u64)
    }
}

/// Adds a value to a parameter of the deterministic model.
fn shift(model: &mut SensorModel<f64>, parameter: crate::covariance::Parameter, value: f64) {
    use crate::covariance::Parameter as P;
    macro_rules! triad {
        ($sensor:expr) => {
            match $sensor {
                Sensor::Gyro => &mut model.gyro,
                Sensor::Accel => &mut model.accel,
            }
        };
    }
    let a = |axis: Axis| axis.index();
    match parameter {
        P::Bias {
            sensor,
            axis,
            power: 0,
        } => triad!(sensor).bias.fixed[a(axis)] += value,
        P::Bias {
            sensor,
            axis,
            power,
        } => {
            if let Some(row) = triad!(sensor)
                .bias
                .temperature
                .polynomial
                .get_mut(usize::from(power) - 1)
            {
                row[a(axis)] += value;
            }
        }
        P::ScaleFactor {
            sensor,
            axis,
            power: 0,
        } => triad!(sensor).scale_factor.fixed[a(axis)] += value,
        P::ScaleFactor {
            sensor,
            axis,
            power,
        } => {
            if let Some(row) = triad!(sensor)
                .scale_factor
                .temperature
                .polynomial
                .get_mut(usize::from(power) - 1)
            {
                row[a(axis)] += value;
            }
        }
        P::Quadratic { sensor, axis } => triad!(sensor).nonlinearity.quadratic[a(axis)] += value,
        P::Cubic { sensor, axis } => triad!(sensor).nonlinearity.cubic[a(axis)] += value,
        P::Asymmetry { sensor, axis } => triad!(sensor).asymmetry.difference[a(axis)] += value,
        P::OffDiagonal { sensor, element } => {
            let mut add = [0.0; 6];
            add[element.index()] = value;
            let m = &mut triad!(sensor).misalignment.elements;
            *m = m.plus(&OffDiagonal::from_array(add));
        }
        P::GSensitivity { row, column } => {
            model.gyro_g_sensitivity.matrix[a(row)][a(column)] += value;
        }
        P::G2Sensitivity { row, product } => {
            model.gyro_g2_sensitivity.matrix[a(row)][usize::from(product).min(5)] += value;
        }
        P::AxisOffset { accel, component } => {
            model.accel_axis_offset.position[a(accel)][a(component)] += value;
        }
    }
}

/// Lower Cholesky factor of a covariance, row by row; zero pivots (a parameter without error) give zero columns.
pub(super) fn cholesky(block: &Correlated) -> Vec<f64> {
    let n = block.parameters.len();
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = block.covariance[i * n + j];
            for k in 0..j {
                sum -= l[i * n + k] * l[j * n + k];
            }
            if i == j {
                l[i * n + i] = sum.max(0.0).sqrt();
            } else if l[j * n + j] > 0.0 {
                l[i * n + j] = sum / l[j * n + j];
            }
        }
    }
    l
}
