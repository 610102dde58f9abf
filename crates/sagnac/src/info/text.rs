//! The text of `info`: the answer first, then channels, then what gravity says, then findings.

use std::collections::BTreeSet;

use sagnac_log::{Issue, IssueKind};
use sagnac_report::text::{Document, Table, duration, fixed, general, group_thousands, is_note};

use super::{ChannelInfo, InfoOutcome};
use crate::findings::{finding, gathered};

const DEG: f64 = 180.0 / std::f64::consts::PI;
const STANDARD_GRAVITY: f64 = 9.80665;

pub(super) fn document(o: &InfoOutcome) -> Document {
    let mut d = Document::new();
    let long = duration(o.duration_s);
    let seconds = format!("{} s", general(o.duration_s, 6));
    let span = if long == seconds {
        long
    } else {
        format!("{seconds} ({long})")
    };
    let topic = o
        .layout
        .topic
        .as_ref()
        .map_or(String::new(), |t| format!(", {t}"));
    d.paragraph(format!(
        "{}{topic}. {} samples, {span}.",
        o.layout.format,
        group_thousands(&o.samples.to_string())
    ));
    let rate = general(o.rate_hz, 6);
    d.paragraph(match (o.layout.has_time, o.layout.rate_hz.is_some()) {
        (false, _) => format!("Rate {rate} Hz as given; the file has no time column."),
        (true, true) => format!("Rate {rate} Hz as given, not from the time stamps."),
        (true, false) => {
            // A single stamp that is wrong makes no uneven clock.
            let is_uneven =
                |i: &Issue| i.kind == IssueKind::Jitter && i.end_s - i.start_s > 0.5 * o.duration_s;
            match o.stamp_step_s {
                Some(step_s) => format!(
                    "Rate {rate} Hz from time stamps in coarse steps of {}; give --rate if you know it.",
                    duration(step_s)
                ),
                None if o.issues.iter().any(is_uneven) => {
                    format!("Rate {rate} Hz from the time stamps, which jitter.")
                }
                None => format!("Rate {rate} Hz from the time stamps, evenly spaced."),
            }
        }
    });
    if let Some(frame) = &o.layout.frame {
        d.paragraph(format!("Axes: {frame}."));
    }
    let warnings: Vec<_> = o.issues.iter().filter(|i| !i.kind.is_note()).collect();
    if warnings.is_empty() {
        d.paragraph(if o.is_moving {
            "No warnings; it is no log at rest."
        } else {
            "No warnings: the log is sound."
        });
    } else {
        let kinds: BTreeSet<&str> = warnings.iter().map(|i| i.kind.name()).collect();
        // As many as are listed below: many of a kind and channel are one line.
        let lines = o.issues.iter().map(|i| finding(i, o.first_s, o.duration_s));
        let told = gathered(lines.collect());
        let n = told.iter().filter(|f| !is_note(&f.kind)).count();
        let kinds: Vec<&str> = kinds.into_iter().collect();
        d.paragraph(format!(
            "{n} warning{}: {}.",
            if n == 1 { "" } else { "s" },
            kinds.join(", ")
        ));
    }
    d.blank();
    d.table(table(&o.channels));
    d.blank();
    if let Some(line) = gravity(o) {
        d.paragraph(line);
        d.blank();
    }
    let lines = o.issues.iter().map(|i| finding(i, o.first_s, o.duration_s));
    d.findings(gathered(lines.collect()));
    d.blank();
    for note in &o.layout.notes {
        d.note(note.clone());
    }
    if o.layout.topics.len() > 1 {
        for t in &o.layout.topics {
            let n = t.messages.map_or(String::new(), |n| {
                format!(", {} messages", group_thousands(&n.to_string()))
            });
            d.hanging("topic  ", format!("{} ({}){n}", t.name, t.kind));
        }
    }

    d
}

fn table(channels: &[ChannelInfo]) -> Table {
    let mut table = Table::new(
        &["channel", "unit", "mean", "scatter", "min", "max", "step"],
        &[
            sagnac_report::text::Align::Left,
            sagnac_report::text::Align::Left,
        ],
    );
    for c in channels {
        let (mut unit, mut factor) = shown_unit(c);
        if (c.min.abs().max(c.max.abs()) * factor).is_infinite() {
            (unit, factor) = (&c.unit, 1.0);
        }
        let (std, lsb) = (c.std * factor, c.lsb.map(|l| l * factor));
        let digits = decimals(std, 3);
        let step = lsb.map_or_else(
            || digits.saturating_sub(1),
            |l| decimals(l, 3).min(digits + 1),
        );
        let lsb_text = lsb.map_or_else(|| "-".to_owned(), |l| general(l, 3));
        let step = lsb_text.split_once('.').map_or(step, |(_, d)| d.len());
        table.row([
            c.name.clone(),
            unit.to_owned(),
            cell(c.mean * factor, digits),
            cell(std, digits),
            cell(c.min * factor, step),
            cell(c.max * factor, step),
            lsb_text,
        ]);
    }
    table
}

/// A number of a table; one too long for its column in powers of ten.
fn cell(value: f64, decimals: usize) -> String {
    if value.abs() >= 1e9 {
        general(value, 3)
    } else {
        fixed(value, decimals)
    }
}

/// Decimals that show so many digits of `value`.
fn decimals(value: f64, digits: i32) -> usize {
    if !(value.is_finite() && value != 0.0) {
        return 2;
    }
    (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 9) as usize
}

fn shown_unit(c: &ChannelInfo) -> (&str, f64) {
    match c.unit.as_str() {
        "rad/s" => ("deg/s", DEG),
        "rad/s^2" => ("deg/s^2", DEG),
        "m/s^2" if c.name.starts_with("accel") => ("mg", 1000.0 / STANDARD_GRAVITY),
        "" => ("-", 1.0),
        other => (other, 1.0),
    }
}

/// Share of |f| that the mean of f keeps in one attitude: less is left of two attitudes 36 deg apart, half of the time each.
const LEAST_LEFT: f64 = 0.95;

/// What |f| and |w| say of a log at rest.
fn gravity(o: &InfoOutcome) -> Option<String> {
    if o.is_moving {
        return Some(
            "The sensor moved most of the time: findings about a log at rest were not looked for."
                .to_owned(),
        );
    }
    let triad = |word: &str| -> Option<[f64; 3]> {
        let mut out = [0.0; 3];
        for (v, axis) in out.iter_mut().zip(["x", "y", "z"]) {
            *v = o
                .channels
                .iter()
                .find(|c| c.name == format!("{word}_{axis}") && c.mean.is_finite())?
                .mean;
        }
        Some(out)
    };
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut text = String::new();
    if let Some(f) = triad("accel") {
        let mean = length(f) / STANDARD_GRAVITY;
        let g = o.force_m_s2.map_or(mean, |f| f / STANDARD_GRAVITY);
        text = format!("|f| = {} g", fixed(g, 3));
        if mean < LEAST_LEFT * g {
            text += &format!(
                ", but the mean of f is {} g long: it was turned",
                fixed(mean, 3)
            );
        }
        let k = (0..3)
            .max_by(|&a, &b| f[a].abs().total_cmp(&f[b].abs()))
            .unwrap_or(2);
        if f[k].abs() > 0.98 * length(f) {
            let (name, sign) = (["x", "y", "z"][k], if f[k] < 0.0 { "-" } else { "+" });
            let way = if f[k] < 0.0 { "down" } else { "up" };
            text += &format!(
                ", along {sign}{name}: {}{name} {way}",
                if k == 2 { "level, " } else { "" }
            );
        }
        text += ". ";
    }
    if let Some(w) = triad("gyro") {
        let w = length(w) * DEG * 3600.0;
        let earth = if w > 30.0 {
            "bias; the Earth's 15 deg/h cannot be seen beside it."
        } else {
            "the Earth's 15 deg/h and bias."
        };
        text += &format!("|w| = {} deg/h: {earth}", general(w, 4));
    }
    (!text.is_empty()).then_some(text)
}
