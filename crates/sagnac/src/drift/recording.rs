//! `drift MODEL --log LOG --reference F`: the strapdown on a real log, as recorded and corrected, beside what the model
//! predicted (navigation.md §3.6).

use sagnac_core::{Compensation, Reading};
use sagnac_log::Log;
use sagnac_model::Model;
use sagnac_nav::drift::{Alignment, Scene, Setting};
use sagnac_nav::sensor::Calibration;
use sagnac_nav::strapdown::{Sculling, State, Strapdown, Vertical};
use sagnac_nav::trajectory::{PathAttitude, PathData, PathPosition};
use sagnac_nav::{Earth, Start, Trajectory};
use sagnac_report::text::{general, group_thousands};

use crate::Error;
use crate::motion::sensor_errors;
use crate::path::path_with_gaps;

/// Horizons, s.
const HORIZONS_S: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0];
const STEP_S: f64 = 10.0;
const LARGEST_GAP_S: f64 = 0.05;
const AROUND_S: f64 = 0.1;

/// A log and what it is compared with.
#[derive(Debug, Clone, Copy)]
pub struct RecordingRequest<'a> {
    /// The sensor.
    pub model: &'a Model,
    /// The log: gyro and accelerometer.
    pub log: &'a Log,
    /// Its label.
    pub log_label: &'a str,
    /// Truth log or path with attitude.
    pub reference: &'a Log,
    /// Its label.
    pub reference_label: &'a str,
    /// Start of local axes.
    pub start: Start,
    /// The Earth.
    pub earth: Earth,
}

/// Errors over the horizons.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingOutcome {
    /// The sensor's name.
    pub sensor: String,
    /// Labels of the log and of its reference.
    pub labels: [String; 2],
    /// Horizons, s.
    pub horizon_s: Vec<f64>,
    /// Starts that count.
    pub starts: Vec<usize>,
    /// RMS of the 3-D error of the log as recorded, m.
    pub raw_m: Vec<Option<f64>>,
    /// After correction.
    pub corrected_m: Vec<Option<f64>>,
    /// As the covariance predicts.
    pub predicted_m: Vec<Option<f64>>,
    /// Rows of either file that are left out, and where.
    pub warnings: Vec<String>,
}

/// One sample of the log.
struct Sample {
    time_s: f64,
    raw: [f64; 6],
    corrected: [f64; 6],
}

/// Integrates a log from many starts and compares it with its reference.
///
/// # Errors
/// A log without gyro and accelerometer, a reference without attitude, no time in common, a model that cannot be inverted.
pub fn recording(request: &RecordingRequest<'_>) -> Result<RecordingOutcome, Error> {
    let log = request.log;
    let dt = log.dt_s()?;
    // Both clocks are the files' own: times count from the log's first sample.
    let shift = match (request.reference.stamps.get(0), log.stamps.get(0)) {
        (Some(r), Some(l)) => r.since(l),
        _ => 0.0,
    };
    let (mut data, left_out) = path_with_gaps(request.reference, request.reference_label)?;
    let mut warnings: Vec<String> = left_out
        .map(|rows| rows.sentence(request.reference_label))
        .into_iter()
        .collect();
    if data.attitude == PathAttitude::Coordinated {
        return Err(Error::data("the reference has no attitude")
            .at(request.reference_label.to_owned())
            .advise("give quaternion_w…z or roll, pitch, heading columns"));
    }
    for t in &mut data.time_s {
        *t += shift;
    }
    let times = data.time_s.clone();
    let trajectory = Trajectory::from_reference(
        request.reference_label,
        request.earth,
        &request.start,
        &data,
    )
    .map_err(|e| Error::from(e).at(request.reference_label.to_owned()))?;
    let samples = samples(request, dt, &mut warnings)?;
    let (Some(first), Some(last)) = (
        samples.first().map(|s| s.time_s),
        samples.last().map(|s| s.time_s),
    ) else {
        return Err(Error::data("the log has no samples").at(request.log_label.to_owned()));
    };
    let begin = first.max(times[0]);
    let end = last.min(times[times.len() - 1]);
    if begin >= end {
        return Err(Error::data("log and reference have no time in common")
            .at(format!("{}: {first:.3} to {last:.3} s; reference: {:.3} to {:.3} s after the log's first sample", request.log_label, times[0], times[times.len() - 1]))
            .advise("both clocks must be the same; shift one file's time column"));
    }
    let log_times: Vec<f64> = samples.iter().map(|s| s.time_s).collect();
    let mut squares = vec![[0.0; 2]; HORIZONS_S.len()];
    let mut counts = vec![0usize; HORIZONS_S.len()];
    let mut predicted = vec![0.0; HORIZONS_S.len()];
    let sensor = sensor_errors(request.model)?;
    let mut start = begin;
    while start < end {
        let velocity = velocity_at(&data, &trajectory, start);
        for (h, horizon) in HORIZONS_S.into_iter().enumerate() {
            let stop = start + horizon;
            if stop > end || !covered(&log_times, &times, start, stop) {
                continue;
            }
            let Some(velocity) = velocity else { continue };
            let truth = trajectory.at(start - times[0]);
            let initial = State {
                position_e: truth.position_e,
                velocity_e: velocity,
                e_from_b: truth.e_from_b,
            };
            let target = trajectory.at(stop - times[0]);
            counts[h] += 1;
            for (k, corrected) in [false, true].into_iter().enumerate() {
                let error = integrate(request.earth, &samples, start, stop, initial, corrected)
                    .position_error_m(&target);
                squares[h][k] += error * error;
            }
            predicted[h] += predict(request, &sensor, &trajectory, &data, start, horizon, dt)?;
        }
        start += STEP_S;
    }
    let mean = |h: usize, sum: f64| (counts[h] > 0).then(|| (sum / counts[h] as f64).sqrt());
    Ok(RecordingOutcome {
        sensor: request.model.name().to_owned(),
        labels: [request.log_label, request.reference_label].map(str::to_owned),
        horizon_s: HORIZONS_S.to_vec(),
        raw_m: (0..HORIZONS_S.len())
            .map(|h| mean(h, squares[h][0]))
            .collect(),
        corrected_m: (0..HORIZONS_S.len())
            .map(|h| mean(h, squares[h][1]))
            .collect(),
        predicted_m: (0..HORIZONS_S.len())
            .map(|h| mean(h, predicted[h]))
            .collect(),
        starts: counts,
        warnings,
    })
}

fn samples(
    request: &RecordingRequest<'_>,
    dt: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Sample>, Error> {
    let log = request.log;
    let correct = Compensation::new(&sensor_errors(request.model)?.model, dt)
        .map_err(|e| Error::data(e.to_string()).at(request.model.label().to_owned()))?;
    let get = |name: &str| {
        log.channel(name).ok_or_else(|| {
            Error::data(format!("the log has no column `{name}`"))
                .at(request.log_label.to_owned())
                .advise("name its columns with --columns 'gyro=…, accel=…'")
        })
    };
    let channels = [
        get("gyro_x")?,
        get("gyro_y")?,
        get("gyro_z")?,
        get("accel_x")?,
        get("accel_y")?,
        get("accel_z")?,
    ];
    let temperature = log.channel("temperature");
    let reference_c = request.model.reference_temperature_c();
    let time: Vec<f64> = (0..log.rows).map(|k| log.time_s(k)).collect();
    // The angular acceleration for the size effect is the slope of the parabola through three samples (model.md §2).
    let slope = |c: &[f64], k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(log.rows - 1));
        if a == b || time[b] <= time[a] {
            0.0
        } else {
            (c[b] - c[a]) / (time[b] - time[a])
        }
    };
    let mut left_out = Vec::new();
    let samples: Vec<Sample> = (0..log.rows)
        .filter_map(|k| {
            let raw: [f64; 6] = std::array::from_fn(|c| channels[c][k]);
            if !raw.iter().all(|x| x.is_finite()) {
                left_out.push(k);
                return None;
            }
            let reading = Reading {
                gyro: [raw[0], raw[1], raw[2]],
                accel: [raw[3], raw[4], raw[5]],
                gyro_rate: std::array::from_fn(|c| slope(channels[c], k)),
                temperature_c: temperature.map_or(reference_c, |t| t[k]),
            };
            let y = correct.correct(&reading);
            let corrected = std::array::from_fn(|c| if c < 3 { y.gyro[c] } else { y.accel[c - 3] });
            Some(Sample {
                time_s: time[k],
                raw,
                corrected,
            })
        })
        .collect();
    if let Some(&first) = left_out.first() {
        let count = |n: usize| group_thousands(&n.to_string());
        warnings.push(format!(
            "{} of {} samples of {} {} row {} at {} s, where a value is not a finite number: a start across a gap above \
             {LARGEST_GAP_S} s does not count",
            count(left_out.len()),
            count(log.rows),
            request.log_label,
            match left_out.len() {
                1 => "is left out,",
                _ => "are left out, the first is",
            },
            count(first + 1),
            general(time[first], 9),
        ));
    }
    Ok(samples)
}

/// Whether neither file has a gap near both ends, and the log none in between.
fn covered(log: &[f64], reference: &[f64], start: f64, stop: f64) -> bool {
    // Where a file has not begun, or has ended, it has a gap as well.
    let dense = |times: &[f64], from: f64, to: f64| {
        let begin = times.partition_point(|t| *t <= from).saturating_sub(1);
        let end = times.partition_point(|t| *t < to).min(times.len() - 1);
        times[begin] - from <= LARGEST_GAP_S
            && to - times[end] <= LARGEST_GAP_S
            && times[begin..=end]
                .windows(2)
                .all(|w| w[1] - w[0] <= LARGEST_GAP_S)
    };
    dense(log, start - AROUND_S, stop + AROUND_S)
        && dense(reference, start - AROUND_S, start + AROUND_S)
        && dense(reference, stop - AROUND_S, stop + AROUND_S)
}

/// Slope at t₀ of the least-squares parabola through the reference positions within ±0.1 s, Earth axes.
fn velocity_at(data: &PathData, trajectory: &Trajectory, t0: f64) -> Option<[f64; 3]> {
    let first = data.time_s[0];
    let centre = trajectory.at(t0 - first).position_e;
    let (mut s, mut b) = ([0.0; 5], [[0.0; 3]; 3]);
    let mut n = 0;
    for &t in &data.time_s {
        let x = t - t0;
        if x.abs() <= AROUND_S + 1e-9 {
            n += 1;
            let p = trajectory.at(t - first).position_e;
            for k in 0..5 {
                s[k] += x.powi(k as i32);
            }
            for k in 0..3 {
                for i in 0..3 {
                    b[k][i] += x.powi(k as i32) * (p[i] - centre[i]);
                }
            }
        }
    }
    if n < 3 {
        return None;
    }
    // Normal equations of c0 + c1 x + c2 x², Cramer's rule for c1.
    let det = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let normal = [[s[0], s[1], s[2]], [s[1], s[2], s[3]], [s[2], s[3], s[4]]];
    let whole = det(normal);
    (whole.abs() > 0.0).then(|| {
        std::array::from_fn(|i| {
            let mut m = normal;
            for k in 0..3 {
                m[k][1] = b[k][i];
            }
            det(m) / whole
        })
    })
}

fn integrate(
    earth: Earth,
    samples: &[Sample],
    start: f64,
    stop: f64,
    initial: State,
    corrected: bool,
) -> State {
    let mut nav = Strapdown::<1>::new(earth, Sculling::Five, Vertical::Free, [initial]);
    let mut at = start;
    let first = samples.partition_point(|s| s.time_s <= start + 1e-9);
    for s in &samples[first..] {
        let to = s.time_s.min(stop);
        if to > at {
            let v = if corrected { &s.corrected } else { &s.raw };
            nav.feed(to - at, &v.map(|x| [x]), [0.0; 2]);
            at = to;
        }
        if at >= stop - 1e-9 {
            break;
        }
    }
    nav.finish();
    nav.state(0)
}

/// Mean square of the 3-D error over one start by the covariance.
fn predict(
    request: &RecordingRequest<'_>,
    sensor: &sagnac_nav::sensor::SensorErrors,
    whole: &Trajectory,
    data: &PathData,
    start: f64,
    horizon: f64,
    dt: f64,
) -> Result<f64, Error> {
    // The same path from the start on, as points of the spline.
    let first = data.time_s[0];
    let begin = data
        .time_s
        .partition_point(|t| *t < start)
        .saturating_sub(1);
    let end = (data.time_s.partition_point(|t| *t <= start + horizon) + 1).min(data.time_s.len());
    let mut times = vec![start];
    times.extend(
        data.time_s[begin..end]
            .iter()
            .copied()
            .filter(|t| *t > start + 1e-6 && *t < start + horizon - 1e-6),
    );
    times.push(start + horizon);
    let motions: Vec<_> = times.iter().map(|t| whole.motion(t - first)).collect();
    let piece = PathData {
        time_s: times,
        position: PathPosition::Geodetic(
            motions
                .iter()
                .map(|m| [m.latitude_rad, m.longitude_rad, m.height_m])
                .collect(),
        ),
        attitude: PathAttitude::Quaternion(motions.iter().map(|m| m.quaternion).collect()),
    };
    let trajectory =
        Trajectory::from_reference("reference", request.earth, &request.start, &piece)?;
    let setting = Setting {
        duration_s: horizon,
        dt_s: dt.min(horizon),
        vertical: Vertical::Free,
        alignment: Alignment::Perfect,
        calibration: Calibration::Model,
    };
    let reference = request.model.reference_temperature_c();
    let found = Scene::new(&trajectory, setting, &|_| reference)?.covariance(sensor)?;
    Ok(found
        .total
        .last()
        .map_or(0.0, |s| s.variance[..3].iter().sum()))
}
