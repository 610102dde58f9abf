//! `convert`: a log in another format, cut, turned, resampled only when asked.
//!
//! Resampling: y(t) = Σ x_k h(t − t_k)/Σ h(t − t_k), h a sinc of 0.45·min(f_in, f_out) under a Kaiser window (80 dB).

mod grid;
mod resample;

use sagnac_log::{
    Block, Cadence, Issue, IssueKind, Layout, Log, LogReader, Stamp, WriteFormat, WriteSeek, create,
};
use sagnac_model::Model;
use sagnac_model::export::ros_covariances;
use sagnac_report::text::{Document, duration, general, group_thousands};
use serde_json::{Value, json};

use crate::Error;
use crate::clock::GivenRate;
use crate::findings::{finding, number};

/// What is wanted.
#[derive(Debug, Clone)]
pub struct ConvertRequest {
    /// The format to write.
    pub format: WriteFormat,
    /// A new rate, with an anti-alias filter.
    pub resample_hz: Option<f64>,
    /// The sensor's model, whose white noise gives the covariances of ROS messages.
    pub model: Option<Model>,
}

/// What was written.
#[derive(Debug, Clone)]
pub struct ConvertOutcome {
    /// The source.
    pub layout: Layout,
    /// Rows written.
    pub samples: u64,
    /// Their rate.
    pub rate_hz: f64,
    /// samples/rate, or from the first to the last stamp and one interval.
    pub duration_s: f64,
    /// Gaps and steps back in the source; nothing was filled in.
    pub issues: Vec<Issue>,
    /// What the user has to know.
    pub notes: Vec<String>,
    first_s: f64,
}

/// Reads a log and writes it as another, in bounded memory unless it is resampled.
///
/// # Errors
/// Those of reading and writing; a log without rows.
pub fn convert(
    reader: &mut dyn LogReader,
    output: Box<dyn WriteSeek>,
    request: &ConvertRequest,
) -> Result<ConvertOutcome, Error> {
    let holds_increments = reader.layout().channels.iter().any(|c| c.is_increment);
    let mut watch = Watch::default();
    let mut given = GivenRate::of(reader.layout());
    if request.resample_hz.is_none() && !holds_increments {
        let mut layout = reader.layout().clone();
        let mut block = Block::default();
        let mut is_more = reader.read_block(&mut block)?;
        let of_stamps = Cadence::of(&block.stamps).map(|cadence| 1.0 / cadence.dt_s);
        let said = set_covariances(&mut layout, request, of_stamps)?;
        let mut writer = create(request.format, output, &layout)?;
        while is_more {
            watch.see(&block);
            if let Some(given) = &mut given {
                block.stamps = given.stamps(&block.stamps);
            }
            writer.write_block(&block)?;
            is_more = reader.read_block(&mut block)?;
        }
        let mut notes: Vec<String> = said.into_iter().chain(writer.finish()?).collect();
        watch.count(given, &mut notes);
        return watch.outcome(reader.layout().clone(), notes);
    }
    let mut log = Log::read(reader)?;
    let source = log.layout.clone();
    let mut notes = Vec::new();
    if let Some(mut given) = given {
        log.stamps = given.stamps(&log.stamps);
        notes.extend(given.note());
    }
    let mut before = Watch::default();
    if let Some(rate) = request.resample_hz {
        before.bridged_s = resample::LONGEST_BRIDGE * log.dt_s()?;
        for block in log.blocks() {
            before.see(&block);
        }
        let (resampled, said) = resample::resample(&log, rate)?;
        log = resampled;
        // Those of the source are of its own samples.
        log.layout.covariances = None;
        notes.extend(said);
    }
    let of_log = log.dt_s().ok().map(|dt_s| 1.0 / dt_s);
    notes.extend(set_covariances(&mut log.layout, request, of_log)?);
    let mut writer = create(request.format, output, &log.layout)?;
    for block in log.blocks() {
        watch.see(&block);
        writer.write_block(&block)?;
    }
    notes.extend(writer.finish()?);
    let mut outcome = watch.outcome(
        Layout {
            rate_hz: log.layout.rate_hz,
            ..source
        },
        notes,
    )?;
    if let Some(rate) = request.resample_hz {
        outcome.rate_hz = rate;
        before.say_more();
        outcome.issues = before.issues;
    }
    Ok(outcome)
}

/// Covariances of the messages from the model, if one was given, and the sentence about them.
///
/// Their rate is the log's, given or by its stamps, else the model's.
fn set_covariances(
    layout: &mut Layout,
    request: &ConvertRequest,
    of_stamps: Option<f64>,
) -> Result<Option<String>, Error> {
    let Some(model) = &request.model else {
        return Ok(None);
    };
    if !matches!(request.format, WriteFormat::Mcap | WriteFormat::Bag) {
        return Err(Error::usage(
            "a model gives the covariances of ROS messages, and this format has none",
        )
        .at("--model")
        .advise("write .mcap or .bag, or leave --model out"));
    }
    let of_log = layout.rate_hz.or(of_stamps);
    layout.covariances = Some(ros_covariances(model, of_log)?);
    let rate = of_log.or(model.sample_rate_hz());
    Ok(Some(format!(
        "covariances are N² f of {} at {} Hz",
        model.name(),
        general(rate.unwrap_or(f64::NAN), 6)
    )))
}

/// Follows the stamps of a stream.
#[derive(Default)]
struct Watch {
    rows: u64,
    first: Option<Stamp>,
    last: f64,
    cadence: Option<Cadence>,
    steps: f64,
    regular: u64,
    issues: Vec<Issue>,
    more: u64,
    /// Stamps that are no finite number: how many, and the row of the first, from 1.
    no_number: (u64, u64),
    /// Steps that are bridged are no gaps.
    bridged_s: f64,
    /// What jumps back take from the stamps: with it, time goes on.
    back_s: f64,
    /// Such stamps since the last that is one.
    lost: f64,
    /// Of the last row from the first, where a rate was given beside the stamps.
    last_written_s: Option<f64>,
}

impl Watch {
    /// Takes over what a given rate made of the stamps.
    fn count(&mut self, given: Option<GivenRate>, notes: &mut Vec<String>) {
        if let Some(given) = given {
            self.last_written_s = Some(given.last_s);
            notes.extend(given.note());
        }
    }

    fn see(&mut self, block: &Block) {
        let before = self.rows;
        self.rows += block.rows as u64;
        let is_number = |t: &Stamp| t.seconds().is_finite();
        let mut stamps = (0..block.stamps.len()).filter_map(|k| block.stamps.get(k));
        let Some(origin) = stamps.find(is_number) else {
            (before + 1..)
                .take(block.stamps.len())
                .for_each(|row| self.lose(row));
            return;
        };
        let is_first_block = self.first.is_none();
        let first = *self.first.get_or_insert(origin);
        let times = block.stamps.since(first);
        if self.cadence.is_none() {
            self.cadence = Cadence::of(&block.stamps);
        }
        let longest = self.cadence.map_or(f64::INFINITY, |c| c.longest_s);
        // Coarse stamps, and such that arrive together, may be equal.
        let may_be_equal = self.cadence.is_some_and(|c| c.is_coarse);
        let mut is_first = is_first_block;
        for (row, &t) in (before + 1..).zip(&times) {
            if !t.is_finite() {
                self.lose(row);
                continue;
            }
            let step = t - self.last;
            // A row whose stamp is no number is an interval all the same.
            let lost = std::mem::take(&mut self.lost);
            if !is_first {
                if step > self.bridged_s.max(longest * (1.0 + lost)) {
                    self.push(
                        IssueKind::Gap,
                        t - step,
                        t,
                        format!("{}; nothing was filled in", duration(step)),
                    );
                } else if step < 0.0 {
                    self.push(
                        IssueKind::Backwards,
                        t,
                        t,
                        format!("time goes back by {}", duration(-step)),
                    );
                    // Stamps that scatter may go back by less than an interval.
                    let dt = self.cadence.map_or(0.0, |c| c.dt_s);
                    if -step > dt {
                        self.back_s += dt - step;
                    }
                } else if step > 0.0 || (step == 0.0 && may_be_equal) {
                    self.steps += step;
                    self.regular += 1 + lost as u64;
                }
            }
            self.last = t;
            is_first = false;
        }
    }

    /// Counts a stamp that is no finite number.
    fn lose(&mut self, row: u64) {
        if self.no_number.0 == 0 {
            self.no_number.1 = row;
        }
        self.no_number.0 += 1;
        self.lost += 1.0;
    }

    fn push(&mut self, kind: IssueKind, start: f64, end: f64, text: String) {
        if self.issues.len() >= 100 {
            self.more += 1;
            return;
        }
        let first = self.first.map_or(0.0, Stamp::seconds);
        let (start_s, end_s) = (first + start, first + end);
        self.issues.push(Issue {
            kind,
            channel: Some("time".to_owned()),
            start_s,
            end_s,
            count: 1,
            text,
        });
    }

    /// Counts the issues beyond those that are listed.
    fn say_more(&mut self) {
        if let (Some(last), true) = (self.issues.last_mut(), self.more > 0) {
            last.text += &format!("; and {} more", self.more);
        }
    }

    fn outcome(mut self, layout: Layout, mut notes: Vec<String>) -> Result<ConvertOutcome, Error> {
        if self.rows == 0 {
            return Err(Error::data("the log has no samples"));
        }
        self.say_more();
        let is_still = self.rows > 1 && self.regular == 0 && self.issues.is_empty();
        let no_rate = match self.rows - self.no_number.0 {
            _ if self.no_number.0 == 0 => is_still.then_some("time never advances"),
            0 => Some("no time stamp is a number"),
            1 => Some("one time stamp alone is a number"),
            _ => None,
        };
        if let Some(what) = no_rate
            && layout.has_time
            && layout.rate_hz.is_none()
        {
            return Err(Error::data(what)
                .at("time")
                .advise("add --rate, for instance --rate 100Hz"));
        }
        let dt = match layout.rate_hz {
            Some(rate) => 1.0 / rate,
            None if self.regular > 0 => self.steps / self.regular as f64,
            None => f64::NAN,
        };
        let duration_s = if let Some(last_s) = self.last_written_s {
            last_s + dt
        } else if layout.has_time && self.first.is_some() {
            self.last + self.back_s + dt
        } else {
            self.rows as f64 * dt
        };
        let mut all = layout.notes.clone();
        all.append(&mut notes);
        if self.no_number.0 > 0 && self.last_written_s.is_none() {
            let row = group_thousands(&self.no_number.1.to_string());
            all.push(match self.no_number.0 {
                1 => format!("the time stamp of row {row} is no finite number, and stays as it is"),
                n => format!(
                    "{} time stamps are no finite numbers, the first in row {row}, and stay as they are",
                    group_thousands(&n.to_string())
                ),
            });
        }
        Ok(ConvertOutcome {
            samples: self.rows,
            rate_hz: 1.0 / dt,
            duration_s,
            issues: self.issues,
            notes: all,
            first_s: self.first.map_or(0.0, Stamp::seconds),
            layout,
        })
    }
}

impl ConvertOutcome {
    /// The JSON document; `files` as they were named.
    pub fn to_json(&self, files: &[String]) -> Value {
        json!({
            "files": files,
            "samples": self.samples,
            "rate_hz": number(self.rate_hz),
            "duration_s": number(self.duration_s),
            "issues": self.issues.iter().map(crate::findings::issue_json).collect::<Vec<_>>(),
            "notes": self.notes,
        })
    }

    /// The text, without the lines that name the files.
    pub fn document(&self) -> Document {
        let mut d = Document::new();
        let topic = self.layout.topic.as_ref().map_or_else(
            || self.layout.format.clone(),
            |t| format!("{t}, {}", self.layout.format),
        );
        let count = group_thousands(&self.samples.to_string());
        let samples = if self.samples == 1 {
            "sample"
        } else {
            "samples"
        };
        d.paragraph(if self.rate_hz.is_finite() {
            format!(
                "{topic}: {count} {samples}, {}, {} Hz.",
                duration(self.duration_s),
                general(self.rate_hz, 6)
            )
        } else {
            format!("{topic}: {count} {samples}, too few for a rate.")
        });
        if let Some(frame) = &self.layout.frame {
            d.paragraph(format!("Axes: {frame}."));
        }
        for note in &self.notes {
            d.note(note.clone());
        }
        d.findings(
            self.issues
                .iter()
                .map(|i| finding(i, self.first_s, self.duration_s)),
        );
        d
    }
}
