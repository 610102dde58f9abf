//! The power-law noise type α at each averaging time, from the lag-1 autocorrelation.
//!
//! Every m-th phase point, a quadratic removed; difference until ρ = r/(1 + r) < 1/4, then
//! α = 2 − 2d − round(2ρ) `[RILEY]`. α = 2 is white phase (quantization), 0 white, −1
//! flicker, −2 random walk.
//!
//! With fewer than 256 points the autocorrelation scatters by as much as types lie apart. There the type of the largest m
//! that has 256 stays, unless the autocorrelation of the differences that told it has left its value there by more than
//! three standard errors: that of a power law is the same at every m.

use crate::deviation::kernel;

/// Points that the autocorrelation needs.
const LEAST_POINTS: usize = 30;
/// Points from which it tells the type alone: three standard errors are 0.19, white lies 0.2 from the next type.
const SURE_POINTS: usize = 256;
/// Standard errors (1/√n) of the autocorrelation from which fewer points tell another type.
const ERRORS: f64 = 3.0;

/// The noise type that an interval was computed for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoiseType {
    /// Exponent of the spectrum of the rate, S ∝ f^α, −4…2.
    pub alpha: i8,
    /// Whether this averaging time had the points to tell (else α comes from the largest that
    /// had, or is 0 where none had).
    pub measured: bool,
}

/// The noise type at every averaging factor, from the phases of all segments.
///
/// `most_differences` is 2, for the Hadamard deviation 3. A segment of the phase has a point
/// more than it has samples. Fewer than 30 points in all: the α of the largest factor that had
/// them.
pub(crate) fn noise_types(
    phases: &[&[f64]],
    factors: &[usize],
    most_differences: usize,
) -> Vec<NoiseType> {
    use rayon::prelude::*;
    let readings: Vec<Option<Reading>> = factors
        .par_iter()
        .map(|&m| Reading::new(phases, m, most_differences))
        .collect();
    let sure = Reading::new(phases, largest_sure_factor(phases), most_differences);
    let mut last = 0;
    readings
        .into_iter()
        .map(|reading| {
            let measured = reading.is_some();
            last = reading.map_or(last, |r| r.alpha_beside(sure.as_ref()));
            NoiseType {
                alpha: last,
                measured,
            }
        })
        .collect()
}

/// The largest factor with points enough to tell the type alone; 1 where there are few in all.
fn largest_sure_factor(phases: &[&[f64]]) -> usize {
    let total: usize = phases.iter().map(|phase| phase.len()).sum();
    (1..=total / SURE_POINTS)
        .rev()
        .find(|&m| points_at(phases, m) >= SURE_POINTS)
        .unwrap_or(1)
}

fn points_at(phases: &[&[f64]], m: usize) -> usize {
    phases.iter().map(|phase| (phase.len() - 1) / m + 1).sum()
}

/// What the points of one averaging factor say of the noise type.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reading {
    points: usize,
    /// Differences after which the type was told.
    differences: usize,
    /// Lag-1 autocorrelation by the number of differences, as far as it was needed.
    autocorrelation: [f64; 4],
    /// The type that this factor alone tells.
    alpha: i8,
}

impl Reading {
    /// From every m-th point; none where there are too few.
    pub(crate) fn new(phases: &[&[f64]], m: usize, most_differences: usize) -> Option<Self> {
        let points = points_at(phases, m);
        if points < LEAST_POINTS {
            return None;
        }
        let gather = |most: usize| {
            let mut lagged = [Lagged::default(); 4];
            for phase in phases {
                accumulate(Thinned { phase, m }, most, &mut lagged);
            }
            lagged.map(|sums| sums.autocorrelation())
        };
        // White noise of the rate, the common case, is told from the first differences.
        let mut known = if points < SURE_POINTS {
            most_differences
        } else {
            1
        };
        let mut autocorrelation = gather(known);
        let mut differences = 0;
        loop {
            if differences > known {
                known = most_differences;
                autocorrelation = gather(known);
            }
            let r = autocorrelation[differences];
            let rho = r / (1.0 + r);
            if rho < 0.25 || differences == most_differences {
                let alpha = 2.0 - 2.0 * differences as f64 - (2.0 * rho).round();
                let lowest = if most_differences > 2 { -4.0 } else { -2.0 };
                return Some(Self {
                    points,
                    differences,
                    autocorrelation,
                    alpha: alpha.clamp(lowest, 2.0) as i8,
                });
            }
            differences += 1;
        }
    }

    /// Whether there are points enough to tell the type alone.
    pub(crate) fn is_sure(&self) -> bool {
        self.points >= SURE_POINTS
    }

    /// The type, that of a smaller factor which is sure unless these points contradict it.
    pub(crate) fn alpha_beside(&self, sure: Option<&Self>) -> i8 {
        match sure {
            Some(sure) if !self.is_sure() => {
                let d = sure.differences;
                let change = (self.autocorrelation[d] - sure.autocorrelation[d]).abs();
                if change > ERRORS / (self.points as f64).sqrt() {
                    self.alpha
                } else {
                    sure.alpha
                }
            }
            _ => self.alpha,
        }
    }
}

/// Every m-th point of a phase.
#[derive(Clone, Copy)]
struct Thinned<'a> {
    phase: &'a [f64],
    m: usize,
}

impl<'a> Thinned<'a> {
    fn len(self) -> usize {
        self.phase.len().div_ceil(self.m)
    }

    /// Points start…start + count − 1, in place where they lie side by side.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "see accumulate_plain")]
    fn block<'b>(self, start: usize, count: usize, space: &'b mut [f64; BLOCK + 4]) -> &'b [f64]
    where
        'a: 'b,
    {
        if self.m == 1 {
            return &self.phase[start..][..count];
        }
        let strided = self.phase[start * self.m..].iter().step_by(self.m);
        for (to, from) in space[..count].iter_mut().zip(strided) {
            *to = *from;
        }
        &space[..count]
    }
}

/// Σ z_k² and Σ z_k z_{k+1} about the mean.
#[derive(Debug, Clone, Copy, Default)]
struct Lagged {
    squares: f64,
    products: f64,
}

impl Lagged {
    /// Lag-1 autocorrelation; 0 for a series that does not move.
    fn autocorrelation(&self) -> f64 {
        if self.squares > 0.0 {
            self.products / self.squares
        } else {
            0.0
        }
    }
}

/// Adds the sums of one segment for its residual from a quadratic and the differences of that.
#[allow(
    unsafe_code,
    reason = "calls itself compiled for wider vectors: half the time of the whole curve"
)]
fn accumulate(points: Thinned, most_differences: usize, lagged: &mut [Lagged; 4]) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f")]
        fn with_512(points: Thinned, most_differences: usize, lagged: &mut [Lagged; 4]) {
            accumulate_plain(points, most_differences, lagged);
        }
        #[target_feature(enable = "avx2,fma")]
        fn with_256(points: Thinned, most_differences: usize, lagged: &mut [Lagged; 4]) {
            accumulate_plain(points, most_differences, lagged);
        }
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature is there.
            return unsafe { with_512(points, most_differences, lagged) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the features are there.
            return unsafe { with_256(points, most_differences, lagged) };
        }
    }
    accumulate_plain(points, most_differences, lagged);
}

/// The form that the compiler widens.
#[inline(always)]
#[allow(
    clippy::inline_always,
    reason = "a function keeps its caller's vectors only where it is inlined"
)]
fn accumulate_plain(points: Thinned, most_differences: usize, lagged: &mut [Lagged; 4]) {
    let n = points.len();
    if n < most_differences + 4 {
        return;
    }
    let quadratic = Quadratic::fit(points);
    let mut gathered = [0.0; BLOCK + 4];
    let mut sums = [Raw::default(); 4];
    // Blocks that stay in the first-level cache; three points of overlap serve the differences.
    let mut buffer = [[0.0; BLOCK + 4]; 4];
    let mut start = 0;
    while start < n {
        let end = (start + BLOCK).min(n);
        let ahead = (end + most_differences + 1).min(n);
        let wide = ahead - start;
        let block = points.block(start, wide, &mut gathered);
        quadratic.residual(block, start, &mut buffer[0][..wide]);
        for d in 1..=most_differences {
            let (before, after) = buffer.split_at_mut(d);
            let (from, to) = (&before[d - 1], &mut after[0]);
            for k in 0..wide.saturating_sub(d) {
                to[k] = from[k + 1] - from[k];
            }
        }
        for d in 0..=most_differences {
            let z = &buffer[d];
            let own = (end - start).min(n - d - start.min(n - d));
            let pairs = own.min((n - d).saturating_sub(start + 1));
            let raw = &mut sums[d];
            raw.sum += kernel::sum(&z[..own]);
            raw.squares += kernel::dot(&z[..own], &z[..own]);
            raw.products += kernel::dot(&z[..pairs], &z[1..=pairs]);
            if start == 0 {
                raw.first = z[0];
            }
            if own > 0 {
                raw.last = z[own - 1];
            }
        }
        start = end;
    }
    for d in 0..=most_differences {
        let count = (n - d) as f64;
        let raw = &sums[d];
        let mean = raw.sum / count;
        lagged[d].squares += raw.squares - mean * raw.sum;
        lagged[d].products += raw.products - mean * (2.0 * raw.sum - raw.first - raw.last)
            + (count - 1.0) * mean * mean;
    }
}

const BLOCK: usize = 256;

/// Sums of a series before its mean is taken out.
#[derive(Debug, Clone, Copy, Default)]
struct Raw {
    sum: f64,
    squares: f64,
    products: f64,
    first: f64,
    last: f64,
}

/// The least-squares parabola through equally spaced points, in t = −1…1.
struct Quadratic {
    level: f64,
    slope: f64,
    curvature: f64,
    mean_t2: f64,
    step_t: f64,
    /// k times the step, within a block.
    ramp: [f64; BLOCK + 4],
}

impl Quadratic {
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "see accumulate_plain")]
    fn fit(points: Thinned) -> Self {
        let n = points.len() as f64;
        let step_t = 2.0 / (n - 1.0);
        // Σt² and Σt⁴ over the symmetric grid, in closed form.
        let sum_t2 = n * (n + 1.0) / (3.0 * (n - 1.0));
        let sum_t4 = sum_t2 * (3.0 * n * n - 7.0) / (5.0 * (n - 1.0) * (n - 1.0));
        let mean_t2 = sum_t2 / n;
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        let ramp: [f64; BLOCK + 4] = std::array::from_fn(|k| f64::from(k as u32) * step_t);
        let mut times = [0.0; BLOCK];
        let mut squares = [0.0; BLOCK];
        let mut gathered = [0.0; BLOCK + 4];
        for start in (0..points.len()).step_by(BLOCK) {
            let start_t = start as f64 * step_t - 1.0;
            let chunk = points.block(start, BLOCK.min(points.len() - start), &mut gathered);
            for k in 0..chunk.len() {
                let t = start_t + ramp[k];
                times[k] = t;
                squares[k] = t * t - mean_t2;
            }
            sum += kernel::sum(chunk);
            first += kernel::dot(chunk, &times[..chunk.len()]);
            second += kernel::dot(chunk, &squares[..chunk.len()]);
        }
        Self {
            level: sum / n,
            slope: first / sum_t2,
            curvature: second / (sum_t4 - sum_t2 * mean_t2),
            mean_t2,
            step_t,
            ramp,
        }
    }

    #[inline(always)]
    #[allow(clippy::inline_always, reason = "see accumulate_plain")]
    /// Points less the parabola; `start` is the index of the first.
    fn residual(&self, points: &[f64], start: usize, out: &mut [f64]) {
        let start_t = start as f64 * self.step_t - 1.0;
        let level = self.level - self.curvature * self.mean_t2;
        for ((point, residual), ramp) in points.iter().zip(out).zip(&self.ramp) {
            let t = start_t + ramp;
            *residual = point - (level + t * (self.slope + t * self.curvature));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plain form of the same definition.
    fn plain(phase: &[f64], m: usize, most: usize) -> i8 {
        let points: Vec<f64> = phase.iter().step_by(m).copied().collect();
        let quadratic = Quadratic::fit(Thinned {
            phase: &points,
            m: 1,
        });
        let mut z = vec![0.0; points.len()];
        for (block, (points, z)) in points.chunks(BLOCK).zip(z.chunks_mut(BLOCK)).enumerate() {
            quadratic.residual(points, block * BLOCK, z);
        }
        let mut d = 0;
        loop {
            let mean = z.iter().sum::<f64>() / z.len() as f64;
            let centered: Vec<f64> = z.iter().map(|v| v - mean).collect();
            let squares: f64 = centered.iter().map(|v| v * v).sum();
            let products: f64 = centered.windows(2).map(|w| w[0] * w[1]).sum();
            let r = products / squares;
            let rho = r / (1.0 + r);
            if rho < 0.25 || d == most {
                return (2.0 - 2.0 * d as f64 - (2.0 * rho).round()).clamp(-4.0, 2.0) as i8;
            }
            z = z.windows(2).map(|w| w[1] - w[0]).collect();
            d += 1;
        }
    }

    fn noise(count: usize) -> Vec<f64> {
        let mut state = 12_345_u64;
        (0..count)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect()
    }

    fn cumulative(values: &[f64]) -> Vec<f64> {
        let mut total = 0.0;
        std::iter::once(0.0)
            .chain(values.iter().map(|v| {
                total += v;
                total
            }))
            .collect()
    }

    #[test]
    fn tells_white_phase_white_rate_and_random_walk_apart() {
        let white = noise(4000);
        let walk = cumulative(&white);
        let cases = [
            (white.clone(), 2),
            (walk.clone(), 0),
            (cumulative(&walk), -2),
        ];
        for (phase, alpha) in cases {
            for m in [1, 3, 10] {
                let found = noise_types(&[&phase], &[m], 2);
                assert_eq!(found[0].alpha, alpha, "m = {m}");
                assert!(found[0].measured);
            }
        }
        let steep = cumulative(&cumulative(&walk));
        assert_eq!(noise_types(&[&steep], &[1], 3)[0].alpha, -4);
        assert_eq!(noise_types(&[&steep], &[1], 2)[0].alpha, -2);
    }

    #[test]
    fn blocked_sums_equal_the_plain_definition() {
        for count in [40, 511, 512, 513, 514, 515, 1027, 3000] {
            let white = noise(count);
            let walk = cumulative(&white);
            for phase in [&white, &walk, &cumulative(&walk)] {
                for most in [2, 3] {
                    let found = noise_types(&[phase], &[1], most)[0].alpha;
                    let lowest = if most == 2 { -2 } else { -4 };
                    assert_eq!(found, plain(phase, 1, most).max(lowest), "{count} {most}");
                }
            }
        }
    }

    #[test]
    fn few_points_keep_the_last_known_type() {
        let phase = cumulative(&noise(100));
        let found = noise_types(&[&phase], &[1, 3, 4, 50], 2);
        assert_eq!(
            found.iter().map(|t| t.measured).collect::<Vec<_>>(),
            [true, true, false, false]
        );
        assert_eq!(found[3].alpha, found[1].alpha);
        let none = noise_types(&[&phase[..20]], &[1], 2)[0];
        assert_eq!((none.alpha, none.measured), (0, false));
    }

    #[test]
    fn few_points_change_the_type_only_where_they_contradict_it() {
        let wrong = |make: &dyn Fn(&[f64]) -> Vec<f64>, alpha: i8| {
            let white = noise(300 * 4096);
            let logs = white.chunks(4096).map(make);
            let wrong = logs.filter(|phase| noise_types(&[phase], &[128], 2)[0].alpha != alpha);
            wrong.count()
        };
        // 33 points; by their own autocorrelation a quarter of the white ones would be of another type.
        assert!(wrong(&cumulative, 0) <= 3);
        assert!(wrong(&|white| cumulative(&cumulative(white)), -2) <= 3);
        // A walk above white noise has an autocorrelation near 1, out of the reach of 33 points' chance.
        let white = Reading {
            points: 257,
            differences: 1,
            autocorrelation: [0.9, 0.02, 0.0, 0.0],
            alpha: 0,
        };
        let few = |r: f64, alpha: i8| Reading {
            points: 33,
            autocorrelation: [0.9, r, 0.0, 0.0],
            alpha,
            ..white
        };
        assert_eq!(few(-0.4, 2).alpha_beside(Some(&white)), 0);
        assert_eq!(few(0.5, -1).alpha_beside(Some(&white)), 0);
        assert_eq!(few(0.7, -2).alpha_beside(Some(&white)), -2);
        let many = Reading {
            points: 300,
            ..few(0.5, -1)
        };
        assert_eq!(many.alpha_beside(Some(&white)), -1);
    }

    #[test]
    fn a_constant_series_is_no_trouble() {
        let zero = [0.0; 200];
        assert_eq!(noise_types(&[&zero], &[1, 2], 2)[0].alpha, 2);
    }
}
