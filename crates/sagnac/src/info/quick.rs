//! Findings that need a noise fit, from a quick one: filtered, line, bias_removed, short.

use sagnac_analysis::fit::{AxisData, Candidates, FindingKind, FitOptions, Segment, estimate};
use sagnac_log::health::Health;
use sagnac_log::{Issue, IssueKind, Log, Quantity};

/// Samples that the quick fit looks at.
const MOST: usize = 1 << 20;

/// Samples of the axis that has most, as far as the quick fit looks at them.
pub(super) fn samples(health: &Health<'_>) -> usize {
    let of = health.channels.iter().map(|h| {
        let quiet = h.quiet.iter().map(|s| s.range.len());
        quiet.sum::<usize>().min(MOST)
    });
    of.max().unwrap_or(0)
}

pub(super) fn issues(log: &Log, health: &Health<'_>) -> Vec<Issue> {
    let mut out = Vec::new();
    let mut gyro_means = Vec::new();
    let is_short = health.issues.iter().any(|i| i.kind == IssueKind::Short);
    let mut candidates = Candidates {
        gauss_markov: 1,
        ..Candidates::default()
    };
    candidates.ramp = false;
    let options = FitOptions {
        candidates,
        data_checks: true,
    };
    for (channel, h) in log.layout.channels.iter().zip(&health.channels) {
        if !matches!(
            channel.quantity,
            Quantity::AngularRate | Quantity::SpecificForce
        ) {
            continue;
        }
        let mut left = MOST;
        let mut segments: Vec<Segment<'_>> = Vec::new();
        for s in &h.quiet {
            let mut n = s.range.len().min(left);
            left -= n;
            // A run of filled samples has one that exists on both sides.
            let runs = s.filled.partition_point(|r| r.end < n);
            n = s.filled.get(runs).map_or(n, |r| n.min(r.start));
            if let Some(samples) = h
                .values
                .get(s.range.start..s.range.start + n)
                .filter(|v| v.len() > 1)
            {
                segments.push(Segment {
                    start_s: s.start_s,
                    samples,
                    filled: &s.filled[..runs],
                });
            }
        }
        if segments.iter().map(|s| s.samples.len()).sum::<usize>() < 1000 || h.sigma_w <= 0.0 {
            continue;
        }
        let data = AxisData {
            segments: &segments,
            temperature: None,
            step_s: h.step_s,
            lsb: h.lsb,
        };
        let fit = estimate(&data, &options);
        if channel.quantity == Quantity::AngularRate {
            gyro_means.push((fit.mean.value, fit.mean.sigma));
        }
        for f in &fit.findings {
            let kind = match f.kind {
                FindingKind::Filtered => IssueKind::Filtered,
                FindingKind::Line => IssueKind::Line,
                // Of a log that is short as a whole health has told; a part of one says nothing of the whole.
                FindingKind::Short if left > 0 && !is_short => IssueKind::Short,
                _ => continue,
            };
            out.push(Issue {
                kind,
                channel: Some(channel.name.clone()),
                start_s: health.first_s + f.start_s,
                end_s: health.first_s + health.duration_s - health.dt_s,
                count: f.count as u64,
                text: f.text.clone(),
            });
        }
    }
    let is_removed = |m: &(Option<f64>, Option<f64>)| matches!(m, (Some(mean), Some(sigma)) if *sigma > 0.0 && mean.abs() < 0.01 * sigma);
    if !gyro_means.is_empty() && gyro_means.iter().all(is_removed) {
        out.push(Issue {
            kind: IssueKind::BiasRemoved,
            channel: None,
            start_s: health.first_s,
            end_s: health.first_s + health.duration_s - health.dt_s,
            count: log.rows as u64,
            text:
                "every gyro's mean is zero far beyond its own noise: the bias was taken out before"
                    .to_owned(),
        });
    }
    out
}
