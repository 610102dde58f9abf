//! Text, SVG and HTML results of sagnac.
//!
//! This crate draws; it computes nothing about sensors and knows no other crate of the workspace.
//! A caller fills plain structs (view models) with numbers and gets back text, an SVG drawing, a PNG
//! picture or a whole HTML page.
//!
//! - [`text`]: 80-column tables, the digits rule, durations, wrapping, colors.
//!
//! Units: numbers arrive in the unit that is shown; [`text::Unit`] converts from SI.

pub mod text;
