//! Which regressors and Gauss–Markov terms a log asks for: taken in one by one, the clearest first, idle ones dropped.
//!
//! A column is kept where 2 Δ ln L passes its threshold: 12 a ramp, 3.84 a power of the temperature, 12 a warm-up, a step
//! what the choice of its place asks for, also with one more Gauss–Markov process refitted with it and without it; what
//! passes its own by most is taken. Source: the measurements of `FIDELITY.md` and `HEALTH.md`.

use super::bins::Column;
use super::checks;
use super::estimate::{Active, ActiveKind, Work};
use super::likelihood::{FIRST_GM, Free, Problem, Solution};
use super::regress;
use super::results::Units;
use super::select::{self, GAUSS_MARKOV_THRESHOLD, RAMP_THRESHOLD};
use super::types::{Candidates, FitOptions, Segment};
use realfft::RealFftPlanner;

/// 2 ln of the likelihood averaged over all places, from which a step is named: white noise leaves few places to choose
/// from, a long walk many, and the average counts them. Of n places that noise tells apart exp(−b/2)/√(π (b/2 + ln n)) of
/// axes pass a bound b by chance: 0.17 % for n = 1000, 1 % of logs of six axes.
const STEP_EVIDENCE: f64 = 9.2;
/// Ratio from which a warm-up is named: with its size and time free 0.25 % of axes reach it by chance, fewer over the floor.
const WARM_UP_THRESHOLD: f64 = 12.0;
/// Shortest time of a warm-up; the longest is a quarter of the log.
const SHORTEST_WARM_UP_S: f64 = 30.0;
/// Ratio from which a power of the temperature is kept.
const TEMPERATURE_THRESHOLD: f64 = 3.84;
const MOST_STEPS: usize = 12;
/// Amplitude of a warm-up over the floor of the Allan deviation; a smaller one is drift as the terms make it.
const WARM_UP_OVER_FLOOR: f64 = 3.0;

/// What was taken in, the fit with it, its bins, and the line and powers of the temperature that were not.
pub(super) type Chosen = (
    Vec<Active>,
    (Solution, Free, usize),
    Problem,
    Vec<(ActiveKind, Column)>,
);

/// Takes in regressors and Gauss–Markov terms one by one, the clearest first.
pub(super) fn regressors(
    work: &Work,
    segments: &[Segment<'_>],
    temperature: Option<&[Segment<'_>]>,
    candidates: &Candidates,
    options: &FitOptions,
    grown: &(Solution, Free, usize),
) -> Chosen {
    let given = work.given.iter().map(|&(segment, at)| Active {
        kind: ActiveKind::Step(segment, at),
        column: regress::step(&work.segments, segment, at, usize::MAX),
        // Judged between the segments: it need not show within its own.
        threshold: f64::MIN_POSITIVE,
    });
    let mut active: Vec<Active> = given.collect();
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
    let times: Vec<f64> = if options.data_checks && duration >= 4.0 * SHORTEST_WARM_UP_S {
        let (low, high) = (SHORTEST_WARM_UP_S / work.step_s, span / 4.0);
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
                offers.push((ActiveKind::WarmUp(*tau), WARM_UP_THRESHOLD));
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
            // A process already found belongs to what the step stands out of.
            // That fit knows no column: a step that is given is none of its own.
            let processes = first_round && grown.2 > 0 && active.is_empty();
            let background = if processes { &grown.0 } else { &now };
            let likely = checks::find_step(work, segments, &active, background);
            let threshold = STEP_EVIDENCE - likely.as_ref().map_or(0.0, |l| l.choice);
            let mut found: Option<(Active, Solution, Problem)> = None;
            for (which, at) in likely.into_iter().flat_map(|l| l.places) {
                let with = |reach: usize| {
                    let column = regress::step(&work.segments, which, at, reach);
                    let mut with: Vec<Column> = active.iter().map(|a| a.column.clone()).collect();
                    with.push(column.clone());
                    let log = work.layout.sum(&work.segments, &with, work.cut);
                    let problem = Problem::new(&[&log], false);
                    let tried = problem.fit(&now.parameters, &free);
                    (column, tried, problem)
                };
                let (mut column, mut tried, mut stepped) = with(regress::SMOOTH_REACH);
                let height = tried.beta[0].last().copied().unwrap_or(0.0);
                let level = work.fitted(&now.parameters).at(0.25 * work.cut).sqrt();
                let reach = regress::step_reach(work.segments[which].n, height / level);
                if reach > 2 * regress::SMOOTH_REACH {
                    (column, tried, stepped) = with(reach);
                }
                let kind = ActiveKind::Step(which, at);
                if found
                    .as_ref()
                    .is_none_or(|f| tried.objective < f.1.objective)
                {
                    let step = Active {
                        kind,
                        column,
                        threshold,
                    };
                    found = Some((step, tried, stepped));
                }
            }
            if let Some((step, tried, stepped)) = found {
                let mut ratio = now.objective - tried.objective;
                if (ratio > threshold || processes) && count < candidates.gauss_markov.min(2) {
                    let more = select::with_gauss_markov(&free, count);
                    let null = select::add_gauss_markov(&problem, &now, &free, count, 6.0);
                    let other = select::add_gauss_markov(&stepped, &tried, &free, count, 6.0);
                    let both = stepped.fit(&null.parameters, &more);
                    let least = both.objective.min(other.objective).min(tried.objective);
                    let beside = null.objective.min(now.objective) - least;
                    let needed = now.objective - null.objective >= GAUSS_MARKOV_THRESHOLD;
                    ratio = if needed { beside } else { ratio.min(beside) };
                }
                let excess = ratio - threshold;
                let rival = best_offer(work, &whole, base, &offers, &now, &free);
                if excess > 0.0 && rival.is_none_or(|r| r.1 - offers[r.0].1 < excess) {
                    active.push(step);
                    current = Some(tried);
                    first_round = false;
                    continue;
                }
            }
        }
        let offer = best_offer(work, &whole, base, &offers, &now, &free);
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
                    threshold: offers[index].1,
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
    let powers = (1..).map(ActiveKind::Temperature).zip(temperature_columns);
    let line = ramp.map(|column| (ActiveKind::Ramp, column));
    let possible = line
        .into_iter()
        .chain(powers)
        .filter(|(kind, _)| active.iter().all(|a| a.kind != *kind))
        .collect();
    (active, (solution, free, count), problem, possible)
}

/// The offered column with the largest gain among those that pass: (index, gain, fit).
fn best_offer(
    work: &Work,
    whole: &Problem,
    base: usize,
    offers: &[(ActiveKind, f64)],
    now: &Solution,
    free: &Free,
) -> Option<(usize, f64, Solution)> {
    let mut best: Option<(usize, f64, Solution)> = None;
    let mut warmest: Option<(usize, f64, Solution)> = None;
    for (i, (kind, threshold)) in offers.iter().enumerate() {
        let mut keep: Vec<usize> = (0..base).collect();
        keep.push(base + i);
        let tried = whole.with_columns(&keep, false).fit(&now.parameters, free);
        let gain = now.objective - tried.objective;
        let held = match kind {
            ActiveKind::Temperature(_) => &mut warmest,
            _ => &mut best,
        };
        if gain >= *threshold
            && held.as_ref().is_none_or(|b| gain > b.1)
            && stands_over_floor(work, *kind, base, &tried)
        {
            *held = Some((i, gain, tried));
        }
    }
    // A temperature that was recorded goes before an exponential that does as well by the freedom of its time.
    let lead = match &best {
        Some((i, ..)) if matches!(offers[*i].0, ActiveKind::WarmUp(_)) => WARM_UP_THRESHOLD,
        _ => 0.0,
    };
    match (best, warmest) {
        (Some(best), Some(warmest)) if best.1 <= warmest.1 + lead => Some(warmest),
        (None, warmest) => warmest,
        (best, _) => best,
    }
}

/// Whether column `index`, where it is a warm-up, starts high enough over the floor of the fit's Allan deviation.
fn stands_over_floor(work: &Work, kind: ActiveKind, index: usize, fit: &Solution) -> bool {
    if !matches!(kind, ActiveKind::WarmUp(_)) {
        return true;
    }
    let amplitude = fit.beta[0].get(index).map_or(0.0, |b| b.abs() * work.scale);
    let terms = Units::new(work).terms(&fit.parameters);
    let longest = work.samples as f64 * work.step_s / 3.0;
    let octaves = (longest / work.step_s).log2().max(0.0);
    let points = (4.0 * octaves).ceil() as i32;
    let floor = (0..=points)
        .map(|k| longest * f64::exp2(-f64::from(k) / 4.0))
        .map(|tau| terms.allan_variance(tau))
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    amplitude > WARM_UP_OVER_FLOOR * floor
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
            let tau = (at * f64::exp(width * factor)).max(SHORTEST_WARM_UP_S / work.step_s);
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
            if matches!(a.kind, ActiveKind::Temperature(1))
                && active.iter().any(|b| b.kind == ActiveKind::Temperature(2))
            {
                continue;
            }
            let keep: Vec<usize> = (0..active.len()).filter(|&k| k != i).collect();
            let fit = whole.with_columns(&keep, false).fit(&now.parameters, free);
            let mut share = (fit.objective - now.objective) / a.threshold;
            if !stands_over_floor(work, a.kind, i, &now) {
                share = share.min(0.0);
            }
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
