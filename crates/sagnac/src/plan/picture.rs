//! The picture of `plan`: relative precision of every term against the length of the log.
//!
//! σ_θ/θ = √(J⁻¹)_aa at 10 min … 10 days, all terms and the mean unknown: [`sagnac_analysis::plan`].

use super::Plan;
use sagnac_analysis::plan::precision;
use sagnac_report::plots::{ChartCurve, Color, CurveChart};
use sagnac_report::svg::Svg;
use sagnac_report::text::{duration, general};

/// Lengths drawn between the shortest and the longest.
const POINTS: usize = 49;

impl Plan {
    /// The drawing: a chart for each sensor, or axis, with noise of its own; only what is observable is drawn.
    pub fn to_svg(&self) -> Svg {
        let shortest = self.duration_s.min(600.0);
        let longest = (10.0 * self.duration_s).max(86_400.0);
        let charts: Vec<Svg> = self
            .groups()
            .into_iter()
            .enumerate()
            .map(|(number, (name, index))| {
                let terms = &self.axes[index].terms;
                let lengths: Vec<f64> = (0..POINTS)
                    .map(|i| shortest * (longest / shortest).powf(i as f64 / (POINTS - 1) as f64))
                    .collect();
                let reached: Vec<_> = lengths
                    .iter()
                    .map(|&d| precision(terms, d, 1.0 / self.rate_hz))
                    .collect();
                let mut curves: Vec<ChartCurve> = Vec::new();
                for (symbol, term) in super::columns_of(terms) {
                    let (x, y): (Vec<f64>, Vec<f64>) = lengths
                        .iter()
                        .zip(&reached)
                        .filter_map(|(d, p)| Some((d / 3600.0, 100.0 * p.of(term)?)))
                        .unzip();
                    if !x.is_empty() {
                        curves.push(ChartCurve {
                            label: symbol,
                            color: [Color::Data, Color::Fit, Color::X, Color::Y, Color::Z]
                                [curves.len() % 5],
                            x,
                            y,
                            ..ChartCurve::default()
                        });
                    }
                }
                CurveChart {
                    id: format!("plan-{number}"),
                    title: format!("{name}: precision against length"),
                    x_title: "length of the log, h".to_owned(),
                    y_title: format!("{name}: 1 sigma, % of the value"),
                    curves,
                    ..CurveChart::default()
                }
                .draw()
            })
            .collect();
        let rows: Vec<Vec<Svg>> = charts.chunks(2).map(<[Svg]>::to_vec).collect();
        let heading = format!(
            "precision against length at {} Hz; planned: {}",
            general(self.rate_hz, 4),
            duration(super::rounded(self.duration_s))
        );
        let mut sheet = Svg::sheet(&heading, &rows);
        sheet.title = heading;
        sheet
    }
}
