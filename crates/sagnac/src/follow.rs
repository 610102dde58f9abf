//! A log that is still being recorded: what is known so far, how well, and how long until a wanted precision.
//!
//! A precision is 1 σ over the value, as in [`plan`](crate::plan); the length that it needs is the bound of what was
//! estimated so far.

use crate::Error;
use crate::characterize::{AxisOutcome, LogOutcome, estimates_table, key_of, shown, shown_sensor};
use crate::plan::planned;
use sagnac_analysis::fit::{Candidates, Estimate, Term};
use sagnac_analysis::plan::duration_for;
use sagnac_core::Sensor;
use sagnac_report::text::{
    Curve, Document, Table, Unit, curves, duration, general, group_thousands, term_name,
    term_symbol,
};
use std::fmt::Write as _;

/// Samples below which nothing is estimated.
pub const LEAST_SAMPLES: usize = 64;

/// Precisions that are shown where none was asked for.
const USUAL: [(&str, f64); 3] = [
    ("angle_random_walk", 0.05),
    ("velocity_random_walk", 0.05),
    ("bias_instability", 0.05),
];

/// How far a wanted precision is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Left {
    /// It is reached.
    Nothing,
    /// About so long from now, in s.
    Time(f64),
    /// Not within a year of recording.
    TooLong,
    /// The term is not seen yet.
    NotSeen,
}

/// A term of one sensor, on the axis that knows it worst.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// JSON name.
    pub name: String,
    /// The axis.
    pub axis: String,
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// The estimate, in SI.
    pub estimate: Estimate,
    /// 1 σ over the value, where it is known.
    pub relative: Option<f64>,
    /// What is wanted of `relative`; none where the term is shown along.
    pub wanted: Option<f64>,
    /// How far that is.
    pub left: Left,
    /// Axes of the sensor that do not have the term: nothing waits for them.
    pub without: Vec<String>,
}

/// What is known so far.
#[derive(Debug, Clone)]
pub struct State<'a> {
    log: &'a LogOutcome,
    /// Every wanted term of every sensor, then the white noise of the others.
    pub terms: Vec<Tracked>,
    is_asked: bool,
}

/// Refuses precisions that these sensors or candidates cannot give.
///
/// # Errors
/// A wanted term that no sensor of the log has, or that is not looked for.
pub fn check(
    wanted: &[(String, f64)],
    sensors: &[Sensor],
    candidates: &Candidates,
) -> Result<(), Error> {
    for (name, _) in wanted {
        let of = |sensor: Sensor| {
            ALL.into_iter()
                .find(|&(term, own)| own.unwrap_or(key_of(sensor, term)) == name)
                .map(|(term, _)| term)
        };
        let Some(term) = Sensor::ALL.into_iter().find_map(of) else {
            continue;
        };
        let mut with = *candidates;
        with.allow(term);
        if with != *candidates {
            return Err(Error::usage(format!("{name} is not looked for"))
                .at("--until and --terms")
                .advise("name it in --terms too, or leave --terms out"));
        }
        if !sensors.iter().any(|&s| of(s).is_some()) {
            let (missing, other) = if sensors.contains(&Sensor::Gyro) {
                (Sensor::Accel, Sensor::Gyro)
            } else {
                (Sensor::Gyro, Sensor::Accel)
            };
            let instead = if sensors.is_empty() {
                "look at what is recorded, or name columns".to_owned()
            } else {
                format!("ask for {}, the {}'s", key_of(other, term), other.name())
            };
            return Err(Error::data(format!(
                "the log has no {}, so {name} can never be known",
                missing.name()
            ))
            .at("--until")
            .advise(instead));
        }
    }
    Ok(())
}

/// Terms that a precision can be asked of, with the name of those that no sensor names by itself.
const ALL: [(Term, Option<&str>); 7] = [
    (Term::Quantization, None),
    (Term::White, None),
    (Term::Flicker, None),
    (Term::RandomWalk, None),
    (Term::Ramp, None),
    (Term::GaussMarkov, None),
    (Term::GaussMarkov, Some("correlation_time")),
];

/// The estimates of an axis that a name stands for: the detected ones first.
fn estimates<'a>(axis: &'a AxisOutcome, name: &str) -> Vec<&'a Estimate> {
    let Some(e) = &axis.estimate else {
        return Vec::new();
    };
    for (term, own) in ALL {
        if own.unwrap_or(key_of(axis.sensor, term)) != name {
            continue;
        }
        if term != Term::GaussMarkov {
            return e.term(term).into_iter().collect();
        }
        let pick = |g: &'a sagnac_analysis::fit::GaussMarkovEstimate| {
            if own.is_some() {
                &g.correlation_time_s
            } else {
                &g.sigma
            }
        };
        return e.gauss_markov.iter().map(pick).collect();
    }
    Vec::new()
}

fn relative(e: &Estimate) -> Option<f64> {
    if !e.is_detected() {
        return None;
    }
    Some(e.sigma? / e.value?.abs())
}

impl<'a> State<'a> {
    /// What a log says so far of what is wanted; of white noise and bias instability where nothing is.
    pub fn of(log: &'a LogOutcome, wanted: Option<&[(String, f64)]>) -> Self {
        let list: Vec<(String, Option<f64>)> = match wanted {
            Some(list) => list.iter().map(|(n, w)| (n.clone(), Some(*w))).collect(),
            None => USUAL.map(|(n, w)| (n.to_owned(), Some(w))).to_vec(),
        };
        let mut terms = Vec::new();
        for sensor in Sensor::ALL {
            let axes: Vec<&AxisOutcome> = log.axes.iter().filter(|a| a.sensor == sensor).collect();
            let white = key_of(sensor, Term::White);
            let mut names = list.clone();
            if !names.iter().any(|(name, _)| name == white) {
                names.push((white.to_owned(), None));
            }
            for (name, wanted) in names {
                terms.extend(tracked(&axes, &name, wanted, log));
            }
        }
        terms.sort_by_key(|t| t.wanted.is_none());
        Self {
            log,
            terms,
            is_asked: wanted.is_some(),
        }
    }

    /// Whether every wanted precision is reached on every axis that has the term, and each is had by some axis.
    pub fn is_reached(&self) -> bool {
        let wanted = || self.terms.iter().filter(|t| t.wanted.is_some());
        self.is_asked
            && wanted().all(|t| {
                let same = wanted().filter(|o| o.name == t.name);
                let mut seen = same.filter(|o| o.left != Left::NotSeen).peekable();
                seen.peek().is_some() && seen.all(|o| o.left == Left::Nothing)
            })
    }

    /// Where all is reached, the axes that do not have a wanted term: they were not waited for.
    fn not_waited_for(&self) -> Option<String> {
        let open = |t: &&Tracked| t.wanted.is_some() && !t.without.is_empty();
        let parts: Vec<String> = self
            .terms
            .iter()
            .filter(open)
            .map(|t| {
                let symbol = term_symbol(&t.name).unwrap_or_else(|| term_name(&t.name));
                let ends = t.without.iter().map(|axis| {
                    let end = axis.rsplit_once('_');
                    end.map_or(axis.as_str(), |(_, end)| end)
                });
                let ends: Vec<&str> = ends.collect();
                format!("{symbol} of {} {}", t.sensor.key(), ends.join(", "))
            })
            .collect();
        (self.is_reached() && !parts.is_empty())
            .then(|| format!("not seen and not waited for: {}", parts.join("; ")))
    }

    /// Number of precisions that are reached.
    pub fn reached(&self) -> usize {
        let all = self.terms.iter();
        all.filter(|t| t.wanted.is_some() && t.left == Left::Nothing)
            .count()
    }

    /// Samples at which all that was seen is expected to be reached; none where nothing is left, or it is too long.
    pub fn needed_samples(&self) -> Option<usize> {
        let left = self.terms.iter().filter_map(|t| match t.left {
            Left::Time(s) => Some(s),
            _ => None,
        });
        let longest = left.fold(0.0, f64::max);
        (longest > 0.0)
            .then(|| ((self.log.duration_s + longest) * self.log.rate_hz).ceil() as usize)
    }

    /// One sentence.
    pub fn line(&self) -> String {
        let mut parts = Vec::new();
        for t in &self.terms {
            let unit = unit_of(t);
            let symbol = term_symbol(&t.name).unwrap_or_else(|| term_name(&t.name));
            let mut text = if t.left == Left::NotSeen {
                let limit = shown(&t.estimate).scaled(unit.per_si);
                let limit = match limit.status() {
                    "upper_limit" => format!(", {limit} {}", unit.text),
                    _ => String::new(),
                };
                format!("{} {symbol} not seen yet{limit}", t.sensor.key())
            } else {
                format!(
                    "{} {symbol} {} {}, 1 sigma {}",
                    t.axis.replace('_', " "),
                    shown(&t.estimate).scaled(unit.per_si),
                    unit.text,
                    t.relative.map_or("-".to_owned(), percent),
                )
            };
            match (t.left, t.wanted) {
                (Left::Time(s), Some(wanted)) => {
                    let _ = write!(text, " ({} in {})", exact(wanted), about(s));
                }
                (Left::TooLong, Some(wanted)) => {
                    let _ = write!(text, " ({} not within a year)", exact(wanted));
                }
                _ => {}
            }
            parts.push(text);
        }
        parts.extend(self.not_waited_for());
        format!(
            "{} read; {}",
            duration(self.log.duration_s.round()),
            parts.join("; ")
        )
    }

    /// What a terminal shows while the log grows: precisions, estimates, Allan curves.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        out.heading(format!(
            "{}: {}, {} samples at {} Hz",
            self.log.name,
            duration(self.log.duration_s.round()),
            group_thousands(&self.log.samples.to_string()),
            general(self.log.rate_hz, 4)
        ));
        out.blank();
        out.table(self.precisions());
        for sensor in Sensor::ALL {
            let axes: Vec<&AxisOutcome> = self
                .log
                .axes
                .iter()
                .filter(|a| a.sensor == sensor)
                .collect();
            if !axes.is_empty() {
                out.blank();
                out.table(estimates_table(&axes, sensor));
            }
        }
        out.blank();
        for line in self.curves() {
            out.line(line);
        }
        if let Some(others) = self.not_waited_for() {
            out.blank().note(others);
        }
        out
    }

    fn precisions(&self) -> Table {
        let mut table = Table::new(&["1 sigma, worst axis", "now", "wanted", "in"], &[]);
        for t in self.terms.iter().filter(|t| t.wanted.is_some()) {
            table.row([
                format!(
                    "{} {}",
                    t.axis.replace('_', " "),
                    term_name(&t.name).to_lowercase()
                ),
                t.relative.map_or("not seen yet".to_owned(), percent),
                t.wanted.map_or(String::new(), exact),
                match t.left {
                    Left::Nothing => "reached".to_owned(),
                    Left::Time(s) => about(s),
                    Left::TooLong => "over a year".to_owned(),
                    Left::NotSeen => "-".to_owned(),
                },
            ]);
        }
        table
    }

    /// Allan curves of the sensors, side by side.
    fn curves(&self) -> Vec<String> {
        const ROWS: usize = 7;
        let sensors: Vec<Sensor> = Sensor::ALL
            .into_iter()
            .filter(|s| self.log.axes.iter().any(|a| a.sensor == *s))
            .collect();
        let wide = if sensors.len() > 1 { 38 } else { 60 };
        let mut out: Vec<String> = Vec::new();
        for sensor in sensors {
            let unit = Unit::of_term(shown_sensor(sensor), "mean");
            let own: Vec<Curve> = self
                .log
                .axes
                .iter()
                .filter(|a| a.sensor == sensor)
                .filter_map(|a| {
                    let curve = a.allan.as_ref()?;
                    // One difference alone may lie anywhere.
                    let known = |k: &usize| curve.edf[*k].is_none_or(|edf| edf >= 2.0);
                    let places = (0..curve.tau_s.len()).filter(known);
                    Some(Curve {
                        mark: ['x', 'y', 'z'][a.index],
                        points: places
                            .map(|k| (curve.tau_s[k], curve.deviation[k] * unit.per_si))
                            .collect(),
                    })
                })
                .collect();
            let title = format!("Allan deviation, {}, against tau, s", unit.text);
            let lines = curves(&title, &own, wide, ROWS);
            if out.is_empty() {
                out = lines;
                continue;
            }
            for (left, right) in out.iter_mut().zip(lines) {
                *left = format!("{left:<40}{right}");
            }
        }
        out
    }
}

/// The axis that knows a term worst; where none knows it, the one with the largest limit.
fn tracked(
    axes: &[&AxisOutcome],
    name: &str,
    wanted: Option<f64>,
    log: &LogOutcome,
) -> Option<Tracked> {
    let all: Vec<(&AxisOutcome, &Estimate)> = axes
        .iter()
        .flat_map(|a| estimates(a, name).into_iter().map(move |e| (*a, e)))
        .collect();
    let (axis, estimate) = all
        .iter()
        .max_by(|a, b| {
            let key = |e: &Estimate| (relative(e).unwrap_or(-1.0), e.upper.unwrap_or(-1.0));
            let (a, b) = (key(a.1), key(b.1));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
        .copied()?;
    let known = relative(estimate);
    let left = match (known, wanted) {
        (None, _) => Left::NotSeen,
        (Some(now), Some(wanted)) if now > wanted => {
            // What the axes that are not there yet need, by the bound.
            let mut most: Option<f64> = Some(0.0);
            for axis in axes {
                let open = estimates(axis, name);
                if open.iter().all(|e| relative(e).is_none_or(|r| r <= wanted)) {
                    continue;
                }
                let Some(own) = axis.estimate.as_ref() else {
                    continue;
                };
                let terms = planned(name, axis.sensor, &own.fitted);
                let terms: Vec<_> = terms.into_iter().map(|t| (t, wanted)).collect();
                let need = duration_for(&own.fitted, 1.0 / log.rate_hz, &terms);
                most = most.zip(need).map(|(m, n)| m.max(n));
            }
            match most {
                // The bound is passed: the estimate scatters about it.
                Some(need) => Left::Time((need - log.duration_s).max(0.01 * log.duration_s)),
                None => Left::TooLong,
            }
        }
        _ => Left::Nothing,
    };
    Some(Tracked {
        name: name.to_owned(),
        axis: axis.axis.clone(),
        sensor: axis.sensor,
        estimate: *estimate,
        relative: known,
        wanted,
        left,
        without: axes
            .iter()
            .filter(|a| {
                estimates(a, name)
                    .into_iter()
                    .all(|e| relative(e).is_none())
            })
            .map(|a| a.axis.clone())
            .collect(),
    })
}

fn unit_of(t: &Tracked) -> Unit {
    if t.name == "correlation_time" {
        Unit::S
    } else {
        Unit::of_term(shown_sensor(t.sensor), &t.name)
    }
}

/// A share as percent, two digits.
fn percent(share: f64) -> String {
    format!("{} %", sagnac_report::text::significant(100.0 * share, 2))
}

/// What was asked for, every digit.
fn exact(share: f64) -> String {
    format!("{} %", general(100.0 * share, 12))
}

/// A time to come: two digits do.
fn about(seconds: f64) -> String {
    if seconds < 60.0 {
        return duration(seconds.ceil());
    }
    let unit = if seconds < 3600.0 { 10.0 } else { 60.0 };
    duration((seconds / unit).ceil() * unit)
}
