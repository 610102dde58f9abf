//! The response of a sensor on a bench: residuals, hysteresis, output against input, the target.

use core::fmt::Write as _;

use super::{Figure, PANEL_WIDTH};
use crate::svg::{Frame, Ink, Plot, Scale, Svg, TextStyle, number};

/// What the plots of `response` show.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResponsePlots {
    /// Quantity and unit of the reference: `reference rate, °/s`.
    pub reference_title: String,
    /// Quantity and unit of the output: `output, °/s`.
    pub output_title: String,
    /// Unit of residuals: `mdps`.
    pub residual_unit: String,
    /// Readings going up: reference and residual from the best line.
    pub up: Vec<(f64, f64)>,
    /// Readings going down.
    pub down: Vec<(f64, f64)>,
    /// Readings whose direction is not known.
    pub still: Vec<(f64, f64)>,
    /// Means at each reference going up.
    pub up_mean: Vec<(f64, f64)>,
    /// Means at each reference going down.
    pub down_mean: Vec<(f64, f64)>,
    /// Means of readings without direction.
    pub still_mean: Vec<(f64, f64)>,
    /// Largest departure of a point from the least-squares line.
    pub least_squares: Option<f64>,
    /// Minimax band: lower and upper line, each by its two ends.
    pub minimax: Option<[[(f64, f64); 2]; 2]>,
    /// Means of the output at each reference.
    pub points: Vec<(f64, f64)>,
    /// The line through them by its two ends.
    pub line: Option<[(f64, f64); 2]>,
    /// Label of the line: `slope 1.00071`.
    pub line_label: String,
    /// Down less up at each reference.
    pub hysteresis: Vec<(f64, f64)>,
    /// Label of its largest: `23.9 at −20 °/s`.
    pub hysteresis_label: String,
    /// The target: error going up, error going down, one dot a repeat.
    pub target: Vec<(f64, f64)>,
    /// Names of the target's axes without unit: `error going up`, `error going down`.
    pub target_titles: (String, String),
}

fn split(points: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    points.iter().copied().unzip()
}

impl ResponsePlots {
    /// Residuals from the best line.
    pub fn residuals(&self) -> Figure {
        Figure::new(
            "response-residuals",
            "",
            "Residuals",
            "from the best line; triangles: readings, lines: means",
            self.draw_residuals(520.0, "response-residuals"),
        )
        .with_narrow(self.draw_residuals(PANEL_WIDTH, "response-residuals-narrow"))
    }

    fn draw_residuals(&self, width: f64, id: &str) -> Svg {
        let readings = || self.up.iter().chain(&self.down).chain(&self.still);
        let ends = self.minimax.iter().flatten().flatten();
        let x = Scale::around(readings().map(|p| p.0), false, 0.04);
        let own = self.least_squares.into_iter().flat_map(|l| [l, -l]);
        let y = Scale::around(
            readings().chain(ends).map(|p| p.1).chain([0.0]).chain(own),
            false,
            0.06,
        );
        let mut frame = Frame::panel(width, 318.0);
        frame.left = Plot::left_room(y, frame.area().h, Svg::FONT_SIZE);
        let mut plot = Plot::new(frame, x, y, id);
        plot.axes(
            &self.reference_title,
            &format!(
                "residual from the least-squares line, {}",
                self.residual_unit
            ),
        );
        zero_line(&mut plot);
        for line in self.minimax.iter().flatten() {
            plot.line(line[0], line[1], Ink::class("q").term("minimax"));
        }
        let span = readings().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(p.0), high.max(p.0))
        });
        for level in self.least_squares.into_iter().flat_map(|l| [l, -l]) {
            plot.line(
                (span.0, level),
                (span.1, level),
                Ink::class("d").term("least-squares"),
            );
        }
        let mut marks = String::new();
        for (points, color, flip) in [
            (&self.up, "--data", 1.0),
            (&self.down, "--fit", -1.0),
            (&self.still, "--w", 1.0),
        ] {
            let mut path = String::new();
            for p in points {
                let (px, py) = plot.at(*p);
                let _ = write!(
                    path,
                    "M{} {}l2.4 {}h-4.8z",
                    number(px),
                    number(py - flip * 2.4),
                    number(flip * 4.4)
                );
            }
            if !path.is_empty() {
                let _ = write!(
                    marks,
                    "<path d=\"{path}\" style=\"fill:var({color});fill-opacity:.62\"/>"
                );
            }
        }
        plot.raw(&marks);
        for (mean, color, label, series, direction) in [
            (&self.down_mean, "--fit", "down", "down", 90.0),
            (&self.up_mean, "--data", "up", "up", 270.0),
            (&self.still_mean, "--w", "", "measured", 90.0),
        ] {
            let (mx, my) = split(mean);
            plot.curve(&mx, &my, Ink::class("c").color(color).series(series));
            if let Some(middle) = mean.get(mean.len() / 2).filter(|_| !label.is_empty()) {
                let style = TextStyle {
                    color,
                    ..TextStyle::default()
                };
                let at = plot.at(*middle);
                plot.label(label, at, Some(direction), 6.0, 60.0, style);
            }
        }
        // The loop is closed where the direction changes.
        for pick in [<[(f64, f64)]>::first, <[(f64, f64)]>::last] {
            if let (Some(up), Some(down)) = (pick(&self.up_mean), pick(&self.down_mean))
                && up.0 == down.0
                && up.1 != down.1
            {
                plot.line(*up, *down, Ink::class("c").color("--muted"));
            }
        }
        if let Some(level) = self.least_squares {
            let at = plot.at((0.85 * span.0 + 0.15 * span.1, -level));
            let style = TextStyle {
                class: "u h",
                bold: false,
                ..TextStyle::default()
            };
            plot.label("least-squares band", at, Some(270.0), 5.0, 70.0, style);
        }
        if let Some([_, upper]) = self.minimax {
            let at = (
                0.4 * upper[0].0 + 0.6 * upper[1].0,
                0.4 * upper[0].1 + 0.6 * upper[1].1,
            );
            let at = plot.at(at);
            let style = TextStyle {
                class: "u h",
                bold: false,
                ..TextStyle::default()
            };
            plot.label("minimax band", at, Some(90.0), 5.0, 70.0, style);
        }
        plot.finish("Residuals from the best line, going up and down", "")
    }

    /// Output against input.
    pub fn line(&self) -> Figure {
        let x = Scale::around(self.points.iter().map(|p| p.0), false, 0.04);
        let y = Scale::around(self.points.iter().map(|p| p.1), false, 0.04);
        let mut frame = Frame::panel(PANEL_WIDTH, 236.0);
        frame.left = Plot::left_room(y, frame.area().h, Svg::FONT_SIZE);
        let mut plot = Plot::new(frame, x, y, "response-line");
        plot.axes(&self.reference_title, &self.output_title);
        if let Some([a, b]) = self.line {
            plot.line(a, b, Ink::class("f").series("fit"));
        }
        for p in self.points.iter().take(1000) {
            plot.circle(*p, 2.6, Ink::class("p").color("--data").series("measured"));
        }
        if let Some([a, b]) = self.line {
            let at = plot.at((0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1)));
            let style = TextStyle {
                color: "--fit",
                ..TextStyle::default()
            };
            plot.label(&self.line_label, at, Some(330.0), 8.0, 80.0, style);
        }
        let svg = plot.finish("Output against input", "");
        Figure::new("response-line", "", "Output against input", "", svg)
    }

    /// Down less up.
    pub fn hysteresis(&self) -> Figure {
        let x = Scale::around(self.hysteresis.iter().map(|p| p.0), false, 0.04);
        let y = Scale::around(
            self.hysteresis.iter().map(|p| p.1).chain([0.0]),
            false,
            0.08,
        );
        let mut frame = Frame::panel(PANEL_WIDTH, 236.0);
        frame.left = Plot::left_room(y, frame.area().h, Svg::FONT_SIZE);
        let mut plot = Plot::new(frame, x, y, "response-hysteresis");
        plot.axes(
            &self.reference_title,
            &format!("down less up, {}", self.residual_unit),
        );
        zero_line(&mut plot);
        let (hx, hy) = split(&self.hysteresis);
        let zero = vec![0.0; hx.len()];
        plot.band(&hx, &zero, &hy, Ink::class("e"));
        plot.curve(&hx, &hy, Ink::class("f").series("measured"));
        let largest = self
            .hysteresis
            .iter()
            .filter(|p| p.1.is_finite())
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        if let Some(p) = largest {
            let at = plot.at(*p);
            let direction = if p.1 >= 0.0 { 90.0 } else { 270.0 };
            plot.label(
                &self.hysteresis_label,
                at,
                Some(direction),
                5.0,
                80.0,
                TextStyle::default(),
            );
        }
        let svg = plot.finish("Hysteresis: output going down less output going up", "");
        Figure::new(
            "response-hysteresis",
            "",
            "Hysteresis",
            ": down less up",
            svg,
        )
    }

    /// The accuracy and precision target.
    pub fn target(&self) -> Figure {
        const SIDE: f64 = 292.0;
        let reach = self
            .target
            .iter()
            .flat_map(|p| [p.0.abs(), p.1.abs()])
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max)
            .max(1e-12)
            * 1.2;
        let scale = Scale::linear(-reach, reach);
        let mut frame = Frame::panel(PANEL_WIDTH, SIDE + 62.0);
        frame.left = PANEL_WIDTH - SIDE - frame.right;
        let mut plot = Plot::new(frame, scale, scale, "response-target");
        plot.axes(
            &format!("{}, {}", self.target_titles.0, self.residual_unit),
            &format!("{}, {}", self.target_titles.1, self.residual_unit),
        );
        let center = plot.at((0.0, 0.0));
        for (value, _) in plot.x.ticks(7) {
            if value > 0.0 {
                plot.raw(&format!(
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" style=\"fill:none;stroke:var(--muted);stroke-width:.8\"/>",
                    number(center.0),
                    number(center.1),
                    number(plot.x.at(value) - center.0)
                ));
            }
        }
        let count = self.target.len().max(1) as f64;
        let middle = (
            self.target.iter().map(|p| p.0).sum::<f64>() / count,
            self.target.iter().map(|p| p.1).sum::<f64>() / count,
        );
        plot.line((0.0, 0.0), middle, Ink::class("f").series("fit"));
        for p in self.target.iter().take(2000) {
            plot.circle(*p, 2.8, Ink::class("p").color("--data").series("measured"));
        }
        plot.raw(&format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"2.6\" style=\"fill:var(--ink)\"/>",
            number(center.0),
            number(center.1)
        ));
        let half = plot.at((0.5 * middle.0, 0.5 * middle.1));
        let end = plot.at(middle);
        for (text, at, color, direction) in [
            ("accuracy", half, "--fit", 0.0),
            ("precision", end, "--data", 180.0),
        ] {
            let style = TextStyle {
                color,
                ..TextStyle::default()
            };
            plot.label(text, at, Some(direction), 10.0, 110.0, style);
        }
        let svg = plot.finish("Accuracy and precision as a target", "");
        Figure::new(
            "response-target",
            "",
            "Accuracy and precision",
            ": how far the middle of the cloud is off, and how wide it is",
            svg,
        )
    }
}

fn zero_line(plot: &mut Plot) {
    if plot.y.holds(0.0) {
        let area = plot.frame.area();
        let y = plot.y.at(0.0);
        plot.raw_under(&format!(
            "<path class=\"a\" d=\"M{} {}H{}\"/>",
            number(area.x),
            number(y),
            number(area.x + area.w)
        ));
    }
}
