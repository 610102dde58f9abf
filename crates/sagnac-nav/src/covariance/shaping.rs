//! Random processes as states over a stretch of time H: their end value and the first three Legendre coefficients of
//! the process, jointly Gaussian (navigation.md §3.3).
//!
//! G_j = (2j + 1)/H ∫ g P_j ds; whatever the process drives is Σ_j G_j M_j with M_j = ∫ w P_j ds of the response w. State
//! space and iterated integrals form one linear system whose transition and covariance follow by doubling, all sums of
//! positive terms, so that nothing cancels however short or long the correlation time is [VANLOAN].

/// Legendre coefficients kept.
pub(super) const ORDERS: usize = 3;

/// Most states of one process.
pub(super) const STATES: usize = 2;

/// A process per unit of its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Process {
    /// White noise of density N² = 1.
    White,
    /// K²/(2πf)² with K = 1, zero at t = 0.
    RandomWalk,
    /// σ = 1, stationary.
    GaussMarkov {
        /// T_c, s.
        correlation_time_s: f64,
    },
    /// σ = 1, stationary.
    Resonance {
        /// f_r, Hz.
        frequency_hz: f64,
        /// ζ.
        damping: f64,
    },
    /// A = 1 with a random phase.
    Sinusoid {
        /// f0, Hz.
        frequency_hz: f64,
    },
    /// Q = 1: the rate (q_k − q_{k−1})/dt.
    Quantization {
        /// Sampling interval, s.
        dt_s: f64,
    },
    /// The same from q_0 = 0 on: increments rounded with a residue that a run begins without (model.md §2).
    Rounding {
        /// Sampling interval, s.
        dt_s: f64,
    },
}

/// A process over one stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    /// Transition of the states.
    pub phi: [[f64; STATES]; STATES],
    /// Legendre coefficients from the states at the start.
    pub map: [[f64; STATES]; ORDERS],
    /// Covariance of the new part of the coefficients.
    pub q_gg: [[f64; ORDERS]; ORDERS],
    /// Covariance of the new parts of coefficients and end states.
    pub q_gp: [[f64; STATES]; ORDERS],
    /// Covariance of the new part of the end states.
    pub q_pp: [[f64; STATES]; STATES],
}

const SIZE: usize = STATES + ORDERS;
type Square = [[f64; SIZE]; SIZE];

fn product(a: &Square, b: &Square) -> Square {
    let mut out = [[0.0; SIZE]; SIZE];
    for i in 0..SIZE {
        for k in 0..SIZE {
            let x = a[i][k];
            if x != 0.0 {
                for j in 0..SIZE {
                    out[i][j] += x * b[k][j];
                }
            }
        }
    }
    out
}

fn sandwich(a: &Square, q: &Square) -> Square {
    let left = product(a, q);
    let mut out = [[0.0; SIZE]; SIZE];
    for i in 0..SIZE {
        for j in 0..SIZE {
            for k in 0..SIZE {
                out[i][j] += left[i][k] * a[j][k];
            }
        }
    }
    out
}

impl Process {
    /// Covariance of the states at t = 0.
    pub fn initial(&self) -> [[f64; STATES]; STATES] {
        match *self {
            Self::White | Self::RandomWalk | Self::Rounding { .. } => [[0.0; 2]; 2],
            Self::GaussMarkov { .. } | Self::Quantization { .. } => [[1.0, 0.0], [0.0, 0.0]],
            // The second state is ẋ/ω.
            Self::Resonance { .. } => [[1.0, 0.0], [0.0, 1.0]],
            Self::Sinusoid { .. } => [[0.5, 0.0], [0.0, 0.5]],
        }
    }

    /// The process over `h` seconds.
    pub fn over(&self, h: f64) -> Discrete {
        // System matrix and noise intensity with time counted in stretches.
        let (a, q): ([[f64; 2]; 2], [[f64; 2]; 2]) = match *self {
            Self::White => return white(h),
            Self::Quantization { dt_s } | Self::Rounding { dt_s } => return quantization(h, dt_s),
            Self::RandomWalk => ([[0.0; 2]; 2], [[h, 0.0], [0.0, 0.0]]),
            Self::GaussMarkov { correlation_time_s } => {
                let x = h / correlation_time_s;
                ([[-x, 0.0], [0.0, 0.0]], [[2.0 * x, 0.0], [0.0, 0.0]])
            }
            Self::Resonance {
                frequency_hz,
                damping,
            } => {
                let w = 2.0 * std::f64::consts::PI * frequency_hz * h;
                (
                    [[0.0, w], [-w, -2.0 * damping * w]],
                    [[0.0, 0.0], [0.0, 4.0 * damping * w]],
                )
            }
            Self::Sinusoid { frequency_hz } => {
                let w = 2.0 * std::f64::consts::PI * frequency_hz * h;
                ([[0.0, w], [-w, 0.0]], [[0.0; 2]; 2])
            }
        };
        let mut system = [[0.0; SIZE]; SIZE];
        let mut intensity = [[0.0; SIZE]; SIZE];
        for i in 0..2 {
            system[i][..2].copy_from_slice(&a[i]);
            intensity[i][..2].copy_from_slice(&q[i]);
        }
        // The iterated integrals I₁ = ∫g, I₂ = ∫I₁, I₃ = ∫I₂.
        system[2][0] = 1.0;
        system[3][2] = 1.0;
        system[4][3] = 1.0;
        let largest = a.iter().flatten().fold(1.0f64, |m, x| m.max(x.abs()));
        let doublings = (largest.log2().ceil() as i32 + 5).max(5);
        let step = 0.5f64.powi(doublings);
        // Short step by its series: Φ = Σ (A s)ᵏ/k!; Q = Σ s^{k+1}/(k+1)! Σ …, by Simpson-free recurrence on powers.
        let mut phi = identity();
        let mut term = identity();
        let mut cov = [[0.0; SIZE]; SIZE];
        let mut cov_term = intensity;
        let mut factor = step;
        for i in 0..SIZE {
            for j in 0..SIZE {
                cov[i][j] = cov_term[i][j] * factor;
            }
        }
        for k in 1..9 {
            let next = product(&system, &term);
            let scale = step / f64::from(k);
            for i in 0..SIZE {
                for j in 0..SIZE {
                    term[i][j] = next[i][j] * scale;
                    phi[i][j] += term[i][j];
                }
            }
            // d/ds of the intensity seen at the end: C_{k} = A C_{k−1} + C_{k−1} Aᵀ, Q = Σ C_k s^{k+1}/(k+1)!.
            let left = product(&system, &cov_term);
            for i in 0..SIZE {
                for j in 0..SIZE {
                    cov_term[i][j] = left[i][j] + left[j][i];
                }
            }
            factor *= step / f64::from(k + 1);
            for i in 0..SIZE {
                for j in 0..SIZE {
                    cov[i][j] += cov_term[i][j] * factor;
                }
            }
        }
        for _ in 0..doublings {
            let moved = sandwich(&phi, &cov);
            for i in 0..SIZE {
                for j in 0..SIZE {
                    cov[i][j] += moved[i][j];
                }
            }
            phi = product(&phi, &phi);
        }
        // ∫g = I₁, ∫s g = I₁ − I₂, ∫s² g = I₁ − 2I₂ + 2I₃ over the unit stretch; then P_j in x = 2s − 1.
        let legendre = [[1.0, 0.0, 0.0], [3.0, -6.0, 0.0], [5.0, -30.0, 60.0]];
        let coefficient = |row: &dyn Fn(usize) -> f64, j: usize| {
            (0..3).map(|i| legendre[j][i] * row(i)).sum::<f64>()
        };
        let mut out = Discrete {
            phi: [[0.0; 2]; 2],
            map: [[0.0; 2]; 3],
            q_gg: [[0.0; 3]; 3],
            q_gp: [[0.0; 2]; 3],
            q_pp: [[0.0; 2]; 2],
        };
        for i in 0..2 {
            for j in 0..2 {
                out.phi[i][j] = phi[i][j];
                out.q_pp[i][j] = cov[i][j];
            }
        }
        for j in 0..3 {
            for p in 0..2 {
                out.map[j][p] = coefficient(&|i| phi[2 + i][p], j);
                out.q_gp[j][p] = coefficient(&|i| cov[2 + i][p], j);
            }
            for k in 0..3 {
                out.q_gg[j][k] = coefficient(&|i| coefficient(&|m| cov[2 + i][2 + m], k), j);
            }
        }
        out
    }

    /// Variance of the mean over `h` seconds and its covariance with the end value, stationary; `None` for processes that
    /// a self-alignment does not see (navigation.md §3.4).
    pub fn mean_before(&self, h: f64) -> Option<(f64, f64)> {
        match *self {
            Self::White => Some((1.0 / h, 0.0)),
            Self::GaussMarkov { correlation_time_s } => {
                let x = h / correlation_time_s;
                let decay = (-x).exp_m1();
                // 2(x − 1 + e^{−x})/x², by its series where it cancels.
                let variance = if x < 1e-3 {
                    1.0 - x / 3.0 + x * x / 12.0
                } else {
                    2.0 * (x + decay) / (x * x)
                };
                Some((variance, -decay / x))
            }
            _ => None,
        }
    }
}

fn identity() -> Square {
    let mut out = [[0.0; SIZE]; SIZE];
    for (i, row) in out.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    out
}

fn white(h: f64) -> Discrete {
    let mut q_gg = [[0.0; 3]; 3];
    for (j, row) in q_gg.iter_mut().enumerate() {
        row[j] = (2 * j + 1) as f64 / h;
    }
    Discrete {
        phi: [[0.0; 2]; 2],
        map: [[0.0; 2]; 3],
        q_gg,
        q_gp: [[0.0; 2]; 3],
        q_pp: [[0.0; 2]; 2],
    }
}

/// Σ w (q_k − q_{k−1}) = w(H) q_end − w(0) q_start − ∫w′ q, the last with the density Q² dt.
fn quantization(h: f64, dt: f64) -> Discrete {
    let mut out = Discrete {
        phi: [[0.0; 2]; 2],
        map: [[0.0; 2]; 3],
        q_gg: [[0.0; 3]; 3],
        q_gp: [[0.0; 2]; 3],
        q_pp: [[1.0, 0.0], [0.0, 0.0]],
    };
    for j in 0..3 {
        let odd = if j % 2 == 1 { -1.0 } else { 1.0 };
        let g = (2 * j + 1) as f64 / h;
        out.map[j][0] = -odd * g;
        out.q_gp[j][0] = g;
        for k in 0..3 {
            out.q_gg[j][k] = g * (2 * k + 1) as f64 / h;
        }
    }
    let h3 = h * h * h;
    out.q_gg[1][1] += 36.0 * dt / h3;
    out.q_gg[2][2] += 300.0 * dt / h3;
    out
}

/// The ladder of Gauss–Markov states that stands for flicker: (σ/B, T_c) from the slowest on.
///
/// σ = B√(ln ρ/π), T_i = 8Tρ^{−(i+½)} down to the first with 1/(2πT_i) ≥ 10 Hz, ρ = 10.
pub fn flicker_ladder(duration_s: f64) -> Vec<(f64, f64)> {
    let ratio = 10.0f64;
    let sigma = (ratio.ln() / std::f64::consts::PI).sqrt();
    let mut out = Vec::new();
    for i in 0..40 {
        let time = 8.0 * duration_s * ratio.powf(-(f64::from(i) + 0.5));
        out.push((sigma, time));
        if 1.0 / (2.0 * std::f64::consts::PI * time) >= 10.0 {
            break;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_markov_mean_and_end() {
        // model.md §3: Var e1 = 1 − φ², mean part x(1 − φ)/h, Var e2 = (2h − 3 + 4φ − φ²)/h², Cov = (1 − φ)²/h.
        for x in [1e-3f64, 0.3, 2.0, 60.0] {
            let d = Process::GaussMarkov {
                correlation_time_s: 1.0 / x,
            }
            .over(1.0);
            let phi = (-x).exp();
            let e2 = if x < 0.01 {
                2.0 / 3.0 * x - 0.5 * x * x + 7.0 / 30.0 * x * x * x
            } else {
                (2.0 * x - 3.0 + 4.0 * phi - phi * phi) / (x * x)
            };
            for (got, want) in [
                (d.phi[0][0], phi),
                (d.map[0][0], (1.0 - phi) / x),
                (d.q_pp[0][0], 1.0 - phi * phi),
                (d.q_gg[0][0], e2),
                (d.q_gp[0][0], (1.0 - phi) * (1.0 - phi) / x),
            ] {
                assert!(
                    (got - want).abs() <= 1e-7 * want.abs() + 1e-12,
                    "{x} {got} {want}"
                );
            }
        }
    }

    #[test]
    fn short_correlation_is_white_noise() {
        let d = Process::GaussMarkov {
            correlation_time_s: 1e-4,
        }
        .over(2.0);
        let w = Process::White.over(2.0);
        for j in 0..3 {
            assert!((d.q_gg[j][j] / (2e-4 * w.q_gg[j][j]) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn random_walk_and_sinusoid() {
        let d = Process::RandomWalk.over(3.0);
        assert!(
            (d.q_pp[0][0] - 3.0).abs() < 1e-12
                && (d.q_gg[0][0] - 1.0).abs() < 1e-12
                && (d.map[0][0] - 1.0).abs() < 1e-12
        );
        let s = Process::Sinusoid { frequency_hz: 0.25 }.over(1.0);
        assert!(s.phi[0][0].abs() < 1e-10 && (s.phi[0][1] - 1.0).abs() < 1e-10);
        assert!((s.map[0][0] - 2.0 / std::f64::consts::PI).abs() < 1e-10);
    }

    #[test]
    fn the_ladder_has_seven_states_for_an_hour() {
        assert_eq!(flicker_ladder(3600.0).len(), 7);
    }
}
