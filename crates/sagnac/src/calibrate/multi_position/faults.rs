//! What is wrong with a hand-turned log, and with the model whose frame it takes, in sentences.

use sagnac_log::health::{self, HealthOptions};
use sagnac_log::{Issue, IssueKind, Log};

use super::{MultiPositionOutcome, clock};
use crate::calibrate::text::short;

/// Findings of the kinds that cost a hand-turned log rests or turns.
pub(super) fn of(log: &Log) -> Vec<Issue> {
    let options = HealthOptions {
        moving: true,
        ..HealthOptions::default()
    };
    health::check(log, &options).map_or_else(
        |_| Vec::new(),
        |health| {
            let mut issues = health.issues;
            issues.retain(|i| {
                matches!(
                    i.kind,
                    IssueKind::Gap
                        | IssueKind::Duplicate
                        | IssueKind::Backwards
                        | IssueKind::Nan
                        | IssueKind::Stuck
                )
            });
            issues
        },
    )
}

/// Time stamps that are no numbers, put between their neighbors, as `info` takes them.
pub(super) fn fill(stamps_s: &mut [f64], dt_s: f64) {
    let Some(first) = stamps_s.iter().position(|t| t.is_finite()) else {
        return;
    };
    for k in (0..first).rev() {
        stamps_s[k] = stamps_s[k + 1] - dt_s;
    }
    for k in first + 1..stamps_s.len() {
        if !stamps_s[k].is_finite() {
            stamps_s[k] = stamps_s[k - 1] + dt_s;
        }
    }
}

impl MultiPositionOutcome {
    /// The log's faults and what they cost, and a mounting that was never measured.
    pub(super) fn faults(&self) -> Vec<String> {
        let mut out = Vec::new();
        if !self.request.unmeasured.is_empty() {
            out.push(format!(
                "no mounting was measured: the model of --start has no {}; name one of a test that determines it \
                 (tumble24)",
                short(&self.request.unmeasured)
            ));
        }
        // The axes of a sensor mostly share a fault.
        let mut told: Vec<(Vec<&str>, &Issue)> = Vec::new();
        for issue in &self.findings {
            let channel = issue.channel.as_deref().unwrap_or("log");
            match told.iter_mut().find(|(_, other)| {
                other.text == issue.text && other.start_s.total_cmp(&issue.start_s).is_eq()
            }) {
                Some((channels, _)) => channels.push(channel),
                None => told.push((vec![channel], issue)),
            }
        }
        for (channels, issue) in told {
            let at = if issue.start_s.is_finite() {
                format!(" at {}", clock(issue.start_s))
            } else {
                String::new()
            };
            out.push(format!("{}{at}: {}", channels.join(", "), issue.text));
        }
        for broken in &self.found.broken {
            out.push(format!(
                "what lies between the rests at {} and {} is left out: {}",
                clock(broken.span_s[0]),
                clock(broken.span_s[1]),
                if broken.is_gap {
                    "time jumps in it"
                } else {
                    "a sample in it is no number"
                }
            ));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::fill;

    #[test]
    fn a_stamp_that_is_no_number_lies_between_its_neighbors() {
        let mut stamps = [f64::NAN, 1.0, f64::NAN, 3.0];
        fill(&mut stamps, 1.0);
        assert_eq!(stamps, [0.0, 1.0, 2.0, 3.0]);
    }
}
