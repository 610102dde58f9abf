//! Sinusoid: lines A²/4 at ±f₀, σ²(τ) = A² (sin²(πf₀τ)/(πf₀τ))², `[IEEE952]` annex C.
//!
//! Sample = A·sinc(f₀dt)·sin(2πf₀(t_k − dt/2) + φ), φ uniform, drawn for every run and axis.

use core::f64::consts::PI;

use crate::frame::{FRAME, Frame, Generator, Scratch};
use crate::math::{sin2_pi, sinc};
use crate::stream::{BLOCK, Purpose, StreamKey};

/// Sinusoid of amplitude A (rad/s, or m/s²) and frequency f₀.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sinusoid {
    /// A, amplitude before averaging.
    pub amplitude: f64,
    /// f₀, Hz.
    pub frequency_hz: f64,
}

impl Sinusoid {
    /// Amplitude A·sinc(f₀dt) of the interval means.
    pub fn sample_amplitude(&self, dt_s: f64) -> f64 {
        self.amplitude * sinc(self.frequency_hz * dt_s)
    }

    /// Allan variance A² (sin²(πf₀τ)/(πf₀τ))², the mean over all phases.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        let x = PI * self.frequency_hz * tau_s;
        if self.amplitude == 0.0 || x == 0.0 {
            return 0.0;
        }
        let shape = sin2_pi(self.frequency_hz * tau_s) / x;
        self.amplitude * self.amplitude * shape * shape
    }
}

const LANES: usize = 8;

/// Sinusoid samples, by turning a phasor that is set anew at the start of every frame.
#[derive(Debug, Clone)]
pub struct SinusoidGenerator {
    amplitude: f64,
    /// f₀dt and φ/2π, turns.
    step_turns: f64,
    phase_turns: f64,
    count: f64,
}

impl SinusoidGenerator {
    /// Sinusoid at sampling interval `dt_s`; `place` counts the list of `noise` from 1.
    pub fn new(term: Sinusoid, dt_s: f64, key: StreamKey, place: u32) -> Self {
        let mut words = [0; BLOCK];
        key.stream(Purpose::Sinusoid, place).next_block(&mut words);
        Self {
            amplitude: term.sample_amplitude(dt_s),
            step_turns: term.frequency_hz * dt_s,
            phase_turns: ((words[0] >> 11) as f64 + 0.5) * (f64::EPSILON / 2.0),
            count: 0.0,
        }
    }

    /// φ, rad, of the run and axis.
    pub fn phase_rad(&self) -> f64 {
        2.0 * PI * self.phase_turns
    }
}

fn phasor(turns: f64) -> (f64, f64) {
    let angle = 2.0 * PI * (turns - libm::round(turns));
    (libm::cos(angle), libm::sin(angle))
}

impl Generator for SinusoidGenerator {
    fn add_frame(&mut self, frame: &mut Frame, _scratch: &mut Scratch) {
        // f₀dt in two parts: the first times a count is exact, so that whole turns drop out.
        let coarse = libm::floor(self.step_turns * 65536.0) / 65536.0;
        let fine = self.step_turns - coarse;
        let middle = self.count + 0.5;
        let whole = coarse * middle;
        let start = (whole - libm::floor(whole)) + fine * middle + self.phase_turns;
        let mut lanes: [(f64, f64); LANES] =
            core::array::from_fn(|k| phasor(start + k as f64 * self.step_turns));
        let (turn_cos, turn_sin) = phasor(LANES as f64 * self.step_turns);
        for group in frame.as_chunks_mut::<LANES>().0 {
            for (sample, (cos, sin)) in group.iter_mut().zip(&mut lanes) {
                *sample += self.amplitude * *sin;
                let turned = *cos * turn_cos - *sin * turn_sin;
                *sin = *cos * turn_sin + *sin * turn_cos;
                *cos = turned;
            }
        }
        self.count += FRAME as f64;
    }
}
