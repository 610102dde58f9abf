//! Exact discrete generators of every random error of an inertial sensor.
//!
//! Each term is defined by its two-sided PSD in rate (acceleration); a sample is the mean over its
//! interval, so that the Allan variances hold exactly at every τ = m·dt (`[IEEE952]`). SI units.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "alloc")]
mod axis;
mod flicker;
mod gauss_markov;
mod math;
mod quantization;
mod ramp;
mod random_walk;
mod resonance;
mod sinusoid;
mod white;

#[cfg(feature = "alloc")]
pub use axis::AxisNoise;
pub use flicker::Flicker;
pub use gauss_markov::GaussMarkov;
pub use quantization::Quantization;
pub use ramp::Ramp;
pub use random_walk::RandomWalk;
pub use resonance::Resonance;
pub use sinusoid::Sinusoid;
pub use white::White;
