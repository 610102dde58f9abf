//! MATLAB imuSensor with gyroparams and accelparams: two-sided N, K as RandomWalk, B as BiasInstability.

use super::Source;
use super::ardupilot::shifted;
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

/// The tool's reference temperature [°C].
const ABOUT_C: f64 = 25.0;

/// Value and slope at 25 °C of a term that the model states about T0: three axes each.
fn about_25(fixed: [f64; 3], polynomial: &[[f64; 3]], reference_c: f64) -> [[f64; 3]; 2] {
    let mut about = [[0.0; 3]; 2];
    for axis in 0..3 {
        let coefficients: Vec<f64> = std::iter::once(fixed[axis])
            .chain(polynomial.iter().map(|row| row[axis]))
            .collect();
        let shifted = shifted(&coefficients, ABOUT_C - reference_c);
        about[0][axis] = shifted[0];
        about[1][axis] = shifted.get(1).copied().unwrap_or(0.0);
    }
    about
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
        let reference_c = source.core.reference_temperature_c;
        let moved = reference_c != ABOUT_C;
        let thermal = &triad.bias.temperature;
        let mut constant = source.fixed_bias(sensor);
        let [at_25, bias] = about_25(constant.axes, &thermal.polynomial, reference_c);
        if moved && thermal.order() > 0 {
            constant.axes = at_25;
            constant.comment = format!(
                "at 25 degC, about which the tool takes the temperature; at {} degC: {}",
                number(reference_c),
                constant.comment
            );
        }
        let mut line = |key: &str, number: super::Number| {
            text.push_str(&comment("%", &number.comment));
            text.push_str(&format!("{name}.{key} = {};\n", list(&number.axes)));
        };
        line("ConstantBias", constant);
        line("NoiseDensity", source.white(sensor)?);
        line("BiasInstability", source.flicker(sensor));
        line("RandomWalk", source.walk(sensor));
        text.push_str(&format!("{name}.NoiseType = 'double-sided';\n"));
        let mut matrix = source.matrix(sensor);
        let fixed = [0, 1, 2].map(|axis| matrix[axis][axis]);
        let thermal = &triad.scale_factor.temperature;
        let [at_25, scale] = about_25(fixed, &thermal.polynomial, reference_c);
        for axis in 0..3 {
            matrix[axis][axis] = at_25[axis];
        }
        let percent = matrix.map(|row| row.map(|value| 100.0 * value));
        text.push_str("% percent, the diagonal is the scale factor\n");
        text.push_str(&format!(
            "{name}.AxesMisalignment = {};\n",
            matrix_text(&percent)
        ));
        if bias.iter().any(|c| *c != 0.0) {
            text.push_str(if triad.bias.temperature.order() > 1 {
                "% slope at 25 degC, about which the tool takes it; higher powers are left out\n"
            } else {
                "% slope; the tool takes it about 25 degC\n"
            });
            text.push_str(&format!("{name}.TemperatureBias = {};\n", list(&bias)));
        }
        if scale.iter().any(|c| *c != 0.0) {
            text.push_str("% percent per degC, slope at 25 degC\n");
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
