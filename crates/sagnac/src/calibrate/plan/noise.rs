//! Standard errors of the means of a dwell: se = √(N²/dwell + (0.6643 B)²).

use sagnac_calibrate::plan::Errors;
use sagnac_core::Sensor;

use super::{PlanRequest, Tested};

/// One axis: a standard error as given, or N and the flicker floor.
#[derive(Clone, Copy, Debug)]
enum Axis {
    Given(f64),
    Of { white: f64, floor: f64 },
}

/// The noise of a sensor as a plan needs it.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    axes: [[Axis; 3]; 2],
}

impl Noise {
    pub(super) fn of(request: &PlanRequest) -> Self {
        let own = match &request.tested {
            Tested::Model(model) => Some(model.as_ref()),
            Tested::Name(_) => None,
        };
        let model = request.noise.as_ref().or(own);
        let axes = Sensor::ALL.map(|sensor| {
            let (given, usual) = match sensor {
                Sensor::Gyro => (request.gyro_se_rad_s, 1e-4),
                Sensor::Accel => (request.accel_se_m_s2, 1e-3),
            };
            [0, 1, 2].map(|k| {
                if let Some(se) = given {
                    return Axis::Given(se);
                }
                let white = model
                    .and_then(|m| m.white_noise(sensor, k))
                    .and_then(|e| e.value)
                    .filter(|n| *n > 0.0);
                match white {
                    Some(white) => Axis::Of {
                        white,
                        floor: model
                            .and_then(|m| m.instability_floor(sensor, k))
                            .unwrap_or(0.0),
                    },
                    None => Axis::Given(usual),
                }
            })
        });
        Self { axes }
    }

    /// Whether the length of a dwell matters.
    pub(super) fn knows_dwell(&self) -> bool {
        self.axes
            .iter()
            .flatten()
            .any(|axis| matches!(axis, Axis::Of { .. }))
    }

    pub(super) fn errors(&self, dwell_s: f64, tilt_rad: f64) -> Errors {
        let of = |sensor: Sensor| {
            self.axes[sensor.index()].map(|axis| match axis {
                Axis::Given(se) => se,
                Axis::Of { white, floor } => (white * white / dwell_s + floor * floor).sqrt(),
            })
        };
        Errors {
            gyro: of(Sensor::Gyro),
            accel: of(Sensor::Accel),
            tilt_rad,
        }
    }
}
