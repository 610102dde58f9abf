//! VINS-Mono and VINS-Fusion: its midpoint rule propagates N and K where acc_n = N√(2f) and acc_w = K√f.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let rate_hz = source.rate_hz()?;
    let mut text = String::from("%YAML:1.0\n---\n");
    text.push_str(&comment("#", &source.head()));
    text.push_str(&format!(
        "# per-sample figures for {} Hz: another rate needs other numbers\n",
        number(rate_hz)
    ));
    text.push_str("imu: 1\n# the topic of your recording\nimu_topic: \"/imu0\"\n");
    for (sensor, name) in [(Sensor::Accel, "acc"), (Sensor::Gyro, "gyr")] {
        let white = source.white(sensor)?;
        let walk = source.needed_walk(sensor)?;
        let sample = white.largest() * rate_hz.sqrt();
        text.push_str(&comment("#", &white.comment));
        text.push_str(&format!("# N sqrt(2 f), what makes the code propagate N; the sigma of a sample is N sqrt(f) = {}\n", number(sample)));
        text.push_str(&format!(
            "{name}_n: {}\n",
            number(white.largest() * (2.0 * rate_hz).sqrt())
        ));
        text.push_str(&comment("#", &walk.comment));
        text.push_str("# K sqrt(f)\n");
        text.push_str(&format!(
            "{name}_w: {}\n",
            number(walk.largest() * rate_hz.sqrt())
        ));
    }
    text.push_str("# m/s^2, standard gravity; write the local one\ng_norm: 9.80665\n");
    Ok(text)
}
