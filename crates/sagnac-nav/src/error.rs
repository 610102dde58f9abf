//! What can be wrong with a navigation request: one sentence, where, and what to do.

use crate::trajectory::in_few_digits;

/// Why a trajectory, an alignment or a drift question was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The name is none of the built-in trajectories.
    #[error("unknown trajectory `{name}`")]
    UnknownTrajectory {
        /// What was asked for.
        name: String,
    },
    /// Roll or pitch were given for a trajectory that sets its own attitude.
    #[error("`{name}` sets its own attitude: --roll and --pitch belong to `rest` alone")]
    AttitudeNotFree {
        /// The trajectory.
        name: String,
    },
    /// A number is outside what the quantity allows.
    #[error("{quantity} is {value}, expected {expected}")]
    OutOfRange {
        /// The quantity's name.
        quantity: &'static str,
        /// Its value, with unit.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A run ends before its first sample does.
    #[error("a run of {} is shorter than one sample, {}", in_few_digits(*duration_s, "s"), in_few_digits(*dt_s, "s"))]
    TooShort {
        /// Length asked for, s.
        duration_s: f64,
        /// Sampling interval, s.
        dt_s: f64,
    },
    /// A path has too few points, or columns of different lengths.
    #[error("{what}")]
    BadPath {
        /// One sentence.
        what: String,
        /// The time in the path's own clock, s, if the fault has one.
        time_s: Option<f64>,
        /// What to do.
        advice: String,
    },
    /// Self-alignment cannot find a heading with this gyro at this place.
    #[error("{what}")]
    Alignment {
        /// One sentence with the numbers.
        what: String,
    },
    /// A question that has no answer as asked, for instance zero runs.
    #[error("{what}")]
    Request {
        /// One sentence.
        what: String,
        /// What to do.
        advice: String,
    },
}

impl Error {
    /// Where in the input the fault lies, if it has a place.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::BadPath {
                time_s: Some(t), ..
            } => Some(format!("time {t} s")),
            Self::OutOfRange { quantity, .. } => Some(option(quantity)),
            Self::TooShort { .. } => Some("--duration".to_owned()),
            _ => None,
        }
    }

    /// What the user can do about it.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::UnknownTrajectory { .. } => Some(format!("choose one of {}, or name a file", crate::trajectory::NAMES.join(", "))),
            Self::AttitudeNotFree { .. } => Some("leave them out, or use --trajectory rest".to_owned()),
            Self::BadPath { advice, .. } | Self::Request { advice, .. } => (!advice.is_empty()).then(|| advice.clone()),
            Self::Alignment { .. } => Some("give a heading, for instance --alignment 'roll=0.1deg, pitch=0.1deg, heading=1deg'".to_owned()),
            Self::TooShort { .. } => Some("lengthen --duration, or raise --rate".to_owned()),
            Self::OutOfRange { quantity, .. } => Some(format!("write for instance {} {}", option(quantity), example(quantity))),
        }
    }
}

/// The option that sets a quantity.
fn option(quantity: &str) -> String {
    match quantity {
        "sampling interval" => "--rate".to_owned(),
        other => format!("--{other}"),
    }
}

/// A value that such a quantity often has.
fn example(quantity: &str) -> &'static str {
    match quantity {
        "duration" => "1h",
        "sampling interval" => "100Hz",
        "height" => "500m",
        "latitude" => "45deg",
        _ => "30deg",
    }
}
