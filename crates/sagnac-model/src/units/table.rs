//! The one table of units: symbol, exponents, factor to SI. The parser, the errors, the docs and the completions read it.
//!
//! Factors are exact (SI brochure, 9th edition): g = 9.80665 m/s², 1 nmi = 1852 m, 1 ft = 0.3048 m, 1 Gal = 0.01 m/s²; 1° = π/180 rad.

use super::dimension::{EXPONENT_PARTS, Exponents};
use super::double_double::DoubleDouble;

/// One unit of the table.
#[derive(Debug, Clone, Copy)]
pub struct UnitRow {
    /// As written.
    pub symbol: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    exponents: [i32; 4],
    /// The factor as `numerator·π^pi / denominator`: both integers, so that it is known to 32 digits.
    numerator: u64,
    denominator: u64,
    times_pi: bool,
}

/// π to 32 digits.
const PI: DoubleDouble = DoubleDouble::new(std::f64::consts::PI, 1.224_646_799_147_353_2e-16);

const RAD: [i32; 4] = [1, 0, 0, 0];
const METER: [i32; 4] = [0, 1, 0, 0];
const SECOND: [i32; 4] = [0, 0, 1, 0];
const HERTZ: [i32; 4] = [0, 0, -1, 0];
const ACCELERATION: [i32; 4] = [0, 1, -2, 0];
const RATE: [i32; 4] = [1, 0, -1, 0];
const KELVIN: [i32; 4] = [0, 0, 0, 1];
const NONE: [i32; 4] = [0; 4];

const fn row(
    symbol: &'static str,
    meaning: &'static str,
    exponents: [i32; 4],
    numerator: u64,
    denominator: u64,
) -> UnitRow {
    UnitRow {
        symbol,
        meaning,
        exponents,
        numerator,
        denominator,
        times_pi: false,
    }
}

const fn pi_row(
    symbol: &'static str,
    meaning: &'static str,
    exponents: [i32; 4],
    denominator: u64,
) -> UnitRow {
    UnitRow {
        symbol,
        meaning,
        exponents,
        numerator: 1,
        denominator,
        times_pi: true,
    }
}

/// Every accepted unit. `°C` and `degC` are kelvins here; the parser keeps apart where they stand alone.
pub const UNITS: &[UnitRow] = &[
    row("rad", "radian", RAD, 1, 1),
    row("mrad", "milliradian", RAD, 1, 1000),
    row("urad", "microradian", RAD, 1, 1_000_000),
    row("µrad", "microradian", RAD, 1, 1_000_000),
    pi_row("deg", "degree", RAD, 180),
    pi_row("°", "degree", RAD, 180),
    pi_row("arcmin", "minute of arc", RAD, 180 * 60),
    pi_row("arcsec", "second of arc", RAD, 180 * 3600),
    row("s", "second", SECOND, 1, 1),
    row("ms", "millisecond", SECOND, 1, 1000),
    row("us", "microsecond", SECOND, 1, 1_000_000),
    row("µs", "microsecond", SECOND, 1, 1_000_000),
    row("ns", "nanosecond", SECOND, 1, 1_000_000_000),
    row("min", "minute", SECOND, 60, 1),
    row("h", "hour", SECOND, 3600, 1),
    row("hr", "hour", SECOND, 3600, 1),
    row("d", "day", SECOND, 86_400, 1),
    row("Hz", "hertz", HERTZ, 1, 1),
    row("kHz", "kilohertz", HERTZ, 1000, 1),
    row("m", "meter", METER, 1, 1),
    row("mm", "millimeter", METER, 1, 1000),
    row("cm", "centimeter", METER, 1, 100),
    row("km", "kilometer", METER, 1000, 1),
    row("nmi", "nautical mile", METER, 1852, 1),
    row("ft", "foot", METER, 3048, 10_000),
    row(
        "g",
        "standard gravity, 9.80665 m/s^2",
        ACCELERATION,
        980_665,
        100_000,
    ),
    row(
        "mg",
        "thousandth of standard gravity",
        ACCELERATION,
        980_665,
        100_000_000,
    ),
    row(
        "ug",
        "millionth of standard gravity",
        ACCELERATION,
        980_665,
        100_000_000_000,
    ),
    row(
        "µg",
        "millionth of standard gravity",
        ACCELERATION,
        980_665,
        100_000_000_000,
    ),
    row("Gal", "0.01 m/s^2", ACCELERATION, 1, 100),
    row("mGal", "1e-5 m/s^2", ACCELERATION, 1, 100_000),
    pi_row("dps", "degree per second", RATE, 180),
    pi_row("mdps", "thousandth of a degree per second", RATE, 180_000),
    row("%", "percent", NONE, 1, 100),
    row("ppm", "part per million", NONE, 1, 1_000_000),
    row("ppb", "part per billion", NONE, 1, 1_000_000_000),
    row("K", "kelvin", KELVIN, 1, 1),
    row(
        "degC",
        "degree Celsius; kelvin in a product or quotient",
        KELVIN,
        1,
        1,
    ),
    row(
        "°C",
        "degree Celsius; kelvin in a product or quotient",
        KELVIN,
        1,
        1,
    ),
];

impl UnitRow {
    /// Exponents of the base units.
    pub fn exponents(&self) -> Exponents {
        Exponents(self.exponents.map(|exponent| exponent * EXPONENT_PARTS))
    }

    /// Value of one such unit in SI.
    pub fn factor(&self) -> f64 {
        self.exact_factor().round()
    }

    pub(crate) fn exact_factor(&self) -> DoubleDouble {
        let ratio =
            DoubleDouble::from_u64(self.numerator).div(DoubleDouble::from_u64(self.denominator));
        if self.times_pi {
            PI.div(DoubleDouble::from_u64(self.denominator))
        } else {
            ratio
        }
    }
}

/// The row of a symbol; the Greek letter mu counts as the micro sign.
pub(crate) fn find(symbol: &str) -> Option<&'static UnitRow> {
    let same = |row: &&UnitRow| row.symbol == symbol;
    UNITS.iter().find(same).or_else(|| {
        let rest = symbol.strip_prefix('\u{3bc}')?;
        UNITS
            .iter()
            .find(|row| row.symbol.strip_prefix('\u{b5}') == Some(rest))
    })
}

#[cfg(test)]
mod tests {
    use super::{UNITS, find};

    #[test]
    fn factors_are_the_nearest_numbers() {
        // The right sides are the decimal expansions of the exact values.
        let cases = [
            ("deg", 0.017_453_292_519_943_295),
            ("arcsec", 4.848_136_811_095_36e-6),
            ("mdps", 1.745_329_251_994_329_6e-5),
            ("ug", 9.806_65e-6),
            ("mGal", 1e-5),
            ("ft", 0.3048),
            ("ppb", 1e-9),
        ];
        for (symbol, factor) in cases {
            assert_eq!(
                find(symbol).map(super::UnitRow::factor),
                Some(factor),
                "{symbol}"
            );
        }
    }

    #[test]
    fn symbols_are_unique() {
        for (i, row) in UNITS.iter().enumerate() {
            assert!(
                UNITS[..i].iter().all(|other| other.symbol != row.symbol),
                "{}",
                row.symbol
            );
        }
    }
}
