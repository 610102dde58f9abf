//! What the ROS writers share: rows as `sensor_msgs/Imu`, and what such a message cannot hold.
//!
//! Covariances are the layout's, else 0, which ROS reads as unknown; −1 where the log has no such triad (and for the
//! orientation).

use crate::{Block, Error, Layout, Stamp};

/// Where the six values of a message stand in the block.
pub(crate) struct ImuRows {
    columns: [Option<usize>; 6],
    covariances: Option<[[f64; 9]; 2]>,
    rate_hz: Option<f64>,
    rows: u64,
    left_out: Vec<String>,
    rounded: bool,
    /// The name of the topic.
    pub(crate) topic: String,
    /// The frame of the messages.
    pub(crate) frame_id: String,
}

/// The topic, and the frame of its messages, of logs that have none.
const TOPIC: &str = "/imu/data";
const FRAME: &str = "imu";

impl ImuRows {
    pub(crate) fn new(layout: &Layout) -> Result<Self, Error> {
        let names = [
            "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z",
        ];
        let columns = names.map(|n| layout.index(n));
        if columns.iter().all(Option::is_none) {
            return Err(Error::data(
                "sensor_msgs/Imu holds gyro and accelerometer, and the log has neither",
            ));
        }
        Ok(Self {
            columns,
            covariances: layout.covariances,
            rate_hz: layout.rate_hz,
            rows: 0,
            left_out: layout
                .channels
                .iter()
                .filter(|c| !names.contains(&c.name.as_str()))
                .map(|c| c.name.clone())
                .collect(),
            rounded: false,
            topic: match (&layout.topic, &layout.frame_id) {
                (Some(topic), Some(_)) => topic.clone(),
                _ => TOPIC.to_owned(),
            },
            frame_id: layout.frame_id.clone().unwrap_or_else(|| FRAME.to_owned()),
        })
    }

    /// Stamp [ns] and body (orientation to the last covariance, little-endian) of row `k`.
    pub(crate) fn row(&mut self, block: &Block, k: usize) -> Result<(u64, [u8; 296]), Error> {
        let counted = || Stamp::of_row(self.rows + 1, self.rate_hz.unwrap_or(1.0));
        let ns = match block.stamps.get(k).unwrap_or_else(counted) {
            Stamp::Nanoseconds(ns) => Some(ns),
            Stamp::Seconds(s) => {
                self.rounded = true;
                (s.is_finite() && s.abs() < 9e9).then(|| (s * 1e9).round() as i64)
            }
        };
        // Seconds of ROS time are 32 bits, of ROS 2 with a sign.
        let ns = ns
            .and_then(|ns| u64::try_from(ns).ok())
            .filter(|ns| ns / 1_000_000_000 <= u64::from(u32::MAX >> 1))
            .ok_or_else(|| {
                Error::data("ROS time holds 1970 to 2038, and a time stamp of the log lies outside")
            })?;
        self.rows += 1;
        let mut body = [0; 296];
        let mut put = |i: usize, v: f64| body[8 * i..8 * i + 8].copy_from_slice(&v.to_le_bytes());
        put(4, -1.0);
        for (place, triad) in [(13, 0), (25, 3)] {
            let own = &self.columns[triad..triad + 3];
            if own.iter().all(Option::is_none) {
                put(place + 3, -1.0);
            } else if let Some(all) = &self.covariances {
                for (j, v) in all[triad / 3].iter().enumerate() {
                    put(place + 3 + j, *v);
                }
            }
            for (j, column) in own.iter().enumerate() {
                let value = match column {
                    Some(c) => block.columns.get(*c).and_then(|v| v.get(k)).copied(),
                    None => Some(0.0),
                };
                put(place + j, value.unwrap_or(f64::NAN));
            }
        }
        Ok((ns, body))
    }

    /// What the user should be told.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut out = vec![format!(
            "written as {}, frame_id \"{}\"; covariances are {}",
            crate::map::columns::clip(&self.topic),
            crate::map::columns::clip(&self.frame_id),
            if self.covariances.is_some() {
                "set, the same in every message"
            } else {
                "0, which ROS reads as unknown"
            }
        )];
        if !self.left_out.is_empty() {
            out.push(format!(
                "sensor_msgs/Imu has no place for {}: left out",
                self.left_out.join(", ")
            ));
        }
        if self.rounded {
            out.push("time stamps were rounded to nanoseconds".to_owned());
        }
        out
    }
}

/// The parts of the message's definition after its header line, for both generations.
pub(crate) fn definition(header: &str, header_parts: &str) -> String {
    let line = "=".repeat(80);
    let body = "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
        geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
        geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n";
    let parts = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
    let vector = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    format!("{header}\n{body}{line}\n{header_parts}{line}\n{parts}{line}\n{vector}")
}

/// A divider between the parts of a definition.
pub(crate) fn divider() -> String {
    "=".repeat(80)
}
