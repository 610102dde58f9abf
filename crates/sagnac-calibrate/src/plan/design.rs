//! A test for one sensor: stations are added to a tumble until every term of its model is known well enough.
//!
//! Each time the candidate that lowers Σ (σ/goal)² most per station; σ² = ((XᵀWX + P⁻¹)⁻¹)_ii with the plausible
//! sizes P until the terms are admitted.

use super::{Errors, sigmas};
use crate::stations::{Belief, Bundle, Decided, Options, Station, bundles, decide_all};

/// A parameter and the standard error that is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Parameter path with its axis.
    pub name: String,
    /// Wanted standard error.
    pub sigma: f64,
}

/// The most stations of a plan.
const MOST: usize = 400;

/// Stations that reach the goals, beginning with `start`, and the names of goals that are not reached.
pub fn design(
    start: Vec<Station>,
    goals: &[Goal],
    errors: Errors,
    options: &Options,
) -> (Vec<Station>, Vec<String>) {
    let mut out = start;
    let missed = |stations: &[Station]| -> Vec<String> {
        let found = sigmas(stations, errors, options);
        goals
            .iter()
            .filter(|goal| {
                !found
                    .iter()
                    .any(|(name, sigma)| *name == goal.name && *sigma <= goal.sigma)
            })
            .map(|goal| goal.name.clone())
            .collect()
    };
    let mut open = missed(&out);
    if open.is_empty() {
        return (out, open);
    }
    let fastest = out
        .iter()
        .map(|s| s.w.iter().map(|w| w * w).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let temperature = out.iter().find_map(|s| s.temperature_c);
    let candidates: Vec<Bundle> = bundles(options, fastest, temperature);
    let filled = errors.put_on(&out, options.gravity_m_s2);
    let decided: Vec<Decided> = decide_all(&filled, options);
    let mut beliefs: Vec<(Belief, Vec<(usize, f64)>)> = decided
        .iter()
        .map(|axis| {
            let wanted = goals
                .iter()
                .filter_map(|goal| Some((axis.term_of(&goal.name)?, goal.sigma)))
                .collect();
            (Belief::new(axis, &filled), wanted)
        })
        .collect();
    while !open.is_empty() && out.len() < MOST {
        let best = candidates
            .iter()
            .map(|bundle| {
                let fall: f64 = beliefs
                    .iter()
                    .map(|(belief, wanted)| belief.fall(bundle, wanted, options))
                    .sum();
                (fall / bundle.stations.len().max(1) as f64, bundle)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((fall, bundle)) = best else { break };
        if fall <= 0.0 {
            break;
        }
        for (belief, _) in &mut beliefs {
            belief.take(bundle, options);
        }
        for station in &bundle.stations {
            let mut station = station.clone();
            station.label.clone_from(&bundle.words);
            out.push(station);
        }
        // Admission looks at the table alone; it need not be asked while the goals are far.
        let far = beliefs
            .iter()
            .any(|(belief, wanted)| wanted.iter().any(|(t, goal)| belief.sigma(*t) > 1.2 * goal));
        if !far || out.len() >= MOST {
            open = missed(&out);
        }
    }
    (out, open)
}
