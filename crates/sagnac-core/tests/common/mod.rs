//! What the tests share.
pub(crate) mod models;
pub(crate) mod random;
