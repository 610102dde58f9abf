//! The JSON of `calibrate multi-position`.

use serde_json::{Map, Value, json};

use super::MultiPositionOutcome;
use crate::calibrate::json::parameters;
use crate::findings::issue_json;

impl MultiPositionOutcome {
    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let found = &self.found;
        let parameters = parameters(&found.parameters);
        let names: Vec<&String> = found.parameters.iter().map(|p| &p.name).collect();
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
        json!({
            "model": self.to_model().map_or(Value::Null, |m| m.to_json()),
            "parameters": parameters,
            "residual_rms": { "accel": found.accel_rms, "gyro": found.gyro_rms },
            "before": { "residual_rms": found.before_rms },
            "unobservable": found.held.iter().map(|h| &h.name).collect::<Vec<_>>(),
            "why_unobservable": why,
            "available": found.available,
            "confused": found.confused,
            "advice": self.advice(),
            "add_poses": found.add_poses.iter().map(|p| json!({
                "up": p.up, "improves": p.improves, "sigma_before": p.sigma_before, "sigma_after": p.sigma_after,
            })).collect::<Vec<_>>(),
            "add_turns": found.add_turns.iter().map(|t| json!({
                "axis": t.axis, "improves": t.improves, "sigma_before": t.sigma_before,
                "sigma_after": t.sigma_after,
            })).collect::<Vec<_>>(),
            "chi2": found.fits.iter().map(|f| json!({
                "axis": f.axis, "chi2": f.chi2, "dof": f.dof, "p": f.p, "scaled": f.scaled,
            })).collect::<Vec<_>>(),
            "poses": found.poses.iter().map(|p| json!({
                "start_s": p.start_s, "end_s": p.end_s, "direction": p.direction, "residual": p.residual,
                "weight": p.weight,
            })).collect::<Vec<_>>(),
            "turns": found.turns.iter().map(|t| json!({
                "start_s": t.start_s, "end_s": t.end_s, "error_rad": t.error_rad, "weight": t.weight,
            })).collect::<Vec<_>>(),
            "residuals": found.poses.iter().enumerate().map(|(i, p)| json!({
                "station": (i + 1).to_string(), "accel": p.residual,
                "gyro_x": p.gyro_residual.map(|r| r[0]), "gyro_y": p.gyro_residual.map(|r| r[1]),
                "gyro_z": p.gyro_residual.map(|r| r[2]),
            })).collect::<Vec<_>>(),
            "covariance": { "names": names, "matrix": found.covariance },
            "gravity": self.gravity_m_s2,
            "threshold": { "value": found.threshold_m_s2, "unit": "m/s^2" },
            "covered": found.covered,
            "issues": self.findings.iter().map(issue_json).collect::<Vec<_>>(),
            "notes": self.notes(),
            "gyro_drift": found.gyro_drift.map(|d| json!({
                "rate_random_walk": d.rate_random_walk, "interval": d.interval, "largest": d.largest, "earth_rate_counted": d.has_earth,
            })),
        })
    }
}
