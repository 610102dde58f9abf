//! Dimensions: exponents of rad, m, s and K, and the quantities of this field that have them, by name.
//!
//! The angle counts as a dimension of its own, so that `rad/s` and `1/s` do not convert into one another.

use std::borrow::Cow;
use std::fmt;

/// Exponents are kept in sixtieths: halves, thirds, quarters and fifths are exact.
pub(crate) const EXPONENT_PARTS: i32 = 60;

/// Names of the base units, in the order of [`Exponents`].
pub(crate) const BASE_NAMES: [&str; 4] = ["rad", "m", "s", "K"];

/// Exponents of rad, m, s, K.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Exponents(pub(crate) [i32; 4]);

impl Exponents {
    /// Of a plain number.
    pub const NONE: Self = Self([0; 4]);

    const fn of(rad: i32, m: i32, s_halves: i32, k: i32) -> Self {
        Self([
            rad * EXPONENT_PARTS,
            m * EXPONENT_PARTS,
            s_halves * EXPONENT_PARTS / 2,
            k * EXPONENT_PARTS,
        ])
    }

    pub(crate) fn plus(self, other: Self, sign: i32) -> Self {
        let mut sum = self;
        for (own, theirs) in sum.0.iter_mut().zip(other.0) {
            *own = own.saturating_add(theirs.saturating_mul(sign));
        }
        sum
    }

    /// The unit of the SI with these exponents, such as `rad/s^0.5`, `m/s^2`, `rad*s/m`; `1` of a plain number.
    pub fn si_unit(self) -> String {
        let mut text = String::new();
        for (name, parts) in BASE_NAMES.iter().zip(self.0) {
            if parts > 0 {
                if !text.is_empty() {
                    text.push('*');
                }
                text.push_str(&power_text(name, parts));
            }
        }
        if text.is_empty() {
            text.push('1');
        }
        for (name, parts) in BASE_NAMES.iter().zip(self.0) {
            if parts < 0 {
                text.push('/');
                text.push_str(&power_text(name, -parts));
            }
        }
        text
    }
}

fn power_text(name: &str, parts: i32) -> String {
    if parts == EXPONENT_PARTS {
        name.to_string()
    } else {
        format!("{name}^{}", f64::from(parts) / f64::from(EXPONENT_PARTS))
    }
}

/// A quantity that a value is expected to be: its dimension, the words for it and an example.
///
/// ```
/// use sagnac_model::units::{Dimension, parse_quantity};
/// let n = parse_quantity("0.3 deg/sqrt(h)", Dimension::ANGLE_RANDOM_WALK)?;
/// assert!((n - 8.7266e-5).abs() < 1e-9); // rad/√s
/// let refused = parse_quantity("0.3 deg/h", Dimension::ANGLE_RANDOM_WALK).unwrap_err();
/// assert_eq!(refused.to_string(), "expected a random walk of angle, got a rate: \"0.3 deg/h\"");
/// # Ok::<(), sagnac_model::units::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension {
    exponents: Exponents,
    words: &'static str,
    example: &'static str,
    field_unit: &'static str,
    per_kelvin: u8,
    absolute_temperature: bool,
}

const fn named(
    exponents: Exponents,
    words: &'static str,
    example: &'static str,
    field_unit: &'static str,
) -> Dimension {
    Dimension {
        exponents,
        words,
        example,
        field_unit,
        per_kelvin: 0,
        absolute_temperature: false,
    }
}

impl Dimension {
    /// A number without dimension: `300 ppm`, `0.1 %`, `0.003`.
    pub const RATIO: Self = named(Exponents::NONE, "a plain number", "300 ppm", "ppm");
    /// An angle \[rad\].
    pub const ANGLE: Self = named(Exponents::of(1, 0, 0, 0), "an angle", "0.5 mrad", "mrad");
    /// An angular rate [rad/s].
    pub const ANGULAR_RATE: Self = named(
        Exponents::of(1, 0, -2, 0),
        "an angular rate",
        "3 deg/s",
        "deg/h",
    );
    /// An angular acceleration [rad/s²].
    pub const ANGULAR_ACCELERATION: Self = named(
        Exponents::of(1, 0, -4, 0),
        "an angular acceleration",
        "2 deg/s^2",
        "deg/s^2",
    );
    /// A ramp of rate R [rad/s²].
    pub const RATE_RAMP: Self = named(
        Exponents::of(1, 0, -4, 0),
        "a ramp of rate",
        "0.2 deg/h/h",
        "deg/h/h",
    );
    /// Angle random walk N, a two-sided density [rad/√s = rad/s/√Hz].
    pub const ANGLE_RANDOM_WALK: Self = named(
        Exponents::of(1, 0, -1, 0),
        "a random walk of angle",
        "0.3 deg/sqrt(h)",
        "deg/sqrt(h)",
    );
    /// A one-sided density of rate noise [rad/s/√Hz].
    pub const RATE_NOISE_DENSITY: Self = named(
        Exponents::of(1, 0, -1, 0),
        "a noise density of rate",
        "0.007 deg/s/sqrt(Hz)",
        "deg/s/sqrt(Hz)",
    );
    /// Rate random walk K [rad/s/√s].
    pub const RATE_RANDOM_WALK: Self = named(
        Exponents::of(1, 0, -3, 0),
        "a random walk of rate",
        "1.5 deg/h/sqrt(h)",
        "deg/h/sqrt(h)",
    );
    /// A length \[m\].
    pub const LENGTH: Self = named(Exponents::of(0, 1, 0, 0), "a length", "10 mm", "mm");
    /// A speed [m/s].
    pub const SPEED: Self = named(Exponents::of(0, 1, -2, 0), "a speed", "0.1 mm/s", "mm/s");
    /// An acceleration [m/s²].
    pub const ACCELERATION: Self =
        named(Exponents::of(0, 1, -4, 0), "an acceleration", "10 mg", "mg");
    /// A ramp of acceleration [m/s³].
    pub const ACCELERATION_RAMP: Self = named(
        Exponents::of(0, 1, -6, 0),
        "a ramp of acceleration",
        "0.1 ug/h",
        "ug/h",
    );
    /// Velocity random walk N, a two-sided density [m/s/√s = m/s²/√Hz].
    pub const VELOCITY_RANDOM_WALK: Self = named(
        Exponents::of(0, 1, -3, 0),
        "a random walk of velocity",
        "0.03 m/s/sqrt(h)",
        "m/s/sqrt(h)",
    );
    /// A one-sided density of acceleration noise [m/s²/√Hz].
    pub const ACCELERATION_NOISE_DENSITY: Self = named(
        Exponents::of(0, 1, -3, 0),
        "a noise density of acceleration",
        "100 ug/sqrt(Hz)",
        "ug/sqrt(Hz)",
    );
    /// Acceleration random walk K [m/s²/√s].
    pub const ACCELERATION_RANDOM_WALK: Self = named(
        Exponents::of(0, 1, -5, 0),
        "a random walk of acceleration",
        "0.5 mg/sqrt(h)",
        "mg/sqrt(h)",
    );
    /// A duration \[s\].
    pub const TIME: Self = named(Exponents::of(0, 0, 2, 0), "a duration", "30 s", "s");
    /// A frequency \[Hz\].
    pub const FREQUENCY: Self = named(Exponents::of(0, 0, -2, 0), "a frequency", "100 Hz", "Hz");
    /// An absolute temperature; the value is in degrees Celsius, kelvins are converted.
    pub const TEMPERATURE: Self = Dimension {
        exponents: Exponents::of(0, 0, 0, 1),
        words: "a temperature",
        example: "25 degC",
        field_unit: "degC",
        per_kelvin: 0,
        absolute_temperature: true,
    };
    /// A difference of temperatures \[K\].
    pub const TEMPERATURE_DIFFERENCE: Self = named(
        Exponents::of(0, 0, 0, 1),
        "a temperature difference",
        "1 K",
        "K",
    );
    /// A gyro's quadratic scale-factor term k2 [s/rad].
    pub const GYRO_QUADRATIC: Self = named(
        Exponents::of(-1, 0, 2, 0),
        "a quadratic scale-factor term of a gyro",
        "1e-4 s/rad",
        "s/rad",
    );
    /// A gyro's cubic scale-factor term k3 [s²/rad²].
    pub const GYRO_CUBIC: Self = named(
        Exponents::of(-2, 0, 4, 0),
        "a cubic scale-factor term of a gyro",
        "1e-6 s^2/rad^2",
        "s^2/rad^2",
    );
    /// An accelerometer's quadratic scale-factor term k2 [s²/m].
    pub const ACCEL_QUADRATIC: Self = named(
        Exponents::of(0, -1, 4, 0),
        "a quadratic scale-factor term of an accelerometer",
        "20 ug/g^2",
        "ug/g^2",
    );
    /// An accelerometer's cubic scale-factor term k3 [s⁴/m²].
    pub const ACCEL_CUBIC: Self = named(
        Exponents::of(0, -2, 8, 0),
        "a cubic scale-factor term of an accelerometer",
        "1 ug/g^3",
        "ug/g^3",
    );
    /// g-sensitivity of a gyro [(rad/s)/(m/s²)].
    pub const G_SENSITIVITY: Self = named(
        Exponents::of(1, -1, 2, 0),
        "a g-sensitivity",
        "10 deg/h/g",
        "deg/h/g",
    );
    /// g²-sensitivity of a gyro [(rad/s)/(m/s²)²].
    pub const G2_SENSITIVITY: Self = named(
        Exponents::of(1, -2, 6, 0),
        "a g^2-sensitivity",
        "0.5 deg/h/g^2",
        "deg/h/g^2",
    );

    /// Every named quantity: for the errors, the docs and the completions.
    pub const ALL: [Self; 25] = [
        Self::RATIO,
        Self::ANGLE,
        Self::ANGULAR_RATE,
        Self::ANGULAR_ACCELERATION,
        Self::RATE_RAMP,
        Self::ANGLE_RANDOM_WALK,
        Self::RATE_NOISE_DENSITY,
        Self::RATE_RANDOM_WALK,
        Self::LENGTH,
        Self::SPEED,
        Self::ACCELERATION,
        Self::ACCELERATION_RAMP,
        Self::VELOCITY_RANDOM_WALK,
        Self::ACCELERATION_NOISE_DENSITY,
        Self::ACCELERATION_RANDOM_WALK,
        Self::TIME,
        Self::FREQUENCY,
        Self::TEMPERATURE,
        Self::TEMPERATURE_DIFFERENCE,
        Self::GYRO_QUADRATIC,
        Self::GYRO_CUBIC,
        Self::ACCEL_QUADRATIC,
        Self::ACCEL_CUBIC,
        Self::G_SENSITIVITY,
        Self::G2_SENSITIVITY,
    ];

    /// The same per kelvin to a power: the coefficient of θ^`power` in a temperature polynomial.
    #[must_use]
    pub const fn per_kelvin(self, power: u8) -> Self {
        let mut exponents = self.exponents;
        exponents.0[3] -= power as i32 * EXPONENT_PARTS;
        Dimension {
            exponents,
            per_kelvin: self.per_kelvin + power,
            ..self
        }
    }

    /// The exponents of the base units.
    pub const fn exponents(self) -> Exponents {
        self.exponents
    }

    /// What it is called, with its article: `an angular rate`, `a random walk of angle`.
    pub fn words(self) -> Cow<'static, str> {
        match self.per_kelvin {
            0 => Cow::Borrowed(self.words),
            1 => Cow::Owned(format!("{} per kelvin", self.words)),
            power => Cow::Owned(format!("{} per K^{power}", self.words)),
        }
    }

    /// A value as it may be written: `0.3 deg/sqrt(h)`.
    pub fn example(self) -> Cow<'static, str> {
        self.with_kelvin(self.example)
    }

    /// The unit in which the field writes it: `deg/sqrt(h)`.
    pub fn field_unit(self) -> Cow<'static, str> {
        self.with_kelvin(self.field_unit)
    }

    fn with_kelvin(self, text: &'static str) -> Cow<'static, str> {
        match self.per_kelvin {
            0 => Cow::Borrowed(text),
            1 => Cow::Owned(format!("{text}/K")),
            power => Cow::Owned(format!("{text}/K^{power}")),
        }
    }

    /// The unit of its value in SI, as in JSON: `rad/s^0.5`; `degC` of an absolute temperature.
    pub fn si_unit(self) -> String {
        if self.absolute_temperature {
            "degC".to_string()
        } else {
            self.exponents.si_unit()
        }
    }

    /// Whether it is an absolute temperature, whose value is in degrees Celsius.
    pub const fn is_absolute_temperature(self) -> bool {
        self.absolute_temperature
    }

    /// Whether a bare number is accepted.
    pub fn is_plain(self) -> bool {
        self.exponents == Exponents::NONE
    }

    /// What a unit of these exponents measures, in words, for the `got` of an error.
    pub(crate) fn words_of(exponents: Exponents) -> Cow<'static, str> {
        if exponents == Self::ANGULAR_RATE.exponents {
            return Cow::Borrowed("a rate");
        }
        for dimension in Self::ALL {
            if dimension.exponents == exponents {
                return Cow::Borrowed(dimension.words);
            }
        }
        for power in 1..=8 {
            for dimension in Self::ALL {
                let candidate = dimension.per_kelvin(power);
                if candidate.exponents == exponents && dimension.exponents.0[3] == 0 {
                    return Cow::Owned(candidate.words().into_owned());
                }
            }
        }
        Cow::Owned(format!("a value in {}", exponents.si_unit()))
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words())
    }
}

#[cfg(test)]
mod tests {
    use super::Dimension;

    #[test]
    fn si_units_read_as_in_the_contract() {
        assert_eq!(Dimension::ANGLE_RANDOM_WALK.si_unit(), "rad/s^0.5");
        assert_eq!(Dimension::ACCELERATION.si_unit(), "m/s^2");
        assert_eq!(Dimension::RATIO.si_unit(), "1");
        assert_eq!(Dimension::G_SENSITIVITY.si_unit(), "rad*s/m");
        assert_eq!(Dimension::TEMPERATURE.si_unit(), "degC");
        assert_eq!(Dimension::ANGULAR_RATE.per_kelvin(2).si_unit(), "rad/s/K^2");
    }

    #[test]
    fn every_example_reads_as_its_own_dimension() {
        for dimension in Dimension::ALL {
            for power in 0..=2 {
                if power > 0 && dimension.exponents.0[3] != 0 {
                    continue;
                }
                let wanted = dimension.per_kelvin(power);
                let example = wanted.example();
                assert!(
                    super::super::parse_quantity(&example, wanted).is_ok(),
                    "{example}"
                );
                assert!(
                    super::super::Unit::parse(&wanted.field_unit()).is_ok(),
                    "{}",
                    wanted.field_unit()
                );
            }
        }
    }
}
