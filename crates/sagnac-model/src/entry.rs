//! One number of a model and what is known about it.

use crate::units::{Dimension, Unit};

/// A value with its uncertainty and source; every number in SI (absolute temperatures in °C).
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The value; none where only a limit is known.
    pub value: Option<f64>,
    /// One standard deviation.
    pub sigma: Option<f64>,
    /// The 95 % limit of a term that was looked for and not seen; it is simulated as zero.
    pub upper_limit: Option<f64>,
    /// The lower end of the range known.
    pub lower: Option<f64>,
    /// The upper end of the range known.
    pub upper: Option<f64>,
    /// Where the number comes from: `D: data sheet, rev. C, table 2`.
    pub source: Option<String>,
    /// Anything else about it.
    pub note: Option<String>,
    /// The unit in which it was read or is to be written.
    pub unit: Unit,
}

impl Entry {
    /// A bare value, written in the unit of the field.
    pub fn of(value: f64, dimension: Dimension) -> Self {
        Self {
            value: Some(value),
            ..Self::empty(Unit::field(dimension))
        }
    }

    /// Nothing known yet.
    pub fn empty(unit: Unit) -> Self {
        Self {
            value: None,
            sigma: None,
            upper_limit: None,
            lower: None,
            upper: None,
            source: None,
            note: None,
            unit,
        }
    }

    /// An estimate: value, 1σ and the ends of its 95 % interval.
    pub fn estimate(value: f64, sigma: f64, interval: [f64; 2], dimension: Dimension) -> Self {
        let [lower, upper] = interval.map(Some);
        Self {
            sigma: Some(sigma),
            lower,
            upper,
            ..Self::of(value, dimension)
        }
    }

    /// A term that was looked for and not seen: its 95 % limit.
    pub fn limit(upper_limit: f64, dimension: Dimension) -> Self {
        Self {
            upper_limit: Some(upper_limit),
            ..Self::empty(Unit::field(dimension))
        }
    }

    /// The same with a source.
    #[must_use]
    pub fn with_source(self, source: impl Into<String>) -> Self {
        Self {
            source: Some(source.into()),
            ..self
        }
    }

    /// The same with a note.
    #[must_use]
    pub fn with_note(self, note: impl Into<String>) -> Self {
        Self {
            note: Some(note.into()),
            ..self
        }
    }

    /// What is simulated: the value, or zero where only a limit is known.
    pub fn simulated(&self) -> f64 {
        self.value.unwrap_or(0.0)
    }

    /// Whether it is an upper limit only.
    pub fn is_limit(&self) -> bool {
        self.value.is_none() && self.upper_limit.is_some()
    }

    /// Whether anything but the value is known.
    pub(crate) fn is_bare(&self) -> bool {
        self.value.is_some()
            && [self.sigma, self.upper_limit, self.lower, self.upper]
                .iter()
                .all(Option::is_none)
            && self.source.is_none()
            && self.note.is_none()
    }

    /// The quantities in the order of the file, by key.
    pub(crate) fn quantities(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("value", self.value),
            ("sigma", self.sigma),
            ("upper_limit", self.upper_limit),
            ("lower", self.lower),
            ("upper", self.upper),
        ]
    }

    pub(crate) fn set_quantity(&mut self, key: &str, value: f64) {
        let place = match key {
            "value" => &mut self.value,
            "sigma" => &mut self.sigma,
            "upper_limit" => &mut self.upper_limit,
            "lower" => &mut self.lower,
            _ => &mut self.upper,
        };
        *place = Some(value);
    }
}
