//! Is somebody's noise file right? What each number means, whether it is possible, and whether a reference shows it.
//!
//! The reference is a model: a sensor's sheet, or what a log gave, with the intervals that its entries carry.

use super::convention::{Foreign, Quantity, Reading, Rule, read};
use super::correct::correct;
use super::mistake::{Case, Mistake, mistakes};
use crate::error::Error;
use crate::export::Format;
use crate::model::Model;
use crate::random::FLICKER_FLOOR;
use crate::units::{Unit, format_number};
use sagnac_core::Sensor;

/// What is thought of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As the reference; without one only: possible.
    Consistent,
    /// Not as the reference, or as no sensor is.
    Suspicious,
    /// A known mistake, or impossible.
    Wrong,
    /// Cannot be told.
    Unknown,
}

impl Verdict {
    /// As in JSON.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Suspicious => "suspicious",
            Self::Wrong => "wrong",
            Self::Unknown => "unknown",
        }
    }
}

/// Value over reference, with the interval of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// Value over reference.
    pub value: f64,
    /// Value over the reference's upper end.
    pub lower: f64,
    /// Value over the reference's lower end.
    pub upper: f64,
    /// Whether the reference has an interval.
    pub known: bool,
}

/// One number judged.
#[derive(Debug, Clone, PartialEq)]
pub struct AuditEntry {
    /// The key in the file.
    pub key: String,
    /// As written.
    pub value: f64,
    /// Which convention the tool expects.
    pub convention: String,
    /// What it is.
    pub quantity: Quantity,
    /// Of which sensor.
    pub sensor: Sensor,
    /// In SI; none where it needs a rate that is not known.
    pub meaning: Option<f64>,
    /// Whether a sensor can have it; none where nothing is known of such numbers.
    pub possible: Option<bool>,
    /// Against the reference.
    pub ratio: Option<Ratio>,
    /// The verdict.
    pub verdict: Verdict,
    /// How it came about.
    pub likely_mistake: Option<Mistake>,
    /// The reasons, in a sentence.
    pub text: String,
}

/// A file judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Audit {
    /// Its format.
    pub format: Format,
    /// Another format that it fits.
    pub also: Option<Format>,
    /// The rate used \[Hz\].
    pub rate_hz: Option<f64>,
    /// Number by number.
    pub entries: Vec<AuditEntry>,
    /// What the tool lacks or would not read, and what was not read here.
    pub notes: Vec<String>,
    /// The file with the reference's numbers in its convention; none without a reference or of a binary file.
    pub corrected: Option<String>,
}

/// The reference's number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) limit: bool,
    known: bool,
}

/// Judges a file; `reference` is a model with the intervals that a log gave, or a sheet.
///
/// ```
/// use sagnac_model::foreign::{Mistake, audit};
/// // The published EuRoC file: its gyro random walk is exactly 4 deg/h.
/// let yaml = "gyroscope_noise_density: 1.6968e-04\ngyroscope_random_walk: 1.9393e-05\nupdate_rate: 200\n";
/// let judged = audit(yaml.as_bytes(), "imu.yaml", None, None, None)?;
/// assert_eq!(judged.entries[1].likely_mistake, Some(Mistake::InstabilityAsWalk));
/// # Ok::<(), sagnac_model::Error>(())
/// ```
///
/// # Errors
/// A file of no known format or without noise numbers.
pub fn audit(
    bytes: &[u8],
    label: &str,
    from: Option<Format>,
    rate_hz: Option<f64>,
    reference: Option<&Model>,
) -> Result<Audit, Error> {
    let foreign = read(bytes, label, from)?;
    let rate_hz = foreign
        .rate_hz
        .or(rate_hz)
        .or_else(|| reference.and_then(Model::sample_rate_hz));
    let noise: Vec<&Reading> = foreign
        .readings
        .iter()
        .filter(|reading| reading.quantity != Quantity::FixedBias)
        .collect();
    if noise.is_empty() {
        return Err(Error::File {
            what: format!(
                "the file has no noise number; {} holds none",
                foreign.format.title()
            ),
            place: label.to_string(),
            advice: Some("read its calibration with: sagnac import".to_string()),
        });
    }
    let entries = noise
        .iter()
        .map(|reading| judge(reading, &foreign, rate_hz, reference))
        .collect();
    let corrected = reference.and_then(|model| {
        std::str::from_utf8(bytes)
            .ok()
            .map(|text| correct(text, &foreign, rate_hz, model))
    });
    Ok(Audit {
        format: foreign.format,
        also: foreign.also,
        rate_hz,
        entries,
        notes: foreign.notes,
        corrected,
    })
}

/// Ranges beyond the noisiest and the quietest sensors known.
fn possible_range(quantity: Quantity, sensor: Sensor) -> Option<[f64; 2]> {
    Some(match (quantity, sensor) {
        (Quantity::White, Sensor::Gyro) => [1e-8, 3e-3],
        (Quantity::White, Sensor::Accel) => [1e-7, 3e-2],
        (Quantity::Walk, Sensor::Gyro) => [1e-12, 1e-3],
        (Quantity::Walk, Sensor::Accel) => [1e-9, 1e-2],
        _ => return None,
    })
}

pub(super) fn estimate(model: &Model, reading: &Reading) -> Option<Estimate> {
    let sensor = reading.sensor;
    let entry = |axis: usize| match reading.quantity {
        Quantity::White => model.white_noise(sensor, axis),
        Quantity::Walk => model
            .under(sensor, &format!("noise.{}", Model::walk_key(sensor)), axis)
            .cloned(),
        Quantity::RunToRun => model.under(sensor, "bias.stability", axis).cloned(),
        Quantity::BiasSigma => model
            .under(sensor, "noise.gauss_markov.1.sigma", axis)
            .cloned(),
        Quantity::Coefficient | Quantity::AllanMinimum => model.flicker(sensor, axis),
        Quantity::FixedBias => None,
    };
    let scale = if reading.quantity == Quantity::AllanMinimum {
        FLICKER_FLOOR
    } else {
        1.0
    };
    let axes: Vec<usize> = reading
        .axis
        .map_or_else(|| vec![0, 1, 2], |axis| vec![axis]);
    axes.into_iter()
        .filter_map(|axis| {
            let entry = entry(axis)?;
            let Some(value) = entry.value else {
                let limit = scale * entry.upper_limit?;
                return Some(Estimate {
                    value: limit,
                    lower: limit,
                    upper: limit,
                    limit: true,
                    known: false,
                });
            };
            let half = entry.sigma.map(|sigma| 1.96 * sigma);
            let lower = entry
                .lower
                .or(half.map(|half| value - half))
                .unwrap_or(value);
            let upper = entry
                .upper
                .or(half.map(|half| value + half))
                .unwrap_or(value);
            let known = entry.lower.is_some() || entry.sigma.is_some();
            Some(Estimate {
                value: scale * value,
                lower: scale * lower,
                upper: scale * upper,
                limit: false,
                known,
            })
        })
        .filter(|estimate| estimate.value > 0.0)
        .max_by(|a, b| {
            (!a.limit, a.value)
                .partial_cmp(&(!b.limit, b.value))
                .unwrap_or(std::cmp::Ordering::Equal)
        })
}

fn judge(
    reading: &Reading,
    foreign: &Foreign,
    rate_hz: Option<f64>,
    reference: Option<&Model>,
) -> AuditEntry {
    // imu_utils wrote N in some versions and √f·N in others, which gave the Allan minimum for `_w`: the reference decides.
    let open =
        foreign.format == Format::ImuUtils && !super::readings::says_continuous(&foreign.flat);
    let per_sample = open && wrote_per_sample(reading.sensor, foreign, rate_hz, reference);
    let mut reading = reading.clone();
    if per_sample && reading.quantity == Quantity::White {
        reading.rule = Rule::PerSample(1.0);
    }
    if per_sample && reading.quantity == Quantity::Walk {
        reading.quantity = Quantity::AllanMinimum;
        reading.convention = "the minimum of the Allan deviation";
    }
    let reading = &reading;
    let rule = reading.rule;
    let known = reference.and_then(|model| estimate(model, reading));
    let meaning = rule
        .meaning(reading.value, rate_hz)
        .filter(|meaning| meaning.is_finite());
    let mut entry = AuditEntry {
        key: reading.key.clone(),
        value: reading.value,
        convention: reading.convention.to_string(),
        quantity: reading.quantity,
        sensor: reading.sensor,
        meaning,
        possible: None,
        ratio: None,
        verdict: Verdict::Unknown,
        likely_mistake: None,
        text: String::new(),
    };
    let Some(meaning) = meaning else {
        entry.text =
            "what it means depends on the sampling rate, which the file does not say: add --rate"
                .into();
        return entry;
    };
    entry.possible = possible_range(reading.quantity, reading.sensor)
        .map(|[low, high]| (low..=high).contains(&meaning));
    match known {
        Some(known) => against(
            &mut entry,
            meaning,
            known,
            foreign.format,
            rate_hz,
            reference,
        ),
        None => alone(&mut entry, meaning, reading, foreign, rate_hz),
    }
    if open && reading.quantity == Quantity::White {
        entry.text.push_str(&match (rule, rate_hz) {
            (Rule::PerSample(_), _) => {
                "; read as sqrt(f) N, as the last version of the original wrote".to_string()
            }
            (_, Some(rate_hz)) => {
                format!(
                    "; as sqrt(f) N of the last version of the original it would be {}",
                    plain(meaning / rate_hz.sqrt(), &entry)
                )
            }
            _ => "; the last version of the original wrote sqrt(f) N".to_string(),
        });
    }
    entry
}

fn plain(value: f64, entry: &AuditEntry) -> String {
    let dimension = entry.quantity.dimension(entry.sensor);
    let digits = |value: f64| format_number(format!("{value:.2e}").parse().unwrap_or(value));
    format!(
        "{} {} = {} {}",
        digits(value),
        dimension.si_unit(),
        digits(value / Unit::field(dimension).factor()),
        dimension.field_unit()
    )
}

/// Without a reference: possible, or as no sensor is.
fn alone(
    entry: &mut AuditEntry,
    meaning: f64,
    reading: &Reading,
    foreign: &Foreign,
    rate_hz: Option<f64>,
) {
    let says = plain(meaning, entry);
    if entry.possible == Some(false) {
        entry.verdict = Verdict::Wrong;
        entry.text = format!("is {says}: no sensor has that");
        return;
    }
    let deg_h = meaning.to_degrees() * 3600.0;
    if reading.quantity == Quantity::Walk && reading.sensor == Sensor::Gyro {
        let whole = deg_h.round();
        if (1.0..=360.0).contains(&whole) && (deg_h - whole).abs() <= 2e-4 * whole {
            entry.verdict = Verdict::Suspicious;
            entry.likely_mistake = Some(Mistake::InstabilityAsWalk);
            entry.text = format!(
                "is {says}: the number is {whole} deg/h in rad/s, a bias and no random walk"
            );
            return;
        }
    }
    let partner = foreign
        .readings
        .iter()
        .filter(|other| {
            other.sensor == reading.sensor
                && other.quantity == Quantity::White
                && (other.axis == reading.axis || reading.axis.is_none())
        })
        .filter_map(|other| other.rule.meaning(other.value, rate_hz))
        .reduce(f64::max);
    if reading.quantity == Quantity::Walk
        && let Some(white) = partner
        && meaning > 0.0
    {
        let crossing_s = 3.0_f64.sqrt() * white / meaning;
        if crossing_s < 10.0 {
            entry.verdict = Verdict::Suspicious;
            entry.likely_mistake = Some(Mistake::Inflated);
            let n = format_number(format!("{white:.2e}").parse().unwrap_or(white));
            entry.text = format!(
                "is {says}: with N = {n} it passes the white noise after {crossing_s:.1} s, as no such sensor does"
            );
            return;
        }
    }
    entry.verdict = Verdict::Consistent;
    entry.text = format!("is {says}: possible; without a log or a model no more can be said");
}

/// With a reference.
fn against(
    entry: &mut AuditEntry,
    meaning: f64,
    known: Estimate,
    format: Format,
    rate_hz: Option<f64>,
    reference: Option<&Model>,
) {
    let says = plain(meaning, entry);
    let ratio = Ratio {
        value: meaning / known.value,
        lower: meaning / known.upper,
        upper: meaning / known.lower.max(f64::MIN_POSITIVE),
        known: known.known,
    };
    if known.limit && meaning < known.value {
        entry.text = format!(
            "is {says}: the reference only bounds it, < {}",
            plain(known.value, entry)
        );
        return;
    }
    entry.ratio = Some(ratio);
    let times = if ratio.known {
        format!(
            "{:.3} ({:.3} to {:.3}) times the reference",
            ratio.value, ratio.lower, ratio.upper
        )
    } else {
        format!("{:.3} times the reference", ratio.value)
    };
    if ratio.lower <= 1.25 && ratio.upper >= 0.8 {
        entry.verdict = Verdict::Consistent;
        entry.text = format!("is {says}: {times}");
        return;
    }
    let found = mistakes(&Case {
        entry,
        meaning,
        known,
        ratio,
        format,
        rate_hz,
        reference,
    });
    let impossible = entry.possible == Some(false);
    let named = !found.is_empty();
    let found = if named || impossible || ratio.value <= 1.5 {
        found
    } else {
        vec![Mistake::Inflated]
    };
    entry.likely_mistake = found.first().copied();
    entry.verdict = if named || impossible {
        Verdict::Wrong
    } else {
        Verdict::Suspicious
    };
    let mut reason = String::new();
    for mistake in &found {
        match (mistake, rate_hz) {
            (Mistake::PerSample | Mistake::SqrtRate, Some(rate_hz)) => reason.push_str(&format!(
                ", and sqrt({} Hz) = {:.1}",
                format_number(rate_hz),
                rate_hz.sqrt()
            )),
            (Mistake::Degrees, _) => reason.push_str(", and 180/pi = 57.3"),
            (Mistake::G, _) => reason.push_str(", and g = 9.81 m/s^2"),
            _ => {}
        }
    }
    let words: Vec<&str> = found.iter().map(|mistake| mistake.words()).collect();
    let words = if words.is_empty() {
        String::new()
    } else {
        format!(": {}", words.join(", or "))
    };
    let never = if impossible {
        "; no sensor has that"
    } else {
        ""
    };
    entry.text = format!("is {says}: {times}{reason}{words}{never}");
}

/// Whether the reference shows that an imu_utils file holds √f·N.
fn wrote_per_sample(
    sensor: Sensor,
    foreign: &Foreign,
    rate_hz: Option<f64>,
    reference: Option<&Model>,
) -> bool {
    let white = foreign
        .readings
        .iter()
        .find(|reading| reading.sensor == sensor && reading.quantity == Quantity::White);
    let (Some(white), Some(rate_hz), Some(model)) = (white, rate_hz, reference) else {
        return false;
    };
    let Some(known) = estimate(model, white) else {
        return false;
    };
    let off = |meaning: f64| (meaning / known.value).ln().abs();
    off(white.value / rate_hz.sqrt()) < off(white.value)
}
