//! Traces of a bias that was taken out before: low frequencies that a high-pass took away, a first stretch with mean zero.
//!
//! No term of the model lies below the white level at low frequencies: Σ P/N² over the ν lowest coefficients is at least
//! χ²_ν. And the sums S_k of samples pass zero within ε σ √k by chance at about 0.8 ε of the places k; that the sums of three
//! axes do so at one place tells that the mean up to there was subtracted. Where one axis is high-passed and the others'
//! means are zero, the Earth's rate not in them, the same was done to all.

use super::findings::{EARTH_RATE_RAD_S, sort};
use super::{AxisOutcome, LogOutcome};
use sagnac_analysis::fit::AxisEstimate;
use sagnac_core::Sensor;
use sagnac_log::health::{ChannelHealth, Health};
use sagnac_log::{Issue, IssueKind};
use sagnac_report::text::{Unit, duration, general};

/// Standard deviations (of the cube root of χ², [WilsonHilferty1931]) below the white level: 3e-6 a test by chance.
const BELOW_WHITE: f64 = -4.5;
/// Chance of a false zero mean of a stretch in a log.
const FALSE_ZERO: f64 = 1e-4;
/// Standard errors within which a mean is zero, and by which the Earth's rate must be missed.
const ZERO_ERRORS: f64 = 3.0;
/// Fewest samples of such a stretch.
const FEWEST: usize = 64;

/// Adds what tells of a removed bias to the issues of the log.
pub(super) fn add(outcome: &mut LogOutcome, health: &Health<'_>) {
    let known = |channel: &str| {
        let mut removed = outcome
            .issues
            .iter()
            .filter(|i| i.kind == IssueKind::BiasRemoved);
        removed.any(|i| i.channel.as_deref().is_some_and(|c| channel.starts_with(c)))
    };
    let whole = |axis: &AxisOutcome, text: String| Issue {
        kind: IssueKind::BiasRemoved,
        channel: Some(axis.axis.clone()),
        start_s: outcome.first_s,
        end_s: outcome.first_s + outcome.duration_s,
        count: outcome.samples as u64,
        text,
    };
    let mut new = Vec::new();
    for axis in &outcome.axes {
        let Some(corner_hz) = axis.estimate.as_ref().and_then(high_pass_hz) else {
            continue;
        };
        new.push(whole(
            axis,
            format!(
                "the spectrum falls below the white noise under {} Hz: high-passed, the bias and slow terms are gone",
                general(corner_hz, 2)
            ),
        ));
    }
    if let Some(text) = on_the_fly(outcome, &new) {
        new.push(Issue {
            kind: IssueKind::BiasRemoved,
            channel: Some("gyro".to_owned()),
            start_s: outcome.first_s,
            end_s: outcome.first_s + outcome.duration_s,
            count: outcome.samples as u64,
            text,
        });
    } else if !known("gyro")
        && let Some(end) = zero_stretch(health)
    {
        let end_s = end as f64 * health.dt_s;
        new.push(Issue {
            kind: IssueKind::BiasRemoved,
            channel: Some("gyro".to_owned()),
            start_s: outcome.first_s,
            end_s: outcome.first_s + end_s,
            count: end as u64,
            text: format!(
                "the mean of the first {} is zero: it was taken for the bias and removed from all",
                duration(end_s)
            ),
        });
    }
    outcome.issues.extend(new);
    sort(&mut outcome.issues);
}

/// Where one gyro axis is high-passed and no axis shows a bias or the Earth's rate: the remover works on all of them.
///
/// Means of zero alone tell nothing: a log may be of noise without a sensor.
fn on_the_fly(outcome: &LogOutcome, high_passed: &[Issue]) -> Option<String> {
    let gyro: Vec<&AxisOutcome> = outcome
        .axes
        .iter()
        .filter(|a| a.sensor == Sensor::Gyro)
        .collect();
    let passed = gyro
        .iter()
        .filter(|a| {
            high_passed
                .iter()
                .any(|i| i.channel.as_ref() == Some(&a.axis))
        })
        .count();
    if gyro.len() < 3 || passed == 0 || passed == gyro.len() {
        return None;
    }
    let (mut square, mut variance) = (0.0, 0.0);
    for axis in gyro {
        let e = axis.estimate.as_ref().filter(|e| !e.is_coarse())?;
        let (mean, sigma) = e.mean.value.zip(e.mean.sigma)?;
        if mean.abs() > ZERO_ERRORS * sigma {
            return None;
        }
        square += mean * mean;
        variance += sigma * sigma;
    }
    let rate: f64 = square.sqrt();
    (rate + ZERO_ERRORS * variance.sqrt() < EARTH_RATE_RAD_S).then(|| {
        format!(
            "no axis shows a bias or the Earth's 15.04 deg/h, |w| = {} deg/h: removed on the fly on all, means and slow terms are those of the remover",
            general(Unit::DEG_PER_H.from_si(rate), 2)
        )
    })
}

/// The frequency below which the spectrum is that of a high-pass: half of the white level.
fn high_pass_hz(e: &AxisEstimate) -> Option<f64> {
    let white = e.fitted.white.powi(2);
    if white <= 0.0 || e.is_coarse() {
        return None;
    }
    // Every regressor takes a coefficient's worth of power.
    let taken = e.regressors.len() as f64 + if e.fitted.ramp == 0.0 { 0.0 } else { 1.0 };
    let (mut sum, mut count, mut is_below) = (0.0, -taken, false);
    let bins = || e.spectrum.iter().filter(|b| b.used);
    for bin in bins() {
        sum += bin.count * bin.measured / white;
        count += bin.count;
        if count >= 8.0 {
            let spread = 2.0 / (9.0 * count);
            let z = ((sum / count).cbrt() - (1.0 - spread)) / spread.sqrt();
            is_below |= z < BELOW_WHITE && sum < 0.5 * count;
        }
    }
    if !is_below {
        return None;
    }
    // From above, the first octave with less than half of the level.
    let (low, mut high) = (
        bins().next()?.frequency_hz,
        bins().next_back()?.frequency_hz,
    );
    while high > low {
        let own = bins().filter(|b| b.frequency_hz <= high && b.frequency_hz > 0.5 * high);
        let (sum, count) = own.fold((0.0, 0.0), |(s, n), b| {
            (s + b.count * b.measured, n + b.count)
        });
        if count > 0.0 && sum < 0.5 * white * count {
            return Some(high);
        }
        high *= std::f64::consts::FRAC_1_SQRT_2;
    }
    None
}

/// The number of samples from the start over which every gyro axis has a mean of zero, where that is no chance.
fn zero_stretch(health: &Health<'_>) -> Option<usize> {
    let gyro: Vec<&ChannelHealth<'_>> = health
        .channels
        .iter()
        .filter(|c| super::axis_of(&c.name).is_some_and(|(s, _)| s == Sensor::Gyro))
        .collect();
    let [x, y, z] = gyro[..] else { return None };
    let n = x.values.len();
    let of = [x, y, z];
    // Each its own noise, and nothing known of a grid on which sums are zero by rounding.
    let apart = x.values != y.values && y.values != z.values && z.values != x.values;
    if !apart || of.iter().any(|c| c.values.len() != n || c.sigma_w <= 0.0) || n <= FEWEST {
        return None;
    }
    let share = (FALSE_ZERO / n as f64).cbrt() / 0.8;
    let mut sums = [0.0; 3];
    let mut found = None;
    for k in 0..n {
        for (sum, c) in sums.iter_mut().zip(&of) {
            let y = c.values[k];
            if y.is_finite() {
                *sum += y / c.sigma_w;
            }
        }
        let level = share * ((k + 1) as f64).sqrt();
        if k + 1 >= FEWEST
            && k + 1 < n
            && sums.iter().all(|s| s.abs() < level)
            && of
                .iter()
                .all(|c| c.lsb.is_none_or(|q| q < level * c.sigma_w))
        {
            found = Some(k + 1);
        }
    }
    found
}
