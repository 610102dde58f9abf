//! The phase of a segment: x_0 = 0, x_k = x_{k−1} + (y_k − ȳ), N + 1 points, at dt = 1.
//!
//! No deviation depends on the mean; taking it out keeps the rounding of the sum at the scale
//! of the noise.

use rayon::prelude::*;

use super::kernel;
use crate::error::Error;

/// Samples summed as one piece: fixed, so that results do not depend on threads.
const CHUNK: usize = 1 << 15;

/// The phases of all segments that are not empty.
///
/// # Errors
/// [`Error::NotFinite`] for the first sample that is not a number.
pub(crate) fn phases(segments: &[&[f64]]) -> Result<Vec<Vec<f64>>, Error> {
    segments
        .iter()
        .enumerate()
        .filter(|(_, segment)| !segment.is_empty())
        .map(|(number, segment)| phase(segment, number))
        .collect()
}

/// The phase of one segment.
fn phase(samples: &[f64], number: usize) -> Result<Vec<f64>, Error> {
    let sums: Vec<f64> = samples.par_chunks(CHUNK).map(kernel::sum).collect();
    let total: f64 = sums.iter().sum();
    if !total.is_finite()
        && let Some(index) = samples.iter().position(|sample| !sample.is_finite())
    {
        return Err(Error::NotFinite {
            segment: number,
            index,
        });
    }
    let mean = total / samples.len() as f64;
    let mut starts = Vec::with_capacity(sums.len());
    let mut before = 0.0;
    for (sum, chunk) in sums.iter().zip(samples.chunks(CHUNK)) {
        starts.push(before);
        before += sum - chunk.len() as f64 * mean;
    }
    let mut phase = zeros(samples.len() + 1);
    phase[1..]
        .par_chunks_mut(CHUNK)
        .zip(samples.par_chunks(CHUNK))
        .zip(starts)
        .for_each(|((out, chunk), start)| {
            let mut x = start;
            for (point, sample) in out.iter_mut().zip(chunk) {
                x += sample - mean;
                *point = x;
            }
        });
    Ok(phase)
}

/// Zeros, on huge pages where the system has them.
///
/// The far windows of long averaging times touch nine places at once: with small pages a fifth
/// of the time goes into page faults and address translation.
fn zeros(count: usize) -> Vec<f64> {
    let mut zeros = vec![0.0_f64; count];
    advise_huge_pages(&mut zeros);
    zeros
}

#[cfg(target_os = "linux")]
#[allow(
    unsafe_code,
    reason = "the advice has no safe wrapper without another dependency"
)]
fn advise_huge_pages(memory: &mut [f64]) {
    const HUGE: usize = 1 << 21;
    let start = memory.as_mut_ptr().addr();
    let first = start.next_multiple_of(HUGE);
    let end = (start + size_of_val(memory)) / HUGE * HUGE;
    if first < end {
        let aligned = memory.as_mut_ptr().wrapping_byte_add(first - start);
        // SAFETY: the range lies inside the slice; the advice changes no content, and a refusal
        // (a system without huge pages) is of no consequence.
        unsafe { libc::madvise(aligned.cast(), end - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise_huge_pages(_: &mut [f64]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_and_ends_at_zero_whatever_the_mean() {
        let samples: Vec<f64> = (0..100_000).map(|k| 9.8 + f64::from(k % 7)).collect();
        let phase = phase(&samples, 0).expect("finite samples");
        assert_eq!(phase.len(), samples.len() + 1);
        assert_eq!(phase[0], 0.0);
        // 1e5 roundings of a phase below 10.
        assert!(phase[samples.len()].abs() < 1e-9);
    }

    #[test]
    fn names_the_sample_that_is_not_finite() {
        let mut samples = vec![1.0; 100];
        samples[42] = f64::NAN;
        assert_eq!(
            phases(&[&[1.0], &samples]),
            Err(Error::NotFinite {
                segment: 1,
                index: 42
            })
        );
    }
}
