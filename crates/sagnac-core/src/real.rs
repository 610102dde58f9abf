//! The two number types of the core, `f32` and `f64`, behind one trait.
//!
//! Only +, −, ·, /, comparison and the absolute value are used once a model is loaded, so
//! that a result has the same bits on every processor that follows IEEE 754. Fused
//! multiply–add is never used for the same reason. Transcendental functions come from `libm`.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A real number of the measurement model: `f32` or `f64`.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// ½.
    const HALF: Self;
    /// +∞.
    const INFINITY: Self;
    /// Not a number.
    const NAN: Self;
    /// What the rounds of the inverse are carried to: 1e-13 in `f64`, 1e-7 in `f32`.
    const ROUND_EPSILON: f64;
    /// The power of two above which every value is a whole number: 2⁵² or 2²³.
    const WHOLE: Self;

    /// The nearest value of this type.
    fn from_f64(value: f64) -> Self;
    /// This value in `f64`, exactly.
    fn to_f64(self) -> f64;
    /// |x|.
    #[must_use]
    fn abs(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// The larger of two; `other` where `self` is NaN.
    #[must_use]
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    /// `self` held between `low` and `high`; NaN stays NaN.
    #[must_use]
    #[inline(always)]
    fn held(self, low: Self, high: Self) -> Self {
        let x = if self < low { low } else { self };
        if x > high { high } else { x }
    }

    /// The nearest whole number, halves away from zero.
    ///
    /// Plain arithmetic, so that it runs in vector lanes: |x| + 2⁵² − 2⁵² rounds halves to
    /// even, and the halves that went down are put up again. Equals `libm::round` for every
    /// value (tested).
    #[must_use]
    #[inline(always)]
    fn rounded(self) -> Self {
        let size = self.abs();
        let even = (size + Self::WHOLE) - Self::WHOLE;
        let up = if size - even == Self::HALF {
            even + Self::ONE
        } else {
            even
        };
        let whole = if size < Self::WHOLE { up } else { size };
        if self < Self::ZERO { -whole } else { whole }
    }
}

macro_rules! real {
    ($type:ty, $epsilon:expr, $whole:expr) => {
        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const INFINITY: Self = <$type>::INFINITY;
            const NAN: Self = <$type>::NAN;
            const ROUND_EPSILON: f64 = $epsilon;
            const WHOLE: Self = $whole;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as Self
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$type>::abs(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$type>::is_finite(self)
            }
        }
    };
}

real!(f32, 1e-7, 8_388_608.0);
real!(f64, 1e-13, 4_503_599_627_370_496.0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_equals_the_library_function() {
        for x in [
            0.0,
            0.5,
            1.5,
            2.5,
            0.499_999_999_999_999_94,
            4_503_599_627_370_495.5,
            4_503_599_627_370_496.0,
            9.0e15,
            1e300,
            f64::INFINITY,
            1e-310,
        ] {
            assert_eq!(Real::rounded(x), libm::round(x), "{x}");
            assert_eq!(Real::rounded(-x), libm::round(-x), "-{x}");
        }
        let mut x = -20.0_f32;
        while x < 20.0 {
            assert_eq!(Real::rounded(x), libm::roundf(x), "{x}");
            x += 0.0625;
        }
        assert!(Real::rounded(f64::NAN).is_nan());
    }

    #[test]
    fn nan_passes_through_the_clamp() {
        assert!(Real::held(f64::NAN, -1.0, 1.0).is_nan());
        assert_eq!(Real::held(3.0, -1.0, 1.0), 1.0);
    }
}
