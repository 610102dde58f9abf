//! Words of the page: facts, what the log could not tell, the table that opens a page about several logs.

use super::levels;
use super::text::{findings, rival, verdict};
use super::{AxisOutcome, LogOutcome, key_of};
use crate::findings::gathered;
use sagnac_analysis::fit::{Status, Term};
use sagnac_core::Sensor;
use sagnac_report::html::{HtmlTable, Overview, Rich};
use sagnac_report::plots::axis_title;
use sagnac_report::svg::page_number;
use sagnac_report::text::{
    Unit, duration, fixed, general, group_thousands, is_note, seconds, significant, term_name,
};

/// The last part of a path: what a page calls a file.
pub(super) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\'])
        .next()
        .filter(|n| !n.is_empty())
        .unwrap_or(path)
}

/// The verdict with its subject in bold.
pub(super) fn rich_verdict(log: &LogOutcome) -> Rich {
    let mut text = verdict(log);
    for sensor in Sensor::ALL {
        let subject = format!("The {} is known:", sensor.name());
        text = text.replace(&subject, &format!("**{subject}**"));
    }
    Rich::marked(&text)
}

fn of_sensor(log: &LogOutcome, sensor: Sensor) -> Vec<&AxisOutcome> {
    log.axes.iter().filter(|a| a.sensor == sensor).collect()
}

/// Norm of the means of a triad; `None` unless there are three axes.
fn norm(axes: &[&AxisOutcome]) -> Option<f64> {
    if axes.len() != 3 {
        return None;
    }
    axes.iter()
        .map(|a| a.estimate.as_ref()?.mean.value.map(|v| v * v))
        .sum::<Option<f64>>()
        .map(f64::sqrt)
}

fn plural(count: usize, word: &str) -> String {
    if count == 1 {
        format!("1 {word}")
    } else {
        format!("{count} {word}s")
    }
}

/// Warnings and notes as the text counts them: many findings of a kind and channel are one.
fn told(log: &LogOutcome) -> (usize, usize) {
    let lines = gathered(findings(log));
    let notes = lines.iter().filter(|f| is_note(&f.kind)).count();
    (lines.len() - notes, notes)
}

/// Facts of a log in short.
pub(super) fn facts(log: &LogOutcome) -> Vec<(String, String)> {
    let fact = |name: &str, value: String| (name.to_owned(), page_number(&value));
    let sensors: Vec<(Vec<&AxisOutcome>, &str, Unit)> = [
        (Sensor::Gyro, "gyro", Unit::DEG_PER_S),
        (Sensor::Accel, "accel", Unit::G),
    ]
    .into_iter()
    .map(|(sensor, name, unit)| (of_sensor(log, sensor), name, unit))
    .filter(|(axes, ..)| !axes.is_empty())
    .collect();
    let channels: Vec<String> = sensors
        .iter()
        .map(|(axes, name, _)| format!("{} {name}", axes.len()))
        .collect();
    let ranges: Vec<String> = sensors
        .iter()
        .map(|(axes, _, unit)| {
            let most = axes
                .iter()
                .flat_map(|a| &a.series)
                .flat_map(|p| [p[1].abs(), p[3].abs()])
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max);
            format!("±{} {}", general(unit.from_si(most), 3), unit.page)
        })
        .collect();
    let mut out = vec![
        fact("Samples", group_thousands(&log.samples.to_string())),
        fact("Rate", format!("{} Hz", general(log.rate_hz, 5))),
        fact("Duration", seconds(log.duration_s)),
        fact("Channels", channels.join(", ")),
        fact("Range used", ranges.join(", ")),
    ];
    if let Some(force) = log.force_m_s2 {
        out.push(fact(
            "|f| at rest",
            format!("{} g", fixed(Unit::G.from_si(force), 3)),
        ));
    }
    out.push(fact(
        "Temperature",
        log.temperature_c.map_or_else(
            || "not recorded".to_owned(),
            |(_, low, high)| format!("{} … {} °C", fixed(low, 1), fixed(high, 1)),
        ),
    ));
    let (warnings, notes) = told(log);
    out.push(fact(
        "Findings",
        match (warnings, notes) {
            (0, 0) => "none".to_owned(),
            (w, 0) => plural(w, "warning"),
            (0, n) => plural(n, "note"),
            (w, n) => format!("{}, {}", plural(w, "warning"), plural(n, "note")),
        },
    ));
    out
}

/// What this log could not tell, and what would.
pub(super) fn limits(log: &LogOutcome, one_sensor: bool) -> Vec<Rich> {
    let mut out = Vec::new();
    let mut say = |bold: &str, rest: &str| {
        out.push(Rich::new().bold(bold).plain(format!(" {rest}")));
    };
    if log.temperature_c.is_none() {
        say(
            "Temperature.",
            "The log has no temperature channel, so a slow change of temperature would be counted as random walk \
             or bias instability. Record one.",
        );
    }
    if let Some(rate) = norm(&of_sensor(log, Sensor::Gyro)) {
        let rate = page_number(&significant(Unit::DEG_PER_H.from_si(rate), 3));
        say(
            "Earth rate.",
            &format!(
                "The mean rate is {rate} °/h; its 15 °/h of earth rate cannot be told from the bias without turning \
                 the sensor."
            ),
        );
    }
    let force = match (log.force_m_s2, levels::turn(log)) {
        (None, None) => String::new(),
        (Some(f), None) => {
            let g = Unit::G.from_si(f);
            format!(
                " |f| = {} g says that scale factor or bias is off by about {} % of g, not which.",
                fixed(g, 3),
                significant(100.0 * (g - 1.0).abs(), 2)
            )
        }
        (_, Some(_)) => " The sensor was turned: |f| is that of several attitudes.".to_owned(),
    };
    say(
        "Scale factor, misalignment, g-sensitivity.",
        &format!("Not observable at rest.{force}"),
    );
    terms(log, &mut say);
    if !one_sensor {
        out.push(
            Rich::new()
                .bold("Run-to-run bias.")
                .plain(" One run shows one bias. Record five or more switch-ons and add ")
                .code("--one-sensor")
                .plain("."),
        );
    }
    out
}

/// The name of a term that begins a sentence.
fn sentence_start(key: &str) -> &str {
    match key {
        "gauss_markov" => "A Gauss–Markov process",
        other => term_name(other),
    }
}

/// Terms that were not seen, that are known poorly, that cannot be told apart.
fn terms(log: &LogOutcome, say: &mut impl FnMut(&str, &str)) {
    let mut unseen = Vec::new();
    for axis in &log.axes {
        let Some(estimate) = &axis.estimate else {
            continue;
        };
        let title = axis_title(&axis.axis).to_lowercase();
        for term in [Term::White, Term::Flicker, Term::RandomWalk] {
            let name = term_name(key_of(axis.sensor, term));
            let Some(e) = estimate.term(term) else {
                continue;
            };
            if e.status == Status::UpperLimit {
                unseen.push(format!("{} of {title}", name.to_lowercase()));
            }
            if let (Some(v), Some(l), Some(u)) = (e.value.filter(|v| *v > 0.0), e.lower, e.upper) {
                let half = 0.5 * (u - l) / v;
                if half > 0.6 {
                    say(
                        &format!("{name} of {title}"),
                        &format!(
                            "is known to ±{} % only. A longer log would narrow it; sagnac plan says by how much.",
                            significant(100.0 * half, 2)
                        ),
                    );
                }
            }
        }
        for &(a, b) in &estimate.confused {
            let (other, which) = rival(axis.sensor, b, &estimate.gauss_markov);
            say(
                &format!("{} of {title}", sentence_start(key_of(axis.sensor, a))),
                &format!("cannot be told from {other} in this log; {which} bounded from above."),
            );
        }
    }
    if !unseen.is_empty() {
        say(
            "Not seen:",
            &format!("{}. The limits stand in the table.", unseen.join(", ")),
        );
    }
}

/// The table that opens a page about several logs.
pub(super) fn overview(logs: &[LogOutcome]) -> Overview {
    let mut table = HtmlTable::new(
        "overview",
        &[
            "Log",
            "Length",
            "Rate",
            "Findings",
            "Gyro N, °/√h",
            "Accelerometer N, m/s/√h",
        ],
        &[],
    );
    for log in logs {
        let white = |sensor: Sensor, unit: Unit| -> String {
            let values: Vec<String> = of_sensor(log, sensor)
                .iter()
                .map(|a| {
                    a.estimate
                        .as_ref()
                        .and_then(|e| e.white.value)
                        .map_or_else(|| "—".to_owned(), |v| significant(unit.from_si(v), 3))
                })
                .collect();
            page_number(&values.join("  "))
        };
        let (warnings, _) = told(log);
        table.row(vec![
            file_name(&log.name).into(),
            duration(log.duration_s).into(),
            format!("{} Hz", general(log.rate_hz, 5)).into(),
            plural(warnings, "warning").into(),
            white(Sensor::Gyro, Unit::DEG_PER_SQRT_H).into(),
            white(Sensor::Accel, Unit::M_PER_S_PER_SQRT_H).into(),
        ]);
    }
    Overview {
        lead: "White noise of x, y, z side by side.".to_owned(),
        table,
    }
}
