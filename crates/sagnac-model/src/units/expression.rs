//! Units as text: products, quotients, powers and roots of the units of the table.
//!
//! `unit = ["1" "/"] factor {("*" | "·" | "/") factor}`, `factor = primary [power]`,
//! `primary = symbol | "(" unit ")" | "sqrt(" unit ")" | "√" primary`, `power = "^" number | "^(" number ["/" number] ")" | superscripts`.
//! Products and quotients are taken from the left: `a/b/c` is `(a/b)/c`.

use super::dimension::{Dimension, EXPONENT_PARTS, Exponents};
use super::double_double::DoubleDouble;
use super::error::{Error, clip};
use super::number::number_length;
use super::table;
use crate::suggest::suggest;
use std::fmt;

/// No unit is longer; the limits keep hostile input from costing time or stack.
const LONGEST_UNIT: usize = 200;
const DEEPEST_NESTING: usize = 24;
const LARGEST_EXPONENT: i32 = 24 * EXPONENT_PARTS;

/// A unit as it was written, with what it measures and its factor to SI.
///
/// ```
/// use sagnac_model::units::{Dimension, Unit};
/// let unit = Unit::parse("deg/h/√h")?;
/// assert_eq!(unit.factor(), 8.080228018492267e-8); // π/180/3600/60
/// assert!(unit.measures(Dimension::RATE_RANDOM_WALK));
/// assert_eq!(Unit::parse_scaled("125 ug*s")?.factor(), 125.0 * 9.80665e-6);
/// # Ok::<(), sagnac_model::units::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    text: String,
    exponents: Exponents,
    factor: DoubleDouble,
    celsius: bool,
}

impl Unit {
    /// Reads a unit: `deg/sqrt(h)`. An empty text is the unit of a plain number.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let trimmed = text.trim();
        if trimmed.is_empty() {
            return Ok(Self::plain());
        }
        let value = parse_value(trimmed, false)?;
        Ok(Self {
            text: trimmed.to_string(),
            exponents: value.exponents,
            factor: value.factor,
            celsius: value.celsius,
        })
    }

    /// Reads a unit that may carry a factor, as in a column of counts: `0.05 deg/s`, `125 ug*s`, `deg/s`.
    pub fn parse_scaled(text: &str) -> Result<Self, Error> {
        let trimmed = text.trim();
        // `1/s` is a unit without a factor.
        let Some(length) = number_length(trimmed).filter(|_| !is_leading_one(trimmed)) else {
            return Self::parse(trimmed);
        };
        let (number, rest) = trimmed.split_at(length);
        let mut unit = Self::parse_after_number(rest).map_err(|error| error.with_text(trimmed))?;
        let scale = super::number::scaled_value(number, DoubleDouble::ONE, None);
        let product = super::number::scaled_value(number, unit.factor, None);
        if !(product.is_finite() && product != 0.0 && scale > 0.0) {
            return Err(Error::BadUnit {
                problem: "its factor is not a positive number",
                text: clip(trimmed),
                example: None,
            });
        }
        unit.factor = DoubleDouble::new(product, 0.0);
        unit.text = trimmed.to_string();
        Ok(unit)
    }

    /// The rest of a quantity after its number, which may also be `/s`.
    pub(crate) fn parse_after_number(rest: &str) -> Result<Self, Error> {
        let trimmed = rest.trim();
        if trimmed.is_empty() {
            return Ok(Self::plain());
        }
        let value = parse_value(trimmed, true)?;
        Ok(Self {
            text: trimmed.to_string(),
            exponents: value.exponents,
            factor: value.factor,
            celsius: value.celsius,
        })
    }

    /// The unit of a plain number.
    pub fn plain() -> Self {
        Self {
            text: String::new(),
            exponents: Exponents::NONE,
            factor: DoubleDouble::ONE,
            celsius: false,
        }
    }

    /// The unit in which the field writes a quantity.
    pub fn field(dimension: Dimension) -> Self {
        // Every field unit is read by a test; the SI unit is always right as well.
        Self::parse(&dimension.field_unit()).unwrap_or_else(|_| Self::si(dimension))
    }

    /// The SI unit of a quantity.
    pub fn si(dimension: Dimension) -> Self {
        let plain = dimension.is_plain();
        Self {
            text: if plain {
                String::new()
            } else {
                dimension.si_unit()
            },
            exponents: dimension.exponents(),
            factor: DoubleDouble::ONE,
            celsius: dimension.is_absolute_temperature(),
        }
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Value of one such unit in SI.
    pub fn factor(&self) -> f64 {
        self.factor.round()
    }

    pub(crate) fn exact_factor(&self) -> DoubleDouble {
        self.factor
    }

    /// Exponents of the base units.
    pub fn exponents(&self) -> Exponents {
        self.exponents
    }

    /// Whether it is `degC` (`°C`) standing alone: of an absolute temperature.
    pub fn is_celsius(&self) -> bool {
        self.celsius
    }

    /// Whether it measures this quantity.
    pub fn measures(&self, dimension: Dimension) -> bool {
        self.exponents == dimension.exponents()
    }

    /// What it measures, in words: `an angular rate`.
    pub fn words(&self) -> std::borrow::Cow<'static, str> {
        Dimension::words_of(self.exponents)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Whether a text begins with the `1` of a leading `1/`.
pub(crate) fn is_leading_one(text: &str) -> bool {
    text.strip_prefix('1')
        .is_some_and(|rest| rest.trim_start().starts_with('/'))
}

#[derive(Debug, Clone, Copy)]
struct Value {
    exponents: Exponents,
    factor: DoubleDouble,
    celsius: bool,
}

impl Value {
    const ONE: Self = Self {
        exponents: Exponents::NONE,
        factor: DoubleDouble::ONE,
        celsius: false,
    };
}

fn parse_value(text: &str, may_start_with_slash: bool) -> Result<Value, Error> {
    if text.len() > LONGEST_UNIT {
        return Err(Error::BadUnit {
            problem: "it is too long",
            text: clip(text),
            example: None,
        });
    }
    let mut parser = Parser { text, at: 0 };
    let value = parser.unit(0, may_start_with_slash)?;
    if parser.peek().is_some() {
        let problem = if parser.rest().starts_with(')') {
            "a parenthesis is closed that was not opened"
        } else {
            "a `*` or `/` is missing between two units"
        };
        return Err(parser.bad(problem));
    }
    Ok(value)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn bad(&self, problem: &'static str) -> Error {
        Error::BadUnit {
            problem,
            text: clip(self.text),
            example: None,
        }
    }

    /// The next character after spaces, which are skipped.
    fn peek(&mut self) -> Option<char> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start().len();
        self.rest().chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn unit(&mut self, depth: usize, may_start_with_slash: bool) -> Result<Value, Error> {
        if depth > DEEPEST_NESTING {
            return Err(self.bad("it is nested too deeply"));
        }
        self.peek();
        let leading_one = is_leading_one(self.rest());
        if leading_one {
            self.at += 1;
        }
        let mut value = if leading_one || (may_start_with_slash && self.peek() == Some('/')) {
            Value::ONE
        } else {
            self.factor(depth)?
        };
        loop {
            let sign = match self.peek() {
                Some('*' | '·' | '⋅' | '×') => 1,
                Some('/') => -1,
                _ => return Ok(value),
            };
            self.at += self.rest().chars().next().map_or(0, char::len_utf8);
            let next = self.factor(depth)?;
            value = Value {
                exponents: value.exponents.plus(next.exponents, sign),
                factor: if sign > 0 {
                    value.factor.mul(next.factor)
                } else {
                    value.factor.div(next.factor)
                },
                celsius: false,
            };
            self.check(value)?;
        }
    }

    fn check(&self, value: Value) -> Result<(), Error> {
        let sound = value.factor.is_positive()
            && value
                .exponents
                .0
                .iter()
                .all(|parts| parts.abs() <= LARGEST_EXPONENT);
        if sound {
            Ok(())
        } else {
            Err(self.bad("its powers are out of range"))
        }
    }

    fn factor(&mut self, depth: usize) -> Result<Value, Error> {
        let base = self.primary(depth)?;
        match self.power()? {
            Some(power) => self.raised(base, power),
            None => Ok(base),
        }
    }

    fn primary(&mut self, depth: usize) -> Result<Value, Error> {
        match self.peek() {
            None => Err(self.bad("it ends where a unit is expected")),
            Some('(') => self.group(depth),
            Some('√') => {
                self.at += '√'.len_utf8();
                if depth > DEEPEST_NESTING {
                    return Err(self.bad("it is nested too deeply"));
                }
                let base = self.primary(depth + 1)?;
                self.raised(base, 0.5)
            }
            Some(_) => {
                let symbol = self.symbol();
                if symbol.is_empty() {
                    return Err(self.bad("a unit is expected"));
                }
                if symbol == "sqrt" {
                    if self.peek() != Some('(') {
                        return Err(self.bad("`sqrt` needs a parenthesis"));
                    }
                    let base = self.group(depth)?;
                    return self.raised(base, 0.5);
                }
                let Some(row) = table::find(symbol) else {
                    let suggestion = suggest(symbol, table::UNITS.iter().map(|row| row.symbol));
                    return Err(Error::UnknownUnit {
                        symbol: clip(symbol),
                        text: clip(self.text),
                        suggestion: suggestion.filter(|_| symbol.chars().count() > 2),
                        example: None,
                    });
                };
                Ok(Value {
                    exponents: row.exponents(),
                    factor: row.exact_factor(),
                    celsius: matches!(row.symbol, "degC" | "°C"),
                })
            }
        }
    }

    fn group(&mut self, depth: usize) -> Result<Value, Error> {
        self.at += 1;
        let value = self.unit(depth + 1, false)?;
        if self.take(')') {
            Ok(value)
        } else {
            Err(self.bad("a parenthesis is not closed"))
        }
    }

    fn symbol(&mut self) -> &'a str {
        let rest = self.rest();
        let stop = |c: char| {
            c.is_whitespace()
                || matches!(c, '*' | '·' | '⋅' | '×' | '/' | '^' | '(' | ')' | '√')
                || superscript(c).is_some()
        };
        let length = rest.find(stop).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn power(&mut self) -> Result<Option<f64>, Error> {
        if self.take('^') {
            let power = if self.take('(') {
                let mut power = self.number()?;
                if self.take('/') {
                    power /= self.number()?;
                }
                if !self.take(')') {
                    return Err(self.bad("a parenthesis is not closed"));
                }
                power
            } else {
                self.number()?
            };
            return Ok(Some(power));
        }
        let rest = self.rest();
        let digits: String = rest.chars().map_while(superscript).collect();
        if digits.is_empty() {
            return Ok(None);
        }
        self.at += rest
            .find(|c| superscript(c).is_none())
            .unwrap_or(rest.len());
        digits
            .parse()
            .map(Some)
            .map_err(|_| self.bad("a power cannot be read"))
    }

    fn number(&mut self) -> Result<f64, Error> {
        self.peek();
        let rest = self.rest();
        let length = number_length(rest).ok_or_else(|| self.bad("a power is no number"))?;
        self.at += length;
        rest[..length]
            .parse()
            .map_err(|_| self.bad("a power is no number"))
    }

    fn raised(&self, base: Value, power: f64) -> Result<Value, Error> {
        let out_of_range = || self.bad("its powers are out of range");
        if power.is_nan() || power.abs() > 24.0 {
            return Err(out_of_range());
        }
        let mut exponents = [0; 4];
        for (raised, parts) in exponents.iter_mut().zip(base.exponents.0) {
            let wanted = f64::from(parts) * power;
            if (wanted - wanted.round()).abs() > 1e-6 {
                return Err(out_of_range());
            }
            *raised = wanted.round() as i32;
        }
        let factor = if power == power.round() {
            base.factor.powi(power as i32)
        } else if 2.0 * power == (2.0 * power).round() {
            base.factor.sqrt().powi((2.0 * power) as i32)
        } else {
            DoubleDouble::new(base.factor.round().powf(power), 0.0)
        };
        let value = Value {
            exponents: Exponents(exponents),
            factor,
            celsius: false,
        };
        self.check(value)?;
        Ok(value)
    }
}

fn superscript(c: char) -> Option<char> {
    Some(match c {
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        '⁶' => '6',
        '⁷' => '7',
        '⁸' => '8',
        '⁹' => '9',
        '⁻' => '-',
        '⁺' => '+',
        _ => return None,
    })
}
