//! ROS 1 bags, version 2.0, with `sensor_msgs/Imu`: plain chunks, indexed.

use std::io::{Seek, SeekFrom, Write};

use super::WriteSeek;
use super::ros::{ImuRows, definition};
use crate::{Block, Error, Layout, LogWriter};

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Bytes of messages in a chunk: what the recorder of ROS uses.
const CHUNK: usize = 768 << 10;
/// The type's checksum in ROS.
const MD5: &str = "6a62c6daae103f4ff57a132d6f95cec2";

/// Writes `.bag`.
pub(crate) struct BagWriter {
    output: Box<dyn WriteSeek>,
    rows: ImuRows,
    at: u64,
    chunk: Vec<u8>,
    /// Time and offset of the messages of the chunk.
    index: Vec<(u64, u32)>,
    chunks: Vec<u8>,
    chunk_count: u32,
    messages: u32,
}

fn fields(list: &[(&str, &[u8])]) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, value) in list {
        out.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        out.extend(name.as_bytes());
        out.push(b'=');
        out.extend(*value);
    }
    out
}

fn record(header: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = fields(header);
    let mut out = (header.len() as u32).to_le_bytes().to_vec();
    out.extend(header);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out
}

/// Seconds and nanoseconds as ROS writes a time.
fn time(ns: u64) -> [u8; 8] {
    let (s, part) = ((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32);
    let mut out = [0; 8];
    out[..4].copy_from_slice(&s.to_le_bytes());
    out[4..].copy_from_slice(&part.to_le_bytes());
    out
}

/// The head, as long whatever it says.
fn head(index_at: u64, chunks: u32) -> Vec<u8> {
    let header: [(&str, &[u8]); 4] = [
        ("op", &[3]),
        ("index_pos", &index_at.to_le_bytes()),
        ("conn_count", &1_u32.to_le_bytes()),
        ("chunk_count", &chunks.to_le_bytes()),
    ];
    let length = fields(&header).len() + 8;
    record(&header, &vec![b' '; 4096_usize.saturating_sub(length)])
}

fn connection(topic: &str) -> Vec<u8> {
    let text = definition(
        "Header header",
        "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
    );
    let data = fields(&[
        ("topic", topic.as_bytes()),
        ("type", b"sensor_msgs/Imu"),
        ("md5sum", MD5.as_bytes()),
        ("message_definition", text.as_bytes()),
    ]);
    record(
        &[("op", &[7]), ("conn", &[0; 4]), ("topic", topic.as_bytes())],
        &data,
    )
}

impl BagWriter {
    pub(crate) fn new(output: Box<dyn WriteSeek>, layout: &Layout) -> Result<Self, Error> {
        let rows = ImuRows::new(layout)?;
        let mut writer = Self {
            output,
            at: 0,
            chunk: connection(&rows.topic),
            rows,
            index: Vec::new(),
            chunks: Vec::new(),
            chunk_count: 0,
            messages: 0,
        };
        writer.put(MAGIC)?;
        writer.put(&head(0, 0))?;
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
        let count = (index.len() as u32).to_le_bytes();
        let start = self.at;
        self.put(&record(
            &[
                ("op", &[5]),
                ("compression", b"none"),
                ("size", &(chunk.len() as u32).to_le_bytes()),
            ],
            &chunk,
        ))?;
        let mut data = Vec::new();
        for (ns, offset) in &index {
            data.extend(time(*ns));
            data.extend(offset.to_le_bytes());
        }
        self.put(&record(
            &[
                ("op", &[4]),
                ("ver", &1_u32.to_le_bytes()),
                ("conn", &[0; 4]),
                ("count", &count),
            ],
            &data,
        ))?;
        self.chunks.extend(record(
            &[
                ("op", &[6]),
                ("ver", &1_u32.to_le_bytes()),
                ("chunk_pos", &start.to_le_bytes()),
                ("start_time", &time(first)),
                ("end_time", &time(last)),
                ("count", &1_u32.to_le_bytes()),
            ],
            &[[0; 4], count].concat(),
        ));
        self.chunk_count += 1;
        self.chunk = chunk;
        self.chunk.clear();
        Ok(())
    }
}

impl LogWriter for BagWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        for k in 0..block.rows {
            let (ns, body) = self.rows.row(block, k)?;
            self.index.push((ns, self.chunk.len() as u32));
            let mut data = self.messages.to_le_bytes().to_vec();
            data.extend(time(ns));
            data.extend((self.rows.frame_id.len() as u32).to_le_bytes());
            data.extend(self.rows.frame_id.as_bytes());
            data.extend(&body);
            self.chunk.extend(record(
                &[("op", &[2]), ("conn", &[0; 4]), ("time", &time(ns))],
                &data,
            ));
            self.messages = self.messages.wrapping_add(1);
            if self.chunk.len() >= CHUNK {
                self.close_chunk()?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<String>, Error> {
        self.close_chunk()?;
        let index_at = self.at;
        let connection = connection(&self.rows.topic);
        self.put(&connection)?;
        let chunks = std::mem::take(&mut self.chunks);
        self.put(&chunks)?;
        self.output
            .seek(SeekFrom::Start(MAGIC.len() as u64))
            .map_err(Error::write)?;
        let head = head(index_at, self.chunk_count);
        self.output.write_all(&head).map_err(Error::write)?;
        self.output.seek(SeekFrom::End(0)).map_err(Error::write)?;
        self.output.flush().map_err(Error::write)?;
        Ok(self.rows.notes())
    }
}
