//! The JSON of `allan`: lists over τ in SI.

use sagnac_analysis::Curve;
use sagnac_log::Quantity;
use serde_json::{Map, Value, json};

use super::{AllanAxis, AllanOutcome};
use crate::issues;

impl AllanOutcome {
    /// The result as scripts read it.
    pub fn to_json(&self) -> Value {
        let axes: Vec<Value> = self
            .axes
            .iter()
            .map(|axis| {
                if self.request.spectrum {
                    spectrum(axis)
                } else {
                    self.deviation(axis)
                }
            })
            .collect();
        json!({
            "axes": axes,
            "log": {
                "samples": self.samples,
                "rate_hz": 1.0 / self.dt_s,
                "duration_s": self.duration_s(),
                "issues": self.issues.iter().map(issues::to_json).collect::<Vec<_>>(),
            },
        })
    }

    fn deviation(&self, axis: &AllanAxis) -> Value {
        let mut out = Map::new();
        out.insert("axis".into(), json!(axis.axis));
        out.insert(
            "deviation_kind".into(),
            json!(self.request.deviation.name()),
        );
        out.insert("estimate".into(), json!(self.estimate.name()));
        out.insert("unit".into(), json!(deviation_unit(axis, self)));
        let lists = [
            "tau_s",
            "deviation",
            "lower",
            "upper",
            "alpha",
            "edf",
            "samples_used",
        ];
        match &axis.curve {
            Some(curve) => {
                for (name, list) in lists.iter().zip(columns(curve)) {
                    out.insert((*name).into(), list);
                }
                if let Some(unbiased) = &curve.deviation_unbiased {
                    out.insert("deviation_unbiased".into(), json!(unbiased));
                }
            }
            None => {
                for name in lists {
                    out.insert(name.into(), json!([]));
                }
            }
        }
        if let Some(windows) = &axis.windows {
            let windows: Vec<Value> = windows
                .iter()
                .map(|window| {
                    json!({
                        "start_s": window.start_s,
                        "end_s": window.end_s,
                        "tau_s": window.curve.tau_s,
                        "deviation": window.curve.deviation,
                    })
                })
                .collect();
            out.insert("windows".into(), json!(windows));
        }
        Value::Object(out)
    }
}

/// The lists of a curve, in the order of the keys.
fn columns(curve: &Curve) -> [Value; 7] {
    [
        json!(curve.tau_s),
        json!(curve.deviation),
        json!(curve.lower),
        json!(curve.upper),
        json!(curve.alpha),
        json!(curve.edf),
        json!(curve.samples_used),
    ]
}

fn spectrum(axis: &AllanAxis) -> Value {
    let (frequency_hz, density) = match &axis.density {
        Some(density) => (density.frequency_hz.as_slice(), density.density.as_slice()),
        None => (&[] as &[f64], &[] as &[f64]),
    };
    json!({
        "axis": axis.axis,
        "frequency_hz": frequency_hz,
        "density": density,
        "unit": density_unit(axis),
        "sides": "one",
    })
}

/// SI unit of a deviation: that of the axis, of its phase for tdev.
pub(super) fn deviation_unit(axis: &AllanAxis, outcome: &AllanOutcome) -> String {
    if outcome.request.deviation == sagnac_analysis::Deviation::Tdev {
        return match axis.quantity {
            Quantity::AngularRate => "rad".to_owned(),
            Quantity::SpecificForce => "m/s".to_owned(),
            Quantity::AngularAcceleration => "rad/s".to_owned(),
            _ => format!("{} s", axis.unit).trim().to_owned(),
        };
    }
    axis.unit.clone()
}

/// SI unit of a spectrum.
pub(super) fn density_unit(axis: &AllanAxis) -> String {
    match axis.quantity {
        Quantity::AngularRate => "rad^2/s".to_owned(),
        Quantity::SpecificForce => "m^2/s^3".to_owned(),
        Quantity::AngularAcceleration => "rad^2/s^3".to_owned(),
        _ => format!("({})^2/Hz", axis.unit),
    }
}
