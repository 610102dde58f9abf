//! PX4 parameters: corrected = (raw − thermal − offset)·scale, so OFF = b and SCALE = 1/(1 + M_kk); nothing off the diagonal.

use super::matrix::apply;
use super::text::{comment, number};
use super::{Exported, Source};
use crate::model::ThermalTerm;
use crate::units::Dimension;
use sagnac_core::{G2Sensitivity, Sensor};

/// Whether a model has a calibration of a sensor: without one its parameters are left out, since zeros would wipe the
/// one that is in the device.
pub(super) fn is_calibrated(source: &Source, sensor: Sensor) -> bool {
    source.model.parameters().any(|(path, entry)| {
        let path_text = path.without_axis().to_string();
        let key = path_text.split_once('.').map_or("", |(_, key)| key);
        let fixed = ["bias", "scale_factor", "misalignment", "cross_axis"].contains(&key)
            || key.starts_with("bias.temperature");
        path.sensor() == sensor && fixed && entry.value.is_some()
    })
}

/// The sentence on a sensor whose parameters are not written.
pub(super) fn absent(sensor: Sensor) -> String {
    format!(
        "{}: the model has no calibration of it, so its parameters are left out and those of the device stay",
        sensor.name()
    )
}

/// What is left out, and the largest error that leaves at 1 g in any direction.
pub(super) fn dropped(source: &Source, sensor: Sensor, scale_kept: bool) -> String {
    let triad = source.core.triad(sensor);
    let matrix = source.matrix(sensor);
    let mut names = Vec::new();
    let mut name = |is_present: bool, text: &'static str| {
        if is_present {
            names.push(text);
        }
    };
    let scale = triad.scale_factor.fixed.iter().any(|s| *s != 0.0);
    name(scale && !scale_kept, "scale factor");
    name(
        triad.scale_factor.temperature.is_present(),
        "scale factor over temperature",
    );
    name(triad.bias.temperature.spline.is_some(), "bias spline");
    let some = |elements: [f64; 6]| elements.iter().any(|m| *m != 0.0);
    name(some(triad.misalignment.elements.to_array()), "misalignment");
    name(some(triad.cross_axis.elements.to_array()), "cross-axis");
    name(triad.nonlinearity.is_present(), "nonlinearity");
    name(triad.asymmetry.is_present(), "asymmetry");
    if sensor == Sensor::Gyro {
        name(source.core.gyro_g_sensitivity.is_present(), "g-sensitivity");
        name(
            source.core.gyro_g2_sensitivity.is_present(),
            "g2-sensitivity",
        );
    } else {
        name(source.core.accel_axis_offset.is_present(), "axis offset");
    }
    if names.is_empty() {
        return "nothing of the model is left out".into();
    }
    // Of a row of small terms in the force's direction the largest stands close to its gradient: a grid of 1 degree is
    // within 2e-4 of it.
    let mut worst = 0.0_f64;
    for latitude in -90..=90 {
        for longitude in 0..360 {
            let (sin, cos) = f64::from(latitude).to_radians().sin_cos();
            let (east, north) = f64::from(longitude).to_radians().sin_cos();
            let force = [cos * north, cos * east, sin].map(|part| 9.80665 * part);
            let error = match sensor {
                Sensor::Accel => {
                    let quadratic = triad.nonlinearity.quadratic_part(force);
                    let cubic = triad.nonlinearity.cubic_part(force);
                    let uneven = triad.asymmetry.part(force);
                    [0, 1, 2].map(|i| {
                        let across: f64 = (0..3)
                            .filter(|j| *j != i)
                            .map(|j| matrix[i][j] * force[j])
                            .sum();
                        across + quadratic[i] + cubic[i] + uneven[i]
                    })
                }
                Sensor::Gyro => {
                    let linear = apply(&source.core.gyro_g_sensitivity.matrix, force);
                    let products = G2Sensitivity::products(force);
                    let squares = source
                        .core
                        .gyro_g2_sensitivity
                        .matrix
                        .map(|row| row.iter().zip(products).map(|(h, q)| h * q).sum::<f64>());
                    [0, 1, 2].map(|i| linear[i] + squares[i])
                }
            };
            worst = error
                .iter()
                .fold(worst, |most, error| most.max(error.abs()));
        }
    }
    let (at, dimension) = match sensor {
        Sensor::Accel => ("1 g", Dimension::ACCELERATION),
        Sensor::Gyro => ("1 g at rest", Dimension::ANGULAR_RATE),
    };
    format!(
        "left out: {}; the largest error that leaves at {at} is {}",
        names.join(", "),
        super::source::short(worst, dimension)
    )
}

/// The scales that the autopilot does not take.
pub(super) fn scale_warnings(scales: [f64; 3], name: &str, range: [f64; 2]) -> Vec<String> {
    ["X", "Y", "Z"]
        .iter()
        .zip(scales)
        .filter(|(_, scale)| !(range[0]..=range[1]).contains(scale))
        .map(|(axis, scale)| {
            format!(
                "{} is {scale:.4}, outside {} to {}, which the autopilot takes",
                name.replace('?', axis),
                range[0],
                range[1]
            )
        })
        .collect()
}

/// c_0 … c_3 of the temperature polynomial; none where the model has no polynomial.
pub(super) fn polynomial(source: &Source, sensor: Sensor) -> Option<Vec<[f64; 3]>> {
    let dependence = &source.core.triad(sensor).bias.temperature;
    (dependence.order() > 0).then(|| {
        std::iter::once([0.0; 3])
            .chain(dependence.polynomial)
            .collect()
    })
}

pub(super) fn temperature_range(source: &Source, sensor: Sensor) -> Option<[f64; 2]> {
    source
        .model
        .own_temperature_range_c(sensor, ThermalTerm::Bias)
        .or(source.model.temperature_range_c())
}

pub(super) fn write(source: &Source) -> Exported {
    let mut remarks = Vec::new();
    let mut text = comment("#", &source.head());
    text.push_str("# _ID, _PRIO and _ROT are not written: PX4 uses a block only once its _ID is the device's\n");
    let mut line = |note: &str, name: &str, value: String, kind: u8| {
        if !note.is_empty() {
            text.push_str(&comment("#", note));
        }
        text.push_str(&format!("1\t1\t{name}\t{value}\t{kind}\n"));
    };
    for (sensor, block, letter) in [(Sensor::Accel, "ACC", "A"), (Sensor::Gyro, "GYRO", "G")] {
        if !is_calibrated(source, sensor) {
            continue;
        }
        let bias = source.fixed_bias(sensor);
        let matrix = source.matrix(sensor);
        for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
            let note = if axis == 0 { bias.comment.as_str() } else { "" };
            line(
                note,
                &format!("CAL_{block}0_{name}OFF"),
                number(bias.axes[axis]),
                9,
            );
        }
        if sensor == Sensor::Accel {
            let scales = [0, 1, 2].map(|axis| 1.0 / matrix[axis][axis]);
            remarks.extend(scale_warnings(scales, "CAL_ACC0_?SCALE", [0.1, 3.0]));
            for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
                let note = if axis == 0 {
                    "1/(1 + scale factor error)"
                } else {
                    ""
                };
                line(
                    note,
                    &format!("CAL_{block}0_{name}SCALE"),
                    number(scales[axis]),
                    9,
                );
            }
        }
        let Some(polynomial) = polynomial(source, sensor) else {
            continue;
        };
        line(
            "bias over temperature",
            &format!("TC_{letter}_ENABLE"),
            "1".into(),
            6,
        );
        for (power, row) in polynomial.iter().enumerate().take(4) {
            for (axis, value) in row.iter().enumerate() {
                line(
                    "",
                    &format!("TC_{letter}0_X{power}_{axis}"),
                    number(*value),
                    9,
                );
            }
        }
        line(
            "",
            &format!("TC_{letter}0_TREF"),
            number(source.core.reference_temperature_c),
            9,
        );
        if let Some([low, high]) = temperature_range(source, sensor) {
            line("", &format!("TC_{letter}0_TMIN"), number(low), 9);
            line("", &format!("TC_{letter}0_TMAX"), number(high), 9);
        }
    }
    for sensor in [Sensor::Accel, Sensor::Gyro] {
        if !is_calibrated(source, sensor) {
            text.push_str(&comment("#", &absent(sensor)));
            continue;
        }
        let left_out = dropped(source, sensor, sensor == Sensor::Accel);
        text.push_str(&comment("#", &format!("{}: {left_out}", sensor.name())));
        if polynomial(source, sensor)
            .is_some_and(|rows| rows.iter().skip(4).flatten().any(|c| *c != 0.0))
        {
            text.push_str("# powers of temperature above 3 are left out\n");
        }
    }
    for remark in &remarks {
        text.push_str(&comment("#", remark));
    }
    Exported {
        bytes: text.into_bytes(),
        remarks,
    }
}
