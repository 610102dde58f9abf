//! One strapdown step in inertial axes, several runs in vector lanes. Rate and specific force are one element A = (ω, f)
//! of se(3), [A, B] = (ω_A×ω_B, ω_A×f_B − ω_B×f_A); Magnus' series of its polynomial A₀ + A₁u + A₂u² …,
//! (φ, ρ) = ∫A + coning and sculling + [A₀,[A₀,A₂]]/360 − [A₁,[A₀,A₁]]/240 − …, gives the rotation vector φ and the velocity
//! change Δv = ρ + (1 − cos φ)/φ² φ×ρ + (φ − sin φ)/φ³ φ×(φ×ρ) [BLANES] [SAVAGE].
//!
//! Inertial axes need no Coriolis or transport terms; the field is symmetric about z, so gravitation is a function of the
//! inertial position alone. The loop over lanes is straight-line arithmetic that the compiler turns into vectors; nothing
//! is contracted, so every instruction set gives the same bits.

#![allow(
    clippy::inline_always,
    reason = "the lanes become vector code only where the body is inlined into their loop"
)]

use super::weights::Weights;
use crate::earth::{Earth, WGS84_F};

/// Positions, velocities and attitudes of `L` runs, inertial axes.
#[derive(Debug, Clone)]
pub struct Lanes<const L: usize> {
    /// Body → inertial quaternion, scalar first.
    pub q: [[f64; L]; 4],
    /// Velocity, m/s.
    pub v: [[f64; L]; 3],
    /// Position, m.
    pub r: [[f64; L]; 3],
    /// Gravitation at `r`, m/s².
    pub gravitation: [[f64; L]; 3],
    /// Integral of the barometric loop, m/s².
    pub baro: [[f64; L]; 1],
    /// What the quaternion's additions have rounded off so far: at rest the same rounding would else come back at every
    /// step and add up.
    pub q_rest: [[f64; L]; 4],
}

/// What the vertical channel is held to after a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    /// Parts of the height and climb errors that are removed after each step.
    pub(super) height_gain: f64,
    pub(super) climb_gain: f64,
    /// Barometric loop: velocity per height error, per step; integral per height error, per step.
    pub(super) velocity_per_height: f64,
    pub(super) integral_per_height: f64,
    pub(super) dt_s: f64,
    pub(super) height_m: f64,
    pub(super) climb_m_s: f64,
}

/// Constants of the Earth, so that the ellipsoid and the sphere are the same arithmetic.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    a: f64,
    e2: f64,
    flat: f64,
    ep2_b: f64,
    e2_a_flat: f64,
    rate: f64,
    sphere: bool,
}

impl Field {
    pub(super) fn new(earth: Earth) -> Self {
        let (a, e2) = (earth.semi_major_m(), earth.eccentricity_sq());
        let flat = (1.0 - e2).sqrt();
        Self {
            a,
            e2,
            flat,
            ep2_b: e2 / (1.0 - e2) * a * flat,
            e2_a_flat: e2 * a * flat,
            rate: earth.rate_rad_s(),
            sphere: earth == Earth::Sphere,
        }
    }

    /// Gravitation, normal and height: Bowring's tangent once, in a form without singularity at the poles.
    #[inline(always)]
    fn at(&self, x: f64, y: f64, z: f64) -> ([f64; 3], [f64; 3], f64) {
        let p2 = x * x + y * y;
        let inverse = 1.0 / (p2 * self.flat * self.flat + z * z).sqrt();
        let su = z * inverse;
        let cu2 = p2 * self.flat * self.flat * inverse * inverse;
        let num = z * (1.0 + self.ep2_b * inverse * su * su);
        let den = 1.0 - self.e2_a_flat * inverse * cu2;
        let inverse = 1.0 / (num * num + p2 * den * den).sqrt();
        let (k, s) = (den * inverse, num * inverse);
        let s2 = s * s;
        // √(1 − e² s²) and its inverse by their series: e² s² < 0.0067, seven terms leave 1e-17.
        let w = self.e2 * s2;
        let root = 1.0
            - w * (0.5
                + w * (0.125
                    + w * (0.0625 + w * (5.0 / 128.0 + w * (7.0 / 256.0 + w * (21.0 / 1024.0))))));
        let inverse_root = 1.0
            + w * (0.5
                + w * (0.375
                    + w * (0.3125
                        + w * (35.0 / 128.0 + w * (63.0 / 256.0 + w * (231.0 / 1024.0))))));
        let height = p2 * k + z * s - self.a * root;
        let gravity = if self.sphere {
            let ratio = self.a / (self.a + height);
            9.806_65 * ratio * ratio
        } else {
            let h = height * (1.0 / crate::earth::WGS84_A_M);
            9.780_325_335_9
                * (1.0 + 0.001_931_852_652_41 * s2)
                * inverse_root
                * (1.0 - 2.0 * (1.0 + WGS84_F + 0.003_449_786_506_84 - 2.0 * WGS84_F * s2) * h
                    + 3.0 * h * h)
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
pub(super) fn gravitation(field: &Field, r: [f64; 3]) -> [f64; 3] {
    field.at(r[0], r[1], r[2]).0
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// [A, B] = (ω_A×ω_B, ω_A×f_B − ω_B×f_A).
#[inline(always)]
fn bracket(wa: [f64; 3], fa: [f64; 3], wb: [f64; 3], fb: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    (cross(wa, wb), add(cross(wa, fb), cross(fa, wb)))
}

/// Advances every lane over one interval. `window` is oldest first; `place` is the interval's sample in it.
#[inline(always)]
pub(super) fn advance<const L: usize, const CENTRED: bool>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    window: [&[[f64; L]; 6]; 5],
    place: usize,
    dt: f64,
    hold: &Hold,
) {
    let here = window[place];
    for l in 0..L {
        let (mut a0, mut a1, mut a2, mut a3) = ([0.0; 6], [0.0; 6], [0.0; 6], [0.0; 6]);
        let (mut e1, mut e3, mut mean) = ([0.0; 6], [0.0; 6], [0.0; 6]);
        for c in 0..6 {
            mean[c] = here[c][l];
            let m = [
                window[0][c][l],
                window[1][c][l],
                window[2][c][l],
                window[3][c][l],
                window[4][c][l],
            ];
            if CENTRED {
                let (s1, s2, d1, d2) = (m[3] + m[1], m[4] + m[0], m[3] - m[1], m[4] - m[0]);
                a0[c] = weights.a0[2] * m[2] + weights.a0[3] * s1 + weights.a0[4] * s2;
                a2[c] = weights.a2[2] * m[2] + weights.a2[3] * s1 + weights.a2[4] * s2;
                a1[c] = weights.a1[3] * d1 + weights.a1[4] * d2;
                a3[c] = weights.a3[3] * d1 + weights.a3[4] * d2;
                e1[c] = weights.e1[2] * m[2] + weights.e1[3] * s1 + weights.e1[4] * s2;
                e3[c] = weights.e3[2] * m[2] + weights.e3[3] * s1 + weights.e3[4] * s2;
            } else {
                let sum = |w: &[f64; 5]| {
                    w[0] * m[0] + w[1] * m[1] + w[2] * m[2] + w[3] * m[3] + w[4] * m[4]
                };
                a0[c] = sum(&weights.a0);
                a1[c] = sum(&weights.a1);
                a2[c] = sum(&weights.a2);
                a3[c] = sum(&weights.a3);
                e1[c] = sum(&weights.e1);
                e3[c] = sum(&weights.e3);
            }
        }
        let gyro = |v: &[f64; 6]| [v[0], v[1], v[2]];
        let accel = |v: &[f64; 6]| [v[3], v[4], v[5]];
        let (h, h2) = (dt, dt * dt);

        // Second order of the series: coning and sculling.
        let coning = add(cross(gyro(&e1), gyro(&a1)), cross(gyro(&e3), gyro(&a3)));
        let sculling = add(
            add(cross(gyro(&e1), accel(&a1)), cross(gyro(&e3), accel(&a3))),
            add(cross(accel(&e1), gyro(&a1)), cross(accel(&e3), gyro(&a3))),
        );
        // Third and fourth order: [A₀, [A₀, A₂]]/360 − [A₁, [A₀, A₁]]/240 − [A₀, [A₀, [A₀, A₁]]]/720, where [A₀, A₁] is
        // 12 times the second order.
        let (mut w2, mut f2) = (gyro(&a2), accel(&a2));
        for i in 0..3 {
            w2[i] -= 6.0 * h * coning[i];
            f2[i] -= 6.0 * h * sculling[i];
        }
        let (inner_w, inner_f) = bracket(gyro(&a0), accel(&a0), w2, f2);
        let (outer_w, outer_f) = bracket(gyro(&a0), accel(&a0), inner_w, inner_f);
        let (odd_w, odd_f) = bracket(gyro(&a1), accel(&a1), coning, sculling);
        let (mut phi, mut rho) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            phi[i] = h
                * (mean[i] + h * (coning[i] + h * (outer_w[i] * (1.0 / 360.0) - odd_w[i] * 0.05)));
            rho[i] = h
                * (mean[3 + i]
                    + h * (sculling[i] + h * (outer_f[i] * (1.0 / 360.0) - odd_f[i] * 0.05)));
        }
        let x = phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2];

        // Series in x = φ²: (1 − cos φ)/φ², (φ − sin φ)/φ³ and their integrals for the position.
        let c1 = 0.5
            + x * (-1.0 / 24.0
                + x * (1.0 / 720.0 + x * (-1.0 / 40_320.0 + x * (1.0 / 3_628_800.0))));
        let c2 = 1.0 / 6.0
            + x * (-1.0 / 120.0
                + x * (1.0 / 5040.0 + x * (-1.0 / 362_880.0 + x * (1.0 / 39_916_800.0))));
        let p2 = 1.0 / 24.0 + x * (-1.0 / 720.0 + x * (1.0 / 40_320.0));
        let turned = cross(phi, rho);
        let twice = cross(phi, turned);
        let mut dv = [0.0; 3];
        for i in 0..3 {
            dv[i] = rho[i] + c1 * turned[i] + c2 * twice[i];
        }

        // ∫∫f = h²(½ f̄ − a₁/12 − a₃/80); ∫(h − τ)α × f = h³(a₀×b₀/6 + 0·a₀×b₁ − a₁×b₀/24 …).
        let (b1, b3) = (accel(&a1), accel(&a3));
        let f0 = accel(&a0);
        let (constant, linear_rate) = (cross(gyro(&a0), f0), cross(gyro(&a1), f0));
        let mut dp = [0.0; 3];
        for i in 0..3 {
            dp[i] = h2 * (0.5 * mean[3 + i] - b1[i] * (1.0 / 12.0) - b3[i] * (1.0 / 80.0))
                + h2 * h * (c2 * constant[i] - (1.0 / 24.0) * linear_rate[i])
                + h * p2 * twice[i];
        }

        let (q0, q1, q2, q3) = (lanes.q[0][l], lanes.q[1][l], lanes.q[2][l], lanes.q[3][l]);
        let c = [
            [
                1.0 - 2.0 * (q2 * q2 + q3 * q3),
                2.0 * (q1 * q2 - q0 * q3),
                2.0 * (q1 * q3 + q0 * q2),
            ],
            [
                2.0 * (q1 * q2 + q0 * q3),
                1.0 - 2.0 * (q1 * q1 + q3 * q3),
                2.0 * (q2 * q3 - q0 * q1),
            ],
            [
                2.0 * (q1 * q3 - q0 * q2),
                2.0 * (q2 * q3 + q0 * q1),
                1.0 - 2.0 * (q1 * q1 + q2 * q2),
            ],
        ];
        let mut v = [lanes.v[0][l], lanes.v[1][l], lanes.v[2][l]];
        let mut r = [lanes.r[0][l], lanes.r[1][l], lanes.r[2][l]];
        let g = [
            lanes.gravitation[0][l],
            lanes.gravitation[1][l],
            lanes.gravitation[2][l],
        ];
        for i in 0..3 {
            r[i] +=
                h * v[i] + (c[i][0] * dp[0] + c[i][1] * dp[1] + c[i][2] * dp[2]) + 0.5 * h2 * g[i];
        }
        let (g_end, normal, height) = field.at(r[0], r[1], r[2]);
        for i in 0..3 {
            v[i] +=
                (c[i][0] * dv[0] + c[i][1] * dv[1] + c[i][2] * dv[2]) + 0.5 * h * (g[i] + g_end[i]);
            r[i] += h2 * (1.0 / 6.0) * (g_end[i] - g[i]);
        }

        // The vertical channel: e = h̃ − h, climb = n·(v − Ω×r).
        let error = height - hold.height_m;
        let climb = normal[0] * (v[0] + field.rate * r[1])
            + normal[1] * (v[1] - field.rate * r[0])
            + normal[2] * v[2];
        let integral = lanes.baro[0][l];
        let dh = hold.height_gain * error;
        let dc = hold.climb_gain * (climb - hold.climb_m_s)
            + hold.velocity_per_height * error
            + hold.dt_s * integral;
        lanes.baro[0][l] = integral + hold.integral_per_height * error;
        for i in 0..3 {
            r[i] -= dh * normal[i];
            v[i] -= dc * normal[i];
            lanes.r[i][l] = r[i];
            lanes.v[i][l] = v[i];
            lanes.gravitation[i][l] = g_end[i];
        }

        // q ← q ⊗ (cos ½φ, sin ½φ) as an increment, with the rounding carried along.
        let y = 0.25 * x;
        let ch = y
            * (-0.5
                + y * (1.0 / 24.0
                    + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 + y * (-1.0 / 3_628_800.0)))));
        let sh = 0.5
            + y * (-1.0 / 12.0 + y * (1.0 / 240.0 + y * (-1.0 / 10_080.0 + y * (1.0 / 725_760.0))));
        let (u1, u2, u3) = (sh * phi[0], sh * phi[1], sh * phi[2]);
        let unit = ch + 0.5 * (1.0 - (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3));
        let change = [
            q0 * unit - q1 * u1 - q2 * u2 - q3 * u3,
            q0 * u1 + q1 * unit + q2 * u3 - q3 * u2,
            q0 * u2 - q1 * u3 + q2 * unit + q3 * u1,
            q0 * u3 + q1 * u2 - q2 * u1 + q3 * unit,
        ];
        let old = [q0, q1, q2, q3];
        for i in 0..4 {
            let wanted = change[i] - lanes.q_rest[i][l];
            let new = old[i] + wanted;
            lanes.q_rest[i][l] = (new - old[i]) - wanted;
            lanes.q[i][l] = new;
        }
    }
}

/// Every step of a stretch whose windows are complete; `samples` starts with the first window's oldest.
#[inline(always)]
fn stretch<const L: usize, const CENTRED: bool>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    for (i, hold) in holds.iter().enumerate() {
        let (window, place) = if CENTRED {
            let Some([a, b, c, d, e]) = samples.get(i..i + 5) else {
                return;
            };
            ([a, b, c, d, e], 2)
        } else {
            let Some([a, b]) = samples.get(i..i + 2) else {
                return;
            };
            ([a, b, b, b, b], 1)
        };
        advance::<L, CENTRED>(lanes, field, weights, window, place, hold.dt_s, hold);
    }
}

/// Runs a stretch with the widest vectors of this machine.
pub(super) fn run<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    sculling: super::Sculling,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    match sculling {
        super::Sculling::Five => dispatch::<L, true>(lanes, field, weights, samples, holds),
        super::Sculling::Two => dispatch::<L, false>(lanes, field, weights, samples, holds),
    }
}

#[cfg(target_arch = "x86_64")]
fn dispatch<const L: usize, const CENTRED: bool>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    #[target_feature(enable = "avx512f")]
    fn wide<const L: usize, const CENTRED: bool>(
        lanes: &mut Lanes<L>,
        field: &Field,
        weights: &Weights,
        samples: &[[[f64; L]; 6]],
        holds: &[Hold],
    ) {
        stretch::<L, CENTRED>(lanes, field, weights, samples, holds);
    }
    #[target_feature(enable = "avx2")]
    fn middle<const L: usize, const CENTRED: bool>(
        lanes: &mut Lanes<L>,
        field: &Field,
        weights: &Weights,
        samples: &[[[f64; L]; 6]],
        holds: &[Hold],
    ) {
        stretch::<L, CENTRED>(lanes, field, weights, samples, holds);
    }
    if L >= 8 && std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the feature was just detected; the body is safe code.
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for a detected instruction set"
        )]
        unsafe {
            wide::<L, CENTRED>(lanes, field, weights, samples, holds);
        }
    } else if L >= 4 && std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the feature was just detected; the body is safe code.
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for a detected instruction set"
        )]
        unsafe {
            middle::<L, CENTRED>(lanes, field, weights, samples, holds);
        }
    } else {
        stretch::<L, CENTRED>(lanes, field, weights, samples, holds);
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn dispatch<const L: usize, const CENTRED: bool>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    stretch::<L, CENTRED>(lanes, field, weights, samples, holds);
}
