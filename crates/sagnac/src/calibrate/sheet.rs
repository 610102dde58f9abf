//! What the certificates of all calibrations share: texts, tables of results, histograms, correlations, spelling.

use sagnac_calibrate::stations::{Parameter, Term};
use sagnac_core::Sensor;
use sagnac_report::html::{CertificatePage, Input, ResultRow, ResultTable};
use sagnac_report::plots::{Color, CorrelationMap, Histogram};
use sagnac_report::text::{Estimate, significant};

use super::json::{rms, unit};
use super::text::{in_g, title};
use super::units::shown;

/// What only the caller knows of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PageFacts {
    /// The command as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Inputs with their hashes.
    pub inputs: Vec<(String, String)>,
}

/// What the caller writes on a certificate; what is empty stays as a line to fill in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CertificateTexts {
    /// Item: name and serial number.
    pub item: String,
    /// Customer.
    pub customer: String,
    /// Number of the certificate.
    pub certificate: String,
}

/// What ± is on a certificate.
pub(super) const EXPANDED: &str =
    "± is the expanded uncertainty, k = 2, for a coverage of about 95 %";

/// A certificate with what is filled in alike for every method.
pub(super) fn blank(
    sensors: &[Sensor],
    texts: &CertificateTexts,
    facts: &PageFacts,
) -> CertificatePage {
    CertificatePage {
        title: match sensors {
            [Sensor::Accel] => "Accelerometer triad",
            [Sensor::Gyro] => "Gyro triad",
            _ => "Inertial measurement unit",
        }
        .to_owned(),
        number: texts.certificate.clone(),
        item: texts.item.clone(),
        customer: texts.customer.clone(),
        command: facts.command.clone(),
        version: facts.version.clone(),
        inputs: Input::all(&facts.inputs),
        ..CertificatePage::default()
    }
}

/// Coordinates of the laboratory.
pub(super) fn place(latitude_rad: Option<f64>, height_m: Option<f64>) -> String {
    let Some(phi) = latitude_rad.map(f64::to_degrees) else {
        return String::new();
    };
    let half = if phi < 0.0 { "S" } else { "N" };
    match height_m {
        Some(h) => format!("{:.2}° {half}, {h:.0} m", phi.abs()),
        None => format!("{:.2}° {half}", phi.abs()),
    }
}

/// The name of a row as scripts know it: the path without sensor and axis.
pub(super) fn term_key(sensor: Sensor, term: Term) -> String {
    let name = term.name(sensor, 0);
    super::text::stem(&name)
        .split_once('.')
        .map_or_else(String::new, |(_, key)| key.to_owned())
}

/// The results of every sensor with parameters: expanded uncertainty is twice the standard one, or Student's
/// quantile of it where that is wider.
pub(super) fn results(parameters: &[Parameter]) -> Vec<ResultTable> {
    super::text::rows_of(parameters)
        .into_iter()
        .map(|(sensor, terms)| ResultTable {
            heading: title(sensor).to_owned(),
            sensor: sensor.key().to_owned(),
            rows: terms
                .into_iter()
                .map(|term| row(parameters, sensor, term))
                .collect(),
        })
        .collect()
}

fn row(parameters: &[Parameter], sensor: Sensor, term: Term) -> ResultRow {
    let shown = shown(sensor, term);
    let of = |k: usize| {
        parameters
            .iter()
            .find(|p| p.sensor == sensor && p.axis == k && p.term == Some(term))
    };
    let si = (0..3)
        .find_map(of)
        .map_or_else(String::new, |p| unit(&p.name));
    ResultRow {
        name: shown.name,
        term: term_key(sensor, term),
        cells: [0, 1, 2].map(|k| {
            of(k).map_or(Estimate::Absent, |p| {
                let half = (2.0 * p.sigma).max((p.upper - p.lower) / 2.0);
                Estimate::plus_minus(p.value, half).scaled(shown.per_si)
            })
        }),
        unit: page_unit(shown.unit),
        si: (page_unit(&si), shown.per_si),
    }
}

/// Correlations of a covariance; none without parameters.
pub(super) fn correlations(names: &[String], covariance: &[Vec<f64>]) -> Option<CorrelationMap> {
    let of = |i: usize, j: usize| {
        let size = (covariance[i][i] * covariance[j][j]).sqrt();
        if size > 0.0 {
            covariance[i][j] / size
        } else {
            0.0
        }
    };
    (!names.is_empty()).then(|| CorrelationMap {
        names: names.to_vec(),
        matrix: (0..names.len())
            .map(|i| (0..names.len()).map(|j| of(i, j)).collect())
            .collect(),
    })
}

/// |f| − g before and after the correction.
pub(super) fn magnitudes(before_m_s2: &[f64], after_m_s2: &[f64]) -> Vec<Histogram> {
    [
        ("calibration-before", "Before", before_m_s2, Color::Fit),
        ("calibration-after", "After", after_m_s2, Color::Data),
    ]
    .into_iter()
    .filter_map(|(plot, caption, values, color)| {
        let rms = rms(values)?;
        let (unit, factor) = if rms > 1e-3 * 9.80665 {
            ("mg", 1e3 / 9.80665)
        } else {
            ("µg", 1e6 / 9.80665)
        };
        Some(Histogram {
            plot: plot.to_owned(),
            caption: caption.to_owned(),
            caption_rest: format!(": |f| − g, {} rms", page_words(&in_g(rms))),
            x_title: format!("|f| − g, {unit}"),
            values: values.iter().map(|v| v * factor).collect(),
            color,
        })
    })
    .collect()
}

/// A rate in °/h as a page shows it.
pub(super) fn rate_words(rad_s: f64) -> String {
    format!("{} °/h", significant(rad_s.to_degrees() * 3600.0, 2))
}

/// A unit of a terminal as on a page.
pub(super) fn page_unit(unit: &str) -> String {
    let mut out = unit
        .replace("deg", "°")
        .replace("^2", "²")
        .replace("^3", "³");
    for (from, to) in [("ug", "µg"), ("urad", "µrad")] {
        if let Some(rest) = out.strip_prefix(from) {
            out = format!("{to}{rest}");
        }
    }
    out
}

/// Terminal spelling as on a page.
pub(super) fn page_words(text: &str) -> String {
    let mut out = text
        .replace(" ug", " µg")
        .replace(" - g", " − g")
        .replace("m/s^2", "m/s²")
        .replace(" degC", " °C")
        .replace(" deg/", " °/");
    for end in [" ", ",", ".", ";"] {
        out = out.replace(&format!(" deg{end}"), &format!(" °{end}"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_calibrate::stations::Group;

    #[test]
    fn degrees_of_a_terminal_become_those_of_a_page() {
        assert_eq!(
            page_words("0.020 deg rms at 20 degC, 100 deg/s; 12 degrees of freedom"),
            "0.020 ° rms at 20 °C, 100 °/s; 12 degrees of freedom"
        );
    }

    #[test]
    fn a_row_is_called_as_its_path_without_sensor_and_axis() {
        for (sensor, group, component, key) in [
            (Sensor::Gyro, Group::Bias, 0, "bias"),
            (
                Sensor::Accel,
                Group::ScaleTemperature(1),
                0,
                "scale_factor.temperature.1",
            ),
            (Sensor::Gyro, Group::GSensitivity, 2, "g_sensitivity"),
            (Sensor::Gyro, Group::G2Sensitivity, 3, "g2_sensitivity"),
        ] {
            assert_eq!(term_key(sensor, Term { group, component }), key);
        }
    }
}
