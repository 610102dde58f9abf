//! Coning and sculling: what one interval does in the body axes of its start, whatever the state before it.

#![allow(
    clippy::inline_always,
    reason = "the lanes become vector code only where the body is inlined into their loop"
)]

use super::super::weights::Weights;
use super::{CHUNK, REACH};

/// What an interval does, whatever the state before it: sin(φ/2)/φ·φ and cos(φ/2) − 1 of its turn, and the velocity and
/// position it adds in the body axes of its start.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    pub(super) turn: [[f64; CHUNK]; 3],
    pub(super) unit: [f64; CHUNK],
    pub(super) dv: [[f64; CHUNK]; 3],
    pub(super) dp: [[f64; CHUNK]; 3],
}

impl Parts {
    pub(super) fn new() -> Self {
        Self {
            turn: [[0.0; CHUNK]; 3],
            unit: [0.0; CHUNK],
            dv: [[0.0; CHUNK]; 3],
            dp: [[0.0; CHUNK]; 3],
        }
    }
}

/// How the window of an interval lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Five samples, the interval's in the middle.
    Centred,
    /// Two samples, the interval's last.
    Pair,
    /// Any weights of up to five samples, the interval's at this place.
    Any(usize),
}

/// The parts of `count` intervals of length `h`, each from the samples at its index and the following ones `L` apart.
#[inline(always)]
pub(super) fn intervals<const L: usize>(
    samples: [&[f64; REACH]; 6],
    form: Form,
    weights: &Weights,
    h: f64,
    count: usize,
    parts: &mut Parts,
) {
    match form {
        Form::Centred => interval_loop::<L, 5, true>(samples, 2, weights, h, count, parts),
        Form::Pair => interval_loop::<L, 2, false>(samples, 1, weights, h, count, parts),
        Form::Any(place) => {
            interval_loop::<L, 5, false>(samples, place, weights, h, count, parts);
        }
    }
}

#[inline(always)]
fn interval_loop<const L: usize, const WIDTH: usize, const CENTRED: bool>(
    samples: [&[f64; REACH]; 6],
    place: usize,
    weights: &Weights,
    h: f64,
    count: usize,
    parts: &mut Parts,
) {
    let centred = weights.centred;
    let scale = if CENTRED { centred.scale } else { 1.0 };
    let second = h * h * scale;
    let (third, fourth, cubic) = (
        h * h * h * (1.0 / 720.0),
        12.0 * h * scale,
        0.025 * h * second,
    );
    let twelfth = h * (1.0 / 12.0);
    let here = place.min(4) * L;
    for i in 0..count.min(CHUNK) {
        // Coning is E₁ × O₁ + E₂ × O₂ in even and odd combinations of the samples, and sculling likewise; 2a₁, 2a₂ and
        // the change of f over the interval serve the smaller terms.
        let (mut even, mut odd) = ([[0.0; 6]; 2], [[0.0; 6]; 2]);
        let (mut bend, mut slope, mut rise) = ([0.0; 6], [0.0; 6], [0.0; 3]);
        let mut mean = [0.0; 6];
        for c in 0..6 {
            if CENTRED {
                let m: [f64; 5] = core::array::from_fn(|j| samples[c][i + j * L]);
                mean[c] = m[2];
                let (s1, s2, d1, d2) = (m[3] + m[1], m[4] + m[0], m[3] - m[1], m[4] - m[0]);
                let d = d2 + centred.odd[0] * d1;
                even[0][c] = m[2] + centred.even[0] * s1;
                even[1][c] = s2 + centred.even[1] * s1;
                odd[0][c] = d1 + centred.odd[1] * d;
                odd[1][c] = centred.odd[2] * d;
                slope[c] = d1;
                bend[c] = (s1 - m[2]) - m[2];
                if c >= 3 {
                    rise[c - 3] = (2.0 / 3.0) * d1 - (1.0 / 12.0) * d2;
                }
            } else {
                mean[c] = samples[c][i + here];
                let m: [f64; WIDTH] = core::array::from_fn(|j| samples[c][i + j * L]);
                let sum = |w: &[f64; 5]| {
                    let mut sum = 0.0;
                    for j in 0..WIDTH {
                        sum += w[j] * m[j];
                    }
                    sum
                };
                even[0][c] = sum(&weights.e1);
                even[1][c] = sum(&weights.e3);
                odd[0][c] = sum(&weights.a1);
                odd[1][c] = sum(&weights.a3);
                slope[c] = 2.0 * odd[0][c];
                bend[c] = 2.0 * sum(&weights.a2);
                if c >= 3 {
                    rise[c - 3] = odd[0][c] + 0.25 * odd[1][c];
                }
            }
        }
        let gyro = |v: &[f64; 6]| [v[0], v[1], v[2]];
        let accel = |v: &[f64; 6]| [v[3], v[4], v[5]];

        // Second order of the series: coning and sculling.
        let coning = add(
            cross(gyro(&even[0]), gyro(&odd[0])),
            cross(gyro(&even[1]), gyro(&odd[1])),
        );
        let sculling = add(
            add(
                cross(gyro(&even[0]), accel(&odd[0])),
                cross(gyro(&even[1]), accel(&odd[1])),
            ),
            add(
                cross(accel(&even[0]), gyro(&odd[0])),
                cross(accel(&even[1]), gyro(&odd[1])),
            ),
        );
        // Third and fourth order: [A₀, [A₀, A₂]]/360 − [A₁, [A₀, A₁]]/240 − [A₀, [A₀, [A₀, A₁]]]/720 with the mean for A₀
        // and the middle slope for A₁; [A₀, A₁] is 12 times the second order.
        for k in 0..3 {
            bend[k] -= fourth * coning[k];
            bend[3 + k] -= fourth * sculling[k];
        }
        let (inner_w, inner_f) = bracket(gyro(&mean), accel(&mean), gyro(&bend), accel(&bend));
        let (outer_w, outer_f) = bracket(gyro(&mean), accel(&mean), inner_w, inner_f);
        let (odd_w, odd_f) = bracket(gyro(&slope), accel(&slope), coning, sculling);
        let (mut phi, mut rho) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            phi[k] = h * mean[k] + (second * coning[k] + (third * outer_w[k] - cubic * odd_w[k]));
            rho[k] =
                h * mean[3 + k] + (second * sculling[k] + (third * outer_f[k] - cubic * odd_f[k]));
        }
        let x = phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2];

        // Series in x = φ²: (1 − cos φ)/φ² and (φ − sin φ)/φ³.
        let c1 = 0.5
            + x * (-1.0 / 24.0
                + x * (1.0 / 720.0 + x * (-1.0 / 40_320.0 + x * (1.0 / 3_628_800.0))));
        let c2 = 1.0 / 6.0
            + x * (-1.0 / 120.0
                + x * (1.0 / 5040.0 + x * (-1.0 / 362_880.0 + x * (1.0 / 39_916_800.0))));
        let turned = cross(phi, rho);
        let twice = cross(phi, turned);
        // h (v̇₁ − v̇₀) = s + φ×s/2 … with s = h Δf + φ×ρ.
        let change = [
            turned[0] + h * rise[0],
            turned[1] + h * rise[1],
            turned[2] + h * rise[2],
        ];
        let further = cross(phi, change);
        // (cos ½φ, sin ½φ) as an increment.
        let y = 0.25 * x;
        let sh = 0.5
            + y * (-1.0 / 12.0 + y * (1.0 / 240.0 + y * (-1.0 / 10_080.0 + y * (1.0 / 725_760.0))));
        parts.unit[i] = y
            * (-0.5
                + y * (1.0 / 24.0
                    + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 + y * (-1.0 / 3_628_800.0)))));
        for k in 0..3 {
            let dv = rho[k] + (c1 * turned[k] + c2 * twice[k]);
            parts.turn[k][i] = sh * phi[k];
            parts.dv[k][i] = dv;
            parts.dp[k][i] = (0.5 * h) * dv - twelfth * (change[k] + 0.5 * further[k]);
        }
    }
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
