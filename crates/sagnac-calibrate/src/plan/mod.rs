//! Plans of tests: which stations, and the standard errors that they will give.
//!
//! ```
//! use sagnac_calibrate::plan::{Errors, predict, six_position};
//! use sagnac_calibrate::stations::Options;
//! let errors = Errors { gyro: [1e-4; 3], accel: [1e-3; 3], tilt_rad: 0.0 };
//! let found = predict(&six_position(9.80665), errors, &Options::default())?;
//! assert!((found.parameter("accel.bias.x").unwrap().sigma - 4.08e-4).abs() < 1e-6);
//! # Ok::<(), sagnac_calibrate::stations::Error>(())
//! ```

mod design;
mod tables;

pub use design::{Goal, design};
pub use tables::{centrifuge, chamber, rate_table, six_position, tumble24};

use crate::stations::{self, Error, Options, Outcome, Station, reference::tilt_sigma};

/// Standard errors of the means of a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Gyro \[rad/s\].
    pub gyro: [f64; 3],
    /// Accelerometer \[m/s²\].
    pub accel: [f64; 3],
    /// Levelling \[rad\].
    pub tilt_rad: f64,
}

impl Errors {
    /// Those of the mean of so many independent repeats.
    #[must_use]
    pub fn of_repeats(self, repeats: f64) -> Self {
        let root = repeats.sqrt();
        Self {
            gyro: self.gyro.map(|e| e / root),
            accel: self.accel.map(|e| e / root),
            tilt_rad: self.tilt_rad / root,
        }
    }

    /// The stations with outputs of a sensor without errors, and these standard errors.
    pub fn put_on(self, stations: &[Station], gravity_m_s2: f64) -> Vec<Station> {
        stations
            .iter()
            .map(|s| {
                let size = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
                Station {
                    accel: Some(s.f),
                    accel_se: Some(self.accel),
                    gyro: Some(s.w),
                    gyro_se: Some(self.gyro),
                    f_sigma: tilt_sigma(s.f, gravity_m_s2.min(size(s.f)), self.tilt_rad),
                    w_sigma: tilt_sigma(s.w, size(s.w), self.tilt_rad),
                    ..s.clone()
                }
            })
            .collect()
    }
}

/// What stations will give: standard errors, what they cannot tell, which to add.
///
/// # Errors
/// As [`stations::calibrate`].
pub fn predict(stations: &[Station], errors: Errors, options: &Options) -> Result<Outcome, Error> {
    stations::calibrate(&errors.put_on(stations, options.gravity_m_s2), options)
}

/// Names and standard errors of what stations determine, without the rest of [`predict`].
pub fn sigmas(stations: &[Station], errors: Errors, options: &Options) -> Vec<(String, f64)> {
    stations::sigmas(&errors.put_on(stations, options.gravity_m_s2), options)
}
