//! Dwells that nobody named: where the windowed variance of every channel stays at its quiet level.
//!
//! The quiet level of a channel is the tenth percentile of its variance over windows of 0.3 s; a constant rate is
//! quiet. A dwell lasts at least 1 s; 0.15 s are cut at both ends.

use std::collections::VecDeque;

use super::{CHANNELS, Columns, NOISY, Pool, Reduced, Reduction, block_s};

/// Length of a window \[s\].
const WINDOW_S: f64 = 0.3;
/// What is cut at both ends of a dwell \[s\].
const CUT_S: f64 = 0.15;
/// The shortest dwell \[s\].
const SHORTEST_S: f64 = 1.0;
/// How far the variance of a dwell's window may rise above the quiet level, beside the scatter of a variance.
const LOUD: f64 = 16.0;
/// Cells that are kept until the quiet level is told: about 40 min.
const KEPT: usize = 50_000;
/// Bins of the histogram of variances: twenty a decade from 1e-30.
const BINS: usize = 1000;

/// A few samples.
#[derive(Clone, Copy, Debug)]
struct Cell {
    start_s: f64,
    end_s: f64,
    samples: f64,
    mean: [f64; CHANNELS],
    m2: [f64; NOISY],
    /// Whether time jumped before it.
    after_gap: bool,
}

/// A dwell that has not ended.
#[derive(Clone, Debug)]
struct Open {
    cells: VecDeque<Cell>,
    start_s: f64,
    /// Number of the last cell that a quiet window covers.
    covered: u64,
    /// Cells that are summed and gone.
    samples: f64,
    sum: [f64; CHANNELS],
    loudness: [f64; NOISY],
    windows: f64,
    last: Option<[f64; CHANNELS]>,
    long: bool,
}

/// Finds dwells in a log, block by block of the log.
#[derive(Clone, Debug)]
pub struct Dwells {
    dt_s: f64,
    per_cell: usize,
    per_window: usize,
    cut: usize,
    has: [bool; CHANNELS],
    filling: Option<(Cell, [f64; NOISY])>,
    cells: Vec<Cell>,
    /// Number of the first of `cells`.
    first: u64,
    /// How many of `cells` were looked at already.
    seen: usize,
    histogram: Vec<[u32; NOISY]>,
    step: [f64; NOISY],
    last_value: Option<[f64; NOISY]>,
    last_s: f64,
    open: Option<Open>,
    found: Vec<(Reduced, [f64; NOISY])>,
    pool: Pool,
    extent_s: Option<[f64; 2]>,
}

impl Dwells {
    /// For a log of sampling interval `dt_s`.
    pub fn new(dt_s: f64) -> Self {
        let per_cell = ((0.05 / dt_s).round() as usize).max(1);
        let cell_s = per_cell as f64 * dt_s;
        let cells = |length_s: f64| (length_s / cell_s - 1e-6).ceil().max(1.0) as usize;
        Self {
            dt_s,
            per_cell,
            per_window: cells(WINDOW_S).max(6_usize.div_ceil(per_cell)),
            cut: cells(CUT_S),
            has: [false; CHANNELS],
            filling: None,
            cells: Vec::new(),
            first: 0,
            seen: 0,
            histogram: vec![[0; NOISY]; BINS],
            step: [f64::INFINITY; NOISY],
            last_value: None,
            last_s: f64::NEG_INFINITY,
            open: None,
            found: Vec::new(),
            pool: Pool::default(),
            extent_s: None,
        }
    }

    /// Takes further rows; `times` rise, columns are as long as they.
    pub fn push(&mut self, times: &[f64], columns: &Columns) {
        for (has, column) in self.has.iter_mut().zip(columns) {
            *has |= column.is_some();
        }
        for (i, t) in times.iter().enumerate() {
            let mut values = [0.0; CHANNELS];
            for (value, column) in values.iter_mut().zip(columns) {
                if let Some(column) = column {
                    *value = column.get(i).copied().unwrap_or(f64::NAN);
                }
            }
            self.sample(*t, &values);
            if self.cells.len() >= KEPT {
                self.look();
            }
        }
    }

    fn sample(&mut self, t: f64, values: &[f64; CHANNELS]) {
        self.extent_s = Some([self.extent_s.map_or(t, |e| e[0]), t]);
        if let Some(last) = &self.last_value {
            for (k, step) in self.step.iter_mut().enumerate() {
                let change = (values[k] - last[k]).abs();
                if change > 0.0 && change < *step {
                    *step = change;
                }
            }
        }
        self.last_value = Some(std::array::from_fn(|k| values[k]));
        let gap = self.last_s.is_finite() && t - self.last_s > WINDOW_S.max(3.0 * self.dt_s);
        self.last_s = t;
        if gap && let Some((cell, _)) = self.filling.take() {
            self.cells.push(cell);
        }
        let (cell, origin) = self.filling.get_or_insert_with(|| {
            let origin = std::array::from_fn(|k| values[k]);
            let cell = Cell {
                start_s: t - self.dt_s,
                end_s: t,
                samples: 0.0,
                mean: [0.0; CHANNELS],
                m2: [0.0; NOISY],
                after_gap: gap,
            };
            (cell, origin)
        });
        cell.samples += 1.0;
        cell.end_s = t;
        for (sum, value) in cell.mean.iter_mut().zip(values) {
            *sum += value;
        }
        for k in 0..NOISY {
            cell.m2[k] += (values[k] - origin[k]).powi(2);
        }
        if cell.samples >= self.per_cell as f64
            && let Some((mut cell, origin)) = self.filling.take()
        {
            for mean in &mut cell.mean {
                *mean /= cell.samples;
            }
            for k in 0..NOISY {
                let shift = cell.mean[k] - origin[k];
                cell.m2[k] = (cell.m2[k] - cell.samples * shift * shift).max(0.0);
            }
            self.cells.push(cell);
        }
    }

    /// Variance of each channel over the window that ends with cell `last` of those kept.
    fn variance(&self, last: usize) -> Option<[f64; NOISY]> {
        let window = self
            .cells
            .get((last + 1).checked_sub(self.per_window)?..=last)?;
        if window.iter().skip(1).any(|cell| cell.after_gap) {
            return None;
        }
        let n: f64 = window.iter().map(|cell| cell.samples).sum();
        Some(std::array::from_fn(|k| {
            let origin = window[0].mean[k];
            let (mut sum, mut square, mut within) = (0.0, 0.0, 0.0);
            for cell in window {
                let shift = cell.mean[k] - origin;
                sum += cell.samples * shift;
                square += cell.samples * shift * shift;
                within += cell.m2[k];
            }
            ((within + square - sum * sum / n) / (n - 1.0).max(1.0)).max(0.0)
        }))
    }

    fn limits(&self) -> [f64; NOISY] {
        // The tenth percentile of a variance of few samples lies below their mean.
        let freedom = (self.per_window * self.per_cell) as f64 - 1.0;
        let low = (1.0 - 2.0 / (9.0 * freedom) - 1.2816 * (2.0 / (9.0 * freedom)).sqrt()).powi(3);
        std::array::from_fn(|k| {
            if !self.has[k] {
                return f64::INFINITY;
            }
            let total: u64 = self.histogram.iter().map(|bin| u64::from(bin[k])).sum();
            let mut below = 0;
            let bin = self
                .histogram
                .iter()
                .position(|bin| {
                    below += u64::from(bin[k]);
                    below * 10 >= total
                })
                .unwrap_or(0);
            let quiet = 10f64.powf((bin as f64 + 0.5) / 20.0 - 30.0) / low.max(0.1);
            let step = if self.step[k].is_finite() {
                self.step[k]
            } else {
                0.0
            };
            // A variance of a rounded constant is up to a quarter of the step squared.
            LOUD * quiet.max(step * step / 12.0)
        })
    }

    /// Sorts the cells kept into dwells, and keeps those that a window still needs.
    fn look(&mut self) {
        let variances: Vec<Option<[f64; NOISY]>> =
            (0..self.cells.len()).map(|i| self.variance(i)).collect();
        for variance in variances.iter().skip(self.seen).flatten() {
            for (k, v) in variance.iter().enumerate() {
                let bin = ((v.max(1e-30).log10() + 30.0) * 20.0).clamp(0.0, (BINS - 1) as f64);
                self.histogram[bin as usize][k] += 1;
            }
        }
        let limits = self.limits();
        for i in self.seen..self.cells.len() {
            let quiet = variances[i].filter(|v| v.iter().zip(limits).all(|(v, limit)| *v <= limit));
            let number = self.first + i as u64;
            if let Some(open) = &mut self.open {
                open.cells.push_back(self.cells[i]);
                if let Some(v) = quiet {
                    // Windows that overlap those before are one dwell.
                    if number < open.covered + self.per_window as u64 + 1 {
                        open.covered = number;
                        open.louder(&v);
                        open.drain(number, self.cut, &mut self.pool);
                        continue;
                    }
                } else if number < open.covered + self.per_window as u64 {
                    continue;
                }
                self.end(number);
            }
            if let Some(v) = quiet {
                let from = (i + 1).saturating_sub(self.per_window);
                let mut open = Open {
                    cells: self.cells[from..=i].iter().copied().collect(),
                    start_s: self.cells[from].start_s,
                    covered: number,
                    samples: 0.0,
                    sum: [0.0; CHANNELS],
                    loudness: [0.0; NOISY],
                    windows: 0.0,
                    last: None,
                    long: false,
                };
                open.louder(&v);
                self.open = Some(open);
            }
        }
        let kept = (self.per_window - 1).min(self.cells.len());
        let gone = self.cells.len() - kept;
        self.cells.drain(..gone);
        self.first += gone as u64;
        self.seen = kept;
    }

    /// Ends the open dwell; `number` is that of its last cell in memory.
    fn end(&mut self, number: u64) {
        let Some(mut open) = self.open.take() else {
            return;
        };
        let beyond = usize::try_from(number.saturating_sub(open.covered)).unwrap_or(0);
        open.cells.truncate(open.cells.len().saturating_sub(beyond));
        let end_s = open.cells.back().map_or(open.start_s, |cell| cell.end_s);
        if end_s - open.start_s < SHORTEST_S - 0.5 * self.dt_s {
            return;
        }
        open.cells
            .truncate(open.cells.len().saturating_sub(self.cut));
        if !open.long {
            open.cells.drain(..self.cut.min(open.cells.len()));
            open.start_s = open.cells.front().map_or(open.start_s, |cell| cell.start_s);
        }
        let end_s = open.cells.back().map_or(open.start_s, |cell| cell.end_s);
        open.blocks(end_s - open.start_s, true, &mut self.pool);
        let loudness = open.loudness.map(|sum| sum / open.windows.max(1.0));
        let mean = std::array::from_fn(|c| {
            (self.has[c] && open.samples > 0.0).then(|| open.sum[c] / open.samples)
        });
        let row = Reduced {
            start_s: open.start_s,
            end_s,
            samples: open.samples as u64,
            mean,
        };
        self.found.push((row, loudness));
    }

    /// The dwells, and the noise.
    pub fn finish(mut self) -> Reduction {
        self.look();
        let number = self.first + self.cells.len() as u64;
        // The last cell that was pushed has the number before.
        self.end(number.saturating_sub(1));
        // Dwells told by the level of an early, louder part of the log.
        let limits = self.limits();
        self.found
            .retain(|(_, loudness)| loudness.iter().zip(limits).all(|(v, limit)| *v <= limit));
        Reduction {
            density2: self.pool.density2(self.has),
            rows: self.found.into_iter().map(|(row, _)| row).collect(),
            extent_s: self.extent_s,
        }
    }
}

impl Open {
    fn louder(&mut self, variance: &[f64; NOISY]) {
        for (sum, v) in self.loudness.iter_mut().zip(variance) {
            *sum += v;
        }
        self.windows += 1.0;
    }

    /// Sums what is safely inside a long dwell, so that memory stays small.
    fn drain(&mut self, number: u64, cut: usize, pool: &mut Pool) {
        let length_s = self.cells.back().map_or(0.0, |cell| cell.end_s) - self.start_s;
        if !self.long {
            if length_s < 8.0 {
                return;
            }
            self.long = true;
            self.cells.drain(..cut.min(self.cells.len()));
            self.start_s = self.cells.front().map_or(self.start_s, |cell| cell.start_s);
        }
        let beyond = usize::try_from(number - self.covered).unwrap_or(0);
        let tail_from = self.cells.len().saturating_sub(cut + beyond);
        let ahead = self
            .cells
            .get(tail_from.saturating_sub(1))
            .map_or(0.0, |c| c.end_s)
            - self.cells.front().map_or(0.0, |c| c.start_s);
        if ahead > 2.0 {
            let tail = self.cells.split_off(tail_from);
            self.blocks(f64::INFINITY, false, pool);
            self.cells.extend(tail);
        }
    }

    /// Turns cells into blocks; what is no whole block stays, or goes into the sums at the end.
    fn blocks(&mut self, length_s: f64, all: bool, pool: &mut Pool) {
        let block_s = if self.long { 1.0 } else { block_s(length_s) };
        let Some(cell_s) = self.cells.front().map(|c| c.end_s - c.start_s) else {
            return;
        };
        let each = ((block_s / cell_s + 1e-6).floor() as usize).max(1);
        while self.cells.len() >= each || (all && !self.cells.is_empty()) {
            let whole = self.cells.len() >= each;
            let (mut n, mut sum) = (0.0, [0.0; CHANNELS]);
            let (mut start_s, mut end_s) = (f64::INFINITY, 0.0);
            for cell in self.cells.drain(..each.min(self.cells.len())) {
                n += cell.samples;
                for (sum, mean) in sum.iter_mut().zip(cell.mean) {
                    *sum += cell.samples * mean;
                }
                start_s = start_s.min(cell.start_s);
                end_s = cell.end_s;
            }
            self.samples += n;
            for (all, part) in self.sum.iter_mut().zip(sum) {
                *all += part;
            }
            if whole {
                let mean = sum.map(|sum| sum / n);
                if let Some(before) = &self.last {
                    pool.add(before, &mean, end_s - start_s);
                }
                self.last = Some(mean);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(state: &mut u64) -> f64 {
        // A sum of four uniform numbers.
        (0..4)
            .map(|_| {
                *state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .sum::<f64>()
            * 1.7
    }

    /// Six dwells of 12 s at several rates, parted by ramps of 1 s, and after a loud start.
    #[test]
    fn finds_what_was_made() {
        let (dt, mut state) = (0.01, 42);
        let mut dwells = Dwells::new(dt);
        let (mut times, mut w, mut f) = (Vec::new(), Vec::new(), Vec::new());
        let mut t = 0.0;
        for _ in 0..500 {
            t += dt;
            times.push(t);
            w.push(noise(&mut state));
            f.push(9.8 + noise(&mut state));
        }
        for station in 0..6 {
            for k in 0..1300 {
                t += dt;
                times.push(t);
                let ramp = if k < 100 { f64::from(k) / 100.0 } else { 1.0 };
                w.push(f64::from(station) + ramp + 1e-3 * noise(&mut state));
                f.push(9.8 + 1e-2 * noise(&mut state));
            }
        }
        for (i, t) in times.iter().enumerate() {
            let mut columns: Columns = [None; CHANNELS];
            columns[2] = Some(&w[i..=i]);
            columns[5] = Some(&f[i..=i]);
            dwells.push(&[*t], &columns);
        }
        let found = dwells.finish();
        assert_eq!(found.rows.len(), 6);
        for (station, row) in found.rows.iter().enumerate() {
            let start = 5.0 + 13.0 * station as f64 + 1.0;
            assert!(
                row.start_s > start - 0.06 && row.start_s < start + 0.4,
                "{row:?}"
            );
            assert!(
                row.end_s < start + 12.0 && row.end_s > start + 11.6,
                "{row:?}"
            );
            let mean = row.mean[2].unwrap_or(f64::NAN);
            assert!((mean - station as f64 - 1.0).abs() < 3e-4, "{mean}");
        }
        let density = found.density2[2].unwrap_or(f64::NAN).sqrt();
        // σ √dt = 1e-3 · 0.98 · 0.1, known to 1/√(2 · 60).
        assert!((density / 9.8e-5 - 1.0).abs() < 0.3, "{density}");
    }
}
