//! Allan deviation of adjacent averages: σ² = ½τ⁻² mean of (x_{(i+2)m} − 2x_{(i+1)m} + x_{im})².
//!
//! Source `[SP1065]`.

use rayon::prelude::*;

/// Σ of squares for each factor, each with 2m ≤ N.
pub(crate) fn sums_of_squares(phase: &[f64], factors: &[usize]) -> Vec<f64> {
    factors
        .par_iter()
        .map(|&m| {
            let mut points = phase.iter().step_by(m);
            let (Some(&first), Some(&second)) = (points.next(), points.next()) else {
                return 0.0;
            };
            let (mut before, mut middle) = (first, second);
            points
                .map(|&after| {
                    let difference = (before + after) - 2.0 * middle;
                    (before, middle) = (middle, after);
                    difference * difference
                })
                .sum()
        })
        .collect()
}
