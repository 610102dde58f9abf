//! The reader every command sees: chosen columns, SI units, remounted axes, cut to the wanted time.
//!
//! value_SI = value·factor + offset; increments are divided by dt, accumulated angles are differenced before.

use sagnac_model::units::{Dimension, Unit};

use super::axes::AxisMap;
use super::columns::{
    AXES, ColumnName, ColumnUnit, Group, Role, Scale, clip, parse, scale, time_kind,
};
use super::raw::{Plan, RawColumn, RawLayout, RawReader};
use crate::text::number::TimeKind;
use crate::{Block, Channel, Error, Layout, LogReader, Quantity, ReadOptions, Stamp};

/// One output column before remounting.
#[derive(Debug, Clone)]
struct Op {
    channel: Channel,
    column: usize,
    scale: Scale,
    /// Accumulated values: differences are taken.
    accumulated: bool,
}

/// Column and kind of time, and the channels.
type Chosen = (Option<(usize, TimeKind)>, Vec<Op>);

/// A format's columns as channels in SI.
pub(crate) struct Mapped {
    raw: Box<dyn RawReader>,
    layout: Layout,
    ops: Vec<Op>,
    /// Output k is `sign` times column `from` of the scaled block.
    mount: Vec<(usize, f64)>,
    label: String,
    start_s: Option<f64>,
    end_s: Option<f64>,
    first: Option<Stamp>,
    /// Last accumulated value of each op; `None` before the first row.
    last: Option<Vec<f64>>,
    rows_seen: u64,
    rows_kept: u64,
    done: bool,
    scratch: Block,
    own_notes: Vec<String>,
}

impl Mapped {
    pub(crate) fn new(
        mut raw: Box<dyn RawReader>,
        options: &ReadOptions,
        label: &str,
    ) -> Result<Self, Error> {
        if let Some(rate) = options.rate_hz
            && !(1e-6..=1e12).contains(&rate)
        {
            return Err(
                Error::usage("the rate must lie between 1e-6 Hz and 1e12 Hz")
                    .at("--rate")
                    .advise("write for instance --rate 200Hz"),
            );
        }
        if let (Some(start), Some(end)) = (options.start_s, options.end_s)
            && start >= end
        {
            return Err(Error::usage("the end comes before the start")
                .at("--start, --end")
                .advise("both count from the first sample, for instance --start 30s --end 2h"));
        }
        let axes = options.axes.as_deref().map(AxisMap::parse).transpose()?;
        let (time, ops) = match options.columns.as_deref() {
            Some(text) => by_request(&parse(text)?, raw.raw())?,
            None => by_name(raw.raw())?,
        };
        let found = raw.raw().clone();
        if time.is_none() && options.rate_hz.is_none() && found.rate_hz.is_none() {
            return Err(Error::data("the log has no time and no rate")
                .at(columns_place(&found))
                .advise("add --rate, for instance --rate 100Hz"));
        }
        let plan = Plan {
            time,
            columns: ops.iter().map(|o| o.column).collect(),
        };
        raw.select(plan)?;
        let mut layout = Layout {
            format: found.format,
            channels: ops.iter().map(|o| o.channel.clone()).collect(),
            has_time: time.is_some(),
            rate_hz: options.rate_hz.or(found.rate_hz),
            time_unit_s: time.and_then(|(_, kind)| kind.unit_s()),
            topics: found.topics,
            topic: found.topic,
            frame: found.frame,
            samples: found.samples,
            notes: Vec::new(),
        };
        say_increments(&ops, &mut layout);
        let mount = match axes {
            Some(map) => remount(&map, &mut layout)?,
            None => (0..ops.len()).map(|k| (k, 1.0)).collect(),
        };
        if let Some(rate) = layout.rate_hz {
            for c in &mut layout.channels {
                c.is_increment = false;
            }
            if !(rate.is_finite() && rate > 0.0) {
                return Err(Error::data("the rate that the log states is not positive").at(label));
            }
        }
        let mut mapped = Self {
            raw,
            layout,
            ops,
            mount,
            label: label.to_owned(),
            start_s: options.start_s,
            end_s: options.end_s,
            first: None,
            last: None,
            rows_seen: 0,
            rows_kept: 0,
            done: false,
            scratch: Block::default(),
            own_notes: Vec::new(),
        };
        mapped.own_notes.clone_from(&mapped.layout.notes);
        mapped.refresh_notes();
        Ok(mapped)
    }

    fn refresh_notes(&mut self) {
        self.layout.notes.clone_from(&self.raw.raw().notes);
        self.layout.notes.extend_from_slice(&self.own_notes);
    }

    /// Scales the raw block and takes differences of accumulated columns.
    fn scale(&mut self, block: &mut Block) {
        let dt = self.layout.rate_hz.map(|r| 1.0 / r);
        let first_block = self.last.is_none();
        let mut last = self
            .last
            .take()
            .unwrap_or_else(|| vec![f64::NAN; self.ops.len()]);
        let any_accumulated = self.ops.iter().any(|o| o.accumulated);
        for ((op, column), last) in self.ops.iter().zip(&mut block.columns).zip(&mut last) {
            let Scale { factor, offset, .. } = op.scale;
            if factor != 1.0 || offset != 0.0 {
                for v in column.iter_mut() {
                    *v = *v * factor + offset;
                }
            }
            if op.accumulated {
                for v in column.iter_mut() {
                    let now = *v;
                    *v = now - *last;
                    *last = now;
                }
            }
            if let (true, Some(dt)) = (op.channel.from_increments, dt) {
                for v in column.iter_mut() {
                    *v /= dt;
                }
            }
        }
        if first_block && any_accumulated && block.rows > 0 {
            block.keep(1..block.rows);
        }
        self.last = Some(last);
    }

    /// Cuts the block to `--start` and `--end`; true where nothing later can be wanted.
    fn cut(&mut self, block: &mut Block) -> bool {
        let seen = self.rows_seen;
        self.rows_seen += block.rows as u64;
        if self.start_s.is_none() && self.end_s.is_none() || block.rows == 0 {
            return false;
        }
        let start = self.start_s.unwrap_or(f64::NEG_INFINITY);
        let end = self.end_s.unwrap_or(f64::INFINITY);
        let times: Vec<f64> = if block.stamps.is_empty() {
            let rate = self.layout.rate_hz.unwrap_or(f64::NAN);
            (0..block.rows as u64)
                .map(|k| (seen + k) as f64 / rate)
                .collect()
        } else {
            let origin = *self
                .first
                .get_or_insert_with(|| block.stamps.get(0).unwrap_or(Stamp::Seconds(0.0)));
            block.stamps.since(origin)
        };
        // A time that is no number belongs to its neighbors.
        let wanted: Vec<bool> = times
            .iter()
            .map(|&t| t.is_nan() || (t >= start && t < end))
            .collect();
        if wanted.iter().all(|&w| w) {
            return false;
        }
        block.filter(&wanted);
        times.iter().all(|&t| t >= end)
    }
}

impl LogReader for Mapped {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn read_block(&mut self, block: &mut Block) -> Result<bool, Error> {
        block.clear();
        let mut scratch = std::mem::take(&mut self.scratch);
        while !self.done {
            let more = self
                .raw
                .read_raw(&mut scratch)
                .map_err(|e| e.in_source(&self.label));
            let more = match more {
                Ok(more) => more,
                Err(e) => {
                    self.done = true;
                    return Err(e);
                }
            };
            if !more {
                self.done = true;
                self.refresh_notes();
                break;
            }
            self.scale(&mut scratch);
            if self.cut(&mut scratch) {
                self.done = true;
                self.refresh_notes();
            }
            if scratch.rows == 0 {
                continue;
            }
            self.rows_kept += scratch.rows as u64;
            block.rows = scratch.rows;
            std::mem::swap(&mut block.stamps, &mut scratch.stamps);
            let columns = &mut scratch.columns;
            block.columns.resize_with(self.mount.len(), Vec::new);
            for (out, &(from, sign)) in block.columns.iter_mut().zip(&self.mount) {
                // Every source is used once: its memory moves on.
                std::mem::swap(out, &mut columns[from]);
                if sign < 0.0 {
                    for v in out.iter_mut() {
                        *v = -*v;
                    }
                }
            }
            self.scratch = scratch;
            return Ok(true);
        }
        if self.rows_kept == 0
            && self.rows_seen > 0
            && (self.start_s.is_some() || self.end_s.is_some())
        {
            let what = format!(
                "no sample lies between --start and --end; the log has {} samples",
                self.rows_seen
            );
            return Err(Error::data(what)
                .at(self.label.clone())
                .advise("both count from the first sample"));
        }
        self.scratch = scratch;
        Ok(false)
    }
}

/// Channels and their sources as `--columns` says.
fn by_request(groups: &[Group], raw: &RawLayout) -> Result<Chosen, Error> {
    let mut time = None;
    let mut ops = Vec::new();
    for group in groups {
        let place = format!("--columns, {}", group.role.channel(group.axis));
        let sources = resolve(group, raw)?;
        for &index in &sources {
            if raw.columns.get(index).is_some_and(|c| c.is_text) && group.unit != ColumnUnit::Iso {
                let name = describe(raw, index);
                return Err(
                    Error::data(format!("column {name} holds text, not numbers")).at(place),
                );
            }
        }
        let unit = match (
            &group.unit,
            sources.first().and_then(|&i| raw.columns.get(i)),
        ) {
            (
                ColumnUnit::Missing,
                Some(RawColumn {
                    unit: Some(text), ..
                }),
            ) => ColumnUnit::Unit(
                Unit::parse_scaled(text)
                    .map_err(|e| unknown_unit(raw, group.role, &sources, &e.to_string()))?,
            ),
            (unit, _) => unit.clone(),
        };
        if group.role == Role::Time {
            let kind = time_kind(&unit).map_err(|e| e.at(place))?;
            time = sources.first().map(|&i| (i, kind));
            continue;
        }
        let unit = match unit {
            ColumnUnit::Missing if group.role == Role::Quaternion => {
                ColumnUnit::Unit(Unit::si(Dimension::RATIO))
            }
            unit => unit,
        };
        let ColumnUnit::Unit(unit) = unit else {
            return Err(unknown_unit(
                raw,
                group.role,
                &sources,
                "the unit is missing",
            ));
        };
        let scale = scale(group.role, &unit).map_err(|e| e.at(place))?;
        let axes: Vec<Option<usize>> = match group.axis {
            None if group.role.has_axes() => (0..group.role.axes().len()).map(Some).collect(),
            axis => vec![axis],
        };
        for (axis, &column) in axes.into_iter().zip(&sources) {
            ops.push(op(group.role, axis, column, scale));
        }
    }
    if ops.is_empty() {
        return Err(Error::usage("no channel besides time is named")
            .at("--columns")
            .advise("write for instance --columns 'time=0:s, gyro=1,2,3:deg/s'"));
    }
    // Two channels of one source column would share its memory.
    let mut used: Vec<usize> = ops
        .iter()
        .map(|o| o.column)
        .chain(time.map(|t| t.0))
        .collect();
    used.sort_unstable();
    if let Some(pair) = used.windows(2).find(|w| w[0] == w[1]) {
        let name = describe(raw, pair[0]);
        return Err(Error::usage(format!("column {name} is used twice")).at("--columns"));
    }
    Ok((time, ops))
}

fn op(role: Role, axis: Option<usize>, column: usize, scale: Scale) -> Op {
    let accumulated = matches!(role, Role::Angle | Role::Speed);
    let is_increment = scale.is_increment || accumulated;
    let channel = if role.is_of_path() {
        Channel::other(&role.channel(axis), &role.dimensions().0.si_unit())
    } else {
        Channel {
            is_increment,
            from_increments: is_increment,
            ..Channel::named(&role.channel(axis))
        }
    };
    Op {
        channel,
        column,
        scale,
        accumulated,
    }
}

/// Indices of a group's columns.
fn resolve(group: &Group, raw: &RawLayout) -> Result<Vec<usize>, Error> {
    let one = |name: &ColumnName| -> Result<usize, Error> {
        match name {
            ColumnName::Index(i) => {
                if *i < raw.columns.len() {
                    return Ok(*i);
                }
                // A header may well be called "3".
                if let Ok(i) = find(raw, &i.to_string()) {
                    return Ok(i);
                }
                let n = raw.columns.len();
                Err(Error::data(format!(
                    "`{}` asks for column {i}, the log has {n} columns, 0 to {}",
                    group.role.word(),
                    n.saturating_sub(1)
                ))
                .at(columns_place(raw)))
            }
            ColumnName::Name(name) => find(raw, name),
        }
    };
    let wants_three = group.role.has_axes() && group.axis.is_none();
    if let (true, [single]) = (wants_three, group.sources.as_slice()) {
        let name = single.to_string();
        for pattern in ["[#]", "_#", ".#", " #"] {
            let axes = group.role.axes();
            let names: Vec<String> = (0..axes.len())
                .map(|k| {
                    let part = if pattern == "[#]" {
                        k.to_string()
                    } else {
                        axes[k].to_owned()
                    };
                    format!("{name}{}", pattern.replace('#', &part))
                })
                .collect();
            let found: Result<Vec<usize>, Error> = names.iter().map(|n| find(raw, n)).collect();
            if let Ok(found) = found {
                if pattern == "[#]" && find(raw, &format!("{name}[{}]", axes.len())).is_ok() {
                    return Err(Error::data(format!(
                        "array `{}` has more than {} columns",
                        clip(&name),
                        if axes.len() == 3 { "three" } else { "four" }
                    ))
                    .at(columns_place(raw))
                    .advise(format!(
                        "name three of them: {}={name}[0],{name}[1],{name}[2]",
                        group.role.word()
                    )));
                }
                return Ok(found);
            }
        }
        return match one(single) {
            Ok(_) => Err(Error::usage(format!(
                "`{}` takes three columns, got 1",
                group.role.word()
            ))
            .at("--columns")),
            Err(e) => Err(e),
        };
    }
    group.sources.iter().map(one).collect()
}

fn find(raw: &RawLayout, name: &str) -> Result<usize, Error> {
    let mut hits = raw.columns.iter().enumerate().filter(|(_, c)| {
        c.name == name
            || c.unit.as_ref().is_some_and(|u| {
                name.strip_prefix(c.name.as_str())
                    .is_some_and(|r| r.trim() == format!("[{u}]"))
            })
    });
    match (hits.next(), hits.next()) {
        (Some((i, _)), None) => Ok(i),
        (Some(_), Some(_)) => Err(
            Error::data(format!("two columns are called `{}`", clip(name)))
                .at(columns_place(raw))
                .advise("name them by index, counting from 0"),
        ),
        (None, _) => {
            let error = Error::data(format!("the log has no column `{}`", clip(name)))
                .at(columns_place(raw));
            let near = raw
                .columns
                .iter()
                .find(|c| c.name.eq_ignore_ascii_case(name) || c.name.trim() == name.trim());
            Err(match near {
                Some(c) => error.advise(format!("did you mean `{}`?", c.name)),
                None => error,
            })
        }
    }
}

/// Channels by the names of the columns, or by the format's own definition.
fn by_name(raw: &RawLayout) -> Result<Chosen, Error> {
    let mut time = None;
    let mut ops: Vec<Op> = Vec::new();
    let mut known = 0;
    for (index, column) in raw.columns.iter().enumerate() {
        let name = column.channel.as_deref().unwrap_or(&column.name);
        let role = Role::parse(name).filter(|(r, a)| {
            // Only full channel names: `gyro` alone is no channel, accumulated angles are for --columns.
            a.is_some() == r.has_axes()
                && !matches!(r, Role::Angle | Role::Speed)
                && !r.is_of_path()
        });
        let Some((role, axis)) = role else {
            if column.is_text {
                continue;
            }
            let unit = column.unit.clone().unwrap_or_default();
            let channel = Channel::other(&column.name, &unit);
            ops.push(Op {
                channel,
                column: index,
                scale: Scale {
                    factor: 1.0,
                    offset: 0.0,
                    is_increment: false,
                },
                accumulated: false,
            });
            continue;
        };
        let place = |raw: &RawLayout| {
            let head = raw
                .header_place
                .clone()
                .map(|p| p + ": ")
                .unwrap_or_default();
            let unit = column
                .unit
                .as_ref()
                .map(|u| format!(" [{}]", clip(u)))
                .unwrap_or_default();
            format!("{head}{}{unit}", column.name)
        };
        let Some(text) = &column.unit else {
            let triad = triad_of(raw, role, axis, index);
            return Err(unknown_unit(raw, role, &triad, ""));
        };
        let Ok(unit) = Unit::parse_scaled(text) else {
            let (dimension, _) = role.dimensions();
            return Err(
                Error::data(format!("the unit of column `{}` is not known", column.name))
                    .at(place(raw))
                    .advise(format!(
                        "write {}, for instance {} [{}]",
                        dimension.words(),
                        column.name,
                        example_unit(role)
                    )),
            );
        };
        if column.is_text && role != Role::Time {
            return Err(
                Error::data(format!("column `{}` holds text, not numbers", column.name))
                    .at(place(raw)),
            );
        }
        let scale = scale(role, &unit).map_err(|e| {
            let advice = format!(
                "write for instance {} [{}]",
                column.name,
                example_unit(role)
            );
            Error::data(e.to_string()).at(place(raw)).advise(advice)
        })?;
        known += 1;
        if role == Role::Time {
            if time.is_some() {
                return Err(Error::data("two columns are called `time`").at(columns_place(raw)));
            }
            time = Some((index, TimeKind::of_factor(scale.factor)));
        } else {
            ops.push(op(role, axis, index, scale));
        }
    }
    if known == 0 {
        return Err(Error::data("no column of the log is a channel by its name")
            .at(columns_place(raw))
            .advise("say what they are, for instance --columns 'time=0:s, gyro=1,2,3:deg/s, accel=4,5,6:g'"));
    }
    for (i, op) in ops.iter().enumerate() {
        if ops[..i].iter().any(|o| o.channel.name == op.channel.name) {
            return Err(Error::data(format!(
                "two columns are called `{}`",
                clip(&op.channel.name)
            ))
            .at(columns_place(raw))
            .advise("name them by index, counting from 0, for instance --columns 'time=0:s, gyro=1,2,3:rad/s'"));
        }
    }
    if ops.is_empty() {
        return Err(Error::data("the log has no channel besides time").at(columns_place(raw)));
    }
    Ok((time, ops))
}

fn example_unit(role: Role) -> &'static str {
    match role {
        Role::Time => "s",
        Role::Gyro => "deg/s",
        Role::Accel => "m/s^2",
        Role::GyroRate => "rad/s^2",
        Role::Temperature => "degC",
        Role::Angle => "rad",
        Role::Speed => "m/s",
        Role::Position | Role::Height => "m",
        Role::Quaternion => "1",
        Role::Latitude | Role::Longitude | Role::Roll | Role::Pitch | Role::Heading => "deg",
    }
}

/// The columns that form a triad with `index`, by their names.
fn triad_of(raw: &RawLayout, role: Role, axis: Option<usize>, index: usize) -> Vec<usize> {
    if axis.is_none() {
        return vec![index];
    }
    let all: Vec<usize> = (0..3)
        .filter_map(|k| {
            raw.columns
                .iter()
                .position(|c| c.name == role.channel(Some(k)))
        })
        .collect();
    if all.len() == 3 { all } else { vec![index] }
}

/// The error of a unit that is not known, with what the values suggest.
fn unknown_unit(raw: &RawLayout, role: Role, sources: &[usize], detail: &str) -> Error {
    let names: Vec<&str> = sources
        .iter()
        .filter_map(|&i| raw.columns.get(i))
        .map(|c| c.name.as_str())
        .collect();
    let name = names.first().copied().unwrap_or("");
    let head = raw
        .header_place
        .clone()
        .map(|p| p + ": ")
        .unwrap_or_default();
    let list = sources
        .iter()
        .map(usize::to_string)
        .collect::<Vec<_>>()
        .join(",");
    let shown = if name.is_empty() {
        format!("{}={list}", role.word())
    } else {
        format!("`{}`", clip(name))
    };
    let mut unit = example_unit(role).to_owned();
    let mut hint = String::new();
    if role == Role::Accel
        && sources.len() == 3
        && let Some(length) = mean_length(raw, sources)
    {
        let value = short(length);
        if let Some(fit) = accel_unit_that_fits(length) {
            hint = format!("|f| is {value}, as if in {fit}; ");
            fit.clone_into(&mut unit);
        } else {
            hint = format!("|f| is {value}; ");
        }
    }
    let what = match detail {
        "" | "the unit is missing" => format!("the unit of column {shown} is not known"),
        detail => format!("the unit of column {shown} is not known: {detail}"),
    };
    Error::data(what)
        .at(if names.iter().all(|n| n.is_empty()) {
            columns_place(raw)
        } else {
            format!("{head}{}", clip(&names.join(", ")))
        })
        .advise(format!(
            "{hint}name it, for instance --columns '{}={list}:{unit}'",
            role.word()
        ))
}

/// Mean length of the vectors in the first rows.
fn mean_length(raw: &RawLayout, sources: &[usize]) -> Option<f64> {
    let columns: Vec<&[f64]> = sources
        .iter()
        .filter_map(|&i| raw.columns.get(i))
        .map(|c| c.preview.as_slice())
        .collect();
    let rows = columns
        .iter()
        .map(|c| c.len())
        .min()
        .filter(|&n| n > 0 && columns.len() == 3)?;
    let lengths: Vec<f64> = (0..rows)
        .map(|k| columns.iter().map(|c| c[k] * c[k]).sum::<f64>().sqrt())
        .filter(|l| l.is_finite())
        .collect();
    (!lengths.is_empty()).then(|| lengths.iter().sum::<f64>() / lengths.len() as f64)
}

/// The unit of acceleration in which a length of `value` is near one g.
pub(crate) fn accel_unit_that_fits(value: f64) -> Option<&'static str> {
    [
        ("g", 1.0),
        ("m/s^2", 9.80665),
        ("mg", 1e3),
        ("mm/s^2", 9806.65),
        ("ug", 1e6),
        ("Gal", 980.665),
        ("mGal", 980_665.0),
        ("ft/s^2", 32.174),
    ]
    .into_iter()
    .find(|&(_, g)| (value / g - 1.0).abs() < 0.12)
    .map(|(unit, _)| unit)
}

fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        format!("{value:.3e}")
    } else {
        format!("{value:.3}")
    }
}

fn describe(raw: &RawLayout, index: usize) -> String {
    match raw.columns.get(index) {
        Some(c) if !c.name.is_empty() => format!("`{}`", clip(&c.name)),
        _ => format!("{index}"),
    }
}

/// "columns gx, gy, gz", shortened.
pub(crate) fn columns_place(raw: &RawLayout) -> String {
    let n = raw.columns.len();
    if !raw.has_names {
        return format!("{n} columns without names");
    }
    let names: Vec<String> = raw
        .columns
        .iter()
        .take(12)
        .map(|c| clip(c.name.trim()))
        .collect();
    let more = if n > 12 {
        format!(" and {} more", n - 12)
    } else {
        String::new()
    };
    format!("columns {}{more}", names.join(", "))
}

fn say_increments(ops: &[Op], layout: &mut Layout) {
    let names = |wanted: fn(&Op) -> bool| {
        let list: Vec<&str> = ops
            .iter()
            .filter(|o| wanted(o))
            .map(|o| o.channel.name.as_str())
            .collect();
        (!list.is_empty()).then(|| list.join(", "))
    };
    if let Some(list) = names(|o| o.accumulated) {
        layout.notes.push(format!(
            "{list}: accumulated values, differenced and divided by dt"
        ));
    }
    if let Some(list) = names(|o| o.channel.from_increments && !o.accumulated) {
        layout
            .notes
            .push(format!("{list}: increments, divided by dt"));
    }
}

/// Applies `--axes` to every triad.
fn remount(map: &AxisMap, layout: &mut Layout) -> Result<Vec<(usize, f64)>, Error> {
    let mut mount: Vec<(usize, f64)> = (0..layout.channels.len()).map(|k| (k, 1.0)).collect();
    let mut turned = Vec::new();
    let old = layout.channels.clone();
    for word in ["gyro", "accel", "gyro_rate"] {
        let index: Vec<Option<usize>> = AXES
            .iter()
            .map(|a| layout.index(&format!("{word}_{a}")))
            .collect();
        if index.iter().all(Option::is_none) {
            continue;
        }
        for k in 0..3 {
            match (index[k], index[map.from[k]]) {
                (Some(new), Some(from)) => {
                    mount[new] = (from, map.sign[k]);
                    let name = layout.channels[new].name.clone();
                    layout.channels[new] = Channel {
                        name,
                        ..old[from].clone()
                    };
                }
                (None, None) => {}
                _ => {
                    return Err(Error::data(format!("--axes needs all axes of {word}"))
                        .advise("the log holds only some of them; leave --axes out"));
                }
            }
        }
        turned.push(word);
    }
    if turned.is_empty() {
        return Err(Error::data(
            "--axes has nothing to turn: the log has no triad",
        ));
    }
    let mirror = if map.is_mirror() {
        "; this mirrors the axes (left-handed)"
    } else {
        ""
    };
    layout
        .notes
        .push(format!("axes turned: {}{mirror}", map.words()));
    debug_assert!(
        layout
            .channels
            .iter()
            .all(|c| c.quantity == Quantity::of(&c.name))
    );
    Ok(mount)
}
