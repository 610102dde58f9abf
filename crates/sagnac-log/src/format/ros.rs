//! `sensor_msgs/Imu` as ROS 1 and ROS 2 (CDR, either byte order) write it.
//!
//! Header (stamp, frame), orientation 4×f64, covariance 9×f64, angular velocity 3×f64 [rad/s], covariance 9×f64,
//! linear acceleration 3×f64 [m/s²], covariance 9×f64. A covariance that begins with −1 says "not measured".

use crate::{Error, Topic};

/// How a message is put into bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wire {
    /// ROS 1: packed, little-endian, with a sequence number.
    Ros1,
    /// ROS 2: CDR.
    Cdr,
}

/// A decoded message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Imu<'a> {
    pub(crate) stamp_ns: i64,
    pub(crate) frame: &'a [u8],
    /// Angular velocity, then linear acceleration.
    pub(crate) values: [f64; 6],
    pub(crate) has_gyro: bool,
    pub(crate) has_accel: bool,
}

/// A message that unpacks to more is no inertial one.
const LARGEST_PACKED: usize = 1 << 16;
/// Bytes from the orientation to the end.
const BODY: usize = 37 * 8;

/// A message's seconds, nanoseconds, frame, the bytes from the orientation on, and whether they are big-endian.
type Parts<'a> = (i64, u32, &'a [u8], &'a [u8], bool);

/// Decodes one message; `None` where its bytes are too few or no such message.
#[inline]
pub(crate) fn decode(bytes: &[u8], wire: Wire) -> Option<Imu<'_>> {
    let (sec, nsec, frame, body, big) = parts(bytes, wire)?;
    finish(sec, nsec, frame, body, big)
}

/// Decodes messages, also such that rosbag2 packed one by one by zstd.
#[derive(Default)]
pub(crate) struct Decoder {
    unpacker: Option<zstd::bulk::Decompressor<'static>>,
    unpacked: Vec<u8>,
}

impl Decoder {
    /// The message as it is decoded, and its bytes as they are unpacked.
    #[inline]
    pub(crate) fn decode<'a>(&'a mut self, bytes: &'a [u8], wire: Wire) -> Option<Imu<'a>> {
        // A frame of zstd begins as no message of ROS 2 does.
        if wire == Wire::Cdr && bytes.starts_with(&[0x28, 0xB5, 0x2F, 0xFD]) {
            return decode(self.unpack(bytes)?, wire);
        }
        decode(bytes, wire)
    }

    /// A message's bytes, unpacked where they are packed.
    pub(crate) fn plain<'a>(&'a mut self, bytes: &'a [u8], wire: Wire) -> &'a [u8] {
        if wire == Wire::Cdr && bytes.starts_with(&[0x28, 0xB5, 0x2F, 0xFD]) {
            return self.unpack(bytes).unwrap_or(&[]);
        }
        bytes
    }

    #[cold]
    fn unpack(&mut self, bytes: &[u8]) -> Option<&[u8]> {
        if self.unpacker.is_none() {
            self.unpacker = zstd::bulk::Decompressor::new().ok();
        }
        self.unpacked.clear();
        self.unpacked.reserve(LARGEST_PACKED);
        self.unpacker
            .as_mut()?
            .decompress_to_buffer(bytes, &mut self.unpacked)
            .ok()?;
        Some(&self.unpacked)
    }
}

/// What the first message of a topic tells of all.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct First {
    pub(crate) frame_id: String,
    pub(crate) has_gyro: bool,
    pub(crate) has_accel: bool,
}

impl First {
    pub(crate) fn of(message: &Imu<'_>) -> Self {
        Self {
            frame_id: String::from_utf8_lossy(message.frame).into_owned(),
            has_gyro: message.has_gyro,
            has_accel: message.has_accel,
        }
    }

    /// The same, where there is one and it measures anything.
    pub(crate) fn or_refuse(first: Option<Self>, topic: &Topic) -> Result<Self, Error> {
        let name = crate::map::columns::clip(&topic.name);
        let Some(first) = first else {
            return Err(match topic.messages {
                Some(0) => Error::data(format!("topic `{name}` is empty: it has no message"))
                    .advise("choose another topic, or record again"),
                _ => Error::data(format!(
                    "topic `{name}` has no readable {} message",
                    crate::map::columns::clip(&topic.kind)
                ))
                .advise("look whether its type is what the recording says, or copy the file again"),
            });
        };
        if !first.has_gyro && !first.has_accel {
            return Err(Error::data(format!(
                "topic `{name}` says that it measures neither angular velocity nor acceleration (covariances begin with -1)"
            ))
            .advise("choose another topic, or mend the covariances where it is published"));
        }
        Ok(first)
    }

    /// Values of a message that are columns.
    pub(crate) fn pick(&self) -> &'static [usize] {
        match (self.has_gyro, self.has_accel) {
            (true, false) => &[0, 1, 2],
            (false, true) => &[3, 4, 5],
            _ => &[0, 1, 2, 3, 4, 5],
        }
    }
}

/// The covariances of a message that states both triads': zeros say unknown, −1 not measured.
pub(crate) fn covariances(bytes: &[u8], wire: Wire) -> Option<[[f64; 9]; 2]> {
    let (.., body, big) = parts(bytes, wire)?;
    let all = [16, 28].map(|at| std::array::from_fn(|k| real(body, at + k, big)));
    let is_stated = |c: &[f64; 9]| c[0] >= 0.0 && c.iter().all(|v| v.is_finite());
    (all.iter().all(is_stated) && all.as_flattened().iter().any(|&v| v != 0.0)).then_some(all)
}

#[inline]
fn parts(bytes: &[u8], wire: Wire) -> Option<Parts<'_>> {
    match wire {
        Wire::Ros1 => {
            let sec = number(bytes, 4, false)?;
            let nsec = number(bytes, 8, false)?;
            let length = number(bytes, 12, false)? as usize;
            let body_at = length.checked_add(16)?;
            let frame = bytes.get(16..body_at)?;
            let body = bytes.get(body_at..body_at.checked_add(BODY)?)?;
            Some((i64::from(sec), nsec, frame, body, false))
        }
        Wire::Cdr => {
            let kind = *bytes.get(1)?;
            let big = match (*bytes.first()?, kind) {
                (0, 0 | 6) => true,
                (0, 1 | 7) => false,
                _ => return None,
            };
            let cdr = bytes.get(4..)?;
            let sec = number(cdr, 0, big)? as i32;
            let nsec = number(cdr, 4, big)?;
            let length = number(cdr, 8, big)? as usize;
            let end = length.checked_add(12)?;
            let frame = cdr.get(12..end)?;
            let frame = frame.strip_suffix(&[0]).unwrap_or(frame);
            // Version 2 of the encoding aligns to four bytes at most.
            let body_at = end.checked_next_multiple_of(if kind < 2 { 8 } else { 4 })?;
            let body = cdr.get(body_at..body_at.checked_add(BODY)?)?;
            Some((i64::from(sec), nsec, frame, body, big))
        }
    }
}

#[inline]
fn number(b: &[u8], at: usize, big: bool) -> Option<u32> {
    let raw: [u8; 4] = b.get(at..at + 4)?.try_into().ok()?;
    Some(if big {
        u32::from_be_bytes(raw)
    } else {
        u32::from_le_bytes(raw)
    })
}

/// Number `i` of a message's body, which has it.
#[inline]
fn real(body: &[u8], i: usize, big: bool) -> f64 {
    let mut raw = [0; 8];
    raw.copy_from_slice(&body[8 * i..8 * i + 8]);
    if big {
        f64::from_be_bytes(raw)
    } else {
        f64::from_le_bytes(raw)
    }
}

#[inline]
fn finish<'a>(sec: i64, nsec: u32, frame: &'a [u8], body: &[u8], big: bool) -> Option<Imu<'a>> {
    let body: &[u8; BODY] = body.try_into().ok()?;
    let f = |i: usize| real(body, i, big);
    Some(Imu {
        stamp_ns: sec * 1_000_000_000 + i64::from(nsec),
        frame,
        values: [f(13), f(14), f(15), f(25), f(26), f(27)],
        has_gyro: f(16) != -1.0,
        has_accel: f(28) != -1.0,
    })
}

/// True for the names of the type in ROS 1 and ROS 2.
pub(crate) fn is_imu(kind: &str) -> bool {
    matches!(kind, "sensor_msgs/Imu" | "sensor_msgs/msg/Imu")
}

/// The axes in words.
pub(crate) fn axes(frame: &[u8]) -> String {
    let name = crate::map::columns::clip(&String::from_utf8_lossy(frame));
    if name.is_empty() {
        "the sensor's own (sensor_msgs/Imu, no frame_id)".to_owned()
    } else {
        format!("those of frame_id \"{name}\" (sensor_msgs/Imu: rad/s, m/s^2)")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn cdr(big: bool) -> Vec<u8> {
        let n = |v: u32| {
            if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
        };
        let mut out = vec![0, u8::from(!big), 0, 0];
        out.extend([n(7), n(5), n(4)].concat());
        out.extend(b"imu\0");
        for i in 0..37 {
            let v = f64::from(i);
            out.extend(if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            });
        }
        out
    }

    #[test]
    fn both_byte_orders_are_read() {
        for big in [false, true] {
            let bytes = cdr(big);
            let m = decode(&bytes, Wire::Cdr).unwrap();
            assert_eq!(m.stamp_ns, 7_000_000_005);
            assert_eq!(m.frame, b"imu");
            assert_eq!(m.values, [13.0, 14.0, 15.0, 25.0, 26.0, 27.0]);
            for n in 0..bytes.len() {
                assert!(decode(&bytes[..n], Wire::Cdr).is_none());
            }
        }
    }
}
