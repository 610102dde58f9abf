//! One strapdown step in inertial axes, several runs in vector lanes. Rate and specific force are one element A = (ω, f)
//! of se(3), [A, B] = (ω_A×ω_B, ω_A×f_B − ω_B×f_A); Magnus' series of its polynomial A₀ + A₁u + A₂u² …,
//! (φ, ρ) = ∫A + coning and sculling + [A₀,[A₀,A₂]]/360 − …, gives the rotation vector φ and the velocity change
//! Δv = ρ + (1 − cos φ)/φ² φ×ρ + (φ − sin φ)/φ³ φ×(φ×ρ) [BLANES] [SAVAGE]; the position follows by Euler and Maclaurin's
//! rule, ∫v = h(v₀ + v₁)/2 − h²(v̇₁ − v̇₀)/12.
//!
//! Inertial axes need no Coriolis or transport terms; the field is symmetric about z, so gravitation is a function of the
//! inertial position alone. The loop over lanes is straight-line arithmetic that the compiler turns into vectors; nothing
//! is contracted, so every instruction set gives the same bits.

#![allow(
    clippy::inline_always,
    reason = "the lanes become vector code only where the body is inlined into their loop"
)]

mod field;
mod interval;

use super::weights::Weights;
pub(super) use field::{Field, gravitation};
use interval::{Form, Parts, intervals};

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

impl Hold {
    fn holds(&self) -> bool {
        self.height_gain != 0.0 || self.climb_gain != 0.0
    }
}

/// Steps that are worked out at once, pass by pass.
const STEPS: usize = 16;
/// Intervals of all lanes in them, for up to eight lanes.
const CHUNK: usize = STEPS * 8;
/// With the four samples more that the windows reach.
const REACH: usize = CHUNK + 4 * 8;

/// Samples by channel, lane after lane and step after step.
type Channels = [[f64; REACH]; 6];

/// Three components of every interval in a chunk.
type Three = [[f64; CHUNK]; 3];

/// Room for a chunk's passes.
struct Room {
    samples: Channels,
    parts: Parts,
    /// Attitude at the start of every interval.
    attitude: [[f64; CHUNK]; 4],
    /// Velocity and position changes, turned into inertial axes.
    gained: Three,
    moved: Three,
    /// Where the field is evaluated, and what it is.
    place: Three,
    pull: Three,
    normal: Three,
    height: [f64; CHUNK],
}

impl Room {
    fn new() -> Self {
        Self {
            samples: [[0.0; REACH]; 6],
            parts: Parts::new(),
            attitude: [[0.0; CHUNK]; 4],
            gained: [[0.0; CHUNK]; 3],
            moved: [[0.0; CHUNK]; 3],
            place: [[0.0; CHUNK]; 3],
            pull: [[0.0; CHUNK]; 3],
            normal: [[0.0; CHUNK]; 3],
            height: [0.0; CHUNK],
        }
    }
}

/// Carries every lane over the intervals of a chunk, which all last as long as the first.
///
/// The attitude does not need the position, and the position needs gravitation only: so attitudes come first, then
/// positions with a gravitation that is carried on along its gradient (in [`STEPS`] steps at 100 Hz off by 1e-8 m, in
/// which gravitation does not change by 1e-13 m/s²), then the field at all of them, then the motion with that field.
/// Only what one step needs of the last stands in the loops from step to step; all else runs over the whole chunk.
#[inline(always)]
fn carry<const L: usize, const HELD: bool>(
    lanes: &mut Lanes<L>,
    field: &Field,
    room: &mut Room,
    holds: &[Hold],
) {
    let Some(h) = holds.first().map(|hold| hold.dt_s) else {
        return;
    };
    let count = (holds.len().min(STEPS) * L).min(CHUNK);
    // A number of lanes that the compiler does not know: it unrolls a loop of known length and then finds no vectors in
    // it, while this one becomes a vector of lanes.
    let width = if L == 1 { 1 } else { core::hint::black_box(L) };
    follow_attitude::<L>(lanes, room, count, width);
    turn(room, count);
    predict::<L>(lanes, room, count, width, h);
    for at in 0..count {
        let (g, n, above) = field.at([room.place[0][at], room.place[1][at], room.place[2][at]]);
        for i in 0..3 {
            room.pull[i][at] = g[i];
            room.normal[i][at] = n[i];
        }
        room.height[at] = above;
    }
    move_on::<L, HELD>(lanes, field.rate, room, holds, width);
}

/// q ← q ⊗ (cos ½φ, sin ½φ) as an increment, step by step, with the rounding carried along; the length of q is mended once
/// a chunk, in which roundings change it by 1e-15.
#[inline(always)]
fn follow_attitude<const L: usize>(
    lanes: &mut Lanes<L>,
    room: &mut Room,
    count: usize,
    width: usize,
) {
    let (mut q, mut rest, mut mend) = (lanes.q, lanes.q_rest, [0.0; L]);
    let Room {
        parts, attitude, ..
    } = room;
    for l in 0..width.min(L) {
        mend[l] = 0.5
            * (1.0
                - (q[0][l] * q[0][l] + q[1][l] * q[1][l] + q[2][l] * q[2][l] + q[3][l] * q[3][l]));
    }
    for at in (0..count.min(CHUNK + 1 - L)).step_by(L) {
        for l in 0..width.min(L) {
            let k = at + l;
            let old = [q[0][l], q[1][l], q[2][l], q[3][l]];
            let [q0, q1, q2, q3] = old;
            let (u1, u2, u3) = (parts.turn[0][k], parts.turn[1][k], parts.turn[2][k]);
            let unit = parts.unit[k] + mend[l];
            mend[l] = 0.0;
            let change = [
                (q0 * unit - q1 * u1) - (q2 * u2 + q3 * u3),
                (q0 * u1 + q1 * unit) + (q2 * u3 - q3 * u2),
                (q0 * u2 - q1 * u3) + (q2 * unit + q3 * u1),
                (q0 * u3 + q1 * u2) - (q2 * u1 - q3 * unit),
            ];
            for i in 0..4 {
                attitude[i][k] = old[i];
                let wanted = change[i] - rest[i][l];
                let new = old[i] + wanted;
                rest[i][l] = (new - old[i]) - wanted;
                q[i][l] = new;
            }
        }
    }
    (lanes.q, lanes.q_rest) = (q, rest);
}

/// Velocity and position changes of every interval in inertial axes.
#[inline(always)]
fn turn(room: &mut Room, count: usize) {
    let Room {
        parts,
        attitude,
        gained,
        moved,
        ..
    } = room;
    for k in 0..count.min(CHUNK) {
        let (q0, q1, q2, q3) = (
            attitude[0][k],
            attitude[1][k],
            attitude[2][k],
            attitude[3][k],
        );
        let (t1, t2, t3) = (q1 + q1, q2 + q2, q3 + q3);
        let (xx, yy, zz) = (q1 * t1, q2 * t2, q3 * t3);
        let (xy, xz, yz) = (q1 * t2, q1 * t3, q2 * t3);
        let (sx, sy, sz) = (q0 * t1, q0 * t2, q0 * t3);
        let c = [
            [1.0 - (yy + zz), xy - sz, xz + sy],
            [xy + sz, 1.0 - (xx + zz), yz - sx],
            [xz - sy, yz + sx, 1.0 - (xx + yy)],
        ];
        let dv = [parts.dv[0][k], parts.dv[1][k], parts.dv[2][k]];
        let dp = [parts.dp[0][k], parts.dp[1][k], parts.dp[2][k]];
        for i in 0..3 {
            gained[i][k] = c[i][0] * dv[0] + c[i][1] * dv[1] + c[i][2] * dv[2];
            moved[i][k] = c[i][0] * dp[0] + c[i][1] * dp[1] + c[i][2] * dp[2];
        }
    }
}

/// Where the lanes will be, with gravitation carried on along its gradient.
#[inline(always)]
fn predict<const L: usize>(lanes: &Lanes<L>, room: &mut Room, count: usize, width: usize, h: f64) {
    let (mut r, mut v, mut g) = (lanes.r, lanes.v, lanes.gravitation);
    let Room {
        gained,
        moved,
        place,
        ..
    } = room;
    let mut step = [[0.0; L]; 3];
    for l in 0..width.min(L) {
        // ġ of a point mass: −(g/r)(v − 3 r (r·v)/r²).
        let inverse = 1.0 / (r[0][l] * r[0][l] + r[1][l] * r[1][l] + r[2][l] * r[2][l]);
        let pull = (g[0][l] * r[0][l] + g[1][l] * r[1][l] + g[2][l] * r[2][l]) * inverse;
        let along = 3.0 * (r[0][l] * v[0][l] + r[1][l] * v[1][l] + r[2][l] * v[2][l]) * inverse;
        for i in 0..3 {
            step[i][l] = h * pull * (v[i][l] - along * r[i][l]);
        }
    }
    let (half, sixth) = (0.5 * h, h * h * (1.0 / 6.0));
    for at in (0..count.min(CHUNK + 1 - L)).step_by(L) {
        for l in 0..width.min(L) {
            for i in 0..3 {
                r[i][l] += h * (v[i][l] + half * g[i][l]) + (sixth * step[i][l] + moved[i][at + l]);
                v[i][l] += gained[i][at + l] + (h * g[i][l] + half * step[i][l]);
                g[i][l] += step[i][l];
                place[i][at + l] = r[i][l];
            }
        }
    }
}

/// Position and velocity over every interval, gravitation running straight from its start to its end, and the hold of the
/// vertical channel after it.
#[inline(always)]
fn move_on<const L: usize, const HELD: bool>(
    lanes: &mut Lanes<L>,
    rate: f64,
    room: &Room,
    holds: &[Hold],
    width: usize,
) {
    let Room {
        gained,
        moved,
        place,
        pull,
        normal,
        height,
        ..
    } = room;
    let (mut r, mut v, mut g, mut baro) = (lanes.r, lanes.v, lanes.gravitation, lanes.baro);
    let count = (holds.len().min(STEPS) * L).min(CHUNK);
    for at in (0..count.min(CHUNK + 1 - L)).step_by(L) {
        let Some(hold) = holds.get(at / L).copied() else {
            break;
        };
        let h = hold.dt_s;
        let (half, third, sixth) = (0.5 * h, h * h * (1.0 / 3.0), h * h * (1.0 / 6.0));
        for l in 0..width.min(L) {
            let k = at + l;
            for i in 0..3 {
                let (begin, end) = (g[i][l], pull[i][k]);
                r[i][l] += h * v[i][l] + (third * begin + (sixth * end + moved[i][k]));
                v[i][l] += gained[i][k] + half * (begin + end);
                g[i][l] = end;
            }
            if HELD {
                // The vertical channel: e = h̃ − h, climb = n·(v − Ω×r).
                let n = [normal[0][k], normal[1][k], normal[2][k]];
                let error = (height[k] - hold.height_m)
                    + (n[0] * (r[0][l] - place[0][k])
                        + n[1] * (r[1][l] - place[1][k])
                        + n[2] * (r[2][l] - place[2][k]));
                let climb = n[0] * (v[0][l] + rate * r[1][l])
                    + n[1] * (v[1][l] - rate * r[0][l])
                    + n[2] * v[2][l];
                let dh = hold.height_gain * error;
                let dc = hold.climb_gain * (climb - hold.climb_m_s)
                    + hold.velocity_per_height * error
                    + hold.dt_s * baro[0][l];
                baro[0][l] += hold.integral_per_height * error;
                for i in 0..3 {
                    r[i][l] -= dh * n[i];
                    v[i][l] -= dc * n[i];
                }
            }
        }
    }
    (lanes.r, lanes.v, lanes.gravitation, lanes.baro) = (r, v, g, baro);
}

/// One interval with any weights; `window` is oldest first, `place` the interval's sample in it.
pub(super) fn edge<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    window: [&[[f64; L]; 6]; 5],
    place: usize,
    hold: &Hold,
) {
    let mut room = Room::new();
    for (j, sample) in window.iter().enumerate() {
        spread(sample, j, &mut room.samples);
    }
    let Room { samples, parts, .. } = &mut room;
    intervals::<L>(samples, Form::Any(place), weights, hold.dt_s, L, parts);
    carry::<L, true>(lanes, field, &mut room, std::slice::from_ref(hold));
}

/// Puts a sample at step `j` of the channels.
#[inline(always)]
fn spread<const L: usize>(sample: &[[f64; L]; 6], j: usize, to: &mut Channels) {
    for (channel, values) in to.iter_mut().zip(sample) {
        if let Some(place) = channel.get_mut(j * L..(j + 1) * L) {
            place.copy_from_slice(values);
        }
    }
}

/// Every step of a stretch whose windows are complete; `samples` starts with the first window's oldest.
#[inline(always)]
fn stretch<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    sculling: super::Sculling,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    let (form, width) = match sculling {
        super::Sculling::Five => (Form::Centred, 5),
        super::Sculling::Two => (Form::Pair, 2),
    };
    let held = holds.iter().any(Hold::holds);
    let mut room = Room::new();
    let mut from = 0;
    while from < holds.len() {
        // Intervals of one length, as many as a chunk holds.
        let h = holds[from].dt_s;
        let steps = holds[from..]
            .iter()
            .take(STEPS.min(CHUNK / L))
            .take_while(|hold| hold.dt_s == h)
            .count()
            .max(1);
        let Some(window) = samples.get(from..from + steps + width - 1) else {
            return;
        };
        for (j, sample) in window.iter().enumerate() {
            spread(sample, j, &mut room.samples);
        }
        let Room { samples, parts, .. } = &mut room;
        intervals::<L>(samples, form, weights, h, steps * L, parts);
        let holds = &holds[from..from + steps];
        if held {
            carry::<L, true>(lanes, field, &mut room, holds);
        } else {
            carry::<L, false>(lanes, field, &mut room, holds);
        }
        from += steps;
    }
}

/// Runs a stretch with the widest vectors of this machine.
#[cfg(target_arch = "x86_64")]
pub(super) fn run<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    sculling: super::Sculling,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    #[target_feature(enable = "avx512f")]
    fn wide<const L: usize>(
        lanes: &mut Lanes<L>,
        field: &Field,
        weights: &Weights,
        sculling: super::Sculling,
        samples: &[[[f64; L]; 6]],
        holds: &[Hold],
    ) {
        stretch::<L>(lanes, field, weights, sculling, samples, holds);
    }
    #[target_feature(enable = "avx2")]
    fn middle<const L: usize>(
        lanes: &mut Lanes<L>,
        field: &Field,
        weights: &Weights,
        sculling: super::Sculling,
        samples: &[[[f64; L]; 6]],
        holds: &[Hold],
    ) {
        stretch::<L>(lanes, field, weights, sculling, samples, holds);
    }
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the feature was just detected; the body is safe code.
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for a detected instruction set"
        )]
        unsafe {
            wide::<L>(lanes, field, weights, sculling, samples, holds);
        }
    } else if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the feature was just detected; the body is safe code.
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for a detected instruction set"
        )]
        unsafe {
            middle::<L>(lanes, field, weights, sculling, samples, holds);
        }
    } else {
        stretch::<L>(lanes, field, weights, sculling, samples, holds);
    }
}

/// Runs a stretch.
#[cfg(not(target_arch = "x86_64"))]
pub(super) fn run<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    sculling: super::Sculling,
    samples: &[[[f64; L]; 6]],
    holds: &[Hold],
) {
    stretch::<L>(lanes, field, weights, sculling, samples, holds);
}
