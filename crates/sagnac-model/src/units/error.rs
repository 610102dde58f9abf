//! What can be wrong with a quantity as text: one sentence, and an example of what is right.

use std::borrow::Cow;

/// A text that is not the quantity it should be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Nothing, or something that does not begin with a number.
    #[error("expected {expected}, got no number: \"{text}\"")]
    NotANumber {
        /// The text, cut to a readable length.
        text: String,
        /// The expected quantity in words.
        expected: Cow<'static, str>,
        /// How it may be written.
        example: Cow<'static, str>,
    },
    /// A number, or its value in SI, beyond the range of an `f64`.
    #[error(
        "expected {expected}, got a number that is too large: \"{text}\" is beyond 1.8e308 in SI"
    )]
    TooLarge {
        /// The text, cut to a readable length.
        text: String,
        /// The expected quantity in words.
        expected: Cow<'static, str>,
        /// How it may be written.
        example: Cow<'static, str>,
    },
    /// `inf` or `nan`.
    #[error("expected {expected}, got a value that is not finite: \"{text}\"")]
    NotFinite {
        /// The text, cut to a readable length.
        text: String,
        /// The expected quantity in words.
        expected: Cow<'static, str>,
        /// How it may be written.
        example: Cow<'static, str>,
    },
    /// A bare number where a unit is needed.
    #[error("expected {expected} with its unit, got a bare number: \"{text}\"")]
    MissingUnit {
        /// The text, cut to a readable length.
        text: String,
        /// The expected quantity in words.
        expected: Cow<'static, str>,
        /// How it may be written.
        example: Cow<'static, str>,
    },
    /// A symbol that is not in the table of units.
    #[error("the unit `{symbol}` is not known: \"{text}\"")]
    UnknownUnit {
        /// The symbol.
        symbol: String,
        /// The text, cut to a readable length.
        text: String,
        /// A unit that is spelled nearly so.
        suggestion: Option<&'static str>,
        /// How the quantity may be written, where one was expected.
        example: Option<Cow<'static, str>>,
    },
    /// Symbols that do not form a unit.
    #[error("the quantity cannot be read, {problem}: \"{text}\"")]
    BadUnit {
        /// What is wrong.
        problem: &'static str,
        /// The text, cut to a readable length.
        text: String,
        /// How the quantity may be written, where one was expected.
        example: Option<Cow<'static, str>>,
    },
    /// A unit of another dimension.
    #[error("expected {expected}, got {got}: \"{text}\"")]
    WrongDimension {
        /// The text, cut to a readable length.
        text: String,
        /// The expected quantity in words.
        expected: Cow<'static, str>,
        /// What the unit measures, in words.
        got: Cow<'static, str>,
        /// How it may be written.
        example: Cow<'static, str>,
    },
    /// Another number of values than expected.
    #[error("expected {expected} numbers and a unit, got {got}: \"{text}\"")]
    Count {
        /// The text, cut to a readable length.
        text: String,
        /// How many were expected.
        expected: usize,
        /// How many there are.
        got: usize,
    },
}

impl Error {
    /// What to do about it, with an example.
    pub fn advice(&self) -> Option<String> {
        let example = match self {
            Self::NotANumber { example, .. }
            | Self::TooLarge { example, .. }
            | Self::NotFinite { example, .. }
            | Self::MissingUnit { example, .. }
            | Self::WrongDimension { example, .. } => example,
            Self::UnknownUnit {
                suggestion: Some(suggestion),
                ..
            } => return Some(format!("did you mean `{suggestion}`?")),
            Self::UnknownUnit { example, .. } | Self::BadUnit { example, .. } => {
                example.as_ref()?
            }
            Self::Count { .. } => return None,
        };
        Some(format!("write for instance \"{example}\""))
    }

    pub(crate) fn with_example(self, wanted: impl Into<Cow<'static, str>>) -> Self {
        match self {
            Self::UnknownUnit {
                symbol,
                text,
                suggestion,
                ..
            } => Self::UnknownUnit {
                symbol,
                text,
                suggestion,
                example: Some(wanted.into()),
            },
            Self::BadUnit { problem, text, .. } => Self::BadUnit {
                problem,
                text,
                example: Some(wanted.into()),
            },
            other => other,
        }
    }

    pub(crate) fn with_text(mut self, wanted: &str) -> Self {
        let (Self::NotANumber { text, .. }
        | Self::TooLarge { text, .. }
        | Self::NotFinite { text, .. }
        | Self::MissingUnit { text, .. }
        | Self::UnknownUnit { text, .. }
        | Self::BadUnit { text, .. }
        | Self::WrongDimension { text, .. }
        | Self::Count { text, .. }) = &mut self;
        *text = clip(wanted);
        self
    }
}

/// A text cut to a length that an error can show, without control characters.
pub(crate) fn clip(text: &str) -> String {
    let mut cut: String = text
        .chars()
        .take(60)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if text.chars().nth(60).is_some() {
        cut.push('…');
    }
    cut
}
