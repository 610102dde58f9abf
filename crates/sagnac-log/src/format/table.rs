//! What message and column formats share: the columns of an inertial message, the choice of a topic, values to a block.

use crate::map::raw::{Plan, RawColumn};
use crate::text::grouped;
use crate::text::number::TimeKind;
use crate::{Block, Error, ReadOptions, Topic};

/// Rows handed out at once.
pub(crate) const ROWS: usize = 1 << 13;
/// More columns than any log has.
pub(crate) const MOST_COLUMNS: usize = 4096;

/// A column that is a channel by the format's definition.
pub(crate) fn column(channel: &str, unit: &str) -> RawColumn {
    RawColumn {
        name: channel.to_owned(),
        unit: Some(unit.to_owned()),
        channel: Some(channel.to_owned()),
        ..RawColumn::default()
    }
}

/// `time` in `time_unit`, then the triads asked for in rad/s and m/s^2.
pub(crate) fn columns(time_unit: &str, has_gyro: bool, has_accel: bool) -> Vec<RawColumn> {
    let mut out = vec![column("time", time_unit)];
    for (word, unit, has) in [("gyro", "rad/s", has_gyro), ("accel", "m/s^2", has_accel)] {
        if has {
            out.extend(["x", "y", "z"].map(|a| column(&format!("{word}_{a}"), unit)));
        }
    }
    out
}

/// Adds one row: a time stamp that is a whole number, and the values of the columns after it.
#[inline]
pub(crate) fn push(block: &mut Block, plan: &Plan, time: i64, values: &[f64]) {
    if let Some((_, kind)) = plan.time {
        match (&mut block.stamps, kind) {
            (
                crate::Stamps::Nanoseconds(v),
                TimeKind::Decimal {
                    exponent: -9,
                    multiple: 1,
                },
            ) => v.push(time),
            (stamps, kind) => stamps.push(kind.of_integer(time)),
        }
    }
    for (out, &c) in block.columns.iter_mut().zip(&plan.columns) {
        out.push(match c {
            0 => time as f64,
            c => values.get(c - 1).copied().unwrap_or(f64::NAN),
        });
    }
    block.rows += 1;
}

/// An empty block of the plan's columns.
pub(crate) fn begin(block: &mut Block, plan: &Plan) {
    block.clear();
    block.columns.resize_with(plan.columns.len(), Vec::new);
}

/// Where a column's values go.
pub(crate) struct Sink<'a> {
    stamps: Option<&'a mut crate::Stamps>,
    column: Option<&'a mut Vec<f64>>,
    kind: Option<TimeKind>,
}

impl<'a> Sink<'a> {
    /// Of the plan's column `k`, where time, if wanted, is the first.
    pub(crate) fn new(block: &'a mut Block, plan: &Plan, k: usize) -> Self {
        let stamps = usize::from(plan.time.is_some());
        Self {
            stamps: (k < stamps).then_some(&mut block.stamps),
            column: block.columns.get_mut(k.wrapping_sub(stamps)),
            kind: plan.time.map(|t| t.1),
        }
    }

    #[inline]
    pub(crate) fn whole(&mut self, value: Option<i64>) {
        self.put(value, value.map_or(f64::NAN, |v| v as f64));
    }

    #[inline]
    pub(crate) fn put(&mut self, whole: Option<i64>, value: f64) {
        if let (Some(stamps), Some(kind)) = (&mut self.stamps, self.kind) {
            stamps.push(match whole {
                Some(i) => kind.of_integer(i),
                None => kind.of_float(value),
            });
        } else if let Some(column) = &mut self.column {
            column.push(value);
        }
    }
}

/// That lists are left out, and what to write instead.
pub(crate) fn lists_note(mut lists: Vec<String>) -> Option<String> {
    lists.dedup();
    lists.truncate(20);
    let lists: Vec<String> = lists.iter().map(|name| format!("`{name}`")).collect();
    (!lists.is_empty()).then(|| {
        format!(
            "lists are not read, and were left out: {}; write every axis as a column of its own",
            lists.join(", ")
        )
    })
}

/// Refuses a file of columns that has no rows, or none of numbers, with what was left out of it.
pub(crate) fn refuse_empty(rows: u64, has_no_columns: bool, notes: &[String]) -> Result<(), Error> {
    if rows == 0 {
        return Err(Error::data("the file has columns and no rows")
            .advise("look at what recorded it, or copy it again"));
    }
    if has_no_columns {
        return Err(
            Error::data("the file has no column of numbers").advise(match notes.first() {
                Some(note) => note.clone(),
                None => "look at what recorded it".to_owned(),
            }),
        );
    }
    Ok(())
}

/// That columns of no numbers are left out.
pub(crate) fn left_out_note(mut left_out: Vec<String>) -> Option<String> {
    let more = left_out.len().saturating_sub(20) as u64;
    left_out.truncate(20);
    let tail = match more {
        0 => String::new(),
        n => format!(" and {} more", grouped(n)),
    };
    let names = left_out.join(", ");
    (!names.is_empty()).then(|| format!("no columns of numbers, and left out: {names}{tail}"))
}

/// The IMU of a number: as the format counts (`IMU[1]`, `vehicle_imu/1`, where the first may stand bare), or by the names
/// that ArduPilot's older logs have (`IMU`, `IMU2`).
fn by_number(topics: &[Topic], inertial: &[usize], text: &str) -> Option<usize> {
    let named = |wanted: String| inertial.iter().copied().find(|&i| topics[i].name == wanted);
    if let Some(rest) = text.strip_prefix("IMU") {
        let k = if rest.is_empty() {
            1
        } else {
            rest.parse().ok()?
        };
        return named(format!("IMU[{}]", u32::checked_sub(k, 1)?));
    }
    let k: u32 = text.parse().ok()?;
    let is_k = |t: &Topic| {
        let bare = t.name == t.kind;
        // Of several of one kind the first may have no number: 0 of PX4, 1 of ArduPilot.
        let has = |name: String| inertial.iter().any(|&i| topics[i].name == name);
        t.name.ends_with(&format!("[{k}]"))
            || t.name.ends_with(&format!("/{k}"))
            || t.name == format!("IMU{k}")
            || (bare && k == 0 && has(format!("{}/1", t.name)))
            || (t.name == "IMU" && k == 1 && has("IMU2".to_owned()))
    };
    let found: Vec<usize> = inertial
        .iter()
        .copied()
        .filter(|&i| is_k(&topics[i]))
        .collect();
    let whole = found.iter().find(|&&i| topics[i].kind == "vehicle_imu");
    match found.as_slice() {
        [one] => Some(*one),
        _ => whole.copied(),
    }
}

/// Index of the topic to read: the one asked for, or the only inertial one.
pub(crate) fn choose(topics: &[Topic], options: &ReadOptions, what: &str) -> Result<usize, Error> {
    let inertial: Vec<usize> = (0..topics.len())
        .filter(|&i| topics[i].is_inertial)
        .collect();
    let list = |which: &[usize]| {
        let mut text: Vec<&str> = which
            .iter()
            .take(20)
            .map(|&i| topics[i].name.as_str())
            .collect();
        if which.len() > 20 {
            text.push("…");
        }
        text.join(", ")
    };
    if let Some(name) = options.topic.as_deref() {
        let same = |t: &Topic| t.name == name || t.name.strip_prefix('/') == Some(name);
        let found = inertial
            .iter()
            .copied()
            .find(|&i| same(&topics[i]))
            .or_else(|| topics.iter().position(same))
            .or_else(|| by_number(topics, &inertial, name));
        let offer = if inertial.is_empty() {
            let all: Vec<usize> = (0..topics.len()).collect();
            format!("it has no inertial topic; it holds {}", list(&all))
        } else {
            format!("inertial topics of the log: {}", list(&inertial))
        };
        return match found {
            Some(i) if topics[i].is_inertial => Ok(i),
            Some(i) => Err(Error::data(format!(
                "`{name}` is of type {}, not {what}",
                crate::map::columns::clip(&topics[i].kind)
            ))
            .at("--topic")
            .advise(offer)),
            None => Err(Error::data(format!("the log has no topic `{name}`"))
                .at("--topic")
                .advise(offer)),
        };
    }
    match inertial.as_slice() {
        [one] => Ok(*one),
        [] => {
            let all: Vec<usize> = (0..topics.len()).collect();
            let what = what.strip_prefix("an ").unwrap_or(what);
            let error = Error::data(format!("the log has no {what}"));
            Err(if all.is_empty() {
                error.advise(
                    "it holds no message at all: look at what recorded it, or copy it again",
                )
            } else {
                error.advise(format!("it holds {}; name a log that has one", list(&all)))
            })
        }
        [first, ..] if options.any_topic => Ok(*first),
        [first, ..] => Err(Error::data(format!(
            "the log has {} inertial topics: {}",
            inertial.len(),
            list(&inertial)
        ))
        .at("--topic")
        .advise(format!(
            "choose one, for instance --topic {}",
            topics[*first].name
        ))),
    }
}
