//! Gravitation, normal and height of a position, without a branch, so that many positions are one vector loop.

#![allow(
    clippy::inline_always,
    reason = "the lanes become vector code only where the body is inlined into their loop"
)]

use crate::earth::{Earth, WGS84_F};

/// Constants of the Earth, so that the ellipsoid and the sphere are the same arithmetic.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Field {
    a: f64,
    e2: f64,
    flat2: f64,
    ep2_b: f64,
    e2_a_flat: f64,
    pub(super) rate: f64,
    sphere: bool,
}

impl Field {
    pub(in super::super) fn new(earth: Earth) -> Self {
        let (a, e2) = (earth.semi_major_m(), earth.eccentricity_sq());
        let flat = (1.0 - e2).sqrt();
        Self {
            a,
            e2,
            flat2: flat * flat,
            ep2_b: e2 / (1.0 - e2) * a * flat,
            e2_a_flat: e2 * a * flat,
            rate: earth.rate_rad_s(),
            sphere: earth == Earth::Sphere,
        }
    }

    /// Whether `SPHERE` of [`Field::at`] holds.
    pub(super) fn is_sphere(&self) -> bool {
        self.sphere
    }

    /// Gravitation, normal and height.
    #[inline(always)]
    fn at<const SPHERE: bool>(&self, place: [f64; 3]) -> ([f64; 3], [f64; 3], f64) {
        let slope = self.slope(place);
        self.pull::<SPHERE>(place, Self::direction(place, slope))
    }

    /// Tangent of the latitude as numerator over p times the denominator: Bowring's formula once, in a form without
    /// singularity at the poles.
    #[inline(always)]
    pub(super) fn slope(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let p2 = x * x + y * y;
        let inverse = inverse_root(p2 * self.flat2 + z * z);
        let su = z * inverse;
        let su2 = su * su;
        [
            z * (1.0 + self.ep2_b * inverse * su2),
            1.0 - self.e2_a_flat * inverse * (1.0 - su2),
        ]
    }

    /// Cosine of the latitude over p, and sine.
    #[inline(always)]
    pub(super) fn direction([x, y, _]: [f64; 3], [num, den]: [f64; 2]) -> [f64; 2] {
        let inverse = inverse_root(num * num + (x * x + y * y) * (den * den));
        [den * inverse, num * inverse]
    }

    /// Gravitation, normal and height in a direction.
    #[inline(always)]
    pub(super) fn pull<const SPHERE: bool>(
        &self,
        [x, y, z]: [f64; 3],
        [k, s]: [f64; 2],
    ) -> ([f64; 3], [f64; 3], f64) {
        let s2 = s * s;
        // 1/√(1 − e² s²) by its series: e² s² < 0.0067, seven terms leave 1e-16.
        let w = self.e2 * s2;
        let w2 = w * w;
        let inverse_root = (1.0 + 0.5 * w)
            + w2 * ((0.375 + 0.3125 * w)
                + w2 * ((35.0 / 128.0 + 63.0 / 256.0 * w) + w2 * (231.0 / 1024.0)));
        let height = (x * x + y * y) * k + z * s - self.a * ((1.0 - w) * inverse_root);
        let gravity = if SPHERE {
            let ratio = self.a / (self.a + height);
            9.806_65 * ratio * ratio
        } else {
            const M: f64 = 0.003_449_786_506_84;
            let h = height * (1.0 / crate::earth::WGS84_A_M);
            (9.780_325_335_9 + (9.780_325_335_9 * 0.001_931_852_652_41) * s2)
                * inverse_root
                * (1.0 + h * ((4.0 * WGS84_F * s2 - 2.0 * (1.0 + WGS84_F + M)) + 3.0 * h))
        };
        let across = -gravity * k - self.rate * self.rate;
        (
            [x * across, y * across, -gravity * s],
            [x * k, y * k, s],
            height,
        )
    }
}

/// 1/√x of a squared distance in m², to the last bit but one: the root of single precision and two of Newton's steps,
/// y ← y (3 − x y²)/2, which square its error of 2⁻²⁴ twice. Root and quotient of double precision would keep the one
/// divider of the processor busy for longer than all the rest of the field takes.
#[inline(always)]
#[allow(clippy::cast_possible_truncation, reason = "a first estimate")]
fn inverse_root(x: f64) -> f64 {
    let half = 0.5 * x;
    let mut y = f64::from(1.0 / (x as f32).sqrt());
    for _ in 0..2 {
        y = y * (1.5 - half * y * y);
    }
    y
}

/// The gravitation of one position, by the kernel's own formula.
pub(in super::super) fn gravitation(field: &Field, r: [f64; 3]) -> [f64; 3] {
    if field.sphere {
        field.at::<true>(r).0
    } else {
        field.at::<false>(r).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_roots_are_exact_to_two_ulps() {
        for i in 0..20_000 {
            // Distances from 1 m to 1e15 m.
            let x = 10f64.powf(f64::from(i) * 0.0015);
            let (got, want) = (inverse_root(x), 1.0 / x.sqrt());
            assert!(
                (got / want - 1.0).abs() <= 2.0 * f64::EPSILON,
                "{x:e}: {got:e} {want:e}"
            );
        }
    }
}
