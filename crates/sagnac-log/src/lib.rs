//! Readers and writers of inertial logs, and their health.
//!
//! A log is a stream of rows: [`open`] recognizes the format by its content and gives a [`LogReader`] that hands out
//! blocks of rows with channels in SI; [`Log::read`] collects them. Units are never guessed.

mod beat;
mod cells;
mod clock;
mod coarse;
mod error;
mod format;

pub mod health;
mod input;
mod issue;
mod layout;
mod live;
mod log;
mod map;
mod npy;
mod options;
mod sections;
mod source;
mod stamps;
mod stream;
mod text;
mod wild;
mod write;

pub use beat::Cadence;
pub use cells::{Cells, TextColumn};
pub use error::Error;
pub use issue::{Issue, IssueKind};
pub use layout::{Channel, Layout, Quantity, Topic};
pub use log::Log;
pub use options::ReadOptions;
pub use sections::{Section, Sections};
pub use source::{Folder, ReadSeek, Source, SourceBytes};
pub use stamps::{Stamp, Stamps};
pub use stream::{Block, LogReader, LogWriter};
pub use write::{WriteFormat, WriteSeek, create};

/// Opens a log: recognizes its format by content and maps its columns to channels in SI.
///
/// # Errors
/// An unknown format, an unknown unit, columns that cannot be told apart, no time and no rate.
///
/// ```
/// use sagnac_log::{Log, ReadOptions, Source, open};
/// let text = "time [s],gyro_x [deg/s]\n0.01,180\n0.02,90\n";
/// let mut reader = open(Source::memory("a.csv", text.into()), &ReadOptions::default())?;
/// let log = Log::read(&mut *reader)?;
/// assert_eq!(log.channel("gyro_x").map(|c| c[0]), Some(std::f64::consts::PI));
/// // Units are never guessed.
/// let error = open(Source::memory("a.csv", "time [s],gyro_x\n0,1\n".into()), &ReadOptions::default());
/// assert!(error.is_err_and(|e| e.to_string().contains("unit")));
/// # Ok::<(), sagnac_log::Error>(())
/// ```
pub fn open(source: Source, options: &ReadOptions) -> Result<Box<dyn LogReader>, Error> {
    let label = source.label.clone();
    open_here(source, options, &label).map_err(|e| e.in_source(&label))
}

fn open_here(
    source: Source,
    options: &ReadOptions,
    label: &str,
) -> Result<Box<dyn LogReader>, Error> {
    let raw = format::open(source, options)?;
    Ok(Box::new(map::mapped::Mapped::new(raw, options, label)?))
}

/// Reads a whole log into memory: [`open`], then [`Log::read`].
///
/// # Errors
/// Those of both.
pub fn read(source: Source, options: &ReadOptions) -> Result<Log, Error> {
    let label = source.label.clone();
    let mut reader = open(source, options)?;
    Log::read(&mut *reader).map_err(|e| e.in_source(&label))
}
