//! What archives of named arrays share (`.npz`, MATLAB, HDF5): arrays of one length side by side are a log.
//!
//! Arrays as long as the longest are columns, `NAME[k]` (`NAME` alone where it has one); the longer side is time.

use std::io::Read;

use crate::map::columns::clip;
use crate::map::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::npy::{Header, Npy, row_size};
use crate::text::{grouped, name_and_unit};
use crate::{Block, Error};

/// Archives of more arrays are no log.
pub(super) const MOST_ARRAYS: usize = 256;

/// Arrays left out beyond these are counted alone.
const MOST_NOTES: usize = 20;

/// A stream of an array's numbers from the first on; asked for once a column where columns stand one after another.
type Open = Box<dyn Fn() -> Result<Box<dyn Read + Send>, Error> + Send>;

/// An array that the archive holds.
pub(super) struct Found {
    pub(super) name: String,
    header: Header,
    open: Open,
}

impl Found {
    pub(super) fn new(
        name: String,
        header: Header,
        open: impl Fn() -> Result<Box<dyn Read + Send>, Error> + Send + 'static,
    ) -> Self {
        let open = Box::new(open);
        Self { name, header, open }
    }
}

/// What is said of an array that cannot be columns.
pub(super) fn no_table(name: &str) -> String {
    format!(
        "array `{}` is no table of numbers and was left out",
        clip(name)
    )
}

/// Why archives are not read from a pipe.
pub(super) fn no_pipe(what: &str, packed: &str) -> Error {
    match packed.trim_start_matches(", ") {
        "" => {
            Error::data(format!("{what} cannot be read from a pipe")).advise("name the file itself")
        }
        tool => Error::data(format!("{what} is not read while it is packed by {tool}"))
            .advise(format!("unpack it first: {tool} -d FILE")),
    }
}

/// The error of an array: one whose bytes are wrong is told with what to do.
fn told(error: Error, name: &str) -> Error {
    let damaged = match &error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::InvalidData => {
            Error::data(source.to_string())
                .advise("copy the file again from where it was written; what it holds is not right")
        }
        _ => error,
    };
    damaged.at(format!("array {}", clip(name)))
}

/// An array, or one of its columns where they stand one after another.
struct Part {
    /// Which of the archive's arrays.
    array: usize,
    header: Header,
    /// Its first column in the log.
    first: usize,
    columns: usize,
    /// Bytes of the array before it.
    skip: u64,
    reader: Option<Npy>,
    /// What it has delivered and was not yet taken.
    held: Block,
    taken: usize,
    /// Columns of the block and the column of the array that each is.
    slots: Vec<(usize, usize)>,
}

/// An archive as a log.
pub(crate) struct Arrays {
    layout: RawLayout,
    found: Vec<Found>,
    parts: Vec<Part>,
    plan: Plan,
    time_part: Option<usize>,
}

impl Arrays {
    pub(super) fn new(
        format: String,
        mut found: Vec<Found>,
        mut notes: Vec<String>,
    ) -> Result<Self, Error> {
        let rows = found.iter().map(|f| f.header.shape[0]).max().unwrap_or(0);
        if rows == 0 {
            return Err(Error::data("the archive holds no array of a log"));
        }
        found.retain(|f| {
            let is_long = f.header.shape[0] == rows;
            if !is_long {
                notes.push(format!(
                    "array `{}` has {} row{}, not {}, and was left out",
                    clip(&f.name),
                    grouped(f.header.shape[0]),
                    if f.header.shape[0] == 1 { "" } else { "s" },
                    grouped(rows)
                ));
            }
            is_long
        });
        if notes.len() > MOST_NOTES {
            let more = notes.len() - MOST_NOTES;
            notes.truncate(MOST_NOTES);
            notes.push(format!(
                "{} further ones were left out",
                grouped(more as u64)
            ));
        }
        let (mut parts, mut columns) = (Vec::new(), Vec::new());
        for (array, Found { name, header, .. }) in found.iter().enumerate() {
            let first = columns.len();
            let n = header.fields.len();
            for (k, (field, _)) in header.fields.iter().enumerate() {
                let (field, unit) = name_and_unit(field);
                let name = match (header.is_structured, n) {
                    (true, _) => field,
                    (false, 1) => name.clone(),
                    _ => format!("{name}[{k}]"),
                };
                columns.push(RawColumn {
                    name,
                    unit,
                    ..RawColumn::default()
                });
            }
            // Columns one after another are as many parts, each read from its own place.
            let split = header.fortran && n > 1;
            for k in 0..if split { n } else { 1 } {
                let mut header = header.clone();
                let mut skip = 0;
                if split {
                    header.fields.truncate(1);
                    header.fortran = false;
                    skip = (row_size(&header) as u64)
                        .saturating_mul(rows)
                        .saturating_mul(k as u64);
                }
                parts.push(Part {
                    array,
                    columns: header.fields.len(),
                    header,
                    first: first + k,
                    skip,
                    reader: None,
                    held: Block::default(),
                    taken: 0,
                    slots: Vec::new(),
                });
            }
        }
        Ok(Self {
            layout: RawLayout {
                format,
                columns,
                has_names: true,
                samples: Some(rows),
                header_place: Some("arrays".to_owned()),
                notes,
                ..RawLayout::default()
            },
            found,
            parts,
            plan: Plan::default(),
            time_part: None,
        })
    }
}

impl Arrays {
    /// Reads every array that was wanted to its end, once.
    fn finish(&mut self) -> Result<(), Error> {
        let mut last: Vec<Option<usize>> = vec![None; self.found.len()];
        for (k, part) in self.parts.iter().enumerate() {
            let before = last[part.array].map_or(0, |k| self.parts[k].skip);
            if part.skip >= before {
                last[part.array] = Some(k);
            }
        }
        for k in last.into_iter().flatten() {
            let part = &mut self.parts[k];
            if let Some(reader) = &mut part.reader {
                reader
                    .drain()
                    .map_err(|e| told(Error::read(e), &self.found[part.array].name))?;
            }
        }
        Ok(())
    }
}

impl RawReader for Arrays {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        for part in &mut self.parts {
            let own = part.first..part.first + part.columns;
            let time = plan.time.filter(|t| own.contains(&t.0));
            part.slots = plan
                .columns
                .iter()
                .enumerate()
                .filter(|(_, c)| own.contains(c))
                .map(|(slot, &c)| (slot, c - part.first))
                .collect();
            if time.is_none() && part.slots.is_empty() {
                continue;
            }
            let mut bytes = (self.found[part.array].open)()?;
            std::io::copy(&mut bytes.by_ref().take(part.skip), &mut std::io::sink())
                .map_err(|e| told(Error::read(e), &self.found[part.array].name))?;
            let mut reader = Npy::of_array(part.header.clone(), bytes);
            reader.select(Plan {
                time: time.map(|(c, kind)| (c - part.first, kind)),
                columns: part.slots.iter().map(|s| s.1).collect(),
                ..Plan::default()
            })?;
            part.reader = Some(reader);
        }
        self.parts.retain(|a| a.reader.is_some());
        self.time_part = plan.time.and_then(|t| {
            self.parts
                .iter()
                .position(|a| (a.first..a.first + a.columns).contains(&t.0))
        });
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        super::table::begin(block, &self.plan);
        let mut n = usize::MAX;
        for part in &mut self.parts {
            if part.taken >= part.held.rows
                && let Some(reader) = &mut part.reader
            {
                part.taken = 0;
                let more = reader
                    .read_raw(&mut part.held)
                    .map_err(|e| told(e, &self.found[part.array].name))?;
                if !more {
                    self.finish()?;
                    return Ok(false);
                }
            }
            n = n.min(part.held.rows - part.taken);
        }
        if n == usize::MAX || n == 0 {
            return Ok(false);
        }
        for (i, part) in self.parts.iter_mut().enumerate() {
            let range = part.taken..part.taken + n;
            for (&(slot, _), column) in part.slots.iter().zip(&part.held.columns) {
                block.columns[slot].extend_from_slice(column.get(range.clone()).unwrap_or(&[]));
            }
            if self.time_part == Some(i) {
                for k in range {
                    if let Some(stamp) = part.held.stamps.get(k) {
                        block.stamps.push(stamp);
                    }
                }
            }
            part.taken += n;
        }
        block.rows = n;
        Ok(true)
    }
}
