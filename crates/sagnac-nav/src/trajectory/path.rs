//! A user's own path: quintic splines through Earth-fixed positions and body → Earth quaternions, or the attitude of a
//! coordinated turn (navigation.md §1.3).

use super::{Point, Start};
use crate::Error;
use crate::attitude::{
    Mat3, Vec3, add, from_columns, from_quaternion, from_yaw_pitch_roll, mul, mul_vec, mul_vec_t,
    norm, quaternion_product, scale, sub, to_quaternion, to_rotation_vector, transpose,
};
use crate::earth::{Earth, Place, STANDARD_GRAVITY_M_S2};
use crate::spline::Spline;

/// Positions of a path.
#[derive(Debug, Clone, PartialEq)]
pub enum PathPosition {
    /// Latitude rad, longitude rad, height m.
    Geodetic(Vec<Vec3>),
    /// East, north, up from the start, m.
    Local(Vec<Vec3>),
}

/// Attitudes of a path.
#[derive(Debug, Clone, PartialEq)]
pub enum PathAttitude {
    /// That of a coordinated turn along ground speed and course.
    Coordinated,
    /// Quaternions, scalar first: body → north-east-down beside geodetic, body → east-north-up at the start beside
    /// local positions.
    Quaternion(Vec<[f64; 4]>),
    /// Roll, pitch, heading, rad (ZYX, body → north-east-down at the place).
    RollPitchHeading(Vec<Vec3>),
}

/// A path's columns, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct PathData {
    /// Times, s, strictly increasing; shifted so that the first is 0.
    pub time_s: Vec<f64>,
    /// Positions.
    pub position: PathPosition,
    /// Attitudes.
    pub attitude: PathAttitude,
}

/// A path ready to be asked.
#[derive(Debug, Clone)]
pub struct Path {
    earth: Earth,
    origin_e: Vec3,
    position: Spline<3>,
    attitude: Option<Spline<4>>,
    first_s: f64,
}

fn bad(what: impl Into<String>, time_s: Option<f64>, advice: &str) -> Error {
    Error::BadPath {
        what: what.into(),
        time_s,
        advice: advice.to_owned(),
    }
}

/// Largest |v|, |f|, |ω| that a path may ask for.
const SPEED_LIMIT_M_S: f64 = 12_000.0;
const FORCE_LIMIT_M_S2: f64 = 2000.0;
const RATE_LIMIT_RAD_S: f64 = 100.0;
const MIN_GROUND_SPEED_M_S: f64 = 0.1;

impl Path {
    /// Builds and checks a path. Local axes are tangent at `start`.
    ///
    /// # Errors
    /// Fewer than two points; times that do not increase; a quaternion whose length is off 1 by more than 1e-2; a height
    /// below −500 m, |v| above 12 km/s, |f| above 2000 m/s² or |ω| above 100 rad/s at a point or midway; ground speed
    /// below 0.1 m/s where there is no attitude.
    pub fn new(earth: Earth, start: &Start, data: &PathData) -> Result<Self, Error> {
        let path = Self::measured(earth, start, data)?;
        let times: Vec<f64> = data.time_s.iter().map(|t| t - path.first_s).collect();
        path.check(&times)?;
        Ok(path)
    }

    /// The same for a measured reference, whose noise and gaps may ask for any force.
    ///
    /// # Errors
    /// As [`Path::new`], but for the limits of speed, force and rate.
    pub fn measured(earth: Earth, start: &Start, data: &PathData) -> Result<Self, Error> {
        let n = data.time_s.len();
        let points = match &data.position {
            PathPosition::Geodetic(p) | PathPosition::Local(p) => p,
        };
        if n < 2 {
            return Err(bad(
                format!("a path needs at least two points, this one has {n}"),
                None,
                "give a longer path",
            ));
        }
        let rows = match &data.attitude {
            PathAttitude::Coordinated => n,
            PathAttitude::Quaternion(q) => q.len(),
            PathAttitude::RollPitchHeading(a) => a.len(),
        };
        if points.len() != n || rows != n {
            return Err(bad(
                "the path's columns differ in length",
                None,
                "give every column the same number of rows",
            ));
        }
        for (i, t) in data.time_s.iter().enumerate() {
            if !t.is_finite() || !points[i].iter().all(|x| x.is_finite()) {
                return Err(bad(
                    "a value of the path is not a finite number",
                    Some(*t),
                    "leave the row out",
                ));
            }
            if i > 0 && *t <= data.time_s[i - 1] {
                return Err(bad(
                    format!("time does not increase after {} s", data.time_s[i - 1]),
                    Some(*t),
                    "sort the rows and drop double ones",
                ));
            }
        }
        let first_s = data.time_s[0];
        let time_s: Vec<f64> = data.time_s.iter().map(|t| t - first_s).collect();
        let origin = Place::from_geodetic(start.latitude_rad, start.longitude_rad, start.height_m);
        let [north, east, down] = transpose(&origin.e_from_n());
        let e_from_local = from_columns(east, north, scale(-1.0, down));
        let origin_e = match &data.position {
            PathPosition::Local(_) => earth.position_e(&origin),
            PathPosition::Geodetic(p) => {
                earth.position_e(&Place::from_geodetic(p[0][0], p[0][1], p[0][2]))
            }
        };
        let offsets: Vec<Vec3> = match &data.position {
            PathPosition::Local(p) => p.iter().map(|p| mul_vec(&e_from_local, *p)).collect(),
            PathPosition::Geodetic(p) => p
                .iter()
                .map(|p| {
                    sub(
                        earth.position_e(&Place::from_geodetic(p[0], p[1], p[2])),
                        origin_e,
                    )
                })
                .collect(),
        };
        let places: Vec<Place> = offsets
            .iter()
            .map(|o| earth.place(add(origin_e, *o)))
            .collect();
        for (i, place) in places.iter().enumerate() {
            if place.height_m < -500.0 {
                return Err(bad(
                    format!(
                        "the path is {:.0} m below the ellipsoid: through the Earth",
                        -place.height_m
                    ),
                    Some(data.time_s[i]),
                    "check the height column and its unit",
                ));
            }
        }
        let attitude = match &data.attitude {
            PathAttitude::Coordinated => None,
            PathAttitude::Quaternion(q) => Some(
                q.iter()
                    .enumerate()
                    .map(|(i, q)| {
                        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                        if (length - 1.0).abs().is_nan() || (length - 1.0).abs() > 1e-2 {
                            return Err(bad(
                                format!("the quaternion has length {length}, not 1"),
                                Some(data.time_s[i]),
                                "check the columns: scalar first, w x y z",
                            ));
                        }
                        let e_from_a = match &data.position {
                            PathPosition::Local(_) => e_from_local,
                            PathPosition::Geodetic(_) => places[i].e_from_n(),
                        };
                        Ok(quaternion_product(
                            to_quaternion(&e_from_a),
                            q.map(|x| x / length),
                        ))
                    })
                    .collect::<Result<Vec<_>, Error>>()?,
            ),
            PathAttitude::RollPitchHeading(a) => Some(
                a.iter()
                    .enumerate()
                    .map(|(i, [roll, pitch, heading])| {
                        if !(roll.is_finite() && pitch.is_finite() && heading.is_finite()) {
                            return Err(bad(
                                "an angle of the path is not a finite number",
                                Some(data.time_s[i]),
                                "leave the row out",
                            ));
                        }
                        let m = from_yaw_pitch_roll(
                            (heading.cos(), heading.sin()),
                            (pitch.cos(), pitch.sin()),
                            (roll.cos(), roll.sin()),
                        );
                        Ok(to_quaternion(&mul(&places[i].e_from_n(), &m)))
                    })
                    .collect::<Result<Vec<_>, Error>>()?,
            ),
        };
        let attitude = attitude.map(|mut q| {
            for i in 1..q.len() {
                if (0..4).map(|j| q[i][j] * q[i - 1][j]).sum::<f64>() < 0.0 {
                    q[i] = q[i].map(|x| -x);
                }
            }
            Spline::new(&time_s, &q)
        });
        let path = Self {
            earth,
            origin_e,
            position: Spline::new(&time_s, &offsets),
            attitude,
            first_s,
        };
        Ok(path)
    }

    /// Refuses a jump where it is: the spline through it swings far to both sides.
    fn check_steps(&self, time_s: &[f64]) -> Result<(), Error> {
        for pair in time_s.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let way_m = norm(sub(self.position.at(to)[0], self.position.at(from)[0]));
            let speed = way_m / (to - from);
            if speed.is_nan() || speed > SPEED_LIMIT_M_S {
                return Err(bad(
                    format!(
                        "the path goes {} in {} s, faster than {SPEED_LIMIT_M_S} m/s",
                        super::in_few_digits((way_m * 10.0).round() / 10.0, "m"),
                        to - from
                    ),
                    Some(to + self.first_s),
                    "check the path for jumps and its units",
                ));
            }
        }
        Ok(())
    }

    fn check(&self, time_s: &[f64]) -> Result<(), Error> {
        self.check_steps(time_s)?;
        for (i, &t) in time_s.iter().enumerate() {
            let middle = time_s.get(i + 1).map(|next| 0.5 * (t + next));
            for t in std::iter::once(t).chain(middle) {
                let at = Some(t + self.first_s);
                if self.attitude.is_none() {
                    let [r, v, ..] = self.position.at(t);
                    let place = self.earth.place(add(self.origin_e, r));
                    let ground = mul_vec_t(&place.e_from_n(), v);
                    if ground[0].hypot(ground[1]) < MIN_GROUND_SPEED_M_S {
                        return Err(bad(
                            format!(
                                "the ground speed is {:.3} m/s, too slow to take the attitude from the course",
                                ground[0].hypot(ground[1])
                            ),
                            at,
                            "give attitude columns: quaternion_w…z or roll, pitch, heading",
                        ));
                    }
                }
                let p = self.at(t);
                let jump = "check the path for jumps and its units";
                if p.place.height_m < -500.0 {
                    return Err(bad(
                        format!(
                            "the path is {:.0} m below the ellipsoid: through the Earth",
                            -p.place.height_m
                        ),
                        at,
                        jump,
                    ));
                }
                let checks = [
                    ("speed", norm(p.velocity_e), SPEED_LIMIT_M_S, "m/s"),
                    (
                        "specific force",
                        norm(p.force_b(self.earth)),
                        FORCE_LIMIT_M_S2,
                        "m/s^2",
                    ),
                    (
                        "rate",
                        norm(p.rate_b(self.earth)),
                        RATE_LIMIT_RAD_S,
                        "rad/s",
                    ),
                ];
                for (name, value, limit, unit) in checks {
                    if value.is_nan() || value > limit {
                        return Err(bad(
                            format!(
                                "the path asks for a {name} of {value:.4} {unit}, above {limit} {unit}"
                            ),
                            at,
                            jump,
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// The time of the last point, counted from the first, s.
    pub fn last_time_s(&self) -> f64 {
        self.position.knots_s().last().copied().unwrap_or(0.0)
    }

    /// The time of the first point in the path's own clock, s.
    pub fn first_time_s(&self) -> f64 {
        self.first_s
    }

    pub(super) fn breaks(&self, from_s: f64, to_s: f64) -> &[f64] {
        let knots = self.position.knots_s();
        let begin = knots.partition_point(|k| *k <= from_s);
        let end = knots.partition_point(|k| *k < to_s);
        if begin < end { &knots[begin..end] } else { &[] }
    }

    /// State at `t_s` after the first point.
    pub fn at(&self, t_s: f64) -> Point {
        let [r, velocity_e, acceleration_e, _] = self.position.at(t_s);
        let position_e = add(self.origin_e, r);
        let place = self.earth.place(position_e);
        let (e_from_b, rate_eb_b) = match &self.attitude {
            Some(spline) => {
                let [q, q_dot, ..] = spline.at(t_s);
                let n2: f64 = q.iter().map(|x| x * x).sum();
                // ω = 2 Im(q* q̇)/|q|²: the part of q̇ along q only changes its length.
                let product = quaternion_product([q[0], -q[1], -q[2], -q[3]], q_dot);
                (
                    from_quaternion(q),
                    [
                        2.0 * product[1] / n2,
                        2.0 * product[2] / n2,
                        2.0 * product[3] / n2,
                    ],
                )
            }
            None => (self.coordinated(t_s), self.coordinated_rate(t_s)),
        };
        Point {
            place,
            position_e,
            velocity_e,
            acceleration_e,
            e_from_b,
            rate_eb_b,
        }
    }

    /// e_from_b of a coordinated turn: ψ = course, θ = climb angle, tan φ = (v_N v̇_E − v_E v̇_N)/(v·9.80665).
    fn coordinated(&self, t_s: f64) -> Mat3 {
        let [r, v, a, _] = self.position.at(t_s);
        let position = add(self.origin_e, r);
        let place = self.earth.place(position);
        let e_from_n = place.e_from_n();
        let (velocity, acceleration) = (mul_vec_t(&e_from_n, v), mul_vec_t(&e_from_n, a));
        let ground = velocity[0].hypot(velocity[1]);
        let [x, y, z] = place.normal_e;
        let radius_sq = position[0] * position[0] + position[1] * position[1];
        let longitude_rate = if radius_sq > 0.0 {
            (position[0] * v[1] - position[1] * v[0]) / radius_sq
        } else {
            0.0
        };
        // d/dt(N·v) = N·a + Ṅ·v with Ṅ = −λ̇ sin φ E − φ̇ Up; Ė = λ̇(sin φ N − cos φ Up).
        let up = -velocity[2];
        let cos_latitude = x.hypot(y);
        let latitude_rate = self.latitude_rate(&place, velocity[0]);
        let north_dot = acceleration[0] - longitude_rate * z * velocity[1] - latitude_rate * up;
        let east_dot = acceleration[1] + longitude_rate * (z * velocity[0] - cos_latitude * up);
        let roll =
            (velocity[0] * east_dot - velocity[1] * north_dot) / (ground * STANDARD_GRAVITY_M_S2);
        let roll_norm = roll.hypot(1.0);
        let speed = ground.hypot(up);
        let m = from_yaw_pitch_roll(
            (velocity[0] / ground, velocity[1] / ground),
            (ground / speed, up / speed),
            (1.0 / roll_norm, roll / roll_norm),
        );
        mul(&e_from_n, &m)
    }

    fn latitude_rate(&self, place: &Place, north_m_s: f64) -> f64 {
        let (a, e2) = (self.earth.semi_major_m(), self.earth.eccentricity_sq());
        let w = 1.0 - e2 * place.normal_e[2] * place.normal_e[2];
        north_m_s / (a * (1.0 - e2) / (w * w.sqrt()) + place.height_m)
    }

    /// Rate of the coordinated attitude from rotation vectors over ±1 and ±2 ms, (8L(δ) − L(2δ))/12δ: error δ⁴/30 of
    /// the rate's fourth derivative.
    fn coordinated_rate(&self, t_s: f64) -> Vec3 {
        let step = 1e-3;
        let vector = |d: f64| {
            to_rotation_vector(&mul(
                &transpose(&self.coordinated(t_s - d)),
                &self.coordinated(t_s + d),
            ))
        };
        scale(
            1.0 / (12.0 * step),
            sub(scale(8.0, vector(step)), vector(2.0 * step)),
        )
    }
}
