//! Calibration of inertial sensors from stations, hand-turned logs and temperature sweeps.

pub mod merge;
pub mod plan;
pub mod response;
pub mod schedule;
pub mod stations;
