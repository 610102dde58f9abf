//! The plots, each a plain struct of numbers that draws itself.
//!
//! Numbers are in the unit that is shown. Panels are 350 units wide and wrap; a plot that must be wide has
//! a second, narrow drawing ([`Figure`]).

mod allan;
mod calibration;
mod chart;
mod drift;
mod explain;
mod issues;
mod response;
mod scatter;
mod series;
mod spectrum;

pub use allan::{AllanPanel, AllanTerm, allan_panels};
pub use calibration::{CorrelationMap, Histogram, PoseSphere, StationResiduals};
pub use chart::{ChartCurve, CurveChart};
pub use drift::{DriftCloud, DriftGrowth, DriftShare};
pub use explain::{ExplainPanel, explain_panels};
pub use issues::{IssueBar, IssueTimeline};
pub use response::ResponsePlots;
pub use scatter::{Marker, Region, ScatterChart, ScatterPoint};
pub use series::{SeriesPanel, series_panels};
pub use spectrum::{SpectrumMark, SpectrumPanel, spectrum_panels};

use crate::svg::Svg;

/// Width of a panel in units.
pub const PANEL_WIDTH: f64 = 350.0;
/// Width of a wide drawing in units.
pub const WIDE_WIDTH: f64 = 860.0;

/// A color with a meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Color {
    /// Axis x.
    #[default]
    X,
    /// Axis y.
    Y,
    /// Axis z.
    Z,
    /// What is none of the axes.
    Other,
    /// Measured.
    Data,
    /// Fitted.
    Fit,
    /// Ink.
    Ink,
    /// Muted ink.
    Muted,
}

impl Color {
    /// Name of the custom property.
    pub fn property(self) -> &'static str {
        match self {
            Self::X => "--x",
            Self::Y => "--y",
            Self::Z => "--z",
            Self::Other => "--w",
            Self::Data => "--data",
            Self::Fit => "--fit",
            Self::Ink => "--ink",
            Self::Muted => "--muted",
        }
    }

    /// Color of axis 0, 1, 2; others are neutral.
    pub fn of_index(index: usize) -> Self {
        match index {
            0 => Self::X,
            1 => Self::Y,
            2 => Self::Z,
            _ => Self::Other,
        }
    }

    /// Color of a channel by its last letter.
    pub fn of_axis(axis: &str) -> Self {
        match axis.as_bytes().last() {
            Some(b'x') => Self::X,
            Some(b'y') => Self::Y,
            Some(b'z') => Self::Z,
            _ => Self::Other,
        }
    }
}

/// Title of a channel: `gyro_x` is `Gyro x`, `accel_z` is `Accelerometer z`.
///
/// ```
/// assert_eq!(sagnac_report::plots::axis_title("accel_z"), "Accelerometer z");
/// ```
pub fn axis_title(axis: &str) -> String {
    match axis.split_once('_') {
        Some(("gyro", rest)) => format!("Gyro {rest}"),
        Some(("accel", rest)) => format!("Accelerometer {rest}"),
        _ => axis.to_owned(),
    }
}

/// A plot of a page: its drawing, or a wide and a narrow one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// Name of the plot, the value of `data-plot`.
    pub plot: String,
    /// Channel, the value of `data-axis`; empty where it is about none.
    pub axis: String,
    /// Start of the caption, bold.
    pub caption: String,
    /// Rest of the caption.
    pub caption_rest: String,
    /// The drawing; with a narrow one beside it, that of wide pages.
    pub svg: Svg,
    /// The drawing for pages below 760 px.
    pub narrow: Option<Svg>,
}

impl Figure {
    /// A figure of one drawing.
    pub fn new(plot: &str, axis: &str, caption: &str, caption_rest: &str, svg: Svg) -> Self {
        Self {
            plot: plot.to_owned(),
            axis: axis.to_owned(),
            caption: caption.to_owned(),
            caption_rest: caption_rest.to_owned(),
            svg,
            narrow: None,
        }
    }

    /// With a narrow drawing beside the wide one.
    #[must_use]
    pub fn with_narrow(mut self, narrow: Svg) -> Self {
        self.narrow = Some(narrow);
        self
    }
}

/// Unit of a time axis of this length and its number of seconds.
pub(crate) fn time_unit(duration_s: f64) -> (&'static str, f64) {
    if duration_s >= 6.0 * 3600.0 {
        ("time, h", 3600.0)
    } else if duration_s >= 300.0 {
        ("time, min", 60.0)
    } else {
        ("time, s", 1.0)
    }
}
