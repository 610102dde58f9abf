//! Reading the tables of a model file.

use super::Reader;
use super::leaf::{Expected, entries, single};
use crate::calibration::Calibration;
use crate::catalog_table::{CatalogTable, Conflict, OtherValue};
use crate::error::Error;
use crate::model::{Model, Process, ThermalTerm};
use crate::path::ParameterPath;
use crate::schema::{self, Kind, LEAVES, MOST_LISTED, MOST_POWERS, Sign};
use crate::tree::{Content, Member, Node};
use crate::units::{Dimension, clip};
use sagnac_core::{MAX_KNOTS, Output, Sensor};

const ROOT_KEYS: [&str; 10] = [
    "schema",
    "name",
    "manufacturer",
    "sample_rate",
    "reference_temperature",
    "temperature_range",
    "gyro",
    "accel",
    "calibration",
    "catalog",
];
/// A covariance of more names would be larger than any file that is read.
const MOST_NAMES: usize = 1000;

pub(super) fn root(reader: &Reader, node: &Node, model: &mut Model) -> Result<(), Error> {
    let members = reader.table(node, "")?;
    let mut name = None;
    for member in members {
        let key = member.key.as_str();
        match key {
            "schema" => schema_number(reader, member)?,
            "name" => name = Some(reader.name(&member.node)?),
            "manufacturer" => model.manufacturer = Some(reader.text(&member.node, key)?),
            "sample_rate" => {
                model.sample_rate = Some(single(
                    reader,
                    &member.node,
                    key,
                    Dimension::FREQUENCY,
                    Sign::Positive,
                )?);
            }
            "reference_temperature" => {
                model.reference_temperature = Some(single(
                    reader,
                    &member.node,
                    key,
                    Dimension::TEMPERATURE,
                    Sign::Any,
                )?);
            }
            "temperature_range" => {
                model.temperature_range_c = Some(temperature_range(reader, &member.node, key)?);
            }
            "gyro" => sensor(reader, &member.node, Sensor::Gyro, model)?,
            "accel" => sensor(reader, &member.node, Sensor::Accel, model)?,
            "calibration" => {
                for block in reader.list(&member.node, key, "[[calibration]]")? {
                    model.calibrations.push(calibration(reader, block)?);
                }
            }
            "catalog" => model.catalog = Some(catalog(reader, &member.node)?),
            _ => return Err(reader.unknown_key(member, "", &ROOT_KEYS)),
        }
    }
    match name {
        Some(name) if !name.trim().is_empty() => model.name = name,
        _ => {
            let what = "the model has no name".to_string();
            return Err(reader.in_table(
                1,
                "",
                what,
                Some("write for instance name = \"IMU 7\"".to_string()),
            ));
        }
    }
    Ok(())
}

fn schema_number(reader: &Reader, member: &Member) -> Result<(), Error> {
    let number = reader.number(&member.node, "schema")?;
    if number == 1.0 {
        return Ok(());
    }
    let what = format!("schema {number} is not known; this version reads schema 1");
    Err(reader.at_value(
        member.line,
        "schema",
        what,
        Some("write schema = 1, or leave it out".to_string()),
    ))
}

fn temperature_range(reader: &Reader, node: &Node, path: &str) -> Result<[f64; 2], Error> {
    let example = "[\"-20 degC\", \"70 degC\"]";
    let [low, high] = reader.list(node, path, example)? else {
        let what = "expected the two ends of a range".to_string();
        return Err(reader.at_value(
            node.line,
            path,
            what,
            Some(format!("write for instance {example}")),
        ));
    };
    let end = |node| {
        reader
            .quantity(node, path, Dimension::TEMPERATURE)
            .map(|(value, _)| value)
    };
    let ends = [end(low)?, end(high)?];
    if ends[0] < ends[1] && ends[0] >= -273.15 {
        return Ok(ends);
    }
    let what = "the lower end of the range is not below the upper".to_string();
    Err(reader.at_value(
        node.line,
        path,
        what,
        Some(format!("write for instance {example}")),
    ))
}

/// The text keys come first: the dimension of the resolution depends on the output.
fn sensor(reader: &Reader, node: &Node, sensor: Sensor, model: &mut Model) -> Result<(), Error> {
    let members = reader.table(node, sensor.key())?;
    model.sensors[sensor.index()].present = true;
    for member in members {
        let path = format!("{}.{}", sensor.key(), member.key);
        match member.key.as_str() {
            "technology" => {
                model.sensors[sensor.index()].technology = Some(reader.text(&member.node, &path)?);
            }
            "output" => {
                let choices = [("rate", Output::Rate), ("increment", Output::Increment)];
                model.sensors[sensor.index()].output =
                    Some(choice(reader, &member.node, &path, &choices)?);
            }
            _ => {}
        }
    }
    table(reader, members, sensor, &mut Vec::new(), model)
}

fn choice<T: Copy>(
    reader: &Reader,
    node: &Node,
    path: &str,
    choices: &[(&str, T)],
) -> Result<T, Error> {
    let text = reader.text(node, path)?;
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
        return Ok(*value);
    }
    let names: Vec<String> = choices
        .iter()
        .map(|(name, _)| format!("\"{name}\""))
        .collect();
    let what = format!("\"{}\" is not one of the choices", clip(&text));
    Err(reader.at_value(
        node.line,
        path,
        what,
        Some(format!("write {}", names.join(" or "))),
    ))
}

/// The members of `[gyro]`, `[gyro.bias]`, `[gyro.bias.instability]`…
fn table(
    reader: &Reader,
    members: &[Member],
    sensor: Sensor,
    at: &mut Vec<&'static str>,
    model: &mut Model,
) -> Result<(), Error> {
    for member in members {
        let key = member.key.as_str();
        let path = join(sensor, at, key);
        let own = |leaf: &&(usize, &schema::Leaf)| {
            leaf.1.sensors.contains(&sensor) && leaf.1.table == at.as_slice() && leaf.1.key == key
        };
        let numbered: Vec<(usize, &schema::Leaf)> = LEAVES.iter().enumerate().collect();
        if let Some((index, leaf)) = numbered
            .iter()
            .find(own)
            .filter(|(_, leaf)| leaf.kind != Kind::Listed)
        {
            leaf_values(reader, &member.node, sensor, *index, leaf, &path, model)?;
            continue;
        }
        let inner = |leaf: &&(usize, &schema::Leaf)| {
            leaf.1.sensors.contains(&sensor)
                && leaf.1.table.starts_with(at)
                && leaf.1.table.get(at.len()) == Some(&key)
        };
        if let Some((_, leaf)) = numbered.iter().find(inner) {
            let name = leaf.table[at.len()];
            at.push(name);
            if leaf.kind == Kind::Listed && leaf.table == at.as_slice() {
                listed(reader, &member.node, sensor, at, model)?;
            } else {
                if at.as_slice() == ["bias", "instability"] && member.node.table().is_none() {
                    let what = "a bias instability is either the coefficient B or the Allan minimum, and they differ".to_string();
                    let advice = "write { coefficient = \"8 deg/h\" } or { allan_minimum = \"5.3 deg/h\" }: the minimum is 0.664 times B";
                    return Err(reader.at_value(
                        member.line,
                        &path,
                        what,
                        Some(advice.to_string()),
                    ));
                }
                let inner = reader.table(&member.node, &path)?;
                table(reader, inner, sensor, at, model)?;
                spline_lengths(reader, &member.node, sensor, at, model)?;
            }
            at.pop();
            continue;
        }
        if schema::other_keys(at).contains(&key) {
            other(reader, member, sensor, at, &path, model)?;
            continue;
        }
        return Err(unknown(reader, member, sensor, at));
    }
    Ok(())
}

fn join(sensor: Sensor, at: &[&str], key: &str) -> String {
    let mut path = sensor.key().to_string();
    for part in at.iter().copied().chain([key]) {
        path.push('.');
        path.push_str(part);
    }
    path
}

fn unknown(reader: &Reader, member: &Member, sensor: Sensor, at: &[&str]) -> Error {
    let known = schema::keys_of(sensor, at);
    let table = join_table(sensor, at);
    let other = if sensor == Sensor::Gyro {
        Sensor::Accel
    } else {
        Sensor::Gyro
    };
    if schema::keys_of(other, at).contains(&member.key.as_str()) {
        let what = format!("unknown key `{}`", member.key);
        let advice = format!("`{}` belongs under [{}]", member.key, join_table(other, at));
        return reader.in_table(member.line, &table, what, Some(advice));
    }
    reader.unknown_key(member, &table, &known)
}

fn join_table(sensor: Sensor, at: &[&str]) -> String {
    std::iter::once(sensor.key())
        .chain(at.iter().copied())
        .collect::<Vec<_>>()
        .join(".")
}

fn other(
    reader: &Reader,
    member: &Member,
    sensor: Sensor,
    at: &[&str],
    path: &str,
    model: &mut Model,
) -> Result<(), Error> {
    let texts = &mut model.sensors[sensor.index()];
    let term = ThermalTerm::ALL
        .into_iter()
        .find(|term| at.first() == Some(&term.key()));
    match (member.key.as_str(), term) {
        ("temperature_range", Some(term)) => {
            texts.temperature_range_c[term.index()] =
                Some(temperature_range(reader, &member.node, path)?);
        }
        ("process", _) => {
            let choices = Process::ALL.map(|process| (process.key(), process));
            texts.process = Some(choice(reader, &member.node, path, &choices)?);
        }
        ("knots", Some(term)) => {
            texts.knots_c[term.index()] = Some(knots(reader, &member.node, path)?);
        }
        // `technology` and `output` were read before.
        _ => {}
    }
    Ok(())
}

fn knots(reader: &Reader, node: &Node, path: &str) -> Result<Vec<f64>, Error> {
    let items = reader.list(node, path, "[\"-18 degC\", \"5 degC\", \"40 degC\"]")?;
    if !(2..=MAX_KNOTS).contains(&items.len()) {
        let what = format!(
            "a spline has 2 to {MAX_KNOTS} knots, this one {}",
            items.len()
        );
        return Err(reader.at_value(node.line, path, what, None));
    }
    let knots: Vec<f64> = items
        .iter()
        .map(|item| {
            reader
                .quantity(item, path, Dimension::TEMPERATURE)
                .map(|(value, _)| value)
        })
        .collect::<Result<_, _>>()?;
    if let Some(at) = knots.windows(2).position(|pair| pair[0] >= pair[1]) {
        let what = format!("knot {} is not above the one before it", at + 2);
        return Err(reader.at_value(node.line, path, what, None));
    }
    Ok(knots)
}

fn spline_lengths(
    reader: &Reader,
    node: &Node,
    sensor: Sensor,
    at: &[&str],
    model: &Model,
) -> Result<(), Error> {
    let [term, "temperature_spline"] = at else {
        return Ok(());
    };
    let Some(term) = ThermalTerm::ALL
        .into_iter()
        .find(|candidate| candidate.key() == *term)
    else {
        return Ok(());
    };
    let knots = model.knots_c(sensor, term).map_or(0, <[f64]>::len);
    let values = members_of(node, "values")
        .and_then(Node::list)
        .map_or(0, <[Node]>::len);
    if knots == values && knots > 0 {
        return Ok(());
    }
    let what = format!("{knots} knots and {values} rows of values are given");
    Err(reader.in_table(
        node.line,
        &join_table(sensor, at),
        what,
        Some("give a row of values for each knot".to_string()),
    ))
}

fn members_of<'n>(node: &'n Node, key: &str) -> Option<&'n Node> {
    node.table()?
        .iter()
        .find(|member| member.key == key)
        .map(|member| &member.node)
}

fn leaf_values(
    reader: &Reader,
    node: &Node,
    sensor: Sensor,
    index: usize,
    leaf: &'static schema::Leaf,
    path: &str,
    model: &mut Model,
) -> Result<(), Error> {
    let base = ParameterPath::new(sensor, index, 0, None);
    if leaf.kind == Kind::Value {
        let expected = Expected {
            path,
            dimension: model.dimension(base),
            shape: leaf.shape,
            sign: leaf.sign,
        };
        store(model, base, entries(reader, node, expected)?);
        return Ok(());
    }
    let (most, what) = if leaf.kind == Kind::Powers {
        (MOST_POWERS, "powers")
    } else {
        (MAX_KNOTS, "knots")
    };
    let rows = rows(reader, node, path, most, what)?;
    for (number, row) in rows.into_iter().enumerate() {
        let base = ParameterPath::new(sensor, index, number + 1, None);
        let path = base.to_string();
        let expected = Expected {
            path: &path,
            dimension: base.dimension(),
            shape: leaf.shape,
            sign: leaf.sign,
        };
        store(model, base, entries(reader, row, expected)?);
    }
    Ok(())
}

/// The rows of a polynomial: a list. (A table of lists is refused; a row may be a table.)
fn rows<'n>(
    reader: &Reader,
    node: &'n Node,
    path: &str,
    most: usize,
    what: &str,
) -> Result<Vec<&'n Node>, Error> {
    let items = reader.list(
        node,
        path,
        "a row for each power of T - T0, from 1: [[\"0.4 deg/h/K\", \"0 deg/h/K\", \"0 deg/h/K\"]]",
    )?;
    if items.len() > most {
        return Err(reader.at_value(
            node.line,
            path,
            format!("at most {most} {what} are read, found {}", items.len()),
            None,
        ));
    }
    Ok(items.iter().collect())
}

fn store(model: &mut Model, base: ParameterPath, entries: Vec<Option<crate::entry::Entry>>) {
    for (path, entry) in base.elements().into_iter().zip(entries) {
        if let Some(entry) = entry {
            model.entries.insert(path, entry);
        }
    }
}

/// `gauss_markov`, `sinusoids`, `resonances`: a table an entry, every key of it needed.
fn listed(
    reader: &Reader,
    node: &Node,
    sensor: Sensor,
    at: &[&'static str],
    model: &mut Model,
) -> Result<(), Error> {
    let path = join_table(sensor, at);
    let items = reader.list(
        node,
        &path,
        "[{ sigma = \"3 deg/h\", correlation_time = \"300 s\" }]",
    )?;
    if items.len() > MOST_LISTED {
        return Err(reader.at_value(
            node.line,
            &path,
            format!(
                "at most {MOST_LISTED} entries are read, found {}",
                items.len()
            ),
            None,
        ));
    }
    let keys = schema::keys_of(sensor, at);
    for (number, item) in items.iter().enumerate() {
        let members = reader.table(item, &path)?;
        for member in members {
            let found = LEAVES.iter().enumerate().find(|(_, leaf)| {
                leaf.sensors.contains(&sensor) && leaf.table == at && leaf.key == member.key
            });
            let Some((index, leaf)) = found else {
                return Err(reader.unknown_key(member, &path, &keys));
            };
            let base = ParameterPath::new(sensor, index, number + 1, None);
            let name = base.to_string();
            let expected = Expected {
                path: &name,
                dimension: base.dimension(),
                shape: leaf.shape,
                sign: leaf.sign,
            };
            store(model, base, entries(reader, &member.node, expected)?);
        }
        if let Some(key) = keys
            .iter()
            .find(|key| members.iter().all(|member| member.key != **key))
        {
            let what = format!("entry {} lacks `{key}`", number + 1);
            return Err(reader.in_table(
                item.line,
                &path,
                what,
                Some(format!("an entry has {}", keys.join(", "))),
            ));
        }
    }
    Ok(())
}

fn calibration(reader: &Reader, node: &Node) -> Result<Calibration, Error> {
    const KEYS: [&str; 8] = [
        "method",
        "source",
        "frame",
        "names",
        "covariance",
        "dof",
        "held",
        "note",
    ];
    const TABLE: &str = "calibration";
    let mut block = Calibration::default();
    for member in reader.table(node, TABLE)? {
        let value = &member.node;
        match member.key.as_str() {
            "method" => block.method = reader.text(value, TABLE)?,
            "source" => block.source = Some(reader.text(value, TABLE)?),
            "frame" => block.frame = Some(reader.text(value, TABLE)?),
            "note" => block.note = Some(reader.text(value, TABLE)?),
            "names" => block.names = names(reader, value, "calibration.names")?,
            "held" => block.held = names(reader, value, "calibration.held")?,
            "dof" => block.dof = Some(reader.number(value, "calibration.dof")?),
            "covariance" => block.covariance = Some(covariance(reader, value)?),
            _ => return Err(reader.unknown_key(member, TABLE, &KEYS)),
        }
    }
    if block.method.is_empty() {
        let advice = "write for instance method = \"stations\"".to_string();
        return Err(reader.in_table(
            node.line,
            TABLE,
            "the calibration has no `method`".to_string(),
            Some(advice),
        ));
    }
    if let Some(rows) = &block.covariance
        && rows.len() != block.names.len()
    {
        let what = format!(
            "{} names and {} rows of covariance are given",
            block.names.len(),
            rows.len()
        );
        return Err(reader.in_table(
            node.line,
            TABLE,
            what,
            Some("give a row for each name".to_string()),
        ));
    }
    Ok(block)
}

fn names(reader: &Reader, node: &Node, path: &str) -> Result<Vec<String>, Error> {
    let items = reader.list(node, path, "[\"accel.bias.x\"]")?;
    if items.len() > MOST_NAMES {
        return Err(reader.at_value(
            node.line,
            path,
            format!("at most {MOST_NAMES} names are read, found {}", items.len()),
            None,
        ));
    }
    let mut names = Vec::with_capacity(items.len());
    for item in items {
        let name = reader.text(item, path)?;
        if let Err(error) = name.parse::<ParameterPath>() {
            return Err(reader.at_value(item.line, path, error.to_string(), error.advice()));
        }
        names.push(name);
    }
    Ok(names)
}

/// The lower triangle, or a full symmetric matrix of which the lower triangle is kept.
fn covariance(reader: &Reader, node: &Node) -> Result<Vec<Vec<f64>>, Error> {
    const PATH: &str = "calibration.covariance";
    let rows = reader.list(node, PATH, "[[1e-6], [0.0, 1e-6]]")?;
    if rows.len() > MOST_NAMES {
        return Err(reader.at_value(
            node.line,
            PATH,
            format!("at most {MOST_NAMES} rows are read, found {}", rows.len()),
            None,
        ));
    }
    let mut triangle = Vec::with_capacity(rows.len());
    for (i, row) in rows.iter().enumerate() {
        let items = reader.list(row, PATH, "[0.0, 1e-6]")?;
        if items.len() != i + 1 && items.len() != rows.len() {
            let what = format!(
                "row {} of the covariance has {} numbers",
                i + 1,
                items.len()
            );
            return Err(reader.at_value(
                row.line,
                PATH,
                what,
                Some("row i of the lower triangle has i numbers".to_string()),
            ));
        }
        let numbers: Vec<f64> = items
            .iter()
            .take(i + 1)
            .map(|item| reader.number(item, PATH))
            .collect::<Result<_, _>>()?;
        if numbers[i] < 0.0 {
            return Err(reader.at_value(
                row.line,
                PATH,
                format!("variance {} is negative", i + 1),
                None,
            ));
        }
        triangle.push(numbers);
    }
    Ok(triangle)
}

fn catalog(reader: &Reader, node: &Node) -> Result<CatalogTable, Error> {
    const KEYS: [&str; 5] = [
        "quality",
        "price_class",
        "price_evidence",
        "notes",
        "conflicts",
    ];
    const TABLE: &str = "catalog";
    let mut table = CatalogTable::default();
    for member in reader.table(node, TABLE)? {
        let value = &member.node;
        match member.key.as_str() {
            "quality" => table.quality = Some(reader.text(value, TABLE)?),
            "price_class" => {
                let classes = crate::catalog_table::PRICE_CLASSES.map(|class| (class, class));
                table.price_class =
                    Some(choice(reader, value, "catalog.price_class", &classes)?.to_string());
            }
            "price_evidence" => table.price_evidence = Some(reader.text(value, TABLE)?),
            "notes" => {
                for note in reader.list(value, "catalog.notes", "[\"…\"]")? {
                    table.notes.push(reader.text(note, "catalog.notes")?);
                }
            }
            "conflicts" => {
                for conflict in reader.list(
                    value,
                    "catalog.conflicts",
                    "[{ parameter = \"gyro.range\" }]",
                )? {
                    table.conflicts.push(catalog_conflict(reader, conflict)?);
                }
            }
            _ => return Err(reader.unknown_key(member, TABLE, &KEYS)),
        }
    }
    Ok(table)
}

fn catalog_conflict(reader: &Reader, node: &Node) -> Result<Conflict, Error> {
    const PATH: &str = "catalog.conflicts";
    let text_of = |node: &Node, key: &str| match members_of(node, key) {
        Some(value) => match &value.content {
            Content::Number(number) => Ok(crate::units::format_number(*number)),
            _ => reader.text(value, PATH),
        },
        None => Ok(String::new()),
    };
    let mut others = Vec::new();
    if let Some(list) = members_of(node, "others") {
        for other in reader.list(
            list,
            PATH,
            "[{ value = \"1\", unit = \"deg/h\", source = \"…\" }]",
        )? {
            others.push(OtherValue {
                value: text_of(other, "value")?,
                unit: text_of(other, "unit")?,
                source: text_of(other, "source")?,
            });
        }
    }
    Ok(Conflict {
        parameter: text_of(node, "parameter")?,
        used: text_of(node, "used")?,
        others,
    })
}
