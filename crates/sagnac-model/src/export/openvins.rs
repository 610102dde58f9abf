//! OpenVINS kalibr_imu_chain.yaml: gyro = Tw R_IMUtoGYRO w + Tg f + b, accel = Ta R_IMUtoACC f + b.

use super::Source;
use super::kalibr_result::lower;
use super::matrix::IDENTITY;
use super::text::{comment, number, rows};
use crate::error::Error;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let lower = lower(source)?;
    let mut text = String::from("%YAML:1.0\n");
    text.push_str(&comment("#", &source.head()));
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
        text.push_str(&format!("    - [{}]\n", values.join(", ")));
    }
    text.push_str(&super::kalibr::noise_keys(source, "  ")?);
    text.push_str("  model: \"kalibr\"\n");
    text.push_str("  # the topic of your recording\n  rostopic: /imu0\n  time_offset: 0.0\n");
    text.push_str(&format!(
        "  # Hz, as in the model\n  update_rate: {}\n",
        number(source.rate_hz()?)
    ));
    text.push_str("  # three axes of the gyro, truth to reading\n");
    text.push_str(&format!("  Tw:\n{}", rows(&lower.gyro, "    ")));
    text.push_str(&format!(
        "  R_IMUtoGYRO:\n{}",
        rows(&lower.gyro_from_imu, "    ")
    ));
    text.push_str(&comment("  #", &lower.turned_comment()));
    text.push_str(&format!("  Ta:\n{}", rows(&lower.accel, "    ")));
    text.push_str(&format!("  R_IMUtoACC:\n{}", rows(&IDENTITY, "    ")));
    text.push_str("  # g-sensitivity, (rad/s)/(m/s^2), on specific force in the IMU frame\n");
    text.push_str(&format!("  Tg:\n{}", rows(&lower.in_imu_frame, "    ")));
    Ok(text)
}
