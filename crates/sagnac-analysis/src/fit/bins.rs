//! The coefficients of a log's segments, gathered into bins narrow enough that nothing measurable is lost.
//!
//! The lowest coefficients of each segment stand alone; from there on bins are 4 % wide in frequency, shared by all
//! segments. A bin keeps Σ c², and for regressors Σ c·a and Σ a², so that they are profiled out without the log.

use super::fill::{Fill, variogram};
use super::spectra;
use std::ops::Range;
use std::sync::Arc;

/// One segment's transform.
#[derive(Debug, Clone)]
pub(crate) struct SegmentSpectrum {
    /// Start [s].
    pub start_s: f64,
    /// Length in samples of the transform.
    pub n: usize,
    /// Coefficients c_0 (zero) to c_{n−1}, in units of the scale.
    pub coefficients: Vec<f64>,
    /// Coefficients that belong to lines and stay out, sorted.
    pub excluded: Vec<Range<usize>>,
    /// Runs of coefficients and the share of each that went into the end values of quantization noise; empty where they
    /// were not taken out.
    pub leverage: Vec<(Range<usize>, f64)>,
}

impl SegmentSpectrum {
    /// Number of coefficients among these that the end values took.
    fn leverage_of(&self, range: &Range<usize>) -> f64 {
        let first = self.leverage.partition_point(|(r, _)| r.end <= range.start);
        self.leverage[first..]
            .iter()
            .take_while(|(r, _)| r.start < range.end)
            .map(|(r, share)| (r.end.min(range.end) - r.start.max(range.start)) as f64 * share)
            .sum()
    }
}

/// A column of the regression: its coefficients per segment, from j = 0, zero beyond the end of each list.
pub(crate) type Column = Vec<Vec<f64>>;

/// A run of coefficients of one segment that falls into one bin.
#[derive(Debug, Clone, Copy)]
struct Piece {
    bin: usize,
    first: usize,
    end: usize,
}

/// Where each coefficient of each segment goes.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pieces: Vec<Vec<Piece>>,
    bins: usize,
    /// What filling lost samples made of the spectrum, where any were filled.
    pub fill: Option<Arc<Fill>>,
    /// Whether the end values of quantization noise were taken out.
    pub ends_taken: bool,
    /// Whether processes faster than ten samples are in the fit.
    pub fast: bool,
}

/// Sums over bins of one log.
#[derive(Debug, Clone, Default)]
pub(crate) struct BinnedLog {
    /// Center of each bin, u = f·dt.
    pub u: Vec<f64>,
    /// 4 sin²(πu) at the three Gauss points of each bin.
    pub nodes: Vec<[f64; 3]>,
    /// Effective coefficient number (harmonic mean).
    pub j: Vec<f64>,
    /// Effective segment length (harmonic mean).
    pub n: Vec<f64>,
    /// Coefficients in the bin, each counted by its weight.
    pub count: Vec<f64>,
    /// What a coefficient of the bin counts: 1 where nothing was filled.
    pub weight: Vec<f64>,
    /// What filling made of the spectrum.
    pub fill: Option<Arc<Fill>>,
    /// Whether the end values of quantization noise were taken out.
    pub ends_taken: bool,
    /// Whether processes faster than ten samples are in the fit.
    pub fast: bool,
    /// Σ c².
    pub yy: Vec<f64>,
    /// Σ c·a, a row a bin.
    pub ya: Vec<f64>,
    /// Σ a·a, a full square a bin.
    pub aa: Vec<f64>,
    /// Number of columns.
    pub columns: usize,
    /// Shapes of Q, N, B, K.
    pub basis: [Vec<f64>; 4],
    /// Its step over the one that the parameters are in; none: they are in its own.
    pub step: Option<f64>,
}

const SINGLES: usize = 48;
/// Coefficients of which the ends took more than the rest of this share are left out: what is left is rounding.
const LEAST_LEFT: f64 = 0.1;
const RATIO: f64 = 1.04;

impl Layout {
    /// Bins for segments of these lengths.
    pub(crate) fn new(segments: &[SegmentSpectrum], fill: Option<Arc<Fill>>) -> Self {
        let count = segments.len().max(1);
        let singles = ((SINGLES as f64 / (count as f64).sqrt()) as usize).clamp(3, SINGLES);
        let lowest = segments
            .iter()
            .filter(|s| s.n > singles + 1)
            .map(|s| (singles + 1) as f64 / (2.0 * s.n as f64))
            .fold(0.5, f64::min);
        let grid_of = |u: f64| ((u / lowest).ln() / RATIO.ln()).floor().max(0.0) as usize;
        let mut bins = 0;
        let mut pieces = Vec::with_capacity(segments.len());
        let mut shared: Vec<Option<usize>> = Vec::new();
        for segment in segments {
            let mut own = Vec::new();
            let n = segment.n;
            for j in 1..=singles.min(n.saturating_sub(1)) {
                own.push(Piece {
                    bin: bins,
                    first: j,
                    end: j + 1,
                });
                bins += 1;
            }
            let mut j = singles + 1;
            while j < n {
                let cell = grid_of(j as f64 / (2.0 * n as f64) * (1.0 + 1e-12));
                let upper = lowest * RATIO.powi(cell as i32 + 1) * 2.0 * n as f64;
                let end = (upper.ceil() as usize).clamp(j + 1, n);
                if shared.len() <= cell {
                    shared.resize(cell + 1, None);
                }
                let bin = *shared[cell].get_or_insert_with(|| {
                    bins += 1;
                    bins - 1
                });
                own.push(Piece { bin, first: j, end });
                j = end;
            }
            pieces.push(own);
        }
        Self {
            pieces,
            bins,
            fill,
            ends_taken: false,
            fast: false,
        }
    }

    /// The runs of coefficients of segment `s` that share a bin: first, end.
    pub(crate) fn spans(&self, s: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.pieces[s].iter().map(|p| (p.first, p.end))
    }

    /// Sums the coefficients into bins, those at u > `cut` left out.
    pub(crate) fn sum(
        &self,
        segments: &[SegmentSpectrum],
        columns: &[Column],
        cut: f64,
    ) -> BinnedLog {
        let p = columns.len();
        let bins = self.bins;
        let mut count = vec![0.0; bins];
        let mut yy = vec![0.0; bins];
        let mut ya = vec![0.0; bins * p];
        let mut aa = vec![0.0; bins * p * p];
        let mut inverse_j = vec![0.0; bins];
        let mut inverse_n = vec![0.0; bins];
        let mut low = vec![f64::INFINITY; bins];
        let mut high = vec![0.0_f64; bins];
        for (s, segment) in segments.iter().enumerate() {
            let step = 1.0 / (2.0 * segment.n as f64);
            for piece in &self.pieces[s] {
                let last = ((cut / step).floor() as usize + 1).min(piece.end);
                if last <= piece.first {
                    continue;
                }
                let b = piece.bin;
                let mut number = 0.0;
                let mut add = |range: Range<usize>| {
                    if range.is_empty() {
                        return;
                    }
                    let own = range.len() as f64 - segment.leverage_of(&range);
                    if own < LEAST_LEFT * range.len() as f64 {
                        return;
                    }
                    number += own;
                    yy[b] += sum_of_squares(&segment.coefficients[range.clone()]);
                    for (i, column) in columns.iter().enumerate() {
                        let a = &column[s];
                        let reach = range.start.min(a.len())..range.end.min(a.len());
                        if reach.is_empty() {
                            continue;
                        }
                        ya[b * p + i] +=
                            dot(&segment.coefficients[reach.clone()], &a[reach.clone()]);
                        for (k, other) in columns.iter().enumerate().take(i + 1) {
                            let o = &other[s];
                            let both = reach.start.min(o.len())..reach.end.min(o.len());
                            let value = dot(&a[both.clone()], &o[both]);
                            aa[(b * p + i) * p + k] += value;
                            if k != i {
                                aa[(b * p + k) * p + i] += value;
                            }
                        }
                    }
                };
                let mut at = piece.first;
                for gap in &segment.excluded {
                    if gap.end <= at || gap.start >= last {
                        continue;
                    }
                    add(at..gap.start.max(at));
                    at = gap.end.max(at);
                }
                if at < last {
                    add(at..last);
                }
                if number == 0.0 {
                    continue;
                }
                count[b] += number;
                let middle = 0.5 * (piece.first + last - 1) as f64;
                inverse_j[b] += number / middle;
                inverse_n[b] += number / segment.n as f64;
                if last - piece.first == 1 {
                    low[b] = low[b].min(piece.first as f64 * step);
                    high[b] = high[b].max(piece.first as f64 * step);
                } else {
                    low[b] = low[b].min((piece.first as f64 - 0.5) * step);
                    high[b] = high[b].max((last as f64 - 0.5) * step);
                }
            }
        }
        let mut out = BinnedLog {
            columns: p,
            fill: self.fill.clone(),
            ends_taken: self.ends_taken,
            fast: self.fast,
            ..BinnedLog::default()
        };
        for b in 0..bins {
            if count[b] == 0.0 {
                continue;
            }
            out.push_shape(
                (low[b], high[b]),
                count[b],
                count[b] / inverse_j[b],
                count[b] / inverse_n[b],
            );
            out.yy.push(yy[b]);
            out.ya.extend_from_slice(&ya[b * p..(b + 1) * p]);
            out.aa.extend_from_slice(&aa[b * p * p..(b + 1) * p * p]);
            if let Some(fill) = &self.fill {
                out.weigh_last(fill.weight(0.5 * (low[b] + high[b])));
            }
        }
        out
    }
}

impl BinnedLog {
    /// The bins of one segment of `n` samples without its data, for the information that such a log holds.
    pub(crate) fn empty(n: usize) -> Self {
        let mut out = Self::default();
        let step = 1.0 / (2.0 * n as f64);
        let mut first = 1;
        while first < n {
            let end = if first <= SINGLES {
                first + 1
            } else {
                ((first as f64 * RATIO).ceil() as usize).min(n)
            };
            let number = (end - first) as f64;
            let span = if end - first == 1 {
                (first as f64 * step, first as f64 * step)
            } else {
                ((first as f64 - 0.5) * step, (end as f64 - 0.5) * step)
            };
            out.push_shape(span, number, 0.5 * (first + end - 1) as f64, n as f64);
            out.yy.push(number);
            first = end;
        }
        out
    }

    /// What the two end values add to quantization noise of the shape `q`, where they were not taken out.
    fn ends_of(&self, q: f64, n: f64) -> f64 {
        if self.ends_taken { 0.0 } else { (4.0 - q) / n }
    }

    /// Counts the coefficients of the last bin as `weight` each.
    fn weigh_last(&mut self, weight: f64) {
        let p = self.columns;
        let (ya, aa) = (self.ya.len() - p, self.aa.len() - p * p);
        let last = |all: &mut [f64]| {
            if let Some(last) = all.last_mut() {
                *last *= weight;
            }
        };
        last(&mut self.weight);
        last(&mut self.count);
        last(&mut self.yy);
        self.ya[ya..].iter_mut().for_each(|v| *v *= weight);
        self.aa[aa..].iter_mut().for_each(|v| *v *= weight);
    }

    /// Multiplies the measured values by `factor`.
    pub(crate) fn rescale(&mut self, factor: f64) {
        for y in &mut self.yy {
            *y *= factor * factor;
        }
        for y in &mut self.ya {
            *y *= factor;
        }
    }

    /// Puts the terms in units of another step, `step` times smaller than its own: a variance θ of Q goes with 1/dt², of N
    /// with 1/dt, of B with neither, of K with dt.
    pub(crate) fn at_step(&mut self, step: f64) {
        let factors = [1.0 / (step * step), 1.0 / step, 1.0, step];
        for (shape, factor) in self.basis.iter_mut().zip(factors) {
            for phi in shape {
                *phi *= factor;
            }
        }
        self.step = Some(step);
    }

    /// Adds a bin over u from `span.0` to `span.1` (one coefficient where they are equal).
    fn push_shape(&mut self, span: (f64, f64), count: f64, j: f64, n: f64) {
        let center = 0.5 * (span.0 + span.1);
        let half = 0.5 * (span.1 - span.0);
        let points = [
            center - half * 0.6_f64.sqrt(),
            center,
            center + half * 0.6_f64.sqrt(),
        ];
        // A bin of one number of coefficient has a whole j; others take the smooth form between.
        let j = if half == 0.0 {
            j.round()
        } else {
            j.floor() + 0.5
        };
        self.u.push(center);
        self.nodes.push(points.map(spectra::quantization));
        self.j.push(j);
        self.n.push(n);
        self.count.push(count);
        self.weight.push(1.0);
        let quadrature = |shape: &dyn Fn(f64) -> f64| {
            if half == 0.0 {
                shape(center)
            } else {
                (5.0 * shape(points[0]) + 8.0 * shape(points[1]) + 5.0 * shape(points[2])) / 18.0
            }
        };
        if let Some(fill) = self.fill.clone() {
            // What passes coherently, with the ends' factor, and what the pattern scatters.
            let leak = fill.leak_weights(center);
            let filled = |index: usize, factor: f64, shape: &dyn Fn(f64) -> f64| {
                let scattered: f64 = (0..leak.len()).map(|s| leak[s] * variogram(index, s)).sum();
                factor * quadrature(&|u| fill.transfer(u) * shape(u)) + scattered
            };
            let ends = self.ends_of(quadrature(&spectra::quantization), n);
            let basis = [
                filled(0, 1.0, &spectra::quantization) + ends,
                filled(1, 1.0, &|_| 1.0),
                filled(2, spectra::flicker_end_factor(j), &spectra::flicker),
                filled(3, 1.0, &spectra::random_walk),
            ];
            for (all, own) in self.basis.iter_mut().zip(basis) {
                all.push(own);
            }
            return;
        }
        let q = quadrature(&spectra::quantization);
        self.basis[0].push(q + self.ends_of(q, n));
        self.basis[1].push(1.0);
        self.basis[2].push(quadrature(&spectra::flicker) * spectra::flicker_end_factor(j));
        self.basis[3].push(quadrature(&spectra::random_walk));
    }
}

fn sum_of_squares(x: &[f64]) -> f64 {
    dot(x, x)
}

/// Sum of products in eight lanes, so that the compiler can keep them apart.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut lanes = [0.0_f64; 8];
    let (mut xs, mut ys) = (x.chunks_exact(8), y.chunks_exact(8));
    for (a, b) in (&mut xs).zip(&mut ys) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    let rest: f64 = xs
        .remainder()
        .iter()
        .zip(ys.remainder())
        .map(|(a, b)| a * b)
        .sum();
    lanes.iter().sum::<f64>() + rest
}
