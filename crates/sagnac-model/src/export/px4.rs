//! PX4 parameters: corrected = (raw − thermal − offset)·scale, so OFF = b and SCALE = 1/(1 + M_kk); nothing off the diagonal.

use super::Source;
use super::text::{comment, number};
use crate::model::ThermalTerm;
use crate::units::Dimension;
use sagnac_core::Sensor;

/// What the diagonal leaves out, and the largest error that makes at 1 g.
pub(super) fn dropped(source: &Source, sensor: Sensor, scale_kept: bool) -> String {
    let matrix = source.matrix(sensor);
    let mut worst = 0.0_f64;
    for (i, row) in matrix.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            if i != j {
                worst = worst.max(value.abs());
            }
        }
    }
    match sensor {
        Sensor::Accel => {
            let nonlinearity = source
                .core
                .accel
                .nonlinearity
                .quadratic
                .iter()
                .fold(0.0_f64, |most, k2| most.max(k2.abs()));
            let error = worst * 9.80665 + nonlinearity * 9.80665 * 9.80665;
            format!(
                "left out: misalignment, cross-axis, nonlinearity; the largest error that leaves at 1 g is {}",
                super::source::short(error, Dimension::ACCELERATION)
            )
        }
        Sensor::Gyro => {
            let g = source
                .core
                .gyro_g_sensitivity
                .matrix
                .iter()
                .flatten()
                .fold(0.0_f64, |most, g| most.max(g.abs()));
            let scale = if scale_kept { "" } else { "scale factor, " };
            format!(
                "left out: {scale}misalignment, cross-axis, g-sensitivity; the largest error that leaves at 1 g at rest is {}",
                super::source::short(g * 9.80665, Dimension::ANGULAR_RATE)
            )
        }
    }
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

pub(super) fn write(source: &Source) -> String {
    let mut text = comment("#", &source.head());
    text.push_str("# _ID, _PRIO and _ROT are not written: PX4 uses a block only once its _ID is the device's\n");
    let mut line = |note: &str, name: &str, value: String, kind: u8| {
        if !note.is_empty() {
            text.push_str(&comment("#", note));
        }
        text.push_str(&format!("1\t1\t{name}\t{value}\t{kind}\n"));
    };
    for (sensor, block, letter) in [(Sensor::Accel, "ACC", "A"), (Sensor::Gyro, "GYRO", "G")] {
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
            for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
                let note = if axis == 0 {
                    "1/(1 + scale factor error)"
                } else {
                    ""
                };
                line(
                    note,
                    &format!("CAL_{block}0_{name}SCALE"),
                    number(1.0 / matrix[axis][axis]),
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
        text.push_str(&comment(
            "#",
            &format!(
                "{}: {}",
                sensor.name(),
                dropped(source, sensor, sensor == Sensor::Accel)
            ),
        ));
        if polynomial(source, sensor)
            .is_some_and(|rows| rows.iter().skip(4).flatten().any(|c| *c != 0.0))
        {
            text.push_str("# powers of temperature above 3 are left out\n");
        }
    }
    text
}
