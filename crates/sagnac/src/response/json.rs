//! The JSON of `response`: SI where the unit is known, `null` with a reason where the record gives nothing.

use sagnac_calibrate::response::Interval;
use serde_json::{Map, Value, json};

use super::{ResponseOutcome, per};

impl ResponseOutcome {
    /// The document of `--format json`.
    pub fn to_json(&self) -> Value {
        let r = &self.response;
        let (x, y) = (self.reference.si(), self.output.si());
        let percent = 100.0 / (r.sensitivity.value.abs() * r.full_scale);
        let mut missing = Map::new();
        let mut note = |name: &str, reason: Option<&&'static str>| {
            if let Some(reason) = reason {
                missing.insert(name.to_owned(), json!(reason));
            }
        };
        note("linearity", r.linearity.as_ref().err());
        note("accuracy", r.accuracy.as_ref().err());
        note("precision", r.precision.as_ref().err());
        note("resolution", r.resolution.as_ref().err());
        note("hysteresis", r.hysteresis.as_ref().err());
        note("threshold", r.threshold.as_ref().err());
        note("dead_band", r.threshold.as_ref().err());
        note("asymmetry", r.asymmetry.as_ref().err());
        let linearity = r.linearity.as_ref().ok();
        json!({
            "sensitivity": interval(&r.sensitivity, &per(&y, &x)),
            "offset": { "value": r.offset, "unit": y },
            "full_scale": { "value": r.full_scale, "unit": x },
            "linearity": linearity.map(|l| l.least_squares),
            "linearity_percent_fs": linearity.map(|l| l.least_squares * percent),
            "linearity_minimax": linearity.map(|l| l.minimax),
            "linearity_minimax_percent_fs": linearity.map(|l| l.minimax * percent),
            "accuracy": r.accuracy.as_ref().ok().map(|a| json!({
                "mean": a.mean, "max_abs": a.max_abs, "single_reading_95": a.single_reading, "unit": y,
            })),
            "precision": r.precision.as_ref().ok().map(|p| json!({
                "value": p.value, "lower": p.lower, "upper": p.upper, "dof": p.dof, "noise_part": p.noise_part, "unit": y,
            })),
            "resolution": r.resolution.as_ref().ok().map(|s| json!({ "value": s.value, "lsb": r.lsb, "unit": x })),
            "hysteresis": r.hysteresis.as_ref().ok().map(|h| json!({
                "value": h.value, "percent_fs": h.value * percent, "at": h.at, "unit": y,
            })),
            "threshold": r.threshold.as_ref().ok().map(|t| json!({
                "value": t.value, "positive": t.positive, "negative": t.negative, "unit": x,
            })),
            "dead_band": r.threshold.as_ref().ok().map(|t| json!({ "value": t.dead_band, "unit": x })),
            "asymmetry": r.asymmetry.as_ref().ok().map(|a| interval(a, "1")),
            "points": r.points.iter().map(|p| json!({
                "reference": p.reference, "mean": p.mean, "up": p.up, "down": p.down, "residual": p.residual, "count": p.count,
            })).collect::<Vec<_>>(),
            "not_given": missing,
        })
    }
}

fn interval(i: &Interval, unit: &str) -> Value {
    json!({
        "status": if i.excludes_zero() { "detected" } else { "upper_limit" },
        "value": i.value, "lower": i.lower, "upper": i.upper, "sigma": i.sigma, "unit": unit,
    })
}
