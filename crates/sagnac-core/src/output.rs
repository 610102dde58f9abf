//! The output stage of a triad: y = round(saturate(lowpass(u))), after the random terms.
//!
//! Lecture slides 2 and 8. State is two samples of each filter and one residue of each
//! rounded increment; nothing else is remembered.

use crate::{LowPass, Range, Real, Resolution, Triad, vector::Vector};

/// Low-pass, saturation and rounding of three axes, with their state.
///
/// ```
/// use sagnac_core::{Output, OutputStage, Triad};
///
/// let mut triad = Triad::<f64>::default();
/// triad.resolution.lsb = [0.01; 3];
/// triad.resolution.output = Output::Increment;
/// let mut stage = OutputStage::new(&triad, 1.0, [0.0; 3]);
/// // A rate of 0.4 LSB is not lost: the residue is carried.
/// let angle: f64 = (0..10).map(|_| stage.next_sample([0.004, 0.0, 0.0])[0]).sum();
/// assert!((angle - 0.04).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputStage<T> {
    low_pass: [LowPass<T>; 3],
    range: Range<T>,
    resolution: Resolution<T>,
    residue: Vector<T>,
    dt_s: T,
}

impl<T: Real> OutputStage<T> {
    /// A stage at samples `dt_s` apart, settled at the first sample without noise.
    pub fn new(triad: &Triad<T>, dt_s: T, settled: Vector<T>) -> Self {
        let f = triad.bandwidth.cutoff_hz;
        Self {
            low_pass: [
                LowPass::new(f[0], dt_s, settled[0]),
                LowPass::new(f[1], dt_s, settled[1]),
                LowPass::new(f[2], dt_s, settled[2]),
            ],
            range: triad.range,
            resolution: triad.resolution,
            residue: [T::ZERO; 3],
            dt_s,
        }
    }

    /// The output for the next sample of deterministic part plus random terms.
    #[inline(always)]
    pub fn next_sample(&mut self, u: Vector<T>) -> Vector<T> {
        let [x, y, z] = &mut self.low_pass;
        let filtered = [
            x.next_sample(u[0]),
            y.next_sample(u[1]),
            z.next_sample(u[2]),
        ];
        let (rounded, residue) =
            self.resolution
                .round(self.range.saturate(filtered), self.residue, self.dt_s);
        self.residue = residue;
        rounded
    }

    /// Whether samples pass unchanged: no low-pass, no range, no resolution.
    pub fn is_transparent(&self) -> bool {
        self.low_pass.iter().all(LowPass::is_flat)
            && !self.range.is_present()
            && !self.resolution.is_present()
    }
}
