//! MATLAB imuSensor with gyroparams and accelparams: two-sided N, K as RandomWalk, B as BiasInstability.

use super::Source;
use super::matrix::Matrix;
use super::text::{comment, list, number};
use crate::error::Error;
use sagnac_core::{Output, Sensor};

fn matrix_text(matrix: &Matrix) -> String {
    format!(
        "[{}]",
        matrix
            .iter()
            .map(|row| row.map(number).join(", "))
            .collect::<Vec<_>>()
            .join("; ")
    )
}

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = comment("%", &source.head());
    for (sensor, name, make) in [
        (Sensor::Accel, "accel", "accelparams"),
        (Sensor::Gyro, "gyro", "gyroparams"),
    ] {
        let triad = source.core.triad(sensor);
        text.push_str(&format!("{name} = {make};\n"));
        let range = triad
            .range
            .largest()
            .map_or_else(|| "Inf".to_string(), number);
        text.push_str(&format!("{name}.MeasurementRange = {range};\n"));
        let lsb = triad.resolution.lsb.into_iter().fold(0.0, f64::max);
        if lsb > 0.0 && source.model.output(sensor) == Output::Rate {
            text.push_str(&format!("{name}.Resolution = {};\n", number(lsb)));
        }
        let mut line = |key: &str, number: super::Number| {
            text.push_str(&comment("%", &number.comment));
            text.push_str(&format!("{name}.{key} = {};\n", list(&number.axes)));
        };
        line("ConstantBias", source.fixed_bias(sensor));
        line("NoiseDensity", source.white(sensor)?);
        line("BiasInstability", source.flicker(sensor));
        line("RandomWalk", source.walk(sensor));
        text.push_str(&format!("{name}.NoiseType = 'double-sided';\n"));
        let percent = source
            .matrix(sensor)
            .map(|row| row.map(|value| 100.0 * value));
        text.push_str("% percent, the diagonal is the scale factor\n");
        text.push_str(&format!(
            "{name}.AxesMisalignment = {};\n",
            matrix_text(&percent)
        ));
        let bias = triad.bias.temperature.polynomial[0];
        let scale = triad.scale_factor.temperature.polynomial[0];
        if bias.iter().any(|c| *c != 0.0) {
            text.push_str(
                "% linear term; higher powers are left out, the tool takes it about 25 degC\n",
            );
            text.push_str(&format!("{name}.TemperatureBias = {};\n", list(&bias)));
        }
        if scale.iter().any(|c| *c != 0.0) {
            text.push_str("% percent per degC, linear term\n");
            text.push_str(&format!(
                "{name}.TemperatureScaleFactor = {};\n",
                list(&scale.map(|c| 100.0 * c))
            ));
        }
        if sensor == Sensor::Gyro && source.core.gyro_g_sensitivity.is_present() {
            let matrix = source.core.gyro_g_sensitivity.matrix;
            text.push_str("% (rad/s)/(m/s^2), the diagonal of the g-sensitivity\n");
            text.push_str(&format!(
                "{name}.AccelerationBias = {};\n",
                list(&[matrix[0][0], matrix[1][1], matrix[2][2]])
            ));
        }
    }
    let celsius = number(source.core.reference_temperature_c);
    text.push_str(&format!(
        "IMU = imuSensor('accel-gyro', 'SampleRate', {}, 'Temperature', {celsius}, 'Accelerometer', accel, 'Gyroscope', gyro);\n",
        number(source.rate_hz()?)
    ));
    Ok(text)
}
