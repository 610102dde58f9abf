//! What a log holds: its format, channels, clock and the notes that reading it gave.

use crate::TextColumn;

/// What a channel measures, which fixes its SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// `gyro_*`, in rad/s.
    AngularRate,
    /// `accel_*`, in m/s^2: specific force.
    SpecificForce,
    /// `gyro_rate_*`, in rad/s^2.
    AngularAcceleration,
    /// `temperature`, in degC.
    Temperature,
    /// Anything else, kept as it is in its own unit.
    Other,
}

impl Quantity {
    /// The unit of the values, empty for [`Quantity::Other`].
    pub const fn unit(self) -> &'static str {
        match self {
            Self::AngularRate => "rad/s",
            Self::SpecificForce => "m/s^2",
            Self::AngularAcceleration => "rad/s^2",
            Self::Temperature => "degC",
            Self::Other => "",
        }
    }

    /// What the channel called `name` measures.
    pub fn of(name: &str) -> Self {
        match name {
            "gyro_x" | "gyro_y" | "gyro_z" => Self::AngularRate,
            "accel_x" | "accel_y" | "accel_z" => Self::SpecificForce,
            "gyro_rate_x" | "gyro_rate_y" | "gyro_rate_z" => Self::AngularAcceleration,
            "temperature" => Self::Temperature,
            _ => Self::Other,
        }
    }
}

/// One channel of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name: `gyro_x`, `accel_z`, `temperature`, or the source's own.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Unit of the values handed out: SI for the known quantities, the source's text for the others.
    pub unit: String,
    /// True while the values are increments (rad, m/s) that still have to be divided by dt.
    /// Never true in a [`crate::Log`].
    pub is_increment: bool,
    /// True where the source holds increments, also after they were divided by dt.
    pub from_increments: bool,
}

impl Channel {
    /// A channel in the SI unit of its name.
    pub fn named(name: &str) -> Self {
        let quantity = Quantity::of(name);
        Self {
            name: name.to_owned(),
            quantity,
            unit: quantity.unit().to_owned(),
            is_increment: false,
            from_increments: false,
        }
    }

    /// A further channel that is kept with its own unit.
    pub fn other(name: &str, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            quantity: Quantity::Other,
            unit: unit.to_owned(),
            is_increment: false,
            from_increments: false,
        }
    }
}

/// A topic, message type or instance of a log that can hold several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name, as `--topic` takes it.
    pub name: String,
    /// Its type, as the format calls it (`sensor_msgs/Imu`).
    pub kind: String,
    /// Messages in it, where the file says so before it is read.
    pub messages: Option<u64>,
    /// True where it can be read as an inertial log.
    pub is_inertial: bool,
}

/// What a log holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layout {
    /// The format in words: "CSV with a header, gzip".
    pub format: String,
    /// Channels, in the order of the block's columns. Time is not among them.
    pub channels: Vec<Channel>,
    /// Columns that are kept as text ([`crate::ReadOptions::keep_text`]), in the order of the block's.
    pub texts: Vec<TextColumn>,
    /// True where blocks carry time stamps.
    pub has_time: bool,
    /// The rate that was given or that the file states; `None` where it comes from the stamps.
    pub rate_hz: Option<f64>,
    /// Seconds of one unit of the source's time column, where it is a number: counters wrap at 2³² of them.
    pub time_unit_s: Option<f64>,
    /// Topics of the file, empty where the format has none.
    pub topics: Vec<Topic>,
    /// The topic read.
    pub topic: Option<String>,
    /// Axes as the format defines them ("x forward, right, down (FRD)"), where it does.
    pub frame: Option<String>,
    /// `frame_id` of the messages of a ROS recording, whose topic the ROS writers keep too.
    pub frame_id: Option<String>,
    /// Covariances of a sample as the source states them, row by row: angular velocity [rad²/s²], acceleration [m²/s⁴].
    pub covariances: Option<[[f64; 9]; 2]>,
    /// Samples, where the file says so before it is read.
    pub samples: Option<u64>,
    /// What a reader must know: preamble skipped, increments divided, columns left out.
    pub notes: Vec<String>,
}

impl Layout {
    /// Index of the channel called `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|c| c.name == name)
    }
}
