//! Another rate by a windowed sinc: cutoff 0.45·min(f_in, f_out), 32 lobes, Kaiser window β = 8 (80 dB).

use sagnac_log::health::{self, HealthOptions, Segment};
use sagnac_log::{Channel, Layout, Log, Stamp, Stamps};
use sagnac_report::text::{duration, general};

use crate::Error;

/// Zero crossings of the sinc on each side.
const LOBES: f64 = 16.0;
const KAISER_BETA: f64 = 8.0;

/// The log at `rate_hz`, stretch by stretch between gaps, and the sentence about it.
pub(super) fn resample(log: &Log, rate_hz: f64) -> Result<(Log, String), Error> {
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(Error::usage("the new rate must be positive")
            .at("--resample")
            .advise("write for instance --resample 100Hz"));
    }
    let health = health::check(
        log,
        &HealthOptions {
            moving: true,
            ..HealthOptions::default()
        },
    )?;
    let dt = health.dt_s;
    let ratio = 1.0 / (dt * rate_hz);
    let rows = log.rows as f64 / ratio;
    if rows > 1e10 {
        return Err(Error::usage(format!(
            "{} Hz would give {} samples",
            general(rate_hz, 6),
            general(rows, 2)
        ))
        .at("--resample")
        .advise("choose a lower rate"));
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
    // In units of input samples: cutoff in cycles a sample.
    let cutoff = 0.45 * (1.0 / ratio).min(1.0);
    let reach = LOBES / (2.0 * cutoff);
    let reference = stretches(log)?;
    let mut out = Log {
        layout: log.layout.clone(),
        columns: vec![Vec::new(); log.columns.len()],
        ..Log::default()
    };
    out.layout.rate_hz = Some(rate_hz);
    // Without time the first row ends its interval at dt, as `Stamp::of_row` has it.
    let origin = log.stamps.get(0).unwrap_or(Stamp::of_row(1, 1.0 / dt));
    let mut stamps = Stamps::default();
    for segment in &reference {
        let n = segment.range.len();
        let new = ((n - 1) as f64 / ratio).floor() as usize + 1;
        for k in 0..new {
            let at = k as f64 * ratio;
            let (from, to) = (
                (at - reach).ceil().max(0.0) as usize,
                ((at + reach).floor() as usize).min(n - 1),
            );
            let weights: Vec<f64> = (from..=to)
                .map(|j| kernel(j as f64 - at, cutoff, reach))
                .collect();
            let total: f64 = weights.iter().sum();
            for (column, h) in out.columns.iter_mut().zip(&health.channels) {
                let part = h
                    .values
                    .get(segment.range.start + from..=segment.range.start + to)
                    .unwrap_or(&[]);
                let sum: f64 = part.iter().zip(&weights).map(|(v, w)| v * w).sum();
                column.push(sum / total);
            }
            let t = segment.start_s + k as f64 / rate_hz;
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
    let note = format!(
        "resampled from {} Hz to {} Hz, low-passed at {} Hz against aliases; its noise above that is gone",
        general(1.0 / dt, 9),
        general(rate_hz, 9),
        general(cutoff / dt, 9)
    );
    Ok((out, note))
}

/// The stretches between gaps of time, whatever the channels hold: those of a channel that is always sound.
fn stretches(log: &Log) -> Result<Vec<Segment>, Error> {
    let beat = Log {
        layout: Layout {
            channels: vec![Channel::other("beat", "")],
            texts: Vec::new(),
            ..log.layout.clone()
        },
        stamps: log.stamps.clone(),
        columns: vec![(0..log.rows).map(|k| (k * 7919 % 13) as f64).collect()],
        rows: log.rows,
        ..Log::default()
    };
    let options = HealthOptions {
        moving: true,
        ..HealthOptions::default()
    };
    let health = health::check(&beat, &options)?;
    let first = health.channels.into_iter().next();
    Ok(first.map(|channel| channel.segments).unwrap_or_default())
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
