//! What a terminal can show: UTF-8 or ASCII, colors or none, and how wide a text is.

/// How text is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// `± … √ ━` as they are; otherwise their ASCII spellings.
    pub unicode: bool,
    /// ANSI colors.
    pub color: bool,
}

impl Style {
    /// UTF-8 without colors: what a file or a pipe gets.
    pub const PLAIN: Self = Self {
        unicode: true,
        color: false,
    };
    /// ASCII without colors.
    pub const ASCII: Self = Self {
        unicode: false,
        color: false,
    };
    /// UTF-8 with colors.
    pub const COLOR: Self = Self {
        unicode: true,
        color: true,
    };

    /// The text in this style's character set.
    pub fn encode(self, text: &str) -> String {
        if self.unicode {
            text.to_owned()
        } else {
            to_ascii(text)
        }
    }

    /// The text in this style's character set, cut to `columns` with `…` or `..` where it was longer.
    pub fn cut(self, text: &str, columns: usize) -> String {
        let text = self.encode(text);
        if self.unicode || width(&text) <= columns {
            return cut(&text, columns);
        }
        let mut out: String = text.chars().take(columns.saturating_sub(2)).collect();
        out.push_str(&".."[..columns.min(2)]);
        out
    }

    /// The text wrapped in the color of its role, if there are colors.
    pub fn paint(self, role: Role, text: &str) -> String {
        match role.code() {
            Some(code) if self.color && !text.is_empty() => format!("\x1b[{code}m{text}\x1b[0m"),
            _ => text.to_owned(),
        }
    }
}

impl Default for Style {
    fn default() -> Self {
        Self::PLAIN
    }
}

/// What a piece of text is; color follows from it, never the other way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Ordinary text.
    #[default]
    Plain,
    /// A heading: bold.
    Heading,
    /// A warning: yellow.
    Warning,
    /// An error or a bad verdict: red.
    Bad,
    /// A good verdict: green.
    Good,
    /// An interval or an aside: dim.
    Dim,
}

impl Role {
    fn code(self) -> Option<&'static str> {
        match self {
            Self::Plain => None,
            Self::Heading => Some("1"),
            Self::Warning => Some("33"),
            Self::Bad => Some("31"),
            Self::Good => Some("32"),
            Self::Dim => Some("2"),
        }
    }
}

/// Number of terminal columns of a text without color codes.
///
/// Every character counts one, East-Asian wide characters two, combining marks none.
pub fn width(text: &str) -> usize {
    text.chars().map(char_width).sum()
}

pub(crate) fn char_width(c: char) -> usize {
    match c as u32 {
        0x300..=0x36f | 0x200b..=0x200f | 0xfe00..=0xfe0f => 0,
        0x1100..=0x115f
        | 0x2e80..=0xa4cf
        | 0xac00..=0xd7a3
        | 0xf900..=0xfaff
        | 0xfe30..=0xfe6f
        | 0xff00..=0xff60
        | 0xffe0..=0xffe6
        | 0x1f300..=0x1faff => 2,
        _ => 1,
    }
}

/// The text cut to `columns` with `…` at the end where it was longer.
pub fn cut(text: &str, columns: usize) -> String {
    if width(text) <= columns {
        return text.to_owned();
    }
    let mut out = String::new();
    let mut used = 0;
    for c in text.chars() {
        let w = char_width(c);
        if used + w + 1 > columns {
            break;
        }
        used += w;
        out.push(c);
    }
    if columns > 0 {
        out.push('…');
    }
    out
}

/// A name from outside (file, channel, topic) without control characters.
///
/// Control characters and the Unicode direction overrides are replaced by `?`, so that a name can
/// neither color nor move what is printed around it.
pub fn clean(name: &str) -> String {
    name.chars()
        .map(|c| {
            if c.is_control() || matches!(c as u32, 0x202a..=0x202e | 0x2066..=0x2069) {
                '?'
            } else {
                c
            }
        })
        .collect()
}

fn to_ascii(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '√' => {
                out.push_str("sqrt(");
                while let Some(next) = chars.next_if(char::is_ascii_alphanumeric) {
                    out.push(next);
                }
                out.push(')');
            }
            '±' => out.push_str("+/-"),
            '…' => out.push_str(".."),
            '━' | '█' => out.push('#'),
            '─' | '−' | '–' | '—' | '‐' | '\u{2011}' => out.push('-'),
            '°' => out.push_str("deg"),
            'µ' | 'μ' => out.push('u'),
            'τ' => out.push_str("tau"),
            'σ' => out.push_str("sigma"),
            'χ' => out.push_str("chi"),
            'ω' => out.push('w'),
            'Δ' => out.push('d'),
            'ρ' => out.push_str("rho"),
            '²' => out.push_str("^2"),
            '³' => out.push_str("^3"),
            '×' => out.push('x'),
            '·' => out.push('*'),
            '≤' => out.push_str("<="),
            '≥' => out.push_str(">="),
            '≈' => out.push('~'),
            '→' => out.push_str("->"),
            '’' | '‘' => out.push('\''),
            '“' | '”' => out.push('"'),
            '\u{a0}' | '\u{202f}' | '\u{2009}' => out.push(' '),
            c if c.is_ascii() => out.push(c),
            _ => out.push('?'),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ascii_spells_the_roots() {
        assert_eq!(
            Style::ASCII.encode("2.4 ± 0.1 deg/√h, 1 … 2 mg/√Hz"),
            "2.4 +/- 0.1 deg/sqrt(h), 1 .. 2 mg/sqrt(Hz)"
        );
    }

    #[test]
    fn names_cannot_carry_escapes() {
        assert_eq!(clean("a\x1b[31mb\n"), "a?[31mb?");
    }

    #[test]
    fn cutting_counts_columns() {
        assert_eq!(cut("abcdef", 4), "abc…");
        assert_eq!(cut("abcd", 4), "abcd");
        assert_eq!(width(&cut("漢字漢字", 5)), 5);
    }
}
