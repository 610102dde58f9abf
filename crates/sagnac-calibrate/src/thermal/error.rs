//! Why a sweep cannot be used, in one sentence with what to do.

use super::branches::Bin;
use super::{Options, Sweep};

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
    /// |f| contradicts `--up`.
    #[error("{what}")]
    Contradiction {
        /// In words.
        what: String,
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
            _ => None,
        }
    }

    /// What to do.
    pub fn advice(&self) -> Option<String> {
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
                Self::Contradiction { .. } => {
                    "name the axis that points up, for instance --up -z, one a log"
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
        if let (Some(accel), Some((axis, sense))) = (&sweep.accel, sweep.up) {
            let mean = |k: usize| {
                accel[k].iter().filter(|v| v.is_finite()).sum::<f64>() / accel[k].len() as f64
            };
            let size = (0..3).map(|k| mean(k).powi(2)).sum::<f64>().sqrt();
            let (name, sign) = (["x", "y", "z"][axis], if sense > 0.0 { '+' } else { '-' });
            if (0.5..1.5).contains(&size) {
                return Err(Error::Contradiction {
                    what: format!("|f| is {size:.3}, which looks like g, not m/s^2"),
                });
            }
            if mean(axis) * sense < 0.7 * size {
                return Err(Error::Contradiction {
                    what: format!(
                        "{sign}{name} is said to be up but accel_{name} reads {:.2} m/s^2",
                        mean(axis)
                    ),
                });
            }
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
