//! basalt calibration.json: a = (I + S_a) raw − b, S_a lower triangular; w = (I + S_g) raw − b: the inverse of truth to reading.

use super::matrix::{angle, apply, inverse, product};
use super::{Exported, Source};
use crate::error::Error;
use sagnac_core::Sensor;
use serde_json::{Value, json};

pub(super) fn write(source: &Source) -> Result<Exported, Error> {
    let (lower, turned) = source.lower(&source.matrix(Sensor::Accel), Sensor::Accel)?;
    let singular = || Error::BadValue {
        path: "gyro".into(),
        problem: "has a singular matrix of scale factor and misalignment".into(),
    };
    let accel = inverse(&lower).ok_or_else(singular)?;
    let gyro = product(
        &turned,
        &inverse(&source.matrix(Sensor::Gyro)).ok_or_else(singular)?,
    );
    let fixed = |sensor| source.fixed_bias(sensor);
    let accel_bias = apply(&accel, fixed(Sensor::Accel).axes);
    let gyro_bias = apply(&gyro, fixed(Sensor::Gyro).axes);
    // Column by column, the lower triangle only.
    let mut calib_accel = accel_bias.to_vec();
    for (row, column) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)] {
        calib_accel.push(accel[row][column] - f64::from(u8::from(row == column)));
    }
    let mut calib_gyro = gyro_bias.to_vec();
    for column in 0..3 {
        for (row, values) in gyro.iter().enumerate() {
            calib_gyro.push(values[column] - f64::from(u8::from(row == column)));
        }
    }
    let mut remarks = vec![source.head()];
    let mut three = |key: &str, number: super::Number| -> Value {
        remarks.push(format!("{key}: {}", number.comment));
        json!(number.axes)
    };
    let accel_noise = three("accel_noise_std", source.white(Sensor::Accel)?);
    let gyro_noise = three("gyro_noise_std", source.white(Sensor::Gyro)?);
    let accel_walk = three("accel_bias_std", source.needed_walk(Sensor::Accel)?);
    let gyro_walk = three("gyro_bias_std", source.needed_walk(Sensor::Gyro)?);
    three("calib_accel_bias", fixed(Sensor::Accel));
    three("calib_gyro_bias", fixed(Sensor::Gyro));
    remarks.push(format!(
        "the IMU frame is turned from the model's body frame by {} mrad, so that the accelerometer matrix is lower triangular",
        crate::units::format_number((angle(&turned) * 1e6).round() / 1e3)
    ));
    if source
        .core
        .gyro_g_sensitivity
        .matrix
        .iter()
        .flatten()
        .any(|g| *g != 0.0)
    {
        remarks.push("g-sensitivity is left out: the format has none".into());
    }
    let document = json!({ "value0": {
        "T_imu_cam": [],
        "intrinsics": [],
        "resolution": [],
        "calib_accel_bias": calib_accel,
        "calib_gyro_bias": calib_gyro,
        "imu_update_rate": source.rate_hz()?,
        "accel_noise_std": accel_noise,
        "gyro_noise_std": gyro_noise,
        "accel_bias_std": accel_walk,
        "gyro_bias_std": gyro_walk,
        "cam_time_offset_ns": 0,
        "vignette": [],
    }});
    let text = serde_json::to_string_pretty(&document).map_err(|error| Error::Usage {
        what: format!("the file cannot be written: {error}"),
        advice: None,
    })?;
    Ok(Exported {
        bytes: (text + "\n").into_bytes(),
        remarks,
    })
}
