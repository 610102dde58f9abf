//! Reading what one key holds: one value for all axes, an array, tables that say more, or tables of arrays.

use super::Reader;
use crate::entry::Entry;
use crate::error::Error;
use crate::schema::{Shape, Sign};
use crate::tree::{Content, Node};
use crate::units::{Dimension, Unit, format_quantity};

/// The keys of a table that says more about a value.
const QUANTITIES: [&str; 5] = ["value", "sigma", "upper_limit", "lower", "upper"];
const KNOWN: [&str; 7] = [
    "value",
    "sigma",
    "upper_limit",
    "lower",
    "upper",
    "source",
    "note",
];

/// What a leaf is expected to be.
#[derive(Clone, Copy)]
pub(super) struct Expected<'a> {
    pub(super) path: &'a str,
    pub(super) dimension: Dimension,
    pub(super) shape: Shape,
    pub(super) sign: Sign,
}

/// The entries of a key, one an element; none where nothing is known of an element.
pub(super) fn entries(
    reader: &Reader,
    node: &Node,
    expected: Expected,
) -> Result<Vec<Option<Entry>>, Error> {
    if is_detail(node) {
        return detailed(reader, node, expected);
    }
    cells(reader, node, expected)?
        .into_iter()
        .map(|cell| cell.map_or(Ok(None), |cell| entry(reader, cell, expected)))
        .collect()
}

/// One value without axes, such as `sample_rate`.
pub(super) fn single(
    reader: &Reader,
    node: &Node,
    path: &str,
    dimension: Dimension,
    sign: Sign,
) -> Result<Entry, Error> {
    let expected = Expected {
        path,
        dimension,
        shape: Shape::Axes,
        sign,
    };
    if node.list().is_some() {
        return Err(wrong(reader, node, expected, "one value"));
    }
    entry(reader, node, expected)?.ok_or_else(|| wrong(reader, node, expected, "a value"))
}

/// Whether a node is a table that says more about a value, not one of elements.
fn is_detail(node: &Node) -> bool {
    node.table().is_some_and(|members| {
        members.is_empty()
            || members
                .iter()
                .any(|member| KNOWN.contains(&member.key.as_str()))
    })
}

/// `{ value = [x, y, z], sigma = … }`.
fn detailed(reader: &Reader, node: &Node, expected: Expected) -> Result<Vec<Option<Entry>>, Error> {
    let members = reader.table(node, expected.path)?;
    let count = expected.shape.suffixes().len();
    let mut found: Vec<Option<Entry>> = vec![None; count];
    let mut source = None;
    let mut note = None;
    for member in members {
        match member.key.as_str() {
            "source" => source = Some(reader.text(&member.node, expected.path)?),
            "note" => note = Some(reader.text(&member.node, expected.path)?),
            key if QUANTITIES.contains(&key) => {
                let dimension = dimension_of(key, expected.dimension);
                let cells = cells(
                    reader,
                    &member.node,
                    Expected {
                        dimension,
                        ..expected
                    },
                )?;
                for (slot, cell) in found.iter_mut().zip(cells) {
                    let Some(cell) = cell.filter(|cell| !is_detail(cell)) else {
                        continue;
                    };
                    let (value, unit) = reader.quantity(cell, expected.path, dimension)?;
                    put(slot, key, value, unit);
                }
            }
            _ => return Err(reader.unknown_key(member, expected.path, &KNOWN)),
        }
    }
    for entry in found.iter_mut().flatten() {
        entry.source.clone_from(&source);
        entry.note.clone_from(&note);
        check(reader, node, entry, expected)?;
    }
    Ok(found)
}

fn put(slot: &mut Option<Entry>, key: &str, value: f64, unit: Unit) {
    let entry = slot.get_or_insert_with(|| Entry::empty(unit.clone()));
    if key == "value" {
        entry.unit = unit;
    }
    entry.set_quantity(key, value);
}

/// σ of an absolute temperature is a difference.
fn dimension_of(key: &str, dimension: Dimension) -> Dimension {
    if key == "sigma" && dimension.is_absolute_temperature() {
        Dimension::TEMPERATURE_DIFFERENCE
    } else {
        dimension
    }
}

/// One cell: a quantity, or a table that says more; an empty table says that nothing is known.
fn entry(reader: &Reader, node: &Node, expected: Expected) -> Result<Option<Entry>, Error> {
    let Some(members) = node.table() else {
        let (value, unit) = reader.quantity(node, expected.path, expected.dimension)?;
        let entry = Entry {
            value: Some(value),
            ..Entry::empty(unit)
        };
        check(reader, node, &entry, expected)?;
        return Ok(Some(entry));
    };
    let mut slot = None;
    let mut source = None;
    let mut note = None;
    for member in members {
        match member.key.as_str() {
            "source" => source = Some(reader.text(&member.node, expected.path)?),
            "note" => note = Some(reader.text(&member.node, expected.path)?),
            key if QUANTITIES.contains(&key) => {
                let (value, unit) = reader.quantity(
                    &member.node,
                    expected.path,
                    dimension_of(key, expected.dimension),
                )?;
                put(&mut slot, key, value, unit);
            }
            _ => return Err(reader.unknown_key(member, expected.path, &KNOWN)),
        }
    }
    let Some(mut entry) = slot else {
        return Ok(None);
    };
    entry.source = source;
    entry.note = note;
    check(reader, node, &entry, expected)?;
    Ok(Some(entry))
}

/// The cells of a key in the order of its shape; a single value serves all.
fn cells<'n>(
    reader: &Reader,
    node: &'n Node,
    expected: Expected,
) -> Result<Vec<Option<&'n Node>>, Error> {
    let suffixes = expected.shape.suffixes();
    let single = || vec![Some(node); suffixes.len()];
    match (expected.shape, &node.content) {
        (Shape::Axes | Shape::Vector, Content::List(items)) => {
            row(reader, node, items, 3, expected)
        }
        (Shape::Axes, Content::Text(_) | Content::Number(_) | Content::Table(_))
        | (Shape::Elements, Content::Text(_) | Content::Number(_)) => Ok(single()),

        (Shape::Elements, Content::Table(members)) => {
            if let Some(member) = members
                .iter()
                .find(|member| !suffixes.contains(&member.key.as_str()))
            {
                return Err(reader.unknown_key(member, expected.path, suffixes));
            }
            let of = |suffix: &&str| {
                members
                    .iter()
                    .find(|member| member.key == *suffix)
                    .map(|member| &member.node)
            };
            Ok(suffixes.iter().map(of).collect())
        }
        (Shape::Matrix | Shape::Products, Content::List(rows)) => {
            if rows.len() != 3 {
                return Err(wrong(
                    reader,
                    node,
                    expected,
                    &format!("3 rows, found {}", rows.len()),
                ));
            }
            let columns = suffixes.len() / 3;
            let mut all = Vec::with_capacity(suffixes.len());
            for line in rows {
                let items = reader.list(
                    line,
                    expected.path,
                    "[\"0 deg/h/g\", \"0 deg/h/g\", \"0 deg/h/g\"]",
                )?;
                all.extend(row(reader, line, items, columns, expected)?);
            }
            Ok(all)
        }
        _ => Err(wrong(reader, node, expected, shape_words(expected.shape))),
    }
}

fn row<'n>(
    reader: &Reader,
    node: &Node,
    items: &'n [Node],
    count: usize,
    expected: Expected,
) -> Result<Vec<Option<&'n Node>>, Error> {
    if items.len() != count {
        return Err(wrong(
            reader,
            node,
            expected,
            &format!("{count} values, found {}", items.len()),
        ));
    }
    Ok(items.iter().map(Some).collect())
}

const fn shape_words(shape: Shape) -> &'static str {
    match shape {
        Shape::Axes => "one value or [x, y, z]",
        Shape::Elements => "one value or { xy, xz, yx, yz, zx, zy }",
        Shape::Matrix => "three rows of three",
        Shape::Products => "three rows of six (xx, yy, zz, xy, xz, yz)",
        Shape::Vector => "the three components [x, y, z]",
    }
}

fn wrong(reader: &Reader, node: &Node, expected: Expected, what: &str) -> Error {
    let example = expected.dimension.example();
    let advice = match expected.shape {
        Shape::Axes => format!("write for instance \"{example}\", or an array of three"),
        Shape::Elements => format!("write for instance {{ xy = \"{example}\" }}"),
        _ => format!("the rule is {}", shape_words(expected.shape)),
    };
    let got = if what.contains("found") {
        String::new()
    } else {
        format!(", got {}", node.kind())
    };
    reader.at_value(
        node.line,
        expected.path,
        format!("expected {what}{got}"),
        Some(advice),
    )
}

/// The rules that hold for every entry.
fn check(reader: &Reader, node: &Node, entry: &Entry, expected: Expected) -> Result<(), Error> {
    if let Some(problem) = problem_of(entry, expected.sign, expected.dimension) {
        let advice = match expected.sign {
            Sign::Any => None,
            Sign::NotNegative => {
                Some("a density, deviation or width has no sign: write it without the minus")
            }
            Sign::Positive => Some("write a positive value, or leave out what the sensor has not"),
            Sign::Fraction => Some("write a damping ratio, for instance 0.1"),
        };
        let is_of_sign = problem.starts_with("the value must");
        let advice = advice.filter(|_| is_of_sign).map(str::to_owned);
        return Err(reader.at_value(node.line, expected.path, problem, advice));
    }
    Ok(())
}

/// What is wrong with an entry, if anything.
pub(crate) fn problem_of(entry: &Entry, sign: Sign, dimension: Dimension) -> Option<String> {
    if entry
        .quantities()
        .iter()
        .any(|(_, value)| value.is_some_and(|value| !value.is_finite()))
    {
        return Some("the value is not finite".to_string());
    }
    if entry.value.is_some() && entry.upper_limit.is_some() {
        return Some("both `value` and `upper_limit` are given".to_string());
    }
    if entry.value.is_none() && entry.upper_limit.is_none() {
        return Some("neither `value` nor `upper_limit` is given".to_string());
    }
    if entry.sigma.is_some_and(|sigma| sigma < 0.0) {
        return Some("`sigma` is negative".to_string());
    }
    if let (Some(lower), Some(upper)) = (entry.lower, entry.upper)
        && lower > upper
    {
        return Some("`lower` is above `upper`".to_string());
    }
    if entry.upper_limit.is_some_and(|limit| limit < 0.0) && !dimension.is_absolute_temperature() {
        return Some("`upper_limit` is negative".to_string());
    }
    let value = entry.value?;
    let problem = match sign {
        Sign::NotNegative if value < 0.0 => "the value must not be negative",
        Sign::Positive if value <= 0.0 => "the value must be above zero",
        Sign::Fraction if value <= 0.0 || value >= 1.0 => "the value must lie between 0 and 1",
        _ if dimension.is_absolute_temperature() && value < -273.15 => {
            "the temperature is below absolute zero"
        }
        _ => return None,
    };
    Some(format!(
        "{problem}, got {}",
        format_quantity(value, &entry.unit)
    ))
}
