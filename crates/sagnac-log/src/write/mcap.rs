//! MCAP with `sensor_msgs/msg/Imu` of ROS 2 (CDR, little-endian): plain chunks, indexed.

use std::io::Write;

use super::WriteSeek;
use super::ros::{ImuRows, definition, divider};
use crate::{Block, Error, Layout, LogWriter};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Bytes of messages in a chunk.
const CHUNK: usize = 1 << 20;

/// Writes `.mcap`.
pub(crate) struct McapWriter {
    output: Box<dyn WriteSeek>,
    rows: ImuRows,
    at: u64,
    chunk: Vec<u8>,
    /// Time and offset of the messages of the chunk.
    index: Vec<(u64, u64)>,
    chunks: Vec<u8>,
    chunk_count: u32,
    messages: u64,
    span: Option<(u64, u64)>,
}

fn string(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut out = vec![kind];
    out.extend((body.len() as u64).to_le_bytes());
    out.extend(body);
    out
}

fn schema_and_channel(topic: &str) -> Vec<u8> {
    let header = format!(
        "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{}\n\
         MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
        divider()
    );
    let mut schema = 1_u16.to_le_bytes().to_vec();
    string(&mut schema, "sensor_msgs/msg/Imu");
    string(&mut schema, "ros2msg");
    string(&mut schema, &definition("std_msgs/Header header", &header));
    let mut channel = [0_u16.to_le_bytes(), 1_u16.to_le_bytes()].concat();
    string(&mut channel, topic);
    string(&mut channel, "cdr");
    channel.extend(0_u32.to_le_bytes());
    [record(3, &schema), record(4, &channel)].concat()
}

impl McapWriter {
    pub(crate) fn new(output: Box<dyn WriteSeek>, layout: &Layout) -> Result<Self, Error> {
        let mut writer = Self {
            output,
            rows: ImuRows::new(layout)?,
            at: 0,
            chunk: Vec::new(),
            index: Vec::new(),
            chunks: Vec::new(),
            chunk_count: 0,
            messages: 0,
            span: None,
        };
        let mut header = Vec::new();
        string(&mut header, "ros2");
        string(&mut header, "sagnac");
        writer.put(MAGIC)?;
        writer.put(&record(1, &header))?;
        let about = schema_and_channel(&writer.rows.topic);
        writer.put(&about)?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.output.write_all(bytes).map_err(Error::write)?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn close_chunk(&mut self) -> Result<(), Error> {
        if self.index.is_empty() {
            return Ok(());
        }
        let chunk = std::mem::take(&mut self.chunk);
        let index = std::mem::take(&mut self.index);
        let first = index.iter().map(|i| i.0).min().unwrap_or(0);
        let last = index.iter().map(|i| i.0).max().unwrap_or(0);
        let size = chunk.len() as u64;
        let mut sum = flate2::Crc::new();
        sum.update(&chunk);
        let mut body = [first, last, size].map(u64::to_le_bytes).concat();
        body.extend(sum.sum().to_le_bytes());
        string(&mut body, "");
        body.extend(size.to_le_bytes());
        body.extend(&chunk);
        let start = self.at;
        self.put(&record(6, &body))?;
        let index_at = self.at;
        let mut body = 0_u16.to_le_bytes().to_vec();
        body.extend((index.len() as u32 * 16).to_le_bytes());
        for (time, offset) in &index {
            body.extend([*time, *offset].map(u64::to_le_bytes).concat());
        }
        self.put(&record(7, &body))?;
        let mut entry = [first, last, start, index_at - start]
            .map(u64::to_le_bytes)
            .concat();
        entry.extend(10_u32.to_le_bytes());
        entry.extend(0_u16.to_le_bytes());
        entry.extend(index_at.to_le_bytes());
        entry.extend((self.at - index_at).to_le_bytes());
        string(&mut entry, "");
        entry.extend([size, size].map(u64::to_le_bytes).concat());
        self.chunks.extend(record(8, &entry));
        self.chunk_count += 1;
        self.chunk = chunk;
        self.chunk.clear();
        Ok(())
    }
}

impl LogWriter for McapWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        for k in 0..block.rows {
            let (ns, body) = self.rows.row(block, k)?;
            self.index.push((ns, self.chunk.len() as u64));
            // Encapsulation, stamp, frame with its zero, padding to eight bytes from the stamp on.
            let mut head = vec![0, 1, 0, 0];
            head.extend(((ns / 1_000_000_000) as u32).to_le_bytes());
            head.extend(((ns % 1_000_000_000) as u32).to_le_bytes());
            head.extend((self.rows.frame_id.len() as u32 + 1).to_le_bytes());
            head.extend(self.rows.frame_id.as_bytes());
            head.push(0);
            head.resize(4 + (head.len() - 4).next_multiple_of(8), 0);
            self.chunk.push(5);
            let length = 22 + head.len() + body.len();
            self.chunk.extend((length as u64).to_le_bytes());
            self.chunk.extend(0_u16.to_le_bytes());
            self.chunk.extend((self.messages as u32).to_le_bytes());
            self.chunk.extend([ns, ns].map(u64::to_le_bytes).concat());
            self.chunk.extend(&head);
            self.chunk.extend(&body);
            self.messages += 1;
            let (first, last) = self.span.unwrap_or((ns, ns));
            self.span = Some((first.min(ns), last.max(ns)));
            if self.chunk.len() >= CHUNK {
                self.close_chunk()?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<String>, Error> {
        self.close_chunk()?;
        self.put(&record(15, &0_u32.to_le_bytes()))?;
        let summary = self.at;
        let about = schema_and_channel(&self.rows.topic);
        self.put(&about)?;
        let (first, last) = self.span.unwrap_or((0, 0));
        let mut body = self.messages.to_le_bytes().to_vec();
        body.extend(1_u16.to_le_bytes());
        body.extend([1, 0, 0, self.chunk_count].map(u32::to_le_bytes).concat());
        body.extend([first, last].map(u64::to_le_bytes).concat());
        body.extend(10_u32.to_le_bytes());
        body.extend(0_u16.to_le_bytes());
        body.extend(self.messages.to_le_bytes());
        self.put(&record(11, &body))?;
        let chunks = std::mem::take(&mut self.chunks);
        self.put(&chunks)?;
        let mut footer = [summary, 0].map(u64::to_le_bytes).concat();
        footer.extend(0_u32.to_le_bytes());
        self.put(&record(2, &footer))?;
        self.put(MAGIC)?;
        self.output.flush().map_err(Error::write)?;
        Ok(self.rows.notes())
    }
}
