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

    /// Gravitation, normal and height: Bowring's tangent once, in a form without singularity at the poles.
    #[inline(always)]
    pub(super) fn at(&self, [x, y, z]: [f64; 3]) -> ([f64; 3], [f64; 3], f64) {
        let p2 = x * x + y * y;
        let inverse = 1.0 / (p2 * self.flat2 + z * z).sqrt();
        let su = z * inverse;
        let su2 = su * su;
        let num = z * (1.0 + self.ep2_b * inverse * su2);
        let den = 1.0 - self.e2_a_flat * inverse * (1.0 - su2);
        let inverse = 1.0 / (num * num + p2 * (den * den)).sqrt();
        let (k, s) = (den * inverse, num * inverse);
        let s2 = s * s;
        // 1/√(1 − e² s²) by its series: e² s² < 0.0067, seven terms leave 1e-16.
        let w = self.e2 * s2;
        let w2 = w * w;
        let inverse_root = (1.0 + 0.5 * w)
            + w2 * ((0.375 + 0.3125 * w)
                + w2 * ((35.0 / 128.0 + 63.0 / 256.0 * w) + w2 * (231.0 / 1024.0)));
        let height = p2 * k + z * s - self.a * ((1.0 - w) * inverse_root);
        let gravity = if self.sphere {
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

/// The gravitation of one position, by the kernel's own formula.
pub(in super::super) fn gravitation(field: &Field, r: [f64; 3]) -> [f64; 3] {
    field.at(r).0
}
