//! How well a log of a given length can know each term, and how long it must be: the Cramér–Rao bound.
//!
//! J_ab = ½ Σ_j ∂ln S(f_j)/∂ln θ_a · ∂ln S(f_j)/∂ln θ_b over f_j = j/(2n·dt), j = 1…n−1, S the exact spectrum of interval
//! means; relative σ of θ_a = √(J⁻¹)_aa with every term of the mixture and the mean unknown. Source: \[Whittle1953\].

use crate::fit::NoiseTerms;
use crate::fit::internal::{BinnedLog, Problem, inverse, line_information};

/// Relative standard deviations of the terms of a mixture; none where a term is zero or the bound is above 100 %.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Precision {
    /// Of Q.
    pub quantization: Option<f64>,
    /// Of N.
    pub white: Option<f64>,
    /// Of B.
    pub flicker: Option<f64>,
    /// Of K.
    pub random_walk: Option<f64>,
    /// Of R.
    pub ramp: Option<f64>,
    /// Of σ and T_c of each Gauss–Markov term, in the order of the mixture.
    pub gauss_markov: Vec<(Option<f64>, Option<f64>)>,
}

/// A number of a mixture that a precision can be asked of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlannedTerm {
    /// Q.
    Quantization,
    /// N.
    White,
    /// B.
    Flicker,
    /// K.
    RandomWalk,
    /// R.
    Ramp,
    /// σ of a Gauss–Markov term, from 0.
    Sigma(usize),
    /// T_c of a Gauss–Markov term, from 0.
    CorrelationTime(usize),
}

impl Precision {
    /// The relative standard deviation of one number.
    pub fn of(&self, term: PlannedTerm) -> Option<f64> {
        match term {
            PlannedTerm::Quantization => self.quantization,
            PlannedTerm::White => self.white,
            PlannedTerm::Flicker => self.flicker,
            PlannedTerm::RandomWalk => self.random_walk,
            PlannedTerm::Ramp => self.ramp,
            PlannedTerm::Sigma(i) => self.gauss_markov.get(i).and_then(|g| g.0),
            PlannedTerm::CorrelationTime(i) => self.gauss_markov.get(i).and_then(|g| g.1),
        }
    }
}

/// A log of more samples than this is planned as one of so many.
pub const MOST_SAMPLES: f64 = 1e18;

/// The bound for a log of `duration_s` at `step_s`, all terms of `terms` that are not zero unknown.
///
/// Agrees with the scatter of [`crate::fit::estimate`] within 10 % wherever a term stands clear.
///
/// ```
/// use sagnac_analysis::{fit::NoiseTerms, plan::precision};
/// let white = NoiseTerms { white: 1e-4, ..NoiseTerms::default() };
/// // σ_N/N = 1/√(2n)
/// let n = precision(&white, 3600.0, 0.01).white.unwrap();
/// assert!((n * (2.0 * 360_000.0_f64).sqrt() - 1.0).abs() < 1e-4);
/// ```
pub fn precision(terms: &NoiseTerms, duration_s: f64, step_s: f64) -> Precision {
    let n = (duration_s / step_s).round().clamp(4.0, MOST_SAMPLES) as usize;
    let log = BinnedLog::empty(n);
    let problem = Problem::new(&[&log], false);
    let mut build = Columns {
        spectrum: vec![0.0; problem.u.len()],
        columns: Vec::new(),
    };
    // Variance parameters per sample, as in the fit.
    let values = [
        (terms.quantization / step_s).powi(2),
        terms.white.powi(2) / step_s,
        terms.flicker.powi(2),
        terms.random_walk.powi(2) * step_s,
    ];
    let single = [0, 1, 2, 3].map(|k| {
        (values[k] > 0.0).then(|| {
            let column: Vec<f64> = problem.basis(k).iter().map(|phi| values[k] * phi).collect();
            build.add(&column)
        })
    });
    let markov: Vec<Option<usize>> = terms
        .gauss_markov
        .iter()
        .map(|&(sigma, time)| {
            (sigma > 0.0 && time > 0.0).then(|| {
                let log_time = (time / step_s).ln();
                let shape = problem.gauss_markov_basis(log_time);
                let after = problem.gauss_markov_basis(log_time + 1e-4);
                let v = sigma * sigma;
                let column: Vec<f64> = shape.iter().map(|phi| v * phi).collect();
                let place = build.add(&column);
                build.columns.push(
                    shape
                        .iter()
                        .zip(&after)
                        .map(|(a, b)| v * (b - a) / 1e-4)
                        .collect(),
                );
                place
            })
        })
        .collect();
    let k = build.columns.len();
    let mut information = vec![0.0; k * k];
    for p in 0..k {
        for q in 0..=p {
            let sum: f64 = (0..problem.u.len())
                .map(|b| {
                    0.5 * problem.count[b] * build.columns[p][b] * build.columns[q][b]
                        / (build.spectrum[b] * build.spectrum[b])
                })
                .sum();
            information[p * k + q] = sum;
            information[q * k + p] = sum;
        }
    }
    let covariance = inverse(&information, k);
    let at = |place: Option<usize>| {
        let (place, matrix) = (place?, covariance.as_ref()?);
        let sigma = matrix[place * k + place].sqrt();
        (sigma <= 1.0).then_some(sigma)
    };
    let ramp = if terms.ramp == 0.0 || k == 0 {
        None
    } else {
        // The line's coefficients against the spectrum; its slope is per sample.
        let information = line_information(&log, n, &build.spectrum);
        let relative = 1.0 / (information.sqrt() * terms.ramp.abs() * step_s);
        (relative <= 1.0).then_some(relative)
    };
    Precision {
        quantization: at(single[0]),
        white: at(single[1]),
        flicker: at(single[2]),
        random_walk: at(single[3]),
        ramp,
        gauss_markov: markov
            .iter()
            .map(|&place| (at(place), at(place.map(|p| p + 1))))
            .collect(),
    }
}

struct Columns {
    spectrum: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Columns {
    /// Adds a term's share of the spectrum; ∂S/∂ln θ is twice that.
    fn add(&mut self, column: &[f64]) -> usize {
        for (s, c) in self.spectrum.iter_mut().zip(column) {
            *s += c;
        }
        self.columns.push(column.iter().map(|c| 2.0 * c).collect());
        self.columns.len() - 1
    }
}

/// The shortest duration \[s\], to 1 %, at which every wanted precision is reached; none where a year does not do.
pub fn duration_for(terms: &NoiseTerms, step_s: f64, wanted: &[(PlannedTerm, f64)]) -> Option<f64> {
    const YEAR_S: f64 = 365.25 * 86_400.0;
    let reached = |duration: f64| {
        let p = precision(terms, duration, step_s);
        wanted
            .iter()
            .all(|&(term, limit)| p.of(term).is_some_and(|v| v <= limit))
    };
    let mut low = 4.0 * step_s;
    let mut high = (64.0 * step_s).max(1.0);
    while !reached(high) {
        low = high;
        high *= 2.0;
        if high > YEAR_S {
            return None;
        }
    }
    while high / low > 1.003 {
        let middle = (low * high).sqrt();
        if reached(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// Standard error [unit] of the mean of a log of this length.
pub fn mean_error(terms: &NoiseTerms, duration_s: f64, step_s: f64) -> f64 {
    terms.mean_variance(duration_s, step_s).sqrt()
}

/// The length \[s\] from which on doubling the time never betters the mean's error by 10 %; none within ten years.
///
/// A Gauss–Markov process holds the error up for about its correlation time and then lets it fall on: such a plateau is
/// not the end.
pub fn mean_saturates(terms: &NoiseTerms, step_s: f64) -> Option<f64> {
    let most = 10.0 * 365.25 * 86_400.0_f64;
    let mut end = None;
    let mut steps = ((most / step_s).ln() / 1.02_f64.ln()).ceil();
    while steps >= 0.0 {
        let duration = step_s * 1.02_f64.powf(steps);
        let gain = mean_error(terms, 2.0 * duration, step_s) / mean_error(terms, duration, step_s);
        if gain <= 0.9 {
            break;
        }
        end = Some(duration);
        steps -= 1.0;
    }
    end
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn terms(n: f64, b: f64, k: f64) -> NoiseTerms {
        NoiseTerms {
            white: n,
            flicker: b,
            random_walk: k,
            ..NoiseTerms::default()
        }
    }

    #[test]
    fn bounds_are_the_tabulated_ones() {
        // Consumer MEMS, 100 Hz: N 0.3 °/√h, B 8 °/h, K 30 °/h/√h, Q 20″, σ 10 °/h, T_c 300 s.
        let degree = std::f64::consts::PI / 180.0;
        let mems = NoiseTerms {
            quantization: 20.0 / 3600.0 * degree,
            white: 0.3 * degree / 60.0,
            flicker: 8.0 * degree / 3600.0,
            random_walk: 30.0 * degree / 3600.0 / 60.0,
            ..NoiseTerms::default()
        };
        let hour = precision(&mems, 3600.0, 0.01);
        for (got, want) in [
            (hour.quantization, 0.0012),
            (hour.white, 0.010),
            (hour.flicker, 0.063),
            (hour.random_walk, 0.41),
        ] {
            let got = got.unwrap();
            assert!((got / want - 1.0).abs() < 0.05, "{got} {want}");
        }
        let day = precision(&mems, 12.0 * 3600.0, 0.01);
        assert!((day.random_walk.unwrap() / 0.11 - 1.0).abs() < 0.05);
        let markov = NoiseTerms {
            quantization: 0.0,
            flicker: 0.0,
            random_walk: 0.0,
            gauss_markov: vec![(10.0 * degree / 3600.0, 300.0)],
            ..mems
        };
        let p = precision(&markov, 4.0 * 3600.0, 0.01);
        assert!((p.gauss_markov[0].0.unwrap() / 0.11 - 1.0).abs() < 0.05);
        assert!((p.gauss_markov[0].1.unwrap() / 0.24 - 1.0).abs() < 0.05);
    }

    #[test]
    fn rules_of_thumb_hold() {
        let p = precision(&terms(1.0, 0.3, 0.0), 3600.0, 0.02);
        assert!((p.flicker.unwrap() / 0.0706 - 1.0).abs() < 0.01);
        let p = precision(&terms(1.0, 0.0, 0.03), 3600.0, 0.02);
        assert!((p.random_walk.unwrap() / 0.137 - 1.0).abs() < 0.01);
        let ramp = NoiseTerms {
            ramp: 1e-3,
            ..terms(1.0, 0.0, 0.0)
        };
        let want = 12f64.sqrt() / (1e-3 * 3600f64.powf(1.5));
        assert!((precision(&ramp, 3600.0, 0.02).ramp.unwrap() / want - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_shortest_duration_just_reaches() {
        let t = terms(1.0, 0.3, 0.0);
        let d = duration_for(&t, 0.02, &[(PlannedTerm::Flicker, 0.05)]).unwrap();
        assert!(precision(&t, d, 0.02).flicker.unwrap() <= 0.05);
        assert!(precision(&t, 0.99 * d, 0.02).flicker.unwrap() > 0.05);
    }

    #[test]
    fn a_plateau_of_a_gauss_markov_process_is_not_the_end() {
        let markov = NoiseTerms {
            gauss_markov: vec![(4.0, 30.0)],
            ..terms(1.0, 0.0, 0.0)
        };
        // The mean falls as 1/√T for good once T is many correlation times.
        assert_eq!(mean_saturates(&markov, 0.04), None);
        let with_walk = NoiseTerms {
            random_walk: 1e-3,
            ..markov
        };
        let end = mean_saturates(&with_walk, 0.04).unwrap();
        let gain = |d: f64| mean_error(&with_walk, 2.0 * d, 0.04) / mean_error(&with_walk, d, 0.04);
        assert!(end > 3600.0, "{end}");
        assert!(gain(end) > 0.9 && gain(end / 1.03) <= 0.9);
        assert!((1..40).all(|k| gain(end * 1.5_f64.powi(k)) > 0.9));
    }

    #[test]
    fn a_very_high_rate_helps_white_noise_alone() {
        for (t, duration) in [
            (terms(1.0, 0.3, 0.0), 3600.0),
            (terms(1.0, 0.3, 0.03), 86_400.0),
        ] {
            let (slow, fast) = (precision(&t, duration, 5e-4), precision(&t, duration, 1e-9));
            let same =
                |a: Option<f64>, b: Option<f64>| (a.unwrap() / b.unwrap() - 1.0).abs() < 0.02;
            assert!(same(slow.flicker, fast.flicker), "{slow:?} {fast:?}");
            assert!(t.random_walk == 0.0 || same(slow.random_walk, fast.random_walk));
            let most = (duration * 1e9 * 2.0).sqrt();
            assert!((fast.white.unwrap() * most - 1.0).abs() < 0.05, "{fast:?}");
        }
        let markov = NoiseTerms {
            gauss_markov: vec![(1.0, 30.0)],
            ..terms(1.0, 0.0, 0.0)
        };
        let (slow, fast) = (
            precision(&markov, 7200.0, 5e-4),
            precision(&markov, 7200.0, 1e-9),
        );
        for (a, b) in [
            (slow.gauss_markov[0].0, fast.gauss_markov[0].0),
            (slow.gauss_markov[0].1, fast.gauss_markov[0].1),
        ] {
            assert!(
                (a.unwrap() / b.unwrap() - 1.0).abs() < 0.02,
                "{slow:?} {fast:?}"
            );
        }
    }

    #[test]
    fn unobservable_terms_have_no_number() {
        assert_eq!(precision(&terms(1.0, 0.01, 0.0), 60.0, 0.01).flicker, None);
        assert_eq!(
            precision(&terms(0.0, 0.0, 0.0), 60.0, 0.01),
            Precision::default()
        );
    }
}
