//! Findings about a log as JSON and as lines of text.

use sagnac_log::Issue;
use sagnac_report::text::Finding;
use serde_json::{Value, json};

/// The finding as scripts read it.
pub(crate) fn to_json(issue: &Issue) -> Value {
    json!({
        "kind": issue.kind.name(),
        "channel": issue.channel,
        "start_s": issue.start_s,
        "end_s": issue.end_s,
        "count": issue.count,
        "text": issue.text,
    })
}

/// The finding as a line of text; spans count from `origin_s`.
pub(crate) fn to_finding(issue: &Issue, origin_s: f64, duration_s: f64) -> Finding {
    let (start, end) = (issue.start_s - origin_s, issue.end_s - origin_s);
    let all = start <= 0.0 && end >= 0.999 * duration_s;
    Finding {
        kind: issue.kind.name().to_owned(),
        channel: issue.channel.clone().unwrap_or_else(|| "log".to_owned()),
        span_s: (!all).then_some((start.max(0.0), end.max(0.0))),
        text: issue.text.clone(),
    }
}
