//! Recordings of messages in chunks (ROS 1 bag, MCAP): one walk over their records, whole or salvaged.
//!
//! Records stand one after another, some of them chunks of further records, packed or not. The walk needs no index:
//! a pipe and a recording that was never closed are read like any other.

use std::io::{Cursor, Read};

use super::part::Shared;
use super::ros::{self, First, Wire};
use super::scan::{LARGEST, Scan};
use super::table;
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::text::grouped;
use crate::{Block, Error, ReadOptions, Topic};

/// A packed chunk beyond this is left out: chunks of real recordings hold some megabytes.
const LARGEST_CHUNK: u64 = 1 << 27;
/// A larger chunk is not held as a whole, and so goes on before its checksum could be looked at.
const LARGEST_CHECKED: u64 = 1 << 26;
/// Bytes of a pipe that are looked at to find its topics.
const PEEK: u64 = 1 << 23;
/// More connections than any recording has.
const MOST_CONNECTIONS: usize = 1 << 16;

/// How a chunk is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Bzip2,
    Lz4,
    Zstd,
    Unknown,
}

impl Packing {
    pub(crate) fn parse(name: &[u8]) -> Self {
        match name {
            b"none" | b"" => Self::None,
            b"bz2" => Self::Bzip2,
            b"lz4" => Self::Lz4,
            b"zstd" => Self::Zstd,
            _ => Self::Unknown,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::None => "not compressed",
            Self::Bzip2 => "bz2",
            Self::Lz4 => "lz4",
            Self::Zstd => "zstd",
            Self::Unknown => "unknown compression",
        }
    }

    fn unpack(self, bytes: Vec<u8>) -> Result<Box<dyn Read + Send>, Error> {
        let bytes = Cursor::new(bytes);
        Ok(match self {
            Self::None => Box::new(bytes),
            Self::Bzip2 => Box::new(bzip2::read::MultiBzDecoder::new(bytes)),
            Self::Lz4 => Box::new(lz4_flex::frame::FrameDecoder::new(bytes)),
            Self::Zstd => {
                let mut decoder = zstd::Decoder::new(bytes).map_err(Error::read)?;
                decoder.window_log_max(27).map_err(Error::read)?;
                Box::new(decoder)
            }
            Self::Unknown => return Err(Error::data("the compression is not known")),
        })
    }
}

/// What a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Item {
    /// A message of a connection; its payload begins so many bytes into the body.
    Message { connection: u32, payload: usize },
    /// A chunk; its records begin so many bytes into the body.
    Chunk {
        packing: Packing,
        records: usize,
        unpacked: u64,
        /// CRC-32 of the records, unpacked.
        sum: Option<u32>,
    },
    /// A connection, schema or index entry: [`Container::define`] wants the whole record.
    Definition,
    /// Of no use here.
    Other,
    /// The last record.
    End,
}

/// What stands at the beginning of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parsed {
    /// So many bytes are needed to tell.
    Need(usize),
    /// No record of this format.
    Damaged,
    Record {
        body: usize,
        length: u64,
        item: Item,
    },
}

/// A connection: a topic with its type.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Connection {
    pub(crate) id: u32,
    pub(crate) topic: String,
    pub(crate) kind: String,
    /// `None` where the encoding is not one of ROS.
    pub(crate) wire: Option<Wire>,
    pub(crate) messages: u64,
}

/// A format of records.
pub(crate) trait Container {
    const NAME: &'static str;
    /// Bytes before the first record.
    const MAGIC: usize;
    fn parse(&self, window: &[u8]) -> Parsed;
    fn define(&mut self, record: &[u8], body: usize);
    fn connections(&self) -> &[Connection];
    fn connections_mut(&mut self) -> &mut Vec<Connection>;
    /// Where the index stands by the file's own word; `None` where there is none.
    fn index(&self, file: &Shared) -> Option<u64>;
    /// Whether the file was closed and has no index by its own word.
    fn is_closed(&self, _: &Shared) -> bool {
        false
    }
}

/// Adds a connection once.
pub(crate) fn add(list: &mut Vec<Connection>, new: Connection) {
    if list.len() < MOST_CONNECTIONS && !list.iter().any(|c| c.id == new.id) {
        list.push(new);
    }
}

/// The walk.
struct Walk {
    scan: Scan,
    inner: Option<Scan>,
    /// End of the plain chunk that the walk is in.
    chunk_end: Option<u64>,
    first_packing: Option<Packing>,
    lost: Vec<String>,
    lost_more: u64,
    /// Messages wanted in chunks whose checksum says that they are damaged.
    lost_messages: u64,
    /// Chunks too large to be checked before their messages go on.
    unchecked: u64,
    is_over: bool,
}

impl Walk {
    fn new(reader: Box<dyn Read + Send>) -> Self {
        Self {
            scan: Scan::new(reader),
            inner: None,
            chunk_end: None,
            first_packing: None,
            lost: Vec::new(),
            lost_more: 0,
            lost_messages: 0,
            unchecked: 0,
            is_over: false,
        }
    }

    fn lose(&mut self, text: String) {
        if self.lost.len() < 5 {
            self.lost.push(text);
        } else {
            self.lost_more += 1;
        }
    }

    fn lose_chunk(&mut self, at: u64, messages: u64) {
        self.lose(format!(
            "the chunk at byte {} does not match its checksum and is left out",
            grouped(at)
        ));
        self.lost_messages += messages;
    }

    fn notes(&self) -> Vec<String> {
        let mut out = self.lost.clone();
        if self.lost_more > 0 {
            out.push(format!(
                "{} further damaged places",
                grouped(self.lost_more)
            ));
        }
        if self.lost_messages > 0 {
            let (n, s) = (
                self.lost_messages,
                if self.lost_messages == 1 { "" } else { "s" },
            );
            out.push(format!("{} message{s} stood in them", grouped(n)));
        }
        if self.unchecked > 0 {
            out.push(format!(
                "{} chunks are larger than {} MB: their checksums were not looked at",
                grouped(self.unchecked),
                LARGEST_CHECKED >> 20
            ));
        }
        out
    }

    /// Goes on until `take` returns `false` (the result is `true`) or the recording ends.
    ///
    /// `wanted` are the connections whose payload `take` sees; without, messages are counted.
    #[inline]
    fn run<C: Container>(
        &mut self,
        c: &mut C,
        wanted: Option<&[u32]>,
        take: &mut impl FnMut(u32, &[u8]) -> bool,
    ) -> Result<bool, Error> {
        while !self.is_over {
            if let Some(mut inner) = self.inner.take() {
                match records(&mut inner, c, wanted, take, None) {
                    Ok(Stop::Taken) => {
                        self.inner = Some(inner);
                        return Ok(true);
                    }
                    Ok(Stop::End | Stop::Last) => {}
                    Ok(_) | Err(_) => self.lose(format!(
                        "the packed chunk that ends at byte {} is damaged; the rest of it is left out",
                        grouped(self.scan.offset())
                    )),
                }
                continue;
            }
            let at = self.scan.offset();
            if self.chunk_end.is_some_and(|end| at >= end) {
                self.chunk_end = None;
            }
            let stop = records(&mut self.scan, c, wanted, take, self.chunk_end)?;
            match stop {
                Stop::Taken => return Ok(true),
                Stop::End | Stop::Last => self.is_over = true,
                Stop::ChunkEnd => {}
                Stop::Cut => {
                    let at = self.scan.offset();
                    self.lose(format!(
                        "the recording is cut off at byte {}; the record there is left out",
                        grouped(at)
                    ));
                    self.is_over = true;
                }
                Stop::Damaged => {
                    let at = self.scan.offset();
                    if let Some(end) = self.chunk_end.take() {
                        self.lose(format!(
                            "bytes {} to {} are damaged and left out",
                            grouped(at),
                            grouped(end)
                        ));
                        self.scan.skip(end.saturating_sub(at))?;
                    } else {
                        self.lose(format!(
                            "from byte {} on the recording is damaged; the rest is left out",
                            grouped(at)
                        ));
                        self.is_over = true;
                    }
                }
                Stop::Chunk {
                    packing,
                    length,
                    unpacked,
                    sum,
                } => {
                    self.first_packing.get_or_insert(packing);
                    // Messages that are only counted are read again.
                    let sum = sum.filter(|_| wanted.is_some());
                    let at = self.scan.offset();
                    if packing == Packing::None {
                        if !check(&mut self.scan, length, sum, &mut self.unchecked)? {
                            let window = self.scan.window();
                            let chunk = window.get(..length as usize).unwrap_or(window);
                            let n = count(c, chunk, wanted);
                            self.lose_chunk(at, n);
                            self.scan.skip(length)?;
                            continue;
                        }
                        self.chunk_end = Some(at.saturating_add(length));
                        continue;
                    }
                    if length > LARGEST_CHUNK || packing == Packing::Unknown {
                        self.lose(format!(
                            "the chunk at byte {} ({} bytes, {}) is left out",
                            grouped(at),
                            grouped(length),
                            packing.word()
                        ));
                        self.scan.skip(length)?;
                        continue;
                    }
                    let bytes = self.scan.take(length)?;
                    // What is there of a chunk that is cut off cannot be checked.
                    let sum = sum.filter(|_| bytes.len() as u64 == length);
                    let Ok(reader) = packing.unpack(bytes) else {
                        self.lose(format!("the chunk at byte {} is damaged", grouped(at)));
                        continue;
                    };
                    let mut inner = Scan::new(Box::new(reader.take(unpacked)));
                    match check(&mut inner, unpacked, sum, &mut self.unchecked) {
                        Ok(true) => self.inner = Some(inner),
                        Ok(false) => {
                            let n = count(c, inner.window(), wanted);
                            self.lose_chunk(at, n);
                        }
                        Err(_) => self.lose_chunk(at, 0),
                    }
                }
            }
        }
        Ok(false)
    }
}

/// Whether a chunk of `length` bytes, which begins here, has the checksum that it should.
fn check(
    scan: &mut Scan,
    length: u64,
    sum: Option<u32>,
    unchecked: &mut u64,
) -> Result<bool, Error> {
    let Some(sum) = sum else { return Ok(true) };
    if length > LARGEST_CHECKED {
        *unchecked += 1;
        return Ok(true);
    }
    let length = length as usize;
    if !scan.hold(length)? {
        // Cut off: found where it ends.
        return Ok(true);
    }
    let mut found = flate2::Crc::new();
    found.update(scan.window().get(..length).unwrap_or(&[]));
    Ok(found.sum() == sum)
}

/// Messages of the wanted connections in a chunk, as far as its records can be followed.
fn count<C: Container>(c: &C, mut chunk: &[u8], wanted: Option<&[u32]>) -> u64 {
    let mut n = 0;
    while let Parsed::Record { body, length, item } = c.parse(chunk) {
        if let Item::Message { connection, .. } = item {
            n += u64::from(wanted.is_some_and(|w| w.contains(&connection)));
        }
        let total = usize::try_from(length)
            .ok()
            .and_then(|n| n.checked_add(body));
        let Some(rest) = total.and_then(|n| chunk.get(n..)) else {
            break;
        };
        chunk = rest;
    }
    n
}

enum Stop {
    Taken,
    End,
    Last,
    ChunkEnd,
    Cut,
    Damaged,
    Chunk {
        packing: Packing,
        length: u64,
        unpacked: u64,
        sum: Option<u32>,
    },
}

#[inline]
fn records<C: Container>(
    scan: &mut Scan,
    c: &mut C,
    wanted: Option<&[u32]>,
    take: &mut impl FnMut(u32, &[u8]) -> bool,
    end: Option<u64>,
) -> Result<Stop, Error> {
    loop {
        if end.is_some_and(|end| scan.offset() >= end) {
            return Ok(Stop::ChunkEnd);
        }
        let (body, length, item) = match c.parse(scan.window()) {
            Parsed::Record { body, length, item } => (body, length, item),
            Parsed::Damaged => return Ok(Stop::Damaged),
            Parsed::Need(n) => {
                if !scan.need(n)? {
                    return Ok(match (n > LARGEST, scan.window().is_empty()) {
                        (true, _) => Stop::Damaged,
                        (false, true) => Stop::End,
                        (false, false) => Stop::Cut,
                    });
                }
                continue;
            }
        };
        let total = length.saturating_add(body as u64);
        match item {
            Item::Message {
                connection,
                payload,
            } => {
                let is_wanted = wanted.is_some_and(|w| w.contains(&connection));
                if is_wanted && total <= LARGEST as u64 {
                    if !scan.need(total as usize)? {
                        return Ok(Stop::Cut);
                    }
                    let record = scan.window().get(body..total as usize).unwrap_or(&[]);
                    let go_on = take(connection, record.get(payload..).unwrap_or(&[]));
                    scan.consume(total as usize);
                    if !go_on {
                        return Ok(Stop::Taken);
                    }
                    continue;
                }
                if wanted.is_none()
                    && let Some(x) = c.connections_mut().iter_mut().find(|x| x.id == connection)
                {
                    x.messages += 1;
                }
                if scan.skip(total)? < total {
                    return Ok(Stop::Cut);
                }
            }
            Item::Chunk {
                packing,
                records,
                unpacked,
                sum,
            } => {
                if end.is_some() {
                    return Ok(Stop::Damaged);
                }
                scan.skip((body + records) as u64)?;
                return Ok(Stop::Chunk {
                    packing,
                    length: length.saturating_sub(records as u64),
                    unpacked,
                    sum,
                });
            }
            Item::Definition if total <= LARGEST as u64 => {
                if !scan.need(total as usize)? {
                    return Ok(Stop::Cut);
                }
                c.define(scan.window().get(..total as usize).unwrap_or(&[]), body);
                scan.consume(total as usize);
            }
            Item::Definition | Item::Other => {
                if scan.skip(total)? < total {
                    return Ok(Stop::Cut);
                }
            }
            Item::End => return Ok(Stop::Last),
        }
    }
}

/// A recording as a log.
pub(crate) struct Chunked<C> {
    layout: RawLayout,
    container: C,
    walk: Walk,
    wanted: Vec<u32>,
    wire: Wire,
    plan: Plan,
    /// Values of the message that are columns.
    pick: &'static [usize],
    decoder: ros::Decoder,
    bad: u64,
    told: Vec<String>,
}

impl<C: Container + Default> Chunked<C> {
    pub(crate) fn open(
        bytes: InputBytes,
        packed: &str,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let mut c = C::default();
        let mut notes = Vec::new();
        let mut counted = true;
        let mut peek = Vec::new();
        let mut shared = None;
        let reader: Box<dyn Read + Send> = match bytes {
            InputBytes::Stream(mut reader) => {
                reader
                    .by_ref()
                    .take(PEEK)
                    .read_to_end(&mut peek)
                    .map_err(Error::read)?;
                survey(&mut c, Box::new(Cursor::new(peek.clone())))?;
                counted = (peek.len() as u64) < PEEK;
                Box::new(Cursor::new(peek.clone()).chain(reader))
            }
            InputBytes::File(file) => {
                let file = Shared::new(file);
                let mut indexed = false;
                if let Some(at) = c.index(&file) {
                    let mut walk = Walk::new(Box::new(file.from(at)));
                    walk.run(&mut c, Some(&[]), &mut |_, _| true)?;
                    indexed =
                        walk.lost.is_empty() && c.connections().iter().any(|x| x.messages > 0);
                }
                if !indexed {
                    if !c.is_closed(&file) {
                        notes.push(
                        "the index is missing or damaged (a recording that was not closed); the messages were read without it"
                            .to_owned(),
                        );
                    }
                    c = C::default();
                    survey(&mut c, Box::new(file.from(0)))?;
                }
                shared = Some(file.clone());
                Box::new(file.from(0))
            }
        };
        let mut topics: Vec<Topic> = Vec::new();
        for x in c.connections() {
            let is_inertial = x.wire.is_some() && ros::is_imu(&x.kind);
            let n = counted.then_some(x.messages);
            match topics
                .iter_mut()
                .find(|t| t.name == x.topic && t.kind == x.kind)
            {
                Some(t) => t.messages = t.messages.zip(n).map(|(a, b)| a + b),
                None => topics.push(Topic {
                    name: x.topic.clone(),
                    kind: x.kind.clone(),
                    messages: n,
                    is_inertial,
                }),
            }
        }
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        let chosen = topics
            .get(table::choose(&topics, options, "sensor_msgs/Imu")?)
            .cloned()
            .ok_or_else(|| Error::data("the log has no topics"))?;
        let mine = |x: &&Connection| x.topic == chosen.name && x.kind == chosen.kind;
        let wanted: Vec<u32> = c.connections().iter().filter(mine).map(|x| x.id).collect();
        let wire = c
            .connections()
            .iter()
            .find(mine)
            .and_then(|x| x.wire)
            .unwrap_or(Wire::Cdr);
        // The first message tells the frame and what was measured.
        let mut first: Option<First> = None;
        let mut decoder = ros::Decoder::default();
        let mut covariances = None;
        let mut look = |_: u32, payload: &[u8]| {
            first = decoder.decode(payload, wire).map(|m| First::of(&m));
            covariances = ros::covariances(decoder.plain(payload, wire), wire);
            first.is_none()
        };
        let mut walk = start::<C>(match &shared {
            Some(file) => Box::new(file.from(0)),
            None => Box::new(Cursor::new(peek)),
        })?;
        walk.run(&mut c, Some(&wanted), &mut look)?;
        let packing = walk.first_packing;
        let first = First::or_refuse(first, &chosen)?;
        for (has, what) in [
            (first.has_gyro, "angular velocity"),
            (first.has_accel, "acceleration"),
        ] {
            if !has {
                notes.push(format!("no {what}: its covariance begins with -1"));
            }
        }
        let layout = RawLayout {
            format: format!(
                "{}, {}{packed}",
                C::NAME,
                packing.unwrap_or(Packing::None).word()
            ),
            columns: table::columns("ns", first.has_gyro, first.has_accel),
            has_names: true,
            samples: chosen.messages,
            topics,
            topic: Some(chosen.name),
            frame: Some(ros::axes(first.frame_id.as_bytes())),
            frame_id: Some(first.frame_id.clone()),
            covariances,
            notes: notes.clone(),
            ..RawLayout::default()
        };
        Ok(Self {
            layout,
            container: c,
            walk: start::<C>(reader)?,
            wanted,
            wire,
            plan: Plan::default(),
            pick: first.pick(),
            decoder,
            bad: 0,
            told: notes,
        })
    }
}

fn start<C: Container>(reader: Box<dyn Read + Send>) -> Result<Walk, Error> {
    let mut walk = Walk::new(reader);
    walk.scan.skip(C::MAGIC as u64)?;
    Ok(walk)
}

/// Counts the messages of every connection.
fn survey<C: Container>(c: &mut C, reader: Box<dyn Read + Send>) -> Result<(), Error> {
    let mut walk = start::<C>(reader)?;
    walk.run(c, None, &mut |_, _| true)?;
    Ok(())
}

impl<C: Container> RawReader for Chunked<C> {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        let Self {
            container,
            walk,
            wanted,
            wire,
            plan,
            pick,
            decoder,
            bad,
            ..
        } = self;
        table::begin(block, plan);
        let more = walk.run(container, Some(wanted), &mut |_, payload| {
            match decoder.decode(payload, *wire) {
                Some(m) => {
                    let v = m.values;
                    let mut row = [0.0; 6];
                    for (out, &i) in row.iter_mut().zip(pick.iter()) {
                        *out = v[i];
                    }
                    table::push(block, plan, m.stamp_ns, &row);
                }
                None => *bad += 1,
            }
            block.rows < table::ROWS
        })?;
        if !more {
            self.layout.notes.clone_from(&self.told);
            self.layout.notes.extend(self.walk.notes());
            if self.bad > 0 {
                self.layout.notes.push(format!(
                    "{} messages are no sensor_msgs/Imu and were left out",
                    grouped(self.bad)
                ));
            }
        }
        Ok(block.rows > 0)
    }
}
