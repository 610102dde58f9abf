//! The Earth: WGS 84 with normal gravity, or a sphere at rest, g(φ, h) = γ_e (1 + k sin²φ)/√(1 − e² sin²φ) ·
//! [1 − (2/a)(1 + f + m − 2f sin²φ)h + 3h²/a²] \[WGS84\].
//!
//! Gravity points down along the ellipsoid normal at every height and contains the centrifugal part.

use crate::attitude::{Mat3, Vec3, cross, dot, from_columns, scale, sub};

/// Semi-major axis of WGS 84, m.
pub const WGS84_A_M: f64 = 6_378_137.0;
/// Flattening of WGS 84.
pub const WGS84_F: f64 = 1.0 / 298.257_223_563;
/// Rotation rate of WGS 84, rad/s.
pub const WGS84_RATE_RAD_S: f64 = 7.292_115e-5;
/// Radius of the sphere, and of the sphere on which trajectories measure lengths, m.
pub const SPHERE_R_M: f64 = 6_371_000.0;
/// Standard gravity, m/s².
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

const GAMMA_E_M_S2: f64 = 9.780_325_335_9;
const GAMMA_K: f64 = 0.001_931_852_652_41;
const GAMMA_M: f64 = 0.003_449_786_506_84;

/// Which Earth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Earth {
    /// The rotating ellipsoid WGS 84 with normal gravity.
    #[default]
    Wgs84,
    /// A sphere of 6 371 000 m that does not rotate, with g = 9.80665 (R/(R + h))² m/s².
    Sphere,
}

/// A place by its ellipsoid normal and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Unit normal of the ellipsoid, upwards, Earth axes.
    pub normal_e: Vec3,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
}

impl Place {
    /// The place at a geodetic latitude and longitude, rad, and height, m.
    pub fn from_geodetic(latitude_rad: f64, longitude_rad: f64, height_m: f64) -> Self {
        let (sp, cp) = latitude_rad.sin_cos();
        let (sl, cl) = longitude_rad.sin_cos();
        Self {
            normal_e: [cp * cl, cp * sl, sp],
            height_m,
        }
    }

    /// Geodetic latitude, rad.
    pub fn latitude_rad(&self) -> f64 {
        self.normal_e[2].atan2(self.normal_e[0].hypot(self.normal_e[1]))
    }

    /// Longitude, rad, in (−π, π]; 0 at a pole.
    pub fn longitude_rad(&self) -> f64 {
        self.normal_e[1].atan2(self.normal_e[0])
    }

    /// e_from_n: the columns are north, east, down; at a pole itself as at longitude 0.
    pub fn e_from_n(&self) -> Mat3 {
        let [x, y, z] = self.normal_e;
        let p = x.hypot(y);
        let (cl, sl) = if p > 0.0 { (x / p, y / p) } else { (1.0, 0.0) };
        from_columns(
            [-z * cl, -z * sl, p],
            [-sl, cl, 0.0],
            scale(-1.0, self.normal_e),
        )
    }
}

impl Earth {
    /// Semi-major axis, m.
    pub const fn semi_major_m(self) -> f64 {
        match self {
            Self::Wgs84 => WGS84_A_M,
            Self::Sphere => SPHERE_R_M,
        }
    }

    /// First eccentricity squared.
    pub const fn eccentricity_sq(self) -> f64 {
        match self {
            Self::Wgs84 => WGS84_F * (2.0 - WGS84_F),
            Self::Sphere => 0.0,
        }
    }

    /// Rotation rate about z, rad/s.
    pub const fn rate_rad_s(self) -> f64 {
        match self {
            Self::Wgs84 => WGS84_RATE_RAD_S,
            Self::Sphere => 0.0,
        }
    }

    /// Magnitude of gravity, m/s², from sin²φ of the geodetic latitude and the height in m.
    #[inline]
    pub fn gravity_m_s2(self, sin_sq: f64, height_m: f64) -> f64 {
        match self {
            Self::Wgs84 => {
                let h = height_m / WGS84_A_M;
                GAMMA_E_M_S2 * (1.0 + GAMMA_K * sin_sq)
                    / (1.0 - self.eccentricity_sq() * sin_sq).sqrt()
                    * (1.0 - 2.0 * (1.0 + WGS84_F + GAMMA_M - 2.0 * WGS84_F * sin_sq) * h
                        + 3.0 * h * h)
            }
            Self::Sphere => {
                let ratio = SPHERE_R_M / (SPHERE_R_M + height_m);
                STANDARD_GRAVITY_M_S2 * ratio * ratio
            }
        }
    }

    /// Gravity as a vector in Earth axes, m/s².
    #[inline]
    pub fn gravity_e(self, place: &Place) -> Vec3 {
        scale(
            -self.gravity_m_s2(place.normal_e[2] * place.normal_e[2], place.height_m),
            place.normal_e,
        )
    }

    /// Mass attraction, gravity without its centrifugal part: g + Ω×(Ω×r), m/s², Earth axes (inertial axes likewise: the
    /// field is symmetric about z).
    pub fn gravitation_e(self, position_e: Vec3) -> Vec3 {
        let g = self.gravity_e(&self.place(position_e));
        let w2 = self.rate_rad_s() * self.rate_rad_s();
        [g[0] - w2 * position_e[0], g[1] - w2 * position_e[1], g[2]]
    }

    /// Earth-fixed position of a place, m.
    pub fn position_e(self, place: &Place) -> Vec3 {
        let e2 = self.eccentricity_sq();
        let [x, y, z] = place.normal_e;
        let nu = self.semi_major_m() / (1.0 - e2 * z * z).sqrt();
        let h = place.height_m;
        [(nu + h) * x, (nu + h) * y, (nu * (1.0 - e2) + h) * z]
    }

    /// The place of an Earth-fixed position in m: Bowring's tangent, iterated until it stands (exact to rounding above
    /// −6000 km). The centre of the Earth is taken as lying below the north pole.
    pub fn place(self, position_e: Vec3) -> Place {
        let a = self.semi_major_m();
        let e2 = self.eccentricity_sq();
        let [x, y, z] = position_e;
        let p = x.hypot(y);
        if p == 0.0 && z == 0.0 {
            return Place {
                normal_e: [0.0, 0.0, 1.0],
                height_m: -a * (1.0 - e2).sqrt(),
            };
        }
        let flat = (1.0 - e2).sqrt();
        let b = a * flat;
        let ep2 = e2 / (1.0 - e2);
        // tan of the parametric latitude, kept as (cos, sin) so that poles need no care.
        let (mut cu, mut su) = {
            let n = (p * flat).hypot(z);
            (p * flat / n, z / n)
        };
        let (mut c, mut s) = (0.0, 0.0);
        for _ in 0..3 {
            let (num, den) = (z + ep2 * b * su * su * su, p - e2 * a * cu * cu * cu);
            let n = num.hypot(den);
            (c, s) = (den / n, num / n);
            let n = c.hypot(flat * s);
            (cu, su) = (c / n, flat * s / n);
        }
        let height_m = p * c + z * s - a * (1.0 - e2 * s * s).sqrt();
        let (cl, sl) = if p > 0.0 { (x / p, y / p) } else { (1.0, 0.0) };
        Place {
            normal_e: [c * cl, c * sl, s],
            height_m,
        }
    }

    /// Specific force in Earth axes that a motion needs, r̈ + 2Ω×ṙ − g, m/s².
    #[inline]
    pub fn specific_force_e(self, place: &Place, velocity_e: Vec3, acceleration_e: Vec3) -> Vec3 {
        let coriolis = scale(2.0, cross([0.0, 0.0, self.rate_rad_s()], velocity_e));
        sub(
            crate::attitude::add(acceleration_e, coriolis),
            self.gravity_e(place),
        )
    }

    /// Height change per metre towards a direction: the up component of a displacement, m.
    pub fn up(place: &Place, displacement_e: Vec3) -> f64 {
        dot(place.normal_e, displacement_e)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn gravity_at_45_degrees() {
        // navigation.md §1.1: 9.8061978 m/s², all digits given.
        let p = Place::from_geodetic(45f64.to_radians(), 0.0, 0.0);
        assert!((Earth::Wgs84.gravity_m_s2(p.normal_e[2].powi(2), 0.0) - 9.806_197_8).abs() < 5e-8);
        // Somigliana's formula gives the pole's 9.8321849378 m/s² of WGS 84.
        assert!((Earth::Wgs84.gravity_m_s2(1.0, 0.0) - 9.832_184_937_8).abs() < 1e-9);
    }

    #[test]
    fn places_come_back() {
        for earth in [Earth::Wgs84, Earth::Sphere] {
            for latitude in [-90.0f64, -89.999_999, -45.0, -1e-9, 0.0, 30.0, 89.5, 90.0] {
                for (longitude, height) in
                    [(0.0f64, 0.0), (179.9, 6e4), (-180.0, -500.0), (12.0, 4e7)]
                {
                    let place =
                        Place::from_geodetic(latitude.to_radians(), longitude.to_radians(), height);
                    let position = earth.position_e(&place);
                    let back = earth.position_e(&earth.place(position));
                    for i in 0..3 {
                        // A few roundings of 1e7 m.
                        assert!(
                            (position[i] - back[i]).abs() < 2e-15 * (6.4e6 + height),
                            "{latitude} {longitude} {height}"
                        );
                    }
                    assert!(
                        (earth.place(position).latitude_rad() - latitude.to_radians()).abs()
                            < 1e-14
                    );
                }
            }
        }
    }
}
