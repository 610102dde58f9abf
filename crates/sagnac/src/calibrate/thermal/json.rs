//! The JSON of `calibrate thermal`.

use sagnac_calibrate::thermal::{Curve, Stretch, channel};
use serde_json::{Value, json};

use super::ThermalOutcome;
use crate::calibrate::json::unit;
use crate::findings::issue_json;

/// Numbers with null where there is none.
fn numbers(values: &[f64]) -> Vec<Value> {
    values
        .iter()
        .map(|v| if v.is_finite() { json!(v) } else { Value::Null })
        .collect()
}

fn curve(curve: &Curve) -> Value {
    json!({
        "axis": channel(curve.sensor, curve.axis),
        "kind": curve.kind.key(),
        "form": if curve.is_spline { "spline" } else { "polynomial" },
        "order": curve.order,
        "temperature": curve.temperature_c,
        "value": curve.value,
        "sigma": curve.sigma,
        "lower": numbers(&curve.lower),
        "upper": numbers(&curve.upper),
        "heating_minus_cooling": curve.heating_minus_cooling,
        "hysteresis": curve.hysteresis.map(|h| json!({
            "max": h.largest, "at": h.at_c, "at_reference_temperature": h.at_reference,
        })),
        "cv_rms": numbers(&curve.cv_rms),
        "cv_rms_spline": numbers(&curve.cv_rms_spline),
        "residual_rms": curve.residual_rms,
        "residual_rms_single": curve.residual_rms_single,
        "neighbour_correlation": curve.correlation,
    })
}

impl ThermalOutcome {
    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let found = &self.found;
        let stretch = |s: &Stretch| {
            json!({ "log": self.logs.get(s.log), "start_s": s.start_s, "end_s": s.end_s,
                    "temperature": s.temperature_c })
        };
        json!({
            "model": self.to_model().map_or(Value::Null, |m| m.to_json()),
            "parameters": found.parameters.iter().map(|p| json!({
                "name": p.name, "value": p.value, "sigma": p.sigma, "lower": p.lower, "upper": p.upper,
                "unit": unit(&p.name),
            })).collect::<Vec<_>>(),
            "residual_rms": { "accel": found.residual_rms[1], "gyro": found.residual_rms[0] },
            "unobservable": found.held,
            "confused": Vec::<Value>::new(),
            "advice": self.advice(),
            "notes": found.notes,
            "issues": self.issues.iter().zip(&self.logs).flat_map(|((issues, ..), log)| {
                issues.iter().map(move |issue| {
                    let mut out = issue_json(issue);
                    out["log"] = json!(log);
                    out
                })
            }).collect::<Vec<_>>(),
            "temperature_range": found.range_c,
            "branches": found.branches.iter().map(|b| {
                let mut out = stretch(b);
                out["direction"] = json!(if b.is_heating { "heating" } else { "cooling" });
                out
            }).collect::<Vec<_>>(),
            "soaks": found.soaks.iter().map(stretch).collect::<Vec<_>>(),
            "curves": found.curves.iter().map(curve).collect::<Vec<_>>(),
            "covariance": {
                "names": found.parameters.iter().map(|p| &p.name).collect::<Vec<_>>(),
                "matrix": found.covariance,
            },
            "gravity": self.options.gravity_m_s2,
            "reference_temperature": self.options.reference_temperature_c,
        })
    }
}
