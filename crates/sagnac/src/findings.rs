//! Findings about a log's quality as JSON and as lines of text.

use sagnac_log::Issue;
use sagnac_report::text::{Finding, clock, duration, group_numbers};
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

/// Who a finding about several channels is told of: the triad that it names, or the log.
pub(crate) fn sensor(issue: &Issue) -> &'static str {
    let has = |words: [&str; 2]| words.iter().any(|word| issue.text.contains(word));
    match (has(["gyro_", "|w|"]), has(["accel_", "|f|"])) {
        (true, false) => "gyro",
        (false, true) => "accel",
        _ => "log",
    }
}

/// Lines of one kind and channel that are told one by one; more are told together.
const MOST_LINES: usize = 4;

/// What the last finding that is listed says of those that are not.
struct Unlisted {
    count: usize,
    /// From the log's first sample; 0 where it is not said.
    end_s: f64,
    /// Where in the text it begins.
    begins: usize,
}

impl Unlisted {
    fn of(finding: &Finding) -> Option<Self> {
        let begins = finding.text.rfind("; and ")?;
        let (count, tail) = finding.text[begins + 6..].split_once(" more of this kind")?;
        let end = tail
            .strip_prefix(" up to ")
            .and_then(|t| t.strip_suffix(" s"));
        Some(Self {
            count: count.replace(' ', "").parse().ok()?,
            end_s: end.and_then(|e| e.parse().ok()).unwrap_or(0.0),
            begins,
        })
    }
}

/// Many findings of one kind and channel as one: how many, how long in all, and what the longest says.
pub(crate) fn gathered(findings: Vec<Finding>) -> Vec<Finding> {
    let mut groups: Vec<Vec<Finding>> = Vec::new();
    for finding in findings {
        let same = |g: &&mut Vec<Finding>| {
            g[0].kind == finding.kind && g[0].channel == finding.channel && g[0].span_s.is_some()
        };
        match groups.iter_mut().find(same) {
            Some(group) if finding.span_s.is_some() => group.push(finding),
            _ => groups.push(vec![finding]),
        }
    }
    let length = |f: &Finding| f.span_s.map_or(0.0, |(a, b)| b - a);
    let mut out = Vec::new();
    for group in groups {
        let longest = group.iter().max_by(|a, b| length(a).total_cmp(&length(b)));
        let (Some(longest), true) = (longest, group.len() > MOST_LINES) else {
            out.extend(group);
            continue;
        };
        // The last one that is listed says how many are not, and where they end.
        let unlisted: Vec<Unlisted> = group.iter().filter_map(Unlisted::of).collect();
        let more: usize = unlisted.iter().map(|u| u.count).sum();
        let (start, end) = group
            .iter()
            .filter_map(|f| f.span_s)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| {
                (a.min(s.0), b.max(s.1))
            });
        let end = unlisted.iter().fold(end, |end, u| end.max(u.end_s));
        let at = clock(longest.span_s.map_or(0.0, |s| s.0));
        let total: f64 = group.iter().map(length).sum();
        // Neighbouring ones of these are told as one, which spans sound samples as well.
        let spans_sound = ["gap", "duplicate", "backwards", "nan"].contains(&longest.kind.as_str());
        let total = if total >= 1.0 && !spans_sound {
            format!(", {} in all", duration(total.round()))
        } else {
            String::new()
        };
        let text =
            Unlisted::of(longest).map_or(longest.text.as_str(), |u| &longest.text[..u.begins]);
        out.push(Finding {
            kind: longest.kind.clone(),
            channel: longest.channel.clone(),
            span_s: Some((start, end)),
            text: format!(
                "{} times{total}; the longest at {at}: {text}",
                group.len() + more
            ),
        });
    }
    // In order of time; what concerns the whole log begins with it.
    let start = |f: &Finding| f.span_s.map_or(0.0, |s| s.0);
    out.sort_by(|a, b| start(a).total_cmp(&start(b)));
    out
}

/// The line of a finding; times count from the log's first sample, at `first_s` on its clock.
pub fn finding(issue: &Issue, first_s: f64, duration_s: f64) -> Finding {
    let (start, end) = (issue.start_s - first_s, issue.end_s - first_s);
    // The last stamp is one interval before the end.
    let is_whole = start <= 0.0 && end >= 0.99 * duration_s;
    Finding {
        kind: issue.kind.name().to_owned(),
        channel: issue
            .channel
            .clone()
            .unwrap_or_else(|| sensor(issue).to_owned()),
        span_s: (!is_whole).then_some((start, end)),
        text: group_numbers(&issue.text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_findings_of_a_kind_are_one_line() {
        let motion = |k: u32, long: f64| Finding {
            kind: "motion".to_owned(),
            channel: "gyro".to_owned(),
            span_s: Some((10.0 * f64::from(k), 10.0 * f64::from(k) + long)),
            text: format!("moved {k}"),
        };
        let mut many: Vec<Finding> = (0..7)
            .map(|k| motion(k, if k == 3 { 5.0 } else { 2.0 }))
            .collect();
        many[6].text += "; and 30 more of this kind up to 250.000 s";
        let lines = gathered(many);
        assert_eq!(lines.len(), 1);
        assert_eq!(
            lines[0].text,
            "37 times, 17 s in all; the longest at 0:30: moved 3"
        );
        assert_eq!(lines[0].span_s, Some((0.0, 250.0)));
        assert_eq!(gathered(vec![motion(0, 1.0), motion(1, 1.0)]).len(), 2);
    }
}
