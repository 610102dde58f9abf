//! Parameter paths: the keys of the model file joined by dots, `fixed` and `matrix` left out, then the axis.
//!
//! `gyro.bias.x`, `gyro.misalignment.xy`, `gyro.g2_sensitivity.x.yz`, `accel.axis_offset.xz`,
//! `accel.scale_factor.temperature.1.y` (power 1), `gyro.noise.gauss_markov.1.sigma.x` (entries count from 1).

use crate::error::Error;
use crate::schema::{Kind, LEAVES, Leaf, MOST_LISTED, MOST_POWERS, Shape};
use crate::suggest::suggest;
use crate::units::Dimension;
use sagnac_core::Sensor;
use std::fmt;

/// A parameter's place in the model: of one axis, or of all.
///
/// ```
/// use sagnac_model::ParameterPath;
/// let path: ParameterPath = "gyro.noise.angle_random_walk.x".parse()?;
/// assert_eq!(path.dimension().si_unit(), "rad/s^0.5");
/// assert_eq!(path.without_axis().elements().len(), 3);
/// let error = "gyro.noise.angel_random_walk".parse::<ParameterPath>().unwrap_err();
/// assert_eq!(error.advice().as_deref(), Some("did you mean `gyro.noise.angle_random_walk`?"));
/// # Ok::<(), sagnac_model::Error>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParameterPath {
    sensor: Sensor,
    /// The place in the schema, so that paths sort in the order of the contract.
    leaf: usize,
    number: usize,
    element: Option<usize>,
}

impl ParameterPath {
    pub(crate) fn new(sensor: Sensor, leaf: usize, number: usize, element: Option<usize>) -> Self {
        Self {
            sensor,
            leaf,
            number,
            element,
        }
    }

    pub(crate) fn leaf(self) -> &'static Leaf {
        &LEAVES[self.leaf]
    }

    pub(crate) fn leaf_index(self) -> usize {
        self.leaf
    }

    /// The power of temperature, or the place in a list or of a knot, from 1; 0 where there is none.
    pub fn number(self) -> usize {
        self.number
    }

    /// Gyro or accelerometer.
    pub fn sensor(self) -> Sensor {
        self.sensor
    }

    /// The place among the elements of its key; none where it stands for all.
    pub fn element(self) -> Option<usize> {
        self.element
    }

    /// The sense axis of the element, 0 to 2.
    pub fn axis(self) -> Option<usize> {
        let element = self.element?;
        Some(match self.leaf().shape {
            Shape::Axes => element,
            Shape::Elements => element / 2,
            Shape::Matrix => element / 3,
            Shape::Products => element / 6,
            Shape::Vector => ["x", "y", "z"]
                .iter()
                .position(|axis| *axis == self.leaf().key)?,
        })
    }

    /// What it measures. The resolution of a sensor with `output = "increment"` is an angle or a speed instead.
    pub fn dimension(self) -> Dimension {
        let dimension = self.leaf().dimension(self.sensor);
        if self.leaf().kind == Kind::Powers {
            dimension.per_kelvin(self.number as u8)
        } else {
            dimension
        }
    }

    /// The same of all axes.
    #[must_use]
    pub fn without_axis(self) -> Self {
        Self {
            element: None,
            ..self
        }
    }

    /// One element of its key, by its place; none beyond the last.
    pub fn with_element(self, element: usize) -> Option<Self> {
        (element < self.leaf().shape.suffixes().len()).then_some(Self {
            element: Some(element),
            ..self
        })
    }

    /// The paths of its elements: itself if it names one.
    pub fn elements(self) -> Vec<Self> {
        if self.element.is_some() {
            return vec![self];
        }
        (0..self.leaf().shape.suffixes().len())
            .map(|element| Self {
                element: Some(element),
                ..self
            })
            .collect()
    }

    /// The keys in the file that it stands under, without the sensor: `["noise", "angle_random_walk"]`.
    pub fn file_keys(self) -> Vec<&'static str> {
        self.leaf()
            .table
            .iter()
            .copied()
            .chain([self.leaf().key])
            .collect()
    }

    /// Every path without axis that a sensor can have, with number 1 where it is counted.
    pub fn all() -> impl Iterator<Item = Self> {
        Sensor::ALL.into_iter().flat_map(|sensor| {
            LEAVES
                .iter()
                .enumerate()
                .filter(move |(_, leaf)| leaf.sensors.contains(&sensor))
                .map(move |(index, leaf)| {
                    let number = usize::from(leaf.kind != Kind::Value);
                    Self {
                        sensor,
                        leaf: index,
                        number,
                        element: None,
                    }
                })
        })
    }

    fn parse(text: &str) -> Option<Self> {
        let (sensor, rest) = text.split_once('.')?;
        let sensor = Sensor::ALL
            .into_iter()
            .find(|candidate| candidate.key() == sensor)?;
        let parts: Vec<&str> = rest.split('.').collect();
        if parts.len() > 8 {
            return None;
        }
        // The longest key wins: `bias.stability` before `bias`.
        let mut best: Option<(usize, Self)> = None;
        for (index, leaf) in LEAVES
            .iter()
            .enumerate()
            .filter(|(_, leaf)| leaf.sensors.contains(&sensor))
        {
            if let Some((used, number, after)) = match_keys(leaf, &parts) {
                let element = match after {
                    [] => None,
                    after => {
                        let suffix = after.join(".");
                        let Some(at) = leaf
                            .shape
                            .suffixes()
                            .iter()
                            .position(|known| **known == suffix)
                        else {
                            continue;
                        };
                        Some(at)
                    }
                };
                let candidate = Self {
                    sensor,
                    leaf: index,
                    number,
                    element,
                };
                if best.is_none_or(|(length, _)| used > length) {
                    best = Some((used, candidate));
                }
            }
        }
        best.map(|(_, path)| path)
    }
}

/// Matches the keys of a leaf at the beginning of a path: keys used, number, what is left.
fn match_keys<'a, 'b>(leaf: &Leaf, parts: &'b [&'a str]) -> Option<(usize, usize, &'b [&'a str])> {
    // A vector's letter and its component's are written together: see `parse_offset`.
    if leaf.shape == Shape::Vector {
        return None;
    }
    let (at_number, most) = match leaf.kind {
        Kind::Value => (None, 0),
        Kind::Powers => (Some(leaf.path_length()), MOST_POWERS),
        Kind::Spline => (Some(leaf.path_length()), sagnac_core::MAX_KNOTS),
        Kind::Listed => (Some(leaf.table.len()), MOST_LISTED),
    };
    let mut number = 0;
    let mut at = 0;
    for (index, key) in leaf.path_keys().enumerate() {
        if at_number == Some(index) {
            number = parse_number(parts.get(at)?, most)?;
            at += 1;
        }
        if parts.get(at) != Some(&key) {
            return None;
        }
        at += 1;
    }
    if at_number == Some(leaf.path_length()) {
        number = parse_number(parts.get(at)?, most)?;
        at += 1;
    }
    Some((at, number, parts.get(at..)?))
}

fn parse_number(text: &str, most: usize) -> Option<usize> {
    let number: usize = text.parse().ok()?;
    (1..=most).contains(&number).then_some(number)
}

impl std::str::FromStr for ParameterPath {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        // The components of a vector are matched without its letter.
        if let Some(path) = parse_offset(text).or_else(|| Self::parse(text)) {
            return Ok(path);
        }
        let names: Vec<String> = Self::all().map(|path| path.to_string()).collect();
        let bare = text
            .trim_end_matches(".x")
            .trim_end_matches(".y")
            .trim_end_matches(".z");
        let suggestion = suggest(bare, names.iter().map(String::as_str)).map(str::to_string);
        Err(Error::UnknownPath {
            path: crate::units::clip(text),
            suggestion,
        })
    }
}

/// `accel.axis_offset.xz`, or `accel.axis_offset.x` for the whole vector of accelerometer x.
fn parse_offset(text: &str) -> Option<ParameterPath> {
    let letters = text.strip_prefix("accel.axis_offset.")?;
    let mut letters = letters.chars();
    let vector = letters.next()?.to_string();
    let leaf = LEAVES
        .iter()
        .position(|leaf| leaf.shape == Shape::Vector && leaf.key == vector)?;
    let element = match letters.next() {
        None => None,
        Some(component) => Some("xyz".find(component)?),
    };
    letters.next().is_none().then_some(ParameterPath {
        sensor: Sensor::Accel,
        leaf,
        number: 0,
        element,
    })
}

impl fmt::Display for ParameterPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sensor.key())?;
        for (index, key) in self.leaf().path_keys().enumerate() {
            if self.leaf().kind == Kind::Listed && index == self.leaf().table.len() {
                write!(f, ".{}", self.number)?;
            }
            write!(f, ".{key}")?;
        }
        if matches!(self.leaf().kind, Kind::Powers | Kind::Spline) {
            write!(f, ".{}", self.number)?;
        }
        if let Some(element) = self.element {
            let dot = if self.leaf().shape == Shape::Vector {
                ""
            } else {
                "."
            };
            write!(f, "{dot}{}", self.leaf().shape.suffixes()[element])?;
        }
        Ok(())
    }
}

impl fmt::Debug for ParameterPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ParameterPath({self})")
    }
}
