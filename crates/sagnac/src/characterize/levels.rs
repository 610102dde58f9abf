//! What steps make of the means: a level before, between and after them, and gravity that moves from axis to axis.

use super::text::{shown, shown_sensor};
use super::{AxisOutcome, LogOutcome};
use sagnac_analysis::fit::{AxisEstimate, Estimate, Level};
use sagnac_core::Sensor;
use sagnac_report::text::{Unit, clock, clock_span};
use std::fmt::Write as _;

/// Angle in degrees from which a change of f is a turn, not a bias: 0.05 g.
const LEAST_TURN_DEG: f64 = 3.0;
/// By how much |f| may differ before and after a turn: gravity keeps its size but for biases and scale factors.
const SAME_SIZE: f64 = 0.1;
/// Most levels that are told one by one.
const MOST_TOLD: usize = 3;

/// The largest turn of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn {
    /// The angle between gravity before and after.
    pub angle_deg: f64,
    /// When it took place, from the log's first sample.
    pub span_s: (f64, f64),
}

/// The mean of an axis; without an interval where its halves would contradict it, for there are several levels.
pub(super) fn mean(e: &AxisEstimate) -> Estimate {
    if e.levels.len() < 2 {
        return e.mean;
    }
    Estimate {
        lower: None,
        upper: None,
        ..e.mean
    }
}

/// Sentences about the levels of a sensor's axes, and of the accelerometer's about a turn.
pub(super) fn sentences(log: &LogOutcome, sensor: Sensor) -> String {
    let unit = Unit::of_term(shown_sensor(sensor), "mean");
    let mut out = String::new();
    for axis in log.axes.iter().filter(|a| a.sensor == sensor) {
        let levels = axis.estimate.as_ref().map_or(&[][..], |e| &e.levels);
        if levels.len() < 2 {
            continue;
        }
        let value = |level: &Level| {
            let text = shown(&level.mean).scaled(unit.per_si).text();
            format!("{} {}", text.value, text.interval)
                .trim()
                .to_owned()
        };
        let name = ["x", "y", "z"][axis.index];
        if levels.len() > MOST_TOLD {
            let by_size = |a: &&Level, b: &&Level| {
                let mean = |l: &Level| l.mean.value.unwrap_or(0.0);
                mean(a).total_cmp(&mean(b))
            };
            let ends = levels
                .iter()
                .min_by(by_size)
                .zip(levels.iter().max_by(by_size));
            if let Some((low, high)) = ends {
                let _ = write!(
                    out,
                    " The mean of {name} is no single one: {} levels from {} to {} {}.",
                    levels.len(),
                    value(low),
                    value(high),
                    unit.text
                );
            }
            continue;
        }
        let parts: Vec<String> = levels
            .iter()
            .enumerate()
            .map(|(i, level)| {
                let until = if i + 1 < levels.len() {
                    format!(" until {}", clock(level.end_s))
                } else {
                    format!(" from {} on", clock(level.start_s))
                };
                format!("{}{until}", value(level))
            })
            .collect();
        let _ = write!(
            out,
            " The mean of {name} is no single one: {} ({}).",
            parts.join(", "),
            unit.text
        );
    }
    if sensor == Sensor::Accel
        && let Some(turn) = turn(log)
    {
        let _ = write!(
            out,
            " The sensor was turned by {:.0} deg at {}: this is not one log at rest.",
            turn.angle_deg,
            clock_span(turn.span_s.0, turn.span_s.1)
        );
    }
    out
}

/// The largest angle between f before and after a step of an accelerometer axis, where it is one of gravity.
pub(super) fn turn(log: &LogOutcome) -> Option<Turn> {
    let axes: Vec<&AxisEstimate> = log
        .axes
        .iter()
        .filter(|a: &&AxisOutcome| a.sensor == Sensor::Accel)
        .filter_map(|a| a.estimate.as_ref())
        .collect();
    let [x, y, z] = axes[..] else { return None };
    let mut largest: Option<Turn> = None;
    for pair in [x, y, z].iter().flat_map(|e| e.levels.windows(2)) {
        let (before_s, after_s) = (pair[0].end_s, pair[1].start_s);
        // An axis may tell of the same turn a little earlier or later.
        let slack = 0.01 * log.duration_s;
        let force = |time_s: f64| {
            let at = |e: &AxisEstimate| {
                let level = e.levels.iter().take_while(|l| l.start_s <= time_s).last();
                level.map_or(e.mean, |l| l.mean).value
            };
            Some([at(x)?, at(y)?, at(z)?])
        };
        let (Some(a), Some(b)) = (force(before_s - slack), force(after_s + slack)) else {
            continue;
        };
        if let Some(angle_deg) = turned_deg(a, b)
            && largest.is_none_or(|t| angle_deg > t.angle_deg)
        {
            largest = Some(Turn {
                angle_deg,
                span_s: (before_s, after_s),
            });
        }
    }
    largest
}

/// By how many degrees gravity turned; none where the change is one of biases.
fn turned_deg(before: [f64; 3], after: [f64; 3]) -> Option<f64> {
    let size = norm(before);
    let angle_deg = angle(before, after).to_degrees();
    let is_turn = (norm(after) - size).abs() <= SAME_SIZE * size && angle_deg >= LEAST_TURN_DEG;
    is_turn.then_some(angle_deg)
}

/// The angle between two vectors, accurate near zero as well.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    norm(cross).atan2(dot)
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::turned_deg;

    #[test]
    fn gravity_turns_and_biases_step() {
        let turned = turned_deg([0.0, 0.1, 9.8], [4.9, 0.1, 8.3]).unwrap_or(0.0);
        assert!((turned - 30.5).abs() < 0.5, "{turned}");
        assert_eq!(turned_deg([0.0, 0.1, 9.8], [0.3, 0.1, 9.8]), None);
        // No gravity in the columns: the direction of a bias is none of the sensor.
        assert_eq!(turned_deg([1e-5, 0.0, 1e-6], [2e-4, 1.7e-4, 1.9e-4]), None);
    }
}
