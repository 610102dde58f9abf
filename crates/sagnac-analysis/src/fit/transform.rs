//! From the segments of one axis to their coefficients, in units of the scatter of neighboring samples.

use super::bins::{Layout, SegmentSpectrum};
use super::dct::{dct2, fast_length};
use super::estimate::Work;
use super::fill::Fill;
use super::types::Segment;
use realfft::RealFftPlanner;
use std::ops::Range;
use std::sync::Arc;

/// The transformed log; none where no sample differs from another.
pub(super) fn transform(segments: &[Segment<'_>], step_s: f64, samples: usize) -> Option<Work> {
    let (mut squares, mut count, mut spread) = (0.0, 0.0, 0.0);
    let (mut sum, mut used) = (0.0, 0.0);
    let mut means = Vec::with_capacity(segments.len());
    for segment in segments {
        let n = segment.samples.len() as f64;
        // The first sample is taken out before summing, for the digits.
        let first = segment.samples[0];
        let mean = first + segment.samples.iter().map(|y| y - first).sum::<f64>() / n;
        means.push(mean);
        // Filled samples tell nothing of the mean that their neighbors do not.
        let lost: usize = segment.filled.iter().map(Range::len).sum();
        let of_filled: f64 = segment
            .filled
            .iter()
            .flat_map(|r| &segment.samples[r.clone()])
            .map(|y| y - mean)
            .sum();
        sum += mean * n - lost as f64 * mean - of_filled;
        used += n - lost as f64;
        for pair in segment.samples.windows(2) {
            let d = pair[1] - pair[0];
            squares += d * d;
        }
        spread += segment
            .samples
            .iter()
            .map(|y| (y - mean).powi(2))
            .sum::<f64>();
        count += n - 1.0;
    }
    let scale = match ((0.5_f64 * squares / count).sqrt(), (spread / count).sqrt()) {
        (d, _) if d > 0.0 && d.is_finite() => d,
        (_, s) if s > 0.0 && s.is_finite() => s,
        _ => return None,
    };
    let fill = Fill::of(segments).map(Arc::new);
    let mut planner = RealFftPlanner::new();
    let spectra: Vec<SegmentSpectrum> = segments
        .iter()
        .zip(&means)
        .map(|(segment, &mean)| {
            let n = fast_length(segment.samples.len());
            let mut coefficients = dct2(&segment.samples[..n], mean, &mut planner);
            let unit = 1.0 / scale;
            for c in &mut coefficients {
                *c *= unit;
            }
            SegmentSpectrum {
                start_s: segment.start_s,
                n,
                coefficients,
                excluded: Vec::new(),
                leverage: Vec::new(),
            }
        })
        .collect();
    let filled = fill.as_ref().map_or(0, |f| f.filled);
    Some(Work {
        layout: Layout::new(&spectra, fill),
        segments: spectra,
        scale,
        step_s,
        cut: 0.5,
        lines: Vec::new(),
        samples,
        filled,
        mean: sum / used,
        given: Vec::new(),
    })
}
