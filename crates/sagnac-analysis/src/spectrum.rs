//! Power spectral density by Welch's method: Hann window, half overlap, mean removed.
//!
//! S(f_j) = mean over pieces of 2·dt·|Σ w_k y_k e^{−2πi jk/L}|²/Σ w_k², one-sided
//! `[WELCH]`.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use crate::error::Error;

/// The longest piece.
const LONGEST: usize = 1 << 20;
/// The least samples in a row that give a spectrum: eight pieces of two.
const LEAST: usize = 16;

/// A one-sided power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// Frequencies in Hz, from one step above zero to Nyquist.
    pub frequency_hz: Vec<f64>,
    /// One-sided density, the unit of the samples squared per Hz: twice the two-sided S of the
    /// noise terms.
    pub density: Vec<f64>,
    /// Pieces averaged.
    pub pieces: usize,
}

/// The length of the pieces where the longest stretch has so many samples.
fn piece_length(longest: usize) -> usize {
    (1 << (longest / 8).max(2).ilog2()).min(LONGEST)
}

/// What pieces of one length are transformed with.
struct Piece {
    window: Vec<f64>,
    transform: Arc<dyn RealToComplex<f64>>,
    input: Vec<f64>,
    output: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Piece {
    fn new(length: usize) -> Self {
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
        Self {
            window: hann(length).collect(),
            input: transform.make_input_vec(),
            output: transform.make_output_vec(),
            scratch: transform.make_scratch_vec(),
            transform,
        }
    }

    /// Adds |transform|² of a piece without its mean to `sums`, from one step above zero on.
    fn add(&mut self, piece: &[f64], sums: &mut [f64]) {
        let mean = piece.iter().sum::<f64>() / piece.len() as f64;
        for ((to, from), w) in self.input.iter_mut().zip(piece).zip(&self.window) {
            *to = (from - mean) * w;
        }
        // The lengths are those of the plan: this cannot fail.
        if self
            .transform
            .process_with_scratch(&mut self.input, &mut self.output, &mut self.scratch)
            .is_ok()
        {
            for (sum, value) in sums.iter_mut().zip(&self.output[1..]) {
                *sum += value.norm_sqr();
            }
        }
    }
}

fn hann(length: usize) -> impl Iterator<Item = f64> {
    let turn = std::f64::consts::TAU / length as f64;
    (0..length).map(move |k| 0.5 - 0.5 * (turn * k as f64).cos())
}

/// The density of sums over so many pieces.
fn density(length: usize, sums: &[f64], pieces: usize, dt_s: f64) -> Density {
    let weight: f64 = hann(length).map(|w| w * w).sum();
    let scale = 2.0 * dt_s / weight / pieces as f64;
    let mut density: Vec<f64> = sums.iter().map(|sum| scale * sum).collect();
    // Nyquist stands for itself alone, the others also for their negative frequencies.
    if let Some(last) = density.last_mut() {
        *last /= 2.0;
    }
    let step_hz = 1.0 / (length as f64 * dt_s);
    Density {
        frequency_hz: (1..=length / 2).map(|j| j as f64 * step_hz).collect(),
        density,
        pieces,
    }
}

fn check(longest: usize, dt_s: f64) -> Result<(), Error> {
    if !(dt_s.is_finite() && dt_s > 0.0) {
        return Err(Error::NotPositive {
            name: "the sampling step",
            value_s: dt_s,
        });
    }
    if longest < LEAST {
        return Err(Error::TooShort {
            kind: "a spectrum",
            needed: LEAST,
            found: longest,
        });
    }
    Ok(())
}

/// Welch's one-sided density of one axis.
///
/// `segments` as in [`crate::deviations`]. The pieces have the largest power of two ≤ N/8
/// samples of the longest segment, at most 2²⁰; those of all segments are averaged. The mean of
/// each piece is taken out, so the density at zero frequency is not given.
///
/// # Errors
/// [`Error::NotPositive`] for a step that is not; [`Error::TooShort`] below 16 samples in a row.
pub fn welch(segments: &[&[f64]], dt_s: f64) -> Result<Density, Error> {
    let longest = segments.iter().map(|s| s.len()).max().unwrap_or(0);
    check(longest, dt_s)?;
    let length = piece_length(longest);
    let pieces: Vec<&[f64]> = segments
        .iter()
        .flat_map(|segment| segment.windows(length).step_by(length / 2))
        .collect();
    // Fixed batches, added in order: the same bits for any number of threads.
    let batches: Vec<Vec<f64>> = pieces
        .par_chunks(pieces.len().div_ceil(16))
        .map(|batch| {
            let mut work = Piece::new(length);
            let mut sums = vec![0.0; length / 2];
            for piece in batch {
                work.add(piece, &mut sums);
            }
            sums
        })
        .collect();
    let mut sums = vec![0.0; length / 2];
    for batch in batches {
        for (total, sum) in sums.iter_mut().zip(batch) {
            *total += sum;
        }
    }
    Ok(density(length, &sums, pieces.len(), dt_s))
}

/// Welch's density of samples that come one after another, in memory that does not grow with them.
///
/// The length of the pieces is that of [`welch`], which the whole log alone tells: those are averaged that it may still
/// be, four lengths until it is the longest. Axes share what they are transformed with.
///
/// ```
/// use sagnac_analysis::{Transforms, WelchStream, welch};
/// let y: Vec<f64> = (0..5000).map(|k| f64::from(k * 7919 % 101)).collect();
/// let (mut stream, mut transforms) = (WelchStream::default(), Transforms::default());
/// y.chunks(77).for_each(|part| stream.push(part, &mut transforms));
/// let (a, b) = (stream.finish(0.01)?, welch(&[&y], 0.01)?);
/// assert_eq!((a.pieces, a.frequency_hz), (b.pieces, b.frequency_hz));
/// assert!((a.density[9] / b.density[9] - 1.0).abs() < 1e-12);
/// # Ok::<(), sagnac_analysis::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct WelchStream {
    levels: Vec<Level>,
    /// The last samples of the stretch, and how many came before them.
    recent: Vec<f64>,
    before: usize,
    longest: usize,
}

/// Transforms of all lengths that were asked for.
#[derive(Default)]
pub struct Transforms(Vec<Piece>);

impl Transforms {
    fn of(&mut self, length: usize) -> &mut Piece {
        let known = self.0.iter().position(|piece| piece.window.len() == length);
        let at = known.unwrap_or_else(|| {
            self.0.push(Piece::new(length));
            self.0.len() - 1
        });
        &mut self.0[at]
    }
}

/// Pieces of one length.
#[derive(Debug, Clone)]
struct Level {
    length: usize,
    /// Where in the stretch the next piece begins.
    next: usize,
    pieces: usize,
    sums: Vec<f64>,
}

impl WelchStream {
    /// Adds samples of one stretch.
    pub fn push(&mut self, samples: &[f64], transforms: &mut Transforms) {
        for part in samples.chunks(LONGEST / 4) {
            self.recent.extend_from_slice(part);
            self.take(transforms);
        }
    }

    /// Begins another stretch.
    pub fn end_segment(&mut self) {
        self.recent.clear();
        self.before = 0;
        for level in &mut self.levels {
            level.next = 0;
        }
    }

    /// Takes the pieces that are whole by now, and lets go of what no piece needs.
    fn take(&mut self, transforms: &mut Transforms) {
        let end = self.before + self.recent.len();
        self.longest = self.longest.max(end);
        let least = piece_length(self.longest);
        self.levels.retain(|level| level.length >= least);
        let mut length = least;
        while length <= end.min(LONGEST) {
            if !self.levels.iter().any(|level| level.length == length) {
                self.levels.push(Level::new(length));
            }
            length *= 2;
        }
        for level in &mut self.levels {
            let work = transforms.of(level.length);
            while level.next + level.length <= end {
                let from = level.next - self.before;
                work.add(&self.recent[from..from + level.length], &mut level.sums);
                level.pieces += 1;
                level.next += level.length / 2;
            }
        }
        // Lengths that no piece was of yet begin with the stretch.
        let wanted = if end < LONGEST {
            0
        } else {
            self.levels
                .iter()
                .map(|level| level.next)
                .min()
                .unwrap_or(end)
        };
        if wanted > self.before + LONGEST / 4 {
            self.recent.drain(..wanted - self.before);
            self.before = wanted;
        }
    }

    /// The density of all stretches at this step.
    ///
    /// # Errors
    /// Those of [`welch`].
    pub fn finish(self, dt_s: f64) -> Result<Density, Error> {
        check(self.longest, dt_s)?;
        let length = piece_length(self.longest);
        let own = self.levels.into_iter().find(|level| level.length == length);
        let own = own.ok_or(Error::TooShort {
            kind: "a spectrum",
            needed: LEAST,
            found: self.longest,
        })?;
        Ok(density(length, &own.sums, own.pieces, dt_s))
    }
}

impl Level {
    fn new(length: usize) -> Self {
        Self {
            length,
            next: 0,
            pieces: 0,
            sums: vec![0.0; length / 2],
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn white_noise_has_twice_its_variance_times_the_step() {
        let mut state = 7_u64;
        let samples: Vec<f64> = (0..1 << 17)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect();
        let spectrum = welch(&[&samples], 0.01).unwrap();
        assert_eq!(spectrum.frequency_hz.len(), 1 << 13);
        assert_eq!(spectrum.pieces, 15);
        let mean = spectrum.density.iter().sum::<f64>() / spectrum.density.len() as f64;
        // 1/12 is the variance; the mean of 8192 × 15/1.9 scatters by 0.5 %.
        assert!((mean / (2.0 * 0.01 / 12.0) - 1.0).abs() < 0.02, "{mean}");
    }

    #[test]
    fn a_line_stands_at_its_frequency() {
        let samples: Vec<f64> = (0..4096)
            .map(|k| 9.8 + (std::f64::consts::TAU * f64::from(k) / 16.0).sin())
            .collect();
        let spectrum = welch(&[&samples], 0.1).unwrap();
        let (peak, _) = spectrum
            .density
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .unwrap();
        assert!((spectrum.frequency_hz[peak] - 0.625).abs() < 1e-12);
        let power: f64 = spectrum.density.iter().sum::<f64>() * spectrum.frequency_hz[0];
        assert!((power - 0.5).abs() < 1e-9, "{power}");
    }

    #[test]
    fn too_short_is_an_error() {
        assert!(matches!(
            welch(&[&[0.0; 15]], 1.0),
            Err(Error::TooShort { .. })
        ));
        assert!(welch(&[&[0.0; 16]], 1.0).is_ok());
        assert!(welch(&[&[0.0; 16]], f64::NAN).is_err());
    }

    #[test]
    fn a_stream_takes_the_pieces_of_the_whole() {
        // Stretches of several lengths, in parts of any size; longer than the longest piece asks for memory.
        for lengths in [
            vec![16, 5],
            vec![40, 1000, 300],
            vec![100_000, 99],
            vec![9 << 20],
        ] {
            let all: Vec<Vec<f64>> = lengths
                .iter()
                .map(|&n: &usize| (0..n).map(|k| ((k * 7919 + n) % 1009) as f64).collect())
                .collect();
            let slices: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
            let whole = welch(&slices, 0.1).unwrap();
            let (mut stream, mut transforms) = (WelchStream::default(), Transforms::default());
            for stretch in &slices {
                let parts = stretch.chunks(70_001);
                parts.for_each(|part| stream.push(part, &mut transforms));
                assert!(stream.recent.len() <= 2 * LONGEST);
                stream.end_segment();
            }
            let found = stream.finish(0.1).unwrap();
            assert_eq!(found.pieces, whole.pieces, "{lengths:?}");
            assert_eq!(found.frequency_hz, whole.frequency_hz);
            for (a, b) in found.density.iter().zip(&whole.density) {
                assert!((a - b).abs() <= 1e-9 * b + 1e-20, "{lengths:?}: {a} {b}");
            }
        }
        assert!(WelchStream::default().finish(0.1).is_err());
    }
}
