//! MCAP: records of one byte of kind, eight of length; chunks none, lz4 or zstd; `sensor_msgs/Imu` of ROS 2 or ROS 1.
//!
//! Kinds used: schema (3), channel (4), message (5), chunk (6), statistics (11), end of data (15), footer (2).
//! Source: [MCAP].

use std::io::Read;

use super::chunked::{Connection, Container, Item, Packing, Parsed, add};
use super::part::Shared;
use super::ros::Wire;
use super::scan::{u16_at, u32_at, u64_at};

pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// What is known of an MCAP file.
#[derive(Default)]
pub(crate) struct Mcap {
    schemas: Vec<(u16, String)>,
    connections: Vec<Connection>,
    counts: Vec<(u32, u64)>,
}

/// A string with its length before it, and what follows.
fn string(b: &[u8]) -> Option<(&[u8], &[u8])> {
    let n = u32_at(b, 0)? as usize;
    let text = b.get(4..n.checked_add(4)?)?;
    Some((text, &b[n + 4..]))
}

impl Mcap {
    fn define_some(&mut self, kind: u8, data: &[u8]) -> Option<()> {
        let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
        match kind {
            3 => {
                let id = u16_at(data, 0)?;
                let (name, _) = string(data.get(2..)?)?;
                if !self.schemas.iter().any(|s| s.0 == id) {
                    self.schemas.push((id, text(name)));
                }
            }
            4 => {
                let id = u32::from(u16_at(data, 0)?);
                let schema = u16_at(data, 2)?;
                let (topic, rest) = string(data.get(4..)?)?;
                let (encoding, _) = string(rest)?;
                let kind = self.schemas.iter().find(|s| s.0 == schema);
                let messages = self.counts.iter().find(|c| c.0 == id).map_or(0, |c| c.1);
                add(
                    &mut self.connections,
                    Connection {
                        id,
                        topic: text(topic),
                        kind: kind.map_or_else(|| "unknown".to_owned(), |s| s.1.clone()),
                        wire: match encoding {
                            b"cdr" => Some(Wire::Cdr),
                            b"ros1" => Some(Wire::Ros1),
                            _ => None,
                        },
                        messages,
                    },
                );
            }
            11 => {
                let map = data.get(46..)?;
                for pair in map.chunks_exact(10) {
                    let (id, n) = (u32::from(u16_at(pair, 0)?), u64_at(pair, 2)?);
                    self.counts.push((id, n));
                    if let Some(c) = self.connections.iter_mut().find(|c| c.id == id) {
                        c.messages = n;
                    }
                }
            }
            _ => {}
        }
        Some(())
    }
}

impl Container for Mcap {
    const NAME: &'static str = "MCAP";
    const MAGIC: usize = MAGIC.len();

    #[inline]
    fn parse(&self, window: &[u8]) -> Parsed {
        let (Some(&kind), Some(length)) = (window.first(), u64_at(window, 1)) else {
            return Parsed::Need(9);
        };
        let item = match kind {
            5 => {
                let Some(connection) = u16_at(window, 9) else {
                    return Parsed::Need(11);
                };
                if length < 22 {
                    return Parsed::Damaged;
                }
                Item::Message {
                    connection: u32::from(connection),
                    payload: 22,
                }
            }
            6 => {
                let Some(name_length) = u32_at(window, 9 + 28) else {
                    return Parsed::Need(9 + 32);
                };
                let name_length = name_length as usize;
                if name_length > 64 || length < 40 + name_length as u64 {
                    return Parsed::Damaged;
                }
                let Some(name) = window.get(41..41 + name_length) else {
                    return Parsed::Need(41 + name_length);
                };
                Item::Chunk {
                    packing: Packing::parse(name),
                    records: 40 + name_length,
                    unpacked: u64_at(window, 9 + 16).unwrap_or(0),
                    // 0: the writer made none.
                    sum: u32_at(window, 9 + 24).filter(|&sum| sum != 0),
                }
            }
            2 => Item::End,
            3 | 4 => Item::Definition,
            11 if self.wants_statistics() => Item::Definition,
            0 => return Parsed::Damaged,
            _ => Item::Other,
        };
        Parsed::Record {
            body: 9,
            length,
            item,
        }
    }

    fn define(&mut self, record: &[u8], body: usize) {
        let kind = record.first().copied().unwrap_or(0);
        let data = record.get(body..).unwrap_or(&[]);
        // A definition that is cut short defines nothing.
        let _ = self.define_some(kind, data);
    }

    fn connections(&self) -> &[Connection] {
        &self.connections
    }

    fn connections_mut(&mut self) -> &mut Vec<Connection> {
        &mut self.connections
    }

    fn index(&self, file: &Shared) -> Option<u64> {
        let at = summary(file)?;
        (at >= 8 && at < file.length().ok()?).then_some(at)
    }

    /// A summary may be left out.
    fn is_closed(&self, file: &Shared) -> bool {
        summary(file) == Some(0)
    }
}

/// Where the footer says that the summary begins.
fn summary(file: &Shared) -> Option<u64> {
    let mut tail = Vec::new();
    // Footer: kind, length, start of the summary, start of its offsets, checksum; then the magic again.
    file.part(file.length().ok()?.checked_sub(37)?, 37)
        .read_to_end(&mut tail)
        .ok()?;
    (tail.first() == Some(&2) && tail.ends_with(MAGIC)).then_some(())?;
    u64_at(&tail, 9)
}

impl Mcap {
    /// Statistics count once: where messages were not counted one by one.
    fn wants_statistics(&self) -> bool {
        self.counts.is_empty() && self.connections.iter().all(|c| c.messages == 0)
    }
}
