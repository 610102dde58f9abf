//! Rests of a hand-turned log: where the windowed variance of both sensors stays at its quiet level.
//!
//! s = max(V_a/q_a, V_g/q_g), V the variance over 0.3 s summed over the axes, q its quietest tenth; the threshold
//! lies above the lower of the two modes of ln s. Detector after `[TEDALDI2014]`.

use super::Recording;
use crate::interval::median;

/// Length of the window.
const WINDOW_S: f64 = 0.3;
/// Shortest rest, of samples used.
const SHORTEST_S: f64 = 0.5;
/// Cut at both ends.
const CUT_S: f64 = 0.15;
/// Block of the Allan variance that gives the noise.
const BLOCK_S: f64 = 0.25;

/// A still pose: the samples used, `first` to `end` (exclusive), and their means.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rest {
    pub(super) first: usize,
    pub(super) end: usize,
    pub(super) accel: [f64; 3],
    pub(super) gyro: Option<[f64; 3]>,
}

impl Rest {
    pub(super) fn samples(&self) -> f64 {
        (self.end - self.first) as f64
    }
}

/// What the detector found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) rests: Vec<Rest>,
    /// Steady stretches that turn: no rests.
    pub(super) turning: Vec<Rest>,
    /// Standard deviation of an accelerometer axis at the threshold \[m/s²\].
    pub(super) threshold_m_s2: f64,
    /// Quiet level: standard deviation of an accelerometer and a gyro axis.
    pub(super) quiet: [f64; 2],
    /// Samples before which the log has a gap.
    pub(super) gaps: Vec<usize>,
}

/// Variance over a window, summed over the axes; infinite where a value is not finite.
fn variance(axes: &[&[f64]; 3], from: usize, to: usize) -> f64 {
    let n = (to - from) as f64;
    let mut sum = 0.0;
    for axis in axes {
        let part = &axis[from..to];
        let origin = part[0];
        let (mut s1, mut s2) = (0.0, 0.0);
        for v in part {
            let d = v - origin;
            s1 += d;
            s2 += d * d;
        }
        sum += (s2 - s1 * s1 / n) / (n - 1.0);
    }
    if sum.is_finite() {
        sum.max(0.0)
    } else {
        f64::INFINITY
    }
}

/// The smallest step between neighbouring values, squared over 12 and summed: no variance lies below rounding.
fn rounding(axes: &[&[f64]; 3]) -> f64 {
    axes.iter()
        .map(|axis| {
            let step = axis
                .windows(2)
                .map(|w| (w[1] - w[0]).abs())
                .filter(|d| *d > 0.0)
                .fold(f64::INFINITY, f64::min);
            if step.is_finite() {
                step * step / 12.0
            } else {
                0.0
            }
        })
        .sum()
}

/// The quiet level of windowed variances: the middle of their quietest tenth.
fn quiet_level(variances: &[f64], floor: f64) -> f64 {
    let mut sorted: Vec<f64> = variances
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    sorted
        .get(sorted.len() / 20)
        .map_or(floor, |v| v.max(floor))
        .max(f64::MIN_POSITIVE)
}

/// Bins of the histogram of ln s.
const BINS: usize = 256;

/// The threshold on ln s: Otsu's split between its two modes; none where there is one mode alone.
///
/// The split maximises the variance between the classes and so lies midway between their means. A hand that touches
/// the sensor makes windows between the modes: their mean is still a mean of a rest, and its scatter is weighed.
fn threshold(logs: &[f64]) -> Option<f64> {
    let finite: Vec<f64> = logs.iter().copied().filter(|v| v.is_finite()).collect();
    let low = finite.iter().copied().fold(f64::INFINITY, f64::min);
    let high = finite.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if finite.len() < 2 || high - low < 0.7 {
        return None;
    }
    let width = (high - low) / BINS as f64;
    let mut counts = [0.0; BINS];
    for v in &finite {
        counts[(((v - low) / width) as usize).min(BINS - 1)] += 1.0;
    }
    let n = finite.len() as f64;
    let total: f64 = counts.iter().enumerate().map(|(i, c)| i as f64 * c).sum();
    let (mut below, mut sum, mut best, mut split) = (0.0, 0.0, -1.0, 0);
    for (i, count) in counts.iter().enumerate() {
        below += count;
        sum += i as f64 * count;
        if below == 0.0 || below >= n {
            continue;
        }
        let d = sum / below - (total - sum) / (n - below);
        let between = below * (n - below) * d * d;
        if between > best {
            (best, split) = (between, i);
        }
    }
    let at = low + (split + 1) as f64 * width;
    let (still, moving): (Vec<f64>, Vec<f64>) = finite.iter().partition(|v| **v < at);
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let (lower, upper) = (mean(&still), mean(&moving));
    if upper - lower < 1.0 {
        return None;
    }
    Some(f64::midpoint(lower, upper).min(median(still)? + MOST_ABOVE_STILL))
}

/// Most of ln s above the still mode: 14 times its standard deviation, however violent the turns.
const MOST_ABOVE_STILL: f64 = 5.3;

/// Leaves out scraps, rests shorter than a quarter of the usual one, where a dozen others are there.
fn without_scraps(rests: Vec<Rest>) -> Vec<Rest> {
    let usual = median(rests.iter().map(Rest::samples).collect()).unwrap_or(0.0);
    let kept: Vec<Rest> = rests
        .iter()
        .filter(|r| r.samples() >= usual / 4.0)
        .cloned()
        .collect();
    if kept.len() >= 12 { kept } else { rests }
}

/// Finds the rests.
pub(super) fn find(recording: &Recording) -> Found {
    let n = recording.samples();
    let dt = recording.dt_s;
    let window = ((WINDOW_S / dt).round() as usize).max(4);
    let stride = (window / 10).max(1);
    let sensors: Vec<[&[f64]; 3]> = std::iter::once(recording.accel)
        .chain(recording.gyro)
        .collect();
    let mut found = Found {
        rests: Vec::new(),
        turning: Vec::new(),
        threshold_m_s2: 0.0,
        quiet: [0.0; 2],
        gaps: recording.gaps(),
    };
    if n < window {
        return found;
    }
    let starts: Vec<usize> = (0..=n - window).step_by(stride).collect();
    let mut logs = vec![f64::NEG_INFINITY; starts.len()];
    for (i, axes) in sensors.iter().enumerate() {
        let variances: Vec<f64> = starts
            .iter()
            .map(|s| variance(axes, *s, s + window))
            .collect();
        let level = quiet_level(&variances, rounding(axes));
        found.quiet[i] = (level / 3.0).sqrt();
        for (log, v) in logs.iter_mut().zip(&variances) {
            *log = log.max((v.max(level * 1e-3) / level).ln());
        }
    }
    let limit = threshold(&logs).unwrap_or(f64::MAX);
    found.threshold_m_s2 = if limit == f64::MAX {
        found.quiet[0] * 2f64.sqrt()
    } else {
        found.quiet[0] * (limit / 2.0).exp()
    };
    // A quiet window makes all its samples still.
    let mut still = vec![false; n];
    let mut marked = 0;
    for (s, log) in starts.iter().zip(&logs) {
        if *log <= limit {
            still[(*s).max(marked)..s + window].fill(true);
            marked = s + window;
        }
    }
    let shortest = (SHORTEST_S / dt).round() as usize;
    let cut = (CUT_S / dt).ceil() as usize;
    let mut breaks = found.gaps.iter().copied().peekable();
    let mut k = 0;
    while k < n {
        if !still[k] {
            k += 1;
            continue;
        }
        let first = k;
        while breaks.next_if(|b| *b <= first).is_some() {}
        let stop = breaks.peek().copied().unwrap_or(n);
        while k < n && still[k] && k < stop {
            k += 1;
        }
        if k - first >= shortest + 2 * cut {
            found.rests.push(rest(&sensors, first + cut, k - cut));
        }
    }
    let (rests, turning) = part(recording, std::mem::take(&mut found.rests), found.quiet[0]);
    found.rests = without_scraps(rests);
    found.turning = turning;
    found
}

/// Slowest turn of the direction of gravity in the sensor that is no rest \[rad/s\]: a hand that holds it still does not
/// reach it.
const TURNING_RAD_S: f64 = 0.03;
/// Difference of the gyro's mean from that of the other rests that no bias, no drift and no g-sensitivity makes.
const SPINNING_RAD_S: f64 = 0.06;

/// Parts steady stretches into rests and those in which the sensor turns all the while: where the direction of
/// gravity moves steadily, or the gyro reads far from what it reads in the others.
fn part(recording: &Recording, all: Vec<Rest>, quiet_m_s2: f64) -> (Vec<Rest>, Vec<Rest>) {
    let usual =
        [0, 1, 2].map(|k| median(all.iter().filter_map(|r| r.gyro.map(|g| g[k])).collect()));
    // A gyro in a wrong unit reads its turns larger too.
    let fast = recording.gyro.map_or(0.0, |gyro| {
        let mut sizes: Vec<f64> = (0..recording.samples())
            .step_by(7)
            .map(|k| {
                (0..3)
                    .map(|j| gyro[j][k] - usual[j].unwrap_or(0.0))
                    .map(|v| v * v)
                    .sum()
            })
            .filter(|v: &f64| v.is_finite())
            .collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() * 9 / 10).map_or(0.0, |v| v.sqrt())
    });
    let most = SPINNING_RAD_S.max(0.05 * fast);
    all.into_iter().partition(|rest| {
        let spins = rest
            .gyro
            .is_some_and(|g| (0..3).any(|k| usual[k].is_some_and(|u| (g[k] - u).abs() > most)));
        !spins && turn_rate(recording, rest, quiet_m_s2) < TURNING_RAD_S
    })
}

/// Length of the parts of a stretch whose directions are compared.
const PART_S: f64 = 1.0;

/// Rate at which the direction of the specific force moves all through a stretch: the median from part to part, 0
/// where noise explains it.
fn turn_rate(recording: &Recording, rest: &Rest, quiet_m_s2: f64) -> f64 {
    let part = ((PART_S / recording.dt_s).round() as usize).min((rest.end - rest.first) / 3);
    if part == 0 {
        return 0.0;
    }
    let mean = |from: usize| {
        recording
            .accel
            .map(|axis| axis[from..from + part].iter().sum::<f64>() / part as f64)
    };
    let means: Vec<[f64; 3]> = (rest.first..=rest.end - part)
        .step_by(part)
        .map(mean)
        .collect();
    let dot = |u: &[f64; 3], v: &[f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let rate = |pair: &[[f64; 3]]| {
        let (a, b) = (&pair[0], &pair[1]);
        let size = dot(a, a).sqrt().max(1e-9);
        let along = dot(a, b) / size;
        let across = (dot(b, b) - along * along).max(0.0).sqrt();
        let angle = across.atan2(along);
        let noise = quiet_m_s2 * (2.0 / part as f64).sqrt() / size;
        if angle > 6.0 * noise {
            angle / (part as f64 * recording.dt_s)
        } else {
            0.0
        }
    };
    median(means.windows(2).map(rate).collect()).unwrap_or(0.0)
}

fn rest(sensors: &[[&[f64]; 3]], first: usize, end: usize) -> Rest {
    let mean = |axes: &[&[f64]; 3]| {
        axes.map(|axis| {
            let part = &axis[first..end];
            let origin = part[0];
            origin + part.iter().map(|v| v - origin).sum::<f64>() / part.len() as f64
        })
    };
    Rest {
        first,
        end,
        accel: mean(&sensors[0]),
        gyro: sensors.get(1).map(mean),
    }
}

/// Standard deviation of a sample of each axis: Allan variance of 0.25 s block means at lag one, pooled over the rests.
pub(super) fn noise(axes: &[&[f64]; 3], rests: &[Rest], dt_s: f64) -> [f64; 3] {
    let block = ((BLOCK_S / dt_s).round() as usize).max(1);
    axes.map(|axis| {
        let (mut sum, mut pairs) = (0.0, 0.0);
        let (mut scatter, mut freedom) = (0.0, 0.0);
        for rest in rests {
            let part = &axis[rest.first..rest.end];
            let mut last: Option<f64> = None;
            for chunk in part.chunks_exact(block) {
                let mean = chunk.iter().sum::<f64>() / block as f64;
                if let Some(before) = last {
                    sum += (mean - before).powi(2) / 2.0;
                    pairs += 1.0;
                }
                last = Some(mean);
            }
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            scatter += part.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            freedom += part.len() as f64 - 1.0;
        }
        let plain = scatter / f64::max(freedom, 1.0);
        let step = axis
            .windows(2)
            .map(|w| (w[1] - w[0]).abs())
            .filter(|d| *d > 1e-12)
            .fold(f64::INFINITY, f64::min);
        let floor = if step.is_finite() {
            step * step / 12.0
        } else {
            0.0
        };
        let variance = if pairs >= 5.0 {
            sum / pairs * block as f64
        } else {
            plain
        };
        variance.max(floor).sqrt().max(1e-12)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_modes_have_a_threshold_between_them_and_one_mode_has_none() {
        let still = (0..1000).map(|i| 0.3 * f64::sin(f64::from(i)));
        let moving = (0..500).map(|i| 8.0 + f64::cos(f64::from(i)));
        let both: Vec<f64> = still.clone().chain(moving).collect();
        let at = threshold(&both).unwrap_or(f64::NAN);
        assert!(at > 0.3 && at < 7.0, "{at}");
        assert_eq!(threshold(&still.collect::<Vec<_>>()), None);
    }
}
