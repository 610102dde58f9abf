//! The outcome in a terminal: the answer first, a table a sensor, findings, what the log could not tell.

use super::page_regressors::temperature_of;
use super::{AxisOutcome, LogOutcome, Outcome, key_of, levels};
use crate::findings::{gathered, sensor};
use sagnac_analysis::fit::{Estimate, GaussMarkovEstimate, Status, Term};
use sagnac_core::Sensor;
use sagnac_log::{Issue, IssueKind};
use sagnac_report::text::{
    Document, Estimate as Shown, Finding, Role, Sensor as ShownSensor, Table, Unit, general,
    group_numbers, term_in_sentence, term_name,
};
use std::fmt::Write as _;

pub(crate) fn shown_sensor(sensor: Sensor) -> ShownSensor {
    match sensor {
        Sensor::Gyro => ShownSensor::Gyro,
        Sensor::Accel => ShownSensor::Accel,
    }
}

/// An estimate in SI as the report shows it.
pub(crate) fn shown(e: &Estimate) -> Shown {
    match e.status {
        Status::Detected => match (e.value, e.lower, e.upper) {
            (Some(v), Some(l), Some(u)) => Shown::detected(v, l, u),
            (Some(v), ..) => Shown::Value(v),
            _ => Shown::Absent,
        },
        Status::UpperLimit => e.upper.map_or(Shown::Absent, Shown::upper_limit),
        Status::Absent => Shown::Absent,
    }
}

pub(super) fn outcome(outcome: &Outcome) -> Document {
    let mut out = Document::new();
    let several = outcome.logs.len() > 1;
    if several {
        overview(outcome, &mut out);
    }
    if let Some(axes) = &outcome.sensor {
        super::pooled_text::add(outcome, axes, &mut out);
        closing(outcome, &mut out);
        return out;
    }
    for log in &outcome.logs {
        if several {
            out.blank();
            out.heading(log.name.clone());
        }
        one(log, &mut out);
    }
    closing(outcome, &mut out);
    out
}

fn overview(outcome: &Outcome, out: &mut Document) {
    let n = outcome.logs.len();
    let what = if outcome.sensor.is_some() {
        "logs of one sensor"
    } else {
        "logs"
    };
    let numbers = super::pooled_text::runs_with_numbers(outcome);
    let of = match numbers.filter(|&k| k < n) {
        Some(k) => format!(", {k} with numbers"),
        None => String::new(),
    };
    if outcome.outliers.is_empty() {
        out.paragraph(format!("{n} {what}{of}; none differs from the others."));
    } else {
        let named = |log: &usize| outcome.outliers.iter().any(|o| o.log == *log);
        let names: Vec<&str> = (0..n)
            .filter(named)
            .map(|log| outcome.logs[log].name.as_str())
            .collect();
        let differ = match names.len() {
            1 => "differs from the others",
            all if all == n => "have no terms in common",
            _ => "differ from the others",
        };
        out.verdict(
            Role::Warning,
            format!("{n} {what}{of}; {} {differ}.", names.join(", ")),
        );
    }
    out.blank();
    for sentence in outcome.differences() {
        out.warning(sentence);
    }
}

fn one(log: &LogOutcome, out: &mut Document) {
    out.paragraph(verdict(log));
    for sensor in Sensor::ALL {
        let axes: Vec<&AxisOutcome> = log.axes.iter().filter(|a| a.sensor == sensor).collect();
        if axes.is_empty() {
            continue;
        }
        out.blank();
        out.table(table(&axes, sensor));
    }
    remarks(log, out);
}

/// What was found in a log and what speaks against its numbers.
pub(crate) fn remarks(log: &LogOutcome, out: &mut Document) {
    beside(log, true, out);
}

/// The same; of terms that cannot be told apart only where `terms` are shown.
pub(super) fn beside(log: &LogOutcome, terms: bool, out: &mut Document) {
    let findings = gathered(findings(log));
    if !findings.is_empty() {
        out.blank();
        out.findings(findings);
    }
    let mut blank = true;
    for axis in &log.axes {
        let Some(e) = &axis.estimate else { continue };
        for finding in &e.findings {
            if finding.kind == sagnac_analysis::fit::FindingKind::Misfit {
                if std::mem::take(&mut blank) {
                    out.blank();
                }
                out.warning(format!("{}: {}", axis.axis, finding.text));
            }
        }
        for &(a, b) in e.confused.iter().filter(|_| terms) {
            if std::mem::take(&mut blank) {
                out.blank();
            }
            let (other, which) = rival(axis.sensor, b, &e.gauss_markov);
            out.note(format!(
                "{}: this log cannot tell {} from {other}; {which} bounded from above.",
                axis.axis,
                term_in_sentence(key_of(axis.sensor, a)),
            ));
        }
    }
    for note in &log.notes {
        out.note(note.clone());
    }
}

/// The second of two terms that cannot be told apart, and which of them are bounded: beside a process that was found the
/// second is one more.
pub(super) fn rival(
    sensor: Sensor,
    term: Term,
    found: &[GaussMarkovEstimate],
) -> (String, &'static str) {
    let is_more = term == Term::GaussMarkov && found.iter().any(|g| g.sigma.is_detected());
    if is_more {
        ("one more Gauss-Markov process".to_owned(), "the former is")
    } else {
        (term_in_sentence(key_of(sensor, term)), "both are")
    }
}

/// The estimates of a sensor's axes, a term a row.
pub(crate) fn table(axes: &[&AxisOutcome], sensor: Sensor) -> Table {
    let shown_as = shown_sensor(sensor);
    let mut heading = vec![shown_as.title()];
    heading.extend(axes.iter().map(|a| ["x", "y", "z"][a.index]));
    heading.push("");
    let mut table = Table::estimates(&heading);
    for term in [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ] {
        let cells: Vec<Estimate> = axes
            .iter()
            .map(|a| {
                a.estimate
                    .as_ref()
                    .and_then(|e| e.term(term))
                    .copied()
                    .unwrap_or(Estimate::ABSENT)
            })
            .collect();
        let usual = matches!(term, Term::White | Term::Flicker | Term::RandomWalk);
        let seen = cells.iter().any(Estimate::is_detected);
        if !(seen || usual && cells.iter().any(|c| c.status != Status::Absent)) {
            continue;
        }
        let key = key_of(sensor, term);
        row(
            &mut table,
            short_name(key),
            Unit::of_term(shown_as, key),
            &cells,
        );
    }
    let most = axes.iter().map(|a| markov_of(a).count()).max().unwrap_or(0);
    for place in 0..most {
        let pick = |time: bool| -> Vec<Estimate> {
            axes.iter()
                .map(|a| {
                    // Where one axis has the term the limits of the others stand beside it.
                    let limit = a.estimate.iter().flat_map(|e| &e.gauss_markov);
                    let mut limit = limit.filter(|g| !g.sigma.is_detected() && place == 0);
                    markov_of(a)
                        .nth(place)
                        .or_else(|| limit.next())
                        .map_or(Estimate::ABSENT, |g| {
                            if time { g.correlation_time_s } else { g.sigma }
                        })
                })
                .collect()
        };
        let name = if most > 1 {
            format!("Gauss-Markov {}", place + 1)
        } else {
            "Gauss-Markov sigma".to_owned()
        };
        row(
            &mut table,
            &name,
            Unit::of_term(shown_as, "gauss_markov"),
            &pick(false),
        );
        row(&mut table, "  correlation time", Unit::S, &pick(true));
    }
    for axis_regressors in [0, 1] {
        // Temperature coefficients of power 1 and 2, where any axis has them.
        let power = axis_regressors + 1;
        let cells: Vec<Estimate> = axes.iter().map(|a| temperature_of(a, power)).collect();
        temperature_row(&mut table, power, shown_as, &cells);
    }
    let means: Vec<Estimate> = axes
        .iter()
        .map(|a| a.estimate.as_ref().map_or(Estimate::ABSENT, levels::mean))
        .collect();
    row(&mut table, "Mean", Unit::of_term(shown_as, "mean"), &means);
    let mut fit: Vec<sagnac_report::text::Cell> = vec!["Fit".into()];
    for axis in axes {
        fit.push(
            axis.estimate
                .as_ref()
                .and_then(|e| e.p_value)
                .map_or_else(|| "-".to_owned(), probability)
                .into(),
        );
    }
    fit.push("p".into());
    table.row(fit);
    table
}

/// Coefficients of a power of the temperature, where any axis has one.
pub(super) fn temperature_row(
    table: &mut Table,
    power: usize,
    shown_as: ShownSensor,
    cells: &[Estimate],
) {
    if !cells.iter().any(Estimate::is_detected) {
        return;
    }
    let unit = Unit::of_term(shown_as, "mean");
    let (name, per) = if power == 1 {
        ("Bias per K", "/K")
    } else {
        ("Bias per K^2", "/K^2")
    };
    let mut texts: Vec<sagnac_report::text::Cell> = vec![name.into()];
    texts.extend(cells.iter().map(|c| shown(c).scaled(unit.per_si).into()));
    texts.push(format!("{}{per}", unit.text).into());
    table.row(texts);
}

/// A probability: two decimals, three below 0.01, `< 0.001`.
pub(super) fn probability(p: f64) -> String {
    if p < 0.001 {
        "< 0.001".to_owned()
    } else if p < 0.01 {
        format!("{p:.3}")
    } else {
        format!("{p:.2}")
    }
}

fn markov_of(
    axis: &AxisOutcome,
) -> impl Iterator<Item = &sagnac_analysis::fit::GaussMarkovEstimate> {
    axis.estimate
        .iter()
        .flat_map(|e| &e.gauss_markov)
        .filter(|g| g.sigma.is_detected())
}

/// Names that leave room for three axes.
pub(super) fn short_name(key: &str) -> &str {
    match key {
        "acceleration_random_walk" => "Accel. random walk",
        other => term_name(other),
    }
}

pub(super) fn row(table: &mut Table, name: &str, unit: Unit, cells: &[Estimate]) {
    let mut texts: Vec<sagnac_report::text::Cell> = vec![name.into()];
    texts.extend(cells.iter().map(|c| shown(c).scaled(unit.per_si).into()));
    texts.push(unit.text.into());
    table.row(texts);
}

/// An interval of white noise wider than this, in %, is no knowledge to speak of.
const ROUGH: f64 = 20.0;

/// A few sentences a sensor: how well what is known, and whether anything speaks against it.
pub(super) fn verdict(log: &LogOutcome) -> String {
    let mut sentences = Vec::new();
    for sensor in Sensor::ALL {
        let axes: Vec<&AxisOutcome> = log.axes.iter().filter(|a| a.sensor == sensor).collect();
        if axes.is_empty() {
            continue;
        }
        let status = |term: Term, status: Status| {
            axes.iter()
                .filter_map(|a| a.estimate.as_ref()?.term(term))
                .any(|e| e.status == status)
        };
        // Terms that were not asked for are absent: nothing is said of them.
        let asked = |term: Term| !status(term, Status::Absent);
        let others = [
            Term::Quantization,
            Term::Flicker,
            Term::RandomWalk,
            Term::Ramp,
        ];
        let white_asked = asked(Term::White) || !others.into_iter().any(asked);
        if white_asked && !status(Term::White, Status::Detected) {
            sentences.push(format!(
                "The {} gives no white noise from this log.",
                sensor.name()
            ));
            continue;
        }
        let mut known = Vec::new();
        let mut bounded = Vec::new();
        let mut white = 0.0;
        for (term, name) in [
            (Term::White, "white noise"),
            (Term::Flicker, "bias instability"),
            (Term::RandomWalk, "random walk"),
        ] {
            let widths: Vec<(usize, f64)> = axes
                .iter()
                .filter_map(|a| {
                    let e = a.estimate.as_ref()?.term(term)?;
                    Some((a.index, 50.0 * (e.upper? - e.lower?) / e.value?))
                })
                .collect();
            if widths.is_empty() {
                if status(term, Status::UpperLimit) {
                    bounded.push(name);
                }
                continue;
            }
            let (low, high) = widths
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(l, h), &(_, w)| {
                    (l.min(w), h.max(w))
                });
            if term == Term::White {
                white = high;
            }
            let on = if widths.len() < axes.len() {
                let names: Vec<&str> = widths.iter().map(|w| ["x", "y", "z"][w.0]).collect();
                format!(" on {} alone", names.join(" and "))
            } else {
                String::new()
            };
            known.push(format!("{name} to {}{on}", range(low, high)));
        }
        let is_of = |i: &&Issue| match i.channel.as_deref() {
            Some(channel) => channel.starts_with(sensor.key()),
            // What is told of the log as a whole is told of both.
            None => [sensor.key(), "log"].contains(&crate::findings::sensor(i)),
        };
        let kinds = |of: &[IssueKind]| -> usize {
            let own = log.issues.iter().filter(is_of);
            own.filter(|i| of.contains(&i.kind)).count()
        };
        let warned = kinds(&[
            IssueKind::Motion,
            IssueKind::Step,
            IssueKind::WarmUp,
            IssueKind::NonStationary,
        ]);
        let state = match (warned, white) {
            (0, _) if known.is_empty() => "is bounded".to_owned(),
            (0, w) if w <= ROUGH => "is known".to_owned(),
            (0, _) => "is known roughly".to_owned(),
            (n, _) => format!(
                "was disturbed ({n} warning{})",
                if n == 1 { "" } else { "s" }
            ),
        };
        let mut told = known.join(", ");
        if !bounded.is_empty() {
            if !told.is_empty() {
                told.push_str("; ");
            }
            let _ = write!(told, "{} only bounded from above", bounded.join(" and "));
        }
        if told.is_empty() {
            told.push_str("none of white noise, bias instability and random walk was asked for");
        }
        let mut text = format!("The {} {state}: {told}.", sensor.name());
        if warned > 0 {
            text.push_str(" Read its slow terms with care.");
        }
        if kinds(&[IssueKind::Units]) > 0 {
            text.push_str(" Its size does not fit its unit: if the unit is wrong, every number is off by that factor.");
        }
        if kinds(&[IssueKind::Saturation]) > 0 {
            text.push_str(" It was saturated: its numbers are conditional.");
        }
        let unfit: Vec<&str> = axes
            .iter()
            .filter(|a| {
                a.estimate
                    .as_ref()
                    .and_then(|e| e.p_value)
                    .is_some_and(|p| p < 1e-3)
            })
            .map(|a| ["x", "y", "z"][a.index])
            .collect();
        if !unfit.is_empty() {
            let _ = write!(
                text,
                " The terms do not explain {}: intervals there are conditional.",
                unfit.join(" and ")
            );
        }
        text.push_str(&levels::sentences(log, sensor));
        text.push_str(&weak_lines(&axes));
        sentences.push(text);
    }
    sentences.join(" ")
}

fn range(low: f64, high: f64) -> String {
    let text = |x: f64| {
        // 0.96 is 1, not 1.0.
        if x < 0.95 {
            format!("{x:.1}")
        } else {
            format!("{x:.0}")
        }
    };
    let (a, b) = (text(low), text(high));
    if a == b {
        format!("{b} %")
    } else {
        format!("{a}-{b} %")
    }
}

/// Issues as lines, those of one kind and time on several axes of a sensor as one.
pub(super) fn findings(log: &LogOutcome) -> Vec<Finding> {
    let mut groups: Vec<Vec<&Issue>> = Vec::new();
    for issue in &log.issues {
        let sensor = |i: &Issue| {
            i.channel
                .as_deref()
                .and_then(|c| c.split_once('_'))
                .map(|(s, _)| s.to_owned())
        };
        let place = groups.iter_mut().find(|g| {
            let head = g[0];
            head.kind == issue.kind
                // Numbers that are none are told a channel each, but where all lose the same.
                && (issue.kind != IssueKind::Nan
                    || (head.start_s, head.end_s, &head.text)
                        == (issue.start_s, issue.end_s, &issue.text))
                && sensor(head).is_some()
                && sensor(head) == sensor(issue)
                && (issue.kind == IssueKind::Line
                    || !g.iter().any(|o| o.channel == issue.channel)
                        && (head.start_s - issue.start_s).abs() < 2.0 + 0.002 * log.duration_s
                        && (head.end_s - issue.end_s).abs() < 2.0 + 0.01 * log.duration_s)
        });
        match place {
            Some(group) => group.push(issue),
            None => groups.push(vec![issue]),
        }
    }
    for group in &mut groups {
        group.sort_by(|a, b| a.channel.cmp(&b.channel));
    }
    groups.iter().map(|g| finding(log, g)).collect()
}

fn finding(log: &LogOutcome, group: &[&Issue]) -> Finding {
    let head = group[0];
    let (start, end) = group
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), i| {
            (a.min(i.start_s), b.max(i.end_s))
        });
    let (start, end) = (start - log.first_s, end - log.first_s);
    let whole = start <= 0.02 * log.duration_s && end >= 0.98 * log.duration_s;
    let channel = head
        .channel
        .clone()
        .unwrap_or_else(|| sensor(head).to_owned());
    let axis = |i: &Issue| {
        i.channel
            .as_deref()
            .and_then(|c| c.split_once('_'))
            .map_or(String::new(), |(_, a)| a.to_owned())
    };
    let several = group.iter().any(|i| i.channel != head.channel);
    let sensor = channel.split('_').next().unwrap_or(&channel).to_owned();
    let text = if head.kind == IssueKind::Line {
        lines_text(group)
    } else if group.iter().all(|i| i.text == head.text) {
        head.text.clone()
    } else if let Some(text) = [
        "changes by ",
        "not white above ",
        "the spectrum falls below the white noise under ",
        "the scatter is ",
        "a step is ",
    ]
    .iter()
    .find_map(|words| joined_numbers(group, words))
    {
        let axes: Vec<String> = group.iter().map(|i| axis(i)).collect();
        let axes = axes.join(", ");
        match text.split_once(": ") {
            Some((what, rest)) => format!("{what} on {axes}: {rest}"),
            None => format!("{text} on {axes}"),
        }
    } else {
        let parts: Vec<String> = group
            .iter()
            .map(|i| format!("{}: {}", axis(i), i.text))
            .collect();
        parts.join("; ")
    };
    Finding {
        kind: head.kind.name().to_owned(),
        channel: if several { sensor } else { channel },
        span_s: (!whole).then_some((start.max(0.0), end.max(0.0))),
        text: group_numbers(&text),
    }
}

/// `changes by 1, 2, 3 mm/s^2` of texts that differ in their number alone.
fn joined_numbers(group: &[&Issue], head: &str) -> Option<String> {
    let mut numbers = Vec::new();
    let mut unit = None;
    for issue in group {
        let rest = issue.text.strip_prefix(head)?;
        let (number, own) = rest.split_once(' ')?;
        if *unit.get_or_insert(own) != own {
            return None;
        }
        numbers.push(number);
    }
    Some(format!("{head}{} {}", numbers.join(", "), unit?))
}

/// Lines too weak for a warning; they are fitted and written as the others.
fn weak_lines(axes: &[&AxisOutcome]) -> String {
    let found: Vec<String> = axes
        .iter()
        .flat_map(|a| {
            let lines = a.estimate.iter().flat_map(|e| &e.sinusoids);
            lines
                .filter(|line| line.share_of_white <= 0.1)
                .filter_map(|line| line.frequency_hz.value)
                .map(|f| format!("{} Hz on {}", general(f, 4), ["x", "y", "z"][a.index]))
        })
        .collect();
    match found.as_slice() {
        [] => String::new(),
        [one] => format!(" A weak line stands at {one}."),
        all if all.len() <= 4 => format!(" Weak lines stand at {}.", all.join(", ")),
        all => format!(
            " Weak lines stand at {} and {} more.",
            all[..4].join(", "),
            all.len() - 4
        ),
    }
}

fn lines_text(group: &[&Issue]) -> String {
    let mut out: Vec<String> = Vec::new();
    for issue in group.iter().take(4) {
        let axis = issue
            .channel
            .as_deref()
            .and_then(|c| c.split_once('_'))
            .map_or("", |(_, a)| a);
        let frequency = issue
            .text
            .strip_prefix("a line at ")
            .and_then(|t| t.split_once(" Hz"))
            .and_then(|(f, _)| f.parse::<f64>().ok());
        match frequency {
            Some(f) => out.push(format!("{} Hz on {axis}", general(f, 4))),
            None => out.push(issue.text.clone()),
        }
    }
    let mut text = out.join(", ");
    if group.len() > 4 {
        let _ = write!(text, " and {} more", group.len() - 4);
    }
    text.push_str("; may be aliased");
    text
}

/// What the logs could not tell, what ± means.
fn closing(outcome: &Outcome, out: &mut Document) {
    let logs = &outcome.logs;
    out.blank();
    out.paragraph("± is half the 95 % interval. B is the coefficient; the Allan floor is 0.664 B.");
    let mut unknown = Vec::new();
    if logs.iter().all(|l| l.temperature_c.is_none()) {
        unknown.push("temperature effects (no temperature channel)");
    }
    if logs.len() == 1 {
        unknown.push("run-to-run bias (one run)");
    }
    unknown.push("scale factor");
    unknown.push("misalignment");
    let disturbs = |i: &Issue| matches!(i.kind, IssueKind::Motion | IssueKind::Step);
    let is_still = !logs.iter().flat_map(|l| &l.issues).any(disturbs);
    unknown.push(if is_still {
        "g-sensitivity (it lay still)"
    } else {
        "g-sensitivity"
    });
    let which = if logs.len() == 1 {
        "this log"
    } else {
        "these logs"
    };
    out.paragraph(format!("Not told by {which}: {}.", unknown.join(", ")));
    let grows = logs.iter().flat_map(|l| &l.axes).any(|a| {
        a.estimate
            .as_ref()
            .is_some_and(|e| e.fitted.flicker > 0.0 || e.fitted.random_walk > 0.0)
    });
    // The pooled table has no mean.
    if grows && outcome.sensor.is_none() {
        out.paragraph(
            "The mean's ± is its scatter about the bias at the start, which grows with the run.",
        );
    }
}
