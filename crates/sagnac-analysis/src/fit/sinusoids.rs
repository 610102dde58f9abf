//! What is said of the lines that were taken out: which stand for themselves, their amplitudes and frequencies.
//!
//! Lines within a few widths of each other are lines of their own where each is constant: where what they leave around and
//! between them is noise, and no three share the coefficients of one. A mains hum, a fan or a swaying floor leaves more: it
//! is one line that wanders, the strongest stands for all, and its interval reaches over the others'.

use super::bins::SegmentSpectrum;
use super::estimate::Work;
use super::likelihood::Parameters;
use super::lines::{Line, LocalNoise, QUIET, is_more, level_at, neighbors};
use super::tones::{REACH, Window};
use super::types::{Estimate, NoiseTerms, SinusoidEstimate};

/// Most lines told of an axis.
const MOST: usize = 16;
/// Coefficients of which three lines make one that wanders.
const ONE: f64 = 24.0;
/// Most constant lines of a group.
const MOST_NEAR: usize = 5;
/// Share of a line's frequency within which lines may be one that wanders.
const WANDER: f64 = 0.004;
/// Coefficients beside a line that tell the level of the noise there.
const FLANK: usize = 64;
/// Half of a 95 % interval in standard deviations.
const WIDTH: f64 = 1.96;

/// The lines of a log, with the noise of these parameters beneath.
pub(super) fn sinusoids(
    work: &Work,
    parameters: &Parameters,
    fitted: &NoiseTerms,
) -> Vec<SinusoidEstimate> {
    let mut out: Vec<SinusoidEstimate> = Vec::new();
    for group in groups(work, parameters) {
        let s = group[0].segment;
        let own: Vec<Line> = group.iter().filter(|l| l.segment == s).copied().collect();
        let is_steady = is_constant(&work.segments[s], &group, &own);
        let told = if is_steady { own.len() } else { 1 };
        for i in 0..told {
            let mut estimate = Estimator {
                work,
                fitted,
                all: &own,
                is_steady,
            }
            .of(i);
            if !is_steady {
                reach_over(&mut estimate, &group, work);
            }
            out.push(estimate);
        }
    }
    out.sort_by(|a, b| b.height.total_cmp(&a.height));
    out.truncate(MOST);
    out.sort_by(|a, b| {
        a.frequency_hz
            .value
            .partial_cmp(&b.frequency_hz.value)
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    out
}

/// Lines that may be one, the strongest first, each with the level of the noise around it.
fn groups(work: &Work, parameters: &Parameters) -> Vec<Vec<Line>> {
    let levels: Vec<Vec<LocalNoise>> = (0..work.segments.len())
        .map(|s| {
            if work.lines.iter().any(|l| l.segment == s) {
                work.levels(s, parameters)
            } else {
                Vec::new()
            }
        })
        .collect();
    let mut lines: Vec<Line> = work.lines.clone();
    lines.retain_mut(|line| {
        let levels = &levels[line.segment];
        let level = level_at(levels, line.nu).unwrap_or(line.level);
        line.level = around(&work.segments[line.segment], line.nu, level);
        line.height = 0.5 * line.gain(line.level);
        // Found above a level that a lower corner or the coefficients beside it make void, it is none.
        let place = levels.partition_point(|l| l.end as f64 <= line.nu);
        let wanted = levels.get(place).map_or(0.0, |l| l.wanted);
        let is_void = line.u() > work.cut || line.level > level;
        !is_void || 2.0 * line.height > wanted
    });
    lines.sort_by(|a, b| b.height.total_cmp(&a.height));
    let mut out: Vec<Vec<Line>> = Vec::new();
    for line in lines {
        let near = |seed: &Line| {
            let width = resolution(seed, &line).max(WANDER * seed.u());
            (seed.u() - line.u()).abs() < width
        };
        match out.iter().position(|group| near(&group[0])) {
            Some(place) => out[place].push(line),
            None if out.len() < MOST => out.push(vec![line]),
            None => {}
        }
    }
    out
}

/// Distance in u from which lines of two segments are different ones.
fn resolution(a: &Line, b: &Line) -> f64 {
    QUIET / (2.0 * a.n.min(b.n) as f64)
}

/// The level at ν, raised where the coefficients on both sides lie higher than by chance.
fn around(segment: &SegmentSpectrum, nu: f64, level: f64) -> f64 {
    let j = nu.round() as usize;
    let low = j.saturating_sub(REACH + FLANK).max(1)..j.saturating_sub(REACH).max(1);
    let high = (j + REACH).min(segment.n)..(j + REACH + FLANK).min(segment.n);
    let (mut sum, mut count) = (0.0, 0.0);
    for j in low.chain(high) {
        if !segment.excluded.iter().any(|r| r.contains(&j)) {
            sum += segment.coefficients[j].powi(2);
            count += 1.0;
        }
    }
    if is_more(sum / level, count) {
        sum / count
    } else {
        level
    }
}

/// What is left between two coefficients over the level, and its degrees of freedom beside the lines' own.
fn left(segment: &SegmentSpectrum, own: &[Line], low: f64, high: f64, level: f64) -> (f64, f64) {
    let first = (low - QUIET).max(1.0) as usize;
    let end = ((high + QUIET) as usize + 1).min(segment.n);
    let sum: f64 = segment.coefficients[first..end].iter().map(|c| c * c).sum();
    let inside = own
        .iter()
        .filter(|l| l.nu >= first as f64 && l.nu < end as f64)
        .count();
    (sum / level, (end - first) as f64 - 3.0 * inside as f64)
}

/// Whether the lines of a group are constant ones.
fn is_constant(segment: &SegmentSpectrum, group: &[Line], own: &[Line]) -> bool {
    let elsewhere = group.iter().any(|other| {
        own.iter()
            .all(|l| (l.u() - other.u()).abs() > resolution(l, other))
    });
    let mut places: Vec<f64> = own.iter().map(|l| l.nu).collect();
    places.sort_by(f64::total_cmp);
    let crowded = places.windows(3).any(|w| w[2] - w[0] < ONE);
    let more = |low: f64, high: f64| {
        let (sum, freedom) = left(segment, own, low, high, own[0].level);
        is_more(sum, freedom)
    };
    let ends = (places[0], places[places.len() - 1]);
    own.len() <= MOST_NEAR
        && !(elsewhere || crowded || more(ends.0, ends.1) || places.iter().any(|&nu| more(nu, nu)))
}

/// Lets the interval of a line that wanders reach over those that it stands for.
fn reach_over(estimate: &mut SinusoidEstimate, group: &[Line], work: &Work) {
    let mut power = 0.0;
    for line in group {
        let f = line.u() / work.step_s;
        let half = WIDTH * line.nu_sigma(line.level) / (2.0 * line.n as f64 * work.step_s);
        let widen = |end: &mut Option<f64>, value: f64, pick: fn(f64, f64) -> f64| {
            *end = end.map(|e| pick(e, value));
        };
        widen(&mut estimate.frequency_hz.lower, f - half, f64::min);
        widen(&mut estimate.frequency_hz.upper, f + half, f64::max);
        if line.segment == group[0].segment {
            power += (line.amplitude * as_sampled(line, work)).powi(2);
        }
    }
    estimate.amplitude.upper = estimate.amplitude.upper.map(|u| u.max(power.sqrt()));
}

/// From the amplitude of means over a step, in units of the scale, to that of the sine.
fn as_sampled(line: &Line, work: &Work) -> f64 {
    let x = std::f64::consts::PI * line.u();
    work.scale * x / x.sin()
}

/// Amplitude and frequency of one of the lines of a group.
struct Estimator<'a> {
    work: &'a Work,
    fitted: &'a NoiseTerms,
    all: &'a [Line],
    is_steady: bool,
}

impl Estimator<'_> {
    fn of(&self, i: usize) -> SinusoidEstimate {
        let line = self.all[i];
        let joint = self.is_steady.then(|| self.intervals(i)).flatten();
        let [amplitude, nu] = joint.unwrap_or_else(|| self.alone(i));
        let unit = as_sampled(&line, self.work);
        let hz = 1.0 / (2.0 * line.n as f64 * self.work.step_s);
        let white = self.fitted.white.powi(2) / self.work.step_s;
        let scaled = |[value, sigma, lower, upper]: [f64; 4], unit: f64| {
            Estimate::detected(
                value * unit,
                lower.max(0.0) * unit,
                upper * unit,
                sigma * unit,
            )
        };
        SinusoidEstimate {
            amplitude: scaled(amplitude, unit),
            frequency_hz: scaled(nu, hz),
            height: line.height,
            share_of_white: if white > 0.0 {
                0.5 * (line.amplitude * self.work.scale).powi(2) / white
            } else {
                f64::INFINITY
            },
            is_steady: self.is_steady,
            is_filtered: line.u() > self.work.cut,
        }
    }

    /// Value, standard deviation and interval of amplitude and ν, from the profile beside the lines that share its
    /// coefficients.
    fn intervals(&self, i: usize) -> Option<[[f64; 4]; 2]> {
        let group = neighbors(self.all, i);
        let lines: Vec<Line> = group.iter().map(|&k| self.all[k]).collect();
        let line = &lines[0];
        let segment = &self.work.segments[line.segment];
        let window = Window::around(&segment.coefficients, &lines);
        let mut tones = lines.iter().flat_map(Line::tone).collect();
        window.fit(&mut tones, None);
        let level = line.level;
        let of = |index: usize| {
            let [sigma, lower, upper] = window.interval(&tones, index, level)?;
            Some([tones[index], sigma, lower, upper])
        };
        Some([of(0)?, of(2)?])
    }

    /// The same of a line alone, from the information, what it leaves around itself being the noise.
    fn alone(&self, i: usize) -> [[f64; 4]; 2] {
        let line = &self.all[i];
        let segment = &self.work.segments[line.segment];
        let (sum, freedom) = left(segment, self.all, line.nu, line.nu, line.level);
        let level = line.level * (sum / freedom.max(1.0)).max(1.0);
        let of =
            |value: f64, sigma: f64| [value, sigma, value - WIDTH * sigma, value + WIDTH * sigma];
        [
            of(line.amplitude, line.amplitude_sigma(level)),
            of(line.nu, line.nu_sigma(level)),
        ]
    }
}
