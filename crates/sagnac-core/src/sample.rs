//! One sample of truth and one of output; both are means over the sampling interval.

use crate::{DEFAULT_REFERENCE_C, Real, vector::Vector};

/// What really happened over an interval: the input of the forward model.
///
/// The default is 25 °C and all else zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth<T> {
    /// f, the specific force at the IMU centre in body axes, m/s².
    pub specific_force: Vector<T>,
    /// ω, the angular rate against inertial space in body axes, rad/s.
    pub angular_rate: Vector<T>,
    /// ω̇, rad/s².
    pub angular_acceleration: Vector<T>,
    /// T, °C.
    pub temperature_c: T,
}

impl<T: Real> Default for Truth<T> {
    fn default() -> Self {
        Self {
            specific_force: [T::ZERO; 3],
            angular_rate: [T::ZERO; 3],
            angular_acceleration: [T::ZERO; 3],
            temperature_c: T::from_f64(DEFAULT_REFERENCE_C),
        }
    }
}

/// What the sensor put out: the input of the inverse.
///
/// The default is 25 °C and all else zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<T> {
    /// y_g, rad/s.
    pub gyro: Vector<T>,
    /// y_a, m/s².
    pub accel: Vector<T>,
    /// ω̇, rad/s², for the size effect (model or measured elsewhere, not of this sensor).
    pub gyro_rate: Vector<T>,
    /// T, °C.
    pub temperature_c: T,
}

impl<T: Real> Default for Reading<T> {
    fn default() -> Self {
        Self {
            gyro: [T::ZERO; 3],
            accel: [T::ZERO; 3],
            gyro_rate: [T::ZERO; 3],
            temperature_c: T::from_f64(DEFAULT_REFERENCE_C),
        }
    }
}

/// A corrected sample with its flags.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Corrected<T> {
    /// ω, rad/s.
    pub gyro: Vector<T>,
    /// f at the IMU centre, m/s².
    pub accel: Vector<T>,
    /// The sum of [`flags`](crate::flags).
    pub flags: u32,
}

/// Bits of a corrected sample.
pub mod flags {
    /// A gyroscope is saturated.
    pub const GYRO_SATURATED: u32 = 1;
    /// An accelerometer is saturated.
    pub const ACCEL_SATURATED: u32 = 2;
    /// The temperature is outside the stated range (the nearer end was taken).
    pub const TEMPERATURE: u32 = 4;
    /// Outside validity: the model or this sample is outside the convergence bound, the
    /// solution left the box, or the temperature is beyond −40…85 °C where none is stated.
    pub const OUTSIDE_VALIDITY: u32 = 8;
    /// A value that is needed, or the result, is not finite; the result is NaN.
    pub const NOT_FINITE: u32 = 16;
}
