//! Readers and writers of inertial logs, and their health.
//!
//! A log is a stream of rows: [`open`] recognizes the format by its content and gives a [`LogReader`] that hands out
//! blocks of rows with channels in SI; [`Log::read`] collects them. Units are never guessed.

mod error;
pub mod health;
mod issue;
mod layout;
mod log;
mod options;
mod source;
mod stamps;
mod stream;

pub use error::Error;
pub use issue::{Issue, IssueKind};
pub use layout::{Channel, Layout, Quantity, Topic};
pub use log::Log;
pub use options::ReadOptions;
pub use source::{Folder, ReadSeek, Source, SourceBytes};
pub use stamps::{Stamp, Stamps};
pub use stream::{Block, LogReader, LogWriter};

/// Opens a log: recognizes its format by content and maps its columns to channels in SI.
///
/// # Errors
/// An unknown format, an unknown unit, columns that cannot be told apart, no time and no rate.
pub fn open(source: Source, options: &ReadOptions) -> Result<Box<dyn LogReader>, Error> {
    let _ = options;
    Err(Error::data("the format is not known").at(source.label))
}
