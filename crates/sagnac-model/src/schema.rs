//! The keys of a model file that hold numbers: table, key, dimension, shape. Reader, writer and parameter paths all read this table.
//!
//! Contract: one sensor, everything the lecture names; every value may differ by axis (slides 2–11).

use crate::units::Dimension;
use sagnac_core::Sensor;

/// How many numbers a key holds, and what they are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    /// One value for all axes, or x, y, z.
    Axes,
    /// One value for all, or a table of xy, xz, yx, yz, zx, zy.
    Elements,
    /// Three rows of three.
    Matrix,
    /// Three rows of six: xx, yy, zz, xy, xz, yz.
    Products,
    /// The three components of a position vector.
    Vector,
}

const AXES: [&str; 3] = ["x", "y", "z"];
const ELEMENTS: [&str; 6] = ["xy", "xz", "yx", "yz", "zx", "zy"];
const MATRIX: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];
const PRODUCTS: [&str; 18] = [
    "x.xx", "x.yy", "x.zz", "x.xy", "x.xz", "x.yz", "y.xx", "y.yy", "y.zz", "y.xy", "y.xz", "y.yz",
    "z.xx", "z.yy", "z.zz", "z.xy", "z.xz", "z.yz",
];

impl Shape {
    /// What a parameter path ends in, in the order of the file.
    pub(crate) fn suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Axes | Self::Vector => &AXES,
            Self::Elements => &ELEMENTS,
            Self::Matrix => &MATRIX,
            Self::Products => &PRODUCTS,
        }
    }
}

/// Which numbers a key accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Any,
    NotNegative,
    Positive,
    /// Between 0 and 1, both excluded.
    Fraction,
}

/// Where the entries of a key stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A value.
    Value,
    /// A list with a row for each power of T − T0, from 1.
    Powers,
    /// In each table of a list of tables.
    Listed,
    /// In the rows `values` of a spline.
    Spline,
}

/// One key.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaf {
    /// The sensors that have it.
    pub(crate) sensors: &'static [Sensor],
    /// The tables under the sensor's that it stands in, and for [`Kind::Listed`] the list.
    pub(crate) table: &'static [&'static str],
    /// The key itself.
    pub(crate) key: &'static str,
    /// The dimension for gyro and accelerometer.
    pub(crate) dimensions: [Dimension; 2],
    pub(crate) shape: Shape,
    pub(crate) sign: Sign,
    pub(crate) kind: Kind,
}

impl Leaf {
    pub(crate) fn dimension(&self, sensor: Sensor) -> Dimension {
        self.dimensions[sensor.index()]
    }

    /// The keys of the path under the sensor: `fixed` and `matrix` are left out, and `values` of a spline.
    pub(crate) fn path_keys(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.table
            .iter()
            .copied()
            .chain((!self.is_silent()).then_some(self.key))
    }

    pub(crate) fn path_length(&self) -> usize {
        self.table.len() + usize::from(!self.is_silent())
    }

    fn is_silent(&self) -> bool {
        matches!(self.kind, Kind::Value) && matches!(self.key, "fixed" | "matrix")
            || matches!(self.kind, Kind::Spline)
    }
}

use Dimension as D;
const BOTH: &[Sensor] = &[Sensor::Gyro, Sensor::Accel];
const GYRO: &[Sensor] = &[Sensor::Gyro];
const ACCEL: &[Sensor] = &[Sensor::Accel];
const OUTPUT: [Dimension; 2] = [D::ANGULAR_RATE, D::ACCELERATION];
const RATIO: [Dimension; 2] = [D::RATIO, D::RATIO];
const ANGLE: [Dimension; 2] = [D::ANGLE, D::ANGLE];
const TIME: [Dimension; 2] = [D::TIME, D::TIME];
const FREQUENCY: [Dimension; 2] = [D::FREQUENCY, D::FREQUENCY];
const LENGTH: [Dimension; 2] = [D::LENGTH, D::LENGTH];
const WHITE: [Dimension; 2] = [D::ANGLE_RANDOM_WALK, D::VELOCITY_RANDOM_WALK];
const DENSITY: [Dimension; 2] = [D::RATE_NOISE_DENSITY, D::ACCELERATION_NOISE_DENSITY];
const WALK: [Dimension; 2] = [D::RATE_RANDOM_WALK, D::ACCELERATION_RANDOM_WALK];
const RAMP: [Dimension; 2] = [D::RATE_RAMP, D::ACCELERATION_RAMP];

const fn leaf(
    sensors: &'static [Sensor],
    table: &'static [&'static str],
    key: &'static str,
    dimensions: [Dimension; 2],
    shape: Shape,
    sign: Sign,
) -> Leaf {
    Leaf {
        sensors,
        table,
        key,
        dimensions,
        shape,
        sign,
        kind: Kind::Value,
    }
}

const fn axes(
    table: &'static [&'static str],
    key: &'static str,
    dimensions: [Dimension; 2],
    sign: Sign,
) -> Leaf {
    leaf(BOTH, table, key, dimensions, Shape::Axes, sign)
}

const fn of_kind(kind: Kind, leaf: Leaf) -> Leaf {
    Leaf { kind, ..leaf }
}

const BIAS: &[&str] = &["bias"];
const INSTABILITY: &[&str] = &["bias", "instability"];
const SCALE: &[&str] = &["scale_factor"];
const NOISE: &[&str] = &["noise"];
const GAUSS_MARKOV: &[&str] = &["noise", "gauss_markov"];
const SINUSOIDS: &[&str] = &["noise", "sinusoids"];
const RESONANCES: &[&str] = &["noise", "resonances"];

/// Every key that holds numbers, in the order of the contract.
pub(crate) const LEAVES: &[Leaf] = &[
    axes(&[], "range", OUTPUT, Sign::Positive),
    axes(&[], "resolution", OUTPUT, Sign::Positive),
    axes(&[], "bandwidth", FREQUENCY, Sign::Positive),
    axes(BIAS, "fixed", OUTPUT, Sign::Any),
    of_kind(Kind::Powers, axes(BIAS, "temperature", OUTPUT, Sign::Any)),
    of_kind(
        Kind::Spline,
        axes(&["bias", "temperature_spline"], "values", OUTPUT, Sign::Any),
    ),
    axes(BIAS, "stability", OUTPUT, Sign::NotNegative),
    axes(INSTABILITY, "coefficient", OUTPUT, Sign::NotNegative),
    axes(INSTABILITY, "allan_minimum", OUTPUT, Sign::NotNegative),
    axes(INSTABILITY, "sigma", OUTPUT, Sign::NotNegative),
    axes(INSTABILITY, "correlation_time", TIME, Sign::Positive),
    leaf(
        GYRO,
        INSTABILITY,
        "rate_random_walk",
        WALK,
        Shape::Axes,
        Sign::NotNegative,
    ),
    leaf(
        ACCEL,
        INSTABILITY,
        "acceleration_random_walk",
        WALK,
        Shape::Axes,
        Sign::NotNegative,
    ),
    axes(SCALE, "fixed", RATIO, Sign::Any),
    of_kind(Kind::Powers, axes(SCALE, "temperature", RATIO, Sign::Any)),
    of_kind(
        Kind::Spline,
        axes(
            &["scale_factor", "temperature_spline"],
            "values",
            RATIO,
            Sign::Any,
        ),
    ),
    axes(SCALE, "stability", RATIO, Sign::NotNegative),
    axes(
        SCALE,
        "quadratic",
        [D::GYRO_QUADRATIC, D::ACCEL_QUADRATIC],
        Sign::Any,
    ),
    axes(SCALE, "cubic", [D::GYRO_CUBIC, D::ACCEL_CUBIC], Sign::Any),
    axes(SCALE, "asymmetry", RATIO, Sign::Any),
    leaf(
        BOTH,
        &["misalignment"],
        "fixed",
        ANGLE,
        Shape::Elements,
        Sign::Any,
    ),
    leaf(
        BOTH,
        &["misalignment"],
        "stability",
        ANGLE,
        Shape::Elements,
        Sign::NotNegative,
    ),
    leaf(
        BOTH,
        &["cross_axis"],
        "fixed",
        RATIO,
        Shape::Elements,
        Sign::Any,
    ),
    leaf(
        GYRO,
        &["g_sensitivity"],
        "matrix",
        [D::G_SENSITIVITY, D::G_SENSITIVITY],
        Shape::Matrix,
        Sign::Any,
    ),
    leaf(
        GYRO,
        &["g2_sensitivity"],
        "matrix",
        [D::G2_SENSITIVITY, D::G2_SENSITIVITY],
        Shape::Products,
        Sign::Any,
    ),
    leaf(
        GYRO,
        NOISE,
        "angle_random_walk",
        WHITE,
        Shape::Axes,
        Sign::NotNegative,
    ),
    leaf(
        ACCEL,
        NOISE,
        "velocity_random_walk",
        WHITE,
        Shape::Axes,
        Sign::NotNegative,
    ),
    axes(NOISE, "noise_density_one_sided", DENSITY, Sign::NotNegative),
    leaf(
        GYRO,
        NOISE,
        "rate_random_walk",
        WALK,
        Shape::Axes,
        Sign::NotNegative,
    ),
    leaf(
        ACCEL,
        NOISE,
        "acceleration_random_walk",
        WALK,
        Shape::Axes,
        Sign::NotNegative,
    ),
    axes(
        NOISE,
        "quantization",
        [D::ANGLE, D::SPEED],
        Sign::NotNegative,
    ),
    leaf(GYRO, NOISE, "rate_ramp", RAMP, Shape::Axes, Sign::Any),
    leaf(
        ACCEL,
        NOISE,
        "acceleration_ramp",
        RAMP,
        Shape::Axes,
        Sign::Any,
    ),
    of_kind(
        Kind::Listed,
        axes(GAUSS_MARKOV, "sigma", OUTPUT, Sign::NotNegative),
    ),
    of_kind(
        Kind::Listed,
        axes(GAUSS_MARKOV, "correlation_time", TIME, Sign::Positive),
    ),
    of_kind(
        Kind::Listed,
        axes(SINUSOIDS, "amplitude", OUTPUT, Sign::NotNegative),
    ),
    of_kind(
        Kind::Listed,
        axes(SINUSOIDS, "frequency", FREQUENCY, Sign::Positive),
    ),
    of_kind(
        Kind::Listed,
        axes(RESONANCES, "sigma", OUTPUT, Sign::NotNegative),
    ),
    of_kind(
        Kind::Listed,
        axes(RESONANCES, "frequency", FREQUENCY, Sign::Positive),
    ),
    of_kind(
        Kind::Listed,
        axes(RESONANCES, "damping", RATIO, Sign::Fraction),
    ),
    leaf(
        ACCEL,
        &["axis_offset"],
        "x",
        LENGTH,
        Shape::Vector,
        Sign::Any,
    ),
    leaf(
        ACCEL,
        &["axis_offset"],
        "y",
        LENGTH,
        Shape::Vector,
        Sign::Any,
    ),
    leaf(
        ACCEL,
        &["axis_offset"],
        "z",
        LENGTH,
        Shape::Vector,
        Sign::Any,
    ),
];

/// Keys of a table under a sensor that hold no parameter.
pub(crate) fn other_keys(table: &[&str]) -> &'static [&'static str] {
    match table {
        [] => &["technology", "output"],
        ["bias" | "scale_factor"] => &["temperature_range"],
        ["bias", "instability"] => &["process"],
        ["bias" | "scale_factor", "temperature_spline"] => &["knots"],
        _ => &[],
    }
}

/// The most powers of temperature.
pub(crate) const MOST_POWERS: usize = sagnac_core::MAX_POWER;
/// The most entries of a list of processes: more is no sensor.
pub(crate) const MOST_LISTED: usize = 64;

/// The keys and tables that a table under a sensor may hold.
pub(crate) fn keys_of(sensor: Sensor, table: &[&str]) -> Vec<&'static str> {
    let mut keys: Vec<&'static str> = Vec::new();
    for leaf in LEAVES.iter().filter(|leaf| leaf.sensors.contains(&sensor)) {
        if !leaf.table.starts_with(table) {
            continue;
        }
        let key = leaf.table.get(table.len()).copied().unwrap_or(leaf.key);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys.extend(other_keys(table));
    keys
}
