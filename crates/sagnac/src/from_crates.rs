//! The errors of the crates below as the one error of the façade.

use crate::Error;

/// Puts the three lines of a crate's error together.
fn gather(mut error: Error, place: Option<String>, advice: Option<String>) -> Error {
    error.place = place;
    error.advice = advice;
    error
}

impl From<sagnac_log::Error> for Error {
    fn from(error: sagnac_log::Error) -> Self {
        let what = error.to_string();
        let out = if error.is_usage() {
            Self::usage(what)
        } else {
            Self::data(what)
        };
        gather(out, error.place(), error.advice())
    }
}

impl From<sagnac_model::Error> for Error {
    fn from(error: sagnac_model::Error) -> Self {
        let what = error.to_string();
        let out = if error.is_usage() {
            Self::usage(what)
        } else {
            Self::data(what)
        };
        gather(out, error.place(), error.advice())
    }
}

impl From<sagnac_nav::Error> for Error {
    fn from(error: sagnac_nav::Error) -> Self {
        use sagnac_nav::Error as Nav;
        let what = error.to_string();
        let out = match &error {
            Nav::BadPath { .. } | Nav::Alignment { .. } => Self::data(what),
            _ => Self::usage(what),
        };
        gather(out, error.place(), error.advice())
    }
}

impl From<sagnac_analysis::Error> for Error {
    fn from(error: sagnac_analysis::Error) -> Self {
        // Samples that are no numbers were left out before: a sum is beyond the largest number.
        if matches!(error, sagnac_analysis::Error::NotFinite { .. }) {
            return Self::data("its values are too large to be summed")
                .advise("look at the unit, and at the largest values with sagnac info");
        }
        let what = error.to_string();
        let out = match &error {
            sagnac_analysis::Error::WindowTooLong { .. } => Self::usage(what),
            _ => Self::data(what),
        };
        gather(out, error.place(), error.advice())
    }
}

impl From<sagnac_noise::Error> for Error {
    fn from(error: sagnac_noise::Error) -> Self {
        Self::data(error.to_string())
    }
}
impl From<sagnac_model::emit::EmitError> for Error {
    fn from(error: sagnac_model::emit::EmitError) -> Self {
        gather(Self::data(error.to_string()), error.place(), error.advice())
    }
}
