//! A sentence with bold words and code; what comes from outside stays text.

use core::fmt::Write as _;

use crate::svg::escape;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Plain,
    Bold,
    Code,
    Colored(&'static str),
}

/// A sentence of plain, bold and code pieces.
///
/// ```
/// use sagnac_report::html::Rich;
/// let rich = Rich::new().bold("Temperature.").plain(" Read <b> as text.");
/// assert_eq!(rich.html(), "<b>Temperature.</b> Read &lt;b&gt; as text.");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Rich {
    pieces: Vec<(Kind, String)>,
}

impl Rich {
    /// An empty sentence.
    pub fn new() -> Self {
        Self::default()
    }

    /// A sentence in which the caller marked `**bold**` and `` `code` ``.
    ///
    /// Only for sentences of the program; names from a log go through [`Rich::plain`].
    pub fn marked(text: &str) -> Self {
        let mut rich = Self::new();
        for (i, part) in text.split("**").enumerate() {
            for (j, piece) in part.split('`').enumerate() {
                let kind = match (i % 2, j % 2) {
                    (_, 1) => Kind::Code,
                    (1, _) => Kind::Bold,
                    _ => Kind::Plain,
                };
                if !piece.is_empty() {
                    rich.pieces.push((kind, piece.to_owned()));
                }
            }
        }
        rich
    }

    /// With a plain piece.
    #[must_use]
    pub fn plain(self, text: impl Into<String>) -> Self {
        self.with(Kind::Plain, text)
    }

    /// With a bold piece.
    #[must_use]
    pub fn bold(self, text: impl Into<String>) -> Self {
        self.with(Kind::Bold, text)
    }

    /// With a piece of code.
    #[must_use]
    pub fn code(self, text: impl Into<String>) -> Self {
        self.with(Kind::Code, text)
    }

    /// With a bold piece in the color of a class (`chip-mems`, `good`, …).
    #[must_use]
    pub fn colored(self, class: &'static str, text: impl Into<String>) -> Self {
        self.with(Kind::Colored(class), text)
    }

    fn with(mut self, kind: Kind, text: impl Into<String>) -> Self {
        self.pieces.push((kind, text.into()));
        self
    }

    /// Whether nothing is in it.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// The sentence as markup.
    pub fn html(&self) -> String {
        let mut out = String::new();
        for (kind, text) in &self.pieces {
            let text = escape(text);
            let _ = match kind {
                Kind::Plain => write!(out, "{text}"),
                Kind::Bold => write!(out, "<b>{text}</b>"),
                Kind::Code => write!(out, "<code>{text}</code>"),
                Kind::Colored(class) => write!(out, "<span class=\"{class}\">{text}</span>"),
            };
        }
        out
    }

    /// The sentence without marks.
    pub fn text(&self) -> String {
        self.pieces.iter().map(|p| p.1.as_str()).collect()
    }
}

impl From<&str> for Rich {
    fn from(text: &str) -> Self {
        Self::new().plain(text)
    }
}

impl From<String> for Rich {
    fn from(text: String) -> Self {
        Self::new().plain(text)
    }
}
