//! What a sensor does on a run that no linear covariance holds: its range cuts off, its rounding sticks.

use super::{CovarianceDrift, Scene};
use crate::covariance::{Kind, Parameter};
use crate::sensor::{Calibration, SensorErrors};
use sagnac_core::{Axis, Output, Sensor};

/// A reason why the covariance is not to be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// The motion goes beyond the range, and Monte Carlo and covariance differ.
    Clipped {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
        /// Largest output, rad/s or m/s².
        reaches: f64,
        /// When, s.
        time_s: f64,
        /// The range.
        limit: f64,
    },
    /// A rate is rounded in steps that its own noise does not wash out: the output sticks (model.md §4, trap 4).
    Sticks {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
        /// The step, rad/s or m/s².
        step: f64,
        /// 1σ of a sample's noise over the step.
        noise: f64,
    },
}

/// Noise over step from which rounding is white noise of LSB²/12.
const ENOUGH_NOISE: f64 = 0.35;

/// Power of a stuck step over that of everything together, from which the RMS error changes by a tenth.
const MATTERS: f64 = 0.21;

impl Scene {
    /// Why `found`, the covariance here of `sensor` at a sampling interval, is not to be trusted; the worst axis of each
    /// sensor.
    pub fn doubts(&self, sensor: &SensorErrors, found: &CovarianceDrift, dt_s: f64) -> Vec<Doubt> {
        let mut out = self.clipped(sensor);
        out.extend(self.sticks(sensor, found, dt_s));
        out
    }

    fn clipped(&self, sensor: &SensorErrors) -> Vec<Doubt> {
        let model = &sensor.model;
        let ranged = |s: Sensor| model.triad(s).range.limit.iter().any(|l| l.is_finite());
        if !Sensor::ALL.into_iter().any(ranged) {
            return Vec::new();
        }
        let sensitivity = sensor.sensitivity(Calibration::Perfect, self.start_temperature_c);
        let reach = self.timeline.reach(&sensitivity.forward);
        let worst = |s: Sensor| {
            let limit = model.triad(s).range.limit;
            let ratio = |a: &Axis| reach[s.index()][a.index()].value / limit[a.index()];
            Axis::ALL
                .into_iter()
                .max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
                .filter(|a| ratio(a) > 1.0)
                .map(|axis| Doubt::Clipped {
                    sensor: s,
                    axis,
                    reaches: reach[s.index()][axis.index()].value,
                    time_s: reach[s.index()][axis.index()].time_s,
                    limit: limit[axis.index()],
                })
        };
        Sensor::ALL.into_iter().filter_map(worst).collect()
    }

    fn sticks(&self, sensor: &SensorErrors, found: &CovarianceDrift, dt_s: f64) -> Vec<Doubt> {
        let mut out = Vec::new();
        let mut power = 0.0;
        for s in Sensor::ALL {
            let resolution = &sensor.model.triad(s).resolution;
            if resolution.output != Output::Rate {
                continue;
            }
            let mut worst: Option<(Axis, f64, f64)> = None;
            for axis in Axis::ALL {
                let step = resolution.lsb[axis.index()];
                if step <= 0.0 {
                    continue;
                }
                let noise = sample_sigma(sensor, s, axis, dt_s) / step;
                if noise >= ENOUGH_NOISE {
                    continue;
                }
                let bias = Kind::Constant(Parameter::Bias {
                    sensor: s,
                    axis,
                    power: 0,
                });
                let stuck = self.unit(bias).spread.last().map_or(0.0, |spread| {
                    spread.horizontal.north_north + spread.horizontal.east_east
                });
                power += stuck * step * step / 12.0;
                if worst.is_none_or(|(_, _, least)| noise < least) {
                    worst = Some((axis, step, noise));
                }
            }
            out.extend(worst.map(|(axis, step, noise)| Doubt::Sticks {
                sensor: s,
                axis,
                step,
                noise,
            }));
        }
        let end = found.end();
        if power > MATTERS * (end.north_north + end.east_east) {
            out
        } else {
            Vec::new()
        }
    }
}

/// 1σ of a sample's own noise: white, quantization and resonance; slower terms let the output stick in between.
fn sample_sigma(sensor: &SensorErrors, of: Sensor, axis: Axis, dt_s: f64) -> f64 {
    let noise = &sensor.noise[of.index()][axis.index()];
    let square = |x: f64| x * x;
    let ringing: f64 = noise.resonance.iter().map(|r| square(r.sigma)).sum();
    (square(noise.white.density) / dt_s
        + 2.0 * square(noise.quantization.coefficient / dt_s)
        + ringing)
        .sqrt()
}
