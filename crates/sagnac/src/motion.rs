//! What drifts, from a model: the façade's way into [`sagnac_nav`] (navigation.md §3.1).

use sagnac_core::{Axis, Element, PRODUCT_KEYS, Sensor};
use sagnac_model::units::Unit;
use sagnac_model::{Model, ParameterPath, Process};
use sagnac_nav::covariance::Parameter;
use sagnac_nav::sensor::{Correlated, SensorErrors, Uncertain};

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
            let what = match model.process(sensor) {
                Process::Flicker => ", Allan floor (0.664 B)",
                _ => "",
            };
            return Some(format!(
                "{} {}{what}",
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
