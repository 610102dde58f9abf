//! The random terms of a model as they act: white noise from either of its keys, the in-run instability from any of its processes.
//!
//! B = (Allan minimum)/√(2 ln2/π), N = (one-sided density)/√2 [IEEE952].

use crate::entry::Entry;
use crate::model::{Model, Process};
use crate::path::ParameterPath;
use sagnac_core::Sensor;
use sagnac_noise::{
    AxisNoise, Flicker, GaussMarkov, Quantization, Ramp, RandomWalk, Resonance, Sinusoid, White,
};

/// √(2 ln2/π): the floor of the Allan deviation of flicker noise over its coefficient B.
pub const FLICKER_FLOOR: f64 = 0.664_282_470_267_960_1;

impl Model {
    /// `noise.angle_random_walk` of a gyro, `noise.velocity_random_walk` of an accelerometer.
    pub fn white_key(sensor: Sensor) -> &'static str {
        match sensor {
            Sensor::Gyro => "angle_random_walk",
            Sensor::Accel => "velocity_random_walk",
        }
    }

    /// `rate_random_walk` or `acceleration_random_walk`.
    pub fn walk_key(sensor: Sensor) -> &'static str {
        match sensor {
            Sensor::Gyro => "rate_random_walk",
            Sensor::Accel => "acceleration_random_walk",
        }
    }

    /// `rate_ramp` or `acceleration_ramp`.
    pub fn ramp_key(sensor: Sensor) -> &'static str {
        match sensor {
            Sensor::Gyro => "rate_ramp",
            Sensor::Accel => "acceleration_ramp",
        }
    }

    /// N of an axis, two-sided [rad/√s, m/s/√s], from its own key or from the one-sided density over √2.
    pub fn white_noise(&self, sensor: Sensor, axis: usize) -> Option<Entry> {
        self.under(sensor, &format!("noise.{}", Self::white_key(sensor)), axis)
            .cloned()
            .or_else(|| {
                self.under(sensor, "noise.noise_density_one_sided", axis)
                    .map(|entry| scaled(entry, std::f64::consts::FRAC_1_SQRT_2))
            })
    }

    /// B of an axis [rad/s, m/s²], from the coefficient or from the Allan minimum over 0.66428; none for other processes.
    pub fn flicker(&self, sensor: Sensor, axis: usize) -> Option<Entry> {
        if self.process(sensor) != Process::Flicker {
            return None;
        }
        self.under(sensor, "bias.instability.coefficient", axis)
            .cloned()
            .or_else(|| {
                self.under(sensor, "bias.instability.allan_minimum", axis)
                    .map(|entry| scaled(entry, 1.0 / FLICKER_FLOOR))
            })
    }

    /// The floor of the Allan deviation of the in-run instability [rad/s, m/s²]: 0.66428·B, σ of a Gauss–Markov process,
    /// K·√(3600 s) of a random walk.
    pub fn instability_floor(&self, sensor: Sensor, axis: usize) -> Option<f64> {
        match self.process(sensor) {
            Process::Flicker => Some(FLICKER_FLOOR * self.flicker(sensor, axis)?.value?),
            Process::GaussMarkov => self.under(sensor, "bias.instability.sigma", axis)?.value,
            Process::RandomWalk => {
                let key = format!("bias.instability.{}", Self::walk_key(sensor));
                self.under(sensor, &key, axis)?
                    .value
                    .map(|walk| 60.0 * walk)
            }
        }
    }

    /// An entry by its path under the sensor, and axis.
    pub fn under(&self, sensor: Sensor, key: &str, axis: usize) -> Option<&Entry> {
        let path: ParameterPath = format!("{}.{key}", sensor.key()).parse().ok()?;
        self.entries.get(&path.with_element(axis)?)
    }

    fn number(&self, sensor: Sensor, key: &str, axis: usize) -> f64 {
        self.under(sensor, key, axis).map_or(0.0, Entry::simulated)
    }

    fn list_length(&self, sensor: Sensor, list: &str, key: &str) -> usize {
        format!("{}.noise.{list}.1.{key}", sensor.key())
            .parse()
            .map_or(0, |path| self.count(path))
    }

    /// The random terms of one axis, as the generators take them; a term with an upper limit only is zero.
    pub fn axis_noise(&self, sensor: Sensor, axis: usize) -> AxisNoise {
        let number = |key: &str| self.number(sensor, key, axis);
        let process = self.process(sensor);
        let walk = Self::walk_key(sensor);
        let listed = |list: &str, place: usize, key: &str| {
            number(&format!("noise.{list}.{}.{key}", place + 1))
        };
        AxisNoise {
            quantization: Quantization {
                coefficient: number("noise.quantization"),
            },
            white: White {
                density: self
                    .white_noise(sensor, axis)
                    .map_or(0.0, |entry| entry.simulated()),
            },
            flicker: Flicker {
                coefficient: self
                    .flicker(sensor, axis)
                    .map_or(0.0, |entry| entry.simulated()),
            },
            random_walk: RandomWalk {
                coefficient: number(&format!("noise.{walk}")),
            },
            instability_random_walk: RandomWalk {
                coefficient: if process == Process::RandomWalk {
                    number(&format!("bias.instability.{walk}"))
                } else {
                    0.0
                },
            },
            ramp: Ramp {
                slope: number(&format!("noise.{}", Self::ramp_key(sensor))),
            },
            gauss_markov: (0..self.list_length(sensor, "gauss_markov", "sigma"))
                .map(|place| GaussMarkov {
                    sigma: listed("gauss_markov", place, "sigma"),
                    correlation_time_s: listed("gauss_markov", place, "correlation_time"),
                })
                .collect(),
            instability_gauss_markov: if process == Process::GaussMarkov {
                GaussMarkov {
                    sigma: number("bias.instability.sigma"),
                    correlation_time_s: number("bias.instability.correlation_time"),
                }
            } else {
                GaussMarkov::default()
            },
            resonance: (0..self.list_length(sensor, "resonances", "sigma"))
                .map(|place| Resonance {
                    sigma: listed("resonances", place, "sigma"),
                    frequency_hz: listed("resonances", place, "frequency"),
                    damping: listed("resonances", place, "damping"),
                })
                .collect(),
            sinusoid: (0..self.list_length(sensor, "sinusoids", "amplitude"))
                .map(|place| Sinusoid {
                    amplitude: listed("sinusoids", place, "amplitude"),
                    frequency_hz: listed("sinusoids", place, "frequency"),
                })
                .collect(),
        }
    }

    /// The random terms of gyro and accelerometer, x, y, z each.
    pub fn noise(&self) -> [[AxisNoise; 3]; 2] {
        Sensor::ALL.map(|sensor| [0, 1, 2].map(|axis| self.axis_noise(sensor, axis)))
    }

    /// The run-to-run 1σ of bias, scale factor (x, y, z) and misalignment (xy, xz, yx, yz, zx, zy) of a sensor; zero where absent.
    pub fn stability(&self, sensor: Sensor) -> Stability {
        let of = |key: &str, count: usize| -> Vec<f64> {
            (0..count)
                .map(|element| self.number(sensor, key, element))
                .collect()
        };
        let axes = |key: &str| of(key, 3).try_into().unwrap_or([0.0; 3]);
        Stability {
            bias: axes("bias.stability"),
            scale_factor: axes("scale_factor.stability"),
            misalignment: of("misalignment.stability", 6)
                .try_into()
                .unwrap_or([0.0; 6]),
        }
    }

    /// Parameters of which only an upper limit is known: they are simulated as zero.
    pub fn limits(&self) -> Vec<ParameterPath> {
        self.parameters()
            .filter(|(_, entry)| entry.is_limit())
            .map(|(path, _)| path)
            .collect()
    }
}

/// The 1σ of the draws of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stability {
    /// rad/s or m/s²: x, y, z.
    pub bias: [f64; 3],
    /// x, y, z.
    pub scale_factor: [f64; 3],
    /// rad: xy, xz, yx, yz, zx, zy.
    pub misalignment: [f64; 6],
}

fn scaled(entry: &Entry, factor: f64) -> Entry {
    let times = |value: Option<f64>| value.map(|value| value * factor);
    Entry {
        value: times(entry.value),
        sigma: times(entry.sigma),
        upper_limit: times(entry.upper_limit),
        lower: times(entry.lower),
        upper: times(entry.upper),
        ..entry.clone()
    }
}
