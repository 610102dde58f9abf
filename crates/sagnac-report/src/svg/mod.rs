//! Drawings as SVG: scales, axes, curves, labels that do not collide, themes.
//!
//! A plot is an [`Svg`]: inside a page it takes the page's colors ([`Svg::inline`]); alone it carries its
//! style, light and dark ([`Svg::standalone`]); as a picture it is drawn in its light form
//! ([`Svg::to_png`], feature `png`).

mod label;
mod metrics;
mod plot;
#[cfg(feature = "png")]
mod png;
mod scale;
mod theme;

pub use label::Rect;
pub use metrics::text_width;
pub(crate) use plot::{Frame, Ink, Plot, TextStyle, halo_text};
pub use scale::{Scale, decade_label, page_number};
pub use theme::{PLOT_CSS, TOKENS, light_palette};

use core::fmt::Write as _;

/// A drawing: its size, its words and its body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Svg {
    /// Width in units (pixels at scale 1).
    pub width: f64,
    /// Height in units.
    pub height: f64,
    /// What is shown: the `<title>` of the drawing.
    pub title: String,
    /// A sentence for those who cannot see it; empty: none.
    pub description: String,
    /// Elements inside `<svg>`.
    pub body: String,
}

impl Svg {
    /// Size of ordinary text in units.
    pub const FONT_SIZE: f64 = 11.5;

    fn open(&self, attributes: &str) -> String {
        let (w, h) = (number(self.width), number(self.height));
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {w} {h}\" \
             width=\"{w}\" height=\"{h}\" font-size=\"{}\"{attributes}><title>{}</title>",
            Self::FONT_SIZE,
            escape(&self.title)
        );
        if !self.description.is_empty() {
            let _ = write!(out, "<desc>{}</desc>", escape(&self.description));
        }
        out
    }

    /// The element for a page; `class` is put on it (`wide`, `narrow` or nothing).
    pub fn inline(&self, class: &str) -> String {
        let attributes = if class.is_empty() {
            String::new()
        } else {
            format!(" class=\"{}\"", escape(class))
        };
        // The namespace is implied in HTML.
        let open = self
            .open(&attributes)
            .replace(" xmlns=\"http://www.w3.org/2000/svg\"", "");
        format!("{open}{}</svg>", self.body)
    }

    /// A whole file with its style inside, light or dark as the reader prefers.
    pub fn standalone(&self) -> String {
        let mut out = self.open("");
        let _ = write!(
            out,
            "<style>{TOKENS}{PLOT_CSS}</style><rect width=\"100%\" height=\"100%\" fill=\"var(--page)\"/>{}</svg>",
            self.body
        );
        out.push('\n');
        out
    }

    /// A whole file in the light colors, without custom properties.
    pub fn light(&self) -> String {
        let mut out = self.open("");
        let _ = write!(
            out,
            "<style>{PLOT_CSS}</style><rect width=\"{}\" height=\"{}\" fill=\"var(--page)\"/>{}</svg>",
            number(self.width),
            number(self.height),
            self.body
        );
        out.push('\n');
        theme::resolve_light(&out)
    }

    /// Several drawings side by side in rows, below a heading, as one drawing.
    ///
    /// Rows are as high as their highest drawing; `heading` is empty where there is none.
    pub fn sheet(heading: &str, rows: &[Vec<Self>]) -> Self {
        const GAP: f64 = 26.0;
        const MARGIN: f64 = 12.0;
        let mut body = String::new();
        let mut top = MARGIN;
        let mut width = 0.0_f64;
        if !heading.is_empty() {
            let _ = write!(
                body,
                "<text class=\"hd\" x=\"{MARGIN}\" y=\"{}\">{}</text>",
                number(top + 15.0),
                escape(heading)
            );
            width = text_width(heading, 16.0, true) + 2.0 * MARGIN;
            top += 30.0;
        }
        for row in rows {
            let mut left = MARGIN;
            let mut height = 0.0_f64;
            for drawing in row {
                let _ = write!(
                    body,
                    "<g transform=\"translate({},{})\">{}</g>",
                    number(left),
                    number(top),
                    drawing.body
                );
                left += drawing.width + GAP;
                height = height.max(drawing.height);
            }
            width = width.max(left - GAP + MARGIN);
            top += height + GAP;
        }
        Self {
            width: width.ceil(),
            height: (top - GAP + MARGIN).ceil(),
            title: heading.to_owned(),
            description: String::new(),
            body,
        }
    }

    /// The drawing with a caption above it, for sheets.
    #[must_use]
    pub fn captioned(&self, bold: &str, rest: &str) -> Self {
        let at = text_width(bold, 12.5, true) + 5.0;
        let mut body = format!(
            "<text class=\"cap\" x=\"0\" y=\"13\">{}</text>",
            escape(bold)
        );
        if !rest.is_empty() {
            let _ = write!(
                body,
                "<text class=\"u\" x=\"{}\" y=\"13\">{}</text>",
                number(at),
                escape(rest)
            );
        }
        let _ = write!(body, "<g transform=\"translate(0,20)\">{}</g>", self.body);
        Self {
            width: self.width,
            height: self.height + 20.0,
            title: self.title.clone(),
            description: self.description.clone(),
            body,
        }
    }
}

/// Text as content or attribute value of markup.
///
/// Characters that XML does not allow become `?`.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(' '),
            c if c.is_control()
                || matches!(c as u32, 0x202a..=0x202e | 0x2066..=0x2069 | 0xfffe | 0xffff) =>
            {
                out.push('?');
            }
            c => out.push(c),
        }
    }
    out
}

/// A coordinate with at most two decimals.
pub(crate) fn number(x: f64) -> String {
    if !x.is_finite() {
        return "0".to_owned();
    }
    let mut text = format!("{x:.2}");
    if text.contains('.') {
        let keep = text.trim_end_matches('0').trim_end_matches('.').len();
        text.truncate(keep);
    }
    if text == "-0" { "0".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(10.126), "10.13");
        assert_eq!(number(100.0), "100");
    }

    #[test]
    fn markup_stays_text() {
        assert_eq!(
            escape("<script>&\"'\u{7}</script>"),
            "&lt;script&gt;&amp;&quot;&#39;?&lt;/script&gt;"
        );
    }

    #[test]
    fn a_light_drawing_has_no_custom_properties() {
        let svg = Svg {
            width: 10.0,
            height: 10.0,
            body: "<path style=\"color:var(--x)\"/>".to_owned(),
            ..Svg::default()
        };
        assert!(!svg.light().contains("var("));
        assert!(svg.standalone().contains("prefers-color-scheme: dark"));
    }
}
