//! Another tool's file as a sensor model.

use crate::Error;
use sagnac_model::Model;
use sagnac_model::export::Format;
use sagnac_report::text::{Document, Style};
use serde_json::{Value, json};

/// How a file is read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImportRequest {
    /// The format; found by its keys where absent.
    pub from: Option<Format>,
    /// The sampling rate, where the file does not say it, in Hz.
    pub rate_hz: Option<f64>,
}

/// The model.
#[derive(Debug, Clone)]
pub struct ImportOutcome {
    /// What the file says, as a model.
    pub model: Model,
    /// The format it was read as.
    pub format: Format,
    /// What is ambiguous about it.
    pub notes: Vec<String>,
}

/// Reads another tool's file; `label` names it in errors.
///
/// # Errors
/// A file of no known format, or one without a number of a sensor.
pub fn import(bytes: &[u8], label: &str, request: &ImportRequest) -> Result<ImportOutcome, Error> {
    let imported = sagnac_model::foreign::import(bytes, label, request.from, request.rate_hz)?;
    Ok(ImportOutcome {
        model: imported.model,
        format: imported.format,
        notes: imported.notes,
    })
}

impl ImportOutcome {
    /// `{"format", "model", "notes"}`.
    pub fn to_json(&self) -> Value {
        json!({ "format": self.format.name(), "model": self.model.to_json(), "notes": self.notes })
    }

    /// What was found, as a document.
    pub fn document(&self) -> Document {
        let count = self
            .model
            .parameters()
            .map(|(path, _)| path.without_axis())
            .collect::<std::collections::BTreeSet<_>>()
            .len();
        let mut document = Document::new();
        document
            .paragraph(format!("{}: {count} parameters.", self.format.title()))
            .blank();
        for note in &self.notes {
            document.note(note.as_str());
        }
        document
    }

    /// What was found, as text.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}
