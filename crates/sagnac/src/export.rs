//! A model for another tool, in that tool's keys, units and conventions.
//!
//! ```
//! use sagnac::export::{ExportRequest, export};
//! use sagnac::model::{Catalogue, export::Format};
//!
//! let model = Catalogue::embedded().find("ADIS16470")?;
//! let request = ExportRequest { format: Format::Kalibr, inflate: 1.0 };
//! let outcome = export(&model, &request)?;
//! assert!(String::from_utf8_lossy(&outcome.bytes).contains("gyroscope_noise_density"));
//! # Ok::<(), sagnac::Error>(())
//! ```

use crate::Error;
use sagnac_model::Model;
use sagnac_model::export::Format;
use serde_json::{Value, json};

/// For which tool, and by how much the noise is inflated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExportRequest {
    /// The tool's format.
    pub format: Format,
    /// Factor on N, K and in-run bias sigmas; 1 leaves them.
    pub inflate: f64,
}

/// The file.
#[derive(Debug, Clone)]
pub struct ExportOutcome {
    /// Its format.
    pub format: Format,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What its format cannot hold as comments.
    pub remarks: Vec<String>,
    /// Parameters of which only an upper limit is known: they count as absent.
    pub limits: Vec<String>,
}

/// Writes a model for another tool.
///
/// # Errors
/// A number that the format needs and the model lacks, by name.
pub fn export(model: &Model, request: &ExportRequest) -> Result<ExportOutcome, Error> {
    let exported = sagnac_model::export::export(model, request.format, request.inflate)?;
    Ok(ExportOutcome {
        format: request.format,
        bytes: exported.bytes,
        remarks: exported.remarks,
        limits: model.limits().iter().map(ToString::to_string).collect(),
    })
}

impl ExportOutcome {
    /// `{"format", "bytes", "text", "remarks"}`; `text` is null of a binary file.
    pub fn to_json(&self) -> Value {
        json!({
            "format": self.format.name(),
            "bytes": self.bytes.len(),
            "text": self.format.is_text().then(|| String::from_utf8_lossy(&self.bytes)),
            "remarks": self.remarks,
        })
    }

    /// The file, where it is text.
    pub fn to_text(&self) -> String {
        if self.format.is_text() {
            String::from_utf8_lossy(&self.bytes).into_owned()
        } else {
            String::new()
        }
    }
}
