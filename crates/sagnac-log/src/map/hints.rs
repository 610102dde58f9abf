//! What errors about columns say: where they stand, which units would fit.

use super::columns::{Role, clip};
use super::raw::{RawColumn, RawLayout};
use crate::Error;

/// A unit of the role, for advice.
pub(super) fn example_unit(role: Role) -> &'static str {
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
pub(super) fn triad_of(
    raw: &RawLayout,
    role: Role,
    axis: Option<usize>,
    index: usize,
) -> Vec<usize> {
    if axis.is_none() {
        return vec![index];
    }
    let all: Vec<usize> = (0..3)
        .filter_map(|k| {
            raw.columns
                .iter()
                .position(|c| Role::parse(c.name.trim()) == Some((role, Some(k))))
        })
        .collect();
    if all.len() == 3 { all } else { vec![index] }
}

/// The error of a unit that is not known, with what the values suggest.
pub(super) fn unknown_unit(raw: &RawLayout, role: Role, sources: &[usize], detail: &str) -> Error {
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
    let is_date = sources
        .first()
        .and_then(|&i| raw.columns.get(i))
        .is_some_and(RawColumn::is_date);
    if role == Role::Time && is_date {
        "iso".clone_into(&mut unit);
        "it holds dates; ".clone_into(&mut hint);
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

/// A list for `--columns`, with the log's own column of dates where it has one.
pub(super) fn example(raw: &RawLayout) -> String {
    let time = match raw.columns.iter().position(RawColumn::is_date) {
        Some(k) => format!("time={k}:iso"),
        None => "time=0:s".to_owned(),
    };
    format!("--columns '{time}, gyro=1,2,3:deg/s, accel=4,5,6:g'")
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

/// A column by its name, else by its number.
pub(crate) fn describe(raw: &RawLayout, index: usize) -> String {
    match raw.columns.get(index) {
        Some(c) if !c.name.is_empty() => format!("`{}`", clip(&c.name)),
        _ => format!("{index}"),
    }
}

/// "columns gx, gy, gz", shortened.
pub(crate) fn columns_place(raw: &RawLayout) -> String {
    let n = raw.columns.len();
    if !raw.has_names {
        let columns = if n == 1 { "column" } else { "columns" };
        return format!("{n} {columns} without names");
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

/// What a table without time is that other commands read, and which.
pub(crate) fn another_sort(raw: &RawLayout) -> Option<(&'static str, &'static str)> {
    let has = |name: &str| raw.columns.iter().any(|c| c.name.trim() == name);
    if has("reference") && has("output") {
        return Some((
            "a table of references and outputs",
            "sagnac response reads it",
        ));
    }
    (has("station") || has("up") || has("f_x")).then_some((
        "a table of stations",
        "sagnac calibrate stations reads it; a log has time [s], or --rate, and a row a sample",
    ))
}
