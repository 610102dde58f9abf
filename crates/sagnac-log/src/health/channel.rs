//! What is wrong with one channel: missing numbers, saturation, a stuck value, units, coarse steps, changing noise.
//!
//! σ_w = 1.4826·median|y_k − y_{k−1}|/√2, where that is 0 the differences' standard deviation/√2.

use std::ops::Range;

use super::found::{Found, Said};
use super::moments::Moments;
use super::thin::Thin;
use super::time::Clock;
use super::{ChannelHealth, robust};
use crate::map::hints::accel_unit_that_fits;
use crate::{Issue, IssueKind, Log};

/// Statistics of one channel.
pub(crate) struct Facts {
    pub(crate) mean: f64,
    pub(crate) std: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) median: f64,
    pub(crate) sigma_w: f64,
    pub(crate) lsb: Option<f64>,
    pub(crate) numbers: usize,
}

/// Values beyond it are no measurements; their squares overflow soon.
const LARGEST: f64 = 1e140;

impl Facts {
    pub(crate) fn of(values: &[f64]) -> Self {
        let largest = values
            .iter()
            .filter(|v| v.is_finite())
            .fold(0.0_f64, |a, v| a.max(v.abs()));
        if largest > LARGEST {
            // Sums and squares of such values have no place in an f64: they are taken in smaller units.
            let unit = largest / LARGEST.sqrt();
            let small: Vec<f64> = values.iter().map(|v| v / unit).collect();
            let f = Self::of(&small);
            return Self {
                mean: f.mean * unit,
                std: f.std * unit,
                min: f.min * unit,
                max: f.max * unit,
                median: f.median * unit,
                sigma_w: f.sigma_w * unit,
                lsb: f.lsb.map(|l| l * unit),
                numbers: f.numbers,
            };
        }
        let (mut n, mut sum, mut min, mut max) = (0_usize, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        // The first number is taken out: a large mean costs no digits.
        let pivot = values
            .iter()
            .copied()
            .find(|v| v.is_finite())
            .unwrap_or(f64::NAN);
        let mut squares = 0.0;
        for &v in values.iter().filter(|v| v.is_finite()) {
            let d = v - pivot;
            n += 1;
            sum += d;
            squares += d * d;
            min = min.min(v);
            max = max.max(v);
        }
        if n == 0 {
            let nan = f64::NAN;
            return Self {
                mean: nan,
                std: nan,
                min: nan,
                max: nan,
                median: nan,
                sigma_w: nan,
                lsb: None,
                numbers: 0,
            };
        }
        let shift = sum / n as f64;
        let variance = if n > 1 {
            (squares - sum * shift) / (n - 1) as f64
        } else {
            0.0
        };
        let lsb = lsb(values);
        let sigma_w = sigma_w(values, lsb);
        let mut sample: Vec<f64> = every(values, 1 << 20).filter(|v| v.is_finite()).collect();
        let median = crate::clock::median(&mut sample).unwrap_or(f64::NAN);
        let lsb = lsb.filter(|l| *l > 1e-3 * sigma_w);
        Self {
            mean: pivot + shift,
            std: variance.max(0.0).sqrt(),
            min,
            max,
            median,
            sigma_w,
            lsb,
            numbers: n,
        }
    }
}

/// At most about `most` values, evenly picked.
fn every(values: &[f64], most: usize) -> impl Iterator<Item = f64> + '_ {
    values
        .iter()
        .copied()
        .step_by(values.len().div_ceil(most).max(1))
}

/// The robust scatter of first differences over √2; in data of coarse steps the median is taken inside its step.
fn sigma_w(values: &[f64], lsb: Option<f64>) -> f64 {
    let mut d: Vec<f64> = values
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|v| v.is_finite())
        .collect();
    if d.is_empty() {
        return 0.0;
    }
    let square: f64 = d.iter().map(|v| v * v).sum::<f64>() / d.len() as f64;
    let plain = robust(&mut d) / std::f64::consts::SQRT_2;
    if plain == 0.0 {
        return square.sqrt() / std::f64::consts::SQRT_2;
    }
    let Some(lsb) = lsb.filter(|l| plain < 5.0 * l) else {
        return plain;
    };
    // |d| sits on multiples of the step: the median is spread over its step.
    let middle = plain * std::f64::consts::SQRT_2 / 1.4826;
    let n = d.len() as f64;
    let below = d.iter().filter(|v| **v < middle - 0.5 * lsb).count() as f64;
    let at = d
        .iter()
        .filter(|v| (**v - middle).abs() <= 0.5 * lsb)
        .count() as f64;
    let inside = ((0.5 * n - below) / at.max(1.0)).clamp(0.0, 1.0);
    1.4826 * (middle + (inside - 0.5) * lsb) / std::f64::consts::SQRT_2
}

/// The smallest step of the grid that the values lie on.
fn lsb(values: &[f64]) -> Option<f64> {
    // Blocks, not single picks: neighbors show the small steps.
    const BLOCK: usize = 500;
    let blocks = values.len().div_ceil(BLOCK);
    let stride = blocks.div_ceil(40).max(1);
    let mut sample: Vec<f64> = values
        .chunks(BLOCK)
        .step_by(stride)
        .flatten()
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    if sample.len() < 16 {
        return None;
    }
    sample.sort_unstable_by(f64::total_cmp);
    let largest = sample[0].abs().max(sample[sample.len() - 1].abs());
    let noise = 8.0 * f64::EPSILON * largest;
    // Beside a value beyond all measure the steps of the others are rounding.
    let swallowed = sample
        .windows(2)
        .filter(|w| w[1] > w[0] && w[1] - w[0] <= noise)
        .count();
    if 10 * swallowed > sample.len() {
        return None;
    }
    let step = sample
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > noise)
        .fold(f64::INFINITY, f64::min);
    if !step.is_finite() || noise > 0.01 * step {
        return None;
    }
    let origin = sample[0];
    // The step is refined on the way out: its own error grows with the number of steps.
    let mut unit = step;
    for v in &sample {
        let k = ((v - origin) / unit).round();
        if k > 0.0 {
            let off = (v - origin) / k;
            if ((v - origin) / unit - k).abs() > 0.02 + noise / unit {
                return None;
            }
            if k >= 2.0 * (unit / step).max(1.0) {
                unit = off;
            }
        }
    }
    Some(unit)
}

fn issue(
    kind: IssueKind,
    name: &str,
    clock: &Clock<'_>,
    rows: &Range<usize>,
    count: usize,
    text: String,
) -> Issue {
    Issue {
        kind,
        channel: Some(name.to_owned()),
        start_s: clock.absolute(rows.start),
        end_s: clock.absolute(rows.end.saturating_sub(1).max(rows.start)),
        count: count as u64,
        text,
    }
}

/// A channel whose values stand in rows of a log.
pub(crate) struct Place<'a> {
    pub(crate) name: &'a str,
    pub(crate) clock: &'a Clock<'a>,
    /// Rows of a range of its values.
    pub(crate) rows: &'a dyn Fn(&Range<usize>) -> Range<usize>,
    /// Whether the log goes on beyond what is held of it.
    pub(crate) is_part: bool,
}

/// Values that are missing at a thin channel's own interval.
pub(crate) fn lost_issues(name: &str, thin: &Thin, clock: &Clock<'_>, issues: &mut Vec<Found>) {
    for (rows, n) in thin.lost() {
        let (samples, are) = if n == 1 {
            ("sample", "is no number")
        } else {
            ("samples", "are no numbers")
        };
        let text = format!("{n} {samples} {are}");
        let lost = issue(IssueKind::Nan, name, clock, &rows, n, text);
        issues.push(Found::event(lost, rows));
    }
}

/// Runs of numbers that are none.
pub(crate) fn nan_issues(
    name: &str,
    values: &[f64],
    clock: &Clock<'_>,
    facts: &Facts,
    issues: &mut Vec<Found>,
) {
    if facts.numbers == values.len() {
        return;
    }
    for run in runs(values, |v| !v.is_finite()) {
        let n = run.len();
        let (text, said) = if facts.numbers < super::FEWEST_NUMBERS {
            let text = format!("only {} numbers: no parameters", facts.numbers);
            (text, Said::Once)
        } else {
            (no_numbers(n as u64), Said::Count(no_numbers))
        };
        let none = issue(IssueKind::Nan, name, clock, &run, n, text);
        issues.push(Found::run(none, run, said));
    }
}

fn no_numbers(n: u64) -> String {
    if n == 1 {
        "1 sample is no number".to_owned()
    } else {
        format!("{n} samples are no numbers")
    }
}

/// Ranges in which `is` holds.
pub(super) fn runs(values: &[f64], is: impl Fn(f64) -> bool) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for (k, &v) in values.iter().enumerate() {
        if is(v) {
            match out.last_mut() {
                Some(r) if r.end == k => r.end = k + 1,
                _ => out.push(k..k + 1),
            }
        }
    }
    out
}

/// An extreme value that repeats less often is none of a range's end.
pub(super) const FEWEST_SATURATED: usize = 5;

/// An extreme value that repeats.
pub(crate) fn saturation_issues(
    place: &Place<'_>,
    values: &[f64],
    facts: &Facts,
    range: Option<f64>,
    issues: &mut Vec<Found>,
) {
    if facts.numbers < 10 || facts.min == facts.max {
        return;
    }
    for limit in [facts.max, facts.min] {
        let hits = runs(values, |v| v == limit);
        let count: usize = hits.iter().map(Range::len).sum();
        let longest = hits.iter().map(Range::len).max().unwrap_or(0);
        if longest < 3 || (count < FEWEST_SATURATED && !place.is_part) {
            continue;
        }
        let at_range = range.is_some_and(|r| limit.abs() >= r * (1.0 - 1e-6));
        let is_far = (limit - facts.median).abs() >= 3.0 * facts.sigma_w;
        // Coarse steps repeat an extreme value by chance: only runs beyond chance count.
        let is_coarse = facts.lsb.is_some_and(|l| facts.sigma_w < 3.0 * l);
        let share = count as f64 / facts.numbers as f64;
        let by_chance = facts.numbers as f64 * share.powi(longest as i32) > 1e-3;
        // Steps that hide the noise repeat every value; a range that ends lies far from the mean.
        let is_near =
            |q: f64| hides_noise(facts.sigma_w / q) && (limit - facts.median).abs() < 100.0 * q;
        if !at_range && facts.lsb.is_some_and(is_near) {
            continue;
        }
        if at_range || (is_far && !(is_coarse && by_chance)) {
            let is_largest = limit == facts.max;
            let text = saturated(limit, is_largest, count as u64);
            let said = Said::Saturated { limit, is_largest };
            for hit in hits {
                let rows = (place.rows)(&hit);
                let issue = issue(
                    IssueKind::Saturation,
                    place.name,
                    place.clock,
                    &rows,
                    hit.len(),
                    text.clone(),
                );
                issues.push(Found::run(issue, rows, said));
            }
        }
    }
}

/// What is said of an extreme value that repeats.
pub(super) fn saturated(limit: f64, is_largest: bool, count: u64) -> String {
    let side = if is_largest { "largest" } else { "smallest" };
    format!("{side} value {} {count} times: saturated", number(limit))
}

fn number(v: f64) -> String {
    let text = format!("{v:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A number with about four digits.
pub(super) fn short(v: f64) -> String {
    if !(1e-2..1e6).contains(&v.abs()) {
        return format!("{v:.3e}");
    }
    let decimals = (3 - v.abs().log10().floor() as i32).clamp(0, 5) as usize;
    format!("{v:.decimals$}")
}

/// Rows in which one value stands too long.
pub(crate) fn stuck_runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut long: Vec<Range<usize>> = Vec::new();
    let mut longest_short = 1;
    let mut start = 0;
    for k in 1..=values.len() {
        // As numbers: −0 and 0 are one value, and one that is no number counts for nothing.
        if k == values.len() || values[k] != values[start] {
            let n = k - start;
            if n > 20 && values[start].is_finite() {
                long.push(start..k);
            } else if values[start].is_finite() {
                longest_short = longest_short.max(n);
            }
            start = k;
        }
    }
    long.sort_by_key(|r| std::cmp::Reverse(r.len()));
    // The longest runs that stand out tenfold from what remains.
    let limit = |rest: usize| 20.max(10 * rest);
    let mut found = 0;
    for n in 1..=long.len().min(1000) {
        let rest = long.get(n).map_or(longest_short, Range::len);
        let rest = if long[n - 1].len() == values.len() {
            0
        } else {
            rest
        };
        if long[n - 1].len() > limit(rest) {
            found = n;
        }
    }
    long.truncate(found);
    long.sort_by_key(|r| r.start);
    long
}

pub(crate) fn stuck_issues(
    place: &Place<'_>,
    values: usize,
    runs: &[Range<usize>],
    issues: &mut Vec<Found>,
) {
    for run in runs {
        let text = if run.len() == values {
            STUCK_ALWAYS.to_owned()
        } else {
            stuck(run.len() as u64)
        };
        let rows = (place.rows)(run);
        let issue = issue(
            IssueKind::Stuck,
            place.name,
            place.clock,
            &rows,
            run.len(),
            text,
        );
        issues.push(Found::run(issue, rows, Said::Count(stuck)));
    }
}

/// What is said of a channel that holds one value.
pub(super) const STUCK_ALWAYS: &str = "one value all the time: no numbers from this channel";

fn stuck(n: u64) -> String {
    format!("one value for {n} samples; left out")
}

/// Whether values of this scatter in steps, the rounding's own 1/12 in its square, stand for noise below 0.7 steps.
fn hides_noise(ratio: f64) -> bool {
    ratio * ratio - 1.0 / 12.0 < 0.49
}

/// What coarse steps do to the noise; `None` where it spans enough of them.
pub(super) fn quantization(sigma_w: f64, lsb: Option<f64>) -> Option<String> {
    let ratio = sigma_w / lsb?;
    (ratio < 1.5 && sigma_w > 0.0).then(|| {
        let limits = if hides_noise(ratio) {
            "; quantization and white noise only as upper limits"
        } else {
            ""
        };
        format!("a step is {:.2} of the scatter{limits}", 1.0 / ratio)
    })
}

/// More than the fastest gyros sold measure (20 000 deg/s), rad/s.
const FASTEST_GYRO: f64 = 350.0;

/// An accelerometer at rest that shows less is dead, m/s^2.
const DEAD: f64 = 0.1;

/// Moments of what is finite and not far out: a single absurd sample moves none.
fn robust_moments(rows: usize, value: impl Fn(usize) -> f64) -> Moments {
    let stride = rows.div_ceil(10_000).max(1);
    let mut some: Vec<f64> = (0..rows)
        .step_by(stride)
        .map(&value)
        .filter(|v| v.is_finite())
        .collect();
    let Some(middle) = crate::clock::median(&mut some) else {
        return Moments::default();
    };
    let mut apart: Vec<f64> = some.iter().map(|v| (v - middle).abs()).collect();
    let spread = crate::clock::median(&mut apart).unwrap_or(0.0);
    let far = 20.0 * spread + 0.5 * middle;
    let (mut n, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    for l in (0..rows).map(value).filter(|l| (l - middle).abs() <= far) {
        n += 1;
        sum += l - middle;
        squares += (l - middle) * (l - middle);
    }
    if n == 0 {
        return Moments::default();
    }
    let off = sum / n as f64;
    let variance = (squares / n as f64 - off * off).max(0.0);
    Moments {
        count: n,
        mean: middle + off,
        spread: variance.sqrt(),
    }
}

/// Moments over some rows of the lengths of accelerometer and gyro: of all three axes of an accelerometer, of those axes
/// of a gyro that there are.
pub(super) fn lengths(log: &Log, rows: &Range<usize>) -> [Moments; 2] {
    [("accel", 3), ("gyro", 1)].map(|(word, least)| {
        let c: Vec<&[f64]> = ["x", "y", "z"]
            .iter()
            .filter_map(|a| log.channel(&format!("{word}_{a}"))?.get(rows.clone()))
            .collect();
        if c.len() < least {
            return Moments::default();
        }
        robust_moments(rows.len(), |k| {
            c.iter().map(|x| x[k] * x[k]).sum::<f64>().sqrt()
        })
    })
}

/// Mean of |f| over the log [m/s²], of three accelerometer axes; absurd samples apart.
///
/// Not the length of the mean f, which is shorter where the sensor was turned.
pub fn mean_force(log: &Log) -> Option<f64> {
    let [force, _] = lengths(log, &(0..log.rows));
    force.mean()
}

/// |f| far from g, |w| of a log at rest far from zero; `None` where neither is.
pub(super) fn units([force, rate]: [Moments; 2]) -> Option<String> {
    // Findings of one kind and span are one: both sensors are told in its text.
    let mut texts: Vec<String> = Vec::new();
    if let Some(f) = force.mean()
        && (f / 9.81 - 1.0).abs() > 0.08
    {
        // The values were multiplied by the unit's factor: what they were tells what they are.
        let hint = match accel_unit_that_fits(f) {
            Some("m/s^2") | None => [
                ("in m/s^2, read as g", 9.80665 * 9.81),
                ("in m/s^2, read as mg", 9.80665e-3 * 9.81),
                ("in g, read as mg", 9.80665e-3),
                ("in mg, read as g", 9806.65),
            ]
            .iter()
            .find(|(_, g)| (f / g - 1.0).abs() < 0.12)
            .map_or(String::new(), |(text, _)| format!(", as if it were {text}")),
            Some(unit) => format!(", as if it were in {unit}"),
        };
        texts.push(format!("|f| is {} m/s^2, far from 9.81{hint}", short(f)));
    }
    if let Some(w) = rate.mean() {
        // A dead accelerometer says nothing of rest.
        let is_still = force
            .mean()
            .is_none_or(|f| f < DEAD || force.spread <= 0.1 * f);
        let hint = if w > FASTEST_GYRO {
            Some("more than gyros measure: look at the unit")
        } else if w > 5.0 && is_still {
            Some("at rest, as if it were in deg/s")
        } else {
            None
        };
        if let Some(hint) = hint {
            let comma = if w > FASTEST_GYRO { "," } else { "" };
            let text = format!("|w| is {} rad/s{comma} {hint}", short(w));
            texts.push(text);
        }
    }
    (!texts.is_empty()).then(|| texts.join("; "))
}

/// Count and sum of squared differences of a fortieth, its start and end.
type Bin = (u64, f64, f64, f64);

/// Parts of a tenth of the log whose σ_w differs from the rest's.
pub(crate) fn non_stationary_issues(
    health: &ChannelHealth<'_>,
    clock: &Clock<'_>,
    issues: &mut Vec<Issue>,
) {
    const STEPS: usize = 40;
    const WIDTH: usize = 4;
    let total: usize = health.quiet.iter().map(|s| s.range.len()).sum();
    if total < 4000 || health.sigma_w <= 0.0 {
        return;
    }
    // Where a step hides the noise, the scatter is a matter of where the mean stands between two steps.
    if health.lsb.is_some_and(|q| hides_noise(health.sigma_w / q)) {
        return;
    }
    // Sums of squared differences over fortieths; outliers beyond 6 σ are no scatter.
    let clip = 6.0 * std::f64::consts::SQRT_2 * health.sigma_w.max(health.lsb.unwrap_or(0.0));
    let mut bins: Vec<Bin> = vec![(0, 0.0, f64::NAN, f64::NAN); STEPS];
    let mut seen = 0;
    for s in &health.quiet {
        let values = &health.values[s.range.clone()];
        // Filled samples lie on lines: they are no scatter.
        let mut filled = s.filled.iter().peekable();
        let is_filled = !s.filled.is_empty();
        for (k, w) in values.windows(2).enumerate() {
            if is_filled {
                while filled.next_if(|r| r.end <= k).is_some() {}
                if filled.peek().is_some_and(|r| r.start <= k + 1) {
                    continue;
                }
            }
            let bin = &mut bins[((seen + k) * STEPS / total).min(STEPS - 1)];
            let d = w[1] - w[0];
            if d.abs() < clip {
                bin.0 += 1;
                bin.1 += d * d;
            }
            let t = s.start_s + k as f64 * health.step_s;
            if bin.2.is_nan() {
                bin.2 = t;
            }
            bin.3 = t + health.step_s;
        }
        seen += values.len();
    }
    let sum = |part: &[Bin]| part.iter().fold((0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let differs = |part: (u64, f64), rest: (u64, f64)| {
        if part.0 < 100 || rest.0 < 100 || rest.1 <= 0.0 {
            return None;
        }
        let ratio = (part.1 / part.0 as f64 / (rest.1 / rest.0 as f64)).sqrt();
        // Differences of white noise are correlated by −½: the variance of their mean square is 3σ⁴/n.
        let error = ratio * (0.75 / part.0 as f64 + 0.75 / rest.0 as f64).sqrt();
        ((ratio - 1.0).abs() > 0.1 && (ratio - 1.0).abs() > 6.0 * error).then_some(ratio)
    };
    let without = |whole: (u64, f64), part: (u64, f64)| (whole.0 - part.0, whole.1 - part.1);
    let all = sum(&bins);
    if !bins
        .windows(WIDTH)
        .any(|w| differs(sum(w), without(all, sum(w))).is_some())
    {
        return;
    }
    // The part that differs most from the rest, then of what is left, each with its own edges.
    let mut left: Vec<Bin> = bins.clone();
    let mut flagged: Vec<(usize, usize, f64)> = Vec::new();
    while flagged.len() < 4 {
        let whole = sum(&left);
        let mut best: Option<(f64, usize, usize, f64)> = None;
        for from in 0..STEPS {
            for to in from + WIDTH - 1..=STEPS {
                // Of two halves the louder.
                if left[from..to].iter().any(|b| b.0 == 0) || 2 * (to - from) > STEPS {
                    continue;
                }
                let part = sum(&left[from..to]);
                let rest = without(whole, part);
                let Some(ratio) = differs(part, rest) else {
                    continue;
                };
                if 2 * (to - from) == STEPS && (from == 0 || to == STEPS) && ratio < 1.0 {
                    continue;
                }
                let term = |x: (u64, f64)| x.0 as f64 * (x.1 / x.0 as f64).ln();
                let gain = term(whole) - term(part) - term(rest);
                if best.is_none_or(|b| gain > b.0) {
                    best = Some((gain, from, to, ratio));
                }
            }
        }
        let Some((_, from, to, ratio)) = best else {
            break;
        };
        flagged.push((from, to, ratio));
        left[from..to]
            .iter_mut()
            .for_each(|b| (b.0, b.1) = (0, 0.0));
    }
    // Parts that are most of the log together are the rest: what differs is what they leave.
    let marked = |k: usize| flagged.iter().any(|f| (f.0..f.1).contains(&k));
    if 2 * (0..STEPS).filter(|&k| marked(k)).count() > STEPS {
        let others: Vec<usize> = (0..STEPS).filter(|&k| !marked(k)).collect();
        let mut parts: Vec<(usize, usize, f64)> = others
            .chunk_by(|a, b| a + 1 == *b)
            .map(|run| (run[0], run[0] + run.len()))
            .filter_map(|(from, to)| {
                let part = sum(&bins[from..to]);
                Some((from, to, differs(part, without(all, part))?))
            })
            .collect();
        if parts.is_empty() {
            parts.extend(flagged.first());
        }
        flagged = parts;
    }
    flagged.sort_by_key(|f| f.0);
    let first = clock.absolute(0);
    for (from, to, ratio) in flagged {
        let (a, b, count) = bins[from..to].iter().fold((f64::NAN, f64::NAN, 0), |x, b| {
            (
                if x.0.is_nan() { b.2 } else { x.0 },
                if b.3.is_nan() { x.1 } else { b.3 },
                x.2 + b.0,
            )
        });
        issues.push(Issue {
            kind: IssueKind::NonStationary,
            channel: Some(health.name.clone()),
            start_s: first + a,
            end_s: first + b,
            count,
            text: format!("the scatter is {ratio:.2} times that of the rest"),
        });
    }
}
