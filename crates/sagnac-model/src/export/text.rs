//! Numbers and lists as the readers of yaml, Python and MATLAB take them.

use super::matrix::Matrix;
use crate::units::format_number;

/// The shortest decimal with a point and a signed exponent: YAML 1.1 reads `1e-7` as a text, `1.0e-7` as a number.
pub(crate) fn number(value: f64) -> String {
    let text = format_number(value);
    match text.split_once('e') {
        None if text.contains('.') => text,
        None => format!("{text}.0"),
        Some((mantissa, exponent)) => {
            let point = if mantissa.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{mantissa}{point}e{sign}{exponent}")
        }
    }
}

/// `[a, b, c]`.
pub(crate) fn list(values: &[f64]) -> String {
    format!(
        "[{}]",
        values
            .iter()
            .map(|value| number(*value))
            .collect::<Vec<_>>()
            .join(", ")
    )
}

/// A matrix as a block list of rows, indented.
pub(crate) fn rows(matrix: &Matrix, indent: &str) -> String {
    matrix
        .iter()
        .map(|row| format!("{indent}- {}\n", list(row)))
        .collect()
}

/// `[[…], […], […]]`.
pub(crate) fn nested(matrix: &Matrix) -> String {
    format!(
        "[{}]",
        matrix
            .iter()
            .map(|row| list(row))
            .collect::<Vec<_>>()
            .join(", ")
    )
}

/// A comment line a line of the text.
pub(crate) fn comment(mark: &str, text: &str) -> String {
    text.lines()
        .map(|line| format!("{mark} {line}\n"))
        .collect()
}
