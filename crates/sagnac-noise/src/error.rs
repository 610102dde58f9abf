//! What a set of noise parameters can be refused for.

use core::fmt;

/// A parameter outside its range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A parameter must be positive and finite.
    NotPositive {
        /// The parameter's name, with its term.
        name: &'static str,
        /// What was given, SI.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A parameter must be finite.
    NotFinite {
        /// The parameter's name.
        name: &'static str,
    },
    /// A damping ratio must lie between 0 and 1.
    Damping {
        /// What was given.
        value: f64,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPositive { name, value, unit } => {
                write!(f, "the {name} must be positive, got {value} {unit}")
            }
            Self::NotFinite { name } => write!(f, "the {name} must be a finite number"),
            Self::Damping { value } => {
                write!(
                    f,
                    "the damping of a resonance must lie between 0 and 1, got {value}"
                )
            }
        }
    }
}

impl core::error::Error for Error {}
