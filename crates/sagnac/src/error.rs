//! One error for every task: what is wrong, where, and what to do about it.
//!
//! ```
//! use sagnac::Error;
//!
//! let error = Error::data("the log has no time and no rate")
//!     .at("counts.csv: columns gx, gy, gz")
//!     .advise("add --rate, for instance --rate 100Hz");
//! assert_eq!(error.what, "the log has no time and no rate");
//! assert_eq!(error.exit_code(), 1);
//! ```

use std::fmt;

/// Whether the request or the data is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What is in a file or a log: exit code 1.
    Data,
    /// The request itself, e.g. a value of the wrong dimension or an output that exists: exit code 2.
    Usage,
}

/// Why a task could not be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// Whose fault it is.
    pub kind: Kind,
    /// One sentence that says what is wrong, lower case and without a full stop.
    pub what: String,
    /// File, line, column, row or parameter path.
    pub place: Option<String>,
    /// What to do, with an example.
    pub advice: Option<String>,
    /// What was found all the same: the document of `--format json`.
    pub found: Option<Box<serde_json::Value>>,
}

impl Error {
    /// An error in the data.
    pub fn data(what: impl Into<String>) -> Self {
        Self {
            kind: Kind::Data,
            what: what.into(),
            place: None,
            advice: None,
            found: None,
        }
    }

    /// An error in the request.
    pub fn usage(what: impl Into<String>) -> Self {
        Self {
            kind: Kind::Usage,
            ..Self::data(what)
        }
    }

    /// Says where; a place that is already known stays and is put behind this one, e.g. `imu.toml, line 3`.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> Self {
        let outer = place.into();
        self.place = Some(match self.place.take() {
            // A place that names its file already is not told twice.
            Some(inner) if inner.starts_with(&outer) => inner,
            Some(inner) => format!("{outer}, {inner}"),
            None => outer,
        });
        self
    }

    /// Says what to do.
    #[must_use]
    pub fn advise(mut self, advice: impl Into<String>) -> Self {
        self.advice = Some(advice.into());
        self
    }

    /// Keeps what was found before it failed.
    #[must_use]
    pub fn with_found(mut self, found: serde_json::Value) -> Self {
        self.found = Some(Box::new(found));
        self
    }

    /// 1 for data, 2 for usage.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Data => 1,
            Kind::Usage => 2,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        for line in [&self.place, &self.advice].into_iter().flatten() {
            write!(f, "\n  {line}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
