//! The CSV of `allan`: a row an axis and τ (or f), the JSON keys as columns.

use std::fmt::Write as _;

use super::{AllanAxis, AllanOutcome, json};

impl AllanOutcome {
    /// The whole table, in SI; cells without a number are empty.
    pub fn to_csv(&self) -> String {
        let mut out = String::new();
        if self.request.spectrum {
            out.push_str("axis,frequency_hz,density,unit\n");
            for axis in &self.axes {
                spectrum_rows(axis, &mut out);
            }
            return out;
        }
        let unbiased = self.axes.iter().any(|axis| {
            axis.curve
                .as_ref()
                .is_some_and(|curve| curve.deviation_unbiased.is_some())
        });
        out.push_str(
            "axis,deviation_kind,estimate,unit,tau_s,deviation,lower,upper,alpha,edf,samples_used",
        );
        out.push_str(if unbiased {
            ",deviation_unbiased\n"
        } else {
            "\n"
        });
        for axis in &self.axes {
            let Some(curve) = &axis.curve else { continue };
            let unit = json::deviation_unit(axis, self);
            for k in 0..curve.len() {
                let _ = write!(
                    out,
                    "{},{},{},{},{},{},{},{},{},{},{}",
                    cell(&axis.axis),
                    curve.kind.name(),
                    curve.estimate.name(),
                    cell(&unit),
                    curve.tau_s[k],
                    number(Some(curve.deviation[k])),
                    number(curve.lower[k]),
                    number(curve.upper[k]),
                    curve.alpha[k],
                    number(curve.edf[k]),
                    curve.samples_used[k],
                );
                if let Some(list) = &curve.deviation_unbiased {
                    let _ = write!(out, ",{}", number(list[k]));
                }
                out.push('\n');
            }
        }
        out
    }
}

fn spectrum_rows(axis: &AllanAxis, out: &mut String) {
    let Some(density) = &axis.density else { return };
    let unit = json::density_unit(axis);
    for (frequency_hz, value) in density.frequency_hz.iter().zip(&density.density) {
        let _ = writeln!(
            out,
            "{},{frequency_hz},{},{}",
            cell(&axis.axis),
            number(Some(*value)),
            cell(&unit)
        );
    }
}

/// The shortest decimal that reads back to the same bits; empty where there is none.
fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() => {
            if value != 0.0 && !(1e-4..1e15).contains(&value.abs()) {
                format!("{value:e}")
            } else {
                format!("{value}")
            }
        }
        _ => String::new(),
    }
}

/// A name as a cell.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
