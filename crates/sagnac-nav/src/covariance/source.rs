//! The independent sources of navigation error: what each puts on the corrected output, per unit.

use super::shaping::Process;
use crate::attitude::{Mat3, Vec3};
use sagnac_core::{Axis, Element, Measurement, Sensor, Truth};

/// A parameter of the deterministic model, by what it adds to the output (model.md §2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parameter {
    /// c_i θ^i of a bias; power 0 is the bias itself.
    Bias {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
        /// Power of (T − T0).
        power: u8,
    },
    /// s_i θ^i times the input.
    ScaleFactor {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
        /// Power of (T − T0).
        power: u8,
    },
    /// k2 u².
    Quadratic {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
    },
    /// k3 u³.
    Cubic {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
    },
    /// ½ a |u|.
    Asymmetry {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
    },
    /// Misalignment or cross-axis response.
    OffDiagonal {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Element.
        element: Element,
    },
    /// (rad/s)/(m/s²).
    GSensitivity {
        /// Gyro axis.
        row: Axis,
        /// Axis of the specific force.
        column: Axis,
    },
    /// (rad/s)/(m/s²)².
    G2Sensitivity {
        /// Gyro axis.
        row: Axis,
        /// Product, as `PRODUCT_KEYS`.
        product: u8,
    },
    /// m.
    AxisOffset {
        /// Accelerometer.
        accel: Axis,
        /// Component of its position.
        component: Axis,
    },
}

/// What a source does in time, per unit of its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A random constant in a parameter.
    Constant(Parameter),
    /// A random slope: t seconds times the axis.
    Ramp {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
    },
    /// A random process on an axis.
    Process {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
        /// The process.
        process: Process,
    },
    /// B = 1 by the ladder of states.
    Flicker {
        /// Gyro or accelerometer.
        sensor: Sensor,
        /// Axis.
        axis: Axis,
    },
    /// A rotation of 1 rad at the start about forward (0), right (1), both horizontal, or down (2).
    Alignment(u8),
    /// All that the deterministic model adds when nothing is corrected.
    Mean,
}

/// The truth at an instant, as the sources see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input {
    pub(super) force: Vec3,
    pub(super) rate: Vec3,
    pub(super) rate_dot: Vec3,
    pub(super) time_s: f64,
    pub(super) temperature_c: f64,
}

/// How the sensor turns errors of its output into errors after correction.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// (I + M_g)⁻¹, or I where nothing is corrected.
    pub gyro: Mat3,
    /// (I + M_a)⁻¹.
    pub accel: Mat3,
    /// G_g: an error of the force becomes one of the rate, −(I + M_g)⁻¹ G.
    pub coupling: Mat3,
    /// Reference temperature T0, °C.
    pub reference_c: f64,
    /// The forward model, for [`Kind::Mean`] and f'.
    pub forward: Measurement<f64>,
}

impl Sensitivity {
    /// The corrected error [gyro, accel] of an output error.
    pub(super) fn corrected(&self, gyro: Vec3, accel: Vec3) -> [f64; 6] {
        let a = crate::attitude::mul_vec(&self.accel, accel);
        let coupled = crate::attitude::mul_vec(&self.coupling, a);
        let g = crate::attitude::mul_vec(&self.gyro, crate::attitude::sub(gyro, coupled));
        [g[0], g[1], g[2], a[0], a[1], a[2]]
    }

    /// The corrected error of a unit on one axis.
    pub(super) fn direction(&self, sensor: Sensor, axis: Axis) -> [f64; 6] {
        let mut unit = [0.0; 3];
        unit[axis.index()] = 1.0;
        match sensor {
            Sensor::Gyro => self.corrected(unit, [0.0; 3]),
            Sensor::Accel => self.corrected([0.0; 3], unit),
        }
    }

    /// The corrected error of a unit of a parameter for an input.
    pub(super) fn parameter(&self, parameter: Parameter, input: &Input) -> [f64; 6] {
        let truth = Truth {
            specific_force: input.force,
            angular_rate: input.rate,
            angular_acceleration: input.rate_dot,
            temperature_c: input.temperature_c,
        };
        let seen = |sensor: Sensor| match sensor {
            Sensor::Gyro => input.rate,
            Sensor::Accel => self.forward.at_accelerometers(&truth),
        };
        // θ where the terms hold: outside they stay at the end of their range.
        let theta = |held: f64| held - self.reference_c;
        let errors = |sensor: Sensor| self.forward.errors(sensor);
        let on = |sensor: Sensor, axis: Axis, value: f64| {
            let mut v = [0.0; 3];
            v[axis.index()] = value;
            match sensor {
                Sensor::Gyro => self.corrected(v, [0.0; 3]),
                Sensor::Accel => self.corrected([0.0; 3], v),
            }
        };
        match parameter {
            Parameter::Bias {
                sensor,
                axis,
                power,
            } => {
                let theta = theta(errors(sensor).bias_temperature_c(input.temperature_c));
                on(sensor, axis, theta.powi(i32::from(power)))
            }
            Parameter::ScaleFactor {
                sensor,
                axis,
                power,
            } => {
                let theta = theta(errors(sensor).scale_factor_temperature_c(input.temperature_c));
                on(
                    sensor,
                    axis,
                    theta.powi(i32::from(power)) * seen(sensor)[axis.index()],
                )
            }
            Parameter::Quadratic { sensor, axis } => {
                on(sensor, axis, seen(sensor)[axis.index()].powi(2))
            }
            Parameter::Cubic { sensor, axis } => {
                on(sensor, axis, seen(sensor)[axis.index()].powi(3))
            }
            Parameter::Asymmetry { sensor, axis } => {
                on(sensor, axis, 0.5 * seen(sensor)[axis.index()].abs())
            }
            Parameter::OffDiagonal { sensor, element } => on(
                sensor,
                element.row(),
                seen(sensor)[element.column().index()],
            ),
            Parameter::GSensitivity { row, column } => {
                on(Sensor::Gyro, row, input.force[column.index()])
            }
            Parameter::G2Sensitivity { row, product } => {
                let [x, y, z] = input.force;
                let q = [x * x, y * y, z * z, x * y, x * z, y * z];
                on(Sensor::Gyro, row, q[usize::from(product).min(5)])
            }
            Parameter::AxisOffset { accel, component } => {
                let mut r = [0.0; 3];
                r[component.index()] = 1.0;
                let w = input.rate;
                let size = crate::attitude::add(
                    crate::attitude::cross(w, crate::attitude::cross(w, r)),
                    crate::attitude::cross(input.rate_dot, r),
                );
                on(Sensor::Accel, accel, size[accel.index()])
            }
        }
    }

    /// What the deterministic terms add to an input.
    pub(super) fn mean(&self, input: &Input) -> [f64; 6] {
        let truth = Truth {
            specific_force: input.force,
            angular_rate: input.rate,
            angular_acceleration: input.rate_dot,
            temperature_c: input.temperature_c,
        };
        let y = self.forward.corrupt(&truth);
        std::array::from_fn(|i| {
            if i < 3 {
                y.gyro[i] - input.rate[i]
            } else {
                y.accel[i - 3] - input.force[i - 3]
            }
        })
    }
}
