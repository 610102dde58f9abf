//! `--where` and `--sort`: which sensors, in which order.
//!
//! `expr = and {"or" and}`, `and = not {"and" not}`, `not = ["not"] (comparison | "(" expr ")")`; a comparison is a parameter
//! path, `< <= > >= = !=` and a quantity, or a text field, `= != ~` and a text. A sensor without the number fails it.

use super::{key_of, price_class, quality, technology};
use crate::error::Error;
use crate::model::Model;
use crate::path::ParameterPath;
use crate::random::FLICKER_FLOOR;
use crate::suggest::suggest;
use crate::units::{Dimension, clip, parse_with_unit};
use sagnac_core::Sensor;
use std::cmp::Ordering;

const DEEPEST: usize = 50;
const TEXT_FIELDS: [&str; 5] = [
    "name",
    "manufacturer",
    "technology",
    "quality",
    "price_class",
];

/// A condition on sensors, parsed.
///
/// ```
/// use sagnac_model::{Catalogue, Filter};
/// let filter: Filter = "gyro.angle_random_walk < 0.1 deg/sqrt(h) and not technology ~ 'MEMS'".parse()?;
/// let kept = Catalogue::embedded().select(Some(&filter), None)?;
/// assert!(kept.iter().any(|model| model.name() == "HG9900"));
/// # Ok::<(), sagnac_model::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Filter(Expression);

/// What sensors are sorted by.
#[derive(Debug, Clone)]
pub struct SortKey(Subject);

#[derive(Debug, Clone)]
enum Expression {
    Any(Vec<Expression>),
    All(Vec<Expression>),
    Not(Box<Expression>),
    Number(Subject, Operator, f64, crate::units::Exponents),
    Text(usize, Operator, String),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operator {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
    Contains,
}

/// What a path of a condition stands for.
#[derive(Debug, Clone)]
enum Subject {
    Parameter(ParameterPath),
    /// The Allan floor of the bias instability, of one axis or of the worst.
    Instability(Sensor, Option<usize>),
    SampleRate,
    /// A text field, for sorting.
    Field(usize),
}

impl Subject {
    fn parse(text: &str) -> Result<Self, Error> {
        if text == "sample_rate" {
            return Ok(Self::SampleRate);
        }
        for sensor in Sensor::ALL {
            if let Some(rest) = text
                .strip_prefix(sensor.key())
                .and_then(|rest| rest.strip_prefix(".bias.instability"))
            {
                match rest {
                    "" => return Ok(Self::Instability(sensor, None)),
                    ".x" | ".y" | ".z" => {
                        return Ok(Self::Instability(
                            sensor,
                            ["x", "y", "z"].iter().position(|axis| rest.ends_with(axis)),
                        ));
                    }
                    _ => {}
                }
            }
        }
        let error = match text.parse::<ParameterPath>() {
            Ok(path) => return Ok(Self::Parameter(path)),
            Err(error) => error,
        };
        // `noise.` may be left out.
        if let Some((sensor, rest)) = text.split_once('.')
            && let Ok(path) = format!("{sensor}.noise.{rest}").parse::<ParameterPath>()
        {
            return Ok(Self::Parameter(path));
        }
        let advised = suggest(text, TEXT_FIELDS.into_iter().chain(["sample_rate"]));
        Err(match advised {
            Some(field) => Error::UnknownPath {
                path: clip(text),
                suggestion: Some(field.to_string()),
            },
            None => error,
        })
    }

    fn dimension(&self) -> Dimension {
        match self {
            Self::Parameter(path) => path.dimension(),
            Self::Instability(Sensor::Gyro, _) => Dimension::ANGULAR_RATE,
            Self::Instability(Sensor::Accel, _) => Dimension::ACCELERATION,
            Self::SampleRate => Dimension::FREQUENCY,
            Self::Field(_) => Dimension::RATIO,
        }
    }

    /// The value of a sensor, and the dimension that it has there.
    fn value(&self, model: &Model) -> Option<(f64, Dimension)> {
        let worst = |axis: Option<usize>, of: &dyn Fn(usize) -> Option<f64>| match axis {
            Some(axis) => of(axis),
            None => (0..3)
                .filter_map(of)
                .max_by(|a, b| a.abs().total_cmp(&b.abs())),
        };
        let value = match self {
            Self::SampleRate => model.sample_rate_hz(),
            Self::Instability(sensor, axis) => {
                worst(*axis, &|axis| model.instability_floor(*sensor, axis))
            }
            Self::Parameter(path)
                if path.file_keys().last() == Some(&Model::white_key(path.sensor())) =>
            {
                worst(path.axis(), &|axis| {
                    model.white_noise(path.sensor(), axis)?.value
                })
            }
            Self::Parameter(path) => match path.file_keys().as_slice() {
                // B and its floor are one number, however the sheet states it.
                [
                    "bias",
                    "instability",
                    key @ ("coefficient" | "allan_minimum"),
                ] => {
                    let factor = if *key == "coefficient" {
                        1.0
                    } else {
                        FLICKER_FLOOR
                    };
                    worst(path.axis(), &|axis| {
                        Some(factor * model.flicker(path.sensor(), axis)?.value?)
                    })
                }
                _ => model.largest(*path),
            },
            Self::Field(_) => None,
        };
        let dimension = match self {
            Self::Parameter(path) => model.dimension(*path),
            other => other.dimension(),
        };
        value.map(|value| (value, dimension))
    }
}

fn field(model: &Model, field: usize) -> Option<String> {
    match TEXT_FIELDS[field] {
        "name" => Some(model.name().to_string()),
        "manufacturer" => model.manufacturer().map(str::to_string),
        "technology" => technology(model).map(str::to_string),
        "quality" => quality(model),
        _ => price_class(model).map(|price| price.class.to_string()),
    }
}

impl Filter {
    /// Whether a sensor meets the condition.
    pub fn keeps(&self, model: &Model) -> bool {
        holds(&self.0, model)
    }
}

fn holds(expression: &Expression, model: &Model) -> bool {
    match expression {
        Expression::Any(parts) => parts.iter().any(|part| holds(part, model)),
        Expression::All(parts) => parts.iter().all(|part| holds(part, model)),
        Expression::Not(inner) => !holds(inner, model),
        Expression::Number(subject, operator, limit, exponents) => {
            let Some((value, _)) = subject
                .value(model)
                .filter(|(_, dimension)| dimension.exponents() == *exponents)
            else {
                return false;
            };
            match operator {
                Operator::Less => value < *limit,
                Operator::LessOrEqual => value <= *limit,
                Operator::Greater => value > *limit,
                Operator::GreaterOrEqual => value >= *limit,
                Operator::Equal => value == *limit,
                Operator::NotEqual => value != *limit,
                Operator::Contains => false,
            }
        }
        Expression::Text(place, operator, wanted) => {
            let Some(text) = field(model, *place) else {
                return false;
            };
            let (text, wanted) = (text.to_lowercase(), wanted.to_lowercase());
            match operator {
                Operator::Contains => text.contains(&wanted),
                Operator::NotEqual => text != wanted,
                _ => {
                    text == wanted
                        || (TEXT_FIELDS[*place] == "name" && key_of(&text) == key_of(&wanted))
                }
            }
        }
    }
}

impl SortKey {
    /// Sorts ascending; sensors without the number come last, ties by name.
    pub fn sort(&self, models: &mut [Model]) {
        models.sort_by(|a, b| {
            self.order(a, b)
                .then_with(|| key_of(a.name()).cmp(&key_of(b.name())))
        });
    }

    fn order(&self, a: &Model, b: &Model) -> Ordering {
        let last = |a: bool, b: bool| b.cmp(&a);
        if let Subject::Field(place) = &self.0 {
            if TEXT_FIELDS[*place] == "price_class" {
                let rank =
                    |model: &Model| price_class(model).map_or(usize::MAX, |price| price.rank());
                return rank(a).cmp(&rank(b));
            }
            let text = |model: &Model| field(model, *place).map(|text| text.to_lowercase());
            let (a, b) = (text(a), text(b));
            return last(a.is_some(), b.is_some()).then_with(|| a.cmp(&b));
        }
        let value = |model: &Model| self.0.value(model).map(|(value, _)| value);
        match (value(a), value(b)) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            (a, b) => last(a.is_some(), b.is_some()),
        }
    }
}

impl std::str::FromStr for SortKey {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let text = text.trim();
        if let Some(place) = TEXT_FIELDS.iter().position(|field| *field == text) {
            return Ok(Self(Subject::Field(place)));
        }
        Subject::parse(text).map(Self)
    }
}

impl std::str::FromStr for Filter {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let mut parser = Parser { rest: text };
        let expression = parser.any(0)?;
        if parser.rest.trim().is_empty() {
            return Ok(Self(expression));
        }
        Err(parser.wrong("expected `and`, `or` or the end"))
    }
}

struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn wrong(&self, what: &str) -> Error {
        let at = if self.rest.trim().is_empty() {
            "the end".to_string()
        } else {
            format!("\"{}\"", clip(self.rest.trim()))
        };
        Error::Usage {
            what: format!("the condition cannot be read, {what} at {at}"),
            advice: Some("write for instance --where 'gyro.noise.angle_random_walk < 0.1 deg/sqrt(h) and technology = MEMS'".to_string()),
        }
    }

    fn any(&mut self, depth: usize) -> Result<Expression, Error> {
        let mut parts = vec![self.all(depth)?];
        while self.word("or") {
            parts.push(self.all(depth)?);
        }
        Ok(Expression::Any(parts))
    }

    fn all(&mut self, depth: usize) -> Result<Expression, Error> {
        let mut parts = vec![self.not(depth)?];
        while self.word("and") {
            parts.push(self.not(depth)?);
        }
        Ok(Expression::All(parts))
    }

    fn not(&mut self, depth: usize) -> Result<Expression, Error> {
        if depth > DEEPEST {
            return Err(self.wrong("it is nested too deeply"));
        }
        if self.word("not") {
            return Ok(Expression::Not(Box::new(self.not(depth + 1)?)));
        }
        self.rest = self.rest.trim_start();
        if let Some(inner) = self.rest.strip_prefix('(') {
            self.rest = inner;
            let expression = self.any(depth + 1)?;
            self.rest = self.rest.trim_start();
            let Some(after) = self.rest.strip_prefix(')') else {
                return Err(self.wrong("a parenthesis is not closed"));
            };
            self.rest = after;
            return Ok(expression);
        }
        self.comparison()
    }

    /// Takes a word in any case, if it comes next.
    fn word(&mut self, word: &str) -> bool {
        let rest = self.rest.trim_start();
        let found = starts_with_word(rest, word);
        if found {
            self.rest = &rest[word.len()..];
        }
        found
    }

    fn comparison(&mut self) -> Result<Expression, Error> {
        let rest = self.rest.trim_start();
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || matches!(c, '.' | '_')))
            .unwrap_or(rest.len());
        if length == 0 {
            return Err(self.wrong("expected a parameter"));
        }
        let (subject, after) = rest.split_at(length);
        self.rest = after.trim_start();
        let operators = [
            ("<=", Operator::LessOrEqual),
            (">=", Operator::GreaterOrEqual),
            ("!=", Operator::NotEqual),
            ("==", Operator::Equal),
            ("<", Operator::Less),
            (">", Operator::Greater),
            ("=", Operator::Equal),
            ("~", Operator::Contains),
        ];
        let found = operators
            .iter()
            .find(|(sign, _)| self.rest.starts_with(sign));
        let Some((sign, operator)) = found else {
            return Err(self.wrong("expected <, <=, >, >=, =, != or ~"));
        };
        self.rest = self.rest[sign.len()..].trim_start();
        if let Some(place) = TEXT_FIELDS
            .iter()
            .position(|field| field.eq_ignore_ascii_case(subject))
        {
            if !matches!(
                operator,
                Operator::Equal | Operator::NotEqual | Operator::Contains
            ) {
                return Err(self.wrong("a text takes =, != or ~"));
            }
            return Ok(Expression::Text(place, *operator, self.text()?.to_string()));
        }
        let subject = Subject::parse(subject)?;
        if *operator == Operator::Contains {
            return Err(self.wrong("a number takes <, <=, >, >=, = or !="));
        }
        let quantity = self.value();
        let dimension = subject.dimension();
        let read = parse_with_unit(quantity, dimension).or_else(|error| match &subject {
            // The resolution of increments is an angle or a speed.
            Subject::Parameter(path) if path.file_keys() == ["resolution"] => {
                let other = if path.sensor() == Sensor::Gyro {
                    Dimension::ANGLE
                } else {
                    Dimension::SPEED
                };
                parse_with_unit(quantity, other).map_err(|_| error)
            }
            _ => Err(error),
        });
        let (limit, unit) = read?;
        Ok(Expression::Number(
            subject,
            *operator,
            limit,
            unit.exponents(),
        ))
    }

    fn text(&mut self) -> Result<&'a str, Error> {
        for quote in ['"', '\''] {
            if let Some(inner) = self.rest.strip_prefix(quote) {
                let Some(end) = inner.find(quote) else {
                    return Err(self.wrong("a quote is not closed"));
                };
                self.rest = &inner[end + 1..];
                return Ok(&inner[..end]);
            }
        }
        let text = self.value();
        if text.is_empty() {
            Err(self.wrong("expected a text"))
        } else {
            Ok(text)
        }
    }

    /// Up to the next `and`, `or`, or a parenthesis that closes one outside.
    fn value(&mut self) -> &'a str {
        let rest = self.rest;
        let mut depth = 0;
        let mut end = rest.len();
        let mut after_space = true;
        for (at, c) in rest.char_indices() {
            match c {
                '(' => depth += 1,
                ')' if depth == 0 => {
                    end = at;
                    break;
                }
                ')' => depth -= 1,
                _ if after_space
                    && depth == 0
                    && (starts_with_word(&rest[at..], "and")
                        || starts_with_word(&rest[at..], "or")) =>
                {
                    end = at;
                    break;
                }
                _ => {}
            }
            after_space = c.is_whitespace();
        }
        self.rest = &rest[end..];
        rest[..end].trim()
    }
}

fn starts_with_word(text: &str, word: &str) -> bool {
    text.get(..word.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(word))
        && text[word.len()..]
            .chars()
            .next()
            .is_none_or(|c| !(c.is_alphanumeric() || matches!(c, '_' | '.')))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::{Filter, SortKey};
    use crate::catalogue::Catalogue;

    fn kept(text: &str) -> Vec<String> {
        let filter: Filter = text.parse().unwrap();
        Catalogue::embedded()
            .select(Some(&filter), None)
            .unwrap()
            .iter()
            .map(|model| model.name().to_string())
            .collect()
    }

    #[test]
    fn conditions_combine() {
        let quiet = kept("gyro.noise.angle_random_walk < 0.01 deg/sqrt(h)");
        assert!(quiet.contains(&"HG9900".to_string()));
        let both = kept(
            "gyro.angle_random_walk < 0.01 deg/sqrt(h) AND (technology = nothing or quality = S)",
        );
        assert!(!both.is_empty() && both.len() <= quiet.len());
        assert_eq!(kept("name = 'stim300'"), ["STIM300"]);
        assert_eq!(kept("name = openrtk330-300za or name = STIM300").len(), 2);
        let negated = kept("not (gyro.angle_random_walk < 0.01 deg/sqrt(h))");
        assert_eq!(negated.len() + quiet.len(), 73);
        // A sensor without the number fails != too.
        let known = kept("gyro.bias.stability != -1 deg/h").len();
        assert!(known > 10 && known < 60, "{known}");
        // The floor, from whichever key: 8 deg/h printed as the minimum.
        assert!(kept("gyro.bias.instability <= 8 deg/h and name ~ 16470") == ["ADIS16470"]);
        // From a one-sided density of 0.0028 deg/s/√Hz.
        assert!(
            kept("gyro.angle_random_walk < 0.0021 deg/s/sqrt(Hz) and name ~ 42688")
                == ["ICM-42688-P"]
        );
        assert!(kept("gyro.resolution > 1 arcsec").contains(&"HG9900".to_string()));
    }

    #[test]
    fn wrong_conditions_are_refused() {
        let deep = "(".repeat(1000);
        for text in [
            "",
            "gyro.noise.angel_random_walk < 1 deg/h",
            "gyro.range < 1 m",
            "gyro.range",
            "gyro.range ~ 3 deg/s",
            "name < b",
            "name = 'a",
            "(name = a",
            "name = a)",
            "name = a gyro.range < 3 deg/s and",
            &deep,
            "not",
            "and",
        ] {
            assert!(text.parse::<Filter>().is_err(), "{text}");
        }
        let error = "gyro.noise.angel_random_walk < 1 deg/h"
            .parse::<Filter>()
            .unwrap_err();
        assert_eq!(
            error.advice().unwrap(),
            "did you mean `gyro.noise.angle_random_walk`?"
        );
    }

    #[test]
    fn sorting_puts_the_absent_last() {
        let key: SortKey = "gyro.bias.instability".parse().unwrap();
        let models = Catalogue::embedded().select(None, Some(&key)).unwrap();
        let floors: Vec<Option<f64>> = models
            .iter()
            .map(|model| {
                (0..3)
                    .filter_map(|axis| model.instability_floor(sagnac_core::Sensor::Gyro, axis))
                    .reduce(f64::max)
            })
            .collect();
        let first_absent = floors.iter().position(Option::is_none).unwrap();
        assert!(floors[first_absent..].iter().all(Option::is_none));
        assert!(
            floors[..first_absent]
                .windows(2)
                .all(|pair| pair[0] <= pair[1])
        );
        assert!("gyro.bias.instabilty".parse::<SortKey>().is_err());
    }
}
