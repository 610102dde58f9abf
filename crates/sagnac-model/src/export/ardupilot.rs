//! ArduPilot parameters: temperature, minus ACCOFFS, times ACCSCAL; the polynomial is about 35 °C and scaled by 10⁶.

use super::px4::{absent, dropped, is_calibrated, polynomial, scale_warnings, temperature_range};
use super::text::{comment, number};
use super::{Exported, Source};
use sagnac_core::Sensor;

/// ArduPilot's reference temperature [°C].
const ABOUT_C: f64 = 35.0;

/// The coefficients of Σ c_i (T − T0)^i about another temperature.
pub(crate) fn shifted(coefficients: &[f64], by: f64) -> Vec<f64> {
    // Horner's scheme, repeated: synthetic division by (x + by).
    let mut shifted = coefficients.to_vec();
    for start in 0..shifted.len() {
        for i in (start..shifted.len() - 1).rev() {
            shifted[i] += by * shifted[i + 1];
        }
    }
    shifted
}

pub(super) fn write(source: &Source) -> Exported {
    let mut remarks = Vec::new();
    let mut text = comment("#", &source.head());
    let reference_c = source.core.reference_temperature_c;
    let mut thermal = String::new();
    for (sensor, offsets, letter) in [
        (Sensor::Accel, "INS_ACCOFFS", "ACC"),
        (Sensor::Gyro, "INS_GYROFFS", "GYR"),
    ] {
        if !is_calibrated(source, sensor) {
            continue;
        }
        let bias = source.fixed_bias(sensor);
        text.push_str(&comment("#", &bias.comment));
        for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
            text.push_str(&format!("{offsets}_{name},{}\n", number(bias.axes[axis])));
        }
        if sensor == Sensor::Accel {
            let matrix = source.matrix(sensor);
            text.push_str("# 1/(1 + scale factor error)\n");
            let scales = [0, 1, 2].map(|axis| 1.0 / matrix[axis][axis]);
            remarks.extend(scale_warnings(scales, "INS_ACCSCAL_?", [0.8, 1.2]));
            for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
                text.push_str(&format!("INS_ACCSCAL_{name},{}\n", number(scales[axis])));
            }
        }
        if let Some(rows) = polynomial(source, sensor) {
            thermal.push_str(&format!(
                "# {} bias over temperature, about 35 degC, times 1e6\n",
                sensor.name()
            ));
            for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
                let coefficients: Vec<f64> = rows.iter().map(|row| row[axis]).collect();
                let about = shifted(&coefficients, ABOUT_C - reference_c);
                for power in 1..=3 {
                    thermal.push_str(&format!(
                        "INS_TCAL1_{letter}{power}_{name},{}\n",
                        number(1e6 * about[power])
                    ));
                }
            }
            if rows.iter().skip(4).flatten().any(|c| *c != 0.0) {
                thermal.push_str("# powers of temperature above 3 are left out\n");
            }
        }
    }
    if !thermal.is_empty() {
        text.push_str("INS_TCAL1_ENABLE,1\n");
        if let Some([low, high]) =
            temperature_range(source, Sensor::Gyro).or(temperature_range(source, Sensor::Accel))
        {
            text.push_str(&format!(
                "INS_TCAL1_TMIN,{}\nINS_TCAL1_TMAX,{}\n",
                number(low),
                number(high)
            ));
        }
        text.push_str("# the temperature at which the offsets hold\n");
        for (sensor, block) in [(Sensor::Accel, "ACC"), (Sensor::Gyro, "GYR")] {
            if is_calibrated(source, sensor) {
                let celsius = number(reference_c);
                text.push_str(&format!("INS_{block}1_CALTEMP,{celsius}\n"));
            }
        }
        text.push_str(&thermal);
    }
    for sensor in [Sensor::Accel, Sensor::Gyro] {
        let said = if is_calibrated(source, sensor) {
            let left_out = dropped(source, sensor, sensor == Sensor::Accel);
            format!("{}: {left_out}", sensor.name())
        } else {
            absent(sensor)
        };
        text.push_str(&comment("#", &said));
    }
    for remark in &remarks {
        text.push_str(&comment("#", remark));
    }
    Exported {
        bytes: text.into_bytes(),
        remarks,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn shifting_a_polynomial_keeps_its_values() {
        let about_25 = [0.0, 2.0, -0.5, 0.25];
        let about_35 = super::shifted(&about_25, 10.0);
        let at = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
        for t in [-20.0, 25.0, 60.0] {
            assert!((at(&about_25, t - 25.0) - at(&about_35, t - 35.0)).abs() < 1e-9);
        }
    }
}
