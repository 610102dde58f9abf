//! Equivalent degrees of freedom of a deviation and its χ² limits.
//!
//! edf = 2E²/Var of the variance estimate; σ̂²·edf/σ² is taken as χ² of edf degrees. The edf is
//! Greenhall's sum over the covariance of the differences `[GREENHALL]` with the generalized
//! autocovariance of interval means: for α ≤ 0 that of phase samples that are not averaged.

use statrs::function::gamma::{gamma_lr, gamma_ur, ln_gamma};

use crate::deviation::Deviation;

/// A 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower limit.
    pub lower: f64,
    /// Upper limit.
    pub upper: f64,
}

/// The 95 % interval of a deviation (root of a variance) with `edf` degrees of freedom:
/// σ̂·√(edf/χ²_{0.975}), σ̂·√(edf/χ²_{0.025}).
pub fn chi_squared_interval(deviation: f64, edf: f64) -> Interval {
    Interval {
        lower: deviation * (edf / chi_squared_quantile(0.975, edf)).sqrt(),
        upper: deviation * (edf / chi_squared_quantile(0.025, edf)).sqrt(),
    }
}

/// The value that χ² of `degrees` (> 0, any real number) stays below with `probability`.
///
/// Relative error below 1e-9 for the probabilities of 95 % intervals (tested against tables).
pub fn chi_squared_quantile(probability: f64, degrees: f64) -> f64 {
    let z = normal_quantile(probability);
    if degrees > 2000.0 {
        return cornish_fisher(z, degrees);
    }
    // Wilson and Hilferty's cube as the start, then Newton on the regularized gamma function,
    // in ln x, where the distribution is close to linear even below one degree.
    let a = degrees / 2.0;
    let cube = 1.0 - 2.0 / (9.0 * degrees) + z * (2.0 / (9.0 * degrees)).sqrt();
    let mut x = if cube > 0.2 {
        a * cube.powi(3)
    } else {
        ((probability.ln() + ln_gamma(a + 1.0)) / a).exp()
    };
    for _ in 0..50 {
        // The smaller tail keeps its relative precision.
        let (excess, scale) = if probability < 0.5 {
            (gamma_lr(a, x) - probability, 1.0)
        } else {
            (gamma_ur(a, x) - (1.0 - probability), -1.0)
        };
        let density = (a * x.ln() - x - ln_gamma(a)).exp();
        let step = (scale * excess / density).clamp(-1.0, 1.0);
        x *= (-step).exp();
        if step.abs() < 1e-13 {
            break;
        }
    }
    2.0 * x
}

/// Quantile of the standard normal.
fn normal_quantile(probability: f64) -> f64 {
    -std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * probability)
}

/// Cornish–Fisher expansion of the χ² quantile, relative error below 1e-9 from 2000 degrees on.
fn cornish_fisher(z: f64, degrees: f64) -> f64 {
    let root = (2.0 * degrees).sqrt();
    let (z2, z3) = (z * z, z * z * z);
    let (z4, z5) = (z2 * z2, z3 * z2);
    degrees + root * z + 2.0 / 3.0 * (z2 - 1.0) + (z3 - 7.0 * z) / (9.0 * root)
        - (6.0 * z4 + 14.0 * z2 - 32.0) / (405.0 * degrees)
        + (9.0 * z5 + 256.0 * z3 - 433.0 * z) / (4860.0 * root * degrees)
}

/// Equivalent degrees of freedom of one estimate over `samples` interval means in a row.
///
/// For α = 2…−2 (hdev …−4). Exact for interval means, within 1.5 % where the covariance is
/// summed over at most 32 starts per τ (tested against tr²G/tr G² of dense matrices). `None`
/// where no formula is known: for totdev where α > 0.
pub fn equivalent_degrees(kind: Deviation, alpha: i8, m: usize, samples: usize) -> Option<f64> {
    let (n, factor) = (samples as f64, m as f64);
    match kind {
        Deviation::Totdev => match alpha {
            0 => Some(1.5 * n / factor),
            -1 => Some(1.168 * n / factor - 0.222),
            -2 => Some(0.927 * n / factor - 0.358),
            // No source has constants for noise of the phase, and the reflected terms repeat one
            // another: what the terms inside the record give covers from 18 to 90 %.
            _ => None,
        },
        Deviation::Theo1 => theo1_degrees(alpha, m, samples),
        _ => Some(difference_degrees(kind, alpha, m, samples)),
    }
}

/// edf of Thêo1, by the fits of `[SP1065]` to simulated noise; r = 0.75·m.
fn theo1_degrees(alpha: i8, m: usize, samples: usize) -> Option<f64> {
    let points = samples as f64 + 1.0;
    let r = 0.75 * m as f64;
    let edf = match alpha {
        2 => 0.86 * (points + 1.0) * (points - 4.0 * r / 3.0) / (points - r) * (r / (r + 1.14)),
        1 => {
            (4.798 * points * points - 6.374 * points * r + 12.387 * r)
                / ((r + 36.6).sqrt() * (points - r))
                * (r / (r + 0.3))
        }
        0 => {
            let root = r.powf(1.5);
            ((4.1 * points + 0.8) / r - (3.1 * points + 6.5) / points) * (root / (root + 5.2))
        }
        -1 => {
            let cube = r.powi(3);
            (2.0 * points * points - 1.3 * points * r - 3.5 * r) / (points * r)
                * (cube / (cube + 2.3))
        }
        -2 => {
            let w = 4.4 * points;
            (w - 2.0) / (2.9 * r) * ((w - 1.0).powi(2) - 8.6 * r * (w - 1.0) + 11.4 * r * r)
                / (w - 3.0).powi(2)
        }
        _ => return None,
    };
    // The fits leave the range of meaning where m nears the length of the record.
    edf.is_finite().then_some(edf.max(1.0))
}

/// How a deviation differences the phase.
struct Shape {
    /// Phase differences per term.
    order: usize,
    /// Starts per τ.
    starts: usize,
    /// Averages of the phase per τ; m means single points.
    filter: f64,
    /// Whether the term is a mean over m differences.
    averaged: bool,
}

/// edf of the Allan and Hadamard families.
fn difference_degrees(kind: Deviation, alpha: i8, m: usize, samples: usize) -> f64 {
    let shape = Shape {
        order: if kind == Deviation::Hdev { 3 } else { 2 },
        starts: if kind == Deviation::Adev { 1 } else { m },
        filter: if kind.is_modified() { 1.0 } else { m as f64 },
        averaged: kind.is_modified(),
    };
    let covariance = Covariance::new(alpha, m, &shape);
    let starts = covariance.starts(&shape);
    let factor = m as f64;
    let s = starts as f64;
    let span = samples as f64 + 1.0 - factor / shape.filter - factor * shape.order as f64;
    let terms = (1.0 + (s * span / factor).floor()).max(1.0);
    let cut = terms.min(((shape.order + 1) * starts) as f64);
    let at_zero = covariance.of_terms(0.0).powi(2);
    let at_cut = (1.0 - cut / terms) * covariance.of_terms(cut / s).powi(2);
    let inner = sum_over_lags(&covariance, starts, terms, cut as usize);
    terms * at_zero / (at_zero + 2.0 * inner + at_cut)
}

/// The most starts per τ that are summed one by one.
const FINE_STARTS: usize = 2048;
/// Starts per τ that stand for all where the covariance has no finer structure.
const COARSE_STARTS: usize = 32;

/// Generalized autocovariance of the phase, at lags in units of τ.
struct Covariance {
    alpha: i8,
    /// Averaging factor; also F of the filtered form.
    m: usize,
    form: Form,
    order: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// Points of an integrated rate, α ≤ 0.
    Points,
    /// Averages over τ/F, α = 1, 2 and the modified deviations.
    Filtered { filter: f64 },
    /// Sum over the m points of a modified deviation's average, small m.
    Averaged,
}

impl Covariance {
    fn new(alpha: i8, m: usize, shape: &Shape) -> Self {
        let form = match (alpha > 0, shape.averaged) {
            (false, false) => Form::Points,
            (false, true) if m < 8 => Form::Averaged,
            _ => Form::Filtered {
                filter: shape.filter,
            },
        };
        Self {
            alpha,
            m,
            form,
            order: shape.order,
        }
    }

    /// Starts per τ of the sum, at most those that the covariance needs.
    fn starts(&self, shape: &Shape) -> usize {
        match self.form {
            _ if self.alpha <= 0 => shape.starts.min(COARSE_STARTS),
            // Averaged over a whole τ the covariance is as smooth for phase noise.
            Form::Filtered { filter: 1.0 } => shape.starts.min(FINE_STARTS),
            _ => shape.starts,
        }
    }

    /// s_w(t) of the exponent α, up to a positive factor.
    fn integrated(alpha: i8, t: f64) -> f64 {
        let t = t.abs();
        if t == 0.0 {
            return 0.0;
        }
        match alpha {
            2 => -t,
            1 => t * t * t.ln(),
            0 => t.powi(3),
            -1 => -t.powi(4) * t.ln(),
            _ => -t.powi(5),
        }
    }

    /// s_x(t), the phase.
    fn of_phase(&self, t: f64) -> f64 {
        match self.form {
            Form::Points => Self::integrated(self.alpha + 2, t),
            Form::Filtered { filter } => {
                let step = 1.0 / filter;
                if self.alpha == 1 && t.abs() * filter > 100.0 {
                    // −s″ and its next term: the difference itself would cancel.
                    return -2.0 * t.abs().ln() - 3.0 + (step / t).powi(2) / 6.0;
                }
                let s = |t| Self::integrated(self.alpha, t);
                filter * filter * (2.0 * s(t) - s(t - step) - s(t + step))
            }
            Form::Averaged => {
                let m = self.m as i32;
                (1 - m..m)
                    .map(|l| {
                        let weight = f64::from(m - l.abs()) / f64::from(m * m);
                        weight * Self::integrated(self.alpha + 2, t + f64::from(l) / f64::from(m))
                    })
                    .sum()
            }
        }
    }

    /// s_z(t), the differences whose squares a deviation averages.
    fn of_terms(&self, t: f64) -> f64 {
        let s = |shift: f64| self.of_phase(t + shift) + self.of_phase(t - shift);
        if self.order == 2 {
            6.0 * self.of_phase(t) - 4.0 * s(1.0) + s(2.0)
        } else {
            20.0 * self.of_phase(t) - 15.0 * s(1.0) + 6.0 * s(2.0) - s(3.0)
        }
    }
}

/// Σ_{j=1}^{J−1} (1 − j/M) s_z(j/S)².
fn sum_over_lags(covariance: &Covariance, starts: usize, terms: f64, cut: usize) -> f64 {
    let s = starts as f64;
    let term = |j: f64| (1.0 - j / terms) * covariance.of_terms(j / s).powi(2);
    if starts <= FINE_STARTS {
        return (1..cut).map(|j| term(j as f64)).sum();
    }
    if covariance.alpha == 2 {
        // Phase samples are independent: only whole multiples of τ correlate.
        return (1..=covariance.order)
            .map(|k| k * starts)
            .filter(|&j| j < cut)
            .map(|j| term(j as f64))
            .sum();
    }
    // Flicker of phase: logarithmic peaks one start wide at whole multiples of τ. Summed one
    // by one beside a peak, by quadrature on blocks that double away from it.
    (0..=covariance.order)
        .map(|k| {
            let (low, high) = ((k * starts).max(1), ((k + 1) * starts).min(cut));
            if low >= high {
                return 0.0;
            }
            let middle = (k * starts + starts / 2).min(high);
            let upward = sum_away_from(low, middle, |offset| term(low as f64 + offset));
            let downward = sum_away_from(middle, high, |offset| term((high - 1) as f64 - offset));
            upward + downward
        })
        .sum()
}

/// Σ_{offset=0}^{high−low−1} f(offset) for f that varies on the scale of its own argument.
fn sum_away_from(low: usize, high: usize, f: impl Fn(f64) -> f64) -> f64 {
    const SINGLE: usize = 256;
    /// Nodes and weights of Gauss's rule of six points on −1…1.
    const GAUSS: [(f64, f64); 3] = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];
    let count = high.saturating_sub(low);
    let mut total: f64 = (0..count.min(SINGLE)).map(|k| f(k as f64)).sum();
    let mut start = SINGLE;
    while start < count {
        let end = (2 * start).min(count);
        // The midpoint rule's end correction: Σ over whole numbers ≈ ∫ from half before.
        let center = (start + end) as f64 / 2.0 - 0.5;
        let half = (end - start) as f64 / 2.0;
        for (node, weight) in GAUSS {
            total += half * weight * (f(center - half * node) + f(center + half * node));
        }
        start = end;
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2E²/Var = (tr G)²/tr G² with G the covariance of the differences, written out.
    ///
    /// `alpha` 2: white phase; 0: white rate; −2: interval means of a random walk of the rate,
    /// whose increments have the covariance of the product of two integrated Brownian motions;
    /// −1: first differences of flicker means have covariance δ⁴[k² ln|k|] (a generalized
    /// covariance k² ln|k| of the phase's second integral: differences see nothing else).
    fn dense_degrees(kind: Deviation, alpha: i8, m: usize, samples: usize) -> f64 {
        let phase_covariance = |k: f64| -> f64 {
            let k = k.abs();
            match alpha {
                2 => f64::from(u8::from(k == 0.0)),
                0 => -k,
                -1 if k == 0.0 => 0.0,
                -1 => k * k * k.ln(),
                _ => k.powi(3),
            }
        };
        let coefficients: Vec<f64> = if kind == Deviation::Hdev {
            vec![-1.0, 3.0, -3.0, 1.0]
        } else {
            vec![1.0, -2.0, 1.0]
        };
        let (average, stride) = match kind {
            Deviation::Mdev => (m, 1),
            Deviation::Adev => (1, m),
            _ => (1, 1),
        };
        let term = |lag: usize| -> f64 {
            let mut total = 0.0;
            for (a, ca) in coefficients.iter().enumerate() {
                for (b, cb) in coefficients.iter().enumerate() {
                    for p in 0..average {
                        for q in 0..average {
                            let shift = (lag + a * m + p) as f64 - (b * m + q) as f64;
                            total += ca * cb * phase_covariance(shift);
                        }
                    }
                }
            }
            total
        };
        let terms = kind.terms(samples, m) as usize;
        let row: Vec<f64> = (0..terms).map(|k| term(k * stride)).collect();
        let squares: f64 = (0..terms)
            .map(|k| {
                let times = if k == 0 { terms } else { 2 * (terms - k) };
                times as f64 * row[k] * row[k]
            })
            .sum();
        (terms as f64 * row[0]).powi(2) / squares
    }

    #[test]
    fn degrees_are_those_of_dense_covariance_matrices() {
        for kind in [Deviation::Oadev, Deviation::Adev, Deviation::Hdev] {
            for alpha in [2, 0, -1, -2] {
                for m in [1, 2, 3, 4, 8, 16, 31, 50, 100, 130] {
                    let want = dense_degrees(kind, alpha, m, 400);
                    let got = equivalent_degrees(kind, alpha, m, 400).expect("a formula");
                    // Rounding; 32 starts per τ stand for all above m = 32 (1.5 %), flicker of
                    // interval means has no closed covariance (0.8 %).
                    let tolerance = match (alpha, m) {
                        (-1, _) => 0.016,
                        (2, _) => 1e-9,
                        (_, ..=32) => 1e-7,
                        _ => 0.016,
                    };
                    assert!(
                        (got / want - 1.0).abs() < tolerance,
                        "{kind:?} alpha {alpha} m {m}: {got} for {want}"
                    );
                }
            }
        }
    }

    #[test]
    fn degrees_of_the_modified_deviation() {
        for alpha in [2, 0, -1, -2] {
            for m in [1, 2, 3, 5, 7, 8, 12, 30, 60] {
                let want = dense_degrees(Deviation::Mdev, alpha, m, 400);
                let got = equivalent_degrees(Deviation::Mdev, alpha, m, 400).expect("a formula");
                // From m = 8 on the average is taken as continuous: 1 %, phase noise more.
                let tolerance = if m < 8 && alpha <= 0 { 0.009 } else { 0.05 };
                assert!(
                    (got / want - 1.0).abs() < tolerance,
                    "alpha {alpha} m {m}: {got} for {want}"
                );
            }
        }
    }

    #[test]
    fn totdev_has_degrees_for_noise_of_the_rate_alone() {
        for m in [1, 8, 200, 399] {
            let degrees = |alpha| equivalent_degrees(Deviation::Totdev, alpha, m, 400);
            for alpha in [0, -1, -2] {
                assert!(degrees(alpha).is_some_and(|edf| edf > 0.0), "{alpha} {m}");
            }
            assert_eq!((degrees(1), degrees(2)), (None, None), "{m}");
        }
    }

    #[test]
    fn long_sums_agree_with_those_one_by_one() {
        for alpha in [1, 2] {
            for (m, samples) in [(3000, 20_000), (3000, 7000), (5000, 1_000_000)] {
                let shape = Shape {
                    order: 2,
                    starts: m,
                    filter: m as f64,
                    averaged: false,
                };
                let covariance = Covariance::new(alpha, m, &shape);
                let terms = (samples - 2 * m + 1) as f64;
                let cut = (3 * m).min(terms as usize);
                let term = |j: usize| {
                    (1.0 - j as f64 / terms) * covariance.of_terms(j as f64 / m as f64).powi(2)
                };
                let want: f64 = (1..cut).map(term).sum();
                let got = sum_over_lags(&covariance, m, terms, cut);
                // 1 % of an edf moves no printed digit of an interval.
                let scale = want + covariance.of_terms(0.0).powi(2);
                assert!(
                    (got - want).abs() < 2e-3 * scale,
                    "{alpha} {m}: {got} {want}"
                );
            }
        }
    }

    #[test]
    fn chi_squared_quantiles_are_those_of_tables() {
        // scipy.stats.chi2.ppf 1.17.
        for (probability, degrees, want) in CHI_SQUARED {
            let got = chi_squared_quantile(probability, degrees);
            assert!(
                (got / want - 1.0).abs() < 1e-9,
                "{probability} {degrees}: {got} {want}"
            );
        }
    }

    const CHI_SQUARED: [(f64, f64, f64); 26] = [
        (0.025, 0.5, 5.273202591259991e-07),
        (0.975, 0.5, 3.433235299960771),
        (0.025, 1.0, 0.0009820691171752555),
        (0.975, 1.0, 5.023886187314888),
        (0.025, 1.7, 0.024578860686948416),
        (0.975, 1.7, 6.729887825681821),
        (0.025, 2.0, 0.05063561596857975),
        (0.975, 2.0, 7.377758908227871),
        (0.025, 5.0, 0.8312116134866625),
        (0.975, 5.0, 12.832501994030027),
        (0.025, 10.3, 3.415421685869906),
        (0.975, 10.3, 20.916545063158285),
        (0.025, 30.0, 16.79077226556663),
        (0.975, 30.0, 46.97924224367115),
        (0.025, 100.0, 74.22192747492373),
        (0.975, 100.0, 129.5611971858366),
        (0.025, 999.5, 913.7790733081248),
        (0.975, 999.5, 1089.0089929931223),
        (0.025, 1999.0, 1876.9770330918507),
        (0.975, 1999.0, 2124.81130603695),
        (0.025, 2001.0, 1878.9150482883376),
        (0.975, 2001.0, 2126.873291113057),
        (0.025, 50000.0, 49382.10144327502),
        (0.975, 50000.0, 50621.68715758982),
        (0.025, 10000000.0, 9991236.669053895),
        (0.975, 10000000.0, 10008767.119557811),
    ];
}
