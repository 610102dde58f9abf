//! What can be wrong with a model: one sentence, the place, and what to do.

use crate::units;

/// An error of this crate. `Display` is one sentence; [`Error::place`] says where, [`Error::advice`] what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A value or a key of a model file that cannot be taken.
    #[error("{what}")]
    File {
        /// One sentence.
        what: String,
        /// The file, the line, and the key or table.
        place: String,
        /// What to do.
        advice: Option<String>,
    },
    /// A quantity given outside a file.
    #[error(transparent)]
    Quantity(#[from] units::Error),
    /// No such parameter.
    #[error("there is no parameter `{path}`")]
    UnknownPath {
        /// As given.
        path: String,
        /// One that is spelled nearly so.
        suggestion: Option<String>,
    },
    /// A number that the parameter cannot take.
    #[error("`{path}` {problem}")]
    BadValue {
        /// The parameter.
        path: String,
        /// What is wrong, as the end of a sentence.
        problem: String,
    },
    /// A number that the task needs and the model lacks.
    #[error("the model has no {what}")]
    Missing {
        /// The term in words.
        what: String,
        /// The model.
        model: String,
        /// What to add.
        advice: Option<String>,
    },
    /// No sensor of this name.
    #[error("there is no sensor `{name}` in the catalogue")]
    UnknownSensor {
        /// As given.
        name: String,
        /// Names that are spelled nearly so.
        suggestion: Option<String>,
    },
    /// A request that cannot be understood.
    #[error("{what}")]
    Usage {
        /// One sentence.
        what: String,
        /// What to do.
        advice: Option<String>,
    },
}

impl Error {
    /// Where it is wrong: file, line and key.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::File { place, .. } => Some(place.clone()),
            Self::Missing { model, .. } => Some(model.clone()),
            _ => None,
        }
    }

    /// What to do about it, with an example.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::File { advice, .. }
            | Self::Missing { advice, .. }
            | Self::Usage { advice, .. } => advice.clone(),
            Self::Quantity(error) => error.advice(),
            Self::UnknownPath {
                suggestion: Some(name),
                ..
            } => Some(format!("did you mean `{name}`?")),
            Self::UnknownSensor {
                suggestion: Some(name),
                ..
            } => Some(format!("did you mean catalog:{name}?")),
            Self::UnknownSensor { .. } => Some("list them with: sagnac catalog list".to_string()),
            Self::UnknownPath { .. } => {
                Some("write for instance gyro.noise.angle_random_walk".to_string())
            }
            Self::BadValue { .. } => None,
        }
    }

    /// Whether the request, not a file, is wrong.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Quantity(_)
                | Self::UnknownPath { .. }
                | Self::UnknownSensor { .. }
                | Self::Usage { .. }
        )
    }
}
