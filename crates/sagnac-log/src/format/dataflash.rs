//! ArduPilot DataFlash `.bin`: messages A3 95, kind, fields; their layouts are messages of kind 128 in the log itself.
//!
//! `IMU`, `IMU2`, `IMU3` (instance by name, or by a field `I`): GyrX…Z [rad/s], AccX…Z [m/s²], T [°C], TimeUS [µs].
//! Source: [ARDUPILOT].

use std::io::Read;

use super::part::{Peeked, peek};
use super::scan::{Scan, f32_at, u64_at};
use super::table;
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::text::grouped;
use crate::{Block, Error, ReadOptions, Topic};

/// Messages begin so; the first describes the descriptions.
pub(crate) const MAGIC: &[u8] = &[0xA3, 0x95, 0x80];
const PEEK: u64 = 1 << 22;
const FRAME: &str = "body, x forward, y right, z down (FRD)";
const FORMAT: u8 = 128;

/// The layout of one kind of message.
#[derive(Debug, Clone, PartialEq)]
struct Format {
    kind: u8,
    length: usize,
    name: String,
    /// Label, type letter and offset of every field.
    fields: Vec<(String, u8, usize)>,
}

impl Format {
    /// Reads the body of a description.
    fn parse(body: &[u8]) -> Option<Self> {
        let (kind, length) = (*body.first()?, usize::from(*body.get(1)?));
        let text = |from: usize, to: usize| {
            let b = body.get(from..to)?;
            let end = b.iter().position(|&c| c == 0).unwrap_or(b.len());
            Some(String::from_utf8_lossy(&b[..end]).into_owned())
        };
        let (name, types, labels) = (text(2, 6)?, text(6, 22)?, text(22, 86)?);
        let mut fields = Vec::new();
        let mut at = 0;
        for (letter, label) in types.bytes().zip(labels.split(',')) {
            fields.push((label.to_owned(), letter, at));
            at += match letter {
                b'b' | b'B' | b'M' => 1,
                b'h' | b'H' | b'c' | b'C' | b'g' => 2,
                b'i' | b'I' | b'f' | b'n' | b'e' | b'E' | b'L' => 4,
                b'd' | b'q' | b'Q' => 8,
                b'N' => 16,
                b'Z' | b'a' => 64,
                _ => return None,
            };
        }
        (length >= 3 && at + 3 <= length).then_some(Self {
            kind,
            length,
            name,
            fields,
        })
    }

    fn at(&self, label: &str, letters: &[u8]) -> Option<usize> {
        self.fields
            .iter()
            .find(|f| f.0 == label && letters.contains(&f.1))
            .map(|f| f.2)
    }
}

/// Where the values of an inertial message stand.
#[derive(Debug, Clone, PartialEq)]
struct Inertial {
    kind: u8,
    time: usize,
    /// Field of the instance and its value.
    instance: Option<(usize, u8)>,
    values: [usize; 6],
    temperature: Option<usize>,
}

impl Inertial {
    fn of(format: &Format) -> Option<Self> {
        let f = |label: &str| format.at(label, b"f");
        Some(Self {
            kind: format.kind,
            time: format.at("TimeUS", b"Q")?,
            instance: format.at("I", b"B").map(|at| (at, 0)),
            values: [
                f("GyrX")?,
                f("GyrY")?,
                f("GyrZ")?,
                f("AccX")?,
                f("AccY")?,
                f("AccZ")?,
            ],
            temperature: f("T"),
        })
    }
}

/// The walk over the messages.
struct Walk {
    scan: Scan,
    /// Length of every kind of message, 0 where it is not known.
    lengths: [usize; 256],
    formats: Vec<Format>,
    lost: Vec<String>,
    lost_bytes: u64,
}

impl Walk {
    fn new(reader: Box<dyn Read + Send>) -> Self {
        let mut lengths = [0; 256];
        lengths[usize::from(FORMAT)] = 89;
        Self {
            scan: Scan::new(reader),
            lengths,
            formats: Vec::new(),
            lost: Vec::new(),
            lost_bytes: 0,
        }
    }

    /// One message of kind and body to `sink`; `false` at the end.
    #[inline]
    fn step(&mut self, sink: &mut impl FnMut(u8, &[u8])) -> Result<bool, Error> {
        if !self.scan.need(3)? {
            return Ok(self.end());
        }
        let head = self.scan.window();
        let kind = head[2];
        let length = self.lengths[usize::from(kind)];
        if head[0] != 0xA3 || head[1] != 0x95 || length < 3 {
            return self.resynchronize();
        }
        if !self.scan.need(length)? {
            return Ok(self.end());
        }
        let body = self.scan.window().get(3..length).unwrap_or(&[]);
        if kind == FORMAT {
            if let Some(f) = Format::parse(body) {
                self.lengths[usize::from(f.kind)] = f.length;
                if !self.formats.iter().any(|g| g.kind == f.kind) {
                    self.formats.push(f);
                }
            }
        } else {
            sink(kind, body);
        }
        self.scan.consume(length);
        Ok(true)
    }

    fn end(&mut self) -> bool {
        if !self.scan.window().is_empty() {
            self.lost.push(format!(
                "the log is cut off at byte {}; the message there is left out",
                grouped(self.scan.offset())
            ));
        }
        false
    }

    #[cold]
    fn resynchronize(&mut self) -> Result<bool, Error> {
        loop {
            self.scan.consume(1);
            self.lost_bytes += 1;
            if !self.scan.need(3)? {
                return Ok(false);
            }
            let window = self.scan.window();
            match memchr::memmem::find(window, &[0xA3, 0x95]) {
                Some(0) if self.lengths[usize::from(window[2])] >= 3 => return Ok(true),
                Some(0) => {}
                Some(at) => {
                    self.scan.consume(at - 1);
                    self.lost_bytes += at as u64 - 1;
                }
                None => {
                    let n = window.len() - 2;
                    self.scan.consume(n);
                    self.lost_bytes += n as u64;
                }
            }
        }
    }
}

/// A DataFlash log.
pub(crate) struct Dataflash {
    layout: RawLayout,
    walk: Walk,
    inertial: Inertial,
    plan: Plan,
    told: Vec<String>,
    is_over: bool,
}

impl Dataflash {
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
        let mut walk = Walk::new(look);
        let mut counts = vec![0_u64; 1 << 16];
        // The field of the instance is the byte after the time in every message that has one.
        let mut instance_at = [None; 256];
        let mut known = 0;
        loop {
            for f in walk.formats.iter().skip(known) {
                instance_at[usize::from(f.kind)] = Inertial::of(f).and_then(|i| i.instance);
            }
            known = walk.formats.len();
            let mut count = |kind: u8, body: &[u8]| {
                let instance = instance_at[usize::from(kind)]
                    .and_then(|(at, _): (usize, u8)| body.get(at))
                    .copied()
                    .unwrap_or(0);
                counts[usize::from(kind) << 8 | usize::from(instance)] += 1;
            };
            if !walk.step(&mut count)? {
                break;
            }
        }
        let mut topics = Vec::new();
        let mut sources = Vec::new();
        for format in &walk.formats {
            let inertial = Inertial::of(format);
            let n = |instance: usize| counts[usize::from(format.kind) << 8 | instance];
            let instances: Vec<usize> = (0..256).filter(|&i| n(i) > 0).collect();
            for &i in &instances {
                let several =
                    inertial.as_ref().is_some_and(|x| x.instance.is_some()) && instances.len() > 1;
                topics.push(Topic {
                    name: if several {
                        format!("{}[{i}]", format.name)
                    } else {
                        format.name.clone()
                    },
                    kind: format.name.clone(),
                    messages: is_whole.then_some(n(i)),
                    is_inertial: inertial.is_some() && format.name.starts_with("IMU"),
                });
                sources.push(inertial.clone().map(|x| Inertial {
                    instance: x.instance.map(|(at, _)| (at, i as u8)),
                    ..x
                }));
            }
        }
        let index = table::choose(&topics, options, "message IMU")?;
        let (Some(topic), Some(Some(inertial))) = (topics.get(index), sources.get(index)) else {
            return Err(Error::data("the log has no message IMU"));
        };
        let mut columns = table::columns("us", true, true);
        if inertial.temperature.is_some() {
            columns.push(table::column("temperature", "degC"));
        }
        Ok(Self {
            layout: RawLayout {
                format: format!("ArduPilot DataFlash{packed}"),
                columns,
                has_names: true,
                samples: topic.messages,
                topic: Some(topic.name.clone()),
                frame: Some(FRAME.to_owned()),
                topics: topics.clone(),
                ..RawLayout::default()
            },
            walk: Walk::new(reader),
            inertial: inertial.clone(),
            plan: Plan::default(),
            told: Vec::new(),
            is_over: false,
        })
    }
}

impl RawReader for Dataflash {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        table::begin(block, &self.plan);
        let (inertial, plan) = (&self.inertial, &self.plan);
        let mut row = [0.0; 7];
        while !self.is_over && block.rows < table::ROWS {
            let mut sink = |kind: u8, body: &[u8]| {
                if kind != inertial.kind
                    || inertial
                        .instance
                        .is_some_and(|(at, i)| body.get(at) != Some(&i))
                {
                    return;
                }
                let all = inertial.values.iter().chain(inertial.temperature.iter());
                for (out, &at) in row.iter_mut().zip(all) {
                    *out = f32_at(body, at).unwrap_or(f64::NAN);
                }
                let time = u64_at(body, inertial.time).unwrap_or(0);
                table::push(block, plan, time.try_into().unwrap_or(i64::MAX), &row);
            };
            if !self.walk.step(&mut sink)? {
                self.is_over = true;
                let notes = &mut self.layout.notes;
                notes.clone_from(&self.told);
                notes.extend(self.walk.lost.iter().cloned());
                if self.walk.lost_bytes > 0 {
                    notes.push(format!(
                        "{} bytes are damaged and left out",
                        grouped(self.walk.lost_bytes)
                    ));
                }
                break;
            }
        }
        Ok(block.rows > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_must_fit_its_length() {
        let mut body = vec![0; 86];
        body[0] = 7;
        body[1] = 10;
        body[2..5].copy_from_slice(b"IMU");
        body[6..8].copy_from_slice(b"QB");
        assert!(Format::parse(&body).is_none());
        body[1] = 12;
        assert!(Format::parse(&body).is_some());
    }
}
