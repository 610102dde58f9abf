//! Sensor model files, quantities with units as text, the sensor catalogue and exporters.

mod suggest;
pub mod units;

pub use suggest::suggest;
