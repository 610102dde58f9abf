//! Spectral lines: found where the periodogram stands above the fitted spectrum, fitted in the cosine domain, taken out.
//!
//! A sine at ν (in coefficients) has closed-form coefficients; amplitude, phase and frequency come from the ±24 around
//! it. Under noise the gain 2 Δ ln L is χ²_2 at each of N/2 frequencies; searched between them as well, p < 10⁻³ needs
//! 2 ln(3250·N). σ_A² = 2S/n, σ_ω² = 24·S/(A²n³) [RifeBoorstyn1974].

use super::bins::SegmentSpectrum;
use super::likelihood::solve;
use std::f64::consts::PI;

/// A line found in one segment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// Frequency in coefficients, 2nf·dt.
    pub nu: f64,
    /// Samples of the segment.
    pub n: usize,
    /// Amplitude in units of the scale, as sampled.
    pub amplitude: f64,
    /// Height of the periodogram over the spectrum.
    pub height: f64,
    /// Spectrum there, variance of a coefficient.
    pub level: f64,
    /// Amplitudes of cosine and sine.
    parts: (f64, f64),
}

impl Line {
    /// u = f·dt.
    pub(crate) fn u(&self) -> f64 {
        self.nu / (2.0 * self.n as f64)
    }

    /// Standard deviation of the amplitude, in units of the scale.
    pub(crate) fn amplitude_sigma(&self) -> f64 {
        (2.0 * self.level / self.n as f64).sqrt()
    }

    /// Standard deviation of u.
    pub(crate) fn u_sigma(&self) -> f64 {
        let n = self.n as f64;
        (24.0 * self.level / (self.amplitude * self.amplitude * n * n * n)).sqrt() / (2.0 * PI)
    }
}

/// Coefficients j of cos and sin at ν over a segment of n samples (orthonormal).
fn columns(nu: f64, j: usize, n: usize) -> (f64, f64) {
    let (n, j) = (n as f64, j as f64);
    let pair = |offset: f64| {
        // w = π·offset/n: Σ cos w(k+½) and Σ sin w(k+½)
        let half = PI * offset / (2.0 * n);
        if half.sin().abs() < 1e-12 {
            return (n, 0.0);
        }
        let (sin, cos) = (PI * offset).sin_cos();
        (sin / (2.0 * half.sin()), (1.0 - cos) / (2.0 * half.sin()))
    };
    let (a, b) = (pair(nu - j), pair(nu + j));
    let scale = (2.0 / n).sqrt() * 0.5;
    (scale * (a.0 + b.0), scale * (a.1 + b.1))
}

/// Gain and parts of a sine at ν fitted to the coefficients around it.
fn gain(coefficients: &[f64], nu: f64, first: usize, end: usize) -> Option<(f64, f64, f64)> {
    let n = coefficients.len();
    let (mut m, mut h) = ([0.0; 4], [0.0; 2]);
    for j in first..end {
        let (c, s) = columns(nu, j, n);
        m[0] += c * c;
        m[1] += c * s;
        m[3] += s * s;
        h[0] += c * coefficients[j];
        h[1] += s * coefficients[j];
    }
    m[2] = m[1];
    let x = solve(&m, &h)?;
    Some((h[0] * x[0] + h[1] * x[1], x[0], x[1]))
}

/// The gain that a line needs among `n` samples.
pub(crate) fn threshold(n: usize) -> f64 {
    2.0 * (3250.0 * n as f64).ln()
}

/// Finds the lines of one segment above `level(j)` and takes them out of its coefficients.
///
/// `limit` is the first coefficient not searched. Strong lines come first; at most `most` are taken a call.
pub(crate) fn take_out(
    segment: &mut SegmentSpectrum,
    levels: &[(usize, usize, f64)],
    most: usize,
) -> Vec<Line> {
    let n = segment.n;
    let wanted = threshold(n);
    let first_look = 0.62 * wanted;
    let mut found: Vec<Line> = Vec::new();
    let mut candidates: Vec<(usize, f64, f64)> = Vec::new();
    let c = &segment.coefficients;
    for &(first, end, level) in levels {
        let limit = first_look * level;
        let (from, to) = (first.max(12), end.min(n.saturating_sub(1)));
        let mut j = from;
        while j < to {
            let sum = c[j - 1] * c[j - 1] + c[j] * c[j] + c[j + 1] * c[j + 1];
            if sum > limit && !is_excluded(&segment.excluded, j) {
                match candidates.last_mut() {
                    Some(last) if j - last.0 <= 3 => {
                        if sum / level > last.1 {
                            *last = (j, sum / level, level);
                        }
                    }
                    _ => candidates.push((j, sum / level, level)),
                }
            }
            j += 1;
        }
    }
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
    candidates.truncate(4 * most + 32);
    for (j, _, level) in candidates {
        if found.len() >= most {
            break;
        }
        if is_excluded(&segment.excluded, j) {
            continue;
        }
        let (first, end) = (j.saturating_sub(24).max(1), (j + 25).min(n));
        let mut best = (0.0, j as f64, 0.0, 0.0);
        for step in -16..=16 {
            let nu = j as f64 + 0.125 * f64::from(step);
            if let Some((g, a, b)) = gain(&segment.coefficients, nu, first, end)
                && g > best.0
            {
                best = (g, nu, a, b);
            }
        }
        if best.0 < 0.9 * wanted * level {
            continue;
        }
        let mut width = 0.0625;
        while width > 1e-5 {
            for nu in [best.1 - width, best.1 + width] {
                if let Some((g, a, b)) = gain(&segment.coefficients, nu, first, end)
                    && g > best.0
                {
                    best = (g, nu, a, b);
                }
            }
            width *= 0.5;
        }
        let (g, nu, a, b) = best;
        if g < wanted * level || nu <= 4.0 || nu >= n as f64 - 4.0 {
            continue;
        }
        let line = Line {
            nu,
            n,
            amplitude: a.hypot(b),
            height: 0.5 * g / level,
            level,
            parts: (a, b),
        };
        subtract(segment, &line);
        found.push(line);
    }
    found
}

/// Takes the line's coefficients out wherever they matter, and excludes the few nearest.
fn subtract(segment: &mut SegmentSpectrum, line: &Line) {
    let n = segment.n;
    let reach = (2000.0 * line.height).sqrt().ceil() + 16.0;
    let first = (line.nu - reach).max(1.0) as usize;
    let end = ((line.nu + reach) as usize).min(n);
    for j in first..end {
        let (c, s) = columns(line.nu, j, n);
        segment.coefficients[j] -= line.parts.0 * c + line.parts.1 * s;
    }
    exclude(segment, line.nu, 4.0);
}

/// Excludes the coefficients within `half` of ν.
pub(crate) fn exclude(segment: &mut SegmentSpectrum, nu: f64, half: f64) {
    let first = (nu - half).max(1.0).round() as usize;
    let end = ((nu + half).round() as usize + 1).min(segment.n);
    if first >= end {
        return;
    }
    let mut all = std::mem::take(&mut segment.excluded);
    all.push(first..end);
    all.sort_by_key(|r| r.start);
    for range in all {
        match segment.excluded.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => segment.excluded.push(range),
        }
    }
}

fn is_excluded(excluded: &[std::ops::Range<usize>], j: usize) -> bool {
    let place = excluded.partition_point(|r| r.end <= j);
    excluded.get(place).is_some_and(|r| r.start <= j)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::fit::dct::dct2;
    use realfft::RealFftPlanner;

    #[test]
    fn a_sine_between_coefficients_is_found_whole() {
        let n = 5000;
        let (amplitude, u, phase) = (0.7, 0.071_234, 1.1);
        let mut seed = 1_u64;
        let samples: Vec<f64> = (0..n)
            .map(|k| {
                let mut noise = -6.0;
                for _ in 0..12 {
                    seed = seed
                        .wrapping_mul(6364136223846793005)
                        .wrapping_add(1442695040888963407);
                    noise += (seed >> 11) as f64 / (1_u64 << 53) as f64;
                }
                amplitude * (2.0 * PI * u * (k as f64 + 0.5) + phase).sin() + noise
            })
            .collect();
        let mut segment = SegmentSpectrum {
            start_s: 0.0,
            n,
            coefficients: dct2(&samples, 0.0, &mut RealFftPlanner::new()),
            excluded: Vec::new(),
            leverage: Vec::new(),
        };
        let lines = take_out(&mut segment, &[(1, n, 1.0)], 8);
        assert_eq!(lines.len(), 1);
        let line = lines[0];
        assert!((line.amplitude - amplitude).abs() < 3.0 * line.amplitude_sigma());
        assert!((line.u() - u).abs() < 3.0 * line.u_sigma());
        let rest: f64 = segment.coefficients.iter().map(|c| c * c).sum::<f64>() / n as f64;
        assert!((rest - 1.0).abs() < 0.1);
    }
}
