//! One sensor: everything the lecture names, by parameter path, with uncertainties and sources.

use crate::calibration::Calibration;
use crate::catalog_table::CatalogTable;
use crate::entry::Entry;
use crate::error::Error;
use crate::path::ParameterPath;
use crate::read;
use sagnac_core::{Output, Sensor};
use std::collections::BTreeMap;
use toml_edit::DocumentMut;

/// The process of `bias.instability`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Process {
    /// PSD B²/(2π|f|).
    #[default]
    Flicker,
    /// PSD K²/(2πf)².
    RandomWalk,
    /// First-order, exponential correlation.
    GaussMarkov,
}

impl Process {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Flicker, Self::RandomWalk, Self::GaussMarkov];

    /// As in the file: `flicker`, `random_walk`, `gauss_markov`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Flicker => "flicker",
            Self::RandomWalk => "random_walk",
            Self::GaussMarkov => "gauss_markov",
        }
    }
}

/// What a model says of a sensor besides numbers by axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct SensorTexts {
    pub(crate) present: bool,
    pub(crate) technology: Option<String>,
    pub(crate) output: Option<Output>,
    pub(crate) process: Option<Process>,
    /// Of bias and scale factor.
    pub(crate) temperature_range_c: [Option<[f64; 2]>; 2],
    /// Of the splines of bias and scale factor.
    pub(crate) knots_c: [Option<Vec<f64>>; 2],
}

/// The two terms that depend on temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThermalTerm {
    /// `bias`.
    Bias,
    /// `scale_factor`.
    ScaleFactor,
}

impl ThermalTerm {
    pub(crate) const ALL: [Self; 2] = [Self::Bias, Self::ScaleFactor];

    pub(crate) const fn index(self) -> usize {
        match self {
            Self::Bias => 0,
            Self::ScaleFactor => 1,
        }
    }

    pub(crate) const fn key(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::ScaleFactor => "scale_factor",
        }
    }
}

/// A sensor model, as its file says it.
///
/// Numbers are in SI and found by parameter path; what is written again keeps comments, order and spelling of
/// everything that was not changed.
///
/// ```
/// use sagnac_model::Model;
/// let model = Model::parse("name = \"X\"\n[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"", "x.toml")?;
/// let n = model.triad("gyro.noise.angle_random_walk").unwrap();
/// assert!((n[0] - 8.7266e-5).abs() < 1e-9); // rad/√s, all three axes alike
/// let error = Model::parse("name = \"X\"\n[gyro.noise]\nangel_random_walk = \"1 deg/sqrt(h)\"", "x.toml").unwrap_err();
/// assert_eq!(error.place().as_deref(), Some("x.toml, line 3, in [gyro.noise]"));
/// # Ok::<(), sagnac_model::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    pub(crate) label: String,
    pub(crate) document: DocumentMut,
    pub(crate) name: String,
    pub(crate) manufacturer: Option<String>,
    pub(crate) sample_rate: Option<Entry>,
    pub(crate) reference_temperature: Option<Entry>,
    pub(crate) temperature_range_c: Option<[f64; 2]>,
    pub(crate) sensors: [SensorTexts; 2],
    pub(crate) entries: BTreeMap<ParameterPath, Entry>,
    pub(crate) calibrations: Vec<Calibration>,
    pub(crate) catalog: Option<CatalogTable>,
}

impl Model {
    /// Reads a model file; `label` names it in errors.
    ///
    /// # Errors
    /// Anything that is not as the contract says: unknown keys (with a suggestion), wrong dimensions, values that
    /// exclude one another; each with file, line and key.
    pub fn parse(text: &str, label: &str) -> Result<Self, Error> {
        read::model(text, label)
    }

    /// As [`Model::parse`], of bytes that need not be text.
    pub fn from_bytes(bytes: &[u8], label: &str) -> Result<Self, Error> {
        let text = std::str::from_utf8(bytes).map_err(|error| Error::File {
            what: "the file is no text, so it is no model file".to_string(),
            place: format!("{label}, byte {}", error.valid_up_to()),
            advice: Some("a model file is TOML in UTF-8".to_string()),
        })?;
        Self::parse(text.strip_prefix('\u{feff}').unwrap_or(text), label)
    }

    /// A model that knows nothing but its name.
    pub fn new(name: &str) -> Self {
        let mut document = DocumentMut::new();
        document.insert("schema", toml_edit::value(1));
        document.insert("name", toml_edit::value(name));
        Self {
            label: name.to_string(),
            document,
            name: name.to_string(),
            manufacturer: None,
            sample_rate: None,
            reference_temperature: None,
            temperature_range_c: None,
            sensors: Default::default(),
            entries: BTreeMap::new(),
            calibrations: Vec::new(),
            catalog: None,
        }
    }

    /// The text of the file.
    pub fn to_toml(&self) -> String {
        self.document.to_string()
    }

    /// What errors call it: the file's name as given.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The sensor's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Who makes it.
    pub fn manufacturer(&self) -> Option<&str> {
        self.manufacturer.as_deref()
    }

    /// The sampling rate \[Hz\].
    pub fn sample_rate_hz(&self) -> Option<f64> {
        self.sample_rate.as_ref()?.value
    }

    /// T0 [°C]: 25 where the file has none.
    pub fn reference_temperature_c(&self) -> f64 {
        self.reference_temperature
            .as_ref()
            .and_then(|entry| entry.value)
            .unwrap_or(sagnac_core::DEFAULT_REFERENCE_C)
    }

    /// T0 [°C], if the file states it.
    pub fn stated_reference_temperature_c(&self) -> Option<f64> {
        self.reference_temperature.as_ref()?.value
    }

    /// Where the temperature terms hold [°C].
    pub fn temperature_range_c(&self) -> Option<[f64; 2]> {
        self.temperature_range_c
    }

    /// The range of one term, which wins over the model's [°C].
    pub fn own_temperature_range_c(&self, sensor: Sensor, term: ThermalTerm) -> Option<[f64; 2]> {
        self.sensors[sensor.index()].temperature_range_c[term.index()]
    }

    /// The knots of a term's temperature spline [°C].
    pub fn knots_c(&self, sensor: Sensor, term: ThermalTerm) -> Option<&[f64]> {
        self.sensors[sensor.index()].knots_c[term.index()].as_deref()
    }

    /// Whether the file has a table of this sensor.
    pub fn has(&self, sensor: Sensor) -> bool {
        self.sensors[sensor.index()].present
    }

    /// `MEMS`, `FOG`, …
    pub fn technology(&self, sensor: Sensor) -> Option<&str> {
        self.sensors[sensor.index()].technology.as_deref()
    }

    /// Rates (the default) or increments.
    pub fn output(&self, sensor: Sensor) -> Output {
        self.sensors[sensor.index()].output.unwrap_or_default()
    }

    /// The process of the bias instability; `flicker` where the file names none.
    pub fn process(&self, sensor: Sensor) -> Process {
        self.sensors[sensor.index()].process.unwrap_or_default()
    }

    /// What is known of one parameter: of the path's axis, or without one of the first axis that has it.
    pub fn get(&self, path: &str) -> Option<&Entry> {
        self.at(path.parse().ok()?)
    }

    /// As [`Model::get`], by a path that was parsed.
    pub fn at(&self, path: ParameterPath) -> Option<&Entry> {
        path.elements()
            .into_iter()
            .find_map(|element| self.entries.get(&element))
    }

    /// The simulated values of all elements of a key: an axis without one has zero. None if no axis has one.
    pub fn values(&self, path: ParameterPath) -> Option<Vec<f64>> {
        let elements = path.without_axis().elements();
        let found: Vec<Option<&Entry>> = elements
            .into_iter()
            .map(|element| self.entries.get(&element))
            .collect();
        found.iter().any(Option::is_some).then(|| {
            found
                .into_iter()
                .map(|entry| entry.map_or(0.0, Entry::simulated))
                .collect()
        })
    }

    /// As [`Model::values`], of a key with x, y, z.
    pub fn triad(&self, path: &str) -> Option<[f64; 3]> {
        self.values(path.parse().ok()?)?.try_into().ok()
    }

    /// The largest value of the axes of a path (of its axis, if it names one), by size; none where only limits are known.
    pub fn largest(&self, path: ParameterPath) -> Option<f64> {
        path.elements()
            .into_iter()
            .filter_map(|element| self.entries.get(&element)?.value)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Every number in the model, in the order of the contract.
    pub fn parameters(&self) -> impl Iterator<Item = (ParameterPath, &Entry)> {
        self.entries.iter().map(|(path, entry)| (*path, entry))
    }

    /// How many entries a list (`gauss_markov`, `sinusoids`, `resonances`) or a temperature polynomial has.
    pub fn count(&self, path: ParameterPath) -> usize {
        let same = |other: &&ParameterPath| {
            other.sensor() == path.sensor() && other.leaf_index() == path.leaf_index()
        };
        self.entries
            .keys()
            .filter(same)
            .map(|path| path.number())
            .max()
            .unwrap_or(0)
    }

    /// The calibrations that went into it.
    pub fn calibrations(&self) -> &[Calibration] {
        &self.calibrations
    }

    /// What the catalogue says about it.
    pub fn catalog(&self) -> Option<&CatalogTable> {
        self.catalog.as_ref()
    }

    /// An error about a number that a task needs.
    pub fn missing(&self, what: &str, advice: Option<String>) -> Error {
        Error::Missing {
            what: what.to_string(),
            model: self.label.clone(),
            advice,
        }
    }
}
