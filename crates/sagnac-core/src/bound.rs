//! The convergence bound of the inverse: where the rounds of [`Compensation`](crate::Compensation)
//! have one solution, and how many of them it takes.
//!
//! Norms are largest row sums of absolute values at the worst of T0 and the ends of the
//! temperature range. With R the largest range of a triad and U = 1.5 (R + ‖b‖):
//!
//! μ = ‖M‖, ν = max_k(2|k2_k| U + 3|k3_k| U² + ½|a_k|),
//! L = max_k U_g (4|r_k,k| + 2 Σ_{j≠k}|r_k,j|), F = 2U_a + U_g² max_k(2|r_k,k| + Σ_{j≠k}|r_k,j|),
//! γ = max_k Σ_j|G_kj| + 2F max_k Σ_j|H_kj|, δ = (F max_k Σ_j|G_kj| + F² max_k Σ_j|H_kj|)/U_g,
//! q = max( ν_a/(1−μ_a), (ν_g + γL)/(1−μ_g) ).
//!
//! Inside where μ_a + ν_a ≤ ⅓, μ_g + ν_g + δ ≤ ⅓ and q ≤ ½: the rounds are a contraction of
//! the box |f'| ≤ U_a, |w| ≤ U_g into itself (Banach), the error falls by q a round, and
//! n = ⌈ln ε / ln q⌉ + 2 rounds suffice.

use crate::{DEFAULT_RANGE_C, Measurement, Real, Sensor, TriadErrors, vector::norm_inf};

/// The rounds at q = ½, the most a model inside the bound can take in `f64`.
const ROUNDS_AT_HALF: u32 = 46;

/// Sizes tried where a triad has no range: 1e-6 · 1.5^i, up to 1e9.
const STEPS: i32 = 86;
const STEP: f64 = 1.5;

/// The numbers of the bound for given ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound<T> {
    /// ‖M‖ of gyro and accelerometer.
    pub mu: [T; 2],
    /// Slope of the nonlinearity at the edge of the box, gyro and accelerometer.
    pub nu: [T; 2],
    /// U: the box of the solution, rad/s and m/s².
    pub limit: [T; 2],
    /// How far f can move with ω, (m/s²)/(rad/s).
    pub lever: T,
    /// F: the largest specific force at the centre, m/s².
    pub force: T,
    /// How far the gyro can move with f, (rad/s)/(m/s²).
    pub gamma: T,
    /// What f adds to the gyro, as a part of its box.
    pub delta: T,
    /// The contraction a round.
    pub q: T,
}

impl<T: Real> Bound<T> {
    /// μ_a + ν_a ≤ ⅓, μ_g + ν_g + δ ≤ ⅓ and q ≤ ½.
    #[inline(always)]
    pub fn is_inside(&self) -> bool {
        let third = T::ONE / T::from_f64(3.0);
        self.mu[1] + self.nu[1] <= third
            && self.mu[0] + self.nu[0] + self.delta <= third
            && self.q <= T::HALF
    }

    /// n = ⌈ln ε / ln q⌉ + 2, one where q = 0, at most 46.
    pub fn rounds(&self) -> u32 {
        rounds(self.q.to_f64(), T::ROUND_EPSILON)
    }
}

fn rounds(q: f64, epsilon: f64) -> u32 {
    if q <= 0.0 {
        1
    } else if q < 0.5 {
        (libm::ceil(libm::log(epsilon) / libm::log(q)) as u32 + 2).min(ROUNDS_AT_HALF)
    } else {
        ROUNDS_AT_HALF
    }
}

/// What the bound needs of a model, before the ranges are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundTerms<T> {
    /// ‖M‖ of gyro and accelerometer.
    pub mu: [T; 2],
    /// ‖b‖ of both.
    pub bias: [T; 2],
    /// |k2| of both, by axis.
    pub quadratic: [[T; 3]; 2],
    /// |k3| of both, by axis.
    pub cubic: [[T; 3]; 2],
    /// |a| of both, by axis.
    pub asymmetry: [[T; 3]; 2],
    /// max_k (4|r_k,k| + 2 Σ_{j≠k}|r_k,j|), m.
    pub lever_l: T,
    /// max_k (2|r_k,k| + Σ_{j≠k}|r_k,j|), m.
    pub lever_f: T,
    /// max_k Σ_j|G_kj|.
    pub g: T,
    /// max_k Σ_j|H_kj|.
    pub h: T,
}

impl<T: Real> BoundTerms<T> {
    pub(crate) fn new(of: &Measurement<T>) -> Self {
        let (gyro, accel) = (&of.gyro, &of.accel);
        let n = |e: &TriadErrors<T>| {
            let n = &e.triad.nonlinearity;
            (
                n.quadratic.map(T::abs),
                n.cubic.map(T::abs),
                e.triad.asymmetry.difference.map(T::abs),
            )
        };
        let ((k2g, k3g, ag), (k2a, k3a, aa)) = (n(gyro), n(accel));
        let (mut lever_l, mut lever_f) = (T::ZERO, T::ZERO);
        if let Some(offset) = &of.axis_offset {
            let two = T::ONE + T::ONE;
            for (k, r) in offset.position.iter().enumerate() {
                let (mut own, mut others) = (T::ZERO, T::ZERO);
                for (j, x) in r.iter().enumerate() {
                    if j == k {
                        own = x.abs();
                    } else {
                        others += x.abs();
                    }
                }
                lever_f = lever_f.larger(two * own + others);
                lever_l = lever_l.larger(two * (two * own + others));
            }
        }
        let row_sum = |row: &[T]| row.iter().fold(T::ZERO, |sum, x| sum + x.abs());
        let (mut g, mut h) = (T::ZERO, T::ZERO);
        if let Some(of_f) = &of.g_sensitivity {
            g = of_f
                .matrix
                .iter()
                .fold(g, |max, row| max.larger(row_sum(row)));
        }
        if let Some(of_ff) = &of.g2_sensitivity {
            h = of_ff
                .matrix
                .iter()
                .fold(h, |max, row| max.larger(row_sum(row)));
        }
        let (mu_g, bias_g) = worst(gyro, of.reference_c);
        let (mu_a, bias_a) = worst(accel, of.reference_c);
        Self {
            mu: [mu_g, mu_a],
            bias: [bias_g, bias_a],
            quadratic: [k2g, k2a],
            cubic: [k3g, k3a],
            asymmetry: [ag, aa],
            lever_l,
            lever_f,
            g,
            h,
        }
    }

    /// The bound where outputs reach `range` (gyro, accelerometer).
    #[inline(always)]
    pub(crate) fn at(&self, range: [T; 2]) -> Bound<T> {
        let c = T::from_f64;
        let (two, three, half) = (c(2.0), c(3.0), T::HALF);
        let limit = [
            c(1.5) * (range[0] + self.bias[0]),
            c(1.5) * (range[1] + self.bias[1]),
        ];
        let nu_of = |s: usize, u: T| {
            let (k2, k3, a) = (self.quadratic[s], self.cubic[s], self.asymmetry[s]);
            let one = |k: usize| two * k2[k] * u + three * k3[k] * (u * u) + half * a[k];
            one(0).larger(one(1)).larger(one(2))
        };
        let nu = [nu_of(0, limit[0]), nu_of(1, limit[1])];
        let lever = limit[0] * self.lever_l;
        let force = two * limit[1] + limit[0] * limit[0] * self.lever_f;
        let gamma = self.g + two * force * self.h;
        let from_f = force * self.g + force * force * self.h;
        let delta = if from_f > T::ZERO {
            from_f / limit[0]
        } else {
            T::ZERO
        };
        let part = |slope: T, mu: T| {
            if mu < T::ONE {
                slope / (T::ONE - mu)
            } else {
                T::INFINITY
            }
        };
        Bound {
            mu: self.mu,
            nu,
            limit,
            lever,
            force,
            gamma,
            delta,
            q: part(nu[1], self.mu[1]).larger(part(nu[0] + gamma * lever, self.mu[0])),
        }
    }

    /// The rounds for ranges of which some are not known: those of the largest q that a
    /// sample inside the bound can have.
    pub(crate) fn rounds(&self, range: [Option<T>; 2]) -> u32 {
        if let [Some(gyro), Some(accel)] = range {
            return self.at([gyro, accel]).rounds();
        }
        let far = |bound: Bound<T>| bound.q.to_f64();
        // Where q does not depend on the size of the sample there is nothing to search.
        let q0 = far(self.at([T::ONE, T::ONE]));
        let q1 = far(self.at([T::from_f64(100.0), T::from_f64(100.0)]));
        if q0 == q1 {
            return rounds(q0, T::ROUND_EPSILON);
        }
        // Sizes from 1e-6 to 1e9 by factors of 1.5; q grows with both. Each is tried one step
        // further than the sample that is still inside, so that none between is missed.
        let size = |known: Option<T>, i: i32| match known {
            Some(range) => range,
            None => T::from_f64(1e-6 * libm::pow(STEP, f64::from(i))),
        };
        let steps = |known: Option<T>| if known.is_some() { 1 } else { STEPS };
        let mut largest = 0.0_f64;
        for i in 0..steps(range[0]) {
            for j in 0..steps(range[1]) {
                if self.at([size(range[0], i), size(range[1], j)]).is_inside() {
                    let next = self.at([size(range[0], i + 1), size(range[1], j + 1)]);
                    largest = largest.max(far(next).min(0.5));
                }
            }
        }
        rounds(largest, T::ROUND_EPSILON)
    }
}

/// ‖M‖ and ‖b‖ at the worst of T0 and the ends of the temperature range.
fn worst<T: Real>(errors: &TriadErrors<T>, reference_c: T) -> (T, T) {
    let default = DEFAULT_RANGE_C.map(T::from_f64);
    let ends = |range: Option<[T; 2]>| range.unwrap_or(default);
    let [low_b, high_b] = ends(errors.bias_thermal.range_c());
    let [low_s, high_s] = ends(errors.scale_thermal.range_c());
    let (mut mu, mut bias) = (T::ZERO, T::ZERO);
    for t in [reference_c, low_b, high_b] {
        bias = bias.larger(norm_inf(errors.bias(t)));
    }
    for t in [reference_c, low_s, high_s] {
        let gain = errors.gain(t);
        for (k, row) in gain.iter().enumerate() {
            let mut sum = T::ZERO;
            for (j, x) in row.iter().enumerate() {
                sum += if j == k { (*x - T::ONE).abs() } else { x.abs() };
            }
            mu = mu.larger(sum);
        }
    }
    (mu, bias)
}

/// Why a model has no inverse here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompensationError {
    /// I + M cannot be inverted.
    Singular {
        /// Whose.
        sensor: Sensor,
    },
    /// μ + ν ≥ 1: errors as large as the signal.
    TooLarge {
        /// Whose.
        sensor: Sensor,
        /// ‖M‖ + the slope of the nonlinearity.
        mu_plus_nu: f64,
    },
    /// A parameter of the model, or a sum of its parameters, is infinite or NaN.
    NotFinite {
        /// Whose.
        sensor: Sensor,
    },
    /// The sampling interval is not a positive number.
    Interval {
        /// What was given, s.
        dt_s: f64,
    },
}

impl core::fmt::Display for CompensationError {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Singular { sensor } => write!(
                out,
                "the {} matrix I + M is singular: its three axes do not span space",
                sensor.name()
            ),
            Self::TooLarge { sensor, mu_plus_nu } => write!(
                out,
                "the {} errors are as large as the signal: mu + nu = {mu_plus_nu:.3}, and no inverse is known from 1 on",
                sensor.name()
            ),
            Self::NotFinite { sensor } => {
                write!(
                    out,
                    "a {} parameter is too large to reckon with, or no number",
                    sensor.name()
                )
            }
            Self::Interval { dt_s } => {
                write!(out, "the sampling interval must be positive, got {dt_s} s")
            }
        }
    }
}

impl core::error::Error for CompensationError {}
