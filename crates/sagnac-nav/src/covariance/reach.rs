//! The largest output that a run asks of each axis: what a range may cut off.

use super::Timeline;
use sagnac_core::{Measurement, Truth};

/// An output at the instant when it is largest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reach {
    /// Its size, rad/s or m/s².
    pub value: f64,
    /// When, s.
    pub time_s: f64,
}

impl Timeline {
    /// The largest output without noise along the run, gyro (0) and accelerometer (1), x, y, z.
    pub fn reach(&self, forward: &Measurement<f64>) -> [[Reach; 3]; 2] {
        let mut out = [[Reach::default(); 3]; 2];
        for node in &self.nodes {
            let input = &node.input;
            let y = forward.corrupt(&Truth {
                specific_force: input.force,
                angular_rate: input.rate,
                angular_acceleration: input.rate_dot,
                temperature_c: input.temperature_c,
            });
            for (triad, values) in out.iter_mut().zip([y.gyro, y.accel]) {
                for (reach, value) in triad.iter_mut().zip(values) {
                    if value.abs() > reach.value {
                        *reach = Reach {
                            value: value.abs(),
                            time_s: input.time_s,
                        };
                    }
                }
            }
        }
        out
    }
}
