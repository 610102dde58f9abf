//! Why a hand-turned log cannot be used, in one sentence with what to add.

use nalgebra::Vector3;

use super::rests::{Found, Rest};
use super::{Options, Recording, accel, add};
use crate::stations::Status;

/// Why a hand-turned log cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Fewer samples than a rest needs.
    #[error("the log is {length_s:.2} s long, too short for a rest of 0.5 s")]
    TooShort {
        /// Length \[s\].
        length_s: f64,
    },
    /// No rest.
    #[error("the sensor moves all the time: it never lies still for 0.5 s{}", turns(*turning))]
    AlwaysMoving {
        /// Steady stretches in which it turns all the while.
        turning: usize,
    },
    /// Outputs in g that claim to be in m/s².
    #[error("|f| at rest is {size:.3}, which looks like g, not m/s^2")]
    LooksLikeG {
        /// Size of the mean output at rest.
        size: f64,
    },
    /// |f| far from gravity.
    #[error("|f| at rest is {size:.3} m/s^2 where gravity is {gravity:.3} m/s^2")]
    NotGravity {
        /// Size of the mean output at rest.
        size: f64,
        /// Gravity used.
        gravity: f64,
    },
    /// Too few distinct poses.
    #[error(
        "{poses} still poses were found, {distinct} of them distinct; bias and scale factor of three axes need six"
    )]
    FewPoses {
        /// Rests.
        poses: usize,
        /// Rests in directions more than 5° apart.
        distinct: usize,
        /// Directions that point up in them.
        seen: String,
    },
    /// Poses that do not determine bias and scale factor.
    #[error("the {poses} poses do not determine {missing}{plane}")]
    NotDetermined {
        /// Rests.
        poses: usize,
        /// Names.
        missing: String,
        /// `: they lie in one plane`, or nothing.
        plane: String,
        /// Poses to add, in words.
        add: String,
    },
    /// The estimate runs away.
    #[error("the accelerometer's outputs in the poses fit no bias, scale factor and misalignment")]
    Diverged,
    /// No turn to calibrate the gyro with.
    #[error("no turn between two rests was found, so the gyro has no reference")]
    NoTurns,
    /// Gyro and accelerometer contradict each other.
    #[error("the gyro's turns do not lead from one direction of gravity to the next")]
    TurnsDisagree,
}

/// What steady stretches that are no rests do.
fn turns(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => ", and turns in the one stretch that is steady".to_owned(),
        n => format!(", and turns in each of {n} stretches that are steady"),
    }
}

impl Error {
    /// Where.
    pub fn place(&self) -> Option<String> {
        Some(
            match self {
                Self::LooksLikeG { .. } | Self::NotGravity { .. } | Self::Diverged => "accel",
                Self::TurnsDisagree => "gyro",
                _ => return None,
            }
            .to_owned(),
        )
    }

    /// What to do.
    pub fn advice(&self) -> Option<String> {
        Some(match self {
            Self::TooShort { .. } => {
                "record at least nine rests of 2 s or more, turned by hand between them".to_owned()
            }
            Self::AlwaysMoving { .. } => {
                "lay the sensor down between the turns, 2 s or more each time, in nine directions or more".to_owned()
            }
            Self::LooksLikeG { .. } => {
                "write the unit of the columns as g, for instance --columns 'accel=1,2,3:g'".to_owned()
            }
            Self::NotGravity { .. } => {
                "check the unit of the accelerometer columns, for instance --columns 'accel=1,2,3:1/2048 g'".to_owned()
            }
            Self::FewPoses { seen, .. } => {
                format!("add rests in other directions: each axis up and down and some between{seen}")
            }
            Self::NotDetermined { add, .. } => format!("add rests with these directions up: {add}"),
            Self::Diverged => {
                "check units and mounting of the accelerometer (--axes), and that it lay still in the poses".to_owned()
            }
            Self::NoTurns => "keep the log running while it is turned from rest to rest".to_owned(),
            Self::TurnsDisagree => {
                "check the gyro's unit, its axes against the accelerometer's (--axes, a mirrored axis) and --rate"
                    .to_owned()
            }
        })
    }
}

/// Refuses what is not a hand-turned log at all.
pub(super) fn check(recording: &Recording, found: &Found, options: &Options) -> Result<(), Error> {
    let length_s = recording.samples() as f64 * recording.dt_s;
    if length_s < 0.5 {
        return Err(Error::TooShort { length_s });
    }
    // The quietest tenth of a log that rests somewhere is sensor noise.
    // Where most steady stretches turn, the few others are chance.
    let turning = found.turning.len();
    if found.rests.is_empty()
        || turning > 2 * found.rests.len()
        || found.quiet[0] > 0.4
        || found.quiet[1] > 0.08
    {
        return Err(Error::AlwaysMoving { turning });
    }
    let sizes = found
        .rests
        .iter()
        .map(|r| Vector3::from(r.accel).norm())
        .collect();
    let size = crate::interval::median(sizes).unwrap_or(0.0);
    let gravity = options.gravity_m_s2;
    if (0.5..1.5).contains(&size) {
        return Err(Error::LooksLikeG { size });
    }
    if !(0.7..1.4).contains(&(size / gravity)) {
        return Err(Error::NotGravity { size, gravity });
    }
    Ok(())
}

/// Refuses fewer than six distinct poses.
pub(super) fn few(rests: &[Rest], directions: &[Vector3<f64>]) -> Result<(), Error> {
    let distinct = add::distinct(directions, 5f64.to_radians());
    if distinct.len() < 6 {
        let seen: Vec<String> = distinct.iter().map(words).collect();
        return Err(Error::FewPoses {
            poses: rests.len(),
            distinct: distinct.len(),
            seen: format!("; up so far: {}", seen.join(", ")),
        });
    }
    Ok(())
}

/// The nearest of the 26 directions.
fn words(d: &Vector3<f64>) -> String {
    crate::stations::add::directions()
        .into_iter()
        .max_by(|a, b| {
            let along = |v: &[f64; 3]| Vector3::from(*v).dot(d);
            along(&a.0).total_cmp(&along(&b.0))
        })
        .map_or_else(String::new, |(_, name)| name)
}

/// Refuses poses that do not give bias and scale factor of all three axes.
pub(super) fn enough(
    fit: &accel::Fit,
    asked: &[bool; 9],
    directions: &[Vector3<f64>],
    se_m_s2: [f64; 3],
) -> Result<(), Error> {
    let missing: Vec<usize> = (0..6)
        .filter(|j| asked[*j] && fit.status[*j] != Status::Admitted)
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(not_determined(&missing, asked, directions, se_m_s2))
}

/// Why an estimate ran away: poses that tell too little of some terms, or outputs that fit none.
pub(super) fn ran_away(asked: &[bool; 9], directions: &[Vector3<f64>], se_m_s2: [f64; 3]) -> Error {
    let missing = add::missing(directions, asked, se_m_s2);
    if missing.is_empty() {
        return Error::Diverged;
    }
    not_determined(&missing, asked, directions, se_m_s2)
}

fn not_determined(
    missing: &[usize],
    asked: &[bool; 9],
    directions: &[Vector3<f64>],
    se_m_s2: [f64; 3],
) -> Error {
    let names: Vec<String> = missing
        .iter()
        .map(|j| {
            let (k, term) = accel::TERMS[*j];
            term.name(sagnac_core::Sensor::Accel, k)
        })
        .collect();
    Error::NotDetermined {
        poses: directions.len(),
        missing: names.join(", "),
        plane: if add::in_a_plane(directions) {
            ": they lie in one plane".to_owned()
        } else {
            String::new()
        },
        add: add::resolving(directions, asked, se_m_s2).join(", "),
    }
}

/// Refuses a gyro that does not lead from pose to pose.
pub(super) fn turns_agree(median_error_rad: f64) -> Result<(), Error> {
    if median_error_rad > 0.15 {
        return Err(Error::TurnsDisagree);
    }
    Ok(())
}
