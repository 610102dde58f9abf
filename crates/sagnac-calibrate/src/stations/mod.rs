//! One weighted regression for every test with known inputs: faces, tumbles, rate tables, centrifuges, chambers.
//!
//! output − u' = Σ parameter × column, axis by axis, every term of the measurement model that the table
//! determines. Terms of `[IEEE1293]`, `[IEEE1554]`.
//!
//! ```
//! use sagnac_calibrate::stations::{Options, Station, calibrate};
//! let g = 9.80665;
//! let rows: Vec<Station> = (0..6).map(|i| {
//!     let mut f = [0.0; 3];
//!     f[i / 2] = if i % 2 == 0 { g } else { -g };
//!     let accel = [1.001 * f[0] + 0.02, f[1], f[2]];
//!     Station { accel: Some(accel), accel_se: Some([1e-3; 3]), f, ..Station::new(&format!("{}", i + 1)) }
//! }).collect();
//! let found = calibrate(&rows, &Options::default())?;
//! assert!((found.parameter("accel.scale_factor.x").unwrap().value - 1e-3).abs() < 1e-9);
//! // One face alone gives no scale factor, and says so.
//! assert!(calibrate(&rows[..1], &Options::default()).is_err());
//! # Ok::<(), sagnac_calibrate::stations::Error>(())
//! ```

pub(crate) mod add;
mod check;
pub(crate) mod determine;
mod fit;
mod magnitude;
mod outcome;
pub mod reference;
mod tell;
pub mod terms;

pub use add::{Addition, Bundle};
pub(crate) use add::{Belief, bundles};
pub use determine::Status;
pub use outcome::{Available, AxisFit, Held, Outcome, Parameter, ResidualRow, calibrate};
pub(crate) use outcome::{Decided, decide_all, sigmas};
pub use terms::{Group, Term};

use sagnac_core::Sensor;

/// A stretch of time with constant, known inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// What it is called.
    pub label: String,
    /// Where it stands: file and line.
    pub place: Option<String>,
    /// Mean outputs \[m/s²\].
    pub accel: Option<[f64; 3]>,
    /// Standard errors of the means \[m/s²\].
    pub accel_se: Option<[f64; 3]>,
    /// Mean outputs \[rad/s\].
    pub gyro: Option<[f64; 3]>,
    /// Standard errors of the means \[rad/s\].
    pub gyro_se: Option<[f64; 3]>,
    /// True specific force \[m/s²\].
    pub f: [f64; 3],
    /// Standard errors of its components \[m/s²\].
    pub f_sigma: [f64; 3],
    /// True inertial rate \[rad/s\].
    pub w: [f64; 3],
    /// Standard errors of its components \[rad/s\].
    pub w_sigma: [f64; 3],
    /// True angular acceleration \[rad/s²\].
    pub wdot: [f64; 3],
    /// Sensor temperature \[°C\].
    pub temperature_c: Option<f64>,
    /// Which switch-on.
    pub run: Option<String>,
}

impl Station {
    /// A station without inputs and outputs.
    pub fn new(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            place: None,
            accel: None,
            accel_se: None,
            gyro: None,
            gyro_se: None,
            f: [0.0; 3],
            f_sigma: [0.0; 3],
            w: [0.0; 3],
            w_sigma: [0.0; 3],
            wdot: [0.0; 3],
            temperature_c: None,
            run: None,
        }
    }

    /// The mean outputs of a sensor.
    pub fn output(&self, sensor: Sensor) -> Option<[f64; 3]> {
        match sensor {
            Sensor::Gyro => self.gyro,
            Sensor::Accel => self.accel,
        }
    }

    /// The standard errors of a sensor's means.
    pub fn output_se(&self, sensor: Sensor) -> Option<[f64; 3]> {
        match sensor {
            Sensor::Gyro => self.gyro_se,
            Sensor::Accel => self.accel_se,
        }
    }

    /// True input of a sensor at the IMU centre.
    pub fn input(&self, sensor: Sensor) -> [f64; 3] {
        match sensor {
            Sensor::Gyro => self.w,
            Sensor::Accel => self.f,
        }
    }

    pub(crate) fn input_sigma(&self, sensor: Sensor) -> [f64; 3] {
        match sensor {
            Sensor::Gyro => self.w_sigma,
            Sensor::Accel => self.f_sigma,
        }
    }
}

/// Which groups are asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Asked {
    /// All but nonlinearity and g²-sensitivity; temperature where it spans 5 K.
    #[default]
    Default,
    /// Every group.
    All,
    /// These keys of [`Group::KEYS`].
    Only(Vec<&'static str>),
    /// The default with changes.
    Changed {
        /// Added.
        with: Vec<&'static str>,
        /// Taken away.
        without: Vec<&'static str>,
    },
}

impl Asked {
    /// Reads `default`, `all`, a list of groups, or changes `+name`, `-name`.
    ///
    /// # Errors
    /// An unknown group, or a list that mixes names and changes.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let find = |name: &str| {
            Group::KEYS
                .into_iter()
                .find(|key| *key == name || format!("scale_factor.{name}") == *key)
                .or_else(|| {
                    let short = name.strip_prefix("scale_factor.")?;
                    Group::KEYS.into_iter().find(|key| *key == short)
                })
                .ok_or_else(|| Error::UnknownTerm {
                    name: name.to_owned(),
                })
        };
        let words: Vec<&str> = text
            .split(',')
            .map(str::trim)
            .filter(|w| !w.is_empty())
            .collect();
        let (mut with, mut without, mut only) = (Vec::new(), Vec::new(), Vec::new());
        for word in words {
            match word {
                "default" => {}
                "all" => with.extend(Group::KEYS),
                _ if word.starts_with('+') => with.push(find(&word[1..])?),
                _ if word.starts_with('-') => without.push(find(&word[1..])?),
                _ => only.push(find(word)?),
            }
        }
        match (only.is_empty(), with.is_empty() && without.is_empty()) {
            (true, true) => Ok(Self::Default),
            (true, false) => Ok(Self::Changed { with, without }),
            (false, true) => Ok(Self::Only(only)),
            (false, false) => {
                only.extend(with);
                only.retain(|key| !without.contains(key));
                Ok(Self::Only(only))
            }
        }
    }

    /// Whether a group is asked for; `warm` where the temperature spans at least 5 K.
    pub fn has(&self, group: Group, warm: bool) -> bool {
        let usual = match group {
            Group::Quadratic | Group::Asymmetry | Group::Cubic | Group::G2Sensitivity => false,
            Group::BiasTemperature(_) | Group::ScaleTemperature(_) => warm,
            _ => true,
        };
        match self {
            Self::Default => usual,
            Self::All => true,
            Self::Only(keys) => keys.contains(&group.key()),
            Self::Changed { with, without } => {
                (usual || with.contains(&group.key())) && !without.contains(&group.key())
            }
        }
    }
}

/// What is known besides the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Groups asked for.
    pub asked: Asked,
    /// Powers of T − T0 of the bias.
    pub temperature_order: u8,
    /// Powers of T − T0 of the scale factor.
    pub scale_temperature_order: u8,
    /// T0 \[°C\].
    pub reference_temperature_c: f64,
    /// Size of gravity \[m/s²\].
    pub gravity_m_s2: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            asked: Asked::Default,
            temperature_order: 1,
            scale_temperature_order: 1,
            reference_temperature_c: 25.0,
            gravity_m_s2: 9.80665,
        }
    }
}

/// Why a table cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// No row has outputs.
    #[error("the table has no outputs")]
    NoOutputs,
    /// A name that is no group.
    #[error("`{name}` is no group of terms")]
    UnknownTerm {
        /// What was written.
        name: String,
    },
    /// All rows have one input.
    #[error("{what}")]
    OneInput {
        /// In words.
        what: String,
    },
    /// As many parameters as rows and nothing said of the noise.
    #[error("{axis} has as many parameters as stations ({rows})")]
    NoFreedom {
        /// Which.
        axis: String,
        /// Rows.
        rows: usize,
    },
    /// A label that the output contradicts.
    #[error("{what}")]
    Contradiction {
        /// In words.
        what: String,
        /// Where.
        place: Option<String>,
    },
    /// Outputs in g that claim to be in m/s².
    #[error(
        "station {station}: the mean accelerometer output is {size:.3}, which looks like g, not m/s^2"
    )]
    LooksLikeG {
        /// Which.
        station: String,
        /// Size of the mean output.
        size: f64,
        /// Where.
        place: Option<String>,
    },
    /// A standard error that is not positive.
    #[error("station {station}: a standard error must be above zero")]
    BadError {
        /// Which.
        station: String,
        /// Where.
        place: Option<String>,
    },
    /// Nothing asked for is determined.
    #[error("no term that was asked for is determined by this table")]
    NothingDetermined,
}

impl Error {
    /// Where.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::Contradiction { place, .. }
            | Self::LooksLikeG { place, .. }
            | Self::BadError { place, .. } => place.clone(),
            Self::UnknownTerm { .. } => Some("--terms".to_owned()),
            _ => None,
        }
    }

    /// What to do.
    pub fn advice(&self) -> Option<String> {
        Some(match self {
            Self::NoOutputs => {
                "add columns accel_x, accel_y, accel_z [m/s^2] or gyro_x, gyro_y, gyro_z [rad/s]"
                    .to_owned()
            }
            Self::UnknownTerm { .. } => format!("the groups are {}", Group::KEYS.join(", ")),
            Self::OneInput { .. } => {
                "add stations with each axis up and down (sagnac calibrate plan six-position), or ask for --terms bias"
                    .to_owned()
            }
            Self::NoFreedom { .. } => {
                "add a station, or give standard errors (accel_x_se …)".to_owned()
            }
            Self::Contradiction { .. } => {
                "correct the label, or remount a mirrored axis with --axes".to_owned()
            }
            Self::LooksLikeG { .. } => {
                "write the unit of the column as g, for instance accel_x [g]".to_owned()
            }
            Self::BadError { .. } => {
                "give the standard error of each mean, or leave the columns out".to_owned()
            }
            Self::NothingDetermined => {
                "add stations (sagnac calibrate plan six-position), or ask for other --terms".to_owned()
            }
        })
    }
}
