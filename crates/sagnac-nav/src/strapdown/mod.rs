//! Strapdown integration of a stream of interval means (navigation.md §2), for one run or several side by side.
//!
//! ```
//! use sagnac_nav::strapdown::{Sculling, Strapdown, Vertical};
//! use sagnac_nav::{Earth, Start, Trajectory};
//! let walk = Trajectory::named("walking", Earth::Wgs84, &Start::default())?;
//! let mut nav = Strapdown::<1>::new(Earth::Wgs84, Sculling::Five, Vertical::Free, [walk.at(0.0).into()]);
//! for s in walk.samples(0.01).take(1000) {
//!     nav.push(0.01, &s.rate_rad_s.map(|x| [x]), &s.force_m_s2.map(|x| [x]), [s.height_m, s.climb_m_s]);
//! }
//! nav.finish();
//! let error = nav.state(0).position_error_m(&walk.at(10.0));
//! assert!(error < 1e-6);
//! # Ok::<(), sagnac_nav::Error>(())
//! ```

mod kernel;
mod weights;

use crate::attitude::{
    Mat3, Vec3, add, cross, from_quaternion, mul, mul_vec, mul_vec_t, norm, sub, to_quaternion,
    transpose,
};
use crate::earth::Earth;
use crate::trajectory::{Motion, Point};
pub use kernel::Lanes;
use kernel::{Field, Hold};
pub use weights::Sculling;
use weights::Weights;

/// What holds the vertical channel, which by itself is unstable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Vertical {
    /// Nothing.
    Free,
    /// Height and down velocity are set to the truth's after every step.
    #[default]
    Fixed,
    /// A third-order loop on error-free height, gains 3/τ, 3/τ² + 2g/R, 1/τ³ with τ = 100 s.
    Baro,
}

/// Time constant of the barometric loop, s.
pub const BARO_TAU_S: f64 = 100.0;
/// Gain of the barometric loop's velocity, 3/τ² + 2g/R, 1/s².
pub const BARO_VELOCITY_GAIN: f64 = 3.0 / (BARO_TAU_S * BARO_TAU_S)
    + 2.0 * crate::earth::STANDARD_GRAVITY_M_S2 / crate::earth::SPHERE_R_M;

/// A navigation state, Earth axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position, m.
    pub position_e: Vec3,
    /// Velocity relative to the Earth, m/s.
    pub velocity_e: Vec3,
    /// Body → Earth.
    pub e_from_b: Mat3,
}

impl From<Point> for State {
    fn from(p: Point) -> Self {
        Self {
            position_e: p.position_e,
            velocity_e: p.velocity_e,
            e_from_b: p.e_from_b,
        }
    }
}

impl State {
    /// 3-D distance to the truth, m.
    pub fn position_error_m(&self, truth: &Point) -> f64 {
        norm(sub(self.position_e, truth.position_e))
    }

    /// In the words of a log.
    pub fn motion(&self, earth: Earth) -> Motion {
        let place = earth.place(self.position_e);
        let e_from_n = place.e_from_n();
        Motion::from_local(
            &place,
            mul_vec_t(&e_from_n, self.velocity_e),
            &mul(&transpose(&e_from_n), &self.e_from_b),
        )
    }
}

/// One sample of every lane: gyro x, y, z, accelerometer x, y, z.
pub type LaneSample<const L: usize> = [[f64; L]; 6];

/// The integrator. Samples are pushed; steps follow as soon as their window is complete, two samples late for
/// [`Sculling::Five`], and all by [`Strapdown::finish`].
#[derive(Debug, Clone)]
pub struct Strapdown<const L: usize> {
    earth: Earth,
    field: Field,
    sculling: Sculling,
    vertical: Vertical,
    lanes: Lanes<L>,
    /// Samples from the oldest that a window still needs, by channel, all lanes of a step together.
    queue: [Vec<f64>; 6],
    steps: Vec<[f64; 3]>,
    /// Steps made before the queue's first sample.
    base: u64,
    done: u64,
    time_s: f64,
    finished: bool,
    centred: Weights,
}

impl<const L: usize> Strapdown<L> {
    /// From the states of the lanes at t = 0.
    pub fn new(earth: Earth, sculling: Sculling, vertical: Vertical, initial: [State; L]) -> Self {
        let field = Field::new(earth);
        let mut lanes = Lanes {
            q: [[0.0; L]; 4],
            v: [[0.0; L]; 3],
            r: [[0.0; L]; 3],
            gravitation: [[0.0; L]; 3],
            baro: [[0.0; L]],
            q_rest: [[0.0; L]; 4],
        };
        for (l, s) in initial.iter().enumerate() {
            let q = to_quaternion(&s.e_from_b);
            let v = add(
                s.velocity_e,
                cross([0.0, 0.0, earth.rate_rad_s()], s.position_e),
            );
            let g = kernel::gravitation(&field, s.position_e);
            for i in 0..4 {
                lanes.q[i][l] = q[i];
            }
            for i in 0..3 {
                lanes.v[i][l] = v[i];
                lanes.r[i][l] = s.position_e[i];
                lanes.gravitation[i][l] = g[i];
            }
        }
        let centred = match sculling {
            Sculling::Two => Weights::new(2, 1),
            Sculling::Five => Weights::new(5, 2),
        };
        Self {
            earth,
            field,
            sculling,
            vertical,
            lanes,
            queue: std::array::from_fn(|_| Vec::new()),
            steps: Vec::new(),
            base: 0,
            done: 0,
            time_s: 0.0,
            finished: false,
            centred,
        }
    }

    /// Adds one sample: the interval's length, means of rate (rad/s) and specific force (m/s²) by axis and lane, and the
    /// true [height m, climb m/s] at its end (used unless the vertical channel is free).
    pub fn push(
        &mut self,
        dt_s: f64,
        rate: &[[f64; L]; 3],
        force: &[[f64; L]; 3],
        truth: [f64; 2],
    ) {
        self.feed(
            dt_s,
            &[rate[0], rate[1], rate[2], force[0], force[1], force[2]],
            truth,
        );
        self.run_to(u64::MAX);
    }

    /// Queues one sample without stepping.
    pub fn feed(&mut self, dt_s: f64, sample: &LaneSample<L>, truth: [f64; 2]) {
        self.forget();
        for (channel, lanes) in self.queue.iter_mut().zip(sample) {
            channel.extend_from_slice(lanes);
        }
        self.steps.push([dt_s, truth[0], truth[1]]);
    }

    /// Queues samples `dt_s` apart without stepping, as many as both slices hold.
    pub fn feed_block(&mut self, dt_s: f64, samples: &[LaneSample<L>], truth: &[[f64; 2]]) {
        let count = samples.len().min(truth.len());
        self.forget();
        for (c, channel) in self.queue.iter_mut().enumerate() {
            channel.extend(samples[..count].iter().flat_map(|sample| sample[c]));
        }
        self.steps
            .extend(truth[..count].iter().map(|t| [dt_s, t[0], t[1]]));
    }

    /// The same from one row by channel for each of the `L` lanes, `rows[lane][channel][sample]`, as many samples as `truth`
    /// and a row hold.
    pub(crate) fn feed_rows<const N: usize>(
        &mut self,
        dt_s: f64,
        rows: [&[[f64; N]; 6]; L],
        truth: &[[f64; 2]],
    ) {
        let count = truth.len().min(N);
        self.forget();
        for (c, channel) in self.queue.iter_mut().enumerate() {
            let begin = channel.len();
            channel.resize(begin + count * L, 0.0);
            let rows: [&[f64; N]; L] = std::array::from_fn(|l| &rows[l][c]);
            for (k, to) in channel[begin..]
                .as_chunks_mut::<L>()
                .0
                .iter_mut()
                .enumerate()
            {
                *to = std::array::from_fn(|l| rows[l][k]);
            }
        }
        self.steps
            .extend(truth[..count].iter().map(|t| [dt_s, t[0], t[1]]));
    }

    /// Drops the samples that are no longer in any window, when they are most of the queue.
    fn forget(&mut self) {
        let used = (self.done.saturating_sub(4).saturating_sub(self.base)) as usize;
        if used >= 256 && 8 * used > 7 * self.steps.len() {
            for channel in &mut self.queue {
                channel.drain(..used * L);
            }
            self.steps.drain(..used);
            self.base += used as u64;
        }
    }

    /// Declares the record complete, so that [`Self::run_to`] can go to its end.
    pub fn close(&mut self) {
        self.finished = true;
    }

    /// Declares the record complete and makes the remaining steps.
    pub fn finish(&mut self) {
        self.close();
        self.run_to(u64::MAX);
    }

    /// Steps made so far.
    pub fn steps_done(&self) -> u64 {
        self.done
    }

    /// Time since the start at the last step, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Makes steps up to number `step` as far as their windows are complete.
    pub fn run_to(&mut self, step: u64) {
        let received = self.base + self.steps.len() as u64;
        let width = self.sculling.width() as u64;
        let ready = if self.finished {
            received
        } else if received < width {
            0
        } else {
            received - (width - 1) / 2
        };
        let last = step.min(ready);
        let ahead = (width - 1) / 2;
        while self.done < last {
            let full = width.min(received);
            // First sample of the window, counted from 0; step number done + 1 integrates sample `done`.
            let first = self
                .done
                .saturating_sub(width - 1 - ahead)
                .min(received - full);
            let place = (self.done - first) as usize;
            let centre = (width - 1 - ahead) as usize;
            if full == width && place == centre {
                let end = last.min(received - ahead);
                self.run_centred((end - self.done) as usize);
            } else {
                self.run_edge(first, full as usize, place);
            }
        }
    }

    fn hold(&self, [dt_s, height_m, climb_m_s]: [f64; 3]) -> Hold {
        let free = Hold {
            height_gain: 0.0,
            climb_gain: 0.0,
            velocity_per_height: 0.0,
            integral_per_height: 0.0,
            dt_s,
            height_m,
            climb_m_s,
        };
        match self.vertical {
            Vertical::Free => free,
            Vertical::Fixed => Hold {
                height_gain: 1.0,
                climb_gain: 1.0,
                ..free
            },
            Vertical::Baro => Hold {
                height_gain: 3.0 / BARO_TAU_S * dt_s,
                velocity_per_height: BARO_VELOCITY_GAIN * dt_s,
                integral_per_height: dt_s / (BARO_TAU_S * BARO_TAU_S * BARO_TAU_S),
                ..free
            },
        }
    }

    fn run_edge(&mut self, first: u64, width: usize, place: usize) {
        let weights = Weights::new(width, place);
        let begin = (first - self.base) as usize;
        let window = part::<L>(&self.queue, begin, begin + width);
        let step = self.steps[begin + place];
        let hold = self.hold(step);
        kernel::edge::<L>(&mut self.lanes, &self.field, &weights, window, place, &hold);
        self.done += 1;
        self.time_s += step[0];
    }

    fn run_centred(&mut self, count: usize) {
        let begin = (self.done - self.base) as usize;
        let behind = (self.sculling.width() - 1) - (self.sculling.width() - 1) / 2;
        let low = begin - behind;
        let high = begin + count + (self.sculling.width() - 1) / 2;
        let steps = &self.steps[begin..begin + count];
        let holds: Vec<Hold> = steps.iter().map(|s| self.hold(*s)).collect();
        for s in steps {
            self.time_s += s[0];
        }
        let samples = part::<L>(&self.queue, low, high);
        kernel::run(
            &mut self.lanes,
            &self.field,
            &self.centred,
            self.sculling,
            samples,
            &holds,
        );
        self.done += count as u64;
    }

    /// The state of a lane after the last step made.
    pub fn state(&self, lane: usize) -> State {
        let get = |a: &[[f64; L]; 3]| [a[0][lane], a[1][lane], a[2][lane]];
        let (r, v) = (get(&self.lanes.r), get(&self.lanes.v));
        let v = sub(v, cross([0.0, 0.0, self.earth.rate_rad_s()], r));
        let (s, c) = (self.earth.rate_rad_s() * self.time_s).sin_cos();
        let e_from_i: Mat3 = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]];
        let q: [f64; 4] = std::array::from_fn(|i| self.lanes.q[i][lane]);
        State {
            position_e: mul_vec(&e_from_i, r),
            velocity_e: mul_vec(&e_from_i, v),
            e_from_b: mul(&e_from_i, &from_quaternion(q)),
        }
    }
}

/// The channels from one sample of the queue to another.
fn part<const L: usize>(queue: &[Vec<f64>; 6], from: usize, to: usize) -> [&[f64]; 6] {
    queue.each_ref().map(|channel| &channel[from * L..to * L])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::trajectory::{NAMES, Start, Trajectory};

    fn worst_return(
        name: &str,
        start: &Start,
        rate_hz: f64,
        duration_s: f64,
        sculling: Sculling,
    ) -> f64 {
        let tr = Trajectory::named(name, Earth::Wgs84, start).unwrap();
        let dt = 1.0 / rate_hz;
        let mut nav =
            Strapdown::<1>::new(Earth::Wgs84, sculling, Vertical::Free, [tr.at(0.0).into()]);
        let mut worst = 0.0f64;
        for s in tr.samples(dt).take((duration_s * rate_hz).round() as usize) {
            nav.feed(
                dt,
                &[
                    [s.rate_rad_s[0]],
                    [s.rate_rad_s[1]],
                    [s.rate_rad_s[2]],
                    [s.force_m_s2[0]],
                    [s.force_m_s2[1]],
                    [s.force_m_s2[2]],
                ],
                [0.0, 0.0],
            );
            if ((s.time_s / dt).round() as u64).is_multiple_of(2000) {
                nav.run_to(u64::MAX);
                worst = worst.max(
                    nav.state(0)
                        .position_error_m(&tr.at(nav.steps_done() as f64 * dt)),
                );
            }
        }
        nav.finish();
        worst.max(
            nav.state(0)
                .position_error_m(&tr.at(nav.steps_done() as f64 * dt)),
        )
    }

    #[test]
    fn every_trajectory_returns_after_an_hour_at_200_hz() {
        for name in NAMES {
            let five = worst_return(name, &Start::default(), 200.0, 3600.0, Sculling::Five);
            assert!(five <= 1e-3, "{name} {five}");
        }
    }

    #[test]
    fn two_samples_return_what_the_contract_says() {
        // navigation.md §2: ≤ 2.3e-5 m, flight 9.3e-6, coning 1.0, walking 1.7, rocket 2.8 m.
        for (name, limit) in [
            ("turn", 1e-4),
            ("drive", 1e-4),
            ("coning", 1.5),
            ("walking", 2.5),
            ("rocket", 4.0),
        ] {
            let two = worst_return(name, &Start::default(), 200.0, 3600.0, Sculling::Two);
            assert!(two <= limit, "{name} {two}");
        }
    }

    #[test]
    fn pole_and_date_line_are_ordinary_places() {
        let over = Start {
            latitude_rad: 89.5f64.to_radians(),
            ..Start::default()
        };
        let across = Start {
            latitude_rad: 10f64.to_radians(),
            longitude_rad: 179.9f64.to_radians(),
            heading_rad: std::f64::consts::FRAC_PI_2,
            ..Start::default()
        };
        for start in [over, across] {
            let worst = worst_return("flight", &start, 200.0, 3600.0, Sculling::Five);
            assert!(worst <= 1e-3, "{worst}");
        }
        let at_pole = Start {
            latitude_rad: std::f64::consts::FRAC_PI_2,
            ..Start::default()
        };
        assert!(worst_return("rest", &at_pole, 100.0, 600.0, Sculling::Five) < 1e-4);
    }

    #[test]
    fn short_records_are_integrated_whole() {
        for n in 1..8 {
            for sculling in [Sculling::Two, Sculling::Five] {
                let error = worst_return(
                    "turn",
                    &Start::default(),
                    100.0,
                    f64::from(n) * 0.01,
                    sculling,
                );
                assert!(error < 1e-6, "{n} {error}");
            }
        }
    }

    #[test]
    fn lanes_are_the_same_bits_as_one_run() {
        let tr = Trajectory::named("walking", Earth::Wgs84, &Start::default()).unwrap();
        let mut one = Strapdown::<1>::new(
            Earth::Wgs84,
            Sculling::Five,
            Vertical::Fixed,
            [tr.at(0.0).into()],
        );
        let mut eight = Strapdown::<8>::new(
            Earth::Wgs84,
            Sculling::Five,
            Vertical::Fixed,
            [tr.at(0.0).into(); 8],
        );
        for s in tr.samples(0.01).take(3000) {
            let truth = [s.height_m, s.climb_m_s];
            one.push(
                0.01,
                &s.rate_rad_s.map(|x| [x]),
                &s.force_m_s2.map(|x| [x]),
                truth,
            );
            eight.push(
                0.01,
                &s.rate_rad_s.map(|x| [x; 8]),
                &s.force_m_s2.map(|x| [x; 8]),
                truth,
            );
        }
        one.finish();
        eight.finish();
        for lane in 0..8 {
            assert_eq!(one.state(0), eight.state(lane));
        }
        assert!(one.state(0).position_error_m(&tr.at(30.0)) < 1e-3);
    }
}
