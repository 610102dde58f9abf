//! Terminal text: numbers with their uncertainty, tables of 80 columns, sentences, findings.
//!
//! A [`Document`] collects paragraphs, tables and findings and is rendered once, for a [`Style`]
//! (UTF-8 or ASCII, colored or not). Its plain rendering is what `to_text` of an outcome returns.
//!
//! ```
//! use sagnac_report::text::{Cell, Document, Estimate, Style, Table};
//! let mut table = Table::estimates(&["Gyro", "x", "y", ""]);
//! table.row([
//!     Cell::from("Angle random walk"),
//!     Estimate::detected(2.4139, 2.393, 2.435).into(),
//!     Estimate::upper_limit(0.0312).into(),
//!     "deg/√h".into(),
//! ]);
//! let mut document = Document::new();
//! document.paragraph("The gyro is well determined.").blank().table(table);
//! assert_eq!(
//!     document.render(Style::PLAIN),
//!     "The gyro is well determined.\n\n\
//!      Gyro               x              y\n\
//!      Angle random walk  2.414 ± 0.021  < 0.031  deg/√h\n"
//! );
//! ```

mod curve;
mod document;
mod number;
mod style;
mod table;
mod time;
mod unit;

pub use curve::{Curve, curves};
pub use document::{Document, Finding, is_note, wrap};
pub use number::{
    Estimate, EstimateText, decimals_of, estimate, fixed, general, group_numbers, group_thousands,
    limit, percent, significant,
};
pub use style::{Role, Style, clean, cut, width};
pub use table::{Align, Cell, Table};
pub use time::{clock, clock_span, duration, seconds};
pub use unit::{Sensor, Unit, term_in_sentence, term_name, term_symbol};

/// Number of columns of every line of text.
pub const COLUMNS: usize = 80;
