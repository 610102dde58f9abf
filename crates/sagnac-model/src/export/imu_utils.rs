//! imu_utils result in the continuous units of its maintained fork: N and K.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = String::from("%YAML:1.0\n---\n");
    text.push_str(&comment("#", &source.head()));
    text.push_str("# gyr_n, acc_n: N; gyr_w, acc_w: K, both in continuous time\ntype: IMU\n");
    text.push_str(&format!(
        "name: \"{}\"\n",
        source.model.name().replace(['"', '\n', '\r'], " ")
    ));
    for (sensor, top, letters, units) in [
        (
            Sensor::Gyro,
            "Gyr",
            "gyr",
            "rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)",
        ),
        (
            Sensor::Accel,
            "Acc",
            "acc",
            "m/s^2/sqrt(Hz), m/s^3/sqrt(Hz)",
        ),
    ] {
        let white = source.white(sensor)?;
        let walk = source.walk(sensor);
        text.push_str(&format!("{top}:\n   unit: \" {units}\"\n"));
        text.push_str(&comment("   #", &white.comment));
        text.push_str(&comment("   #", &walk.comment));
        let mut block = |name: &str, n: f64, k: f64| {
            text.push_str(&format!(
                "   {name}:\n      {letters}_n: {}\n      {letters}_w: {}\n",
                number(n),
                number(k)
            ));
        };
        block("avg-axis", white.largest(), walk.largest());
        for (axis, name) in ["x-axis", "y-axis", "z-axis"].iter().enumerate() {
            block(name, white.axes[axis], walk.axes[axis]);
        }
    }
    Ok(text)
}
