//! Numbers as text: the digits rule for values with intervals, significant digits, thousands.
//!
//! The half width of a 95 % interval is shown with two digits where it starts below 3.5, else with
//! one; the value, and both ends of a range, end at the same decimal place.

use core::fmt;

/// An estimate as it is shown, in the unit that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Estimate {
    /// A value with its 95 % interval.
    Detected {
        /// The value.
        value: f64,
        /// Lower end of the 95 % interval.
        lower: f64,
        /// Upper end of the 95 % interval.
        upper: f64,
    },
    /// A value whose interval is not known.
    Value(f64),
    /// Looked for and not seen: the 95 % upper limit.
    UpperLimit(f64),
    /// Nothing to say.
    #[default]
    Absent,
}

impl Estimate {
    /// A value with the ends of its 95 % interval.
    pub const fn detected(value: f64, lower: f64, upper: f64) -> Self {
        Self::Detected {
            value,
            lower,
            upper,
        }
    }

    /// A value with a symmetric interval, `value ± half`.
    pub fn plus_minus(value: f64, half: f64) -> Self {
        Self::detected(value, value - half, value + half)
    }

    /// A 95 % upper limit.
    pub const fn upper_limit(upper: f64) -> Self {
        Self::UpperLimit(upper)
    }

    /// The same estimate in another unit: every number times a positive factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Detected {
                value,
                lower,
                upper,
            } => Self::detected(value * factor, lower * factor, upper * factor),
            Self::Value(value) => Self::Value(value * factor),
            Self::UpperLimit(upper) => Self::UpperLimit(upper * factor),
            Self::Absent => Self::Absent,
        }
    }

    /// The estimate in words and figures.
    pub fn text(self) -> EstimateText {
        match self {
            Self::Detected {
                value,
                lower,
                upper,
            } => estimate(value, lower, upper),
            Self::Value(value) => EstimateText {
                value: significant(value, 4),
                interval: String::new(),
            },
            Self::UpperLimit(upper) => EstimateText {
                value: limit(upper),
                interval: String::new(),
            },
            Self::Absent => EstimateText {
                value: "-".to_owned(),
                interval: String::new(),
            },
        }
    }

    /// Name of the status as scripts know it: `detected`, `upper_limit` or `absent`.
    pub fn status(self) -> &'static str {
        match self {
            Self::Detected { .. } | Self::Value(_) => "detected",
            Self::UpperLimit(_) => "upper_limit",
            Self::Absent => "absent",
        }
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text().fmt(f)
    }
}

/// An estimate as two texts, to be aligned on the `±`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EstimateText {
    /// `0.2473`, `< 310` or `-`.
    pub value: String,
    /// `± 0.0017`, `12 … 32` or nothing.
    pub interval: String,
}

impl fmt::Display for EstimateText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.interval.is_empty() {
            f.write_str(&self.value)
        } else if self.interval.starts_with('±') {
            write!(f, "{} {}", self.value, self.interval)
        } else {
            write!(f, "{}  {}", self.value, self.interval)
        }
    }
}

/// The text of a value with its 95 % interval.
///
/// `value ± half` where the longer side is at most 1.3 times the shorter, else `value  lower … upper`.
/// An interval that is not finite or has no width leaves the value alone, with four digits; a value that
/// is not finite gives `-`.
///
/// ```
/// use sagnac_report::text::estimate;
/// assert_eq!(estimate(0.24731, 0.2456, 0.2490).to_string(), "0.2473 ± 0.0017");
/// assert_eq!(estimate(24.2, 11.8, 31.9).to_string(), "24  12 … 32");
/// ```
pub fn estimate(value: f64, lower: f64, upper: f64) -> EstimateText {
    if !value.is_finite() {
        return EstimateText {
            value: "-".to_owned(),
            interval: String::new(),
        };
    }
    let half = 0.5 * (upper - lower);
    if !half.is_finite() || half <= 0.0 {
        return EstimateText {
            value: significant(value, 4),
            interval: String::new(),
        };
    }
    let place = place_of(half);
    let (above, below) = (upper - value, value - lower);
    let longer = above.max(below);
    let shorter = above.min(below);
    let scientific = !(-7..=6).contains(&place);
    let show = |x: f64| {
        if scientific {
            scientific_at(x, place)
        } else {
            at_place(x, place)
        }
    };
    let interval = if shorter > 0.0 && longer <= 1.3 * shorter {
        format!("± {}", show(half))
    } else {
        format!("{} … {}", show(lower), show(upper))
    };
    EstimateText {
        value: show(value),
        interval,
    }
}

/// The text of a 95 % upper limit, `< 310`: two digits.
///
/// ```
/// assert_eq!(sagnac_report::text::limit(312.4), "< 310");
/// ```
pub fn limit(upper: f64) -> String {
    if upper.is_finite() {
        format!("< {}", significant(upper, 2))
    } else {
        "-".to_owned()
    }
}

/// Decimal place of the last digit that a half width shows, as a power of ten.
fn place_of(half: f64) -> i32 {
    let exponent = half.log10().floor() as i32;
    let mantissa = half / 10f64.powi(exponent);
    // Rounding first: 3.46 shows as 3.5, but still with two digits.
    if mantissa < 3.5 {
        exponent - 1
    } else {
        exponent
    }
}

/// Number of decimals that the digits rule gives to a value with this half width.
///
/// ```
/// assert_eq!(sagnac_report::text::decimals_of(0.0017), 4);
/// assert_eq!(sagnac_report::text::decimals_of(8.0), 0);
/// ```
pub fn decimals_of(half: f64) -> usize {
    if half.is_finite() && half > 0.0 {
        usize::try_from(-place_of(half)).unwrap_or(0)
    } else {
        0
    }
}

fn at_place(x: f64, place: i32) -> String {
    if place < 0 {
        fixed(x, usize::try_from(-place).unwrap_or(0))
    } else {
        let step = 10f64.powi(place);
        fixed((x / step).round() * step, 0)
    }
}

fn scientific_at(x: f64, place: i32) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let exponent = x.abs().log10().floor() as i32;
    let digits = usize::try_from(exponent - place).unwrap_or(0);
    format!("{x:.digits$e}")
}

/// The number with a fixed number of decimals, thousands parted by a space from five digits on.
///
/// Minus is the ASCII hyphen; what rounds to zero has no sign.
///
/// ```
/// assert_eq!(sagnac_report::text::fixed(-12345.678, 1), "-12 345.7");
/// assert_eq!(sagnac_report::text::fixed(-0.001, 2), "0.00");
/// ```
pub fn fixed(x: f64, decimals: usize) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    let text = format!("{x:.decimals$}");
    let text = match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        _ => text,
    };
    group_thousands(&text)
}

/// The number with `digits` significant digits, trailing zeros kept.
///
/// From 1e7 on and below 1e-5 in powers of ten.
///
/// ```
/// use sagnac_report::text::significant;
/// assert_eq!(significant(1145.3, 4), "1145");
/// assert_eq!(significant(48.851, 4), "48.85");
/// assert_eq!(significant(123456.0, 3), "123 000");
/// assert_eq!(significant(1.5e-9, 2), "1.5e-9");
/// ```
pub fn significant(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.max(1);
    // The exponent after rounding: 9.996 with three digits is 10.0.
    let rounded = format!("{x:.*e}", digits - 1);
    let exponent: i32 = rounded
        .split_once('e')
        .and_then(|(_, e)| e.parse().ok())
        .unwrap_or(0);
    if !(-5..7).contains(&exponent) {
        return rounded;
    }
    let place = exponent - (digits as i32 - 1);
    at_place(x, place)
}

/// The number with at most `digits` significant digits, trailing zeros dropped.
///
/// ```
/// use sagnac_report::text::general;
/// assert_eq!(general(0.1, 4), "0.1");
/// assert_eq!(general(10000.0, 4), "10 000");
/// ```
pub fn general(x: f64, digits: usize) -> String {
    let text = significant(x, digits);
    if let Some((mantissa, exponent)) = text.split_once('e') {
        return format!("{}e{exponent}", drop_zeros(mantissa));
    }
    drop_zeros(&text).to_owned()
}

fn drop_zeros(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}

/// A share as percent: `75.2 %`, `< 0.1 %`, `0 %`.
///
/// ```
/// assert_eq!(sagnac_report::text::percent(0.752), "75.2 %");
/// assert_eq!(sagnac_report::text::percent(0.0004), "< 0.1 %");
/// ```
pub fn percent(share: f64) -> String {
    if !share.is_finite() {
        "-".to_owned()
    } else if share == 0.0 {
        "0 %".to_owned()
    } else if share.abs() < 0.0005 {
        "< 0.1 %".to_owned()
    } else {
        format!("{} %", fixed(100.0 * share, 1))
    }
}

/// The same for every whole number of a sentence that stands as a word of its own.
///
/// ```
/// let text = sagnac_report::text::group_numbers("one value for 20000 samples; left out");
/// assert_eq!(text, "one value for 20 000 samples; left out");
/// ```
pub fn group_numbers(text: &str) -> String {
    let words: Vec<String> = text
        .split(' ')
        .map(|word| {
            if word.bytes().all(|b| b.is_ascii_digit()) {
                group_thousands(word)
            } else {
                word.to_owned()
            }
        })
        .collect();
    words.join(" ")
}

/// Parts the digits before the decimal point by spaces in threes, from five digits on.
///
/// ```
/// assert_eq!(sagnac_report::text::group_thousands("10000"), "10 000");
/// assert_eq!(sagnac_report::text::group_thousands("-1017.9"), "-1017.9");
/// ```
pub fn group_thousands(text: &str) -> String {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", text),
    };
    let end = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    let (whole, tail) = rest.split_at(end);
    if whole.len() < 5 {
        return text.to_owned();
    }
    let mut out = String::from(sign);
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i) % 3 == 0 {
            out.push(' ');
        }
        out.push(digit);
    }
    out.push_str(tail);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: f64, half: f64) -> String {
        Estimate::plus_minus(value, half).to_string()
    }

    #[test]
    fn digits_rule() {
        assert_eq!(shown(2.41393, 0.0211), "2.414 ± 0.021");
        assert_eq!(shown(36.2, 8.1), "36 ± 8");
        assert_eq!(shown(152.0, 131.0), "150 ± 130");
        assert_eq!(shown(150.0, 90.0), "150 ± 90");
        assert_eq!(shown(-1017.92, 2.9), "-1017.9 ± 2.9");
        assert_eq!(shown(-1571.0, 240.0), "-1570 ± 240");
        assert_eq!(shown(1.000713, 0.00003), "1.000713 ± 0.000030");
        assert_eq!(shown(3.12, 0.96), "3.1 ± 1.0");
        assert_eq!(shown(2.0, 0.352), "2.0 ± 0.4");
        assert_eq!(shown(2.0, 0.348), "2.00 ± 0.35");
        assert_eq!(shown(1234567.0, 21000.0), "1 235 000 ± 21 000");
    }

    #[test]
    fn ranges_where_one_side_is_longer() {
        assert_eq!(estimate(26.0, 17.2, 32.1).to_string(), "26  17 … 32");
        assert_eq!(estimate(0.0, 0.0, 0.5).to_string(), "0.00  0.00 … 0.50");
    }

    #[test]
    fn odd_numbers_never_panic() {
        for x in [
            f64::NAN,
            f64::INFINITY,
            -0.0,
            1e-300,
            1e300,
            f64::MIN_POSITIVE,
        ] {
            for h in [f64::NAN, 0.0, 1e-300, 1.0, 1e300] {
                let _ = shown(x, h);
            }
            let _ = (limit(x), significant(x, 3), general(x, 3), percent(x));
        }
        assert_eq!(estimate(f64::NAN, 0.0, 1.0).to_string(), "-");
        assert_eq!(
            estimate(1.5e-9, 1.3e-9, 1.7e-9).to_string(),
            "1.50e-9 ± 2.0e-10"
        );
    }

    #[test]
    fn general_drops_zeros() {
        assert_eq!(general(100.0, 4), "100");
        assert_eq!(general(0.05, 4), "0.05");
        assert_eq!(general(2.5e-8, 4), "2.5e-8");
        assert_eq!(significant(9.996, 3), "10.0");
        assert_eq!(significant(99995.0, 4), "100 000");
    }
}
