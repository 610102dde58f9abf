//! Quantisation noise: S(f) = (4Q²/dt) sin²(πf dt), σ²(τ) = 3Q²/τ², `[IEEE952]` annex C.
//!
//! Sample = (q_k − q_{k−1})/dt with q_k independent, uniform on ±√3·Q.

use crate::frame::{Frame, Generator, Scratch};
use crate::math::sin2_pi;
use crate::stream::{BLOCK, Purpose, Stream, StreamKey};

/// Quantisation noise of coefficient Q (rad, or m/s for an accelerometer).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quantization {
    /// Q, the standard deviation of the angle's (velocity's) error.
    pub coefficient: f64,
}

impl Quantization {
    /// Two-sided PSD of interval means at `frequency_hz`: 4Q² sin²(πf dt)/dt.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        4.0 * self.coefficient * self.coefficient * sin2_pi(frequency_hz * dt_s) / dt_s
    }

    /// Allan variance 3Q²/τ², exact at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        3.0 * self.coefficient * self.coefficient / (tau_s * tau_s)
    }

    /// Standard deviation √2·Q/dt of one sample.
    pub fn sample_sigma(&self, dt_s: f64) -> f64 {
        core::f64::consts::SQRT_2 * self.coefficient / dt_s
    }
}

/// Quantisation noise samples: (q_k − q_{k−1})/dt.
#[derive(Debug, Clone)]
pub struct QuantizationGenerator {
    stream: Stream,
    /// √3·Q/dt.
    scale: f64,
    last: f64,
}

impl QuantizationGenerator {
    /// Quantisation noise at sampling interval `dt_s` on the streams of `key`.
    pub fn new(term: Quantization, dt_s: f64, key: StreamKey) -> Self {
        let scale = libm::sqrt(3.0) * term.coefficient / dt_s;
        let mut words = [0; BLOCK];
        key.stream(Purpose::Quantization, 1).next_block(&mut words);
        Self {
            stream: key.stream(Purpose::Quantization, 0),
            scale,
            last: scale * symmetric_uniform(words[0]),
        }
    }
}

/// Uniform on [−1, 1) from the upper 52 bits; its mean is 2⁻⁵² off 0.
fn symmetric_uniform(word: u64) -> f64 {
    f64::from_bits(word >> 12 | 0x4000_0000_0000_0000) - 3.0
}

impl Generator for QuantizationGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        for half in frame.as_chunks_mut::<BLOCK>().0 {
            self.stream.next_block(&mut scratch.words);
            for (sample, word) in half.iter_mut().zip(&scratch.words) {
                let now = self.scale * symmetric_uniform(*word);
                *sample += now - self.last;
                self.last = now;
            }
        }
    }
}
