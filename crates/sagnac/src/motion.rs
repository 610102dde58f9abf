//! What drifts and along which path, from models and logs: the façade's way into [`sagnac_nav`].

use sagnac_core::{Axis, Element, PRODUCT_KEYS, Sensor};
use sagnac_log::Log;
use sagnac_model::units::{Dimension, Unit};
use sagnac_model::{Model, ParameterPath};
use sagnac_nav::covariance::Parameter;
use sagnac_nav::sensor::{Correlated, SensorErrors, Uncertain};
use sagnac_nav::trajectory::{PathAttitude, PathData, PathPosition};

use crate::Error;

/// Everything of a model that drifts (navigation.md §3.1).
///
/// # Errors
/// A model that cannot be made ready for simulation.
pub fn sensor_errors(model: &Model) -> Result<SensorErrors, Error> {
    let mut out = SensorErrors {
        model: model.to_core()?,
        noise: model.noise(),
        ..SensorErrors::default()
    };
    for sensor in Sensor::ALL {
        let s = model.stability(sensor);
        out.bias_stability[sensor.index()] = s.bias;
        out.scale_factor_stability[sensor.index()] = s.scale_factor;
        out.misalignment_stability[sensor.index()] = s.misalignment;
    }
    let mut joint: Vec<String> = Vec::new();
    for block in model.calibrations() {
        if block.covariance.is_none() {
            continue;
        }
        let places: Vec<(usize, String, Parameter)> = block
            .names
            .iter()
            .enumerate()
            .filter(|(_, name)| !joint.contains(name))
            .filter_map(|(i, name)| parameter(name).map(|(term, p)| (i, term, p)))
            .collect();
        let n = places.len();
        let mut covariance = vec![0.0; n * n];
        for (a, (i, ..)) in places.iter().enumerate() {
            for (b, (j, ..)) in places.iter().enumerate() {
                covariance[a * n + b] = block.covariance_of(*i, *j).unwrap_or(0.0);
            }
        }
        joint.extend(places.iter().map(|(i, ..)| block.names[*i].clone()));
        if n > 0 {
            out.correlated.push(Correlated {
                parameters: places.into_iter().map(|(_, t, p)| (t, p)).collect(),
                covariance,
            });
        }
    }
    for (path, entry) in model.parameters() {
        let Some(sigma) = entry.sigma.filter(|s| *s > 0.0) else {
            continue;
        };
        for element in path.elements() {
            let name = element.to_string();
            if joint.contains(&name)
                || (path.element().is_none() && model.at(element).is_some_and(|e| e != entry))
            {
                continue;
            }
            if let Some((term, parameter)) = parameter(&name) {
                out.uncertain.push(Uncertain {
                    term,
                    parameter,
                    sigma,
                });
            }
        }
    }
    Ok(out)
}

fn axis_of(key: &str) -> Option<Axis> {
    Axis::ALL.into_iter().find(|a| a.key() == key)
}

/// The parameter of a path such as `accel.scale_factor.temperature.1.y`, with the path without axis.
fn parameter(path: &str) -> Option<(String, Parameter)> {
    let parts: Vec<&str> = path.split('.').collect();
    let sensor = Sensor::ALL
        .into_iter()
        .find(|s| Some(&s.key()) == parts.first())?;
    let term = |n: usize| parts[..n].join(".");
    match parts.get(1..)? {
        ["bias", a] => Some((
            term(2),
            Parameter::Bias {
                sensor,
                axis: axis_of(a)?,
                power: 0,
            },
        )),
        ["scale_factor", a] => Some((
            term(2),
            Parameter::ScaleFactor {
                sensor,
                axis: axis_of(a)?,
                power: 0,
            },
        )),
        ["bias", "temperature", p, a] => Some((
            term(4),
            Parameter::Bias {
                sensor,
                axis: axis_of(a)?,
                power: p.parse().ok()?,
            },
        )),
        ["scale_factor", "temperature", p, a] => Some((
            term(4),
            Parameter::ScaleFactor {
                sensor,
                axis: axis_of(a)?,
                power: p.parse().ok()?,
            },
        )),
        ["scale_factor", "quadratic", a] => Some((
            term(3),
            Parameter::Quadratic {
                sensor,
                axis: axis_of(a)?,
            },
        )),
        ["scale_factor", "cubic", a] => Some((
            term(3),
            Parameter::Cubic {
                sensor,
                axis: axis_of(a)?,
            },
        )),
        ["scale_factor", "asymmetry", a] => Some((
            term(3),
            Parameter::Asymmetry {
                sensor,
                axis: axis_of(a)?,
            },
        )),
        ["misalignment" | "cross_axis", e] => {
            let element = Element::ALL.into_iter().find(|x| x.key() == *e)?;
            Some((term(2), Parameter::OffDiagonal { sensor, element }))
        }
        ["g_sensitivity", e] => Some((
            term(2),
            Parameter::GSensitivity {
                row: axis_of(e.get(..1)?)?,
                column: axis_of(e.get(1..)?)?,
            },
        )),
        ["g2_sensitivity", row, product] => {
            let product = PRODUCT_KEYS.iter().position(|k| k == product)?;
            Some((
                term(2),
                Parameter::G2Sensitivity {
                    row: axis_of(row)?,
                    product: product as u8,
                },
            ))
        }
        ["axis_offset", e] => Some((
            term(2),
            Parameter::AxisOffset {
                accel: axis_of(e.get(..1)?)?,
                component: axis_of(e.get(1..)?)?,
            },
        )),
        _ => None,
    }
}

/// The value of a budget term in a model, for people: `20 deg/h`; `None` for terms without one number.
pub(crate) fn value_text(model: &Model, term: &str) -> Option<String> {
    let path: ParameterPath = match term {
        "gyro.bias.instability" | "accel.bias.instability" => {
            let sensor = if term.starts_with("gyro") {
                Sensor::Gyro
            } else {
                Sensor::Accel
            };
            let floor = (0..3)
                .filter_map(|a| model.instability_floor(sensor, a))
                .fold(0.0, f64::max);
            let unit = if sensor == Sensor::Gyro {
                sagnac_report::text::Unit::DEG_PER_H
            } else {
                sagnac_report::text::Unit::MICRO_G
            };
            return Some(format!(
                "{} {}",
                sagnac_report::text::general(unit.from_si(floor), 3),
                unit.text
            ));
        }
        other => other.parse().ok()?,
    };
    let largest = path
        .elements()
        .into_iter()
        .filter_map(|p| model.at(p).or_else(|| model.at(path)))
        .filter_map(|e| e.value.filter(|v| *v != 0.0).or(e.sigma))
        .map(f64::abs)
        .fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    let unit = Unit::field(path.dimension());
    Some(format!(
        "{} {}",
        sagnac_report::text::general(largest / unit.factor(), 3),
        unit.text()
            .replace("sqrt(h)", "√h")
            .replace("sqrt(Hz)", "√Hz")
    ))
}

/// A column of a log in SI under any of its names, if the log has it; the unit of a column that is not an inertial
/// channel is read from the log.
fn column(
    log: &Log,
    names: &[&str],
    dimension: Dimension,
    label: &str,
) -> Result<Option<Vec<f64>>, Error> {
    for name in names {
        let Some(index) = log.layout.index(name) else {
            continue;
        };
        let channel = &log.layout.channels[index];
        let values = &log.columns[index];
        if dimension == Dimension::RATIO || channel.unit.is_empty() {
            return Ok(Some(values.clone()));
        }
        let unit = Unit::parse(&channel.unit)
            .map_err(|e| Error::data(e.to_string()).at(format!("{label}, column {name}")))?;
        if !unit.measures(dimension) {
            return Err(Error::data(format!(
                "column `{name}` is {}, expected {}",
                unit.words(),
                dimension.words()
            ))
            .at(label.to_owned())
            .advise(format!(
                "write its unit in brackets, for instance {name} [{}]",
                dimension.field_unit()
            )));
        }
        let factor = unit.factor();
        return Ok(Some(values.iter().map(|v| v * factor).collect()));
    }
    Ok(None)
}

/// All columns of a group, or none.
fn group<const N: usize>(
    log: &Log,
    names: [&[&str]; N],
    dimension: Dimension,
    label: &str,
) -> Result<Option<[Vec<f64>; N]>, Error> {
    let mut out: Vec<Vec<f64>> = Vec::new();
    for set in &names {
        match column(log, set, dimension, label)? {
            Some(values) => out.push(values),
            None if out.is_empty() => return Ok(None),
            None => {
                return Err(Error::data(format!(
                    "column `{}` is missing beside the others of its group",
                    set[0]
                ))
                .at(label.to_owned()));
            }
        }
    }
    Ok(out.try_into().ok())
}

/// The path and attitude that a log or a file of way points holds (navigation.md §1.3); rows with a NaN are left out.
///
/// # Errors
/// A file without positions, or with half a group of columns; a unit of another dimension.
pub fn path(log: &Log, label: &str) -> Result<PathData, Error> {
    let latitude = column(log, &["latitude"], Dimension::ANGLE, label)?;
    let longitude = column(log, &["longitude"], Dimension::ANGLE, label)?;
    let height = column(log, &["height"], Dimension::LENGTH, label)?;
    let local = group(
        log,
        [
            &["position_x", "p_RS_R_x", "p_x"],
            &["position_y", "p_RS_R_y", "p_y"],
            &["position_z", "p_RS_R_z", "p_z"],
        ],
        Dimension::LENGTH,
        label,
    )?;
    let quaternion = group(
        log,
        [
            &["quaternion_w", "q_RS_w", "q_w"],
            &["quaternion_x", "q_RS_x", "q_x"],
            &["quaternion_y", "q_RS_y", "q_y"],
            &["quaternion_z", "q_RS_z", "q_z"],
        ],
        Dimension::RATIO,
        label,
    )?;
    let angles = group(
        log,
        [&["roll"], &["pitch"], &["heading"]],
        Dimension::ANGLE,
        label,
    )?;
    let time: Vec<f64> = (0..log.rows).map(|k| log.time_s(k)).collect();
    let zip = |x: &[Vec<f64>; 3]| -> Vec<[f64; 3]> {
        (0..log.rows).map(|k| [x[0][k], x[1][k], x[2][k]]).collect()
    };
    let (positions, is_local) = match (latitude, longitude, height, local) {
        (Some(a), Some(b), Some(c), _) => (zip(&[a, b, c]), false),
        (.., Some(local)) => (zip(&local), true),
        _ => {
            let names: Vec<&str> = log
                .layout
                .channels
                .iter()
                .map(|c| c.name.as_str())
                .collect();
            return Err(Error::data("the path has no positions")
                .at(format!("{label}: columns time, {}", names.join(", ")))
                .advise("give latitude [deg], longitude [deg], height [m], or position_x [m], position_y [m], position_z [m]"));
        }
    };
    let quaternions: Option<Vec<[f64; 4]>> = quaternion.map(|q| {
        (0..log.rows)
            .map(|k| [q[0][k], q[1][k], q[2][k], q[3][k]])
            .collect()
    });
    let angles = angles.as_ref().map(zip);
    let keep: Vec<usize> = (0..log.rows)
        .filter(|&k| {
            time[k].is_finite()
                && positions[k].iter().all(|x| x.is_finite())
                && quaternions
                    .as_ref()
                    .is_none_or(|q| q[k].iter().all(|x| x.is_finite()))
                && angles
                    .as_ref()
                    .is_none_or(|a| a[k].iter().all(|x| x.is_finite()))
        })
        .collect();
    let pick = |x: &[[f64; 3]]| -> Vec<[f64; 3]> { keep.iter().map(|&k| x[k]).collect() };
    Ok(PathData {
        time_s: keep.iter().map(|&k| time[k]).collect(),
        position: if is_local {
            PathPosition::Local(pick(&positions))
        } else {
            PathPosition::Geodetic(pick(&positions))
        },
        attitude: match (quaternions, angles) {
            (Some(q), _) => PathAttitude::Quaternion(keep.iter().map(|&k| q[k]).collect()),
            (None, Some(a)) => PathAttitude::RollPitchHeading(pick(&a)),
            _ => PathAttitude::Coordinated,
        },
    })
}
