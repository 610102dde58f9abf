//! What a model can do for a log: the terms that it lacks channels for are left out and told.

use sagnac_core::{Sensor, SensorModel};
use sagnac_model::Model;
use sagnac_report::text::general;

use super::{Columns, CorrectOutcome};
use crate::Error;
use crate::calibrate::{has_spline, short_beside, stem};

/// The model without the terms for which the log lacks a channel; what that means is noted.
pub(super) fn usable(
    model: &Model,
    columns: &Columns,
    outcome: &mut CorrectOutcome,
) -> Result<SensorModel<f64>, Error> {
    let mut core = model.to_core()?;
    if columns.gyro.is_none() {
        if core.accel_axis_offset.is_present() {
            outcome.notes.push(
                "the log has no gyro: the accelerometer is corrected without its axis offset"
                    .to_owned(),
            );
        }
        core = core.without_gyro();
    }
    if columns.accel.is_none() {
        if core.gyro_g_sensitivity.is_present() || core.gyro_g2_sensitivity.is_present() {
            outcome.notes.push(
                "the log has no accelerometer: the gyro is corrected without its g-sensitivity"
                    .to_owned(),
            );
        }
        core = core.without_accel();
    }
    if columns.temperature.is_none() && core.depends_on_temperature() {
        outcome.notes.push(format!(
            "the log has no temperature: the model's temperature terms are taken at {} degC",
            general(core.reference_temperature_c, 4)
        ));
    }
    let mut not_undone = vec!["noise"];
    for sensor in Sensor::ALL {
        let triad = core.triad(sensor);
        let s = model.stability(sensor);
        let mut add = |has: bool, word: &'static str| {
            if has && !not_undone.contains(&word) {
                not_undone.push(word);
            }
        };
        add(s.bias.iter().any(|x| *x > 0.0), "run-to-run bias");
        add(
            s.scale_factor.iter().any(|x| *x > 0.0),
            "run-to-run scale factor",
        );
        add(
            s.misalignment.iter().any(|x| *x > 0.0),
            "run-to-run misalignment",
        );
        add(
            (0..3).any(|k| model.instability_floor(sensor, k).is_some_and(|x| x > 0.0)),
            "bias instability",
        );
        add(triad.bandwidth.is_present(), "the low-pass");
        add(triad.resolution.is_present(), "rounding");
        add(triad.range.is_present(), "saturation");
    }
    let list = match not_undone.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => "noise".to_owned(),
    };
    outcome
        .notes
        .push(format!("a model cannot take out {list}."));
    let held = held_at_zero(model);
    if !held.is_empty() {
        let determined = |of: &str| {
            let names = model.calibrations().iter().flat_map(|c| &c.names);
            names.into_iter().any(|name| stem(name) == of)
        };
        outcome.notes.push(format!(
            "not corrected, held at zero in the calibration: {}",
            short_beside(&held, determined)
        ));
    }
    Ok(core)
}

/// The terms that the model's calibrations held at zero, each once and without those that it has all the same.
pub fn held_at_zero(model: &Model) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for name in model.calibrations().iter().flat_map(|c| &c.held) {
        if !out.contains(name)
            && model.get(name).is_none()
            && !model
                .calibrations()
                .iter()
                .any(|c| has_spline(&c.names, name))
        {
            out.push(name.clone());
        }
    }
    out
}
