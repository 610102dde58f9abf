//! Deviations, spectra and the joint estimate of noise parameters.

pub mod fit;
