//! Another tool's file as a model: the rules of the exports inverted; what a format does not hold is left out, never zero.

use super::convention::{Foreign, Quantity, read};
use crate::entry::Entry;
use crate::error::Error;
use crate::export::Format;
use crate::export::matrix::{Matrix, apply, inverse, product};
use crate::model::Model;
use crate::units::Dimension;
use sagnac_core::Sensor;

/// A model and what is to be said about how it was read.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The model.
    pub model: Model,
    /// The format that the file was read as.
    pub format: Format,
    /// Remarks: other formats that fit, what is ambiguous.
    pub notes: Vec<String>,
}

/// Reads a file of another tool as a model; `from` decides where several formats fit, `rate_hz` stands in where the file
/// does not say its rate.
///
/// ```
/// use sagnac_model::foreign::import;
/// let yaml = "accelerometer_noise_density: 2.0e-3\ngyroscope_noise_density: 1.7e-4\nupdate_rate: 200.0\n";
/// let imported = import(yaml.as_bytes(), "imu.yaml", None, None)?;
/// assert_eq!(imported.model.triad("gyro.noise.angle_random_walk"), Some([1.7e-4; 3]));
/// assert_eq!(imported.model.triad("gyro.noise.rate_random_walk"), None);
/// # Ok::<(), sagnac_model::Error>(())
/// ```
///
/// # Errors
/// A file of no known format, or without a number of a sensor.
pub fn import(
    bytes: &[u8],
    label: &str,
    from: Option<Format>,
    rate_hz: Option<f64>,
) -> Result<Imported, Error> {
    let mut foreign = read(bytes, label, from)?;
    foreign.rate_hz = foreign.rate_hz.or(rate_hz);
    let mut notes = std::mem::take(&mut foreign.notes);
    if let Some(also) = foreign.also {
        notes.push(format!(
            "the file also fits {}; --from {} reads it so",
            also.name(),
            also.name()
        ));
    }
    let stem = label.rsplit(['/', '\\']).next().unwrap_or(label);
    let mut model = Model::new(
        stem.split('.')
            .next()
            .filter(|name| !name.is_empty())
            .unwrap_or("imported"),
    );
    model.label = label.to_string();
    if let Some(rate_hz) = foreign.rate_hz {
        model.set_sample_rate_hz(rate_hz)?;
    }
    noise(&foreign, &mut model, &mut notes)?;
    deterministic(&foreign, &mut model, &mut notes)?;
    if foreign.format == Format::ImuUtils && !super::readings::says_continuous(&foreign.flat) {
        notes.push(
            "gyr_n and acc_n were taken as N; the last version of the original wrote sqrt(f) N"
                .into(),
        );
    }
    if model.parameters().next().is_none() {
        return Err(Error::File {
            what: "the file has no number of a sensor that can be read".into(),
            place: label.to_string(),
            advice: notes.into_iter().next(),
        });
    }
    Ok(Imported {
        model,
        format: foreign.format,
        notes,
    })
}

fn noise(foreign: &Foreign, model: &mut Model, notes: &mut Vec<String>) -> Result<(), Error> {
    for sensor in Sensor::ALL {
        for quantity in [
            Quantity::FixedBias,
            Quantity::RunToRun,
            Quantity::Coefficient,
            Quantity::AllanMinimum,
            Quantity::White,
            Quantity::Walk,
            Quantity::BiasSigma,
        ] {
            let mine: Vec<_> = foreign
                .readings
                .iter()
                .filter(|reading| reading.sensor == sensor && reading.quantity == quantity)
                .collect();
            // A number of each axis says more than their mean.
            let mine: Vec<_> = if mine.iter().any(|reading| reading.axis.is_some()) {
                mine.into_iter()
                    .filter(|reading| reading.axis.is_some())
                    .collect()
            } else {
                mine
            };
            // Zero stands for "none" in these formats.
            if mine.iter().all(|reading| reading.value == 0.0) {
                continue;
            }
            let key = match quantity {
                Quantity::White => format!("noise.{}", Model::white_key(sensor)),
                Quantity::Walk => format!("noise.{}", Model::walk_key(sensor)),
                Quantity::RunToRun => "bias.stability".to_string(),
                Quantity::Coefficient => "bias.instability.coefficient".to_string(),
                Quantity::AllanMinimum => "bias.instability.allan_minimum".to_string(),
                Quantity::FixedBias => "bias".to_string(),
                Quantity::BiasSigma => "noise.gauss_markov.1.sigma".to_string(),
            };
            for reading in mine {
                let Some(meaning) = reading.rule.meaning(reading.value, foreign.rate_hz) else {
                    let note = format!(
                        "{} was left out: it needs the sampling rate, which the file does not say: add --rate",
                        reading.key
                    );
                    notes.push(note);
                    continue;
                };
                let axis = reading
                    .axis
                    .map_or_else(String::new, |axis| format!(".{}", ["x", "y", "z"][axis]));
                let source = format!("{}: {}", foreign.format.name(), reading.convention);
                let entry = Entry::of(meaning, quantity.dimension(sensor)).with_source(source);
                model.set(&format!("{}.{key}{axis}", sensor.key()), entry)?;
                if quantity == Quantity::BiasSigma {
                    let time_s = reading
                        .time_s
                        .filter(|time_s| time_s.is_finite() && *time_s > 0.0)
                        .unwrap_or(3600.0);
                    let path = format!(
                        "{}.noise.gauss_markov.1.correlation_time{axis}",
                        sensor.key()
                    );
                    model.set(&path, Entry::of(time_s, Dimension::TIME))?;
                }
            }
        }
    }
    Ok(())
}

fn nine(numbers: Option<&[f64]>) -> Option<Matrix> {
    let numbers = numbers.filter(|numbers| numbers.len() == 9)?;
    let mut matrix = [[0.0; 3]; 3];
    for (row, values) in matrix.iter_mut().zip(numbers.chunks(3)) {
        row.copy_from_slice(values);
    }
    Some(matrix)
}

/// The keys of matrices and the like that a format may have beside its noise.
pub(super) fn matrix_keys(format: Format) -> &'static [&'static str] {
    match format {
        Format::KalibrResult => &[
            "imu0.accelerometers.M",
            "imu0.gyroscopes.M",
            "imu0.gyroscopes.A",
            "imu0.gyroscopes.C_gyro_i",
        ],
        Format::OpenVins => &[
            "imu0.Ta",
            "imu0.Tw",
            "imu0.Tg",
            "imu0.R_IMUtoACC",
            "imu0.R_IMUtoGYRO",
        ],
        Format::Basalt => &["calib_accel_bias", "calib_gyro_bias"],
        Format::Matlab => &[
            "accel.AxesMisalignment",
            "gyro.AxesMisalignment",
            "accel.TemperatureBias",
            "gyro.TemperatureBias",
            "accel.TemperatureScaleFactor",
            "gyro.TemperatureScaleFactor",
            "gyro.AccelerationBias",
        ],
        Format::Pyins => &[
            "accel_parameters.transform",
            "gyro_parameters.transform",
            "accel_model.scale_misal_sd",
            "gyro_model.scale_misal_sd",
        ],
        Format::KfGins => &[
            "initgyrscale",
            "initaccscale",
            "imunoise.gsstd",
            "imunoise.asstd",
            "imunoise.corrtime",
        ],
        _ => &[],
    }
}

fn deterministic(
    foreign: &Foreign,
    model: &mut Model,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    let flat = &foreign.flat;
    let get = |key: &str| nine(flat.get(key));
    match foreign.format {
        Format::KalibrResult => {
            set_matrix(model, Sensor::Accel, get("imu0.accelerometers.M"))?;
            let rotation =
                get("imu0.gyroscopes.C_gyro_i").unwrap_or(crate::export::matrix::IDENTITY);
            set_matrix(
                model,
                Sensor::Gyro,
                get("imu0.gyroscopes.M").map(|m| product(&m, &rotation)),
            )?;
            set_g_sensitivity(
                model,
                get("imu0.gyroscopes.A").map(|a| product(&a, &rotation)),
            )
        }
        Format::OpenVins => {
            let turned =
                |m: Option<Matrix>, r: Option<Matrix>| m.map(|m| r.map_or(m, |r| product(&m, &r)));
            set_matrix(
                model,
                Sensor::Accel,
                turned(get("imu0.Ta"), get("imu0.R_IMUtoACC")),
            )?;
            set_matrix(
                model,
                Sensor::Gyro,
                turned(get("imu0.Tw"), get("imu0.R_IMUtoGYRO")),
            )?;
            set_g_sensitivity(model, get("imu0.Tg"))
        }
        Format::Basalt => basalt(flat, model),
        Format::Matlab => {
            for sensor in Sensor::ALL {
                let percent = get(&format!("{}.AxesMisalignment", sensor.key()));
                set_matrix(
                    model,
                    sensor,
                    percent.map(|m| m.map(|row| row.map(|value| value / 100.0))),
                )?;
                matlab_thermal(flat, model, sensor)?;
                for (key, path) in [("MeasurementRange", "range"), ("Resolution", "resolution")] {
                    if let Some(value) = flat
                        .one(&format!("{}.{key}", sensor.key()))
                        .filter(|value| *value > 0.0)
                    {
                        let path = format!("{}.{path}", sensor.key());
                        model.set(
                            &path,
                            Entry::of(value, Quantity::FixedBias.dimension(sensor)),
                        )?;
                    }
                }
            }
            Ok(())
        }
        Format::Pyins => {
            for sensor in Sensor::ALL {
                set_matrix(
                    model,
                    sensor,
                    get(&format!("{}_parameters.transform", sensor.key())),
                )?;
                let spread = get(&format!("{}_model.scale_misal_sd", sensor.key()));
                pyins_spread(spread, model, sensor, notes)?;
            }
            Ok(())
        }
        Format::KfGins => {
            for (sensor, key, path) in [
                (Sensor::Gyro, "initgyrscale", "scale_factor"),
                (Sensor::Accel, "initaccscale", "scale_factor"),
                (Sensor::Gyro, "imunoise.gsstd", "scale_factor.stability"),
                (Sensor::Accel, "imunoise.asstd", "scale_factor.stability"),
            ] {
                for (axis, ppm) in flat
                    .get(key)
                    .unwrap_or_default()
                    .iter()
                    .enumerate()
                    .take(3)
                    .filter(|(_, ppm)| **ppm != 0.0)
                {
                    set_axis(model, sensor, path, axis, 1e-6 * ppm, Dimension::RATIO)?;
                }
            }
            Ok(())
        }
        Format::Px4 | Format::ArduPilot => parameters(foreign, model),
        _ => Ok(()),
    }
}

fn set_axis(
    model: &mut Model,
    sensor: Sensor,
    key: &str,
    axis: usize,
    value: f64,
    dimension: Dimension,
) -> Result<(), Error> {
    model.set(
        &format!("{}.{key}.{}", sensor.key(), ["x", "y", "z"][axis]),
        Entry::of(value, dimension),
    )
}

/// I + M as scale factor and misalignment.
fn set_matrix(model: &mut Model, sensor: Sensor, matrix: Option<Matrix>) -> Result<(), Error> {
    let Some(matrix) = matrix.filter(|matrix| *matrix != crate::export::matrix::IDENTITY) else {
        return Ok(());
    };
    for (row, values) in matrix.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            if row == column {
                set_axis(
                    model,
                    sensor,
                    "scale_factor",
                    row,
                    value - 1.0,
                    Dimension::RATIO,
                )?;
            } else {
                let path = format!(
                    "{}.misalignment.{}{}",
                    sensor.key(),
                    ["x", "y", "z"][row],
                    ["x", "y", "z"][column]
                );
                model.set(&path, Entry::of(*value, Dimension::ANGLE))?;
            }
        }
    }
    Ok(())
}

/// Coefficients about 25 °C, where the tool's other numbers hold.
fn matlab_thermal(
    flat: &super::flat::Flat,
    model: &mut Model,
    sensor: Sensor,
) -> Result<(), Error> {
    let three = |key: &str| {
        let numbers = flat.get(&format!("{}.{key}", sensor.key()))?;
        let axes = match numbers {
            [one] => [*one; 3],
            [x, y, z] => [*x, *y, *z],
            _ => return None,
        };
        axes.iter().any(|value| *value != 0.0).then_some(axes)
    };
    let output = Quantity::FixedBias.dimension(sensor);
    for (key, path, factor, dimension) in [
        ("TemperatureBias", "bias", 1.0, output),
        (
            "TemperatureScaleFactor",
            "scale_factor",
            0.01,
            Dimension::RATIO,
        ),
    ] {
        for (axis, value) in three(key).into_iter().flatten().enumerate() {
            model.set_reference_temperature_c(25.0);
            let path = format!("{path}.temperature.1");
            let dimension = dimension.per_kelvin(1);
            set_axis(model, sensor, &path, axis, factor * value, dimension)?;
        }
    }
    if sensor == Sensor::Gyro
        && let Some([x, y, z]) = three("AccelerationBias")
    {
        let matrix = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        set_g_sensitivity(model, Some(matrix))?;
    }
    Ok(())
}

/// The diagonal is the scale factor's run-to-run spread; the rest, where equal, that of the misalignment.
fn pyins_spread(
    spread: Option<Matrix>,
    model: &mut Model,
    sensor: Sensor,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    let Some(spread) = spread else { return Ok(()) };
    let scale = [0, 1, 2].map(|axis| spread[axis][axis]);
    if scale.iter().any(|value| *value != 0.0) {
        for (axis, value) in scale.into_iter().enumerate() {
            let path = "scale_factor.stability";
            set_axis(model, sensor, path, axis, value, Dimension::RATIO)?;
        }
    }
    let rest: Vec<f64> = (0..9)
        .filter(|place| place % 4 != 0)
        .map(|place| spread[place / 3][place % 3])
        .collect();
    if rest.iter().any(|value| *value != rest[0]) {
        notes.push(format!(
            "the off-diagonal of {}_model.scale_misal_sd was not read: a model has one misalignment stability for all six",
            sensor.key()
        ));
    } else if rest[0] > 0.0 {
        let path = format!("{}.misalignment.stability", sensor.key());
        model.set(&path, Entry::of(rest[0], Dimension::ANGLE))?;
    }
    Ok(())
}

fn set_g_sensitivity(model: &mut Model, matrix: Option<Matrix>) -> Result<(), Error> {
    let Some(matrix) = matrix.filter(|matrix| matrix.iter().flatten().any(|g| *g != 0.0)) else {
        return Ok(());
    };
    for (row, values) in matrix.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            let path = format!(
                "gyro.g_sensitivity.{}{}",
                ["x", "y", "z"][row],
                ["x", "y", "z"][column]
            );
            model.set(&path, Entry::of(*value, Dimension::G_SENSITIVITY))?;
        }
    }
    Ok(())
}

fn basalt(flat: &super::flat::Flat, model: &mut Model) -> Result<(), Error> {
    for (sensor, key) in [
        (Sensor::Accel, "calib_accel_bias"),
        (Sensor::Gyro, "calib_gyro_bias"),
    ] {
        let Some(numbers) = flat.get(key) else {
            continue;
        };
        let mut correction = crate::export::matrix::IDENTITY;
        let places: &[(usize, usize)] = match (sensor, numbers.len()) {
            (Sensor::Accel, 9) => &[(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)],
            (Sensor::Gyro, 12) => &[
                (0, 0),
                (1, 0),
                (2, 0),
                (0, 1),
                (1, 1),
                (2, 1),
                (0, 2),
                (1, 2),
                (2, 2),
            ],
            _ => continue,
        };
        for ((row, column), value) in places.iter().zip(&numbers[3..]) {
            correction[*row][*column] += value;
        }
        let Some(matrix) = inverse(&correction) else {
            continue;
        };
        let bias = apply(&matrix, [numbers[0], numbers[1], numbers[2]]);
        if bias != [0.0; 3] {
            for (axis, value) in bias.into_iter().enumerate() {
                set_axis(
                    model,
                    sensor,
                    "bias",
                    axis,
                    value,
                    Quantity::FixedBias.dimension(sensor),
                )?;
            }
        }
        set_matrix(model, sensor, Some(matrix))?;
    }
    Ok(())
}

/// PX4 and ArduPilot: offsets, scales, temperature polynomials.
fn parameters(foreign: &Foreign, model: &mut Model) -> Result<(), Error> {
    let flat = &foreign.flat;
    let px4 = foreign.format == Format::Px4;
    for sensor in Sensor::ALL {
        let (block, offsets, scales) = match sensor {
            Sensor::Accel => ("CAL_ACC0", "INS_ACCOFFS", "INS_ACCSCAL"),
            Sensor::Gyro => ("CAL_GYRO0", "INS_GYROFFS", ""),
        };
        let dimension = Quantity::FixedBias.dimension(sensor);
        for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
            let offset = flat.one(&if px4 {
                format!("{block}_{name}OFF")
            } else {
                format!("{offsets}_{name}")
            });
            if let Some(offset) = offset {
                set_axis(model, sensor, "bias", axis, offset, dimension)?;
            }
            let scale = flat.one(&if px4 {
                format!("{block}_{name}SCALE")
            } else {
                format!("{scales}_{name}")
            });
            if let Some(scale) = scale.filter(|scale| *scale > 0.0) {
                set_axis(
                    model,
                    sensor,
                    "scale_factor",
                    axis,
                    1.0 / scale - 1.0,
                    Dimension::RATIO,
                )?;
            }
        }
        let letter = if sensor == Sensor::Accel { "A" } else { "G" };
        let about_c = if px4 {
            flat.one(&format!("TC_{letter}0_TREF")).unwrap_or(25.0)
        } else {
            35.0
        };
        let reference_c = if px4 {
            about_c
        } else {
            flat.one("INS_ACC1_CALTEMP")
                .filter(|t| *t > -300.0)
                .unwrap_or(35.0)
        };
        for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
            let coefficient = |power: usize| {
                if px4 {
                    flat.one(&format!("TC_{letter}0_X{power}_{axis}"))
                } else {
                    let block = if sensor == Sensor::Accel {
                        "ACC"
                    } else {
                        "GYR"
                    };
                    flat.one(&format!("INS_TCAL1_{block}{power}_{name}"))
                        .map(|value| 1e-6 * value)
                }
            };
            let about: Vec<f64> = (0..=3)
                .map(|power| {
                    if power == 0 {
                        0.0
                    } else {
                        coefficient(power).unwrap_or(0.0)
                    }
                })
                .collect();
            if about.iter().all(|c| *c == 0.0) {
                continue;
            }
            let shifted = crate::export::shifted(&about, reference_c - about_c);
            for (power, value) in shifted.iter().enumerate().skip(1) {
                set_axis(
                    model,
                    sensor,
                    &format!("bias.temperature.{power}"),
                    axis,
                    *value,
                    dimension.per_kelvin(power as u8),
                )?;
            }
            model.set_reference_temperature_c(reference_c);
        }
        let range = if px4 {
            [format!("TC_{letter}0_TMIN"), format!("TC_{letter}0_TMAX")]
        } else {
            ["INS_TCAL1_TMIN".into(), "INS_TCAL1_TMAX".into()]
        };
        if let (Some(low), Some(high)) = (flat.one(&range[0]), flat.one(&range[1]))
            && low < high
            && low >= -273.15
        {
            model.set_temperature_range_c([low, high]);
        }
    }
    Ok(())
}
