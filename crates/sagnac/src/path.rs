//! A path of the user's own from the columns of a log (navigation.md §1.3).
//!
//! `latitude`, `longitude`, `height` or `position_x…z` (east, north, up), and for attitude
//! `quaternion_w…z`, or `roll`, `pitch`, `heading`, or nothing.

use sagnac_log::Log;
use sagnac_model::units::{Dimension, Unit};
use sagnac_nav::trajectory::{PathAttitude, PathData, PathPosition};
use sagnac_nav::{Earth, Start, Trajectory};

use crate::Error;

/// A column of a log in SI under any of its names, if the log has it; the unit of a column that is not an inertial
/// channel is read from the log.
fn column(
    log: &Log,
    names: &[&str],
    dimension: Dimension,
    label: &str,
) -> Result<Option<Vec<f64>>, Error> {
    for name in names {
        let Some(index) = log.layout.index(name) else {
            continue;
        };
        let channel = &log.layout.channels[index];
        let values = &log.columns[index];
        if dimension == Dimension::RATIO {
            return Ok(Some(values.clone()));
        }
        if channel.unit.trim().is_empty() {
            return Err(
                Error::data(format!("the unit of column `{name}` is not known"))
                    .at(label.to_owned())
                    .advise(format!(
                        "write it in the header, for instance {name} [{}]",
                        dimension.field_unit()
                    )),
            );
        }
        let unit = Unit::parse(&channel.unit)
            .map_err(|e| Error::data(e.to_string()).at(format!("{label}, column {name}")))?;
        if !unit.measures(dimension) {
            return Err(Error::data(format!(
                "column `{name}` is {}, expected {}",
                unit.words(),
                dimension.words()
            ))
            .at(label.to_owned())
            .advise(format!(
                "write its unit in brackets, for instance {name} [{}]",
                dimension.field_unit()
            )));
        }
        let factor = unit.factor();
        return Ok(Some(values.iter().map(|v| v * factor).collect()));
    }
    Ok(None)
}

/// All columns of a group, or none.
fn group<const N: usize>(
    log: &Log,
    names: [&[&str]; N],
    dimension: Dimension,
    label: &str,
) -> Result<Option<[Vec<f64>; N]>, Error> {
    let mut out: Vec<Vec<f64>> = Vec::new();
    for set in &names {
        match column(log, set, dimension, label)? {
            Some(values) => out.push(values),
            None if out.is_empty() => return Ok(None),
            None => {
                return Err(Error::data(format!(
                    "column `{}` is missing beside the others of its group",
                    set[0]
                ))
                .at(label.to_owned()));
            }
        }
    }
    Ok(out.try_into().ok())
}

/// The path and attitude that a log or a file of way points holds (navigation.md §1.3); rows with a NaN are left out.
///
/// # Errors
/// A file without positions, or with half a group of columns; a unit of another dimension.
pub fn path(log: &Log, label: &str) -> Result<PathData, Error> {
    let latitude = column(log, &["latitude"], Dimension::ANGLE, label)?;
    let longitude = column(log, &["longitude"], Dimension::ANGLE, label)?;
    let height = column(log, &["height"], Dimension::LENGTH, label)?;
    let local = group(
        log,
        [
            &["position_x", "p_RS_R_x", "p_x"],
            &["position_y", "p_RS_R_y", "p_y"],
            &["position_z", "p_RS_R_z", "p_z"],
        ],
        Dimension::LENGTH,
        label,
    )?;
    let quaternion = group(
        log,
        [
            &["quaternion_w", "q_RS_w", "q_w"],
            &["quaternion_x", "q_RS_x", "q_x"],
            &["quaternion_y", "q_RS_y", "q_y"],
            &["quaternion_z", "q_RS_z", "q_z"],
        ],
        Dimension::RATIO,
        label,
    )?;
    let angles = group(
        log,
        [&["roll"], &["pitch"], &["heading"]],
        Dimension::ANGLE,
        label,
    )?;
    let time: Vec<f64> = (0..log.rows).map(|k| log.time_s(k)).collect();
    let zip = |x: &[Vec<f64>; 3]| -> Vec<[f64; 3]> {
        (0..log.rows).map(|k| [x[0][k], x[1][k], x[2][k]]).collect()
    };
    let (positions, is_local) = match (latitude, longitude, height, local) {
        (Some(a), Some(b), Some(c), _) => (zip(&[a, b, c]), false),
        (.., Some(local)) => (zip(&local), true),
        _ => {
            let names: Vec<&str> = log
                .layout
                .channels
                .iter()
                .map(|c| c.name.as_str())
                .collect();
            return Err(Error::data("the path has no positions")
                .at(format!("{label}: columns time, {}", names.join(", ")))
                .advise("give latitude [deg], longitude [deg], height [m], or position_x [m], position_y [m], position_z [m]"));
        }
    };
    if !is_local
        && let Some(k) = positions
            .iter()
            .position(|p| p[0].abs() > std::f64::consts::FRAC_PI_2 + 1e-12)
    {
        return Err(Error::data(format!(
            "the latitude {} deg lies beyond a pole",
            positions[k][0].to_degrees()
        ))
        .at(format!("{label}, {} s", time[k]))
        .advise("give latitudes from -90 deg to 90 deg"));
    }
    let quaternions: Option<Vec<[f64; 4]>> = quaternion.map(|q| {
        (0..log.rows)
            .map(|k| [q[0][k], q[1][k], q[2][k], q[3][k]])
            .collect()
    });
    let angles = angles.as_ref().map(zip);
    let keep: Vec<usize> = (0..log.rows)
        .filter(|&k| {
            time[k].is_finite()
                && positions[k].iter().all(|x| x.is_finite())
                && quaternions
                    .as_ref()
                    .is_none_or(|q| q[k].iter().all(|x| x.is_finite()))
                && angles
                    .as_ref()
                    .is_none_or(|a| a[k].iter().all(|x| x.is_finite()))
        })
        .collect();
    let pick = |x: &[[f64; 3]]| -> Vec<[f64; 3]> { keep.iter().map(|&k| x[k]).collect() };
    Ok(PathData {
        time_s: keep.iter().map(|&k| time[k]).collect(),
        position: if is_local {
            PathPosition::Local(pick(&positions))
        } else {
            PathPosition::Geodetic(pick(&positions))
        },
        attitude: match (quaternions, angles) {
            (Some(q), _) => PathAttitude::Quaternion(keep.iter().map(|&k| q[k]).collect()),
            (None, Some(a)) => PathAttitude::RollPitchHeading(pick(&a)),
            _ => PathAttitude::Coordinated,
        },
    })
}

/// The trajectory along the path of a log; local axes are tangent at `start`.
///
/// # Errors
/// Those of [`path`] and of [`sagnac_nav::trajectory::Path::new`], with the log's name.
pub fn trajectory_of_log(
    log: &Log,
    label: &str,
    earth: Earth,
    start: &Start,
) -> Result<Trajectory, Error> {
    let data = path(log, label)?;
    Trajectory::from_path(label, earth, start, &data)
        .map_err(|error| Error::from(error).at(label.to_owned()))
}
