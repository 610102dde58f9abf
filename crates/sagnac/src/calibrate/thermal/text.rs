//! `calibrate thermal` in a terminal: what was swept, curves in words, hysteresis, what is not known.

use sagnac_calibrate::thermal::{Curve, Kind, channel};
use sagnac_core::Sensor;
use sagnac_report::text::{Cell, Document, Estimate, Finding, Table, significant};

use super::ThermalOutcome;
use crate::calibrate::text::{short_beside, stem, title};
use crate::findings::{finding, gathered};

/// Unit in which a curve is shown, and how many of it make the SI unit.
pub(super) fn shown(curve: &Curve) -> (&'static str, f64) {
    match (curve.kind, curve.sensor) {
        (Kind::ScaleFactor, _) => ("ppm", 1e6),
        (_, Sensor::Gyro) => ("deg/h", 3600f64.to_degrees()),
        (_, Sensor::Accel) => ("mg", 1e3 / 9.80665),
    }
}

/// Whole degrees; zero has no sign.
pub(super) fn degrees(t_c: f64) -> String {
    format!("{:.0}", t_c.round() + 0.0)
}

impl ThermalOutcome {
    /// What to add, in words.
    pub fn advice(&self) -> Vec<String> {
        let found = &self.found;
        let mut out = Vec::new();
        let heating = found.branches.iter().filter(|b| b.is_heating).count();
        if heating == 0 || heating == found.branches.len() {
            out.push("a sweep in the other direction -> hysteresis".to_owned());
        }
        if found.curves.iter().any(|c| c.sensor == Sensor::Accel)
            && !found.curves.iter().any(|c| c.kind == Kind::ScaleFactor)
        {
            out.push(
                "a sweep with the other side up, --up +z,-z -> accel.scale_factor.temperature"
                    .to_owned(),
            );
        }
        if found.soaks.is_empty() {
            out.push(
                "soaks of 10 min at some temperatures -> the sensor without the lag of its ramp"
                    .to_owned(),
            );
        }
        out
    }

    pub(super) fn verdict(&self) -> String {
        let found = &self.found;
        let [low, high] = found.range_c;
        let mut out = format!(
            "{} sweep{} between {low:.1} and {high:.1} degC ({}).",
            found.branches.len(),
            if found.branches.len() == 1 { "" } else { "s" },
            found
                .branches
                .iter()
                .map(|b| if b.is_heating { "heating" } else { "cooling" })
                .collect::<Vec<_>>()
                .join(", ")
        );
        let worst = found
            .curves
            .iter()
            .filter(|c| c.kind == Kind::Bias)
            .filter_map(|c| c.hysteresis.map(|h| (c, h)))
            .max_by(|a, b| {
                let share = |c: &Curve, h: f64| h / span(c).max(1e-300);
                share(a.0, a.1.largest).total_cmp(&share(b.0, b.1.largest))
            });
        if let Some((curve, h)) = worst {
            let (unit, factor) = shown(curve);
            out.push_str(&format!(
                " Heating and cooling differ the most on {}: {} {unit} at {} degC.",
                channel(curve.sensor, curve.axis),
                significant(h.largest * factor, 2),
                degrees(h.at_c)
            ));
        }
        out
    }

    /// The result as a document.
    pub fn document(&self) -> Document {
        let found = &self.found;
        let mut out = Document::new();
        out.paragraph(self.verdict());
        for sensor in [Sensor::Accel, Sensor::Gyro] {
            for kind in [Kind::Bias, Kind::ScaleFactor] {
                self.table(sensor, kind, &mut out);
            }
        }
        out.blank();
        out.paragraph(format!(
            "± is half the 95 % interval of the curve. Residual: all samples, against the curve with hysteresis and \
             without. Outside {:.1} … {:.1} degC nothing is known: the model holds the nearer end, and correct flags it.",
            found.range_c[0], found.range_c[1]
        ));
        out.findings(self.findings());
        if !found.held.is_empty() {
            out.paragraph(format!("Not determined: {}.", self.held()));
        }
        for note in &found.notes {
            out.note(note.clone());
        }
        for text in self.advice() {
            out.hanging("add: ", text);
        }
        out
    }

    /// What was left out.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let logs = self.issues.iter().zip(&self.logs);
        let lines = logs.flat_map(|((issues, first_s, duration_s), log)| {
            issues.iter().map(move |issue| {
                let mut line = finding(issue, *first_s, *duration_s);
                if self.logs.len() > 1 {
                    line.text = format!("{log}: {}", line.text);
                }
                line
            })
        });
        gathered(lines.collect())
    }

    /// Names held at zero, axes gathered.
    pub(super) fn held(&self) -> String {
        short_beside(&self.found.held, |s| {
            self.found.parameters.iter().any(|p| stem(&p.name) == s)
        })
    }

    fn table(&self, sensor: Sensor, kind: Kind, out: &mut Document) {
        let curves: Vec<&Curve> = self
            .found
            .curves
            .iter()
            .filter(|c| c.sensor == sensor && c.kind == kind)
            .collect();
        let Some(first) = curves.first() else {
            return;
        };
        let (unit, factor) = shown(first);
        let head = match kind {
            Kind::Bias => title(sensor).to_owned(),
            Kind::ScaleFactor => format!("{}, scale factor", title(sensor)),
        };
        let mut table = Table::estimates(&[&head, "x", "y", "z", ""]);
        let of = |k: usize| curves.iter().find(|c| c.axis == k).copied();
        let n = first.temperature_c.len();
        for i in (0..n).step_by((n - 1) / 4) {
            let mut cells: Vec<Cell> =
                vec![format!("at {} degC", degrees(first.temperature_c[i])).into()];
            cells.extend((0..3).map(|k| {
                Cell::from(of(k).map_or(Estimate::Absent, |c| {
                    Estimate::detected(c.value[i], c.lower[i], c.upper[i]).scaled(factor)
                }))
            }));
            cells.push(unit.into());
            table.row(cells);
        }
        let mut plain = |name: &str, unit: &str, value: &dyn Fn(&Curve) -> String| {
            let mut cells: Vec<Cell> = vec![name.into()];
            cells.extend((0..3).map(|k| Cell::from(of(k).map_or("-".to_owned(), value))));
            cells.push(unit.into());
            table.row(cells);
        };
        if first.hysteresis.is_some() {
            plain("Hysteresis, largest", unit, &|c| {
                c.hysteresis
                    .map_or("-".to_owned(), |h| significant(h.largest * factor, 2))
            });
        }
        if kind == Kind::Bias {
            plain("Residual", unit, &|c| {
                significant(c.residual_rms * factor, 3)
            });
            plain("  without hysteresis", unit, &|c| {
                significant(c.residual_rms_single * factor, 3)
            });
        }
        plain("Form", "", &|c| {
            if c.is_spline {
                format!("{} knots", c.order)
            } else {
                format!("order {}", c.order)
            }
        });
        out.blank();
        out.table(table);
    }
}

/// Extent of a curve.
fn span(curve: &Curve) -> f64 {
    let [low, high] = curve
        .value
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
            [a.min(*v), b.max(*v)]
        });
    high - low
}
