//! gnss-ins-sim's constructor dictionary: deg/h, deg/√h, m/s², m/s/√h.

use super::Source;
use super::text::{comment, list};
use crate::error::Error;
use crate::units::Unit;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |unit| unit.factor());
    let mut text = comment("#", &source.head());
    text.push_str("imu_err = {\n");
    for (sensor, name, output, white_name, white_unit) in [
        (Sensor::Gyro, "gyro", "deg/h", "arw", "deg/sqrt(h)"),
        (Sensor::Accel, "accel", "m/s^2", "vrw", "m/s/sqrt(h)"),
    ] {
        let white = source.white(sensor)?;
        let bias = source.fixed_bias(sensor);
        let (sigma, times_s) = source.correlated_bias(sensor);
        let mut line = |note: &str, key: &str, axes: [f64; 3], unit: &str| {
            let scale = factor(unit);
            text.push_str(&comment("    #", note));
            text.push_str(&format!(
                "    '{name}_{key}': {},\n",
                list(&axes.map(|value| value / scale))
            ));
        };
        line(
            &format!("{output}: {}", bias.comment),
            "b",
            bias.axes,
            output,
        );
        line(
            &format!("{white_unit}: {}", white.comment),
            white_name,
            white.axes,
            white_unit,
        );
        line(
            &format!("{output}: {}", sigma.comment),
            "b_stability",
            sigma.axes,
            output,
        );
        line("s", "b_corr", times_s, "s");
    }
    text.push_str("}\n");
    Ok(text)
}
