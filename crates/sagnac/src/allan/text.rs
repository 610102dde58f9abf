//! The text of `allan`: a row an averaging time, a column an axis.

use std::fmt::Write as _;

use sagnac_analysis::{Deviation, Estimate, TauGrid};
use sagnac_log::Quantity;
use sagnac_report::text::{Align, Document, Table, Unit, general, group_thousands, significant};

use super::{AllanAxis, AllanOutcome};
use crate::findings::gathered;
use crate::issues;

/// Rows that a table shows at most where the grid was not chosen by the user.
const MOST_ROWS: usize = 40;

/// A unit that a column is shown in.
pub(super) struct Shown {
    pub(super) text: String,
    pub(super) page: String,
    pub(super) per_si: f64,
}

impl Shown {
    /// The field's unit of a deviation, or of the root of a density.
    pub(super) fn of(axis: &AllanAxis, outcome: &AllanOutcome) -> Self {
        let spectrum = outcome.request.spectrum;
        let phase = outcome.request.deviation == Deviation::Tdev && !spectrum;
        let unit = match axis.quantity {
            Quantity::AngularRate if spectrum => Unit::DEG_PER_S_PER_SQRT_HZ,
            Quantity::AngularRate if phase => Unit::ARCSEC,
            Quantity::AngularRate => Unit::DEG_PER_H,
            Quantity::SpecificForce if spectrum => Unit::MICRO_G_PER_SQRT_HZ,
            Quantity::SpecificForce if phase => Unit::MM_PER_S,
            Quantity::SpecificForce => Unit::MICRO_G,
            _ => {
                let own = if spectrum {
                    format!("{}/√Hz", axis.unit)
                } else {
                    super::json::deviation_unit(axis, outcome)
                };
                return Self {
                    text: own.clone(),
                    page: own,
                    per_si: 1.0,
                };
            }
        };
        Self {
            text: unit.text.to_owned(),
            page: unit.page.to_owned(),
            per_si: unit.per_si,
        }
    }
}

impl AllanOutcome {
    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        document.paragraph(self.opening());
        document.blank();
        if self.request.spectrum {
            document.table(self.spectrum_table());
        } else {
            document.table(self.deviation_table());
        }
        document.blank();
        for axis in self.axes.iter().filter(|axis| axis.is_empty()) {
            document.warning(format!("{} has too few samples for numbers", axis.axis));
        }
        let duration_s = self.duration_s();
        let lines = self
            .issues
            .iter()
            .map(|issue| issues::to_finding(issue, self.origin_s, duration_s));
        document.findings(gathered(lines.collect()));
        for note in &self.notes {
            document.note(note.clone());
        }
        let mut curves = self.axes.iter().filter_map(|axis| axis.curve.as_ref());
        if self.request.deviation == Deviation::Totdev
            && curves.any(|curve| curve.edf.iter().any(Option::is_none))
        {
            document.note(
                "no interval where the noise is that of the angle or velocity (alpha 1, 2): \
                 the degrees of freedom of totdev are not known there"
                    .to_owned(),
            );
        }
        document.blank();
        if self.request.spectrum {
            document.paragraph(
                "One-sided: white noise shows √2 N. All frequencies: -o spectrum.csv; picture: \
                 -o spectrum.svg",
            );
        } else {
            document.paragraph(
                "Intervals and all averaging times: -o curve.csv; picture: -o curve.svg",
            );
        }
        document
    }

    /// The sentence that says what stands below.
    fn opening(&self) -> String {
        let what = if self.request.spectrum {
            "One-sided noise density (Welch)".to_owned()
        } else {
            capitalized(self.request.deviation.full_name())
        };
        let mut text = format!(
            "{what} of {} samples at {} Hz",
            group_thousands(&self.samples.to_string()),
            general(1.0 / self.dt_s, 6)
        );
        if self.segments > 1 {
            let _ = write!(text, ", {} stretches pooled", self.segments);
        }
        text.push('.');
        if self.estimate == Estimate::Strided {
            text.push_str(" Strided: starts at least every τ/64.");
        }
        if let Some(windows) = self.axes.iter().find_map(|axis| axis.windows.as_ref()) {
            let _ = write!(text, " {} windows in JSON (--format json).", windows.len());
        }
        text
    }

    fn blank_table(&self, first: &str) -> (Table, Vec<(&AllanAxis, Shown)>) {
        let axes: Vec<(&AllanAxis, Shown)> = self
            .axes
            .iter()
            .filter(|axis| !axis.is_empty())
            .map(|axis| (axis, Shown::of(axis, self)))
            .collect();
        let mut heading = vec![first];
        heading.extend(axes.iter().map(|(axis, _)| axis.axis.as_str()));
        let mut table = Table::new(&heading, &vec![Align::Right; heading.len()]);
        let mut units = vec![String::new()];
        units.extend(axes.iter().map(|(_, shown)| shown.text.clone()));
        table.row(units);
        (table, axes)
    }

    fn deviation_table(&self) -> Table {
        let (mut table, axes) = self.blank_table("tau, s");
        for tau_s in self.rows() {
            let mut cells = vec![general(tau_s, 4)];
            cells.extend(axes.iter().map(|(axis, shown)| {
                axis.curve
                    .as_ref()
                    .and_then(|curve| {
                        let k = curve.tau_s.iter().position(|t| is_same(*t, tau_s))?;
                        Some(significant(curve.deviation[k] * shown.per_si, 4))
                    })
                    .unwrap_or_else(|| "-".to_owned())
            }));
            table.row(cells);
        }
        table
    }

    /// Averaging times of the table: all that were asked for by name, else one a decade. Of axes at other intervals those
    /// that all have, and where there are none near, those of each.
    fn rows(&self) -> Vec<f64> {
        let mut grids: Vec<&[f64]> = Vec::new();
        for curve in self.axes.iter().filter_map(|axis| axis.curve.as_ref()) {
            if !grids.contains(&curve.tau_s.as_slice()) {
                grids.push(&curve.tau_s);
            }
        }
        let most = grids.iter().map(|g| g.len()).max().unwrap_or(0);
        let is_chosen = matches!(self.request.taus, TauGrid::Octave | TauGrid::Times(_));
        let mut rows: Vec<f64> = if is_chosen && most <= MOST_ROWS {
            grids.concat()
        } else {
            a_decade(&grids)
        };
        rows.sort_by(f64::total_cmp);
        rows.dedup_by(|a, b| is_same(*a, *b));
        rows
    }

    fn spectrum_table(&self) -> Table {
        let (mut table, axes) = self.blank_table("f, Hz");
        let Some(first) = axes.iter().find_map(|(axis, _)| axis.density.as_ref()) else {
            return table;
        };
        // A row an octave from the top: the root of the mean density of that octave.
        let nyquist_hz = first.frequency_hz.last().copied().unwrap_or(0.0);
        let lowest_hz = first.frequency_hz.first().copied().unwrap_or(1.0);
        let mut high_hz = nyquist_hz;
        let mut rows = Vec::new();
        while high_hz >= lowest_hz && rows.len() < MOST_ROWS {
            let low_hz = high_hz / 2.0;
            let mut cells = vec![format!(
                "{} - {}",
                general(low_hz.max(lowest_hz), 3),
                general(high_hz, 3)
            )];
            cells.extend(axes.iter().map(|(axis, shown)| {
                let values: Vec<f64> = axis
                    .density
                    .iter()
                    .flat_map(|d| d.frequency_hz.iter().zip(&d.density))
                    .filter(|(f, _)| **f > low_hz && **f <= high_hz)
                    .map(|(_, density)| *density)
                    .collect();
                if values.is_empty() {
                    return "-".to_owned();
                }
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                significant(mean.sqrt() * shown.per_si, 3)
            }));
            rows.push(cells);
            high_hz = low_hz;
        }
        for cells in rows.into_iter().rev() {
            table.row(cells);
        }
        table
    }
}

/// Whether two averaging times are one, but for rounding.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b
}

/// An averaging time a decade: one that all grids have, where there is one near, else one of each.
fn a_decade(grids: &[&[f64]]) -> Vec<f64> {
    /// Half a decade away another row is nearer.
    const NEAR: f64 = 2.5;
    let first = grids.iter().filter_map(|g| g.first()).copied();
    let last = grids.iter().filter_map(|g| g.last()).copied();
    let mut wanted = first.fold(f64::INFINITY, f64::min);
    let last = last.fold(0.0, f64::max);
    let mut rows = Vec::new();
    while wanted <= last * 1.1 {
        let far = |t: f64| (t / wanted).ln().abs();
        let nearest =
            |among: &mut dyn Iterator<Item = f64>| among.min_by(|a, b| far(*a).total_cmp(&far(*b)));
        let in_all = |t: &f64| {
            grids
                .iter()
                .all(|g| g.iter().any(|other| is_same(*other, *t)))
        };
        let mut common = grids
            .first()
            .map_or(&[][..], |g| g)
            .iter()
            .copied()
            .filter(in_all);
        match nearest(&mut common).filter(|t| grids.len() == 1 || far(*t) < NEAR.ln()) {
            Some(tau_s) => rows.push(tau_s),
            None => rows.extend(
                grids
                    .iter()
                    .filter_map(|g| nearest(&mut g.iter().copied()))
                    .filter(|t| far(*t) < NEAR.ln()),
            ),
        }
        wanted *= 10.0;
    }
    rows
}

pub(crate) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().collect::<String>() + letters.as_str(),
        None => String::new(),
    }
}
