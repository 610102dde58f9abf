//! A document of paragraphs, tables and findings, rendered once for a terminal.

use super::COLUMNS;
use super::style::{Role, Style, clean, width};
use super::table::Table;
use super::time::clock_span;

/// A finding about the data, as one aligned line.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Kind, as scripts know it: `motion`, `step`, `line`; it also decides warning or note.
    pub kind: String,
    /// Channel or sensor: `accel`, `gyro_x`, `time`.
    pub channel: String,
    /// Start and end in s since the start of the log; `None`: all the time.
    pub span_s: Option<(f64, f64)>,
    /// What was found, without the words before it.
    pub text: String,
}

impl Finding {
    /// `warning` or `note`.
    pub fn severity(&self) -> &'static str {
        if is_note(&self.kind) {
            "note"
        } else {
            "warning"
        }
    }

    fn time(&self) -> String {
        self.span_s
            .map_or_else(|| "all the time".to_owned(), |(a, b)| clock_span(a, b))
    }
}

/// Whether a finding of this kind is a note; the others are warnings.
pub fn is_note(kind: &str) -> bool {
    matches!(kind, "quantization" | "line" | "filtered" | "earth_rate")
}

#[derive(Debug, Clone)]
enum Block {
    Paragraph(String, Role),
    Labelled(String, String, Role),
    Hanging(String, String),
    Line(String, Role),
    Table(Table),
    Findings(Vec<Finding>),
    Blank,
}

/// Paragraphs, tables and findings in the order in which they are read.
///
/// Consecutive blank lines count once; none stands at the start or the end.
#[derive(Debug, Clone, Default)]
pub struct Document {
    blocks: Vec<Block>,
}

impl Document {
    /// An empty document.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether nothing stands in it.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// A paragraph, wrapped.
    pub fn paragraph(&mut self, text: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Paragraph(text.into(), Role::Plain));
        self
    }

    /// A paragraph in the color of a role.
    pub fn verdict(&mut self, role: Role, text: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Paragraph(text.into(), role));
        self
    }

    /// A line as it is, cut where it is too long.
    pub fn line(&mut self, text: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Line(text.into(), Role::Plain));
        self
    }

    /// A heading line.
    pub fn heading(&mut self, text: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Line(text.into(), Role::Heading));
        self
    }

    /// A line with a label, wrapped under its text: `label text`.
    pub fn hanging(&mut self, label: impl Into<String>, text: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Hanging(label.into(), text.into()));
        self
    }

    /// `note: text`, wrapped under its text.
    pub fn note(&mut self, text: impl Into<String>) -> &mut Self {
        self.labelled("note:", text, Role::Plain)
    }

    /// `warning: text`, wrapped under its text.
    pub fn warning(&mut self, text: impl Into<String>) -> &mut Self {
        self.labelled("warning:", text, Role::Warning)
    }

    /// `next: text`, wrapped under its text.
    pub fn next(&mut self, text: impl Into<String>) -> &mut Self {
        self.labelled("next:", text, Role::Plain)
    }

    fn labelled(&mut self, label: &str, text: impl Into<String>, role: Role) -> &mut Self {
        self.blocks
            .push(Block::Labelled(label.to_owned(), text.into(), role));
        self
    }

    /// A table.
    pub fn table(&mut self, table: Table) -> &mut Self {
        self.blocks.push(Block::Table(table));
        self
    }

    /// Findings, aligned with one another; warnings keep their order before the notes.
    pub fn findings(&mut self, findings: impl IntoIterator<Item = Finding>) -> &mut Self {
        let mut findings: Vec<Finding> = findings.into_iter().collect();
        findings.sort_by_key(|f| is_note(&f.kind));
        if !findings.is_empty() {
            self.blocks.push(Block::Findings(findings));
        }
        self
    }

    /// A blank line.
    pub fn blank(&mut self) -> &mut Self {
        self.blocks.push(Block::Blank);
        self
    }

    /// Appends another document.
    pub fn append(&mut self, other: Self) -> &mut Self {
        self.blocks.extend(other.blocks);
        self
    }

    /// The document as text; no line is longer than 80 columns, each ends with a line feed.
    pub fn render(&self, style: Style) -> String {
        let mut lines: Vec<String> = Vec::new();
        for block in &self.blocks {
            match block {
                Block::Blank => {
                    if lines.last().is_some_and(|l| !l.is_empty()) {
                        lines.push(String::new());
                    }
                }
                Block::Paragraph(text, role) => {
                    for line in wrap(&style.encode(text), COLUMNS) {
                        lines.push(style.paint(*role, &line));
                    }
                }
                Block::Line(text, role) => {
                    let text = style.cut(text.trim_end(), COLUMNS);
                    lines.push(style.paint(*role, text.trim_end()));
                }
                Block::Labelled(label, text, role) => {
                    hang(&mut lines, style, label, *role, text, false);
                }
                Block::Hanging(label, text) => {
                    hang(&mut lines, style, label, Role::Plain, text, true);
                }
                Block::Table(table) => lines.extend(table.render(style, COLUMNS)),
                Block::Findings(findings) => render_findings(findings, style, &mut lines),
            }
        }
        while lines.last().is_some_and(String::is_empty) {
            lines.pop();
        }
        let mut out = lines.join("\n");
        if !out.is_empty() {
            out.push('\n');
        }
        out
    }
}

fn hang(
    lines: &mut Vec<String>,
    style: Style,
    label: &str,
    role: Role,
    text: &str,
    keep_spaces: bool,
) {
    let label = style.encode(label);
    let start = if keep_spaces {
        width(&label)
    } else {
        width(&label) + 1
    };
    let wrapped = wrap(&style.encode(text), COLUMNS.saturating_sub(start).max(20));
    for (i, line) in wrapped.iter().enumerate() {
        let head = if i == 0 {
            let space = if keep_spaces { "" } else { " " };
            format!("{}{space}", style.paint(role, &label))
        } else {
            " ".repeat(start)
        };
        lines.push(format!("{head}{line}").trim_end().to_owned());
    }
}

fn render_findings(findings: &[Finding], style: Style, lines: &mut Vec<String>) {
    let column = |f: &dyn Fn(&Finding) -> String| -> usize {
        findings.iter().map(|x| width(&f(x))).max().unwrap_or(0)
    };
    let label = column(&|f| format!("{}:", f.severity()));
    let channel = column(&|f| style.encode(&clean(&f.channel))).min(12);
    let kind = column(&|f| f.kind.clone()).min(16);
    let time = column(&Finding::time);
    let start = label + 1 + channel + 2 + kind + 2 + time + 2;
    for finding in findings {
        let severity = format!("{}:", finding.severity());
        let role = if is_note(&finding.kind) {
            Role::Plain
        } else {
            Role::Warning
        };
        let head = format!(
            "{}{} {}  {}  {}  ",
            style.paint(role, &severity),
            " ".repeat(label - width(&severity)),
            padded(&style.cut(&clean(&finding.channel), channel), channel),
            padded(&style.cut(&finding.kind, kind), kind),
            padded(&finding.time(), time),
        );
        let text = style.encode(&clean(&finding.text));
        for (i, line) in wrap(&text, COLUMNS - start).iter().enumerate() {
            let lead = if i == 0 {
                head.clone()
            } else {
                " ".repeat(start)
            };
            lines.push(format!("{lead}{line}").trim_end().to_owned());
        }
    }
}

fn padded(text: &str, columns: usize) -> String {
    format!("{text}{}", " ".repeat(columns.saturating_sub(width(text))))
}

/// The text in lines of at most `columns` columns, broken at spaces; a longer word is broken where it must.
///
/// A number and its unit (`10 min`) may be parted: write a no-break space where they must not.
/// There is always at least one line.
pub fn wrap(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut lines = Vec::new();
    for part in text.split('\n') {
        let mut line = String::new();
        for word in part.split(' ').filter(|w| !w.is_empty()) {
            let mut word = word.to_owned();
            if !line.is_empty() && width(&line) + 1 + width(&word) > columns {
                lines.push(core::mem::take(&mut line));
            }
            while width(&word) > columns {
                let head: String = head_of(&word, columns);
                word = word[head.len()..].to_owned();
                lines.push(head);
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(&word);
        }
        lines.push(line);
    }
    for line in &mut lines {
        *line = line.replace('\u{a0}', " ");
    }
    lines
}

fn head_of(word: &str, columns: usize) -> String {
    let mut head = String::new();
    for c in word.chars() {
        if !head.is_empty() && width(&head) + super::style::char_width(c) > columns {
            break;
        }
        head.push(c);
    }
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(channel: &str, kind: &str, span_s: Option<(f64, f64)>, text: &str) -> Finding {
        Finding {
            kind: kind.to_owned(),
            channel: channel.to_owned(),
            span_s,
            text: text.to_owned(),
        }
    }

    #[test]
    fn findings_align_and_notes_come_last() {
        let mut document = Document::new();
        document.findings([
            finding("accel", "line", None, "0.568 Hz, 10 mm/s^2 on x"),
            finding(
                "accel",
                "motion",
                Some((0.0, 70.0)),
                "levels move by up to 36 mm/s^2",
            ),
            finding(
                "accel",
                "step",
                Some((2020.0, 2020.0)),
                "-20, -14, -13 mm/s^2 on x, y, z",
            ),
        ]);
        assert_eq!(
            document.render(Style::PLAIN),
            "\
warning: accel  motion  0:00 - 1:10   levels move by up to 36 mm/s^2
warning: accel  step    33:40         -20, -14, -13 mm/s^2 on x, y, z
note:    accel  line    all the time  0.568 Hz, 10 mm/s^2 on x
"
        );
    }

    #[test]
    fn no_line_is_longer_than_eighty_columns() {
        let mut document = Document::new();
        document
            .paragraph("word ".repeat(60))
            .paragraph("x".repeat(200))
            .warning("word ".repeat(40))
            .line("y".repeat(90))
            .findings([finding(
                &"c".repeat(60),
                "non_stationary",
                None,
                &"t".repeat(300),
            )]);
        for style in [Style::PLAIN, Style::ASCII] {
            for line in document.render(style).lines() {
                assert!(width(line) <= COLUMNS, "{line}");
                assert_eq!(line, line.trim_end());
            }
        }
    }

    #[test]
    fn labels_hang() {
        let mut document = Document::new();
        document.note("a ".repeat(50));
        let text = document.render(Style::PLAIN);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("note: a a"));
        assert!(lines[1].starts_with("      a"));
    }

    #[test]
    fn blanks_collapse() {
        let mut document = Document::new();
        document.blank().line("a").blank().blank().line("b").blank();
        assert_eq!(document.render(Style::PLAIN), "a\n\nb\n");
    }
}
