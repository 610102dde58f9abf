//! Tables of pages: on a phone each row becomes a block.

use core::fmt::Write as _;

use super::Rich;
use crate::svg::escape;

/// A cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HtmlCell {
    /// What it says.
    pub text: Rich,
    /// A number: right-aligned.
    pub number: bool,
    /// Second line, muted.
    pub note: String,
    /// Share of a bar in it, 0 … 1.
    pub bar: Option<f64>,
    /// Class of its text: `good`, `warn`, `bad` or nothing.
    pub class: &'static str,
    /// On a phone it takes the whole width: a sentence, not a number.
    pub whole_row: bool,
}

impl HtmlCell {
    /// A number.
    pub fn number(text: impl Into<Rich>) -> Self {
        Self {
            text: text.into(),
            number: true,
            ..Self::default()
        }
    }

    /// A bar of this share of the cell.
    pub fn bar(share: f64) -> Self {
        Self {
            bar: Some(share),
            ..Self::default()
        }
    }

    /// As wide as the page on a phone.
    #[must_use]
    pub fn whole_row(mut self) -> Self {
        self.whole_row = true;
        self
    }

    /// With a second line.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

impl From<&str> for HtmlCell {
    fn from(text: &str) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }
}

impl From<String> for HtmlCell {
    fn from(text: String) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }
}

impl From<Rich> for HtmlCell {
    fn from(text: Rich) -> Self {
        Self {
            text,
            ..Self::default()
        }
    }
}

/// A table whose first column names its rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HtmlTable {
    /// Value of `data-table`.
    pub name: String,
    /// Headings.
    pub heading: Vec<String>,
    /// Which columns hold numbers (headings stand right too).
    pub numbers: Vec<bool>,
    /// Rows: the first cell is the name.
    pub rows: Vec<Vec<HtmlCell>>,
}

impl HtmlTable {
    /// A table with these headings; `numbers` are the indices of columns of numbers.
    pub fn new(name: &str, heading: &[&str], numbers: &[usize]) -> Self {
        Self {
            name: name.to_owned(),
            heading: heading.iter().map(|&h| h.to_owned()).collect(),
            numbers: (0..heading.len()).map(|i| numbers.contains(&i)).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<HtmlCell>) -> &mut Self {
        self.rows.push(cells);
        self
    }

    /// The table as markup.
    pub fn html(&self) -> String {
        let columns = self.heading.len().saturating_sub(1).clamp(1, 3);
        let mut out = format!(
            "<table class=\"blocks\" data-table=\"{}\" style=\"--columns:{columns}\"><thead><tr>",
            escape(&self.name)
        );
        for (i, heading) in self.heading.iter().enumerate() {
            let class = if self.is_number(i) {
                " class=\"n\""
            } else {
                ""
            };
            let _ = write!(out, "<th scope=\"col\"{class}>{}</th>", escape(heading));
        }
        out.push_str("</tr></thead><tbody>");
        for row in &self.rows {
            out.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                self.cell(i, cell, &mut out);
            }
            out.push_str("</tr>");
        }
        out.push_str("</tbody></table>");
        out
    }

    fn is_number(&self, column: usize) -> bool {
        self.numbers.get(column).copied().unwrap_or(false)
    }

    fn cell(&self, column: usize, cell: &HtmlCell, out: &mut String) {
        if column == 0 {
            let _ = write!(out, "<th scope=\"row\">{}</th>", cell.text.html());
            return;
        }
        let label = self.heading.get(column).map_or("", String::as_str);
        let label = if label.is_empty() {
            String::new()
        } else {
            format!(" data-label=\"{}\"", escape(label))
        };
        if let Some(share) = cell.bar {
            let share = if share.is_finite() {
                share.clamp(0.0, 1.0)
            } else {
                0.0
            };
            let _ = write!(
                out,
                "<td class=\"barcell\"><span class=\"bar\" style=\"width:{:.1}%\"></span></td>",
                100.0 * share
            );
            return;
        }
        let class = if cell.whole_row {
            " class=\"whole\""
        } else if cell.number || self.is_number(column) {
            " class=\"n\""
        } else {
            ""
        };
        let text = if cell.class.is_empty() {
            cell.text.html()
        } else {
            format!("<span class=\"{}\">{}</span>", cell.class, cell.text.html())
        };
        let _ = write!(out, "<td{class}{label}>{text}");
        if !cell.note.is_empty() {
            let _ = write!(out, "<span class=\"i\">{}</span>", escape(&cell.note));
        }
        out.push_str("</td>");
    }
}
