//! A log that goes by in sections, as one answer.
//!
//! Each section is judged as a log of its own, with rows of its neighbors beside it; what a quick fit tells is that of the
//! first section in which enough lies still.

use sagnac_log::health::{Gathering, HealthOptions, check_section};
use sagnac_log::{Issue, IssueKind, Layout, Section};

use super::{ChannelInfo, InfoOutcome, InfoRequest, is_carried, options_of, quick, stillness};
use crate::Error;

/// What the sections so far have told.
pub(super) struct Course {
    options: HealthOptions,
    layout: Layout,
    gathering: Gathering,
    /// Samples without motion, and all of them.
    stillness: (usize, usize),
    has_motion: bool,
    /// What the quick fit told, and of how many samples.
    quick: (usize, Vec<Issue>),
}

impl Course {
    pub(super) fn new(request: &InfoRequest) -> Self {
        Self {
            options: options_of(request),
            layout: Layout::default(),
            gathering: Gathering::default(),
            stillness: (0, 0),
            has_motion: false,
            quick: (0, Vec::new()),
        }
    }

    /// Takes in the next section.
    pub(super) fn add(&mut self, section: &Section<'_>) -> Result<(), Error> {
        self.layout.clone_from(&section.log.layout);
        let known_s = self.gathering.dt_s();
        let mut of = check_section(section, &self.options, known_s)?;
        let stillness = stillness(&of.health);
        self.stillness.0 += stillness.0;
        self.stillness.1 += stillness.1;
        self.has_motion |= of.has_motion();
        if of.has_motion() && is_carried(stillness) {
            // Whether the whole log is carried about is known at its end.
            let moving = HealthOptions {
                moving: true,
                ..self.options
            };
            let rest = of;
            of = check_section(section, &moving, known_s)?;
            of.keep_motion(rest);
        } else {
            let samples = quick::samples(&of.health);
            if samples > self.quick.0 {
                self.quick = (samples, quick::issues(section.log, &of.health));
            }
        }
        self.gathering.add(section, of);
        Ok(())
    }

    /// The answer.
    pub(super) fn finish(mut self) -> Result<InfoOutcome, Error> {
        let is_moving = self.has_motion && is_carried(self.stillness);
        let told = self.gathering.finish(&self.layout.channels, is_moving)?;
        let mut issues = told.issues;
        if !is_moving {
            // A part of a log does not tell that the whole is short.
            self.quick.1.retain(|i| i.kind != IssueKind::Short);
            for issue in &mut self.quick.1 {
                issue.start_s = told.first_s;
                issue.end_s = told.first_s + told.duration_s - told.dt_s;
                if issue.kind == IssueKind::BiasRemoved {
                    issue.count = told.rows;
                }
            }
            issues.append(&mut self.quick.1);
        }
        issues.sort_by_key(|a| a.kind.is_note());
        let channels = self.layout.channels.iter().zip(told.channels);
        let channels = channels
            .map(|(c, (numbers, lsb))| ChannelInfo::new(c, numbers, lsb))
            .collect();
        self.layout.notes.extend(told.notes);
        Ok(InfoOutcome {
            layout: self.layout,
            samples: usize::try_from(told.rows).unwrap_or(usize::MAX),
            rate_hz: 1.0 / told.dt_s,
            duration_s: told.duration_s,
            stamp_step_s: told.stamp_step_s,
            channels,
            force_m_s2: told.force_m_s2,
            issues,
            first_s: told.first_s,
            is_moving,
        })
    }
}
