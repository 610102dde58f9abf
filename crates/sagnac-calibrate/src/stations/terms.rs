//! The terms of a station regression: groups, names, columns, plausible sizes.
//!
//! output_k − u' = Σ parameter × column; u' = w, or f' = f + Ω r_k for accelerometers. Terms of `[IEEE1293]`, `[IEEE1554]`.

use sagnac_core::Sensor;

/// Letters of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Products of specific force, in the order of the columns of the g²-sensitivity.
pub const PRODUCTS: [(usize, usize, &str); 6] = [
    (0, 0, "xx"),
    (1, 1, "yy"),
    (2, 2, "zz"),
    (0, 1, "xy"),
    (0, 2, "xz"),
    (1, 2, "yz"),
];

/// The highest power of temperature that a model holds.
const MOST_POWERS: u8 = 8;

/// A group of terms that enters the regression together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// b.
    Bias,
    /// s.
    ScaleFactor,
    /// m, two of each axis.
    Misalignment,
    /// c of one power of T − T0.
    BiasTemperature(u8),
    /// G, three of each gyro axis.
    GSensitivity,
    /// r, three of each accelerometer.
    AxisOffset,
    /// s of one power of T − T0.
    ScaleTemperature(u8),
    /// k2.
    Quadratic,
    /// a.
    Asymmetry,
    /// k3.
    Cubic,
    /// H, six of each gyro axis.
    G2Sensitivity,
}

impl Group {
    /// Its name, without a power.
    pub fn key(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::ScaleFactor => "scale_factor",
            Self::Misalignment => "misalignment",
            Self::BiasTemperature(_) => "bias.temperature",
            Self::GSensitivity => "g_sensitivity",
            Self::AxisOffset => "axis_offset",
            Self::ScaleTemperature(_) => "scale_factor.temperature",
            Self::Quadratic => "quadratic",
            Self::Asymmetry => "asymmetry",
            Self::Cubic => "cubic",
            Self::G2Sensitivity => "g2_sensitivity",
        }
    }

    /// Every name.
    pub const KEYS: [&'static str; 11] = [
        "bias",
        "scale_factor",
        "misalignment",
        "bias.temperature",
        "g_sensitivity",
        "axis_offset",
        "scale_factor.temperature",
        "quadratic",
        "asymmetry",
        "cubic",
        "g2_sensitivity",
    ];

    /// The groups of a sensor, in the order in which they enter.
    pub fn of(sensor: Sensor, bias_order: u8, scale_order: u8) -> Vec<Self> {
        let mut out = vec![Self::Bias, Self::ScaleFactor, Self::Misalignment];
        out.extend((1..=bias_order).map(Self::BiasTemperature));
        out.push(match sensor {
            Sensor::Gyro => Self::GSensitivity,
            Sensor::Accel => Self::AxisOffset,
        });
        out.extend((1..=scale_order).map(Self::ScaleTemperature));
        out.extend([Self::Quadratic, Self::Asymmetry, Self::Cubic]);
        if sensor == Sensor::Gyro {
            out.push(Self::G2Sensitivity);
        }
        out
    }
}

/// One term of one axis; `component` is the other axis, the product or the switch-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// Its group.
    pub group: Group,
    /// Which of the group.
    pub component: usize,
}

impl Term {
    /// The terms of axis `k`, in the order in which they enter; a bias for each of `runs` switch-ons.
    pub fn of(groups: &[Group], k: usize, runs: usize) -> Vec<Self> {
        let mut out = Vec::new();
        for &group in groups {
            let components: Vec<usize> = match group {
                Group::Bias => (0..runs.max(1)).collect(),
                Group::Misalignment => (0..3).filter(|j| *j != k).collect(),
                Group::GSensitivity | Group::AxisOffset => (0..3).collect(),
                Group::G2Sensitivity => (0..6).collect(),
                _ => vec![0],
            };
            out.extend(
                components
                    .into_iter()
                    .map(|component| Self { group, component }),
            );
        }
        out
    }

    /// The parameter path of the term of axis `k`.
    pub fn name(self, sensor: Sensor, k: usize) -> String {
        let (s, axis) = (sensor.key(), AXES[k]);
        match self.group {
            Group::Bias => format!("{s}.bias.{axis}"),
            Group::ScaleFactor => format!("{s}.scale_factor.{axis}"),
            Group::Misalignment => format!("{s}.misalignment.{axis}{}", AXES[self.component]),
            Group::BiasTemperature(i) => format!("{s}.bias.temperature.{i}.{axis}"),
            Group::GSensitivity => format!("{s}.g_sensitivity.{axis}{}", AXES[self.component]),
            Group::AxisOffset => format!("{s}.axis_offset.{axis}{}", AXES[self.component]),
            Group::ScaleTemperature(i) => format!("{s}.scale_factor.temperature.{i}.{axis}"),
            Group::Quadratic => format!("{s}.scale_factor.quadratic.{axis}"),
            Group::Asymmetry => format!("{s}.scale_factor.asymmetry.{axis}"),
            Group::Cubic => format!("{s}.scale_factor.cubic.{axis}"),
            Group::G2Sensitivity => {
                format!("{s}.g2_sensitivity.{axis}.{}", PRODUCTS[self.component].2)
            }
        }
    }

    /// The term of a parameter path, its sensor and its axis.
    pub fn named(name: &str) -> Option<(Sensor, usize, Self)> {
        Sensor::ALL.into_iter().find_map(|sensor| {
            let groups = Group::of(sensor, MOST_POWERS, MOST_POWERS);
            (0..3).find_map(|k| {
                let term = Self::of(&groups, k, 1)
                    .into_iter()
                    .find(|term| term.name(sensor, k) == name)?;
                Some((sensor, k, term))
            })
        })
    }

    /// What is known of its size before any test; `reach` is the largest |u'|, `warmth_k` the largest |T − T0|.
    pub fn plausible(self, sensor: Sensor, reach: f64, warmth_k: f64) -> f64 {
        match self.group {
            Group::Bias => f64::INFINITY,
            Group::ScaleFactor | Group::Misalignment => 0.05,
            Group::BiasTemperature(i) => {
                let whole = match sensor {
                    Sensor::Gyro => 0.05,
                    Sensor::Accel => 0.5,
                };
                whole / warmth_k.powi(i32::from(i))
            }
            Group::GSensitivity => 1e-3,
            Group::AxisOffset => 0.1,
            Group::ScaleTemperature(i) => 0.02 / warmth_k.powi(i32::from(i)),
            Group::Quadratic => 0.02 / reach,
            Group::Asymmetry => 0.02,
            Group::Cubic => 0.02 / (reach * reach),
            Group::G2Sensitivity => 1e-4,
        }
    }
}

/// True inputs of a station as the columns need them.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// u': rate, or specific force with the size effect.
    pub u: [f64; 3],
    /// Specific force at the IMU centre.
    pub f: [f64; 3],
    /// Ω's row of the axis.
    pub omega_row: [f64; 3],
    /// ∂output/∂u'.
    pub slope: f64,
    /// T − T0.
    pub warmth_k: f64,
    /// The switch-on.
    pub run: usize,
}

impl Term {
    /// Its column of axis `k` at a station.
    pub fn column(self, k: usize, at: &Inputs) -> f64 {
        let u = at.u[k];
        match self.group {
            Group::Bias => f64::from(u8::from(self.component == at.run)),
            Group::ScaleFactor => u,
            Group::Misalignment => at.u[self.component],
            Group::BiasTemperature(i) => at.warmth_k.powi(i32::from(i)),
            Group::GSensitivity => at.f[self.component],
            Group::AxisOffset => at.slope * at.omega_row[self.component],
            Group::ScaleTemperature(i) => at.warmth_k.powi(i32::from(i)) * u,
            Group::Quadratic => u * u,
            Group::Asymmetry => 0.5 * u.abs(),
            Group::Cubic => u * u * u,
            Group::G2Sensitivity => {
                let (i, j, _) = PRODUCTS[self.component];
                at.f[i] * at.f[j]
            }
        }
    }
}

/// Row `k` of Ω, the sum of the square of the cross-product matrix of w and that of ẇ.
pub fn omega_row(k: usize, w: [f64; 3], wdot: [f64; 3]) -> [f64; 3] {
    match k {
        0 => [
            -(w[1] * w[1] + w[2] * w[2]),
            w[0] * w[1] - wdot[2],
            w[0] * w[2] + wdot[1],
        ],
        1 => [
            w[0] * w[1] + wdot[2],
            -(w[0] * w[0] + w[2] * w[2]),
            w[1] * w[2] - wdot[0],
        ],
        _ => [
            w[0] * w[2] - wdot[1],
            w[1] * w[2] + wdot[0],
            -(w[0] * w[0] + w[1] * w[1]),
        ],
    }
}
