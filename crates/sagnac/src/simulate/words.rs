//! What a simulation says about itself: sensor, motion, which terms are on, and what to beware of.

use std::collections::BTreeMap;

use sagnac_core::{Output, Sensor, SensorModel};
use sagnac_model::Model;
use sagnac_model::units::Dimension;
use sagnac_nav::{Earth, Trajectory};
use sagnac_report::text::{duration, general, group_thousands};

use crate::Error;
use crate::clock::RowClock;

use super::run::{OutsideRange, Recipe};
use super::{MotionSource, SimulateOutcome, SimulateRequest};

/// Columns of a log of truth that tell of the run that wrote it.
pub(super) fn of_another_run(names: &[String], label: &str) -> String {
    let mut groups: Vec<String> = names
        .iter()
        .map(|name| {
            let axis = ["_x", "_y", "_z"]
                .iter()
                .find_map(|of| name.strip_suffix(of));
            axis.map_or_else(|| name.clone(), |group| format!("{group}_*"))
        })
        .collect();
    groups.dedup();
    let of_truth = if groups.iter().any(|group| group != "flags") {
        ", and --truth writes those of this run"
    } else {
        ""
    };
    format!(
        "{} of {label} tell of the run that wrote it: left out{of_truth}",
        groups.join(" and ")
    )
}

/// A term of either sensor: its name, whether the model has it, and the name in `--noise` if it is random.
struct Named {
    id: &'static str,
    name: &'static str,
    present: bool,
    random: Option<&'static str>,
}

/// Every term of a sensor, in the order of the lecture.
fn terms(model: &Model, recipe: &Recipe, sensor: Sensor) -> Vec<Named> {
    let triad = recipe.core.triad(sensor);
    let gyro = sensor == Sensor::Gyro;
    let stability = model.stability(sensor);
    let noise = [0, 1, 2].map(|axis| model.axis_noise(sensor, axis));
    let any = |values: &[f64]| values.iter().any(|value| *value != 0.0);
    let some = |of: &dyn Fn(&sagnac_noise::AxisNoise) -> bool| noise.iter().any(of);
    let named = |id, name, present| Named {
        id,
        name,
        present,
        random: None,
    };
    let drawn = |id, name, present| Named {
        id,
        name,
        present,
        random: Some("stability"),
    };
    let random = |id, name, present| Named {
        id,
        name,
        present,
        random: Some(id),
    };
    let word = |gyro_word, accel_word| if gyro { gyro_word } else { accel_word };
    let mut out = vec![
        named("bias", "fixed bias", any(&triad.bias.fixed)),
        drawn("bias_draw", "run-to-run bias", any(&stability.bias)),
        named("scale", "scale factor", any(&triad.scale_factor.fixed)),
        drawn(
            "scale_draw",
            "run-to-run scale factor",
            any(&stability.scale_factor),
        ),
        named(
            "temperature",
            "temperature",
            triad.bias.temperature.is_present() || triad.scale_factor.temperature.is_present(),
        ),
        named(
            "nonlinearity",
            "nonlinearity",
            triad.nonlinearity.is_present(),
        ),
        named("asymmetry", "asymmetry", triad.asymmetry.is_present()),
        named(
            "misalignment",
            "misalignment",
            any(&triad.misalignment.elements.to_array()),
        ),
        drawn(
            "misalignment_draw",
            "run-to-run misalignment",
            any(&stability.misalignment),
        ),
        named(
            "cross_axis",
            "cross-axis response",
            any(&triad.cross_axis.elements.to_array()),
        ),
    ];
    if gyro {
        out.push(named(
            "g",
            "g-sensitivity",
            recipe.core.gyro_g_sensitivity.is_present(),
        ));
        out.push(named(
            "g2",
            "g2-sensitivity",
            recipe.core.gyro_g2_sensitivity.is_present(),
        ));
    } else {
        out.push(named(
            "offset",
            "axis offset",
            recipe.core.accel_axis_offset.is_present(),
        ));
    }
    out.extend([
        random(
            "white",
            word("angle random walk", "velocity random walk"),
            some(&|n| n.white.density != 0.0),
        ),
        random(
            "flicker",
            "bias instability",
            some(&|n| n.flicker.coefficient != 0.0),
        ),
        random(
            "random_walk",
            word("rate random walk", "acceleration random walk"),
            some(&|n| {
                n.random_walk.coefficient != 0.0 || n.instability_random_walk.coefficient != 0.0
            }),
        ),
        random(
            "quantization",
            "quantization",
            some(&|n| n.quantization.coefficient != 0.0),
        ),
        random(
            "ramp",
            word("rate ramp", "acceleration ramp"),
            some(&|n| n.ramp.slope != 0.0),
        ),
        random(
            "gauss_markov",
            "Gauss-Markov",
            some(&|n| {
                n.instability_gauss_markov.sigma != 0.0
                    || n.gauss_markov.iter().any(|term| term.sigma != 0.0)
            }),
        ),
        random(
            "resonance",
            "resonance",
            some(&|n| n.resonance.iter().any(|t| t.sigma != 0.0)),
        ),
        random(
            "sinusoid",
            "sinusoid",
            some(&|n| n.sinusoid.iter().any(|t| t.amplitude != 0.0)),
        ),
        named("bandwidth", "bandwidth", triad.bandwidth.is_present()),
        named("range", "range", triad.range.is_present()),
        named("resolution", "resolution", triad.resolution.is_present()),
    ]);
    out
}

/// The headline and the lists of what is on and off.
pub(super) fn describe(
    request: &SimulateRequest<'_>,
    recipe: &Recipe,
    outcome: &mut SimulateOutcome,
) {
    let name = request.model.name();
    let place = match &request.motion {
        MotionSource::Trajectory {
            trajectory, start, ..
        } => {
            let latitude = start.latitude_rad.to_degrees();
            let side = if latitude < 0.0 { "south" } else { "north" };
            let latitude = format!("{} deg {side}", general(latitude.abs(), 6));
            if trajectory.is_rest() {
                let level = start.roll_rad == 0.0 && start.pitch_rad == 0.0;
                let attitude = if level {
                    "level".to_owned()
                } else {
                    format!(
                        "roll {} deg, pitch {} deg",
                        general(start.roll_rad.to_degrees(), 6),
                        general(start.pitch_rad.to_degrees(), 6)
                    )
                };
                format!("at rest, {attitude}, {latitude}")
            } else if trajectory.last_time_s().is_some() {
                format!("along {}", trajectory.name())
            } else {
                format!("on `{}` from {latitude}", trajectory.name())
            }
        }
        MotionSource::Log { label, .. } => format!("on the truth of {label}"),
    };
    let each = if outcome.runs > 1 {
        format!("{} runs of ", group_thousands(&outcome.runs.to_string()))
    } else {
        String::new()
    };
    outcome.headline = format!(
        "{name} {place}: {each}{} {}, {}.",
        group_thousands(&outcome.samples.to_string()),
        if outcome.samples == 1 {
            "sample"
        } else {
            "samples"
        },
        duration(outcome.duration_s)
    );
    let sensors: Vec<(Sensor, Vec<Named>)> = Sensor::ALL
        .into_iter()
        .filter(|sensor| recipe.present[sensor.index()])
        .map(|sensor| (sensor, terms(request.model, recipe, sensor)))
        .collect();
    let is_on =
        |term: &Named| term.present && term.random.is_none_or(|name| request.terms.has(name));
    let list =
        |terms: &[Named], wanted: &dyn Fn(&Named) -> bool| -> Vec<(&'static str, &'static str)> {
            terms
                .iter()
                .filter(|term| wanted(term))
                .map(|term| (term.id, term.name))
                .collect()
        };
    let on: Vec<_> = sensors
        .iter()
        .map(|(_, terms)| list(terms, &is_on))
        .collect();
    let join = |list: &[(&str, &str)]| {
        if list.is_empty() {
            "nothing".to_owned()
        } else {
            list.iter()
                .map(|(_, name)| *name)
                .collect::<Vec<_>>()
                .join(", ")
        }
    };
    let ids = |list: &[(&'static str, &'static str)]| {
        list.iter()
            .map(|(id, _)| *id)
            .filter(|id| !["g", "g2", "offset"].contains(id))
            .collect::<Vec<_>>()
    };
    let mut text = format!(
        "On: {}",
        on.first().map_or_else(String::new, |list| join(list))
    );
    if let [gyro, accel] = on.as_slice() {
        if ids(gyro) == ids(accel) {
            text.push_str("; the same for the accelerometer");
            if accel.iter().any(|(id, _)| *id == "offset") {
                text.push_str(", and axis offset");
            }
        } else {
            text.push_str("; accelerometer: ");
            text.push_str(&join(accel));
        }
    }
    text.push_str(&format!(". Seed {}.", outcome.seed));
    outcome.remarks.push(text);
    let mut everywhere: Vec<&str> = Vec::new();
    let mut unwanted: Vec<&str> = Vec::new();
    for term in sensors.iter().flat_map(|(_, terms)| terms) {
        let same = || {
            sensors
                .iter()
                .flat_map(|(_, terms)| terms)
                .filter(|other| other.id == term.id)
        };
        if same().all(|other| !other.present) && !everywhere.contains(&term.name) {
            everywhere.push(term.name);
        }
        if term.present && !is_on(term) && !unwanted.contains(&term.name) {
            unwanted.push(term.name);
        }
    }
    if !unwanted.is_empty() {
        outcome
            .remarks
            .push(format!("Off, by --noise: {}.", unwanted.join(", ")));
    }
    if !everywhere.is_empty() {
        outcome
            .remarks
            .push(format!("Off, not in the model: {}.", everywhere.join(", ")));
    }
}

/// Refuses increments whose step is a rate beyond the range at this interval.
pub(super) fn check_increments(
    model: &Model,
    core: &SensorModel<f64>,
    dt_s: f64,
) -> Result<(), Error> {
    for sensor in Sensor::ALL {
        let triad = core.triad(sensor);
        let mut pairs = triad.resolution.lsb.iter().zip(&triad.range.limit);
        if triad.resolution.output == Output::Increment
            && pairs.any(|(lsb, limit)| lsb / dt_s > *limit)
        {
            return Err(Error::data(format!(
                "{}.resolution is coarser than the range at {} Hz: every output would be 0",
                sensor.key(),
                general(1.0 / dt_s, 6)
            ))
            .at(model.label())
            .advise("lower the rate, or look for a wrong unit in `resolution` or `range`"));
        }
    }
    Ok(())
}

/// Warnings that the model alone gives.
pub(super) fn warn_of_terms(
    model: &Model,
    request: &SimulateRequest<'_>,
    recipe: &Recipe,
    outcome: &mut SimulateOutcome,
) {
    for sensor in Sensor::ALL {
        let name = sensor.name();
        if !recipe.present[sensor.index()] {
            let lost = match sensor {
                Sensor::Gyro => "the axis offset of the accelerometer is left out",
                Sensor::Accel => "g-sensitivity of the gyro is left out",
            };
            outcome.notes.push(format!(
                "the input has no {name} channels: neither has the output, and {lost}"
            ));
            continue;
        }
        let triad = recipe.core.triad(sensor);
        let limits = triad.bandwidth.cutoff_hz;
        let mut cutoffs = limits.iter().filter(|cutoff| cutoff.is_finite());
        if triad.bandwidth.is_present() && cutoffs.all(|cutoff| cutoff * recipe.dt_s >= 0.5) {
            outcome.notes.push(format!(
                "{}.bandwidth is not below half the rate, {} Hz: it changes nothing",
                sensor.key(),
                general(0.5 / recipe.dt_s, 6)
            ));
        }
        let counted_twice = triad.resolution.is_present()
            && triad.resolution.output == Output::Increment
            && request.terms.has("quantization")
            && (0..3).any(|axis| model.axis_noise(sensor, axis).quantization.coefficient != 0.0);
        if counted_twice {
            outcome.warnings.push(format!(
                "{}.noise.quantization and the rounding of increments ({}.resolution) both act: quantization counts twice",
                sensor.key(),
                sensor.key()
            ));
        }
    }
    let [gyro, accel] = recipe.present;
    let mut core = recipe.core;
    if !gyro {
        core = core.without_gyro();
    }
    if !accel {
        core = core.without_accel();
    }
    outcome
        .warnings
        .extend(crate::explain::no_inverse(&core, recipe.dt_s));
    let limits = model.limits();
    if !limits.is_empty() {
        let mut names: Vec<String> = limits.iter().take(3).map(ToString::to_string).collect();
        if limits.len() > 3 {
            names.push(format!("{} more", limits.len() - 3));
        }
        outcome.notes.push(format!(
            "only upper limits are known, simulated as zero: {}",
            names.join(", ")
        ));
    }
}

/// From this error of gravity on, as a part of it, a height is told: as much as the bias of a good accelerometer.
const GRAVITY_ERROR: f64 = 1e-4;

/// Warns of heights at which the formula of gravity, of second order in the height, no longer holds.
pub(super) fn warn_of_height(
    trajectory: &Trajectory,
    duration_s: f64,
    outcome: &mut SimulateOutcome,
) {
    const LOOKS: u32 = 1000;
    let height_m = (0..=LOOKS)
        .map(|k| trajectory.at(duration_s * f64::from(k) / f64::from(LOOKS)))
        .map(|point| point.place.height_m)
        .fold(f64::NEG_INFINITY, f64::max);
    // Beside the inverse square, which the formula expands.
    let h = height_m / Earth::Wgs84.semi_major_m();
    let error = (1.0 - 2.0 * h + 3.0 * h * h) * (1.0 + h) * (1.0 + h) - 1.0;
    if height_m > 0.0 && error > GRAVITY_ERROR {
        let by = if error < 1.0 {
            format!("by {} %", general(100.0 * error, 2))
        } else {
            format!("{} times", general(1.0 + error, 2))
        };
        outcome.warnings.push(format!(
            "the motion goes up to {} km, where the formula of gravity, of second order in height, gives too much {by}",
            general(height_m / 1000.0, 4)
        ));
    }
}

/// Warnings that the samples gave.
pub(super) fn warn_of_samples(
    model: &Model,
    clipped: BTreeMap<String, (u64, f64)>,
    outside: &[OutsideRange],
    clock: Option<&RowClock>,
    outcome: &mut SimulateOutcome,
) {
    for (channel, (count, limit)) in clipped {
        let dimension = if channel.starts_with("gyro") {
            Dimension::ANGULAR_RATE
        } else {
            Dimension::ACCELERATION
        };
        let limit = limit / (1.0 - 1e-9);
        let limit = if channel.starts_with("gyro") {
            format!("{} deg/s", general(limit.to_degrees(), 4))
        } else {
            format!("{} {}", general(limit, 4), dimension.si_unit())
        };
        let samples = if count == 1 { "sample" } else { "samples" };
        outcome.warnings.push(format!(
            "{channel} is saturated in {} {samples}, at {limit}",
            group_thousands(&count.to_string())
        ));
    }
    for of in outside.iter().filter(|of| of.count > 0) {
        let [low, high] = of.range_c;
        let whose = if model.temperature_range_c() == Some(of.range_c) {
            String::new()
        } else {
            format!(", the range of {},", of.terms.join(" and "))
        };
        outcome.warnings.push(format!(
            "the temperature is outside {} to {} degC{whose} in {} {}: the nearer end is taken",
            general(low, 6),
            general(high, 6),
            group_thousands(&of.count.to_string()),
            if of.count == 1 { "sample" } else { "samples" }
        ));
    }
    if let Some(clock) = clock {
        outcome
            .warnings
            .extend(clock.sentences("the input", "noise goes on from row to row"));
    }
}
