//! Sensor model files, quantities with units as text, the sensor catalogue and exporters.

mod calibration;
mod catalog_table;
pub mod catalogue;
pub mod emit;
mod entry;
mod error;
pub mod export;
pub mod foreign;
mod json;
mod model;
mod path;
mod random;
mod read;
mod schema;
mod suggest;
mod to_core;
mod tree;
pub mod units;
mod write;

pub use calibration::Calibration;
pub use catalog_table::{CatalogTable, Conflict, OtherValue, PRICE_CLASSES};
pub use catalogue::{Catalogue, Filter, SortKey};
pub use entry::Entry;
pub use error::Error;
pub use model::{Model, Process, ThermalTerm};
pub use path::ParameterPath;
pub use random::{FLICKER_FLOOR, Stability};
pub use suggest::suggest;
