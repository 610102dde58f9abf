//! Deviations, spectra and the joint estimate of noise parameters.
