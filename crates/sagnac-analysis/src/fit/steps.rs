//! Steps of an axis: found with the regressors and between the segments, with their levels, findings and intervals.

use super::across;
use super::blocks::known_sum;
use super::checks::{self, digits};
use super::columns::{Chosen, regressors};
use super::estimate::{Active, ActiveKind, Work};
use super::likelihood::{Free, Solution};
use super::types::{
    Candidates, Estimate, Finding, FindingKind, FitOptions, Level, NoiseTerms, Regressor,
    RegressorKind, Segment,
};

/// Segment and its first sample on the new level: 0 where the step lies in the cut before the segment.
pub(super) type Place = (usize, usize);

/// Rounds of regressors and steps between the segments.
const ROUNDS: usize = 3;

/// A step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub place: Place,
    /// Height and standard deviation in units of the scale; none where the regressors' fit has them.
    pub height: Option<(f64, f64)>,
}

/// A stretch between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    start_s: f64,
    end_s: f64,
    samples: usize,
    mean: f64,
}

/// The steps of an axis and what lies between them.
#[derive(Debug, Clone, Default)]
pub(super) struct Steps {
    all: Vec<Step>,
    /// When each took place [s]: the ends of the cut, or one time twice.
    spans_s: Vec<(f64, f64)>,
    stretches: Vec<Stretch>,
}

/// Places of the steps among the regressors.
pub(super) fn places(active: &[Active]) -> Vec<Place> {
    let steps = active.iter().filter_map(|a| match a.kind {
        ActiveKind::Step(segment, at) => Some((segment, at)),
        _ => None,
    });
    steps.collect()
}

/// Regressors, Gauss–Markov terms and steps, those between the segments included.
pub(super) fn chosen(
    work: &mut Work,
    segments: &[Segment<'_>],
    temperature: Option<&[Segment<'_>]>,
    candidates: &Candidates,
    options: &FitOptions,
    grown: &(Solution, Free, usize),
) -> (Chosen, Steps) {
    let mut out = regressors(work, segments, temperature, candidates, options, grown);
    let mut steps: Vec<Step> = places(&out.0)
        .into_iter()
        .map(|place| Step {
            place,
            height: None,
        })
        .collect();
    if options.data_checks && segments.len() > 1 {
        for round in 1..=ROUNDS {
            let now = &out.1.0;
            let Some(found) = across::find(work, segments, temperature, &out.0, &now.parameters)
            else {
                break;
            };
            steps = found.steps;
            if found.inside.is_empty() && !found.is_fewer || round == ROUNDS {
                break;
            }
            // What lies inside a segment bends its spectrum: it joins the regressors, and all is chosen anew.
            work.given = steps
                .iter()
                .map(|s| s.place)
                .filter(|&(s, at)| at > 0 && at < work.segments[s].n)
                .collect();
            for (place, around) in found.inside {
                let sharp = checks::sharpen(work, &segments[place.0], place, around, now);
                if let Some(given) = work.given.iter_mut().find(|g| **g == place) {
                    given.1 = sharp;
                }
            }
            out = regressors(work, segments, temperature, candidates, options, grown);
        }
    }
    steps.sort_by_key(|s| s.place);
    let steps = Steps::new(work, segments, steps);
    (out, steps)
}

impl Steps {
    fn new(work: &Work, segments: &[Segment<'_>], all: Vec<Step>) -> Self {
        let time = |(s, at): Place| segments[s].start_s + at as f64 * work.step_s;
        let spans_s: Vec<(f64, f64)> = all
            .iter()
            .map(|step| match step.place {
                (s, 0) if s > 0 => (
                    time((s - 1, segments[s - 1].samples.len())).min(time((s, 0))),
                    time((s, 0)),
                ),
                place => (time(place), time(place)),
            })
            .collect();
        let mut stretches = Vec::new();
        if !all.is_empty() {
            let mut from = (0, 0);
            let end = (segments.len(), 0);
            let mut start_s = segments.first().map_or(0.0, |s| s.start_s);
            let last_s = segments
                .last()
                .map_or(0.0, |s| s.start_s + s.samples.len() as f64 * work.step_s);
            let borders = all.iter().map(|s| s.place).zip(spans_s.iter().copied());
            for (to, (before_s, after_s)) in borders.chain([(end, (last_s, last_s))]) {
                let (mut sum, mut samples) = (0.0, 0);
                for (s, segment) in segments.iter().enumerate().take(to.0 + 1).skip(from.0) {
                    let first = if s == from.0 { from.1 } else { 0 };
                    let last = if s == to.0 {
                        to.1
                    } else {
                        segment.samples.len()
                    };
                    let (own, count) = known_sum(segment, first..last.max(first), work.mean);
                    sum += own;
                    samples += count;
                }
                stretches.push(Stretch {
                    start_s,
                    end_s: before_s,
                    samples,
                    mean: work.mean + sum / samples.max(1) as f64,
                });
                (from, start_s) = (to, after_s);
            }
        }
        Self {
            all,
            spans_s,
            stretches,
        }
    }

    /// Whether a step is smaller than this [unit of the axis].
    pub(super) fn any_below(&self, work: &Work, size: f64) -> bool {
        self.all
            .iter()
            .filter_map(|s| s.height)
            .any(|(height, _)| height.abs() * work.scale < size)
    }

    /// Height and standard deviation [unit of the axis] of every step, from the final fit where it has them.
    fn heights(&self, work: &Work, active: &[Active], best: &Solution) -> Vec<(f64, f64)> {
        let p = active.len();
        self.all
            .iter()
            .map(|step| {
                let own = step.height.or_else(|| {
                    let (s, at) = step.place;
                    let i = active
                        .iter()
                        .position(|a| a.kind == ActiveKind::Step(s, at))?;
                    Some((best.beta[0][i], best.beta_covariance[0][i * p + i].sqrt()))
                });
                let (height, sigma) = own.unwrap_or((f64::NAN, f64::NAN));
                (height * work.scale, sigma * work.scale)
            })
            .collect()
    }

    /// The findings.
    pub(super) fn findings(&self, work: &Work, active: &[Active], best: &Solution) -> Vec<Finding> {
        let heights = self.heights(work, active, best);
        heights
            .iter()
            .zip(&self.spans_s)
            .map(|(&(height, _), &(start_s, end_s))| {
                let when = if start_s < end_s {
                    format!("between {start_s:.1} and {end_s:.1} s")
                } else {
                    format!("at {end_s:.1} s")
                };
                Finding {
                    kind: FindingKind::Step,
                    start_s,
                    end_s,
                    count: 1,
                    size: Some(height),
                    text: format!("the mean changes by {} {when}", digits(height)),
                }
            })
            .collect()
    }

    /// The regressors, with 95 % intervals.
    pub(super) fn regressors(
        &self,
        work: &Work,
        active: &[Active],
        best: &Solution,
    ) -> impl Iterator<Item = Regressor> {
        let heights = self.heights(work, active, best);
        let spans_s = self.spans_s.clone();
        heights
            .into_iter()
            .zip(spans_s)
            .map(|((value, sigma), span)| Regressor {
                kind: RegressorKind::Step { time_s: span.1 },
                value,
                lower: value - 1.96 * sigma,
                upper: value + 1.96 * sigma,
            })
    }

    /// The means between the steps, each with its standard error given the fitted noise.
    pub(super) fn levels(&self, fitted: &NoiseTerms, step_s: f64) -> Vec<Level> {
        self.stretches
            .iter()
            .filter(|s| s.samples > 0)
            .map(|s| {
                let sigma = fitted
                    .mean_variance(s.samples as f64 * step_s, step_s)
                    .sqrt();
                let (low, high) = (s.mean - 1.96 * sigma, s.mean + 1.96 * sigma);
                Level {
                    start_s: s.start_s,
                    end_s: s.end_s,
                    mean: Estimate::detected(s.mean, low, high, sigma),
                }
            })
            .collect()
    }
}
