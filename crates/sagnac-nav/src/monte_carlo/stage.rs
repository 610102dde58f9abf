//! The output stage of a triad on blocks of samples: y = round(saturate(u)), [`OutputStage`](sagnac_core::OutputStage)
//! without its low-pass, which is a matter of time tags and is left out of both methods.

use sagnac_core::simd::{Kernel, dispatch};
use sagnac_core::{Output, Range, Resolution, Triad};

/// Saturation and rounding of three axes.
pub(super) struct Stage {
    range: Range<f64>,
    resolution: Resolution<f64>,
    residue: [f64; 3],
    dt_s: f64,
}

impl Stage {
    pub(super) fn new(triad: &Triad<f64>, dt_s: f64) -> Self {
        Self {
            range: triad.range,
            resolution: triad.resolution,
            residue: [0.0; 3],
            dt_s,
        }
    }

    /// Saturates and rounds three axes in place; returns how many values lie beyond the range.
    pub(super) fn block(&mut self, axes: [&mut [f64]; 3]) -> u64 {
        let mut clipped = 0;
        let rounds = self.resolution.is_present();
        let carries = rounds && self.resolution.output == Output::Increment;
        let [x, y, z] = axes;
        for (axis, values) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
            let limit = self.range.limit[axis];
            let lsb = if carries {
                0.0
            } else {
                self.resolution.lsb[axis]
            };
            if limit.is_finite() || lsb > 0.0 {
                dispatch(Axis {
                    values,
                    limit,
                    lsb,
                    clipped: &mut clipped,
                });
            }
        }
        if carries {
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                let (rounded, residue) =
                    self.resolution.round([*x, *y, *z], self.residue, self.dt_s);
                ([*x, *y, *z], self.residue) = (rounded, residue);
            }
        }
        clipped
    }
}

/// One axis: its range, and its rounding where that does not carry a residue.
struct Axis<'a> {
    values: &'a mut [f64],
    limit: f64,
    lsb: f64,
    clipped: &'a mut u64,
}

impl Kernel for Axis<'_> {
    #[allow(
        clippy::inline_always,
        reason = "becomes vector code only where it is inlined"
    )]
    #[inline(always)]
    fn run(self) {
        let range = Range {
            limit: [self.limit, f64::INFINITY, f64::INFINITY],
        };
        let resolution = Resolution {
            lsb: [self.lsb, 0.0, 0.0],
            output: Output::Rate,
        };
        let mut beyond = 0_u64;
        for value in &mut *self.values {
            beyond += u64::from(value.abs() > self.limit);
            *value = range.saturate([*value, 0.0, 0.0])[0];
        }
        if self.lsb > 0.0 {
            for value in self.values {
                *value = resolution.round([*value, 0.0, 0.0], [0.0; 3], 1.0).0[0];
            }
        }
        *self.clipped += beyond;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_core::OutputStage;

    #[test]
    fn blocks_are_the_bits_of_the_output_stage() {
        for output in [Output::Rate, Output::Increment] {
            for lsb in [[0.0; 3], [0.013, 0.0, 0.5], [1e-3; 3]] {
                for limit in [[f64::INFINITY; 3], [0.7, 1.2, f64::INFINITY], [0.3; 3]] {
                    let mut triad = Triad::<f64>::default();
                    triad.range.limit = limit;
                    triad.resolution.lsb = lsb;
                    triad.resolution.output = output;
                    let (mut block, mut one) = (
                        Stage::new(&triad, 0.01),
                        OutputStage::new(&triad, 0.01, [0.0; 3]),
                    );
                    let wave = |i: u32, k: f64| (f64::from(i) * k).sin() * 1.5;
                    let samples: Vec<[f64; 3]> = (0..50)
                        .map(|i| [wave(i, 0.3), wave(i, 1.7), wave(i, 0.05)])
                        .collect();
                    let mut axes =
                        [0, 1, 2].map(|a| samples.iter().map(|s| s[a]).collect::<Vec<_>>());
                    let [x, y, z] = &mut axes;
                    let clipped = block.block([x, y, z]);
                    let mut want = 0;
                    for (i, s) in samples.iter().enumerate() {
                        want += (0..3).filter(|a| s[*a].abs() > limit[*a]).count() as u64;
                        assert_eq!(one.next_sample(*s), [axes[0][i], axes[1][i], axes[2][i]]);
                    }
                    assert_eq!(clipped, want);
                }
            }
        }
    }
}
