//! `calibrate stations` in a terminal: what was found, the table, what was not determined, what to add.

use sagnac_calibrate::stations::{Group, Outcome, Parameter, Status, Term};
use sagnac_core::Sensor;
use sagnac_report::text::{Cell, Document, Estimate, Table, significant};

use super::StationsOutcome;
use super::json::rms;
use super::units::shown;

/// The word for a sensor at the head of a table.
pub(super) fn title(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Gyro => "Gyro",
        Sensor::Accel => "Accelerometer",
    }
}

/// The terms of a sensor that were estimated on any axis, in the order of the contract.
pub(super) fn terms_of(found: &Outcome, sensor: Sensor) -> Vec<Term> {
    terms_in(&found.parameters, sensor)
}

/// The terms of a sensor that were estimated on any axis, in their order.
pub(super) fn terms_in(parameters: &[Parameter], sensor: Sensor) -> Vec<Term> {
    let mut out: Vec<Term> = Vec::new();
    for p in parameters {
        if let Some(term) = p.term.filter(|_| p.sensor == sensor)
            && !out.contains(&term)
        {
            out.push(term);
        }
    }
    let groups = Group::of(sensor, 8, 8);
    out.sort_by_key(|t| (groups.iter().position(|g| *g == t.group), t.component));
    out
}

/// The sensors that have parameters, with their terms.
pub(super) fn rows_of(parameters: &[Parameter]) -> Vec<(Sensor, Vec<Term>)> {
    [Sensor::Accel, Sensor::Gyro]
        .into_iter()
        .map(|sensor| (sensor, terms_in(parameters, sensor)))
        .filter(|(_, terms)| !terms.is_empty())
        .collect()
}

/// The estimates of one term on x, y, z, in the unit shown.
pub(super) fn estimates(
    parameters: &[Parameter],
    sensor: Sensor,
    term: Term,
    factor: f64,
) -> [Estimate; 3] {
    [0, 1, 2].map(|k| {
        parameters
            .iter()
            .find(|p| p.sensor == sensor && p.axis == k && p.term == Some(term))
            .map_or(Estimate::Absent, |p| {
                Estimate::detected(p.value, p.lower, p.upper).scaled(factor)
            })
    })
}

/// An acceleration in µg or mg.
pub(super) fn in_g(value_m_s2: f64) -> String {
    let micro = value_m_s2 / 9.80665 * 1e6;
    if micro.abs() < 1000.0 {
        format!("{} ug", significant(micro, 2))
    } else {
        format!("{} mg", significant(micro / 1e3, 3))
    }
}

/// A row a term of a sensor, its axes beside each other.
pub(super) fn estimates_table(sensor: Sensor, terms: Vec<Term>, parameters: &[Parameter]) -> Table {
    let mut table = Table::estimates(&[title(sensor), "x", "y", "z", ""]);
    for term in terms {
        let shown = shown(sensor, term);
        let mut cells: Vec<Cell> = vec![shown.name.into()];
        cells.extend(estimates(parameters, sensor, term, shown.per_si).map(Cell::from));
        cells.push(shown.unit.into());
        table.row(cells);
    }
    table
}

impl StationsOutcome {
    /// What to add, in words.
    pub fn advice(&self) -> Vec<String> {
        advice(&self.found)
    }

    /// The result as a document.
    pub fn document(&self) -> Document {
        let found = &self.found;
        let mut out = Document::new();
        out.paragraph(self.verdict());
        for sensor in [Sensor::Accel, Sensor::Gyro] {
            let terms = terms_of(&self.found, sensor);
            if terms.is_empty() {
                continue;
            }
            let mut table = estimates_table(sensor, terms, &found.parameters);
            let stability: Vec<&Parameter> = found
                .parameters
                .iter()
                .filter(|p| p.sensor == sensor && p.term.is_none())
                .collect();
            if !stability.is_empty() {
                let shown = shown(
                    sensor,
                    Term {
                        group: Group::Bias,
                        component: 0,
                    },
                );
                let mut cells: Vec<Cell> = vec!["Bias stability".into()];
                for k in 0..3 {
                    let found = stability.iter().find(|p| p.axis == k);
                    cells.push(
                        found
                            .map_or(Estimate::Absent, |p| {
                                Estimate::detected(p.value, p.lower, p.upper).scaled(shown.per_si)
                            })
                            .into(),
                    );
                }
                cells.push(shown.unit.into());
                table.row(cells);
            }
            out.blank();
            out.table(table);
        }
        out.blank();
        out.paragraph(self.remarks());
        out.paragraph(self.not_determined());
        for (a, b, r) in found.confused.iter().take(4) {
            out.note(format!(
                "{a} and {b} can hardly be told apart (correlation {})",
                significant(*r, 3)
            ));
        }
        for note in &self.notes {
            out.note(note.clone());
        }
        for text in self.advice() {
            out.hanging("add: ", text);
        }
        out
    }

    pub(super) fn verdict(&self) -> String {
        let found = &self.found;
        let mut parts = Vec::new();
        for sensor in [Sensor::Accel, Sensor::Gyro] {
            let count = found
                .parameters
                .iter()
                .filter(|p| p.sensor == sensor)
                .count();
            if count > 0 {
                parts.push(format!(
                    "{count} parameters of the {}",
                    title(sensor).to_lowercase()
                ));
            }
        }
        let mut out = format!(
            "{} stations determine {}.",
            self.stations.len(),
            parts.join(" and ")
        );
        if let (Some(before), Some(after)) = (rms(&found.before_m_s2), rms(&found.after_m_s2)) {
            out.push_str(&format!(
                " |f| - g {} from {} to {} rms.",
                if after <= before { "falls" } else { "goes" },
                in_g(before),
                in_g(after)
            ));
        }
        let scaled: Vec<&str> = found
            .fits
            .iter()
            .filter(|f| f.scaled && f.p.is_some())
            .map(|f| f.axis.as_str())
            .collect();
        let p = found.fits.iter().filter_map(|f| f.p).fold(1.0, f64::min);
        if !scaled.is_empty() {
            out.push_str(&format!(
                " The stations scatter more than their standard errors ({}): the intervals are widened.",
                scaled.join(", ")
            ));
        } else if found.fits.iter().any(|f| f.p.is_some()) {
            out.push_str(&format!(
                " The residuals are as large as the noise says (p = {}).",
                significant(p, 2)
            ));
        } else if !found.has_errors.contains(&true) {
            out.push_str(" No standard errors were given: the intervals are from the scatter.");
        }
        out
    }

    pub(super) fn remarks(&self) -> String {
        let mut out = String::new();
        if self
            .found
            .parameters
            .iter()
            .any(|p| p.term.is_some_and(|t| t.group == Group::Misalignment))
        {
            out.push_str("Misalignment and cross-axis response together. ");
        }
        out.push_str(&format!("Gravity {}.", self.gravity_words()));
        out
    }

    pub(super) fn gravity_words(&self) -> String {
        let from = match (self.request.gravity_m_s2, self.request.latitude_rad) {
            (Some(_), _) => "as given",
            (None, Some(_)) => "from latitude and height",
            (None, None) => "(standard gravity: no place was given)",
        };
        format!("{:.5} m/s^2 {from}", self.options.gravity_m_s2)
    }

    pub(super) fn not_determined(&self) -> String {
        not_determined(&self.found)
    }
}

/// What to add to a table, in words.
pub(super) fn advice(found: &Outcome) -> Vec<String> {
    let mut out = Vec::new();
    for addition in &found.additions {
        let words: Vec<&str> = addition.bundles.iter().map(|b| b.words.as_str()).collect();
        // Of a term that several additions share, each names its axes.
        let others = |of: &str| {
            found
                .additions
                .iter()
                .filter(|a| a.resolves.iter().any(|n| stem(n) == of))
                .count()
                > 1
        };
        out.push(format!(
            "{} -> {}",
            words.join("; "),
            short_beside(&addition.resolves, others)
        ));
    }
    if !found.hopeless.is_empty() {
        out.push(format!(
                "no single station of rest, spin, angular acceleration, 5 g or +-20 K gives {}: average longer",
                short(&found.hopeless)
            ));
    }
    for available in &found.available {
        if let Some(p) = available.p.filter(|p| *p < 0.001) {
            out.push(format!(
                "{}: the residuals ask for it (p = {}); add --terms +{}",
                available.name,
                significant(p, 2),
                available.group.key()
            ));
        }
    }
    out
}

/// The groups not determined, with the reason in words.
pub(super) fn not_determined(found: &Outcome) -> String {
    let mut groups: Vec<(String, Vec<String>, Status, bool)> = Vec::new();
    for held in found.held.iter().filter(|h| h.asked) {
        let stem = stem(&held.name);
        match groups
            .iter_mut()
            .find(|g| g.0 == stem && g.2 == held.status)
        {
            Some(group) => group.1.push(held.name.clone()),
            None => groups.push((
                stem,
                vec![held.name.clone()],
                held.status,
                held.group == Group::AxisOffset,
            )),
        }
    }
    if groups.is_empty() {
        return "Every term that was asked for is determined.".to_owned();
    }
    let words: Vec<String> = groups
        .iter()
        .map(|(name, names, status, offset)| {
            let reason = match status {
                Status::NoInput if *offset => "no rotation",
                Status::NoInput => "no such input",
                Status::Aliased => "looks like other terms here",
                _ => "too weak an input",
            };
            let name = group_name(name, names, |stem| {
                found.parameters.iter().any(|p| self::stem(&p.name) == stem)
            });
            format!("{name} ({reason})")
        })
        .collect();
    format!("Not determined: {}.", words.join(", "))
}

/// A path without its axis.
pub(crate) fn stem(name: &str) -> String {
    name.trim_end_matches(['x', 'y', 'z'])
        .trim_end_matches('.')
        .trim_end_matches(".x")
        .trim_end_matches(".y")
        .trim_end_matches(".z")
        .to_owned()
}

/// Whether a temperature term is one that a spline among `names` stands for.
pub(crate) fn has_spline(names: &[String], name: &str) -> bool {
    name.split_once(".temperature.").is_some_and(|(of, _)| {
        let row = format!("{of}.temperature_spline.");
        names.iter().any(|n| n.starts_with(&row))
    })
}

/// What names of one stem are called together: of a term that other axes determine, with the axes that are missing.
pub(super) fn group_name(
    stem: &str,
    names: &[String],
    is_estimated: impl Fn(&str) -> bool,
) -> String {
    match names {
        [one] => one.clone(),
        _ if is_estimated(stem) => {
            let axes: Vec<&str> = names.iter().filter_map(|n| n.rsplit('.').next()).collect();
            format!("{stem}.{}", axes.join("/"))
        }
        _ => stem.to_owned(),
    }
}

/// Names with their axes gathered.
pub(super) fn short(names: &[String]) -> String {
    short_beside(names, |_| false)
}

/// Names with their axes gathered; of terms that other axes determine, with the axes.
pub(crate) fn short_beside(names: &[String], is_estimated: impl Fn(&str) -> bool) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for name in names {
        let stem = stem(name);
        match groups.iter_mut().find(|g| g.0 == stem) {
            Some(group) => group.1.push(name.clone()),
            None => groups.push((stem, vec![name.clone()])),
        }
    }
    let words: Vec<String> = groups
        .iter()
        .map(|(stem, names)| group_name(stem, names, &is_estimated))
        .collect();
    words.join(", ")
}
