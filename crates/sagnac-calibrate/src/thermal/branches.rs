//! Heating and cooling branches of a temperature sweep, its soaks, and bins of each branch.
//!
//! A turning point is a reversal by more than 5 % of the range, at least 1 K; bins are max(1 K, range/60) wide.

use super::Sweep;

/// A stretch between two turning points: samples `first..end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Branch {
    pub(super) first: usize,
    pub(super) end: usize,
    /// +1 heating, −1 cooling.
    pub(super) sign: f64,
}

/// Mean temperature and outputs of one bin of one branch.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bin {
    pub(super) log: usize,
    pub(super) branch: usize,
    pub(super) sign: f64,
    pub(super) temperature_c: f64,
    /// Mean time since the start of the log \[s\].
    pub(super) elapsed_s: f64,
    /// Of each axis that the logs have.
    pub(super) outputs: Vec<f64>,
    pub(super) count: f64,
}

/// Extremes of finite temperatures.
pub(super) fn range(temperatures: &[f64]) -> [f64; 2] {
    temperatures
        .iter()
        .filter(|t| t.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| {
            [a.min(*t), b.max(*t)]
        })
}

/// The branches of a log.
pub(super) fn branches(temperatures: &[f64], range_k: f64) -> Vec<Branch> {
    let reversal = (0.05 * range_k).max(1.0);
    let mut turning: Vec<usize> = vec![0];
    let (mut low, mut high) = (0, 0);
    let mut sign = 0.0;
    let mut signs: Vec<f64> = Vec::new();
    for (k, t) in temperatures.iter().enumerate() {
        if !t.is_finite() {
            continue;
        }
        if !temperatures[low].is_finite() || *t < temperatures[low] {
            low = k;
        }
        if !temperatures[high].is_finite() || *t > temperatures[high] {
            high = k;
        }
        if sign >= 0.0 && temperatures[high] - t > reversal {
            if sign > 0.0 || (high > 0 && temperatures[high] - temperatures[0] > reversal) {
                if sign == 0.0 {
                    signs.push(1.0);
                }
                turning.push(high);
                signs.push(-1.0);
            } else if sign == 0.0 {
                signs.push(-1.0);
            }
            sign = -1.0;
            low = k;
        } else if sign <= 0.0 && t - temperatures[low] > reversal {
            if sign < 0.0 || (low > 0 && temperatures[0] - temperatures[low] > reversal) {
                if sign == 0.0 {
                    signs.push(-1.0);
                }
                turning.push(low);
                signs.push(1.0);
            } else if sign == 0.0 {
                signs.push(1.0);
            }
            sign = 1.0;
            high = k;
        }
    }
    turning.push(temperatures.len());
    signs
        .into_iter()
        .zip(turning.windows(2))
        .map(|(sign, pair)| Branch {
            first: pair[0],
            end: pair[1],
            sign,
        })
        .collect()
}

/// Stretches of at least 5 min in which the temperature stays within 0.2 K.
pub(super) fn soaks(temperatures: &[f64], dt_s: f64) -> Vec<(usize, usize)> {
    let shortest = (300.0 / dt_s).round().max(2.0) as usize;
    let mut out = Vec::new();
    let mut first = 0;
    while first + shortest <= temperatures.len() {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut end = first;
        while end < temperatures.len() {
            let (a, b) = (low.min(temperatures[end]), high.max(temperatures[end]));
            if b - a > 0.2 || !temperatures[end].is_finite() {
                break;
            }
            (low, high) = (a, b);
            end += 1;
        }
        if end - first >= shortest {
            out.push((first, end));
            first = end;
        } else {
            // Nothing that begins before the sample that broke the stretch can be long enough but by a later start.
            first += ((end - first) / 4).max(1);
        }
    }
    joined(temperatures, &out)
}

/// Soaks that a short excursion parts are one: where all but a fiftieth of both lies within 0.2 K.
fn joined(temperatures: &[f64], soaks: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let is_one = |first: usize, end: usize| {
        let mut part: Vec<f64> = temperatures[first..end]
            .iter()
            .copied()
            .filter(|t| t.is_finite())
            .collect();
        part.sort_by(f64::total_cmp);
        let spare = part.len() / 100;
        part.len() > 2 * spare && part[part.len() - 1 - spare] - part[spare] <= 0.2
    };
    let mut out: Vec<(usize, usize)> = Vec::new();
    for &(first, end) in soaks {
        match out.last_mut() {
            Some(last) if is_one(last.0, end) => last.1 = end,
            _ => out.push((first, end)),
        }
    }
    out
}

/// Bins of the branches of a log; of soaks alone where these are given.
pub(super) fn bins(
    log: usize,
    sweep: &Sweep,
    branches: &[Branch],
    low_c: f64,
    range_k: f64,
    soaks: Option<&[(usize, usize)]>,
    out: &mut Vec<Bin>,
) {
    let width = (range_k / 60.0).max(1.0);
    let channels: Vec<&[f64]> = sweep.channels();
    for (number, branch) in branches.iter().enumerate() {
        if let Some(soaks) = soaks {
            for (first, end) in soaks {
                let half = usize::midpoint(*first, *end);
                if half >= branch.first && half < branch.end {
                    let mut sums = Sums::new(channels.len());
                    (half..*end).for_each(|k| sums.add(sweep, &channels, k));
                    out.extend(sums.bin(log, number, branch.sign));
                }
            }
            continue;
        }
        let count = (range_k / width) as usize + 1;
        let mut all: Vec<Sums> = (0..count).map(|_| Sums::new(channels.len())).collect();
        for k in branch.first..branch.end {
            let t = sweep.temperature_c[k];
            if t.is_finite() {
                let place = (((t - low_c) / width) as usize).min(count - 1);
                all[place].add(sweep, &channels, k);
            }
        }
        out.extend(all.iter().filter_map(|s| s.bin(log, number, branch.sign)));
    }
}

struct Sums {
    temperature: f64,
    elapsed_s: f64,
    outputs: Vec<f64>,
    count: f64,
}

impl Sums {
    fn new(channels: usize) -> Self {
        Self {
            temperature: 0.0,
            elapsed_s: 0.0,
            outputs: vec![0.0; channels],
            count: 0.0,
        }
    }

    fn add(&mut self, sweep: &Sweep, channels: &[&[f64]], k: usize) {
        if channels.iter().all(|c| c[k].is_finite()) {
            self.temperature += sweep.temperature_c[k];
            self.elapsed_s += sweep.time_s(k) - sweep.start_s(0);
            for (sum, c) in self.outputs.iter_mut().zip(channels) {
                *sum += c[k];
            }
            self.count += 1.0;
        }
    }

    fn bin(&self, log: usize, branch: usize, sign: f64) -> Option<Bin> {
        (self.count > 0.0).then(|| Bin {
            log,
            branch,
            sign,
            temperature_c: self.temperature / self.count,
            elapsed_s: self.elapsed_s / self.count,
            outputs: self.outputs.iter().map(|v| v / self.count).collect(),
            count: self.count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_down_up_and_half_down_has_three_branches() {
        let down = (0..100).map(|k| 50.0 - 0.7 * f64::from(k));
        let up = (0..100).map(|k| -20.0 + 0.9 * f64::from(k));
        let back = (0..50).map(|k| 70.0 - 0.7 * f64::from(k));
        let t: Vec<f64> = down.chain(up).chain(back).collect();
        let found = branches(&t, 90.0);
        let signs: Vec<f64> = found.iter().map(|b| b.sign).collect();
        assert_eq!(signs, [-1.0, 1.0, -1.0]);
        assert_eq!(found[1].first, 100);
        assert_eq!(found[2].first, 200);
        assert_eq!(found[2].end, 250);
    }

    #[test]
    fn a_small_wave_is_no_turning_point() {
        let t: Vec<f64> = (0..500)
            .map(|k| f64::from(k) * 0.1 + 0.8 * f64::from(k).sin())
            .collect();
        assert_eq!(branches(&t, 50.0).len(), 1);
    }

    #[test]
    fn a_plateau_is_a_soak() {
        let mut t = vec![20.0; 400];
        t.extend((0..100).map(|k| 20.0 + f64::from(k) * 0.3));
        t.extend(vec![50.0; 320]);
        let found = soaks(&t, 1.0);
        assert_eq!(found.len(), 2, "{found:?}");
    }

    #[test]
    fn an_excursion_of_a_moment_parts_no_soak() {
        let mut t: Vec<f64> = (0..800).map(|k| 20.0 + 0.01 * f64::from(k % 7)).collect();
        t[400..404].fill(20.3);
        assert_eq!(soaks(&t, 1.0), [(0, 800)]);
        // A slow creep stays as many soaks as its steps of 0.2 K.
        let creep: Vec<f64> = (0..2000).map(|k| 20.0 + 5e-4 * f64::from(k)).collect();
        assert!(soaks(&creep, 1.0).len() > 3);
    }
}
