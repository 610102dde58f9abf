//! `calibrate`: deterministic errors from tables of stations, as text, JSON, model file and certificate.

mod certificate;
mod json;
mod model_file;
mod table;
mod text;
mod units;

pub use certificate::PageFacts;

use sagnac_calibrate::stations::{self, Asked, Options, Outcome, Station, reference};

use crate::Error;

/// What `calibrate stations` is asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StationsRequest {
    /// The table, whole.
    pub table: String,
    /// What errors call it.
    pub label: String,
    /// Name and hash of the table, for the model file.
    pub source: Option<String>,
    /// Name of the model.
    pub name: String,
    /// `default`, `all`, a list of groups, `+name`, `-name`.
    pub terms: Option<String>,
    /// Powers of T − T0 of the bias; 1 where not given.
    pub temperature_order: Option<u8>,
    /// Powers of T − T0 of the scale factor; 1 where not given.
    pub scale_temperature_order: Option<u8>,
    /// T0; 25 °C where not given.
    pub reference_temperature_c: Option<f64>,
    /// Latitude of the laboratory \[rad\].
    pub latitude_rad: Option<f64>,
    /// Height of the laboratory \[m\].
    pub height_m: Option<f64>,
    /// Gravity \[m/s²\]; wins over latitude and height.
    pub gravity_m_s2: Option<f64>,
    /// Standard error of the levelling \[rad\]; 0.5° for `up` rows and 0 else where not given.
    pub tilt_rad: Option<f64>,
    /// Texts of the certificate.
    pub item: String,
    /// Customer.
    pub customer: String,
    /// Number of the certificate.
    pub certificate: String,
}

/// What a table of stations gave.
#[derive(Clone, Debug, PartialEq)]
pub struct StationsOutcome {
    /// The regression.
    pub found: Outcome,
    /// The stations as they were used.
    pub stations: Vec<Station>,
    /// What was asked.
    pub request: StationsRequest,
    /// Options of the regression.
    pub options: Options,
    /// What must be said about the references.
    pub notes: Vec<String>,
}

/// Estimates every term of a table of stations that it determines.
///
/// # Errors
/// A table that cannot be read or that contradicts itself, with line and advice.
pub fn stations(request: &StationsRequest) -> Result<StationsOutcome, Error> {
    let asked = request
        .terms
        .as_deref()
        .map(Asked::parse)
        .transpose()
        .map_err(|error| {
            let mut error = Error::from(error);
            error.kind = crate::Kind::Usage;
            error
        })?
        .unwrap_or_default();
    let options = Options {
        asked,
        temperature_order: request.temperature_order.unwrap_or(1),
        scale_temperature_order: request.scale_temperature_order.unwrap_or(1),
        reference_temperature_c: request.reference_temperature_c.unwrap_or(25.0),
        gravity_m_s2: gravity(request)?,
    };
    let read = table::read(request, options.gravity_m_s2)?;
    let found = stations::calibrate(&read.stations, &options).map_err(|error| {
        let error = Error::from(error);
        // A station's place begins with the name of its table already.
        if error.place.is_some() {
            error
        } else {
            error.at(request.label.clone())
        }
    })?;
    Ok(StationsOutcome {
        found,
        stations: read.stations,
        request: request.clone(),
        options,
        notes: read.notes,
    })
}

/// Gravity of the request: given, from latitude and height, or standard.
fn gravity(request: &StationsRequest) -> Result<f64, Error> {
    if let Some(latitude) = request.latitude_rad
        && latitude.abs() > std::f64::consts::FRAC_PI_2 + 1e-12
    {
        return Err(Error::data("the latitude lies beyond 90 deg")
            .at("--latitude")
            .advise("write for instance --latitude 46.5deg"));
    }
    match (request.gravity_m_s2, request.latitude_rad) {
        (Some(g), _) if g > 0.0 => Ok(g),
        (Some(_), _) => Err(Error::usage("gravity must be positive")
            .at("--gravity")
            .advise("write for instance --gravity '9.81 m/s^2'")),
        (None, Some(latitude)) => Ok(reference::gravity_m_s2(
            latitude,
            request.height_m.unwrap_or(0.0),
        )),
        (None, None) if request.height_m.is_some() => {
            Err(Error::usage("a height without a latitude gives no gravity")
                .at("--height")
                .advise("add --latitude, for instance --latitude 46.5deg"))
        }
        (None, None) => Ok(9.80665),
    }
}

impl From<stations::Error> for Error {
    fn from(error: stations::Error) -> Self {
        let mut out = Self::data(error.to_string());
        out.place = error.place();
        out.advice = error.advice();
        out
    }
}
