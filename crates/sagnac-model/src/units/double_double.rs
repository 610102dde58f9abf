//! Pairs of `f64` that carry about 32 digits: unit factors and decimals are multiplied in them and rounded once.
//!
//! x = hi + lo, |lo| ≤ ½ ulp(hi). Sums and products are error-free transformations [DEKKER71].
//! With one rounding every `f64` in SI has a decimal of at most 17 digits in every unit that reads back to it;
//! with a product of two rounded factors some would have none.

/// An unevaluated sum of two `f64`, the smaller below half a unit in the last place of the larger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    pub(crate) const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// From two parts that do not overlap.
    pub(crate) const fn new(hi: f64, lo: f64) -> Self {
        Self { hi, lo }
    }

    /// Exact for every integer below 2⁶⁴.
    pub(crate) fn from_u64(value: u64) -> Self {
        // The upper and lower 32 bits are exact in f64, and so is their error-free sum.
        let high = (value >> 32) as f64 * 4_294_967_296.0;
        let low = (value & 0xffff_ffff) as f64;
        Self::from_sum(high, low)
    }

    fn from_sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let part = hi - a;
        let lo = (a - (hi - part)) + (b - part);
        Self { hi, lo }
    }

    /// The nearest `f64`.
    pub(crate) fn round(self) -> f64 {
        self.hi + self.lo
    }

    /// Whether the value is exactly one.
    pub(crate) fn is_one(self) -> bool {
        self.hi == 1.0 && self.lo == 0.0
    }

    /// Whether the value is finite and above zero.
    pub(crate) fn is_positive(self) -> bool {
        self.hi.is_finite() && self.hi > 0.0
    }

    pub(crate) fn mul(self, other: Self) -> Self {
        let hi = self.hi * other.hi;
        let error = self.hi.mul_add(other.hi, -hi);
        let lo = error + (self.hi * other.lo + self.lo * other.hi);
        Self::quick_sum(hi, lo)
    }

    pub(crate) fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self.sub(other.mul(Self::new(first, 0.0)));
        let second = rest.hi / other.hi;
        let rest = rest.sub(other.mul(Self::new(second, 0.0)));
        let third = rest.hi / other.hi;
        let sum = Self::quick_sum(first, second);
        Self::quick_sum(sum.hi, sum.lo + third)
    }

    pub(crate) fn negated(self) -> Self {
        Self::new(-self.hi, -self.lo)
    }

    fn sub(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        let high = Self::from_sum(self.hi, other.hi);
        let low = Self::from_sum(self.lo, other.lo);
        let part = Self::quick_sum(high.hi, high.lo + low.hi);
        Self::quick_sum(part.hi, part.lo + low.lo)
    }

    fn quick_sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        Self {
            hi,
            lo: b - (hi - a),
        }
    }

    /// √x of a positive x: one Newton step on the `f64` root.
    pub(crate) fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        let rest = self.sub(Self::new(root, 0.0).mul(Self::new(root, 0.0)));
        Self::quick_sum(root, rest.hi / (2.0 * root))
    }

    /// xⁿ by repeated squaring.
    pub(crate) fn powi(self, power: i32) -> Self {
        let mut result = Self::ONE;
        let mut square = self;
        let mut left = power.unsigned_abs();
        while left > 0 {
            if left & 1 == 1 {
                result = result.mul(square);
            }
            left >>= 1;
            if left > 0 {
                square = square.mul(square);
            }
        }
        if power < 0 {
            Self::ONE.div(result)
        } else {
            result
        }
    }

    /// 10ⁿ.
    pub(crate) fn power_of_ten(power: i32) -> Self {
        Self::new(10.0, 0.0).powi(power)
    }

    /// The nearest integer of a value below 2⁶³, from 0 upwards.
    pub(crate) fn round_to_u64(self) -> u64 {
        // Above 2⁵³ hi is an integer, and lo holds the rest.
        let whole = self.hi.floor();
        let rest = (self.hi - whole) + self.lo;
        let rounded = rest.round() as i64;
        (whole as u64).saturating_add_signed(rounded)
    }
}

#[cfg(test)]
mod tests {
    use super::DoubleDouble;

    #[test]
    fn powers_of_ten_are_right_to_thirty_digits() {
        // The f64 nearest to 10²³ is 8388608 below it.
        let ten23 = DoubleDouble::power_of_ten(23);
        assert_eq!(ten23.hi, 1e23);
        assert_eq!(ten23.lo, 8_388_608.0);
    }

    #[test]
    fn square_root_and_division_invert() {
        let three = DoubleDouble::from_u64(3);
        let root = three.sqrt();
        let back = root.mul(root);
        assert!(
            (back.hi - 3.0).abs() < 1e-30 && back.lo.abs() < 1e-30,
            "{back:?}"
        );
        let third = DoubleDouble::ONE.div(three);
        let one = third.mul(three);
        assert!((one.hi - 1.0).abs() + one.lo.abs() < 1e-31, "{one:?}");
    }

    #[test]
    fn integers_come_back() {
        for value in [0_u64, 1, (1 << 53) + 1, 9_999_999_999_999_999, 1 << 62] {
            assert_eq!(DoubleDouble::from_u64(value).round_to_u64(), value);
        }
    }
}
