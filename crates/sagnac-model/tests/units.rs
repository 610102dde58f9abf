//! Laws of quantities as text: round trips, equal spellings, refusals, and no panic on any input.
#![allow(clippy::unwrap_used, reason = "tests")]

use proptest::prelude::*;
use sagnac_model::units::{
    Dimension, Error, Unit, format_quantity, parse_column, parse_numbers, parse_quantity,
    parse_triple, parse_with_unit,
};

/// Spellings of one value, each with the value in SI.
#[test]
fn spellings_convert() {
    let cases: &[(&str, Dimension, f64)] = &[
        (
            "0.34 deg/sqrt(h)",
            Dimension::ANGLE_RANDOM_WALK,
            9.890_199_094_634_534e-5,
        ),
        (
            "0.34deg/√h",
            Dimension::ANGLE_RANDOM_WALK,
            9.890_199_094_634_534e-5,
        ),
        (
            "0.34 °/√(h)",
            Dimension::ANGLE_RANDOM_WALK,
            9.890_199_094_634_534e-5,
        ),
        (
            "0.34 deg*h^-0.5",
            Dimension::ANGLE_RANDOM_WALK,
            9.890_199_094_634_534e-5,
        ),
        (
            "0.34 deg·h^(-1/2)",
            Dimension::ANGLE_RANDOM_WALK,
            9.890_199_094_634_534e-5,
        ),
        ("1 rad/s/√Hz", Dimension::ANGLE_RANDOM_WALK, 1.0),
        ("1 rad/sqrt(s)", Dimension::ANGLE_RANDOM_WALK, 1.0),
        (
            "1 deg/s/sqrt(Hz)",
            Dimension::RATE_NOISE_DENSITY,
            0.017_453_292_519_943_295,
        ),
        ("2h", Dimension::TIME, 7200.0),
        ("9.5 hr", Dimension::TIME, 34200.0),
        ("1 d", Dimension::TIME, 86400.0),
        ("30min", Dimension::TIME, 1800.0),
        ("+.5 ms", Dimension::TIME, 5e-4),
        ("7 µs", Dimension::TIME, 7e-6),
        ("7 μs", Dimension::TIME, 7e-6),
        ("200Hz", Dimension::FREQUENCY, 200.0),
        ("1 kHz", Dimension::FREQUENCY, 1000.0),
        ("5 1/s", Dimension::FREQUENCY, 5.0),
        ("5/s", Dimension::FREQUENCY, 5.0),
        ("450 dps", Dimension::ANGULAR_RATE, 7.853_981_633_974_483),
        (
            "1 mdps",
            Dimension::ANGULAR_RATE,
            1.745_329_251_994_329_6e-5,
        ),
        (
            "0.4 deg/h/K",
            Dimension::ANGULAR_RATE.per_kelvin(1),
            1.939_254_724_438_144e-6,
        ),
        (
            "0.4 deg/h/degC",
            Dimension::ANGULAR_RATE.per_kelvin(1),
            1.939_254_724_438_144e-6,
        ),
        (
            "0.4 (deg/h)/(K²)",
            Dimension::ANGULAR_RATE.per_kelvin(2),
            1.939_254_724_438_144e-6,
        ),
        ("25 degC", Dimension::TEMPERATURE, 25.0),
        ("25 °C", Dimension::TEMPERATURE, 25.0),
        ("298.15 K", Dimension::TEMPERATURE, 25.0),
        ("300 ppm", Dimension::RATIO, 3e-4),
        ("0.1 %", Dimension::RATIO, 1e-3),
        ("2%", Dimension::RATIO, 0.02),
        ("5 ppb", Dimension::RATIO, 5e-9),
        ("-3e-4", Dimension::RATIO, -3e-4),
        (
            "1 ug/g^2",
            Dimension::ACCEL_QUADRATIC,
            1.019_716_212_977_928_3e-7,
        ),
        (
            "1e-6/g",
            Dimension::ACCEL_QUADRATIC,
            1.019_716_212_977_928_3e-7,
        ),
        (
            "1e-6 1/g",
            Dimension::ACCEL_QUADRATIC,
            1.019_716_212_977_928_3e-7,
        ),
        ("0 s/rad", Dimension::GYRO_QUADRATIC, 0.0),
        ("2 s^4/m^2", Dimension::ACCEL_CUBIC, 2.0),
        ("1 g", Dimension::ACCELERATION, 9.806_65),
        ("1 mGal", Dimension::ACCELERATION, 1e-5),
        ("1 nmi", Dimension::LENGTH, 1852.0),
        ("1 ft", Dimension::LENGTH, 0.3048),
        ("1 cm", Dimension::LENGTH, 0.01),
        ("1 arcsec", Dimension::ANGLE, 4.848_136_811_095_36e-6),
        ("1 arcmin", Dimension::ANGLE, 2.908_882_086_657_216e-4),
        (
            "1 deg/h/sqrt(h)",
            Dimension::RATE_RANDOM_WALK,
            8.080_228_018_492_267e-8,
        ),
        (
            "1 mg/√h",
            Dimension::ACCELERATION_RANDOM_WALK,
            1.634_441_666_666_666_7e-4,
        ),
    ];
    for (text, dimension, expected) in cases {
        let got = parse_quantity(text, *dimension).unwrap();
        // The factors carry 31 digits and one rounding follows: at most one unit in the last place.
        assert!(
            (got - expected).abs() <= 2.3e-16 * expected.abs(),
            "{text}: {got:e}, not {expected:e}"
        );
    }
}

#[test]
fn left_to_right() {
    assert_eq!(Unit::parse("m/s/s").unwrap().factor(), 1.0);
    assert!(
        Unit::parse("m/s/s")
            .unwrap()
            .measures(Dimension::ACCELERATION)
    );
    assert!(Unit::parse("m/s*s").unwrap().measures(Dimension::LENGTH));
    assert!(
        Unit::parse("m/(s*s)")
            .unwrap()
            .measures(Dimension::ACCELERATION)
    );
    assert!(Unit::parse("1/(1/s)").unwrap().measures(Dimension::TIME));
    assert_eq!(
        parse_triple("0 0 -9.81 m/s^2", Dimension::ACCELERATION).unwrap(),
        [0.0, 0.0, -9.81]
    );
    assert_eq!(
        parse_triple("10,0, 5 deg/s", Dimension::ANGULAR_RATE).unwrap()[1],
        0.0
    );
    assert_eq!(
        parse_numbers("1 g", Dimension::ACCELERATION).unwrap().len(),
        1
    );
    let increments = Unit::parse_scaled("125 ug*s").unwrap();
    assert!(increments.measures(Dimension::SPEED));
    assert_eq!(
        parse_column("gyro_x [0.05 deg/s]")
            .unwrap()
            .unit
            .unwrap()
            .text(),
        "0.05 deg/s"
    );
}

fn refusal(text: &str, dimension: Dimension) -> String {
    let error: Error = parse_quantity(text, dimension).unwrap_err();
    format!("{error}; {}", error.advice().unwrap_or_default())
}

#[test]
fn refusals_say_what_is_expected() {
    let walk = Dimension::ANGLE_RANDOM_WALK;
    let lines = [
        refusal("0.3 deg/h", walk),
        refusal("0.3", walk),
        refusal("deg/sqrt(h)", walk),
        refusal("nan deg/sqrt(h)", walk),
        refusal("1e999 deg/sqrt(h)", walk),
        refusal("0.3 dag/sqrt(h)", walk),
        refusal("0.3 deg sqrt(h)", walk),
        refusal("0.3 deg/sqrt(h", walk),
        refusal("0.3 deg/sqrt h", walk),
        refusal("0.3 degrees/sqrt(h)", walk),
        refusal("0,3 deg/sqrt(h)", walk),
        refusal("5 MHz", Dimension::FREQUENCY),
        refusal("5 m", Dimension::TIME),
        refusal("5 mrad", Dimension::RATIO),
        refusal("3 grams", Dimension::ACCELERATION),
        refusal("1 K", Dimension::RATIO.per_kelvin(1)),
        refusal("1 m^999", Dimension::LENGTH),
        refusal("", Dimension::LENGTH),
    ];
    insta::assert_snapshot!(lines.join("\n"));
}

#[test]
fn hostile_units_are_refused_at_once() {
    for text in [
        "(".repeat(100_000),
        "√".repeat(100_000),
        "m^9".repeat(50),
        "m*".repeat(90),
        "1/".repeat(99),
    ] {
        assert!(Unit::parse(&text).is_err());
        assert!(parse_quantity(&format!("1 {text}"), Dimension::LENGTH).is_err());
    }
    assert!(parse_quantity(&"9".repeat(1_000_000), Dimension::RATIO).is_err());
}

const UNITS: [(&str, Dimension); 16] = [
    ("deg/sqrt(h)", Dimension::ANGLE_RANDOM_WALK),
    ("deg/h", Dimension::ANGULAR_RATE),
    ("dps", Dimension::ANGULAR_RATE),
    ("mg", Dimension::ACCELERATION),
    ("ug", Dimension::ACCELERATION),
    ("ug/g^2", Dimension::ACCEL_QUADRATIC),
    ("deg/h/g^2", Dimension::G2_SENSITIVITY),
    ("ft", Dimension::LENGTH),
    ("nmi", Dimension::LENGTH),
    ("ppm", Dimension::RATIO),
    ("%", Dimension::RATIO),
    ("min", Dimension::TIME),
    ("arcsec", Dimension::ANGLE),
    ("deg/h/sqrt(h)", Dimension::RATE_RANDOM_WALK),
    ("m/s/√h", Dimension::VELOCITY_RANDOM_WALK),
    ("degC", Dimension::TEMPERATURE),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Any value in SI is written in any unit so that it reads back to the same bits.
    #[test]
    fn written_values_read_back(bits in any::<u64>(), which in 0..UNITS.len()) {
        let (unit, dimension) = UNITS[which];
        let unit = Unit::parse(unit).unwrap();
        // Exponents are folded into a range that no sensor leaves.
        let exponent = 1023 - 200 + (bits >> 52) % 300;
        let value = f64::from_bits((bits & 0x800f_ffff_ffff_ffff) | (exponent << 52));
        let text = format_quantity(value, &unit);
        let (back, read) = parse_with_unit(&text, dimension).unwrap();
        prop_assert_eq!(back.to_bits(), value.to_bits(), "{}", text);
        prop_assert_eq!(read.text(), unit.text());
    }

    /// A decimal of up to 15 digits is written back as it was.
    #[test]
    fn short_decimals_are_kept(digits in 1_u64..1_000_000_000_000_000, power in -20_i32..5, which in 0..UNITS.len()) {
        let (unit, dimension) = UNITS[which];
        let text = format!("{digits}e{power} {unit}");
        let (value, read) = parse_with_unit(&text, dimension).unwrap();
        let written = dimension.format_in(value, &read);
        let number: f64 = written.split(' ').next().unwrap().parse().unwrap();
        prop_assert_eq!(number, format!("{digits}e{power}").parse::<f64>().unwrap());
    }

    /// No text makes the parsers panic.
    #[test]
    fn never_panics(text in "\\PC{0,40}") {
        for dimension in Dimension::ALL {
            let _ = parse_quantity(&text, dimension);
        }
        let _ = parse_column(&text);
        let _ = Unit::parse_scaled(&text);
        let _ = parse_triple(&text, Dimension::LENGTH);
    }

    /// Neither does one of the right alphabet.
    #[test]
    fn never_panics_on_unit_like_text(text in "[0-9.eE+ *·/^()√a-zµ°%²⁻-]{0,40}") {
        for dimension in [Dimension::LENGTH, Dimension::TEMPERATURE, Dimension::RATIO] {
            let _ = parse_quantity(&text, dimension);
        }
        let _ = parse_column(&format!("{text} [{text}]"));
    }
}
