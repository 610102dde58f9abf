//! From one axis to its estimates: transform, lines, filter, regressors, tests, intervals.
//!
//! Order: coefficients; lines out; frequencies above a filter's corner out; regressors and Gauss–Markov terms taken in
//! one by one, the clearest first; then every term tested with all others free. Source: [Whittle1953] and the tests'
//! own files.

use super::bins::{Column, Layout, SegmentSpectrum};
use super::checks;
use super::coarse::Coarse;
use super::cumulant;
use super::ends;
use super::fill::{FittedSpectrum, is_long_for_its_losses};
use super::goodness;
use super::likelihood::{B, Free, K, N, Parameters, Problem, Q, Solution};
use super::lines::{self, Line, LocalNoise};
use super::profile;
use super::results::{
    Units, beside_columns, coefficients_below_corner, describe, gauss_markov_estimates,
    named_covariance, ramp, spectrum_bins,
};
use super::select;
use super::singles::Tested;
use super::sinusoids::sinusoids;
use super::steps::{self, Steps};
use super::transform::transform;
use super::types::{
    AxisData, AxisEstimate, Candidates, Covariance, Estimate, Finding, FindingKind, FitOptions,
    GaussMarkovEstimate, NoiseTerms, Segment,
};
use std::cell::LazyCell;

const MOST_LINES: usize = 24;
/// Below this duration B, K, R and Gauss–Markov terms are bounded only.
pub(super) const SHORT_S: f64 = 100.0;
/// Likelihood ratio from which a B or K with too few coefficients is told of: 0.1 % of absent ones reach it. Below, it is
/// not seen at all, and its limit stands as that of any other.
const NAMED_RATIO: f64 = 9.5;
/// The same of all slow terms together, where each alone leaves the others what it explains.
const CERTAIN_RATIO: f64 = 25.0;
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
    /// Samples, filled ones among them.
    pub samples: usize,
    /// Filled samples.
    pub filled: usize,
    /// Mean of those that were not filled.
    pub mean: f64,
    /// Steps inside segments that were found between them: segment, sample.
    pub given: Vec<steps::Place>,
}

/// A regressor that is in the fit.
#[derive(Clone)]
pub(super) struct Active {
    pub kind: ActiveKind,
    pub column: Column,
    /// 2 Δ ln L from which it is kept.
    pub threshold: f64,
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
    pub steps: Steps,
    /// The line and the powers of the temperature that were not taken in.
    pub possible: Vec<Column>,
}

/// The joint estimate of one axis.
///
/// Any input gives an answer: what cannot be known is an upper limit or absent, and why is in `findings`. For white noise
/// and random walk the likelihood is exact; biases, coverage and efficiency are measured by `tools/fidelity.py`.
///
/// ```
/// use sagnac_analysis::fit::{AxisData, FitOptions, Segment, estimate};
/// let samples: Vec<f64> = (0..4000).map(|k| ((k * 7919 % 1000) as f64 / 500.0 - 1.0) * 1e-3).collect();
/// let segments = [Segment { start_s: 0.0, samples: &samples, filled: &[] }];
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
        gauss_markov: vec![GaussMarkovEstimate::ABSENT],
        sinusoids: Vec::new(),
        confused: Vec::new(),
        regressors: Vec::new(),
        levels: Vec::new(),
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

/// Why a log has no scale of its noise.
fn why_no_noise(segments: &[Segment<'_>]) -> String {
    let all = || segments.iter().flat_map(|s| s.samples);
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &y| {
        (l.min(y), h.max(y))
    });
    let size = if high > low {
        0.5 * high - 0.5 * low
    } else {
        0.0
    };
    if size == 0.0 {
        return "the values do not change: no noise can be seen".to_owned();
    }
    let side = if size < 1.0 { "small" } else { "large" };
    format!(
        "the values change by {:.1e}, too {side} for a number to hold its square: look at the unit",
        2.0 * size
    )
}

/// Transforms the log, takes lines, filters and regressors into account and finds the best fit of all candidates.
pub(super) fn prepare(
    data: &AxisData<'_>,
    options: &FitOptions,
) -> Result<Prepared, Box<AxisEstimate>> {
    let mut samples: usize = data.segments.iter().map(|s| s.samples.len()).sum();
    if samples < FEWEST {
        let text = format!("{samples} samples are too few for parameters; 64 are needed");
        return Err(Box::new(nothing(data, &text)));
    }
    let kept: Vec<usize> = (0..data.segments.len())
        .filter(|&i| {
            data.segments[i].samples.len() >= 8 && is_long_for_its_losses(&data.segments[i])
        })
        .collect();
    if data.segments.iter().any(|s| !s.filled.is_empty()) {
        samples = kept.iter().map(|&i| data.segments[i].samples.len()).sum();
        if samples < FEWEST {
            let text = "too many samples are lost: what is left stands in stretches too short for parameters";
            return Err(Box::new(nothing(data, text)));
        }
    }
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
        return Err(Box::new(nothing(data, &why_no_noise(&segments))));
    };
    let mut candidates = options.candidates;
    // What disturbed a log is told from all its noise: what a caller leaves out would pass for steps and warm-ups.
    let mut all = Candidates {
        sinusoids: candidates.sinusoids,
        ..if options.data_checks {
            Candidates::default()
        } else {
            candidates
        }
    };
    if longest_s(&segments, data.step_s) < SHORT_S {
        for c in [&mut candidates, &mut all] {
            c.ramp = false;
            c.gauss_markov = 0;
        }
    }

    // The ends of quantization noise, lines, then a filter's corner, then lines below it alone.
    let mut grown;
    let (mut rounds, mut ends_rounds) = (0, 0);
    loop {
        let log = work.layout.sum(&work.segments, &[], work.cut);
        let problem = Problem::new(&[&log], false);
        grown = select::grow(&problem, &all);
        work.layout.fast = problem.is_fast(&grown.0.parameters);
        if all.quantization
            && ends_rounds < ends::MOST_ROUNDS
            && ends::take_out(&mut work, &segments, &problem, &grown.0)
        {
            ends_rounds += 1;
            continue;
        }
        rounds += 1;
        if all.sinusoids && rounds <= 8 && take_lines(&mut work, &grown.0.parameters) {
            continue;
        }
        if !options.data_checks {
            break;
        }
        if work.cut < 0.5 {
            let Some(cut) = checks::lower_corner(&work, &problem, &grown.0) else {
                break;
            };
            work.cut = cut;
        } else if let Some(cut) = checks::filter_corner(&work, &problem, (&grown.0, &grown.1), &all)
        {
            // What stood above the fit of the whole spectrum was no line: that fit is void.
            if let Some(anew) = transform(&segments, data.step_s, samples) {
                work = anew;
            }
            work.cut = cut;
            (rounds, ends_rounds) = (0, 0);
        } else {
            break;
        }
        // Its mark is the top of the spectrum, which is gone; below the corner a resonance of the filter passes for it.
        all.quantization = false;
        candidates.quantization = false;
    }
    let ((mut active, mut grown, mut problem, possible), steps) = steps::chosen(
        &mut work,
        &segments,
        temperature.as_deref(),
        &all,
        options,
        &grown,
    );
    // A drift across a step of the grid changes the mean by that step: none that the sensor made.
    if options.data_checks
        && let Some(coarse) = Coarse::of(data)
        && (steps.any_below(&work, 2.0 * coarse.step)
            || active.iter().enumerate().any(|(i, a)| {
                let size = grown.0.beta[0].get(i).map_or(0.0, |b| b.abs() * work.scale);
                matches!(a.kind, ActiveKind::Step(..) | ActiveKind::WarmUp(_))
                    && size < 2.0 * coarse.step
            }))
    {
        let unchecked = FitOptions {
            data_checks: false,
            ..*options
        };
        return prepare(data, &unchecked);
    }
    if candidates != all {
        active.retain(|a| candidates.ramp || a.kind != ActiveKind::Ramp);
        let columns: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
        let log = work.layout.sum(&work.segments, &columns, work.cut);
        problem = Problem::new(&[&log], !active.is_empty());
        grown = select::grow(&problem, &candidates);
    }
    let possible = possible
        .into_iter()
        .filter(|(kind, _)| candidates.ramp || *kind != ActiveKind::Ramp)
        .map(|(_, column)| column)
        .collect();
    Ok(Prepared {
        work,
        active,
        candidates,
        problem,
        grown,
        steps,
        possible,
    })
}

impl Work {
    /// The spectrum of these parameters as this log shows it.
    pub(super) fn fitted(&self, parameters: &Parameters) -> FittedSpectrum<'_> {
        FittedSpectrum::new(parameters, self.layout.fill.as_deref())
    }

    /// The noise that lines of segment `s` stand above: below the cut the fit, above it what the log itself shows.
    pub(super) fn levels(&self, s: usize, parameters: &Parameters) -> Vec<LocalNoise> {
        let n = self.segments[s].n;
        let fitted = self.fitted(parameters);
        let wanted = lines::threshold(n);
        let at = |j: f64| j / (2.0 * n as f64);
        let mut out: Vec<LocalNoise> = self
            .layout
            .spans(s)
            .map(|(first, end)| (first, end, at(0.5 * (first + end - 1) as f64)))
            .take_while(|span| span.2 <= self.cut)
            .map(|(first, end, u)| LocalNoise {
                first,
                end,
                level: fitted.at(u).max(1e-300),
                wanted,
            })
            .collect();
        if self.cut < 0.5 {
            let from = out.last().map_or(1, |l| l.end);
            out.extend(lines::local_levels(&self.segments[s].coefficients, from));
        }
        out
    }
}

/// Looks for lines above the noise; whether any was taken out.
fn take_lines(work: &mut Work, parameters: &Parameters) -> bool {
    let mut any = false;
    let mut lines = std::mem::take(&mut work.lines);
    for s in 0..work.segments.len() {
        if work.segments[s].n < 128 {
            continue;
        }
        let levels = work.levels(s, parameters);
        let (mut own, others) = lines.into_iter().partition(|l: &Line| l.segment == s);
        any |= lines::take_out(&mut work.segments[s], s, &levels, &mut own, MOST_LINES);
        lines = others;
        lines.append(&mut own);
    }
    work.lines = lines;
    any
}

/// The longest stretch of samples without a gap, filled ones counted, in s.
fn longest_s(segments: &[Segment<'_>], step_s: f64) -> f64 {
    let longest = segments.iter().map(|s| s.samples.len()).max();
    longest.unwrap_or(0) as f64 * step_s
}

/// Tests the terms, finds intervals and limits, and says what the data show.
fn conclude(data: &AxisData<'_>, options: &FitOptions, prepared: Prepared) -> AxisEstimate {
    let Prepared {
        work,
        active,
        candidates,
        problem,
        grown,
        steps,
        possible,
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
    let (best, free) = tests.final_fit(&problem, &candidates);
    let stretch_s = longest_s(data.segments, data.step_s);
    let short = stretch_s < SHORT_S;
    if short {
        let text = if duration_s < SHORT_S {
            format!("{duration_s:.0} s are too short for slow terms: they are bounded only")
        } else {
            format!(
                "no unbroken stretch reaches {SHORT_S:.0} s, the longest has {} s: slow terms are bounded only",
                checks::digits(stretch_s)
            )
        };
        findings.push(whole_log(FindingKind::Short, Some(stretch_s), text));
    }
    // Terms that pass but that so few coefficients or so coarse steps cannot carry: bounded only.
    let mut bounded = [false; 4];
    // Slow terms that are there for certain, and would each do, may be none of them.
    let slow = LazyCell::new(|| tests.ratio_of_slow(&problem));
    let instead = || {
        (*slow >= CERTAIN_RATIO)
            .then(|| checks::step_instead(&work, &active, &best, *slow))
            .flatten()
            .map(|time_s| format!("; one step at {time_s:.1} s would do as well"))
    };
    if tests.confused
        && let Some(instead) = instead()
    {
        let text = format!(
            "flicker noise and random walk cannot be told apart: both are bounded only{instead}"
        );
        findings.push(whole_log(FindingKind::Short, None, text));
    }
    for k in [B, K] {
        if !tests.passed[k] || tests.is_confused(k) {
            continue;
        }
        let few = coefficients_below_corner(&problem, &best.parameters, k);
        if short || few < 10.0 {
            bounded[k] = true;
            let is_alone = !tests.passed[B + K - k] && tests.gauss_markov == 0;
            if !short && (tests.ratios[k] >= NAMED_RATIO || is_alone && *slow >= CERTAIN_RATIO) {
                let name = if k == B {
                    "flicker noise"
                } else {
                    "random walk"
                };
                let text = format!(
                    "{few:.0} coefficients below its corner are too few for {name}: bounded only{}",
                    instead().unwrap_or_default()
                );
                findings.push(whole_log(FindingKind::Short, Some(few), text));
            }
        }
    }
    let coarse = Coarse::of(data);
    if let Some((finding, coarse)) = checks::rounding(data, end_s) {
        findings.push(finding);
        if coarse {
            bounded[Q] = true;
            bounded[N] = true;
        }
    }

    let allowed = candidates.singles();
    let mut covariance = profile::covariance(&problem, &best, &free);
    let quantization = cumulant::apply(
        &mut covariance,
        best.parameters[Q],
        cumulant::excess(data.segments, best.parameters[Q] * work.scale * work.scale),
        work.samples - work.filled,
    );
    let alternative = tests.alternative(&problem, &candidates);
    let tested = Tested {
        problem: &problem,
        tests: &tests,
        best: &best,
        free: &free,
        covariance: covariance.as_ref(),
        alternative: alternative.as_ref(),
        units: &units,
    };
    let mut single = tested.singles(allowed, bounded, quantization);
    let mut gauss_markov = if options.candidates.gauss_markov == 0 || short && work.samples < 160 {
        vec![GaussMarkovEstimate::ABSENT]
    } else {
        gauss_markov_estimates(&tested)
    };

    for at in problem.surely_fast(&best, &free) {
        let time = units.time(best.parameters[at + 1]);
        findings.push(checks::fast_process(time, end_s, work.samples));
    }

    if let Some(coarse) = &coarse {
        coarse.bound(&mut single, &mut gauss_markov);
    }

    single[K] = beside_columns(&work, &active, &possible, &best, &free, single[K], &units);
    let mut fitted = units.terms(&best.parameters);
    let mut ratios = [None; 5];
    for k in 0..4 {
        ratios[k] = allowed[k].then_some(tests.ratios[k]);
    }
    let (mut ramp, ratio) = ramp(
        &work,
        &active,
        &problem,
        &tests,
        &best,
        &free,
        options.candidates.ramp,
    );
    ratios[4] = ratio;
    if let Some(coarse) = &coarse {
        ramp = coarse.slope(ramp);
    }
    fitted.ramp = ramp.value.unwrap_or(0.0);

    // Goodness of fit of the bins used, and the spectrum for people to look at.
    let power = problem.residual_power(&best);
    let fit = problem.spectrum(&best.parameters);
    let parameters = free.iter().filter(|&&f| f).count() + active.len();
    let p_value = goodness::p_value(&power, &fit, &problem.plain_count(), parameters);
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
    let sinusoids = if options.candidates.sinusoids {
        sinusoids(&work, &best.parameters, &fitted)
    } else {
        Vec::new()
    };
    for line in &sinusoids {
        if line.share_of_white > 0.1
            && let Some(f) = line.frequency_hz.value
        {
            findings.push(whole_log(
                FindingKind::Line,
                Some(f),
                checks::line_text(line),
            ));
        }
    }
    fitted.sinusoids = sinusoids
        .iter()
        .filter_map(|s| s.amplitude.value.zip(s.frequency_hz.value))
        .collect();
    if work.cut < 0.5 {
        let corner = work.cut / work.step_s;
        let mut text = format!(
            "not white above {} Hz: those frequencies leave the fit, white noise is from below",
            checks::digits(corner)
        );
        if options.candidates.quantization && !candidates.quantization {
            text += "; quantization noise cannot be looked for there";
        }
        findings.push(whole_log(FindingKind::Filtered, Some(corner), text));
    }
    let mut regressors = describe(&work, &active, &problem, &best, &free);
    regressors.extend(steps.regressors(&work, &active, &best));
    findings.extend(steps.findings(&work, &active, &best));
    findings.extend(checks::regressor_findings(
        &work, &active, &best, data, end_s,
    ));
    // Where a step hides the noise, the scatter is a matter of where the mean stands.
    if options.data_checks
        && coarse.is_none()
        && let Some(finding) = checks::non_stationary(data)
    {
        findings.push(finding);
    }

    // Of two rivals that are not told apart the one that lets the mean scatter more counts.
    let mut variance = alternative
        .iter()
        .map(|(fit, _)| units.terms(&fit.parameters))
        .map(|other| other.mean_variance(duration_s, work.step_s))
        .fold(fitted.mean_variance(duration_s, work.step_s), f64::max);
    if work.filled > 0 {
        // White noise of the samples that are there.
        let used_s = (work.samples - work.filled) as f64 * work.step_s;
        variance += fitted.white.powi(2) * (1.0 / used_s - 1.0 / duration_s);
    }
    variance += coarse.map_or(0.0, |c| c.mean_variance());
    let error = variance.sqrt();
    let mean = Estimate::detected(
        work.mean,
        work.mean - 1.96 * error,
        work.mean + 1.96 * error,
        error,
    );
    findings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    AxisEstimate {
        samples: work.samples - work.filled,
        step_s: work.step_s,
        duration_s,
        mean,
        quantization: single[Q],
        white: single[N],
        flicker: single[B],
        random_walk: single[K],
        ramp,
        covariance: named_covariance(
            covariance.as_ref(),
            &best.parameters,
            &units,
            &single,
            &gauss_markov,
        ),
        gauss_markov,
        sinusoids,
        confused: tests.pairs(),
        regressors,
        levels: steps.levels(&fitted, work.step_s),
        p_value,
        findings,
        spectrum: spectrum_bins(&work, &active, &best),
        fitted,
        likelihood_ratios: ratios,
    }
}
