//! The health of a log that goes by in sections: what each tells of its own rows, and what they tell together.
//!
//! Findings of places are those of the section that owns the rows; what goes on over a border is one. Of the whole log are
//! interval, duration, mean, scatter and extremes, exactly, and what follows from them.

use super::channel;
use super::found::Found;
use super::listing::Listing;
use super::moments::Moments;
use super::{Health, HealthOptions, is_sensor, look, no_numbers, short, sound};
use crate::clock::median;
use crate::{Channel, Error, Issue, IssueKind, Section};

/// The health of a section, of which the findings are not told yet.
pub struct SectionHealth<'a> {
    /// Its channels, those of its neighbors' rows among them that it holds; without findings.
    pub health: Health<'a>,
    found: Vec<Found>,
    /// Times of its own first and last row on the log's clock, before wraps of earlier sections.
    ends_s: (f64, f64),
    /// From its own first row to that of the next section.
    span_s: f64,
    /// Its own rows at which a counter wraps, with what that adds.
    wraps: Vec<(u64, f64)>,
}

impl SectionHealth<'_> {
    /// Whether the sensor was moved.
    pub fn has_motion(&self) -> bool {
        self.found.iter().any(|f| f.issue.kind == IssueKind::Motion)
    }

    /// Takes over the motion of the same section, looked at as one at rest.
    pub fn keep_motion(&mut self, rest: Self) {
        let is_motion = |f: &Found| f.issue.kind == IssueKind::Motion;
        self.found.extend(rest.found.into_iter().filter(is_motion));
    }
}

/// Checks a section of a log; `known_s` is the interval of the sections before.
///
/// # Errors
/// The first section's stamps never advance, and no rate.
pub fn check_section<'a>(
    section: &Section<'a>,
    options: &HealthOptions,
    known_s: Option<f64>,
) -> Result<SectionHealth<'a>, Error> {
    let own = &section.own;
    let (health, found, clock) = look(section.log, options, own, known_s)?;
    let found = found.into_iter().filter_map(|f| f.within(own, &clock));
    let last = own.end - 1;
    let span_s = if section.is_last {
        clock.span_s(own.start, last) + clock.dt_s
    } else {
        clock.span_s(own.start, own.end)
    };
    let wraps = clock.beat.wraps.iter().filter(|w| own.contains(&w.0));
    Ok(SectionHealth {
        found: sound(found.collect()),
        ends_s: (clock.absolute(own.start), clock.absolute(last)),
        span_s,
        wraps: wraps
            .map(|&(row, turn)| (section.before + row as u64, turn))
            .collect(),
        health,
    })
}

/// What the sections of a log tell together.
#[derive(Debug, Default)]
pub struct Gathering {
    rows: u64,
    ends_s: (f64, f64),
    span_s: f64,
    has_stamps: bool,
    /// Interval of the first section, and by how much those of all are longer, summed over their rows.
    dt_s: Option<f64>,
    longer_s: f64,
    stamp_step_s: Option<f64>,
    wraps: Vec<(u64, f64)>,
    channels: Vec<Totals>,
    /// Of |f| and |w|.
    lengths: [Moments; 2],
    listing: Listing,
    notes: Vec<String>,
}

/// A channel so far.
#[derive(Debug, Default, Clone)]
struct Totals {
    all: Moments,
    extremes: Option<[f64; 2]>,
    /// The same without the rows in which it is stuck.
    sound: Moments,
    sound_extremes: Option<[f64; 2]>,
    is_stuck: bool,
    lsb: Option<f64>,
    has_no_grid: bool,
    /// Of each section.
    sigma_w: Vec<f64>,
}

/// The health of a log that went by in sections.
#[derive(Debug, Clone, PartialEq)]
pub struct InSections {
    /// As in [`Health`].
    pub dt_s: f64,
    /// As in [`Health`].
    pub first_s: f64,
    /// Time of the last row on the log's own clock.
    pub last_s: f64,
    /// As in [`Health`].
    pub duration_s: f64,
    /// As in [`Health`].
    pub stamp_step_s: Option<f64>,
    /// Rows.
    pub rows: u64,
    /// Findings, as in [`Health`].
    pub issues: Vec<Issue>,
    /// Mean, standard deviation, smallest and largest value and step of the values' grid of each channel; without what is
    /// stuck.
    pub channels: Vec<([f64; 4], Option<f64>)>,
    /// Mean of |f| [m/s²], as by [`super::mean_force`].
    pub force_m_s2: Option<f64>,
    /// As in [`Health`].
    pub notes: Vec<String>,
}

impl Gathering {
    /// The interval so far.
    pub fn dt_s(&self) -> Option<f64> {
        self.dt_s
    }

    /// Adds the next section.
    pub fn add(&mut self, section: &Section<'_>, of: SectionHealth<'_>) {
        let (log, own) = (section.log, &section.own);
        let rows = own.len() as f64;
        // What its stamps do not tell: that counters wrapped, or how many rows came before.
        let earlier = self.wraps.iter().filter(|w| w.0 <= section.before);
        let mut late_s: f64 = earlier.map(|w| w.1).sum();
        self.has_stamps |= !log.stamps.is_empty();
        if !self.has_stamps {
            late_s += section.before as f64 * of.health.dt_s;
        }
        self.wraps.extend(of.wraps);
        let (start_s, end_s) = (of.ends_s.0 + late_s, of.ends_s.1 + late_s);
        if self.rows == 0 {
            self.ends_s.0 = start_s;
            self.stamp_step_s = of.health.stamp_step_s;
            self.channels = vec![Totals::default(); log.columns.len()];
        }
        self.ends_s.1 = end_s;
        self.span_s += of.span_s;
        self.rows += own.len() as u64;
        let first_dt_s = *self.dt_s.get_or_insert(of.health.dt_s);
        self.longer_s += rows * (of.health.dt_s - first_dt_s);
        for note in of.health.notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        for (totals, (column, health)) in self
            .channels
            .iter_mut()
            .zip(log.columns.iter().zip(&of.health.channels))
        {
            let is_own = |f: &&Found| {
                f.issue.kind == IssueKind::Stuck && f.issue.channel.as_ref() == Some(&health.name)
            };
            let mut stuck: Vec<_> = of
                .found
                .iter()
                .filter(is_own)
                .map(|f| f.rows.clone())
                .collect();
            stuck.sort_by_key(|r| r.start);
            totals.add(&column[own.clone()], own.start, &stuck);
            match health.lsb {
                Some(lsb) => totals.lsb = Some(totals.lsb.map_or(lsb, |l| l.min(lsb))),
                None => totals.has_no_grid |= health.std > 0.0,
            }
            totals
                .sigma_w
                .extend(Some(health.sigma_w).filter(|s| *s > 0.0));
        }
        for (all, part) in self.lengths.iter_mut().zip(channel::lengths(log, own)) {
            all.join(&part);
        }
        let mut found = of.found;
        for f in &mut found {
            f.issue.start_s += late_s;
            f.issue.end_s += late_s;
        }
        self.listing.add(found, of.health.dt_s);
    }

    /// What they tell; of a sensor that was carried about nothing that is told of one at rest.
    ///
    /// # Errors
    /// No sections, or not a single number.
    pub fn finish(mut self, channels: &[Channel], is_moving: bool) -> Result<InSections, Error> {
        let Some(first_dt_s) = self.dt_s else {
            return Err(Error::no_samples());
        };
        if !self.channels.is_empty() && self.channels.iter().all(|c| c.all.count == 0) {
            return Err(no_numbers());
        }
        let dt_s = first_dt_s + self.longer_s / self.rows as f64;
        if is_moving {
            self.listing.forget(&[IssueKind::Motion]);
        }
        let (start_s, end_s) = self.ends_s;
        // A sum over sections would leave its last digits in a duration that the rate gives.
        let duration_s = if self.has_stamps {
            self.span_s
        } else {
            self.rows as f64 * dt_s
        };
        let mut whole = Vec::new();
        let mut push = |kind, channel: Option<&str>, text| {
            let issue = Issue {
                kind,
                channel: channel.map(str::to_owned),
                start_s,
                end_s: end_s.max(start_s),
                count: self.rows,
                text,
            };
            whole.push(Found::event(issue, 0..0));
        };
        let mut told = Vec::with_capacity(channels.len());
        for (channel, totals) in channels.iter().zip(&mut self.channels) {
            let extremes = totals.extremes.unwrap_or([f64::NAN; 2]);
            self.listing
                .correct(&channel.name, totals.all.count, extremes);
            let lsb = totals.lsb.filter(|_| !totals.has_no_grid);
            let sigma_w = median(&mut totals.sigma_w).unwrap_or(0.0);
            if is_sensor(channel.quantity)
                && let Some(text) = channel::quantization(sigma_w, lsb)
            {
                push(IssueKind::Quantization, Some(&channel.name), text);
            }
            told.push((totals.numbers(), lsb));
        }
        if !is_moving && let Some(text) = channel::units(self.lengths) {
            push(IssueKind::Units, None, text);
        }
        if let Some(text) = short(self.rows, duration_s) {
            push(IssueKind::Short, None, text);
        }
        self.listing.add(whole, dt_s);
        Ok(InSections {
            dt_s,
            first_s: start_s,
            last_s: end_s,
            duration_s,
            stamp_step_s: self.stamp_step_s,
            rows: self.rows,
            issues: self.listing.finish(start_s),
            channels: told,
            force_m_s2: self.lengths[0].mean(),
            notes: self.notes,
        })
    }
}

impl Totals {
    /// Adds a section's own values, of which the first stands in row `first`, and the rows in which they are stuck.
    fn add(&mut self, values: &[f64], first: usize, stuck: &[std::ops::Range<usize>]) {
        join(&mut self.all, &mut self.extremes, values);
        self.is_stuck |= !stuck.is_empty();
        let mut at = first;
        let end = first + values.len();
        for run in stuck.iter().cloned().chain(std::iter::once(end..end)) {
            if run.start > at {
                let part = &values[at - first..run.start - first];
                join(&mut self.sound, &mut self.sound_extremes, part);
            }
            at = at.max(run.end);
        }
    }

    /// Mean, standard deviation, smallest and largest.
    fn numbers(&self) -> [f64; 4] {
        let (of, extremes, lost) = match self.sound_extremes {
            Some(extremes) if self.is_stuck => (self.sound, extremes, 0),
            _ => (self.all, self.extremes.unwrap_or([f64::NAN; 2]), 1),
        };
        let Some(mean) = of.mean() else {
            return [f64::NAN; 4];
        };
        let n = of.count as f64;
        let std = of.spread * (n / (n - f64::from(lost)).max(1.0)).sqrt();
        [mean, std, extremes[0], extremes[1]]
    }
}

/// Adds values to moments and extremes.
fn join(moments: &mut Moments, extremes: &mut Option<[f64; 2]>, values: &[f64]) {
    moments.join(&Moments::of(values.iter().copied()));
    for &v in values.iter().filter(|v| v.is_finite()) {
        let [low, high] = extremes.get_or_insert([v, v]);
        *low = low.min(v);
        *high = high.max(v);
    }
}
