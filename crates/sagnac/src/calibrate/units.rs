//! Names and units in which the parameters of a calibration are shown.

use sagnac_calibrate::stations::{Group, Term, terms::AXES};
use sagnac_core::Sensor;

const G: f64 = 9.80665;
const DEG: f64 = 180.0 / std::f64::consts::PI;

/// A row of results: name, unit in a terminal and how many of it make the SI unit.
pub(super) struct Shown {
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) per_si: f64,
}

/// How a term is shown.
pub(super) fn shown(sensor: Sensor, term: Term) -> Shown {
    let gyro = sensor == Sensor::Gyro;
    let pick = |of_gyro: (&'static str, f64), of_accel: (&'static str, f64)| {
        if gyro { of_gyro } else { of_accel }
    };
    let hour = DEG * 3600.0;
    let micro_g = 1e6 / G;
    let (name, (unit, per_si)) = match term.group {
        Group::Bias => ("Bias".to_owned(), pick(("deg/h", hour), ("ug", micro_g))),
        Group::ScaleFactor => ("Scale factor".to_owned(), ("ppm", 1e6)),
        Group::Misalignment => (
            format!("Misalignment to {}", AXES[term.component]),
            ("urad", 1e6),
        ),
        Group::BiasTemperature(1) => (
            "Bias, temperature".to_owned(),
            pick(("deg/h/K", hour), ("ug/K", micro_g)),
        ),
        Group::BiasTemperature(i) => (
            format!("Bias, temperature {i}"),
            match (gyro, i) {
                (true, 2) => ("deg/h/K^2", hour),
                (true, 3) => ("deg/h/K^3", hour),
                (true, 4) => ("deg/h/K^4", hour),
                (true, _) => ("deg/h/K^5", hour),
                (false, 2) => ("ug/K^2", micro_g),
                (false, 3) => ("ug/K^3", micro_g),
                (false, 4) => ("ug/K^4", micro_g),
                (false, _) => ("ug/K^5", micro_g),
            },
        ),
        Group::GSensitivity => (
            format!("g-sensitivity to {}", AXES[term.component]),
            ("deg/h/g", hour * G),
        ),
        Group::AxisOffset => (format!("Axis offset {}", AXES[term.component]), ("mm", 1e3)),
        Group::ScaleTemperature(1) => ("Scale, temperature".to_owned(), ("ppm/K", 1e6)),
        Group::ScaleTemperature(i) => (
            format!("Scale, temperature {i}"),
            match i {
                2 => ("ppm/K^2", 1e6),
                3 => ("ppm/K^3", 1e6),
                4 => ("ppm/K^4", 1e6),
                _ => ("ppm/K^5", 1e6),
            },
        ),
        Group::Quadratic => (
            "Quadratic".to_owned(),
            pick(("ppm/(deg/s)", 1e6 / DEG), ("ug/g^2", 1e6 * G)),
        ),
        Group::Asymmetry => ("Asymmetry".to_owned(), ("ppm", 1e6)),
        Group::Cubic => (
            "Cubic".to_owned(),
            pick(
                ("ppm/(deg/s)^2", 1e6 / (DEG * DEG)),
                ("ug/g^3", 1e6 * G * G),
            ),
        ),
        Group::G2Sensitivity => (
            format!(
                "g2-sensitivity {}",
                sagnac_calibrate::stations::terms::PRODUCTS[term.component].2
            ),
            ("deg/h/g^2", hour * G * G),
        ),
    };
    Shown { name, unit, per_si }
}
