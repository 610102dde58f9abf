//! The inertial measurement model and its inverse, without std and without heap.
//!
//! # The model in two equations
//!
//! Three accelerometers and three gyroscopes feel the specific force f and the angular rate ω of the body
//! (x forward, y right, z down), and each reads them with its own errors (slides are those of the lecture):
//!
//! ```text
//!                f'_k = f_k + [ω × (ω × r_k) + ω̇ × r_k]_k           size effect, slide 10
//! equation 1     f~   = b_a + (I + M_a) f' + N_a(f')
//! equation 2     ω~   = b_g + (I + M_g) ω  + N_g(ω) + G_g f + H_g q(f)
//! output         y    = round(saturate(low-pass(f~ or ω~, + random terms)))
//!
//! N_k(u) = k2_k u_k² + k3_k u_k³ + ½ a_k |u_k|       q(f) = (fx², fy², fz², fx·fy, fx·fz, fy·fz)
//! ```
//!
//! Each term is a type with a file of its own, its equation and an example that runs:
//!
//! | symbol | term | type | slide |
//! |---|---|---|---|
//! | b | fixed bias, with temperature | [`Bias`], [`TemperatureDependence`] | 4 |
//! | M, diagonal | scale factor error, with temperature | [`ScaleFactorError`] | 5 |
//! | N: k2, k3 | nonlinearity | [`Nonlinearity`] | 5 |
//! | N: a | asymmetry | [`Asymmetry`] | 5 |
//! | M, off the diagonal | misalignment | [`Misalignment`] | 6 |
//! | M, off the diagonal | cross-axis response | [`CrossAxis`] | 7 |
//! | G_g | g-sensitivity | [`GSensitivity`] | 9 |
//! | H_g | g²-sensitivity, anisoelasticity | [`G2Sensitivity`] | 9 |
//! | r_k | axis offset, the size effect | [`AxisOffset`] | 10 |
//! | low-pass | bandwidth | [`Bandwidth`], [`LowPass`] | 2 |
//! | saturate | range | [`Range`] | 2 |
//! | round | resolution, of rates or increments | [`Resolution`] | 2, 8 |
//!
//! Bias stability, what changes from run to run, is a [`Draw`] added to the fixed parts; bias instability and
//! the noise of slide 8 are the random terms of the crate `sagnac-noise`.
//!
//! # Forwards
//!
//! A [`SensorModel`] holds the numbers, a [`Measurement`] puts them on. Equation 1 on one axis, by hand and by
//! the library:
//!
//! ```
//! use sagnac_core::{Measurement, SensorModel, Truth};
//!
//! let mut model = SensorModel::<f64>::default();
//! model.accel.bias.fixed = [0.02, 0.0, 0.0]; // b_a
//! model.accel.scale_factor.fixed = [1e-3, 0.0, 0.0]; // M_xx
//! model.accel.misalignment.elements.xz = 2e-3; // M_xz: the x axis leans towards z
//! model.accel_axis_offset.position[0] = [0.05, 0.0, 0.0]; // r_x
//!
//! let truth = Truth {
//!     specific_force: [1.0, 0.0, -9.8],
//!     angular_rate: [0.0, 0.0, 2.0],
//!     ..Truth::default()
//! };
//! let sensed = 1.0 - 2.0 * 2.0 * 0.05; // f'_x: the spin pulls the accelerometer inwards
//! let by_hand = 0.02 + (1.0 + 1e-3) * sensed + 2e-3 * -9.8;
//! let reading = Measurement::new(&model).corrupt(&truth);
//! assert!((reading.accel[0] - by_hand).abs() < 1e-15);
//! ```
//!
//! # Backwards
//!
//! [`Compensation`] takes the errors out again. The two equations are coupled (ω moves the accelerometers, f
//! disturbs the gyroscopes) and nonlinear, so it goes round: bias off, inverse matrix, size effect off, and
//! again, as often as the [`Bound`] of the model asks for. Inside the bound the way there and back loses no
//! more than 1e-12 of the scale in `f64` (2⁻¹⁸ in `f32`); outside it every sample is [flagged](flags).
//!
//! ```
//! use sagnac_core::{Compensation, Measurement, SensorModel, Truth};
//!
//! let mut model = SensorModel::<f64>::default();
//! model.gyro.range.limit = [8.0; 3];
//! model.accel.range.limit = [160.0; 3];
//! model.gyro.bias.fixed = [0.01, -0.02, 0.005];
//! model.gyro.scale_factor.fixed = [0.02; 3];
//! model.gyro_g_sensitivity.matrix[1][2] = 1e-4; // f_z turns the y gyro
//!
//! let truth = Truth {
//!     specific_force: [0.5, -0.2, -9.8],
//!     angular_rate: [1.0, 2.0, -3.0],
//!     ..Truth::default()
//! };
//! let inverse = Compensation::new(&model, 0.01)?;
//! let back = inverse.correct(&Measurement::new(&model).corrupt(&truth));
//! for k in 0..3 {
//!     assert!((back.gyro[k] - truth.angular_rate[k]).abs() < 1e-14);
//! }
//! assert_eq!(back.flags, 0);
//!
//! // A gyroscope that reads nothing (s = −1) has no inverse: refused rather than silently wrong.
//! model.gyro.scale_factor.fixed = [-1.0; 3];
//! assert!(Compensation::new(&model, 0.01).is_err());
//! # Ok::<(), sagnac_core::CompensationError>(())
//! ```
//!
//! Many samples at once, in vector instructions: [`Measurement::corrupt_block`] and
//! [`Compensation::correct_block`]. What a microcontroller pays for one sample stands in `EMBEDDED.md`.
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
