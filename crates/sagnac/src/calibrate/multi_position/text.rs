//! `calibrate multi-position` in a terminal: what was found, the tables, what was not determined, how to turn next.

use sagnac_calibrate::stations::Status;
use sagnac_core::Sensor;
use sagnac_report::text::{Document, significant};

use super::MultiPositionOutcome;
use super::clock;
use crate::calibrate::text::{estimates_table, group_name, in_g, short, stem, terms_in};

/// Poses and turns to add that are told at once.
const SHOWN: usize = 4;

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
        let list = |words: Vec<&str>| words.join(", then ");
        if !found.add_poses.is_empty() {
            let shown = || found.add_poses.iter().take(SHOWN);
            let words = shown().map(|p| p.words.as_str()).collect();
            out.push(format!(
                "turn it so next: {} up -> {}",
                list(words),
                names(shown().map(|p| p.improves.as_str()))
            ));
        }
        if !found.add_turns.is_empty() {
            let shown = || found.add_turns.iter().take(SHOWN);
            let words = shown().map(|t| t.words.as_str()).collect();
            out.push(format!(
                "turn it by a quarter about {} (level) -> {}",
                list(words),
                names(shown().map(|t| t.improves.as_str()))
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
            out.push_str(&scatter(&scaled));
        }
        out
    }

    pub(super) fn remarks(&self) -> String {
        let mut out = format!(
            "Poses cover {:.0} % of the sphere. Body axes: {}. Misalignment and cross-axis response together. Gravity {}.",
            100.0 * self.found.covered,
            self.frame_words(),
            self.request.place.words(self.gravity_m_s2)
        );
        if self.request.place.is_default() {
            out.push_str(" 0.1 % of it is 1000 ppm in every accelerometer scale factor: give --gravity or --latitude.");
        }
        out
    }

    /// The axes that the result holds for.
    pub(super) fn frame_words(&self) -> String {
        if self.request.fixture.is_none() {
            return "x along the accelerometer's x, y in the plane of its x and y".to_owned();
        }
        if self.request.unmeasured.is_empty() {
            return "those of the fixture, by the mounting of the model given (taken as exact)"
                .to_owned();
        }
        format!(
            "those of the fixture as far as {} is zero, which the model given does not determine",
            short(&self.request.unmeasured)
        )
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
            return format!(
                "Every term that was asked for is determined; {}.",
                self.taken()
            );
        }
        let mut by_reason: Vec<(&str, Vec<String>)> = Vec::new();
        for (name, names, status) in &groups {
            let refused = self.found.gyro_refused.is_some() && name.starts_with("gyro.");
            let reason = match status {
                _ if refused => "the gyro was not calibrated",
                Status::NoInput => "no such input",
                Status::Aliased => "looks like other terms here",
                _ => "these poses and turns say too little",
            };
            let name = group_name(name, names, |s| {
                self.found.parameters.iter().any(|p| stem(&p.name) == s)
            });
            match by_reason.last_mut() {
                Some((last, names)) if *last == reason => names.push(name),
                _ => by_reason.push((reason, vec![name])),
            }
        }
        let words: Vec<String> = by_reason
            .iter()
            .map(|(reason, names)| format!("{} ({reason})", names.join(", ")))
            .collect();
        format!(
            "Not determined, held at zero: {}. Besides, {}.",
            words.join(", "),
            self.taken()
        )
    }

    /// What no hand-turned log tells, as far as the sensors of the log have it.
    fn taken(&self) -> &'static str {
        if self.found.held.iter().any(|h| h.name.starts_with("gyro.")) {
            "temperature, nonlinearity, g2-sensitivity and axis offset are taken as zero"
        } else {
            "temperature, nonlinearity and axis offset are taken as zero"
        }
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let found = &self.found;
        let mut out = self.faults();
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
            let broken = found.broken.iter().any(|b| b.span_s[0] == pair[0].end_s);
            if !turned && !broken && pair[1].start_s - pair[0].end_s < 1.0 {
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
        for [start_s, end_s] in &found.turning {
            out.push(format!(
                "{} - {} is no rest: it is steady, but the sensor turns in it",
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
                    let shown = |v: f64| significant(v.to_degrees() * 3600.0 * 60.0, 2);
                    format!(
                        "{} {} deg/h/sqrt(h), 95 % {} ... {}",
                        ["x", "y", "z"][k],
                        shown(drift.rate_random_walk[k]),
                        shown(drift.interval[k][0]),
                        shown(drift.interval[k][1])
                    )
                })
                .collect();
            if !axes.is_empty() {
                out.push(format!(
                    "the gyro bias drifted between rests ({}); it is in the intervals, and the bias is its mean over \
                     the rests",
                    axes.join("; ")
                ));
            }
        }
        out
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

/// That sensors scatter more than their noise says.
fn scatter(sensors: &[&str]) -> String {
    let who = match sensors {
        [one] => format!("{one} scatters more than its"),
        all => format!("{} scatter more than their", all.join(" and the ")),
    };
    format!(" The {who} noise says: the intervals are widened.")
}

#[cfg(test)]
mod tests {
    use super::scatter;

    #[test]
    fn one_sensor_scatters_and_two_scatter() {
        assert!(scatter(&["gyro"]).contains("The gyro scatters more than its noise"));
        let both = scatter(&["accelerometer", "gyro"]);
        assert!(both.contains("The accelerometer and the gyro scatter more than their noise"));
    }
}
