//! Keys that exclude or need one another, and why.

use super::Reader;
use crate::error::Error;
use crate::model::{Model, Process, ThermalTerm};
use crate::tree::{Member, Node};
use sagnac_core::{Output, Sensor};

pub(super) fn all(reader: &Reader, root: &Node, model: &Model) -> Result<(), Error> {
    for sensor in Sensor::ALL {
        let Some(table) = find(root, &[sensor.key()]) else {
            continue;
        };
        instability(reader, table, sensor, model)?;
        white_noise(reader, table, sensor)?;
        thermal(reader, table, sensor)?;
        resolution(reader, table, sensor, model)?;
    }
    Ok(())
}

/// The member under a chain of tables.
fn find<'n>(root: &'n Node, keys: &[&str]) -> Option<&'n Node> {
    let mut node = root;
    for key in keys {
        node = &member(node, key)?.node;
    }
    Some(node)
}

fn member<'n>(node: &'n Node, key: &str) -> Option<&'n Member> {
    node.table()?.iter().find(|member| member.key == key)
}

fn both(
    reader: &Reader,
    table: &Node,
    name: &str,
    first: &str,
    second: &str,
    advice: &str,
) -> Result<(), Error> {
    let (Some(a), Some(b)) = (member(table, first), member(table, second)) else {
        return Ok(());
    };
    let what = format!("both `{first}` and `{second}` are given");
    Err(reader.in_table(a.line.max(b.line), name, what, Some(advice.to_string())))
}

fn instability(reader: &Reader, table: &Node, sensor: Sensor, model: &Model) -> Result<(), Error> {
    let Some(node) = find(table, &["bias", "instability"]) else {
        return Ok(());
    };
    let name = format!("{}.bias.instability", sensor.key());
    both(
        reader,
        node,
        &name,
        "coefficient",
        "allan_minimum",
        "keep one: the Allan minimum is 0.664 times the coefficient",
    )?;
    let walk = if sensor == Sensor::Gyro {
        "rate_random_walk"
    } else {
        "acceleration_random_walk"
    };
    let process = model.process(sensor);
    let allowed: &[&str] = match process {
        Process::Flicker => &["coefficient", "allan_minimum"],
        Process::RandomWalk => &[walk],
        Process::GaussMarkov => &["sigma", "correlation_time"],
    };
    let quoted = |keys: &[&str], word: &str| {
        keys.iter()
            .map(|key| format!("`{key}`"))
            .collect::<Vec<_>>()
            .join(word)
    };
    for member in node.table().unwrap_or(&[]) {
        if member.key != "process" && !allowed.contains(&member.key.as_str()) {
            let what = format!(
                "`{}` does not belong to process \"{}\"",
                member.key,
                process.key()
            );
            let advice = format!(
                "process \"{}\" takes {}",
                process.key(),
                quoted(allowed, " or ")
            );
            return Err(reader.in_table(member.line, &name, what, Some(advice)));
        }
    }
    let given = |key: &&str| member(node, key).is_some();
    let complete = if process == Process::GaussMarkov {
        allowed.iter().all(&given)
    } else {
        allowed.iter().any(given)
    };
    if complete {
        return Ok(());
    }
    let what = format!("process \"{}\" has no number", process.key());
    let word = if process == Process::GaussMarkov {
        " and "
    } else {
        " or "
    };
    Err(reader.in_table(
        node.line,
        &name,
        what,
        Some(format!("give {}", quoted(allowed, word))),
    ))
}

fn white_noise(reader: &Reader, table: &Node, sensor: Sensor) -> Result<(), Error> {
    let Some(node) = find(table, &["noise"]) else {
        return Ok(());
    };
    let name = format!("{}.noise", sensor.key());
    let white = if sensor == Sensor::Gyro {
        "angle_random_walk"
    } else {
        "velocity_random_walk"
    };
    let advice =
        format!("keep one: `{white}` is two-sided, the one-sided density is √2 times as large");
    both(
        reader,
        node,
        &name,
        white,
        "noise_density_one_sided",
        &advice,
    )
}

/// A step of the output beyond its range leaves 0 alone.
fn resolution(reader: &Reader, table: &Node, sensor: Sensor, model: &Model) -> Result<(), Error> {
    let (Some(member), Ok(core)) = (member(table, "resolution"), model.to_core()) else {
        return Ok(());
    };
    let triad = core.triad(sensor);
    // Increments go in steps of LSB/dt; without a rate nothing is known of them.
    let (per_lsb, at) = match (triad.resolution.output, model.sample_rate_hz()) {
        (Output::Rate, _) => (1.0, ""),
        (Output::Increment, Some(rate_hz)) => (rate_hz, " at the model's sample_rate"),
        (Output::Increment, None) => return Ok(()),
    };
    let mut pairs = triad.resolution.lsb.iter().zip(&triad.range.limit);
    if pairs.any(|(lsb, limit)| lsb * per_lsb > *limit) {
        return Err(reader.in_table(
            member.line,
            sensor.key(),
            format!("the resolution is coarser than the range{at}: every output would be 0"),
            Some("look for a wrong unit in `resolution` or `range`".to_owned()),
        ));
    }
    Ok(())
}

fn thermal(reader: &Reader, table: &Node, sensor: Sensor) -> Result<(), Error> {
    for term in ThermalTerm::ALL {
        let Some(node) = find(table, &[term.key()]) else {
            continue;
        };
        let name = format!("{}.{}", sensor.key(), term.key());
        let advice = "keep one: a spline stands instead of the polynomial";
        both(
            reader,
            node,
            &name,
            "temperature",
            "temperature_spline",
            advice,
        )?;
    }
    Ok(())
}
