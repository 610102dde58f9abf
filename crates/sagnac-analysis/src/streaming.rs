//! Deviations of a log that does not fit in memory: starts at least every τ/64.
//!
//! Below m = 1024 every start is used, as in the exact estimate; above, starts stand a power of
//! two apart, between m/128 and m/64, so each octave keeps 64 to 128 starts per τ and the mean
//! loses less than 1 % of its efficiency `[GREENHALL]`. Memory grows with the number of τ alone.

use crate::deviation::kernel::{second_of_slices, third_of_slices};
use crate::deviation::{Curve, Deviation, Estimate, Sum, assemble, hdev, oadev};
use crate::error::Error;
use crate::noise_type::{NoiseType, Reading};

/// Factors below this use every start.
const NEAR: usize = 1024;
/// Starts or middle points of a tile of the near factors.
const TILE: usize = 1024;
/// Samples taken through all factors while they are in the cache.
const BLOCK: usize = 1 << 13;
/// Starts per τ kept at least.
const STARTS: usize = 64;
/// Phase points of each factor from which its noise type is told: the first of the log.
const POINTS: usize = 1024;

/// A deviation under way: push samples, get the curve at the end.
///
/// For `oadev`, `hdev` and `adev` (whose starts do not overlap: exact).
///
/// ```
/// use sagnac_analysis::{Deviation, DeviationStream};
///
/// let mut stream = DeviationStream::new(Deviation::Oadev, vec![1, 2, 4])?;
/// for block in 0..10 {
///     let samples: Vec<f64> = (0..100).map(|k| f64::from((block * 100 + k) * 7919 % 101)).collect();
///     stream.push(&samples);
/// }
/// let curve = stream.finish(0.01)?;
/// assert_eq!(curve.samples_used, [999, 997, 993]);
/// # Ok::<(), sagnac_analysis::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DeviationStream {
    kind: Deviation,
    factors: Vec<usize>,
    /// Factors below [`NEAR`] (none for adev).
    near_count: usize,
    near: Near,
    far: Vec<Far>,
    types: Vec<Points>,
    /// Samples of the segments that ended.
    lengths: Vec<usize>,
    /// Samples of the segment under way.
    samples: usize,
    /// Taken off each sample of the segment: its first block's mean.
    offset: f64,
    phase: f64,
    block: Vec<f64>,
}

impl DeviationStream {
    /// A stream for the averaging factors m, in any order.
    ///
    /// # Errors
    /// [`Error::NotStreaming`] for deviations other than `oadev`, `adev`, `hdev`.
    pub fn new(kind: Deviation, mut factors: Vec<usize>) -> Result<Self, Error> {
        if !matches!(kind, Deviation::Oadev | Deviation::Adev | Deviation::Hdev) {
            return Err(Error::NotStreaming {
                kind: kind.full_name(),
            });
        }
        factors.retain(|&m| m > 0);
        factors.sort_unstable();
        factors.dedup();
        let near_count = if kind == Deviation::Adev {
            0
        } else {
            factors.partition_point(|&m| m < NEAR)
        };
        Ok(Self {
            kind,
            near_count,
            near: Near::new(near_count),
            far: factors[near_count..]
                .iter()
                .map(|&m| Far::new(kind, m))
                .collect(),
            types: factors.iter().map(|&m| Points::new(m)).collect(),
            factors,
            lengths: Vec::new(),
            samples: 0,
            offset: 0.0,
            phase: 0.0,
            block: Vec::new(),
        })
    }

    /// Adds samples that follow those before without a gap.
    pub fn push(&mut self, samples: &[f64]) {
        for chunk in samples.chunks(BLOCK) {
            let first = self.samples == 0;
            if first {
                self.offset = chunk.iter().sum::<f64>() / chunk.len() as f64;
                self.phase = 0.0;
            }
            self.block.clear();
            if first {
                self.block.push(0.0);
            }
            let mut x = self.phase;
            let offset = self.offset;
            self.block.extend(chunk.iter().map(|y| {
                x += y - offset;
                x
            }));
            self.phase = x;
            let start = if first { 0 } else { self.samples + 1 };
            self.samples += chunk.len();
            self.near
                .push(self.kind, &self.factors[..self.near_count], &self.block);
            for far in &mut self.far {
                far.push(start, &self.block);
            }
            for points in &mut self.types {
                points.push(start, &self.block);
            }
        }
    }

    /// Ends the segment: the next samples follow after a gap.
    pub fn end_segment(&mut self) {
        if self.samples == 0 {
            return;
        }
        self.near.flush(self.kind, &self.factors[..self.near_count]);
        for far in &mut self.far {
            far.restart();
        }
        for points in &mut self.types {
            points.end_segment();
        }
        self.lengths.push(self.samples);
        self.samples = 0;
    }

    /// Samples of the longest segment so far.
    pub fn longest(&self) -> usize {
        self.lengths
            .iter()
            .copied()
            .max()
            .unwrap_or(0)
            .max(self.samples)
    }

    /// The curve at the step `dt_s`, of the factors for which there were samples enough.
    ///
    /// # Errors
    /// [`Error::TooShort`] where there is none; [`Error::NotPositive`] for the step.
    pub fn finish(self, dt_s: f64) -> Result<Curve, Error> {
        let factors = self.factors.clone();
        self.finish_at(dt_s, &factors)
    }

    /// As [`Self::finish`], at some of the factors: those of a grid that depends on the length.
    ///
    /// # Errors
    /// Those of [`Self::finish`].
    pub fn finish_at(mut self, dt_s: f64, wanted: &[usize]) -> Result<Curve, Error> {
        if !(dt_s.is_finite() && dt_s > 0.0) {
            return Err(Error::NotPositive {
                name: "the sampling step",
                value_s: dt_s,
            });
        }
        self.end_segment();
        let (mut factors, mut sums, mut types) = (Vec::new(), Vec::new(), Vec::new());
        let mut last = 0;
        let mut sure: Option<Reading> = None;
        let most = if self.kind == Deviation::Hdev { 3 } else { 2 };
        for (k, &m) in self.factors.iter().enumerate() {
            let reading = Reading::new(&self.types[k].segments(), 1, most);
            sure = reading.filter(Reading::is_sure).or(sure).or(reading);
            let sum = if k < self.near_count {
                Sum {
                    squares: self.near.sums[k],
                    terms: self.lengths.iter().map(|&n| self.kind.terms(n, m)).sum(),
                }
            } else {
                self.far[k - self.near_count].sum
            };
            if sum.terms == 0 || wanted.binary_search(&m).is_err() {
                continue;
            }
            last = reading.map_or(last, |r| r.alpha_beside(sure.as_ref()));
            factors.push(m);
            sums.push(sum);
            types.push(NoiseType {
                alpha: last,
                measured: reading.is_some(),
            });
        }
        if factors.is_empty() {
            return Err(Error::TooShort {
                kind: self.kind.full_name(),
                needed: self
                    .kind
                    .least_samples(self.factors.first().copied().unwrap_or(1)),
                found: self.longest(),
            });
        }
        Ok(assemble(
            self.kind,
            Estimate::Strided,
            dt_s,
            &self.lengths,
            &factors,
            &sums,
            &types,
        ))
    }
}

/// The small factors: every start, on a stretch of phase that moves along.
#[derive(Debug, Clone)]
struct Near {
    /// Phase points not yet done with, and as many before as a difference reaches back.
    phase: Vec<f64>,
    /// First middle point (start, for hdev) in `phase` that is not in the sums.
    next: usize,
    sums: Vec<f64>,
}

impl Near {
    fn new(count: usize) -> Self {
        Self {
            phase: Vec::new(),
            next: 0,
            sums: vec![0.0; count],
        }
    }

    fn push(&mut self, kind: Deviation, factors: &[usize], block: &[f64]) {
        let Some(&largest) = factors.last() else {
            return;
        };
        self.phase.extend_from_slice(block);
        let (ahead, behind) = match kind {
            Deviation::Hdev => (3 * largest, 0),
            _ => (largest, largest),
        };
        while self.next + TILE + ahead <= self.phase.len() {
            self.tile(kind, factors, TILE);
        }
        let drop = self.next.saturating_sub(behind);
        if drop >= BLOCK {
            self.phase.drain(..drop);
            self.next -= drop;
        }
    }

    fn tile(&mut self, kind: Deviation, factors: &[usize], count: usize) {
        let tile = if kind == Deviation::Hdev {
            hdev::tile
        } else {
            oadev::tile
        };
        tile(&self.phase, self.next, count, factors, &mut self.sums);
        self.next += count;
    }

    fn flush(&mut self, kind: Deviation, factors: &[usize]) {
        if !factors.is_empty() {
            while self.next < self.phase.len() {
                self.tile(kind, factors, TILE.min(self.phase.len() - self.next));
            }
        }
        self.phase.clear();
        self.next = 0;
    }
}

/// A large factor: starts a stride apart, each point of the difference in a queue of its own.
#[derive(Debug, Clone)]
struct Far {
    m: usize,
    stride: usize,
    legs: Vec<Leg>,
    sum: Sum,
}

/// Phases at start + k·m for one k.
#[derive(Debug, Clone)]
struct Leg {
    waiting: Vec<f64>,
    /// Index of the next phase point to take.
    next: usize,
}

impl Far {
    fn new(kind: Deviation, m: usize) -> Self {
        let legs = if kind == Deviation::Hdev { 4 } else { 3 };
        let stride = if kind == Deviation::Adev {
            m
        } else {
            1 << (m / STARTS).max(1).ilog2()
        };
        Self {
            m,
            stride,
            legs: (0..legs)
                .map(|k| Leg {
                    waiting: Vec::new(),
                    next: k * m,
                })
                .collect(),
            sum: Sum::default(),
        }
    }

    fn push(&mut self, start: usize, block: &[f64]) {
        let end = start + block.len();
        for leg in &mut self.legs {
            if leg.next < end {
                let points = block[leg.next - start..].iter().step_by(self.stride);
                let before = leg.waiting.len();
                leg.waiting.extend(points);
                leg.next += (leg.waiting.len() - before) * self.stride;
            }
        }
        let ready = self.legs.last().map_or(0, |leg| leg.waiting.len());
        // Small batches cost more than they are worth; the rest comes with the restart.
        if ready >= 32 || ready > 0 && self.stride >= BLOCK / 32 {
            self.take(ready);
        }
    }

    /// Adds `count` terms, whose points are all there.
    fn take(&mut self, count: usize) {
        let at = |k: usize| &self.legs[k].waiting[..count];
        self.sum.squares += if self.legs.len() == 3 {
            second_of_slices(at(0), at(1), at(2))
        } else {
            third_of_slices([at(0), at(1), at(2), at(3)])
        };
        self.sum.terms += count as u64;
        for leg in &mut self.legs {
            leg.waiting.drain(..count);
        }
    }

    fn restart(&mut self) {
        let ready = self.legs.last().map_or(0, |leg| leg.waiting.len());
        self.take(ready);
        for (k, leg) in self.legs.iter_mut().enumerate() {
            leg.waiting.clear();
            leg.next = k * self.m;
        }
    }
}

/// The first phase points of a factor, for its noise type.
#[derive(Debug, Clone)]
struct Points {
    m: usize,
    next: usize,
    values: Vec<f64>,
    /// Ends of the segments in `values`.
    ends: Vec<usize>,
}

impl Points {
    fn new(m: usize) -> Self {
        Self {
            m,
            next: 0,
            values: Vec::new(),
            ends: Vec::new(),
        }
    }

    fn push(&mut self, start: usize, block: &[f64]) {
        let end = start + block.len();
        if self.values.len() >= POINTS || self.next >= end {
            return;
        }
        let room = POINTS - self.values.len();
        let points = block[self.next - start..].iter().step_by(self.m).take(room);
        let before = self.values.len();
        self.values.extend(points);
        self.next += (self.values.len() - before) * self.m;
    }

    fn end_segment(&mut self) {
        self.next = 0;
        if self.ends.last() != Some(&self.values.len()) {
            self.ends.push(self.values.len());
        }
    }

    fn segments(&self) -> Vec<&[f64]> {
        let mut start = 0;
        self.ends
            .iter()
            .map(|&end| {
                let segment = &self.values[start..end];
                start = end;
                segment
            })
            .filter(|segment| !segment.is_empty())
            .collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::deviation::deviations;
    use crate::tau_grid::TauGrid;

    fn walk(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut drift = 0.0;
        (0..count)
            .map(|_| {
                let mut uniform = || {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
                };
                drift += 1e-3 * uniform();
                9.8 + drift + uniform()
            })
            .collect()
    }

    fn stream(kind: Deviation, segments: &[&[f64]], factors: &[usize], pieces: usize) -> Curve {
        let mut stream = DeviationStream::new(kind, factors.to_vec()).unwrap();
        for segment in segments {
            for piece in segment.chunks(pieces) {
                stream.push(piece);
            }
            stream.end_segment();
        }
        stream.finish(0.5).unwrap()
    }

    #[test]
    fn small_factors_and_adev_are_exact() {
        let samples = walk(50_000, 3);
        let segments: [&[f64]; 3] = [
            &samples[..20_000],
            &samples[20_000..20_001],
            &samples[20_001..],
        ];
        for kind in [Deviation::Oadev, Deviation::Hdev, Deviation::Adev] {
            let exact = deviations(&segments, 0.5, kind, &TauGrid::Default).unwrap();
            for pieces in [1, 777, 50_000] {
                if pieces == 1 && kind != Deviation::Oadev {
                    continue;
                }
                let got = stream(kind, &segments, &exact.factor, pieces);
                assert_eq!(got.factor, exact.factor);
                for k in 0..got.len() {
                    if exact.factor[k] < NEAR || kind == Deviation::Adev {
                        let relative = got.deviation[k] / exact.deviation[k] - 1.0;
                        assert!(
                            relative.abs() < 1e-9,
                            "{kind:?} {} {relative}",
                            exact.factor[k]
                        );
                        assert_eq!(got.samples_used[k], exact.samples_used[k]);
                    } else {
                        // Starts at least every τ/64: less than 1 % of the scatter is lost, and
                        // the two estimates differ by less than a tenth of it.
                        let sigma = (0.5 / exact.edf[k].unwrap()).sqrt();
                        let relative = got.deviation[k] / exact.deviation[k] - 1.0;
                        assert!(
                            relative.abs() < 0.1 * sigma,
                            "{} {relative}",
                            exact.factor[k]
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn strided_starts_lose_less_than_a_percent_of_efficiency() {
        // Variance ratio over 400 logs of white noise, at 2048 of 16384 samples.
        let (mut exact, mut strided) = (Vec::new(), Vec::new());
        for seed in 0..400 {
            let samples: Vec<f64> = walk(16_384, 1000 + seed);
            let factors = vec![2048];
            let got = stream(Deviation::Oadev, &[&samples], &factors, 4096);
            strided.push(got.deviation[0].powi(2));
            let times = TauGrid::Times(vec![1024.0]);
            let all = deviations(&[&samples], 0.5, Deviation::Oadev, &times).unwrap();
            exact.push(all.deviation[0].powi(2));
        }
        let variance = |v: &[f64]| {
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            v.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / v.len() as f64
        };
        let loss = variance(&strided) / variance(&exact) - 1.0;
        assert!(loss < 0.01, "{loss}");
    }

    #[test]
    fn other_deviations_are_refused() {
        let error = DeviationStream::new(Deviation::Totdev, vec![1]);
        assert!(matches!(error, Err(Error::NotStreaming { .. })));
        let empty = DeviationStream::new(Deviation::Oadev, vec![4]).unwrap();
        assert!(matches!(empty.finish(1.0), Err(Error::TooShort { .. })));
    }
}
