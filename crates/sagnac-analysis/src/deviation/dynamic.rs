//! Dynamic Allan deviation: the overlapping one on windows that step by a quarter.
//!
//! Source `[GALLEANI]`. A log whose noise changes shows it here, not in one curve.

use super::{Curve, Deviation, deviations};
use crate::error::Error;
use crate::tau_grid::TauGrid;

/// One window and its curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Start of the window, seconds from the first sample.
    pub start_s: f64,
    /// Its end.
    pub end_s: f64,
    /// Overlapping Allan deviation of it.
    pub curve: Curve,
}

/// Overlapping Allan deviation on windows of `window_s` every `window_s`/4, the last one ending
/// with the samples.
///
/// `samples` are one stretch without gaps at the step `dt_s`. Times count from the stretch's
/// start.
///
/// # Errors
/// [`Error::NotPositive`] for a window or step that is not; [`Error::WindowTooLong`] for one
/// longer than the samples; those of [`deviations`].
pub fn dynamic(
    samples: &[f64],
    dt_s: f64,
    window_s: f64,
    grid: &TauGrid,
) -> Result<Vec<Window>, Error> {
    let positive = |name: &'static str, value_s: f64| {
        if value_s.is_finite() && value_s > 0.0 {
            Ok(())
        } else {
            Err(Error::NotPositive { name, value_s })
        }
    };
    positive("the sampling step", dt_s)?;
    positive("the window", window_s)?;
    let count = samples.len();
    let wanted = (window_s / dt_s).round();
    if wanted > count as f64 {
        return Err(Error::WindowTooLong {
            window_s,
            duration_s: count as f64 * dt_s,
        });
    }
    let length = wanted as usize;
    if length < 2 {
        return Err(Error::TooShort {
            kind: "a window",
            needed: 2,
            found: length,
        });
    }
    window_starts(count, length)
        .into_iter()
        .map(|start| {
            let window = &samples[start..start + length];
            Ok(Window {
                start_s: start as f64 * dt_s,
                end_s: (start + length) as f64 * dt_s,
                curve: deviations(&[window], dt_s, Deviation::Oadev, grid)?,
            })
        })
        .collect()
}

/// First samples of the windows.
fn window_starts(count: usize, length: usize) -> Vec<usize> {
    let last = count - length;
    let step = length as f64 / 4.0;
    let whole = (last as f64 / step).ceil() as usize;
    let mut starts: Vec<usize> = (0..whole)
        .map(|k| ((k as f64 * step).round() as usize).min(last))
        .collect();
    starts.push(last);
    starts.dedup();
    starts
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn windows_step_by_a_quarter_and_end_with_the_log() {
        assert_eq!(window_starts(100, 40), [0, 10, 20, 30, 40, 50, 60]);
        assert_eq!(window_starts(105, 40), [0, 10, 20, 30, 40, 50, 60, 65]);
        assert_eq!(window_starts(40, 40), [0]);
    }

    #[test]
    fn each_window_is_the_deviation_of_its_samples() {
        let samples: Vec<f64> = (0..200).map(|k| f64::from(k * 7919 % 101)).collect();
        let windows = dynamic(&samples, 0.5, 20.0, &TauGrid::Octave).unwrap();
        assert_eq!((windows[1].start_s, windows[1].end_s), (5.0, 25.0));
        let own = deviations(&[&samples[10..50]], 0.5, Deviation::Oadev, &TauGrid::Octave);
        assert_eq!(windows[1].curve, own.unwrap());
        assert!(dynamic(&samples, 0.5, 101.0, &TauGrid::Octave).is_err());
        assert!(dynamic(&samples, 0.5, 0.1, &TauGrid::Octave).is_err());
    }
}
