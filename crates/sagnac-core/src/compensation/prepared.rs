//! What a triad needs in every round: y − b, (I + M)⁻¹ of each sample, and where the rounds start.

use crate::{
    Real, TriadErrors,
    vector::{self, put, take, take_from},
};

/// What a triad needs in every round.
pub(super) struct Prepared<T, const N: usize> {
    /// y − b.
    pub(super) centered: [[T; N]; 3],
    /// (I + M)⁻¹.
    pub(super) inverse: [[[T; N]; 3]; 3],
    /// f' or ω.
    pub(super) solution: [[T; N]; 3],
    /// The temperature that all of `inverse`, and `bias` and `matrix`, stand for.
    held_c: Option<T>,
    bias: [T; 3],
    matrix: vector::Matrix<T>,
}

impl<T: Real, const N: usize> Prepared<T, N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self {
            centered: [[T::ZERO; N]; 3],
            inverse: [[[T::ZERO; N]; 3]; 3],
            solution: [[T::ZERO; N]; 3],
            held_c: None,
            bias: [T::ZERO; 3],
            matrix: [[T::ZERO; 3]; 3],
        }
    }

    /// b taken off, the inverse matrix of each sample, and the start of the rounds; `common_c`
    /// is the temperature where all samples have the same, or where it changes nothing.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        errors: &TriadErrors<T>,
        y: [&[T; N]; 3],
        temperature_c: &[T; N],
        common_c: Option<T>,
    ) {
        if let Some(t) = common_c {
            if self.held_c != Some(t) {
                self.held_c = Some(t);
                self.bias = errors.bias(t);
                self.matrix = vector::inverse(&errors.gain(t)).0;
                for j in 0..3 {
                    for k in 0..3 {
                        self.inverse[j][k] = [self.matrix[j][k]; N];
                    }
                }
            }
            let (bias, matrix) = (self.bias, self.matrix);
            for i in 0..N {
                let centered = vector::sub(take_from(y, i), bias);
                put(&mut self.centered, i, centered);
                put(&mut self.solution, i, vector::apply(&matrix, centered));
            }
            return;
        }
        self.held_c = None;
        let fixed = errors.triad.bias.fixed;
        let mut bias = [[fixed[0]; N], [fixed[1]; N], [fixed[2]; N]];
        errors.bias_thermal.add_to(temperature_c, &mut bias);
        if !errors.scale_thermal.is_present() {
            let (matrix, _) = vector::inverse(&errors.gain);
            for i in 0..N {
                for j in 0..3 {
                    put(&mut self.inverse[j], i, matrix[j]);
                }
                let centered = vector::sub(take_from(y, i), take(&bias, i));
                put(&mut self.centered, i, centered);
                put(&mut self.solution, i, vector::apply(&matrix, centered));
            }
            return;
        }
        let mut scale = [[T::ZERO; N]; 3];
        errors.scale_thermal.add_to(temperature_c, &mut scale);
        let at_reference = errors.gain;
        for i in 0..N {
            let mut gain = at_reference;
            for k in 0..3 {
                gain[k][k] += scale[k][i];
            }
            let (of_sample, _) = vector::inverse(&gain);
            for j in 0..3 {
                put(&mut self.inverse[j], i, of_sample[j]);
            }
            let centered = vector::sub(take_from(y, i), take(&bias, i));
            put(&mut self.centered, i, centered);
            put(&mut self.solution, i, vector::apply(&of_sample, centered));
        }
    }
}
