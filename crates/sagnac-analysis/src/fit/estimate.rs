//! From one axis to its estimates: transform, lines, filter, regressors, tests, intervals.
//!
//! Order: coefficients; lines out; frequencies above a filter's corner out; regressors and Gauss–Markov terms taken in
//! one by one, the clearest first; then every term tested with all others free. Source: [Whittle1953] and the tests'
//! own files.

use super::bins::{BinnedLog, Column, Layout, SegmentSpectrum};
use super::checks;
use super::dct::{dct2, fast_length};
use super::goodness;
use super::likelihood::{B, FIRST_GM, Free, K, N, PARAMETERS, Parameters, Problem, Q, Solution};
use super::lines::{self, Line};
use super::profile::{self, INTERVAL, LIMIT, Side};
use super::regress;
use super::select::{self, GAUSS_MARKOV_THRESHOLD, RAMP_THRESHOLD, Tests};
use super::spectra;
use super::types::{
    AxisData, AxisEstimate, Candidates, Covariance, Estimate, Finding, FindingKind, FitOptions,
    GaussMarkovEstimate, NoiseTerms, Regressor, RegressorKind, Segment, SinusoidEstimate,
    SpectrumBin, Term,
};
use realfft::RealFftPlanner;

/// Likelihood ratio from which a step or a warm-up is named.
const DATA_THRESHOLD: f64 = 25.0;
/// Ratio from which a power of the temperature is kept.
const TEMPERATURE_THRESHOLD: f64 = 3.84;
const MOST_LINES: usize = 24;
const MOST_STEPS: usize = 12;
/// Below this duration B, K, R and Gauss–Markov terms are bounded only.
pub(super) const SHORT_S: f64 = 100.0;
/// Likelihood ratio below which a detected B or K is weak: its interval allows for an undetected other.
const WEAK_RATIO: f64 = 20.0;
/// Fewest samples that give parameters.
const FEWEST: usize = 64;

/// The transformed log of one axis.
pub(super) struct Work {
    pub segments: Vec<SegmentSpectrum>,
    pub layout: Layout,
    /// Unit of the coefficients [unit of the axis].
    pub scale: f64,
    pub step_s: f64,
    /// Highest u that takes part.
    pub cut: f64,
    pub lines: Vec<Line>,
    pub samples: usize,
    pub mean: f64,
}

/// A regressor that is in the fit.
#[derive(Clone)]
pub(super) struct Active {
    pub kind: ActiveKind,
    pub column: Column,
}

/// What a column stands for.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ActiveKind {
    Ramp,
    Temperature(usize),
    /// Time constant in samples.
    WarmUp(f64),
    /// Segment, sample.
    Step(usize, usize),
}

/// A fitted log before its terms are tested.
pub(super) struct Prepared {
    pub work: Work,
    pub active: Vec<Active>,
    pub candidates: Candidates,
    /// All columns of `active`, restricted where there are any.
    pub problem: Problem,
    pub grown: (Solution, Free, usize),
}

/// The joint estimate of one axis.
///
/// Any input gives an answer: what cannot be known is an upper limit or absent, and why is in `findings`. For white noise
/// and random walk the likelihood is exact; biases, coverage and efficiency are measured by `tools/fidelity.py`.
///
/// ```
/// use sagnac_analysis::fit::{AxisData, FitOptions, Segment, estimate};
/// let samples: Vec<f64> = (0..4000).map(|k| ((k * 7919 % 1000) as f64 / 500.0 - 1.0) * 1e-3).collect();
/// let segments = [Segment { start_s: 0.0, samples: &samples }];
/// let data = AxisData { segments: &segments, temperature: None, step_s: 0.01, lsb: None };
/// let axis = estimate(&data, &FitOptions::default());
/// assert!(axis.samples == 4000);
/// ```
pub fn estimate(data: &AxisData<'_>, options: &FitOptions) -> AxisEstimate {
    match prepare(data, options) {
        Ok(prepared) => conclude(data, options, prepared),
        Err(empty) => *empty,
    }
}

/// What is said where no parameter can be.
fn nothing(data: &AxisData<'_>, text: &str) -> AxisEstimate {
    let samples: usize = data.segments.iter().map(|s| s.samples.len()).sum();
    let all = || data.segments.iter().flat_map(|s| s.samples.iter().copied());
    let mean = all().sum::<f64>() / samples.max(1) as f64;
    let scatter = (all().map(|y| (y - mean).powi(2)).sum::<f64>()
        / samples.saturating_sub(1).max(1) as f64)
        .sqrt();
    let error = scatter / (samples.max(1) as f64).sqrt();
    let end = data
        .segments
        .last()
        .map_or(0.0, |s| s.start_s + s.samples.len() as f64 * data.step_s);
    let mean = if samples > 1 && mean.is_finite() {
        Estimate::detected(mean, mean - 1.96 * error, mean + 1.96 * error, error)
    } else {
        Estimate::ABSENT
    };
    AxisEstimate {
        samples,
        step_s: data.step_s,
        duration_s: samples as f64 * data.step_s,
        mean,
        quantization: Estimate::ABSENT,
        white: Estimate::ABSENT,
        flicker: Estimate::ABSENT,
        random_walk: Estimate::ABSENT,
        ramp: Estimate::ABSENT,
        gauss_markov: vec![GaussMarkovEstimate {
            sigma: Estimate::ABSENT,
            correlation_time_s: Estimate::ABSENT,
        }],
        sinusoids: Vec::new(),
        confused: Vec::new(),
        regressors: Vec::new(),
        p_value: None,
        findings: vec![Finding {
            kind: FindingKind::Short,
            start_s: 0.0,
            end_s: end,
            count: samples,
            size: None,
            text: text.to_string(),
        }],
        fitted: NoiseTerms::default(),
        covariance: Covariance::default(),
        spectrum: Vec::new(),
        likelihood_ratios: [None; 5],
    }
}

/// Transforms the log, takes lines, filters and regressors into account and finds the best fit of all candidates.
pub(super) fn prepare(
    data: &AxisData<'_>,
    options: &FitOptions,
) -> Result<Prepared, Box<AxisEstimate>> {
    let samples: usize = data.segments.iter().map(|s| s.samples.len()).sum();
    if samples < FEWEST {
        let text = format!("{samples} samples are too few for parameters; 64 are needed");
        return Err(Box::new(nothing(data, &text)));
    }
    let kept: Vec<usize> = (0..data.segments.len())
        .filter(|&i| data.segments[i].samples.len() >= 8)
        .collect();
    let segments: Vec<Segment<'_>> = kept.iter().map(|&i| data.segments[i]).collect();
    let temperature: Option<Vec<Segment<'_>>> = data
        .temperature
        .filter(|t| {
            t.len() == data.segments.len()
                && t.iter()
                    .zip(data.segments)
                    .all(|(a, b)| a.samples.len() == b.samples.len())
        })
        .map(|t| kept.iter().map(|&i| t[i]).collect());
    let Some(mut work) = transform(&segments, data.step_s, samples) else {
        return Err(Box::new(nothing(
            data,
            "the values do not change: no noise can be seen",
        )));
    };
    let duration_s = samples as f64 * data.step_s;
    let mut candidates = options.candidates;
    if duration_s < SHORT_S {
        candidates.ramp = false;
        candidates.gauss_markov = 0;
    }

    // Lines, then a filter's corner.
    let mut grown;
    let mut rounds = 0;
    loop {
        let log = work.layout.sum(&work.segments, &[], work.cut);
        let problem = Problem::new(&[&log], false);
        grown = select::grow(&problem, &candidates);
        rounds += 1;
        if candidates.sinusoids && rounds <= 8 && take_lines(&mut work, &grown.0.parameters) {
            continue;
        }
        if options.data_checks
            && work.cut >= 0.5
            && let Some(cut) = checks::filter_corner(&work, &problem, &grown.0, &candidates)
        {
            work.cut = cut;
            continue;
        }
        break;
    }
    let (active, grown, problem) = regressors(
        &work,
        &segments,
        temperature.as_deref(),
        &candidates,
        options,
        &grown,
    );
    Ok(Prepared {
        work,
        active,
        candidates,
        problem,
        grown,
    })
}

fn transform(segments: &[Segment<'_>], step_s: f64, samples: usize) -> Option<Work> {
    let (mut squares, mut count, mut spread) = (0.0, 0.0, 0.0);
    let (mut sum, mut used) = (0.0, 0.0);
    let mut means = Vec::with_capacity(segments.len());
    for segment in segments {
        let n = segment.samples.len() as f64;
        // The first sample is taken out before summing, for the digits.
        let first = segment.samples[0];
        let mean = first + segment.samples.iter().map(|y| y - first).sum::<f64>() / n;
        means.push(mean);
        sum += mean * n;
        used += n;
        for pair in segment.samples.windows(2) {
            let d = pair[1] - pair[0];
            squares += d * d;
        }
        spread += segment
            .samples
            .iter()
            .map(|y| (y - mean).powi(2))
            .sum::<f64>();
        count += n - 1.0;
    }
    let scale = match ((0.5_f64 * squares / count).sqrt(), (spread / count).sqrt()) {
        (d, _) if d > 0.0 && d.is_finite() => d,
        (_, s) if s > 0.0 && s.is_finite() => s,
        _ => return None,
    };
    let mut planner = RealFftPlanner::new();
    let spectra: Vec<SegmentSpectrum> = segments
        .iter()
        .zip(&means)
        .map(|(segment, &mean)| {
            let n = fast_length(segment.samples.len());
            let mut coefficients = dct2(&segment.samples[..n], mean, &mut planner);
            let unit = 1.0 / scale;
            for c in &mut coefficients {
                *c *= unit;
            }
            SegmentSpectrum {
                start_s: segment.start_s,
                n,
                coefficients,
                excluded: Vec::new(),
            }
        })
        .collect();
    Some(Work {
        layout: Layout::new(&spectra),
        segments: spectra,
        scale,
        step_s,
        cut: 0.5,
        lines: Vec::new(),
        samples,
        mean: sum / used,
    })
}

/// Spectrum of the parameters at u, variance of a coefficient, without the ends' corrections.
pub(super) fn spectrum_at(parameters: &Parameters, u: f64) -> f64 {
    let mut s = parameters[N];
    if parameters[Q] > 0.0 {
        s += parameters[Q] * spectra::quantization(u);
    }
    if parameters[B] > 0.0 {
        s += parameters[B] * spectra::flicker(u);
    }
    if parameters[K] > 0.0 {
        s += parameters[K] * spectra::random_walk(u);
    }
    for g in 0..2 {
        let at = FIRST_GM + 2 * g;
        if parameters[at] > 0.0 {
            let shape = spectra::GaussMarkovShape::new((-parameters[at + 1]).exp());
            s += parameters[at] * shape.at(spectra::quantization(u));
        }
    }
    s
}

/// Looks for lines above the fit; whether any was taken out.
fn take_lines(work: &mut Work, parameters: &Parameters) -> bool {
    let mut any = false;
    let mut lines = std::mem::take(&mut work.lines);
    for s in 0..work.segments.len() {
        if work.segments[s].n < 128 {
            continue;
        }
        let n = work.segments[s].n;
        let levels: Vec<(usize, usize, f64)> = work
            .layout
            .spans(s)
            .map(|(first, end)| {
                let u = 0.5 * (first + end - 1) as f64 / (2.0 * n as f64);
                (first, end, spectrum_at(parameters, u).max(1e-300))
            })
            .collect();
        let found = lines::take_out(&mut work.segments[s], &levels, MOST_LINES);
        any |= !found.is_empty();
        lines.extend(found);
    }
    work.lines = lines;
    any
}

type Chosen = (Vec<Active>, (Solution, Free, usize), Problem);

/// Takes in regressors and Gauss–Markov terms one by one, the clearest first.
fn regressors(
    work: &Work,
    segments: &[Segment<'_>],
    temperature: Option<&[Segment<'_>]>,
    candidates: &Candidates,
    options: &FitOptions,
    grown: &(Solution, Free, usize),
) -> Chosen {
    let mut active: Vec<Active> = Vec::new();
    let singles = select::free_singles(candidates);
    let duration = work.samples as f64 * work.step_s;
    let span = segments
        .last()
        .map_or(0.0, |s| s.start_s / work.step_s + s.samples.len() as f64);
    let mut planner = RealFftPlanner::new();
    let temperature_columns: Vec<Column> = temperature
        .filter(|t| temperature_range(t) > 0.0)
        .map(|t| {
            let reference = mean_of(t);
            (1..=2)
                .map(|power| {
                    regress::temperature(&work.segments, t, reference, power, &mut planner)
                })
                .collect()
        })
        .unwrap_or_default();
    let ramp = candidates.ramp.then(|| regress::line(&work.segments));
    let times: Vec<f64> = if options.data_checks && duration >= 4.0 * 30.0 {
        let (low, high) = (30.0 / work.step_s, span / 4.0);
        let steps = ((high / low).ln() / 0.55).ceil().max(1.0) as usize;
        (0..=steps)
            .map(|i| low * (high / low).powf(i as f64 / steps as f64))
            .collect()
    } else {
        Vec::new()
    };
    let exponentials: Vec<Column> = times
        .iter()
        .map(|&tau| regress::exponential(&work.segments, work.step_s, tau))
        .collect();

    let mut free = singles;
    let mut count = 0;
    let mut current: Option<Solution> = None;
    let mut first_round = true;
    loop {
        // Every candidate column is summed once a round.
        let mut columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
        let base = columns.len();
        let mut offers: Vec<(ActiveKind, f64)> = Vec::new();
        let has = |kind: ActiveKind| active.iter().any(|a| a.kind == kind);
        if let Some(column) = &ramp
            && !has(ActiveKind::Ramp)
        {
            offers.push((ActiveKind::Ramp, RAMP_THRESHOLD));
            columns.push(column.clone());
        }
        for (i, column) in temperature_columns.iter().enumerate() {
            let kind = ActiveKind::Temperature(i + 1);
            if !has(kind) && (i == 0 || has(ActiveKind::Temperature(1))) {
                offers.push((kind, TEMPERATURE_THRESHOLD));
                columns.push(column.clone());
            }
        }
        if !active
            .iter()
            .any(|a| matches!(a.kind, ActiveKind::WarmUp(_)))
        {
            for (tau, column) in times.iter().zip(&exponentials) {
                offers.push((ActiveKind::WarmUp(*tau), DATA_THRESHOLD));
                columns.push(column.clone());
            }
        }
        let steps_so_far = active
            .iter()
            .filter(|a| matches!(a.kind, ActiveKind::Step(..)))
            .count();
        let log = work.layout.sum(&work.segments, &columns, work.cut);
        let whole = Problem::new(&[&log], false);
        let own: Vec<usize> = (0..base).collect();
        let problem = whole.with_columns(&own, false);
        let start = current
            .as_ref()
            .map_or_else(|| problem.start(&free), |s| s.parameters);
        let now = problem.fit(&start, &free);
        if options.data_checks && steps_so_far < MOST_STEPS {
            // A step is looked for in what the fit leaves.
            if let Some((which, at)) = checks::find_step(work, segments, &active, &now) {
                let column = regress::step(&work.segments, which, at, usize::MAX);
                let mut with: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
                with.push(column.clone());
                let log = work.layout.sum(&work.segments, &with, work.cut);
                let tried = Problem::new(&[&log], false).fit(&now.parameters, &free);
                let gain = now.objective - tried.objective;
                if gain > DATA_THRESHOLD {
                    let rival = best_offer(&whole, base, &offers, &now, &free);
                    if rival.as_ref().is_none_or(|r| r.1 < gain) {
                        active.push(Active {
                            kind: ActiveKind::Step(which, at),
                            column,
                        });
                        current = Some(tried);
                        first_round = false;
                        continue;
                    }
                }
            }
        }
        let offer = best_offer(&whole, base, &offers, &now, &free);
        // Without anything taken in yet the Gauss–Markov terms are those already found.
        let more = if count < candidates.gauss_markov.min(2) {
            if first_round && grown.2 == 0 {
                None
            } else {
                let tried = select::add_gauss_markov(&problem, &now, &free, count, 6.0);
                Some(tried).filter(|t| {
                    now.objective - t.objective >= GAUSS_MARKOV_THRESHOLD
                        && !problem.at_edge(&t.parameters)
                })
            }
        } else {
            None
        };
        let gain_of_more = more.as_ref().map_or(0.0, |t| now.objective - t.objective);
        match (offer, more) {
            (Some((index, gain, solution)), _) if gain >= gain_of_more => {
                let kind = offers[index].0;
                active.push(Active {
                    kind,
                    column: columns[base + index].clone(),
                });
                current = Some(solution);
            }
            (_, Some(solution)) => {
                free = select::with_gauss_markov(&free, count);
                count += 1;
                current = Some(solution);
            }
            _ => {
                current = Some(now);
                break;
            }
        }
        first_round = false;
        if active.len() > MOST_STEPS + 4 {
            break;
        }
    }
    refine_warm_up(work, &mut active, &mut current, &free);
    drop_idle(work, &mut active, &mut current, &mut free, &mut count);
    let columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
    let log = work.layout.sum(&work.segments, &columns, work.cut);
    let problem = Problem::new(&[&log], !active.is_empty());
    let start = current.map_or_else(|| problem.start(&free), |s| s.parameters);
    let solution = problem.fit(&start, &free);
    (active, (solution, free, count), problem)
}

/// The offered column with the largest gain among those that pass: (index, gain, fit).
fn best_offer(
    whole: &Problem,
    base: usize,
    offers: &[(ActiveKind, f64)],
    now: &Solution,
    free: &Free,
) -> Option<(usize, f64, Solution)> {
    let mut best: Option<(usize, f64, Solution)> = None;
    for (i, (_, threshold)) in offers.iter().enumerate() {
        let mut keep: Vec<usize> = (0..base).collect();
        keep.push(base + i);
        let tried = whole.with_columns(&keep, false).fit(&now.parameters, free);
        let gain = now.objective - tried.objective;
        if gain >= *threshold && best.as_ref().is_none_or(|b| gain > b.1) {
            best = Some((i, gain, tried));
        }
    }
    best
}

/// Refines the time constant of a warm-up between the points of the search.
fn refine_warm_up(work: &Work, active: &mut [Active], current: &mut Option<Solution>, free: &Free) {
    let Some(place) = active
        .iter()
        .position(|a| matches!(a.kind, ActiveKind::WarmUp(_)))
    else {
        return;
    };
    let Some(solution) = current.clone() else {
        return;
    };
    let mut best = (f64::INFINITY, 0.0, Vec::new());
    let ActiveKind::WarmUp(center) = active[place].kind else {
        return;
    };
    let mut width = 0.3;
    let mut at = center;
    for _ in 0..5 {
        for factor in [-1.0, 0.0, 1.0] {
            let tau = at * f64::exp(width * factor);
            let column = regress::exponential(&work.segments, work.step_s, tau);
            let mut columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
            columns[place].clone_from(&column);
            let log = work.layout.sum(&work.segments, &columns, work.cut);
            let fit = Problem::new(&[&log], false).fit(&solution.parameters, free);
            if fit.objective < best.0 {
                best = (fit.objective, tau, column);
                *current = Some(fit);
            }
        }
        at = best.1;
        width *= 0.5;
    }
    active[place].kind = ActiveKind::WarmUp(best.1);
    active[place].column = best.2;
}

/// Drops what no longer passes beside what came after it.
fn drop_idle(
    work: &Work,
    active: &mut Vec<Active>,
    current: &mut Option<Solution>,
    free: &mut Free,
    count: &mut usize,
) {
    if active.len() + *count < 2 {
        return;
    }
    loop {
        let columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
        let log = work.layout.sum(&work.segments, &columns, work.cut);
        let whole = Problem::new(&[&log], false);
        let start = current
            .as_ref()
            .map_or_else(|| whole.start(free), |s| s.parameters);
        let now = whole.fit(&start, free);
        let mut worst: Option<(usize, f64)> = None;
        for (i, a) in active.iter().enumerate() {
            let threshold = match a.kind {
                ActiveKind::Ramp => RAMP_THRESHOLD,
                ActiveKind::Temperature(_) => TEMPERATURE_THRESHOLD,
                _ => DATA_THRESHOLD,
            };
            if matches!(a.kind, ActiveKind::Temperature(1))
                && active.iter().any(|b| b.kind == ActiveKind::Temperature(2))
            {
                continue;
            }
            let keep: Vec<usize> = (0..active.len()).filter(|&k| k != i).collect();
            let fit = whole.with_columns(&keep, false).fit(&now.parameters, free);
            let share = (fit.objective - now.objective) / threshold;
            if share < 1.0 && worst.is_none_or(|w| share < w.1) {
                worst = Some((i, share));
            }
        }
        if let Some((i, _)) = worst {
            active.remove(i);
            *current = Some(now);
            continue;
        }
        if *count > 0 && !active.is_empty() {
            // The last Gauss–Markov term against the fit without it.
            let last = FIRST_GM + 2 * (*count - 1);
            let fit = select::refit_without_gauss_markov(&whole, &now, free, *count - 1);
            if fit.objective - now.objective < GAUSS_MARKOV_THRESHOLD {
                free[last] = false;
                free[last + 1] = false;
                *count -= 1;
                *current = Some(fit);
                continue;
            }
        }
        *current = Some(now);
        return;
    }
}

fn mean_of(segments: &[Segment<'_>]) -> f64 {
    let count: usize = segments.iter().map(|s| s.samples.len()).sum();
    segments.iter().flat_map(|s| s.samples).sum::<f64>() / count.max(1) as f64
}

fn temperature_range(segments: &[Segment<'_>]) -> f64 {
    let (low, high) = segments
        .iter()
        .flat_map(|s| s.samples)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &t| {
            (l.min(t), h.max(t))
        });
    let range = high - low;
    if range.is_finite() { range } else { 0.0 }
}

/// Scales from the fit's units to SI.
pub(super) struct Units {
    scale: f64,
    step_s: f64,
}

impl Units {
    pub(super) fn new(work: &Work) -> Self {
        Self {
            scale: work.scale,
            step_s: work.step_s,
        }
    }

    /// Root of a variance parameter in SI.
    pub(super) fn root(&self, index: usize, variance: f64) -> f64 {
        let root = variance.max(0.0).sqrt() * self.scale;
        match index {
            Q => root * self.step_s,
            N => root * self.step_s.sqrt(),
            K => root / self.step_s.sqrt(),
            _ => root,
        }
    }

    pub(super) fn time(&self, log_time: f64) -> f64 {
        log_time.exp() * self.step_s
    }

    pub(super) fn terms(&self, parameters: &Parameters) -> NoiseTerms {
        NoiseTerms {
            quantization: self.root(Q, parameters[Q]),
            white: self.root(N, parameters[N]),
            flicker: self.root(B, parameters[B]),
            random_walk: self.root(K, parameters[K]),
            ramp: 0.0,
            gauss_markov: (0..2)
                .map(|g| FIRST_GM + 2 * g)
                .filter(|&at| parameters[at] > 0.0)
                .map(|at| (self.root(at, parameters[at]), self.time(parameters[at + 1])))
                .collect(),
            sinusoids: Vec::new(),
        }
    }
}

/// Coefficients below the frequency down from which a term outweighs those that are flatter than it.
fn coefficients_below_corner(problem: &Problem, parameters: &Parameters, index: usize) -> f64 {
    let flatter: &[usize] = match index {
        B => &[Q, N],
        K => &[Q, N, B],
        _ => return f64::INFINITY,
    };
    let mut order: Vec<usize> = (0..problem.u.len()).collect();
    order.sort_by(|&a, &b| problem.u[b].total_cmp(&problem.u[a]));
    let mut below = problem.coefficients();
    for b in order {
        let rest: f64 = flatter
            .iter()
            .map(|&k| parameters[k] * problem.basis(k)[b])
            .sum();
        if parameters[index] * problem.basis(index)[b] >= rest {
            return below;
        }
        below -= problem.count[b];
    }
    0.0
}

/// Tests the terms, finds intervals and limits, and says what the data show.
fn conclude(data: &AxisData<'_>, options: &FitOptions, prepared: Prepared) -> AxisEstimate {
    let Prepared {
        work,
        active,
        candidates,
        problem,
        grown,
    } = prepared;
    let units = Units::new(&work);
    let duration_s = work.samples as f64 * work.step_s;
    let end_s = data.segments.last().map_or(duration_s, |s| {
        s.start_s + s.samples.len() as f64 * data.step_s
    });
    let mut findings = Vec::new();
    let whole_log = |kind: FindingKind, size: Option<f64>, text: String| Finding {
        kind,
        start_s: 0.0,
        end_s,
        count: work.samples,
        size,
        text,
    };

    let tests = select::test(&problem, &candidates, grown);
    let free = tests.kept(&candidates);
    let best = select::final_fit(&problem, &tests.full, &free);
    let short = duration_s < SHORT_S;
    if short {
        findings.push(whole_log(
            FindingKind::Short,
            Some(duration_s),
            format!("{duration_s:.0} s are too short for slow terms: they are bounded only"),
        ));
    }
    // Terms that pass but that so few coefficients or so coarse steps cannot carry: bounded only.
    let mut bounded = [false; 4];
    for k in [B, K] {
        if !tests.passed[k] {
            continue;
        }
        let few = coefficients_below_corner(&problem, &best.parameters, k);
        if short || few < 10.0 {
            bounded[k] = true;
            if !short {
                let name = if k == B {
                    "flicker noise"
                } else {
                    "random walk"
                };
                findings.push(whole_log(
                    FindingKind::Short,
                    Some(few),
                    format!("{few:.0} coefficients below its corner are too few for {name}: bounded only"),
                ));
            }
        }
    }
    if let Some((finding, coarse)) = checks::rounding(data, end_s) {
        findings.push(finding);
        if coarse {
            bounded[Q] = true;
            bounded[N] = true;
        }
    }

    let allowed = [
        candidates.quantization,
        candidates.white,
        candidates.flicker,
        candidates.random_walk,
    ];
    let mut single = [Estimate::ABSENT; 4];
    let covariance = profile::covariance(&problem, &best, &free);
    for k in 0..4 {
        if !allowed[k] {
            continue;
        }
        let confused = tests.confused && (k == B || k == K) || tests.flicker_confused && k == B;
        single[k] = if tests.passed[k] && !bounded[k] && !confused && best.parameters[k] > 0.0 {
            let own = interval(&problem, &best, &free, k, covariance.as_ref(), |v| {
                units.root(k, v)
            });
            weak_interval(&problem, &tests, &free, k, own, &units)
        } else {
            Estimate::limit(units.root(k, limit(&problem, &tests, k)))
        };
    }
    let gauss_markov = if options.candidates.gauss_markov == 0 || short && work.samples < 160 {
        vec![GaussMarkovEstimate {
            sigma: Estimate::ABSENT,
            correlation_time_s: Estimate::ABSENT,
        }]
    } else {
        gauss_markov_estimates(&problem, &tests, &best, &free, covariance.as_ref(), &units)
    };

    let mut fitted = units.terms(&best.parameters);
    let mut ratios = [None; 5];
    for k in 0..4 {
        ratios[k] = allowed[k].then_some(tests.ratios[k]);
    }
    let (ramp, ratio) = ramp(
        &work,
        &active,
        &problem,
        &tests,
        &best,
        &free,
        options.candidates.ramp,
    );
    ratios[4] = ratio;
    fitted.ramp = ramp.value.unwrap_or(0.0);

    // Goodness of fit of the bins used, and the spectrum for people to look at.
    let power = problem.residual_power(&best);
    let fit = problem.spectrum(&best.parameters);
    let parameters = free.iter().filter(|&&f| f).count() + active.len();
    let p_value = goodness::p_value(&power, &fit, &problem.count, parameters);
    if let Some(p) = p_value
        && p < 1e-3
    {
        findings.push(checks::misfit(
            &problem,
            &power,
            &fit,
            work.step_s,
            end_s,
            work.samples,
        ));
    }
    let sinusoids = sinusoids(&work, &fitted, options);
    for line in &sinusoids {
        if line.share_of_white > 0.1
            && let (Some(a), Some(f)) = (line.amplitude.value, line.frequency_hz.value)
        {
            findings.push(whole_log(
                FindingKind::Line,
                Some(f),
                format!("a line at {f:.6} Hz with amplitude {}; it may be an alias of a higher frequency", checks::digits(a)),
            ));
        }
    }
    fitted.sinusoids = sinusoids
        .iter()
        .filter_map(|s| s.amplitude.value.zip(s.frequency_hz.value))
        .collect();
    if work.cut < 0.5 {
        let corner = work.cut / work.step_s;
        findings.push(whole_log(
            FindingKind::Filtered,
            Some(corner),
            format!(
                "not white above {} Hz: those frequencies leave the fit, white noise is from below",
                checks::digits(corner)
            ),
        ));
    }
    let regressors = describe(&work, &active, &best);
    findings.extend(checks::regressor_findings(
        &work, &active, &best, data, end_s,
    ));
    if options.data_checks
        && let Some(finding) = checks::non_stationary(data)
    {
        findings.push(finding);
    }

    let error = fitted.mean_variance(duration_s, work.step_s).sqrt();
    let mean = Estimate::detected(
        work.mean,
        work.mean - 1.96 * error,
        work.mean + 1.96 * error,
        error,
    );
    let mut confused = Vec::new();
    if tests.confused {
        confused.push((Term::Flicker, Term::RandomWalk));
    }
    if tests.flicker_confused {
        confused.push((Term::Flicker, Term::GaussMarkov));
    }
    if tests.top_confused {
        confused.push((Term::Quantization, Term::White));
    }
    findings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    AxisEstimate {
        samples: work.samples,
        step_s: work.step_s,
        duration_s,
        mean,
        quantization: single[Q],
        white: single[N],
        flicker: single[B],
        random_walk: single[K],
        ramp,
        gauss_markov,
        sinusoids,
        confused,
        regressors,
        p_value,
        findings,
        covariance: named_covariance(covariance.as_ref(), &best.parameters, &units),
        spectrum: spectrum_bins(&work, &active, &best),
        fitted,
        likelihood_ratios: ratios,
    }
}

/// Value, profile interval and standard deviation of a detected variance.
pub(super) fn interval(
    problem: &Problem,
    best: &Solution,
    free: &Free,
    index: usize,
    covariance: Option<&(Vec<usize>, Vec<f64>)>,
    to_si: impl Fn(f64) -> f64,
) -> Estimate {
    let lower = profile::bound(problem, best, free, index, Side::Lower, INTERVAL);
    let upper = profile::bound(problem, best, free, index, Side::Upper, INTERVAL);
    let value = best.parameters[index];
    let root = value.sqrt();
    let sigma_root = covariance
        .and_then(|(indices, m)| {
            let place = indices.iter().position(|&i| i == index)?;
            Some(m[place * indices.len() + place].sqrt() / (2.0 * root))
        })
        .unwrap_or((upper.sqrt() - lower.sqrt()) / 3.92);
    let si = to_si(value);
    Estimate::detected(si, to_si(lower), to_si(upper), si * sigma_root / root)
}

/// The interval of a weak B or K beside an undetected other: wide enough for both, the other at zero or free.
///
/// With both weak, what passes carries the power of what does not; its interval given only the detected terms would
/// cover in four of five logs.
fn weak_interval(
    problem: &Problem,
    tests: &Tests,
    free: &Free,
    index: usize,
    own: Estimate,
    units: &Units,
) -> Estimate {
    let other = match index {
        B => K,
        K => B,
        _ => return own,
    };
    if tests.ratios[index] >= WEAK_RATIO
        || free[other]
        || !tests.full_free[other]
        || tests.full.parameters[other] <= 0.0
    {
        return own;
    }
    let (full, all) = (&tests.full, &tests.full_free);
    let end = |side| {
        units.root(
            index,
            profile::bound(problem, full, all, index, side, INTERVAL),
        )
    };
    let (lower, upper) = (end(Side::Lower), end(Side::Upper));
    Estimate {
        lower: own.lower.map(|l| l.min(lower)),
        upper: own.upper.map(|u| u.max(upper)),
        ..own
    }
}

/// Profile limit of a variance with every candidate free.
pub(super) fn limit(problem: &Problem, tests: &Tests, index: usize) -> f64 {
    let level = if index == B || index == K {
        INTERVAL
    } else {
        LIMIT
    };
    profile::bound(
        problem,
        &tests.full,
        &tests.full_free,
        index,
        Side::Upper,
        level,
    )
}

pub(super) fn gauss_markov_estimates(
    problem: &Problem,
    tests: &Tests,
    best: &Solution,
    free: &Free,
    covariance: Option<&(Vec<usize>, Vec<f64>)>,
    units: &Units,
) -> Vec<GaussMarkovEstimate> {
    let mut out = Vec::new();
    for g in 0..tests.gauss_markov {
        let at = FIRST_GM + 2 * g;
        // At an end of the range searched the process lies outside it, and so does its interval.
        if best.parameters[at] <= 0.0 || problem.time_at_edge(best.parameters[at + 1]) {
            continue;
        }
        if tests.flicker_confused && g + 1 == tests.gauss_markov {
            if tests.gauss_markov == 1 {
                let upper = profile::bound(problem, best, free, at, Side::Upper, LIMIT);
                out.push(GaussMarkovEstimate {
                    sigma: Estimate::limit(units.root(at, upper)),
                    correlation_time_s: Estimate::ABSENT,
                });
            }
            continue;
        }
        let sigma = interval(problem, best, free, at, covariance, |v| units.root(at, v));
        let log_time = best.parameters[at + 1];
        let lower = profile::bound(problem, best, free, at + 1, Side::Lower, INTERVAL);
        let upper = profile::bound(problem, best, free, at + 1, Side::Upper, INTERVAL);
        let spread = covariance
            .and_then(|(indices, m)| {
                let place = indices.iter().position(|&i| i == at + 1)?;
                Some(m[place * indices.len() + place].sqrt())
            })
            .unwrap_or((upper - lower) / 3.92);
        let time = units.time(log_time);
        out.push(GaussMarkovEstimate {
            sigma,
            correlation_time_s: Estimate::detected(
                time,
                units.time(lower),
                units.time(upper),
                time * spread,
            ),
        });
    }
    if out.is_empty() {
        // The largest limit over the correlation times searched.
        let at = FIRST_GM;
        let (low, high) = problem.log_time;
        let mut held = tests.full_free;
        held[at] = true;
        held[at + 1] = false;
        let mut worst = 0.0_f64;
        let points = 6;
        for i in 0..=points {
            let mut start = tests.full.parameters;
            start[at] = 0.0;
            start[at + 1] = low + (high - low) * f64::from(i) / f64::from(points);
            let fit = problem.fit_limited(&start, &held, 8);
            worst = worst.max(profile::bound(problem, &fit, &held, at, Side::Upper, LIMIT));
        }
        out.push(GaussMarkovEstimate {
            sigma: Estimate::limit(units.root(at, worst)),
            correlation_time_s: Estimate::ABSENT,
        });
    }
    out.sort_by(|a, b| {
        let time = |e: &GaussMarkovEstimate| e.correlation_time_s.value.unwrap_or(0.0);
        time(a).total_cmp(&time(b))
    });
    out
}

/// The line in time: its slope where it was taken in, else a limit of |R|.
fn ramp(
    work: &Work,
    active: &[Active],
    problem: &Problem,
    tests: &Tests,
    best: &Solution,
    free: &Free,
    wanted: bool,
) -> (Estimate, Option<f64>) {
    if !wanted {
        return (Estimate::ABSENT, None);
    }
    let unit = work.scale / work.step_s;
    let place = active.iter().position(|a| a.kind == ActiveKind::Ramp);
    let (extended, solution, free_set, at, found) = if let Some(place) = place {
        (problem.clone(), best.clone(), *free, place, true)
    } else {
        let mut columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
        columns.push(regress::line(&work.segments));
        let log = work.layout.sum(&work.segments, &columns, work.cut);
        let extended = Problem::new(&[&log], false);
        let fit = extended.fit(&tests.full.parameters, &tests.full_free);
        (extended, fit, tests.full_free, active.len(), false)
    };
    // The profile of a coefficient of the mean: the plain likelihood, noise terms free.
    let plain_keep: Vec<usize> = (0..extended.columns()).collect();
    let plain = extended.with_columns(&plain_keep, false);
    let solution = if found {
        plain.fit(&solution.parameters, &free_set)
    } else {
        solution
    };
    let value = solution.beta[0][at];
    let p = plain.columns();
    let sigma = solution.beta_covariance[0][at * p + at].sqrt();
    let mut warm = solution.parameters;
    let mut rise = |x: f64| {
        let fit = plain
            .with_held_column(at, x)
            .fit_limited(&warm, &free_set, 25);
        warm = fit.parameters;
        fit.objective - solution.objective
    };
    let upper = profile::search(value, sigma, Side::Upper, INTERVAL, true, &mut rise);
    let lower = profile::search(value, sigma, Side::Lower, INTERVAL, true, &mut rise);
    let without: Vec<usize> = (0..p).filter(|&i| i != at).collect();
    let ratio = plain
        .with_columns(&without, false)
        .fit(&solution.parameters, &free_set)
        .objective
        - solution.objective;
    let estimate = if found {
        let restricted = best.beta[0][at] * unit;
        Estimate::detected(restricted, lower * unit, upper * unit, sigma * unit)
    } else {
        Estimate::limit(lower.abs().max(upper.abs()) * unit)
    };
    (estimate, Some(ratio.max(0.0)))
}

fn sinusoids(work: &Work, fitted: &NoiseTerms, options: &FitOptions) -> Vec<SinusoidEstimate> {
    if !options.candidates.sinusoids {
        return Vec::new();
    }
    // Of lines within a few widths of each other (a line that is not quite constant) the strongest stands for all.
    let mut strongest: Vec<Line> = work.lines.clone();
    strongest.sort_by(|a, b| b.height.total_cmp(&a.height));
    let mut kept: Vec<Line> = Vec::new();
    for line in strongest {
        // Above a filter's corner there is no fit that a line could stand above.
        if line.u() > work.cut {
            continue;
        }
        let near = kept.iter().any(|k| {
            let width = (12.0 / (2.0 * k.n.min(line.n) as f64)).max(0.004 * k.u());
            (k.u() - line.u()).abs() < width
        });
        if !near && kept.len() < 16 {
            kept.push(line);
        }
    }
    kept.sort_by(|a, b| a.u().total_cmp(&b.u()));
    let white = fitted.white.powi(2) / work.step_s;
    kept.iter()
        .map(|line| {
            let x = std::f64::consts::PI * line.u();
            let gain = work.scale * x / x.sin();
            let (a, sigma) = (line.amplitude * gain, line.amplitude_sigma() * gain);
            let (f, spread) = (line.u() / work.step_s, line.u_sigma() / work.step_s);
            SinusoidEstimate {
                amplitude: Estimate::detected(
                    a,
                    (a - 1.96 * sigma).max(0.0),
                    a + 1.96 * sigma,
                    sigma,
                ),
                frequency_hz: Estimate::detected(f, f - 1.96 * spread, f + 1.96 * spread, spread),
                height: line.height,
                share_of_white: if white > 0.0 {
                    0.5 * (line.amplitude * work.scale).powi(2) / white
                } else {
                    f64::INFINITY
                },
            }
        })
        .collect()
}

fn describe(work: &Work, active: &[Active], best: &Solution) -> Vec<Regressor> {
    let p = active.len();
    active
        .iter()
        .enumerate()
        .filter_map(|(i, a)| {
            let kind = match a.kind {
                ActiveKind::Ramp => return None,
                ActiveKind::Temperature(power) => RegressorKind::Temperature { power },
                ActiveKind::WarmUp(tau) => RegressorKind::WarmUp {
                    time_constant_s: tau * work.step_s,
                },
                ActiveKind::Step(segment, at) => RegressorKind::Step {
                    time_s: work.segments[segment].start_s + at as f64 * work.step_s,
                },
            };
            let value = best.beta[0][i] * work.scale;
            let half = 1.96 * best.beta_covariance[0][i * p + i].sqrt() * work.scale;
            Some(Regressor {
                kind,
                value,
                lower: value - half,
                upper: value + half,
            })
        })
        .collect()
}

/// Names of the parameters in a covariance.
const NAMES: [&str; PARAMETERS] = ["Q", "N", "B", "K", "sigma1", "Tc1", "sigma2", "Tc2"];

pub(super) fn named_covariance(
    covariance: Option<&(Vec<usize>, Vec<f64>)>,
    parameters: &Parameters,
    units: &Units,
) -> Covariance {
    let Some((indices, matrix)) = covariance else {
        return Covariance::default();
    };
    let n = indices.len();
    // From variances and ln T_c to the terms themselves.
    let slope: Vec<f64> = indices
        .iter()
        .map(|&i| {
            if super::likelihood::is_time(i) {
                units.time(parameters[i])
            } else {
                units.root(i, parameters[i]) / (2.0 * parameters[i])
            }
        })
        .collect();
    let mut out = matrix.clone();
    for i in 0..n {
        for j in 0..n {
            out[i * n + j] *= slope[i] * slope[j];
        }
    }
    Covariance {
        names: indices.iter().map(|&i| NAMES[i].to_string()).collect(),
        matrix: out,
    }
}

/// Measured and fitted densities of every bin, those above a filter's corner included.
fn spectrum_bins(work: &Work, active: &[Active], best: &Solution) -> Vec<SpectrumBin> {
    let columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
    let log: BinnedLog = work.layout.sum(&work.segments, &columns, 0.5);
    let whole = Problem::new(&[&log], false);
    let power = whole.residual_power(best);
    let fit = whole.spectrum(&best.parameters);
    let unit = work.scale * work.scale * work.step_s;
    let mut out: Vec<SpectrumBin> = (0..whole.u.len())
        .map(|b| SpectrumBin {
            frequency_hz: whole.u[b] / work.step_s,
            measured: power[b] * unit,
            fitted: fit[b] * unit,
            count: whole.count[b],
            used: whole.u[b] <= work.cut,
        })
        .collect();
    out.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    out
}
