//! Kalibr's `<bag>-imu.yaml`: accel = M_a C f + b, gyro = M_g C_gyro C w + A (C_gyro f) + b, M lower triangular.

use super::Source;
use super::matrix::{Matrix, angle, product, transposed};
use super::text::{comment, number, rows};
use crate::error::Error;
use sagnac_core::Sensor;

/// The matrices of a tool whose IMU frame makes the accelerometer's matrix lower triangular.
pub(super) struct Lower {
    pub(super) accel: Matrix,
    pub(super) gyro: Matrix,
    /// Rotation from the tool's IMU frame to the gyro frame.
    pub(super) gyro_from_imu: Matrix,
    /// From our body frame to the tool's.
    pub(super) turned: Matrix,
    /// g-sensitivity on specific force in the gyro frame.
    pub(super) in_gyro_frame: Matrix,
    /// g-sensitivity on specific force in the IMU frame.
    pub(super) in_imu_frame: Matrix,
}

pub(super) fn lower(source: &Source) -> Result<Lower, Error> {
    let (accel, turned) = source.lower(&source.matrix(Sensor::Accel), Sensor::Accel)?;
    let back = transposed(&turned);
    let (gyro, gyro_from_imu) =
        source.lower(&product(&source.matrix(Sensor::Gyro), &back), Sensor::Gyro)?;
    let in_imu_frame = product(&source.core.gyro_g_sensitivity.matrix, &back);
    let in_gyro_frame = product(&in_imu_frame, &transposed(&gyro_from_imu));
    Ok(Lower {
        accel,
        gyro,
        gyro_from_imu,
        turned,
        in_gyro_frame,
        in_imu_frame,
    })
}

impl Lower {
    pub(super) fn turned_comment(&self) -> String {
        format!(
            "the IMU frame is turned from the model's body frame by {} mrad, so that the accelerometer matrix is lower triangular",
            crate::units::format_number((angle(&self.turned) * 1e6).round() / 1e3)
        )
    }
}

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let lower = lower(source)?;
    let mut text = comment("#", &source.head());
    text.push_str("imu0:\n");
    text.push_str("  # body is this IMU\n  T_i_b:\n");
    for row in 0..4 {
        let values: Vec<String> = (0..4)
            .map(|column| {
                if row == column {
                    "1.0".into()
                } else {
                    "0.0".into()
                }
            })
            .collect();
        text.push_str(&format!("  - [{}]\n", values.join(", ")));
    }
    text.push_str(&super::kalibr::noise_keys(source, "  ")?);
    text.push_str("  accelerometers:\n");
    text.push_str(&comment(
        "    #",
        "truth to reading: I + scale factor + misalignment + cross-axis",
    ));
    text.push_str(&comment("    #", &lower.turned_comment()));
    text.push_str(&format!("    M:\n{}", rows(&lower.accel, "    ")));
    text.push_str("  gyroscopes:\n");
    text.push_str("    # g-sensitivity, (rad/s)/(m/s^2), on specific force in the gyro frame\n");
    text.push_str(&format!("    A:\n{}", rows(&lower.in_gyro_frame, "    ")));
    text.push_str("    # rotation from the IMU to the gyro frame\n");
    text.push_str(&format!(
        "    C_gyro_i:\n{}",
        rows(&lower.gyro_from_imu, "    ")
    ));
    text.push_str(&format!("    M:\n{}", rows(&lower.gyro, "    ")));
    text.push_str("  model: scale-misalignment\n");
    text.push_str("  # the topic of your recording\n  rostopic: /imu0\n  time_offset: 0.0\n");
    text.push_str(&format!(
        "  # Hz, as in the model\n  update_rate: {}\n",
        number(source.rate_hz()?)
    ));
    Ok(text)
}
