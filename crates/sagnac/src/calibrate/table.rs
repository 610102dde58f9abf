//! A table of stations: outputs, references of three kinds, standard errors.

use sagnac_calibrate::stations::Station;
use sagnac_calibrate::stations::reference::{
    EARTH_RATE_RAD_S, UNKNOWN_EARTH_RATE_RAD_S, body_from_navigation, tilt_sigma,
};
use sagnac_model::units::Dimension;

use super::StationsRequest;
use crate::Error;
use crate::table::Table;

pub(super) struct Read {
    pub(super) stations: Vec<Station>,
    /// Times and turns of a schedule, a row a station; empty for a table of outputs.
    pub(super) timing: Vec<Timing>,
    pub(super) notes: Vec<String>,
}

/// Where the outputs of a row are to be found in a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing {
    /// Start and end on the log's clock \[s\], where the schedule says so.
    pub(super) span_s: Option<[f64; 2]>,
    /// Whether it is a turn by a known angle: its accelerometer outputs are not used.
    pub(super) is_turn: bool,
    /// Whether the specific force has to come from the accelerometer.
    pub(super) needs_f: bool,
}

/// Whether a table holds outputs, or says where a log does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    Outputs,
    Schedule,
}

type Cells = Vec<Option<f64>>;

fn single(table: &Table, name: &str, dimension: Dimension) -> Result<Option<Cells>, Error> {
    table
        .column(name)
        .map(|column| table.quantity(column, dimension))
        .transpose()
}

/// Three columns, or none; a row has all three or none.
fn triad(
    table: &Table,
    names: &[String; 3],
    dimension: Dimension,
) -> Result<Option<Vec<Option<[f64; 3]>>>, Error> {
    let mut columns = Vec::new();
    for name in names {
        columns.push(single(table, name, dimension)?);
    }
    if columns.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut found = Vec::new();
    for (column, name) in columns.into_iter().zip(names) {
        found.push(column.ok_or_else(|| {
            Error::data(format!("column `{name}` is missing"))
                .at(format!("{}, line 1", table.label))
                .advise(format!("give all of {}", names.join(", ")))
        })?);
    }
    let mut out = Vec::with_capacity(table.rows());
    for (row, line) in table.lines.iter().enumerate() {
        let cells = [found[0][row], found[1][row], found[2][row]];
        out.push(match cells {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            [None, None, None] => None,
            _ => {
                return Err(Error::data(format!(
                    "{} has an axis without a value",
                    names.join(", ")
                ))
                .at(format!("{}, line {line}", table.label))
                .advise("fill in all three cells, or leave all three empty"));
            }
        });
    }
    Ok(Some(out))
}

fn xyz(before: &str, after: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| format!("{before}_{axis}{after}"))
}

/// The direction that an `up` cell names.
fn direction(text: &str) -> Option<[f64; 3]> {
    let (sign, axis) = match text.as_bytes() {
        [b'+', axis] | [axis] => (1.0, *axis),
        [b'-', axis] => (-1.0, *axis),
        _ => return None,
    };
    let k = b"xyz".iter().position(|letter| *letter == axis)?;
    let mut out = [0.0; 3];
    out[k] = sign;
    Some(out)
}

fn another_sort(table: &Table) -> Error {
    let has = |name: &str| table.column(name).is_some();
    let base = |what: &str, advice: &str| {
        Error::data(what)
            .at(table.label.clone())
            .advise(advice.to_owned())
    };
    if has("reference") && has("output") {
        return base(
            "this is a table of references and outputs, not of stations",
            "sagnac response reads it",
        );
    }
    if has("time") {
        return base(
            "this is a log: it has times and no references",
            "give --schedule with the references of each time span, or use sagnac calibrate multi-position",
        );
    }
    base(
        "the table has no reference",
        "add f_x, f_y, f_z [m/s^2], or roll, pitch [deg], or a column up with +x -x +y -y +z -z",
    )
}

/// What the references of a row come from.
struct Reference {
    f: [f64; 3],
    /// Where they come from an attitude: body from navigation, and whether the heading is known.
    attitude: Option<([[f64; 3]; 3], bool)>,
    by_up: bool,
}

pub(super) fn read(
    table: &Table,
    sort: Sort,
    request: &StationsRequest,
    gravity: f64,
) -> Result<Read, Error> {
    let (ra, ro) = (Dimension::ACCELERATION, Dimension::ANGULAR_RATE);
    let f = triad(table, &xyz("f", ""), ra)?;
    let roll = single(table, "roll", Dimension::ANGLE)?;
    let pitch = single(table, "pitch", Dimension::ANGLE)?;
    let heading = single(table, "heading", Dimension::ANGLE)?;
    let up = table.column("up");
    let angle = match sort {
        Sort::Schedule => triad(table, &xyz("angle", ""), Dimension::ANGLE)?,
        Sort::Outputs => None,
    };
    if f.is_none() && up.is_none() && (roll.is_none() || pitch.is_none()) && angle.is_none() {
        return Err(another_sort(table));
    }
    let accel = triad(table, &xyz("accel", ""), ra)?;
    let gyro = triad(table, &xyz("gyro", ""), ro)?;
    let filled =
        |cells: &Option<Vec<Option<[f64; 3]>>>| cells.iter().flatten().any(Option::is_some);
    let has_outputs = filled(&accel) || filled(&gyro);
    if sort == Sort::Outputs && !has_outputs && (accel.is_some() || gyro.is_some()) {
        return Err(Error::data("the outputs of all stations are empty")
            .at(table.label.clone())
            .advise(
                "fill in what the sensor read at each: its mean over the dwell in the accel and gyro columns",
            ));
    }
    if sort == Sort::Outputs && !has_outputs {
        return Err(Error::data("the table has no outputs")
            .at(table.label.clone())
            .advise(
                "add columns accel_x, accel_y, accel_z [m/s^2] or gyro_x, gyro_y, gyro_z [rad/s]",
            ));
    }
    if sort == Sort::Schedule && has_outputs {
        return Err(
            Error::data("a schedule has no outputs: they come from the log")
                .at(table.label.clone())
                .advise("leave the columns out, or give the table alone, without --schedule"),
        );
    }
    let accel_se = errors_of(triad(table, &xyz("accel", "_se"), ra)?);
    let gyro_se = errors_of(triad(table, &xyz("gyro", "_se"), ro)?);
    let start = single(table, "start", Dimension::TIME)?;
    let end = single(table, "end", Dimension::TIME)?;
    let w = triad(table, &xyz("w", ""), ro)?;
    let wdot = triad(table, &xyz("wdot", ""), Dimension::ANGULAR_ACCELERATION)?;
    let turn = triad(table, &xyz("turn", ""), ro)?;
    let f_se = single(table, "f_se", ra)?;
    let w_se = single(table, "w_se", ro)?;
    let tilt_se = single(table, "tilt_se", Dimension::ANGLE)?;
    let temperature = single(table, "temperature", Dimension::TEMPERATURE)?;
    let cell = |cells: &Option<Cells>, row: usize| cells.as_ref().and_then(|c| c[row]);
    let of =
        |cells: &Option<Vec<Option<[f64; 3]>>>, row: usize| cells.as_ref().and_then(|c| c[row]);
    let text = |name: &str, row: usize| {
        table
            .column(name)
            .and_then(|c| c.cells.get(row))
            .filter(|t| !t.is_empty())
            .map(str::to_owned)
    };
    let mut out = Read {
        stations: Vec::with_capacity(table.rows()),
        timing: Vec::new(),
        notes: Vec::new(),
    };
    let mut unknown_rate = false;
    for (row, line) in table.lines.iter().enumerate() {
        let place = format!("{}, line {line}", table.label);
        let fault = |what: String, advice: &str| {
            Error::data(what)
                .at(place.clone())
                .advise(advice.to_owned())
        };
        let label = text("station", row).unwrap_or_else(|| (row + 1).to_string());
        let given = of(&f, row);
        let attitude = cell(&roll, row).zip(cell(&pitch, row));
        let upward = text("up", row);
        let kinds = [given.is_some(), attitude.is_some(), upward.is_some()]
            .iter()
            .filter(|k| **k)
            .count();
        let span_s = cell(&start, row).zip(cell(&end, row));
        let turned = of(&angle, row).filter(|a| norm(*a) > 0.0);
        if kinds > 1 || (kinds == 0 && turned.is_none()) {
            return Err(if kinds == 0 {
                fault(
                    format!("station {label} has no reference"),
                    "fill in f_x, f_y, f_z, or roll and pitch, or up",
                )
            } else {
                fault(
                    format!("station {label} has two kinds of reference"),
                    "keep one of f_x, f_y, f_z, or roll and pitch, or up",
                )
            });
        }
        if sort == Sort::Schedule {
            if let Some((start_s, end_s)) = span_s
                && end_s <= start_s
            {
                return Err(fault(
                    format!("station {label} ends at {end_s} s, before it starts at {start_s} s"),
                    "write start and end in seconds of the log's clock",
                ));
            }
            if turned.is_some() && span_s.is_none() {
                return Err(fault(
                    format!("station {label} has an angle and no start and end"),
                    "add the columns start [s] and end [s]: a turn is not found by itself",
                ));
            }
            out.timing.push(Timing {
                span_s: span_s.map(|(a, b)| [a, b]),
                is_turn: turned.is_some(),
                needs_f: kinds == 0,
            });
        }
        let reference = if kinds == 0 {
            Reference {
                f: [0.0; 3],
                attitude: None,
                by_up: false,
            }
        } else if let Some(f) = given {
            Reference {
                f,
                attitude: None,
                by_up: false,
            }
        } else if let Some((roll, pitch)) = attitude {
            let known = cell(&heading, row);
            let c = body_from_navigation(roll, pitch, known.unwrap_or(0.0));
            Reference {
                f: c.map(|r| -gravity * r[2]),
                attitude: Some((c, known.is_some())),
                by_up: false,
            }
        } else {
            let word = upward.unwrap_or_default();
            let d = direction(&word).ok_or_else(|| {
                fault(
                    format!("`{word}` is no direction"),
                    "write +x, -x, +y, -y, +z or -z in the column up",
                )
            })?;
            Reference {
                f: d.map(|v| gravity * v),
                attitude: None,
                by_up: true,
            }
        };
        let mut station = Station::new(&label);
        station.place = Some(place.clone());
        station.accel = of(&accel, row);
        station.gyro = of(&gyro, row);
        station.accel_se = of(&accel_se, row);
        station.gyro_se = of(&gyro_se, row);
        for (sensor, output, se, columns) in [
            ("accel", station.accel, station.accel_se, accel_se.is_some()),
            ("gyro", station.gyro, station.gyro_se, gyro_se.is_some()),
        ] {
            if columns && output.is_some() && se.is_none() {
                return Err(fault(
                    format!("station {label} has {sensor} outputs and no standard errors"),
                    "fill in the standard errors of every station, or leave the columns out",
                ));
            }
        }
        station.f = clean(reference.f, 1e-9);
        station.wdot = clean(of(&wdot, row).unwrap_or_default(), 1e-9);
        station.temperature_c = cell(&temperature, row);
        station.run = text("run", row);
        let size = norm(station.f);
        let upward = if size > 0.0 {
            station.f.map(|v| v / size)
        } else {
            [0.0; 3]
        };
        let turning = match (turned, span_s) {
            (Some(angle), Some((start_s, end_s))) => Some(angle.map(|a| a / (end_s - start_s))),
            _ => of(&turn, row).filter(|t| norm(*t) > 0.0),
        };
        if turned.is_some() && (of(&turn, row).is_some() || of(&w, row).is_some()) {
            return Err(fault(
                format!("station {label} has an angle and a rate"),
                "keep one of angle, turn and w",
            ));
        }
        let mut extra = 0.0;
        let rate = if let Some(w) = of(&w, row) {
            if turning.is_some() {
                return Err(fault(
                    format!("station {label} has both w and turn"),
                    "keep the inertial rate w, or the rate against the Earth, turn",
                ));
            }
            w
        } else if let Some(turn) = turning {
            let t = norm(turn);
            let axis = turn.map(|v| v / t);
            let along = axis.iter().zip(upward).map(|(a, b)| a * b).sum::<f64>();
            if kinds > 0 && given.is_none() && along.abs() < 1f64.to_radians().cos() {
                return Err(fault(
                    format!(
                        "station {label} turns about an axis that is not vertical, so gravity turns in the body"
                    ),
                    "turn about the vertical within 1 deg, or give f_x, f_y, f_z",
                ));
            }
            match (request.latitude_rad, reference.attitude) {
                (Some(phi), Some((c, true))) => {
                    let earth = earth_rate(&c, phi);
                    let part: f64 = earth.iter().zip(axis).map(|(a, b)| a * b).sum();
                    [0, 1, 2].map(|i| turn[i] + part * axis[i])
                }
                (Some(phi), _) if kinds > 0 && given.is_none() => {
                    let part = EARTH_RATE_RAD_S * phi.sin() * along;
                    [0, 1, 2].map(|i| turn[i] + part * axis[i])
                }
                _ => {
                    extra = UNKNOWN_EARTH_RATE_RAD_S;
                    turn
                }
            }
        } else if let (Some(phi), Some((c, true))) = (request.latitude_rad, reference.attitude) {
            earth_rate(&c, phi)
        } else {
            extra = UNKNOWN_EARTH_RATE_RAD_S;
            [0.0; 3]
        };
        unknown_rate |= extra > 0.0 && station.gyro.is_some();
        station.w = clean(rate, 1e-12);
        let tilt = cell(&tilt_se, row)
            .or(request.tilt_rad)
            .unwrap_or(if reference.by_up {
                0.5f64.to_radians()
            } else {
                0.0
            });
        let of_f = tilt_sigma(station.f, gravity.min(size), tilt);
        let of_w = tilt_sigma(station.w, norm(station.w), tilt);
        let (f_se, w_se) = (
            cell(&f_se, row).unwrap_or(0.0),
            cell(&w_se, row).unwrap_or(0.0),
        );
        if f_se < 0.0 || w_se < 0.0 || tilt < 0.0 {
            return Err(fault(
                format!("station {label}: a standard error is negative"),
                "write it as a positive number",
            ));
        }
        station.f_sigma = of_f.map(|t| (t * t + f_se * f_se).sqrt());
        station.w_sigma = of_w.map(|t| (t * t + w_se * w_se + extra * extra).sqrt());
        out.stations.push(station);
    }
    if unknown_rate {
        out.notes.push(
            "the Earth's rate is not known at every station; 15 deg/h count as a standard error of the reference rate"
                .to_owned(),
        );
    }
    Ok(out)
}

/// Columns whose cells are all empty say nothing.
fn errors_of(cells: Option<Vec<Option<[f64; 3]>>>) -> Option<Vec<Option<[f64; 3]>>> {
    cells.filter(|cells| cells.iter().any(Option::is_some))
}

fn earth_rate(c: &[[f64; 3]; 3], latitude_rad: f64) -> [f64; 3] {
    c.map(|row| EARTH_RATE_RAD_S * (row[0] * latitude_rad.cos() - row[2] * latitude_rad.sin()))
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Components too small to be meant count as zero.
fn clean(v: [f64; 3], least: f64) -> [f64; 3] {
    v.map(|v| if v.abs() < least { 0.0 } else { v })
}
