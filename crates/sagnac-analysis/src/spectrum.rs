//! Power spectral density by Welch's method: Hann window, half overlap, mean removed.
//!
//! S(f_j) = mean over pieces of 2·dt·|Σ w_k y_k e^{−2πi jk/L}|²/Σ w_k², one-sided
//! `[WELCH]`.

use rayon::prelude::*;
use realfft::RealFftPlanner;

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

/// Welch's one-sided density of one axis.
///
/// `segments` as in [`crate::deviations`]. The pieces have the largest power of two ≤ N/8
/// samples of the longest segment, at most 2²⁰; those of all segments are averaged. The mean of
/// each piece is taken out, so the density at zero frequency is not given.
///
/// # Errors
/// [`Error::NotPositive`] for a step that is not; [`Error::TooShort`] below 16 samples in a row.
pub fn welch(segments: &[&[f64]], dt_s: f64) -> Result<Density, Error> {
    if !(dt_s.is_finite() && dt_s > 0.0) {
        return Err(Error::NotPositive {
            name: "the sampling step",
            value_s: dt_s,
        });
    }
    let longest = segments.iter().map(|s| s.len()).max().unwrap_or(0);
    if longest < LEAST {
        return Err(Error::TooShort {
            kind: "a spectrum",
            needed: LEAST,
            found: longest,
        });
    }
    let length = (1 << (longest / 8).ilog2()).min(LONGEST);
    let pieces: Vec<&[f64]> = segments
        .iter()
        .flat_map(|segment| segment.windows(length).step_by(length / 2))
        .collect();
    let window: Vec<f64> = (0..length)
        .map(|k| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / length as f64).cos())
        .collect();
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    // Fixed batches, added in order: the same bits for any number of threads.
    let batches: Vec<Vec<f64>> = pieces
        .par_chunks(pieces.len().div_ceil(16))
        .map(|batch| {
            let mut input = transform.make_input_vec();
            let mut output = transform.make_output_vec();
            let mut scratch = transform.make_scratch_vec();
            let mut sums = vec![0.0; length / 2];
            for piece in batch {
                let mean = piece.iter().sum::<f64>() / length as f64;
                for ((to, from), w) in input.iter_mut().zip(*piece).zip(&window) {
                    *to = (from - mean) * w;
                }
                // The lengths are those of the plan: this cannot fail.
                if transform
                    .process_with_scratch(&mut input, &mut output, &mut scratch)
                    .is_ok()
                {
                    for (sum, value) in sums.iter_mut().zip(&output[1..]) {
                        *sum += value.norm_sqr();
                    }
                }
            }
            sums
        })
        .collect();
    let scale = 2.0 * dt_s / weight / pieces.len() as f64;
    let mut density = vec![0.0; length / 2];
    for batch in batches {
        for (total, sum) in density.iter_mut().zip(batch) {
            *total += scale * sum;
        }
    }
    // Nyquist stands for itself alone, the others also for their negative frequencies.
    if let Some(last) = density.last_mut() {
        *last /= 2.0;
    }
    let step_hz = 1.0 / (length as f64 * dt_s);
    Ok(Density {
        frequency_hz: (1..=length / 2).map(|j| j as f64 * step_hz).collect(),
        density,
        pieces: pieces.len(),
    })
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
}
