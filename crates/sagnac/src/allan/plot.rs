//! The picture of `allan`: one chart a sensor, its axes on it.

use sagnac_analysis::Curve;
use sagnac_report::plots::{ChartCurve, Color, CurveChart};
use sagnac_report::svg::Svg;

use super::text::Shown;
use super::{AllanAxis, AllanOutcome};

/// Points of a spectrum that are drawn: means over bins of equal width in log f.
const BINS_PER_DECADE: f64 = 40.0;

impl AllanOutcome {
    /// The drawing: a chart for gyro, accelerometer and whatever else there is.
    pub fn to_svg(&self) -> Svg {
        let mut charts = Vec::new();
        for (group, axes) in self.groups() {
            let shown = Shown::of(axes[0], self);
            let what = if self.request.spectrum {
                "one-sided noise density"
            } else {
                self.request.deviation.plot_name()
            };
            let y_title = format!("{group}: {what}, {}", shown.page);
            let curves: Vec<ChartCurve> = axes
                .iter()
                .filter_map(|axis| Self::curve_of(axis, &shown))
                .collect();
            let mut chart = CurveChart::allan(&format!("allan-{}", charts.len()), &y_title, curves);
            if self.request.spectrum {
                "frequency f, Hz".clone_into(&mut chart.x_title);
            }
            charts.push(chart.draw());
        }
        let rows: Vec<Vec<Svg>> = charts.chunks(2).map(<[Svg]>::to_vec).collect();
        let mut sheet = Svg::sheet(&self.heading(), &rows);
        sheet.title = self.heading();
        sheet
    }

    fn heading(&self) -> String {
        let name = std::path::Path::new(&self.request.label)
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let name = name.split('.').next().unwrap_or_default().to_owned();
        let what = if self.request.spectrum {
            "one-sided noise density".to_owned()
        } else {
            format!("{}, 95 % band", self.request.deviation.full_name())
        };
        if name.is_empty() {
            what
        } else {
            format!("{name}: {what}")
        }
    }

    /// Axes by sensor, in order.
    pub(super) fn groups(&self) -> Vec<(String, Vec<&AllanAxis>)> {
        let mut groups: Vec<(String, Vec<&AllanAxis>)> = Vec::new();
        for axis in self.axes.iter().filter(|axis| !axis.is_empty()) {
            let name = match axis.quantity {
                sagnac_log::Quantity::AngularRate => "gyro".to_owned(),
                sagnac_log::Quantity::SpecificForce => "accelerometer".to_owned(),
                sagnac_log::Quantity::AngularAcceleration => "angular acceleration".to_owned(),
                _ => axis.axis.clone(),
            };
            match groups.last_mut() {
                Some((group, members)) if *group == name => members.push(axis),
                _ => groups.push((name, vec![axis])),
            }
        }
        groups
    }

    fn curve_of(axis: &AllanAxis, shown: &Shown) -> Option<ChartCurve> {
        let label = axis
            .axis
            .rsplit_once('_')
            .map_or(axis.axis.as_str(), |(_, end)| end);
        let mut out = ChartCurve {
            label: label.to_owned(),
            color: Color::of_axis(&axis.axis),
            ..ChartCurve::default()
        };
        if let Some(density) = &axis.density {
            (out.x, out.y) = binned(&density.frequency_hz, &density.density);
            for value in &mut out.y {
                *value = value.sqrt() * shown.per_si;
            }
        } else {
            let curve = axis.curve.as_ref()?;
            fill(&mut out, curve, shown.per_si);
        }
        Some(out)
    }
}

/// The points of a curve; those that are zero cannot be drawn on logarithmic axes.
fn fill(out: &mut ChartCurve, curve: &Curve, per_si: f64) {
    for k in 0..curve.len() {
        let value = curve.deviation[k];
        if value <= 0.0 || !value.is_finite() {
            continue;
        }
        out.x.push(curve.tau_s[k]);
        out.y.push(value * per_si);
        out.lower.push(curve.lower[k].unwrap_or(value) * per_si);
        out.upper.push(curve.upper[k].unwrap_or(value) * per_si);
    }
}

/// Means over bins of equal width in log f.
fn binned(frequency_hz: &[f64], density: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let mut start = 0;
    while start < frequency_hz.len() {
        let bin = |k: usize| (frequency_hz[k].log10() * BINS_PER_DECADE).floor();
        let end = (start..frequency_hz.len())
            .find(|&k| bin(k) > bin(start))
            .unwrap_or(frequency_hz.len());
        let count = (end - start) as f64;
        let mean = density[start..end].iter().sum::<f64>() / count;
        if mean > 0.0 && mean.is_finite() {
            x.push(frequency_hz[start..end].iter().sum::<f64>() / count);
            y.push(mean);
        }
        start = end;
    }
    (x, y)
}
