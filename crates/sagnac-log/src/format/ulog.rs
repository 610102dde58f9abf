//! PX4 ULog: definitions of message formats, then messages of u16 size, u8 kind and payload.
//!
//! Kinds used: formats (F), subscriptions (A), data (D), dropouts (O), flags (B). Source: [ULOG].

use super::part::{Peeked, peek};
use super::scan::{Scan, f32_at, u16_at, u32_at, u64_at};
use super::table;
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::text::grouped;
use crate::{Block, Error, ReadOptions, Topic};

pub(crate) const MAGIC: &[u8] = b"ULog\x01\x12\x35";
/// Bytes looked at to find what is logged.
const PEEK: u64 = 1 << 22;
/// Body axes of PX4.
const FRAME: &str = "body, x forward, y right, z down (FRD)";

/// A scalar of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scalar {
    F32,
    F64,
    I16,
    I32,
    U16,
    U32,
}

impl Scalar {
    fn value(self, data: &[u8], at: usize) -> Option<f64> {
        match self {
            Self::F32 => f32_at(data, at),
            Self::F64 => u64_at(data, at).map(f64::from_bits),
            Self::I16 => u16_at(data, at).map(|v| f64::from(v as i16)),
            Self::I32 => u32_at(data, at).map(|v| f64::from(v as i32)),
            Self::U16 => u16_at(data, at).map(f64::from),
            Self::U32 => u32_at(data, at).map(f64::from),
        }
    }
}

/// Where one value stands in the data of a message.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    at: usize,
    scalar: Scalar,
    column: RawColumn,
    /// Where the time stands, in µs, that an increment has to be divided by.
    per: Option<(usize, Scalar)>,
}

impl Field {
    fn value(&self, data: &[u8]) -> Option<f64> {
        let value = self.scalar.value(data, self.at)?;
        match self.per {
            None => Some(value),
            Some((at, scalar)) => Some(value / (1e-6 * scalar.value(data, at)?)),
        }
    }
}

#[derive(Debug, Default)]
struct Definitions {
    /// Name and fields (`type name;…`).
    formats: Vec<(String, String)>,
    /// Message number, instance and name.
    subscriptions: Vec<(u16, u8, String)>,
    counts: Vec<(u16, u64)>,
    dropouts: u64,
    dropout_ms: u64,
    lost: Vec<String>,
}

/// What one message was.
enum Step {
    Data,
    Other,
    End,
}

impl Definitions {
    fn take(&mut self, kind: u8, body: &[u8]) {
        match kind {
            b'F' => {
                let text = String::from_utf8_lossy(body);
                if let Some((name, fields)) = text.split_once(':')
                    && self.formats.len() < 4096
                {
                    self.formats.push((name.to_owned(), fields.to_owned()));
                }
            }
            b'A' => {
                if let (Some(&instance), Some(id), Some(name)) =
                    (body.first(), u16_at(body, 1), body.get(3..))
                    && !self.subscriptions.iter().any(|s| s.0 == id)
                {
                    let name = String::from_utf8_lossy(name).into_owned();
                    self.subscriptions.push((id, instance, name));
                }
            }
            b'O' => {
                self.dropouts += 1;
                self.dropout_ms += u64::from(u16_at(body, 0).unwrap_or(0));
            }
            _ => {}
        }
    }

    /// Size of a type; nested messages by their own format, to a depth that real logs stay below.
    fn size(&self, kind: &str, depth: usize) -> Option<usize> {
        Some(match kind {
            "int8_t" | "uint8_t" | "bool" | "char" => 1,
            "int16_t" | "uint16_t" => 2,
            "int32_t" | "uint32_t" | "float" => 4,
            "int64_t" | "uint64_t" | "double" => 8,
            _ if depth > 4 => return None,
            other => {
                let format = self.formats.iter().find(|f| f.0 == other)?;
                let mut total = 0_usize;
                for field in format.1.split(';').filter(|f| !f.trim().is_empty()) {
                    let (kind, count) = kind_and_count(field.trim().split(' ').next()?)?;
                    total = total.checked_add(self.size(kind, depth + 1)?.checked_mul(count)?)?;
                }
                total
            }
        })
    }

    /// Offset of the time stamp and the fields of an inertial message.
    fn fields(&self, name: &str) -> Option<(usize, Vec<Field>)> {
        let format = self.formats.iter().find(|f| f.0 == name)?;
        let (mut at, mut time, mut out) = (0_usize, None, Vec::new());
        let (mut sampled, mut intervals) = (None, Vec::new());
        let mut increments: Vec<String> = Vec::new();
        for field in format.1.split(';').filter(|f| !f.trim().is_empty()) {
            let (kind, label) = field.trim().split_once(' ')?;
            let (kind, count) = kind_and_count(kind)?;
            let size = self.size(kind, 0)?;
            let scalar = match kind {
                "float" => Some(Scalar::F32),
                "double" => Some(Scalar::F64),
                "int16_t" => Some(Scalar::I16),
                "int32_t" => Some(Scalar::I32),
                "uint16_t" if label.ends_with("_dt") => Some(Scalar::U16),
                "uint32_t" if label.ends_with("_dt") => Some(Scalar::U32),
                _ => None,
            };
            if let (Some(scalar), Some(of)) = (scalar, label.strip_suffix("_dt")) {
                intervals.push((of.to_owned(), (at, scalar)));
            } else if label == "timestamp_sample" && kind == "uint64_t" && name == "vehicle_imu" {
                sampled = Some(at);
            } else if label == "timestamp" && kind == "uint64_t" {
                time = Some(at);
            } else if let (Some(scalar), Some(channels)) = (scalar, channels(name, label, count)) {
                for (k, (channel, unit)) in channels.into_iter().enumerate() {
                    out.push(Field {
                        at: at + k * size,
                        scalar,
                        column: table::column(&channel, unit),
                        per: None,
                    });
                    increments.push(label.to_owned());
                }
            }
            at = at.checked_add(size.checked_mul(count)?)?;
        }
        if name == "vehicle_imu" {
            for (field, label) in out.iter_mut().zip(&increments) {
                let own = intervals.iter().find(|i| i.0 == *label);
                field.per = Some(own?.1);
            }
        }
        // Old formats hold x, y, z as floats; raw counts of other types have no unit here.
        (!out.is_empty()).then_some((sampled.or(time)?, out))
    }

    fn topics(&self) -> Vec<(u16, Topic)> {
        let mut out: Vec<(u16, Topic)> = self
            .subscriptions
            .iter()
            .map(|(id, instance, name)| {
                let several = self.subscriptions.iter().filter(|s| s.2 == *name).count() > 1;
                let shown = if several && *instance > 0 {
                    format!("{name}/{instance}")
                } else {
                    name.clone()
                };
                let n = self.counts.iter().find(|c| c.0 == *id).map_or(0, |c| c.1);
                let topic = Topic {
                    name: shown,
                    kind: name.clone(),
                    messages: Some(n),
                    is_inertial: n > 0 && self.fields(name).is_some(),
                };
                (*id, topic)
            })
            .collect();
        out.sort_by(|a, b| a.1.name.cmp(&b.1.name));
        out
    }
}

fn kind_and_count(text: &str) -> Option<(&str, usize)> {
    match text.split_once('[') {
        Some((kind, n)) => {
            let n: usize = n.strip_suffix(']')?.parse().ok()?;
            (n <= 65_536).then_some((kind, n))
        }
        None => Some((text, 1)),
    }
}

/// The channels of a field by PX4's message definitions.
fn channels(message: &str, label: &str, count: usize) -> Option<Vec<(String, &'static str)>> {
    let triad = |word: &str, unit| {
        Some(
            ["x", "y", "z"]
                .map(|a| (format!("{word}_{a}"), unit))
                .to_vec(),
        )
    };
    let one = |word: String, unit| Some(vec![(word, unit)]);
    match (message, label, count) {
        // Increments of vehicle_imu are divided by their own intervals.
        ("sensor_combined", "gyro_rad", 3) | ("vehicle_imu", "delta_angle", 3) => {
            triad("gyro", "rad/s")
        }
        ("sensor_combined", "accelerometer_m_s2", 3) | ("vehicle_imu", "delta_velocity", 3) => {
            triad("accel", "m/s^2")
        }
        ("sensor_gyro", "x" | "y" | "z", 1) => one(format!("gyro_{label}"), "rad/s"),
        ("sensor_accel", "x" | "y" | "z", 1) => one(format!("accel_{label}"), "m/s^2"),
        ("sensor_gyro" | "sensor_accel", "temperature", 1) => one(label.to_owned(), "degC"),
        _ => None,
    }
}

/// Walks one message. `sink` sees the data of messages.
#[inline]
fn step(
    scan: &mut Scan,
    definitions: &mut Definitions,
    sink: &mut impl FnMut(u16, &[u8]),
    learn: bool,
) -> Result<Step, Error> {
    if !scan.need(3)? {
        if !scan.window().is_empty() {
            cut(scan, definitions);
        }
        return Ok(Step::End);
    }
    let window = scan.window();
    let size = usize::from(u16_at(window, 0).unwrap_or(0));
    let kind = window.get(2).copied().unwrap_or(0);
    if !b"BFIMPQALCDSOR".contains(&kind) {
        return resynchronize(scan, definitions);
    }
    if !scan.need(size + 3)? {
        cut(scan, definitions);
        return Ok(Step::End);
    }
    let body = scan.window().get(3..size + 3).unwrap_or(&[]);
    let result = if kind == b'D' {
        if let (Some(id), Some(data)) = (u16_at(body, 0), body.get(2..)) {
            sink(id, data);
        }
        Step::Data
    } else {
        if learn || kind == b'O' {
            definitions.take(kind, body);
        }
        Step::Other
    };
    scan.consume(size + 3);
    Ok(result)
}

fn cut(scan: &Scan, definitions: &mut Definitions) {
    definitions.lost.push(format!(
        "the log is cut off at byte {}; the message there is left out",
        grouped(scan.offset())
    ));
}

/// After damage: on at the next synchronization message, whose bytes are fixed.
#[cold]
fn resynchronize(scan: &mut Scan, definitions: &mut Definitions) -> Result<Step, Error> {
    const SYNC: [u8; 11] = [8, 0, b'S', 0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12];
    let from = scan.offset();
    loop {
        if !scan.need(SYNC.len())? {
            definitions.lost.push(format!(
                "from byte {} on the log is damaged; the rest is left out",
                grouped(from)
            ));
            return Ok(Step::End);
        }
        if let Some(at) = memchr::memmem::find(scan.window(), &SYNC) {
            scan.consume(at);
            if definitions.lost.len() < 10 {
                definitions.lost.push(format!(
                    "bytes {} to {} are damaged and left out",
                    grouped(from),
                    grouped(scan.offset())
                ));
            }
            return Ok(Step::Other);
        }
        let n = scan.window().len() - (SYNC.len() - 1);
        scan.consume(n);
    }
}

/// A ULog as a log.
pub(crate) struct Ulog {
    layout: RawLayout,
    scan: Scan,
    definitions: Definitions,
    id: u16,
    time_at: usize,
    fields: Vec<Field>,
    plan: Plan,
    told: Vec<String>,
    short: u64,
    is_over: bool,
}

impl Ulog {
    pub(crate) fn open(
        bytes: InputBytes,
        packed: &str,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let Peeked {
            look,
            reader,
            is_whole,
        } = peek(bytes, PEEK)?;
        let mut found = Definitions::default();
        let mut scan = Scan::new(look);
        scan.skip(16)?;
        let mut counts: Vec<u64> = vec![0; 1 << 16];
        loop {
            let mut count = |id: u16, _: &[u8]| counts[usize::from(id)] += 1;
            if matches!(step(&mut scan, &mut found, &mut count, true)?, Step::End) {
                break;
            }
        }
        found.counts = (0..=u16::MAX).zip(counts).filter(|c| c.1 > 0).collect();
        let mut topics = found.topics();
        // sensor_combined is PX4's own pair of gyro and accelerometer: it is what a log of this format means.
        let combined = topics
            .iter()
            .position(|t| t.1.name == "sensor_combined" && t.1.is_inertial);
        if !is_whole {
            for t in &mut topics {
                t.1.messages = None;
            }
        }
        let list: Vec<Topic> = topics.iter().map(|t| t.1.clone()).collect();
        let index = match (options.topic.as_ref(), combined) {
            (None, Some(i)) => i,
            _ => table::choose(&list, options, "an inertial message")?,
        };
        let (id, topic) = topics
            .get(index)
            .cloned()
            .ok_or_else(|| Error::data("the log has no messages"))?;
        let (time_at, fields) = found
            .fields(&topic.kind)
            .ok_or_else(|| Error::data("the message has no time stamp"))?;
        let mut columns = vec![table::column("time", "us")];
        columns.extend(fields.iter().map(|f| f.column.clone()));
        let mut notes = Vec::new();
        if topic.kind == "vehicle_imu" {
            notes.push(
                "vehicle_imu holds increments: divided by delta_angle_dt and delta_velocity_dt, they are means over those"
                    .to_owned(),
            );
        }
        let others: Vec<&str> = list
            .iter()
            .filter(|t| t.is_inertial && t.name != topic.name)
            .map(|t| t.name.as_str())
            .collect();
        if !others.is_empty() {
            notes.push(format!(
                "message {} was read; --topic takes {} too",
                topic.name,
                others.join(", ")
            ));
        }
        found.lost.clear();
        (found.dropouts, found.dropout_ms) = (0, 0);
        let mut scan = Scan::new(reader);
        scan.skip(16)?;
        Ok(Self {
            layout: RawLayout {
                format: format!("PX4 ULog{packed}"),
                columns,
                has_names: true,
                samples: topic.messages,
                topics: list,
                topic: Some(topic.name),
                frame: Some(FRAME.to_owned()),
                notes: notes.clone(),
                ..RawLayout::default()
            },
            scan,
            definitions: found,
            id,
            time_at,
            fields,
            plan: Plan::default(),
            told: notes,
            short: 0,
            is_over: false,
        })
    }
}

impl RawReader for Ulog {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        table::begin(block, &self.plan);
        let Self {
            scan,
            definitions,
            id,
            time_at,
            fields,
            plan,
            short,
            ..
        } = self;
        let mut row = vec![0.0; fields.len()];
        let mut over = false;
        while !self.is_over && block.rows < table::ROWS {
            let mut sink = |found: u16, data: &[u8]| {
                if found != *id {
                    return;
                }
                let Some(time) = u64_at(data, *time_at) else {
                    *short += 1;
                    return;
                };
                for (out, field) in row.iter_mut().zip(fields.iter()) {
                    let Some(value) = field.value(data) else {
                        *short += 1;
                        return;
                    };
                    *out = value;
                }
                table::push(block, plan, time.try_into().unwrap_or(i64::MAX), &row);
            };
            if matches!(step(scan, definitions, &mut sink, false)?, Step::End) {
                over = true;
                self.is_over = true;
                break;
            }
        }
        if over {
            let notes = &mut self.layout.notes;
            notes.clone_from(&self.told);
            if self.definitions.dropouts > 0 {
                notes.push(format!(
                    "the logger dropped data {} times, {} ms in all",
                    grouped(self.definitions.dropouts),
                    grouped(self.definitions.dropout_ms)
                ));
            }
            notes.extend(self.definitions.lost.iter().cloned());
            if self.short > 0 {
                notes.push(format!(
                    "{} messages are too short and were left out",
                    grouped(self.short)
                ));
            }
        }
        Ok(block.rows > 0)
    }
}
