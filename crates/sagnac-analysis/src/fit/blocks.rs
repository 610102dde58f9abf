//! Means of blocks of samples over all segments of a log, and their covariance under the noise of a fit.
//!
//! Of two blocks of L_i and L_j samples whose centers are D apart, per unit of a term's variance in samples: white δ_ij/L_i;
//! quantization 2/L², −1/(L_i·L_j) of neighbors without a gap; a random walk −D/2, −L/6 of one block; flicker
//! −⟨ln|t|⟩/π, its mean over both blocks by second differences of F(x) = ½x² ln x − ¾x²; a Gauss–Markov process
//! e^{−hD}·s_i·s_j, s = sinh(hL/2)/(hL/2). Random walk and flicker are known up to a constant, which the log's mean takes up:
//! so their covariances hold across gaps, where the likelihood of the segments gives each its own mean.

use super::estimate::Work;
use super::likelihood::{B, FIRST_GM, K, N, Parameters, Q};
use super::types::Segment;
use std::f64::consts::PI;
use std::ops::Range;

/// Most blocks: their matrices are factored a hundred times.
const MOST: usize = 200;
/// Samples of the blocks beside a cut, before they grow.
const FIRST: usize = 10;
/// Growth of the blocks away from a cut.
const GROWTH: f64 = 1.5;
/// Most lines whose leakage into the means is reckoned with.
const MOST_LINES: usize = 8;

/// One block.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// First segment, and sample of it.
    pub segment: usize,
    pub from: usize,
    /// Samples, filled ones among them; the block ends with a segment where it holds several.
    pub samples: usize,
    /// Middle and length in samples of the log's clock.
    middle: f64,
    length: f64,
    /// Samples that were not filled.
    known: f64,
    /// Mean over the log's, in units of the scale.
    pub mean: f64,
    /// Whether samples are lost between the block before and this one.
    pub is_cut: bool,
}

/// All blocks of a log in order of time.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    pub all: Vec<Block>,
    /// Total of samples.
    pub samples: usize,
    lines: Vec<(f64, f64)>,
}

/// Where blocks of one segment begin: fine at cut ends, `largest` in the middle.
fn edges(n: usize, cut: (bool, bool), first: usize, largest: usize) -> Vec<usize> {
    let side = |is_cut: bool| {
        let (mut out, mut size, mut at) = (Vec::new(), first as f64, 0);
        while is_cut && (size as usize) < largest && 2 * (at + size as usize) < n {
            at += size as usize;
            out.push(at);
            size *= GROWTH;
        }
        out
    };
    let (left, right) = (side(cut.0), side(cut.1));
    let (from, to) = (
        left.last().copied().unwrap_or(0),
        n - right.last().copied().unwrap_or(0),
    );
    let parts = (to - from).div_ceil(largest).max(1);
    let mut out = vec![0];
    out.extend(left);
    out.extend((1..parts).map(|i| from + i * (to - from) / parts));
    out.extend(right.iter().rev().map(|r| n - r));
    out.dedup();
    out
}

/// Sum and number of the samples of a range that were not filled.
pub(super) fn known_sum(segment: &Segment<'_>, range: Range<usize>, offset: f64) -> (f64, usize) {
    let mut sum: f64 = segment.samples[range.clone()]
        .iter()
        .map(|y| y - offset)
        .sum();
    let mut count = range.len();
    let first = segment.filled.partition_point(|r| r.end <= range.start);
    for run in segment.filled[first..]
        .iter()
        .take_while(|r| r.start < range.end)
    {
        let lost = run.start.max(range.start)..run.end.min(range.end);
        count -= lost.len();
        sum -= segment.samples[lost]
            .iter()
            .map(|y| y - offset)
            .sum::<f64>();
    }
    (sum, count)
}

impl Blocks {
    /// Blocks of the segments, with a border at each of `places` (segment, sample).
    pub(super) fn new(work: &Work, segments: &[Segment<'_>], places: &[(usize, usize)]) -> Self {
        let samples: usize = segments.iter().map(|s| s.samples.len()).sum();
        let largest = (samples / (MOST / 3)).max(FIRST);
        let mut first = FIRST;
        let mut all = Self::laid(work, segments, places, first, largest);
        while all.len() > MOST && first < largest {
            first *= 2;
            all = Self::laid(work, segments, places, first, largest);
        }
        let mut lines: Vec<_> = work.lines.clone();
        lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        let mut kept: Vec<(f64, f64)> = Vec::new();
        for line in lines {
            // A line is found in every segment.
            let near = |k: &(f64, f64)| (k.0 - line.u()).abs() < 6.0 / line.n as f64;
            if kept.len() < MOST_LINES && !kept.iter().any(near) {
                kept.push((line.u(), 0.5 * line.amplitude * line.amplitude));
            }
        }
        Self {
            all,
            samples,
            lines: kept,
        }
    }

    fn laid(
        work: &Work,
        segments: &[Segment<'_>],
        places: &[(usize, usize)],
        first: usize,
        largest: usize,
    ) -> Vec<Block> {
        let mut out: Vec<Block> = Vec::new();
        // A clock that was set back goes on where it was.
        let mut end = f64::NEG_INFINITY;
        for (s, segment) in segments.iter().enumerate() {
            let n = segment.samples.len();
            let start = (segment.start_s / work.step_s).max(end);
            end = start + n as f64;
            let mut borders = edges(n, (s > 0, s + 1 < segments.len()), first, largest);
            borders.extend(places.iter().filter(|p| p.0 == s && p.1 < n).map(|p| p.1));
            borders.sort_unstable();
            borders.dedup();
            borders.push(n);
            for pair in borders.windows(2) {
                let range = pair[0]..pair[1];
                let (sum, known) = known_sum(segment, range.clone(), work.mean);
                let length = range.len() as f64;
                let block = Block {
                    segment: s,
                    from: range.start,
                    samples: range.len(),
                    middle: start + range.start as f64 + 0.5 * length,
                    length,
                    known: known.max(1) as f64,
                    mean: sum / known.max(1) as f64 / work.scale,
                    is_cut: s > 0 && range.start == 0,
                };
                match out.last_mut() {
                    // Segments too short for a block of their own share one.
                    Some(last) if block.is_cut && last.samples + range.len() <= first => {
                        last.join(&block);
                    }
                    _ => out.push(block),
                }
            }
        }
        out
    }

    /// Middle of block `i` in samples of the log's clock.
    pub(super) fn middle(&self, i: usize) -> f64 {
        self.all[i].middle
    }

    /// Samples of the log's clock from the first to the last.
    pub(super) fn span(&self) -> f64 {
        let ends = self.all.first().zip(self.all.last());
        ends.map_or(1.0, |(a, b)| {
            b.middle + 0.5 * b.length - a.middle + 0.5 * a.length
        })
    }

    fn matrix(
        &self,
        of: impl Fn(&Block, &Block, f64) -> f64,
        own: impl Fn(&Block) -> f64,
    ) -> Vec<f64> {
        let m = self.all.len();
        let mut out = vec![0.0; m * m];
        for i in 0..m {
            out[i * m + i] = own(&self.all[i]);
            for j in 0..i {
                let value = of(
                    &self.all[j],
                    &self.all[i],
                    self.all[i].middle - self.all[j].middle,
                );
                out[i * m + j] = value;
                out[j * m + i] = value;
            }
        }
        out
    }

    /// Covariance of the block means of a random walk of unit variance.
    pub(super) fn walk(&self) -> Vec<f64> {
        let level = self.span();
        self.matrix(|_, _, d| level - 0.5 * d, |b| level - b.length / 6.0)
    }

    /// The same of flicker.
    pub(super) fn flicker(&self) -> Vec<f64> {
        let level = self.span().ln() + 1.0;
        self.matrix(
            |a, b, d| (level - mean_log(a.length, b.length, d)) / PI,
            |b| (level - b.length.ln() + 1.5) / PI,
        )
    }

    /// The same of a Gauss–Markov process with this ln(T_c/dt).
    pub(super) fn markov(&self, log_time: f64) -> Vec<f64> {
        let h = (-log_time).exp();
        // e^{hL/2}·s of one side: what decays over half a block goes with the distance.
        let half = |length: f64| {
            let x = h * length;
            if x < 1e-6 { 1.0 } else { -(-x).exp_m1() / x }
        };
        self.matrix(
            |a, b, d| {
                (-h * (d - 0.5 * (a.length + b.length))).exp() * half(a.length) * half(b.length)
            },
            |b| {
                let x = h * b.length;
                if x < 1e-3 {
                    1.0 - x / 3.0
                } else {
                    2.0 * ((-x).exp_m1() + x) / (x * x)
                }
            },
        )
    }

    /// Covariance of the block means under the parameters of a fit; lines by their amplitudes at any phase.
    pub(super) fn covariance(&self, parameters: &Parameters) -> Vec<f64> {
        let m = self.all.len();
        let mut out = self.matrix(
            |a, b, _| {
                let touch = !b.is_cut && a.segment == b.segment && a.from + a.samples == b.from;
                if touch {
                    -parameters[Q] / (a.length * b.length)
                } else {
                    0.0
                }
            },
            |b| parameters[N] / b.known + 2.0 * parameters[Q] / (b.length * b.length),
        );
        let mut add = |factor: f64, unit: Vec<f64>| {
            for (o, u) in out.iter_mut().zip(unit) {
                *o += factor * u;
            }
        };
        if parameters[K] > 0.0 {
            add(parameters[K], self.walk());
        }
        if parameters[B] > 0.0 {
            add(parameters[B], self.flicker());
        }
        for at in [FIRST_GM, FIRST_GM + 2] {
            if parameters[at] > 0.0 {
                add(parameters[at], self.markov(parameters[at + 1]));
            }
        }
        for &(u, power) in &self.lines {
            let part = |b: &Block| {
                let x = PI * u * b.length;
                if x == 0.0 { 1.0 } else { x.sin() / x }
            };
            add(
                power,
                self.matrix(
                    |a, b, d| (2.0 * PI * u * d).cos() * part(a) * part(b),
                    |b| part(b).powi(2),
                ),
            );
        }
        debug_assert_eq!(out.len(), m * m);
        out
    }

    /// 0 before block `first`, 1 from it on.
    pub(super) fn step(&self, first: usize) -> Vec<f64> {
        (0..self.all.len())
            .map(|i| f64::from(u8::from(i >= first)))
            .collect()
    }
}

impl Block {
    /// Takes the next block in.
    fn join(&mut self, next: &Self) {
        let start = self.middle - 0.5 * self.length;
        let known = self.known + next.known;
        self.mean = (self.mean * self.known + next.mean * next.known) / known;
        self.known = known;
        self.samples += next.samples;
        self.length = next.middle + 0.5 * next.length - start;
        self.middle = start + 0.5 * self.length;
    }
}

/// Mean of ln|t| over two blocks that do not overlap, centers `d` apart.
fn mean_log(a: f64, b: f64, d: f64) -> f64 {
    if d > 10.0 * a.max(b) {
        return d.ln() - (a * a + b * b) / (24.0 * d * d);
    }
    let f = |x: f64| {
        if x > 0.0 {
            0.5 * x * x * x.ln() - 0.75 * x * x
        } else {
            0.0
        }
    };
    let (sum, difference) = (0.5 * (a + b), 0.5 * (a - b));
    (f(d + sum) - f(d + difference) - f(d - difference) + f(d - sum)) / (a * b)
}
