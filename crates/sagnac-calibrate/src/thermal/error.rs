//! Why a sweep cannot be used, in one sentence with what to do.

use super::branches::Bin;
use super::{Options, Sweep};
use crate::stations::terms::AXES;

/// Why a sweep cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// No log.
    #[error("there is no log")]
    NoLog,
    /// Neither gyro nor accelerometer, or not the same in all logs.
    #[error("the logs do not all have the same three-axis sensors")]
    NoSensor,
    /// Temperature all but constant.
    #[error(
        "the temperature stays between {low_c:.1} and {high_c:.1} degC, which tells nothing about its effect"
    )]
    Constant {
        /// Lowest \[°C\].
        low_c: f64,
        /// Highest \[°C\].
        high_c: f64,
    },
    /// No finite temperature.
    #[error("the temperature channel has no numbers")]
    NoTemperature,
    /// Too few bins for a curve.
    #[error("{bins} stretches of temperature were found, too few for a curve")]
    FewBins {
        /// How many.
        bins: usize,
        /// Whether only soaks were asked for.
        is_soak_only: bool,
        /// Soaks found.
        soaks: usize,
    },
    /// The output contradicts `--up`.
    #[error("{up} is said to be up but accel_{axis} reads {reads:.2} m/s^2")]
    Contradiction {
        /// What was said: `-z`.
        up: String,
        /// The axis named.
        axis: &'static str,
        /// Mean output of that axis \[m/s²\].
        reads: f64,
        /// What the outputs say: `+z`.
        seen: String,
    },
    /// |f| is near one.
    #[error("the mean |f| is {size:.3} m/s^2, which looks like g")]
    LooksLikeG {
        /// |mean output|.
        size: f64,
    },
    /// A system that cannot be solved.
    #[error("the curve of {axis} cannot be determined from these temperatures")]
    Singular {
        /// Channel.
        axis: String,
    },
}

impl Error {
    /// Where.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::Constant { .. } | Self::NoTemperature => Some("temperature".to_owned()),
            Self::Contradiction { .. } => Some("--up".to_owned()),
            Self::LooksLikeG { .. } => Some("accel_x, accel_y, accel_z".to_owned()),
            _ => None,
        }
    }

    /// What to do.
    pub fn advice(&self) -> Option<String> {
        if let Self::Contradiction { seen, .. } = self {
            return Some(format!(
                "the outputs say that {seen} is up: write --up {seen}, one axis a log; a mirrored axis is remounted with --axes"
            ));
        }
        Some(
            match self {
                Self::NoLog => "name a log with a temperature channel",
                Self::NoSensor => "name the columns, for instance --columns 'gyro=1,2,3:deg/s, accel=4,5,6:g, temperature=7:degC'",
                Self::Constant { .. } => {
                    "sweep the chamber over 10 K or more, up and down, with the sensor at rest"
                }
                Self::NoTemperature => {
                    "name the column, for instance --columns 'temperature=temp:degC'"
                }
                Self::FewBins { is_soak_only: true, .. } => {
                    "leave --soak-only out, or hold more temperatures within 0.2 K for 5 min or more"
                }
                Self::FewBins { .. } | Self::Singular { .. } => {
                    "sweep over a wider range, up and down, with the sensor at rest"
                }
                Self::Contradiction { .. } => "name the axis that points up",
                Self::LooksLikeG { .. } => {
                    "write the unit that the numbers have: [g] in the header, or --columns 'accel=4,5,6:g'"
                }
            }
            .to_owned(),
        )
    }
}

/// Refuses logs without sensors or temperature, and labels that the output contradicts.
pub(super) fn check(sweeps: &[Sweep]) -> Result<(), Error> {
    let first = sweeps.first().ok_or(Error::NoLog)?;
    let same = |s: &Sweep| {
        s.gyro.is_some() == first.gyro.is_some() && s.accel.is_some() == first.accel.is_some()
    };
    if first.channels().is_empty() || !sweeps.iter().all(same) {
        return Err(Error::NoSensor);
    }
    for sweep in sweeps {
        if !sweep.temperature_c.iter().any(|t| t.is_finite()) {
            return Err(Error::NoTemperature);
        }
        let Some(accel) = &sweep.accel else { continue };
        let means: [f64; 3] = accel.map(|values| {
            let there = values.iter().filter(|v| v.is_finite());
            there.clone().sum::<f64>() / there.count() as f64
        });
        let size = means.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (0.5..1.5).contains(&size) {
            return Err(Error::LooksLikeG { size });
        }
        if let Some((axis, sense)) = sweep.up
            && means[axis] * sense < 0.7 * size
        {
            let largest = (0..3)
                .max_by(|a, b| means[*a].abs().total_cmp(&means[*b].abs()))
                .unwrap_or(axis);
            let named = |axis: usize, sense: f64| {
                format!("{}{}", if sense > 0.0 { '+' } else { '-' }, AXES[axis])
            };
            return Err(Error::Contradiction {
                up: named(axis, sense),
                axis: AXES[axis],
                reads: means[axis],
                seen: named(largest, means[largest].signum()),
            });
        }
    }
    Ok(())
}

/// Refuses a temperature that is all but constant.
pub(super) fn spans(span_k: f64, [low_c, high_c]: [f64; 2]) -> Result<(), Error> {
    if span_k < 5.0 {
        return Err(Error::Constant { low_c, high_c });
    }
    Ok(())
}

/// Refuses fewer bins than a curve needs.
pub(super) fn enough(bins: &[Bin], options: &Options, soaks: usize) -> Result<(), Error> {
    if bins.len() < 4 {
        return Err(Error::FewBins {
            bins: bins.len(),
            is_soak_only: options.is_soak_only,
            soaks,
        });
    }
    Ok(())
}
