//! `calibrate thermal`: bias and scale factor against temperature, as text, JSON, model file and page.

mod figures;
mod json;
mod model_file;
mod page;
mod rest;
mod text;

use sagnac_calibrate::thermal::{self, Form, Options, Outcome, Sweep};
use sagnac_core::Sensor;
use sagnac_log::Issue;

use super::multi_position::{stamps, triad};
use super::{CertificateTexts, Place, place_gravity};
use crate::Error;
use crate::characterize::{NamedLog, once};

/// What `calibrate thermal` is asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermalRequest {
    /// Names and hashes of the logs, for the model file.
    pub source: Option<String>,
    /// Name of the model.
    pub name: String,
    /// Axis that points up, one a log: `+z,-z`.
    pub up: Option<String>,
    /// T0 \[°C\]; 25 where not given.
    pub reference_temperature_c: Option<f64>,
    /// `auto`, `polynomial` or `spline`.
    pub form: Option<String>,
    /// Largest order; 5 where not given.
    pub max_order: Option<usize>,
    /// Second halves of the soaks alone.
    pub is_soak_only: bool,
    /// Where the logs were made.
    pub place: Place,
    /// Texts of the certificate.
    pub texts: CertificateTexts,
}

/// What a temperature sweep gave.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalOutcome {
    /// The curves.
    pub found: Outcome,
    /// What was asked.
    pub request: ThermalRequest,
    /// Options of the estimate.
    pub options: Options,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Rows of all logs.
    pub samples: usize,
    /// What was left out of each log, with the time of its first row and its length \[s\].
    pub issues: Vec<(Vec<Issue>, f64, f64)>,
}

/// Reads `+z,-z`.
fn ups(text: &str, logs: usize) -> Result<Vec<(usize, f64)>, Error> {
    let bad = |what: String| {
        Error::usage(what)
            .at("--up")
            .advise("write the axis that points up, one a log, for instance --up +z,-z")
    };
    let out: Vec<(usize, f64)> = text
        .split(',')
        .map(|word| {
            let word = word.trim();
            let (sense, axis) = match word.as_bytes() {
                [b'+', axis] | [axis] => (1.0, *axis),
                [b'-', axis] => (-1.0, *axis),
                _ => (0.0, 0),
            };
            match axis {
                b'x' | b'y' | b'z' if sense != 0.0 => Ok((usize::from(axis - b'x'), sense)),
                _ => Err(bad(format!("`{word}` is no axis"))),
            }
        })
        .collect::<Result<_, _>>()?;
    if out.len() != logs {
        return Err(bad(format!(
            "{} axes are named for {logs} log{}",
            out.len(),
            if logs == 1 { "" } else { "s" }
        )));
    }
    Ok(out)
}

/// Estimates curves against temperature from logs of a sensor at rest.
///
/// # Errors
/// Logs without temperature or sensors, a temperature that is all but constant, an axis said to be up that is not.
pub fn thermal(logs: &[NamedLog], request: &ThermalRequest) -> Result<ThermalOutcome, Error> {
    let form = match request.form.as_deref() {
        None | Some("auto") => Form::Auto,
        Some("polynomial") => Form::Polynomial,
        Some("spline") => Form::Spline,
        Some(other) => {
            return Err(Error::usage(format!("`{other}` is no form of a curve"))
                .at("--form")
                .advise("one of auto, polynomial, spline"));
        }
    };
    let options = Options {
        reference_temperature_c: request.reference_temperature_c.unwrap_or(25.0),
        gravity_m_s2: place_gravity(&request.place)?,
        form,
        max_order: request.max_order.unwrap_or(5),
        is_soak_only: request.is_soak_only,
    };
    let up = request
        .up
        .as_deref()
        .map(|text| ups(text, logs.len()))
        .transpose()?;
    let mut temperatures = Vec::new();
    for named in logs {
        temperatures.push(named.log.channel("temperature").ok_or_else(|| {
            Error::data("the log has no temperature channel")
                .at(named.name.clone())
                .advise("name its column, for instance --columns 'temperature=temp:degC'")
        })?);
    }
    once(logs)?;
    let all_stamps: Vec<Option<Vec<f64>>> = logs.iter().map(|l| stamps(&l.log)).collect();
    let rests: Vec<rest::Rest> = logs
        .iter()
        .zip(&all_stamps)
        .map(|(named, stamps)| rest::rest(named, stamps.as_deref()))
        .collect::<Result<_, _>>()?;
    let mut sweeps = Vec::new();
    for (i, named) in logs.iter().enumerate() {
        sweeps.push(Sweep {
            dt_s: named.log.dt_s()?,
            stamps_s: all_stamps[i].as_deref(),
            temperature_c: temperatures[i],
            gyro: triad(&rests[i].log, Sensor::Gyro),
            accel: triad(&rests[i].log, Sensor::Accel),
            up: up.as_ref().map(|up| up[i]),
        });
    }
    let found = thermal::calibrate(&sweeps, &options).map_err(|error| {
        let mut out = Error::data(error.to_string());
        out.advice = error.advice();
        let name = logs.first().map_or("", |l| l.name.as_str());
        out.at(match error.place() {
            Some(place) => format!("{name}, {place}"),
            None => name.to_owned(),
        })
    })?;
    Ok(ThermalOutcome {
        found,
        request: request.clone(),
        options,
        logs: logs.iter().map(|l| l.name.clone()).collect(),
        samples: logs.iter().map(|l| l.log.rows).sum(),
        issues: rests
            .into_iter()
            .map(|r| (r.issues, r.first_s, r.duration_s))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::ups;

    #[test]
    fn axes_that_point_up() {
        assert_eq!(ups("+z, -z", 2).ok(), Some(vec![(2, 1.0), (2, -1.0)]));
        assert!(ups("z", 2).is_err());
        assert!(ups("up", 1).is_err());
    }
}
