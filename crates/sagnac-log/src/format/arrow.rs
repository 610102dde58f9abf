//! Apache Arrow's own files (IPC: Feather version 2, `.arrow`, and the stream format): columns of numbers by name, some
//! rows of each at a time. Source: [ARROW].
//!
//! Names may carry units as the CSV header's do (`gyro_x [rad/s]`); time stamps of the format's own kind have theirs.
//! A null is no number. The body of a batch is never held: every column is read from its own place.

use std::io::{BufReader, Read};

use polars_arrow_format::ipc::planus::{self, ReadAsRoot as _};
use polars_arrow_format::ipc::{
    BufferRef, CompressionType, Endianness, FieldRef, MessageHeaderRef, MessageRef, Precision,
    RecordBatchRef, TimeUnit, TypeRef, UnionMode,
};

use super::part::Shared;
use super::table::{MOST_COLUMNS, ROWS, Sink, begin, left_out_note, refuse_empty};
use crate::input::InputBytes;
use crate::map::columns::clip;
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::npy::half;
use crate::text::{grouped, name_and_unit};
use crate::{Block, Error};

/// First bytes of a file.
pub(super) const MAGIC: &[u8] = b"ARROW1\0\0";
/// First bytes of Feather version 1, another format.
pub(super) const FEATHER_1: &[u8] = b"FEA1";
/// First bytes of every message, and so of a stream.
const CONTINUATION: [u8; 4] = [0xFF; 4];
/// More than the description of any log's batch takes.
const MOST_METADATA: u32 = 1 << 24;
/// Deeper than any log's columns are nested.
const DEEPEST: usize = 16;

/// Whether these are the first bytes of a stream: a message that describes columns.
pub(super) fn is_stream(head: &[u8]) -> bool {
    head.strip_prefix(&CONTINUATION).is_some_and(|rest| {
        let length = rest.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
        length > 0 && length < MOST_METADATA && length % 8 == 0
    })
}

fn damaged(about: impl std::fmt::Display) -> Error {
    Error::data(format!(
        "the Arrow file is cut off or damaged: {}",
        clip(&about.to_string())
    ))
    .advise("copy it again, or write it anew")
}

/// How a value is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Bool,
    Int { bytes: usize, signed: bool },
    Half,
    Float,
    Double,
}

impl Kind {
    fn of(about: &TypeRef<'_>) -> planus::Result<Option<Self>> {
        let int = |bits: i32, signed| {
            let bytes = usize::try_from(bits).unwrap_or(0) / 8;
            matches!(bits, 8 | 16 | 32 | 64).then_some(Self::Int { bytes, signed })
        };
        Ok(match about {
            TypeRef::Bool(_) => Some(Self::Bool),
            TypeRef::Int(i) => int(i.bit_width()?, i.is_signed()?),
            TypeRef::FloatingPoint(f) => match f.precision()? {
                Precision::Single => Some(Self::Float),
                Precision::Double => Some(Self::Double),
                Precision::Half => Some(Self::Half),
            },
            TypeRef::Timestamp(_) | TypeRef::Duration(_) => int(64, true),
            TypeRef::Time(t) => int(t.bit_width()?, true),
            _ => None,
        })
    }

    /// Bytes that `n` values take.
    fn length(self, n: usize) -> usize {
        match self {
            Self::Bool => n.div_ceil(8),
            Self::Int { bytes, .. } => n * bytes,
            Self::Half => 2 * n,
            Self::Float => 4 * n,
            Self::Double => 8 * n,
        }
    }
}

/// Unit of a column of the format's own times.
fn stamp_unit(about: &TypeRef<'_>) -> planus::Result<Option<&'static str>> {
    let unit = match about {
        TypeRef::Timestamp(t) => t.unit()?,
        TypeRef::Duration(t) => t.unit()?,
        TypeRef::Time(t) => t.unit()?,
        _ => return Ok(None),
    };
    Ok(Some(match unit {
        TimeUnit::Second => "s",
        TimeUnit::Millisecond => "ms",
        TimeUnit::Microsecond => "us",
        TimeUnit::Nanosecond => "ns",
    }))
}

/// A column of numbers: where its buffers stand among those of a batch.
#[derive(Debug, Clone)]
struct Place {
    /// Who may be null: the column and what it is nested in, each with its node and its buffer.
    validity: Vec<(usize, usize)>,
    values: usize,
    /// Columns before it whose number of buffers a batch tells by itself.
    views: usize,
    kind: Kind,
    /// Of a list of as many numbers in every row: how many, and which of them.
    list: Option<(usize, usize)>,
    /// Who may be null among the numbers of such a list.
    item: Option<(usize, usize)>,
}

/// The columns of a schema, and how many buffers and nodes stand before the next.
#[derive(Default)]
struct Schema {
    columns: Vec<RawColumn>,
    places: Vec<Place>,
    left_out: Vec<String>,
    nodes: usize,
    buffers: usize,
    views: usize,
}

impl Schema {
    /// Takes in a field and those nested in it, `above` that may be null as a whole.
    fn add(
        &mut self,
        field: &FieldRef<'_>,
        path: &str,
        above: Option<&[(usize, usize)]>,
        depth: usize,
    ) -> planus::Result<Result<(), Error>> {
        let name = field.name()?.unwrap_or_default();
        let path = if path.is_empty() {
            name.to_owned()
        } else {
            format!("{path}.{name}")
        };
        let Some(about) = field.type_()? else {
            return Ok(Err(damaged("a column has no type")));
        };
        let children = field.children()?;
        if depth > DEEPEST || self.nodes > 2 * MOST_COLUMNS {
            return Ok(Err(damaged("its columns are nested too deep or too many")));
        }
        let (node, buffer) = (self.nodes, self.buffers);
        // A word of a dictionary is stored as its number.
        if field.dictionary()?.is_some() {
            (self.nodes, self.buffers) = (node + 1, buffer + 2);
            self.left_out.push(clip(&path));
            return Ok(Ok(()));
        }
        self.nodes += 1;
        self.buffers += match &about {
            TypeRef::Null(_) | TypeRef::RunEndEncoded(_) => 0,
            TypeRef::Struct(_) | TypeRef::FixedSizeList(_) => 1,
            TypeRef::Union(u) => 1 + usize::from(u.mode()? == UnionMode::Dense),
            TypeRef::Binary(_)
            | TypeRef::Utf8(_)
            | TypeRef::LargeBinary(_)
            | TypeRef::LargeUtf8(_)
            | TypeRef::ListView(_)
            | TypeRef::LargeListView(_) => 3,
            TypeRef::BinaryView(_) | TypeRef::Utf8View(_) => {
                self.views += 1;
                2
            }
            _ => 2,
        };
        let mut validity = above.map(<[_]>::to_vec).unwrap_or_default();
        validity.push((node, buffer));
        if let TypeRef::Struct(_) = about {
            for child in children.into_iter().flatten() {
                let above = above.is_some().then_some(validity.as_slice());
                if let Err(e) = self.add(&child?, &path, above, depth + 1)? {
                    return Ok(Err(e));
                }
            }
            return Ok(Ok(()));
        }
        if let (TypeRef::FixedSizeList(list), Some(_)) = (&about, above)
            && let Some(item) = children.and_then(|c| c.iter().next())
            && self.list(&item?, &path, list.list_size()?, &validity)?
        {
            return Ok(Ok(()));
        }
        let kind = Kind::of(&about)?;
        match (kind, above) {
            (Some(kind), Some(_)) if self.places.len() < MOST_COLUMNS => {
                let (name, unit) = name_and_unit(&path);
                let own = stamp_unit(&about)?;
                self.columns.push(RawColumn {
                    name,
                    unit: own.map(str::to_owned).or(unit),
                    is_own_unit: own.is_some(),
                    ..RawColumn::default()
                });
                self.places.push(Place {
                    validity,
                    values: buffer + 1,
                    views: self.views,
                    kind,
                    list: None,
                    item: None,
                });
            }
            (_, Some(_)) => self.left_out.push(clip(&path)),
            // Inside a list, which is left out as a whole.
            _ => {}
        }
        for child in children.into_iter().flatten() {
            if let Err(e) = self.add(&child?, &path, None, depth + 1)? {
                return Ok(Err(e));
            }
        }
        Ok(Ok(()))
    }
}

impl Schema {
    /// Takes in a list of as many numbers in every row (`gyro` as `gyro[0]`…); `false` where it is none.
    fn list(
        &mut self,
        item: &FieldRef<'_>,
        path: &str,
        size: i32,
        validity: &[(usize, usize)],
    ) -> planus::Result<bool> {
        let size = usize::try_from(size).unwrap_or(0);
        let (Some(about), None) = (item.type_()?, item.dictionary()?) else {
            return Ok(false);
        };
        let kind = match Kind::of(&about)? {
            Some(kind) if kind != Kind::Bool => kind,
            _ => return Ok(false),
        };
        if !(1..=16).contains(&size) || self.places.len() + size > MOST_COLUMNS {
            return Ok(false);
        }
        let (name, unit) = name_and_unit(path);
        for k in 0..size {
            self.columns.push(RawColumn {
                name: format!("{name}[{k}]"),
                unit: unit.clone(),
                ..RawColumn::default()
            });
            self.places.push(Place {
                validity: validity.to_vec(),
                values: self.buffers + 1,
                views: self.views,
                kind,
                list: Some((size, k)),
                item: Some((self.nodes, self.buffers)),
            });
        }
        self.nodes += 1;
        self.buffers += 2;
        Ok(true)
    }
}

/// A batch of rows: its description and where its body begins.
struct Batch {
    metadata: u64,
    metadata_length: u32,
    body: u64,
    body_length: u64,
}

/// A column's values and nulls, on their way.
struct Wanted {
    place: Place,
    /// Who may be null in the batch that is read.
    validity: Vec<Box<dyn Read + Send>>,
    /// The same of the numbers of a list.
    item: Option<Box<dyn Read + Send>>,
    values: Box<dyn Read + Send>,
}

/// An Arrow file as a log.
pub(crate) struct Arrow {
    layout: RawLayout,
    file: Shared,
    places: Vec<Place>,
    batches: Vec<Batch>,
    plan: Plan,
    /// Time first, where there is one.
    wanted: Vec<Wanted>,
    next: usize,
    left: u64,
}

/// What stands at a place of the file.
struct Message {
    metadata: Vec<u8>,
    at: u64,
    length: u32,
}

impl Message {
    /// The message at `at`; `None` at the end of the messages.
    fn read(file: &Shared, at: u64) -> Result<Option<Self>, Error> {
        let mut head = Vec::new();
        file.part(at, 8)
            .read_to_end(&mut head)
            .map_err(Error::read)?;
        let word = |at: usize| {
            head.get(at..at + 4)
                .and_then(|b| b.first_chunk())
                .map(|b| u32::from_le_bytes(*b))
        };
        // Before version 0.15 the length alone stood here.
        let (length, skip) = match word(0) {
            Some(u32::MAX) => (word(4), 8),
            length => (length, 4),
        };
        match length {
            None | Some(0) => Ok(None),
            Some(n) if n >= MOST_METADATA => Err(damaged(format!(
                "a description of {} bytes",
                grouped(n.into())
            ))),
            Some(length) => {
                let at = at + skip;
                let mut metadata = Vec::new();
                file.part(at, length.into())
                    .read_to_end(&mut metadata)
                    .map_err(Error::read)?;
                if metadata.len() < length as usize {
                    return Ok(None);
                }
                Ok(Some(Self {
                    metadata,
                    at,
                    length,
                }))
            }
        }
    }

    fn root(&self) -> Result<MessageRef<'_>, Error> {
        MessageRef::read_as_root(&self.metadata).map_err(damaged)
    }
}

impl Arrow {
    pub(crate) fn open(bytes: InputBytes, head: &[u8], packed: &str) -> Result<Self, Error> {
        let InputBytes::File(file) = bytes else {
            return Err(super::arrays::no_pipe("an Arrow file", packed));
        };
        let file = Shared::new(file);
        let end = file.length().map_err(Error::read)?;
        let mut at = if head.starts_with(MAGIC) { 8 } else { 0 };
        let mut schema = None;
        let (mut batches, mut rows, mut cut) = (Vec::new(), 0_u64, false);
        while let Some(message) = Message::read(&file, at)? {
            let root = message.root()?;
            let body = message.at + u64::from(message.length);
            let body_length = u64::try_from(root.body_length().map_err(damaged)?)
                .map_err(|_| damaged("a body of less than nothing"))?;
            match (root.header().map_err(damaged)?, &mut schema) {
                (Some(MessageHeaderRef::Schema(s)), None) => {
                    if s.endianness().map_err(damaged)? == Endianness::Big {
                        return Err(Error::data("the Arrow file is big-endian")
                            .advise("write it again on a usual machine"));
                    }
                    let mut found = Schema::default();
                    for field in s.fields().map_err(damaged)?.into_iter().flatten() {
                        let field = field.map_err(damaged)?;
                        found.add(&field, "", Some(&[]), 0).map_err(damaged)??;
                    }
                    schema = Some(found);
                }
                (Some(MessageHeaderRef::RecordBatch(batch)), Some(_)) => {
                    let n = u64::try_from(batch.length().map_err(damaged)?)
                        .map_err(|_| damaged("a batch of less than no rows"))?;
                    if body.saturating_add(body_length) > end {
                        cut = true;
                        break;
                    }
                    rows = rows.saturating_add(n);
                    batches.push(Batch {
                        metadata: message.at,
                        metadata_length: message.length,
                        body,
                        body_length,
                    });
                }
                (_, None) => return Err(damaged("its first message describes no columns")),
                _ => {}
            }
            at = body.saturating_add(body_length);
            cut = at > end;
        }
        let schema = schema.ok_or_else(|| damaged("it describes no columns"))?;
        let mut notes: Vec<String> = left_out_note(schema.left_out).into_iter().collect();
        if cut {
            notes.push("the file was cut off; its whole batches of rows were read".to_owned());
        }
        refuse_empty(rows, schema.columns.is_empty(), &notes)?;
        Ok(Self {
            layout: RawLayout {
                format: format!("Arrow{packed}"),
                columns: schema.columns,
                has_names: true,
                samples: Some(rows),
                header_place: Some("schema".to_owned()),
                notes,
                ..RawLayout::default()
            },
            file,
            places: schema.places,
            batches,
            plan: Plan::default(),
            wanted: Vec::new(),
            next: 0,
            left: 0,
        })
    }

    /// Goes to the next batch that has rows; `false` where there is none.
    fn next_batch(&mut self) -> Result<bool, Error> {
        while self.left == 0 {
            let Some(at) = self.batches.get(self.next) else {
                return Ok(false);
            };
            self.next += 1;
            let mut metadata = Vec::new();
            self.file
                .part(at.metadata, at.metadata_length.into())
                .read_to_end(&mut metadata)
                .map_err(Error::read)?;
            let root = MessageRef::read_as_root(&metadata).map_err(damaged)?;
            let Some(MessageHeaderRef::RecordBatch(batch)) = root.header().map_err(damaged)? else {
                return Err(damaged("the file changed while it was read"));
            };
            let rows = batch.length().map_err(damaged)?;
            self.left = u64::try_from(rows).map_err(|_| damaged("a batch of less than no rows"))?;
            let body = Body {
                file: &self.file,
                at,
                batch,
            };
            for wanted in &mut self.wanted {
                body.begin(wanted)?;
            }
        }
        Ok(true)
    }
}

/// The buffers of a batch.
struct Body<'a> {
    file: &'a Shared,
    at: &'a Batch,
    batch: RecordBatchRef<'a>,
}

impl Body<'_> {
    /// Goes to the column's place in this batch.
    fn begin(&self, wanted: &mut Wanted) -> Result<(), Error> {
        let place = &wanted.place;
        let views = self.batch.variadic_buffer_counts().map_err(damaged)?;
        let before = views.into_iter().flatten().take(place.views);
        let more: i64 = before.fold(0, i64::saturating_add);
        let more = usize::try_from(more).map_err(|_| damaged("less than no buffers"))?;
        let nodes = self.batch.nodes().map_err(damaged)?;
        wanted.validity.clear();
        let bits = |(node, buffer): (usize, usize)| {
            let node = nodes.and_then(|n| n.get(node));
            let node = node.ok_or_else(|| damaged("a batch lacks a column"))?;
            let has_nulls = node.null_count() != 0;
            has_nulls
                .then(|| self.buffer(buffer.saturating_add(more)))
                .transpose()
        };
        for &above in &place.validity {
            wanted.validity.extend(bits(above)?);
        }
        wanted.item = place.item.map(bits).transpose()?.flatten();
        wanted.values = self.buffer(place.values.saturating_add(more))?;
        Ok(())
    }

    /// The bytes of a buffer, unpacked.
    fn buffer(&self, index: usize) -> Result<Box<dyn Read + Send>, Error> {
        let buffers = self.batch.buffers().map_err(damaged)?;
        let Some(buffer) = buffers.and_then(|b| b.get(index)) else {
            return Err(damaged("a batch lacks a buffer"));
        };
        let (from, length) = self.span(&buffer)?;
        let part = |skip: u64| {
            let part = self.file.part(from + skip, length - skip);
            BufReader::with_capacity(1 << 16, part)
        };
        let compression = self.batch.compression().map_err(damaged)?;
        let (Some(compression), true) = (compression, length >= 8) else {
            return Ok(Box::new(part(0)));
        };
        let mut unpacked = [0; 8];
        let read = self.file.part(from, 8).read_exact(&mut unpacked);
        read.map_err(Error::read)?;
        // A buffer that would not shrink is stored as it is.
        if i64::from_le_bytes(unpacked) == -1 {
            return Ok(Box::new(part(8)));
        }
        Ok(match compression.codec().map_err(damaged)? {
            CompressionType::Lz4Frame => Box::new(lz4_flex::frame::FrameDecoder::new(part(8))),
            CompressionType::Zstd => {
                let mut decoder = zstd::Decoder::with_buffer(part(8)).map_err(Error::read)?;
                decoder.window_log_max(27).map_err(Error::read)?;
                Box::new(decoder)
            }
        })
    }

    /// Where in the file a buffer stands, inside the batch's body.
    fn span(&self, buffer: &BufferRef<'_>) -> Result<(u64, u64), Error> {
        let offset = u64::try_from(buffer.offset()).ok();
        let length = u64::try_from(buffer.length()).ok();
        offset
            .zip(length)
            .filter(|(o, l)| o.saturating_add(*l) <= self.at.body_length)
            .map(|(o, l)| (self.at.body + o, l))
            .ok_or_else(|| damaged("a buffer lies outside its batch"))
    }
}

impl RawReader for Arrow {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        let columns = plan.time.iter().map(|t| t.0).chain(plan.columns.clone());
        self.wanted = columns
            .filter_map(|c| self.places.get(c).cloned())
            .map(|place| Wanted {
                place,
                validity: Vec::new(),
                item: None,
                values: Box::new(std::io::empty()),
            })
            .collect();
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        begin(block, &self.plan);
        if !self.next_batch()? {
            return Ok(false);
        }
        let n = self.left.min(ROWS as u64) as usize;
        let (mut valid, mut bits, mut bytes) = (Vec::new(), Vec::new(), Vec::new());
        for (k, wanted) in self.wanted.iter_mut().enumerate() {
            let short = |e: std::io::Error| damaged(e).at(format!("column {}", k + 1));
            valid.clear();
            valid.resize(n.div_ceil(8), 0xFF_u8);
            for reader in &mut wanted.validity {
                bits.resize(n.div_ceil(8), 0);
                reader.read_exact(&mut bits).map_err(short)?;
                valid.iter_mut().zip(&bits).for_each(|(v, b)| *v &= b);
            }
            let (of, which) = wanted.place.list.unwrap_or((1, 0));
            let kind = wanted.place.kind;
            bytes.resize(kind.length(n * of), 0);
            wanted.values.read_exact(&mut bytes).map_err(short)?;
            if of > 1 {
                let size = kind.length(1);
                for k in 0..n {
                    let from = (k * of + which) * size;
                    bytes.copy_within(from..from + size, k * size);
                }
                bytes.truncate(n * size);
            }
            if let Some(reader) = &mut wanted.item {
                bits.resize((n * of).div_ceil(8), 0);
                reader.read_exact(&mut bits).map_err(short)?;
                for k in 0..n {
                    let at = k * of + which;
                    let is_valid = bits[at / 8] >> (at % 8) & 1;
                    valid[k / 8] &= !((1 - is_valid) << (k % 8));
                }
            }
            hand_out(
                &bytes,
                &valid,
                n,
                wanted.place.kind,
                &mut Sink::new(block, &self.plan, k),
            );
        }
        self.left -= n as u64;
        block.rows = n;
        Ok(true)
    }
}

/// Hands `n` values on.
fn hand_out(bytes: &[u8], valid: &[u8], n: usize, kind: Kind, sink: &mut Sink<'_>) {
    let bit = |bits: &[u8], k: usize| bits.get(k / 8).is_some_and(|b| b >> (k % 8) & 1 == 1);
    let is_valid = |k: usize| bit(valid, k);
    match kind {
        Kind::Bool => {
            for k in 0..n {
                sink.whole(is_valid(k).then(|| i64::from(bit(bytes, k))));
            }
        }
        Kind::Half => {
            for (k, b) in bytes.as_chunks().0.iter().enumerate() {
                let value = half(u16::from_le_bytes(*b));
                sink.put(None, if is_valid(k) { value } else { f64::NAN });
            }
        }
        Kind::Float => {
            for (k, b) in bytes.as_chunks().0.iter().enumerate() {
                let value = f64::from(f32::from_le_bytes(*b));
                sink.put(None, if is_valid(k) { value } else { f64::NAN });
            }
        }
        Kind::Double => {
            for (k, b) in bytes.as_chunks().0.iter().enumerate() {
                let value = f64::from_le_bytes(*b);
                sink.put(None, if is_valid(k) { value } else { f64::NAN });
            }
        }
        Kind::Int {
            bytes: size,
            signed,
        } => {
            for (k, b) in bytes.chunks_exact(size).enumerate() {
                if !is_valid(k) {
                    sink.whole(None);
                    continue;
                }
                let fill = if signed && b[size - 1] >= 0x80 {
                    0xFF
                } else {
                    0
                };
                let mut wide = [fill; 8];
                wide[..size].copy_from_slice(b);
                let value = i64::from_le_bytes(wide);
                if signed || value >= 0 {
                    sink.whole(Some(value));
                } else {
                    sink.put(None, value as u64 as f64);
                }
            }
        }
    }
}
