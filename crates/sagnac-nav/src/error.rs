//! What can be wrong with a navigation request: one sentence, where, and what to do.

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
            Self::OutOfRange { .. } => None,
        }
    }
}
