//! Trajectories as closed functions of time, and the truth they give a sensor: f = C_ebᵀ(r̈ + 2Ω×ṙ − g),
//! ω = ω_eb + C_ebᵀΩ, as means over the sampling intervals (navigation.md §1).

mod builtin;
mod panel;
mod path;
mod samples;

use crate::Error;
use crate::attitude::{
    Mat3, Vec3, add, mul, mul_vec_t, to_quaternion, to_roll_pitch_yaw, transpose,
};
use crate::earth::{Earth, Place};
pub use builtin::NAMES;
use builtin::{Builtin, Kind};
pub use path::{Path, PathAttitude, PathData, PathPosition};
pub use samples::{Samples, TruthSample};

/// Where and how a trajectory starts (`--latitude` …; `roll` and `pitch` for `rest` alone).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Geodetic latitude, rad.
    pub latitude_rad: f64,
    /// Longitude, rad.
    pub longitude_rad: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Heading χ of the trajectory's forward axis, rad from north to east.
    pub heading_rad: f64,
    /// Roll at rest, rad.
    pub roll_rad: f64,
    /// Pitch at rest, rad.
    pub pitch_rad: f64,
}

impl Default for Start {
    /// 45° N, 0° E, on the ellipsoid, heading north, level.
    fn default() -> Self {
        Self {
            latitude_rad: std::f64::consts::FRAC_PI_4,
            longitude_rad: 0.0,
            height_m: 0.0,
            heading_rad: 0.0,
            roll_rad: 0.0,
            pitch_rad: 0.0,
        }
    }
}

/// More turns than an angle is given with: its digits end.
const MOST_TURNS: f64 = 1000.0;

impl Start {
    fn check(&self) -> Result<(), Error> {
        let out = |quantity, value: String, expected| {
            Err(Error::OutOfRange {
                quantity,
                value,
                expected,
            })
        };
        if self.latitude_rad.is_nan()
            || self.latitude_rad.abs() > std::f64::consts::FRAC_PI_2 + 1e-12
        {
            return out(
                "latitude",
                in_few_digits(self.latitude_rad.to_degrees(), "deg"),
                "-90 to 90 deg",
            );
        }
        for (quantity, angle) in [
            ("longitude", self.longitude_rad),
            ("heading", self.heading_rad),
            ("roll", self.roll_rad),
            ("pitch", self.pitch_rad),
        ] {
            let turns = angle.abs() / std::f64::consts::TAU;
            if turns.is_nan() || turns > MOST_TURNS {
                return out(
                    quantity,
                    in_few_digits(angle.to_degrees(), "deg"),
                    "-360 000 to 360 000 deg",
                );
            }
        }
        if !(self.height_m >= -500.0 && self.height_m <= 1e8) {
            return out(
                "height",
                in_few_digits(self.height_m, "m"),
                "-500 m to 100 000 km",
            );
        }
        Ok(())
    }
}

/// A value with its unit in at most 12 digits; what is beyond all measure in powers of ten.
pub(crate) fn in_few_digits(value: f64, unit: &str) -> String {
    let value = format!("{value:.11e}").parse().unwrap_or(value);
    if value.abs() < 1e12 {
        format!("{value} {unit}")
    } else {
        format!("{value:e} {unit}")
    }
}

/// The instantaneous state of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Ellipsoid normal and height.
    pub place: Place,
    /// Position, Earth axes, m.
    pub position_e: Vec3,
    /// Velocity relative to the Earth, m/s.
    pub velocity_e: Vec3,
    /// Acceleration relative to the Earth, m/s².
    pub acceleration_e: Vec3,
    /// Body to Earth axes.
    pub e_from_b: Mat3,
    /// Rate of the body relative to the Earth, body axes, rad/s.
    pub rate_eb_b: Vec3,
}

impl Point {
    /// Specific force, body axes, m/s².
    pub fn force_b(&self, earth: Earth) -> Vec3 {
        mul_vec_t(
            &self.e_from_b,
            earth.specific_force_e(&self.place, self.velocity_e, self.acceleration_e),
        )
    }

    /// Rate relative to inertial space, body axes, rad/s.
    pub fn rate_b(&self, earth: Earth) -> Vec3 {
        add(
            self.rate_eb_b,
            mul_vec_t(&self.e_from_b, [0.0, 0.0, earth.rate_rad_s()]),
        )
    }

    /// The same in the words of a log.
    pub fn motion(&self) -> Motion {
        let e_from_n = self.place.e_from_n();
        Motion::from_local(
            &self.place,
            mul_vec_t(&e_from_n, self.velocity_e),
            &mul(&transpose(&e_from_n), &self.e_from_b),
        )
    }
}

/// Position, velocity and attitude as a log holds them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Geodetic latitude, rad.
    pub latitude_rad: f64,
    /// Longitude, rad, in (−π, π].
    pub longitude_rad: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// North, east, down velocity, m/s.
    pub velocity_n: Vec3,
    /// Body → north-east-down, scalar first.
    pub quaternion: [f64; 4],
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Heading, rad, in [0, 2π).
    pub heading_rad: f64,
}

impl Motion {
    /// From a place, the velocity in north, east, down and n_from_b.
    pub fn from_local(place: &Place, velocity_n: Vec3, n_from_b: &Mat3) -> Self {
        let [roll_rad, pitch_rad, yaw] = to_roll_pitch_yaw(n_from_b);
        let turn = 2.0 * std::f64::consts::PI;
        let heading = if yaw < 0.0 { yaw + turn } else { yaw };
        Self {
            latitude_rad: place.latitude_rad(),
            longitude_rad: place.longitude_rad(),
            height_m: place.height_m,
            velocity_n,
            quaternion: to_quaternion(n_from_b),
            roll_rad,
            pitch_rad,
            heading_rad: if heading >= turn { 0.0 } else { heading },
        }
    }
}

#[derive(Debug, Clone)]
enum Shape {
    Builtin(Box<Builtin>),
    Path(Box<Path>),
}

/// A motion of a rigid body over the Earth, known at every instant.
#[derive(Debug, Clone)]
pub struct Trajectory {
    earth: Earth,
    name: String,
    shape: Shape,
}

impl Trajectory {
    /// One of the built-in trajectories ([`NAMES`]) from a start.
    ///
    /// # Errors
    /// An unknown name, a start outside the Earth's surface, roll or pitch with anything but `rest`.
    pub fn named(name: &str, earth: Earth, start: &Start) -> Result<Self, Error> {
        start.check()?;
        let kind = Kind::parse(name).ok_or_else(|| Error::UnknownTrajectory {
            name: name.to_owned(),
        })?;
        if kind != Kind::Rest && (start.roll_rad != 0.0 || start.pitch_rad != 0.0) {
            return Err(Error::AttitudeNotFree {
                name: name.to_owned(),
            });
        }
        Ok(Self {
            earth,
            name: name.to_owned(),
            shape: Shape::Builtin(Box::new(Builtin::new(kind, earth, start))),
        })
    }

    /// A user's own path: quintic splines through its points.
    ///
    /// # Errors
    /// Points that are too few, out of order or impossible to fly ([`Path::new`]).
    pub fn from_path(
        name: &str,
        earth: Earth,
        start: &Start,
        data: &PathData,
    ) -> Result<Self, Error> {
        start.check()?;
        Ok(Self {
            earth,
            name: name.to_owned(),
            shape: Shape::Path(Box::new(Path::new(earth, start, data)?)),
        })
    }

    /// A measured reference: as [`Self::from_path`], without the limits of speed, force and rate.
    ///
    /// # Errors
    /// As [`Path::measured`].
    pub fn from_reference(
        name: &str,
        earth: Earth,
        start: &Start,
        data: &PathData,
    ) -> Result<Self, Error> {
        start.check()?;
        Ok(Self {
            earth,
            name: name.to_owned(),
            shape: Shape::Path(Box::new(Path::measured(earth, start, data)?)),
        })
    }

    /// The Earth it moves on.
    pub fn earth(&self) -> Earth {
        self.earth
    }

    /// Its name or the file's.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is a closed function of time.
    fn is_builtin(&self) -> bool {
        matches!(self.shape, Shape::Builtin(_))
    }

    /// Whether nothing moves relative to the Earth.
    pub fn is_rest(&self) -> bool {
        matches!(&self.shape, Shape::Builtin(b) if b.kind == Kind::Rest)
    }

    /// The last time of a path, s; `None` for built-in trajectories, which do not end.
    pub fn last_time_s(&self) -> Option<f64> {
        match &self.shape {
            Shape::Builtin(_) => None,
            Shape::Path(p) => Some(p.last_time_s()),
        }
    }

    /// The default `--duration`, s: 1 h, or the path's last time.
    pub fn default_duration_s(&self) -> f64 {
        self.last_time_s().unwrap_or(3600.0)
    }

    /// Refuses a duration beyond the path's end, not positive, or beyond ten years.
    ///
    /// # Errors
    /// With the numbers.
    pub fn check_duration(&self, duration_s: f64) -> Result<(), Error> {
        if !(duration_s > 0.0 && duration_s <= 3.2e8) {
            return Err(Error::OutOfRange {
                quantity: "duration",
                value: in_few_digits(duration_s, "s"),
                expected: "more than zero and at most ten years",
            });
        }
        match self.last_time_s() {
            Some(last) if duration_s > last * (1.0 + 1e-12) => Err(Error::Request {
                what: format!(
                    "the path ends after {last} s, the duration asked for is {duration_s} s"
                ),
                advice: format!("use --duration {last}s or less"),
            }),
            _ => Ok(()),
        }
    }

    /// Everything about time `t_s`.
    pub fn at(&self, t_s: f64) -> Point {
        match &self.shape {
            Shape::Builtin(b) => b.at(t_s),
            Shape::Path(p) => p.at(t_s),
        }
    }

    /// Position, velocity and attitude at `t_s`.
    pub fn motion(&self, t_s: f64) -> Motion {
        self.at(t_s).motion()
    }

    /// The stream of interval means from t = 0, without end: sample k is the mean over ((k − 1)·dt, k·dt].
    pub fn samples(&self, dt_s: f64) -> Samples<'_> {
        Samples::new(self, dt_s)
    }

    /// Times inside (from, to) where a derivative jumps (a path's knots), ascending.
    fn breaks(&self, from_s: f64, to_s: f64) -> &[f64] {
        match &self.shape {
            Shape::Builtin(_) => &[],
            Shape::Path(p) => p.breaks(from_s, to_s),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::attitude::{norm, sub, to_rotation_vector};

    #[test]
    fn kinematics_are_derivatives() {
        // Central differences over 2 ms of 6.4e6 m are good to 1e-3 m/s² in the second derivative (rounding 1e-9/4e-6)
        // and 1e-6 in the first.
        let start = Start {
            height_m: 120.0,
            heading_rad: 0.7,
            ..Start::default()
        };
        for name in NAMES {
            for earth in [Earth::Wgs84, Earth::Sphere] {
                let tr = Trajectory::named(name, earth, &start).unwrap();
                for t in [0.3, 17.2, 64.1, 119.0, 333.3] {
                    let h = 2e-3;
                    let (a, b, c) = (tr.at(t - h), tr.at(t), tr.at(t + h));
                    for i in 0..3 {
                        let v = (c.position_e[i] - a.position_e[i]) / (2.0 * h);
                        assert!(
                            (v - b.velocity_e[i]).abs() < 2e-5 * (1.0 + norm(b.acceleration_e)),
                            "{name} {t} v {v} {}",
                            b.velocity_e[i]
                        );
                        let acc = (c.velocity_e[i] - a.velocity_e[i]) / (2.0 * h);
                        assert!(
                            (acc - b.acceleration_e[i]).abs()
                                < 1e-4 * (1.0 + norm(b.acceleration_e)),
                            "{name} {t} a {acc} {}",
                            b.acceleration_e[i]
                        );
                    }
                    let turned = to_rotation_vector(&mul(&transpose(&a.e_from_b), &c.e_from_b))
                        .map(|x| x / (2.0 * h));
                    assert!(
                        norm(sub(turned, b.rate_eb_b)) < 1e-4 * (1e-2 + norm(b.rate_eb_b)),
                        "{name} {t} {turned:?} {:?}",
                        b.rate_eb_b
                    );
                    let place = earth.place(b.position_e);
                    assert!(
                        (place.height_m - b.place.height_m).abs() < 1e-8
                            && norm(sub(place.normal_e, b.place.normal_e)) < 1e-14
                    );
                }
            }
        }
    }

    #[test]
    fn rest_reads_gravity_and_earth_rate() {
        let start = Start {
            heading_rad: std::f64::consts::FRAC_PI_2,
            ..Start::default()
        };
        let tr = Trajectory::named("rest", Earth::Wgs84, &start).unwrap();
        let s = tr.samples(0.01).nth(9).unwrap();
        assert!((s.time_s - 0.1).abs() < 1e-15);
        assert!((s.force_m_s2[2] + 9.806_197_8).abs() < 5e-8 && s.force_m_s2[0].abs() < 1e-12);
        let w = crate::earth::WGS84_RATE_RAD_S * std::f64::consts::FRAC_1_SQRT_2;
        // Heading east: north is to the left, so earth rate's north part is on −y and its down part −Ω sin φ on z.
        assert!(
            (s.rate_rad_s[1] + w).abs() < 1e-18
                && (s.rate_rad_s[2] + w).abs() < 1e-18
                && s.rate_rad_s[0].abs() < 1e-18
        );
    }

    #[test]
    fn means_do_not_depend_on_the_panel() {
        // navigation.md §1.4: within 1e-8 from 50 Hz on; here 50 Hz means against the average of ten means at 500 Hz.
        for name in NAMES {
            let tr = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
            let fine: Vec<TruthSample> = tr.samples(0.002).take(10_000).collect();
            for (k, coarse) in tr.samples(0.02).take(1000).enumerate() {
                for i in 0..3 {
                    let mean = |get: fn(&TruthSample) -> Vec3| {
                        fine[10 * k..10 * k + 10]
                            .iter()
                            .map(|s| get(s)[i])
                            .sum::<f64>()
                            / 10.0
                    };
                    assert!(
                        (mean(|s| s.force_m_s2) - coarse.force_m_s2[i]).abs() < 1e-8,
                        "{name} {k}"
                    );
                    assert!(
                        (mean(|s| s.rate_rad_s) - coarse.rate_rad_s[i]).abs() < 1e-8,
                        "{name} {k}"
                    );
                }
            }
        }
    }

    #[test]
    fn seeking_gives_the_same_bits() {
        for (name, first) in [("walking", 0), ("rocket", 11_900), ("drive", 5000)] {
            let tr = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
            let mut stream = tr.samples(0.01);
            stream.seek(first);
            let all: Vec<TruthSample> = stream.take(400).collect();
            for at in [60, 130, 131, 399] {
                let mut stream = tr.samples(0.01);
                stream.seek(first + at);
                assert_eq!(stream.next_sample(), all[at as usize], "{name} {at}");
            }
        }
    }

    #[test]
    fn panels_are_the_quadrature_of_every_interval() {
        for name in NAMES {
            for (dt, first) in [(0.01, 0), (0.005, 23_900), (0.02, 170_000), (0.1, 400)] {
                let tr = Trajectory::named(name, Earth::Wgs84, &Start::default()).unwrap();
                let (mut fast, mut slow) = (tr.samples(dt), tr.samples(dt).by_quadrature());
                fast.seek(first);
                slow.seek(first);
                for (k, (a, b)) in fast.zip(slow).take(300).enumerate() {
                    // Three points a panel are good to 1e-11 m/s² on the 1 Hz of `coning`; the time itself is rounded to
                    // 5e-13 s after an hour, in which force changes by 1e-11 m/s² where walking shakes the sensor.
                    let near = |a: Vec3, b: Vec3, limit: f64| norm(sub(a, b)) < limit;
                    assert!(
                        near(a.force_m_s2, b.force_m_s2, 2e-9)
                            && near(a.rate_rad_s, b.rate_rad_s, 1e-10)
                            && near(a.rate_dot_rad_s2, b.rate_dot_rad_s2, 1e-9)
                            && (a.height_m - b.height_m).abs() < 1e-9
                            && (a.climb_m_s - b.climb_m_s).abs() < 1e-11
                            && a.time_s == b.time_s,
                        "{name} {dt} {k}: {a:?} {b:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_path_follows_the_trajectory_it_was_sampled_from() {
        let start = Start::default();
        let tr = Trajectory::named("flight", Earth::Wgs84, &start).unwrap();
        let time_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.5 + 3.0).collect();
        let motions: Vec<Motion> = time_s.iter().map(|t| tr.motion(*t)).collect();
        let position = PathPosition::Geodetic(
            motions
                .iter()
                .map(|m| [m.latitude_rad, m.longitude_rad, m.height_m])
                .collect(),
        );
        let data = PathData {
            time_s,
            position,
            attitude: PathAttitude::Quaternion(motions.iter().map(|m| m.quaternion).collect()),
        };
        let with = Trajectory::from_path("p", Earth::Wgs84, &start, &data).unwrap();
        let without = Trajectory::from_path(
            "p",
            Earth::Wgs84,
            &start,
            &PathData {
                attitude: PathAttitude::Coordinated,
                ..data
            },
        )
        .unwrap();
        assert!((with.default_duration_s() - 199.5).abs() < 1e-12);
        for t in [10.3, 77.7, 150.2] {
            let (want, got, course) = (tr.at(t + 3.0), with.at(t), without.at(t));
            assert!(norm(sub(want.position_e, got.position_e)) < 1e-6);
            assert!(norm(sub(want.force_b(Earth::Wgs84), got.force_b(Earth::Wgs84))) < 1e-4);
            assert!(norm(sub(want.rate_eb_b, got.rate_eb_b)) < 1e-7);
            // The built-in course is on the sphere of R₀ and in the track frame: the same to the flattening.
            assert!(
                norm(to_rotation_vector(&mul(
                    &transpose(&want.e_from_b),
                    &course.e_from_b
                ))) < 1e-2
            );
            assert!(norm(sub(want.rate_eb_b, course.rate_eb_b)) < 1e-3);
        }
        assert!(with.check_duration(199.6).is_err() && with.check_duration(199.5).is_ok());
    }

    #[test]
    fn impossible_paths_are_refused_with_their_time() {
        let path = |position: Vec<Vec3>, attitude| {
            let data = PathData {
                time_s: (0..position.len()).map(|i| i as f64).collect(),
                position: PathPosition::Local(position),
                attitude,
            };
            Trajectory::from_path("p", Earth::Wgs84, &Start::default(), &data)
        };
        let ahead: Vec<Vec3> = (0..20).map(|i| [0.0, 10.0 * f64::from(i), 0.0]).collect();
        assert!(path(ahead.clone(), PathAttitude::Coordinated).is_ok());
        let mut jump = ahead.clone();
        jump[9][1] += 50_000.0;
        assert!(
            path(jump, PathAttitude::Coordinated)
                .unwrap_err()
                .place()
                .is_some()
        );
        let mut dive = ahead.clone();
        dive[19][2] = -600.0;
        assert!(
            path(dive, PathAttitude::Coordinated)
                .unwrap_err()
                .to_string()
                .contains("Earth")
        );
        let still: Vec<Vec3> = vec![[0.0; 3]; 20];
        assert!(
            path(still, PathAttitude::Coordinated)
                .unwrap_err()
                .advice()
                .unwrap()
                .contains("attitude")
        );
        assert!(
            path(
                ahead,
                PathAttitude::Quaternion(vec![[0.9, 0.0, 0.0, 0.0]; 20])
            )
            .is_err()
        );
    }
}
