//! Error covariance: every independent source propagated alone along the true trajectory, P = Σ P_i (navigation.md §3.1).

mod reach;
mod shaping;
mod source;
mod stretch;

use crate::attitude::{Vec3, mul_vec};
use crate::ellipse::Horizontal;
pub use reach::Reach;
use shaping::{Discrete, ORDERS, STATES};
pub use shaping::{Process, flicker_ladder};
use source::Input;
pub use source::{Kind, Parameter, Sensitivity};
use std::collections::HashMap;
use stretch::{N, Stretch, Vector, ZERO};
pub use stretch::{REPORTS, Timeline, report_times_s};

/// How long a self-alignment stands still, s.
pub const SELF_ALIGNMENT_S: f64 = 600.0;

/// What the errors do at one report time, per unit of the source squared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// Horizontal position error, m².
    pub horizontal: Horizontal,
    /// Variances: north, east, down position; velocities; rotation vector ε.
    pub variance: [f64; 9],
}

/// A source's response at the report times.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Spread per unit.
    pub spread: Vec<Spread>,
    /// For random constants the error itself per unit, so that correlated ones can be joined.
    pub vector: Option<Vec<[f64; 9]>>,
}

/// The first-order link of the start's mean sensor error to the attitude error of a self-alignment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SelfAlignment {
    g: f64,
    rate_cos: f64,
    tan: f64,
    timeline: stretch::Start,
}

impl SelfAlignment {
    pub(crate) fn new(timeline: &Timeline) -> Self {
        let start = timeline.start;
        Self {
            g: start.gravity,
            rate_cos: timeline.earth.rate_rad_s() * start.latitude_rad.cos(),
            tan: start.latitude_rad.tan(),
            timeline: start,
        }
    }

    /// ε in north, east, down from mean errors of gyro and accelerometer on body axes.
    pub(crate) fn epsilon_n(&self, error: &[f64; 6]) -> Vec3 {
        let w = mul_vec(&self.timeline.n_from_b, [error[0], error[1], error[2]]);
        let f = mul_vec(&self.timeline.n_from_b, [error[3], error[4], error[5]]);
        [
            -f[1] / self.g,
            f[0] / self.g,
            -w[1] / self.rate_cos + f[1] / self.g * self.tan,
        ]
    }

    fn state(&self, error: &[f64; 6]) -> Vector {
        let e = mul_vec(&self.timeline.i_from_n, self.epsilon_n(error));
        let mut x = ZERO;
        x[6..9].copy_from_slice(&e);
        x
    }
}

/// Propagates sources along one timeline.
#[derive(Debug)]
pub struct Propagator<'a> {
    timeline: &'a Timeline,
    sensitivity: &'a Sensitivity,
    aligned: Option<SelfAlignment>,
    rest: Input,
}

impl<'a> Propagator<'a> {
    /// `self_aligned`: the start attitude comes from the sensor itself.
    pub fn new(
        timeline: &'a Timeline,
        sensitivity: &'a Sensitivity,
        self_aligned: bool,
        temperature_c: f64,
    ) -> Self {
        let start = timeline.start;
        let force = crate::attitude::mul_vec_t(&start.n_from_b, [0.0, 0.0, -start.gravity]);
        let (s, c) = start.latitude_rad.sin_cos();
        let omega = timeline.earth.rate_rad_s();
        let rate = crate::attitude::mul_vec_t(&start.n_from_b, [omega * c, 0.0, -omega * s]);
        Self {
            timeline,
            sensitivity,
            aligned: self_aligned.then(|| SelfAlignment::new(timeline)),
            rest: Input {
                force,
                rate,
                rate_dot: [0.0; 3],
                time_s: 0.0,
                temperature_c,
            },
        }
    }

    /// ε_D of a self-alignment per unit of a constant parameter, rad.
    pub fn heading_of(&self, parameter: Parameter) -> f64 {
        self.aligned.map_or(0.0, |a| {
            a.epsilon_n(&self.sensitivity.parameter(parameter, &self.rest))[2]
        })
    }

    /// Variance of ε_D of a self-alignment, rad², per unit of a source squared.
    pub fn heading_variance(&self, kind: Kind) -> f64 {
        let Some(aligned) = self.aligned else {
            return 0.0;
        };
        match kind {
            Kind::Constant(p) => {
                aligned.epsilon_n(&self.sensitivity.parameter(p, &self.rest))[2].powi(2)
            }
            Kind::Process {
                sensor,
                axis,
                process,
            } => {
                let e = aligned.epsilon_n(&self.sensitivity.direction(sensor, axis))[2];
                process
                    .mean_before(SELF_ALIGNMENT_S)
                    .map_or(0.0, |(variance, _)| variance * e * e)
            }
            Kind::Flicker { sensor, axis } => {
                let e = aligned.epsilon_n(&self.sensitivity.direction(sensor, axis))[2];
                let sum: f64 = flicker_ladder(self.timeline.duration_s)
                    .iter()
                    .filter_map(|(s, t)| {
                        Process::GaussMarkov {
                            correlation_time_s: *t,
                        }
                        .mean_before(SELF_ALIGNMENT_S)
                        .map(|(v, _)| s * s * v)
                    })
                    .sum();
                sum * e * e
            }
            _ => 0.0,
        }
    }

    /// The response of one source.
    pub fn respond(&self, kind: Kind) -> Response {
        match kind {
            Kind::Constant(p) => {
                let initial = self.aligned.map_or(ZERO, |a| {
                    a.state(&self.sensitivity.parameter(p, &self.rest))
                });
                self.constant(initial, &|input| self.sensitivity.parameter(p, input))
            }
            Kind::Ramp { sensor, axis } => {
                let direction = self.sensitivity.direction(sensor, axis);
                self.constant(ZERO, &|input| direction.map(|d| d * input.time_s))
            }
            Kind::Mean => {
                let initial = self
                    .aligned
                    .map_or(ZERO, |a| a.state(&self.sensitivity.mean(&self.rest)));
                self.constant(initial, &|input| self.sensitivity.mean(input))
            }
            Kind::Alignment(about) => {
                let start = self.timeline.start;
                let heading = start.n_from_b[1][0].atan2(start.n_from_b[0][0]);
                let (s, c) = heading.sin_cos();
                let epsilon = match about {
                    0 => [c, s, 0.0],
                    1 => [-s, c, 0.0],
                    _ => [0.0, 0.0, 1.0],
                };
                let e = mul_vec(&start.i_from_n, epsilon);
                let mut x = ZERO;
                x[6..9].copy_from_slice(&e);
                self.constant(x, &|_| [0.0; 6])
            }
            Kind::Process {
                sensor,
                axis,
                process,
            } => self.random(&self.sensitivity.direction(sensor, axis), &[(1.0, process)]),
            Kind::Flicker { sensor, axis } => {
                let ladder: Vec<(f64, Process)> = flicker_ladder(self.timeline.duration_s)
                    .iter()
                    .map(|(s, t)| {
                        (
                            *s,
                            Process::GaussMarkov {
                                correlation_time_s: *t,
                            },
                        )
                    })
                    .collect();
                self.random(&self.sensitivity.direction(sensor, axis), &ladder)
            }
        }
    }

    fn constant(&self, initial: Vector, error: &dyn Fn(&Input) -> [f64; 6]) -> Response {
        let mut x = initial;
        let mut spread = Vec::with_capacity(REPORTS);
        let mut vectors = Vec::with_capacity(REPORTS);
        for stretch in &self.timeline.stretches {
            x = stretch.carry(&x);
            for node in &self.timeline.nodes[stretch.nodes.clone()] {
                let u = error(&node.input);
                for axis in 0..6 {
                    if u[axis] != 0.0 {
                        for k in 0..9 {
                            x[k] += u[axis] * node.response[axis][k];
                        }
                    }
                }
            }
            stretch.constrain(&mut x);
            if let Some(report) = stretch.report {
                while vectors.len() <= report {
                    let local = self.timeline.views[vectors.len()].local(&x);
                    vectors.push(local);
                    spread.push(Spread {
                        horizontal: Horizontal {
                            north_north: local[0] * local[0],
                            north_east: local[0] * local[1],
                            east_east: local[1] * local[1],
                            mean: [0.0; 2],
                        },
                        variance: local.map(|v| v * v),
                    });
                }
            }
        }
        Response {
            spread,
            vector: Some(vectors),
        }
    }

    fn random(&self, direction: &[f64; 6], processes: &[(f64, Process)]) -> Response {
        let mut p = [ZERO; N];
        let mut filters: Vec<Filter> = processes
            .iter()
            .map(|(sigma, process)| Filter::new(*sigma, *process))
            .collect();
        if let Some(aligned) = self.aligned {
            let e = aligned.state(direction);
            for filter in &mut filters {
                if let Some((variance, with_end)) = filter.process.mean_before(SELF_ALIGNMENT_S) {
                    let power = filter.sigma * filter.sigma;
                    for i in 6..9 {
                        for j in 6..9 {
                            p[i][j] += power * variance * e[i] * e[j];
                        }
                        filter.cross[0][i] += power * with_end * e[i];
                    }
                }
            }
        }
        let mut spread = Vec::with_capacity(REPORTS);
        for stretch in &self.timeline.stretches {
            advance(&mut p, &mut filters, direction, stretch);
            if let Some(report) = stretch.report {
                while spread.len() <= report {
                    spread.push(self.read(&p, spread.len()));
                }
            }
        }
        Response {
            spread,
            vector: None,
        }
    }

    fn read(&self, p: &[Vector; N], report: usize) -> Spread {
        let view = &self.timeline.views[report];
        // L P Lᵀ: columns first, then rows.
        let half: [[f64; 9]; N] =
            std::array::from_fn(|j| view.local(&std::array::from_fn(|i| p[i][j])));
        let full: [[f64; 9]; 9] =
            std::array::from_fn(|i| view.local(&std::array::from_fn(|j| half[j][i])));
        Spread {
            horizontal: Horizontal {
                north_north: full[0][0],
                north_east: 0.5 * (full[0][1] + full[1][0]),
                east_east: full[1][1],
                mean: [0.0; 2],
            },
            variance: std::array::from_fn(|i| full[i][i]),
        }
    }
}

/// One shaping filter with its covariance with the error state.
#[derive(Debug)]
struct Filter {
    sigma: f64,
    process: Process,
    states: [[f64; STATES]; STATES],
    cross: [Vector; STATES],
    discrete: HashMap<u64, Discrete>,
}

impl Filter {
    fn new(sigma: f64, process: Process) -> Self {
        let states = process.initial().map(|row| row.map(|v| v * sigma * sigma));
        Self {
            sigma,
            process,
            states,
            cross: [ZERO; STATES],
            discrete: HashMap::new(),
        }
    }
}

/// P over one stretch: P ← T P Tᵀ + K Bᵀ + B Kᵀ + M (A P_pp Aᵀ + Q) Mᵀ with K = T P_xp, B = M A.
fn advance(p: &mut [Vector; N], filters: &mut [Filter], direction: &[f64; 6], stretch: &Stretch) {
    let mut m = [ZERO; ORDERS];
    for axis in 0..6 {
        if direction[axis] != 0.0 {
            for j in 0..ORDERS {
                for k in 0..9 {
                    m[j][k] += direction[axis] * stretch.moments[axis][j][k];
                }
            }
        }
    }
    // P is symmetric: its rows are its columns.
    let mut half = [ZERO; N];
    for i in 0..N {
        half[i] = stretch.carry(&p[i]);
    }
    for i in 0..N {
        let column: Vector = std::array::from_fn(|j| half[j][i]);
        p[i] = stretch.carry(&column);
    }
    let mut inner = [[0.0; ORDERS]; ORDERS];
    // Σ K Aᵀ of the filters: 10 × 3.
    let mut link = [ZERO; ORDERS];
    for filter in filters.iter_mut() {
        let power = filter.sigma * filter.sigma;
        let d = *filter
            .discrete
            .entry(stretch.h_s.to_bits())
            .or_insert_with(|| filter.process.over(stretch.h_s));
        let k: [Vector; STATES] = std::array::from_fn(|s| stretch.carry(&filter.cross[s]));
        for j in 0..ORDERS {
            for s in 0..STATES {
                if d.map[j][s] != 0.0 {
                    for i in 0..9 {
                        link[j][i] += k[s][i] * d.map[j][s];
                    }
                }
            }
            for l in 0..ORDERS {
                let mut sum = power * d.q_gg[j][l];
                for s in 0..STATES {
                    for r in 0..STATES {
                        sum += d.map[j][s] * filter.states[s][r] * d.map[l][r];
                    }
                }
                inner[j][l] += sum;
            }
        }
        // P_xp ← (K + M A P_pp) Φᵀ + M Q_gp.
        let mut mixed = k;
        for s in 0..STATES {
            for j in 0..ORDERS {
                let factor: f64 = (0..STATES).map(|r| d.map[j][r] * filter.states[r][s]).sum();
                for i in 0..9 {
                    mixed[s][i] += m[j][i] * factor;
                }
            }
        }
        for s in 0..STATES {
            let mut next = ZERO;
            for i in 0..N {
                for r in 0..STATES {
                    next[i] += mixed[r][i] * d.phi[s][r];
                }
                for j in 0..ORDERS {
                    next[i] += power * m[j][i] * d.q_gp[j][s];
                }
            }
            stretch.constrain(&mut next);
            filter.cross[s] = next;
        }
        let old = filter.states;
        for s in 0..STATES {
            for r in 0..STATES {
                let mut sum = power * d.q_pp[s][r];
                for a in 0..STATES {
                    for b in 0..STATES {
                        sum += d.phi[s][a] * old[a][b] * d.phi[r][b];
                    }
                }
                filter.states[s][r] = sum;
            }
        }
    }
    let mut weighted = [ZERO; ORDERS];
    for j in 0..ORDERS {
        for l in 0..ORDERS {
            for i in 0..9 {
                weighted[j][i] += inner[j][l] * m[l][i];
            }
        }
    }
    for a in 0..9 {
        for b in 0..9 {
            let mut sum = 0.0;
            for j in 0..ORDERS {
                sum += link[j][a] * m[j][b] + m[j][a] * link[j][b] + m[j][a] * weighted[j][b];
            }
            p[a][b] += sum;
        }
    }
    for row in p.iter_mut() {
        stretch.constrain(row);
    }
    for i in 0..N {
        let mut column: Vector = std::array::from_fn(|j| p[j][i]);
        stretch.constrain(&mut column);
        for j in 0..N {
            p[j][i] = column[j];
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::earth::{Earth, SPHERE_R_M, STANDARD_GRAVITY_M_S2};
    use crate::strapdown::Vertical;
    use crate::trajectory::{Start, Trajectory};
    use sagnac_core::{Axis, Measurement, Sensor, SensorModel};

    type Form<'a> = &'a dyn Fn(f64) -> f64;

    fn perfect() -> Sensitivity {
        let one = crate::attitude::IDENTITY;
        Sensitivity {
            gyro: one,
            accel: one,
            coupling: [[0.0; 3]; 3],
            reference_c: 25.0,
            forward: Measurement::new(&SensorModel::default()),
        }
    }

    fn rest(duration_s: f64, kinds: &[Kind]) -> Vec<Vec<Spread>> {
        let tr = Trajectory::named("rest", Earth::Sphere, &Start::default()).unwrap();
        let timeline = Timeline::new(&tr, duration_s, 0.01, Vertical::Fixed, &|_| 25.0);
        let sensitivity = perfect();
        let propagator = Propagator::new(&timeline, &sensitivity, false, 25.0);
        kinds
            .iter()
            .map(|k| propagator.respond(*k).spread)
            .collect()
    }

    #[test]
    fn closed_forms_over_three_hours() {
        // navigation.md §3.5; heading north: accelerometer x is north, gyro y tilts about east and moves north.
        let w = (STANDARD_GRAVITY_M_S2 / SPHERE_R_M).sqrt();
        let bias = |sensor, axis| {
            Kind::Constant(Parameter::Bias {
                sensor,
                axis,
                power: 0,
            })
        };
        let white = |sensor, axis| Kind::Process {
            sensor,
            axis,
            process: Process::White,
        };
        let kinds = [
            bias(Sensor::Accel, Axis::X),
            bias(Sensor::Gyro, Axis::Y),
            white(Sensor::Accel, Axis::X),
            white(Sensor::Gyro, Axis::Y),
            Kind::Alignment(1),
        ];
        let g = STANDARD_GRAVITY_M_S2;
        for (duration, short) in [(3.0 * 3600.0, false), (240.0, true)] {
            let responses = rest(duration, &kinds);
            let worst_of = |k: usize, want: &dyn Fn(f64) -> f64, peak: f64| {
                let mut worst = 0.0f64;
                for (i, s) in responses[k].iter().enumerate() {
                    let t = duration * (i + 1) as f64 / 60.0;
                    worst = worst.max(
                        (s.horizontal.north_north.sqrt() - want(t).abs()).abs()
                            / want(t).abs().max(0.02 * peak),
                    );
                }
                worst
            };
            let r = SPHERE_R_M;
            let forms: [(Form, Form); 5] = [
                (&|t| (1.0 - (w * t).cos()) / (w * w), &|t| t * t / 2.0),
                (&|t| r * (t - (w * t).sin() / w), &|t| g * t.powi(3) / 6.0),
                (
                    &|t| ((t - (2.0 * w * t).sin() / (2.0 * w)) / (2.0 * w * w)).sqrt(),
                    &|t| (t.powi(3) / 3.0).sqrt(),
                ),
                (
                    &|t| {
                        r * (1.5 * t - 2.0 * (w * t).sin() / w + (2.0 * w * t).sin() / (4.0 * w))
                            .sqrt()
                    },
                    &|t| g * (t.powi(5) / 20.0).sqrt(),
                ),
                (&|t| r * (1.0 - (w * t).cos()), &|t| g * t * t / 2.0),
            ];
            for (k, (schuler, brief)) in forms.iter().enumerate() {
                let exact = worst_of(
                    k,
                    schuler,
                    schuler(duration).abs().max(schuler(0.25 * duration)),
                );
                assert!(exact < 1e-3, "{k} {duration}: {exact}");
                if short {
                    assert!(worst_of(k, brief, 0.0) < 0.01, "{k}");
                }
            }
        }
    }

    #[test]
    fn lecture_rows_on_the_real_earth() {
        // navigation.md §4 ▸: navigation row 0.01 deg/h, 50 ug: CEP 0.895 nmi after 1 h perfectly aligned, 0.496 self-aligned.
        let tr = Trajectory::named("rest", Earth::Wgs84, &Start::default()).unwrap();
        let deg_h = std::f64::consts::PI / 180.0 / 3600.0;
        let sensitivity = perfect();
        for (gyro, accel, hours, want) in [
            (0.01, 50.0, 1.0, [0.895, 0.496]),
            (0.005, 30.0, 1.0, [0.455, 0.248]),
            (0.005, 30.0, 24.0, [3.45, 3.45]),
            (1.0, 1000.0, 1.0, [86.0, 49.5]),
        ] {
            let timeline = Timeline::new(&tr, hours * 3600.0, 0.01, Vertical::Fixed, &|_| 25.0);
            for (self_aligned, want) in [(false, want[0]), (true, want[1])] {
                let propagator = Propagator::new(&timeline, &sensitivity, self_aligned, 25.0);
                let mut total = Horizontal::default();
                for axis in Axis::ALL {
                    for (sensor, sigma) in [
                        (Sensor::Gyro, gyro * deg_h),
                        (Sensor::Accel, accel * 9.80665e-6),
                    ] {
                        let response = propagator.respond(Kind::Constant(Parameter::Bias {
                            sensor,
                            axis,
                            power: 0,
                        }));
                        total = total.plus(&response.spread[59].horizontal, sigma * sigma);
                    }
                }
                let cep = total.radius_m(0.5) / 1852.0;
                assert!(
                    (cep / want - 1.0).abs() < 6e-3,
                    "{gyro} {hours} {self_aligned}: {cep} {want}"
                );
            }
        }
    }

    #[test]
    fn flicker_is_near_the_random_constant_of_the_slow_end() {
        // A unit B over an hour acts like a constant of about B√(ln(…)): bounded by its own variance at every scale.
        let kind = Kind::Flicker {
            sensor: Sensor::Accel,
            axis: Axis::X,
        };
        let constant = Kind::Constant(Parameter::Bias {
            sensor: Sensor::Accel,
            axis: Axis::X,
            power: 0,
        });
        let r = rest(3600.0, &[kind, constant]);
        let ratio = (r[0][59].horizontal.north_north / r[1][59].horizontal.north_north).sqrt();
        assert!(ratio > 0.8 && ratio < 1.6, "{ratio}");
    }
}
