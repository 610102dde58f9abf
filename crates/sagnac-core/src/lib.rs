//! The inertial measurement model and its inverse, without std and without heap.
#![no_std]
#![allow(
    clippy::inline_always,
    reason = "a term becomes vector code only where it is inlined into the loop over samples"
)]

#[cfg(any(test, feature = "simd"))]
extern crate std;

mod asymmetry;
mod axes;
mod axis_offset;
mod bandwidth;
mod bias;
mod block;
mod bound;
mod compensation;
mod cross_axis;
mod g2_sensitivity;
mod g_sensitivity;
mod measurement;
mod misalignment;
mod model;
mod nonlinearity;
mod output;
mod range;
mod real;
mod resolution;
mod sample;
mod scale_factor;
pub mod simd;
mod temperature;
pub mod vector;

pub use asymmetry::Asymmetry;
pub use axes::{Axis, Element, PRODUCT_KEYS, Sensor};
pub use axis_offset::AxisOffset;
pub use bandwidth::{Bandwidth, LowPass};
pub use bias::Bias;
pub use block::{CorrectedBlock, OutputBlock, ReadingBlock, TruthBlock};
pub use bound::{Bound, BoundTerms, CompensationError};
pub use compensation::Compensation;
pub use cross_axis::CrossAxis;
pub use g_sensitivity::GSensitivity;
pub use g2_sensitivity::G2Sensitivity;
pub use measurement::{Measurement, NonlinearPart, TriadErrors};
pub use misalignment::{Misalignment, OffDiagonal};
pub use model::{DEFAULT_REFERENCE_C, Draw, SensorModel, Triad};
pub use nonlinearity::Nonlinearity;
pub use output::OutputStage;
pub use range::Range;
pub use real::Real;
pub use resolution::{Output, Resolution};
pub use sample::{Corrected, Reading, Truth, flags};
pub use scale_factor::ScaleFactorError;
pub use temperature::{
    DEFAULT_RANGE_C, MAX_KNOTS, MAX_POWER, Segment, SplineError, TemperatureDependence,
    TemperatureSpline, Thermal,
};
