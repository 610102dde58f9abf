//! What can be wrong with data handed to the analysis.

/// An error of this crate: one sentence, where it is known, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No averaging time of the grid can be estimated from so few samples.
    #[error("{kind} needs at least {needed} samples in a row, the longest stretch has {found}")]
    TooShort {
        /// Name of the statistic.
        kind: &'static str,
        /// Least number of samples.
        needed: usize,
        /// Samples of the longest segment.
        found: usize,
    },
    /// A step, window or time that must be positive and finite is not.
    #[error("{name} must be a positive time, got {value_s} s")]
    NotPositive {
        /// What was given.
        name: &'static str,
        /// Its value in seconds.
        value_s: f64,
    },
    /// A sample is NaN or infinite.
    #[error("sample {index} of segment {segment} is not a finite number")]
    NotFinite {
        /// Segment, from 0.
        segment: usize,
        /// Sample within the segment, from 0.
        index: usize,
    },
    /// The statistic has no streaming form.
    #[error("{kind} has no streaming estimate")]
    NotStreaming {
        /// Name of the statistic.
        kind: &'static str,
    },
    /// A window of the dynamic deviation does not fit.
    #[error("a window of {window_s} s does not fit a stretch of {duration_s} s")]
    WindowTooLong {
        /// Length asked for.
        window_s: f64,
        /// Length of the log.
        duration_s: f64,
    },
}

impl Error {
    /// Where the error stands, where that is known.
    pub fn place(&self) -> Option<String> {
        None
    }

    /// What to do about it.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::TooShort { .. } => Some("record longer, or join the parts of the log".to_owned()),
            Self::NotPositive { .. } => {
                Some("write a time above zero, for instance 10 s".to_owned())
            }
            Self::NotFinite { .. } => {
                Some("cut the log into segments at samples that are lost".to_owned())
            }
            Self::NotStreaming { .. } => {
                Some("use the exact estimate (--estimate exact), or oadev, adev or hdev".to_owned())
            }
            Self::WindowTooLong { duration_s, .. } => {
                Some(format!("choose a window of {duration_s} s or shorter"))
            }
        }
    }
}
