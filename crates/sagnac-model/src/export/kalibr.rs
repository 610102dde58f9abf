//! Kalibr's imu.yaml: continuous-time densities; its reader stops unless all four are above zero.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

/// The four noise keys, each under its comment, which Kalibr, OpenVINS and Kimera share.
pub(super) fn noise_keys(source: &Source, indent: &str) -> Result<String, Error> {
    let mark = format!("{indent}#");
    let mut text = String::new();
    for (sensor, name) in [
        (Sensor::Accel, "accelerometer"),
        (Sensor::Gyro, "gyroscope"),
    ] {
        let white = source.white(sensor)?;
        let walk = source.needed_walk(sensor)?;
        text.push_str(&comment(&mark, &white.comment));
        text.push_str(&format!(
            "{indent}{name}_noise_density: {}\n",
            number(white.largest())
        ));
        text.push_str(&comment(&mark, &walk.comment));
        text.push_str(&format!(
            "{indent}{name}_random_walk: {}\n",
            number(walk.largest())
        ));
    }
    Ok(text)
}

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = comment("#", &source.head());
    text.push_str(
        "# continuous time: rad/s/sqrt(Hz), rad/s^2/sqrt(Hz), m/s^2/sqrt(Hz), m/s^3/sqrt(Hz)\n",
    );
    text.push_str("# the topic of your recording\nrostopic: /imu0\n");
    text.push_str(&format!(
        "# Hz, as in the model\nupdate_rate: {}\n",
        number(source.rate_hz()?)
    ));
    text.push_str(&noise_keys(source, "")?);
    Ok(text)
}
