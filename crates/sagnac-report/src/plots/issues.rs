//! The findings on the time axis, each with its sentence.

use core::fmt::Write as _;

use super::{Figure, PANEL_WIDTH, WIDE_WIDTH, time_unit};
use crate::svg::{Frame, Plot, Scale, Svg, TextStyle, halo_text, number, text_width};
use crate::text::cut;

/// A finding.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IssueBar {
    /// Channel or sensor: `accel`, `gyro z`.
    pub channel: String,
    /// Kind; findings of one kind and channel share a row.
    pub kind: String,
    /// Its sentence.
    pub text: String,
    /// Start and end in s; `None`: all the time.
    pub span_s: Option<(f64, f64)>,
    /// Warning (orange) or note (blue).
    pub warning: bool,
}

/// The findings of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IssueTimeline {
    /// Length of the log in s.
    pub duration_s: f64,
    /// The findings in the order in which they are shown.
    pub issues: Vec<IssueBar>,
}

const FONT: f64 = 11.9;

struct Row<'a> {
    first: &'a IssueBar,
    spans: Vec<(f64, f64)>,
    text: String,
    /// Findings of the row that say something else.
    others: usize,
}

impl IssueTimeline {
    /// The figure with its wide and narrow drawings.
    pub fn figure(&self) -> Figure {
        self.figure_and_cuts().0
    }

    /// The figure, and the sentences that its wide and its narrow drawing had to cut, in full.
    pub fn figure_and_cuts(&self) -> (Figure, Vec<String>, Vec<String>) {
        let (wide, wide_cuts) = self.draw(WIDE_WIDTH, false);
        let (narrow, narrow_cuts) = self.draw(PANEL_WIDTH, true);
        let figure = Figure::new(
            "issues",
            "",
            "",
            "Findings on the time axis. Orange: warning. Blue: note.",
            wide,
        )
        .with_narrow(narrow);
        (figure, wide_cuts, narrow_cuts)
    }

    fn rows(&self) -> Vec<Row<'_>> {
        let mut rows: Vec<Row<'_>> = Vec::new();
        for issue in &self.issues {
            let span = issue.span_s.unwrap_or((0.0, self.duration_s));
            let known = rows.iter_mut().find(|r| {
                r.first.kind == issue.kind
                    && r.first.channel == issue.channel
                    && !issue.kind.is_empty()
            });
            match known {
                Some(row) => {
                    row.spans.push(span);
                    row.others += usize::from(issue.text != row.text);
                }
                None => rows.push(Row {
                    first: issue,
                    spans: vec![span],
                    text: issue.text.clone(),
                    others: 0,
                }),
            }
        }
        for row in &mut rows {
            if row.others > 0 {
                row.text = format!("{} (and {} more)", row.text, row.others);
            }
        }
        rows
    }

    fn draw(&self, width: f64, narrow: bool) -> (Svg, Vec<String>) {
        let mut cuts = Vec::new();
        let rows = self.rows();
        let lines: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                if narrow {
                    let text = format!("{}: {}", row.first.channel, row.text);
                    lines_of(&text, width - 28.0)
                } else {
                    vec![row.text.clone()]
                }
            })
            .collect();
        let step = |i: usize| -> f64 {
            if narrow {
                20.0 + 14.5 * lines[i].len() as f64
            } else {
                25.0
            }
        };
        let total: f64 = (0..rows.len()).map(step).sum();
        let names = rows
            .iter()
            .map(|r| text_width(&cut(&r.first.channel, 18), FONT, false))
            .fold(30.0, f64::max);
        let frame = Frame {
            width,
            height: 6.0 + total + 42.0,
            left: if narrow { 12.0 } else { names + 14.0 },
            right: if narrow { 12.0 } else { 10.0 },
            top: 4.0,
            bottom: 40.0,
        };
        let (title, unit_s) = time_unit(self.duration_s);
        let x = Scale::linear(0.0, (self.duration_s / unit_s).max(1e-9));
        let id = if narrow { "issues-narrow" } else { "issues" };
        let mut plot = Plot::new(frame, x, Scale::linear(0.0, 1.0), id).with_font(FONT);
        plot.x_axis(title);
        let area = frame.area();
        let mut next = area.y;
        for (i, row) in rows.iter().enumerate() {
            let top = next;
            next += step(i);
            // Bars of narrow drawings stand below their lines of text.
            let below = 14.5 * (lines[i].len() as f64 - 1.0);
            let color = if row.first.warning { "--fit" } else { "--data" };
            if !narrow {
                plot.fixed_text(
                    (area.x - 8.0, top + 15.5),
                    "end",
                    "t",
                    &cut(&row.first.channel, 18),
                    "",
                );
            }
            let edges: Vec<(f64, f64)> = row
                .spans
                .iter()
                .map(|&(a, b)| {
                    let a = plot.x.at(a / unit_s).clamp(area.x, area.x + area.w);
                    let b = plot.x.at(b / unit_s).clamp(area.x, area.x + area.w);
                    let w = (b - a).max(3.5);
                    (a.min(area.x + area.w - w), w)
                })
                .collect();
            let long = edges.iter().any(|e| e.1 > 0.5 * area.w);
            let (bar_top, bar_height) = match (narrow, long) {
                (true, true) => (top + 21.0 + below, 3.0),
                (true, false) => (top + 19.0 + below, 8.0),
                (false, true) => (top + 20.0, 3.0),
                (false, false) => (top + 6.5, 9.5),
            };
            let mut bars = String::new();
            for &(a, w) in edges.iter().take(400) {
                let _ = write!(
                    bars,
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:var({color})\"/>",
                    number(a),
                    number(bar_top),
                    number(w),
                    number(bar_height)
                );
            }
            plot.raw(&bars);
            let style = TextStyle {
                size: FONT,
                ..TextStyle::default()
            };
            let (at, anchor, room) = place_text(area.x, area.w, &edges, narrow || long);
            for (k, line) in lines[i].iter().enumerate() {
                let shown = fit(line, room);
                if shown != *line {
                    cuts.push(format!("{}: {}", row.first.channel, row.text));
                }
                let y = if narrow {
                    top + 14.0 + 14.5 * k as f64
                } else {
                    top + 15.5
                };
                plot.raw(&halo_text((at, y), anchor, &shown, style));
            }
        }
        let svg = plot.finish(
            "Findings during the recording, on the time axis",
            "Each row is a finding with its sentence.",
        );
        (svg, cuts)
    }
}

/// Where the sentence of a row begins, and how wide it may be.
fn place_text(
    left: f64,
    width: f64,
    edges: &[(f64, f64)],
    above: bool,
) -> (f64, &'static str, f64) {
    if above {
        return (left + 2.0, "start", width - 4.0);
    }
    let mut bars: Vec<(f64, f64)> = edges.iter().map(|e| (e.0, e.0 + e.1)).collect();
    bars.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(first, _)) = bars.first() else {
        return (left + 2.0, "start", width - 4.0);
    };
    // The widest gap; after a bar rather than before the first.
    let mut best = (first - 7.0, "end", first - left - 7.0);
    let mut last = f64::NEG_INFINITY;
    for (i, bar) in bars.iter().enumerate() {
        last = last.max(bar.1);
        let end = bars.get(i + 1).map_or(left + width, |next| next.0 - 4.0);
        let room = end - last - 7.0;
        if room >= best.2 {
            best = (last + 7.0, "start", room);
        }
    }
    best
}

/// A sentence in at most three lines of this width; the last takes the rest.
fn lines_of(text: &str, room: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let full = lines.len() >= 3;
        let Some(line) = lines.last_mut() else { break };
        let longer = if line.is_empty() {
            word.to_owned()
        } else {
            format!("{line} {word}")
        };
        if full || line.is_empty() || text_width(&longer, FONT, true) <= room {
            *line = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

fn fit(text: &str, room: f64) -> String {
    let mut columns = text.chars().count();
    let mut shown = text.to_owned();
    while columns > 3 && text_width(&shown, FONT, true) > room {
        columns -= 1;
        shown = cut(text, columns);
    }
    shown
}

impl IssueTimeline {
    /// Whether there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.issues.is_empty()
    }
}
