//! Quantities as text: one table of units for the parser, the errors, the docs and the completions.
//!
//! A quantity is a number and a unit, `"0.34 deg/sqrt(h)"`; inside the program it is an `f64` in SI. Products, quotients,
//! powers and roots of the units of [`UNITS`] are read; `a/b/c` means `(a/b)/c`. Numbers have Rust's `f64` grammar
//! without `inf` and `nan`.
//!
//! ```
//! use sagnac_model::units::{Dimension, format_quantity, parse_quantity, parse_with_unit, unit_factor};
//! assert_eq!(parse_quantity("2h", Dimension::TIME)?, 7200.0);
//! assert_eq!(parse_quantity("298.15 K", Dimension::TEMPERATURE)?, 25.0); // degC
//! assert_eq!(unit_factor("km", Dimension::LENGTH)?, 1000.0);
//! let (rate_rad_s, unit) = parse_with_unit("12.5 deg/h", Dimension::ANGULAR_RATE)?;
//! assert_eq!(format_quantity(rate_rad_s, &unit), "12.5 deg/h");
//! let refused = parse_quantity("5 m", Dimension::TIME).unwrap_err();
//! assert_eq!(refused.advice().as_deref(), Some("write for instance \"30 s\""));
//! # Ok::<(), sagnac_model::units::Error>(())
//! ```

mod column;
mod dimension;
mod double_double;
mod error;
mod expression;
mod format;
mod number;
mod quantity;
mod table;

pub use column::{Column, parse_column};
pub use dimension::{Dimension, Exponents};
pub use error::Error;
pub(crate) use error::clip;
pub use expression::Unit;
pub use format::{format_number, format_quantity};
pub(crate) use number::number_length;
pub use quantity::{
    parse_numbers, parse_plain, parse_quantity, parse_triple, parse_with_unit, unit_factor,
};
pub use table::{UNITS, UnitRow};
