//! What is known of one sensor, every number with its source.

use super::{shown_unit, shown_value, words};
use crate::Error;
use sagnac_core::Sensor;
use sagnac_model::catalogue::{price_class, quality, technology};
use sagnac_model::{Catalogue, Entry, Model, ParameterPath};
use sagnac_report::text::{COLUMNS, Document, Style, width};
use serde_json::{Value, json};

/// One sensor.
#[derive(Debug, Clone)]
pub struct ShowOutcome {
    /// Its model.
    pub model: Model,
}

/// Finds a sensor by name.
///
/// # Errors
/// No such sensor; the advice suggests the nearest name.
pub fn show(catalogue: &Catalogue, name: &str) -> Result<ShowOutcome, Error> {
    Ok(ShowOutcome {
        model: catalogue.find(name)?,
    })
}

/// A line of the table: sensor, term, value, sources and what they print.
struct Line {
    sensor: Sensor,
    term: String,
    value: String,
    /// The sources of its axes, each once.
    sources: Vec<String>,
    /// What is printed there, and its condition.
    notes: Vec<String>,
}

/// The sources of a sensor, numbered in the order in which they are read.
#[derive(Default)]
struct Sources(Vec<String>);

impl Sources {
    /// `S [2]`: letter and number of a source.
    fn mark(&mut self, source: &str) -> String {
        let (letter, bare) = match source.split_once(": ") {
            Some((letter, bare)) if letter.len() == 1 => (letter, bare),
            _ => ("", source),
        };
        let place = self.0.iter().position(|known| known == bare);
        let place = place.unwrap_or_else(|| {
            self.0.push(bare.to_string());
            self.0.len() - 1
        });
        format!("{letter} [{}]", place + 1).trim_start().to_string()
    }
}

impl ShowOutcome {
    /// `{"name", "quality", "model": {…}, "conflicts": […], "notes": […], …}`.
    pub fn to_json(&self) -> Value {
        let model = &self.model;
        let price = price_class(model);
        let table = model.catalog();
        let conflicts: Vec<Value> = table
            .map(|table| table.conflicts.as_slice())
            .unwrap_or_default()
            .iter()
            .map(|conflict| {
                let others: Vec<Value> = conflict
                    .others
                    .iter()
                    .map(|other| {
                        let value = other
                            .value
                            .parse::<f64>()
                            .map_or_else(|_| json!(other.value), |number| json!(number));
                        json!({ "value": value, "unit": other.unit, "source": other.source })
                    })
                    .collect();
                json!({ "parameter": conflict.parameter, "used": conflict.used, "others": others })
            })
            .collect();
        json!({
            "name": model.name(),
            "manufacturer": model.manufacturer(),
            "technology": technology(model),
            "quality": quality(model),
            "price_class": price.as_ref().map(|price| price.class),
            "price_evidence": price.as_ref().map(|price| price.evidence.as_str()),
            "model": model.to_json(),
            "conflicts": conflicts,
            "notes": table.map(|table| table.notes.as_slice()).unwrap_or_default(),
        })
    }

    /// The sensor as a document.
    pub fn document(&self) -> Document {
        let model = &self.model;
        let mut document = Document::new();
        let title: Vec<&str> = [Some(model.name()), model.manufacturer(), technology(model)]
            .into_iter()
            .flatten()
            .collect();
        document.heading(title.join(", ")).blank();
        let lines = self.lines();
        let mut sources = Sources::default();
        let widest =
            |of: fn(&Line) -> &str| lines.iter().map(|line| width(of(line))).max().unwrap_or(0);
        let (terms, values) = (widest(|line| &line.term), widest(|line| &line.value));
        let mut last = None;
        for line in &lines {
            let name = if last == Some(line.sensor) {
                ""
            } else {
                line.sensor.key()
            };
            last = Some(line.sensor);
            let pad = |text: &str, columns: usize| {
                format!("{text}{}", " ".repeat(columns.saturating_sub(width(text))))
            };
            let from: Vec<String> = line.sources.iter().map(|s| sources.mark(s)).collect();
            let head = format!(
                "{name:5}  {}  {}  {}",
                pad(&line.term, terms),
                pad(&line.value, values),
                from.join(" ")
            );
            let told = line.notes.join("; ");
            if width(&head) + 2 + width(&told) <= COLUMNS {
                document.line(format!("{head}  {told}").trim_end().to_string());
            } else {
                document.line(head);
                document.hanging("         ", told);
            }
        }
        document.blank();
        if let Some(rate_hz) = model.sample_rate_hz() {
            document.line(format!(
                "Up to {} samples a second.",
                sagnac_report::text::general(rate_hz, 6)
            ));
        }
        if let Some(price) = price_class(model) {
            document.hanging(
                "Price: ",
                format!("USD {}, {}", price.class, price.evidence),
            );
        }
        document.blank();
        if let Some(table) = model.catalog() {
            for conflict in &table.conflicts {
                let others: Vec<String> = conflict
                    .others
                    .iter()
                    .map(|other| {
                        let from = sources.mark(&other.source);
                        format!("{} {} ({from})", other.value, other.unit)
                    })
                    .collect();
                document.note(format!(
                    "{}: {} is used, also printed: {}",
                    conflict.parameter,
                    conflict.used,
                    others.join(", ")
                ));
            }
            for note in &table.notes {
                document.note(note.as_str());
            }
        }
        document.blank();
        for (i, source) in sources.0.iter().enumerate() {
            document.hanging(format!("[{}] ", i + 1), source.clone());
        }
        document
            .blank()
            .line("D data sheet, S second hand, M measured on a unit");
        document
    }

    /// The sensor as text.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }

    fn lines(&self) -> Vec<Line> {
        let mut lines: Vec<Line> = Vec::new();
        let mut done: Vec<ParameterPath> = Vec::new();
        for (path, _) in self.model.parameters() {
            let base = path.without_axis();
            if done.contains(&base) {
                continue;
            }
            done.push(base);
            lines.push(self.line(base));
        }
        lines
    }

    fn line(&self, base: ParameterPath) -> Line {
        let dimension = self.model.dimension(base);
        let mut found: Vec<(ParameterPath, &Entry)> = base
            .elements()
            .into_iter()
            .filter_map(|path| self.model.at(path).map(|entry| (path, entry)))
            .collect();
        let same = found.windows(2).all(|pair| pair[0].1 == pair[1].1);
        // Of a matrix only what is not zero.
        if !same && found.len() > 3 {
            found.retain(|(_, entry)| {
                entry.simulated() != 0.0 || entry.sigma.is_some() || entry.is_limit()
            });
        }
        let uniform = same || found.windows(2).all(|pair| pair[0].1 == pair[1].1);
        let unit = found
            .first()
            .map_or_else(String::new, |(_, entry)| shown_unit(entry.unit.text()));
        let number = if uniform {
            found.first().map_or_else(
                || "-".to_string(),
                |(_, entry)| shown_value(entry, dimension),
            )
        } else {
            found
                .iter()
                .map(|(_, entry)| shown_value(entry, dimension))
                .collect::<Vec<_>>()
                .join(", ")
        };
        let kind = match base.file_keys().last().copied() {
            Some("allan_minimum") => ", Allan minimum",
            Some("coefficient") => ", coefficient B",
            _ if number.starts_with('±') => ", 1 sigma",
            _ => "",
        };
        let each_once = |of: &dyn Fn(&Entry) -> Option<String>| {
            let mut out: Vec<String> = Vec::new();
            for text in found.iter().filter_map(|(_, entry)| of(entry)) {
                if !text.is_empty() && !out.contains(&text) {
                    out.push(text);
                }
            }
            out
        };
        Line {
            sensor: base.sensor(),
            term: words(base),
            value: format!("{number} {unit}{kind}"),
            sources: each_once(&|entry| entry.source.clone()),
            notes: each_once(&|entry| entry.note.clone()),
        }
    }
}
