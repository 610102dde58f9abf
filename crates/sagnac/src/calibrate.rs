//! `calibrate`: deterministic errors from tables of stations, as text, JSON, model file and certificate.

mod certificate;
mod from_log;
mod json;
mod merge;
mod model_file;
mod multi_position;
mod place;
mod plan;
mod sheet;
mod table;
mod text;
mod thermal;
mod units;

pub use merge::{MergeOutcome, MergeRequest, Unequal, merge};
pub use multi_position::{MultiPositionOutcome, MultiPositionRequest, multi_position};
pub use place::Place;
pub use plan::{NAMES as PLAN_NAMES, PlanOutcome, PlanRequest, Tested, plan};
pub use sheet::{CertificateTexts, PageFacts};
pub use thermal::{ThermalOutcome, ThermalRequest, thermal};

pub(crate) use text::{has_spline, short_beside, stem};

use place::place_gravity;

use sagnac_calibrate::stations::{self, Asked, Options, Outcome, Station, reference};

use self::table::Sort;
use crate::Error;
use crate::table::Table;

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
    pub texts: CertificateTexts,
}

/// What a schedule found in a log: `station`, start and end \[s\].
pub type FoundSpan = (String, f64, f64);

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
    /// Where the stations lie in the log, for those made from one.
    pub spans: Vec<FoundSpan>,
    /// What must be said about the references.
    pub notes: Vec<String>,
}

/// Estimates every term of a table of stations that it determines.
///
/// # Errors
/// A table that cannot be read or that contradicts itself, with line and advice.
pub fn stations(request: &StationsRequest) -> Result<StationsOutcome, Error> {
    let options = options(request)?;
    let table = Table::parse(&request.table, &request.label)?;
    let read = table::read(&table, Sort::Outputs, request, options.gravity_m_s2)?;
    let found = regress(&read.stations, &options, &request.label)?;
    Ok(StationsOutcome {
        found,
        stations: read.stations,
        request: request.clone(),
        options,
        spans: Vec::new(),
        notes: read.notes,
    })
}

/// As [`stations()`], with the outputs from a raw log: the request's table is a schedule of time spans with their
/// references, or of references alone, whose dwells are then found.
///
/// # Errors
/// As [`stations()`]; spans without samples; another number of dwells than the schedule has rows.
pub fn stations_from_log(
    request: &StationsRequest,
    reader: &mut dyn sagnac_log::LogReader,
) -> Result<StationsOutcome, Error> {
    let options = options(request)?;
    let table = Table::parse(&request.table, &request.label)?;
    let mut read = table::read(&table, Sort::Schedule, request, options.gravity_m_s2)?;
    let spans = from_log::fill(&mut read, request, reader)?;
    from_log::force_in_turns(&mut read, &options, &request.label)?;
    let found = regress(&read.stations, &options, &request.label)?;
    Ok(StationsOutcome {
        found,
        stations: read.stations,
        request: request.clone(),
        options,
        spans,
        notes: read.notes,
    })
}

fn options(request: &StationsRequest) -> Result<Options, Error> {
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
    Ok(Options {
        asked,
        temperature_order: request.temperature_order.unwrap_or(1),
        scale_temperature_order: request.scale_temperature_order.unwrap_or(1),
        reference_temperature_c: request.reference_temperature_c.unwrap_or(25.0),
        gravity_m_s2: gravity(request.gravity_m_s2, request.latitude_rad, request.height_m)?,
    })
}

fn regress(rows: &[Station], options: &Options, label: &str) -> Result<Outcome, Error> {
    stations::calibrate(rows, options).map_err(|error| {
        let error = Error::from(error);
        // A station's place begins with the name of its table already.
        if error.place.is_some() {
            error
        } else {
            error.at(label.to_owned())
        }
    })
}

/// Gravity of the request: given, from latitude and height, or standard.
fn gravity(
    given_m_s2: Option<f64>,
    latitude_rad: Option<f64>,
    height_m: Option<f64>,
) -> Result<f64, Error> {
    if let Some(latitude) = latitude_rad
        && latitude.abs() > std::f64::consts::FRAC_PI_2 + 1e-12
    {
        return Err(Error::data("the latitude lies beyond 90 deg")
            .at("--latitude")
            .advise("write for instance --latitude 46.5deg"));
    }
    match (given_m_s2, latitude_rad) {
        (Some(g), _) if g > 0.0 => Ok(g),
        (Some(_), _) => Err(Error::usage("gravity must be positive")
            .at("--gravity")
            .advise("write for instance --gravity '9.81 m/s^2'")),
        (None, Some(latitude)) => Ok(reference::gravity_m_s2(latitude, height_m.unwrap_or(0.0))),
        (None, None) if height_m.is_some() => {
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
