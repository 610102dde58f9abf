//! A path of the user's own from the columns of a log (navigation.md §1.3).
//!
//! `latitude`, `longitude`, `height` or `position_x…z` (east, north, up), and for attitude
//! `quaternion_w…z`, or `roll`, `pitch`, `heading`, or nothing.

use sagnac_log::Log;
use sagnac_model::units::{Dimension, Unit};
use sagnac_nav::trajectory::{PathAttitude, PathData, PathPosition};
use sagnac_nav::{Earth, Start, Trajectory};
use sagnac_report::text::{general, group_thousands};

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

/// A longitude may run on past 360 deg, but not for ever: its digits end.
const MOST_TURNS_RAD: f64 = 1e4;

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

/// The velocity north, east, down that a reference states beside its positions, m/s, row by row.
///
/// # Errors
/// A part of the three columns, or a unit of another dimension.
pub(crate) fn velocities(log: &Log, label: &str) -> Result<Option<[Vec<f64>; 3]>, Error> {
    let names: [&[&str]; 3] = [&["velocity_north"], &["velocity_east"], &["velocity_down"]];
    group(log, names, Dimension::SPEED, label)
}

/// The path and attitude that a log or a file of way points holds (navigation.md §1.3); rows with a NaN are left out.
///
/// # Errors
/// Those of [`path_with_gaps`].
pub fn path(log: &Log, label: &str) -> Result<PathData, Error> {
    path_with_gaps(log, label).map(|(data, _)| data)
}

/// As [`path`], with what was left out.
///
/// # Errors
/// A file without positions, or with half a group of columns; a unit of another dimension; fewer than two rows that
/// are left after others were left out.
pub fn path_with_gaps(log: &Log, label: &str) -> Result<(PathData, Option<LeftOut>), Error> {
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
    // From the first stamp that is a number.
    let stamps = || (0..log.stamps.len()).filter_map(|k| log.stamps.get(k));
    let time: Vec<f64> = match stamps().find(|stamp| stamp.seconds().is_finite()) {
        Some(origin) => stamps().map(|stamp| stamp.since(origin)).collect(),
        None => (0..log.rows).map(|k| log.time_s(k)).collect(),
    };
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
    if !is_local && let Some(k) = positions.iter().position(|p| p[1].abs() > MOST_TURNS_RAD) {
        return Err(Error::data(format!(
            "the longitude {} deg is none",
            general(positions[k][1].to_degrees(), 6)
        ))
        .at(format!("{label}, {} s", time[k]))
        .advise("check the column and its unit"));
    }
    let quaternions: Option<Vec<[f64; 4]>> = quaternion.map(|q| {
        (0..log.rows)
            .map(|k| [q[0][k], q[1][k], q[2][k], q[3][k]])
            .collect()
    });
    let angles = angles.as_ref().map(zip);
    let sound = |row: &[f64]| row.iter().all(|x| x.is_finite());
    // What a row lacks, if anything.
    let lacks = |k: usize| {
        if !time[k].is_finite() {
            Some("time")
        } else if !sound(&positions[k]) {
            Some("position")
        } else if quaternions.as_ref().is_some_and(|q| !sound(&q[k]))
            || angles.as_ref().is_some_and(|a| !sound(&a[k]))
        {
            Some("attitude")
        } else {
            None
        }
    };
    let keep: Vec<usize> = (0..log.rows).filter(|&k| lacks(k).is_none()).collect();
    let left_out = LeftOut::of(log, &time, &keep, &lacks);
    if let Some(left_out) = left_out.as_ref().filter(|_| keep.len() < 2) {
        return Err(left_out.error(label, keep.len()));
    }
    let pick = |x: &[[f64; 3]]| -> Vec<[f64; 3]> { keep.iter().map(|&k| x[k]).collect() };
    let data = PathData {
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
    };
    Ok((data, left_out))
}

/// Rows of a path that hold no number where one is needed, and are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub rows: usize,
    /// The first of them, from 1.
    pub first_row: usize,
    /// Its time from the path's first row, s; none where that is what it lacks.
    pub first_s: Option<f64>,
    /// What the first lacks: time, position or attitude.
    pub lacks: &'static str,
    /// The longest time between two rows that are left, s.
    pub longest_s: f64,
}

impl LeftOut {
    fn of(
        log: &Log,
        time_s: &[f64],
        keep: &[usize],
        lacks: &dyn Fn(usize) -> Option<&'static str>,
    ) -> Option<Self> {
        let (first, lacks) = (0..log.rows).find_map(|k| Some((k, lacks(k)?)))?;
        let steps = keep
            .windows(2)
            .map(|pair| time_s[pair[1]] - time_s[pair[0]]);
        Some(Self {
            count: log.rows - keep.len(),
            rows: log.rows,
            first_row: first + 1,
            first_s: Some(time_s[first]).filter(|t| t.is_finite()),
            lacks,
            longest_s: steps.fold(0.0, f64::max),
        })
    }

    /// Where the first is.
    fn place(&self) -> String {
        let row = group_thousands(&self.first_row.to_string());
        self.first_s.map_or_else(
            || format!("row {row}"),
            |t| format!("row {row} at {} s", general(t, 9)),
        )
    }

    /// How many rows of the path called `label` are left out, and the first.
    pub fn sentence(&self, label: &str) -> String {
        let [count, rows] = [self.count, self.rows].map(|n| group_thousands(&n.to_string()));
        let left_out = match self.count {
            1 => "is left out,",
            _ => "are left out, the first is",
        };
        format!(
            "{count} of {rows} rows of {label} {left_out} {}, which has no number for the {}: the points are up to {} s apart",
            self.place(),
            self.lacks,
            general(self.longest_s, 4),
        )
    }

    fn error(&self, label: &str, left: usize) -> Error {
        let left = if left == 0 { "none" } else { "only one" };
        Error::data(format!(
            "a path needs at least two points, and {left} of its {} rows has numbers for time, position and attitude",
            group_thousands(&self.rows.to_string())
        ))
        .at(format!("{label}, {}: no {}", self.place(), self.lacks))
        .advise("fill the cells in, or leave out a column that holds no numbers")
    }
}

/// The trajectory along the path of a log, and the sentence on rows that were left out; local axes are tangent at
/// `start`.
///
/// # Errors
/// Those of [`path`] and of [`sagnac_nav::trajectory::Path::new`], with the log's name.
pub fn trajectory_of_log(
    log: &Log,
    label: &str,
    earth: Earth,
    start: &Start,
) -> Result<(Trajectory, Option<String>), Error> {
    let (data, left_out) = path_with_gaps(log, label)?;
    let trajectory = Trajectory::from_path(label, earth, start, &data)
        .map_err(|error| Error::from(error).at(label.to_owned()))?;
    Ok((trajectory, left_out.map(|rows| rows.sentence(label))))
}
