//! The Allan deviation of each axis with its band, the fitted sum and each term alone.
//!
//! A term alone is a straight line in logarithms: Q √3/τ, N τ^(−1/2), 0.664 B, K √(τ/3), R τ/√2 [IEEE952].

use super::{Figure, PANEL_WIDTH};
use crate::svg::{Frame, Ink, Plot, Scale, TextStyle};

/// A term of the fit as it is drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AllanTerm {
    /// Its letter: Q, N, B, K, R, or a short name.
    pub symbol: String,
    /// Its label: letter, value, unit, interval (`N 2.414 °/√h ± 0.021`).
    pub label: String,
    /// Its deviation at each averaging time of the panel, in the panel's unit.
    pub deviation: Vec<f64>,
    /// Whether this is the upper limit of a term that was not seen.
    pub upper_limit: bool,
}

impl AllanTerm {
    /// A term whose deviation is `at_one_second` τ^`exponent`.
    pub fn power(
        symbol: &str,
        label: &str,
        at_one_second: f64,
        exponent: f64,
        tau_s: &[f64],
    ) -> Self {
        Self {
            symbol: symbol.to_owned(),
            label: label.to_owned(),
            deviation: tau_s
                .iter()
                .map(|t| at_one_second * t.powf(exponent))
                .collect(),
            upper_limit: false,
        }
    }

    /// The same line as the limit of a term that was not seen.
    #[must_use]
    pub fn as_limit(mut self) -> Self {
        self.upper_limit = true;
        self
    }
}

/// The Allan deviation of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AllanPanel {
    /// Channel: `gyro_x`.
    pub axis: String,
    /// Unit of the deviations: `°/h`.
    pub unit: String,
    /// Averaging times in s.
    pub tau_s: Vec<f64>,
    /// Deviation.
    pub deviation: Vec<f64>,
    /// Lower end of the 95 % band; empty where there is none.
    pub lower: Vec<f64>,
    /// Upper end of the 95 % band; empty where there is none.
    pub upper: Vec<f64>,
    /// Deviation of the sum of the fitted terms; empty where nothing was fitted.
    pub fit: Vec<f64>,
    /// The terms alone.
    pub terms: Vec<AllanTerm>,
    /// Name of the fitted curve; empty: `sum of fitted terms`.
    pub fit_name: String,
}

/// The panels of one sensor on one scale.
///
/// The first panel names the curves. Figures come in the order of the panels.
pub fn allan_panels(panels: &[AllanPanel]) -> Vec<Figure> {
    let finite = |v: &&f64| v.is_finite() && **v > 0.0;
    let tau = panels.iter().flat_map(|p| p.tau_s.iter().filter(finite));
    let x = Scale::around(tau.copied(), true, 0.03).at_least_decades(1.5);
    let values = panels.iter().flat_map(|p| {
        p.deviation
            .iter()
            .chain(&p.fit)
            .chain(&p.lower)
            .chain(&p.upper)
            .filter(finite)
    });
    let around = Scale::around(values.copied(), true, 0.0).at_least_decades(1.2);
    // Room below the curve for its terms and their labels.
    let y = Scale::log(around.low() / 2.8, around.high() * 1.7);
    let mut named = false;
    panels
        .iter()
        .map(|panel| {
            let name_curves = !named && !panel.fit.is_empty();
            named |= name_curves;
            let svg = draw(panel, x, y, name_curves);
            Figure::new(
                "allan",
                &panel.axis,
                &super::axis_title(&panel.axis),
                "",
                svg,
            )
        })
        .collect()
}

fn draw(panel: &AllanPanel, x: Scale, y: Scale, name_curves: bool) -> crate::svg::Svg {
    let mut frame = Frame::panel(PANEL_WIDTH, 262.0);
    frame.left = Plot::left_room(y, frame.area().h, 11.5).max(34.0);
    let mut plot = Plot::new(frame, x, y, &format!("allan-{}", panel.axis));
    plot.axes(
        "averaging time τ, s",
        &format!("Allan deviation, {}", panel.unit),
    );
    plot.band(
        &panel.tau_s,
        &panel.lower,
        &panel.upper,
        Ink::class("b").series("band"),
    );
    for term in &panel.terms {
        let (tau, deviation) = shown_part(panel, term, y);
        let class = if term.upper_limit { "q" } else { "d" };
        plot.curve(&tau, &deviation, Ink::class(class).term(&term.symbol));
    }
    plot.curve(
        &panel.tau_s,
        &panel.deviation,
        Ink::class("m").series("measured"),
    );
    plot.curve(&panel.tau_s, &panel.fit, Ink::class("f").series("fit"));

    // Circle: N at 1 s.
    let mut asks: Vec<(String, (f64, f64), f64, bool)> = Vec::new();
    for term in &panel.terms {
        let (tau, deviation) = shown_part(panel, term, y);
        let (Some(first), Some(last)) = (
            tau.first().copied().zip(deviation.first().copied()),
            tau.last().copied().zip(deviation.last().copied()),
        ) else {
            continue;
        };
        let (point, direction) = match term.symbol.as_str() {
            "N" => {
                let at_one = interpolate(&panel.tau_s, &term.deviation, 1.0);
                match at_one.filter(|v| plot.y.holds(*v)) {
                    Some(value) => {
                        if !term.upper_limit {
                            plot.circle((1.0, value), 3.4, Ink::class("o"));
                        }
                        ((1.0, value), 20.0)
                    }
                    None => (middle(&tau, &deviation), 45.0),
                }
            }
            "B" => (first, 200.0),
            "Q" => (first, 60.0),
            "K" | "R" => (last, 120.0),
            // The top of its hump.
            "GM" => {
                let points = tau.iter().copied().zip(deviation.iter().copied());
                let top = points.max_by(|a, b| a.1.total_cmp(&b.1));
                (top.unwrap_or(last), 270.0)
            }
            _ => (middle(&tau, &deviation), 90.0),
        };
        asks.push((
            term.label.clone(),
            plot.at(point),
            direction,
            term.upper_limit,
        ));
    }
    for (text, point, direction, limit) in asks {
        let style = if limit {
            TextStyle {
                class: "l h ln",
                ..TextStyle::default()
            }
        } else {
            TextStyle::default()
        };
        plot.label(&text, point, Some(direction), 6.0, 130.0, style);
    }
    if name_curves {
        let fit_name = if panel.fit_name.is_empty() {
            "sum of fitted terms"
        } else {
            &panel.fit_name
        };
        name(
            &mut plot,
            &panel.tau_s,
            &panel.deviation,
            "measured, 95 % band",
            "lm",
            50.0,
        );
        name(&mut plot, &panel.tau_s, &panel.fit, fit_name, "lf", 230.0);
    }
    plot.finish(
        &format!(
            "Allan deviation of {}, in {} against averaging time",
            super::axis_title(&panel.axis),
            panel.unit
        ),
        "Measured with its 95 percent band, the sum of the fitted terms and each term alone.",
    )
}

/// Names a curve where it runs freely: in its first third.
fn name(plot: &mut Plot, tau: &[f64], values: &[f64], text: &str, class: &str, direction: f64) {
    let at = tau.len() / 6;
    let Some((&t, &v)) = tau.get(at).zip(values.get(at)) else {
        return;
    };
    let point = plot.at((t, v));
    let class = format!("l h {class}");
    let style = TextStyle {
        class: &class,
        ..TextStyle::default()
    };
    plot.label(text, point, Some(direction), 6.0, 110.0, style);
}

/// The part of a term's line that is near the curve: from about a quarter of the sum on.
///
/// A term that is small everywhere is drawn where it is least small, over half a decade at least; a limit
/// that lies outside of the picture is left out.
fn shown_part(panel: &AllanPanel, term: &AllanTerm, y: Scale) -> (Vec<f64>, Vec<f64>) {
    const LEAST_SHARE: f64 = 0.22;
    let whole = if panel.fit.len() == panel.tau_s.len() {
        &panel.fit
    } else {
        &panel.deviation
    };
    let part = |least: f64| -> (Vec<f64>, Vec<f64>) {
        panel
            .tau_s
            .iter()
            .zip(&term.deviation)
            .zip(whole)
            .filter(|((_, d), sum)| d.is_finite() && **d >= least * **sum && y.holds(**d))
            .map(|((&t, &d), _)| (t, d))
            .unzip()
    };
    let long = |part: &(Vec<f64>, Vec<f64>)| match (part.0.first(), part.0.last()) {
        (Some(first), Some(last)) => last / first > 3.0,
        _ => false,
    };
    let near = part(LEAST_SHARE);
    if long(&near) {
        return near;
    }
    let most = term
        .deviation
        .iter()
        .zip(whole)
        .filter(|(d, _)| y.holds(**d))
        .map(|(d, sum)| d / sum)
        .filter(|share| share.is_finite())
        .fold(0.0, f64::max);
    let wider = part((0.35 * most).min(LEAST_SHARE));
    if long(&wider) || !term.upper_limit {
        wider
    } else {
        (Vec::new(), Vec::new())
    }
}

fn middle(tau: &[f64], deviation: &[f64]) -> (f64, f64) {
    let at = tau.len() / 2;
    (
        tau.get(at).copied().unwrap_or(1.0),
        deviation.get(at).copied().unwrap_or(1.0),
    )
}

/// Value of a curve at `x` in logarithms; `None` outside.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> Option<f64> {
    let i = x.windows(2).position(|w| w[0] <= at && at <= w[1])?;
    let (y0, y1) = (*y.get(i)?, *y.get(i + 1)?);
    if !(y0 > 0.0 && y1 > 0.0) {
        return None;
    }
    let t = (at / x[i]).ln() / (x[i + 1] / x[i]).ln();
    Some((y0.ln() + t * (y1.ln() - y0.ln())).exp()).filter(|v| v.is_finite())
}
