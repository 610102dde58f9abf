//! A Gazebo SDF `<sensor type="imu">`: σ per sample, turn-on bias, and a Gauss–Markov bias by its drive σ_b√(2/T_c).

use super::Source;
use super::text::number;
use crate::error::Error;
use sagnac_core::{Output, Sensor};

fn remark(indent: &str, text: &str) -> String {
    // Two hyphens would end an XML comment.
    format!("{indent}<!-- {} -->\n", text.replace("--", "- -"))
}

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let rate_hz = source.rate_hz()?;
    let mut text = remark("", &source.head());
    text.push_str("<sensor name=\"imu\" type=\"imu\">\n  <always_on>true</always_on>\n");
    text.push_str(&format!(
        "  <update_rate>{}</update_rate>\n  <imu>\n",
        number(rate_hz)
    ));
    for (sensor, name) in [
        (Sensor::Gyro, "angular_velocity"),
        (Sensor::Accel, "linear_acceleration"),
    ] {
        let white = source.white(sensor)?;
        let (run, _) = source.run_to_run(sensor);
        let fixed = source.fixed_bias(sensor);
        let (sigma, times_s) = source.correlated_bias(sensor);
        text.push_str(&format!("    <{name}>\n"));
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let lsb = source.core.triad(sensor).resolution.lsb[axis];
            let quantized = lsb > 0.0 && source.model.output(sensor) == Output::Rate;
            let kind = if quantized {
                "gaussian_quantized"
            } else {
                "gaussian"
            };
            let indent = "          ";
            text.push_str(&format!(
                "      <{letter}>\n        <noise type=\"{kind}\">\n{indent}<mean>0.0</mean>\n"
            ));
            text.push_str(&remark(
                indent,
                &format!("N sqrt(f), per sample: {}", white.comment),
            ));
            text.push_str(&format!(
                "{indent}<stddev>{}</stddev>\n",
                number(white.axes[axis] * rate_hz.sqrt())
            ));
            text.push_str(&remark(
                indent,
                &format!(
                    "{}; gz-sensors flips its sign with probability 1/2",
                    fixed.comment
                ),
            ));
            text.push_str(&format!(
                "{indent}<bias_mean>{}</bias_mean>\n",
                number(fixed.axes[axis])
            ));
            text.push_str(&remark(indent, &run.comment));
            text.push_str(&format!(
                "{indent}<bias_stddev>{}</bias_stddev>\n",
                number(run.axes[axis])
            ));
            if sigma.axes[axis] > 0.0 {
                text.push_str(&remark(
                    indent,
                    &format!("drive sigma sqrt(2/T_c): {}", sigma.comment),
                ));
                let drive = sigma.axes[axis] * (2.0 / times_s[axis]).sqrt();
                text.push_str(&format!(
                    "{indent}<dynamic_bias_stddev>{}</dynamic_bias_stddev>\n",
                    number(drive)
                ));
                text.push_str(&format!(
                    "{indent}<dynamic_bias_correlation_time>{}</dynamic_bias_correlation_time>\n",
                    number(times_s[axis])
                ));
            }
            if quantized {
                text.push_str(&format!("{indent}<precision>{}</precision>\n", number(lsb)));
            }
            text.push_str(&format!("        </noise>\n      </{letter}>\n"));
        }
        text.push_str(&format!("    </{name}>\n"));
    }
    text.push_str("  </imu>\n</sensor>\n");
    Ok(text)
}
