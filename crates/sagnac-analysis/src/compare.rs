//! Whether a measured term is as a reference says: ratio with interval, and a verdict in one word.
//!
//! ratio = measured/reference; half widths of measured interval and reference in quadrature. Within 4 % of √2 or 1/√2
//! white noise is unclear: one of the two densities may be one-sided.

use crate::fit::{AxisEstimate, Estimate, Status, Term};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// The verdict on one term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As the reference says.
    Within,
    /// The whole interval lies below 0.8.
    Better,
    /// The whole interval lies above 1.25.
    Worse,
    /// A factor √2 off (white noise), or only bounded above 0.8.
    Unclear,
}

impl Verdict {
    /// The word used in JSON and tables.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Within => "within",
            Verdict::Better => "better",
            Verdict::Worse => "worse",
            Verdict::Unclear => "unclear",
        }
    }
}

/// Ratio of a measured term to its reference, with the verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// measured/reference with its 95 % interval; an upper limit where the measured one is.
    pub ratio: Estimate,
    /// The verdict.
    pub verdict: Verdict,
}

/// Compares a measured term with `reference` (same unit, > 0); none where the measured one is absent.
///
/// ```
/// use sagnac_analysis::{compare::{compare, Verdict}, fit::{Estimate, Term}};
/// let measured = Estimate::detected(0.352, 0.348, 0.356, 0.002);
/// let c = compare(Term::White, &measured, 0.34, None).unwrap();
/// assert_eq!(c.verdict, Verdict::Within);
/// ```
pub fn compare(
    term: Term,
    measured: &Estimate,
    reference: f64,
    reference_sigma: Option<f64>,
) -> Option<Comparison> {
    if reference <= 0.0 || !reference.is_finite() {
        return None;
    }
    match measured.status {
        Status::Absent => None,
        Status::UpperLimit => {
            let upper = measured.upper? / reference;
            Some(Comparison {
                ratio: Estimate::limit(upper),
                verdict: if upper < 0.8 {
                    Verdict::Better
                } else {
                    Verdict::Unclear
                },
            })
        }
        Status::Detected => {
            let value = measured.value?;
            let ratio = value / reference;
            let spread = reference_sigma.unwrap_or(0.0) / reference;
            let side = |end: Option<f64>| {
                end.map_or(0.0, |end| {
                    let relative = (end - value) / value;
                    ratio * relative.hypot(1.96 * spread)
                })
            };
            let (lower, upper) = (
                (ratio - side(measured.lower)).max(0.0),
                ratio + side(measured.upper),
            );
            let sigma = measured.sigma.map_or((upper - lower) / 3.92, |s| {
                ratio * (s / value).hypot(spread)
            });
            let off = |factor: f64| (ratio / factor - 1.0).abs() <= 0.04;
            let verdict = if term == Term::White && (off(SQRT_2) || off(FRAC_1_SQRT_2)) {
                Verdict::Unclear
            } else if upper < 0.8 {
                Verdict::Better
            } else if lower > 1.25 {
                Verdict::Worse
            } else {
                Verdict::Within
            };
            Some(Comparison {
                ratio: Estimate::detected(ratio, lower, upper, sigma),
                verdict,
            })
        }
    }
}

/// A log that differs from the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlier {
    /// Index of the log.
    pub log: usize,
    /// The term that differs; none where the whole spectrum does.
    pub term: Option<Term>,
    /// How many times the median of the others, where a term differs.
    pub ratio: Option<f64>,
    /// Whether that median is of upper limits, so that the ratio is at least so large.
    pub is_bound: bool,
    /// Probability of its likelihood ratio against the pooled terms.
    pub p_value: Option<f64>,
}

/// What a log says of a term: a value with its σ towards smaller and larger values, or a bound.
///
/// The interval of a weak term is far from even: the σ of a side is the larger one of the estimate and of its end.
#[derive(Clone, Copy)]
struct Told {
    value: f64,
    sigma: Option<[f64; 2]>,
}

fn told(axis: &AxisEstimate, term: Term) -> Option<Told> {
    let of = |e: &Estimate| match e.status {
        Status::Absent => None,
        Status::UpperLimit => e.upper.map(|value| Told { value, sigma: None }),
        Status::Detected => e.value.zip(e.sigma).map(|(value, sigma)| {
            let side =
                |end: Option<f64>| end.map_or(sigma, |e| sigma.max((e - value).abs() / 1.96));
            Told {
                value,
                sigma: Some([side(e.lower), side(e.upper)]),
            }
        }),
    };
    if term == Term::GaussMarkov {
        // Of several processes the largest.
        let all = axis.gauss_markov.iter().filter_map(|g| of(&g.sigma));
        return all.max_by(|a, b| a.value.total_cmp(&b.value));
    }
    of(axis.term(term)?)
}

/// Sensors whose N, B, K or Gauss–Markov σ on one axis is off the median of at least three others by more than 5 of its
/// own standard deviations and more than 5 robust ones of theirs.
///
/// Where that median or more of the others have upper limits alone, what stands as far above these differs as well.
pub fn fleet_outliers(axes: &[Option<&AxisEstimate>]) -> Vec<Outlier> {
    let mut out = Vec::new();
    for term in [
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::GaussMarkov,
    ] {
        let values: Vec<Option<Told>> = axes
            .iter()
            .map(|axis| axis.and_then(|a| told(a, term)))
            .collect();
        for (log, own) in values.iter().enumerate() {
            let Some(Told {
                value,
                sigma: Some(sigma),
            }) = *own
            else {
                continue;
            };
            let others = values.iter().enumerate().filter(|(i, _)| *i != log);
            let others: Vec<Told> = others.filter_map(|(_, v)| *v).collect();
            // The distance from the median of some of the others, where it counts.
            let differs = |of: Vec<f64>| {
                let mut of = of;
                if of.len() < 3 {
                    return None;
                }
                let center = median(&mut of);
                let mut distances: Vec<f64> = of.iter().map(|o| (o - center).abs()).collect();
                let spread = 1.4826 * median(&mut distances);
                let off = value - center;
                let own = sigma[usize::from(off < 0.0)];
                (off.abs() > 5.0 * own && off.abs() > 5.0 * spread).then_some((off, center))
            };
            let known = others.iter().filter(|o| o.sigma.is_some());
            let among_known = differs(known.map(|o| o.value).collect());
            let above = differs(others.iter().map(|o| o.value).collect());
            let above = above.filter(|(off, _)| *off > 0.0);
            let bounds = others.iter().any(|o| o.sigma.is_none());
            let found = match (among_known, above) {
                (Some((_, center)), _) => Some((center, false)),
                (None, Some((_, center))) if bounds => Some((center, true)),
                _ => None,
            };
            if let Some((center, is_bound)) = found {
                out.push(Outlier {
                    log,
                    term: Some(term),
                    ratio: Some(value / center),
                    is_bound,
                    p_value: None,
                });
            }
        }
    }
    out
}

/// Of `suspects` the log whose spectrum is farthest from the others', by the median over them of its likelihood ratio
/// Σ n [r_o − r + ln(r/r_o)], r = measured/own fit, r_o = measured/fit of the other, over the bins of its spectrum.
///
/// The median holds while fewer than half of the logs differ, however far they do; pooled terms are drawn by one.
pub fn farthest(logs: &[(usize, &AxisEstimate)], suspects: &[usize]) -> Option<usize> {
    let ratio = |own: &AxisEstimate, other: &AxisEstimate| -> f64 {
        let bins = own.spectrum.iter().filter(|b| b.used);
        bins.map(|b| {
            let density = |e: &AxisEstimate| e.fitted.density(b.frequency_hz, own.step_s);
            let (mine, theirs) = (density(own), density(other));
            b.count * (b.measured / theirs - b.measured / mine + (theirs / mine).ln())
        })
        .sum()
    };
    let distance = |&(log, own): &(usize, &AxisEstimate)| -> Option<(usize, f64)> {
        let others = logs.iter().filter(|(other, _)| *other != log);
        let mut ratios: Vec<f64> = others.map(|(_, other)| ratio(own, other)).collect();
        ratios.sort_by(f64::total_cmp);
        // Of an even number the smaller: with three logs the two that agree have one near.
        let at = ratios.len().checked_sub(1)? / 2;
        Some((log, ratios[at]))
    };
    logs.iter()
        .filter(|(log, _)| suspects.contains(log))
        .filter_map(distance)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(log, _)| log)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn verdict(term: Term, value: f64, half: f64) -> Verdict {
        let e = Estimate::detected(value, value - half, value + half, half / 1.96);
        compare(term, &e, 1.0, None).unwrap().verdict
    }

    #[test]
    fn verdicts_follow_the_interval() {
        assert_eq!(verdict(Term::Flicker, 0.6, 0.1), Verdict::Better);
        assert_eq!(verdict(Term::Flicker, 0.75, 0.1), Verdict::Within);
        assert_eq!(verdict(Term::Flicker, 1.5, 0.1), Verdict::Worse);
        assert_eq!(verdict(Term::Flicker, 1.42, 0.01), Verdict::Worse);
        assert_eq!(verdict(Term::White, 1.42, 0.01), Verdict::Unclear);
        assert_eq!(verdict(Term::White, 0.73, 0.01), Verdict::Unclear);
        assert_eq!(verdict(Term::White, 1.35, 0.01), Verdict::Worse);
    }

    #[test]
    fn limits_are_better_or_unclear() {
        let at = |upper| compare(Term::RandomWalk, &Estimate::limit(upper), 1.0, None).unwrap();
        assert_eq!(at(0.5).verdict, Verdict::Better);
        assert_eq!(at(2.0).verdict, Verdict::Unclear);
        assert!(compare(Term::RandomWalk, &Estimate::ABSENT, 1.0, None).is_none());
    }

    #[test]
    fn an_uncertain_reference_widens_the_ratio() {
        let e = Estimate::detected(1.0, 0.97, 1.03, 0.015);
        let c = compare(Term::White, &e, 1.0, Some(0.02)).unwrap();
        let half: f64 = 0.03_f64.hypot(1.96 * 0.02);
        assert!((c.ratio.upper.unwrap() - 1.0 - half).abs() < 1e-12);
    }
}
