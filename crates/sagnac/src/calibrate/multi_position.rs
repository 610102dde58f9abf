//! `calibrate multi-position`: accelerometer and gyro from a log turned by hand, as text, JSON, model file and page.

mod faults;
mod json;
mod model_file;
mod page;
mod text;

use sagnac_calibrate::multi_position::{self, Options, Outcome, Recording};
use sagnac_calibrate::stations::Asked;
use sagnac_core::Sensor;
use sagnac_log::{Issue, Log};

use super::{CertificateTexts, Place, place_gravity};
use crate::Error;

/// What `calibrate multi-position` is asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MultiPositionRequest {
    /// What errors call the log.
    pub label: String,
    /// Name and hash of the log, for the model file.
    pub source: Option<String>,
    /// Name of the model.
    pub name: String,
    /// `default`, a list of `bias`, `scale_factor`, `misalignment`, `g_sensitivity`, or changes `+name`, `-name`.
    pub terms: Option<String>,
    /// Where the log was made.
    pub place: Place,
    /// I + M of the accelerometer of a stations model, whose frame is kept.
    pub fixture: Option<[[f64; 3]; 3]>,
    /// Misalignments of that model that no test measured.
    pub unmeasured: Vec<String>,
    /// Texts of the certificate.
    pub texts: CertificateTexts,
}

/// What a hand-turned log gave.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiPositionOutcome {
    /// The estimate.
    pub found: Outcome,
    /// What was asked.
    pub request: MultiPositionRequest,
    /// Gravity used \[m/s²\].
    pub gravity_m_s2: f64,
    /// Rows of the log.
    pub samples: usize,
    /// Sampling interval \[s\].
    pub dt_s: f64,
    /// Gaps, samples and stamps that are no numbers, as `info` finds them.
    pub findings: Vec<Issue>,
}

/// The three channels of a sensor.
pub(super) fn triad(log: &Log, sensor: Sensor) -> Option<[&[f64]; 3]> {
    let of = |axis: &str| log.channel(&format!("{}_{axis}", sensor.key()));
    Some([of("x")?, of("y")?, of("z")?])
}

/// Time stamps of a log in seconds by its own clock; none where it has none.
pub(super) fn stamps(log: &Log) -> Option<Vec<f64>> {
    let origin = log.stamps.get(0)?;
    let first = origin.seconds();
    Some(
        log.stamps
            .since(origin)
            .into_iter()
            .map(|t| first + t)
            .collect(),
    )
}

/// Estimates accelerometer and gyro from a log turned by hand between still poses.
///
/// # Errors
/// A log without accelerometer, or one that does not determine bias and scale factor of its three axes, with what
/// to add.
pub fn multi_position(
    log: &Log,
    request: &MultiPositionRequest,
) -> Result<MultiPositionOutcome, Error> {
    let asked = Asked::parse(request.terms.as_deref().unwrap_or("default")).map_err(|error| {
        let mut error = Error::from(error);
        error.kind = crate::Kind::Usage;
        error.advise("the groups here are bias, scale_factor, misalignment, g_sensitivity")
    })?;
    let gravity_m_s2 = place_gravity(&request.place)?;
    let accel = triad(log, Sensor::Accel).ok_or_else(|| {
        Error::data("the log has no accelerometer with three axes")
            .at(request.label.clone())
            .advise("name its columns, for instance --columns 'accel=1,2,3:g'")
    })?;
    let dt_s = log.dt_s()?;
    let mut stamps = stamps(log);
    if let Some(stamps) = &mut stamps {
        faults::fill(stamps, dt_s);
    }
    let recording = Recording {
        dt_s,
        stamps_s: stamps.as_deref(),
        accel,
        gyro: triad(log, Sensor::Gyro),
    };
    let options = Options {
        gravity_m_s2,
        latitude_rad: request.place.latitude_rad,
        asked,
    };
    let found = multi_position::calibrate(&recording, &options).map_err(|error| {
        let place = error.place();
        let mut out = Error::data(error.to_string());
        out.advice = error.advice();
        out.at(match place {
            Some(place) => format!("{}, {place}", request.label),
            None => request.label.clone(),
        })
    })?;
    let found = match &request.fixture {
        Some(response) => multi_position::into_fixture(found, response).map_err(|_| {
            Error::data("the accelerometer of the model has no mounting: its I + M is singular")
                .at("--start")
        })?,
        None => found,
    };
    Ok(MultiPositionOutcome {
        found,
        request: request.clone(),
        gravity_m_s2,
        samples: log.rows,
        dt_s,
        findings: faults::of(log),
    })
}

/// A time of the log.
fn clock(s: f64) -> String {
    if (0.0..36_000.0).contains(&s) {
        format!("{:.0}:{:04.1}", (s / 60.0).floor(), s % 60.0)
    } else {
        format!("{s:.1} s")
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_of_a_log() {
        assert_eq!(super::clock(582.34), "9:42.3");
    }
}
