//! The names of sensors, axes and matrix elements that every other crate uses.

/// Which of the two triads: gyroscopes or accelerometers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sensor {
    /// Three gyroscopes: angular rate, rad/s.
    Gyro,
    /// Three accelerometers: specific force, m/s².
    Accel,
}

impl Sensor {
    /// Both, gyroscopes first.
    pub const ALL: [Self; 2] = [Self::Gyro, Self::Accel];

    /// The key of model files and channel names: `gyro` or `accel`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accel => "accel",
        }
    }

    /// The word of a sentence: `gyro` or `accelerometer`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accel => "accelerometer",
        }
    }

    /// 0 for the gyroscopes, 1 for the accelerometers.
    pub const fn index(self) -> usize {
        match self {
            Self::Gyro => 0,
            Self::Accel => 1,
        }
    }
}

/// A body axis: x forward, y right, z down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Forward.
    X,
    /// Right.
    Y,
    /// Down.
    Z,
}

impl Axis {
    /// x, y, z.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// `x`, `y` or `z`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// 0, 1 or 2.
    pub const fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// An element off the diagonal of a 3×3 matrix, row (sense axis) first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Element {
    /// Row x, column y.
    Xy,
    /// Row x, column z.
    Xz,
    /// Row y, column x.
    Yx,
    /// Row y, column z.
    Yz,
    /// Row z, column x.
    Zx,
    /// Row z, column y.
    Zy,
}

impl Element {
    /// The six in the order of the draws: xy, xz, yx, yz, zx, zy.
    pub const ALL: [Self; 6] = [Self::Xy, Self::Xz, Self::Yx, Self::Yz, Self::Zx, Self::Zy];

    /// `xy` … `zy`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Xy => "xy",
            Self::Xz => "xz",
            Self::Yx => "yx",
            Self::Yz => "yz",
            Self::Zx => "zx",
            Self::Zy => "zy",
        }
    }

    /// The place in [`Element::ALL`].
    pub const fn index(self) -> usize {
        match self {
            Self::Xy => 0,
            Self::Xz => 1,
            Self::Yx => 2,
            Self::Yz => 3,
            Self::Zx => 4,
            Self::Zy => 5,
        }
    }

    /// The sense axis.
    pub const fn row(self) -> Axis {
        match self {
            Self::Xy | Self::Xz => Axis::X,
            Self::Yx | Self::Yz => Axis::Y,
            Self::Zx | Self::Zy => Axis::Z,
        }
    }

    /// The axis of the stimulus.
    pub const fn column(self) -> Axis {
        match self {
            Self::Yx | Self::Zx => Axis::X,
            Self::Xy | Self::Zy => Axis::Y,
            Self::Xz | Self::Yz => Axis::Z,
        }
    }
}

/// The keys of the products q(f) = (fx², fy², fz², fx·fy, fx·fz, fy·fz), the columns of H_g.
pub const PRODUCT_KEYS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];
