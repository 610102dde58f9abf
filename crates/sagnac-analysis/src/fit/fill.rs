//! What filling lost samples by lines makes of every term's spectrum, and how much a filled log still tells.
//!
//! A filled sample is z = y + e with e = Σ_o h_o·y_o, Σ h = 0, over the two neighbors of its run and itself. Averaged over
//! the log, S_z = A²·S_y + Σ_l cos(2πul)·G(l), A = 1 + Σ a_o cos(2πuo) of the mean weights a, and
//! G(l) = −Σ (ρ − a·a)·V(s) of the pattern's own products ρ at lag l and the term's variogram V. Exact for white and
//! quantization noise. A filled log counts as n² / tr(D C D C) samples, C the covariance of filled white noise and D the
//! inverse of its spectrum: what the likelihood's estimate of N really scatters by. Source: [Whittle1953] for the form.

use super::bins::{BinnedLog, dot};
use super::likelihood::{B, FIRST_GM, K, N, Parameters, Q};
use super::spectra::{self, GaussMarkovShape};
use super::types::Segment;
use std::f64::consts::PI;

/// Below this u every coefficient counts in full: a level that all share is known less well, not each of them.
const FULL_BELOW: f64 = 1.0 / 64.0;
/// Samples of each part of the log in which the weight is worked out, and how many parts.
const PART: usize = 2048;
const PARTS: usize = 8;

/// Share of the level that the ends of a filled segment may put wrong.
const MOST_AT_ENDS: f64 = 0.005;

/// The pattern of filled samples of one log.
#[derive(Debug, Clone)]
pub(crate) struct Fill {
    /// a_o for o = 0, 1, …: mean weights, the same on both sides.
    mean: Vec<f64>,
    /// −(ρ − a·a) of V(s) at lag l, a row a lag.
    kernel: Vec<Vec<f64>>,
    /// Samples that the log counts as, over its samples.
    weight: f64,
    /// Filled samples.
    pub(crate) filled: usize,
}

/// Offsets and weights of e at place `i` (from 1) of a run of `length`.
fn weights(i: usize, length: usize) -> [(isize, f64); 3] {
    let share = i as f64 / (length + 1) as f64;
    [
        (-(i as isize), 1.0 - share),
        (0, -1.0),
        ((length + 1 - i) as isize, share),
    ]
}

impl Fill {
    /// The pattern of the segments; none where nothing was filled.
    pub(crate) fn of(segments: &[Segment<'_>]) -> Option<Self> {
        let runs = || segments.iter().flat_map(|s| s.filled);
        let longest = runs().map(std::ops::Range::len).max()?;
        let filled = runs().map(std::ops::Range::len).sum();
        let samples: usize = segments.iter().map(|s| s.samples.len()).sum();
        let unit = 1.0 / samples as f64;
        let reach = longest + 1;
        let lags = 2 * reach + 1;
        let mut mean = vec![0.0; reach + 1];
        let mut kernel = vec![vec![0.0; lags + 2 * reach + 1]; lags];
        for segment in segments {
            let places: Vec<(usize, [(isize, f64); 3])> = segment
                .filled
                .iter()
                .flat_map(|r| (r.clone()).map(|k| (k, weights(k - r.start + 1, r.len()))))
                .collect();
            for (p, (k, own)) in places.iter().enumerate() {
                for (o, h) in own {
                    // Both sides alike: each place of a run has its mirror image.
                    let half = if *o == 0 { 1.0 } else { 0.5 };
                    mean[o.unsigned_abs()] += half * h * unit;
                }
                for (other, theirs) in &places[p..] {
                    let lag = other - k;
                    if lag >= lags {
                        break;
                    }
                    for (o, h) in own {
                        for (q, g) in theirs {
                            kernel[lag][(lag as isize + q - o).unsigned_abs()] -= h * g * unit;
                        }
                    }
                }
            }
        }
        let reach = reach as isize;
        for (lag, row) in kernel.iter_mut().enumerate() {
            for o in -reach..=reach {
                for q in -reach..=reach {
                    row[(lag as isize + q - o).unsigned_abs()] +=
                        mean[o.unsigned_abs()] * mean[q.unsigned_abs()];
                }
            }
        }
        let mut out = Self {
            mean,
            kernel,
            weight: 1.0,
            filled,
        };
        out.weight = out.information(segments);
        Some(out)
    }

    /// Share of the information that a coefficient at u keeps.
    pub(crate) fn weight(&self, u: f64) -> f64 {
        if u < FULL_BELOW { 1.0 } else { self.weight }
    }

    /// Mean amplitude of what is at u.
    pub(crate) fn amplitude(&self, u: f64) -> f64 {
        1.0 + cosines(&self.mean, u)
    }

    /// A²(u).
    pub(crate) fn transfer(&self, u: f64) -> f64 {
        let a = self.amplitude(u);
        a * a
    }

    /// Number of lags of V that count.
    pub(crate) fn reach(&self) -> usize {
        self.kernel[0].len()
    }

    /// The factor of V(s), s = 0, 1, …, in the part of the spectrum at u that is not coherent.
    pub(crate) fn leak_weights(&self, u: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.reach()];
        for (lag, row) in self.kernel.iter().enumerate() {
            let c = if lag == 0 {
                1.0
            } else {
                2.0 * (2.0 * PI * u * lag as f64).cos()
            };
            for (out, k) in out.iter_mut().zip(row) {
                *out += c * k;
            }
        }
        out
    }

    /// The incoherent part's covariances G(l) of a term with this variogram.
    fn covariances(&self, variogram: impl Fn(usize) -> f64) -> Vec<f64> {
        let v: Vec<f64> = (0..self.reach()).map(variogram).collect();
        self.kernel
            .iter()
            .map(|row| row.iter().zip(&v).map(|(k, v)| k * v).sum())
            .collect()
    }

    /// Covariances of filled white noise of variance `white` a sample and quantization noise of `quantization` (Q²/dt²).
    pub(crate) fn white_covariances(&self, white: f64, quantization: f64) -> Vec<f64> {
        let reach = self.mean.len() as isize - 1;
        let own = |lag: isize| match lag.abs() {
            0 => white + 2.0 * quantization,
            1 => -quantization,
            _ => 0.0,
        };
        let amplitude = |o: isize| self.mean[o.unsigned_abs()] + f64::from(u8::from(o == 0));
        let scattered =
            self.covariances(|s| white * variogram(N, s) + quantization * variogram(Q, s));
        (0..scattered.len().max(2 * self.mean.len() + 2))
            .map(|lag| {
                let mut sum = scattered.get(lag).copied().unwrap_or(0.0);
                for o in -reach..=reach {
                    for p in -reach..=reach {
                        sum += amplitude(o) * amplitude(p) * own(lag as isize + o - p);
                    }
                }
                sum
            })
            .collect()
    }

    /// The spectrum of filled noise from the covariances of the incoherent part and the spectrum before.
    fn spectrum(&self, before: f64, incoherent: &[f64], u: f64) -> f64 {
        self.transfer(u) * before + cosines(incoherent, u)
    }

    /// n²/tr(D C D C) over n, of white noise, from parts of the log spread over it.
    fn information(&self, segments: &[Segment<'_>]) -> f64 {
        const GRID: usize = 512;
        const LAGS: usize = 24;
        let white = self.covariances(|s| variogram(N, s));
        let inverse: Vec<f64> = (0..GRID)
            .map(|i| 1.0 / self.spectrum(1.0, &white, (i as f64 + 0.5) / (2 * GRID) as f64))
            .collect();
        let d: Vec<f64> = (0..=LAGS)
            .map(|lag| {
                let sum: f64 = (0..GRID)
                    .map(|i| inverse[i] * (PI * (i as f64 + 0.5) * lag as f64 / GRID as f64).cos())
                    .sum();
                sum / GRID as f64
            })
            .collect();
        let total: usize = segments.iter().map(|s| s.samples.len()).sum();
        let stride = (total / PARTS).max(PART);
        let (mut count, mut trace, mut next, mut seen) = (0.0, 0.0, 0, 0);
        for segment in segments {
            let n = segment.samples.len();
            while next < seen + n {
                let from = next - seen;
                let to = (from + PART).min(n);
                count += (to - from) as f64;
                trace += self.trace(segment, from, to, &d);
                next += stride;
            }
            seen += n;
        }
        if trace > 0.0 {
            (count / trace).min(1.0)
        } else {
            1.0
        }
    }

    /// tr(D C D C) of samples `from` to `to` of a segment.
    fn trace(&self, segment: &Segment<'_>, from: usize, to: usize, d: &[f64]) -> f64 {
        let n = to - from;
        // Rows of the filling: up to two samples that exist with their weights.
        let mut rows: Vec<[(usize, f64); 2]> = (from..to).map(|k| [(k, 1.0), (k, 0.0)]).collect();
        let first = segment.filled.partition_point(|r| r.end <= from);
        for run in segment.filled[first..].iter().take_while(|r| r.start < to) {
            for k in run.clone().filter(|k| (from..to).contains(k)) {
                let share = (k + 1 - run.start) as f64 / (run.len() + 1) as f64;
                rows[k - from] = [(run.start - 1, 1.0 - share), (run.end, share)];
            }
        }
        let wide = self.mean.len();
        let band = wide + d.len() - 1;
        // C and D·C by diagonals: entry (k, k + o) at [k][o + wide], [k][o + band].
        let covariance = |a: usize, b: usize| -> f64 {
            let mut sum = 0.0;
            for (i, v) in rows[a] {
                for (j, w) in rows[b] {
                    if i == j {
                        sum += v * w;
                    }
                }
            }
            sum
        };
        let mut c = vec![0.0; n * (2 * wide + 1)];
        for a in 0..n {
            for b in a.saturating_sub(wide)..(a + wide + 1).min(n) {
                c[a * (2 * wide + 1) + b + wide - a] = covariance(a, b);
            }
        }
        let mut x = vec![0.0; n * (2 * band + 1)];
        for k in 0..n {
            for a in k.saturating_sub(d.len() - 1)..(k + d.len()).min(n) {
                let factor = d[k.abs_diff(a)];
                for b in a.saturating_sub(wide)..(a + wide + 1).min(n) {
                    x[k * (2 * band + 1) + b + band - k] +=
                        factor * c[a * (2 * wide + 1) + b + wide - a];
                }
            }
        }
        let mut trace = 0.0;
        for k in 0..n {
            for l in k.saturating_sub(band)..(k + band + 1).min(n) {
                trace +=
                    x[k * (2 * band + 1) + l + band - k] * x[l * (2 * band + 1) + k + band - l];
            }
        }
        trace
    }
}

/// Whether the ends of a segment, where what filling does differs from its mean, weigh little.
pub(crate) fn is_long_for_its_losses(segment: &Segment<'_>) -> bool {
    let filled: usize = segment.filled.iter().map(std::ops::Range::len).sum();
    let longest = segment
        .filled
        .iter()
        .map(std::ops::Range::len)
        .max()
        .unwrap_or(0);
    let n = segment.samples.len() as f64;
    (filled * (longest + 1)) as f64 <= MOST_AT_ENDS * n * n
}

/// c_0 + 2 Σ c_l cos(2πul).
fn cosines(c: &[f64], u: f64) -> f64 {
    let turn = 2.0 * (2.0 * PI * u).cos();
    let (mut before, mut now) = (0.5 * turn, 1.0);
    let mut sum = c[0];
    for c in &c[1..] {
        let next = turn * now - before;
        (before, now) = (now, next);
        sum += 2.0 * c * now;
    }
    sum
}

/// Half the mean square of y_{k+s} − y_k of a single term (Q, N, B, K), per unit of its variance parameter.
pub(crate) fn variogram(index: usize, s: usize) -> f64 {
    if s == 0 {
        return 0.0;
    }
    let x = s as f64;
    match index {
        Q if s == 1 => 3.0,
        Q => 2.0,
        B => {
            let term = |k: f64| if k > 0.0 { k * k * k.ln() } else { 0.0 };
            (term(x + 1.0) - 2.0 * term(x) + term(x - 1.0)) / (2.0 * PI)
        }
        K => 0.5 * x - 1.0 / 6.0,
        _ => 1.0,
    }
}

/// What filling made of the spectrum in every bin of several logs, for terms whose shape is not known beforehand.
#[derive(Debug, Clone)]
pub(crate) struct FilledBins {
    /// A² at the three nodes of every bin.
    transfer: Vec<[f64; 3]>,
    /// Factors of the variogram, `reach` a bin.
    leak: Vec<f64>,
    reach: usize,
}

impl FilledBins {
    /// The bins of all logs; none where nothing was filled in any.
    pub(crate) fn of(logs: &[&BinnedLog]) -> Option<Self> {
        let fills = logs.iter().filter_map(|log| log.fill.as_deref());
        let reach = fills.map(Fill::reach).max()?;
        let mut out = Self {
            transfer: Vec::new(),
            leak: Vec::new(),
            reach,
        };
        for log in logs {
            for (u, nodes) in log.u.iter().zip(&log.nodes) {
                // Of 4 sin²(πu) back to u.
                let place = |node: f64| (0.5 * node.sqrt()).min(1.0).asin() / PI;
                let fill = log.fill.as_ref();
                let a2 = |node: f64| fill.map_or(1.0, |f| f.transfer(place(node)));
                out.transfer.push(nodes.map(a2));
                let mut row = fill.map_or(Vec::new(), |f| f.leak_weights(*u));
                row.resize(reach, 0.0);
                out.leak.extend(row);
            }
        }
        Some(out)
    }

    /// What of a process passes coherently into bin `b`, from 4 sin²(πu) at its nodes.
    pub(crate) fn coherent(&self, b: usize, shape: &GaussMarkovShape, nodes: [f64; 3]) -> f64 {
        let [low, middle, high] = self.transfer[b];
        (5.0 * low * shape.at(nodes[0])
            + 8.0 * middle * shape.at(nodes[1])
            + 5.0 * high * shape.at(nodes[2]))
            / 18.0
    }

    /// Adds what the pattern scatters of a process in these bins.
    pub(crate) fn add_scattered(
        &self,
        out: &mut [f64],
        bins: std::ops::Range<usize>,
        shape: &GaussMarkovShape,
    ) {
        let v: Vec<f64> = (0..self.reach).map(|s| shape.variogram(s)).collect();
        let leak = self.leak.chunks_exact(self.reach).skip(bins.start);
        for (out, leak) in out[bins].iter_mut().zip(leak) {
            *out += dot(leak, &v);
        }
    }
}

/// The fitted spectrum at any u, of a filled log as of a whole one.
pub(crate) struct FittedSpectrum<'a> {
    parameters: Parameters,
    fill: Option<(&'a Fill, Vec<f64>)>,
}

impl<'a> FittedSpectrum<'a> {
    pub(crate) fn new(parameters: &Parameters, fill: Option<&'a Fill>) -> Self {
        let fill = fill.map(|fill| {
            let mut all = vec![0.0; fill.kernel.len()];
            let mut add = |factor: f64, g: Vec<f64>| {
                for (all, g) in all.iter_mut().zip(g) {
                    *all += factor * g;
                }
            };
            for k in [Q, N, B, K] {
                if parameters[k] > 0.0 {
                    add(parameters[k], fill.covariances(|s| variogram(k, s)));
                }
            }
            for at in [FIRST_GM, FIRST_GM + 2] {
                if parameters[at] > 0.0 {
                    let shape = GaussMarkovShape::new((-parameters[at + 1]).exp());
                    add(parameters[at], fill.covariances(|s| shape.variogram(s)));
                }
            }
            (fill, all)
        });
        Self {
            parameters: *parameters,
            fill,
        }
    }

    /// Variance of a coefficient at u, without the ends' corrections.
    pub(crate) fn at(&self, u: f64) -> f64 {
        let before = plain(&self.parameters, u);
        match &self.fill {
            Some((fill, incoherent)) => fill.spectrum(before, incoherent, u),
            None => before,
        }
    }
}

/// Spectrum of the parameters at u where nothing was filled.
fn plain(parameters: &Parameters, u: f64) -> f64 {
    let mut s = parameters[N];
    if parameters[Q] > 0.0 {
        s += parameters[Q] * spectra::quantization(u);
    }
    if parameters[B] > 0.0 {
        s += parameters[B] * spectra::flicker(u);
    }
    if parameters[K] > 0.0 {
        s += parameters[K] * spectra::random_walk(u);
    }
    for g in 0..2 {
        let at = FIRST_GM + 2 * g;
        if parameters[at] > 0.0 {
            let shape = GaussMarkovShape::new((-parameters[at + 1]).exp());
            s += parameters[at] * shape.at(spectra::quantization(u));
        }
    }
    s
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use std::ops::Range;

    /// Runs of 1 to `most` lost samples among `n`, from a simple generator.
    fn pattern(n: usize, share: f64, most: usize) -> Vec<Range<usize>> {
        let mut state = 12345_u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut out: Vec<Range<usize>> = Vec::new();
        let mut k = 1;
        while k + most + 1 < n {
            if draw() < share {
                let long = 1 + (draw() * most as f64) as usize;
                out.push(k..k + long);
                k += long;
            }
            k += 1;
        }
        out
    }

    /// Averaged covariances of the filled process from its definition, of covariance `r`.
    fn averaged(
        n: usize,
        runs: &[Range<usize>],
        r: impl Fn(usize) -> f64,
        lags: usize,
    ) -> Vec<f64> {
        let mut rows: Vec<Vec<(usize, f64)>> = (0..n).map(|k| vec![(k, 1.0)]).collect();
        for run in runs {
            for k in run.clone() {
                let share = (k + 1 - run.start) as f64 / (run.len() + 1) as f64;
                rows[k] = vec![(run.start - 1, 1.0 - share), (run.end, share)];
            }
        }
        (0..lags)
            .map(|lag| {
                let mut sum = 0.0;
                for k in 0..n - lag {
                    for (i, v) in &rows[k] {
                        for (j, w) in &rows[k + lag] {
                            sum += v * w * r(i.abs_diff(*j));
                        }
                    }
                }
                sum / n as f64
            })
            .collect()
    }

    fn fill_of(n: usize, runs: &[Range<usize>]) -> Fill {
        let samples = vec![0.0; n];
        Fill::of(&[Segment {
            start_s: 0.0,
            samples: &samples,
            filled: runs,
        }])
        .unwrap()
    }

    #[test]
    fn filled_white_and_quantization_noise_have_the_spectrum_of_their_definition() {
        let n = 6000;
        let periodic: Vec<Range<usize>> = (10..n - 1).step_by(50).map(|k| k..k + 1).collect();
        for runs in [
            pattern(n, 0.1, 1),
            pattern(n, 0.2, 1),
            pattern(n, 0.04, 5),
            periodic,
        ] {
            let fill = fill_of(n, &runs);
            for (index, r) in [(N, [1.0, 0.0]), (Q, [2.0, -1.0])] {
                let want = averaged(n, &runs, |s| r.get(s).copied().unwrap_or(0.0), 30);
                let mut parameters = [0.0; 8];
                parameters[index] = 1.0;
                let got = FittedSpectrum::new(&parameters, Some(&fill));
                for i in 0..40 {
                    let u = 0.5 * (f64::from(i) + 0.5) / 40.0;
                    let want = cosines(&want, u);
                    assert!(
                        (got.at(u) - want).abs() < 2e-3,
                        "{index} {u} {} {want}",
                        got.at(u)
                    );
                }
            }
        }
    }

    #[test]
    fn isolated_losses_move_power_down_as_their_share_says() {
        let n = 40_000;
        let runs: Vec<Range<usize>> = (10..n - 1).step_by(40).map(|k| k..k + 1).collect();
        let p = 1.0 / 40.0;
        let fill = fill_of(n, &runs);
        let mut parameters = [0.0; 8];
        parameters[N] = 1.0;
        let got = FittedSpectrum::new(&parameters, Some(&fill));
        // r_0 = 1 − p/2, r_1 = p, r_2 = 0: the neighbors of a lost sample are whole.
        for u in [0.01, 0.2, 0.45] {
            let want = 1.0 - 0.5 * p + 2.0 * p * (2.0 * PI * u).cos();
            assert!((got.at(u) - want).abs() < 1e-4, "{u} {} {want}", got.at(u));
        }
    }

    #[test]
    fn a_filled_process_with_a_time_keeps_its_spectrum_up_to_what_the_pattern_makes_of_it() {
        let n = 20_000;
        let runs = pattern(n, 0.1, 3);
        let fill = fill_of(n, &runs);
        let shape = GaussMarkovShape::new(0.1);
        let variance = shape.variogram(100_000);
        let lags = 200;
        let want = averaged(n, &runs, |s| variance - shape.variogram(s), lags);
        let mut parameters = [0.0; 8];
        parameters[FIRST_GM] = 1.0;
        parameters[FIRST_GM + 1] = 10_f64.ln();
        let got = FittedSpectrum::new(&parameters, Some(&fill));
        for u in [0.003, 0.02, 0.1, 0.3, 0.48] {
            let want = cosines(&want, u);
            assert!(
                (got.at(u) / want - 1.0).abs() < 0.02,
                "{u} {} {want}",
                got.at(u)
            );
        }
    }

    #[test]
    fn a_filled_log_counts_as_fewer_samples_than_it_has() {
        // Dense matrices of 1500 samples: 0.871 at 10.2 %, 0.876 at every tenth.
        let n = 4000;
        let runs: Vec<Range<usize>> = (5..n - 1).step_by(10).map(|k| k..k + 1).collect();
        let weight = fill_of(n, &runs).weight(0.3);
        assert!((weight - 0.876).abs() < 0.003, "{weight}");
        assert!((fill_of(n, &runs).weight(0.001) - 1.0).abs() < 1e-12);
    }
}
