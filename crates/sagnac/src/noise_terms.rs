//! The random terms of a model's axis as the analysis takes them.
//!
//! Processes of one spectrum are one term: the random walk of `noise` and that of `bias.instability` add in quadrature.

use sagnac_analysis::fit::NoiseTerms;
use sagnac_core::Sensor;
use sagnac_model::Model;

/// Q, N, B, K, R, Gauss–Markov processes and lines of one axis.
pub(crate) fn of_axis(model: &Model, sensor: Sensor, axis: usize) -> NoiseTerms {
    let noise = model.axis_noise(sensor, axis);
    let mut gauss_markov: Vec<(f64, f64)> = noise
        .gauss_markov
        .iter()
        .map(|g| (g.sigma, g.correlation_time_s))
        .collect();
    let own = noise.instability_gauss_markov;
    if own.sigma > 0.0 {
        gauss_markov.push((own.sigma, own.correlation_time_s));
    }
    NoiseTerms {
        quantization: noise.quantization.coefficient,
        white: noise.white.density,
        flicker: noise.flicker.coefficient,
        random_walk: noise
            .random_walk
            .coefficient
            .hypot(noise.instability_random_walk.coefficient),
        ramp: noise.ramp.slope,
        gauss_markov,
        sinusoids: noise
            .sinusoid
            .iter()
            .filter(|s| s.amplitude > 0.0)
            .map(|s| (s.amplitude, s.frequency_hz))
            .collect(),
    }
}
