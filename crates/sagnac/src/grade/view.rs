//! A grade in words: the verdict, the table, what the next grade needs.

use super::{Bias, GradeOutcome, NMI_M, Needed};
use sagnac_report::html::{HtmlCell, HtmlTable, Rich};
use sagnac_report::text::{Align, Cell, Document, Style, Table, Unit, general, significant};

impl GradeOutcome {
    fn bias_text(&self, i: usize) -> String {
        self.bias[i].map_or("not stated".to_owned(), |(kind, value)| {
            let what = match kind {
                Bias::InRun => "in run (Allan floor)",
                Bias::RunToRun => "run to run",
            };
            format!("{}, {what}", bias_value(i, value))
        })
    }

    /// The answer in one or two sentences.
    pub fn verdict(&self) -> String {
        let table = self.table.words();
        let kind = match self.bias_kind() {
            Some("mixed") => {
                "mixed biases (in-run of one sensor, run-to-run of the other)".to_owned()
            }
            Some(kind) => format!("{kind} bias"),
            None => return format!("No grade: {}.", self.reasons.join("; ")),
        };
        let mut out = match self.overall {
            Some(row) => format!(
                "{}, by {table} and {kind}.",
                words(self.table.rows()[row].name, true)
            ),
            None => format!("Outside {table}, by {kind}."),
        };
        if let Some(row) = self.next_row()
            && !self.needed_for_next.is_empty()
        {
            let needs: Vec<String> = self.foremost().into_iter().map(need_words).collect();
            out.push_str(&format!(
                " {} grade needs {}.",
                words(self.table.rows()[row].name, true),
                needs.join(" and ")
            ));
        }
        out
    }

    /// What the verdict names: what holds the sensor back, and what misses the next row by more.
    fn foremost(&self) -> Vec<&Needed> {
        let is_held = |n: &&Needed| match self.held_back_by {
            Some("gyro_bias") => n.parameter.starts_with("gyro"),
            Some("accel_bias") => n.parameter.starts_with("accel"),
            Some(_) => n.parameter == "position",
            None => false,
        };
        let largest = self
            .needed_for_next
            .iter()
            .max_by(|a, b| a.factor.total_cmp(&b.factor));
        let held = self.needed_for_next.iter().find(is_held);
        let mut out: Vec<&Needed> = held.into_iter().collect();
        out.extend(largest.filter(|l| {
            held.is_none_or(|h| significant(h.factor, 2) != significant(l.factor, 2) && h != *l)
        }));
        out
    }

    fn next_row(&self) -> Option<usize> {
        match self.overall {
            Some(0) => None,
            Some(row) => Some(row - 1),
            None => Some(self.table.rows().len() - 1),
        }
    }

    /// What stands in the table: by gyro bias, by accelerometer bias, by position, overall.
    pub(super) fn rows(&self) -> [[String; 3]; 4] {
        let name = |row: Option<usize>| self.key(row).map_or("-".to_owned(), |n| words(n, false));
        let position = match self.cep_m {
            [Some(cep), None] => {
                format!("CEP {} nmi after 1 h at rest", significant(cep / NMI_M, 2))
            }
            [Some(hour), Some(day)] => format!(
                "CEP {} nmi after 1 h at rest, {} after 24 h",
                significant(hour / NMI_M, 2),
                significant(day / NMI_M, 2)
            ),
            _ => "-".to_owned(),
        };
        let held = match self.held_back_by {
            Some("gyro_bias") => "held back by the gyro bias",
            Some("accel_bias") => "held back by the accelerometer bias",
            Some("position") => "held back by the position",
            _ if self.overall == Some(0) => "the best there is",
            _ => "",
        };
        let row =
            |what: &str, grade: Option<usize>, why: String| [what.to_owned(), name(grade), why];
        [
            row("by gyro bias", self.by_gyro_bias, self.bias_text(0)),
            row(
                "by accelerometer bias",
                self.by_accel_bias,
                self.bias_text(1),
            ),
            row("by position", self.by_position, position),
            row("overall", self.overall, held.to_owned()),
        ]
    }

    /// Of what misses the next row: what, now, needed, how far; with that row's name.
    pub(super) fn needed_rows(&self) -> Option<(String, Vec<[String; 4]>)> {
        let row = self
            .next_row()
            .filter(|_| !self.needed_for_next.is_empty())?;
        let above = &self.table.rows()[row];
        let rows = self.needed_for_next.iter().map(|n| {
            let value = |v: f64| match n.unit {
                "rad/s" => bias_value(0, v),
                "m/s^2" => bias_value(1, v),
                _ => format!("{} nmi", significant(v / NMI_M, 2)),
            };
            let hours = above.position.map_or(1.0, |(hours, _)| hours);
            let title = if n.parameter == "position" {
                format!("position, CEP {hours} h")
            } else {
                n.parameter.clone()
            };
            let strict = if n.is_strict { "< " } else { "" };
            let factor = match significant(n.factor, 2).as_str() {
                "1.0" => "a little less".to_owned(),
                factor => format!("{factor} times less"),
            };
            [
                title,
                value(n.now),
                format!("{strict}{}", value(n.needed)),
                factor,
            ]
        });
        Some((words(above.name, false), rows.collect()))
    }

    /// The overall grade in words.
    pub(super) fn overall_words(&self) -> String {
        match (self.overall, self.bias_kind()) {
            (Some(row), _) => words(self.table.rows()[row].name, false),
            (None, Some(_)) => "outside the table".to_owned(),
            (None, None) => "without a grade".to_owned(),
        }
    }

    /// The tables of the page, each with its heading.
    pub(super) fn tables(&self) -> Vec<(String, HtmlTable)> {
        let key = sagnac_model::catalogue::key_of(&self.sensor);
        let mut grades = HtmlTable::new(&format!("grade-{key}"), &["By", "Grade", "Because"], &[]);
        for [what, grade, why] in self.rows() {
            let what = what.trim_start_matches("by ").to_owned();
            grades.row(vec![
                what.into(),
                Rich::new().bold(grade).into(),
                why.into(),
            ]);
        }
        let mut out = vec![(format!("{}: the grade", self.sensor), grades)];
        if let Some((next, rows)) = self.needed_rows() {
            let mut needed = HtmlTable::new(
                &format!("needed-{key}"),
                &["Quantity", "Now", "Needed", "How far"],
                &[],
            );
            for row in rows {
                needed.row(row.into_iter().map(HtmlCell::from).collect());
            }
            out.push((format!("{}: what {next} grade needs", self.sensor), needed));
        }
        out
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut doc = Document::new();
        doc.paragraph(self.verdict()).blank();
        let mut table = Table::new(&["", "", ""], &[Align::Left; 3]);
        for row in self.rows() {
            table.row(row.map(Cell::from));
        }
        doc.table(table);
        for reason in &self.reasons {
            doc.note(reason.clone());
        }
        if let Some((next, rows)) = self.needed_rows() {
            doc.blank();
            let heading = format!("for {next}");
            let mut needed = Table::new(&[&heading, "now", "needed", ""], &[Align::Left; 4]);
            for row in rows {
                needed.row(row.map(Cell::from));
            }
            doc.table(needed);
        }
        doc
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}

/// `a 30 times smaller gyro bias`; close to the limit `a gyro bias below 0.01 deg/h`.
fn need_words(n: &Needed) -> String {
    let what = match n.parameter.split('.').next() {
        Some("gyro") => "gyro bias",
        Some("accel") => "accelerometer bias",
        _ => "position error",
    };
    let factor = significant(n.factor, 2);
    if factor == "1.0" {
        let limit = match n.unit {
            "rad/s" => bias_value(0, n.needed),
            "m/s^2" => bias_value(1, n.needed),
            _ => format!("{} nmi", significant(n.needed / NMI_M, 2)),
        };
        let how = if n.is_strict { "below" } else { "of at most" };
        let article = if what.starts_with('a') { "an" } else { "a" };
        return format!("{article} {what} {how} {limit}");
    }
    // Eight, eleven and eighteen begin with a vowel.
    let article = match factor.split('.').next() {
        Some("11" | "18") => "an",
        _ if factor.starts_with('8') => "an",
        _ => "a",
    };
    format!("{article} {factor} times smaller {what}")
}

fn bias_value(sensor: usize, value: f64) -> String {
    if sensor == 0 {
        format!("{} deg/h", general(Unit::DEG_PER_H.from_si(value), 3))
    } else {
        let ug = Unit::MICRO_G.from_si(value);
        if ug >= 499.999 {
            format!("{} mg", general(ug / 1000.0, 3))
        } else {
            format!("{} ug", general(ug, 3))
        }
    }
}

/// `control_system` in a sentence.
fn words(name: &str, first: bool) -> String {
    let out = if name == "ahrs" {
        "AHRS".to_owned()
    } else {
        name.replace('_', " ")
    };
    if first {
        let mut chars = out.chars();
        return chars
            .next()
            .map_or(String::new(), |c| c.to_uppercase().chain(chars).collect());
    }
    out
}
