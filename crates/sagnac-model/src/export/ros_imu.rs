//! Covariances of ROS sensor_msgs/Imu: N²·f on the diagonal, the variance of a sample; −1 says that there is no orientation.

use super::text::{comment, list};
use super::{Format, Source};
use crate::Model;
use crate::error::Error;
use sagnac_core::Sensor;

/// N²·f on the diagonal.
fn diagonal(density: [f64; 3], rate_hz: f64) -> [f64; 9] {
    std::array::from_fn(|k| match k % 4 {
        0 => density[k / 4].powi(2) * rate_hz,
        _ => 0.0,
    })
}

/// Covariances of a sample at `rate_hz`, else at the model's rate: angular velocity [rad²/s²], acceleration [m²/s⁴], row
/// by row, N²·f on the diagonal.
///
/// # Errors
/// A model without white noise of a triad; no rate.
pub fn ros_covariances(model: &Model, rate_hz: Option<f64>) -> Result<[[f64; 9]; 2], Error> {
    let source = Source::new(model, Format::RosImu, 1.0)?;
    let rate_hz = match rate_hz {
        Some(rate) => rate,
        None => source.rate_hz()?,
    };
    let (gyro, accel) = (source.white(Sensor::Gyro)?, source.white(Sensor::Accel)?);
    Ok([gyro, accel].map(|white| diagonal(white.axes, rate_hz)))
}

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
        let covariance = diagonal(white.axes, rate_hz);
        text.push_str(&format!("{key}: {}\n", list(&covariance)));
    }
    Ok(text)
}
