//! The units of the field, by sensor and term: how a number in SI is shown.

use core::f64::consts::PI;

const DEG: f64 = 180.0 / PI;
const STANDARD_GRAVITY: f64 = 9.806_65;
/// √(1 h / 1 s).
const SQRT_HOUR: f64 = 60.0;

/// A sensor of three axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sensor {
    /// Gyroscope, angular rate.
    Gyro,
    /// Accelerometer, specific force.
    Accel,
}

impl Sensor {
    /// Name as in channel names: `gyro`, `accel`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accel => "accel",
        }
    }

    /// Name at the start of a sentence: `Gyro`, `Accelerometer`.
    pub fn title(self) -> &'static str {
        match self {
            Self::Gyro => "Gyro",
            Self::Accel => "Accelerometer",
        }
    }

    /// The sensor of a channel name such as `gyro_x`.
    pub fn of_axis(name: &str) -> Option<Self> {
        if name.starts_with("gyro") {
            Some(Self::Gyro)
        } else if name.starts_with("accel") {
            Some(Self::Accel)
        } else {
            None
        }
    }
}

/// A unit in which a number is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Spelling in a terminal, readable as input: `deg/√h`.
    pub text: &'static str,
    /// Spelling on a page: `°/√h`.
    pub page: &'static str,
    /// Number in this unit of one SI unit.
    pub per_si: f64,
}

impl Unit {
    const fn new(text: &'static str, page: &'static str, per_si: f64) -> Self {
        Self { text, page, per_si }
    }

    /// Value in this unit of a value in SI.
    pub fn from_si(self, value: f64) -> f64 {
        value * self.per_si
    }

    /// deg/h.
    pub const DEG_PER_H: Self = Self::new("deg/h", "°/h", DEG * 3600.0);
    /// deg/s.
    pub const DEG_PER_S: Self = Self::new("deg/s", "°/s", DEG);
    /// mdeg/s, spelt `mdps`.
    pub const MDPS: Self = Self::new("mdps", "mdps", DEG * 1e3);
    /// deg/√h.
    pub const DEG_PER_SQRT_H: Self = Self::new("deg/√h", "°/√h", DEG * SQRT_HOUR);
    /// deg/s/√Hz, two- or one-sided as said beside it.
    pub const DEG_PER_S_PER_SQRT_HZ: Self = Self::new("deg/s/√Hz", "°/s/√Hz", DEG);
    /// deg/h/√h.
    pub const DEG_PER_H_PER_SQRT_H: Self =
        Self::new("deg/h/√h", "°/h/√h", DEG * 3600.0 * SQRT_HOUR);
    /// deg/h/h.
    pub const DEG_PER_H_PER_H: Self = Self::new("deg/h/h", "°/h/h", DEG * 3600.0 * 3600.0);
    /// arcsec.
    pub const ARCSEC: Self = Self::new("arcsec", "arcsec", DEG * 3600.0);
    /// Micro-g (standard gravity).
    pub const MICRO_G: Self = Self::new("ug", "µg", 1e6 / STANDARD_GRAVITY);
    /// Milli-g.
    pub const MILLI_G: Self = Self::new("mg", "mg", 1e3 / STANDARD_GRAVITY);
    /// Standard gravity.
    pub const G: Self = Self::new("g", "g", 1.0 / STANDARD_GRAVITY);
    /// m/s^2.
    pub const M_PER_S2: Self = Self::new("m/s^2", "m/s²", 1.0);
    /// mm/s^2.
    pub const MM_PER_S2: Self = Self::new("mm/s^2", "mm/s²", 1e3);
    /// m/s/√h.
    pub const M_PER_S_PER_SQRT_H: Self = Self::new("m/s/√h", "m/s/√h", SQRT_HOUR);
    /// ug/√Hz.
    pub const MICRO_G_PER_SQRT_HZ: Self = Self::new("ug/√Hz", "µg/√Hz", 1e6 / STANDARD_GRAVITY);
    /// mg/√h.
    pub const MILLI_G_PER_SQRT_H: Self =
        Self::new("mg/√h", "mg/√h", 1e3 / STANDARD_GRAVITY * SQRT_HOUR);
    /// mg/h.
    pub const MILLI_G_PER_H: Self = Self::new("mg/h", "mg/h", 1e3 / STANDARD_GRAVITY * 3600.0);
    /// mm/s.
    pub const MM_PER_S: Self = Self::new("mm/s", "mm/s", 1e3);
    /// Parts per million.
    pub const PPM: Self = Self::new("ppm", "ppm", 1e6);
    /// Microradian.
    pub const MICRO_RAD: Self = Self::new("urad", "µrad", 1e6);
    /// Milliradian.
    pub const MILLI_RAD: Self = Self::new("mrad", "mrad", 1e3);
    /// Second.
    pub const S: Self = Self::new("s", "s", 1.0);
    /// Hertz.
    pub const HZ: Self = Self::new("Hz", "Hz", 1.0);
    /// Degree Celsius (the number in SI is taken in degC as well).
    pub const DEG_C: Self = Self::new("degC", "°C", 1.0);
    /// rad/s.
    pub const RAD_PER_S: Self = Self::new("rad/s", "rad/s", 1.0);

    /// Unit in which the field gives a noise term, by its JSON name.
    ///
    /// Amplitudes of Gauss–Markov processes and sinusoids (`gauss_markov`, `sinusoids`) are those of the
    /// bias instability; `mean` is deg/h and mg; an unknown name gets the unit of the sensor's output.
    pub fn of_term(sensor: Sensor, term: &str) -> Self {
        match (sensor, term) {
            (Sensor::Gyro, "quantization") => Self::ARCSEC,
            (Sensor::Gyro, "angle_random_walk") => Self::DEG_PER_SQRT_H,
            (Sensor::Gyro, "rate_random_walk") => Self::DEG_PER_H_PER_SQRT_H,
            (Sensor::Gyro, "rate_ramp") => Self::DEG_PER_H_PER_H,
            (Sensor::Gyro, "lsb_rate") => Self::DEG_PER_S,
            (Sensor::Gyro, _) => Self::DEG_PER_H,
            (Sensor::Accel, "quantization") => Self::MM_PER_S,
            (Sensor::Accel, "velocity_random_walk") => Self::M_PER_S_PER_SQRT_H,
            (Sensor::Accel, "acceleration_random_walk") => Self::MILLI_G_PER_SQRT_H,
            (Sensor::Accel, "acceleration_ramp") => Self::MILLI_G_PER_H,
            (Sensor::Accel, "bias_instability" | "gauss_markov" | "sinusoids" | "allan") => {
                Self::MICRO_G
            }
            (Sensor::Accel, _) => Self::MILLI_G,
        }
    }

    /// SI spelling of the unit of a noise term, as on pages.
    pub fn si_of_term(sensor: Sensor, term: &str) -> &'static str {
        match (sensor, term) {
            (Sensor::Gyro, "quantization") => "rad",
            (Sensor::Gyro, "angle_random_walk") => "rad/√s",
            (Sensor::Gyro, "rate_random_walk") => "rad/s/√s",
            (Sensor::Gyro, "rate_ramp") => "rad/s²",
            (Sensor::Gyro, _) => "rad/s",
            (Sensor::Accel, "quantization") => "m/s",
            (Sensor::Accel, "velocity_random_walk") => "m/s/√s",
            (Sensor::Accel, "acceleration_random_walk") => "m/s²/√s",
            (Sensor::Accel, "acceleration_ramp") => "m/s³",
            (Sensor::Accel, _) => "m/s²",
        }
    }
}

/// Full name of a noise term by its JSON name, as in IEEE Std 528 and 952.
pub fn term_name(term: &str) -> &str {
    match term {
        "quantization" => "Quantization noise",
        "angle_random_walk" => "Angle random walk",
        "velocity_random_walk" => "Velocity random walk",
        "bias_instability" => "Bias instability",
        "rate_random_walk" => "Rate random walk",
        "acceleration_random_walk" => "Acceleration random walk",
        "rate_ramp" => "Rate ramp",
        "acceleration_ramp" => "Acceleration ramp",
        "gauss_markov" => "Gauss-Markov sigma",
        "sinusoids" => "Sinusoid amplitude",
        "mean" => "Mean",
        "bias_stability" => "Bias stability",
        other => other,
    }
}

/// Name of a noise term within a sentence: `angle random walk`, `a Gauss-Markov process`.
pub fn term_in_sentence(term: &str) -> String {
    match term {
        "gauss_markov" => "a Gauss-Markov process".to_owned(),
        other => term_name(other).to_lowercase(),
    }
}

/// Letter of a noise term by its JSON name: Q, N, B, K, R; `None` for terms without one.
pub fn term_symbol(term: &str) -> Option<&'static str> {
    match term {
        "quantization" => Some("Q"),
        "angle_random_walk" | "velocity_random_walk" => Some("N"),
        "bias_instability" => Some("B"),
        "rate_random_walk" | "acceleration_random_walk" => Some("K"),
        "rate_ramp" | "acceleration_ramp" => Some("R"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_random_walk_converts() {
        // 0.3 deg/√h = 0.3 π/180/60 rad/√s, by the definition of the hour; f64 rounding only.
        let si = 0.3 * PI / 180.0 / 60.0;
        let unit = Unit::of_term(Sensor::Gyro, "angle_random_walk");
        assert!((unit.from_si(si) / 0.3 - 1.0).abs() < 1e-14);
        assert_eq!(unit.text, "deg/√h");
    }

    #[test]
    fn acceleration_random_walk_converts() {
        // 1 mg/√h = 9.80665e-3/60 m/s²/√s.
        let unit = Unit::of_term(Sensor::Accel, "acceleration_random_walk");
        assert!((unit.from_si(9.80665e-3 / 60.0) - 1.0).abs() < 1e-14);
    }
}
