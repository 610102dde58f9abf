//! How wide a text is, without a font: an upper bound over the usual system fonts.
//!
//! The advance of each character is the largest among DejaVu Sans, Inter and Liberation Sans, so that a
//! label that fits by this measure fits with the reader's own font.

/// Advances of U+0020 … U+007E in hundredths of the font size.
const REGULAR: [u8; 95] = [
    32, 40, 46, 84, 64, 95, 78, 27, 39, 39, 50, 84, 32, 46, 32, 36, 64, 64, 64, 64, 64, 64, 64, 64,
    64, 64, 34, 34, 84, 84, 84, 56, 102, 68, 69, 73, 77, 67, 61, 78, 75, 29, 54, 67, 56, 89, 75,
    79, 67, 79, 72, 67, 64, 74, 68, 99, 69, 67, 69, 39, 36, 39, 84, 56, 50, 61, 63, 56, 63, 62, 36,
    63, 63, 28, 28, 58, 28, 97, 63, 61, 63, 63, 41, 52, 39, 63, 59, 82, 59, 59, 54, 64, 34, 64, 84,
];

/// The same in bold.
const BOLD: [u8; 95] = [
    35, 46, 52, 84, 70, 100, 87, 31, 46, 46, 54, 84, 38, 47, 38, 38, 70, 70, 70, 70, 70, 70, 70,
    70, 70, 70, 40, 40, 84, 84, 84, 61, 100, 77, 76, 74, 83, 68, 68, 82, 84, 37, 56, 77, 64, 100,
    84, 85, 73, 85, 77, 72, 68, 81, 77, 110, 77, 72, 73, 46, 38, 46, 84, 56, 50, 67, 72, 59, 72,
    68, 44, 72, 71, 34, 34, 67, 34, 104, 71, 69, 72, 72, 49, 60, 48, 71, 65, 92, 65, 65, 58, 71,
    37, 71, 84,
];

/// Upper bound of the width of a text in units, at this font size.
///
/// ```
/// let narrow = sagnac_report::svg::text_width("il", 12.0, false);
/// assert!(narrow < sagnac_report::svg::text_width("WM", 12.0, false));
/// ```
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let hundredths: f64 = text.chars().map(|c| advance(c, bold)).sum();
    0.01 * hundredths * size
}

fn advance(c: char, bold: bool) -> f64 {
    let code = c as usize;
    if (0x20..0x7f).contains(&code) {
        let table = if bold { &BOLD } else { &REGULAR };
        return f64::from(table[code - 0x20]);
    }
    let (regular, heavy) = match c {
        '°' => (50.0, 50.0),
        '⁰'..='⁹' | '²' | '³' | '¹' => (44.0, 46.0),
        '⁻' => (53.0, 53.0),
        '±' | '−' | '×' | '≤' | '≥' | 'ω' => (84.0, 89.0),
        '…' | '→' => (100.0, 100.0),
        'σ' | 'χ' | 'τ' | 'µ' | 'μ' | '√' => (66.0, 78.0),
        '·' | '’' | '‘' => (32.0, 38.0),
        '\u{202f}' | '\u{2009}' => (25.0, 25.0),
        '\u{a0}' => (32.0, 35.0),
        '“' | '”' | '–' => (58.0, 62.0),
        _ if code >= 0x2e80 => (102.0, 102.0),
        _ => (80.0, 90.0),
    };
    if bold { heavy } else { regular }
}
