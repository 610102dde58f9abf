//! `calibrate multi-position` in a terminal: what was found, the tables, what was not determined, how to turn next.

use sagnac_calibrate::stations::Status;
use sagnac_core::Sensor;
use sagnac_report::text::{Document, significant};

use super::MultiPositionOutcome;
use crate::calibrate::text::{estimates_table, group_name, in_g, stem, terms_in};

/// A length of time in words.
fn duration(s: f64) -> String {
    if s < 100.0 {
        format!("{} s", significant(s, 3))
    } else {
        format!("{} min", significant(s / 60.0, 2))
    }
}

impl MultiPositionOutcome {
    /// What to do next, in words.
    pub fn advice(&self) -> Vec<String> {
        let found = &self.found;
        let mut out = Vec::new();
        let list = |words: Vec<&str>| {
            let shown: Vec<&str> = words.iter().copied().take(4).collect();
            shown.join(", then ")
        };
        if !found.add_poses.is_empty() {
            let words = found.add_poses.iter().map(|p| p.words.as_str()).collect();
            out.push(format!(
                "turn it so next: {} up -> {}",
                list(words),
                names(found.add_poses.iter().map(|p| p.improves.as_str()))
            ));
        }
        if !found.add_turns.is_empty() {
            let words = found.add_turns.iter().map(|t| t.words.as_str()).collect();
            out.push(format!(
                "turn it by a quarter about {} (level) -> {}",
                list(words),
                names(found.add_turns.iter().map(|t| t.improves.as_str()))
            ));
        }
        if let Some(error) = &found.gyro_refused {
            out.push(format!("gyro: {}", error.advice().unwrap_or_default()));
        }
        out
    }

    /// The result as a document.
    pub fn document(&self) -> Document {
        let found = &self.found;
        let mut out = Document::new();
        out.paragraph(self.verdict());
        for sensor in [Sensor::Accel, Sensor::Gyro] {
            let terms = terms_in(&found.parameters, sensor);
            if terms.is_empty() {
                continue;
            }
            let table = estimates_table(sensor, terms, &found.parameters);
            out.blank();
            out.table(table);
        }
        out.blank();
        out.paragraph(self.remarks());
        out.paragraph(self.not_determined());
        for (a, b, r) in found.confused.iter().take(4) {
            out.note(format!(
                "{a} and {b} can hardly be told apart (correlation {})",
                significant(*r, 3)
            ));
        }
        for note in self.notes() {
            out.note(note);
        }
        for text in self.advice() {
            out.hanging("add: ", text);
        }
        out
    }

    pub(super) fn verdict(&self) -> String {
        let found = &self.found;
        let mut out = format!(
            "{} still poses found (threshold {} m/s^2, chosen by itself), {}. |f| - g {} from {} to {} rms.",
            found.poses.len(),
            significant(found.threshold_m_s2, 2),
            duration(self.samples as f64 * self.dt_s),
            if found.accel_rms <= found.before_rms {
                "falls"
            } else {
                "goes"
            },
            in_g(found.before_rms),
            in_g(found.accel_rms)
        );
        if let Some(gyro) = found.gyro_rms {
            out.push_str(&format!(
                " {} turns are met within {} deg rms.",
                found.turns.len(),
                significant(gyro.to_degrees(), 2)
            ));
        }
        let scaled: Vec<&str> = found
            .fits
            .iter()
            .filter(|f| f.scaled)
            .map(|f| {
                if f.axis == "accel" {
                    "accelerometer"
                } else {
                    "gyro"
                }
            })
            .collect();
        if !scaled.is_empty() {
            out.push_str(&format!(
                " The {} scatters more than its noise says: the intervals are widened.",
                scaled.join(" and the ")
            ));
        }
        out
    }

    pub(super) fn remarks(&self) -> String {
        let mut out = format!(
            "Poses cover {:.0} % of the sphere. Body axes: {}. Misalignment and cross-axis response together. Gravity {}.",
            100.0 * self.found.covered,
            if self.request.fixture.is_some() {
                "those of the fixture, by the mounting of the model given (taken as exact)"
            } else {
                "x along the accelerometer's x, y in the plane of its x and y"
            },
            self.request.place.words(self.gravity_m_s2)
        );
        if self.request.place.is_default() {
            out.push_str(" 0.1 % of it is 1000 ppm in every accelerometer scale factor: give --gravity or --latitude.");
        }
        out
    }

    /// The terms held at zero, with the reason in words and what they may be.
    pub(super) fn not_determined(&self) -> String {
        let mut groups: Vec<(String, Vec<String>, Status)> = Vec::new();
        for held in self.found.held.iter().filter(|h| h.asked) {
            let stem = stem(&held.name);
            match groups
                .iter_mut()
                .find(|g| g.0 == stem && g.2 == held.status)
            {
                Some(group) => group.1.push(held.name.clone()),
                None => groups.push((stem, vec![held.name.clone()], held.status)),
            }
        }
        if groups.is_empty() {
            return "Every term that was asked for is determined; temperature, nonlinearity and axis offset are \
                    taken as zero."
                .to_owned();
        }
        let words: Vec<String> = groups
            .iter()
            .map(|(name, names, status)| {
                let reason = match status {
                    Status::NoInput => "no such input",
                    Status::Aliased => "looks like other terms here",
                    _ => "these poses and turns say too little",
                };
                let name = group_name(name, names, |s| {
                    self.found.parameters.iter().any(|p| stem(&p.name) == s)
                });
                format!("{name} ({reason})")
            })
            .collect();
        format!("Not determined, held at zero: {}.", words.join(", "))
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let found = &self.found;
        let mut out = Vec::new();
        for (i, pose) in found
            .poses
            .iter()
            .enumerate()
            .filter(|(_, p)| p.weight < 1.0)
        {
            out.push(format!(
                "pose {} (at {}) does not fit the others: |f| - g is {}, its weight {}",
                i + 1,
                clock(pose.start_s),
                in_g(pose.residual),
                significant(pose.weight, 2)
            ));
        }
        for (i, pair) in found.poses.windows(2).enumerate() {
            let turned = found
                .turns
                .iter()
                .any(|t| t.start_s >= pair[0].end_s - 1e-9 && t.end_s <= pair[1].start_s + 1e-9);
            if !turned && pair[1].start_s - pair[0].end_s < 1.0 {
                out.push(format!(
                    "a knock at {} splits pose {}; both parts count",
                    clock(pair[0].end_s),
                    i + 1
                ));
            }
        }
        for (i, turn) in found
            .turns
            .iter()
            .enumerate()
            .filter(|(_, t)| t.weight < 1.0)
        {
            out.push(format!(
                "turn {} (at {}) does not fit the others: its error is {} deg, its weight {}",
                i + 1,
                clock(turn.start_s),
                significant(turn.error_rad.to_degrees(), 2),
                significant(turn.weight, 2)
            ));
        }
        for [start_s, end_s] in &found.saturated {
            out.push(format!(
                "the turn at {} - {} is left out: the gyro saturates in it",
                clock(*start_s),
                clock(*end_s)
            ));
        }
        if let Some(error) = &found.gyro_refused {
            out.push(format!("the gyro was not calibrated: {error}"));
        }
        if let Some(drift) = &found.gyro_drift {
            let axes: Vec<String> = (0..3)
                .filter(|k| drift.rate_random_walk[*k] > 0.0)
                .map(|k| {
                    format!(
                        "{} {} deg/h/sqrt(h)",
                        ["x", "y", "z"][k],
                        significant(drift.rate_random_walk[k].to_degrees() * 3600.0 * 60.0, 2)
                    )
                })
                .collect();
            if !axes.is_empty() {
                out.push(format!(
                    "the gyro bias drifted between rests ({}); it is in the intervals, and the bias is its mean over \
                     the rests",
                    axes.join(", ")
                ));
            }
        }
        out
    }
}

/// A time of the log.
fn clock(s: f64) -> String {
    if (0.0..36_000.0).contains(&s) {
        format!("{:.0}:{:04.1}", (s / 60.0).floor(), s % 60.0)
    } else {
        format!("{s:.1} s")
    }
}

/// Names with their axes gathered, in the order in which they come.
fn names<'a>(all: impl Iterator<Item = &'a str>) -> String {
    let mut out: Vec<String> = Vec::new();
    for name in all {
        let word = stem(name);
        if !out.contains(&word) {
            out.push(word);
        }
    }
    out.join(", ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_of_a_log() {
        assert_eq!(super::clock(582.34), "9:42.3");
    }
}
