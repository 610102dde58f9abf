//! Spectral lines: found where the periodogram stands above the noise, fitted in the cosine domain, taken out.
//!
//! A sine at ν (in coefficients) has closed-form coefficients; amplitude, phase and frequency come from the ±24 around
//! it. Under noise the gain 2 Δ ln L is χ²_2 at each of N/2 frequencies; searched between them as well, p < 10⁻³ needs
//! 2 ln(3250·N). σ_A² = 2S/n, σ_ω² = 24·S/(A²n³) [RifeBoorstyn1974]. Lines near each other are fitted at once (`tones`),
//! and one line becomes two where that explains more. The noise is the fit; above a filter's corner, where there is none, a
//! running median of the squared coefficients, whose own scatter raises the threshold as in the F distribution.

use super::bins::SegmentSpectrum;
use super::likelihood::solve;
use super::tones::Window;
use std::f64::consts::PI;

/// Coefficients within which lines are fitted at once, and how many of them.
const NEIGHBOR: f64 = 40.0;
const MOST_AT_ONCE: usize = 6;
/// Gain from which two lines stand in place of one: p < 10⁻³ of three more parameters over the places near one line.
const TWO: f64 = 25.0;
/// Least distance of two lines in coefficients, a quarter of what 1/T is: closer, it is one line that changes.
const APART: f64 = 0.5;
/// Misses of a line alone, over their level, in the 13 coefficients around it, from which two are tried.
const WORTH_TRYING: f64 = 18.0;
/// Share of a level down to which it must fall before two lines are tried again.
const TRY_AGAIN: f64 = 0.9;
/// Coefficients of one median above a filter's corner, most and least.
const BLOCK: usize = 512;
const LEAST_BLOCK: usize = 64;
/// Coefficients on either side of a line that are noise where it is constant.
pub(crate) const QUIET: f64 = 12.0;
/// Median of χ²_1.
const MEDIAN: f64 = 0.454_936;

/// A line found in one segment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// Frequency in coefficients, 2nf·dt.
    pub nu: f64,
    /// Samples of the segment.
    pub n: usize,
    /// Segment it was found in.
    pub segment: usize,
    /// Amplitude in units of the scale, as sampled.
    pub amplitude: f64,
    /// Phase of the cosine at the segment's start.
    pub phase: f64,
    /// Height of the periodogram over the spectrum.
    pub height: f64,
    /// Spectrum there, variance of a coefficient.
    pub level: f64,
    /// LocalNoise down to which two lines in its place were tried in vain; nothing where it is one of two already.
    tried: f64,
}

/// The noise of a run of coefficients and the gain over it that a line needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalNoise {
    pub first: usize,
    pub end: usize,
    pub level: f64,
    pub wanted: f64,
}

impl Line {
    /// u = f·dt.
    pub(crate) fn u(&self) -> f64 {
        self.nu / (2.0 * self.n as f64)
    }

    /// 2 Δ ln L that it makes alone.
    pub(crate) fn gain(&self, level: f64) -> f64 {
        0.5 * self.n as f64 * self.amplitude * self.amplitude / level
    }

    /// Standard deviation of the amplitude, in units of the scale.
    pub(crate) fn amplitude_sigma(&self, level: f64) -> f64 {
        (2.0 * level / self.n as f64).sqrt()
    }

    /// Standard deviation of ν.
    pub(crate) fn nu_sigma(&self, level: f64) -> f64 {
        let n = self.n as f64;
        (24.0 * level / (self.amplitude * self.amplitude * n)).sqrt() / PI
    }

    /// What it adds to coefficient j.
    pub(crate) fn at(&self, j: usize) -> f64 {
        let (c, s) = columns(self.nu, j, self.n);
        self.amplitude * (self.phase.cos() * c + self.phase.sin() * s)
    }

    /// Amplitude, phase and ν.
    pub(crate) fn tone(&self) -> [f64; 3] {
        [self.amplitude, self.phase, self.nu]
    }

    /// The same with other amplitude, phase and ν.
    fn with(&self, tone: &[f64]) -> Self {
        let turn = if tone[0] < 0.0 { PI } else { 0.0 };
        let mut out = Self {
            amplitude: tone[0].abs(),
            phase: (tone[1] + turn) % (2.0 * PI),
            nu: tone[2],
            ..*self
        };
        out.height = 0.5 * out.gain(out.level);
        out
    }
}

/// Coefficients j of cos and sin at ν over a segment of n samples (orthonormal).
pub(super) fn columns(nu: f64, j: usize, n: usize) -> (f64, f64) {
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

/// Noise of the coefficients from `from` on, without a fit.
///
/// Medians of blocks, of even and odd coefficients apart (the two ends of a smooth log reach them with different signs),
/// the largest of a block and its neighbors (a filter may fall steeply). A median of m is known to 2.35/√m, as χ²_ν with
/// ν = 0.36 m, so the gain follows 2·F(2, ν).
pub(crate) fn local_levels(coefficients: &[f64], from: usize) -> Vec<LocalNoise> {
    let n = coefficients.len();
    let from = from.max(1);
    let wanted = threshold(n);
    let mut blocks: Vec<LocalNoise> = Vec::new();
    let mut first = from;
    while first + LEAST_BLOCK <= n {
        // Narrow towards Nyquist, where a filter may have a zero.
        let left = n - first;
        let mut width = ((n - from) / 8).min(left / 6).clamp(LEAST_BLOCK, BLOCK);
        if left < width + LEAST_BLOCK {
            width = left;
        }
        let freedom = 0.18 * width as f64;
        blocks.push(LocalNoise {
            first,
            end: first + width,
            level: (0..2)
                .map(|odd| median_square(coefficients, first + odd, first + width))
                .fold(1e-300, f64::max),
            wanted: freedom * ((wanted / freedom).exp() - 1.0),
        });
        first += width;
    }
    let own: Vec<f64> = blocks.iter().map(|b| b.level).collect();
    for (i, block) in blocks.iter_mut().enumerate() {
        let near = i.saturating_sub(1)..(i + 2).min(own.len());
        block.level = own[near].iter().copied().fold(0.0, f64::max);
    }
    blocks
}

/// Variance of every second coefficient from `first` on, from the median of their squares.
fn median_square(coefficients: &[f64], first: usize, end: usize) -> f64 {
    let mut squares: Vec<f64> = (first..end)
        .step_by(2)
        .map(|j| coefficients[j] * coefficients[j])
        .collect();
    let middle = squares.len() / 2;
    *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN
}

/// Finds the lines of segment `index` above the levels and takes them out of its coefficients; whether any was taken.
///
/// Strong lines come first; at most `most` are taken a call. `lines` are those of this segment. Where there are very many,
/// the levels are wrong, not the lines: they are not fitted at once.
pub(crate) fn take_out(
    segment: &mut SegmentSpectrum,
    index: usize,
    levels: &[LocalNoise],
    lines: &mut Vec<Line>,
    most: usize,
) -> bool {
    let mut taken = 0;
    for (j, level) in candidates(segment, levels, 4 * most + 32) {
        if taken >= most {
            break;
        }
        if is_excluded(&segment.excluded, j) {
            continue;
        }
        if let Some(line) = fit_alone(segment, index, j, &level) {
            subtract(segment, &line);
            lines.push(line);
            taken += 1;
            let i = lines.len() - 1;
            let group = neighbors(lines, i);
            if 2 * taken > most {
                continue;
            }
            if group.len() > 1 {
                settle(segment, lines, &group);
            }
            // At once: what two lines leave of one would pass for more of them.
            try_two(segment, lines, i);
        }
    }
    let mut any = taken > 0;
    for i in 0..lines.len() {
        lower(segment, &mut lines[i], levels);
        if 2 * taken <= most && lines[i].level < TRY_AGAIN * lines[i].tried {
            any |= try_two(segment, lines, i);
        }
    }
    any
}

/// Tries two lines in the place of line `i` over its level; whether they explain more.
fn try_two(segment: &mut SegmentSpectrum, lines: &mut Vec<Line>, i: usize) -> bool {
    lines[i].tried = lines[i].level;
    split(segment, lines, i)
}

/// Gives a line the present level, over a lower one of which it reaches further.
fn lower(segment: &mut SegmentSpectrum, line: &mut Line, levels: &[LocalNoise]) {
    let old = *line;
    line.level = level_at(levels, old.nu).unwrap_or(old.level);
    if line.level < 0.5 * old.level {
        *line = line.with(&old.tone());
        replace(segment, &[old], &[*line]);
    }
}

/// The level at ν.
pub(crate) fn level_at(levels: &[LocalNoise], nu: f64) -> Option<f64> {
    let place = levels.partition_point(|l| l.end as f64 <= nu);
    levels
        .get(place)
        .filter(|l| l.first as f64 <= nu + 1.0)
        .map(|l| l.level)
}

/// Places where three coefficients hold much of a line, highest first.
fn candidates(
    segment: &SegmentSpectrum,
    levels: &[LocalNoise],
    most: usize,
) -> Vec<(usize, LocalNoise)> {
    let c = &segment.coefficients;
    let mut out: Vec<(usize, f64, LocalNoise)> = Vec::new();
    for level in levels {
        let limit = 0.62 * level.wanted * level.level;
        let (from, to) = (
            level.first.max(12),
            level.end.min(segment.n.saturating_sub(1)),
        );
        for j in from..to {
            let sum = c[j - 1] * c[j - 1] + c[j] * c[j] + c[j + 1] * c[j + 1];
            if sum <= limit || is_excluded(&segment.excluded, j) {
                continue;
            }
            let height = sum / level.level;
            match out.last_mut() {
                Some(last) if j - last.0 <= 3 => {
                    if height > last.1 {
                        *last = (j, height, *level);
                    }
                }
                _ => out.push((j, height, *level)),
            }
        }
    }
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out.truncate(most);
    out.into_iter().map(|(j, _, level)| (j, level)).collect()
}

/// The line near coefficient j, if its gain suffices.
fn fit_alone(
    segment: &SegmentSpectrum,
    index: usize,
    j: usize,
    level: &LocalNoise,
) -> Option<Line> {
    let n = segment.n;
    let wanted = level.wanted * level.level;
    let (first, end) = (j.saturating_sub(24).max(1), (j + 25).min(n));
    let mut best = (0.0, j as f64, 0.0, 0.0);
    let try_at = |nu: f64, best: &mut (f64, f64, f64, f64)| {
        if let Some((g, a, b)) = gain(&segment.coefficients, nu, first, end)
            && g > best.0
        {
            *best = (g, nu, a, b);
        }
    };
    for step in -16..=16 {
        try_at(j as f64 + 0.125 * f64::from(step), &mut best);
    }
    if best.0 < 0.9 * wanted {
        return None;
    }
    let mut width = 0.0625;
    while width > 1e-5 {
        for nu in [best.1 - width, best.1 + width] {
            try_at(nu, &mut best);
        }
        width *= 0.5;
    }
    let (g, nu, a, b) = best;
    (g >= wanted && is_inside(nu, n)).then_some(Line {
        nu,
        n,
        segment: index,
        amplitude: a.hypot(b),
        phase: b.atan2(a),
        height: 0.5 * g / level.level,
        level: level.level,
        tried: f64::INFINITY,
    })
}

/// Whether the closed form holds: away from mean and Nyquist.
fn is_inside(nu: f64, n: usize) -> bool {
    nu > 4.0 && nu < n as f64 - 4.0
}

/// Line `i` and the nearest of those whose coefficients it shares.
pub(crate) fn neighbors(lines: &[Line], i: usize) -> Vec<usize> {
    let distance = |k: &usize| (lines[*k].nu - lines[i].nu).abs();
    let mut out: Vec<usize> = (0..lines.len())
        .filter(|k| distance(k) < NEIGHBOR)
        .collect();
    out.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    out.truncate(MOST_AT_ONCE);
    out
}

/// Fits the lines of a group anew, all at once.
fn settle(segment: &mut SegmentSpectrum, lines: &mut [Line], group: &[usize]) {
    let old: Vec<Line> = group.iter().map(|&i| lines[i]).collect();
    let mut tones = old.iter().flat_map(Line::tone).collect();
    Window::around(&segment.coefficients, &old).fit(&mut tones, None);
    let new: Vec<Line> = old
        .iter()
        .zip(tones.chunks_exact(3))
        .map(|(l, t)| l.with(t))
        .collect();
    let holds = old
        .iter()
        .zip(&new)
        .all(|(a, b)| is_inside(b.nu, b.n) && (a.nu - b.nu).abs() < 2.0);
    if holds && nearest(&new) > nearest(&old).min(2.0) - 0.5 {
        replace(segment, &old, &new);
        for (&i, line) in group.iter().zip(&new) {
            lines[i] = *line;
        }
    }
}

/// Least distance of any two in coefficients.
fn nearest(lines: &[Line]) -> f64 {
    let mut places: Vec<f64> = lines.iter().map(|l| l.nu).collect();
    places.sort_by(f64::total_cmp);
    places
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(f64::INFINITY, f64::min)
}

/// Puts two lines in the place of line `i` where they explain more; whether they do.
fn split(segment: &mut SegmentSpectrum, lines: &mut Vec<Line>, i: usize) -> bool {
    let line = lines[i];
    let alone = Window::around(&segment.coefficients, &[line]);
    let (left, _) = alone.left(&line.tone(), line.nu - 6.5, line.nu + 6.5);
    if left < WORTH_TRYING * line.level {
        return false;
    }
    let Some(pair) = alone.pair(line.nu) else {
        return false;
    };
    let group = neighbors(lines, i);
    let old: Vec<Line> = group.iter().map(|&k| lines[k]).collect();
    let window = Window::around(&segment.coefficients, &old);
    let mut one: Vec<f64> = old.iter().flat_map(Line::tone).collect();
    let mut two: Vec<f64> = pair;
    two.extend(old[1..].iter().flat_map(Line::tone));
    let before = window.fit(&mut one, None);
    let after = window.fit(&mut two, None);
    let half = Line { tried: 0.0, ..line };
    let mut new = vec![half.with(&two[..3]), half.with(&two[3..6])];
    let apart = (new[0].nu - new[1].nu).abs();
    let stays = new
        .iter()
        .all(|l| is_inside(l.nu, l.n) && (l.nu - line.nu).abs() < 12.0);
    // A line that wanders leaves more than noise however many stand for it.
    let (low, high) = (
        new[0].nu.min(new[1].nu) - QUIET,
        new[0].nu.max(new[1].nu) + QUIET,
    );
    let (left, count) = window.left(&two, low, high);
    let inside = two.chunks_exact(3).filter(|t| (low..high).contains(&t[2]));
    let freedom = count - 3.0 * inside.count() as f64;
    if before - after < TWO * line.level
        || apart < APART
        || !stays
        || is_more(left / line.level, freedom)
    {
        return false;
    }
    new.extend(
        old[1..]
            .iter()
            .zip(two[6..].chunks_exact(3))
            .map(|(l, t)| l.with(t)),
    );
    replace(segment, &old, &new);
    for (&k, line) in group[1..].iter().zip(&new[2..]) {
        lines[k] = *line;
    }
    lines[i] = new[0];
    lines.push(new[1]);
    true
}

/// Whether a χ² of `freedom` degrees is larger than by chance, 0.05 % by its cube root [WilsonHilferty1931].
pub(crate) fn is_more(sum: f64, freedom: f64) -> bool {
    if freedom < 1.0 {
        return false;
    }
    let variance = 2.0 / (9.0 * freedom);
    (sum / freedom).cbrt() > 1.0 - variance + 3.3 * variance.sqrt()
}

/// Takes the line's coefficients out wherever they matter, and excludes the few nearest.
fn subtract(segment: &mut SegmentSpectrum, line: &Line) {
    add(segment, line, -1.0);
    exclude(segment, line.nu, 4.0);
}

/// Puts lines back and takes others out.
fn replace(segment: &mut SegmentSpectrum, old: &[Line], new: &[Line]) {
    for line in old {
        add(segment, line, 1.0);
    }
    for line in new {
        subtract(segment, line);
    }
}

/// Adds the line's coefficients wherever they matter.
fn add(segment: &mut SegmentSpectrum, line: &Line, sign: f64) {
    let reach = (2000.0 * line.height).sqrt().ceil() + 16.0;
    let first = (line.nu - reach).max(1.0) as usize;
    let end = ((line.nu + reach) as usize).min(segment.n);
    for j in first..end {
        segment.coefficients[j] += sign * line.at(j);
    }
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
        let all = LocalNoise {
            first: 1,
            end: n,
            level: 1.0,
            wanted: threshold(n),
        };
        let mut lines = Vec::new();
        assert!(take_out(&mut segment, 0, &[all], &mut lines, 8));
        assert_eq!(lines.len(), 1);
        let line = lines[0];
        assert!((line.amplitude - amplitude).abs() < 3.0 * line.amplitude_sigma(1.0));
        let nu = 2.0 * n as f64 * u;
        assert!((line.nu - nu).abs() < 3.0 * line.nu_sigma(1.0));
        let rest: f64 = segment.coefficients.iter().map(|c| c * c).sum::<f64>() / n as f64;
        assert!((rest - 1.0).abs() < 0.1);
    }
}
