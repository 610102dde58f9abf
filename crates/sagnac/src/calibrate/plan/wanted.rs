//! Wanted standard errors: from `--precision`, or a tenth of what a model has; and how long it takes to reach them.

use sagnac_calibrate::plan::{Goal, sigmas};
use sagnac_calibrate::stations::{Group, Options, Station, Term};
use sagnac_model::units::parse_quantity;
use sagnac_model::{Model, ParameterPath};
use sagnac_report::text::{duration, significant};

use super::noise::Noise;
use crate::Error;

/// Parameters and their wanted standard errors.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted {
    pub(super) goals: Vec<Goal>,
}

/// Repeats and dwell that reach the goals.
pub(super) struct Reached {
    pub(super) repeats: u32,
    pub(super) dwell_s: f64,
    pub(super) notes: Vec<String>,
}

/// A repeat costs this much more than its dwell \[s\].
const HANDLING_S: f64 = 30.0;
/// No dwell is longer \[s\].
const LONGEST_S: f64 = 86_400.0;

impl Wanted {
    /// Reads `accel.bias=1 mg, gyro.scale_factor=50 ppm`.
    pub(super) fn parse(list: Option<&str>) -> Result<Self, Error> {
        let mut out = Self::default();
        let example = "write for instance --precision 'accel.bias=1 mg, gyro.scale_factor=50 ppm'";
        for part in list.unwrap_or_default().split(',').map(str::trim) {
            if part.is_empty() {
                continue;
            }
            let wrong = |what: String| {
                Error::usage(what)
                    .at(format!("--precision {part}"))
                    .advise(example)
            };
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| wrong("a precision is a parameter, `=` and a value".to_owned()))?;
            let path: ParameterPath = name
                .trim()
                .parse()
                .map_err(|error: sagnac_model::Error| wrong(error.to_string()))?;
            let sigma = parse_quantity(value.trim(), path.dimension())
                .map_err(|error| wrong(error.to_string()))?;
            if sigma <= 0.0 {
                return Err(wrong("a precision must be above zero".to_owned()));
            }
            let before = out.goals.len();
            for element in path.elements() {
                let name = element.to_string();
                if Term::named(&name).is_some() {
                    out.goals.retain(|goal| goal.name != name);
                    out.goals.push(Goal { name, sigma });
                }
            }
            if out.goals.len() == before {
                return Err(wrong(format!(
                    "no test of stations determines `{}`",
                    name.trim()
                )));
            }
        }
        Ok(out)
    }

    /// A tenth of each value of a model that is not wanted otherwise.
    pub(super) fn add_from(&mut self, model: &Model) -> Result<(), Error> {
        let mut any = false;
        for (path, entry) in model.parameters() {
            let name = path.to_string();
            let Some(value) = entry.value.filter(|v| *v != 0.0) else {
                continue;
            };
            // What a calibration sees of cross-axis response is misalignment.
            let name = name.replace(".cross_axis.", ".misalignment.");
            if Term::named(&name).is_none() {
                continue;
            }
            any = true;
            if !self.goals.iter().any(|goal| goal.name == name) {
                self.goals.push(Goal {
                    name,
                    sigma: value.abs() / 10.0,
                });
            }
        }
        if any || !self.goals.is_empty() {
            return Ok(());
        }
        Err(model
            .missing(
                "deterministic terms",
                Some(
                    "name a test: six-position, tumble24, rate-table, centrifuge, chamber"
                        .to_owned(),
                ),
            )
            .into())
    }

    /// The groups of what is wanted.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut out: Vec<Group> = Vec::new();
        for goal in &self.goals {
            if let Some((_, _, term)) = Term::named(&goal.name)
                && !out.contains(&term.group)
            {
                out.push(term.group);
            }
        }
        out
    }

    /// The shortest campaign of repeats and dwells, none shorter than `dwell_s`, that reaches every goal.
    pub(super) fn lengthen(
        &self,
        stations: &[Station],
        noise: &Noise,
        dwell_s: f64,
        tilt_rad: f64,
        options: &Options,
    ) -> Reached {
        let at = |repeats: u32, dwell_s: f64| {
            let errors = noise
                .errors(dwell_s, tilt_rad)
                .of_repeats(f64::from(repeats));
            sigmas(stations, errors, options)
        };
        let first = at(1, dwell_s);
        let known = |goal: &Goal| first.iter().any(|(name, _)| *name == goal.name);
        let mut notes = Vec::new();
        let hidden: Vec<String> = self
            .goals
            .iter()
            .filter(|goal| !known(goal))
            .map(|goal| goal.name.clone())
            .collect();
        if !hidden.is_empty() {
            notes.push(format!(
                "no dwell reaches {}: these stations do not determine it",
                super::super::text::short(&hidden)
            ));
        }
        // The largest σ over its goal, and whose it is.
        let worst = |repeats: u32, dwell_s: f64| {
            at(repeats, dwell_s)
                .into_iter()
                .filter_map(|(name, sigma)| {
                    let goal = self.goals.iter().find(|goal| goal.name == name)?;
                    Some((sigma / goal.sigma, name, sigma))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let enough =
            |repeats: u32, dwell_s: f64| worst(repeats, dwell_s).is_none_or(|w| w.0 <= 1.0);
        let mut best: Option<(f64, u32, f64)> = None;
        let mut counts: Vec<u32> = (1..=10).collect();
        counts.extend([
            12, 15, 20, 25, 30, 40, 50, 70, 100, 150, 200, 300, 500, 700, 1000,
        ]);
        for repeats in counts {
            let reached = if enough(repeats, dwell_s) {
                dwell_s
            } else if noise.knows_dwell() && enough(repeats, LONGEST_S) {
                let (mut low, mut high) = (dwell_s.ln(), LONGEST_S.ln());
                for _ in 0..40 {
                    let middle = f64::midpoint(low, high);
                    if enough(repeats, middle.exp()) {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                rounded_up(high.exp())
            } else {
                continue;
            };
            let cost = f64::from(repeats) * (reached + HANDLING_S);
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, repeats, reached));
            }
            if reached <= dwell_s {
                break;
            }
        }
        if noise.knows_dwell()
            && !enough(1, LONGEST_S)
            && let Some((_, name, sigma)) = worst(1, LONGEST_S)
        {
            notes.push(format!(
                "no dwell alone reaches {name}: bias instability leaves {} at one visit of each station",
                in_users_units(&name, sigma)
            ));
        }
        if let Some((_, repeats, dwell_s)) = best {
            return Reached {
                repeats,
                dwell_s,
                notes,
            };
        }
        if let Some((ratio, name, _)) = worst(1, dwell_s) {
            notes.push(format!(
                "{name} is not reached with a thousand repeats: {} times too large after one of {}",
                significant(ratio, 2),
                duration(dwell_s)
            ));
        }
        Reached {
            repeats: 1,
            dwell_s,
            notes,
        }
    }
}

/// A standard error in the unit in which the tables show its parameter.
fn in_users_units(name: &str, sigma: f64) -> String {
    match Term::named(name) {
        Some((sensor, _, term)) => {
            let shown = super::super::units::shown(sensor, term);
            format!("{} {}", significant(sigma * shown.per_si, 2), shown.unit)
        }
        None => format!(
            "{} {}",
            significant(sigma, 2),
            super::super::json::unit(name)
        ),
    }
}

/// The next number of two digits.
fn rounded_up(value: f64) -> f64 {
    let step = 10f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / step - 1e-9).ceil() * step;
    // Steps below one second are inexact decimals.
    (rounded * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_floor_is_told_as_the_tables_show_it() {
        let rate = super::in_users_units("gyro.bias.x", 1f64.to_radians() / 3600.0);
        assert_eq!(rate, "1.0 deg/h");
        assert_eq!(
            super::in_users_units("accel.scale_factor.z", 2e-5),
            "20 ppm"
        );
    }
}
