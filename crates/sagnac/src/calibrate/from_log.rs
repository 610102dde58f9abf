//! Outputs of stations from a raw log: over the spans of a schedule, or over dwells that are found.

use sagnac_calibrate::schedule::{CHANNELS, Columns, Dwells, Reduced, Reduction, Span, Spans};
use sagnac_calibrate::stations::{self, Options};
use sagnac_log::{Block, LogReader};
use sagnac_report::text::general;

use super::table::Read;
use super::{FoundSpan, StationsRequest};
use crate::Error;

/// Channels of a log in the order of [`Columns`].
const NAMES: [&str; CHANNELS] = [
    "gyro_x",
    "gyro_y",
    "gyro_z",
    "accel_x",
    "accel_y",
    "accel_z",
    "temperature",
];

/// What the log is reduced to: the spans of a schedule, and where the sensor is steady.
struct Passed {
    spans: Option<Reduction>,
    steady: Reduction,
    has: [bool; CHANNELS],
}

/// Fills in outputs and standard errors from the log; returns where each station lies.
pub(super) fn fill(
    read: &mut Read,
    request: &StationsRequest,
    reader: &mut dyn LogReader,
) -> Result<Vec<FoundSpan>, Error> {
    let named = read.timing.iter().filter(|t| t.span_s.is_some()).count();
    if named != 0 && named != read.timing.len() {
        return Err(Error::data("some rows have start and end, some do not")
            .at(request.label.clone())
            .advise("fill in start [s] and end [s] in every row, or leave both columns out"));
    }
    apart(read, request)?;
    let spans: Vec<Span> = read
        .timing
        .iter()
        .filter_map(|t| {
            t.span_s.map(|[start_s, end_s]| Span {
                start_s,
                end_s,
                is_turn: t.is_turn,
            })
        })
        .collect();
    let reduced = reduce(reader, (named != 0).then(|| Spans::new(&spans)))?;
    let has = reduced.has;
    if reduced.spans.is_some() {
        read.notes.extend(unsteady(read, &reduced.steady));
    }
    let found = reduced.spans.unwrap_or(reduced.steady);
    let whole = |first: usize| (first..first + 3).all(|c| has[c]);
    if !whole(0) && !whole(3) {
        return Err(
            Error::data("the log has neither a gyro nor an accelerometer of three axes")
                .advise("name them with --columns 'gyro=1,2,3:deg/s, accel=4,5,6:g'"),
        );
    }
    if named == 0 && found.rows.len() != read.stations.len() {
        return Err(other_number(&found, read.stations.len(), &request.label));
    }
    let mut out = Vec::with_capacity(read.stations.len());
    for ((station, timing), row) in read.stations.iter_mut().zip(&read.timing).zip(&found.rows) {
        if row.samples == 0 {
            let [from, to] = found.extent_s.unwrap_or_default();
            return Err(Error::data(format!(
                "station {} from {} s to {} s holds no samples: the log runs from {} s to {} s",
                station.label,
                general(row.start_s, 8),
                general(row.end_s, 8),
                general(from, 8),
                general(to, 8)
            ))
            .at(request.label.clone())
            .advise("write start and end in seconds of the log's clock"));
        }
        let triad = |first: usize| {
            let mean = |k: usize| row.mean[first + k];
            Some([mean(0)?, mean(1)?, mean(2)?]).filter(|_| whole(first))
        };
        station.gyro = triad(0);
        station.accel = triad(3);
        station.gyro_se = found
            .standard_errors(row, 0)
            .filter(|_| station.gyro.is_some());
        station.accel_se = found
            .standard_errors(row, 3)
            .filter(|_| station.accel.is_some());
        station.temperature_c = station.temperature_c.or(row.mean[6]);
        if timing.is_turn && !timing.needs_f {
            station.accel = None;
            station.accel_se = None;
        }
        out.push((station.label.clone(), row.start_s, row.end_s));
    }
    read.notes.extend(reader.layout().notes.iter().cloned());
    if found.density2.iter().all(Option::is_none) {
        read.notes.push(
            "no dwell is long enough to tell the noise: the intervals are from the scatter"
                .to_owned(),
        );
    }
    Ok(out)
}

/// Refuses spans that share samples: a sensor is at one station at a time.
fn apart(read: &Read, request: &StationsRequest) -> Result<(), Error> {
    let mut spans: Vec<(&str, [f64; 2])> = read
        .stations
        .iter()
        .zip(&read.timing)
        .filter_map(|(station, timing)| Some((station.label.as_str(), timing.span_s?)))
        .collect();
    spans.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    for pair in spans.windows(2) {
        let [(one, [_, end_s]), (other, [start_s, _])] = [pair[0], pair[1]];
        // Ends that were rounded when they were written are no overlap.
        if end_s - start_s > 1e-6 * end_s.abs().max(1.0) {
            return Err(Error::data(format!(
                "station {other} starts at {} s, before station {one} ends at {} s",
                general(start_s, 8),
                general(end_s, 8)
            ))
            .at(request.label.clone())
            .advise("write spans that do not overlap, each within the rest or the steady turn of its station"));
        }
    }
    Ok(())
}

/// One pass through the log.
fn reduce(reader: &mut dyn LogReader, mut spans: Option<Spans>) -> Result<Passed, Error> {
    let mut dwells: Option<Dwells> = None;
    let layout = reader.layout().clone();
    let index = NAMES.map(|name| layout.index(name));
    let mut block = Block::with_columns(layout.channels.len());
    let mut row = 0_u64;
    let mut last_s = f64::NEG_INFINITY;
    let mut dt_s: Option<f64> = None;
    let mut times: Vec<f64> = Vec::new();
    while reader.read_block(&mut block)? {
        let dt_s = match dt_s {
            Some(dt_s) => dt_s,
            None => *dt_s.insert(interval(layout.rate_hz, &block)?),
        };
        times.clear();
        // Without stamps a sample carries the end of its interval.
        times.extend((0..block.rows).map(|i| {
            block.stamps.get(i).map_or(
                (row + i as u64 + 1) as f64 * dt_s,
                sagnac_log::Stamp::seconds,
            )
        }));
        row += block.rows as u64;
        for t in &times {
            if *t < last_s {
                return Err(Error::data(format!(
                    "time goes backwards from {} s to {} s",
                    general(last_s, 9),
                    general(*t, 9)
                ))
                .advise("join the parts in order, or read one with --start and --end"));
            }
            last_s = *t;
        }
        for (channel, column) in layout.channels.iter().zip(&mut block.columns) {
            if channel.is_increment {
                for v in column.iter_mut() {
                    *v /= dt_s;
                }
            }
        }
        let columns: Columns = index.map(|i| i.map(|i| block.columns[i].as_slice()));
        if let Some(spans) = &mut spans {
            spans.push(&times, &columns);
        }
        dwells
            .get_or_insert_with(|| Dwells::new(dt_s))
            .push(&times, &columns);
    }
    let steady = dwells
        .ok_or_else(|| Error::data("the log has no samples"))?
        .finish();
    Ok(Passed {
        spans: spans.map(Spans::finish),
        steady,
        has: index.map(|i| i.is_some()),
    })
}

/// What is cut at the ends of a dwell that is found, and the window by which it is told \[s\].
const NEAR_S: f64 = 0.5;

/// Says in which spans without an angle the sensor is not steady, as dwells are told: for a part, or nowhere.
fn unsteady(read: &Read, steady: &Reduction) -> Vec<String> {
    let (mut partly, mut nowhere) = (Vec::new(), Vec::new());
    for (station, timing) in read.stations.iter().zip(&read.timing) {
        let Some([start_s, end_s]) = timing
            .span_s
            .filter(|s| !timing.is_turn && s[1] - s[0] >= 1.0)
        else {
            continue;
        };
        // The parts of the span that no dwell covers.
        let mut from_s = start_s;
        let mut parts: Vec<[f64; 2]> = Vec::new();
        for dwell in &steady.rows {
            if dwell.end_s > from_s && dwell.start_s < end_s {
                if dwell.start_s - from_s > NEAR_S {
                    parts.push([from_s, dwell.start_s]);
                }
                from_s = dwell.end_s;
            }
        }
        if from_s == start_s {
            nowhere.push(station.label.clone());
            continue;
        }
        if end_s - from_s > NEAR_S {
            parts.push([from_s, end_s]);
        }
        let at = |[a, b]: &[f64; 2]| format!("{} at {a:.1}–{b:.1} s", station.label);
        partly.extend(parts.iter().map(at));
    }
    let first = |names: &[String]| {
        let more = names.len().saturating_sub(6);
        let listed = names[..names.len() - more].join(", ");
        if more > 0 {
            format!("{listed} and {more} more")
        } else {
            listed
        }
    };
    let mut out = Vec::new();
    if !partly.is_empty() {
        out.push(format!(
            "the sensor is not steady all through its station ({}): the mean is of the whole span; shorten it, or \
             give its angle if it is a turn",
            first(&partly)
        ));
    }
    if !nowhere.is_empty() {
        out.push(format!(
            "the sensor vibrates or moves all through its station ({}), more than where it is stillest: the mean of \
             the span is as good as the motion is even",
            first(&nowhere)
        ));
    }
    out
}

fn interval(rate_hz: Option<f64>, first: &Block) -> Result<f64, Error> {
    let mut steps: Vec<f64> = (1..first.rows)
        .filter_map(|k| Some(first.stamps.get(k)?.since(first.stamps.get(k - 1)?)))
        .filter(|step| *step > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    rate_hz
        .map(|rate| 1.0 / rate)
        .or(steps.get(steps.len() / 2).copied())
        .ok_or_else(|| {
            Error::data("the log has no time and no rate")
                .advise("add --rate, for instance --rate 100Hz")
        })
}

fn other_number(found: &Reduction, rows: usize, label: &str) -> Error {
    let span = |row: &Reduced| format!("{:.1}–{:.1} s", row.start_s, row.end_s);
    let mut list: Vec<String> = found.rows.iter().take(8).map(span).collect();
    if found.rows.len() > 8 {
        list.push("…".to_owned());
    }
    let at = if list.is_empty() {
        String::new()
    } else {
        format!(" (at {})", list.join(", "))
    };
    Error::data(format!(
        "found {} dwells{at}, the schedule has {rows}",
        found.rows.len()
    ))
    .at(label.to_owned())
    .advise("add columns start [s] and end [s] to the schedule, or write a row for every dwell")
    .with_found(serde_json::json!({
        "stations": found.rows.iter().zip(1..).map(|(row, number)| serde_json::json!({
            "station": number.to_string(), "start_s": row.start_s, "end_s": row.end_s,
        })).collect::<Vec<_>>(),
    }))
}

/// The specific force in turns that have no reference: the mean output, corrected by the calibration of the dwells.
pub(super) fn force_in_turns(read: &mut Read, options: &Options, label: &str) -> Result<(), Error> {
    if !read.timing.iter().any(|t| t.needs_f) {
        return Ok(());
    }
    let at_rest: Vec<_> = read
        .stations
        .iter()
        .zip(&read.timing)
        .filter(|(_, t)| !t.is_turn)
        .map(|(s, _)| stations::Station {
            gyro: None,
            gyro_se: None,
            ..s.clone()
        })
        .filter(|s| s.accel.is_some())
        .collect();
    let advice = "give f_x, f_y, f_z or up in every row with an angle, or add dwells with each axis up and down";
    if at_rest.is_empty() {
        return Err(Error::data(
            "the specific force in the turns is not known: no dwell has an accelerometer",
        )
        .at(label.to_owned())
        .advise(advice));
    }
    let found = super::regress(&at_rest, options, label).map_err(|error| {
        let why = error.what.clone();
        Error::data(format!(
            "the specific force in the turns is not known: {why}"
        ))
        .at(label.to_owned())
        .advise(advice)
    })?;
    for (station, timing) in read.stations.iter_mut().zip(&read.timing) {
        if timing.needs_f
            && let Some(output) = station.accel.take()
        {
            station.f = found.specific_force(output, station, options);
            station.accel_se = None;
        }
    }
    Ok(())
}
