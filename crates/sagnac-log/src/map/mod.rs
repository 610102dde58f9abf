//! From a source's columns to channels in SI.

pub(crate) mod axes;
mod choose;
pub(crate) mod columns;
pub(crate) mod hints;
pub(crate) mod mapped;
pub(crate) mod raw;
