//! The recording of each axis: mean, smallest and largest sample of equal pieces of the log.

use core::fmt::Write as _;

use super::{Figure, PANEL_WIDTH, time_unit};
use crate::svg::{Frame, Ink, Plot, Scale, number};

/// The time series of one axis in at most 720 pieces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeriesPanel {
    /// Channel.
    pub axis: String,
    /// Unit, with what was taken off if anything: `mg, less −1018 mg`.
    pub unit: String,
    /// Caption after the name: `scatter 0.349 °/s`.
    pub note: String,
    /// Length of the log in s.
    pub duration_s: f64,
    /// Middle of each piece in s since the start.
    pub time_s: Vec<f64>,
    /// Smallest sample of each piece; not a number where there is none.
    pub min: Vec<f64>,
    /// Mean of each piece.
    pub mean: Vec<f64>,
    /// Largest sample of each piece.
    pub max: Vec<f64>,
    /// Time spans of findings in s.
    pub findings_s: Vec<(f64, f64)>,
}

impl SeriesPanel {
    /// How many pieces the log is parted in, those in gaps counted.
    pub fn pieces(&self) -> usize {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|w| w[1] - w[0]).collect();
        steps.retain(|s| *s > 0.0);
        steps.sort_by(f64::total_cmp);
        let usual = steps.get(steps.len() / 2);
        usual.map_or(self.time_s.len(), |s| {
            (self.duration_s / s).round() as usize
        })
    }
}

/// The panels of one sensor, each on its own range but of equal length.
pub fn series_panels(panels: &[SeriesPanel]) -> Vec<Figure> {
    // Equal scales within a sensor: one length, centered on each axis's own middle.
    let ranges: Vec<(f64, f64)> = panels.iter().map(range).collect();
    let length = ranges.iter().map(|r| r.1 - r.0).fold(0.0, f64::max);
    panels
        .iter()
        .zip(&ranges)
        .map(|(panel, range)| {
            let middle = 0.5 * (range.0 + range.1);
            let y = Scale::linear(middle - 0.54 * length, middle + 0.54 * length);
            let svg = draw(panel, y);
            Figure::new(
                "series",
                &panel.axis,
                &super::axis_title(&panel.axis),
                &panel.note,
                svg,
            )
        })
        .collect()
}

fn range(panel: &SeriesPanel) -> (f64, f64) {
    let scale = Scale::around(
        panel
            .min
            .iter()
            .chain(&panel.max)
            .chain(&panel.mean)
            .copied(),
        false,
        0.0,
    );
    (scale.low(), scale.high())
}

fn draw(panel: &SeriesPanel, y: Scale) -> crate::svg::Svg {
    let mut frame = Frame::panel(PANEL_WIDTH, 162.0);
    frame.left = Plot::left_room(y, frame.area().h, 11.5).max(34.0);
    let (title, unit_s) = time_unit(panel.duration_s);
    let x = Scale::linear(0.0, (panel.duration_s / unit_s).max(1e-9));
    let mut plot = Plot::new(frame, x, y, &format!("series-{}", panel.axis));
    plot.axes(title, &panel.unit);
    let area = frame.area();
    let mut marks = String::new();
    for &(start, end) in panel.findings_s.iter().take(200) {
        let a = plot.x.at(start / unit_s).clamp(area.x, area.x + area.w);
        let b = plot.x.at(end / unit_s).clamp(area.x, area.x + area.w);
        let width = (b - a).max(2.5);
        let a = a.min(area.x + area.w - width);
        let _ = write!(
            marks,
            "<rect class=\"w\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
            number(a),
            number(area.y),
            number(width),
            number(area.h)
        );
    }
    plot.raw_under(&marks);
    let time: Vec<f64> = panel.time_s.iter().map(|t| t / unit_s).collect();
    // Gaps part the band.
    let mut start = 0;
    for i in 0..=time.len() {
        let broken = i == time.len()
            || !panel.min.get(i).is_some_and(|v| v.is_finite())
            || !panel.max.get(i).is_some_and(|v| v.is_finite());
        if broken {
            if i == start + 1 {
                // A piece between two gaps has no length of its own.
                let half = panel.duration_s / unit_s / 1440.0;
                let twice = |v: &[f64]| v.get(start).map_or(Vec::new(), |&v| vec![v; 2]);
                let alone = [time[start] - half, time[start] + half];
                plot.band(
                    &alone,
                    &twice(&panel.min),
                    &twice(&panel.max),
                    Ink::class("e").series("envelope"),
                );
                plot.curve(
                    &alone,
                    &twice(&panel.mean),
                    Ink::class("s").series("measured"),
                );
            } else if i > start + 1 {
                plot.band(
                    &time[start..i],
                    &panel.min[start..i],
                    &panel.max[start..i],
                    Ink::class("e").series("envelope"),
                );
                if panel.mean.len() >= i {
                    plot.curve(
                        &time[start..i],
                        &panel.mean[start..i],
                        Ink::class("s").series("measured"),
                    );
                }
            }
            start = i + 1;
        }
    }
    plot.finish(
        &format!(
            "{} over time, in {}",
            super::axis_title(&panel.axis),
            panel.unit
        ),
        "Line: mean of each piece of the log. Shade: its smallest and largest sample.",
    )
}
