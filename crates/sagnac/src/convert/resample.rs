//! Another rate by a windowed sinc: cutoff 0.45·min(f_in, f_out), 32 lobes, Kaiser window β = 8 (80 dB).

use sagnac_log::{Log, Stamp, Stamps};
use sagnac_report::text::{duration, general, group_thousands};

pub(super) use super::grid::LONGEST_BRIDGE;
use super::grid::{OnGrid, stretches};
use crate::Error;

/// Zero crossings of the sinc on each side.
const LOBES: f64 = 16.0;
const KAISER_BETA: f64 = 8.0;
/// More rows than this are written only of a log that has more itself.
const MOST_ROWS: f64 = 1e8;

/// The log at `rate_hz`, stretch by stretch between gaps, and the sentences about it.
pub(super) fn resample(log: &Log, rate_hz: f64) -> Result<(Log, Vec<String>), Error> {
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(Error::usage("the new rate must be positive")
            .at("--resample")
            .advise("write for instance --resample 100Hz"));
    }
    let dt = log.dt_s()?;
    let rows = log.rows as f64 * dt * rate_hz;
    if rows > MOST_ROWS.max(log.rows as f64) {
        return Err(Error::usage(format!(
            "{} Hz would give {} samples",
            general(rate_hz, 6),
            general(rows, 2)
        ))
        .at("--resample")
        .advise(format!(
            "choose a lower rate: the log itself has {} Hz, and more adds nothing",
            general(1.0 / dt, 4)
        )));
    }
    if rows < 2.0 {
        return Err(Error::usage(format!(
            "a log of {} has no two samples at {} Hz",
            duration(log.rows as f64 * dt),
            general(rate_hz, 6)
        ))
        .at("--resample")
        .advise("choose a higher rate"));
    }
    let (stretches, clock) = stretches(log, dt)?;
    let mut out = Log {
        layout: log.layout.clone(),
        columns: vec![Vec::new(); log.columns.len()],
        ..Log::default()
    };
    out.layout.rate_hz = Some(rate_hz);
    // Without time the first row ends its interval at dt, as `Stamp::of_row` has it.
    let origin = (0..log.rows)
        .filter_map(|k| log.stamps.get(k))
        .find(|t| t.seconds().is_finite())
        .unwrap_or(Stamp::of_row(1, 1.0 / dt));
    let mut stamps = Stamps::default();
    let (mut missing, mut unknown) = (vec![0; log.columns.len()], 0_u64);
    for stretch in &stretches {
        let ratio = 1.0 / (stretch.step_s * rate_hz);
        // In units of input samples: cutoff in cycles a sample.
        let cutoff = 0.45 * (1.0 / ratio).min(1.0);
        let reach = LOBES / (2.0 * cutoff);
        let n = stretch.points;
        // What rounds off to the last point is on it.
        let new = ((n - 1) as f64 / ratio + 1e-6).floor() as usize + 1;
        let grids: Vec<OnGrid> = log.columns.iter().map(|c| stretch.on_grid(c)).collect();
        for (missing, grid) in missing.iter_mut().zip(&grids) {
            *missing += grid.missing;
        }
        let mut weights = Vec::new();
        for k in 0..new {
            let at = k as f64 * ratio;
            let (from, to) = (
                (at - reach).ceil().max(0.0) as usize,
                ((at + reach).floor() as usize).min(n - 1),
            );
            weights.clear();
            weights.extend((from..=to).map(|j| kernel(j as f64 - at, cutoff, reach)));
            let total: f64 = weights.iter().sum();
            for (column, grid) in out.columns.iter_mut().zip(&grids) {
                let part = grid.values.get(from..=to).unwrap_or(&[]);
                let sum: f64 = part.iter().zip(&weights).map(|(v, w)| v * w).sum();
                let (low, high) = (at.floor() as usize, at.ceil() as usize);
                let hole = grid.holes.partition_point(|h| h.end <= low);
                let is_hole = grid.holes.get(hole).is_some_and(|h| h.start <= high);
                unknown += u64::from(is_hole);
                column.push(if is_hole { f64::NAN } else { sum / total });
            }
            let t = stretch.start_s + k as f64 / rate_hz;
            stamps.push(match origin {
                Stamp::Nanoseconds(ns) => {
                    Stamp::Nanoseconds(ns.saturating_add((t * 1e9).round() as i64))
                }
                Stamp::Seconds(s) => Stamp::Seconds(s + t),
            });
        }
        out.rows += new;
    }
    if out.rows == 0 {
        return Err(Error::data(
            "the log has no stretch that could be resampled",
        ));
    }
    out.stamps = stamps;
    let cutoff_hz = 0.45 * rate_hz.min(1.0 / dt);
    let mut notes = vec![format!(
        "resampled from {} Hz to {} Hz, low-passed at {} Hz against aliases; its noise above that is gone",
        general(1.0 / dt, 9),
        general(rate_hz, 9),
        general(cutoff_hz, 9)
    )];
    if clock.is_coarse {
        notes
            .push("its time stamps are coarse: the samples were taken as evenly spaced".to_owned());
    } else if clock.jitter_s > 0.0 {
        notes.push(format!(
            "its time stamps jitter by up to {}: every sample was taken at its stamp",
            duration(clock.jitter_s)
        ));
    }
    let count = |n: u64| group_thousands(&n.to_string());
    if clock.lost > 0 {
        notes.push(format!(
            "{} lost samples were bridged from their neighbors",
            count(clock.lost)
        ));
    }
    let of: Vec<String> = log
        .layout
        .channels
        .iter()
        .zip(&missing)
        .filter(|(_, n)| **n > 0)
        .map(|(c, n)| format!("{} of {}", count(*n), c.name))
        .collect();
    if !of.is_empty() {
        notes.push(format!(
            "samples that are no finite numbers: {}; up to 3 in a row were bridged from their neighbors, more gave {} values nan",
            of.join(", "),
            count(unknown)
        ));
    }
    Ok((out, notes))
}

fn kernel(x: f64, cutoff: f64, reach: f64) -> f64 {
    let u = x / reach;
    let window = bessel_i0(KAISER_BETA * (1.0 - u * u).max(0.0).sqrt());
    let z = 2.0 * std::f64::consts::PI * cutoff * x;
    let sinc = if z.abs() < 1e-9 { 1.0 } else { z.sin() / z };
    sinc * window
}

/// Modified Bessel function of order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (x / (2.0 * k)).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}
