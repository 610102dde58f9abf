//! The file again with the reference's numbers in its convention; everything else stays as it is.
//!
//! Behind each line that changes stands what it was: comments of the file still speak of those numbers.

use super::audit::estimate;
use super::convention::{Foreign, Quantity, Reading, Rule};
use crate::export::{Format, yaml_number};
use crate::model::Model;
use sagnac_core::Sensor;
use std::ops::Range;

type Change = (Range<usize>, String);

pub(super) fn correct(
    text: &str,
    foreign: &Foreign,
    rate_hz: Option<f64>,
    model: &Model,
) -> String {
    let mut changes = if foreign.format == Format::Gtsam {
        expressions(text, foreign, model)
    } else {
        numbers(foreign, rate_hz, model)
    };
    // A number that is the reference's in other digits stays.
    changes.retain(|(span, new)| {
        let old = text.get(span.clone()).unwrap_or_default();
        match (old.parse::<f64>(), new.parse::<f64>()) {
            (Ok(old), Ok(new)) => (old - new).abs() > 1e-12 * new.abs(),
            _ => old != new,
        }
    });
    changes.sort_by_key(|(span, _)| span.start);
    let mut edits = changes.clone();
    let mut pending: Vec<&Range<usize>> = Vec::new();
    for (number, (span, _)) in changes.iter().enumerate() {
        pending.push(span);
        let line_end = end_of_line(text, span.end);
        let next = changes.get(number + 1);
        if next.is_none_or(|(next, _)| next.start >= line_end) {
            if let Some(remark) = remark(foreign, text, &pending, line_end) {
                edits.push((line_end..line_end, remark));
            }
            pending.clear();
        }
    }
    edits.sort_by_key(|(span, _)| (span.start, span.end));
    let mut corrected = String::with_capacity(text.len());
    let mut at = 0;
    for (span, new) in edits {
        if span.start >= at {
            corrected.push_str(text.get(at..span.start).unwrap_or_default());
            corrected.push_str(&new);
            at = span.end;
        }
    }
    corrected.push_str(text.get(at..).unwrap_or_default());
    corrected
}

fn numbers(foreign: &Foreign, rate_hz: Option<f64>, model: &Model) -> Vec<Change> {
    let mut changes = Vec::new();
    for reading in &foreign.readings {
        let written = wanted(reading, model)
            .and_then(|meaning| reading.rule.written(meaning, rate_hz))
            .map(yaml_number);
        let (item, number) = reading.place;
        let span = foreign
            .flat
            .items
            .get(item)
            .and_then(|item| item.spans.get(number));
        if let (Some(written), Some(span)) = (written, span) {
            changes.push((span.clone(), written));
        }
    }
    changes
}

/// What the reference says in place of a number.
fn wanted(reading: &Reading, model: &Model) -> Option<f64> {
    let known = estimate(model, reading).filter(|known| !known.limit)?;
    Some(known.value)
}

/// GTSAM's covariances are expressions: the whole one is written again, with sigmas that one can read.
fn expressions(text: &str, foreign: &Foreign, model: &Model) -> Vec<Change> {
    let cpp = ["::", "->", "#include"]
        .iter()
        .any(|mark| text.contains(mark));
    let square = |value: f64| {
        let sigma = yaml_number(value);
        if cpp {
            format!("std::pow({sigma}, 2)")
        } else {
            format!("{sigma} ** 2")
        }
    };
    let mut changes = Vec::new();
    for (place, item) in foreign.flat.items.iter().enumerate() {
        let mine: Vec<&Reading> = foreign
            .readings
            .iter()
            .filter(|reading| reading.place.0 == place)
            .collect();
        let Some(span) = item.spans.first() else {
            continue;
        };
        if mine.iter().all(|reading| wanted(reading, model).is_none()) {
            continue;
        }
        let sigma = |reading: &&Reading| {
            let old = Rule::Variance.meaning(reading.value, None);
            square(wanted(reading, model).or(old).unwrap_or(0.0))
        };
        let new = if mine
            .iter()
            .any(|reading| reading.quantity == Quantity::RunToRun)
        {
            let three = |sensor: Sensor| {
                let parts: Vec<String> = mine
                    .iter()
                    .filter(|reading| reading.sensor == sensor)
                    .map(sigma)
                    .collect();
                if let [one] = parts.as_slice() {
                    [one.as_str(); 3].join(", ")
                } else {
                    parts.join(", ")
                }
            };
            let six = format!("{}, {}", three(Sensor::Accel), three(Sensor::Gyro));
            if cpp {
                format!("(gtsam::Vector6() << {six}).finished().asDiagonal()")
            } else {
                format!("np.diag([{six}])")
            }
        } else if let [one] = mine.as_slice() {
            let squared = sigma(one);
            if cpp {
                format!("gtsam::I_3x3 * {squared}")
            } else {
                format!("np.eye(3) * {squared}")
            }
        } else {
            let three: Vec<String> = mine.iter().map(sigma).collect();
            let three = three.join(", ");
            if cpp {
                format!("gtsam::Vector3({three}).asDiagonal()")
            } else {
                format!("np.diag([{three}])")
            }
        };
        changes.push((span.clone(), new));
    }
    changes
}

fn end_of_line(text: &str, from: usize) -> usize {
    let rest = text.get(from..).unwrap_or_default();
    let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
    from + line.trim_end().len()
}

/// What the numbers of a line were, as a comment at its end; none where a format has no comments.
fn remark(
    foreign: &Foreign,
    text: &str,
    spans: &[&Range<usize>],
    line_end: usize,
) -> Option<String> {
    let mark = match foreign.format {
        Format::Basalt | Format::NaveGo => return None,
        Format::Matlab => "%",
        Format::Gazebo => "<!--",
        Format::Gtsam if text.contains("::") || text.contains("->") => "//",
        _ => "#",
    };
    let first = spans.first()?.start;
    let begin = text.get(..first)?.rfind('\n').map_or(0, |at| at + 1);
    let line = text.get(begin..line_end)?;
    let above = text[..begin].lines().next_back().unwrap_or_default();
    let mut old: Vec<&str> = foreign
        .flat
        .items
        .iter()
        .filter(|item| spans.iter().any(|span| item.spans.contains(span)))
        .map(|item| item.raw.as_str())
        .collect();
    old.dedup();
    let old = old.join(", ");
    let old = old.split_whitespace().collect::<Vec<_>>().join(" ");
    let of_it = if above.trim_start().starts_with(mark) {
        ", of which the comment above speaks"
    } else {
        ""
    };
    let said = format!("was {old}{of_it}");
    Some(match mark {
        "<!--" => format!("  <!-- {said} -->"),
        _ if line.contains(mark) => format!("; {said}"),
        _ => format!("  {mark} {said}"),
    })
}
