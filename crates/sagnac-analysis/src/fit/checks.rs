//! What the data show beside noise: a filter, a step, warm-up, changing scatter, coarse rounding, a model that fails.
//!
//! Thresholds: a step or a warm-up those of `columns`; a changing scatter > 10 % and > 6 of its own standard errors; a
//! filter leaves the top octave under the white level and falling, and a spectrum that no mixture of the terms explains.

use super::coarse::is_coarse;
use super::estimate::{Active, ActiveKind, Work};
use super::fill::FittedSpectrum;
use super::goodness;
use super::likelihood::{B, FIRST_GM, Free, K, N, Parameters, Problem, Solution};
use super::select;
use super::steps;
use super::types::{AxisData, Candidates, Finding, FindingKind, Segment, SinusoidEstimate};
use realfft::RealFftPlanner;
use std::f64::consts::PI;
use std::ops::Range;

/// The corner (in u) below which the terms explain the spectrum, where the log was filtered.
pub(super) fn filter_corner(
    work: &Work,
    problem: &Problem,
    (solution, free): (&Solution, &Free),
    candidates: &Candidates,
) -> Option<f64> {
    // A log that its terms explain is not filtered, unless a low-pass is what they describe.
    let power = problem.residual_power(solution);
    let fit = problem.spectrum(&solution.parameters);
    let p = goodness::p_value(&power, &fit, &problem.plain_count(), 4)?;
    if p > 1e-4 && !problem.is_low_pass(solution, free) {
        return None;
    }
    let band = |low: f64, high: f64, values: &[f64]| {
        let (mut sum, mut count) = (0.0, 0.0);
        for b in 0..values.len() {
            if problem.u[b] >= low && problem.u[b] < high {
                sum += problem.count[b] * values[b] / problem.basis(N)[b];
                count += problem.count[b];
            }
        }
        (sum / count, count)
    };
    let (top, top_count) = band(0.25, 0.5, &power);
    let (high, _) = band(0.4, 0.5, &power);
    let (low, _) = band(0.25, 0.35, &power);
    let (below, _) = band(0.125, 0.25, &power);
    // A moving average of three rises again from its zero at a third of the rate.
    let falls = high < low || top < 0.5 * below;
    if top_count < 32.0 || !falls {
        return None;
    }
    let mut plain = *candidates;
    plain.gauss_markov = candidates.gauss_markov.min(1);
    plain.quantization = false;
    let mut cut = 0.5;
    let mut likeliest: Option<(f64, f64)> = None;
    while cut > LEAST_CORNER {
        cut *= std::f64::consts::FRAC_1_SQRT_2;
        let log = work.layout.sum(&work.segments, &[], cut);
        let part = Problem::new(&[&log], false);
        if part.coefficients() < 200.0 {
            break;
        }
        let (fit, _, _) = select::grow(&part, &plain);
        if top >= TOP_SHARE * fit.parameters[N] {
            continue;
        }
        let measured = part.residual_power(&fit);
        let model = part.spectrum(&fit.parameters);
        let p = goodness::p_value(&measured, &model, &part.plain_count(), 3).unwrap_or(1.0);
        if p > 0.01 || top_agrees(&part, &measured, &model, cut) {
            return Some(cut);
        }
        if likeliest.is_none_or(|best| p > best.1) {
            likeliest = Some((cut, p));
        }
    }
    likeliest.filter(|best| best.1 > 1e-4).map(|best| best.0)
}

/// The next lower band, where the filter's fall still reaches below `work.cut`: an octave down.
///
/// Every low-pass falls with u² or faster, so what the octave above the cut lacks bounds what the band below lacks.
pub(super) fn lower_corner(work: &Work, problem: &Problem, solution: &Solution) -> Option<f64> {
    let (cut, next) = (work.cut, 0.5 * work.cut);
    let inside = problem.coefficients();
    if next < LEAST_CORNER || 0.5 * inside < 200.0 {
        return None;
    }
    let high = (2.0 * cut).min(0.5);
    let log = work.layout.sum(&work.segments, &[], high);
    let wider = Problem::new(&[&log], false);
    let power = wider.residual_power(solution);
    let model = wider.spectrum(&solution.parameters);
    let (mut sum, mut count) = (0.0, 0.0);
    for b in 0..power.len() {
        if wider.u[b] > cut {
            sum += wider.count[b] * power[b] / model[b];
            count += wider.count[b];
        }
    }
    if count == 0.0 {
        return None;
    }
    // Mean fall ∝ u² of the band and of the octave above it; the fit already lies lower by the former.
    let below = cut * cut / 3.0;
    let above = (high * high + high * cut + cut * cut) / 3.0;
    let droop = (1.0 - sum / count) * below / (above - below);
    let matters = (DROOP_SHARE * (2.0 / inside).sqrt()).max(LEAST_DROOP);
    (droop > matters).then_some(next)
}

/// Part of the white level's own standard error that a filter may take from it.
const DROOP_SHARE: f64 = 0.2;
/// Share of the white level (of power) that a filter may always take: in a log of a million samples less would cost decades
/// of the band, and the lines and slow terms in them.
const LEAST_DROOP: f64 = 0.003;
/// Share by which the fit may miss half an octave below a corner, however many coefficients see it.
const TOP_TOLERANCE: f64 = 0.03;

/// Whether the fit describes the two octaves below a corner: what it misses further down is no filter's work.
fn top_agrees(problem: &Problem, measured: &[f64], model: &[f64], cut: f64) -> bool {
    (0..4).all(|half| {
        let high = cut * f64::exp2(-0.5 * f64::from(half));
        let low = high * std::f64::consts::FRAC_1_SQRT_2;
        let (mut sum, mut count) = (0.0, 0.0);
        for b in 0..measured.len() {
            if problem.u[b] > low && problem.u[b] <= high {
                sum += problem.count[b] * measured[b] / model[b];
                count += problem.count[b];
            }
        }
        count > 0.0 && (sum / count - 1.0).abs() < (3.3 * (2.0 / count).sqrt()).max(TOP_TOLERANCE)
    })
}

/// Lowest corner looked for, in u.
const LEAST_CORNER: f64 = 0.002;
/// Share of the white level below which the top octave is that of a filter: -1 dB, named only where the terms fail.
const TOP_SHARE: f64 = 0.8;

/// Three significant digits, in plain notation from 0.0001 to 999 999.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !(1e-4..1e6).contains(&size) {
        return if size == 0.0 {
            "0".to_string()
        } else {
            format!("{value:.2e}")
        };
    }
    let places = (2 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// What is said of a strong line.
pub(super) fn line_text(line: &SinusoidEstimate) -> String {
    let mut text = format!(
        "a line at {:.6} Hz with amplitude {}",
        line.frequency_hz.value.unwrap_or(0.0),
        digits(line.amplitude.value.unwrap_or(0.0))
    );
    if !line.is_steady {
        text += ", which is not constant";
    }
    if line.is_filtered {
        text += ", as the filter has left it";
    }
    text + "; it may be an alias of a higher frequency"
}

/// Most coefficients and places of the search for a step. Coarser places than the noise can tell apart count the choice too
/// low: at 1024, 8 % of logs of 1 h with a random walk had a false step.
const STEP_PLACES: usize = 1 << 16;

/// Where a step is likeliest.
pub(super) struct StepPlaces {
    /// Segment and sample: of the whole spectrum, and of white noise nearby.
    pub places: [(usize, usize); 2],
    /// 2 ln of the mean likelihood over all places over the largest: how far the noise lets the place be chosen.
    pub choice: f64,
}

/// Score of a step against the fitted noise from which it is worth a fit.
const WORTH_A_FIT: f64 = 9.0;

/// The likeliest places of a step, where its score against the fitted noise is worth a fit.
pub(super) fn find_step(
    work: &Work,
    segments: &[Segment<'_>],
    active: &[Active],
    now: &Solution,
) -> Option<StepPlaces> {
    let scores = step_scores(work, active, now, &now.parameters);
    let best = scores.iter().max_by(|a, b| a.value.total_cmp(&b.value))?;
    if best.value <= WORTH_A_FIT {
        return None;
    }
    let (s, at) = best.place;
    let (sum, weight) = scores.iter().fold((0.0, 0.0), |(sum, weight), score| {
        let likelihood = (0.5 * (score.value - best.value)).exp();
        (sum + score.samples * likelihood, weight + score.samples)
    });
    Some(StepPlaces {
        places: [
            (s, at),
            (
                s,
                sharpen(work, &segments[s], (s, at), near(work, (s, at)), now),
            ),
        ],
        choice: 2.0 * (sum / weight).ln(),
    })
}

/// When a step took place, from the log's start, that beside the fast terms of `now` alone explains the log as well as its
/// slow terms do (2 Δ ln L `slow`).
pub(super) fn step_instead(
    work: &Work,
    active: &[Active],
    now: &Solution,
    slow: f64,
) -> Option<f64> {
    let mut fast = now.parameters;
    for k in [B, K, FIRST_GM, FIRST_GM + 2] {
        fast[k] = 0.0;
    }
    let scores = step_scores(work, active, now, &fast);
    let best = scores.iter().max_by(|a, b| a.value.total_cmp(&b.value))?;
    let (s, at) = best.place;
    (best.value >= slow).then_some(work.segments[s].start_s + at as f64 * work.step_s)
}

/// What a step at a place adds.
struct StepScore {
    /// 2 Δ ln L given the noise.
    value: f64,
    place: steps::Place,
    /// Samples that the place stands for.
    samples: f64,
}

/// The score of a step at every place, with the noise of these parameters.
fn step_scores(
    work: &Work,
    active: &[Active],
    now: &Solution,
    parameters: &Parameters,
) -> Vec<StepScore> {
    let mut scores = Vec::new();
    let mut planner = RealFftPlanner::new();
    for (s, segment) in work.segments.iter().enumerate() {
        let n = segment.n;
        let edge = ((0.02 * work.samples as f64) as usize).max(10);
        if n < 2 * edge + 10 || n < 128 {
            continue;
        }
        let reach = STEP_PLACES.min(n);
        let fitted = work.fitted(parameters);
        let spectrum: Vec<f64> = (0..reach)
            .map(|j| {
                if j == 0 {
                    return f64::INFINITY;
                }
                fitted.at(j as f64 / (2.0 * n as f64)).max(1e-300)
            })
            .collect();
        let residual: Vec<f64> = (0..reach)
            .map(|j| {
                let mut c = segment.coefficients[j];
                for (i, a) in active.iter().enumerate() {
                    c -= now.beta[0][i] * a.column[s].get(j).copied().unwrap_or(0.0);
                }
                c
            })
            .collect();
        let weight: Vec<f64> = (0..reach)
            .map(|j| {
                if j == 0 {
                    return 0.0;
                }
                -(2.0 / n as f64).sqrt() * 0.5 / (PI * j as f64 / (2.0 * n as f64)).sin()
            })
            .collect();
        // Σ front·sin(πjp/places) and Σ energy·sin²(πjp/places) at every place by two transforms.
        let places = STEP_PLACES.min(n);
        let plan = planner.plan_fft_forward(2 * places);
        let fold = |values: &dyn Fn(usize) -> f64| {
            let mut input = vec![0.0; 2 * places];
            for j in 1..reach {
                input[j % (2 * places)] += values(j);
            }
            let mut output = plan.make_output_vec();
            // The lengths are the plan's own: this cannot fail.
            plan.process(&mut input, &mut output).ok().map(|()| output)
        };
        let front = fold(&|j| residual[j] * weight[j] / spectrum[j]);
        let energy = fold(&|j| weight[j] * weight[j] / spectrum[j]);
        let (Some(front), Some(energy)) = (front, energy) else {
            continue;
        };
        let score = |place: usize| {
            let h = -front[place].im;
            let double = 2 * place;
            let even = energy[double.min(2 * places - double)].re;
            let m = 0.5 * (energy[0].re - even);
            if m > 0.0 { h * h / m } else { 0.0 }
        };
        let first = (edge * places).div_ceil(n).max(1);
        let end = places - first;
        scores.extend((first..end).map(|place| StepScore {
            value: score(place),
            place: (s, place * n / places),
            samples: n as f64 / places as f64,
        }));
    }
    scores
}

/// The samples that one of the places searched stands for.
fn near(work: &Work, (s, at): (usize, usize)) -> Range<usize> {
    let n = work.segments[s].n;
    let coarse = n / STEP_PLACES.min(n) + 1;
    at.saturating_sub(2 * coarse)..(at + 2 * coarse).min(n)
}

/// The sample of a range around a coarse place between whose sides the means differ most, weighed as white noise.
pub(super) fn sharpen(
    work: &Work,
    segment: &Segment<'_>,
    (s, at): (usize, usize),
    around: Range<usize>,
    now: &Solution,
) -> usize {
    let n = work.segments[s].n;
    let coarse = around.len().div_ceil(4);
    let (from, to) = (around.start, around.end.min(n));
    // Where white noise gives way to slower terms the means compared need not be longer.
    let white = now.parameters[N];
    let fitted = FittedSpectrum::new(&now.parameters, None);
    let knee = (1..16)
        .map(|k| 0.25 / f64::from(1 << k))
        .find(|&u| fitted.at(u) > 2.0 * white)
        .unwrap_or(1e-4);
    let half = ((0.25 / knee) as usize).clamp(4 * coarse, 64 * coarse + 64);
    let samples = segment.samples;
    let (low, high) = (from.saturating_sub(half), (to + half).min(n));
    let mut sums = vec![0.0];
    for y in &samples[low..high] {
        sums.push(sums[sums.len() - 1] + (y - samples[low]));
    }
    let mut best = (0.0, at);
    for k in from.max(low + 1)..to.min(high - 1) {
        let (a, b) = (k.saturating_sub(half).max(low), (k + half).min(high));
        let (left, right) = ((k - a) as f64, (b - k) as f64);
        let change =
            (sums[b - low] - sums[k - low]) / right - (sums[k - low] - sums[a - low]) / left;
        let score = change * change / (1.0 / left + 1.0 / right);
        if score > best.0 {
            best = (score, k);
        }
    }
    best.1
}

/// Findings of the regressors that were taken in but steps.
pub(super) fn regressor_findings(
    work: &Work,
    active: &[Active],
    best: &Solution,
    data: &AxisData<'_>,
    end_s: f64,
) -> Vec<Finding> {
    let mut out = Vec::new();
    for (i, a) in active.iter().enumerate() {
        let height = best.beta[0][i] * work.scale;
        match a.kind {
            ActiveKind::WarmUp(tau) => {
                let time = tau * work.step_s;
                let end = (5.0 * time).min(end_s);
                let hint = if data.temperature.is_none() {
                    "; no temperature was recorded"
                } else {
                    ""
                };
                out.push(Finding {
                    kind: FindingKind::WarmUp,
                    start_s: 0.0,
                    end_s: end,
                    count: (end / work.step_s) as usize,
                    size: Some(height),
                    text: format!(
                        "settles by {} with a time of {time:.0} s from the start{hint}",
                        digits(height)
                    ),
                });
            }
            ActiveKind::Ramp | ActiveKind::Temperature(_) | ActiveKind::Step(..) => {}
        }
    }
    out
}

/// A process too fast to be told from what a filter leaves: white noise is what lies beside it.
pub(super) fn fast_process(time_s: f64, end_s: f64, samples: usize) -> Finding {
    Finding {
        kind: FindingKind::Misfit,
        start_s: 0.0,
        end_s,
        count: samples,
        size: Some(time_s),
        text: format!(
            "samples up to {} s apart belong together more than white noise does (a process faster than ten samples): white noise is what lies beside that, the process is not reported",
            digits(time_s)
        ),
    }
}

/// Where the model fails most: the octave with the largest excess of deviance.
pub(super) fn misfit(
    problem: &Problem,
    power: &[f64],
    fit: &[f64],
    step_s: f64,
    end_s: f64,
    samples: usize,
) -> Finding {
    let mut octaves: Vec<(i32, f64, f64)> = Vec::new();
    for b in 0..power.len() {
        let octave = problem.u[b].log2().floor() as i32;
        let n = problem.count[b];
        match octaves.iter_mut().find(|o| o.0 == octave) {
            Some(o) => {
                o.1 += n * power[b] / fit[b];
                o.2 += n;
            }
            None => octaves.push((octave, n * power[b] / fit[b], n)),
        }
    }
    let worst = octaves
        .iter()
        .map(|&(octave, sum, n)| (octave, sum / n, (sum / n - 1.0).abs() * (n / 2.0).sqrt()))
        .max_by(|a, b| a.2.total_cmp(&b.2));
    let (low, ratio) = worst.map_or((0.0, 1.0), |(octave, ratio, _)| {
        (f64::from(octave).exp2() / step_s, ratio)
    });
    let percent = (100.0 * (ratio - 1.0)).round();
    let far = match percent {
        ..0.0 => format!("it lies {} % below the fit", -percent),
        0.0..200.0 => format!("it lies {percent} % above the fit"),
        _ => format!("it is {} times the fit", digits(ratio)),
    };
    Finding {
        kind: FindingKind::Misfit,
        start_s: 0.0,
        end_s,
        count: samples,
        size: Some(low),
        text: format!(
            "no mixture of the terms looked for explains the spectrum (p < 0.001): from {} to {} Hz {far}; intervals are conditional",
            digits(low),
            digits(2.0 * low),
        ),
    }
}

/// Scatter of first differences over √2 of a range of a segment, robust or (for coarse steps) clipped; filled samples,
/// which lie on lines, are left out.
fn difference_scatter(
    segment: &Segment<'_>,
    range: Range<usize>,
    lsb: Option<f64>,
    most: usize,
) -> (f64, usize) {
    let samples = &segment.samples[range.clone()];
    let pairs = samples.len().saturating_sub(1);
    let stride = pairs.div_ceil(most).max(1);
    let is_filled = |k: usize| {
        let run = segment.filled.partition_point(|r| r.end <= k);
        segment.filled.get(run).is_some_and(|r| r.start <= k)
    };
    let mut differences: Vec<f64> = (0..pairs)
        .step_by(stride)
        .filter(|k| !is_filled(range.start + k) && !is_filled(range.start + k + 1))
        .map(|k| (samples[k + 1] - samples[k]).abs())
        .collect();
    let n = differences.len();
    if n == 0 {
        return (0.0, 0);
    }
    let (_, &mut median, _) = differences.select_nth_unstable_by(n / 2, f64::total_cmp);
    let robust = 1.4826 * median / std::f64::consts::SQRT_2;
    let coarse = median == 0.0 || lsb.is_some_and(|q| robust < 4.0 * q);
    if !coarse {
        return (robust, n);
    }
    let rms = (differences.iter().map(|d| d * d).sum::<f64>() / n as f64).sqrt();
    // Knocks are clipped at six times the scatter.
    let clipped = (differences
        .iter()
        .map(|d| d.min(6.0 * rms.min(3.0 * robust.max(0.2 * rms))).powi(2))
        .sum::<f64>()
        / n as f64)
        .sqrt();
    (clipped / std::f64::consts::SQRT_2, n)
}

/// Scatter of the longest stretch in steps of the values' grid.
pub(super) fn scatter_in_steps(data: &AxisData<'_>) -> Option<f64> {
    let lsb = data.lsb.filter(|q| *q > 0.0)?;
    let longest = data.segments.iter().max_by_key(|s| s.samples.len())?;
    let (sigma, _) = difference_scatter(longest, 0..longest.samples.len(), Some(lsb), 200_000);
    Some(sigma / lsb)
}

/// Rounding too coarse for the noise; whether so coarse that Q and N are bounded only (σ_w < 0.7 LSB).
pub(super) fn rounding(data: &AxisData<'_>, end_s: f64) -> Option<(Finding, bool)> {
    let ratio = scatter_in_steps(data)?;
    if ratio >= 1.5 {
        return None;
    }
    let coarse = is_coarse(ratio);
    let rest = if coarse {
        ": quantization and white noise are bounded only"
    } else {
        ""
    };
    Some((
        Finding {
            kind: FindingKind::Quantization,
            start_s: 0.0,
            end_s,
            count: data.segments.iter().map(|s| s.samples.len()).sum(),
            size: Some(ratio),
            text: format!("the scatter is {ratio:.2} of a step{rest}"),
        },
        coarse,
    ))
}

/// A stretch of at least a tenth of the log whose scatter differs from the rest.
pub(super) fn non_stationary(data: &AxisData<'_>) -> Option<Finding> {
    const PARTS: usize = 20;
    let total: usize = data.segments.iter().map(|s| s.samples.len()).sum();
    if total < 40 * PARTS {
        return None;
    }
    // Parts of equal length; a part does not cross a gap.
    let size = total / PARTS;
    let mut parts: Vec<(f64, f64, f64, f64)> = Vec::new();
    for segment in data.segments {
        let count = (segment.samples.len() / size).max(1);
        for i in 0..count {
            let n = segment.samples.len();
            let (from, to) = (i * n / count, (i + 1) * n / count);
            if to - from < 32 {
                continue;
            }
            let (sigma, pairs) = difference_scatter(segment, from..to, data.lsb, 20_000);
            let start = segment.start_s + from as f64 * data.step_s;
            let end = segment.start_s + to as f64 * data.step_s;
            parts.push((sigma, pairs as f64, start, end));
        }
    }
    let m = parts.len();
    if m < 5 {
        return None;
    }
    let sum = |range: &mut dyn Iterator<Item = usize>| {
        let (mut s, mut n) = (0.0, 0.0);
        for i in range {
            s += parts[i].0 * parts[i].1;
            n += parts[i].1;
        }
        (s / n, n)
    };
    let mut worst: Option<(f64, usize, usize, f64)> = None;
    for length in 2..=m / 2 {
        for from in 0..=m - length {
            let (inside, n_in) = sum(&mut (from..from + length));
            let (outside, n_out) = sum(&mut (0..from).chain(from + length..m));
            if outside <= 0.0 || inside <= 0.0 {
                continue;
            }
            let change = inside / outside - 1.0;
            // Of a median of differences of white noise; the neighbours' correlation is in the factor.
            let error = 1.4 * (1.0 / n_in + 1.0 / n_out).sqrt();
            let score = change.abs() / error;
            if change.abs() > 0.1 && score > 6.0 && worst.is_none_or(|w| score > w.0) {
                worst = Some((score, from, length, change));
            }
        }
    }
    let (_, from, length, change) = worst?;
    let (start_s, end_s) = (parts[from].2, parts[from + length - 1].3);
    let side = if change > 0.0 { "above" } else { "below" };
    Some(Finding {
        kind: FindingKind::NonStationary,
        start_s,
        end_s,
        count: ((end_s - start_s) / data.step_s) as usize,
        size: Some(change),
        text: format!(
            "the scatter is {:.0} % {side} the rest of the log",
            100.0 * change.abs()
        ),
    })
}
