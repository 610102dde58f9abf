//! Is somebody's noise file right? Every number: what it means, whether it is possible, whether a reference shows it.
//!
//! ```
//! use sagnac::audit::{AuditRequest, audit};
//!
//! let yaml = "gyroscope_noise_density: 1.6968e-04\ngyroscope_random_walk: 1.9393e-05\nupdate_rate: 200\n";
//! let outcome = audit(yaml.as_bytes(), "imu.yaml", &AuditRequest::default())?;
//! assert!(outcome.to_text().contains("suspicious"));
//! # Ok::<(), sagnac::Error>(())
//! ```

use crate::Error;
use sagnac_model::Model;
use sagnac_model::export::Format;
use sagnac_model::foreign::{Audit, AuditEntry, Verdict};
use sagnac_model::units::format_number;
use sagnac_report::text::{Document, Role, Style, width};
use serde_json::{Value, json};

/// How a file is judged.
#[derive(Debug, Clone, Copy, Default)]
pub struct AuditRequest<'a> {
    /// The format; found by its keys where absent.
    pub from: Option<Format>,
    /// The sampling rate, where the file does not say it, in Hz.
    pub rate_hz: Option<f64>,
    /// What the numbers are compared with: a sheet, or what a log gave.
    pub reference: Option<&'a Model>,
}

/// A file judged.
#[derive(Debug, Clone)]
pub struct AuditOutcome {
    /// Number by number.
    pub audit: Audit,
    /// Whether the corrected file is being written, so that the text need not tell how.
    pub is_written: bool,
    has_reference: bool,
}

/// Judges another tool's file; `label` names it in errors.
///
/// # Errors
/// A file of no known format, or without a noise number.
pub fn audit(bytes: &[u8], label: &str, request: &AuditRequest) -> Result<AuditOutcome, Error> {
    let audit = sagnac_model::foreign::audit(
        bytes,
        label,
        request.from,
        request.rate_hz,
        request.reference,
    )?;
    Ok(AuditOutcome {
        audit,
        is_written: false,
        has_reference: request.reference.is_some(),
    })
}

impl AuditOutcome {
    /// `{"format", "entries": [{"key", "value", "convention", "meaning", "possible", "log_ratio", "verdict", "likely_mistake", "text"}], "notes"}`.
    pub fn to_json(&self) -> Value {
        let entries: Vec<Value> = self.audit.entries.iter().map(entry_json).collect();
        json!({
            "format": self.audit.format.name(),
            "rate_hz": self.audit.rate_hz,
            "entries": entries,
            "notes": self.audit.notes,
        })
    }

    /// How many numbers have a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.audit
            .entries
            .iter()
            .filter(|entry| entry.verdict == verdict)
            .count()
    }

    /// The verdicts as a document.
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        let total = self.audit.entries.len();
        let (wrong, suspicious, unknown) = (
            self.count(Verdict::Wrong),
            self.count(Verdict::Suspicious),
            self.count(Verdict::Unknown),
        );
        let mut parts = Vec::new();
        for (count, word) in [
            (wrong, "wrong"),
            (suspicious, "suspicious"),
            (unknown, "unknown"),
        ] {
            if count > 0 {
                let noun = if parts.is_empty() {
                    format!(" of {total} numbers")
                } else {
                    String::new()
                };
                parts.push(format!(
                    "{count}{noun} {} {word}",
                    if count == 1 { "is" } else { "are" }
                ));
            }
        }
        let basis = if self.has_reference {
            "agree with the reference"
        } else {
            "are possible"
        };
        let summary = if parts.is_empty() {
            format!("all {total} numbers {basis}")
        } else {
            parts.join(", ")
        };
        let role = if wrong > 0 {
            Role::Bad
        } else if suspicious > 0 {
            Role::Warning
        } else {
            Role::Plain
        };
        document
            .verdict(role, format!("{}: {summary}.", self.audit.format.title()))
            .blank();
        let keys = self
            .audit
            .entries
            .iter()
            .map(|entry| width(&entry.key))
            .max()
            .unwrap_or(0);
        for entry in &self.audit.entries {
            let pad = " ".repeat(keys.saturating_sub(width(&entry.key)));
            let mistake = entry.likely_mistake.map_or("", |mistake| mistake.words());
            let line = format!(
                "{}{pad}  {:>9}  {:10}  {mistake}",
                entry.key,
                exponent(entry.value),
                entry.verdict.key()
            );
            document.line(line.trim_end().to_string());
            document.hanging("  ", pretty(&entry.text));
        }
        document.blank();
        if let Some(also) = self.audit.also {
            document.note(format!(
                "the file also fits {0}; --from {0} reads it so",
                also.name()
            ));
        }
        for note in &self.audit.notes {
            document.note(note.as_str());
        }
        let correctable = self.audit.corrected.is_some() && !self.is_written;
        if self.has_reference && wrong + suspicious > 0 && correctable {
            document.line("corrected file: add -o corrected.yaml");
        } else if !self.has_reference {
            document
                .line("next: compare with a log, --log static.csv, or a model, --model imu.toml");
        }
        document
    }

    /// The verdicts as text.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}

fn exponent(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value.abs()) {
        return format_number(value);
    }
    let whole = format!("{value:e}");
    // Of more digits six are enough to find a number in the file.
    if whole.len() <= 12 {
        return whole;
    }
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:e}")
}

/// Units as the terminal shows them.
fn pretty(text: &str) -> String {
    text.replace("sqrt(h)", "√h")
        .replace("sqrt(s)", "√s")
        .replace("sqrt(Hz)", "√Hz")
}

fn entry_json(entry: &AuditEntry) -> Value {
    let dimension = entry.quantity.dimension(entry.sensor);
    let meaning = entry
        .meaning
        .map(|value| json!({ "quantity": entry.quantity.key(), "sensor": entry.sensor.key(), "value": value, "unit": dimension.si_unit() }));
    let ratio = entry.ratio.map(|ratio| {
        let end = |value: f64| {
            if ratio.known {
                json!(value)
            } else {
                Value::Null
            }
        };
        json!({
            "status": "detected",
            "value": ratio.value,
            "lower": end(ratio.lower),
            "upper": end(ratio.upper),
            "sigma": end((ratio.upper - ratio.lower) / 3.92),
            "unit": "1",
        })
    });
    json!({
        "key": entry.key,
        "value": entry.value,
        "convention": entry.convention,
        "meaning": meaning,
        "possible": entry.possible,
        "log_ratio": ratio,
        "verdict": entry.verdict.key(),
        "likely_mistake": entry.likely_mistake.map(sagnac_model::foreign::Mistake::key),
        "text": entry.text,
    })
}
