//! `calibrate plan`: a table of stations to fill in, with the standard error that each parameter will reach.

mod noise;
mod text;
mod wanted;

use sagnac_calibrate::plan::{
    self, Errors, centrifuge, chamber, rate_table, six_position, tumble24,
};
use sagnac_calibrate::stations::{Asked, Group, Options, Outcome, Station};
use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_model::units::format_number;
use serde_json::{Value, json};

use self::noise::Noise;
use self::wanted::Wanted;
use super::json::station;
use crate::Error;

/// What is to be tested.
#[derive(Clone, Debug)]
pub enum Tested {
    /// A test by name: `six-position`, `tumble24`, `rate-table`, `centrifuge`, `chamber`.
    Name(String),
    /// The sensor of a model: every term that it has.
    Model(Box<Model>),
}

/// What `calibrate plan` is asked.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// Which test.
    pub tested: Tested,
    /// The sensor whose noise counts.
    pub noise: Option<Model>,
    /// Length of a dwell \[s\]; 60 s where not given.
    pub dwell_s: Option<f64>,
    /// Standard error of an accelerometer mean \[m/s²\].
    pub accel_se_m_s2: Option<f64>,
    /// Standard error of a gyro mean \[rad/s\].
    pub gyro_se_rad_s: Option<f64>,
    /// Wanted standard errors: `accel.bias=1 mg, gyro.scale_factor=50 ppm`.
    pub precision: Option<String>,
    /// Largest rate of the rate table \[rad/s\].
    pub rate_max_rad_s: Option<f64>,
    /// Arm of the centrifuge \[m\]; 1 m where not given.
    pub radius_m: Option<f64>,
    /// Temperatures of the chamber \[°C\].
    pub temperatures_c: Option<Vec<f64>>,
    /// Groups of terms, as for `calibrate stations`.
    pub terms: Option<String>,
    /// T0 \[°C\]; 25 where not given.
    pub reference_temperature_c: Option<f64>,
    /// Latitude \[rad\].
    pub latitude_rad: Option<f64>,
    /// Height \[m\].
    pub height_m: Option<f64>,
    /// Gravity \[m/s²\].
    pub gravity_m_s2: Option<f64>,
    /// Standard error of the levelling \[rad\]; 0 where not given.
    pub tilt_rad: Option<f64>,
}

/// A planned test.
#[derive(Clone, Debug)]
pub struct PlanOutcome {
    /// What it is called.
    pub name: String,
    /// Stations, repeats one after the other.
    pub stations: Vec<Station>,
    /// What they will give.
    pub found: Outcome,
    /// Standard errors assumed of each mean.
    pub errors: Errors,
    /// Length of a dwell, where the noise is that of a model \[s\].
    pub dwell_s: Option<f64>,
    /// How often every station is taken.
    pub repeats: u32,
    /// What must be said.
    pub notes: Vec<String>,
}

/// Plans a test.
///
/// # Errors
/// An unknown name, a precision that is none, a model without deterministic terms.
pub fn plan(request: &PlanRequest) -> Result<PlanOutcome, Error> {
    let g = super::gravity(request.gravity_m_s2, request.latitude_rad, request.height_m)?;
    let mut options = Options {
        asked: Asked::default(),
        reference_temperature_c: request.reference_temperature_c.unwrap_or(25.0),
        gravity_m_s2: g,
        ..Options::default()
    };
    if let Some(terms) = &request.terms {
        options.asked = Asked::parse(terms).map_err(|error| {
            let mut error = Error::from(error);
            error.kind = crate::Kind::Usage;
            error
        })?;
    }
    let noise = Noise::of(request);
    let mut dwell_s = request.dwell_s.unwrap_or(60.0);
    let tilt = request.tilt_rad.unwrap_or(0.0);
    let mut errors = noise.errors(dwell_s, tilt);
    let mut wanted = Wanted::parse(request.precision.as_deref())?;
    let mut notes = Vec::new();
    let (name, mut stations) = match &request.tested {
        Tested::Name(name) => (name.clone(), by_name(name, request, g)?),
        Tested::Model(model) => {
            wanted.add_from(model)?;
            let (mut with, mut orders) = (Vec::new(), (1, 1));
            for group in wanted.groups() {
                match group {
                    Group::BiasTemperature(i) => orders.0 = orders.0.max(i),
                    Group::ScaleTemperature(i) => orders.1 = orders.1.max(i),
                    _ => {}
                }
                with.push(group.key());
            }
            (options.temperature_order, options.scale_temperature_order) = orders;
            if request.reference_temperature_c.is_none() {
                options.reference_temperature_c = model.reference_temperature_c();
            }
            if request.terms.is_none() {
                options.asked = Asked::Changed {
                    with,
                    without: Vec::new(),
                };
            }
            let mut start = tumble24(g);
            for station in &mut start {
                station.temperature_c = Some(options.reference_temperature_c);
            }
            let (stations, missed) = plan::design(start, &wanted.goals, errors, &options);
            if !missed.is_empty() && request.precision.is_none() {
                notes.push(format!(
                    "{} stations do not reach a tenth of {}: lengthen the dwells, or ask for less with --precision",
                    stations.len(),
                    super::text::short(&missed)
                ));
            }
            (model.name().to_owned(), stations)
        }
    };
    let mut repeats = 1;
    if request.precision.is_some() {
        let reached = wanted.lengthen(&stations, &noise, dwell_s, tilt, &options);
        dwell_s = reached.dwell_s;
        repeats = reached.repeats;
        errors = noise.errors(dwell_s, tilt);
        notes.extend(reached.notes);
    }
    let once = stations.clone();
    for number in 2..=repeats {
        stations.extend(once.iter().map(|s| Station {
            label: format!("{}, repeat {number}", s.label),
            ..s.clone()
        }));
    }
    if stations
        .iter()
        .all(|s| s.temperature_c == Some(options.reference_temperature_c))
    {
        for station in &mut stations {
            station.temperature_c = None;
        }
    }
    let found = plan::predict(&stations, errors, &options)?;
    Ok(PlanOutcome {
        name,
        stations,
        found,
        errors,
        dwell_s: noise.knows_dwell().then_some(dwell_s),
        repeats,
        notes,
    })
}

/// Names of the built-in tests.
pub const NAMES: [&str; 5] = [
    "six-position",
    "tumble24",
    "rate-table",
    "centrifuge",
    "chamber",
];

fn by_name(name: &str, request: &PlanRequest, g: f64) -> Result<Vec<Station>, Error> {
    let range = || {
        let model = request.noise.as_ref()?;
        let range = model.triad("gyro.range")?;
        Some(0.9 * range.into_iter().fold(f64::INFINITY, f64::min))
    };
    Ok(match name {
        "six-position" => six_position(g),
        "tumble24" => tumble24(g),
        "rate-table" => {
            let largest = request
                .rate_max_rad_s
                .or_else(range)
                .unwrap_or(200f64.to_radians());
            rate_table(g, largest)
        }
        "centrifuge" => centrifuge(g, request.radius_m.unwrap_or(1.0)),
        "chamber" => {
            let usual = vec![-20.0, 0.0, 20.0, 40.0, 60.0];
            chamber(g, request.temperatures_c.as_ref().unwrap_or(&usual))
        }
        _ => {
            return Err(
                Error::usage(format!("`{name}` is no test and no model file"))
                    .at(name.to_owned())
                    .advise(format!("the tests are {}", NAMES.join(", "))),
            );
        }
    })
}

impl PlanOutcome {
    /// The table: references filled in, outputs empty.
    pub fn to_csv(&self) -> String {
        let any = |pick: fn(&Station) -> bool| self.stations.iter().any(pick);
        let turns = any(|s| s.wdot != [0.0; 3]);
        let warm = any(|s| s.temperature_c.is_some());
        let mut header: Vec<String> = vec!["station".to_owned()];
        let xyz = |name: &str, unit: &str| ["x", "y", "z"].map(|a| format!("{name}_{a} [{unit}]"));
        header.extend(xyz("f", "m/s^2"));
        header.extend(xyz("w", "rad/s"));
        if turns {
            header.extend(xyz("wdot", "rad/s^2"));
        }
        if warm {
            header.push("temperature [degC]".to_owned());
        }
        if self.errors.tilt_rad > 0.0 {
            header.push("tilt_se [rad]".to_owned());
        }
        if self.dwell_s.is_some() {
            header.push("dwell [s]".to_owned());
        }
        header.extend(xyz("accel", "m/s^2"));
        header.extend(xyz("gyro", "rad/s"));
        let mut out = header.join(",");
        out.push('\n');
        for s in &self.stations {
            let mut row = vec![quoted(&s.label)];
            row.extend(s.f.iter().chain(&s.w).map(|v| format_number(*v)));
            if turns {
                row.extend(s.wdot.iter().map(|v| format_number(*v)));
            }
            if warm {
                row.push(s.temperature_c.map_or_else(String::new, format_number));
            }
            if self.errors.tilt_rad > 0.0 {
                row.push(format_number(self.errors.tilt_rad));
            }
            if let Some(dwell) = self.dwell_s {
                row.push(format_number(dwell));
            }
            row.extend(std::iter::repeat_n(String::new(), 6));
            out.push_str(&row.join(","));
            out.push('\n');
        }
        out
    }

    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let found = &self.found;
        json!({
            "stations": self.stations.iter().map(station).collect::<Vec<_>>(),
            "predicted": found.parameters.iter().map(|p| json!({ "name": p.name, "sigma": p.sigma })).collect::<Vec<_>>(),
            "unobservable": found.held.iter().map(|h| &h.name).collect::<Vec<_>>(),
            "advice": self.advice(),
            "repeats": self.repeats,
            "dwell_s": self.dwell_s,
            "gyro_se": self.errors.gyro,
            "accel_se": self.errors.accel,
        })
    }

    /// What to say besides the numbers.
    fn advice(&self) -> Vec<String> {
        let mut out = super::text::advice(&self.found);
        out.extend(self.notes.iter().cloned());
        out
    }

    /// The largest standard error of a group of a sensor, for tests and tables.
    pub fn sigma(&self, sensor: Sensor, group: Group) -> Option<f64> {
        self.found
            .parameters
            .iter()
            .filter(|p| p.sensor == sensor && p.term.is_some_and(|t| t.group == group))
            .map(|p| p.sigma)
            .reduce(f64::max)
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
