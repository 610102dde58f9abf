//! From motion to what an inertial sensor's errors do to a position: the Earth, closed-form trajectories, the strapdown
//! algorithm, error covariance and Monte Carlo, grades and budgets.
//!
//! Frames: `e` Earth-fixed (x through longitude 0, z through the north pole), `i` inertial (equal to `e` at t = 0),
//! `n` local north, east, down, `b` body (x forward, y right, z down). `e_from_b` is the matrix whose product with a
//! body vector gives the Earth-fixed vector. SI units throughout; angles in radians.
//!
//! ```
//! use sagnac_nav::{Earth, Start, Trajectory};
//! let drive = Trajectory::named("drive", Earth::Wgs84, &Start::default())?;
//! let first = drive.samples(0.01).next().expect("no trajectory ends");
//! assert!((first.force_m_s2[2] + 9.8).abs() < 0.2);
//! # Ok::<(), sagnac_nav::Error>(())
//! ```

pub mod attitude;
pub mod covariance;
pub mod drift;
pub mod earth;
pub mod ellipse;
mod error;
pub mod monte_carlo;
pub mod sensor;
pub mod spline;
pub mod strapdown;
pub mod trajectory;

pub use earth::Earth;
pub use error::Error;
pub use trajectory::{Motion, Start, Trajectory, TruthSample};
