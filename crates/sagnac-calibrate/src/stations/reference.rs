//! True inputs of a station from attitude, the axis that points up, latitude and height.
//!
//! f = C_n^b (0, 0, −g), w = C_n^b Ω_e (cos φ, 0, −sin φ); normal gravity of WGS 84 by Somigliana's formula.

/// Rate of the Earth \[rad/s\].
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;
/// What is added to the reference's standard error where the Earth's rate is not known \[rad/s\].
pub const UNKNOWN_EARTH_RATE_RAD_S: f64 = 7.3e-5;

/// Normal gravity \[m/s²\] at a latitude \[rad\] and a height \[m\].
pub fn gravity_m_s2(latitude_rad: f64, height_m: f64) -> f64 {
    let s2 = latitude_rad.sin().powi(2);
    let surface = 9.780_325_335_9 * (1.0 + 0.001_931_852_652_41 * s2)
        / (1.0 - 0.006_694_379_990_14 * s2).sqrt();
    let (a, flattening, m) = (6_378_137.0, 1.0 / 298.257_223_563, 0.003_449_786_506_84);
    surface
        * (1.0 - 2.0 * height_m / a * (1.0 + flattening + m - 2.0 * flattening * s2)
            + 3.0 * (height_m / a).powi(2))
}

/// C_n^b = R1(roll) R2(pitch) R3(heading), from north, east, down to the body.
pub fn body_from_navigation(roll_rad: f64, pitch_rad: f64, heading_rad: f64) -> [[f64; 3]; 3] {
    let (sr, cr) = roll_rad.sin_cos();
    let (sp, cp) = pitch_rad.sin_cos();
    let (sh, ch) = heading_rad.sin_cos();
    [
        [cp * ch, cp * sh, -sp],
        [sr * sp * ch - cr * sh, sr * sp * sh + cr * ch, sr * cp],
        [cr * sp * ch + sr * sh, cr * sp * sh - sr * ch, cr * cp],
    ]
}

/// Standard errors of the components of a vector of `size` along `direction` that is off by `tilt_rad` about
/// each axis across it: size·t across, size·t²/√2 along.
pub fn tilt_sigma(vector: [f64; 3], size: f64, tilt_rad: f64) -> [f64; 3] {
    let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    if norm == 0.0 || tilt_rad == 0.0 {
        return [0.0; 3];
    }
    vector.map(|v| {
        let along = (v / norm).powi(2);
        let across = (1.0 - along).max(0.0);
        size * tilt_rad * (across + along * tilt_rad * tilt_rad / 2.0).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_gravity_as_published() {
        for (latitude, height, g) in [
            (0.0, 0.0, 9.780_325_336),
            (45.0, 0.0, 9.806_197_769),
            (45.0, 1000.0, 9.803_112_944),
            (90.0, 0.0, 9.832_184_938),
        ] {
            // Ten digits are stated.
            assert!((gravity_m_s2(f64::to_radians(latitude), height) - g).abs() < 6e-10);
        }
    }

    #[test]
    fn attitude_example() {
        let c = body_from_navigation(
            10f64.to_radians(),
            (-20f64).to_radians(),
            30f64.to_radians(),
        );
        let phi = 45f64.to_radians();
        let g = gravity_m_s2(phi, 0.0);
        let f = c.map(|row| -g * row[2]);
        let w = c.map(|row| EARTH_RATE_RAD_S * (row[0] * phi.cos() - row[2] * phi.sin()));
        for (got, want) in f.into_iter().zip([-3.353_917, -1.600_135, -9.074_818]) {
            assert!((got - want).abs() < 1e-6);
        }
        for (got, want) in w
            .into_iter()
            .zip([2.432_629e-5, -3.645_579e-5, -5.828_122e-5])
        {
            assert!((got - want).abs() < 1e-11);
        }
    }
}
