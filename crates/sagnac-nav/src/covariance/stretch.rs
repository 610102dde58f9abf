//! The linear error dynamics along the truth, in stretches: δṙ = δv, δv̇ = Γ δr + ε × f + C δf, ε̇ = C δω in inertial
//! axes, where the attitude error feeds nothing back and Γ is the gradient of gravitation (navigation.md §3.1).
//!
//! Within a stretch the response w(s) of the state at its end to a unit on a body axis at s is known from the velocity
//! V and position P that the specific force gains: an accelerometer gives (C(H − s), C, 0), a gyro
//! (c × P_s, c × V_s, c) with V_s = V(H) − V(s). Γ acts as a kick of half a stretch at both ends.

use super::source::Input;
use crate::attitude::{
    Mat3, Vec3, add, axpy, cross, dot, mul, mul_vec, mul_vec_t, norm, scale, sub, transpose,
};
use crate::earth::Earth;
use crate::strapdown::{BARO_TAU_S, BARO_VELOCITY_GAIN, Vertical};
use crate::trajectory::Trajectory;

/// The error state: position, velocity, attitude (inertial axes), and the barometric integral.
pub(super) const N: usize = 10;
pub(super) type Vector = [f64; N];
pub(super) const ZERO: Vector = [0.0; N];

/// Report times of a run.
pub const REPORTS: usize = 60;

/// Three-point Gauss: places, weights, and the weights of the integrals up to each place.
const GAUSS_C: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const GAUSS_B: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];
const GAUSS_A: [[f64; 3]; 3] = [
    [
        5.0 / 36.0,
        2.0 / 9.0 - 3.872_983_346_207_417 / 15.0,
        5.0 / 36.0 - 3.872_983_346_207_417 / 30.0,
    ],
    [
        5.0 / 36.0 + 3.872_983_346_207_417 / 24.0,
        2.0 / 9.0,
        5.0 / 36.0 - 3.872_983_346_207_417 / 24.0,
    ],
    [
        5.0 / 36.0 + 3.872_983_346_207_417 / 30.0,
        2.0 / 9.0 + 3.872_983_346_207_417 / 15.0,
        5.0 / 36.0,
    ],
];

/// One stretch.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) h_s: f64,
    /// Γ·H/2.
    kick: Mat3,
    /// ∫f and ∫∫f over the stretch.
    velocity: Vec3,
    position: Vec3,
    /// M_j of the six body axes.
    pub(super) moments: [[Vector; 3]; 6],
    /// Its fine nodes.
    pub(super) nodes: std::ops::Range<usize>,
    /// Constraint at the end: normal, gradient of the normal on the velocity, Ω.
    normal: Vec3,
    climb_gradient: Vec3,
    rate: f64,
    vertical: Vertical,
    /// Report number, if the end is a report time.
    pub(super) report: Option<usize>,
}

/// A fine node: the truth and the axes' responses times δs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) input: Input,
    pub(super) response: [Vector; 6],
}

/// How the state reads at a report time.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    n_from_i: Mat3,
    rate: f64,
}

impl View {
    /// Position, velocity and attitude errors in north, east, down.
    pub(super) fn local(&self, x: &Vector) -> [f64; 9] {
        let r = [x[0], x[1], x[2]];
        let v = sub([x[3], x[4], x[5]], cross([0.0, 0.0, self.rate], r));
        let (r, v, e) = (
            mul_vec(&self.n_from_i, r),
            mul_vec(&self.n_from_i, v),
            mul_vec(&self.n_from_i, [x[6], x[7], x[8]]),
        );
        [r[0], r[1], r[2], v[0], v[1], v[2], e[0], e[1], e[2]]
    }
}

/// The whole run, cut into stretches.
#[derive(Debug, Clone)]
pub struct Timeline {
    pub(super) stretches: Vec<Stretch>,
    pub(super) nodes: Vec<Node>,
    pub(super) views: Vec<View>,
    /// Report times, s.
    pub times_s: Vec<f64>,
    pub(super) earth: Earth,
    pub(super) start: Start,
    pub(super) duration_s: f64,
}

/// What alignment needs of the start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    pub(super) i_from_n: Mat3,
    pub(super) n_from_b: Mat3,
    pub(super) gravity: f64,
    pub(super) latitude_rad: f64,
}

/// The report times: i·T/60, i = 1…60, rounded to the nearest sample (at least the first).
pub fn report_times_s(duration_s: f64, dt_s: f64) -> Vec<f64> {
    (1..=REPORTS)
        .map(|i| {
            (i as f64 * duration_s / REPORTS as f64 / dt_s)
                .round()
                .max(1.0)
                * dt_s
        })
        .collect()
}

impl Timeline {
    /// Cuts a run of `duration_s` at sampling interval `dt_s`; `temperature` is T(t) in °C.
    pub fn new(
        trajectory: &Trajectory,
        duration_s: f64,
        dt_s: f64,
        vertical: Vertical,
        temperature: &dyn Fn(f64) -> f64,
    ) -> Self {
        let earth = trajectory.earth();
        let times_s = report_times_s(duration_s, dt_s);
        let fastest = fastest_rate(trajectory, duration_s);
        let rest = trajectory.is_rest();
        // Nodes fine enough for the turning of the body; at rest only the Earth turns.
        let node_s = if rest {
            60.0
        } else {
            (0.15 / fastest)
                .clamp(0.002, 0.05)
                .max(duration_s / 400_000.0)
        };
        let longest = if vertical == Vertical::Fixed {
            60.0f64
        } else {
            2.0f64
        };
        let mut out = Self {
            stretches: Vec::new(),
            nodes: Vec::new(),
            views: Vec::new(),
            times_s: times_s.clone(),
            earth,
            start: Start::new(trajectory),
            duration_s,
        };
        let mut begin = 0.0;
        for (report, &end) in times_s.iter().enumerate() {
            if end <= begin {
                // More reports than samples: the same instant again.
                out.views.push(view(trajectory, end));
                if let Some(last) = out.stretches.last_mut() {
                    last.report = Some(report);
                }
                continue;
            }
            let span = end - begin;
            let mut wanted = (duration_s / 1200.0).min(longest).min(span);
            if !rest {
                wanted = wanted.min(
                    (0.25 / fastest_between(trajectory, begin, end)).max(duration_s / 40_000.0),
                );
            }
            let count = (span / wanted).ceil().max(1.0);
            for i in 0..count as usize {
                let (from, to) = (
                    begin + span * i as f64 / count,
                    begin + span * (i + 1) as f64 / count,
                );
                let nodes = ((to - from) / node_s).ceil().max(2.0) as usize;
                out.add(trajectory, from, to, nodes, vertical, temperature);
            }
            if let Some(last) = out.stretches.last_mut() {
                last.report = Some(report);
            }
            out.views.push(view(trajectory, end));
            begin = end;
        }
        out
    }

    /// Latitude of the start, rad, and the Earth's rate, rad/s.
    pub fn place(&self) -> (f64, f64) {
        (self.start.latitude_rad, self.earth.rate_rad_s())
    }

    fn add(
        &mut self,
        trajectory: &Trajectory,
        from: f64,
        to: f64,
        count: usize,
        vertical: Vertical,
        temperature: &dyn Fn(f64) -> f64,
    ) {
        let earth = self.earth;
        let h = to - from;
        let panels = count.div_ceil(3);
        let step = h / panels as f64;
        let first = self.nodes.len();
        let mut velocity = [0.0; 3];
        let mut position = [0.0; 3];
        let mut gained = Vec::with_capacity(3 * panels);
        for panel in 0..panels {
            let begin = panel as f64 * step;
            let mut forces = [[0.0; 3]; 3];
            let mut axes = [[[0.0; 3]; 3]; 3];
            for i in 0..3 {
                let t = from + begin + GAUSS_C[i] * step;
                let point = trajectory.at(t);
                axes[i] = mul(&i_from_e(earth, t), &point.e_from_b);
                let force = point.force_b(earth);
                forces[i] = mul_vec(&axes[i], force);
                let rate_dot = if trajectory.is_rest() {
                    [0.0; 3]
                } else {
                    let d = 0.005f64.min(0.5 * step);
                    scale(
                        0.5 / d,
                        sub(
                            trajectory.at(t + d).rate_b(earth),
                            trajectory.at(t - d).rate_b(earth),
                        ),
                    )
                };
                self.nodes.push(Node {
                    input: Input {
                        force,
                        rate: point.rate_b(earth),
                        rate_dot,
                        time_s: t,
                        temperature_c: temperature(t),
                    },
                    response: [ZERO; 6],
                });
            }
            // Velocity and position at the nodes by the collocation weights of the same points.
            for i in 0..3 {
                let (mut v, mut p) = (velocity, axpy(position, GAUSS_C[i] * step, velocity));
                for j in 0..3 {
                    v = axpy(v, step * GAUSS_A[i][j], forces[j]);
                    let twice: f64 = (0..3).map(|k| GAUSS_A[i][k] * GAUSS_A[k][j]).sum();
                    p = axpy(p, step * step * twice, forces[j]);
                }
                gained.push((begin + GAUSS_C[i] * step, step * GAUSS_B[i], axes[i], v, p));
            }
            position = axpy(position, step, velocity);
            for j in 0..3 {
                position = axpy(
                    position,
                    step * step * GAUSS_B[j] * (1.0 - GAUSS_C[j]),
                    forces[j],
                );
                velocity = axpy(velocity, step * GAUSS_B[j], forces[j]);
            }
        }
        let mut moments = [[ZERO; 3]; 6];
        for (i, (s, step, c, v, p)) in gained.iter().enumerate() {
            let (s, step) = (*s, *step);
            let left = h - s;
            let late_velocity = sub(velocity, *v);
            let late_position = axpy(sub(position, *p), -left, *v);
            let x = 2.0 * s / h - 1.0;
            let legendre = [1.0, x, 1.5 * x * x - 0.5];
            let node = &mut self.nodes[first + i];
            for axis in 0..3 {
                let column = [c[0][axis], c[1][axis], c[2][axis]];
                let (dv, dr) = (cross(column, late_velocity), cross(column, late_position));
                for k in 0..3 {
                    node.response[axis][k] = step * dr[k];
                    node.response[axis][3 + k] = step * dv[k];
                    node.response[axis][6 + k] = step * column[k];
                    node.response[3 + axis][k] = step * left * column[k];
                    node.response[3 + axis][3 + k] = step * column[k];
                }
            }
            for axis in 0..6 {
                for j in 0..3 {
                    for k in 0..9 {
                        moments[axis][j][k] += legendre[j] * node.response[axis][k];
                    }
                }
            }
        }
        let point = trajectory.at(0.5 * (from + to));
        let turn = i_from_e(earth, 0.5 * (from + to));
        let middle = mul_vec(&turn, point.position_e);
        let (gamma, _) = gradients(earth, middle);
        let end = trajectory.at(to);
        let turn = i_from_e(earth, to);
        let (_, normal_gradient) = gradients(earth, mul_vec(&turn, end.position_e));
        self.stretches.push(Stretch {
            h_s: h,
            kick: gamma.map(|row| row.map(|g| 0.5 * h * g)),
            velocity,
            position,
            moments,
            nodes: first..self.nodes.len(),
            normal: mul_vec(&turn, end.place.normal_e),
            climb_gradient: mul_vec_t(&normal_gradient, mul_vec(&turn, end.velocity_e)),
            rate: earth.rate_rad_s(),
            vertical,
            report: None,
        });
    }
}

impl Stretch {
    /// The state at the end without new errors and before the vertical constraint.
    #[inline]
    pub(super) fn carry(&self, x: &Vector) -> Vector {
        let r = [x[0], x[1], x[2]];
        let e = [x[6], x[7], x[8]];
        let v = add([x[3], x[4], x[5]], mul_vec(&self.kick, r));
        let r = add(axpy(r, self.h_s, v), cross(e, self.position));
        let v = add(add(v, cross(e, self.velocity)), mul_vec(&self.kick, r));
        [r[0], r[1], r[2], v[0], v[1], v[2], e[0], e[1], e[2], x[9]]
    }

    /// The vertical channel at the end.
    #[inline]
    pub(super) fn constrain(&self, x: &mut Vector) {
        if self.vertical == Vertical::Free {
            return;
        }
        let r = [x[0], x[1], x[2]];
        let v = [x[3], x[4], x[5]];
        let height = dot(self.normal, r);
        let climb =
            dot(self.normal, sub(v, cross([0.0, 0.0, self.rate], r))) + dot(self.climb_gradient, r);
        let (dh, dc, integral) = match self.vertical {
            Vertical::Fixed => (height, climb, 0.0),
            _ => (
                3.0 / BARO_TAU_S * self.h_s * height,
                self.h_s * (BARO_VELOCITY_GAIN * height + x[9]),
                self.h_s / (BARO_TAU_S * BARO_TAU_S * BARO_TAU_S) * height,
            ),
        };
        for i in 0..3 {
            x[i] -= dh * self.normal[i];
            x[3 + i] -= dc * self.normal[i];
        }
        if self.vertical == Vertical::Fixed {
            // The climb is held for the position as it is after the height was set.
            let shift = scale(-dh, self.normal);
            let again = -dot(self.normal, cross([0.0, 0.0, self.rate], shift))
                + dot(self.climb_gradient, shift);
            for i in 0..3 {
                x[3 + i] -= again * self.normal[i];
            }
        }
        x[9] += integral;
    }
}

impl Start {
    fn new(trajectory: &Trajectory) -> Self {
        let point = trajectory.at(0.0);
        let e_from_n = point.place.e_from_n();
        Self {
            i_from_n: e_from_n,
            n_from_b: mul(&transpose(&e_from_n), &point.e_from_b),
            gravity: norm(trajectory.earth().gravity_e(&point.place)),
            latitude_rad: point.place.latitude_rad(),
        }
    }
}

pub(super) fn i_from_e(earth: Earth, t_s: f64) -> Mat3 {
    let (s, c) = (earth.rate_rad_s() * t_s).sin_cos();
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

fn view(trajectory: &Trajectory, t_s: f64) -> View {
    let earth = trajectory.earth();
    let i_from_n = mul(&i_from_e(earth, t_s), &trajectory.at(t_s).place.e_from_n());
    View {
        n_from_i: transpose(&i_from_n),
        rate: earth.rate_rad_s(),
    }
}

/// Gradients of gravitation and of the ellipsoid normal by central differences over ±1 km (relative error 1e-8).
fn gradients(earth: Earth, position: Vec3) -> (Mat3, Mat3) {
    let d = 1000.0;
    let (mut gamma, mut normal) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    for j in 0..3 {
        let (mut plus, mut minus) = (position, position);
        plus[j] += d;
        minus[j] -= d;
        let g = sub(earth.gravitation_e(plus), earth.gravitation_e(minus));
        let n = sub(earth.place(plus).normal_e, earth.place(minus).normal_e);
        for i in 0..3 {
            gamma[i][j] = g[i] / (2.0 * d);
            normal[i][j] = n[i] / (2.0 * d);
        }
    }
    (gamma, normal)
}

fn fastest_rate(trajectory: &Trajectory, duration_s: f64) -> f64 {
    if trajectory.is_rest() {
        1e-4
    } else {
        fastest_between(trajectory, 0.0, duration_s.min(3600.0))
    }
}

/// Largest rate relative to the Earth, rad/s, over a hundred or more instants.
fn fastest_between(trajectory: &Trajectory, from: f64, to: f64) -> f64 {
    let count = (((to - from) / 0.11).ceil() as usize).clamp(20, 400);
    (0..=count)
        .map(|i| {
            norm(
                trajectory
                    .at(from + (to - from) * i as f64 / count as f64)
                    .rate_eb_b,
            )
        })
        .fold(1e-4, f64::max)
}
