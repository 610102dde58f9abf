//! How a number that is not the reference's probably came about: the ratios that the usual mistakes give.

use super::audit::{AuditEntry, Estimate, Ratio};
use super::convention::Quantity;
use crate::export::Format;
use crate::model::Model;
use crate::random::FLICKER_FLOOR;
use sagnac_core::Sensor;

/// How a number probably came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// The square was written.
    Variance,
    /// A factor of √f.
    SqrtRate,
    /// A factor of √2.
    Sqrt2,
    /// Allan minimum for coefficient.
    AllanMinimum,
    /// deg for rad.
    Degrees,
    /// g for m/s².
    G,
    /// σ of a sample for a density.
    PerSample,
    /// Bias instability for a random walk.
    InstabilityAsWalk,
    /// Made larger on purpose.
    Inflated,
}

impl Mistake {
    /// As in JSON.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Variance => "variance",
            Self::SqrtRate => "sqrt_rate",
            Self::Sqrt2 => "sqrt_2",
            Self::AllanMinimum => "allan_minimum",
            Self::Degrees => "degrees",
            Self::G => "g",
            Self::PerSample => "per_sample",
            Self::InstabilityAsWalk => "instability_as_walk",
            Self::Inflated => "inflated",
        }
    }

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Variance => "a variance, no standard deviation",
            Self::SqrtRate => "off by the root of the rate",
            Self::Sqrt2 => "off by the root of two",
            Self::AllanMinimum => "Allan minimum and coefficient mixed up",
            Self::Degrees => "degrees and radians mixed up",
            Self::G => "g and m/s^2 mixed up",
            Self::PerSample => "per-sample sigma, no density",
            Self::InstabilityAsWalk => "a bias instability, no random walk",
            Self::Inflated => "inflated on purpose?",
        }
    }
}

/// A number that does not agree, and what it is compared with.
pub(super) struct Case<'a> {
    pub(super) entry: &'a AuditEntry,
    pub(super) meaning: f64,
    pub(super) known: Estimate,
    pub(super) ratio: Ratio,
    pub(super) format: Format,
    pub(super) rate_hz: Option<f64>,
    pub(super) reference: Option<&'a Model>,
}

/// A number counts as held by an interval that it misses by less: digits that a file rounds away.
const ROUNDING: f64 = 0.005;

/// The mistakes that explain a number, the first the likeliest; those that the ratio's interval holds, if it holds any.
pub(super) fn mistakes(case: &Case) -> Vec<Mistake> {
    let mut found: Vec<(Mistake, bool)> = Vec::new();
    let entry = case.entry;
    let noise = matches!(entry.quantity, Quantity::White | Quantity::Walk);
    if entry.quantity == Quantity::Walk {
        as_walk(case, &mut found);
    }
    if noise {
        variance(case, &mut found);
    }
    let ratios = Ratios { ratio: case.ratio };
    let mut add = |mistake: Mistake, targets: &[f64]| {
        if targets.iter().any(|target| ratios.near(*target)) {
            found.push((mistake, targets.iter().any(|target| ratios.holds(*target))));
        }
    };
    if noise && let Some(rate_hz) = case.rate_hz {
        let root = rate_hz.sqrt();
        let wants_density = !matches!(case.format, Format::Vins | Format::Gazebo | Format::RosImu);
        let more = if wants_density {
            Mistake::PerSample
        } else {
            Mistake::SqrtRate
        };
        add(more, &[root]);
        add(Mistake::SqrtRate, &[1.0 / root]);
        if case.format == Format::Vins && entry.quantity == Quantity::White {
            add(Mistake::SqrtRate, &[1.0 / (2.0 * rate_hz).sqrt()]);
        }
    }
    match entry.sensor {
        Sensor::Gyro => add(Mistake::Degrees, &[57.295_779_513, 1.0 / 57.295_779_513]),
        Sensor::Accel => add(Mistake::G, &[9.80665, 1.0 / 9.80665]),
    }
    if entry.quantity == Quantity::White {
        let root = std::f64::consts::SQRT_2;
        add(Mistake::Sqrt2, &[root, 1.0 / root]);
    }
    if matches!(
        entry.quantity,
        Quantity::Coefficient | Quantity::AllanMinimum
    ) {
        add(Mistake::AllanMinimum, &[FLICKER_FLOOR, 1.0 / FLICKER_FLOOR]);
    }
    let decisive = found.iter().any(|(_, held)| *held);
    let mut mistakes: Vec<Mistake> = Vec::new();
    for (mistake, held) in found {
        if (held || !decisive) && !mistakes.contains(&mistake) {
            mistakes.push(mistake);
        }
    }
    mistakes
}

struct Ratios {
    ratio: Ratio,
}

impl Ratios {
    /// The ratio, or the end of its interval that is nearest, is within 12 % of a target.
    fn near(&self, target: f64) -> bool {
        let Ratio {
            value,
            lower,
            upper,
            ..
        } = self.ratio;
        // A negative or unbounded value swaps the ends or leaves none: `clamp` would panic.
        let nearest = target.max(lower.min(upper)).min(lower.max(upper));
        within(value, target, 0.12) || within(nearest, target, 0.12)
    }

    fn holds(&self, target: f64) -> bool {
        let Ratio { lower, upper, .. } = self.ratio;
        (lower * (1.0 - ROUNDING)..=upper * (1.0 + ROUNDING)).contains(&target)
    }
}

fn within(value: f64, target: f64, part: f64) -> bool {
    target > 0.0 && (value / target - 1.0).abs() <= part
}

/// The bias instability of the reference, written as a walk.
fn as_walk(case: &Case, found: &mut Vec<(Mistake, bool)>) {
    let coefficient = case.reference.and_then(|model| {
        (0..3)
            .filter_map(|axis| model.flicker(case.entry.sensor, axis))
            .filter(|entry| entry.value.is_some())
            .max_by(|a, b| a.simulated().total_cmp(&b.simulated()))
    });
    let Some(entry) = coefficient else { return };
    let b = entry.simulated();
    let [lower, upper] = [entry.lower.unwrap_or(b), entry.upper.unwrap_or(b)];
    for part in [1.0, FLICKER_FLOOR] {
        if within(case.meaning, part * b, 0.12) {
            let interval = part * lower * (1.0 - ROUNDING)..=part * upper * (1.0 + ROUNDING);
            found.push((Mistake::InstabilityAsWalk, interval.contains(&case.meaning)));
        }
    }
}

/// The square of the reference, by itself or of a sample.
fn variance(case: &Case, found: &mut Vec<(Mistake, bool)>) {
    let mut factors = vec![1.0];
    if let Some(rate_hz) = case.rate_hz {
        factors.push(rate_hz);
        if case.entry.quantity == Quantity::Walk {
            factors.push(1.0 / rate_hz);
        }
    }
    let known = case.known;
    for factor in factors {
        if within(case.meaning, known.value * known.value * factor, 0.25) {
            let root = (case.meaning / factor).sqrt();
            let interval = known.lower * (1.0 - ROUNDING)..=known.upper * (1.0 + ROUNDING);
            found.push((Mistake::Variance, interval.contains(&root)));
        }
    }
}
