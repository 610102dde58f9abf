//! Covariances of ROS sensor_msgs/Imu: N²·f on the diagonal, the variance of a sample; −1 says that there is no orientation.

use super::Source;
use super::text::{comment, list};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let rate_hz = source.rate_hz()?;
    let mut text = comment("#", &source.head());
    text.push_str("# the sensor gives no orientation\norientation_covariance: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n");
    for (sensor, key) in [
        (Sensor::Gyro, "angular_velocity_covariance"),
        (Sensor::Accel, "linear_acceleration_covariance"),
    ] {
        let white = source.white(sensor)?;
        text.push_str(&comment("#", &white.comment));
        let (bias, known) = source.run_to_run(sensor);
        if known {
            let variance = bias.largest().powi(2);
            text.push_str(&comment(
                "#",
                &format!(
                    "not in it: {}, variance {}",
                    bias.comment,
                    super::text::number(variance)
                ),
            ));
        }
        text.push_str(&format!("# N^2 f at {} Hz\n", super::text::number(rate_hz)));
        let mut covariance = [0.0; 9];
        for axis in 0..3 {
            covariance[4 * axis] = white.axes[axis].powi(2) * rate_hz;
        }
        text.push_str(&format!("{key}: {}\n", list(&covariance)));
    }
    Ok(text)
}
