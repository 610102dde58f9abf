//! White noise (angle or velocity random walk): S(f) = N², σ²(τ) = N²/τ, `[IEEE952]` annex C.
//!
//! The mean of white noise over dt has the standard deviation N/√dt, never N, never N·√dt.

use crate::dispatch::dispatch;
use crate::frame::{Frame, Generator, Scratch};
use crate::stream::{Purpose, Stream, StreamKey};

/// White noise of two-sided density N.
///
/// Unit of N: rad/√s (gyro, "angle random walk") or m/s/√s (accelerometer, "velocity random walk").
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct White {
    /// N, the square root of the two-sided PSD in rate (acceleration).
    pub density: f64,
}

impl White {
    /// Two-sided PSD of interval means at `frequency_hz`: N², at every frequency.
    pub fn psd(&self, _frequency_hz: f64, _dt_s: f64) -> f64 {
        self.density * self.density
    }

    /// Allan variance N²/τ, exact for interval means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        self.density * self.density / tau_s
    }

    /// Standard deviation N/√dt of one sample.
    pub fn sample_sigma(&self, dt_s: f64) -> f64 {
        self.density / libm::sqrt(dt_s)
    }
}

/// White noise samples: N/√dt·n_k.
#[derive(Debug, Clone)]
pub struct WhiteGenerator {
    stream: Stream,
    sigma: f64,
}

impl WhiteGenerator {
    /// White noise at sampling interval `dt_s` on the stream of `key`.
    pub fn new(term: White, dt_s: f64, key: StreamKey) -> Self {
        Self {
            stream: key.stream(Purpose::White, 0),
            sigma: term.sample_sigma(dt_s),
        }
    }
}

impl Generator for WhiteGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        scratch.next_normals(&mut self.stream);
        add_scaled(self.sigma, &scratch.normals, frame);
    }
}

#[inline(always)]
fn add_scaled_body(sigma: f64, normals: &Frame, frame: &mut Frame) {
    for (sample, normal) in frame.iter_mut().zip(normals) {
        *sample += sigma * normal;
    }
}

dispatch! {
    fn add_scaled(sigma: f64, normals: &Frame, frame: &mut Frame) = add_scaled_body;
}
