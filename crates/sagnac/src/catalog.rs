//! The sensor catalogue: which sensors meet a condition, what is known of one, several side by side.
//!
//! ```
//! use sagnac::catalog::{self, ListRequest};
//! use sagnac::model::Catalogue;
//!
//! let request = ListRequest {
//!     filter: Some("gyro.noise.angle_random_walk < 0.01 deg/sqrt(h)".parse()?),
//!     ..ListRequest::default()
//! };
//! let quiet = catalog::list(&Catalogue::embedded(), &request)?;
//! assert!(quiet.to_text().contains("HG9900"));
//! # Ok::<(), sagnac::Error>(())
//! ```

mod compare;
mod list;
mod show;

pub use compare::{CompareOutcome, CompareRow, compare};
pub use list::{ListOutcome, ListRequest, list};
pub use show::{ShowOutcome, show};

use sagnac_core::Sensor;
use sagnac_model::units::Dimension;
use sagnac_model::{Entry, Model, ParameterPath};
use sagnac_report::text::general;

/// The words of a parameter in a sentence, by its keys: `angle random walk`, `bias stability`.
fn words(path: ParameterPath) -> String {
    let keys = path.file_keys();
    let last = keys.last().copied().unwrap_or_default();
    let outer = keys.first().copied().unwrap_or_default().replace('_', " ");
    match last {
        "noise_density_one_sided" => "noise density, one-sided".to_string(),
        "coefficient" | "allan_minimum" => "bias instability".to_string(),
        "fixed" if outer == "bias" => "fixed bias".to_string(),
        "fixed" | "matrix" => outer,
        "temperature" => format!("{outer} per kelvin"),
        _ if outer == "noise" || keys.len() == 1 => last.replace('_', " "),
        _ => format!("{outer} {}", last.replace('_', " ")),
    }
}

/// `sqrt(h)` as the terminal shows it.
fn shown_unit(unit: &str) -> String {
    unit.replace("sqrt(h)", "√h")
        .replace("sqrt(Hz)", "√Hz")
        .replace("sqrt(s)", "√s")
}

/// A value of an entry in its own unit; of a tolerance (value 0, 1σ known) the σ.
fn shown_value(entry: &Entry, dimension: Dimension) -> String {
    let number = |value: f64| general(value / entry.unit.factor(), 6);
    match (entry.value, entry.sigma, entry.upper_limit) {
        (Some(0.0), Some(sigma), _) => format!("± {}", number(sigma)),
        (Some(value), Some(sigma), _) => format!("{} ± {}", number(value), number(sigma)),
        (Some(value), None, _) if dimension.is_absolute_temperature() => general(value, 6),
        (Some(value), None, _) => number(value),
        (None, _, Some(limit)) => format!("< {}", number(limit)),
        _ => "-".to_string(),
    }
}

/// The letter that a source begins with.
fn letter(entry: &Entry) -> &str {
    let source = entry.source.as_deref().unwrap_or_default();
    match source.split_once(':') {
        Some((letter, _)) if letter.len() == 1 => &source[..1],
        _ => "",
    }
}

/// The worst of the axes.
fn worst(of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    (0..3)
        .filter_map(of)
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

fn white_noise(model: &Model, sensor: Sensor) -> Option<f64> {
    worst(|axis| model.white_noise(sensor, axis)?.value)
}

fn floor(model: &Model, sensor: Sensor) -> Option<f64> {
    worst(|axis| model.instability_floor(sensor, axis))
}

fn stability(model: &Model, sensor: Sensor) -> Option<f64> {
    worst(|axis| model.under(sensor, "bias.stability", axis)?.value)
}
