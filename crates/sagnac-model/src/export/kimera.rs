//! Kimera-VIO ImuParams.yaml: Kalibr's four noise keys and its own.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = String::from("%YAML:1.0\n");
    text.push_str(&comment("#", &source.head()));
    text.push_str("# 0 combined, 1 ImuFactor\nimu_preintegration_type: 1\n");
    text.push_str("# body is this IMU\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n");
    text.push_str(&format!(
        "# Hz, as in the model\nrate_hz: {}\n",
        number(source.rate_hz()?)
    ));
    text.push_str("do_imu_rate_time_alignment: 0\ntime_alignment_window_size_s: 10.0\ntime_alignment_variance_threshold_scaling: 30.0\n");
    let (gyro, known) = source.run_to_run(Sensor::Gyro);
    let (accel, accel_known) = source.run_to_run(Sensor::Accel);
    let sigma = if known || accel_known {
        gyro.largest().max(accel.largest())
    } else {
        super::gtsam::SMALL_BIAS
    };
    text.push_str(&comment(
        "#",
        &format!("one number for both: gyro {}", gyro.comment),
    ));
    text.push_str(&comment("#", &format!("accelerometer {}", accel.comment)));
    text.push_str(&format!("imu_bias_init_sigma: {}\n", number(sigma)));
    text.push_str(&super::kalibr::noise_keys(source, "")?);
    text.push_str(
        "# of the integration itself: small\nimu_integration_sigma: 1.0e-8\nimu_time_shift: 0.0\n",
    );
    text.push_str(
        "# m/s^2, standard gravity, z up; write the local one\nn_gravity: [0.0, 0.0, -9.80665]\n",
    );
    Ok(text)
}
