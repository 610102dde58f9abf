//! The comparison in a terminal and as JSON.

use super::{ComparedAxis, ComparedLog, ComparedTerm, ComparisonOutcome};
use crate::characterize::{estimate_json, shown, shown_sensor};
use crate::findings::issue_json;
use sagnac_analysis::compare::Verdict;
use sagnac_analysis::fit::Estimate;
use sagnac_core::Sensor;
use sagnac_report::text::{
    Align, Cell, Document, Estimate as Shown, Role, Table, Unit, general, term_symbol,
};
use serde_json::{Map, Value, json};

impl ComparisonOutcome {
    /// Keys as scripts rely on them.
    pub fn to_json(&self) -> Value {
        let logs: Vec<Value> = self.logs.iter().map(log_json).collect();
        if let [only] = logs.as_slice() {
            return only.clone();
        }
        let mut out = Map::new();
        out.insert("logs".into(), logs.into());
        Value::Object(out)
    }

    /// As a terminal shows it.
    pub fn document(&self) -> Document {
        let mut out = Document::new();
        for (i, log) in self.logs.iter().enumerate() {
            if i > 0 {
                out.blank();
            }
            if self.logs.len() > 1 {
                out.heading(log.name.clone());
            }
            one_document(log, &mut out);
        }
        if !self.left_out.is_empty() {
            out.blank();
            out.paragraph(format!(
                "In the sheet, not compared: {}.",
                self.left_out.join(", ")
            ));
        }
        out
    }
}

fn log_json(log: &ComparedLog) -> Value {
    let axes: Vec<Value> = log.axes.iter().map(axis_json).collect();
    let several = log.issues.len() > 1;
    let issues: Vec<Value> = log
        .issues
        .iter()
        .flat_map(|(name, issues)| issues.iter().map(move |i| (name, i)))
        .map(|(name, issue)| {
            let mut one = issue_json(issue);
            if let (true, Some(map)) = (several, one.as_object_mut()) {
                map.insert("log".into(), name.as_str().into());
            }
            one
        })
        .collect();
    json!({ "name": log.name, "axes": axes, "issues": issues })
}

fn axis_json(axis: &ComparedAxis) -> Value {
    let terms: Vec<Value> = axis
        .terms
        .iter()
        .map(|t| {
            let ratio = t.result.map_or(Estimate::ABSENT, |r| r.ratio);
            json!({
                "term": t.name,
                "measured": estimate_json(&t.measured, &t.unit),
                "reference": t.reference,
                "ratio": estimate_json(&ratio, "1"),
                "verdict": t.verdict().name(),
                "text": t.text,
            })
        })
        .collect();
    json!({ "axis": axis.axis, "terms": terms })
}

/// The unit of a row, and what its numbers are multiplied with besides: densities of a sheet are one-sided.
pub(super) fn shown_unit(sensor: Sensor, term: &ComparedTerm) -> (Unit, f64) {
    if term.name.ends_with(".correlation_time") {
        return (Unit::S, 1.0);
    }
    if !term.is_density {
        let name = term.name.split('.').next().unwrap_or(&term.name);
        return (Unit::of_term(shown_sensor(sensor), name), 1.0);
    }
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S_PER_SQRT_HZ,
        Sensor::Accel => Unit::MICRO_G_PER_SQRT_HZ,
    };
    (unit, std::f64::consts::SQRT_2)
}

/// What a row is called: `N`, `density`, `GM sigma`.
fn label(term: &ComparedTerm) -> &str {
    match term.name.as_str() {
        _ if term.is_density => "density",
        "bias_stability" => "run-to-run",
        "gauss_markov" => "GM",
        name if name.ends_with("sigma") => "GM sigma",
        name if name.ends_with(".correlation_time") => "GM time",
        name => term_symbol(name).unwrap_or(name),
    }
}

/// Rows under a condition, axes of one name together: `gyro x, y N`.
fn named(axes: &[ComparedAxis], is: impl Fn(&ComparedTerm) -> bool) -> Vec<String> {
    let mut groups: Vec<(Sensor, &str, Vec<&str>)> = Vec::new();
    for axis in axes {
        let own = axis.axis.split('_').nth(1).unwrap_or("");
        for term in axis.terms.iter().filter(|t| is(t)) {
            let label = label(term);
            let place = groups
                .iter_mut()
                .find(|g| g.0 == axis.sensor && g.1 == label);
            match place {
                Some(group) if group.2.last() != Some(&own) => group.2.push(own),
                Some(_) => {}
                None => groups.push((axis.sensor, label, vec![own])),
            }
        }
    }
    groups
        .into_iter()
        .map(|(sensor, label, axes)| format!("{} {} {label}", sensor.key(), axes.join(", ")))
        .collect()
}

/// The answer in a sentence: what is worse, and what cannot be told.
pub(super) fn headline(axes: &[ComparedAxis]) -> (Role, String) {
    let of = |v: Verdict| named(axes, |t| t.verdict() == v);
    let (worse, unclear) = (of(Verdict::Worse), of(Verdict::Unclear));
    let all = || axes.iter().flat_map(|a| &a.terms);
    let open = all().filter(|t| t.verdict() == Verdict::Unclear).count();
    let total = all().count();
    let list = |names: &[String]| names.join("; ");
    match (worse.is_empty(), unclear.is_empty()) {
        (true, true) => (
            Role::Good,
            "The unit is as its sheet says or better.".to_owned(),
        ),
        (true, false) if open == total => (
            Role::Warning,
            "Whether the unit is as its sheet says is not told: every term is unclear.".to_owned(),
        ),
        (true, false) => (
            Role::Warning,
            format!(
                "As far as it is told the unit is as its sheet says or better; {open} of {total} rows are unclear: {}.",
                list(&unclear)
            ),
        ),
        (false, true) => (
            Role::Bad,
            format!("The unit is as its sheet says but for {}.", list(&worse)),
        ),
        (false, false) => (
            Role::Bad,
            format!(
                "The unit is worse than its sheet in {}; {open} of {total} rows are unclear: {}.",
                list(&worse),
                list(&unclear)
            ),
        ),
    }
}

fn one_document(log: &ComparedLog, out: &mut Document) {
    let axes = log.axes.as_slice();
    let all = || {
        axes.iter()
            .flat_map(|a| a.terms.iter().map(move |t| (a, t)))
    };
    let (role, text) = headline(axes);
    out.verdict(role, text);
    out.blank();
    let mut table = Table::new(
        &["", "measured", "sheet", "", "ratio", "verdict"],
        &[
            Align::Left,
            Align::PlusMinus,
            Align::Right,
            Align::Left,
            Align::PlusMinus,
            Align::Left,
        ],
    );
    for (axis, t) in all() {
        let (unit, factor) = shown_unit(axis.sensor, t);
        let role = match t.verdict() {
            Verdict::Worse => Role::Bad,
            Verdict::Better => Role::Good,
            Verdict::Unclear => Role::Warning,
            Verdict::Within => Role::Plain,
        };
        let verdict = match t.result {
            Some(r) if r.verdict == Verdict::Unclear && r.ratio.value.is_some() => "unclear: √2",
            _ => t.verdict().name(),
        };
        let ratio = t.result.map_or(Shown::Absent, |r| shown(&r.ratio));
        let row: Vec<Cell> = vec![
            format!("{} {}", axis.axis.replace('_', " "), label(t)).into(),
            shown(&t.measured).scaled(unit.per_si * factor).into(),
            general(t.reference * unit.per_si * factor, 3).into(),
            unit.text.into(),
            ratio.into(),
            Cell::from(verdict).with_role(role),
        ];
        table.row(row);
    }
    out.table(table);
    let mut said: Vec<&str> = Vec::new();
    for (_, t) in all() {
        if t.verdict() == Verdict::Unclear && !said.contains(&t.text.as_str()) {
            if said.is_empty() {
                out.blank();
            }
            said.push(&t.text);
            out.hanging("unclear: ", t.text.clone());
        }
    }
    let extra: Vec<String> = axes
        .iter()
        .flat_map(|a| {
            a.extra.iter().map(|(name, _)| {
                let symbol = term_symbol(name).unwrap_or("Gauss-Markov");
                format!("{} {symbol}", a.axis.replace('_', " "))
            })
        })
        .collect();
    if !extra.is_empty() {
        out.blank();
        out.paragraph(format!("Measured, not in the sheet: {}.", extra.join(", ")));
    }
    if !log.remarks.is_empty() {
        out.blank();
        out.append(log.remarks.clone());
    }
}
