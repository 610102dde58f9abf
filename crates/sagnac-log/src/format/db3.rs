//! ROS 2 recordings of rosbag2 in SQLite (`.db3`): tables `topics` and `messages`, read page by page.
//!
//! A table is a tree of pages: interior pages (5) point to leaves (13) of rows; long rows go on in overflow pages.
//! Source: [SQLITE].

use std::io::Read;

use super::part::Shared;
use super::ros::{self, First, Wire};
use super::table;
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::text::grouped;
use crate::{Block, Error, ReadOptions, Topic};

pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";
/// A row beyond this is no inertial message.
const LARGEST_ROW: u64 = 1 << 16;
/// Trees of real files are a few levels deep.
const DEEPEST: usize = 16;

/// The pages of a database.
struct Pages {
    file: Shared,
    size: usize,
    usable: usize,
    count: u64,
}

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cell<'a> {
    Integer(i64),
    Bytes(&'a [u8]),
    Other,
}

fn be(bytes: &[u8], at: usize, n: usize) -> Option<u64> {
    let b = bytes.get(at..at.checked_add(n)?)?;
    Some(b.iter().fold(0, |a, &x| a << 8 | u64::from(x)))
}

/// A variable-length integer and its length.
fn varint(bytes: &[u8], at: usize) -> Option<(u64, usize)> {
    let mut value = 0_u64;
    for k in 0..9 {
        let b = *bytes.get(at.checked_add(k)?)?;
        if k == 8 {
            return Some((value << 8 | u64::from(b), 9));
        }
        value = value << 7 | u64::from(b & 0x7F);
        if b < 0x80 {
            return Some((value, k + 1));
        }
    }
    None
}

/// The first cells of a record.
fn cells(record: &[u8]) -> Vec<Cell<'_>> {
    let mut out = Vec::new();
    let Some((head, mut at)) = varint(record, 0) else {
        return out;
    };
    let head = usize::try_from(head).unwrap_or(usize::MAX);
    let mut body = head;
    while at < head && out.len() < 16 {
        let Some((kind, n)) = varint(record, at) else {
            break;
        };
        at += n;
        let integer = |n: usize| {
            let shift = 64 - 8 * n as u32;
            be(record, body, n).map(|v| ((v << shift) as i64) >> shift)
        };
        let (cell, length) = match kind {
            1..=4 => (integer(kind as usize).map(Cell::Integer), kind as usize),
            5 => (integer(6).map(Cell::Integer), 6),
            6 => (integer(8).map(Cell::Integer), 8),
            7 => (Some(Cell::Other), 8),
            8 => (Some(Cell::Integer(0)), 0),
            9 => (Some(Cell::Integer(1)), 0),
            0 | 10 | 11 => (Some(Cell::Other), 0),
            k => {
                let n = usize::try_from((k - 12) / 2).unwrap_or(usize::MAX);
                let bytes = body.checked_add(n).and_then(|end| record.get(body..end));
                (bytes.map(Cell::Bytes), n)
            }
        };
        out.push(cell.unwrap_or(Cell::Other));
        body = body.saturating_add(length);
    }
    out
}

impl Pages {
    fn open(file: Shared) -> Result<Self, Error> {
        let mut head = Vec::new();
        file.part(0, 100)
            .read_to_end(&mut head)
            .map_err(Error::read)?;
        let size = match be(&head, 16, 2) {
            Some(1) => 65_536,
            Some(n) if n >= 512 && n.is_power_of_two() => n as usize,
            _ => return Err(Error::data("the head of the SQLite file is damaged")),
        };
        let reserved = usize::from(head.get(20).copied().unwrap_or(0));
        let length = file.length().map_err(Error::read)?;
        Ok(Self {
            file,
            size,
            usable: size.saturating_sub(reserved).max(480),
            count: length / size as u64,
        })
    }

    /// Page `number`, counted from 1.
    fn page(&self, number: u64) -> Option<Vec<u8>> {
        if number == 0 || number > self.count {
            return None;
        }
        let mut out = Vec::with_capacity(self.size);
        self.file
            .part((number - 1) * self.size as u64, self.size as u64)
            .read_to_end(&mut out)
            .ok()?;
        (out.len() == self.size).then_some(out)
    }
}

/// A walk over the rows of a table.
struct Rows {
    /// Pages on the way from the root: content, number of cells and the next one.
    path: Vec<(Vec<u8>, usize, usize)>,
    next: Option<u64>,
    /// Pages seen: a tree that bites its tail ends.
    seen: u64,
    lost_pages: u64,
    lost_cells: u64,
    record: Vec<u8>,
}

impl Rows {
    fn new(root: u64) -> Self {
        Self {
            path: Vec::new(),
            next: Some(root),
            seen: 0,
            lost_pages: 0,
            lost_cells: 0,
            record: Vec::new(),
        }
    }

    /// The next row: its number; its record stands in `self.record`.
    fn step(&mut self, pages: &Pages) -> Option<i64> {
        loop {
            if let Some(number) = self.next.take() {
                self.seen += 1;
                if self.seen > pages.count || self.path.len() >= DEEPEST {
                    self.lost_pages += 1;
                } else {
                    match pages.page(number) {
                        Some(page) => {
                            let at = if number == 1 { 100 } else { 0 };
                            let n = be(&page, at + 3, 2).unwrap_or(0) as usize;
                            if matches!(page.get(at), Some(5 | 13)) {
                                self.path.push((page, n, 0));
                            } else {
                                self.lost_pages += 1;
                            }
                        }
                        None => self.lost_pages += 1,
                    }
                }
            }
            let is_first = self.seen == 1 && self.path.len() == 1;
            let (page, n, k) = self.path.last_mut()?;
            // Only the schema has its root on page 1, after the file's head.
            let at = if is_first && page.starts_with(MAGIC) {
                100
            } else {
                0
            };
            let is_leaf = page.get(at) == Some(&13);
            let table = at + if is_leaf { 8 } else { 12 };
            if *k >= *n {
                if !is_leaf && *k == *n {
                    *k += 1;
                    self.next = be(page, at + 8, 4);
                    continue;
                }
                self.path.pop();
                continue;
            }
            let cell = be(page, table + 2 * *k, 2).unwrap_or(0) as usize;
            *k += 1;
            if !is_leaf {
                self.next = be(page, cell, 4);
                continue;
            }
            let Some((length, a)) = varint(page, cell) else {
                self.lost_cells += 1;
                continue;
            };
            let Some((row, b)) = varint(page, cell + a) else {
                self.lost_cells += 1;
                continue;
            };
            let start = cell + a + b;
            if load(pages, page, start, length, &mut self.record).is_none() {
                self.lost_cells += 1;
                continue;
            }
            return Some(row as i64);
        }
    }
}

/// Puts a record together from its page and its overflow pages.
fn load(pages: &Pages, page: &[u8], start: usize, length: u64, out: &mut Vec<u8>) -> Option<()> {
    out.clear();
    let usable = pages.usable as u64;
    let most = usable - 35;
    if length <= most {
        out.extend_from_slice(page.get(start..start.checked_add(length as usize)?)?);
        return Some(());
    }
    let least = (usable - 12) * 32 / 255 - 23;
    let kept = least + (length - least) % (usable - 4);
    let local = if kept <= most { kept } else { least } as usize;
    out.extend_from_slice(page.get(start..start.checked_add(local)?)?);
    let mut next = be(page, start + local, 4)?;
    // Longer rows are messages of other topics: their first bytes tell what they are.
    let wanted = length.min(LARGEST_ROW);
    while (out.len() as u64) < wanted {
        let page = pages.page(next)?;
        let n = (length - out.len() as u64).min(usable - 4) as usize;
        out.extend_from_slice(page.get(4..4 + n)?);
        next = be(&page, 0, 4)?;
    }
    Some(())
}

/// A recording as a log.
pub(crate) struct Db3 {
    layout: RawLayout,
    pages: Pages,
    rows: Rows,
    topic: i64,
    /// Column of the topic's number and of the data in `messages`.
    columns: (usize, usize),
    pick: &'static [usize],
    decoder: ros::Decoder,
    plan: Plan,
    bad: u64,
    told: Vec<String>,
    is_over: bool,
}

/// Places of the named columns in a `CREATE TABLE`.
fn places(sql: &[u8], names: &[&str]) -> Option<Vec<usize>> {
    let text = String::from_utf8_lossy(sql);
    let list = text.split_once('(')?.1;
    let columns: Vec<String> = list
        .split(',')
        .filter_map(|c| {
            let word = c.split_whitespace().next()?;
            Some(word.trim_matches(['"', '`', '[', ']']).to_ascii_lowercase())
        })
        .collect();
    names
        .iter()
        .map(|n| columns.iter().position(|c| c == n))
        .collect()
}

impl Db3 {
    pub(crate) fn open(
        bytes: InputBytes,
        packed: &str,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let InputBytes::File(file) = bytes else {
            return Err(super::arrays::no_pipe("a .db3 recording", packed));
        };
        let pages = Pages::open(Shared::new(file))?;
        let (mut topics_table, mut messages_table) = (None, None);
        let mut schema = Rows::new(1);
        while schema.step(&pages).is_some() {
            let c = cells(&schema.record);
            let (Some(Cell::Bytes(name)), Some(Cell::Integer(root)), Some(Cell::Bytes(sql))) =
                (c.get(1), c.get(3), c.get(4))
            else {
                continue;
            };
            let root = u64::try_from(*root).unwrap_or(0);
            match *name {
                b"topics" => {
                    topics_table = places(sql, &["name", "type"]).map(|p| (root, p));
                }
                b"messages" => {
                    messages_table = places(sql, &["topic_id", "data"]).map(|p| (root, p));
                }
                _ => {}
            }
        }
        let (Some((topics_root, names)), Some((root, data))) = (topics_table, messages_table)
        else {
            return Err(Error::data(
                "the SQLite file is no ROS 2 recording (no tables topics and messages)",
            ));
        };
        let (mut topics, mut ids) = (Vec::new(), Vec::new());
        let mut rows = Rows::new(topics_root);
        while let Some(id) = rows.step(&pages) {
            let c = cells(&rows.record);
            let text = |k: usize| match c.get(k) {
                Some(Cell::Bytes(b)) => String::from_utf8_lossy(b).into_owned(),
                _ => String::new(),
            };
            if topics.len() < 4096 {
                topics.push(Topic {
                    name: text(names[0]),
                    kind: text(names[1]),
                    messages: Some(0),
                    is_inertial: ros::is_imu(&text(names[1])),
                });
                ids.push(id);
            }
        }
        let columns = (data[0], data[1]);
        let mut decoder = ros::Decoder::default();
        let mut firsts: Vec<Option<First>> = vec![None; ids.len()];
        let mut rows = Rows::new(root);
        while rows.step(&pages).is_some() {
            let c = cells(&rows.record);
            let Some(Cell::Integer(id)) = c.get(columns.0) else {
                continue;
            };
            let Some(i) = ids.iter().position(|x| x == id) else {
                continue;
            };
            topics[i].messages = topics[i].messages.map(|n| n + 1);
            if firsts[i].is_none()
                && topics[i].is_inertial
                && let Some(Cell::Bytes(data)) = c.get(columns.1)
            {
                firsts[i] = decoder.decode(data, Wire::Cdr).map(|m| First::of(&m));
            }
        }
        for t in &mut topics {
            t.is_inertial &= t.messages != Some(0);
        }
        let index = table::choose(&topics, options, "sensor_msgs/Imu")?;
        let (Some(topic), Some(&id)) = (topics.get(index), ids.get(index)) else {
            return Err(Error::data("the recording has no topics"));
        };
        let first = firsts.get_mut(index).and_then(Option::take);
        let first = First::or_refuse(first, topic)?;
        Ok(Self {
            layout: RawLayout {
                format: format!("ROS 2 recording, SQLite{packed}"),
                columns: table::columns("ns", first.has_gyro, first.has_accel),
                has_names: true,
                samples: topic.messages,
                topic: Some(topic.name.clone()),
                frame: Some(ros::axes(first.frame_id.as_bytes())),
                frame_id: Some(first.frame_id.clone()),
                topics: topics.clone(),
                ..RawLayout::default()
            },
            pick: first.pick(),
            decoder,
            topic: id,
            rows: Rows::new(root),
            pages,
            columns,
            plan: Plan::default(),
            bad: 0,
            told: Vec::new(),
            is_over: false,
        })
    }
}

impl RawReader for Db3 {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        table::begin(block, &self.plan);
        while !self.is_over && block.rows < table::ROWS {
            if self.rows.step(&self.pages).is_none() {
                self.is_over = true;
                let notes = &mut self.layout.notes;
                notes.clone_from(&self.told);
                for (n, what) in [
                    (
                        self.rows.lost_pages,
                        "pages of the database are missing or damaged",
                    ),
                    (self.rows.lost_cells, "rows of the database are damaged"),
                    (self.bad, "messages are no sensor_msgs/Imu"),
                ] {
                    if n > 0 {
                        notes.push(format!("{} {what} and were left out", grouped(n)));
                    }
                }
                break;
            }
            let c = cells(&self.rows.record);
            if c.get(self.columns.0) != Some(&Cell::Integer(self.topic)) {
                continue;
            }
            let message = match c.get(self.columns.1) {
                Some(Cell::Bytes(data)) => self.decoder.decode(data, Wire::Cdr),
                _ => None,
            };
            let Some(m) = message else {
                self.bad += 1;
                continue;
            };
            let mut row = [0.0; 6];
            for (out, &i) in row.iter_mut().zip(self.pick) {
                *out = m.values[i];
            }
            table::push(block, &self.plan, m.stamp_ns, &row);
        }
        Ok(block.rows > 0)
    }
}
