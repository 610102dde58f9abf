//! Which columns of a source are which channels: as `--columns` says, by their names, or by the format's definition.

use sagnac_model::units::{Dimension, Unit};

use super::columns::{ColumnName, ColumnUnit, Group, Role, Scale, clip, scale, time_kind};
use super::hints::{columns_place, describe, example, example_unit, triad_of, unknown_unit};
use super::raw::{Cells, RawColumn, RawLayout};
use crate::text::number::TimeKind;
use crate::{Channel, Error, Layout, Quantity, TextColumn};

/// One output column before remounting.
#[derive(Debug, Clone)]
pub(super) struct Op {
    pub(super) channel: Channel,
    pub(super) column: usize,
    pub(super) scale: Scale,
    /// Accumulated values: differences are taken.
    pub(super) accumulated: bool,
    /// No sensor's: kept as it is.
    pub(super) is_other: bool,
}

/// Column and kind of time, and the channels.
pub(super) type Chosen = (Option<(usize, TimeKind)>, Vec<Op>);

/// Adds the columns that are not named as they are, those of text where `with_text`; those that
/// cannot be are said.
pub(super) fn keep_others(
    raw: &RawLayout,
    time: Option<(usize, TimeKind)>,
    ops: &mut Vec<Op>,
    with_text: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    for (index, column) in raw.columns.iter().enumerate() {
        if column.cells == Cells::Nothing
            || column.is_text() && !with_text
            || time.is_some_and(|(at, _)| at == index)
            || ops.iter().any(|op| op.column == index)
        {
            continue;
        }
        let is_channel = Role::parse(column.name.trim()).is_some_and(|(role, _)| {
            !matches!(role, Role::Angle | Role::Speed) && !role.is_of_path()
        });
        if is_channel {
            notes.push(format!(
                "column `{}` is left out: its name is that of a channel; name it in --columns",
                clip(column.name.trim())
            ));
            continue;
        }
        let other = as_it_is(column, index, ops);
        ops.push(other);
    }
    notes
}

/// Takes the columns that are no sensor's out of the channels, to be kept as text.
pub(super) fn take_texts(raw: &RawLayout, ops: &mut Vec<Op>) -> Vec<(usize, TextColumn)> {
    let mut texts = Vec::new();
    let mut place = 0;
    ops.retain(|op| {
        if !op.is_other {
            place += 1;
            return true;
        }
        let header = match raw.columns.get(op.column) {
            Some(column) if raw.has_names => column.header.clone(),
            _ => op.channel.name.clone(),
        };
        texts.push((op.column, TextColumn { header, place }));
        false
    });
    texts
}

/// The sentence on columns of text that are neither kept nor times.
pub(super) fn say_texts(raw: &RawLayout, time: Option<(usize, TimeKind)>) -> Option<String> {
    let names: Vec<String> = raw
        .columns
        .iter()
        .enumerate()
        .filter(|(k, c)| c.is_text() && time.is_none_or(|(at, _)| at != *k))
        .map(|(k, c)| match c.name.trim() {
            "" => format!("column {k}"),
            name => name.to_owned(),
        })
        .collect();
    let list = clip(&names.join(", "));
    (!names.is_empty()).then(|| format!("columns of text left out: {list}"))
}

/// Channels and their sources as `--columns` says.
pub(super) fn by_request(groups: &[Group], raw: &RawLayout) -> Result<Chosen, Error> {
    let mut time = None;
    let mut ops = Vec::new();
    for group in groups {
        let place = format!("--columns, {}", group.role.channel(group.axis));
        let sources = resolve(group, raw)?;
        for &index in &sources {
            if raw.columns.get(index).is_some_and(RawColumn::is_text)
                && group.unit != ColumnUnit::Iso
            {
                let name = describe(raw, index);
                let is_date = raw.columns.get(index).is_some_and(RawColumn::is_date);
                let advice = if is_date && group.role == Role::Time {
                    format!("it holds dates: write time={index}:iso")
                } else {
                    "name a column of numbers".to_owned()
                };
                return Err(
                    Error::data(format!("column {name} holds text, not numbers"))
                        .at(place)
                        .advise(advice),
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
        let unit = match sources.first().and_then(|&i| raw.columns.get(i)) {
            Some(column) if column.is_own_unit => own_unit(column, &unit, &place)?,
            _ => unit,
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
        return Err(Error::usage(format!("column {name} is used twice"))
            .at("--columns")
            .advise("give every channel a column of its own; columns count from 0"));
    }
    Ok((time, ops))
}

/// The unit of a column of the format's own time stamps, which the one that was asked for must not contradict.
fn own_unit(column: &RawColumn, asked: &ColumnUnit, place: &str) -> Result<ColumnUnit, Error> {
    let text = column.unit.as_deref().unwrap_or_default();
    let own = Unit::parse_scaled(text).map_err(|e| Error::data(e.to_string()))?;
    match asked {
        ColumnUnit::Unit(asked) if asked.factor() != own.factor() => Err(Error::usage(format!(
            "column `{}` holds time stamps in {text} by the file's own word, not in {}",
            clip(&column.name),
            asked.text()
        ))
        .at(place)
        .advise(format!("write :{text}, or leave the unit out"))),
        _ => Ok(ColumnUnit::Unit(own)),
    }
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
        is_other: false,
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
                .at(columns_place(raw))
                .advise("columns count from 0; name one that the log has"))
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
            .at("--columns")
            .advise(format!(
                "name three columns, or one axis: {}_x={name}",
                group.role.word()
            ))),
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
            // What was left out of an archive was said by its name.
            let bare = name.split('[').next().unwrap_or(name);
            let told = raw.notes.iter().find(|n| n.contains(&format!("`{bare}`")));
            Err(match near {
                None if told.is_some() => Error::data(format!(
                    "the log has no column `{}`: {}",
                    clip(name),
                    told.map_or("", String::as_str)
                ))
                .at(columns_place(raw))
                .advise(if told.is_some_and(|n| n.contains(" rows, not ") || n.contains(" row, not ")) {
                    "arrays are read beside one another, so that all need the same length: save those that are wanted alone"
                } else {
                    "name one that the log has"
                }),
                Some(c) => error.advise(format!("did you mean `{}`?", c.name)),
                None => error.advise("name one that the log has, or its index, counting from 0"),
            })
        }
    }
}

/// The channel of a full name: `gyro` alone is no channel, accumulated angles are for `--columns`.
fn channel_role(name: &str) -> Option<(Role, Option<usize>)> {
    Role::parse(name).filter(|(r, a)| {
        a.is_some() == r.has_axes() && !matches!(r, Role::Angle | Role::Speed) && !r.is_of_path()
    })
}

/// The channel that a column would be in lower case, where no other column has that name.
fn other_case(raw: &RawLayout, column: &RawColumn) -> Option<(Role, Option<usize>)> {
    let lower = column.name.trim().to_ascii_lowercase();
    let is_taken = raw.columns.iter().any(|c| c.name.trim() == lower);
    channel_role(&lower).filter(|_| !is_taken)
}

/// What to write for a column that is a channel but for its capitals and its unit.
pub(super) fn capital_hint(raw: &RawLayout) -> Option<String> {
    let (index, column, role) = raw
        .columns
        .iter()
        .enumerate()
        .find_map(|(k, c)| Some((k, c, other_case(raw, c)?.0)))?;
    let name = column.name.trim();
    let unit = example_unit(role);
    Some(format!(
        "write column `{}` with its unit, {} [{unit}], or name it: --columns '{}={index}:{unit}, …'",
        clip(name),
        name.to_ascii_lowercase(),
        role.channel(channel_role(&name.to_ascii_lowercase()).and_then(|r| r.1)),
    ))
}

/// Channels by the names of the columns, or by the format's own definition; the others as they are,
/// those of text where `with_text`.
pub(super) fn by_name(raw: &RawLayout, with_text: bool) -> Result<Chosen, Error> {
    let mut time = None;
    let mut ops: Vec<Op> = Vec::new();
    let mut known = 0;
    for (index, column) in raw.columns.iter().enumerate() {
        let name = column.channel.as_deref().unwrap_or(&column.name);
        let role = channel_role(name)
            .or_else(|| other_case(raw, column).filter(|_| column.unit.is_some()));
        let Some((role, axis)) = role else {
            if column.cells != Cells::Nothing && (with_text || !column.is_text()) {
                let other = as_it_is(column, index, &ops);
                ops.push(other);
            }
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
        if column.is_text() && role != Role::Time {
            return Err(
                Error::data(format!("column `{}` holds text, not numbers", column.name))
                    .at(place(raw))
                    .advise("say by --columns which column holds its numbers"),
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
                return Err(Error::data("two columns are called `time`")
                    .at(columns_place(raw))
                    .advise("name them by index with --columns, counting from 0"));
            }
            time = Some((index, TimeKind::of_factor(scale.factor)));
        } else {
            ops.push(op(role, axis, index, scale));
        }
    }
    if known == 0 {
        return Err(Error::data("no column of the log is a channel by its name")
            .at(columns_place(raw))
            .advise(
                capital_hint(raw)
                    .unwrap_or_else(|| format!("say what they are, for instance {}", example(raw))),
            ));
    }
    for (i, op) in ops.iter().enumerate() {
        let is_same = |o: &Op| o.channel.name == op.channel.name;
        if op.channel.quantity != Quantity::Other && ops[..i].iter().any(is_same) {
            return Err(Error::data(format!(
                "two columns are called `{}`",
                clip(&op.channel.name)
            ))
            .at(columns_place(raw))
            .advise("name them by index, counting from 0, for instance --columns 'time=0:s, gyro=1,2,3:rad/s'"));
        }
    }
    if ops.is_empty() {
        return Err(Error::data("the log has no channel besides time")
            .at(columns_place(raw))
            .advise(match raw.notes.first() {
                Some(note) => note.clone(),
                None => "record what the sensor measures beside the time".to_owned(),
            }));
    }
    Ok((time, ops))
}

/// Notes which channels were increments in the source.
pub(super) fn say_increments(ops: &[Op], layout: &mut Layout) {
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

/// A column that is no sensor's, kept in its own unit under a name of its own.
fn as_it_is(column: &RawColumn, index: usize, ops: &[Op]) -> Op {
    let name = match column.name.trim() {
        "" => format!("column {index}"),
        name if ops.iter().any(|op| op.channel.name == name) => {
            format!("{name} (column {index})")
        }
        name => name.to_owned(),
    };
    Op {
        channel: Channel::other(&name, column.unit.as_deref().unwrap_or_default()),
        column: index,
        scale: Scale {
            factor: 1.0,
            offset: 0.0,
            is_increment: false,
        },
        accumulated: false,
        is_other: true,
    }
}
