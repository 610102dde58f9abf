//! Text, SVG and HTML results of sagnac.
