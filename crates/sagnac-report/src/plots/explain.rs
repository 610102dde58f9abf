//! What each term adds to an axis: a signed bar a term, largest first, and the sum.

use core::fmt::Write as _;

use super::{Figure, PANEL_WIDTH};
use crate::svg::{Frame, Plot, Scale, Svg, TextStyle, halo_text, number, page_number, text_width};
use crate::text::{cut, general};

/// The terms of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExplainPanel {
    /// Channel: `gyro_x`.
    pub axis: String,
    /// Caption after the name: `input 10, output 10.01000 °/s`.
    pub note: String,
    /// Unit of the contributions: `°/h`.
    pub unit: String,
    /// Terms with what they add, in the order in which they are shown; zeros are left out by the caller.
    pub terms: Vec<(String, f64)>,
    /// Their sum: output less input.
    pub sum: f64,
}

const ROW: f64 = 20.0;
const BAR: f64 = 11.0;

/// The panels of one sensor on one scale and of one height.
pub fn explain_panels(panels: &[ExplainPanel]) -> Vec<Figure> {
    let values = || {
        panels
            .iter()
            .flat_map(|p| p.terms.iter().map(|t| t.1).chain([p.sum]))
            .filter(|v| v.is_finite())
    };
    let names = panels
        .iter()
        .flat_map(|p| &p.terms)
        .map(|t| text_width(&shown(&t.0), Svg::FONT_SIZE, false))
        .fold(40.0, f64::max)
        + 8.0;
    let width_of = |negative: bool| {
        values()
            .filter(|v| (*v < 0.0) == negative)
            .map(|v| text_width(&signed(v), Svg::FONT_SIZE, true) + 9.0)
            .fold(6.0, f64::max)
    };
    let low = values().fold(0.0, f64::min);
    let high = values().fold(0.0, f64::max);
    let room = PANEL_WIDTH - names - 8.0;
    // Bars and the figures at their ends share the room.
    let bars = (room - width_of(true) - width_of(false)).max(40.0);
    let unit = (high - low).max(1e-300) / bars;
    let scale = if high > low {
        Scale::linear(low - unit * width_of(true), high + unit * width_of(false))
    } else {
        Scale::linear(-1.0, 1.0)
    };
    let rows = panels.iter().map(|p| p.terms.len()).max().unwrap_or(0);
    panels
        .iter()
        .map(|panel| {
            let svg = draw(panel, scale, names, rows);
            Figure::new(
                "explain",
                &panel.axis,
                &super::axis_title(&panel.axis),
                &panel.note,
                svg,
            )
        })
        .collect()
}

fn shown(name: &str) -> String {
    cut(name, 25)
}

fn signed(value: f64) -> String {
    let text = page_number(&general(value, 3));
    if value > 0.0 {
        format!("+{text}")
    } else {
        text
    }
}

fn draw(panel: &ExplainPanel, x: Scale, names: f64, rows: usize) -> Svg {
    let height = 8.0 + ROW * (rows as f64 + 1.4) + 42.0;
    let frame = Frame {
        width: PANEL_WIDTH,
        height,
        left: names,
        right: 8.0,
        top: 4.0,
        bottom: 38.0,
    };
    let mut plot = Plot::new(
        frame,
        x,
        Scale::linear(0.0, 1.0),
        &format!("explain-{}", panel.axis),
    );
    plot.x_axis_with(&format!("added to the output, {}", panel.unit), 5);
    let zero = plot.x.at(0.0);
    let area = frame.area();
    plot.raw(&format!(
        "<path class=\"a\" style=\"stroke:var(--ink)\" d=\"M{} {}V{}\"/>",
        number(zero),
        number(area.y),
        number(area.y + area.h)
    ));
    for (i, (name, value)) in panel.terms.iter().enumerate() {
        row(
            &mut plot,
            &shown(name),
            *value,
            area.y + ROW * i as f64,
            false,
        );
    }
    let top = area.y + ROW * (panel.terms.len() as f64 + 0.25);
    row(&mut plot, "sum", panel.sum, top, true);
    plot.finish(
        &format!("What each term adds to {}", super::axis_title(&panel.axis)),
        "A bar a term, largest first, and their sum.",
    )
}

fn row(plot: &mut Plot, name: &str, value: f64, top: f64, sum: bool) {
    let zero = plot.x.at(0.0);
    let end = plot.x.at(value);
    let color = match (sum, value >= 0.0) {
        (true, _) => "--ink",
        (false, true) => "--data",
        (false, false) => "--fit",
    };
    let mut bar = String::new();
    let _ = write!(
        bar,
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{BAR}\" style=\"fill:var({color})\"/>",
        number(zero.min(end)),
        number(top + 4.5),
        number((end - zero).abs().max(0.8)),
    );
    plot.raw(&bar);
    let base = top + 14.0;
    let class = if sum { "l" } else { "v" };
    let left = plot.frame.left;
    plot.raw(&halo_text(
        (left - 8.0, base),
        "end",
        name,
        TextStyle {
            class,
            bold: sum,
            ..TextStyle::default()
        },
    ));
    let (at, anchor) = if value < 0.0 {
        (end.min(zero) - 5.0, "end")
    } else {
        (end.max(zero) + 5.0, "start")
    };
    plot.raw(&halo_text(
        (at, base),
        anchor,
        &signed(value),
        TextStyle::default(),
    ));
}
