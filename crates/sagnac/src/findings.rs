//! Findings about a log's quality as JSON and as lines of text.

use sagnac_log::Issue;
use sagnac_report::text::Finding;
use serde_json::{Value, json};

/// `{"kind", "channel", "start_s", "end_s", "count", "text"}`.
pub fn issue_json(issue: &Issue) -> Value {
    json!({
        "kind": issue.kind.name(),
        "channel": issue.channel,
        "start_s": number(issue.start_s),
        "end_s": number(issue.end_s),
        "count": issue.count,
        "text": issue.text,
    })
}

/// A number, or null where it is none.
pub fn number(value: f64) -> Value {
    if value.is_finite() {
        json!(value)
    } else {
        Value::Null
    }
}

/// Who a finding about several channels is told of: the triad that moved, or the log.
fn sensor(issue: &Issue) -> &'static str {
    let has = |word: &str| issue.text.contains(word);
    match (issue.kind, has("gyro_"), has("accel_")) {
        (sagnac_log::IssueKind::Motion, true, false) => "gyro",
        (sagnac_log::IssueKind::Motion, false, true) => "accel",
        _ => "log",
    }
}

/// The line of a finding; times count from the log's first sample, at `first_s` on its clock.
pub fn finding(issue: &Issue, first_s: f64, duration_s: f64) -> Finding {
    let (start, end) = (issue.start_s - first_s, issue.end_s - first_s);
    let is_whole = start <= 0.0 && end >= 0.999 * duration_s;
    Finding {
        kind: issue.kind.name().to_owned(),
        channel: issue
            .channel
            .clone()
            .unwrap_or_else(|| sensor(issue).to_owned()),
        span_s: (!is_whole).then_some((start, end)),
        text: issue.text.clone(),
    }
}
