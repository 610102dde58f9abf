//! Quantities as text to `f64` in SI, with the refusals that name the expected dimension and show an example.

use super::dimension::Dimension;
use super::double_double::DoubleDouble;
use super::error::{Error, clip};
use super::expression::Unit;
use super::number::{number_length, scaled_value};

/// −273.15 to 31 digits: 0 K in degrees Celsius.
const ABSOLUTE_ZERO_C: DoubleDouble = DoubleDouble::new(-273.15, -2.273_736_754_432_320_6e-14);

/// A quantity in SI from its text: `0.3 deg/sqrt(h)` as an angle random walk is 8.7266e-5 (rad/√s).
///
/// Absolute temperatures come in degrees Celsius. A bare number is accepted of a quantity without dimension only.
///
/// # Errors
/// A text that is no finite number with a known unit of this dimension; [`Error::advice`] shows an example.
pub fn parse_quantity(text: &str, dimension: Dimension) -> Result<f64, Error> {
    parse_with_unit(text, dimension).map(|(value, _)| value)
}

/// As [`parse_quantity`], with the unit in which it was written.
pub fn parse_with_unit(text: &str, dimension: Dimension) -> Result<(f64, Unit), Error> {
    let trimmed = text.trim();
    let length = number_length(trimmed).ok_or_else(|| no_number(trimmed, dimension))?;
    let (number, rest) = trimmed.split_at(length);
    let unit = Unit::parse_after_number(rest)
        .map_err(|error| error.with_text(trimmed).with_example(dimension.example()))?;
    check_dimension(&unit, trimmed, dimension)?;
    let value = value_in(number, &unit, dimension);
    if value.is_finite() {
        Ok((value, unit))
    } else {
        Err(too_large(trimmed, dimension))
    }
}

/// The factor from a unit to SI, which must measure the given quantity. The unit may carry a factor: `0.05 deg/s`.
///
/// # Errors
/// An unknown unit or one of another dimension.
pub fn unit_factor(text: &str, dimension: Dimension) -> Result<f64, Error> {
    let unit =
        Unit::parse_scaled(text).map_err(|error| error.with_example(dimension.field_unit()))?;
    check_dimension(&unit, text.trim(), dimension)?;
    Ok(unit.factor())
}

/// A plain number: no unit, finite.
pub fn parse_plain(text: &str) -> Result<f64, Error> {
    let trimmed = text.trim();
    if number_length(trimmed) != Some(trimmed.len()) {
        return Err(no_number(trimmed, Dimension::RATIO));
    }
    let value = scaled_value(trimmed, DoubleDouble::ONE, None);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(too_large(trimmed, Dimension::RATIO))
    }
}

/// Three numbers and one unit, as in `--at 'f=0 0 -9.81 m/s^2'`; commas may part them.
pub fn parse_triple(text: &str, dimension: Dimension) -> Result<[f64; 3], Error> {
    let values = parse_numbers(text, dimension)?;
    <[f64; 3]>::try_from(values.as_slice()).map_err(|_| Error::Count {
        text: clip(text.trim()),
        expected: 3,
        got: values.len(),
    })
}

/// One or more numbers and one unit after the last: `0 0 -9.81 m/s^2`.
pub fn parse_numbers(text: &str, dimension: Dimension) -> Result<Vec<f64>, Error> {
    let trimmed = text.trim();
    let mut rest = trimmed;
    let mut numbers = Vec::new();
    while let Some(length) = number_length(rest) {
        let (number, after) = rest.split_at(length);
        numbers.push(number);
        let next = after.trim_start();
        let next = next.strip_prefix(',').map_or(next, str::trim_start);
        // A number ends at a space, a comma or the unit.
        rest = next;
        if next.len() == after.len() {
            break;
        }
    }
    if numbers.is_empty() {
        return Err(no_number(trimmed, dimension));
    }
    let unit = Unit::parse_after_number(rest)
        .map_err(|error| error.with_text(trimmed).with_example(dimension.example()))?;
    check_dimension(&unit, trimmed, dimension)?;
    let values: Vec<f64> = numbers
        .into_iter()
        .map(|number| value_in(number, &unit, dimension))
        .collect();
    if values.iter().all(|value| value.is_finite()) {
        Ok(values)
    } else {
        Err(too_large(trimmed, dimension))
    }
}

/// The value of a decimal in a unit.
pub(crate) fn value_in(number: &str, unit: &Unit, dimension: Dimension) -> f64 {
    let kelvin = dimension.is_absolute_temperature() && !unit.is_celsius();
    scaled_value(
        number,
        unit.exact_factor(),
        kelvin.then_some(ABSOLUTE_ZERO_C),
    )
}

fn check_dimension(unit: &Unit, text: &str, dimension: Dimension) -> Result<(), Error> {
    if unit.measures(dimension) {
        return Ok(());
    }
    let (text, expected, example) = (clip(text), dimension.words(), dimension.example());
    if unit.text().is_empty() {
        return Err(Error::MissingUnit {
            text,
            expected,
            example,
        });
    }
    Err(Error::WrongDimension {
        text,
        expected,
        got: unit.words(),
        example,
    })
}

fn no_number(text: &str, dimension: Dimension) -> Error {
    let word = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
    if word.starts_with("inf") || word.starts_with("nan") {
        return not_finite(text, dimension);
    }
    Error::NotANumber {
        text: clip(text),
        expected: dimension.words(),
        example: dimension.example(),
    }
}

fn too_large(text: &str, dimension: Dimension) -> Error {
    Error::TooLarge {
        text: clip(text),
        expected: dimension.words(),
        example: dimension.example(),
    }
}

fn not_finite(text: &str, dimension: Dimension) -> Error {
    Error::NotFinite {
        text: clip(text),
        expected: dimension.words(),
        example: dimension.example(),
    }
}
