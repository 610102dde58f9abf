//! Calibration of inertial sensors from stations, hand-turned logs and temperature sweeps.

mod interval;
pub mod merge;
pub mod multi_position;
pub mod plan;
pub mod response;
pub mod schedule;
pub mod stations;
pub mod thermal;
