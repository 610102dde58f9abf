//! All random terms of one axis: S(f) and σ²(τ) of their sum (independent terms add).

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::flicker_filter::FlickerGenerator;
use crate::frame::{FRAME, Frame, Generator, Scratch};
use crate::gauss_markov::GaussMarkovGenerator;
use crate::quantization::QuantizationGenerator;
use crate::ramp::RampGenerator;
use crate::random_walk::RandomWalkGenerator;
use crate::resonance::ResonanceGenerator;
use crate::sinusoid::SinusoidGenerator;
use crate::white::WhiteGenerator;
use crate::{
    Error, Flicker, GaussMarkov, Quantization, Ramp, RandomWalk, Resonance, Sinusoid, StreamKey,
    White,
};

/// The random terms of one axis in SI, two-sided; 0 (an empty list) where the axis lacks the term.
///
/// Unit u below is rad/s for a gyro and m/s² for an accelerometer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisNoise {
    /// Q, rad or m/s.
    pub quantization: Quantization,
    /// N, u·√s.
    pub white: White,
    /// B, u: the flicker process of `bias.instability`.
    pub flicker: Flicker,
    /// K, u/√s, of `noise.rate_random_walk` (`acceleration_random_walk`).
    pub random_walk: RandomWalk,
    /// K, u/√s, of `bias.instability` with `process = "random_walk"`: a second, independent walk.
    pub instability_random_walk: RandomWalk,
    /// R, u/s.
    pub ramp: Ramp,
    /// `noise.gauss_markov`; the place in the list chooses the stream, so keep entries of σ = 0.
    pub gauss_markov: Vec<GaussMarkov>,
    /// `bias.instability` with `process = "gauss_markov"`.
    pub instability_gauss_markov: GaussMarkov,
    /// `noise.resonances`; keep entries of σ = 0.
    pub resonance: Vec<Resonance>,
    /// `noise.sinusoids`; keep entries of amplitude 0.
    pub sinusoid: Vec<Sinusoid>,
}

impl AxisNoise {
    /// Two-sided PSD of the samples of all terms but ramp and sinusoids (which have lines, no
    /// density) at `frequency_hz`; averaging and aliasing included.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        self.quantization.psd(frequency_hz, dt_s)
            + self.white.psd(frequency_hz, dt_s)
            + self.flicker.psd(frequency_hz, dt_s)
            + self.random_walk.psd(frequency_hz, dt_s)
            + self.instability_random_walk.psd(frequency_hz, dt_s)
            + self.instability_gauss_markov.psd(frequency_hz, dt_s)
            + self
                .gauss_markov
                .iter()
                .map(|term| term.psd(frequency_hz, dt_s))
                .sum::<f64>()
            + self
                .resonance
                .iter()
                .map(|term| term.psd(frequency_hz, dt_s))
                .sum::<f64>()
    }

    /// Allan variance of the sum of all terms at τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        self.quantization.allan_variance(tau_s)
            + self.white.allan_variance(tau_s)
            + self.flicker.allan_variance(tau_s)
            + self.random_walk.allan_variance(tau_s)
            + self.instability_random_walk.allan_variance(tau_s)
            + self.ramp.allan_variance(tau_s)
            + self.instability_gauss_markov.allan_variance(tau_s)
            + self
                .gauss_markov
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
            + self
                .resonance
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
            + self
                .sinusoid
                .iter()
                .map(|term| term.allan_variance(tau_s))
                .sum::<f64>()
    }
}

/// The names of `--noise`, as a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TermSet(u16);

impl TermSet {
    /// Every name with its bit, in the order of the documentation.
    pub const NAMES: [&'static str; 9] = [
        "white",
        "quantization",
        "flicker",
        "random_walk",
        "ramp",
        "gauss_markov",
        "resonance",
        "sinusoid",
        "stability",
    ];
    /// All terms.
    pub const ALL: Self = Self(0x1ff);
    /// No term.
    pub const NONE: Self = Self(0);

    /// The set with the term of this name added; `None` if there is no such name.
    pub fn with(self, name: &str) -> Option<Self> {
        let bit = Self::NAMES.iter().position(|known| *known == name)?;
        Some(Self(self.0 | 1 << bit))
    }

    /// Whether the term of this name is in the set.
    pub fn has(self, name: &str) -> bool {
        Self::NAMES
            .iter()
            .position(|known| *known == name)
            .is_some_and(|bit| self.0 >> bit & 1 == 1)
    }
}

/// The samples of all random terms of one axis.
///
/// The terms are made in double precision by streams of their own and added in a fixed order, so
/// that no sample of a term depends on the others, on the lengths read, or on threads.
pub struct AxisGenerator {
    drift: Vec<Box<dyn Generator + Send>>,
    other: Vec<Box<dyn Generator + Send>>,
    drift_frame: Frame,
    total_frame: Frame,
    used: usize,
    scratch: Scratch,
}

impl AxisGenerator {
    /// The generator of `noise`, of the terms in `terms`, at sampling interval `dt_s`.
    ///
    /// `run_length_s` fixes where flicker levels off (an input of unknown length counts as 24 h).
    ///
    /// # Errors
    /// A sampling interval, run length, correlation time or frequency that is not positive; a
    /// parameter that is not finite; a damping outside (0, 1).
    pub fn new(
        noise: &AxisNoise,
        terms: TermSet,
        dt_s: f64,
        run_length_s: f64,
        key: StreamKey,
    ) -> Result<Self, Error> {
        Self::with_flicker(noise, terms, dt_s, run_length_s, key, &mut None)
    }

    /// The same with the filter of `flicker`, one of this sampling interval and run length, which is put there where there
    /// is none: many axes need it worked out only once.
    ///
    /// # Errors
    /// Those of [`AxisGenerator::new`].
    pub fn with_flicker(
        noise: &AxisNoise,
        terms: TermSet,
        dt_s: f64,
        run_length_s: f64,
        key: StreamKey,
        flicker: &mut Option<FlickerGenerator>,
    ) -> Result<Self, Error> {
        check(noise, dt_s, run_length_s)?;
        let mut drift: Vec<Box<dyn Generator + Send>> = Vec::new();
        let mut other: Vec<Box<dyn Generator + Send>> = Vec::new();
        if terms.has("white") && noise.white.density != 0.0 {
            other.push(Box::new(WhiteGenerator::new(noise.white, dt_s, key)));
        }
        if terms.has("quantization") && noise.quantization.coefficient != 0.0 {
            other.push(Box::new(QuantizationGenerator::new(
                noise.quantization,
                dt_s,
                key,
            )));
        }
        if terms.has("resonance") {
            for (place, term) in (1..).zip(&noise.resonance) {
                if term.sigma != 0.0 {
                    other.push(Box::new(ResonanceGenerator::new(*term, dt_s, key, place)));
                }
            }
        }
        if terms.has("sinusoid") {
            for (place, term) in (1..).zip(&noise.sinusoid) {
                if term.amplitude != 0.0 {
                    other.push(Box::new(SinusoidGenerator::new(*term, dt_s, key, place)));
                }
            }
        }
        if terms.has("flicker") && noise.flicker.coefficient != 0.0 {
            let first = flicker.get_or_insert_with(|| {
                FlickerGenerator::new(noise.flicker, dt_s, run_length_s, key)
            });
            drift.push(Box::new(first.another(noise.flicker, key)));
        }
        if terms.has("random_walk") {
            for (place, term) in (0..).zip([noise.random_walk, noise.instability_random_walk]) {
                if term.coefficient != 0.0 {
                    drift.push(Box::new(RandomWalkGenerator::new(term, dt_s, key, place)));
                }
            }
        }
        if terms.has("gauss_markov") {
            let list = core::iter::once(&noise.instability_gauss_markov);
            for (place, term) in (0..).zip(list.chain(&noise.gauss_markov)) {
                if term.sigma != 0.0 {
                    drift.push(Box::new(GaussMarkovGenerator::new(*term, dt_s, key, place)));
                }
            }
        }
        if terms.has("ramp") && noise.ramp.slope != 0.0 {
            drift.push(Box::new(RampGenerator::new(noise.ramp, dt_s)));
        }
        Ok(Self {
            drift,
            other,
            drift_frame: [0.0; FRAME],
            total_frame: [0.0; FRAME],
            used: FRAME,
            scratch: Scratch::default(),
        })
    }

    /// Whether no term is on.
    pub fn is_silent(&self) -> bool {
        self.drift.is_empty() && self.other.is_empty()
    }

    fn next_frame(&mut self) {
        self.drift_frame = [0.0; FRAME];
        for term in &mut self.drift {
            term.add_frame(&mut self.drift_frame, &mut self.scratch);
        }
        self.total_frame = self.drift_frame;
        for term in &mut self.other {
            term.add_frame(&mut self.total_frame, &mut self.scratch);
        }
        self.used = 0;
    }

    /// Adds the next samples of all terms to `out`; `scratch` is room to work in.
    ///
    /// The samples of [`AxisGenerator::fill`], added one term after the other: quicker where calls ask for whole frames.
    pub fn add_to(&mut self, out: &mut [f64], scratch: &mut Scratch) {
        let mut rest = 0;
        if self.used == FRAME {
            for frame in out.as_chunks_mut::<FRAME>().0 {
                for term in self.drift.iter_mut().chain(&mut self.other) {
                    term.add_frame(frame, scratch);
                }
                rest += FRAME;
            }
        }
        for piece in out[rest..].chunks_mut(FRAME) {
            let samples = &mut [0.0; FRAME][..piece.len()];
            self.fill(samples, None);
            for (to, sample) in piece.iter_mut().zip(samples) {
                *to += *sample;
            }
        }
    }

    /// Writes the next samples of the sum of all terms to `total` and of the in-run drift (flicker,
    /// random walk, Gauss–Markov, ramp) alone to `drift`; both slices as long as the shorter.
    pub fn fill(&mut self, mut total: &mut [f64], mut drift: Option<&mut [f64]>) {
        while !total.is_empty() {
            if self.used == FRAME {
                self.next_frame();
            }
            let count = total.len().min(FRAME - self.used);
            let range = self.used..self.used + count;
            let (head, rest) = core::mem::take(&mut total).split_at_mut(count);
            head.copy_from_slice(&self.total_frame[range.clone()]);
            total = rest;
            if let Some(drift) = &mut drift {
                let count = count.min(drift.len());
                let (head, rest) = core::mem::take(drift).split_at_mut(count);
                head.copy_from_slice(&self.drift_frame[range][..count]);
                *drift = rest;
            }
            self.used += count;
        }
    }
}

fn check(noise: &AxisNoise, dt_s: f64, run_length_s: f64) -> Result<(), Error> {
    let positive = |name, value: f64, unit| {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(Error::NotPositive { name, value, unit })
        }
    };
    let finite = |name, value: f64| {
        if value.is_finite() {
            Ok(())
        } else {
            Err(Error::NotFinite { name })
        }
    };
    positive("sampling interval", dt_s, "s")?;
    positive("run length", run_length_s, "s")?;
    finite("quantization noise", noise.quantization.coefficient)?;
    finite("white noise density", noise.white.density)?;
    finite("bias instability", noise.flicker.coefficient)?;
    finite("random walk", noise.random_walk.coefficient)?;
    finite("random walk", noise.instability_random_walk.coefficient)?;
    finite("ramp", noise.ramp.slope)?;
    let list = core::iter::once(&noise.instability_gauss_markov);
    for term in list.chain(&noise.gauss_markov) {
        finite("sigma of a Gauss-Markov process", term.sigma)?;
        if term.sigma != 0.0 {
            positive(
                "correlation time of a Gauss-Markov process",
                term.correlation_time_s,
                "s",
            )?;
        }
    }
    for term in &noise.resonance {
        finite("sigma of a resonance", term.sigma)?;
        if term.sigma != 0.0 {
            positive("frequency of a resonance", term.frequency_hz, "Hz")?;
            if !(term.damping > 0.0 && term.damping < 1.0) {
                return Err(Error::Damping {
                    value: term.damping,
                });
            }
        }
    }
    for term in &noise.sinusoid {
        finite("amplitude of a sinusoid", term.amplitude)?;
        if term.amplitude != 0.0 {
            positive("frequency of a sinusoid", term.frequency_hz, "Hz")?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn added_samples_are_the_filled_ones() {
        let noise = AxisNoise {
            white: White { density: 0.1 },
            flicker: Flicker { coefficient: 1.0 },
            random_walk: RandomWalk { coefficient: 0.3 },
            ..AxisNoise::default()
        };
        let key = StreamKey {
            seed: 5,
            run: 2,
            sensor: 1,
            axis: 0,
        };
        let new = || AxisGenerator::new(&noise, TermSet::ALL, 0.01, 60.0, key).unwrap();
        let mut want = alloc::vec![0.0; 6 * FRAME];
        new().fill(&mut want, None);
        let mut added = new();
        let mut got = alloc::vec![0.0; 6 * FRAME];
        let mut from = 0;
        for count in [2 * FRAME, 100, FRAME, 2 * FRAME - 100, FRAME] {
            added.add_to(&mut got[from..from + count], &mut Scratch::default());
            from += count;
        }
        for (got, want) in got.iter().zip(&want) {
            assert!((got - want).abs() < 1e-14, "{got} {want}");
        }
    }
}
