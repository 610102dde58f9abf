//! Interval means of a smooth motion from few instants: over a panel of up to 128 intervals specific force, rate, height
//! and climb are Chebyshev series through 16 instants, Σ c_j T_j(u), whose means over each interval,
//! ∫T_j du = ½(T_{j+1}/(j+1) − T_{j−1}/(j−1)), and ends are sums of 16 products.
//!
//! A panel whose last three coefficients are not rounding alone is halved, down to 8 intervals; what is not smooth enough for
//! those is left to the quadrature of every interval. Panels begin at multiples of their length, so that a sample is
//! the same bits wherever a stream begins.

use super::{Point, Trajectory, TruthSample};
use std::f64::consts::PI;
use std::sync::Arc;

const NODES: usize = 16;
const SIZES: [usize; 5] = [128, 64, 32, 16, 8];
/// Force and rate on three axes, height, climb.
const COLUMNS: usize = 8;
/// Largest last coefficient, m/s², rad/s, m and m/s, absolute and per unit of the largest coefficient.
const LIMITS: [f64; COLUMNS] = [1e-12, 1e-12, 1e-12, 1e-15, 1e-15, 1e-15, 1e-10, 1e-12];
const RELATIVE: [f64; COLUMNS] = [1e-13, 1e-13, 1e-13, 1e-14, 1e-14, 1e-14, 1e-14, 1e-14];

type Series = [[f64; NODES]; COLUMNS];

/// T_j's mean over each interval and value at each end, the start of the panel first.
struct Weights {
    mean: Vec<[f64; NODES]>,
    end: Vec<[f64; NODES]>,
}

impl Weights {
    fn new(size: usize) -> Self {
        let at = |k: usize| 2.0 * k as f64 / size as f64 - 1.0;
        let chebyshev = |u: f64| {
            let mut t = [1.0; NODES + 1];
            t[1] = u;
            for j in 2..=NODES {
                t[j] = 2.0 * u * t[j - 1] - t[j - 2];
            }
            t
        };
        let ends: Vec<[f64; NODES + 1]> = (0..=size).map(|k| chebyshev(at(k))).collect();
        let antiderivative = |t: &[f64; NODES + 1], j: usize| {
            0.5 * (t[j + 1] / (j as f64 + 1.0) - t[j - 1] / (j as f64 - 1.0))
        };
        Self {
            mean: (0..size)
                .map(|k| {
                    std::array::from_fn(|j| match j {
                        0 => 1.0,
                        1 => 0.5 * (at(k) + at(k + 1)),
                        _ => {
                            (antiderivative(&ends[k + 1], j) - antiderivative(&ends[k], j))
                                * (0.5 * size as f64)
                        }
                    })
                })
                .collect(),
            end: ends.iter().map(|t| std::array::from_fn(|j| t[j])).collect(),
        }
    }
}

/// The panel that a stream is in.
#[derive(Clone)]
pub(super) struct Panels {
    weights: Arc<[Weights; SIZES.len()]>,
    /// cos jθ_i at the nodes θ_i = π(i + ½)/16.
    cosines: Arc<[[f64; NODES]; NODES]>,
    /// The largest size that the start of the motion allows: larger ones are not tried.
    largest: usize,
    /// Number of the first sample that is ready, and those ready.
    first: u64,
    ready: Vec<TruthSample>,
    /// The panel of each size that was tried last and is not smooth, counted from 1.
    rough: [u64; SIZES.len()],
}

impl std::fmt::Debug for Panels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Panels")
            .field("first", &self.first)
            .finish_non_exhaustive()
    }
}

impl Panels {
    pub(super) fn new(trajectory: &Trajectory, dt_s: f64) -> Self {
        let mut new = Self {
            weights: Arc::new(SIZES.map(Weights::new)),
            cosines: Arc::new(std::array::from_fn(|j| {
                std::array::from_fn(|i| (j as f64 * PI * (i as f64 + 0.5) / NODES as f64).cos())
            })),
            largest: SIZES.len(),
            first: 0,
            ready: Vec::new(),
            rough: [0; SIZES.len()],
        };
        new.largest = (0..SIZES.len())
            .find(|level| new.fill(trajectory, dt_s, *level, 0))
            .unwrap_or(SIZES.len());
        new
    }

    /// Sample `index`, counted from 0; `None` where the motion is not smooth.
    pub(super) fn sample(
        &mut self,
        trajectory: &Trajectory,
        dt_s: f64,
        index: u64,
    ) -> Option<TruthSample> {
        if !(self.first..self.first + self.ready.len() as u64).contains(&index) {
            let found = (self.largest..SIZES.len()).any(|level| {
                let panel = index / SIZES[level] as u64;
                self.rough[level] != panel + 1 && self.fill(trajectory, dt_s, level, panel)
            });
            if !found {
                self.ready.clear();
                return None;
            }
        }
        self.ready.get((index - self.first) as usize).copied()
    }

    /// Makes a panel ready, or marks it as rough.
    fn fill(&mut self, trajectory: &Trajectory, dt_s: f64, level: usize, panel: u64) -> bool {
        let size = SIZES[level];
        let first = panel * size as u64;
        let half = 0.5 * size as f64 * dt_s;
        let middle = first as f64 * dt_s + half;
        let mut series: Series = [[0.0; NODES]; COLUMNS];
        for i in 0..NODES {
            let values = columns(
                &trajectory.at(middle + half * self.cosines[1][i]),
                trajectory,
            );
            for (of, value) in series.iter_mut().zip(values) {
                for (j, c) in of.iter_mut().enumerate() {
                    let share = if j == 0 { 1.0 } else { 2.0 };
                    *c += share / NODES as f64 * self.cosines[j][i] * value;
                }
            }
        }
        let smooth = series.iter().enumerate().all(|(column, of)| {
            let largest = of.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            let limit = LIMITS[column] + RELATIVE[column] * largest;
            of[NODES - 3..].iter().all(|c| c.abs() <= limit)
        });
        if !smooth {
            self.rough[level] = panel + 1;
            return false;
        }
        let weights = &self.weights[level];
        let sum = |column: usize, w: &[f64; NODES]| {
            let mut sum = [0.0; 4];
            for j in 0..NODES / 4 {
                for lane in 0..4 {
                    sum[lane] += series[column][4 * j + lane] * w[4 * j + lane];
                }
            }
            (sum[0] + sum[2]) + (sum[1] + sum[3])
        };
        let three =
            |from: usize, w: &[f64; NODES]| [sum(from, w), sum(from + 1, w), sum(from + 2, w)];
        let mut before = three(3, &weights.end[0]);
        self.first = first;
        self.ready.clear();
        for k in 0..size {
            let end = &weights.end[k + 1];
            let rate = three(3, end);
            self.ready.push(TruthSample {
                time_s: (first + k as u64 + 1) as f64 * dt_s,
                force_m_s2: three(0, &weights.mean[k]),
                rate_rad_s: three(3, &weights.mean[k]),
                rate_dot_rad_s2: std::array::from_fn(|i| (rate[i] - before[i]) / dt_s),
                height_m: sum(6, end),
                climb_m_s: sum(7, end),
            });
            before = rate;
        }
        true
    }
}

fn columns(point: &Point, trajectory: &Trajectory) -> [f64; COLUMNS] {
    let (f, w) = (
        point.force_b(trajectory.earth()),
        point.rate_b(trajectory.earth()),
    );
    let climb = crate::attitude::dot(point.place.normal_e, point.velocity_e);
    [
        f[0],
        f[1],
        f[2],
        w[0],
        w[1],
        w[2],
        point.place.height_m,
        climb,
    ]
}
