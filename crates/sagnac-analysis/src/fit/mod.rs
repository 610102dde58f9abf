//! The joint estimate of every noise term of one axis, with intervals, from the likelihood of its cosine transform.
//!
//! The log's coefficients c_j of the DCT-II are nearly independent with variance S(f_j)/dt at f_j = j/(2n·dt), so
//! −2 ln L = Σ_j [ln S(f_j) + c_j²·dt/S(f_j)]; S is the sum of the exact spectra of interval means, the mean and slow
//! regressors are profiled out. For white noise and random walk this is the exact likelihood. Sources: \[IEEE952\] for the
//! terms, \[Whittle1953\] for the likelihood.

#![allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "sets of free parameters are passed like the parameters beside them"
)]

mod across;
mod bins;
mod blocks;
mod checks;
mod coarse;
mod columns;
mod cumulant;
mod dct;
mod ends;
mod estimate;
mod fill;
mod filled_deviation;
mod goodness;
mod likelihood;
mod linear;
mod lines;
mod pool;
mod profile;
mod regress;
mod results;
mod runs;
mod select;
mod singles;
mod sinusoids;
mod spectra;
mod steps;
mod terms;
mod times;
mod tones;
mod transform;
mod types;

pub use estimate::estimate;
pub use filled_deviation::filled_deviation;
pub use pool::{PooledEstimate, estimate_pooled};
pub use runs::{RunToRun, Slope, run_to_run};

pub use types::{
    AxisData, AxisEstimate, Candidates, Covariance, Estimate, Finding, FindingKind, FitOptions,
    GaussMarkovEstimate, Level, NoiseTerms, Regressor, RegressorKind, Segment, SinusoidEstimate,
    SpectrumBin, Status, Term,
};

/// What planning shares with the fit.
pub(crate) mod internal {
    pub(crate) use super::bins::BinnedLog;
    pub(crate) use super::likelihood::Problem;
    pub(crate) use super::linear::inverse;
    pub(crate) use super::regress::line_information;
}
