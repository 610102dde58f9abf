//! Quantities to text: the shortest decimal that reads back to the same `f64` in SI.

use super::dimension::Dimension;
use super::double_double::DoubleDouble;
use super::expression::Unit;
use super::number::scaled_value;

/// A quantity in a unit, `0.34 deg/sqrt(h)`: its number is the shortest that reads back to the same `f64` in SI.
///
/// A value of a unit `degC` is taken as an absolute temperature, in degrees Celsius. A value that is not finite, which no
/// text can hold, is written as `nan` or `inf` and is refused when it is read.
pub fn format_quantity(value_si: f64, unit: &Unit) -> String {
    let number = number_in(value_si, unit);
    match unit.text() {
        "" => number,
        // A factor in the unit (`0.05 deg/s`) or a leading `1/` would run into the number.
        text if text.starts_with(|c: char| c.is_ascii_digit() || c == '.') => {
            format!("{number} {}", safe_unit(unit))
        }
        text => format!("{number} {text}"),
    }
}

fn safe_unit(unit: &Unit) -> String {
    // `1/g` after a number is read as it should; anything else falls back to SI with a factor of one.
    if super::expression::is_leading_one(unit.text()) {
        unit.text().to_string()
    } else {
        unit.exponents().si_unit()
    }
}

/// The shortest decimal that reads back to `value_si` in this unit.
fn number_in(value_si: f64, unit: &Unit) -> String {
    let factor = unit.exact_factor();
    if factor.is_one() || value_si == 0.0 || !value_si.is_finite() {
        return format_number(value_si);
    }
    let size = value_si.abs();
    let quotient = DoubleDouble::new(size, 0.0).div(factor);
    let rough = quotient.round();
    if (1e-250..1e250).contains(&rough) {
        let magnitude = rough.log10().floor() as i32;
        for digits in 1..=17 {
            // digits − 1 places after the first: the integer 10^(digits−1−magnitude) · quotient.
            let power = digits - 1 - magnitude;
            let integer = quotient
                .mul(DoubleDouble::power_of_ten(power))
                .round_to_u64();
            let text = decimal_text(integer, -power);
            if scaled_value(&text, factor, None).to_bits() == size.to_bits() {
                return if value_si < 0.0 {
                    format!("-{text}")
                } else {
                    text
                };
            }
        }
    }
    // Beyond the range of exact scaling: the nearest decimals of 17 digits, then whatever f64 gives.
    format_number(value_si / factor.round())
}

/// integer · 10^power as a decimal.
fn decimal_text(integer: u64, power: i32) -> String {
    let digits = integer.to_string();
    let trimmed = digits.trim_end_matches('0');
    let digits_left = if trimmed.is_empty() { "0" } else { trimmed };
    let power = power + (digits.len() - digits_left.len()) as i32;
    layout(digits_left, power)
}

/// The shortest decimal of an `f64`: plain between 1e-5 and 1e15, else with an exponent.
pub fn format_number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || (1e-5..1e15).contains(&size) {
        return value.to_string().to_lowercase();
    }
    format!("{value:e}")
}

fn layout(digits: &str, power: i32) -> String {
    let count = digits.len() as i32;
    let magnitude = count - 1 + power;
    if !(-5..15).contains(&magnitude) {
        let (first, rest) = digits.split_at(1);
        return if rest.is_empty() {
            format!("{first}e{magnitude}")
        } else {
            format!("{first}.{rest}e{magnitude}")
        };
    }
    if power >= 0 {
        return format!("{digits}{}", "0".repeat(power as usize));
    }
    let point = count + power;
    if point > 0 {
        let (whole, fraction) = digits.split_at(point as usize);
        format!("{whole}.{fraction}")
    } else {
        format!("0.{}{digits}", "0".repeat((-point) as usize))
    }
}

impl Dimension {
    /// A value of this quantity in the unit in which the field writes it: `0.34 deg/sqrt(h)`.
    ///
    /// ```
    /// use sagnac_model::units::Dimension;
    /// assert_eq!(Dimension::RATIO.format(3e-4), "300 ppm");
    /// assert_eq!(Dimension::TEMPERATURE.format(25.0), "25 degC");
    /// ```
    pub fn format(self, value_si: f64) -> String {
        format_quantity(value_si, &Unit::field(self))
    }

    /// A value in a unit that was read: in `degC` where the unit is another of an absolute temperature.
    pub fn format_in(self, value_si: f64, unit: &Unit) -> String {
        if self.is_absolute_temperature() && !unit.is_celsius() {
            return self.format(value_si);
        }
        format_quantity(value_si, unit)
    }
}
