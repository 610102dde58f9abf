//! KF-GINS yaml: arw deg/√h, vrw m/s/√h, gbstd deg/h, abstd mGal, scale ppm, corrtime h.

use super::Source;
use super::text::{comment, list, number};
use crate::error::Error;
use crate::units::Unit;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |unit| unit.factor());
    let line = |indent: &str, key: &str, number: &super::Number, unit: &str| {
        let scale = factor(unit);
        let values = number.axes.map(|value| value / scale);
        format!(
            "{}{indent}{key}: {}\n",
            comment(
                &format!("{indent}#"),
                &format!("{unit}: {}", number.comment)
            ),
            list(&values)
        )
    };
    let (gyro_sigma, gyro_times) = source.correlated_bias(Sensor::Gyro);
    let (accel_sigma, accel_times) = source.correlated_bias(Sensor::Accel);
    let mut text = comment("#", &source.head());
    text.push_str(&line(
        "",
        "initgyrbias",
        &source.fixed_bias(Sensor::Gyro),
        "deg/h",
    ));
    text.push_str(&line(
        "",
        "initaccbias",
        &source.fixed_bias(Sensor::Accel),
        "mGal",
    ));
    text.push_str(&line(
        "",
        "initgyrscale",
        &source.fixed_scale(Sensor::Gyro),
        "ppm",
    ));
    text.push_str(&line(
        "",
        "initaccscale",
        &source.fixed_scale(Sensor::Accel),
        "ppm",
    ));
    text.push_str("imunoise:\n");
    text.push_str(&line(
        "  ",
        "arw",
        &source.white(Sensor::Gyro)?,
        "deg/sqrt(h)",
    ));
    text.push_str(&line(
        "  ",
        "vrw",
        &source.white(Sensor::Accel)?,
        "m/s/sqrt(h)",
    ));
    text.push_str(&line("  ", "gbstd", &gyro_sigma, "deg/h"));
    text.push_str(&line("  ", "abstd", &accel_sigma, "mGal"));
    text.push_str(&line(
        "  ",
        "gsstd",
        &source.scale_stability(Sensor::Gyro),
        "ppm",
    ));
    text.push_str(&line(
        "  ",
        "asstd",
        &source.scale_stability(Sensor::Accel),
        "ppm",
    ));
    // One time for all: that of the largest gyro bias.
    let axis = (0..3)
        .max_by(|a, b| gyro_sigma.axes[*a].total_cmp(&gyro_sigma.axes[*b]))
        .unwrap_or(0);
    text.push_str(&format!(
        "  # h, one for all: gyro {} s, accelerometer {} s\n",
        number(gyro_times[axis]),
        number(accel_times[axis])
    ));
    text.push_str(&format!(
        "  corrtime: {}\n",
        number(gyro_times[axis] / 3600.0)
    ));
    Ok(text)
}
