//! ROS 1 bags, version 2.0: records of `name=value` headers and data, chunks none, bz2 or lz4.
//!
//! Record: u32 header length, header, u32 data length, data; a header field: u32 length, `name=value`. `op` tells
//! messages (2), the bag header (3), indexes (4, 6), chunks (5), connections (7). Source: [ROSBAG].

use std::io::Read;

use super::chunked::{Connection, Container, Item, Packing, Parsed, add};
use super::part::Shared;
use super::ros::Wire;
use super::scan::{u32_at, u64_at};

pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// A longer header is none.
const LARGEST_HEADER: usize = 1 << 20;

/// What is known of a bag.
#[derive(Default)]
pub(crate) struct Bag {
    connections: Vec<Connection>,
}

/// Fields of a record's header.
fn fields(mut header: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    std::iter::from_fn(move || {
        let length = u32_at(header, 0)? as usize;
        let field = header.get(4..length.checked_add(4)?)?;
        header = &header[length + 4..];
        let equals = memchr::memchr(b'=', field.get(..field.len().min(32))?)?;
        Some((&field[..equals], &field[equals + 1..]))
    })
}

impl Container for Bag {
    const NAME: &'static str = "ROS 1 bag";
    const MAGIC: usize = MAGIC.len();

    #[inline]
    fn parse(&self, window: &[u8]) -> Parsed {
        let Some(header_length) = u32_at(window, 0) else {
            return Parsed::Need(4);
        };
        let header_length = header_length as usize;
        if header_length == 0 || header_length > LARGEST_HEADER {
            return Parsed::Damaged;
        }
        let body = header_length + 8;
        let Some(length) = u32_at(window, header_length + 4) else {
            return Parsed::Need(body);
        };
        let header = window.get(4..header_length + 4).unwrap_or(&[]);
        let (mut op, mut connection, mut size, mut packing) = (0_u8, None, 0, Packing::Unknown);
        for (name, value) in fields(header) {
            match name {
                b"op" => op = value.first().copied().unwrap_or(0),
                b"conn" => connection = u32_at(value, 0),
                b"size" => size = u32_at(value, 0).unwrap_or(0),
                b"compression" => packing = Packing::parse(value),
                _ => {}
            }
        }
        let item = match (op, connection) {
            (2, Some(connection)) => Item::Message {
                connection,
                payload: 0,
            },
            (5, _) => Item::Chunk {
                packing,
                records: 0,
                unpacked: u64::from(size),
                sum: None,
            },
            (6 | 7, _) => Item::Definition,
            (3 | 4, _) => Item::Other,
            _ => return Parsed::Damaged,
        };
        Parsed::Record {
            body,
            length: u64::from(length),
            item,
        }
    }

    fn define(&mut self, record: &[u8], body: usize) {
        let header = record.get(4..body.saturating_sub(4)).unwrap_or(&[]);
        let data = record.get(body..).unwrap_or(&[]);
        let field = |bytes, wanted: &[u8]| fields(bytes).find(|f| f.0 == wanted).map(|f| f.1);
        let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
        if field(header, b"op") == Some(&[7]) {
            let Some(id) = field(header, b"conn").and_then(|v| u32_at(v, 0)) else {
                return;
            };
            add(
                &mut self.connections,
                Connection {
                    id,
                    topic: text(field(header, b"topic").unwrap_or_default()),
                    kind: text(field(data, b"type").unwrap_or_default()),
                    wire: Some(Wire::Ros1),
                    messages: 0,
                },
            );
        } else {
            // Chunk info: connection and number of messages, four bytes each.
            for pair in data.chunks_exact(8) {
                let (id, n) = (u32_at(pair, 0), u32_at(pair, 4));
                if let Some(c) = self.connections.iter_mut().find(|c| Some(c.id) == id) {
                    c.messages += u64::from(n.unwrap_or(0));
                }
            }
        }
    }

    fn connections(&self) -> &[Connection] {
        &self.connections
    }

    fn connections_mut(&mut self) -> &mut Vec<Connection> {
        &mut self.connections
    }

    fn index(&self, file: &Shared) -> Option<u64> {
        let mut head = Vec::new();
        file.part(0, 4096).read_to_end(&mut head).ok()?;
        let record = head.get(MAGIC.len()..)?;
        let length = u32_at(record, 0)? as usize;
        let header = record.get(4..length.checked_add(4)?)?;
        let at = fields(header)
            .find(|f| f.0 == b"index_pos")
            .and_then(|f| u64_at(f.1, 0))?;
        (at > MAGIC.len() as u64 && at < file.length().ok()?).then_some(at)
    }
}
