//! The built-in trajectories of navigation.md §1.2: lengths s along, y across and h up, closed functions of t, wound
//! onto the ellipsoid's normals, n = cos B (cos A n₀ + sin A u₀) + sin B w₀ with A = s/R₀, B = y/R₀.

use super::{Point, Start};
use crate::attitude::{
    Mat3, Vec3, add, axpy, cross, from_columns, from_yaw_pitch_roll, mul, mul_vec_t, scale,
};
use crate::earth::{Earth, Place, SPHERE_R_M, STANDARD_GRAVITY_M_S2};
use std::f64::consts::PI;

/// The names, in the order of the contract's table.
pub const NAMES: [&str; 8] = [
    "rest",
    "turn",
    "coning",
    "figure-eight",
    "drive",
    "flight",
    "walking",
    "rocket",
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Rest,
    Turn,
    Coning,
    FigureEight,
    Drive,
    Flight,
    Walking,
    Rocket,
}

impl Kind {
    pub(super) fn parse(name: &str) -> Option<Self> {
        const KINDS: [Kind; 8] = [
            Kind::Rest,
            Kind::Turn,
            Kind::Coning,
            Kind::FigureEight,
            Kind::Drive,
            Kind::Flight,
            Kind::Walking,
            Kind::Rocket,
        ];
        NAMES.iter().position(|n| *n == name).map(|i| KINDS[i])
    }
}

#[derive(Debug, Clone)]
pub(super) struct Builtin {
    pub(super) kind: Kind,
    earth: Earth,
    n0: Vec3,
    u0: Vec3,
    w0: Vec3,
    height_m: f64,
    rest: Option<Point>,
}

/// A function of time with its first three derivatives.
type Jet = [f64; 4];

/// a·sin(2πt/P + phase) with its derivatives.
fn sine(a: f64, period_s: f64, t: f64) -> Jet {
    let w = 2.0 * PI / period_s;
    let (s, c) = (w * t).sin_cos();
    [a * s, a * w * c, -a * w * w * s, -a * w * w * w * c]
}

fn cosine(a: f64, period_s: f64, t: f64) -> Jet {
    let w = 2.0 * PI / period_s;
    let (s, c) = (w * t).sin_cos();
    [a * c, -a * w * s, -a * w * w * c, a * w * w * w * s]
}

fn sum(a: Jet, b: Jet) -> Jet {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

fn line(v: f64, t: f64) -> Jet {
    [v * t, v, 0.0, 0.0]
}

/// a − a·cos(2πt/P).
fn versine(a: f64, period_s: f64, t: f64) -> Jet {
    let c = cosine(-a, period_s, t);
    [a + c[0], c[1], c[2], c[3]]
}

/// An angle as (cosine, sine) and its rate, rad/s.
#[derive(Clone, Copy)]
struct Angle {
    cos: f64,
    sin: f64,
    rate: f64,
}

const NO_ANGLE: Angle = Angle {
    cos: 1.0,
    sin: 0.0,
    rate: 0.0,
};

impl Angle {
    fn new(value: f64, rate: f64) -> Self {
        let (sin, cos) = value.sin_cos();
        Self { cos, sin, rate }
    }

    /// atan2(y, x) and its rate, without the arctangent.
    fn of(y: f64, y_dot: f64, x: f64, x_dot: f64) -> Self {
        let n2 = x * x + y * y;
        let n = n2.sqrt();
        Self {
            cos: x / n,
            sin: y / n,
            rate: (x * y_dot - y * x_dot) / n2,
        }
    }
}

/// ψ = atan2(ẏ, ṡ), θ = atan2(ḣ, v), φ = 0 or that of a coordinated turn.
fn course(s: Jet, y: Jet, h: Jet, coordinated: bool) -> [Angle; 3] {
    let v = s[1].hypot(y[1]);
    let v_dot = (s[1] * s[2] + y[1] * y[2]) / v;
    let yaw = Angle::of(y[1], y[2], s[1], s[2]);
    let pitch = Angle::of(h[1], h[2], v, v_dot);
    let roll = if coordinated {
        let k = 1.0 / STANDARD_GRAVITY_M_S2;
        let turn = s[1] * y[2] - y[1] * s[2];
        let turn_dot = s[1] * y[3] - y[1] * s[3];
        Angle::of(k * turn, k * turn_dot, v, v_dot)
    } else {
        NO_ANGLE
    };
    [yaw, pitch, roll]
}

/// S(x) = 35x⁴ − 84x⁵ + 70x⁶ − 20x⁷ with derivatives in t, x = t/T; 1 from x = 1 on.
fn smooth_step(t: f64, total: f64) -> Jet {
    let x = t / total;
    if x >= 1.0 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let (x2, x3) = (x * x, x * x * x);
    [
        x3 * x * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x))),
        x3 * (140.0 + x * (-420.0 + x * (420.0 - 140.0 * x))) / total,
        x2 * (420.0 + x * (-1680.0 + x * (2100.0 - 840.0 * x))) / (total * total),
        x * (840.0 + x * (-5040.0 + x * (8400.0 - 4200.0 * x))) / (total * total * total),
    ]
}

impl Builtin {
    pub(super) fn new(kind: Kind, earth: Earth, start: &Start) -> Self {
        let (sp, cp) = start.latitude_rad.sin_cos();
        let (sl, cl) = start.longitude_rad.sin_cos();
        let n0 = [cp * cl, cp * sl, sp];
        let (north, east) = ([-sp * cl, -sp * sl, cp], [-sl, cl, 0.0]);
        let (sh, ch) = start.heading_rad.sin_cos();
        let mut out = Self {
            kind,
            earth,
            n0,
            u0: axpy(scale(ch, north), sh, east),
            w0: axpy(scale(-sh, north), ch, east),
            height_m: start.height_m,
            rest: None,
        };
        if kind == Kind::Rest {
            let attitude = [
                NO_ANGLE,
                Angle::new(start.pitch_rad, 0.0),
                Angle::new(start.roll_rad, 0.0),
            ];
            out.rest = Some(out.assemble([0.0; 4], [0.0; 4], [0.0; 4], attitude));
        }
        out
    }

    pub(super) fn at(&self, t: f64) -> Point {
        let zero = [0.0; 4];
        match self.kind {
            Kind::Rest => self
                .rest
                .unwrap_or_else(|| self.assemble(zero, zero, zero, [NO_ANGLE; 3])),
            Kind::Turn => {
                let p = 20.0 * PI;
                let roll = Angle::of(1.0, 0.0, STANDARD_GRAVITY_M_S2, 0.0);
                self.assemble(
                    sine(100.0, p, t),
                    versine(100.0, p, t),
                    zero,
                    [Angle::new(0.1 * t, 0.1), NO_ANGLE, roll],
                )
            }
            Kind::Coning => {
                let (s, c) = (2.0 * PI * t).sin_cos();
                let axis = [0.0, c, s];
                let axis_dot = [0.0, -2.0 * PI * s, 2.0 * PI * c];
                let angle = 1f64.to_radians();
                let (sb, cb) = angle.sin_cos();
                let rotation = crate::attitude::from_rotation_vector(scale(angle, axis));
                let rate = axpy(scale(sb, axis_dot), -(1.0 - cb), cross(axis, axis_dot));
                self.place_body(cosine(0.02, 1.0, t), zero, zero, &rotation, rate)
            }
            Kind::FigureEight => {
                let (s, y) = (sine(50.0, 60.0, t), sine(25.0, 30.0, t));
                self.assemble(s, y, zero, course(s, y, zero, false))
            }
            Kind::Drive => {
                let s = sum(line(15.0, t), sine(60.0, 60.0, t));
                let (y, h) = (versine(200.0, 120.0, t), versine(10.0, 300.0, t));
                self.assemble(s, y, h, course(s, y, h, false))
            }
            Kind::Flight => {
                let s = sum(line(80.0, t), sine(300.0, 120.0, t));
                let (y, h) = (versine(4000.0, 300.0, t), versine(1000.0, 600.0, t));
                self.assemble(s, y, h, course(s, y, h, true))
            }
            Kind::Walking => {
                let s = sum(line(1.4, t), sine(0.015, 0.6, t));
                let q = versine(20.0, 200.0, t);
                let y = sum(q, sine(0.02, 1.2, t));
                let h = versine(0.015, 0.6, t);
                let weave = sine(3f64.to_radians(), 1.2, t);
                let base = Angle::of(q[1], q[2], 1.4, 0.0);
                let turn = Angle::new(weave[0], weave[1]);
                let yaw = Angle {
                    cos: base.cos * turn.cos - base.sin * turn.sin,
                    sin: base.sin * turn.cos + base.cos * turn.sin,
                    rate: base.rate + turn.rate,
                };
                let nod = sine(2f64.to_radians(), 0.6, t);
                let sway = cosine(2f64.to_radians(), 1.2, t);
                self.assemble(
                    s,
                    y,
                    h,
                    [
                        yaw,
                        Angle::new(nod[0], nod[1]),
                        Angle::new(sway[0], sway[1]),
                    ],
                )
            }
            Kind::Rocket => {
                let (total, v) = (120.0, 2000.0);
                let x = t / total;
                let s = if t <= total {
                    let (sn, cs) = (2.0 * PI * x).sin_cos();
                    [
                        v * total * (0.5 * x * x + (cs - 1.0) / (4.0 * PI * PI)),
                        v * (x - sn / (2.0 * PI)),
                        v / total * (1.0 - cs),
                        2.0 * PI * v / (total * total) * sn,
                    ]
                } else {
                    [0.5 * v * total + v * (t - total), v, 0.0, 0.0]
                };
                let step = smooth_step(t, total);
                let h = step.map(|d| 60_000.0 * d);
                let (pitch, roll) = (80f64.to_radians(), 60.0 * PI);
                let angles = [
                    NO_ANGLE,
                    Angle::new(pitch * (1.0 - step[0]), -pitch * step[1]),
                    Angle::new(roll * step[0], roll * step[1]),
                ];
                self.assemble(s, [0.0; 4], h, angles)
            }
        }
    }

    fn assemble(&self, s: Jet, y: Jet, h: Jet, [yaw, pitch, roll]: [Angle; 3]) -> Point {
        let rotation = from_yaw_pitch_roll(
            (yaw.cos, yaw.sin),
            (pitch.cos, pitch.sin),
            (roll.cos, roll.sin),
        );
        let rate = [
            roll.rate - yaw.rate * pitch.sin,
            pitch.rate * roll.cos + yaw.rate * pitch.cos * roll.sin,
            -pitch.rate * roll.sin + yaw.rate * pitch.cos * roll.cos,
        ];
        self.place_body(s, y, h, &rotation, rate)
    }

    /// Winds (s, y, h) onto the ellipsoid; `rotation` and its body rate are relative to the track frame [u, w, −n].
    fn place_body(&self, s: Jet, y: Jet, h: Jet, rotation: &Mat3, rate_tb_b: Vec3) -> Point {
        let k = 1.0 / SPHERE_R_M;
        let (a1, a2, b1, b2) = (k * s[1], k * s[2], k * y[1], k * y[2]);
        let (sa, ca) = (k * s[0]).sin_cos();
        let (sb, cb) = (k * y[0]).sin_cos();
        let m = axpy(scale(ca, self.n0), sa, self.u0);
        let u = axpy(scale(ca, self.u0), -sa, self.n0);
        let n = axpy(scale(cb, m), sb, self.w0);
        let w = axpy(scale(cb, self.w0), -sb, m);
        // u̇ = −Ȧ m, ẇ = −Ḃ n − sin B Ȧ u, ṅ = Ḃ w + cos B Ȧ u.
        let n1 = axpy(scale(b1, w), cb * a1, u);
        let w1 = axpy(scale(-b1, n), -sb * a1, u);
        let mut n2 = axpy(scale(b2, w), b1, w1);
        n2 = axpy(n2, cb * a2 - sb * b1 * a1, u);
        n2 = axpy(n2, -cb * a1 * a1, m);

        let e2 = self.earth.eccentricity_sq();
        let q = 1.0 / (1.0 - e2 * n[2] * n[2]);
        let nu = self.earth.semi_major_m() * q.sqrt();
        let q1 = 2.0 * e2 * n[2] * n1[2];
        let q2 = 2.0 * e2 * (n1[2] * n1[2] + n[2] * n2[2]);
        let nu1 = 0.5 * nu * q * q1;
        let nu2 = nu * q * (0.75 * q * q1 * q1 + 0.5 * q2);
        let height = self.height_m + h[0];
        let squash = |v: Vec3| [v[0], v[1], (1.0 - e2) * v[2]];
        let (d, d1, d2) = (squash(n), squash(n1), squash(n2));
        let position_e = axpy(scale(nu, d), height, n);
        let velocity_e = add(
            axpy(scale(nu1, d), nu, d1),
            axpy(scale(h[1], n), height, n1),
        );
        let mut acceleration_e = axpy(axpy(scale(nu2, d), 2.0 * nu1, d1), nu, d2);
        acceleration_e = axpy(
            axpy(axpy(acceleration_e, h[2], n), 2.0 * h[1], n1),
            height,
            n2,
        );

        let track = from_columns(u, w, scale(-1.0, n));
        // Rate of the track frame on its own axes: (Ḃ, −Ȧ cos B, Ȧ sin B).
        let rate_et_t = [b1, -a1 * cb, a1 * sb];
        Point {
            place: Place {
                normal_e: n,
                height_m: height,
            },
            position_e,
            velocity_e,
            acceleration_e,
            e_from_b: mul(&track, rotation),
            rate_eb_b: add(rate_tb_b, mul_vec_t(rotation, rate_et_t)),
        }
    }
}
