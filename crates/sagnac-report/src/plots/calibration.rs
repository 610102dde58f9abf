//! Plots of a calibration: residuals of stations, before and after, poses, correlations.

use core::fmt::Write as _;

use super::{Color, Figure, PANEL_WIDTH, WIDE_WIDTH};
use crate::svg::{
    Frame, Plot, Scale, Svg, TextStyle, escape, halo_text, number, page_number, text_width,
};
use crate::text::{cut, fixed};

/// Residuals of every station (or pose) and axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationResiduals {
    /// Value of `data-axis`: `gyro` or `accel`.
    pub sensor: String,
    /// Unit: `µg`.
    pub unit: String,
    /// Word below the axis: `station` or `pose`.
    pub word: String,
    /// Label of each station.
    pub labels: Vec<String>,
    /// Residuals of x, y, z; not a number where there is none.
    pub axes: [Vec<f64>; 3],
    /// Half width of the band: two standard uncertainties; 0: none.
    pub band: f64,
    /// Standard uncertainty of each residual, where they differ: a bar of two each way stands at each instead of
    /// the band; empty: none.
    pub sigmas: [Vec<f64>; 3],
    /// What is drawn, where it is not the output less the fitted model: `|f| − g`; empty: that.
    pub quantity: String,
}

/// The edges of a band nearer than this have one label for both.
const EDGES_APART: f64 = 15.0;

impl StationResiduals {
    /// The figure.
    pub fn figure(&self) -> Figure {
        let drawn = self.axes.iter().filter(|a| a.iter().any(|v| v.is_finite()));
        let (each, what) = if self.quantity.is_empty() {
            (
                " and axis",
                ", less the fitted model: ● x, ■ y, ▲ z".to_owned(),
            )
        } else if drawn.count() > 1 {
            ("", format!(", {}", self.quantity))
        } else {
            ("", format!(": {}", self.quantity))
        };
        let uncertainty = if self.has_bars() {
            "; bar: ± 2 standard uncertainties of each"
        } else if self.widths() > 0.0 {
            "; band: ± 2 standard uncertainties"
        } else {
            ""
        };
        let sensor = match self.sensor.as_str() {
            "gyro" => "Gyro",
            "accel" => "Accelerometer",
            other => other,
        };
        Figure::new(
            "calibration-residuals",
            &self.sensor,
            &format!("{sensor}, each {}{each}", self.word),
            &format!("{what}{uncertainty}"),
            self.draw(WIDE_WIDTH, "residuals"),
        )
        .with_narrow(self.draw(PANEL_WIDTH, "residuals-narrow"))
    }

    /// The finite standard uncertainties of single residuals.
    fn own(&self) -> impl Iterator<Item = f64> + '_ {
        self.sigmas
            .iter()
            .flatten()
            .copied()
            .filter(|s| s.is_finite() && *s > 0.0)
    }

    /// Whether the residuals have uncertainties that differ.
    fn has_bars(&self) -> bool {
        let (low, high) = self
            .own()
            .fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(s), h.max(s)));
        high > 1.02 * low
    }

    /// Half width of the one band; 0 where there is none.
    fn widths(&self) -> f64 {
        if self.has_bars() {
            0.0
        } else {
            self.own().next().map_or(self.band, |s| 2.0 * s)
        }
    }

    /// Bars of two standard uncertainties each way about zero.
    fn bars(&self, plot: &Plot, apart: f64) -> String {
        let mut path = String::new();
        for (axis, sigmas) in self.sigmas.iter().enumerate() {
            for (i, s) in sigmas.iter().enumerate().filter(|(_, s)| s.is_finite()) {
                let (x, top) = plot.at(((i + 1) as f64, 2.0 * s));
                let x = x + (axis as f64 - 1.0) * apart;
                let _ = write!(
                    path,
                    "M{} {}V{}",
                    number(x),
                    number(top),
                    number(plot.y.at(-2.0 * s))
                );
            }
        }
        path
    }

    fn draw(&self, width: f64, id: &str) -> Svg {
        let font = if width > 400.0 { 11.9 } else { Svg::FONT_SIZE };
        let count = self.labels.len().max(1);
        let reach = self
            .axes
            .iter()
            .flatten()
            .map(|v| v.abs())
            .filter(|v| v.is_finite())
            .chain(self.own().map(|s| 2.0 * s))
            .fold(1.4 * self.widths(), f64::max)
            .max(1e-300)
            * 1.12;
        let y = Scale::linear(-reach, reach);
        let mut frame = Frame::panel(width, 196.0);
        frame.left = Plot::left_room(y, frame.area().h, font);
        let band = self.widths();
        frame.right = if band > 0.0 { 34.0 } else { 10.0 };
        let mut plot = Plot::new(
            frame,
            Scale::linear(0.4, count as f64 + 0.6),
            y,
            &format!("{id}-{}", self.sensor),
        )
        .with_font(font);
        let quantity = if self.quantity.is_empty() || self.quantity.len() > 20 {
            "residual"
        } else {
            &self.quantity
        };
        plot.y_axis(&format!("{quantity}, {}", self.unit));
        let ticks: Vec<(f64, String)> = self
            .labels
            .iter()
            .enumerate()
            .map(|(i, l)| ((i + 1) as f64, cut(l, 12)))
            .collect();
        plot.x_axis_at(&self.word, &ticks, count <= 60);
        let area = frame.area();
        if band > 0.0 {
            let (top, bottom) = (plot.y.at(band), plot.y.at(-band));
            plot.raw_under(&format!(
                "<rect class=\"b\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" data-series=\"band\"/>",
                number(area.x),
                number(top),
                number(area.w),
                number(bottom - top)
            ));
            let edges = if bottom - top < EDGES_APART {
                vec![(f64::midpoint(top, bottom), "±2σ")]
            } else {
                vec![(top, "+2σ"), (bottom, "−2σ")]
            };
            for (y, text) in edges {
                plot.fixed_text((area.x + area.w + 4.0, y + 4.0), "start", "t", text, "");
            }
        }
        let zero = plot.y.at(0.0);
        plot.raw_under(&format!(
            "<path class=\"a\" d=\"M{} {}H{}\"/>",
            number(area.x),
            number(zero),
            number(area.x + area.w)
        ));
        let step = area.w / count as f64;
        let apart = (0.22 * step).min(7.0);
        let r = (0.16 * step).clamp(1.2, 3.4);
        if self.has_bars() {
            let bars = self.bars(&plot, apart);
            plot.raw_under(&format!(
                "<path d=\"{bars}\" data-series=\"band\" style=\"fill:none;stroke:var(--data);stroke-opacity:.22;stroke-width:{}\"/>",
                number(1.6 * r)
            ));
        }
        for (axis, values) in self.axes.iter().enumerate() {
            let mut path = String::new();
            for (i, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
                let (x, y) = plot.at(((i + 1) as f64, *v));
                let x = x + (axis as f64 - 1.0) * apart;
                let (d, s) = (number(2.0 * r), number(r));
                let _ = match axis {
                    0 => write!(
                        path,
                        "M{} {}a{s} {s} 0 1 0 {d} 0a{s} {s} 0 1 0 -{d} 0z",
                        number(x - r),
                        number(y)
                    ),
                    1 => write!(path, "M{} {}h{d}v{d}h-{d}z", number(x - r), number(y - r)),
                    _ => write!(path, "M{} {}l{s} {d}h-{d}z", number(x), number(y - r)),
                };
            }
            let name = ["x", "y", "z"][axis];
            plot.raw(&format!(
                "<path d=\"{path}\" data-series=\"measured\" data-axis=\"{name}\" style=\"fill:var({})\"/>",
                Color::of_index(axis).property()
            ));
        }
        plot.finish(&format!("Residual of every {} and axis", self.word), "")
    }
}

/// A histogram.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Histogram {
    /// Value of `data-plot`: `calibration-before` or `calibration-after`.
    pub plot: String,
    /// Bold caption: `Before`.
    pub caption: String,
    /// Rest: `: |f| − g, 3.25 mg rms`.
    pub caption_rest: String,
    /// Quantity and unit: `|f| − g, mg`.
    pub x_title: String,
    /// The values.
    pub values: Vec<f64>,
    /// Color of the bars.
    pub color: Color,
}

impl Histogram {
    /// The figure.
    pub fn figure(&self) -> Figure {
        Figure::new(
            &self.plot,
            "",
            &self.caption,
            &self.caption_rest,
            self.draw(),
        )
    }

    fn draw(&self) -> Svg {
        let values: Vec<f64> = self
            .values
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        let (low, high) = (
            values.iter().copied().fold(f64::INFINITY, f64::min),
            values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        );
        // Around zero, as wide as the values need: both sides alike.
        let reach = low.abs().max(high.abs()).max(1e-300) * 1.1;
        let reach = if reach.is_finite() { reach } else { 1.0 };
        let bins = ((values.len() as f64).sqrt() * 2.2).ceil().clamp(8.0, 41.0) as usize;
        let step = 2.0 * reach / bins as f64;
        let mut counts = vec![0_usize; bins];
        for v in &values {
            let at = ((v + reach) / step).floor().max(0.0) as usize;
            counts[at.min(bins - 1)] += 1;
        }
        let most = counts.iter().copied().max().unwrap_or(1).max(1);
        let y = Scale::linear(0.0, most as f64 * 1.08);
        let mut frame = Frame::panel(PANEL_WIDTH, 148.0);
        frame.top = 8.0;
        frame.left = Plot::left_room(y, 90.0, Svg::FONT_SIZE);
        let mut plot = Plot::new(frame, Scale::linear(-reach, reach), y, &self.plot);
        plot.x_axis(&self.x_title);
        plot.y_axis_with("", 3);
        let mut bars = String::new();
        let base = plot.y.at(0.0);
        for (i, count) in counts.iter().enumerate().filter(|(_, c)| **c > 0) {
            let left = plot.x.at(-reach + step * i as f64);
            let right = plot.x.at(-reach + step * (i + 1) as f64);
            let top = plot.y.at(*count as f64);
            let _ = write!(
                bars,
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:var({})\"/>",
                number(left + 0.6),
                number(top),
                number((right - left - 1.2).max(0.6)),
                number(base - top),
                self.color.property()
            );
        }
        plot.raw(&bars);
        plot.finish(
            &format!("{}{}", self.caption, self.caption_rest),
            "A histogram.",
        )
    }
}

/// Poses on the sphere of directions, seen from above and from below.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseSphere {
    /// Direction of up in the body axes, a unit vector a pose.
    pub poses: Vec<[f64; 3]>,
    /// Directions that would help most, with a label each.
    pub next: Vec<([f64; 3], String)>,
}

impl PoseSphere {
    /// The figure.
    pub fn figure(&self) -> Figure {
        let rest = if self.next.is_empty() {
            ": which body direction was up; left +z up, right −z up"
        } else {
            ": which body direction was up; left +z up, right −z up; open: turn it so next"
        };
        Figure::new(
            "poses",
            "",
            &format!("{} poses", self.poses.len()),
            rest,
            self.draw(),
        )
    }

    fn draw(&self) -> Svg {
        const R: f64 = 74.0;
        let frame = Frame {
            width: PANEL_WIDTH,
            height: 196.0,
            left: 0.0,
            right: 0.0,
            top: 4.0,
            bottom: 0.0,
        };
        let mut plot = Plot::new(
            frame,
            Scale::linear(0.0, 1.0),
            Scale::linear(0.0, 1.0),
            "poses",
        );
        let centers = [(88.0, 98.0), (262.0, 98.0)];
        for (i, c) in centers.iter().enumerate() {
            plot.raw_under(&format!(
                "<circle cx=\"{0}\" cy=\"{1}\" r=\"{R}\" style=\"fill:var(--soft);stroke:var(--muted)\"/>\
                 <path class=\"g\" d=\"M{2} {1}H{3}M{0} {4}V{5}\"/>\
                 <circle class=\"g\" cx=\"{0}\" cy=\"{1}\" r=\"{6}\"/>",
                number(c.0),
                number(c.1),
                number(c.0 - R),
                number(c.0 + R),
                number(c.1 - R),
                number(c.1 + R),
                number(R * 0.5_f64.sqrt())
            ));
            let mirror = if i == 0 { 1.0 } else { -1.0 };
            plot.fixed_text(
                (c.0 + mirror * (R - 4.0), c.1 - 4.0),
                if i == 0 { "end" } else { "start" },
                "t",
                "+x",
                "",
            );
            plot.fixed_text((c.0 + 4.0, c.1 - R + 13.0), "start", "t", "+y", "");
            plot.fixed_text(
                (c.0, c.1 + R + 15.0),
                "middle",
                "u",
                if i == 0 { "+z up" } else { "−z up" },
                "",
            );
        }
        // Lambert's equal-area projection of each half; the lower half is seen from below.
        let at = |d: &[f64; 3]| {
            let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt().max(1e-300);
            let (x, y, z) = (d[0] / norm, d[1] / norm, d[2] / norm);
            let half = usize::from(z < 0.0);
            let k = R / (1.0 + z.abs()).sqrt();
            let mirror = if half == 0 { 1.0 } else { -1.0 };
            (centers[half].0 + mirror * k * x, centers[half].1 - k * y)
        };
        let mut dots = String::new();
        for d in self.poses.iter().take(2000) {
            let (x, y) = at(d);
            plot.placer.dot((x, y));
            let _ = write!(
                dots,
                "<circle cx=\"{}\" cy=\"{}\" r=\"3.4\" style=\"fill:var(--data);fill-opacity:.8\"/>",
                number(x),
                number(y)
            );
        }
        for (d, label) in self.next.iter().take(6) {
            let (x, y) = at(d);
            let _ = write!(
                dots,
                "<circle cx=\"{}\" cy=\"{}\" r=\"4.2\" style=\"fill:var(--page);stroke:var(--fit);stroke-width:1.8\"/>",
                number(x),
                number(y)
            );
            let style = TextStyle {
                color: "--fit",
                ..TextStyle::default()
            };
            plot.label(label, (x, y), None, 6.0, 60.0, style);
        }
        plot.raw(&dots);
        plot.finish("Poses on the sphere of directions", "")
    }
}

/// Correlations of the estimated parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CorrelationMap {
    /// Names.
    pub names: Vec<String>,
    /// Correlations, row by row.
    pub matrix: Vec<Vec<f64>>,
}

/// A parameter's path in the short words that fit a narrow page.
fn brief(name: &str) -> String {
    let mut out = name.to_owned();
    for (long, short) in [
        ("temperature_spline", "knot"),
        ("temperature", "T"),
        ("scale_factor", "scale"),
        ("misalignment", "misalign"),
        ("g2_sensitivity", "g2"),
        ("g_sensitivity", "g_sens"),
    ] {
        out = out.replace(long, short);
    }
    out
}

/// Text of at most so many characters: paths differ at their ends, so that the middle goes.
fn cut_middle(text: &str, most: usize) -> String {
    let all: Vec<char> = text.chars().collect();
    if all.len() <= most {
        return text.to_owned();
    }
    let head = most / 3;
    let tail = most - 1 - head;
    let part = |range: &[char]| range.iter().collect::<String>();
    format!("{}…{}", part(&all[..head]), part(&all[all.len() - tail..]))
}

impl CorrelationMap {
    const MOST: usize = 36;

    /// The figure; of more than 36 parameters the most correlated are shown.
    pub fn figure(&self) -> Figure {
        let shown = self.shown();
        let rest = if shown.len() < self.names.len() {
            format!(
                " of the {} most correlated of {} parameters; blue: positive, orange: negative",
                shown.len(),
                self.names.len()
            )
        } else {
            " of the parameters; blue: positive, orange: negative, full color: 1".to_owned()
        };
        Figure::new(
            "correlation",
            "",
            "Correlation",
            rest.trim_start(),
            self.draw(520.0, &shown),
        )
        .with_narrow(self.draw(PANEL_WIDTH, &shown))
    }

    fn value(&self, i: usize, j: usize) -> f64 {
        self.matrix
            .get(i)
            .and_then(|row| row.get(j))
            .copied()
            .filter(|v| v.is_finite())
            .unwrap_or(0.0)
            .clamp(-1.0, 1.0)
    }

    fn shown(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.names.len()).collect();
        if order.len() > Self::MOST {
            let strength = |i: usize| {
                (0..self.names.len())
                    .filter(|j| *j != i)
                    .map(|j| self.value(i, j).abs())
                    .fold(0.0, f64::max)
            };
            order.sort_by(|a, b| strength(*b).total_cmp(&strength(*a)));
            order.truncate(Self::MOST);
            order.sort_unstable();
        }
        order
    }

    fn draw(&self, width: f64, shown: &[usize]) -> Svg {
        const ROW: f64 = 15.0;
        let size = Svg::FONT_SIZE;
        let names: Vec<String> = shown
            .iter()
            .map(|&i| {
                if width < 400.0 {
                    cut_middle(&brief(&self.names[i]), 22)
                } else {
                    cut_middle(&self.names[i], 34)
                }
            })
            .collect();
        let left = names
            .iter()
            .map(|n| text_width(n, size, false))
            .fold(40.0, f64::max)
            .min(0.55 * width)
            + 8.0;
        let count = shown.len().max(1) as f64;
        let cell = ((width - left - 6.0) / count).min(46.0);
        let mut body = String::new();
        for (row, (&i, name)) in shown.iter().zip(&names).enumerate() {
            let top = 4.0 + ROW * row as f64;
            body.push_str(&halo_text(
                (left - 6.0, top + 11.5),
                "end",
                name,
                TextStyle {
                    class: "v",
                    bold: false,
                    ..TextStyle::default()
                },
            ));
            for (column, &j) in shown.iter().enumerate() {
                let r = self.value(i, j);
                let color = if i == j {
                    "--w"
                } else if r >= 0.0 {
                    "--data"
                } else {
                    "--fit"
                };
                let opacity = if i == j { 0.35 } else { r.abs() };
                let _ = write!(
                    body,
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:var({color});fill-opacity:{:.2};stroke:var(--grid);stroke-width:.6\"><title>{} and {}: {}</title></rect>",
                    number(left + cell * column as f64),
                    number(top),
                    number(cell),
                    number(ROW),
                    opacity,
                    escape(&self.names[i]),
                    escape(&self.names[j]),
                    page_number(&fixed(r, 2))
                );
            }
        }
        Svg {
            width,
            height: 10.0 + ROW * count,
            title: "Correlation of the estimated parameters".to_owned(),
            description: "A row and a column each, in the same order.".to_owned(),
            body,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(sigmas: [Vec<f64>; 3], band: f64) -> StationResiduals {
        StationResiduals {
            sensor: "accel".to_owned(),
            unit: "mg".to_owned(),
            word: "station".to_owned(),
            labels: vec!["1".to_owned(), "2".to_owned()],
            axes: [vec![0.1, -12.0], vec![0.1, 9.0], vec![3.0, 0.0]],
            band,
            sigmas,
            ..StationResiduals::default()
        }
    }

    #[test]
    fn stations_of_unequal_uncertainty_have_bars_of_their_own() {
        let all = [vec![0.14, 8.7], vec![8.7, 8.7], vec![8.7, 0.14]];
        let figure = some(all, 0.28).figure();
        assert!(figure.caption_rest.contains("bar: ± 2"));
        let drawn = figure.svg.inline("");
        assert_eq!(drawn.matches("data-series=\"band\"").count(), 1);
        assert!(!drawn.contains("<rect class=\"b\""));
        assert!(!drawn.contains("+2σ"));
    }

    #[test]
    fn labels_of_parameters_differ_on_a_narrow_page() {
        let names: Vec<String> = (1..=12)
            .flat_map(|i| {
                ["accel.bias", "accel.scale_factor", "gyro.bias"]
                    .map(|of| format!("{of}.temperature_spline.{i}.x"))
            })
            .collect();
        let n = names.len();
        let map = CorrelationMap {
            names,
            matrix: vec![vec![0.5; n]; n],
        };
        let drawn = map.draw(350.0, &map.shown()).inline("");
        let mut labels: Vec<&str> = drawn
            .split("</text>")
            .filter_map(|t| t.rsplit('>').next())
            .filter(|t| t.contains(".x"))
            .collect();
        let all = labels.len();
        labels.sort_unstable();
        labels.dedup();
        assert_eq!((all, labels.len()), (n, n), "{labels:?}");
    }

    #[test]
    fn the_edges_of_a_thin_band_have_one_label() {
        let narrow = |band: f64| some(Default::default(), band).figure().svg.inline("");
        assert!(narrow(8.0).contains("+2σ") && narrow(8.0).contains("−2σ"));
        assert!(!narrow(0.2).contains("+2σ") && narrow(0.2).contains("±2σ"));
    }
}
