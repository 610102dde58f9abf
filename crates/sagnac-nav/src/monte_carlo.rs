//! Drift by Monte Carlo: the whole nonlinear sensor (draws, random terms, range, rounding), its correction and the
//! strapdown at full rate, eight runs to a vector (navigation.md §3.1).
//!
//! Run r uses the streams of run r of `simulate --runs`; the result does not depend on threads.

use crate::Error;
use crate::attitude::{
    Vec3, from_rotation_vector, mul, mul_vec, mul_vec_t, sub, to_rotation_vector, transpose,
};
use crate::covariance::{SELF_ALIGNMENT_S, report_times_s};
use crate::drift::{Alignment, Setting};
use crate::ellipse::{Sampled, quantile, rms};
use crate::sensor::{Calibration, Correlated, SensorErrors};
use crate::strapdown::{Sculling, State, Strapdown};
use crate::trajectory::{Trajectory, TruthSample};
use rayon::prelude::*;
use sagnac_core::{
    Axis, Compensation, CorrectedBlock, Draw, Measurement, OffDiagonal, OutputBlock, OutputStage,
    ReadingBlock, Sensor, SensorModel, TruthBlock, flags,
};
use sagnac_noise::{AxisGenerator, Purpose, Ramp, StreamKey, TermSet};

/// Runs stepped together.
const LANES: usize = 8;
/// Samples worked at once: a block of all channels stays in the second cache.
const BLOCK: usize = 256;
/// Samples of truth held at once.
const SEGMENT: usize = 1 << 17;

/// What a Monte Carlo is asked.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The motion.
    pub trajectory: &'a Trajectory,
    /// Length, rate, alignment …
    pub setting: Setting,
    /// Form of the strapdown.
    pub sculling: Sculling,
    /// The sensor.
    pub sensor: &'a SensorErrors,
    /// Runs.
    pub runs: u32,
    /// Seed.
    pub seed: u64,
}

/// Errors of every run at the report times.
#[derive(Debug, Clone, PartialEq)]
pub struct MonteCarloDrift {
    /// Report times, s.
    pub time_s: Vec<f64>,
    /// `errors[time][run]`: position, velocity, attitude in north, east, down.
    pub errors: Vec<Vec<[f64; 9]>>,
    /// Samples that a range cut off, all runs and axes.
    pub clipped: u64,
    /// Samples outside the validity of the correction.
    pub outside_validity: u64,
}

impl MonteCarloDrift {
    fn radii(&self, time: usize) -> Vec<f64> {
        let mut out: Vec<f64> = self.errors[time].iter().map(|e| e[0].hypot(e[1])).collect();
        out.sort_by(f64::total_cmp);
        out
    }

    /// CEP (the median) at each time; `tail` in each tail of the interval, 0.025 for 95 %.
    pub fn cep(&self, tail: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| quantile(&self.radii(i), 0.5, tail))
            .collect()
    }

    /// R95 at each time.
    pub fn r95(&self, tail: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| quantile(&self.radii(i), 0.95, tail))
            .collect()
    }

    /// RMS of the horizontal error at each time; `z` = 1.96 for 95 %.
    pub fn rms(&self, z: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| rms(&self.radii(i), z))
            .collect()
    }

    /// RMS of component `i` (north, east, down; velocities; ε) at each time.
    pub fn rms_of(&self, i: usize) -> Vec<f64> {
        self.errors
            .iter()
            .map(|e| (e.iter().map(|x| x[i] * x[i]).sum::<f64>() / e.len() as f64).sqrt())
            .collect()
    }

    /// Whether the errors were small enough for linear numbers: RMS attitude up to 0.1 rad, RMS position up to 100 km.
    pub fn is_linear(&self) -> bool {
        let attitude: Vec<Vec<f64>> = (6..9).map(|i| self.rms_of(i)).collect();
        (0..self.time_s.len()).all(|t| {
            let a =
                (attitude[0][t].powi(2) + attitude[1][t].powi(2) + attitude[2][t].powi(2)).sqrt();
            a <= 0.1 && self.rms(1.96)[t].value_m <= 1e5
        })
    }
}

/// Truth by channel.
#[derive(Default)]
struct Channels {
    force: [Vec<f64>; 3],
    rate: [Vec<f64>; 3],
    rate_dot: [Vec<f64>; 3],
    temperature: Vec<f64>,
    vertical: Vec<[f64; 2]>,
}

impl Channels {
    fn of(samples: &[TruthSample], dt_s: f64, temperature: &(dyn Fn(f64) -> f64 + Sync)) -> Self {
        let channel = |get: fn(&TruthSample) -> Vec3| {
            std::array::from_fn(|i| samples.iter().map(|s| get(s)[i]).collect())
        };
        Self {
            force: channel(|s| s.force_m_s2),
            rate: channel(|s| s.rate_rad_s),
            rate_dot: channel(|s| s.rate_dot_rad_s2),
            temperature: samples
                .iter()
                .map(|s| temperature(s.time_s - 0.5 * dt_s))
                .collect(),
            vertical: samples.iter().map(|s| [s.height_m, s.climb_m_s]).collect(),
        }
    }
}

/// One run's sensor.
struct Unit {
    forward: Measurement<f64>,
    stages: Option<[OutputStage<f64>; 2]>,
    /// Terms that are stationary, and those that start from zero at t = 0.
    stationary: Vec<AxisGenerator>,
    growing: Vec<AxisGenerator>,
    ramp: [f64; 6],
    limit: [[f64; 3]; 2],
    time_s: f64,
}

struct Scratch {
    output: [[f64; BLOCK]; 6],
    corrected: [[f64; BLOCK]; 6],
    noise: [f64; BLOCK],
    flags: [u32; BLOCK],
}

impl Scratch {
    fn new() -> Box<Self> {
        Box::new(Self {
            output: [[0.0; BLOCK]; 6],
            corrected: [[0.0; BLOCK]; 6],
            noise: [0.0; BLOCK],
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
    fn new(
        request: &Request<'_>,
        run: u32,
        settled: &TruthSample,
        factors: &[Vec<f64>],
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
                let make = |terms: TermSet| {
                    AxisGenerator::new(
                        &noise,
                        terms,
                        request.setting.dt_s,
                        request.setting.duration_s,
                        key(s, a),
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
        // The low-pass is a matter of time tags and is left out of both methods.
        let mut output = model;
        output.gyro.bandwidth = sagnac_core::Triad::default().bandwidth;
        output.accel.bandwidth = sagnac_core::Triad::default().bandwidth;
        let forward = Measurement::new(&model);
        let truth = sagnac_core::Truth {
            specific_force: settled.force_m_s2,
            angular_rate: settled.rate_rad_s,
            ..sagnac_core::Truth::default()
        };
        let first = forward.corrupt(&truth);
        let stages = [
            OutputStage::new(&output.gyro, request.setting.dt_s, first.gyro),
            OutputStage::new(&output.accel, request.setting.dt_s, first.accel),
        ];
        let transparent = stages.iter().all(OutputStage::is_transparent);
        Ok(Self {
            forward,
            stages: (!transparent).then_some(stages),
            stationary,
            growing,
            ramp,
            limit: [model.gyro.range.limit, model.accel.range.limit],
            time_s: 0.0,
        })
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "a place in the truth, what corrects it, and where the results go"
    )]
    /// Corrected output of one block; returns how many values were clipped and how many samples are not valid.
    fn block(
        &mut self,
        truth: &Channels,
        from: usize,
        count: usize,
        correct: Option<&Compensation<f64>>,
        dt_s: f64,
        prelude: bool,
        scratch: &mut Scratch,
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
            let out = &mut scratch.output[channel];
            let noise = &mut scratch.noise[..count];
            let mut generators = vec![&mut self.stationary[channel]];
            if !prelude {
                generators.push(&mut self.growing[channel]);
            }
            for generator in generators {
                if !generator.is_silent() {
                    generator.fill(noise, None);
                    for (o, n) in out.iter_mut().zip(noise.iter()) {
                        *o += n;
                    }
                }
            }
            if !prelude && self.ramp[channel] != 0.0 {
                for (i, o) in out.iter_mut().enumerate().take(count) {
                    *o += self.ramp[channel] * (self.time_s + (i as f64 + 0.5) * dt_s);
                }
            }
        }
        if !prelude {
            self.time_s += count as f64 * dt_s;
        }
        let mut clipped = 0;
        if let Some(stages) = &mut self.stages {
            for i in 0..count {
                for (s, stage) in stages.iter_mut().enumerate() {
                    let u: Vec3 = std::array::from_fn(|a| scratch.output[3 * s + a][i]);
                    for a in 0..3 {
                        clipped += u64::from(u[a].abs() > self.limit[s][a]);
                    }
                    let y = stage.next_sample(u);
                    for a in 0..3 {
                        scratch.output[3 * s + a][i] = y[a];
                    }
                }
            }
        }
        let Some(correct) = correct else {
            scratch.corrected = scratch.output;
            return (clipped, 0);
        };
        let raw = &scratch.output;
        let [gx, gy, gz, ax, ay, az] = &mut scratch.corrected;
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
fn cholesky(block: &Correlated) -> Vec<f64> {
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

struct Group {
    first_run: usize,
    units: Vec<Unit>,
    nav: Strapdown<LANES>,
    found: Vec<[State; LANES]>,
    clipped: u64,
    invalid: u64,
    scratch: Box<Scratch>,
}

/// Runs the Monte Carlo; `progress` hears how many of how many samples of the trajectory are done.
///
/// # Errors
/// No runs, a duration or rate that is not possible, a model that cannot be inverted, a self-alignment that cannot find
/// a heading.
pub fn monte_carlo(
    request: &Request<'_>,
    temperature: &(dyn Fn(f64) -> f64 + Sync),
    progress: &mut dyn FnMut(u64, u64),
) -> Result<MonteCarloDrift, Error> {
    let setting = request.setting;
    if request.runs == 0 {
        return Err(Error::Request {
            what: "0 runs tell nothing".to_owned(),
            advice: "use --runs 200, or --method covariance".to_owned(),
        });
    }
    request.trajectory.check_duration(setting.duration_s)?;
    let earth = request.trajectory.earth();
    let dt = setting.dt_s;
    let total = (setting.duration_s / dt).round().max(1.0) as u64;
    if total.saturating_mul(u64::from(request.runs)) > 200_000_000_000 {
        return Err(Error::Request {
            what: format!("{} runs of {total} samples would take days", request.runs),
            advice: "use fewer runs, a shorter duration or --method covariance".to_owned(),
        });
    }
    let correct = match setting.calibration {
        Calibration::None => None,
        _ => Some(
            Compensation::new(&request.sensor.model, dt).map_err(|e| Error::Request {
                what: e.to_string(),
                advice: String::new(),
            })?,
        ),
    };
    let start = request.trajectory.at(0.0);
    let truth_state: State = start.into();
    let factors: Vec<Vec<f64>> = request.sensor.correlated.iter().map(cholesky).collect();
    let groups_count = (request.runs as usize).div_ceil(LANES);
    let first = request.trajectory.samples(dt).next_sample();
    let mut groups: Vec<Group> = (0..groups_count)
        .into_par_iter()
        .map(|g| {
            let mut scratch = Scratch::new();
            let mut units = Vec::new();
            let mut initial = [truth_state; LANES];
            for lane in 0..LANES {
                let run = (g * LANES + lane) as u32 + 1;
                // Lanes beyond the last run are idle copies of it: their results are not read.
                let run = run.min(request.runs);
                let mut unit = Unit::new(request, run, &first, &factors)?;
                initial[lane].e_from_b = aligned(
                    request,
                    run,
                    &mut unit,
                    &truth_state,
                    correct.as_ref(),
                    temperature(0.0),
                    &mut scratch,
                );
                units.push(unit);
            }
            Ok(Group {
                first_run: g * LANES,
                units,
                nav: Strapdown::new(earth, request.sculling, setting.vertical, initial),
                found: Vec::new(),
                clipped: 0,
                invalid: 0,
                scratch,
            })
        })
        .collect::<Result<_, Error>>()?;
    let mut reference =
        Strapdown::<1>::new(earth, request.sculling, setting.vertical, [truth_state]);
    let time_s = report_times_s(setting.duration_s, dt);
    let steps: Vec<u64> = time_s.iter().map(|t| (t / dt).round() as u64).collect();
    let mut reference_found: Vec<State> = Vec::new();

    let mut done = 0u64;
    while done < total {
        let count = (total - done).min(SEGMENT as u64) as usize;
        let truth = segment(request.trajectory, dt, done, count, temperature);
        for i in 0..count {
            reference.feed(
                dt,
                &std::array::from_fn(|c| {
                    [if c < 3 {
                        truth.rate[c][i]
                    } else {
                        truth.force[c - 3][i]
                    }]
                }),
                truth.vertical[i],
            );
        }
        done += count as u64;
        let last = done == total;
        follow(&mut reference, &steps, last, &mut |nav| {
            reference_found.push(nav.state(0));
        });
        groups.par_iter_mut().for_each(|group| {
            let mut from = 0;
            while from < count {
                let n = BLOCK.min(count - from);
                let mut samples = vec![[[0.0; LANES]; 6]; n];
                for (lane, unit) in group.units.iter_mut().enumerate() {
                    let (clipped, invalid) = unit.block(
                        &truth,
                        from,
                        n,
                        correct.as_ref(),
                        dt,
                        false,
                        &mut group.scratch,
                    );
                    if group.first_run + lane < request.runs as usize {
                        group.clipped += clipped;
                        group.invalid += invalid;
                    }
                    for (c, channel) in group.scratch.corrected.iter().enumerate() {
                        for i in 0..n {
                            samples[i][c][lane] = channel[i];
                        }
                    }
                }
                for (i, sample) in samples.iter().enumerate() {
                    group.nav.feed(dt, sample, truth.vertical[from + i]);
                }
                from += n;
                let found = &mut group.found;
                follow(&mut group.nav, &steps, last && from == count, &mut |nav| {
                    found.push(std::array::from_fn(|l| nav.state(l)));
                });
            }
        });
        progress(done, total);
    }
    let errors = (0..steps.len())
        .map(|i| {
            let truth = request.trajectory.at(time_s[i]);
            let e_from_n = truth.place.e_from_n();
            (0..request.runs as usize)
                .map(|run| {
                    let (state, clean) = (
                        &groups[run / LANES].found[i][run % LANES],
                        &reference_found[i],
                    );
                    let r = mul_vec_t(&e_from_n, sub(state.position_e, clean.position_e));
                    let v = mul_vec_t(&e_from_n, sub(state.velocity_e, clean.velocity_e));
                    let e = mul_vec_t(
                        &e_from_n,
                        to_rotation_vector(&mul(&state.e_from_b, &transpose(&clean.e_from_b))),
                    );
                    [r[0], r[1], r[2], v[0], v[1], v[2], e[0], e[1], e[2]]
                })
                .collect()
        })
        .collect();
    Ok(MonteCarloDrift {
        time_s,
        errors,
        clipped: groups.iter().map(|g| g.clipped).sum(),
        outside_validity: groups.iter().map(|g| g.invalid).sum(),
    })
}

/// Steps as far as possible, stopping at each report.
fn follow<const L: usize>(
    nav: &mut Strapdown<L>,
    steps: &[u64],
    last: bool,
    found: &mut dyn FnMut(&Strapdown<L>),
) {
    if last {
        nav.close();
    }
    let mut next = steps.partition_point(|s| *s <= nav.steps_done());
    loop {
        let before = nav.steps_done();
        nav.run_to(steps.get(next).copied().unwrap_or(u64::MAX));
        // Reports of a run with fewer samples than reports share a step.
        while next < steps.len() && steps[next] == nav.steps_done() {
            found(nav);
            next += 1;
        }
        if nav.steps_done() == before {
            break;
        }
    }
}

fn segment(
    trajectory: &Trajectory,
    dt: f64,
    from: u64,
    count: usize,
    temperature: &(dyn Fn(f64) -> f64 + Sync),
) -> Channels {
    let mut samples = vec![TruthSample::default(); count];
    samples
        .par_chunks_mut(4096)
        .enumerate()
        .for_each(|(i, chunk)| {
            let mut stream = trajectory.samples(dt);
            stream.seek(from + 4096 * i as u64);
            stream.fill(chunk);
        });
    Channels::of(&samples, dt, temperature)
}

/// The attitude that a run starts with.
fn aligned(
    request: &Request<'_>,
    run: u32,
    unit: &mut Unit,
    truth: &State,
    correct: Option<&Compensation<f64>>,
    temperature_c: f64,
    scratch: &mut Scratch,
) -> crate::attitude::Mat3 {
    let earth = request.trajectory.earth();
    let place = earth.place(truth.position_e);
    let e_from_n = place.e_from_n();
    let key = StreamKey {
        seed: request.seed,
        run,
        sensor: 0,
        axis: 0,
    };
    let epsilon_n: Vec3 = match request.setting.alignment {
        Alignment::Perfect => return truth.e_from_b,
        Alignment::Given {
            roll_rad,
            pitch_rad,
            heading_rad,
        } => {
            let n_from_b = mul(&transpose(&e_from_n), &truth.e_from_b);
            let (s, c) = n_from_b[1][0].atan2(n_from_b[0][0]).sin_cos();
            let draw = |i: u32, sigma: f64| sigma * key.draw(Purpose::Other, 10 + i);
            let (roll, pitch, heading) =
                (draw(0, roll_rad), draw(1, pitch_rad), draw(2, heading_rad));
            [c * roll - s * pitch, s * roll + c * pitch, heading]
        }
        Alignment::SelfAligned => {
            // 600 s of samples at rest in the start attitude, with the run's own sensor.
            let gravity = earth.gravity_e(&place);
            let force = mul_vec_t(&truth.e_from_b, gravity.map(|g| -g));
            let rate = mul_vec_t(&truth.e_from_b, [0.0, 0.0, earth.rate_rad_s()]);
            let still = Channels {
                force: force.map(|f| vec![f; BLOCK]),
                rate: rate.map(|w| vec![w; BLOCK]),
                rate_dot: [0.0; 3].map(|z: f64| vec![z; BLOCK]),
                temperature: vec![temperature_c; BLOCK],
                vertical: vec![[0.0; 2]; BLOCK],
            };
            let total = (SELF_ALIGNMENT_S / request.setting.dt_s).round() as usize;
            let mut sum = [0.0; 6];
            let mut done = 0;
            while done < total {
                let n = BLOCK.min(total - done);
                unit.block(&still, 0, n, correct, request.setting.dt_s, true, scratch);
                for c in 0..6 {
                    sum[c] += scratch.corrected[c][..n].iter().sum::<f64>();
                }
                done += n;
            }
            let mean = sum.map(|s| s / total as f64);
            let to_n = |v: Vec3| mul_vec_t(&e_from_n, mul_vec(&truth.e_from_b, v));
            let f = to_n([mean[3] - force[0], mean[4] - force[1], mean[5] - force[2]]);
            let w = to_n([mean[0] - rate[0], mean[1] - rate[1], mean[2] - rate[2]]);
            let g = crate::attitude::norm(gravity);
            let latitude = place.latitude_rad();
            [
                -f[1] / g,
                f[0] / g,
                -w[1] / (earth.rate_rad_s() * latitude.cos()) + f[1] / g * latitude.tan(),
            ]
        }
    };
    mul(
        &from_rotation_vector(mul_vec(&e_from_n, epsilon_n)),
        &truth.e_from_b,
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::drift::Scene;
    use crate::earth::Earth;
    use crate::strapdown::Vertical;
    use crate::trajectory::Start;
    use sagnac_noise::{AxisNoise, Flicker, GaussMarkov, RandomWalk, White};

    fn sensor() -> SensorErrors {
        let deg_h = std::f64::consts::PI / 648_000.0;
        let mut out = SensorErrors::default();
        for a in 0..3 {
            out.noise[0][a] = AxisNoise {
                white: White {
                    density: 0.3 * deg_h * 60.0,
                },
                flicker: Flicker {
                    coefficient: 8.0 * deg_h,
                },
                random_walk: RandomWalk {
                    coefficient: 1.5 * deg_h / 60.0,
                },
                gauss_markov: vec![GaussMarkov {
                    sigma: 3.0 * deg_h,
                    correlation_time_s: 300.0,
                }],
                ..AxisNoise::default()
            };
            out.noise[1][a] = AxisNoise {
                white: White { density: 1e-3 },
                flicker: Flicker { coefficient: 4e-4 },
                ..AxisNoise::default()
            };
            out.bias_stability[0][a] = 5.0 * deg_h;
            out.bias_stability[1][a] = 2e-3;
            out.scale_factor_stability[0][a] = 1e-4;
            out.scale_factor_stability[1][a] = 3e-4;
        }
        out.misalignment_stability = [[5e-5; 6]; 2];
        out
    }

    fn setting(duration_s: f64, alignment: Alignment) -> Setting {
        Setting {
            duration_s,
            dt_s: 0.02,
            vertical: Vertical::Fixed,
            alignment,
            calibration: Calibration::Model,
        }
    }

    #[test]
    fn both_methods_agree() {
        let given = Alignment::Given {
            roll_rad: 1e-3,
            pitch_rad: 1e-3,
            heading_rad: 1e-2,
        };
        for (name, alignment) in [
            ("rest", Alignment::Perfect),
            ("drive", given),
            ("flight", Alignment::Perfect),
            ("walking", Alignment::Perfect),
        ] {
            let trajectory = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
            let setting = setting(600.0, alignment);
            let sensor = sensor();
            let scene = Scene::new(&trajectory, setting, &|_| 25.0).unwrap();
            let linear = scene.covariance(&sensor).unwrap();
            let request = Request {
                trajectory: &trajectory,
                setting,
                sculling: Sculling::Five,
                sensor: &sensor,
                runs: 200,
                seed: 1,
            };
            let found = monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap();
            let (rms, cep) = (found.rms(3.29)[59], found.cep(0.0005)[59]);
            // The 99.9 % intervals of navigation.md §3.1.
            let within = |x: f64, s: Sampled| {
                s.interval_m[0].is_none_or(|l| x >= l) && s.interval_m[1].is_none_or(|u| x <= u)
            };
            assert!(
                within(linear.rms_m()[59], rms),
                "{name} rms {} {rms:?}",
                linear.rms_m()[59]
            );
            assert!(
                within(linear.cep_m()[59], cep),
                "{name} cep {} {cep:?}",
                linear.cep_m()[59]
            );
            assert!((linear.budget.iter().map(|e| e.share).sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let trajectory = Trajectory::named("drive", Earth::Wgs84, &Start::default()).unwrap();
        let setting = setting(20.0, Alignment::Perfect);
        let sensor = sensor();
        let request = Request {
            trajectory: &trajectory,
            setting,
            sculling: Sculling::Five,
            sensor: &sensor,
            runs: 19,
            seed: 7,
        };
        let run = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
                .install(|| monte_carlo(&request, &|_| 25.0, &mut |_, _| {}).unwrap())
        };
        assert_eq!(run(1), run(3));
        let fewer =
            monte_carlo(&Request { runs: 5, ..request }, &|_| 25.0, &mut |_, _| {}).unwrap();
        assert_eq!(fewer.errors[59][..5], run(2).errors[59][..5]);
        assert!(monte_carlo(&Request { runs: 0, ..request }, &|_| 25.0, &mut |_, _| {}).is_err());
    }

    #[test]
    fn self_alignment_agrees_at_navigation_grade() {
        let deg_h = std::f64::consts::PI / 648_000.0;
        let mut sensor = SensorErrors::default();
        for a in 0..3 {
            sensor.noise[0][a].flicker.coefficient = 0.01 * deg_h;
            sensor.noise[0][a].white.density = 0.002 * deg_h * 60.0;
            sensor.bias_stability[0][a] = 0.01 * deg_h;
            sensor.bias_stability[1][a] = 5e-4;
        }
        let trajectory = Trajectory::named("rest", Earth::Wgs84, &Start::default()).unwrap();
        let setting = Setting {
            dt_s: 0.1,
            ..setting(3600.0, Alignment::SelfAligned)
        };
        let linear = Scene::new(&trajectory, setting, &|_| 25.0)
            .unwrap()
            .covariance(&sensor)
            .unwrap();
        let request = Request {
            trajectory: &trajectory,
            setting,
            sculling: Sculling::Five,
            sensor: &sensor,
            runs: 400,
            seed: 1,
        };
        let found = monte_carlo(&request, &|_| 25.0, &mut |_, _| {})
            .unwrap()
            .rms(3.29)[59];
        let x = linear.rms_m()[59];
        assert!(
            found.interval_m[0].is_none_or(|l| x >= l)
                && found.interval_m[1].is_none_or(|u| x <= u),
            "{x} {found:?}"
        );
    }
}
