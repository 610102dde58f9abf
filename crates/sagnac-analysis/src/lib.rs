//! Deviations, spectra and the joint estimate of noise parameters.

pub mod compare;
pub mod confidence;
pub mod deviation;
pub mod error;
pub mod fit;
pub mod noise_type;
pub mod plan;
pub mod spectrum;
pub mod streaming;
pub mod tau_grid;

pub use confidence::{Interval, chi_squared_interval};
pub use deviation::dynamic::{Window, dynamic};
pub use deviation::{Curve, Deviation, Estimate, deviations};
pub use error::Error;
pub use spectrum::{Density, Transforms, WelchStream, welch};
pub use streaming::DeviationStream;
pub use tau_grid::TauGrid;
