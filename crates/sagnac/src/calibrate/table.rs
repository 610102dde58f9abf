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
    pub(super) notes: Vec<String>,
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

pub(super) fn read(request: &StationsRequest, gravity: f64) -> Result<Read, Error> {
    let table = Table::parse(&request.table, &request.label)?;
    let (ra, ro) = (Dimension::ACCELERATION, Dimension::ANGULAR_RATE);
    let f = triad(&table, &xyz("f", ""), ra)?;
    let roll = single(&table, "roll", Dimension::ANGLE)?;
    let pitch = single(&table, "pitch", Dimension::ANGLE)?;
    let heading = single(&table, "heading", Dimension::ANGLE)?;
    let up = table.column("up");
    if f.is_none() && up.is_none() && (roll.is_none() || pitch.is_none()) {
        return Err(another_sort(&table));
    }
    let accel = triad(&table, &xyz("accel", ""), ra)?;
    let gyro = triad(&table, &xyz("gyro", ""), ro)?;
    if accel.is_none() && gyro.is_none() {
        return Err(Error::data("the table has no outputs")
            .at(table.label.clone())
            .advise(
                "add columns accel_x, accel_y, accel_z [m/s^2] or gyro_x, gyro_y, gyro_z [rad/s]",
            ));
    }
    let accel_se = triad(&table, &xyz("accel", "_se"), ra)?;
    let gyro_se = triad(&table, &xyz("gyro", "_se"), ro)?;
    let w = triad(&table, &xyz("w", ""), ro)?;
    let wdot = triad(&table, &xyz("wdot", ""), Dimension::ANGULAR_ACCELERATION)?;
    let turn = triad(&table, &xyz("turn", ""), ro)?;
    let f_se = single(&table, "f_se", ra)?;
    let w_se = single(&table, "w_se", ro)?;
    let tilt_se = single(&table, "tilt_se", Dimension::ANGLE)?;
    let temperature = single(&table, "temperature", Dimension::TEMPERATURE)?;
    let cell = |cells: &Option<Cells>, row: usize| cells.as_ref().and_then(|c| c[row]);
    let of =
        |cells: &Option<Vec<Option<[f64; 3]>>>, row: usize| cells.as_ref().and_then(|c| c[row]);
    let text = |name: &str, row: usize| {
        table
            .column(name)
            .and_then(|c| c.cells.get(row))
            .filter(|t| !t.is_empty())
            .cloned()
    };
    let mut out = Read {
        stations: Vec::with_capacity(table.rows()),
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
        if kinds != 1 {
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
        let reference = if let Some(f) = given {
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
        let turning = of(&turn, row).filter(|t| norm(*t) > 0.0);
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
            if given.is_none() && along.abs() < 1f64.to_radians().cos() {
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
                (Some(phi), _) if given.is_none() => {
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
