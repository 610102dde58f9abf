//! Spans that a schedule names: sums over each, and the noise from blocks within the dwells.

use super::{CHANNELS, Columns, Pool, Reduced, Reduction, Span, block_s};

/// Sums of one span.
#[derive(Clone, Debug)]
struct State {
    span: Span,
    samples: u64,
    sum: [f64; CHANNELS],
    block_s: f64,
    /// The block that is being filled: its number, sums and samples.
    number: u64,
    block_sum: [f64; CHANNELS],
    block_samples: u64,
    /// Number and mean of the block before it.
    last: Option<(u64, [f64; CHANNELS])>,
}

/// Reduces a log to the spans of a schedule, block by block of the log.
#[derive(Clone, Debug)]
pub struct Spans {
    states: Vec<State>,
    pool: Pool,
    has: [bool; CHANNELS],
    extent_s: Option<[f64; 2]>,
}

impl Spans {
    /// Spans in the order of the schedule; they may overlap.
    pub fn new(spans: &[Span]) -> Self {
        Self {
            states: spans
                .iter()
                .map(|span| State {
                    span: *span,
                    samples: 0,
                    sum: [0.0; CHANNELS],
                    block_s: block_s(span.end_s - span.start_s),
                    number: 0,
                    block_sum: [0.0; CHANNELS],
                    block_samples: 0,
                    last: None,
                })
                .collect(),
            pool: Pool::default(),
            has: [false; CHANNELS],
            extent_s: None,
        }
    }

    /// Takes further rows; `times` rise, columns are as long as they.
    pub fn push(&mut self, times: &[f64], columns: &Columns) {
        let (Some(first), Some(last)) = (times.first(), times.last()) else {
            return;
        };
        for (has, column) in self.has.iter_mut().zip(columns) {
            *has |= column.is_some();
        }
        self.extent_s = Some([self.extent_s.map_or(*first, |e| e[0]), *last]);
        for state in &mut self.states {
            if state.span.start_s < *last && state.span.end_s >= *first {
                state.push(times, columns, &mut self.pool);
            }
        }
    }

    /// The means, and the noise.
    pub fn finish(mut self) -> Reduction {
        let mut rows = Vec::with_capacity(self.states.len());
        for state in &mut self.states {
            // The last block ends where the span does, but for rounding.
            let length_s = state.span.end_s - state.span.start_s;
            if (state.number + 1) as f64 * state.block_s <= length_s * (1.0 + 1e-9) {
                state.close(&mut self.pool);
            }
            rows.push(Reduced {
                start_s: state.span.start_s,
                end_s: state.span.end_s,
                samples: state.samples,
                mean: std::array::from_fn(|c| {
                    (self.has[c] && state.samples > 0).then(|| state.sum[c] / state.samples as f64)
                }),
            });
        }
        Reduction {
            rows,
            density2: self.pool.density2(self.has),
            extent_s: self.extent_s,
        }
    }
}

impl State {
    fn push(&mut self, times: &[f64], columns: &Columns, pool: &mut Pool) {
        let mut from = times.partition_point(|t| *t <= self.span.start_s);
        let to = times.partition_point(|t| *t <= self.span.end_s);
        while from < to {
            let upto = if self.span.is_turn {
                to
            } else {
                // Blocks are open at their start and closed at their end, as the span is.
                let number = (((times[from] - self.span.start_s) / self.block_s - 1e-9).ceil()
                    - 1.0)
                    .max(0.0);
                let number = number as u64;
                if number != self.number {
                    self.close(pool);
                    self.number = number;
                }
                let end_s = self.span.start_s + ((number + 1) as f64 + 1e-9) * self.block_s;
                from + times[from..to].partition_point(|t| *t <= end_s).max(1)
            };
            for (c, column) in columns.iter().enumerate() {
                if let Some(values) = column.and_then(|values| values.get(from..upto)) {
                    let sum: f64 = values.iter().sum();
                    self.sum[c] += sum;
                    self.block_sum[c] += sum;
                }
            }
            self.samples += (upto - from) as u64;
            self.block_samples += (upto - from) as u64;
            from = upto;
        }
    }

    /// Ends a block; its mean is compared with that of the block before.
    fn close(&mut self, pool: &mut Pool) {
        if self.block_samples > 0 && !self.span.is_turn {
            let mean = self.block_sum.map(|sum| sum / self.block_samples as f64);
            if let Some((number, before)) = &self.last
                && number + 1 == self.number
            {
                pool.add(before, &mean, self.block_s);
            }
            self.last = Some((self.number, mean));
        }
        self.block_sum = [0.0; CHANNELS];
        self.block_samples = 0;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    /// Blocks of any size give the same sums; the noise of a known sequence is that of its block means.
    #[test]
    fn cut_anywhere() {
        let n = 4000_u32;
        let times: Vec<f64> = (1..=n).map(|k| f64::from(k) * 0.01).collect();
        let values: Vec<f64> = (0..n).map(|k| f64::from(k * 7919 % 1009)).collect();
        let spans = [
            Span {
                start_s: 2.0,
                end_s: 12.0,
                is_turn: false,
            },
            Span {
                start_s: 12.5,
                end_s: 14.5,
                is_turn: true,
            },
            Span {
                start_s: 20.0,
                end_s: 22.0,
                is_turn: false,
            },
        ];
        let run = |step: usize| {
            let mut out = Spans::new(&spans);
            for from in (0..times.len()).step_by(step) {
                let to = (from + step).min(times.len());
                let mut columns: Columns = [None; CHANNELS];
                columns[0] = Some(&values[from..to]);
                out.push(&times[from..to], &columns);
            }
            out.finish()
        };
        let whole = run(4000);
        let cut = run(37);
        assert_eq!(whole.rows[0].samples, 1000);
        assert_eq!(whole.rows[1].samples, 200);
        assert!((whole.density2[0].unwrap() / cut.density2[0].unwrap() - 1.0).abs() < 1e-9);
        // By hand: ten blocks of 1 s, five of 0.4 s.
        let mean =
            |from: usize, len: usize| values[from..from + len].iter().sum::<f64>() / len as f64;
        let mut sum = 0.0;
        for b in 0..9 {
            sum += 0.5 * (mean(300 + 100 * b, 100) - mean(200 + 100 * b, 100)).powi(2);
        }
        for b in 0..4 {
            sum += 0.5 * (mean(2040 + 40 * b, 40) - mean(2000 + 40 * b, 40)).powi(2) * 0.4;
        }
        // Sums in another order.
        assert!((whole.density2[0].unwrap() / (sum / 13.0) - 1.0).abs() < 1e-9);
        assert_eq!(whole.rows[0].mean[1], None);
    }
}
