//! Precision from repeated readings, the LSB from the grid of the outputs, resolution from both.

use super::points::{Direction, Point, index_of};
use super::{Reading, chi2_quantile, t_quantile};

/// Repeatability at equal input and direction, 1σ, in output units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// s_p.
    pub value: f64,
    /// Lower 95 % limit.
    pub lower: f64,
    /// Upper 95 % limit.
    pub upper: f64,
    /// Degrees of freedom ν.
    pub dof: usize,
    /// √mean(output_se²), where every reading has a standard error.
    pub noise_part: Option<f64>,
}

/// The smallest input step that is called a change with 95 % probability, in the unit of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The step.
    pub value: f64,
}

pub(super) fn precision(
    readings: &[Reading],
    directions: &[Option<Direction>],
    points: &[Point],
    tolerance: f64,
) -> Result<Precision, &'static str> {
    // Groups: every point three times (up, down, direction unknown).
    let slot = |i: usize| {
        let side = match directions[i] {
            Some(Direction::Up) => 0,
            Some(Direction::Down) => 1,
            None => 2,
        };
        3 * index_of(points, readings[i].reference, tolerance) + side
    };
    let mut sums = vec![(0.0, 0_usize); 3 * points.len()];
    for (i, r) in readings.iter().enumerate() {
        let (sum, n) = &mut sums[slot(i)];
        *sum += r.output;
        *n += 1;
    }
    let dof: usize = sums.iter().map(|&(_, n)| n.saturating_sub(1)).sum();
    if dof == 0 {
        return Err("no point was read twice in one direction");
    }
    let squares: f64 = readings
        .iter()
        .enumerate()
        .map(|(i, r)| {
            let (sum, n) = sums[slot(i)];
            if n < 2 {
                0.0
            } else {
                (r.output - sum / n as f64).powi(2)
            }
        })
        .sum();
    let value = (squares / dof as f64).sqrt();
    let noise: Option<Vec<f64>> = readings.iter().map(|r| r.output_se).collect();
    Ok(Precision {
        value,
        lower: value * (dof as f64 / chi2_quantile(0.975, dof)).sqrt(),
        upper: value * (dof as f64 / chi2_quantile(0.025, dof)).sqrt(),
        dof,
        noise_part: noise
            .map(|se| (se.iter().map(|s| s * s).sum::<f64>() / se.len() as f64).sqrt()),
    })
}

pub(super) fn resolution(
    precision: Option<&Precision>,
    lsb: Option<f64>,
    slope: f64,
) -> Result<Resolution, &'static str> {
    let precision = precision.ok_or("it needs the precision")?;
    if slope == 0.0 {
        return Err("the output does not follow the input");
    }
    let test = (t_quantile(0.975, precision.dof) + t_quantile(0.95, precision.dof))
        * std::f64::consts::SQRT_2
        * precision.value;
    let value = test.max(lsb.unwrap_or(0.0)) / slope.abs();
    if value == 0.0 {
        return Err("the readings repeat exactly and show no rounding step");
    }
    Ok(Resolution { value })
}

/// The largest step of which all differences of outputs are whole multiples within 1 % of it, if at least three
/// different multiples occur and it is above 1e-6 of the outputs' span.
pub(super) fn lsb(readings: &[Reading]) -> Option<f64> {
    let mut values: Vec<f64> = readings.iter().map(|r| r.output).collect();
    values.sort_by(f64::total_cmp);
    let first = *values.first()?;
    let span = values.last()? - first;
    // What differs by rounding errors alone is one value.
    let grain = 1e-9 * span.max(first.abs().max(values.last()?.abs()) * 1e-6);
    values.dedup_by(|a, b| *a - *b <= grain);
    let smallest = values
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return None;
    }
    let parts = (smallest / (1e-6 * span)).floor().min(1e6) as u32;
    (1..=parts)
        .find_map(|part| grid(&values, smallest / f64::from(part)))
        .filter(|step| *step > 1e-6 * span)
}

/// The step near `guess` that all differences are multiples of, if there is one.
fn grid(values: &[f64], guess: f64) -> Option<f64> {
    let first = values[0];
    let mut step = guess;
    let (mut md, mut mm) = (guess, 1.0);
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let mut multiples = std::collections::BTreeSet::new();
    for &v in &values[1..] {
        let d = v - first;
        let m = (d / step).round();
        let off = d - m * step;
        low = low.min(off);
        high = high.max(off);
        // Twice the tolerance while the step is still being refined; the exact test follows.
        if high - low > 0.02 * step {
            return None;
        }
        md += m * d;
        mm += m * m;
        step = md / mm;
    }
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for &v in values {
        let d = v - first;
        let m = (d / step).round();
        let off = d - m * step;
        low = low.min(off);
        high = high.max(off);
        multiples.insert(m as i64);
    }
    let different = differences(&multiples);
    (high - low <= 0.01 * step && different >= 3).then_some(step)
}

/// How many different multiples occur among the pairwise differences; three is all that matters.
fn differences(multiples: &std::collections::BTreeSet<i64>) -> usize {
    let mut seen = std::collections::BTreeSet::new();
    let list: Vec<i64> = multiples.iter().copied().collect();
    for (i, a) in list.iter().enumerate() {
        for b in &list[i + 1..] {
            seen.insert(b - a);
            if seen.len() >= 3 {
                return 3;
            }
        }
    }
    seen.len()
}
