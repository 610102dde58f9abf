//! Text, SVG and HTML results of sagnac.
//!
//! This crate draws; it computes nothing about sensors and knows no other crate of the workspace.
//! A caller fills plain structs (view models) with numbers and gets back text, an SVG drawing, a PNG
//! picture or a whole HTML page.
//!
//! - [`html`]: whole pages.
//! - [`plots`]: Allan deviations, spectra, time series, findings and the other plots.
//! - [`svg`]: drawings, stand-alone files, pictures.
//! - [`text`]: 80-column tables, the digits rule, durations, wrapping, colors.
//!
//! Units: numbers arrive in the unit that is shown; [`text::Unit`] converts from SI.

pub mod html;
pub mod plots;
pub mod svg;
pub mod text;
