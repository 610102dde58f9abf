//! Numbers from text: `f64` correctly rounded, times as whole nanoseconds where they are.
//!
//! value = m·10^e; m < 2^53 and |e| ≤ 22 needs one correctly rounded operation [Clinger1990], everything else goes to
//! the Eisel–Lemire algorithm of `fast_float2`.

use crate::Stamp;

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Value of eight ASCII digits, or `None` if one of them is none.
#[inline]
fn eight_digits(bytes: [u8; 8]) -> Option<u64> {
    let chunk = u64::from_le_bytes(bytes);
    let v = chunk.wrapping_sub(0x3030_3030_3030_3030);
    // A byte outside '0'..='9' sets its top bit in one of the two sums.
    if (chunk.wrapping_add(0x4646_4646_4646_4646) | v) & 0x8080_8080_8080_8080 != 0 {
        return None;
    }
    let v = v.wrapping_mul(10).wrapping_add(v >> 8);
    let a = (v & 0x0000_00FF_0000_00FF).wrapping_mul(0x000F_4240_0000_0064);
    let b = ((v >> 16) & 0x0000_00FF_0000_00FF).wrapping_mul(0x0000_2710_0000_0001);
    Some(a.wrapping_add(b) >> 32)
}

/// A run of digits as far as it goes: mantissa (wrapping beyond 19 digits) and where it ends.
#[inline]
fn digits(text: &[u8], mut at: usize, mut mantissa: u64) -> (u64, usize) {
    while let Some(eight) = text
        .get(at..at + 8)
        .and_then(|s| <[u8; 8]>::try_from(s).ok())
        .and_then(eight_digits)
    {
        mantissa = mantissa.wrapping_mul(100_000_000).wrapping_add(eight);
        at += 8;
    }
    while let Some(&c) = text.get(at) {
        let d = c.wrapping_sub(b'0');
        if d > 9 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    (mantissa, at)
}

/// The number at the start of `text` and its length; `None` if there is none.
///
/// Takes the grammar of Rust's `f64` with a sign, and `nan`, `inf`, `infinity` in any case.
#[inline]
pub(crate) fn parse_f64(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let start = usize::from(negative || text.first() == Some(&b'+'));
    let (mut mantissa, mut at) = digits(text, start, 0);
    let mut count = at - start;
    let mut decimals = 0;
    if text.get(at) == Some(&b'.') {
        let (m, end) = digits(text, at + 1, mantissa);
        decimals = end - at - 1;
        mantissa = m;
        count += decimals;
        at = end;
    }
    let is_plain = count != 0 && count <= 19 && mantissa <= 1 << 53 && decimals <= 22;
    if is_plain && !matches!(text.get(at), Some(b'e' | b'E')) {
        let v = mantissa as f64 / POWERS[decimals];
        return Some((if negative { -v } else { v }, at));
    }
    slow_f64(text)
}

#[cold]
#[inline(never)]
fn slow_f64(text: &[u8]) -> Option<(f64, usize)> {
    let text = text.get(..text.len().min(4096))?;
    let skip = usize::from(text.first() == Some(&b'+'));
    let (v, n) = fast_float2::parse_partial::<f64, _>(text.get(skip..)?).ok()?;
    (n != 0).then_some((v, n + skip))
}

/// The whole of `text` as a number.
pub(crate) fn whole_f64(text: &[u8]) -> Option<f64> {
    parse_f64(text).and_then(|(v, n)| (n == text.len()).then_some(v))
}

/// How a number or text in a time column becomes a stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TimeKind {
    /// In units of `multiple`·10^`exponent` seconds.
    Decimal {
        /// Power of ten.
        exponent: i32,
        /// 1, 60, 3600 or 86400.
        multiple: i64,
    },
    /// In units of so many seconds.
    Scaled(f64),
    /// ISO 8601 dates.
    Iso,
}

impl TimeKind {
    /// The kind of a unit of `factor` seconds.
    pub(crate) fn of_factor(factor: f64) -> Self {
        for (value, exponent) in [(1.0, 0), (1e-3, -3), (1e-6, -6), (1e-9, -9)] {
            for multiple in [1_i64, 60, 3600, 86400] {
                if factor == value * multiple as f64 && (exponent == 0 || multiple == 1) {
                    return Self::Decimal { exponent, multiple };
                }
            }
        }
        Self::Scaled(factor)
    }

    /// Seconds of one unit, where it is a number.
    pub(crate) fn unit_s(self) -> Option<f64> {
        match self {
            Self::Decimal { exponent, multiple } => {
                Some(multiple as f64 / POWERS[exponent.unsigned_abs() as usize % 23])
            }
            Self::Scaled(factor) => Some(factor),
            Self::Iso => None,
        }
    }

    /// Stamp of a whole number.
    pub(crate) fn of_integer(self, value: i64) -> Stamp {
        match self {
            Self::Decimal { exponent, multiple } => decimal_stamp(value, exponent, multiple)
                .unwrap_or_else(|| self.of_float(value as f64)),
            Self::Scaled(factor) => Stamp::Seconds(value as f64 * factor),
            Self::Iso => Stamp::Seconds(value as f64),
        }
    }

    /// Stamp of a number.
    pub(crate) fn of_float(self, value: f64) -> Stamp {
        match self {
            Self::Decimal { exponent, multiple } => {
                let is_whole = value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0;
                if is_whole
                    && exponent != 0
                    && let Some(stamp) = decimal_stamp(value as i64, exponent, multiple)
                {
                    return stamp;
                }
                let v = value * multiple as f64;
                Stamp::Seconds(if exponent < 0 {
                    v / POWERS[exponent.unsigned_abs() as usize % 23]
                } else {
                    v
                })
            }
            Self::Scaled(factor) => Stamp::Seconds(value * factor),
            Self::Iso => Stamp::Seconds(value),
        }
    }

    /// Stamp of the text of a cell: the whole of it has to be one.
    pub(crate) fn of_text(self, text: &[u8]) -> Option<Stamp> {
        match self {
            Self::Decimal { exponent, multiple } => {
                if let Some(stamp) = exact_decimal(text, exponent, multiple) {
                    return Some(stamp);
                }
                whole_f64(text).map(|v| self.of_float(v))
            }
            Self::Scaled(factor) => {
                if let Some(v) = std::str::from_utf8(text)
                    .ok()
                    .and_then(|t| t.parse::<i64>().ok())
                {
                    return Some(Stamp::Seconds(v as f64 * factor));
                }
                whole_f64(text).map(|v| Stamp::Seconds(v * factor))
            }
            Self::Iso => super::iso::parse(text).map(Stamp::Nanoseconds),
        }
    }
}

fn decimal_stamp(value: i64, exponent: i32, multiple: i64) -> Option<Stamp> {
    let scale = 10_i64.checked_pow(u32::try_from(9 + exponent).ok()?)?;
    value
        .checked_mul(multiple)?
        .checked_mul(scale)
        .map(Stamp::Nanoseconds)
}

/// A plain decimal that is a whole number of nanoseconds.
fn exact_decimal(text: &[u8], exponent: i32, multiple: i64) -> Option<Stamp> {
    let negative = text.first() == Some(&b'-');
    let start = usize::from(negative || text.first() == Some(&b'+'));
    let (mut mantissa, mut at) = digits(text, start, 0);
    let mut count = at - start;
    let mut decimals = 0;
    if text.get(at) == Some(&b'.') {
        let (m, end) = digits(text, at + 1, mantissa);
        decimals = end - at - 1;
        mantissa = m;
        count += decimals;
        at = end;
    }
    if at != text.len() || count == 0 || count > 19 {
        return None;
    }
    let mut shift = 9 + exponent - i32::try_from(decimals).ok()?;
    let mut value = i64::try_from(mantissa).ok()?.checked_mul(multiple)?;
    while shift < 0 {
        if value % 10 != 0 {
            return None;
        }
        value /= 10;
        shift += 1;
    }
    let ns = value.checked_mul(10_i64.checked_pow(u32::try_from(shift).ok()?)?)?;
    Some(Stamp::Nanoseconds(if negative { -ns } else { ns }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn numbers_read_as_the_standard_library_reads_them() {
        for text in [
            "0",
            "-0",
            "1",
            "1.5",
            "-2.25",
            "1e3",
            "1E-3",
            "123456789012345678",
            "0.1",
            "9007199254740993",
            ".5",
            "5.",
            "-1.7976931348623157e308",
            "4.9e-324",
            "0.30000000000000004",
            "12345678.12345678",
            "1e400",
            "+7.25",
            "00000000000000000000000000001.5",
            "3.14159265358979323846264338327950288",
        ] {
            let (v, n) = parse_f64(text.as_bytes()).unwrap();
            assert_eq!(n, text.len(), "{text}");
            assert_eq!(
                v.to_bits(),
                text.parse::<f64>().unwrap().to_bits(),
                "{text}"
            );
        }
        assert!(parse_f64(b"NaN").unwrap().0.is_nan());
        assert!(parse_f64(b"-inf").unwrap().0 == f64::NEG_INFINITY);
        for text in ["", "-", ".", "abc", "e5", ","] {
            assert!(parse_f64(text.as_bytes()).is_none(), "{text}");
        }
        assert_eq!(parse_f64(b"1.5,2").unwrap(), (1.5, 3));
    }

    #[test]
    fn times_keep_every_digit() {
        let s = TimeKind::of_factor(1.0);
        let ns = TimeKind::of_factor(1e-9);
        assert_eq!(
            ns.of_text(b"1520530308181901469"),
            Some(Stamp::Nanoseconds(1_520_530_308_181_901_469))
        );
        assert_eq!(
            s.of_text(b"1520530308.181901469"),
            Some(Stamp::Nanoseconds(1_520_530_308_181_901_469))
        );
        assert_eq!(s.of_text(b"-0.25"), Some(Stamp::Nanoseconds(-250_000_000)));
        assert_eq!(
            s.of_text(b"0.3333333333333333"),
            Some(Stamp::Seconds(0.3333333333333333))
        );
        assert_eq!(s.of_text(b"1.5e3"), Some(Stamp::Seconds(1500.0)));
        assert_eq!(
            TimeKind::of_factor(1e-6).of_text(b"12.5"),
            Some(Stamp::Nanoseconds(12_500))
        );
        assert_eq!(
            TimeKind::of_factor(60.0).of_text(b"1.5"),
            Some(Stamp::Nanoseconds(90_000_000_000))
        );
        assert_eq!(s.of_text(b"1.5x"), None);
    }
}
