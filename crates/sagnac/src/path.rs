//! A path of the user's own from the columns of a log (navigation.md §1.3).
//!
//! `latitude`, `longitude`, `height` or `position_x…z` (east, north, up), and for attitude
//! `quaternion_w…z`, or `roll`, `pitch`, `heading`, or nothing.

#![allow(clippy::items_after_statements, reason = "beside its only use")]

use sagnac_log::Log;
use sagnac_model::units::{Dimension, parse_quantity};
use sagnac_nav::trajectory::{PathAttitude, PathData, PathPosition};
use sagnac_nav::{Earth, Start, Trajectory};

use crate::Error;

/// Columns of one kind, all or none.
fn group<const N: usize>(
    log: &Log,
    names: [&str; N],
    dimensions: [Option<Dimension>; N],
) -> Result<Option<Vec<[f64; N]>>, Error> {
    let found = names.map(|name| log.layout.index(name));
    if found.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut columns: Vec<(&[f64], f64)> = Vec::new();
    for ((name, at), dimension) in names.into_iter().zip(found).zip(dimensions) {
        let Some(at) = at else {
            return Err(Error::data(format!(
                "the path has some of {}, but no {name}",
                names.join(", ")
            ))
            .advise("give all of them or none"));
        };
        let unit = log.layout.channels[at].unit.trim();
        let factor = match dimension {
            None => 1.0,
            Some(_) if unit.is_empty() => {
                return Err(
                    Error::data(format!("the unit of column `{name}` is not known")).advise(
                        format!(
                            "write it in the header, for instance {name} [{}]",
                            if name.starts_with("position") || name == "height" {
                                "m"
                            } else {
                                "deg"
                            }
                        ),
                    ),
                );
            }
            Some(dimension) => {
                parse_quantity(&format!("1 {unit}"), dimension).map_err(|error| {
                    Error::data(error.to_string()).at(format!("column {name} [{unit}]"))
                })?
            }
        };
        columns.push((&log.columns[at], factor));
    }
    let rows = (0..log.rows).map(|k| {
        let mut row = [0.0; N];
        for (value, (column, factor)) in row.iter_mut().zip(&columns) {
            *value = column[k] * factor;
        }
        row
    });
    Ok(Some(rows.collect()))
}

/// The path that a log holds, as its columns; rows with a value that is not a number are left out.
///
/// # Errors
/// No position; some columns of a group only; units that are not known.
pub fn path_data(log: &Log) -> Result<PathData, Error> {
    let angle = Some(Dimension::ANGLE);
    let length = Some(Dimension::LENGTH);
    let geodetic = group(
        log,
        ["latitude", "longitude", "height"],
        [angle, angle, length],
    )?;
    let local = group(log, ["position_x", "position_y", "position_z"], [length; 3])?;
    let quaternion = group(
        log,
        [
            "quaternion_w",
            "quaternion_x",
            "quaternion_y",
            "quaternion_z",
        ],
        [None; 4],
    )?;
    let angles = group(log, ["roll", "pitch", "heading"], [angle; 3])?;
    let is_geodetic = geodetic.is_some();
    let Some(position) = geodetic.or(local) else {
        return Err(Error::data("the path has no position").advise(
            "give latitude [deg], longitude [deg], height [m], or position_x, position_y, position_z [m]",
        ));
    };
    let time_s: Vec<f64> = (0..log.rows)
        .map(|k| {
            log.stamps
                .get(k)
                .map_or_else(|| log.time_s(k), sagnac_log::Stamp::seconds)
        })
        .collect();
    // Differences of stamps in nanoseconds are exact where the seconds themselves are not.
    let origin = log.stamps.get(0);
    let time_s = match origin {
        Some(origin) => {
            let first = time_s[0];
            log.stamps
                .since(origin)
                .into_iter()
                .map(|t| if first.abs() < 1e6 { t + first } else { t })
                .collect()
        }
        None => time_s,
    };
    let whole = |k: usize| {
        position[k].iter().all(|x| !x.is_nan())
            && quaternion
                .as_ref()
                .is_none_or(|q| q[k].iter().all(|x| !x.is_nan()))
            && angles
                .as_ref()
                .is_none_or(|a| a[k].iter().all(|x| !x.is_nan()))
    };
    let rows: Vec<usize> = (0..log.rows).filter(|k| whole(*k)).collect();
    fn pick<T: Copy>(all: &[T], rows: &[usize]) -> Vec<T> {
        rows.iter().map(|k| all[*k]).collect()
    }
    let position = pick(&position, &rows);
    let time_s: Vec<f64> = time_s;
    Ok(PathData {
        time_s: pick(&time_s, &rows),
        position: if is_geodetic {
            PathPosition::Geodetic(position)
        } else {
            PathPosition::Local(position)
        },
        attitude: match (quaternion, angles) {
            (Some(quaternion), _) => PathAttitude::Quaternion(pick(&quaternion, &rows)),
            (None, Some(angles)) => PathAttitude::RollPitchHeading(pick(&angles, &rows)),
            (None, None) => PathAttitude::Coordinated,
        },
    })
}

/// The trajectory along the path of a log; local axes are tangent at `start`.
///
/// # Errors
/// Those of [`path_data`] and of [`sagnac_nav::trajectory::Path::new`], with the log's name.
pub fn trajectory_of_log(
    log: &Log,
    label: &str,
    earth: Earth,
    start: &Start,
) -> Result<Trajectory, Error> {
    let data = path_data(log).map_err(|error| error.at(label.to_owned()))?;
    Trajectory::from_path(label, earth, start, &data)
        .map_err(|error| Error::from(error).at(label.to_owned()))
}
