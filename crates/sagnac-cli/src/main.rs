//! The `sagnac` command.

fn main() {}
