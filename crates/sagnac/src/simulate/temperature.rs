//! Temperature over a run: constant, a ramp, a cycle T = a + (b − a)(1 − cos 2πt/P)/2, or a table.
//!
//! A sample holds the mean over its interval, as every truth input does.

use std::f64::consts::PI;

use sagnac_model::units::{Dimension, parse_quantity};

use crate::Error;

/// Temperature over a run, °C against s from the run's start.
#[derive(Debug, Clone, PartialEq)]
pub enum TemperatureProfile {
    /// The same throughout.
    Constant(f64),
    /// Linear from t = 0 to the run's end.
    Ramp {
        /// At the start, °C.
        from_c: f64,
        /// At the end, °C.
        to_c: f64,
    },
    /// There and back, again and again.
    Cycle {
        /// At the start, °C.
        from_c: f64,
        /// Half a period later, °C.
        to_c: f64,
        /// P, s.
        period_s: f64,
    },
    /// Linear between its rows, held outside them.
    Table {
        /// Times, s, increasing.
        time_s: Vec<f64>,
        /// As many temperatures, °C.
        temperature_c: Vec<f64>,
    },
}

/// The lowest temperature there is, °C.
pub(crate) const ABSOLUTE_ZERO_C: f64 = -273.15;

impl TemperatureProfile {
    /// Reads `'40 degC'`, `'ramp 20 degC 60 degC'` or `'cycle -20 degC 70 degC 2 h'`.
    ///
    /// # Errors
    /// Anything else, with an example: a usage error.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let text = text.trim();
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let parts = split_quantities(rest);
        let temperature = |text: &str| match quantity(text, Dimension::TEMPERATURE)? {
            t if t >= ABSOLUTE_ZERO_C => Ok(t),
            _ => Err(Error::usage(format!("{text} is below absolute zero"))
                .advise("write for instance '-40 degC'")),
        };
        match (word, parts.as_slice()) {
            ("ramp", [from, to]) => Ok(Self::Ramp {
                from_c: temperature(from)?,
                to_c: temperature(to)?,
            }),
            ("cycle", [from, to, period]) => {
                let period_s = quantity(period, Dimension::TIME)?;
                if period_s <= 0.0 {
                    return Err(
                        Error::usage("the period of a temperature cycle must be positive")
                            .advise("write for instance 'cycle -20 degC 70 degC 2 h'"),
                    );
                }
                Ok(Self::Cycle {
                    from_c: temperature(from)?,
                    to_c: temperature(to)?,
                    period_s,
                })
            }
            ("ramp", _) => Err(Error::usage("a temperature ramp has a start and an end")
                .advise("write for instance 'ramp 20 degC 60 degC'")),
            ("cycle", _) => Err(Error::usage(
                "a temperature cycle has two temperatures and a period",
            )
            .advise("write for instance 'cycle -20 degC 70 degC 2 h'")),
            _ => Ok(Self::Constant(temperature(text)?)),
        }
    }

    /// Whether it needs to know where the run ends.
    pub fn needs_end(&self) -> bool {
        matches!(self, Self::Ramp { .. })
    }

    /// Whether it stays the same.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            _ => None,
        }
    }

    /// The mean over `from_s` … `to_s` of a run that ends at `end_s`, °C.
    pub fn mean_c(&self, from_s: f64, to_s: f64, end_s: f64) -> f64 {
        let middle = 0.5 * (from_s + to_s);
        match self {
            Self::Constant(value) => *value,
            Self::Ramp { from_c, to_c } => from_c + (to_c - from_c) * (middle / end_s),
            Self::Cycle {
                from_c,
                to_c,
                period_s,
            } => {
                let half = PI * (to_s - from_s) / period_s;
                let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
                from_c + 0.5 * (to_c - from_c) * (1.0 - sinc * (2.0 * PI * middle / period_s).cos())
            }
            Self::Table {
                time_s,
                temperature_c,
            } => table_mean(time_s, temperature_c, from_s, to_s),
        }
    }
}

/// Linear interpolation, held outside.
fn at(time_s: &[f64], value: &[f64], t: f64) -> f64 {
    let after = time_s.partition_point(|x| *x <= t);
    match (after.checked_sub(1), value.get(after)) {
        (None, first) => first.copied().unwrap_or(0.0),
        (Some(before), None) => value.get(before).copied().unwrap_or(0.0),
        (Some(before), Some(next)) => {
            let share = (t - time_s[before]) / (time_s[after] - time_s[before]);
            value[before] + share * (next - value[before])
        }
    }
}

/// The mean of the interpolation over an interval: trapezoids between its ends and the rows inside.
fn table_mean(time_s: &[f64], value: &[f64], from_s: f64, to_s: f64) -> f64 {
    if to_s <= from_s {
        return at(time_s, value, to_s);
    }
    let first = time_s.partition_point(|t| *t <= from_s);
    let end = time_s.partition_point(|t| *t < to_s);
    let (mut sum, mut last) = (0.0, (from_s, at(time_s, value, from_s)));
    let inside = (first..end).map(|k| (time_s[k], value[k]));
    for next in inside.chain(std::iter::once((to_s, at(time_s, value, to_s)))) {
        sum += 0.5 * (last.1 + next.1) * (next.0 - last.0);
        last = next;
    }
    sum / (to_s - from_s)
}

fn quantity(text: &str, dimension: Dimension) -> Result<f64, Error> {
    parse_quantity(text, dimension).map_err(|error| {
        let out = Error::usage(error.to_string());
        match error.advice() {
            Some(advice) => out.advise(advice),
            None => out,
        }
    })
}

/// `20 degC 60 degC` → `20 degC`, `60 degC`: a word that starts as a number starts a quantity.
fn split_quantities(text: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        match parts.last_mut() {
            Some(last) if !is_number => {
                last.push(' ');
                last.push_str(word);
            }
            _ => parts.push(word.to_owned()),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn profiles_read_as_the_contract_writes_them() {
        assert_eq!(
            TemperatureProfile::parse("40 degC").unwrap(),
            TemperatureProfile::Constant(40.0)
        );
        assert_eq!(
            TemperatureProfile::parse("ramp 20 degC 60degC").unwrap(),
            TemperatureProfile::Ramp {
                from_c: 20.0,
                to_c: 60.0
            }
        );
        assert_eq!(
            TemperatureProfile::parse("cycle -20 degC 70 degC 2 h").unwrap(),
            TemperatureProfile::Cycle {
                from_c: -20.0,
                to_c: 70.0,
                period_s: 7200.0
            }
        );
        for wrong in [
            "warm",
            "40 m",
            "ramp 20 degC",
            "cycle 1 degC 2 degC 0 s",
            "cycle 1 s 2 s 3 s",
        ] {
            assert_eq!(
                TemperatureProfile::parse(wrong).unwrap_err().exit_code(),
                2,
                "{wrong}"
            );
        }
    }

    #[test]
    fn means_are_means() {
        let table = TemperatureProfile::Table {
            time_s: vec![0.0, 1.0, 3.0],
            temperature_c: vec![10.0, 20.0, 0.0],
        };
        // 0.5…1: 17.5; 1…2: 15; outside: held.
        assert!((table.mean_c(0.5, 2.0, 9.0) - (0.5 * 17.5 + 15.0) / 1.5).abs() < 1e-12);
        assert_eq!(table.mean_c(5.0, 6.0, 9.0), 0.0);
        assert_eq!(table.mean_c(-2.0, -1.0, 9.0), 10.0);
        let cycle = TemperatureProfile::Cycle {
            from_c: -20.0,
            to_c: 70.0,
            period_s: 100.0,
        };
        let fine: f64 = (0..10_000)
            .map(|k| {
                let t = 20.0 + (f64::from(k) + 0.5) * 1e-3;
                -20.0 + 90.0 * (1.0 - (2.0 * PI * t / 100.0).cos()) / 2.0
            })
            .sum::<f64>()
            / 10_000.0;
        assert!((cycle.mean_c(20.0, 30.0, 1e3) - fine).abs() < 1e-6);
    }
}
