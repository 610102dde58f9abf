//! The true motion by channel, as every run of a Monte Carlo reads it: interval means of specific force, angular rate and
//! angular acceleration, temperature, and what the vertical channel is held to.

use crate::attitude::Vec3;
use crate::trajectory::{Trajectory, TruthSample};
use rayon::prelude::*;

/// Truth by channel.
#[derive(Default)]
pub(super) struct Channels {
    pub(super) force: [Vec<f64>; 3],
    pub(super) rate: [Vec<f64>; 3],
    pub(super) rate_dot: [Vec<f64>; 3],
    pub(super) temperature: Vec<f64>,
    pub(super) vertical: Vec<[f64; 2]>,
}

impl Channels {
    pub(super) fn of(
        samples: &[TruthSample],
        dt_s: f64,
        temperature: &(dyn Fn(f64) -> f64 + Sync),
    ) -> Self {
        let channel = |get: fn(&TruthSample) -> Vec3| {
            std::array::from_fn(|i| samples.iter().map(|s| get(s)[i]).collect())
        };
        Self {
            force: channel(|s| s.force_m_s2),
            rate: channel(|s| s.rate_rad_s),
            rate_dot: channel(|s| s.rate_dot_rad_s2),
            temperature: samples
                .iter()
                .map(|s| temperature(s.time_s - 0.5 * dt_s))
                .collect(),
            vertical: samples.iter().map(|s| [s.height_m, s.climb_m_s]).collect(),
        }
    }
}

/// The truth of `count` samples after the first `from`.
pub(super) fn segment(
    trajectory: &Trajectory,
    dt: f64,
    from: u64,
    count: usize,
    temperature: &(dyn Fn(f64) -> f64 + Sync),
) -> Channels {
    let mut samples = vec![TruthSample::default(); count];
    let stream = trajectory.samples(dt);
    samples
        .par_chunks_mut(4096)
        .enumerate()
        .for_each(|(i, chunk)| {
            let mut stream = stream.clone();
            stream.seek(from + 4096 * i as u64);
            stream.fill(chunk);
        });
    Channels::of(&samples, dt, temperature)
}
