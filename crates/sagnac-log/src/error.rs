//! What can go wrong with a log: one sentence, where it is, and what to do about it.

use std::io;

/// An error of reading, mapping or writing a log.
///
/// `Display` is the sentence (lower case, no full stop); [`Error::place`] says where and [`Error::advice`] what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something in the data is wrong: the caller exits with 1.
    #[error("{what}")]
    Data {
        /// The sentence.
        what: String,
        /// Where: file, line, column.
        place: Option<String>,
        /// What to do, with an example.
        advice: Option<String>,
    },
    /// Something in the request is wrong (an option's text): the caller exits with 2.
    #[error("{what}")]
    Usage {
        /// The sentence.
        what: String,
        /// Where: the option's text.
        place: Option<String>,
        /// What to do, with an example.
        advice: Option<String>,
    },
    /// The operating system refused to read or write.
    #[error("{doing}: {}", plain(source))]
    Io {
        /// What was being done ("cannot read the log").
        doing: &'static str,
        /// Where: the label of the source.
        place: Option<String>,
        /// The reason.
        source: io::Error,
    },
}

const WRITING: &str = "the log cannot be written";

/// The system's sentence without its number, in lower case.
fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        let is_word = chars.clone().next().is_some_and(char::is_lowercase);
        // A file's name keeps its case.
        let keeps = !is_word || error.raw_os_error().is_none();
        let first: String = if keeps {
            first.to_string()
        } else {
            first.to_lowercase().collect()
        };
        format!("{first}{}", chars.as_str())
    })
}

impl Error {
    /// An error in the data.
    pub fn data(what: impl Into<String>) -> Self {
        Self::Data {
            what: what.into(),
            place: None,
            advice: None,
        }
    }

    /// The error of a log without rows.
    pub(crate) fn no_samples() -> Self {
        Self::data("the log has no samples")
            .advise("look at what recorded it, or at --start and --end")
    }

    /// An error in the request.
    pub fn usage(what: impl Into<String>) -> Self {
        Self::Usage {
            what: what.into(),
            place: None,
            advice: None,
        }
    }

    /// An error of the operating system while reading.
    pub fn read(source: io::Error) -> Self {
        Self::Io {
            doing: "the log cannot be read",
            place: None,
            source,
        }
    }

    /// An error of the operating system while writing.
    pub fn write(source: io::Error) -> Self {
        Self::Io {
            doing: WRITING,
            place: None,
            source,
        }
    }

    /// The same error with its place.
    #[must_use]
    pub fn at(mut self, text: impl Into<String>) -> Self {
        match &mut self {
            Self::Data { place, .. } | Self::Usage { place, .. } | Self::Io { place, .. } => {
                *place = Some(text.into());
            }
        }
        self
    }

    /// The same error with `label` before its place.
    #[must_use]
    pub fn in_source(mut self, label: &str) -> Self {
        if let Self::Data { place, .. } | Self::Io { place, .. } = &mut self {
            *place = Some(match place.take() {
                Some(inner) if inner.starts_with(label) => inner,
                Some(inner) => format!("{label}, {inner}"),
                None => label.to_owned(),
            });
        }
        self
    }

    /// The same error with advice.
    #[must_use]
    pub fn advise(mut self, text: impl Into<String>) -> Self {
        if let Self::Data { advice, .. } | Self::Usage { advice, .. } = &mut self {
            *advice = Some(text.into());
        }
        self
    }

    /// Where the error is, if known.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::Data { place, .. } | Self::Usage { place, .. } | Self::Io { place, .. } => {
                place.clone()
            }
        }
    }

    /// What to do, if known.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::Data { advice, .. } | Self::Usage { advice, .. } => advice.clone(),
            Self::Io { doing, .. } if *doing == WRITING => {
                Some("nothing was written; choose another place or free some room".to_owned())
            }
            Self::Io { source, .. } => {
                // What the decompressors say, see `input.rs`.
                let text = source.to_string();
                let is_packed = source.kind() == io::ErrorKind::InvalidData;
                (is_packed && (text.contains("gzip") || text.contains("zstd"))).then(|| {
                    let tool = if text.contains("gzip") { "gzip" } else { "zstd" };
                    format!("copy it again, or keep what is whole: {tool} -dc FILE | sed '$d' > part.csv")
                })
            }
        }
    }

    /// True where the request is at fault and not the data.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Usage { .. })
    }
}
