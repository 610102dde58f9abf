//! The end values of quantization noise, and its lost samples, taken out of a log that it dominates.
//!
//! With y_k = (q_k − q_{k−1})/dt summation by parts gives, θ = πj/n,
//! c_j = 2 sin(θ/2)·w_j + √(2/n) cos(θ/2)·[(−1)^j q_n − q_0]/dt: w white (the DST-I of the inner q), and two numbers that
//! reach every coefficient. Their mean power 4/n lies far over 4 sin²(θ/2) at low j, and all of it is one draw each. So they
//! are columns, √(2/n) cos θ(k + ½) of the first and the last sample k, estimated by least squares weighted with the fitted
//! spectrum and subtracted; so are samples that were lost, where there are few. A coefficient then counts 1 − h_j,
//! h_j = aᵀM⁻¹a/S_j, M = Σ a aᵀ/S, as in the restricted likelihood [PattersonThompson1971].

use super::dct::dct2;
use super::estimate::Work;
use super::likelihood::{PARAMETERS, Parameters, Problem, Q, Solution};
use super::linear::{cholesky, cholesky_solve};
use super::types::Segment;
use realfft::RealFftPlanner;
use std::f64::consts::PI;
use std::ops::Range;

/// Squared height of the ends over the noise, from which they are taken out; below, their mean power says enough.
const DOMINANT: f64 = 1.0;
/// Part of its own standard error by which an end may still move.
const SETTLED: f64 = 0.05;
/// Most rounds of ends and spectrum.
pub(super) const MOST_ROUNDS: usize = 12;
/// 2 Δ ln L from which quantization noise is not alone.
const NOT_ALONE: f64 = 12.0;
/// Most lost samples that become columns, and the longest segment (of one with lost samples) where they do.
const MOST_LOST: usize = 100;
const LONGEST: usize = 1 << 22;
/// Coefficients of one run at which the leverage of lost samples is worked out.
const PLACES: usize = 16;

/// A run of coefficients that take part, with their fitted variance.
type Level = (Range<usize>, f64);

/// What is taken out of one segment.
struct Removal {
    /// What goes out of every coefficient.
    change: Change,
    /// Mean leverage of a coefficient in each run.
    leverage: Vec<(Range<usize>, f64)>,
    /// How many standard errors the columns moved, at most.
    moved: f64,
}

enum Change {
    /// Amplitudes of √(2/n) cos(θ/2) of even and of odd coefficients: the sums and differences of the two ends.
    Ends([f64; 2]),
    Coefficients(Vec<f64>),
}

/// Takes out what the ends (and lost samples) still put into the coefficients; whether that was more than nothing.
pub(super) fn take_out(
    work: &mut Work,
    segments: &[Segment<'_>],
    problem: &Problem,
    solution: &Solution,
) -> bool {
    let mut weighed = solution.parameters;
    if weighed[Q] <= 0.0 || !(work.layout.ends_taken || is_dominant(work, &weighed)) {
        return false;
    }
    let lost: Vec<Vec<usize>> = segments
        .iter()
        .zip(&work.segments)
        .map(|(s, own)| {
            let all = s.filled.iter().flat_map(Range::clone);
            all.filter(|&k| k < own.n).collect()
        })
        .collect();
    let few = lost.iter().map(Vec::len).sum::<usize>() <= MOST_LOST
        && lost
            .iter()
            .zip(&work.segments)
            .all(|(lost, s)| lost.is_empty() || s.n <= LONGEST);
    // What lost samples put into low coefficients looks like slow terms. So they are taken out as if nothing else were
    // there, and again only where the coefficients that are left show that something is.
    if few && lost.iter().any(|l| !l.is_empty()) {
        let mut alone = [0.0; PARAMETERS];
        alone[Q] = weighed[Q];
        if work.layout.ends_taken {
            let mut free = [false; PARAMETERS];
            free[Q] = true;
            let gain = problem.fit(&alone, &free).objective - solution.objective;
            if gain < NOT_ALONE {
                return false;
            }
        } else {
            weighed = alone;
        }
    }
    if few {
        // What was filled is no longer in the coefficients.
        work.layout.fill = None;
    }
    let mut planner = RealFftPlanner::new();
    let mut removals = Vec::with_capacity(lost.len());
    for (s, lost) in lost.iter().enumerate() {
        let levels = levels(work, &weighed, s);
        let removal = if few && !lost.is_empty() {
            columns(work, s, &levels, lost, &mut planner)
        } else {
            None
        };
        removals.push(removal.unwrap_or_else(|| ends(work, s, &levels)));
    }
    let mut moved = !work.layout.ends_taken;
    work.layout.ends_taken = true;
    for (segment, removal) in work.segments.iter_mut().zip(removals) {
        moved |= removal.moved > SETTLED;
        let n = segment.n;
        match removal.change {
            Change::Ends(amplitude) => {
                for (j, c) in segment.coefficients.iter_mut().enumerate().skip(1) {
                    *c -= amplitude[j % 2] * shape(j, n);
                }
            }
            Change::Coefficients(change) => {
                for (c, change) in segment.coefficients.iter_mut().zip(&change) {
                    *c -= change;
                }
            }
        }
        segment.leverage = removal.leverage;
    }
    moved
}

/// Whether the ends stand over the noise of the fit.
fn is_dominant(work: &Work, parameters: &Parameters) -> bool {
    (0..work.segments.len()).any(|s| {
        let n = work.segments[s].n;
        let squares = levels(work, parameters, s).into_iter().map(|(run, level)| {
            // Every second coefficient belongs to one column.
            0.5 * run.len() as f64 * shape(usize::midpoint(run.start, run.end), n).powi(2) / level
        });
        parameters[Q] * squares.sum::<f64>() >= DOMINANT
    })
}

/// What a unit end value puts into coefficient j.
fn shape(j: usize, n: usize) -> f64 {
    (2.0 / n as f64).sqrt() * (PI * j as f64 / (2 * n) as f64).cos()
}

/// Runs of coefficients that take part, with the fitted variance of each.
fn levels(work: &Work, parameters: &Parameters, s: usize) -> Vec<Level> {
    let fitted = work.fitted(parameters);
    let segment = &work.segments[s];
    let step = 1.0 / (2.0 * segment.n as f64);
    let mut out = Vec::new();
    for (first, end) in work.layout.spans(s) {
        let u = 0.5 * (first + end - 1) as f64 * step;
        if u > work.cut {
            continue;
        }
        let level = fitted.at(u).max(1e-300);
        let mut at = first;
        for gap in &segment.excluded {
            if gap.end <= at || gap.start >= end {
                continue;
            }
            out.push((at..gap.start.max(at), level));
            at = gap.end;
        }
        if at < end {
            out.push((at..end, level));
        }
    }
    out
}

/// The two ends alone: of even and of odd coefficients they are one column each.
fn ends(work: &Work, s: usize, levels: &[Level]) -> Removal {
    let segment = &work.segments[s];
    let (mut information, mut sums) = ([0.0; 2], [0.0; 2]);
    let mut squares = Vec::with_capacity(levels.len());
    for (run, level) in levels {
        let (mut own, mut products) = ([0.0; 2], [0.0; 2]);
        for j in run.clone() {
            let a = shape(j, segment.n);
            own[j % 2] += a * a;
            products[j % 2] += a * segment.coefficients[j];
        }
        for parity in 0..2 {
            information[parity] += own[parity] / level;
            sums[parity] += products[parity] / level;
        }
        squares.push(own);
    }
    let mut out = Removal {
        change: Change::Ends([0.0; 2]),
        leverage: Vec::with_capacity(levels.len()),
        moved: 0.0,
    };
    let mut amplitude = [0.0; 2];
    for parity in 0..2 {
        if information[parity] > 0.0 {
            amplitude[parity] = sums[parity] / information[parity];
            let errors = amplitude[parity].abs() * information[parity].sqrt();
            out.moved = out.moved.max(errors);
        }
    }
    for ((run, level), own) in levels.iter().zip(squares) {
        let sum: f64 = (0..2)
            .filter(|&parity| information[parity] > 0.0)
            .map(|parity| own[parity] / (level * information[parity]))
            .sum();
        out.leverage.push((run.clone(), sum / run.len() as f64));
    }
    out.change = Change::Ends(amplitude);
    out
}

/// The ends and lost samples of a segment; none where they cannot be told apart.
fn columns(
    work: &Work,
    s: usize,
    levels: &[Level],
    lost: &[usize],
    planner: &mut RealFftPlanner<f64>,
) -> Option<Removal> {
    let segment = &work.segments[s];
    let n = segment.n;
    let mut places = vec![0, n - 1];
    places.extend(lost.iter().filter(|&&k| k > 0 && k + 1 < n));
    let p = places.len();
    // Σ_j x_j cos(πji/2n), i = 0, 1, …
    let plan = planner.plan_fft_forward(4 * n);
    let cosines = |of: &dyn Fn(usize, f64) -> f64| {
        let mut input = vec![0.0; 4 * n];
        for (run, level) in levels {
            for j in run.clone() {
                input[j] = of(j, *level);
            }
        }
        let mut output = plan.make_output_vec();
        plan.process(&mut input, &mut output).ok().map(|()| output)
    };
    let norm = 2.0 / n as f64;
    let weights = cosines(&|_, level| norm / level)?;
    let products = cosines(&|j, level| norm.sqrt() * segment.coefficients[j] / level)?;
    // cos a cos b = ½[cos(a − b) + cos(a + b)]; beyond n the cosines run back.
    let at = |d: usize| weights[2 * d.min(2 * n - d)].re;
    let mut m = vec![0.0; p * p];
    for (i, &k) in places.iter().enumerate() {
        for (l, &o) in places.iter().enumerate() {
            m[i * p + l] = 0.5 * (at(k.abs_diff(o)) + at(k + o + 1));
        }
    }
    let scale: Vec<f64> = (0..p).map(|i| 1.0 / m[i * p + i].sqrt()).collect();
    let unit: Vec<f64> = (0..p * p)
        .map(|i| m[i] * scale[i / p] * scale[i % p])
        .collect();
    let factor = cholesky(&unit, p)?;
    let right: Vec<f64> = (0..p)
        .map(|i| products[2 * places[i] + 1].re * scale[i])
        .collect();
    let solved = cholesky_solve(&factor, &right);
    let errors: f64 = solved.iter().zip(&right).map(|(x, b)| x * b).sum();
    let mut impulses = vec![0.0; n];
    for (i, &k) in places.iter().enumerate() {
        impulses[k] += solved[i] * scale[i];
    }
    let leverage = levels
        .iter()
        .map(|(run, level)| {
            let stride = run.len().div_ceil(PLACES);
            let (mut sum, mut count) = (0.0, 0.0);
            for j in run.clone().step_by(stride) {
                let a: Vec<f64> = (0..p)
                    .map(|i| {
                        let turn = j * (2 * places[i] + 1) % (4 * n);
                        scale[i] * (PI * turn as f64 / (2 * n) as f64).cos()
                    })
                    .collect();
                let x = cholesky_solve(&factor, &a);
                sum += a.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>();
                count += 1.0;
            }
            (run.clone(), (norm * sum / (level * count)).min(1.0))
        })
        .collect();
    Some(Removal {
        change: Change::Coefficients(dct2(&impulses, 0.0, planner)),
        leverage,
        moved: (errors.max(0.0) / p as f64).sqrt(),
    })
}
