//! `strapdown`: position, velocity and attitude from a log, beginning at a reference's first row (navigation.md §2).
//!
//! The start velocity is the reference's own where it states one (`velocity_north`, `_east`, `_down`), else the slope of
//! the spline through its positions.

use sagnac_core::Sensor;
use sagnac_log::{Block, Channel, Layout, Log, LogWriter, Stamps};
use sagnac_nav::attitude::mul_vec;
use sagnac_nav::strapdown::{Sculling, State, Strapdown, Vertical};
use sagnac_nav::trajectory::{Motion, PathAttitude};
use sagnac_nav::{Earth, Start, Trajectory};
use sagnac_report::text::{Document, Style, duration, group_thousands, significant};
use serde_json::{Value, json};

use crate::Error;
use crate::path::{path_with_gaps, velocities};

/// What to integrate.
#[derive(Debug, Clone, Copy)]
pub struct StrapdownRequest<'a> {
    /// Gyro and accelerometer.
    pub log: &'a Log,
    /// Its label.
    pub log_label: &'a str,
    /// Truth log, or path with attitude.
    pub reference: &'a Log,
    /// Its label.
    pub reference_label: &'a str,
    /// Start of local axes.
    pub start: Start,
    /// Earth.
    pub earth: Earth,
    /// Vertical channel.
    pub vertical: Vertical,
    /// Form.
    pub sculling: Sculling,
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub struct StrapdownOutcome {
    /// Samples integrated.
    pub samples: usize,
    /// Length, s.
    pub duration_s: f64,
    /// Where it ends.
    pub end: Motion,
    /// Distance to the reference at the end, m, where the reference reaches so far.
    pub end_error_m: Option<f64>,
    /// Whether the start velocity is the one that the reference states, not the slope of its positions.
    pub has_stated_velocity: bool,
    /// Files written, filled in by the caller.
    pub files: Vec<String>,
    /// Gaps that were bridged.
    pub gaps: usize,
    /// The sentence on rows of the reference that are left out, if any.
    pub left_out: Option<String>,
}

const NAMES: [(&str, &str); 13] = [
    ("latitude", "deg"),
    ("longitude", "deg"),
    ("height", "m"),
    ("velocity_north", "m/s"),
    ("velocity_east", "m/s"),
    ("velocity_down", "m/s"),
    ("quaternion_w", ""),
    ("quaternion_x", ""),
    ("quaternion_y", ""),
    ("quaternion_z", ""),
    ("roll", "deg"),
    ("pitch", "deg"),
    ("heading", "deg"),
];

/// The layout of the log that [`strapdown`] writes.
pub fn layout(log: &Log) -> Layout {
    Layout {
        channels: NAMES
            .iter()
            .map(|(name, unit)| Channel::other(name, unit))
            .collect(),
        has_time: !log.stamps.is_empty(),
        rate_hz: log.layout.rate_hz,
        ..Layout::default()
    }
}

fn row(m: &Motion) -> [f64; 13] {
    let [w, x, y, z] = m.quaternion;
    let [n, e, d] = m.velocity_n;
    [
        m.latitude_rad.to_degrees(),
        m.longitude_rad.to_degrees(),
        m.height_m,
        n,
        e,
        d,
        w,
        x,
        y,
        z,
        m.roll_rad.to_degrees(),
        m.pitch_rad.to_degrees(),
        m.heading_rad.to_degrees(),
    ]
}

/// Integrates a log and writes one row a sample.
///
/// # Errors
/// A log without gyro or accelerometer, with values that are not finite, or with time that goes backwards; a reference
/// without attitude or outside the log's time.
pub fn strapdown(
    request: &StrapdownRequest<'_>,
    writer: &mut dyn LogWriter,
) -> Result<StrapdownOutcome, Error> {
    let log = request.log;
    let dt = log.dt_s()?;
    let mut channels = Vec::new();
    for sensor in Sensor::ALL {
        for axis in ["x", "y", "z"] {
            let name = format!("{}_{axis}", sensor.key());
            channels.push(log.channel(&name).ok_or_else(|| {
                Error::data(format!("the log has no column `{name}`"))
                    .at(request.log_label.to_owned())
                    .advise("name its columns with --columns 'gyro=…, accel=…'")
            })?);
        }
    }
    let (mut data, left_out) = path_with_gaps(request.reference, request.reference_label)?;
    if data.attitude == PathAttitude::Coordinated {
        return Err(Error::data("the reference has no attitude")
            .at(request.reference_label.to_owned())
            .advise("give quaternion_w…z or roll, pitch, heading columns"));
    }
    let shift = match (request.reference.stamps.get(0), log.stamps.get(0)) {
        (Some(r), Some(l)) => r.since(l),
        _ => 0.0,
    };
    for t in &mut data.time_s {
        *t += shift;
    }
    let first_s = data.time_s[0];
    let trajectory = Trajectory::from_reference(
        request.reference_label,
        request.earth,
        &request.start,
        &data,
    )
    .map_err(|e| Error::from(e).at(request.reference_label.to_owned()))?;
    let reach_s = trajectory.last_time_s().unwrap_or(0.0);
    // A sample belongs to the interval that ends at its time; those before the reference's first row are not integrated.
    let begin = (0..log.rows)
        .find(|&k| log.time_s(k) > first_s + 1e-9)
        .ok_or_else(|| {
            Error::data("the reference begins after the log ends")
                .at(request.reference_label.to_owned())
                .advise("both clocks must be the same; shift one file's time column")
        })?;
    let mut previous = first_s;
    if log.time_s(begin) - dt > first_s + 0.5 * dt {
        // The log begins later than the reference: the state is taken one interval before its first sample.
        previous = log.time_s(begin) - dt;
    }
    let truth = |t: f64| trajectory.at((t - first_s).clamp(0.0, reach_s));
    let mut initial: State = truth(previous).into();
    let stated = stated_velocity(request, previous)?;
    if let Some(velocity_n) = stated {
        let place = truth(previous).place;
        initial.velocity_e = mul_vec(&place.e_from_n(), velocity_n);
    }
    let mut nav = Strapdown::<1>::new(request.earth, request.sculling, request.vertical, [initial]);
    let mut block = Block::with_columns(NAMES.len());
    let mut gaps = 0;
    let mut written = begin;
    let start_time = previous;
    let mut flush = |block: &mut Block, from: usize, to: usize| -> Result<(), Error> {
        if to > from {
            block.stamps = slice(&log.stamps, from, to);
            block.rows = to - from;
            writer.write_block(block)?;
            block.clear();
        }
        Ok(())
    };
    for k in begin..log.rows {
        let time = log.time_s(k);
        let step = time - previous;
        if step <= 0.0 {
            return Err(Error::data(format!("time does not advance at {time} s"))
                .at(format!("{}, row {}", request.log_label, k + 1))
                .advise("cut it with --end"));
        }
        if step > 1.5 * dt {
            gaps += 1;
        }
        let sample: [[f64; 1]; 6] = std::array::from_fn(|c| [channels[c][k]]);
        if !sample.iter().all(|x| x[0].is_finite()) {
            return Err(Error::data("a value is not a finite number")
                .at(format!("{}, row {}", request.log_label, k + 1))
                .advise("cut it out with --start or --end"));
        }
        let held = if request.vertical == Vertical::Free {
            [0.0; 2]
        } else {
            let p = truth(time);
            [
                p.place.height_m,
                sagnac_nav::attitude::dot(p.place.normal_e, p.velocity_e),
            ]
        };
        nav.feed(step, &sample, held);
        previous = time;
        if k + 1 == log.rows {
            nav.close();
        }
        loop {
            let before = nav.steps_done();
            nav.run_to(before + 1);
            if nav.steps_done() == before {
                break;
            }
            for (column, value) in block
                .columns
                .iter_mut()
                .zip(row(&nav.state(0).motion(request.earth)))
            {
                column.push(value);
            }
            let done = begin + nav.steps_done() as usize;
            if done - written >= 4096 {
                flush(&mut block, written, done)?;
                written = done;
            }
        }
    }
    flush(&mut block, written, log.rows)?;
    let state = nav.state(0);
    let end_error_m = (previous - first_s <= reach_s + 0.5 * dt)
        .then(|| state.position_error_m(&truth(previous)));
    Ok(StrapdownOutcome {
        samples: log.rows - begin,
        duration_s: previous - start_time,
        end: state.motion(request.earth),
        end_error_m,
        has_stated_velocity: stated.is_some(),
        files: Vec::new(),
        gaps,
        left_out: left_out.map(|rows| rows.sentence(request.reference_label)),
    })
}

/// The velocity north, east, down of the reference's row at this time of the log, where it states one: the slope of
/// the spline at its end magnifies the last digit of the positions to 1e-6 m/s, which a free height turns into metres.
fn stated_velocity(request: &StrapdownRequest<'_>, time_s: f64) -> Result<Option<[f64; 3]>, Error> {
    let reference = request.reference;
    let Some(columns) = velocities(reference, request.reference_label)? else {
        return Ok(None);
    };
    let time_of = |k: usize| match (reference.stamps.get(k), request.log.stamps.get(0)) {
        (Some(row), Some(first)) => row.since(first),
        _ => reference.time_s(k),
    };
    let row = (0..reference.rows).find(|&k| (time_of(k) - time_s).abs() < 1e-8);
    Ok(row
        .map(|k| [0, 1, 2].map(|i: usize| columns[i][k]))
        .filter(|v| v.iter().all(|x| x.is_finite())))
}

fn slice(stamps: &Stamps, from: usize, to: usize) -> Stamps {
    let mut out = stamps.clone();
    if !out.is_empty() {
        out.keep(from..to);
    }
    out
}

impl StrapdownOutcome {
    /// `{"files", "samples", "duration_s", "end": {…}, "end_error_m"}`.
    pub fn to_json(&self) -> Value {
        let m = &self.end;
        json!({
            "files": self.files,
            "samples": self.samples,
            "duration_s": self.duration_s,
            "end": {
                "latitude_rad": m.latitude_rad,
                "longitude_rad": m.longitude_rad,
                "height_m": m.height_m,
                "velocity_m_s": m.velocity_n,
                "quaternion": m.quaternion,
                "roll_rad": m.roll_rad,
                "pitch_rad": m.pitch_rad,
                "heading_rad": m.heading_rad,
            },
            "end_error_m": self.end_error_m,
            "start_velocity": if self.has_stated_velocity { "stated" } else { "slope" },
            "gaps": self.gaps,
        })
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut doc = Document::new();
        let m = &self.end;
        doc.paragraph(format!(
            "Integrated {} samples, {}, from the velocity that {}.",
            group_thousands(&self.samples.to_string()),
            duration(self.duration_s),
            if self.has_stated_velocity {
                "the reference states"
            } else {
                "the slope of the reference's positions gives"
            }
        ));
        doc.paragraph(format!(
            "It ends at {:.7} deg, {:.7} deg, {} m, heading {:.2} deg, {} m/s over ground.",
            m.latitude_rad.to_degrees(),
            m.longitude_rad.to_degrees(),
            significant(m.height_m, 5),
            m.heading_rad.to_degrees(),
            significant(m.velocity_n[0].hypot(m.velocity_n[1]), 4)
        ));
        if let Some(error) = self.end_error_m {
            doc.paragraph(format!(
                "The reference is then {} m away.",
                significant(error, 3)
            ));
        }
        doc
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}
