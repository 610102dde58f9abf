//! `--columns 'time=0:us, gyro=4,5,6:deg/s'`: which column of a source is which channel, and in what unit.

use sagnac_model::units::{Dimension, Unit};

use crate::Error;
use crate::text::number::TimeKind;

/// What a group of sources is read as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Time,
    Gyro,
    Accel,
    GyroRate,
    Temperature,
    /// Accumulated angle, differenced to the gyro's increments.
    Angle,
    /// Accumulated velocity, differenced to the accelerometer's increments.
    Speed,
    /// Of a path: east, north, up.
    Position,
    /// Of a path: w, x, y, z.
    Quaternion,
    /// Of a path, as are the angles that follow.
    Latitude,
    Longitude,
    Height,
    Roll,
    Pitch,
    Heading,
}

/// One column of the source, as the user names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ColumnName {
    Index(usize),
    Name(String),
}

impl std::fmt::Display for ColumnName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Index(i) => write!(f, "{i}"),
            Self::Name(n) => f.write_str(n),
        }
    }
}

/// The unit of a group.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ColumnUnit {
    /// A unit of the table, with or without a factor.
    Unit(Unit),
    /// ISO 8601 dates.
    Iso,
    /// Not written: the source has to know it.
    Missing,
}

/// One `role=sources:unit`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Group {
    pub(crate) role: Role,
    /// Axis of a single channel (`gyro_x`), `None` for three at once or without axes.
    pub(crate) axis: Option<usize>,
    /// One or three sources.
    pub(crate) sources: Vec<ColumnName>,
    pub(crate) unit: ColumnUnit,
}

const ROLES: [(&str, Role, &[&str]); 15] = [
    ("time", Role::Time, &[]),
    ("gyro", Role::Gyro, &AXES),
    ("accel", Role::Accel, &AXES),
    ("gyro_rate", Role::GyroRate, &AXES),
    ("temperature", Role::Temperature, &[]),
    ("angle", Role::Angle, &AXES),
    ("speed", Role::Speed, &AXES),
    ("position", Role::Position, &AXES),
    ("quaternion", Role::Quaternion, &["w", "x", "y", "z"]),
    ("latitude", Role::Latitude, &[]),
    ("longitude", Role::Longitude, &[]),
    ("height", Role::Height, &[]),
    ("roll", Role::Roll, &[]),
    ("pitch", Role::Pitch, &[]),
    ("heading", Role::Heading, &[]),
];

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

const EXAMPLE: &str = "write for instance --columns 'time=0:s, gyro=1,2,3:deg/s, accel=4,5,6:g'";

impl Role {
    /// The role and axis of a name such as `gyro`, `gyro_x`, `temperature`.
    pub(crate) fn parse(name: &str) -> Option<(Self, Option<usize>)> {
        ROLES.iter().find_map(|&(word, role, axes)| {
            if name == word {
                return Some((role, None));
            }
            // Fields of structures are parted by a point.
            let axis = name.strip_prefix(word)?.strip_prefix(['_', '.'])?;
            let axis = axes.iter().position(|a| *a == axis)?;
            Some((role, Some(axis)))
        })
    }

    /// Names of its axes; none of a single channel.
    pub(crate) fn axes(self) -> &'static [&'static str] {
        ROLES.iter().find(|r| r.1 == self).map_or(&[], |r| r.2)
    }

    /// True for roles of several axes.
    pub(crate) fn has_axes(self) -> bool {
        !self.axes().is_empty()
    }

    /// True for what a path has besides time: no reading of a sensor.
    pub(crate) fn is_of_path(self) -> bool {
        ROLES.iter().position(|r| r.1 == self) >= ROLES.iter().position(|r| r.1 == Self::Position)
    }

    pub(crate) fn word(self) -> &'static str {
        ROLES.iter().find(|r| r.1 == self).map_or("", |r| r.0)
    }

    /// The channel that the role gives for an axis.
    pub(crate) fn channel(self, axis: Option<usize>) -> String {
        let word = match self {
            Self::Angle => "gyro",
            Self::Speed => "accel",
            other => other.word(),
        };
        match axis.and_then(|a| self.axes().get(a)) {
            Some(axis) => format!("{word}_{axis}"),
            None => word.to_owned(),
        }
    }

    /// The dimension of its values, and that of increments where they are allowed instead.
    pub(crate) fn dimensions(self) -> (Dimension, Option<Dimension>) {
        match self {
            Self::Time => (Dimension::TIME, None),
            Self::Gyro => (Dimension::ANGULAR_RATE, Some(Dimension::ANGLE)),
            Self::Accel => (Dimension::ACCELERATION, Some(Dimension::SPEED)),
            Self::GyroRate => (Dimension::ANGULAR_ACCELERATION, None),
            Self::Temperature => (Dimension::TEMPERATURE, None),
            Self::Angle => (Dimension::ANGLE, None),
            Self::Speed => (Dimension::SPEED, None),
            Self::Position | Self::Height => (Dimension::LENGTH, None),
            Self::Quaternion => (Dimension::RATIO, None),
            Self::Latitude | Self::Longitude | Self::Roll | Self::Pitch | Self::Heading => {
                (Dimension::ANGLE, None)
            }
        }
    }
}

/// How values of a unit become SI: value·factor + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub(crate) factor: f64,
    pub(crate) offset: f64,
    /// The values are increments: rad or m/s.
    pub(crate) is_increment: bool,
}

/// The scale of `unit` in the role, or what the role expects instead.
pub(crate) fn scale(role: Role, unit: &Unit) -> Result<Scale, Error> {
    let (dimension, increment) = role.dimensions();
    let plain = Scale {
        factor: unit.factor(),
        offset: 0.0,
        is_increment: false,
    };
    if role == Role::Temperature {
        if unit.is_celsius() {
            return Ok(plain);
        }
        if unit.measures(Dimension::TEMPERATURE_DIFFERENCE) {
            return Ok(Scale {
                offset: -273.15,
                ..plain
            });
        }
    } else if unit.measures(dimension) {
        return Ok(plain);
    } else if increment.is_some_and(|d| unit.measures(d)) {
        return Ok(Scale {
            is_increment: true,
            ..plain
        });
    }
    let example = match role {
        Role::Time => "time=0:us",
        Role::Gyro => "gyro=4,5,6:deg/s",
        Role::Accel => "accel=1,2,3:g",
        Role::GyroRate => "gyro_rate=1,2,3:rad/s^2",
        Role::Temperature => "temperature=7:degC",
        Role::Angle => "angle=1,2,3:rad",
        Role::Speed => "speed=1,2,3:m/s",
        Role::Position => "position=1,2,3:m",
        Role::Quaternion => "quaternion=4,5,6,7",
        Role::Height => "height=3:m",
        Role::Latitude | Role::Longitude | Role::Roll | Role::Pitch | Role::Heading => {
            "heading=4:deg"
        }
    };
    Err(Error::usage(format!(
        "expected {}, got {}: \"{}\"",
        dimension.words(),
        unit.words(),
        unit.text()
    ))
    .advise(format!("write for instance {example}")))
}

/// How a time in `unit` becomes a stamp.
pub(crate) fn time_kind(unit: &ColumnUnit) -> Result<TimeKind, Error> {
    match unit {
        ColumnUnit::Iso => Ok(TimeKind::Iso),
        ColumnUnit::Unit(unit) => scale(Role::Time, unit).map(|s| TimeKind::of_factor(s.factor)),
        ColumnUnit::Missing => Err(Error::usage("the unit of `time` is missing")
            .at("--columns")
            .advise("write for instance time=0:us, or time=0:iso for dates")),
    }
}

/// Reads the text of `--columns`.
pub(crate) fn parse(text: &str) -> Result<Vec<Group>, Error> {
    let fail = |what: String| {
        Error::usage(what)
            .at(format!("--columns '{}'", clip(text)))
            .advise(EXAMPLE)
    };
    let mut scan = Scanner { rest: text };
    let mut groups: Vec<Group> = Vec::new();
    let mut role_text = scan.word(&['=', ',', ':']);
    loop {
        if scan.take() != Some('=') {
            return Err(fail(format!(
                "`{}` is no `role=columns:unit`",
                clip(&role_text.0)
            )));
        }
        let name = role_text.0.trim().to_owned();
        let (role, axis) = Role::parse(&name).ok_or_else(|| {
            fail(format!(
                "the role `{}` is not known; roles are time, gyro, accel, gyro_rate, temperature, angle, speed, and one axis of them as gyro_x",
                clip(&name)
            ))
        })?;
        let mut sources = Vec::new();
        let mut unit = ColumnUnit::Missing;
        let mut next_role = None;
        loop {
            let (word, quoted) = scan.word(&['=', ',', ':']);
            if !quoted && scan.rest.starts_with('=') {
                next_role = Some((word, false));
                break;
            }
            if word.is_empty() {
                return Err(fail(format!("`{name}=` names an empty column")));
            }
            sources.push(match word.parse::<usize>() {
                Ok(i) if !quoted => ColumnName::Index(i),
                _ => ColumnName::Name(word),
            });
            match scan.take() {
                Some(',') => {}
                Some(':') => {
                    let (word, _) = scan.word(&[',']);
                    unit = if word.eq_ignore_ascii_case("iso") {
                        ColumnUnit::Iso
                    } else {
                        let unit = Unit::parse_scaled(&word).map_err(|e| {
                            let advice = e.advice().unwrap_or_else(|| EXAMPLE.to_owned());
                            Error::usage(e.to_string())
                                .at(format!("--columns, {name}"))
                                .advise(advice)
                        })?;
                        if word.is_empty() {
                            ColumnUnit::Missing
                        } else {
                            ColumnUnit::Unit(unit)
                        }
                    };
                    match scan.take() {
                        Some(',') if !scan.rest.trim().is_empty() => {
                            next_role = Some(scan.word(&['=', ',', ':']));
                        }
                        _ => {}
                    }
                    break;
                }
                _ => break,
            }
        }
        if unit == ColumnUnit::Iso && role != Role::Time {
            return Err(fail(format!("only `time` can hold dates, not `{name}`")));
        }
        let all = match axis {
            None => role.axes().len().max(1),
            Some(_) => 1,
        };
        if ![1, all].contains(&sources.len()) {
            let wanted = match all {
                1 => "one column",
                3 => "three columns",
                _ => "four columns",
            };
            return Err(fail(format!(
                "`{name}` takes {wanted}, got {}",
                sources.len()
            )));
        }
        if let ColumnUnit::Unit(u) = &unit {
            scale(role, u).map_err(|e| e.at(format!("--columns, {name}")))?;
        }
        groups.push(Group {
            role,
            axis,
            sources,
            unit,
        });
        match next_role {
            Some(word) => role_text = word,
            None => break,
        }
    }
    refuse_doubles(&groups).map_err(fail)?;
    Ok(groups)
}

fn refuse_doubles(groups: &[Group]) -> Result<(), String> {
    let mut seen: Vec<String> = Vec::new();
    for group in groups {
        let axes: Vec<Option<usize>> = match group.axis {
            None if group.role.has_axes() => (0..group.role.axes().len()).map(Some).collect(),
            axis => vec![axis],
        };
        for axis in axes {
            let channel = group.role.channel(axis);
            if seen.contains(&channel) {
                return Err(format!("`{channel}` is named twice"));
            }
            seen.push(channel);
        }
    }
    Ok(())
}

pub(crate) fn clip(text: &str) -> String {
    let mut out: String = text
        .chars()
        .take(60)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if text.chars().nth(60).is_some() {
        out.push('…');
    }
    out
}

struct Scanner<'a> {
    rest: &'a str,
}

impl Scanner<'_> {
    /// The next word up to one of `ends`, and whether it was quoted.
    fn word(&mut self, ends: &[char]) -> (String, bool) {
        self.rest = self.rest.trim_start();
        if let Some(body) = self.rest.strip_prefix('"')
            && let Some(end) = body.find('"')
        {
            let word = body[..end].to_owned();
            self.rest = body[end + 1..].trim_start();
            return (word, true);
        }
        let end = self.rest.find(ends).unwrap_or(self.rest.len());
        let word = self.rest[..end].trim().to_owned();
        self.rest = &self.rest[end..];
        (word, false)
    }

    fn take(&mut self) -> Option<char> {
        let c = self.rest.chars().next()?;
        self.rest = &self.rest[c.len_utf8()..];
        Some(c)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn the_contracts_example_is_read() {
        let g = parse("time=0:us, gyro=4,5,6:deg/s, accel=1,2,3:g, temperature=temp:degC").unwrap();
        assert_eq!(g.len(), 4);
        assert_eq!(g[1].role, Role::Gyro);
        assert_eq!(g[1].sources, [4, 5, 6].map(ColumnName::Index));
        assert_eq!(g[3].sources, [ColumnName::Name("temp".into())]);
        let g = parse("gyro=1,2,3:0.05 deg/s,accel=\"a,x\",\"a:y\",\"a=z\":125 ug*s,time=t:iso")
            .unwrap();
        assert_eq!(g[1].sources[1], ColumnName::Name("a:y".into()));
        assert_eq!(g[2].unit, ColumnUnit::Iso);
        let g = parse("gyro=gx,gy,gz, accel_x=ax:g").unwrap();
        assert_eq!(g[0].unit, ColumnUnit::Missing);
        assert_eq!(g[1].axis, Some(0));
        assert_eq!(parse("gyro=imu_gyr[3]:rad/s").unwrap()[0].sources.len(), 1);
    }

    #[test]
    fn what_is_wrong_is_refused() {
        for bad in [
            "",
            "gyro",
            "gyro=",
            "gyro=1,2:deg/s",
            "gyros=1,2,3:deg/s",
            "gyro=1,2,3:g",
            "accel=1,2,3:deg",
            "time=0:m",
            "gyro=1,2,3:deg/s, gyro_x=4:deg/s",
            "gyro=1,2,3:iso",
            "temperature=1:m",
            "time=0,1:s",
            "gyro=1,2,3:furlong",
        ] {
            let e = parse(bad).unwrap_err();
            assert!(e.is_usage(), "{bad}");
            assert!(e.advice().is_some(), "{bad}: {e}");
        }
    }
}
