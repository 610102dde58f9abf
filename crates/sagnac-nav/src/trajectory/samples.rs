//! Interval means of specific force and rate by three-point Gauss quadrature, ∫ = (5f₁ + 8f₂ + 5f₃)/18
//! (navigation.md §1.4); of built-in trajectories, where they are smooth, from a series over many intervals (`panel.rs`).

use super::panel::Panels;
use super::{Motion, Trajectory};
use crate::attitude::{Vec3, axpy, dot, scale, sub};

/// The truth of one sample: means over its interval.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TruthSample {
    /// End of the interval, s.
    pub time_s: f64,
    /// Mean specific force, body axes, m/s².
    pub force_m_s2: Vec3,
    /// Mean rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vec3,
    /// Mean angular acceleration, (ω(t_k) − ω(t_{k−1}))/dt, rad/s².
    pub rate_dot_rad_s2: Vec3,
    /// Height above the ellipsoid at the interval's end, m.
    pub height_m: f64,
    /// Rate of that height at the interval's end, m/s: minus the down velocity.
    pub climb_m_s: f64,
}

const GAUSS: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const WEIGHT: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];
/// Longest panel of the quadrature, s: three points a panel are good to 1e-11 m/s² for the 1 Hz of `coning`.
const PANEL_S: f64 = 0.02;

/// A stream of [`TruthSample`]s; also seekable, so that blocks can be made on several threads.
#[derive(Debug, Clone)]
pub struct Samples<'a> {
    trajectory: &'a Trajectory,
    dt_s: f64,
    index: u64,
    /// Rate at the end of the sample of this number.
    last_rate: (u64, Vec3),
    constant: Option<TruthSample>,
    panels: Option<Panels>,
}

impl<'a> Samples<'a> {
    pub(super) fn new(trajectory: &'a Trajectory, dt_s: f64) -> Self {
        let start = trajectory.at(0.0);
        let last_rate = start.rate_b(trajectory.earth);
        let constant = trajectory.is_rest().then(|| TruthSample {
            time_s: 0.0,
            force_m_s2: start.force_b(trajectory.earth),
            rate_rad_s: last_rate,
            rate_dot_rad_s2: [0.0; 3],
            height_m: start.place.height_m,
            climb_m_s: 0.0,
        });
        Self {
            trajectory,
            dt_s,
            index: 0,
            last_rate: (0, last_rate),
            constant,
            panels: (trajectory.is_builtin() && !trajectory.is_rest())
                .then(|| Panels::new(trajectory, dt_s)),
        }
    }

    /// Every interval by quadrature.
    #[cfg(test)]
    pub(super) fn by_quadrature(self) -> Self {
        Self {
            panels: None,
            ..self
        }
    }

    /// Sampling interval, s.
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// Goes on after sample `index` (0: from the start). The samples that follow are the same bits as without the jump.
    pub fn seek(&mut self, index: u64) {
        self.index = index;
    }

    /// Position, velocity and attitude at the end of the sample given last.
    pub fn motion(&self) -> Motion {
        self.trajectory.motion(self.index as f64 * self.dt_s)
    }

    /// The next sample.
    pub fn next_sample(&mut self) -> TruthSample {
        let from = self.index as f64 * self.dt_s;
        self.index += 1;
        let to = self.index as f64 * self.dt_s;
        if let Some(mut sample) = self.constant {
            sample.time_s = to;
            return sample;
        }
        if let Some(panels) = &mut self.panels
            && let Some(sample) = panels.sample(self.trajectory, self.dt_s, self.index - 1)
        {
            return sample;
        }
        self.quadrature(from, to)
    }

    /// The sample that ends the interval (from, to], number `self.index`, by quadrature.
    fn quadrature(&mut self, from: f64, to: f64) -> TruthSample {
        if self.last_rate.0 + 1 != self.index {
            self.last_rate.1 = self.trajectory.at(from).rate_b(self.trajectory.earth);
        }
        let breaks = self.trajectory.breaks(from, to);
        let (mut force, mut rate) = ([0.0; 3], [0.0; 3]);
        let mut begin = from;
        for piece in 0..=breaks.len() {
            let end = breaks.get(piece).copied().unwrap_or(to);
            let panels = ((end - begin) / PANEL_S * (1.0 - 1e-9)).ceil().max(1.0);
            let width = (end - begin) / panels;
            for panel in 0..panels as u64 {
                for i in 0..3 {
                    let point = self
                        .trajectory
                        .at(begin + width * (panel as f64 + GAUSS[i]));
                    force = axpy(
                        force,
                        WEIGHT[i] * width,
                        point.force_b(self.trajectory.earth),
                    );
                    rate = axpy(rate, WEIGHT[i] * width, point.rate_b(self.trajectory.earth));
                }
            }
            begin = end;
        }
        let end_point = self.trajectory.at(to);
        let end_rate = end_point.rate_b(self.trajectory.earth);
        let rate_dot = scale(1.0 / self.dt_s, sub(end_rate, self.last_rate.1));
        self.last_rate = (self.index, end_rate);
        let k = 1.0 / (to - from);
        TruthSample {
            time_s: to,
            force_m_s2: scale(k, force),
            rate_rad_s: scale(k, rate),
            rate_dot_rad_s2: rate_dot,
            height_m: end_point.place.height_m,
            climb_m_s: dot(end_point.place.normal_e, end_point.velocity_e),
        }
    }

    /// Fills a block, the same values as one by one.
    pub fn fill(&mut self, block: &mut [TruthSample]) {
        for sample in block {
            *sample = self.next_sample();
        }
    }
}

impl Iterator for Samples<'_> {
    type Item = TruthSample;

    fn next(&mut self) -> Option<TruthSample> {
        Some(self.next_sample())
    }
}
