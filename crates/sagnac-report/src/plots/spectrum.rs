//! The spectrum of each axis: square root of the power spectral density against frequency.

use super::{Figure, PANEL_WIDTH};
use crate::svg::{Frame, Ink, Plot, Scale, TextStyle};

/// A peak that is named.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpectrumMark {
    /// Its frequency in Hz.
    pub frequency_hz: f64,
    /// Its name: `line at 0.568 Hz`.
    pub text: String,
}

/// The spectrum of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpectrumPanel {
    /// Channel.
    pub axis: String,
    /// Unit of the densities: `°/s/√Hz`.
    pub unit: String,
    /// `one-sided`, said at the axis.
    pub sides: String,
    /// Frequencies in Hz.
    pub frequency_hz: Vec<f64>,
    /// Square root of the density.
    pub density: Vec<f64>,
    /// The same of the sum of the fitted terms, at the same frequencies; empty where nothing was fitted.
    pub fit: Vec<f64>,
    /// What is named.
    pub marks: Vec<SpectrumMark>,
}

/// The panels of one sensor on one scale.
pub fn spectrum_panels(panels: &[SpectrumPanel]) -> Vec<Figure> {
    let positive = |v: &&f64| v.is_finite() && **v > 0.0;
    let frequency = panels
        .iter()
        .flat_map(|p| p.frequency_hz.iter().filter(positive));
    let x = Scale::around(frequency.copied(), true, 0.01).at_least_decades(1.5);
    // The lowest thousandth (notches) does not decide the scale.
    let mut values: Vec<f64> = panels
        .iter()
        .flat_map(|p| p.density.iter().chain(&p.fit).filter(positive).copied())
        .collect();
    values.sort_by(f64::total_cmp);
    let skip = values.len() / 1000;
    let y = Scale::around(values.into_iter().skip(skip), true, 0.04).at_least_decades(1.5);
    let y = Scale::log(y.low(), y.high() * 1.5);
    panels
        .iter()
        .map(|panel| {
            let svg = draw(panel, x, y);
            Figure::new(
                "spectrum",
                &panel.axis,
                &super::axis_title(&panel.axis),
                "",
                svg,
            )
        })
        .collect()
}

fn draw(panel: &SpectrumPanel, x: Scale, y: Scale) -> crate::svg::Svg {
    let mut frame = Frame::panel(PANEL_WIDTH, 212.0);
    frame.left = Plot::left_room(y, frame.area().h, 11.5).max(34.0);
    let mut plot = Plot::new(frame, x, y, &format!("spectrum-{}", panel.axis));
    let sides = if panel.sides.is_empty() {
        String::new()
    } else {
        format!("{}, ", panel.sides)
    };
    plot.axes("frequency, Hz", &format!("√PSD, {sides}{}", panel.unit));
    plot.curve(
        &panel.frequency_hz,
        &panel.density,
        Ink::class("s").series("measured"),
    );
    plot.curve(
        &panel.frequency_hz,
        &panel.fit,
        Ink::class("f").series("fit"),
    );
    for mark in &panel.marks {
        let peak = panel
            .frequency_hz
            .iter()
            .zip(&panel.density)
            .filter(|(f, d)| {
                d.is_finite()
                    && **f > 0.0
                    && mark.frequency_hz > 0.0
                    && (**f / mark.frequency_hz).ln().abs() < 0.1
            })
            .max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((&f, &d)) = peak {
            let point = plot.at((f, d.min(plot.y.high())));
            plot.label(
                &mark.text,
                point,
                Some(90.0),
                5.0,
                90.0,
                TextStyle::default(),
            );
        }
    }
    plot.finish(
        &format!(
            "Spectrum of {}, in {} against frequency",
            super::axis_title(&panel.axis),
            panel.unit
        ),
        "Measured and the sum of the fitted terms.",
    )
}
