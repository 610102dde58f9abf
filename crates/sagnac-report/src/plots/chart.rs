//! A chart of several curves, each named at its end: `allan`, `plan`, comparisons.

use super::Color;
use crate::svg::{Frame, Ink, Plot, Scale, Svg, TextStyle, halo_text, text_width};

/// A curve of a chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartCurve {
    /// Its name, at its end; empty: none.
    pub label: String,
    /// Its color.
    pub color: Color,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Lower end of its band; empty: none.
    pub lower: Vec<f64>,
    /// Upper end of its band; empty: none.
    pub upper: Vec<f64>,
    /// Drawn dashed: a limit, a reference.
    pub dashed: bool,
    /// Value of `data-series`; empty: `measured`.
    pub series: String,
}

/// Several curves on one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveChart {
    /// Name that makes the drawing unique on a page.
    pub id: String,
    /// What is shown, for those who cannot see it.
    pub title: String,
    /// Quantity and unit of the abscissa.
    pub x_title: String,
    /// Quantity and unit of the ordinate.
    pub y_title: String,
    /// Logarithmic abscissa.
    pub x_log: bool,
    /// Logarithmic ordinate.
    pub y_log: bool,
    /// Linear scales begin at zero.
    pub from_zero: bool,
    /// The curves.
    pub curves: Vec<ChartCurve>,
    /// Width in units.
    pub width: f64,
    /// Height in units.
    pub height: f64,
}

impl Default for CurveChart {
    fn default() -> Self {
        Self {
            id: "chart".to_owned(),
            title: String::new(),
            x_title: String::new(),
            y_title: String::new(),
            x_log: true,
            y_log: true,
            from_zero: false,
            curves: Vec::new(),
            width: 500.0,
            height: 380.0,
        }
    }
}

impl CurveChart {
    /// A chart of Allan deviations of one sensor: `gyro: Allan deviation, °/h` against averaging time.
    pub fn allan(id: &str, y_title: &str, curves: Vec<ChartCurve>) -> Self {
        Self {
            id: id.to_owned(),
            title: y_title.to_owned(),
            x_title: "averaging time τ, s".to_owned(),
            y_title: y_title.to_owned(),
            curves,
            ..Self::default()
        }
    }

    /// The drawing.
    pub fn draw(&self) -> Svg {
        let all_x = self.curves.iter().flat_map(|c| c.x.iter().copied());
        let all_y = self
            .curves
            .iter()
            .flat_map(|c| c.y.iter().chain(&c.lower).chain(&c.upper).copied());
        let mut x = Scale::around(all_x, self.x_log, 0.02);
        let mut y = Scale::around(all_y, self.y_log, 0.06);
        if self.y_log {
            y = y.at_least_decades(1.0);
        } else if self.from_zero {
            y = Scale::linear(0.0, y.high().max(0.0));
        }
        if !self.x_log && self.from_zero {
            let end = self.curves.iter().flat_map(|c| c.x.iter().copied());
            x = Scale::linear(0.0, end.filter(|v| v.is_finite()).fold(0.0, f64::max));
        }
        let mut frame = Frame::panel(self.width, self.height);
        frame.left = Plot::left_room(y, frame.area().h, 11.5).max(34.0);
        frame.right = self
            .curves
            .iter()
            .map(|c| text_width(&c.label, 11.5, true))
            .fold(4.0, f64::max)
            .min(0.3 * self.width)
            + 12.0;
        let mut plot = Plot::new(frame, x, y, &self.id);
        plot.axes(&self.x_title, &self.y_title);
        for curve in &self.curves {
            let color = curve.color.property();
            plot.band(
                &curve.x,
                &curve.lower,
                &curve.upper,
                Ink::class("bc").color(color).series("band"),
            );
        }
        for curve in &self.curves {
            let series = if curve.series.is_empty() {
                "measured"
            } else {
                &curve.series
            };
            let ink = Ink::class("c").color(curve.color.property()).series(series);
            let ink = if curve.dashed {
                ink.extra("stroke-dasharray=\"5 3.5\"")
            } else {
                ink
            };
            plot.curve(&curve.x, &curve.y, ink);
        }
        self.name_ends(&mut plot);
        plot.finish(&self.title, "")
    }

    /// Names each curve at its end; names that would touch are moved apart up and down.
    fn name_ends(&self, plot: &mut Plot) {
        const STEP: f64 = 15.0;
        let mut ends: Vec<(f64, f64, &ChartCurve)> =
            self.curves
                .iter()
                .filter(|curve| !curve.label.is_empty())
                .filter_map(|curve| {
                    let last = curve.x.iter().zip(&curve.y).rfind(|(x, y)| {
                        x.is_finite() && y.is_finite() && (!self.y_log || **y > 0.0)
                    })?;
                    let (x, y) = plot.at((*last.0, *last.1));
                    Some((x, y, curve))
                })
                .collect();
        ends.sort_by(|a, b| a.1.total_cmp(&b.1));
        let area = plot.frame.area();
        let mut rows: Vec<f64> = ends.iter().map(|e| e.1).collect();
        for _ in 0..60 {
            for i in 1..rows.len() {
                let overlap = STEP - (rows[i] - rows[i - 1]);
                if overlap > 0.0 {
                    rows[i - 1] -= 0.5 * overlap;
                    rows[i] += 0.5 * overlap;
                }
            }
            for row in &mut rows {
                *row = row.clamp(area.y + 4.0, area.y + area.h - 4.0);
            }
        }
        for ((x, _, curve), y) in ends.iter().zip(rows) {
            let style = TextStyle {
                color: curve.color.property(),
                ..TextStyle::default()
            };
            plot.raw(&halo_text((x + 7.0, y + 4.0), "start", &curve.label, style));
        }
    }
}
