//! Weights of the polynomial through the means of neighbouring samples, p(u) = Σ aᵢ uⁱ with u in [−½, ½] over the
//! interval that is integrated, and of the coning and sculling integrals in its coefficients.
//!
//! ½∫α × ω du = Σ_{i<j} Q_ij aᵢ × aⱼ with Q = ½(K − Kᵀ), K_ij = ∫ (u^{i+1} − (−½)^{i+1})/(i+1) · uʲ du. Q vanishes where
//! i + j is even, so the sum is E₁ × a₁ + E₃ × a₃ with E_o = Σ_even Q_eo a_e: two cross products, whatever the degree
//! [SAVAGE] [IGNAGNI].

/// Which samples the polynomial of an interval goes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sculling {
    /// Samples k − 1 and k: degree 1.
    Two,
    /// Samples k − 2 … k + 2: degree 4, one-sided at the ends of a record.
    #[default]
    Five,
}

impl Sculling {
    /// Samples in a full window.
    pub const fn width(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Five => 5,
        }
    }
}

/// Weights of the window's samples in a₁, a₂, a₃, E₁ and E₃ for one place of the interval in the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    pub(super) a1: [f64; 5],
    pub(super) a2: [f64; 5],
    pub(super) a3: [f64; 5],
    pub(super) e1: [f64; 5],
    pub(super) e3: [f64; 5],
    pub(super) centred: Centred,
}

/// Coning in a symmetric window with fewer products. With the sums and differences s₁, s₂, d₁, d₂ of the neighbours on
/// both sides of the middle sample m, E₁ × a₁ + E₃ × a₃ is scale·(P × O₁ + Q × O₂), where P = m + even₀ s₁,
/// Q = s₂ + even₁ s₁, d = d₂ + odd₀ d₁, O₁ = d₁ + odd₁ d and O₂ = odd₂ d.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Centred {
    pub(super) scale: f64,
    pub(super) even: [f64; 2],
    pub(super) odd: [f64; 3],
}

impl Centred {
    /// From the weights of a symmetric window of five.
    fn new(a1: [f64; 5], a3: [f64; 5], e1: [f64; 5], e3: [f64; 5]) -> Self {
        // E₁ × a₁ + E₃ × a₃ = G₁ × d₁ + G₂ × d₂; both G in (m, s₁, s₂).
        let along = |j: usize| -> [f64; 3] {
            std::array::from_fn(|i| a1[j] * e1[2 + i] + a3[j] * e3[2 + i])
        };
        let (g1, g2) = (along(3), along(4));
        // G₁ − c G₂ has no s₂ where d₂ + c d₁ takes the place of d₂; then G₂ − e G₁ has no m.
        let c = g1[2] / g2[2];
        let first: [f64; 3] = std::array::from_fn(|i| g1[i] - c * g2[i]);
        let e = g2[0] / first[0];
        let second: [f64; 3] = std::array::from_fn(|i| g2[i] - e * first[i]);
        Self {
            scale: first[0],
            even: [first[1] / first[0], second[1] / second[2]],
            odd: [c, e, second[2] / first[0]],
        }
    }
}

/// ∫ uᵏ du over [−½, ½].
fn moment(k: usize) -> f64 {
    if k % 2 == 1 {
        0.0
    } else {
        2.0 * 0.5f64.powi(k as i32 + 1) / (k as f64 + 1.0)
    }
}

fn q(i: usize, j: usize) -> f64 {
    let k = |i: usize, j: usize| {
        (moment(i + 1 + j) - (-0.5f64).powi(i as i32 + 1) * moment(j)) / (i as f64 + 1.0)
    };
    0.5 * (k(i, j) - k(j, i))
}

impl Weights {
    /// For a window of `width` samples (1 to 5) in which the interval is number `place` (0 is the oldest).
    pub(super) fn new(width: usize, place: usize) -> Self {
        // Rows: the mean of uⁱ over the interval of each sample; columns: i. Solved for the unit samples.
        let mut matrix = [[0.0; 10]; 5];
        for (j, row) in matrix.iter_mut().enumerate().take(width) {
            let low = j as f64 - place as f64 - 0.5;
            for (i, cell) in row.iter_mut().enumerate().take(width) {
                let power = i as i32 + 1;
                *cell = ((low + 1.0).powi(power) - low.powi(power)) / f64::from(power);
            }
            row[5 + j] = 1.0;
        }
        for k in 0..width {
            let pivot = (k..width)
                .max_by(|a, b| matrix[*a][k].abs().total_cmp(&matrix[*b][k].abs()))
                .unwrap_or(k);
            matrix.swap(k, pivot);
            let inverse = 1.0 / matrix[k][k];
            for cell in &mut matrix[k] {
                *cell *= inverse;
            }
            for row in 0..width {
                if row != k {
                    let factor = matrix[row][k];
                    for column in 0..10 {
                        matrix[row][column] -= factor * matrix[k][column];
                    }
                }
            }
        }
        let coefficient = |i: usize| -> [f64; 5] {
            std::array::from_fn(|j| {
                if i < width && j < width {
                    matrix[i][5 + j]
                } else {
                    0.0
                }
            })
        };
        let even = |odd: usize| -> [f64; 5] {
            std::array::from_fn(|j| {
                [0usize, 2, 4]
                    .iter()
                    .map(|e| q(*e, odd) * coefficient(*e)[j])
                    .sum()
            })
        };
        let (a1, a3, e1, e3) = (coefficient(1), coefficient(3), even(1), even(3));
        let centred = if width == 5 && place == 2 {
            Centred::new(a1, a3, e1, e3)
        } else {
            Centred::default()
        };
        Self {
            a1,
            a2: coefficient(2),
            a3,
            e1,
            e3,
            centred,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_samples_give_the_classical_twelfth() {
        // Coning of two samples: ½∫α×ω = (1/12) ω_{k−1} × ω_k [SAVAGE].
        let w = Weights::new(2, 1);
        // E₁ × a₁ with a₀ = ω_k, a₁ = ω_k − ω_{k−1}: −E₁·ω_{k−1} part.
        let factor = w.e1[1] * w.a1[0] - w.e1[0] * w.a1[1];
        assert!((factor.abs() - 1.0 / 12.0).abs() < 1e-15, "{factor}");
    }

    #[test]
    fn coefficients_of_a_quartic_come_back() {
        let a = [0.7, -0.3, 0.2, 0.05, -0.11];
        for place in 0..5 {
            let w = Weights::new(5, place);
            let mean = |j: usize| {
                let low = j as f64 - place as f64 - 0.5;
                (0..5)
                    .map(|i| {
                        a[i] * ((low + 1.0f64).powi(i as i32 + 1) - low.powi(i as i32 + 1))
                            / (i as f64 + 1.0)
                    })
                    .sum::<f64>()
            };
            let apply = |row: [f64; 5]| (0..5).map(|j| row[j] * mean(j)).sum::<f64>();
            assert!(
                (apply(w.a1) - a[1]).abs() < 1e-12
                    && (apply(w.a2) - a[2]).abs() < 1e-12
                    && (apply(w.a3) - a[3]).abs() < 1e-12
            );
        }
    }

    #[test]
    fn the_short_form_of_coning_is_the_long_one() {
        let w = Weights::new(5, 2);
        let c = w.centred;
        let x = [0.31, -0.42, 0.57, 0.11, -0.23];
        let y = [-0.17, 0.66, 0.29, -0.51, 0.38];
        let apply = |row: [f64; 5], m: [f64; 5]| -> f64 { (0..5).map(|j| row[j] * m[j]).sum() };
        // One component of a cross product.
        let long = apply(w.e1, x) * apply(w.a1, y) - apply(w.e1, y) * apply(w.a1, x)
            + apply(w.e3, x) * apply(w.a3, y)
            - apply(w.e3, y) * apply(w.a3, x);
        let short = |m: [f64; 5]| {
            let (s1, s2, d1, d2) = (m[3] + m[1], m[4] + m[0], m[3] - m[1], m[4] - m[0]);
            let d = d2 + c.odd[0] * d1;
            (
                [m[2] + c.even[0] * s1, s2 + c.even[1] * s1],
                [d1 + c.odd[1] * d, c.odd[2] * d],
            )
        };
        let ((ex, ox), (ey, oy)) = (short(x), short(y));
        let sum: f64 = (0..2).map(|k| ex[k] * oy[k] - ey[k] * ox[k]).sum();
        assert!((c.scale * sum - long).abs() < 1e-14, "{long}");
    }
}
