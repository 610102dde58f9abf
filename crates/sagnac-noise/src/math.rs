//! Functions that would cancel where they are used, written so that they do not.
//!
//! E(x) = (x − 1 + e^−x)/x², A(x) = (1 − e^−x)/x, D(x) = (2x − 3 + 4e^−x − e^−2x)/x² and the
//! Hurwitz zeta function ζ(3, q) by the Euler–Maclaurin sum (`[DLMF]` 25.11).

use core::f64::consts::PI;
use core::ops::{Add, Mul, Sub};

/// From here on x² may be no finite number, and only the leading term is left.
const BEYOND_SQUARES: f64 = 1e150;

/// `(1 − e^−x)/x`, 1 at x = 0.
pub(crate) fn mean_decay(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x }
}

/// `(x − 1 + e^−x)/x²`, ½ at x = 0.
pub(crate) fn mean_of_mean_decay(x: f64) -> f64 {
    if x < 0.5 {
        // Σ_{k≥2} (−x)^k/k! / x²
        let mut term = 0.5;
        let mut sum = 0.0;
        for k in 3..20 {
            sum += term;
            term *= -x / f64::from(k);
        }
        sum
    } else if x > BEYOND_SQUARES {
        1.0 / x
    } else {
        (x + libm::expm1(-x)) / (x * x)
    }
}

/// `(2x − 3 + 4e^−x − e^−2x)/x²`: variance of a Gauss–Markov process' Allan differences, and of
/// an interval mean whose start value is known; ⅔x for small x.
pub(crate) fn bridged_variance(x: f64) -> f64 {
    if x < 0.5 {
        // Σ_{k≥3} (−1)^k x^(k−2) (4 − 2^k)/k!
        let mut power = -x / 6.0;
        let mut two = 8.0;
        let mut sum = 0.0;
        for k in 4..26 {
            sum += power * (4.0 - two);
            power *= -x / f64::from(k);
            two *= 2.0;
        }
        sum
    } else if x > BEYOND_SQUARES {
        2.0 / x
    } else {
        let one_step = libm::exp(-x);
        (2.0 * x - 3.0 + one_step * (4.0 - one_step)) / (x * x)
    }
}

/// `sin(πx)/(πx)`, 1 at x = 0.
pub(crate) fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        libm::sin(PI * x) / (PI * x)
    }
}

/// `sin²(πx)`, exact zeros at the integers.
pub(crate) fn sin2_pi(x: f64) -> f64 {
    let s = libm::sin(PI * (x - libm::round(x)));
    s * s
}

/// Hurwitz zeta ζ(3, q) = Σ_{j≥0} (q + j)⁻³ for q > 0, relative error below 1e-14.
pub(crate) fn hurwitz_zeta_3(q: f64) -> f64 {
    let mut sum = 0.0;
    let mut x = q;
    while x < 12.0 {
        sum += 1.0 / (x * x * x);
        x += 1.0;
    }
    let i = 1.0 / x;
    let i2 = i * i;
    // ∫ + half + Bernoulli numbers B₂…B₁₀ against the odd derivatives of x⁻³.
    let tail = i2
        * (0.5
            + i * (0.5
                + i * (0.25
                    + i2 * (-1.0 / 12.0
                        + i2 * (1.0 / 12.0 + i2 * (-3.0 / 20.0 + i2 * (5.0 / 12.0)))))));
    sum + tail
}

/// The few operations on complex numbers that the resonance needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Complex {
    pub(crate) re: f64,
    pub(crate) im: f64,
}

impl Complex {
    pub(crate) const ONE: Self = Self { re: 1.0, im: 0.0 };

    pub(crate) fn scale(self, factor: f64) -> Self {
        Self {
            re: self.re * factor,
            im: self.im * factor,
        }
    }

    pub(crate) fn recip(self) -> Self {
        let norm = self.re * self.re + self.im * self.im;
        Self {
            re: self.re / norm,
            im: -self.im / norm,
        }
    }

    pub(crate) fn exp(self) -> Self {
        let size = libm::exp(self.re);
        Self {
            re: size * libm::cos(self.im),
            im: size * libm::sin(self.im),
        }
    }

    pub(crate) fn abs(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Complex [`mean_of_mean_decay`].
    pub(crate) fn mean_of_mean_decay(self) -> Self {
        if self.abs() < 0.5 {
            let mut term = Self { re: 0.5, im: 0.0 };
            let mut sum = Self { re: 0.0, im: 0.0 };
            for k in 3..20 {
                sum = sum + term;
                term = term * self.scale(-1.0 / f64::from(k));
            }
            sum
        } else {
            (self - Self::ONE + self.scale(-1.0).exp()) * (self * self).recip()
        }
    }

    /// Complex [`mean_decay`].
    pub(crate) fn mean_decay(self) -> Self {
        if self.abs() < 0.5 {
            let mut term = Self::ONE;
            let mut sum = Self { re: 0.0, im: 0.0 };
            for k in 2..20 {
                sum = sum + term;
                term = term * self.scale(-1.0 / f64::from(k));
            }
            sum
        } else {
            (Self::ONE - self.scale(-1.0).exp()) * self.recip()
        }
    }

    /// Complex [`bridged_variance`].
    pub(crate) fn bridged_variance(self) -> Self {
        if self.abs() < 0.5 {
            let mut power = self.scale(-1.0 / 6.0);
            let mut two = 8.0;
            let mut sum = Self { re: 0.0, im: 0.0 };
            for k in 4..26 {
                sum = sum + power.scale(4.0 - two);
                power = power * self.scale(-1.0 / f64::from(k));
                two *= 2.0;
            }
            sum
        } else {
            let e = self.scale(-1.0).exp();
            (self.scale(2.0) - Self { re: 3.0, im: 0.0 } + e * (Self { re: 4.0, im: 0.0 } - e))
                * (self * self).recip()
        }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: f64, want: f64, relative: f64) {
        assert!(
            (got - want).abs() <= relative * want.abs(),
            "got {got:e}, want {want:e}"
        );
    }

    #[test]
    fn series_and_closed_form_meet_where_they_join() {
        // At x = 0.5 the closed forms have lost two digits at most.
        for x in [0.49999, 0.50001] {
            let e = libm::exp(-x);
            close(mean_of_mean_decay(x), (x - 1.0 + e) / (x * x), 1e-14);
            close(
                bridged_variance(x),
                (2.0 * x - 3.0 + 4.0 * e - e * e) / (x * x),
                1e-13,
            );
            let z = Complex { re: x, im: 0.0 };
            close(z.mean_decay().re, mean_decay(x), 1e-14);
            close(z.mean_of_mean_decay().re, mean_of_mean_decay(x), 1e-14);
            close(z.bridged_variance().re, bridged_variance(x), 1e-13);
        }
        close(bridged_variance(1e-9), 2e-9 / 3.0, 1e-8);
    }

    #[test]
    fn hurwitz_zeta_at_one_and_a_half() {
        // ζ(3) and ζ(3, ½) = 7 ζ(3).
        let apery = 1.202_056_903_159_594_3;
        close(hurwitz_zeta_3(1.0), apery, 1e-14);
        close(hurwitz_zeta_3(0.5), 7.0 * apery, 1e-14);
    }
}
