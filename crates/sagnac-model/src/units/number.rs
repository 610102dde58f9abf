//! Numbers as text: Rust's `f64` grammar without `inf` and `nan`, `[+-] (digits [. [digits]] | . digits) [(e|E) [+-] digits]`.

use super::double_double::DoubleDouble;

/// Length in bytes of the number that `text` begins with; none if it does not begin with one.
pub(crate) fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = digits(start);
    let mut count = end - start;
    if bytes.get(end) == Some(&b'.') {
        let after = digits(end + 1);
        count += after - end - 1;
        end = after;
    }
    if count == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let after = digits(sign);
        if after > sign {
            end = after;
        }
    }
    Some(end)
}

/// A decimal split into sign, an integer of at most 19 digits and a power of ten, if it has no more digits than that.
struct Decimal {
    negative: bool,
    digits: u64,
    power: i32,
}

fn split(number: &str) -> Option<Decimal> {
    let (negative, body) = match number.as_bytes().first()? {
        b'-' => (true, &number[1..]),
        b'+' => (false, &number[1..]),
        _ => (false, number),
    };
    let (mantissa, exponent) = match body.find(['e', 'E']) {
        Some(at) => (&body[..at], body[at + 1..].parse::<i32>().ok()?),
        None => (body, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let fraction = fraction.trim_end_matches('0');
    let mut digits = 0_u64;
    for digit in whole.bytes().chain(fraction.bytes()) {
        digits = digits
            .checked_mul(10)?
            .checked_add(u64::from(digit - b'0'))?;
    }
    let power = exponent.checked_sub(i32::try_from(fraction.len()).ok()?)?;
    Some(Decimal {
        negative,
        digits,
        power,
    })
}

/// `number · factor + offset`, rounded once where the number has at most 19 digits and the product is no extreme.
///
/// `number` must be one that [`number_length`] accepts as a whole.
pub(crate) fn scaled_value(
    number: &str,
    factor: DoubleDouble,
    offset: Option<DoubleDouble>,
) -> f64 {
    let plain = number.parse::<f64>().unwrap_or(f64::NAN);
    if offset.is_none() && factor.is_one() {
        return plain;
    }
    if let Some(decimal) = split(number).filter(|decimal| decimal.power.abs() <= 250) {
        let exact = DoubleDouble::from_u64(decimal.digits)
            .mul(DoubleDouble::power_of_ten(decimal.power))
            .mul(factor);
        let size = exact.round().abs();
        if (1e-280..1e280).contains(&size) {
            let signed = if decimal.negative {
                exact.negated()
            } else {
                exact
            };
            return offset.map_or(signed, |offset| signed.plus(offset)).round();
        }
    }
    let product = plain * factor.round();
    offset.map_or(product, |offset| product + offset.round())
}

#[cfg(test)]
mod tests {
    use super::{number_length, scaled_value};
    use crate::units::double_double::DoubleDouble;

    #[test]
    fn the_grammar_is_that_of_rust() {
        let cases = [
            ("12", Some(2)),
            ("-1.5e-3 m", Some(7)),
            (".5", Some(2)),
            ("5.", Some(2)),
            ("5.m", Some(2)),
            ("1e", Some(1)),
            ("1e+", Some(1)),
            ("2E5", Some(3)),
            (".", None),
            ("-", None),
            ("inf", None),
            ("nan", None),
            ("e5", None),
            ("", None),
        ];
        for (text, length) in cases {
            assert_eq!(number_length(text), length, "{text}");
            if let Some(length) = length {
                assert!(text[..length].parse::<f64>().is_ok(), "{text}");
            }
        }
    }

    #[test]
    fn a_product_is_rounded_once() {
        // 0.1 · 3 is 0.3, though the product of the two f64 is 0.30000000000000004.
        assert_eq!(scaled_value("0.1", DoubleDouble::from_u64(3), None), 0.3);
        assert_eq!(
            scaled_value("-0", DoubleDouble::from_u64(3), None).to_bits(),
            (-0.0_f64).to_bits()
        );
    }
}
