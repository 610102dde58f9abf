//! From a source's columns to channels in SI.

pub(crate) mod axes;
pub(crate) mod columns;
pub(crate) mod mapped;
pub(crate) mod raw;
