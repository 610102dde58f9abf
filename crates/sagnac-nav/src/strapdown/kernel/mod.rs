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
mod lane;

use super::weights::Weights;
pub(super) use field::{Field, gravitation};
use interval::{Form, Parts, intervals};
use lane::Lane;

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

/// Room for a chunk's passes; where vectors begin with the lines of the cache, none lies across two of them.
#[repr(align(64))]
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
    /// On the way to the field.
    way: [[f64; CHUNK]; 2],
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
            way: [[0.0; CHUNK]; 2],
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
    follow_attitude::<L>(lanes, room, count);
    turn(room, count);
    predict::<L>(lanes, room, count, h);
    if field.is_sphere() {
        evaluate::<true>(field, room, count);
    } else {
        evaluate::<false>(field, room, count);
    }
    move_on::<L, HELD>(lanes, field.rate, room, holds);
}

/// The field at every place, in three loops: each waits for a root, and of a short loop more turns run at once.
#[inline(always)]
fn evaluate<const SPHERE: bool>(field: &Field, room: &mut Room, count: usize) {
    let Room {
        place,
        pull,
        normal,
        height,
        way,
        ..
    } = room;
    let count = count.min(CHUNK);
    let here = |at: usize| [place[0][at], place[1][at], place[2][at]];
    for at in 0..count {
        [way[0][at], way[1][at]] = field.slope(here(at));
    }
    for at in 0..count {
        let direction = Field::direction(here(at), [way[0][at], way[1][at]]);
        [way[0][at], way[1][at]] = direction;
    }
    for at in 0..count {
        let (g, n, above) = field.pull::<SPHERE>(here(at), [way[0][at], way[1][at]]);
        for i in 0..3 {
            pull[i][at] = g[i];
            normal[i][at] = n[i];
        }
        height[at] = above;
    }
}

/// The first `steps` steps of every component, all lanes of a step together.
#[inline(always)]
fn steps_of<const L: usize, const C: usize>(
    of: &[[f64; CHUNK]; C],
    steps: usize,
) -> [&[[f64; L]]; C] {
    core::array::from_fn(|i| &of[i].as_chunks::<L>().0[..steps])
}

#[inline(always)]
fn steps_of_mut<const L: usize, const C: usize>(
    of: &mut [[f64; CHUNK]; C],
    steps: usize,
) -> [&mut [[f64; L]]; C] {
    of.each_mut()
        .map(|component| &mut component.as_chunks_mut::<L>().0[..steps])
}

/// q ← q ⊗ (cos ½φ, sin ½φ) as an increment, step by step, with the rounding carried along; the length of q is mended once
/// a chunk, in which roundings change it by 1e-15.
#[inline(always)]
fn follow_attitude<const L: usize>(lanes: &mut Lanes<L>, room: &mut Room, count: usize) {
    let (mut q, mut rest) = (lanes.q.map(Lane), lanes.q_rest.map(Lane));
    let steps = count / L;
    let turn = steps_of::<L, 3>(&room.parts.turn, steps);
    let [units] = steps_of::<L, 1>(core::array::from_ref(&room.parts.unit), steps);
    let attitude = steps_of_mut::<L, 4>(&mut room.attitude, steps);
    let mut mend =
        Lane::all(0.5) * (Lane::all(1.0) - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]));
    for s in 0..steps {
        let [q0, q1, q2, q3] = q;
        let (u1, u2, u3) = (Lane(turn[0][s]), Lane(turn[1][s]), Lane(turn[2][s]));
        let unit = Lane(units[s]) + mend;
        mend = Lane::all(0.0);
        let change = [
            (q0 * unit - q1 * u1) - (q2 * u2 + q3 * u3),
            (q0 * u1 + q1 * unit) + (q2 * u3 - q3 * u2),
            (q0 * u2 - q1 * u3) + (q2 * unit + q3 * u1),
            (q0 * u3 + q1 * u2) - (q2 * u1 - q3 * unit),
        ];
        for i in 0..4 {
            attitude[i][s] = q[i].0;
            let wanted = change[i] - rest[i];
            let new = q[i] + wanted;
            rest[i] = (new - q[i]) - wanted;
            q[i] = new;
        }
    }
    (lanes.q, lanes.q_rest) = (q.map(|x| x.0), rest.map(|x| x.0));
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
fn predict<const L: usize>(lanes: &Lanes<L>, room: &mut Room, count: usize, h: f64) {
    let (mut r, mut v) = (lanes.r.map(Lane), lanes.v.map(Lane));
    let mut g = lanes.gravitation.map(Lane);
    let steps = count / L;
    let gained = steps_of::<L, 3>(&room.gained, steps);
    let moved = steps_of::<L, 3>(&room.moved, steps);
    let place = steps_of_mut::<L, 3>(&mut room.place, steps);
    // ġ of a point mass: −(g/r)(v − 3 r (r·v)/r²).
    let inverse = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).inverse();
    let pull = (g[0] * r[0] + g[1] * r[1] + g[2] * r[2]) * inverse;
    let along = 3.0 * (r[0] * v[0] + r[1] * v[1] + r[2] * v[2]) * inverse;
    let step: [Lane<L>; 3] = core::array::from_fn(|i| h * pull * (v[i] - along * r[i]));
    let (half, sixth) = (0.5 * h, h * h * (1.0 / 6.0));
    for s in 0..steps {
        for i in 0..3 {
            r[i] = r[i] + (h * (v[i] + half * g[i]) + (sixth * step[i] + Lane(moved[i][s])));
            v[i] = v[i] + (Lane(gained[i][s]) + (h * g[i] + half * step[i]));
            g[i] = g[i] + step[i];
            place[i][s] = r[i].0;
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
) {
    let (mut r, mut v) = (lanes.r.map(Lane), lanes.v.map(Lane));
    let (mut g, mut baro) = (lanes.gravitation.map(Lane), Lane(lanes.baro[0]));
    let steps = holds.len().min(CHUNK / L);
    let gained = steps_of::<L, 3>(&room.gained, steps);
    let moved = steps_of::<L, 3>(&room.moved, steps);
    let place = steps_of::<L, 3>(&room.place, steps);
    let pull = steps_of::<L, 3>(&room.pull, steps);
    let normal = steps_of::<L, 3>(&room.normal, steps);
    let [height] = steps_of::<L, 1>(core::array::from_ref(&room.height), steps);
    for (s, hold) in holds.iter().enumerate().take(steps) {
        let h = hold.dt_s;
        let (half, third, sixth) = (0.5 * h, h * h * (1.0 / 3.0), h * h * (1.0 / 6.0));
        for i in 0..3 {
            let (begin, end) = (g[i], Lane(pull[i][s]));
            r[i] = r[i] + (h * v[i] + (third * begin + (sixth * end + Lane(moved[i][s]))));
            v[i] = v[i] + (Lane(gained[i][s]) + half * (begin + end));
            g[i] = end;
        }
        if HELD {
            // The vertical channel: e = h̃ − h, climb = n·(v − Ω×r).
            let n = [Lane(normal[0][s]), Lane(normal[1][s]), Lane(normal[2][s])];
            let error = (Lane(height[s]) - Lane::all(hold.height_m))
                + (n[0] * (r[0] - Lane(place[0][s]))
                    + n[1] * (r[1] - Lane(place[1][s]))
                    + n[2] * (r[2] - Lane(place[2][s])));
            let climb = n[0] * (v[0] + rate * r[1]) + n[1] * (v[1] - rate * r[0]) + n[2] * v[2];
            let dh = hold.height_gain * error;
            let dc = hold.climb_gain * (climb - Lane::all(hold.climb_m_s))
                + hold.velocity_per_height * error
                + hold.dt_s * baro;
            baro = baro + hold.integral_per_height * error;
            for i in 0..3 {
                r[i] = r[i] - dh * n[i];
                v[i] = v[i] - dc * n[i];
            }
        }
    }
    (lanes.r, lanes.v) = (r.map(|x| x.0), v.map(|x| x.0));
    (lanes.gravitation, lanes.baro) = (g.map(|x| x.0), [baro.0]);
}

/// One interval with any weights; `window` holds up to five samples by channel, oldest first, `place` is the interval's.
pub(super) fn edge<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    window: [&[f64]; 6],
    place: usize,
    hold: &Hold,
) {
    let mut room = Room::new();
    for (to, from) in room.samples.iter_mut().zip(window) {
        // Where there are fewer than five, the weights of the others are zero.
        for (to, from) in to.iter_mut().zip(from) {
            *to = *from;
        }
    }
    let Room { samples, parts, .. } = &mut room;
    let [a, b, c, d, e, f] = &*samples;
    let samples = [a, b, c, d, e, f];
    intervals::<L>(samples, Form::Any(place), weights, hold.dt_s, L, parts);
    carry::<L, true>(lanes, field, &mut room, std::slice::from_ref(hold));
}

/// Every step of a stretch whose windows are complete; `samples` by channel, all lanes of a step together, start with the
/// first window's oldest.
#[inline(always)]
fn stretch<const L: usize>(
    lanes: &mut Lanes<L>,
    field: &Field,
    weights: &Weights,
    sculling: super::Sculling,
    samples: [&[f64]; 6],
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
        let Room {
            samples: spare,
            parts,
            ..
        } = &mut room;
        let count = (steps + width - 1) * L;
        let mut window: [&[f64; REACH]; 6] = [&[0.0; REACH]; 6];
        for ((window, spare), channel) in window.iter_mut().zip(spare).zip(samples) {
            let Some(rest) = channel.get(from * L..) else {
                return;
            };
            *window = if let Some(whole) = rest.first_chunk() {
                whole
            } else {
                let Some(rest) = rest.get(..count) else {
                    return;
                };
                spare[..count].copy_from_slice(rest);
                spare
            };
        }
        intervals::<L>(window, form, weights, h, steps * L, parts);
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
    samples: [&[f64]; 6],
    holds: &[Hold],
) {
    #[target_feature(enable = "avx512f")]
    fn wide<const L: usize>(
        lanes: &mut Lanes<L>,
        field: &Field,
        weights: &Weights,
        sculling: super::Sculling,
        samples: [&[f64]; 6],
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
        samples: [&[f64]; 6],
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
    samples: [&[f64]; 6],
    holds: &[Hold],
) {
    stretch::<L>(lanes, field, weights, sculling, samples, holds);
}
