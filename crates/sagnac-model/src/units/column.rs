//! Column headers of the form `name [unit]`.

use super::error::Error;
use super::expression::Unit;

/// A column header taken apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name, without surrounding spaces.
    pub name: String,
    /// The unit in the brackets, if there are brackets.
    pub unit: Option<Unit>,
}

/// Reads `gyro_x [rad/s]`; the unit may carry a factor, `[0.05 deg/s]`.
///
/// ```
/// use sagnac_model::units::{Dimension, parse_column};
/// let column = parse_column("gyro_x [deg/s]")?;
/// assert_eq!(column.name, "gyro_x");
/// assert!(column.unit.is_some_and(|unit| unit.measures(Dimension::ANGULAR_RATE)));
/// assert_eq!(parse_column("time")?.unit, None);
/// # Ok::<(), sagnac_model::units::Error>(())
/// ```
///
/// # Errors
/// A unit that cannot be read.
pub fn parse_column(header: &str) -> Result<Column, Error> {
    let trimmed = header.trim();
    if let Some((name, unit)) = trimmed
        .strip_suffix(']')
        .and_then(|body| body.rsplit_once('['))
    {
        let unit = Unit::parse_scaled(unit).map_err(|error| error.with_text(trimmed))?;
        return Ok(Column {
            name: name.trim().to_string(),
            unit: Some(unit),
        });
    }
    Ok(Column {
        name: trimmed.to_string(),
        unit: None,
    })
}
