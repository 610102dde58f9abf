//! Calibration of inertial sensors from stations, hand-turned logs and temperature sweeps.

pub mod response;
pub mod stations;
