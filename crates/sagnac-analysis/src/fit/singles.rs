//! Intervals and limits of Q, N, B and K, wide enough for what may be there and is not named.
//!
//! What is not named is zero for the values of the others, and its power is in them; an interval given only the named terms
//! would then hold too rarely. Where it matters it reaches over the fits with what is possible and without. Source: the
//! coverage of `FIDELITY.md`.

use super::cumulant;
use super::likelihood::{B, Free, K, N, Problem, Q, Solution};
use super::profile::{self, INTERVAL, LIMIT, Side};
use super::results::{Units, interval, widened};
use super::select::{self, Tests};
use super::types::Estimate;

/// Likelihood ratio below which a detected K is weak: its interval allows for an undetected B.
const WEAK_RATIO: f64 = 20.0;

/// Level of N's profile with a free Q whose best value is zero.
const BESIDE_NONE: f64 = 2.0;

/// Growth of the variance of N by a term beside it from which its interval allows for the term.
const MATTERS: f64 = 1.1;

/// A fit whose terms were tested.
pub(super) struct Tested<'a> {
    pub problem: &'a Problem,
    pub tests: &'a Tests,
    pub best: &'a Solution,
    pub free: &'a Free,
    /// Indices and covariance of the free parameters.
    pub covariance: Option<&'a (Vec<usize>, Vec<f64>)>,
    /// The fit with the other of two rivals that are not told apart.
    pub alternative: Option<&'a (Solution, Free)>,
    pub units: &'a Units,
}

impl Tested<'_> {
    /// Q, N, B and K where they are `allowed`: limits of what is not named or only `bounded`. `quantization` is the
    /// exponent that narrows the interval of a Q that is rounding.
    pub(super) fn singles(
        &self,
        allowed: [bool; 4],
        bounded: [bool; 4],
        quantization: f64,
    ) -> [Estimate; 4] {
        let mut out = [Estimate::ABSENT; 4];
        for k in (0..4).filter(|&k| allowed[k]) {
            let is_named = self.tests.passed[k] && !bounded[k] && !self.tests.is_confused(k);
            out[k] = if is_named && self.best.parameters[k] > 0.0 {
                let own = interval(
                    self.problem,
                    self.best,
                    self.free,
                    k,
                    self.covariance,
                    |v| self.units.root(k, v),
                );
                let own = self.with_either(self.beside_unnamed(k, own), k);
                match k {
                    Q => cumulant::narrowed(own, quantization),
                    N => self.beside_quantization(self.beside_flicker(own)),
                    _ => own,
                }
            } else {
                Estimate::limit(self.units.root(k, self.limit(k)))
            };
        }
        out
    }

    /// The interval of a term in this fit.
    fn in_fit(&self, fit: &Solution, free: &Free, index: usize) -> Estimate {
        interval(self.problem, fit, free, index, None, |v| {
            self.units.root(index, v)
        })
    }

    /// The intervals of the other terms hold with either of two rivals.
    fn with_either(&self, own: Estimate, k: usize) -> Estimate {
        match self.alternative {
            Some((fit, free)) if free[k] && fit.parameters[k] > 0.0 => {
                widened(own, &self.in_fit(fit, free, k))
            }
            _ => own,
        }
    }

    /// The interval of B or K beside the other of the two, where that is not named: wide enough for it in the fit and at zero.
    ///
    /// What passes carries the power of what does not: given only the detected terms, intervals of B beside a K too weak to be
    /// named would cover in four of five logs. A clear K leaves an unnamed B little.
    fn beside_unnamed(&self, index: usize, own: Estimate) -> Estimate {
        let other = match index {
            B => K,
            K => B,
            _ => return own,
        };
        if !self.tests.full_free[other] || self.tests.passed[other] || self.tests.confused {
            return own;
        }
        let widened_by = |fit: &Solution, free: &Free| widened(own, &self.in_fit(fit, free, index));
        if self.free[other] {
            let mut without = *self.free;
            without[other] = false;
            return widened_by(
                &select::final_fit(self.problem, self.best, &without),
                &without,
            );
        }
        let is_weak = index == B || self.tests.ratios[index] < WEAK_RATIO;
        if is_weak && self.tests.full.parameters[other] > 0.0 {
            return widened_by(&self.tests.full, &self.tests.full_free);
        }
        own
    }

    /// The interval of N, wide enough for flicker that is possible but was taken as zero, where that makes N less certain.
    fn beside_flicker(&self, own: Estimate) -> Estimate {
        let Some(with) = self.tests.with_possible_flicker(self.free) else {
            return own;
        };
        let mut start = self.best.clone();
        start.parameters[B] = self.tests.full.parameters[B];
        let fit = self.problem.fit(&start.parameters, &with);
        let spread = |solution: &Solution, free: &Free| {
            let (indices, m) = profile::covariance(self.problem, solution, free)?;
            let place = indices.iter().position(|&i| i == N)?;
            Some(m[place * indices.len() + place])
        };
        match (spread(&fit, &with), spread(self.best, self.free)) {
            (Some(wide), Some(narrow)) if wide > MATTERS * narrow && fit.parameters[B] > 0.0 => {
                let other = self.in_fit(&fit, &with, N);
                widened(own, &other)
            }
            _ => own,
        }
    }

    /// The interval of N, wide enough for quantization noise that is possible but was taken as zero.
    ///
    /// Q is not named below a ratio of 12, and what of it is there N takes up: up to three times N's own standard deviation.
    /// So the lower end is that of the profile with Q free, where the best Q is zero at a lower level: N scatters independently
    /// of a Q that is not there, and with `INTERVAL` on both sides its intervals would hold in more than 97.5 % without Q.
    fn beside_quantization(&self, own: Estimate) -> Estimate {
        if self.free[Q] || !self.tests.full_free[Q] {
            return own;
        }
        let mut with = self
            .tests
            .with_possible_flicker(self.free)
            .unwrap_or(*self.free);
        with[Q] = true;
        let mut start = self.best.clone();
        for k in [Q, B] {
            if with[k] && !self.free[k] {
                start.parameters[k] = self.tests.full.parameters[k];
            }
        }
        let fit = self.problem.fit(&start.parameters, &with);
        let level = if fit.parameters[Q] > 0.0 {
            INTERVAL
        } else {
            BESIDE_NONE
        };
        let lower = self.units.root(
            N,
            profile::bound(self.problem, &fit, &with, N, Side::Lower, level),
        );
        Estimate {
            lower: own.lower.map(|l| l.min(lower)),
            ..own
        }
    }

    /// Profile limit of a variance with every candidate free; of a term with a rival the larger of those with and without it.
    fn limit(&self, index: usize) -> f64 {
        let level = if index == B || index == K {
            INTERVAL
        } else {
            LIMIT
        };
        let of = |solution: &Solution, free: &Free| {
            profile::bound(self.problem, solution, free, index, Side::Upper, level)
        };
        let both = of(&self.tests.full, &self.tests.full_free);
        if !self.tests.rivaled[index] {
            return both;
        }
        let alone = self.tests.without_rival(&self.tests.full_free);
        let fit = select::final_fit(self.problem, &self.tests.full, &alone);
        both.max(of(&fit, &alone))
    }
}
