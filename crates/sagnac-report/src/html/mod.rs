//! Pages: one file each, readable without scripts, light, dark, on a phone and on paper.
//!
//! A page is built of [`Section`]s with paragraphs, tables and figures; the pages of the commands are
//! structs of their own ([`CharacterizePage`] and others) that build one.

mod calibration;
mod characterize;
mod results;
mod rich;
mod table;
mod views;

pub use calibration::{CertificatePage, Reference};
pub use characterize::{CharacterizePage, Input, LogReport, Overview, ParameterCell, ParameterRow};
pub use results::{ResultRow, ResultTable};
pub use rich::Rich;
pub use table::{HtmlCell, HtmlTable};
pub use views::{
    BudgetRow, ChartPage, ComparePage, CompareRow, DriftPage, ExplainPage, Opening, RandomRow,
    RecordingPage, ResponsePage, ResponseRow,
};

use core::fmt::Write as _;

use crate::plots::Figure;
use crate::svg::{PLOT_CSS, TOKENS, escape};

const PAGE_CSS: &str = include_str!("../../assets/page.css");

/// A page under way.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// `<title>` of the page.
    pub title: String,
    /// Command in its head: `characterize`.
    pub command: String,
    /// Version of the program: `0.1.0`.
    pub version: String,
    /// The heading: what was looked at.
    pub heading: String,
    /// Line below the heading.
    pub subtitle: String,
    /// The verdict in one to three plain sentences.
    pub verdict: Rich,
    /// Facts in short: name and value.
    pub facts: Vec<(String, String)>,
    /// The sections in their order.
    pub sections: Vec<Section>,
    /// Last line of the page.
    pub footer: String,
}

/// A section with its heading.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Value of `id`; unique on the page.
    pub id: String,
    /// Heading; empty: none.
    pub heading: String,
    /// Small text below the heading; empty: none.
    pub lead: String,
    /// What is in it.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading inside the section.
    Heading(String),
    /// A paragraph.
    Paragraph(Rich),
    /// A paragraph in small muted letters.
    Small(Rich),
    /// A list of sentences.
    List(Vec<Rich>),
    /// A command or a file.
    Code(String),
    /// A long hash or number without spaces.
    Hash(String),
    /// A table.
    Table(HtmlTable),
    /// Panels of equal width, three, two or one in a row.
    Panels(Vec<Figure>),
    /// Figures beside one another as there is room; each with the share of width it wants.
    Plots(Vec<(Breadth, Figure)>),
    /// One figure as wide as the page.
    Wide(Figure),
    /// Markup that a page of this crate made.
    Raw(String),
}

/// How wide a figure wants to be among [`Block::Plots`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Breadth {
    /// A panel.
    Panel,
    /// Up to two panels.
    Middle,
}

impl Section {
    /// An empty section.
    pub fn new(id: &str, heading: &str, lead: &str) -> Self {
        Self {
            id: id.to_owned(),
            heading: heading.to_owned(),
            lead: lead.to_owned(),
            blocks: Vec::new(),
        }
    }

    /// The section with one more part.
    #[must_use]
    pub fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    fn write(&self, out: &mut String) {
        let _ = write!(out, "<section id=\"{}\">", escape(&self.id));
        if !self.heading.is_empty() {
            let _ = write!(out, "<h2>{}</h2>", escape(&self.heading));
        }
        if !self.lead.is_empty() {
            let _ = write!(out, "<p class=\"lead\">{}</p>", escape(&self.lead));
        }
        for block in &self.blocks {
            block.write(out);
            out.push('\n');
        }
        out.push_str("</section>\n");
    }
}

impl Block {
    fn write(&self, out: &mut String) {
        match self {
            Self::Heading(text) => {
                let _ = write!(out, "<h3>{}</h3>", escape(text));
            }
            Self::Paragraph(rich) => {
                let _ = write!(out, "<p>{}</p>", rich.html());
            }
            Self::Small(rich) => {
                let _ = write!(out, "<p class=\"small\">{}</p>", rich.html());
            }
            Self::List(items) => {
                if !items.is_empty() {
                    out.push_str("<ul class=\"says\">");
                    for item in items {
                        let _ = write!(out, "<li>{}</li>", item.html());
                    }
                    out.push_str("</ul>");
                }
            }
            Self::Code(text) => {
                let _ = write!(out, "<pre>{}</pre>", escape(text));
            }
            Self::Hash(text) => {
                let _ = write!(out, "<p class=\"hash\">{}</p>", escape(text));
            }
            Self::Table(table) => out.push_str(&table.html()),
            Self::Panels(figures) => {
                if !figures.is_empty() {
                    out.push_str("<div class=\"panels\">");
                    for figure in figures {
                        figure_html(figure, "", out);
                    }
                    out.push_str("</div>");
                }
            }
            Self::Plots(figures) => {
                out.push_str("<div class=\"plots\">");
                for (breadth, figure) in figures {
                    let class = match breadth {
                        Breadth::Panel => "panel",
                        Breadth::Middle => "middle",
                    };
                    figure_html(figure, class, out);
                }
                out.push_str("</div>");
            }
            Self::Wide(figure) => {
                let class = if figure.narrow.is_none() { "plain" } else { "" };
                figure_html(figure, class, out);
            }
            Self::Raw(markup) => out.push_str(markup),
        }
    }
}

fn figure_html(figure: &Figure, class: &str, out: &mut String) {
    let _ = write!(out, "<figure data-plot=\"{}\"", escape(&figure.plot));
    if !figure.axis.is_empty() {
        let _ = write!(out, " data-axis=\"{}\"", escape(&figure.axis));
    }
    if !class.is_empty() {
        let _ = write!(out, " class=\"{class}\"");
    }
    out.push_str("><figcaption>");
    if !figure.caption.is_empty() {
        let _ = write!(out, "<b>{}</b>", escape(&figure.caption));
        let joined = figure.caption_rest.starts_with([':', ',', ';', '.']);
        if !figure.caption_rest.is_empty() && !joined {
            out.push(' ');
        }
    }
    out.push_str(&escape(&figure.caption_rest));
    out.push_str("</figcaption>");
    match &figure.narrow {
        Some(narrow) => {
            out.push_str(&figure.svg.inline("wide"));
            out.push_str(&narrow.inline("narrow"));
        }
        None => out.push_str(&figure.svg.inline("")),
    }
    out.push_str("</figure>");
}

impl Page {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let mut out = String::with_capacity(200_000);
        self.open(&mut out);
        for section in &self.sections {
            section.write(&mut out);
        }
        self.close(&mut out);
        out
    }

    fn open(&self, out: &mut String) {
        let _ = write!(
            out,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"sagnac {}\">\n\
             <link rel=\"icon\" href=\"data:,\">\n\
             <title>{}</title>\n<style>\n{TOKENS}{PAGE_CSS}{PLOT_CSS}</style>\n</head>\n<body>\n",
            escape(&self.version),
            escape(&self.title),
        );
        let _ = write!(
            out,
            "<header><span><b>sagnac</b> {}</span><span>version {}</span></header>\n<main>\n\
             <hr><h1>{}</h1>",
            escape(&self.command),
            escape(&self.version),
            escape(&self.heading)
        );
        if !self.subtitle.is_empty() {
            let _ = write!(out, "<p class=\"subtitle\">{}</p>", escape(&self.subtitle));
        }
        let _ = write!(out, "<p class=\"verdict\">{}</p>", self.verdict.html());
        facts_html(&self.facts, out);
        out.push('\n');
    }

    fn close(&self, out: &mut String) {
        let footer = if self.footer.is_empty() {
            format!("sagnac {}", self.version)
        } else {
            self.footer.clone()
        };
        let _ = write!(
            out,
            "</main>\n<footer>{}</footer>\n</body>\n</html>\n",
            escape(&footer)
        );
    }
}

fn facts_html(facts: &[(String, String)], out: &mut String) {
    if facts.is_empty() {
        return;
    }
    out.push_str("<dl class=\"facts\">");
    for (name, value) in facts {
        let _ = write!(
            out,
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escape(name),
            escape(value)
        );
    }
    out.push_str("</dl>");
}

/// A text with the signs of a page: `−` for a minus before a digit, `µ`, `°`, `²`.
///
/// Terminal units become those of pages: `deg/√h` is `°/√h`, `ug` is `µg`, `m/s^2` is `m/s²`.
///
/// ```
/// assert_eq!(sagnac_report::html::page_text("-3 deg/h, 27 ug, 2 m/s^2"), "−3 °/h, 27 µg, 2 m/s²");
/// ```
pub fn page_text(text: &str) -> String {
    let mut words: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let (core, tail) =
            word.split_at(word.trim_end_matches([',', '.', ';', ':', ')', '"']).len());
        let core = match core {
            "deg" => "°".to_owned(),
            "ug" => "µg".to_owned(),
            "urad" => "µrad".to_owned(),
            "us" => "µs".to_owned(),
            "degC" => "°C".to_owned(),
            c if c.starts_with("deg/") => format!("°{}", &c[3..]),
            c if c.starts_with("ug/") => format!("µ{}", &c[1..]),
            c => c.to_owned(),
        };
        let core = core.replace("^2", "²").replace("^3", "³");
        words.push(format!("{}{tail}", crate::svg::page_number(&core)));
    }
    words.join(" ")
}
