//! What the tests of refusals share: an error is folded to 80 columns, its place and its advice begin with two blanks.

/// Lines of an error that are no continuation of the one before: what, where, what to do.
pub(crate) fn sentences(said: &str) -> usize {
    said.lines()
        .filter(|line| !line.starts_with("    "))
        .count()
}

/// Text as if it had not been folded.
pub(crate) fn flat(said: &str) -> String {
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}
