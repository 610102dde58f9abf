//! Position error: growth in time, where the runs end, which term causes it.

use core::fmt::Write as _;

use super::{ChartCurve, Color, CurveChart, Figure, PANEL_WIDTH, WIDE_WIDTH, time_unit};
use crate::svg::{Frame, Ink, Plot, Scale, Svg, TextStyle, halo_text, number, text_width};

/// Growth of CEP and R95.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DriftGrowth {
    /// Unit of the errors: `m`, `km`.
    pub unit: String,
    /// Times in s.
    pub time_s: Vec<f64>,
    /// CEP of the Monte Carlo, else of the covariance.
    pub cep: Vec<f64>,
    /// Ends of its 95 % interval; empty: none.
    pub cep_interval: (Vec<f64>, Vec<f64>),
    /// R95.
    pub r95: Vec<f64>,
    /// Ends of its 95 % interval; empty: none.
    pub r95_interval: (Vec<f64>, Vec<f64>),
    /// CEP and R95 of the covariance where the other curves are a Monte Carlo; empty: none.
    pub covariance: (Vec<f64>, Vec<f64>),
}

impl DriftGrowth {
    /// The figure.
    pub fn figure(&self) -> Figure {
        let mut rest = Vec::new();
        if !self.cep_interval.0.is_empty() {
            rest.push("bands: 95 % interval of the Monte Carlo");
        }
        if !self.covariance.0.is_empty() {
            rest.push("dashed: covariance");
        }
        let rest = if rest.is_empty() {
            String::new()
        } else {
            format!("; {}", rest.join("; "))
        };
        Figure::new(
            "drift-growth",
            "",
            "Growth in time",
            &rest,
            self.draw(520.0, "drift-growth"),
        )
        .with_narrow(self.draw(PANEL_WIDTH, "drift-growth-narrow"))
    }

    fn draw(&self, width: f64, id: &str) -> Svg {
        let duration = self.time_s.iter().copied().fold(0.0, f64::max);
        let (title, unit_s) = time_unit(duration);
        let x: Vec<f64> = self.time_s.iter().map(|t| t / unit_s).collect();
        let curve =
            |label: &str, color, y: &[f64], interval: &(Vec<f64>, Vec<f64>), dashed| ChartCurve {
                label: label.to_owned(),
                color,
                x: x.clone(),
                y: y.to_vec(),
                lower: interval.0.clone(),
                upper: interval.1.clone(),
                dashed,
                series: if dashed {
                    "fit".to_owned()
                } else {
                    String::new()
                },
            };
        let none = (Vec::new(), Vec::new());
        let mut curves = vec![
            curve("R95", Color::Y, &self.r95, &self.r95_interval, false),
            curve("CEP", Color::X, &self.cep, &self.cep_interval, false),
        ];
        for y in [&self.covariance.0, &self.covariance.1] {
            if !y.is_empty() {
                curves.push(curve("", Color::Ink, y, &none, true));
            }
        }
        CurveChart {
            id: id.to_owned(),
            title: "Growth of the horizontal position error in time".to_owned(),
            x_title: title.to_owned(),
            y_title: format!("horizontal position error, {}", self.unit),
            x_log: false,
            y_log: false,
            from_zero: true,
            curves,
            width,
            height: if width < 400.0 { 300.0 } else { 350.0 },
        }
        .draw()
    }
}

/// Where the runs end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DriftCloud {
    /// Unit: `m`.
    pub unit: String,
    /// Caption after `Where 500 runs end`: `after 2 min`.
    pub note: String,
    /// East errors.
    pub east: Vec<f64>,
    /// North errors.
    pub north: Vec<f64>,
    /// Radius of half of the runs.
    pub cep: f64,
    /// Radius of 95 %.
    pub r95: f64,
    /// Labels of the circles: `CEP 373 m`, `R95 764 m`.
    pub labels: (String, String),
}

impl DriftCloud {
    /// The figure.
    pub fn figure(&self) -> Figure {
        let caption = format!("Where {} runs end", self.east.len());
        Figure::new("drift-cloud", "", &caption, &self.note, self.draw())
    }

    fn draw(&self) -> Svg {
        const SIDE: f64 = 292.0;
        // Nearly all runs: outliers beyond do not shrink the picture.
        let reach = (1.32 * self.r95).max(1e-12);
        let scale = Scale::linear(-reach, reach);
        let mut frame = Frame::panel(PANEL_WIDTH, SIDE + 62.0);
        frame.left = PANEL_WIDTH - SIDE - frame.right;
        let mut plot = Plot::new(frame, scale, scale, "drift-cloud");
        plot.axes(
            &format!("east error, {}", self.unit),
            &format!("north error, {}", self.unit),
        );
        let mut dots = String::new();
        let mut outside = 0;
        for (&e, &n) in self.east.iter().zip(&self.north).take(4000) {
            if !(e.is_finite() && n.is_finite()) || e.abs() > reach || n.abs() > reach {
                outside += 1;
                continue;
            }
            let (x, y) = plot.at((e, n));
            let _ = write!(dots, "M{} {}h0", number(x), number(y));
        }
        plot.raw(&format!(
            "<path d=\"{dots}\" style=\"stroke:var(--data);stroke-width:3.6;stroke-linecap:round;stroke-opacity:.55;fill:none\"/>"
        ));
        let center = plot.at((0.0, 0.0));
        for (radius, color, label) in [
            (self.r95, Color::Fit, &self.labels.1),
            (self.cep, Color::Data, &self.labels.0),
        ] {
            let r = plot.x.at(radius) - center.0;
            plot.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" style=\"fill:none;stroke:var({});stroke-width:2\"/>",
                number(center.0),
                number(center.1),
                number(r),
                color.property()
            ));
            let style = TextStyle {
                color: color.property(),
                ..TextStyle::default()
            };
            plot.label(
                label,
                (center.0, center.1 - r),
                Some(90.0),
                4.0,
                60.0,
                style,
            );
        }
        plot.finish(
            "End points of the runs with the circles that hold half and 95 % of them",
            &format!("{outside} runs end outside of the picture."),
        )
    }
}

/// Shares of the terms over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DriftShare {
    /// Times in s.
    pub time_s: Vec<f64>,
    /// Terms from the largest on: name and share of the variance, 0 … 1, at each time.
    pub terms: Vec<(String, Vec<f64>)>,
}

impl DriftShare {
    /// The figure.
    pub fn figure(&self) -> Figure {
        Figure::new(
            "drift-share",
            "",
            "Which term causes it",
            ", over time",
            self.draw(WIDE_WIDTH, "drift-share"),
        )
        .with_narrow(self.draw(PANEL_WIDTH, "drift-share-narrow"))
    }

    fn draw(&self, width: f64, id: &str) -> Svg {
        const COLORS: [&str; 4] = ["--x", "--y", "--z", "--w"];
        let font = if width > 400.0 { 11.9 } else { Svg::FONT_SIZE };
        let duration = self.time_s.iter().copied().fold(0.0, f64::max);
        let (title, unit_s) = time_unit(duration);
        let time: Vec<f64> = self.time_s.iter().map(|t| t / unit_s).collect();
        let mut frame = Frame::panel(width, 226.0);
        frame.left = 38.0;
        let mut plot = Plot::new(
            frame,
            Scale::linear(0.0, (duration / unit_s).max(1e-9)),
            Scale::linear(0.0, 100.0),
            id,
        )
        .with_font(font);
        plot.axes(title, "share of the position variance, %");
        let mut below = vec![0.0; time.len()];
        let mut texts = String::new();
        for (i, (name, share)) in self.terms.iter().enumerate() {
            let above: Vec<f64> = below
                .iter()
                .zip(share)
                .map(|(b, s)| {
                    b + 100.0
                        * if s.is_finite() {
                            s.clamp(0.0, 1.0)
                        } else {
                            0.0
                        }
                })
                .collect();
            let color = COLORS[i % COLORS.len()];
            let style = "style=\"fill-opacity:.34;stroke:var(--page);stroke-width:1.2\"";
            // The color goes into the same attribute.
            let style = style.replace("fill-opacity", &format!("color:var({color});fill-opacity"));
            plot.band(
                &time,
                &below,
                &above,
                Ink::class("bc").term(name).extra(&style),
            );
            if let Some(text) = name_band(&plot, name, &time, &below, &above, font) {
                texts.push_str(&text);
            }
            below = above;
        }
        plot.raw(&texts);
        plot.finish("Share of each term in the position variance over time", "")
    }
}

/// A name inside its band, where the band is thick along the whole name.
fn name_band(
    plot: &Plot,
    name: &str,
    time: &[f64],
    below: &[f64],
    above: &[f64],
    font: f64,
) -> Option<String> {
    let w = text_width(name, font, true);
    let area = plot.frame.area();
    let edges: Vec<(f64, f64, f64)> = time
        .iter()
        .zip(below)
        .zip(above)
        .map(|((t, b), a)| (plot.x.at(*t), plot.y.at(*a), plot.y.at(*b)))
        .collect();
    let mut best: Option<(f64, f64, f64)> = None;
    for &(x, _, _) in &edges {
        let (left, right) = (x - 0.5 * w - 6.0, x + 0.5 * w + 6.0);
        if left < area.x || right > area.x + area.w {
            continue;
        }
        let under: Vec<&(f64, f64, f64)> = edges
            .iter()
            .filter(|e| e.0 >= left && e.0 <= right)
            .collect();
        let top = under.iter().map(|e| e.1).fold(f64::NEG_INFINITY, f64::max);
        let bottom = under.iter().map(|e| e.2).fold(f64::INFINITY, f64::min);
        let free = bottom - top;
        if free > font * 1.3 && best.is_none_or(|b| free > b.2) {
            best = Some((x, 0.5 * (top + bottom), free));
        }
    }
    let (x, y, _) = best?;
    Some(halo_text(
        (x, y + 0.35 * font),
        "middle",
        name,
        TextStyle {
            class: "l",
            size: font,
            ..TextStyle::default()
        },
    ))
}
