//! The text and the page of `drift`.

#![allow(clippy::unused_self, reason = "reads as a question to the value")]

use sagnac_report::html::{BudgetRow, DriftPage, HtmlCell, HtmlTable, Opening, Rich};
use sagnac_report::plots::{DriftCloud, DriftGrowth, DriftShare};
use sagnac_report::text::{
    Align, Cell, Document, Style, Table, duration, general, percent, significant,
};

use super::{Curve, DriftOutcome, calibration_key};
use sagnac_nav::drift::Alignment;
use sagnac_nav::strapdown::Vertical;

/// A unit for lengths of this size: (name, metres).
pub(crate) fn length_unit(largest_m: f64) -> (&'static str, f64) {
    if largest_m >= 10_000.0 {
        ("km", 1000.0)
    } else {
        ("m", 1.0)
    }
}

/// A length for a sentence: three digits, mm, m or km.
pub(crate) fn length(value_m: f64) -> String {
    if value_m > 0.0 && value_m < 0.01 {
        return format!("{} mm", general(value_m * 1000.0, 3));
    }
    let (unit, factor) = length_unit(value_m);
    format!("{} {unit}", significant(value_m / factor, 3))
}

/// A budget term in words: `gyro.bias.stability` → `Gyro bias, run to run`.
pub(crate) fn term_words(term: &str) -> String {
    let (sensor, rest) = term.split_once('.').unwrap_or(("", term));
    let name = match sensor {
        "gyro" => "Gyro",
        "accel" => "Accel",
        _ => "",
    };
    match rest {
        "alignment" => "Start attitude".to_owned(),
        "bias.stability" => format!("{name} bias, run to run"),
        "bias.instability" => format!("{name} bias instability"),
        "scale_factor.stability" => format!("{name} scale factor, run to run"),
        "misalignment.stability" => format!("{name} misalignment, run to run"),
        "noise.angle_random_walk" => "Angle random walk".to_owned(),
        "noise.velocity_random_walk" => "Velocity random walk".to_owned(),
        "noise.rate_random_walk" => "Rate random walk".to_owned(),
        "noise.acceleration_random_walk" => "Acceleration random walk".to_owned(),
        other => {
            let words = other.trim_start_matches("noise.").replace(['.', '_'], " ");
            format!("{name} {words}")
        }
    }
}

/// Rows of the time table: quarters of the run.
const ROWS: [usize; 4] = [14, 29, 44, 59];

impl DriftOutcome {
    fn interval_text(&self, i: [Option<f64>; 2], factor: f64) -> String {
        let end = |v: f64| significant(v / factor, 3);
        match i {
            [Some(low), Some(high)] => format!("{} … {}", end(low), end(high)),
            [Some(low), None] => format!("> {}", end(low)),
            [None, Some(high)] => format!("< {}", end(high)),
            [None, None] => "unknown".to_owned(),
        }
    }

    /// The last time that is told: the end, rounded to a sample.
    fn end_s(&self) -> f64 {
        let last = self.covariance.time_s.last();
        last.copied().unwrap_or(self.setting.duration_s)
    }

    /// The largest term in a clause.
    fn largest(&self) -> Option<(String, f64)> {
        self.covariance
            .terms()
            .first()
            .filter(|(_, s, _)| *s > 0.0)
            .map(|(t, s, _)| (term_words(t), *s))
    }

    /// The answer in one or two sentences.
    pub fn verdict(&self) -> String {
        let (cep, r95) = (self.cep(), self.r95());
        let (c, r) = (cep.value[59], r95.value[59]);
        let time = duration(self.end_s());
        let who = if self.monte_carlo.is_some() {
            "runs"
        } else {
            "sensors"
        };
        let interval = |curve: &Curve, value: f64| {
            if self.monte_carlo.is_some() {
                let (_, factor) = length_unit(value);
                format!(" ({})", self.interval_text(curve.interval[59], factor))
            } else {
                String::new()
            }
        };
        let mut out = if c == 0.0 && r == 0.0 {
            format!("After {time} there is no error: the model holds nothing that drifts.")
        } else {
            format!(
                "After {time} half of all {who} are off by more than {}{}, one in twenty by more than {}{}.",
                length(c),
                interval(&cep, c),
                length(r),
                interval(&r95, r)
            )
        };
        if let Some((term, share)) = self.largest() {
            out.push_str(&format!(" {term} makes {} of it.", percent_whole(share)));
        }
        out
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut doc = Document::new();
        doc.paragraph(self.verdict()).blank();
        let (cep, r95) = (self.cep(), self.r95());
        let (unit, factor) = length_unit(r95.value[59]);
        let sampled = self.monte_carlo.is_some();
        let headings: Vec<String> = if sampled {
            vec![
                "time".into(),
                format!("CEP, {unit}"),
                "95 %".into(),
                format!("R95, {unit}"),
                "95 %".into(),
            ]
        } else {
            vec![
                "time".into(),
                format!("CEP, {unit}"),
                format!("R95, {unit}"),
                format!("RMS, {unit}"),
                "heading, deg".into(),
            ]
        };
        let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
        let aligns = if sampled {
            [
                Align::Right,
                Align::Point,
                Align::Left,
                Align::Point,
                Align::Left,
            ]
        } else {
            [
                Align::Right,
                Align::Point,
                Align::Point,
                Align::Point,
                Align::Point,
            ]
        };
        let mut table = Table::new(&headings, &aligns);
        let rms = self.rms();
        let heading = self.covariance.rms_of(8);
        for i in ROWS {
            let time = duration(self.covariance.time_s[i]);
            let number = |v: f64| Cell::from(significant(v / factor, 3));
            if sampled {
                table.row([
                    Cell::from(time),
                    number(cep.value[i]),
                    Cell::from(self.interval_text(cep.interval[i], factor)),
                    number(r95.value[i]),
                    Cell::from(self.interval_text(r95.interval[i], factor)),
                ]);
            } else {
                table.row([
                    Cell::from(time),
                    number(cep.value[i]),
                    number(r95.value[i]),
                    number(rms.value[i]),
                    Cell::from(significant(heading[i].to_degrees(), 2)),
                ]);
            }
        }
        doc.table(table).blank();
        let rows = self.budget_rows();
        let whole = self.covariance.end().radius_m(0.5);
        if !rows.is_empty() {
            let mut budget = Table::new(
                &["term", "share", "alone", "if halved"],
                &[Align::Left, Align::Right, Align::Right, Align::Right],
            );
            let shown = rows.iter().filter(|r| r.share >= 1e-3).count().clamp(1, 8);
            for r in rows.iter().take(shown) {
                budget.row([
                    Cell::from(r.term.clone()),
                    Cell::from(r.share_text()),
                    Cell::from(length(r.alone_m)),
                    Cell::from(length(r.halved_m)),
                ]);
            }
            let rest = &rows[shown.min(rows.len())..];
            if !rest.is_empty() {
                let share: f64 = rest.iter().map(|r| r.share).sum();
                let alone = rest
                    .iter()
                    .map(|r| r.alone_m * r.alone_m)
                    .sum::<f64>()
                    .sqrt();
                budget.row([
                    Cell::from(format!("others ({})", rest.len())),
                    Cell::from(percent(share)),
                    Cell::from(length(alone)),
                    Cell::from(length(whole)),
                ]);
            }
            doc.table(budget).blank();
        }
        if let Some(found) = &self.monte_carlo {
            let interval = found.cep(0.0005)[59].interval_m;
            let agree =
                interval[0].is_none_or(|l| whole >= l) && interval[1].is_none_or(|u| whole <= u);
            let text = if !self.doubts.is_empty() {
                format!(
                    "The covariance gives {}, and does not hold here: take the Monte Carlo.",
                    length(whole)
                )
            } else if !self.is_valid() {
                format!(
                    "The covariance gives {}: beyond the linear range, an order of magnitude only.",
                    length(whole)
                )
            } else if agree {
                format!(
                    "The covariance gives {}: the two methods agree.",
                    length(whole)
                )
            } else {
                format!(
                    "The covariance gives {}: the two methods do not agree.",
                    length(whole)
                )
            };
            doc.paragraph(text);
            if found.r95(0.025)[59].interval_m[1].is_none() {
                doc.paragraph("Fewer than 72 runs cannot bound R95 from above.");
            }
        }
        doc.paragraph(self.conditions());
        if let Some((term, _, factor)) = self.improve_first().first() {
            doc.line(format!(
                "improve first: {term}. Half of it brings the CEP to {}.",
                length(whole * factor)
            ));
        }
        doc
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }

    /// How it was asked, in a sentence.
    fn conditions(&self) -> String {
        let alignment = match self.setting.alignment {
            Alignment::Perfect => "perfect start attitude".to_owned(),
            Alignment::SelfAligned => {
                "start attitude from the sensor itself, 600 s at rest".to_owned()
            }
            Alignment::Given {
                roll_rad,
                pitch_rad,
                heading_rad,
            } => format!(
                "start attitude to {}, {}, {} deg (roll, pitch, heading, 1 sigma)",
                general(roll_rad.to_degrees(), 3),
                general(pitch_rad.to_degrees(), 3),
                general(heading_rad.to_degrees(), 3)
            ),
        };
        let vertical = match self.setting.vertical {
            Vertical::Fixed => "height held",
            Vertical::Free => "height free",
            Vertical::Baro => "height by barometer",
        };
        let calibration = match calibration_key(self.setting.calibration) {
            "model" => "corrected by its model",
            "perfect" => "perfectly calibrated",
            _ => "not corrected",
        };
        format!(
            "On `{}`: {alignment}, {vertical}, {calibration}.",
            self.trajectory
        )
    }

    fn budget_rows(&self) -> Vec<TermRow> {
        self.covariance
            .terms()
            .into_iter()
            .filter(|(_, share, h)| *share > 0.0 || h.north_north + h.east_east > 0.0)
            .map(|(term, share, own)| TermRow {
                halved_m: self.covariance.cep_with_m(&term, 0.5),
                alone_m: own.radius_m(0.5),
                share,
                term,
            })
            .collect()
    }

    /// The page.
    pub fn page(&self, opening: Opening) -> DriftPage {
        let (cep, r95) = (self.cep(), self.r95());
        let (unit, factor) = length_unit(r95.value[59]);
        let scale = |v: &[f64]| v.iter().map(|x| x / factor).collect::<Vec<f64>>();
        let ends = |c: &Curve| -> (Vec<f64>, Vec<f64>) {
            if self.monte_carlo.is_none() {
                return (Vec::new(), Vec::new());
            }
            let end = |k: usize| {
                c.interval
                    .iter()
                    .zip(&c.value)
                    .map(|(i, v)| i[k].unwrap_or(*v) / factor)
                    .collect()
            };
            (end(0), end(1))
        };
        let time = duration(self.end_s());
        let terms = self.covariance.terms();
        let growth = DriftGrowth {
            unit: unit.to_owned(),
            time_s: self.covariance.time_s.clone(),
            cep: scale(&cep.value),
            cep_interval: ends(&cep),
            r95: scale(&r95.value),
            r95_interval: ends(&r95),
            covariance: if self.monte_carlo.is_some() {
                (
                    scale(&self.covariance.cep_m()),
                    scale(&self.covariance.r95_m()),
                )
            } else {
                (Vec::new(), Vec::new())
            },
        };
        let cloud = self.monte_carlo.as_ref().map(|m| DriftCloud {
            unit: unit.to_owned(),
            note: format!("after {time}"),
            east: m.errors[59].iter().map(|e| e[1] / factor).collect(),
            north: m.errors[59].iter().map(|e| e[0] / factor).collect(),
            cep: cep.value[59] / factor,
            r95: r95.value[59] / factor,
            labels: (
                format!("CEP {}", length(cep.value[59])),
                format!("R95 {}", length(r95.value[59])),
            ),
        });
        let mut shares: Vec<(String, Vec<f64>)> = terms
            .iter()
            .take(5)
            .filter(|(_, s, _)| *s > 0.0)
            .map(|(t, ..)| (term_words(t), self.covariance.shares_in_time(t)))
            .collect();
        if terms.len() > 5 {
            let rest = (0..60)
                .map(|i| 1.0 - shares.iter().map(|(_, s)| s[i]).sum::<f64>())
                .map(|s| s.max(0.0))
                .collect();
            shares.push(("others".to_owned(), rest));
        }
        let budget = self
            .budget_rows()
            .into_iter()
            .map(|r| BudgetRow {
                in_model: self
                    .values
                    .iter()
                    .find(|(t, _)| *t == r.term)
                    .map_or("–".to_owned(), |(_, v)| sagnac_report::html::page_text(v)),
                share: r.share,
                share_text: r.share_text(),
                alone: length(r.alone_m),
                halved: length(r.halved_m),
                term: term_words(&r.term),
            })
            .collect();
        DriftPage {
            opening: Opening {
                name: self.sensor.clone(),
                subtitle: format!("{} {}", self.subtitle(), self.conditions()).replace('`', ""),
                verdict: self.rich_verdict(),
                ..opening
            },
            growth,
            cloud,
            share: DriftShare {
                time_s: self.covariance.time_s.clone(),
                terms: shares,
            },
            budget_heading: format!("Budget after {time}"),
            budget,
            tables: vec![("Against time".to_owned(), self.time_table())],
        }
    }

    fn subtitle(&self) -> String {
        let time = duration(self.setting.duration_s);
        let how = self.monte_carlo.as_ref().map_or_else(
            || "covariance".to_owned(),
            |_| format!("{} Monte Carlo runs and covariance", self.runs),
        );
        format!("{time} of `{}`; {how}.", self.trajectory)
    }

    fn rich_verdict(&self) -> Rich {
        let text = self.verdict();
        let mut out = match text.split_once(", one in") {
            Some((bold, rest)) => Rich::new()
                .bold(bold.to_owned())
                .plain(format!(", one in{rest}")),
            None => Rich::new().bold(text),
        };
        if let Some((_, _, factor)) = self.improve_first().first() {
            out = out.plain(format!(
                " Half of that term would bring the CEP to {}.",
                length(self.covariance.end().radius_m(0.5) * factor)
            ));
        }
        out
    }

    fn time_table(&self) -> HtmlTable {
        let (cep, r95, rms) = (self.cep(), self.r95(), self.rms());
        let mut table = HtmlTable::new(
            "drift",
            &[
                "Time",
                "CEP",
                "R95",
                "RMS",
                "Velocity, RMS",
                "Tilt, RMS",
                "Heading, RMS",
            ],
            &[1, 2, 3, 4, 5, 6],
        );
        let of = |i: usize| {
            self.monte_carlo
                .as_ref()
                .map_or_else(|| self.covariance.rms_of(i), |m| m.rms_of(i))
        };
        let (vn, ve, tn, te, h) = (of(3), of(4), of(6), of(7), of(8));
        for i in (4..60).step_by(5) {
            table.row(vec![
                duration(self.covariance.time_s[i]).into(),
                HtmlCell::number(length(cep.value[i])),
                HtmlCell::number(length(r95.value[i])),
                HtmlCell::number(length(rms.value[i])),
                HtmlCell::number(format!("{} m/s", significant(vn[i].hypot(ve[i]), 3))),
                HtmlCell::number(format!(
                    "{}°",
                    significant(tn[i].hypot(te[i]).to_degrees(), 2)
                )),
                HtmlCell::number(format!("{}°", significant(h[i].to_degrees(), 2))),
            ]);
        }
        table
    }
}

struct TermRow {
    term: String,
    share: f64,
    alone_m: f64,
    halved_m: f64,
}

impl TermRow {
    fn share_text(&self) -> String {
        percent(self.share)
    }
}

fn percent_whole(share: f64) -> String {
    if share >= 0.995 {
        "all".to_owned()
    } else {
        format!("{:.0} %", 100.0 * share)
    }
}
