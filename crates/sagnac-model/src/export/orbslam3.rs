//! ORB-SLAM3 settings: N and K in continuous time, which its code multiplies and divides by √Frequency.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = String::from("%YAML:1.0\n");
    text.push_str(&comment("#", &source.head()));
    text.push_str("File.version: \"1.0\"\n");
    for (sensor, name) in [(Sensor::Gyro, "Gyro"), (Sensor::Accel, "Acc")] {
        let white = source.white(sensor)?;
        text.push_str(&comment("#", &white.comment));
        text.push_str(&format!("IMU.Noise{name}: {}\n", number(white.largest())));
    }
    for (sensor, name) in [(Sensor::Gyro, "Gyro"), (Sensor::Accel, "Acc")] {
        let walk = source.needed_walk(sensor)?;
        text.push_str(&comment("#", &walk.comment));
        text.push_str(&format!("IMU.{name}Walk: {}\n", number(walk.largest())));
    }
    text.push_str("# Hz, as in the model: a wrong one spoils N and K\n");
    text.push_str(&format!("IMU.Frequency: {}\n", number(source.rate_hz()?)));
    Ok(text)
}
