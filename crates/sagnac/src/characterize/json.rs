//! The outcome as JSON: the keys that scripts rely on, numbers in SI.

use super::{AxisOutcome, LogOutcome, Outcome, SensorAxis, dimension_of, key_of};
use sagnac_analysis::fit::{Estimate, GaussMarkovEstimate, Regressor, RegressorKind, Status, Term};
use sagnac_core::Sensor;
use sagnac_model::units::Dimension;
use serde_json::{Map, Value, json};

fn number(value: Option<f64>) -> Value {
    value
        .filter(|v| v.is_finite())
        .map_or(Value::Null, Value::from)
}

fn status(status: Status) -> &'static str {
    match status {
        Status::Detected => "detected",
        Status::UpperLimit => "upper_limit",
        Status::Absent => "absent",
    }
}

/// An estimate as scripts know it.
pub fn estimate_json(e: &Estimate, unit: &str) -> Value {
    json!({
        "status": status(e.status),
        "value": number(e.value),
        "lower": number(e.lower),
        "upper": number(e.upper),
        "sigma": number(e.sigma),
        "unit": unit,
    })
}

fn in_dimension(e: &Estimate, dimension: Dimension) -> Value {
    estimate_json(e, &dimension.si_unit())
}

fn markov(list: &[GaussMarkovEstimate], sensor: Sensor) -> Value {
    list.iter()
        .map(|g| {
            json!({
                "sigma": in_dimension(&g.sigma, dimension_of(sensor, Term::GaussMarkov)),
                "correlation_time": in_dimension(&g.correlation_time_s, Dimension::TIME),
            })
        })
        .collect()
}

pub(super) fn outcome(outcome: &Outcome) -> Value {
    if let [only] = outcome.logs.as_slice() {
        return log(only);
    }
    let mut out = Map::new();
    out.insert("logs".into(), outcome.logs.iter().map(log).collect());
    if let Some(axes) = &outcome.sensor {
        let axes: Vec<Value> = axes.iter().map(sensor_axis).collect();
        out.insert("sensor".into(), json!({ "axes": axes }));
    }
    let outliers: Vec<Value> = outcome
        .outliers
        .iter()
        .map(|o| {
            let sensor = if o.axis.starts_with("gyro") {
                Sensor::Gyro
            } else {
                Sensor::Accel
            };
            json!({
                "log": o.log,
                "axis": o.axis,
                "term": o.outlier.term.map(|t| key_of(sensor, t)),
                "text": o.text,
            })
        })
        .collect();
    out.insert("outliers".into(), Value::from(outliers));
    Value::Object(out)
}

fn log(log: &LogOutcome) -> Value {
    let issues: Vec<Value> = log
        .issues
        .iter()
        .map(|i| {
            json!({
                "kind": i.kind.name(),
                "channel": i.channel,
                "start_s": i.start_s,
                "end_s": i.end_s,
                "count": i.count,
                "text": i.text,
            })
        })
        .collect();
    json!({
        "name": log.name,
        "log": {
            "samples": log.samples,
            "rate_hz": log.rate_hz,
            "duration_s": log.duration_s,
            "issues": issues,
        },
        "axes": log.axes.iter().map(axis).collect::<Vec<_>>(),
    })
}

fn axis(axis: &AxisOutcome) -> Value {
    let sensor = axis.sensor;
    let mut terms = Map::new();
    let output = dimension_of(sensor, Term::Flicker);
    let estimate = axis.estimate.as_ref();
    for term in [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ] {
        let e = estimate
            .and_then(|e| e.term(term))
            .copied()
            .unwrap_or(Estimate::ABSENT);
        terms.insert(
            key_of(sensor, term).into(),
            in_dimension(&e, dimension_of(sensor, term)),
        );
    }
    let absent = [GaussMarkovEstimate::ABSENT];
    let list = estimate.map_or(absent.as_slice(), |e| e.gauss_markov.as_slice());
    terms.insert("gauss_markov".into(), markov(list, sensor));
    let lines: Vec<Value> = estimate
        .map(|e| e.sinusoids.as_slice())
        .unwrap_or_default()
        .iter()
        .map(|s| {
            json!({
                "amplitude": in_dimension(&s.amplitude, output),
                "frequency": in_dimension(&s.frequency_hz, Dimension::FREQUENCY),
            })
        })
        .collect();
    terms.insert("sinusoids".into(), Value::from(lines));
    let allan = axis.allan.as_ref().map_or_else(
        || json!({"tau_s": [], "deviation": [], "lower": [], "upper": []}),
        |c| {
            json!({
                "tau_s": c.tau_s,
                "deviation": c.deviation,
                "lower": c.lower,
                "upper": c.upper,
            })
        },
    );
    let mean = estimate.map_or(Estimate::ABSENT, |e| e.mean);
    let confused: Vec<Value> = estimate
        .map(|e| e.confused.as_slice())
        .unwrap_or_default()
        .iter()
        .map(|&(a, b)| json!([key_of(sensor, a), key_of(sensor, b)]))
        .collect();
    let regressors: Vec<Value> = estimate
        .map(|e| e.regressors.as_slice())
        .unwrap_or_default()
        .iter()
        .map(|r| regressor(r, output))
        .collect();
    let levels: Vec<Value> = estimate
        .map(|e| e.levels.as_slice())
        .unwrap_or_default()
        .iter()
        .map(|l| {
            json!({
                "start_s": l.start_s,
                "end_s": l.end_s,
                "mean": in_dimension(&l.mean, output),
            })
        })
        .collect();
    json!({
        "axis": axis.axis,
        "mean": in_dimension(&mean, output),
        "levels": levels,
        "lsb": number(axis.lsb),
        "terms": terms,
        "allan": allan,
        "fit": {
            "deviation": axis.fit_deviation,
            "p_value": number(estimate.and_then(|e| e.p_value)),
        },
        "confused": confused,
        "regressors": regressors,
        "covariance": covariance(axis),
    })
}

/// Covariance and correlations of the detected terms: parameter names in the order of the rows.
fn covariance(axis: &AxisOutcome) -> Value {
    let Some(estimate) = &axis.estimate else {
        return Value::Null;
    };
    let c = &estimate.covariance;
    let n = c.names.len();
    let names: Vec<String> = c
        .names
        .iter()
        .map(|name| match name.as_str() {
            "Q" => key_of(axis.sensor, Term::Quantization).to_owned(),
            "N" => key_of(axis.sensor, Term::White).to_owned(),
            "B" => key_of(axis.sensor, Term::Flicker).to_owned(),
            "K" => key_of(axis.sensor, Term::RandomWalk).to_owned(),
            other => {
                let (kind, place) = other.split_at(other.len() - 1);
                let key = if kind == "sigma" {
                    "sigma"
                } else {
                    "correlation_time"
                };
                format!("gauss_markov.{place}.{key}")
            }
        })
        .collect();
    let rows = |m: &[f64]| -> Vec<Vec<Value>> {
        (0..n)
            .map(|i| (0..n).map(|j| number(Some(m[i * n + j]))).collect())
            .collect()
    };
    json!({
        "names": names,
        "matrix": rows(&c.matrix),
        "correlations": rows(&c.correlations()),
    })
}

fn regressor(r: &Regressor, output: Dimension) -> Value {
    let mut out = Map::new();
    let (kind, unit) = match r.kind {
        RegressorKind::Temperature { power } => (
            format!("temperature.{power}"),
            output.per_kelvin(power as u8).si_unit(),
        ),
        RegressorKind::WarmUp { .. } => ("warm_up".to_owned(), output.si_unit()),
        RegressorKind::Step { .. } => ("step".to_owned(), output.si_unit()),
    };
    out.insert("kind".into(), kind.into());
    out.insert("value".into(), number(Some(r.value)));
    out.insert("lower".into(), number(Some(r.lower)));
    out.insert("upper".into(), number(Some(r.upper)));
    out.insert("unit".into(), unit.into());
    match r.kind {
        RegressorKind::WarmUp { time_constant_s } => {
            out.insert("time_constant_s".into(), number(Some(time_constant_s)));
        }
        RegressorKind::Step { time_s } => {
            out.insert("time_s".into(), number(Some(time_s)));
        }
        RegressorKind::Temperature { .. } => {}
    }
    Value::Object(out)
}

fn sensor_axis(axis: &SensorAxis) -> Value {
    let sensor = axis.sensor;
    let p = &axis.pooled;
    let mut terms = Map::new();
    for (term, e) in [
        (Term::Quantization, &p.quantization),
        (Term::White, &p.white),
        (Term::Flicker, &p.flicker),
        (Term::RandomWalk, &p.random_walk),
    ] {
        terms.insert(
            key_of(sensor, term).into(),
            in_dimension(e, dimension_of(sensor, term)),
        );
    }
    terms.insert("gauss_markov".into(), markov(&p.gauss_markov, sensor));
    let output = dimension_of(sensor, Term::Flicker);
    let regressors: Vec<Value> = p
        .run_to_run
        .temperature
        .iter()
        .zip(1_u8..)
        .map(|(&(value, lower, upper), power)| {
            json!({
                "kind": format!("temperature.{power}"),
                "value": value,
                "lower": lower,
                "upper": upper,
                "unit": output.per_kelvin(power).si_unit(),
            })
        })
        .collect();
    json!({
        "axis": axis.axis,
        "terms": terms,
        "runs": axis.runs,
        "bias_stability": in_dimension(&p.run_to_run.stability, output),
        "regressors": regressors,
        "reference_temperature_c": number(p.run_to_run.reference_c),
        "confused": p.confused.iter().map(|&(a, b)| json!([key_of(sensor, a), key_of(sensor, b)])).collect::<Vec<_>>(),
    })
}
