//! Exact discrete generators of every random error of an inertial sensor.
//!
//! Each term is defined by its two-sided PSD in rate (acceleration); a sample is the mean over its
//! interval, so that the Allan variances hold exactly at every τ = m·dt (`[IEEE952]`). SI units.
#![no_std]
#![allow(
    clippy::inline_always,
    reason = "bodies compiled once for each vector width must be inlined into each"
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "alloc")]
mod axis;
mod dispatch;
mod error;
mod flicker;
mod flicker_filter;
mod frame;
mod gauss_markov;
mod gaussian;
mod math;
mod quantization;
mod ramp;
mod random_walk;
mod resonance;
mod sinusoid;
mod stream;
mod white;

#[cfg(feature = "alloc")]
pub use axis::{AxisGenerator, AxisNoise, TermSet};
pub use error::Error;
pub use flicker::Flicker;
pub use flicker_filter::FlickerGenerator;
pub use frame::{FRAME, Frame, Generator, Scratch};
pub use gauss_markov::{GaussMarkov, GaussMarkovGenerator};
pub use gaussian::Normals;
pub use quantization::{Quantization, QuantizationGenerator};
pub use ramp::{Ramp, RampGenerator};
pub use random_walk::{RandomWalk, RandomWalkGenerator};
pub use resonance::{Resonance, ResonanceGenerator};
pub use sinusoid::{Sinusoid, SinusoidGenerator};
pub use stream::{Purpose, Stream, StreamKey};
pub use white::{White, WhiteGenerator};
