//! KITTI oxts folders: a text file of 30 numbers a sample, and `timestamps.txt` with their dates.
//!
//! Numbers 12–14 are ax, ay, az [m/s²], 18–20 wx, wy, wz [rad/s], x forward, y left, z up. Source: the folder's own
//! `dataformat.txt`.

use std::io::Read;

use super::table;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::text::grouped;
use crate::text::iso;
use crate::{Block, Error, Folder};

/// A line of 30 numbers is some hundred bytes.
const LARGEST: u64 = 4096;
/// Dates of more samples than a folder of files holds.
const LARGEST_DATES: u64 = 1 << 28;
/// Places of the values in a line.
const PLACES: [usize; 6] = [17, 18, 19, 11, 12, 13];

/// A folder as a log.
pub(crate) struct Oxts {
    layout: RawLayout,
    folder: Box<dyn Folder>,
    /// Name and date of every sample.
    samples: std::vec::IntoIter<(String, i64)>,
    plan: Plan,
}

/// The number in a name such as `oxts/data/0000000007.txt`.
fn number(name: &str) -> Option<usize> {
    let file = name.rsplit('/').next()?;
    let stem = file.strip_suffix(".txt")?;
    (!stem.is_empty() && stem.bytes().all(|b| b.is_ascii_digit()))
        .then(|| stem.parse().ok())
        .flatten()
}

impl Oxts {
    pub(crate) fn open(folder: Box<dyn Folder>) -> Result<Self, Error> {
        let names = folder.names().map_err(Error::read)?;
        let of_part = |part: &str| {
            let wanted = format!("{part}timestamps.txt");
            names
                .iter()
                .filter(|n| **n == wanted || n.ends_with(&format!("/{wanted}")))
                .collect::<Vec<_>>()
        };
        // The folder itself, or that of a drive, beside those of the cameras.
        let dates = match (
            names.iter().find(|n| *n == "timestamps.txt"),
            &of_part("oxts/")[..],
        ) {
            (Some(own), _) => own,
            (None, [one]) => *one,
            (None, [first, ..]) => {
                let folder = first.strip_suffix("timestamps.txt").unwrap_or("");
                return Err(
                    Error::data("the folder holds several KITTI drives").advise(format!(
                        "name one of them, for instance its folder {folder}"
                    )),
                );
            }
            (None, []) => {
                return Err(Error::data(
                    "the folder is neither of KITTI (no oxts/timestamps.txt) nor of a ROS 2 recording",
                )
                .advise("name the log's file in it"));
            }
        };
        let prefix = dates.strip_suffix("timestamps.txt").unwrap_or("");
        let files: Vec<(usize, &String)> = names
            .iter()
            .filter(|n| n.starts_with(prefix) && n[prefix.len()..].starts_with("data/"))
            .filter_map(|n| Some((number(n)?, n)))
            .collect();
        if files.is_empty() {
            return Err(
                Error::data("the oxts folder holds no samples (data/0000000000.txt)")
                    .advise("unpack or copy the drive again"),
            );
        }
        let mut text = String::new();
        folder
            .open(dates)
            .and_then(|f| f.take(LARGEST_DATES).read_to_string(&mut text))
            .map_err(|e| Error::read(e).at(dates.clone()))?;
        let stamps: Vec<Option<i64>> = text
            .lines()
            .map(|line| iso::parse(line.trim().as_bytes()))
            .collect();
        let mut samples = Vec::new();
        let mut undated = 0;
        for (i, name) in files {
            match stamps.get(i).copied().flatten() {
                Some(ns) => samples.push((name.clone(), ns)),
                None => undated += 1,
            }
        }
        let mut notes = Vec::new();
        let without = stamps.len().saturating_sub(samples.len()) as u64;
        if without > 0 {
            notes.push(format!(
                "{} dates have no sample in the folder",
                grouped(without)
            ));
        }
        if undated > 0 {
            notes.push(format!(
                "{} samples have no date and were left out",
                grouped(undated)
            ));
        }
        if samples.is_empty() {
            return Err(
                Error::data("no sample of the oxts folder has a date in timestamps.txt")
                    .advise("unpack or copy the drive again"),
            );
        }
        Ok(Self {
            layout: RawLayout {
                format: "KITTI oxts folder".to_owned(),
                columns: table::columns("ns", true, true),
                has_names: true,
                samples: Some(samples.len() as u64),
                frame: Some("vehicle, x forward, y left, z up (FLU)".to_owned()),
                notes,
                ..RawLayout::default()
            },
            folder,
            samples: samples.into_iter(),
            plan: Plan::default(),
        })
    }
}

impl RawReader for Oxts {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        table::begin(block, &self.plan);
        while block.rows < table::ROWS {
            let Some((name, ns)) = self.samples.next() else {
                break;
            };
            let mut text = String::new();
            self.folder
                .open(&name)
                .and_then(|f| f.take(LARGEST).read_to_string(&mut text))
                .map_err(|e| Error::read(e).at(name.clone()))?;
            let values: Option<Vec<f64>> =
                text.split_whitespace().map(|w| w.parse().ok()).collect();
            let values = values.filter(|v| v.len() == 30).ok_or_else(|| {
                Error::data("a sample is not a line of 30 numbers").at(name.clone())
            })?;
            table::push(block, &self.plan, ns, &PLACES.map(|k| values[k]));
        }
        Ok(block.rows > 0)
    }
}
