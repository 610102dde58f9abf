//! Options that carry a number with its unit.

use sagnac::Error;
use sagnac::model::units::{Dimension, parse_quantity};

/// The SI value of an option, or a usage error that names the option.
pub(crate) fn quantity(option: &str, text: &str, dimension: Dimension) -> Result<f64, Error> {
    parse_quantity(text, dimension).map_err(|error| {
        let out = Error::usage(error.to_string()).at(format!("{option} {text}"));
        match error.advice() {
            Some(advice) => out.advise(advice),
            None => out,
        }
    })
}

/// The same for an option that may be absent.
pub(crate) fn optional(
    option: &str,
    text: Option<&str>,
    dimension: Dimension,
) -> Result<Option<f64>, Error> {
    text.map(|text| quantity(option, text, dimension))
        .transpose()
}

/// A positive quantity.
pub(crate) fn positive(option: &str, text: &str, dimension: Dimension) -> Result<f64, Error> {
    let value = quantity(option, text, dimension)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err(Error::usage(format!("{option} must be positive"))
            .at(format!("{option} {text}"))
            .advise(format!(
                "write for instance {option} {}",
                dimension.example().replace(' ', "")
            )))
    }
}
