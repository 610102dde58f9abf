//! The JSON of `calibrate stations`.

use sagnac_calibrate::stations::{Bundle, Parameter, Station};
use sagnac_model::ParameterPath;
use serde_json::{Map, Value, json};

use super::StationsOutcome;

/// The SI unit of a parameter path.
pub(super) fn unit(name: &str) -> String {
    name.parse::<ParameterPath>()
        .map_or_else(|_| String::new(), |path| path.dimension().si_unit())
}

/// The estimated parameters.
pub(super) fn parameters(list: &[Parameter]) -> Vec<Value> {
    list.iter()
        .map(|p| {
            json!({
                "name": p.name, "value": p.value, "sigma": p.sigma, "lower": p.lower, "upper": p.upper,
                "unit": unit(&p.name), "assumes": p.assumes,
            })
        })
        .collect()
}

pub(super) fn station(station: &Station) -> Value {
    json!({ "f": station.f, "w": station.w, "wdot": station.wdot, "temperature": station.temperature_c })
}

pub(super) fn bundles(bundles: &[Bundle]) -> Vec<Value> {
    bundles
        .iter()
        .flat_map(|b| b.stations.iter().map(station))
        .collect()
}

impl StationsOutcome {
    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let found = &self.found;
        let parameters = parameters(&found.parameters);
        let why: Vec<Value> = found
            .held
            .iter()
            .map(|held| {
                let aliases: Map<String, Value> = held
                    .aliases
                    .iter()
                    .map(|(name, c)| (name.clone(), json!(c)))
                    .collect();
                json!({ "name": held.name, "reason": held.status.key(), "aliases": aliases })
            })
            .collect();
        let residuals: Vec<Value> = found
            .residuals
            .iter()
            .map(|r| {
                json!({
                    "station": r.station,
                    "accel_x": r.accel[0], "accel_y": r.accel[1], "accel_z": r.accel[2],
                    "gyro_x": r.gyro[0], "gyro_y": r.gyro[1], "gyro_z": r.gyro[2],
                })
            })
            .collect();
        json!({
            "model": self.to_model().map_or(Value::Null, |m| m.to_json()),
            "parameters": parameters,
            "residual_rms": { "accel": found.residual_rms[1], "gyro": found.residual_rms[0] },
            "before": { "residual_rms": rms(&found.before_m_s2) },
            "after": { "residual_rms": rms(&found.after_m_s2) },
            "unobservable": found.held.iter().map(|h| &h.name).collect::<Vec<_>>(),
            "why_unobservable": why,
            "available": found.available.iter().map(|a| &a.name).collect::<Vec<_>>(),
            "confused": found.confused,
            "advice": self.advice(),
            "add_stations": found.additions.iter().map(|a| json!({
                "resolves": a.resolves, "stations": bundles(&a.bundles),
            })).collect::<Vec<_>>(),
            "chi2": found.fits.iter().map(|f| json!({
                "axis": f.axis, "chi2": f.chi2, "dof": f.dof, "p": f.p, "scaled": f.scaled,
            })).collect::<Vec<_>>(),
            "residuals": residuals,
            "stations": self.spans.iter().map(|(station, start_s, end_s)| {
                json!({ "station": station, "start_s": start_s, "end_s": end_s })
            }).collect::<Vec<_>>(),
            "notes": self.notes,
            "covariance": { "names": found.covariance_names, "matrix": found.covariance },
            "gravity": self.options.gravity_m_s2,
        })
    }
}

/// Root mean square; none without values.
pub(super) fn rms(values: &[f64]) -> Option<f64> {
    (!values.is_empty())
        .then(|| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt())
}
