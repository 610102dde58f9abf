//! A sensor as navigation sees it: the deterministic model that corrects it, and everything that stays after correction
//! (navigation.md §3.1).

use crate::attitude::Mat3;
use crate::covariance::{Kind, Parameter, Process, Sensitivity};
use sagnac_core::{Axis, Element, Measurement, Output, Sensor, SensorModel};
use sagnac_noise::AxisNoise;

/// A value of the deterministic model that is known to a σ only.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertain {
    /// Parameter path without the axis, for instance `accel.scale_factor`.
    pub term: String,
    /// What it changes.
    pub parameter: Parameter,
    /// 1σ in SI.
    pub sigma: f64,
}

/// Parameters whose errors are correlated: a `[[calibration]]` block.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Correlated {
    /// Path without axis, and what it changes.
    pub parameters: Vec<(String, Parameter)>,
    /// Covariance in SI, row by row.
    pub covariance: Vec<f64>,
}

/// Everything that drifts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SensorErrors {
    /// Deterministic terms, as the model file has them.
    pub model: SensorModel<f64>,
    /// Random terms of gyro (0) and accelerometer (1), x, y, z.
    pub noise: [[AxisNoise; 3]; 2],
    /// `bias.stability`, 1σ, rad/s and m/s².
    pub bias_stability: [[f64; 3]; 2],
    /// `scale_factor.stability`, 1σ.
    pub scale_factor_stability: [[f64; 3]; 2],
    /// `misalignment.stability`, 1σ, xy, xz, yx, yz, zx, zy.
    pub misalignment_stability: [[f64; 6]; 2],
    /// Values with a σ of their own.
    pub uncertain: Vec<Uncertain>,
    /// Values whose errors are correlated.
    pub correlated: Vec<Correlated>,
}

/// What is removed before navigation (`--calibration`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Calibration {
    /// The model's deterministic terms, known to their σ.
    #[default]
    Model,
    /// The same with every σ zero.
    Perfect,
    /// Nothing.
    None,
}

/// One independent source of error: a kind with its size.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Parameter path without axis, or `alignment`.
    pub term: String,
    /// `x`, `y`, `z`; `roll`, `pitch`, `heading` of an alignment.
    pub axis: &'static str,
    /// What it does per unit.
    pub kind: Kind,
    /// 1σ (or coefficient) in SI.
    pub sigma: f64,
}

const NOISE_KEYS: [[&str; 3]; 2] = [
    ["angle_random_walk", "rate_random_walk", "rate_ramp"],
    [
        "velocity_random_walk",
        "acceleration_random_walk",
        "acceleration_ramp",
    ],
];

impl Parameter {
    /// The axis under which a parameter is listed: that of the instrument.
    pub fn axis(&self) -> Axis {
        match *self {
            Self::Bias { axis, .. }
            | Self::ScaleFactor { axis, .. }
            | Self::Quadratic { axis, .. }
            | Self::Cubic { axis, .. }
            | Self::Asymmetry { axis, .. } => axis,
            Self::OffDiagonal { element, .. } => element.row(),
            Self::GSensitivity { row, .. } | Self::G2Sensitivity { row, .. } => row,
            Self::AxisOffset { accel, .. } => accel,
        }
    }
}

impl SensorErrors {
    /// Which of white noise and bias terms the model lacks: `gyro.noise`, `gyro.bias`, `accel.noise`, `accel.bias`.
    pub fn missing(&self) -> Vec<&'static str> {
        let mut out = Vec::new();
        for (s, names) in [["gyro.noise", "gyro.bias"], ["accel.noise", "accel.bias"]]
            .iter()
            .enumerate()
        {
            let axes = &self.noise[s];
            if axes.iter().all(|a| a.white.density == 0.0) {
                out.push(names[0]);
            }
            let bias = axes.iter().any(|a| {
                a.flicker.coefficient != 0.0
                    || a.random_walk.coefficient != 0.0
                    || a.instability_random_walk.coefficient != 0.0
                    || a.instability_gauss_markov.sigma != 0.0
                    || a.gauss_markov.iter().any(|g| g.sigma != 0.0)
            }) || self.bias_stability[s].iter().any(|b| *b != 0.0);
            if !bias {
                out.push(names[1]);
            }
        }
        out
    }

    /// All sources that are not zero, gyro first, at a sampling interval.
    pub fn sources(&self, dt_s: f64, calibration: Calibration) -> Vec<Source> {
        let mut out = Vec::new();
        for sensor in Sensor::ALL {
            let s = sensor.index();
            let key = sensor.key();
            let triad = self.model.triad(sensor);
            for axis in Axis::ALL {
                let a = axis.index();
                let noise = &self.noise[s][a];
                let mut push = |term: String, kind: Kind, sigma: f64| {
                    if sigma != 0.0 {
                        out.push(Source {
                            term,
                            axis: axis.key(),
                            kind,
                            sigma: sigma.abs(),
                        });
                    }
                };
                let process = |process: Process| Kind::Process {
                    sensor,
                    axis,
                    process,
                };
                push(
                    format!("{key}.bias.stability"),
                    Kind::Constant(Parameter::Bias {
                        sensor,
                        axis,
                        power: 0,
                    }),
                    self.bias_stability[s][a],
                );
                push(
                    format!("{key}.bias.instability"),
                    Kind::Flicker { sensor, axis },
                    noise.flicker.coefficient,
                );
                push(
                    format!("{key}.bias.instability"),
                    process(Process::RandomWalk),
                    noise.instability_random_walk.coefficient,
                );
                push(
                    format!("{key}.bias.instability"),
                    process(Process::GaussMarkov {
                        correlation_time_s: noise.instability_gauss_markov.correlation_time_s,
                    }),
                    noise.instability_gauss_markov.sigma,
                );
                push(
                    format!("{key}.scale_factor.stability"),
                    Kind::Constant(Parameter::ScaleFactor {
                        sensor,
                        axis,
                        power: 0,
                    }),
                    self.scale_factor_stability[s][a],
                );
                for element in Element::ALL.into_iter().filter(|e| e.row() == axis) {
                    push(
                        format!("{key}.misalignment.stability"),
                        Kind::Constant(Parameter::OffDiagonal { sensor, element }),
                        self.misalignment_stability[s][element.index()],
                    );
                }
                push(
                    format!("{key}.noise.{}", NOISE_KEYS[s][0]),
                    process(Process::White),
                    noise.white.density,
                );
                push(
                    format!("{key}.noise.{}", NOISE_KEYS[s][1]),
                    process(Process::RandomWalk),
                    noise.random_walk.coefficient,
                );
                push(
                    format!("{key}.noise.{}", NOISE_KEYS[s][2]),
                    Kind::Ramp { sensor, axis },
                    noise.ramp.slope,
                );
                push(
                    format!("{key}.noise.quantization"),
                    process(Process::Quantization { dt_s }),
                    noise.quantization.coefficient,
                );
                for (i, g) in noise.gauss_markov.iter().enumerate() {
                    push(
                        format!("{key}.noise.gauss_markov.{}", i + 1),
                        process(Process::GaussMarkov {
                            correlation_time_s: g.correlation_time_s,
                        }),
                        g.sigma,
                    );
                }
                for (i, r) in noise.resonance.iter().enumerate() {
                    push(
                        format!("{key}.noise.resonances.{}", i + 1),
                        process(Process::Resonance {
                            frequency_hz: r.frequency_hz,
                            damping: r.damping,
                        }),
                        r.sigma,
                    );
                }
                for (i, l) in noise.sinusoid.iter().enumerate() {
                    push(
                        format!("{key}.noise.sinusoids.{}", i + 1),
                        process(Process::Sinusoid {
                            frequency_hz: l.frequency_hz,
                        }),
                        l.amplitude,
                    );
                }
                let lsb = triad.resolution.lsb[a];
                match triad.resolution.output {
                    Output::Rate => push(
                        format!("{key}.resolution"),
                        process(Process::White),
                        lsb * (dt_s / 12.0).sqrt(),
                    ),
                    Output::Increment => push(
                        format!("{key}.resolution"),
                        process(Process::Rounding { dt_s }),
                        lsb / 12f64.sqrt(),
                    ),
                }
            }
        }
        if calibration != Calibration::Perfect {
            for u in &self.uncertain {
                if u.sigma != 0.0 {
                    out.push(Source {
                        term: u.term.clone(),
                        axis: u.parameter.axis().key(),
                        kind: Kind::Constant(u.parameter),
                        sigma: u.sigma.abs(),
                    });
                }
            }
        }
        out
    }

    /// How errors of the output become errors after correction, at a temperature.
    pub fn sensitivity(&self, calibration: Calibration, temperature_c: f64) -> Sensitivity {
        let forward = Measurement::new(&self.model);
        let mut out = Sensitivity {
            gyro: crate::attitude::IDENTITY,
            accel: crate::attitude::IDENTITY,
            coupling: [[0.0; 3]; 3],
            reference_c: self.model.reference_temperature_c,
            forward,
        };
        if calibration != Calibration::None {
            let gain = |sensor: Sensor| out.forward.errors(sensor).gain(temperature_c);
            if let (Some(g), Some(a)) =
                (inverse(&gain(Sensor::Gyro)), inverse(&gain(Sensor::Accel)))
            {
                out.gyro = g;
                out.accel = a;
            }
            out.coupling = self.model.gyro_g_sensitivity.matrix;
        }
        out
    }
}

fn inverse(m: &Mat3) -> Option<Mat3> {
    use crate::attitude::{cross, dot};
    let (x, y, z) = (cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    let det = dot(m[0], x);
    (det.abs() > 1e-9).then(|| {
        let k = 1.0 / det;
        [
            [k * x[0], k * y[0], k * z[0]],
            [k * x[1], k * y[1], k * z[1]],
            [k * x[2], k * y[2], k * z[2]],
        ]
    })
}
