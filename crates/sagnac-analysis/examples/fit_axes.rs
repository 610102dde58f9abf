//! The joint estimate of raw axes from standard input: little-endian f64, `LENGTH` numbers an axis, one JSON line each.
//!
//! Usage: `fit_axes STEP_S LENGTH [TERMS] [--temperature]`, TERMS a list like `Q,N,B,K,R,GM,line` or `all`; with
//! `--temperature` every axis is followed by as many temperatures in °C. `tools/fidelity.py` feeds it.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example that talks to a pipe"
)]

use sagnac_analysis::fit::{
    AxisData, AxisEstimate, Candidates, Estimate, FitOptions, RegressorKind, Segment, Status, Term,
    estimate,
};
use std::fmt::Write as _;
use std::io::{Read, Write};

fn number(value: Option<f64>) -> String {
    value.map_or("null".to_string(), |v| format!("{v:e}"))
}

fn json(e: &Estimate) -> String {
    let status = match e.status {
        Status::Detected => "detected",
        Status::UpperLimit => "upper_limit",
        Status::Absent => "absent",
    };
    format!(
        r#"{{"status":"{status}","value":{},"lower":{},"upper":{},"sigma":{}}}"#,
        number(e.value),
        number(e.lower),
        number(e.upper),
        number(e.sigma)
    )
}

fn line(axis: &AxisEstimate, seconds: f64) -> String {
    let mut out = String::from("{");
    for (name, e) in [
        ("Q", &axis.quantization),
        ("N", &axis.white),
        ("B", &axis.flicker),
        ("K", &axis.random_walk),
        ("R", &axis.ramp),
        ("mean", &axis.mean),
    ] {
        let _ = write!(out, "\"{name}\":{},", json(e));
    }
    let list: Vec<String> = axis
        .gauss_markov
        .iter()
        .map(|g| {
            format!(
                r#"{{"sigma":{},"Tc":{}}}"#,
                json(&g.sigma),
                json(&g.correlation_time_s)
            )
        })
        .collect();
    let _ = write!(out, "\"GM\":[{}],", list.join(","));
    let list: Vec<String> = axis
        .sinusoids
        .iter()
        .map(|s| {
            format!(
                r#"{{"amplitude":{},"frequency":{}}}"#,
                json(&s.amplitude),
                json(&s.frequency_hz)
            )
        })
        .collect();
    let _ = write!(out, "\"lines\":[{}],", list.join(","));
    let list: Vec<String> = axis
        .confused
        .iter()
        .map(|(a, b)| format!("[\"{}\",\"{}\"]", a.symbol(), b.symbol()))
        .collect();
    let _ = write!(out, "\"confused\":[{}],", list.join(","));
    let list: Vec<String> = axis
        .findings
        .iter()
        .map(|f| {
            format!(
                r#"{{"kind":"{}","start":{},"end":{},"text":"{}"}}"#,
                f.kind.name(),
                f.start_s,
                f.end_s,
                f.text
            )
        })
        .collect();
    let _ = write!(out, "\"findings\":[{}],", list.join(","));
    let list: Vec<String> = axis
        .regressors
        .iter()
        .filter_map(|r| match r.kind {
            RegressorKind::Temperature { power } => Some(format!(
                r#""temperature.{power}":{{"status":"detected","value":{:e},"lower":{:e},"upper":{:e}}}"#,
                r.value, r.lower, r.upper
            )),
            _ => None,
        })
        .collect();
    let _ = write!(out, "\"temperature\":{{{}}},", list.join(","));
    let list: Vec<String> = axis.likelihood_ratios.iter().map(|r| number(*r)).collect();
    let _ = write!(
        out,
        "\"ratios\":[{}],\"p\":{},\"regressors\":{},\"seconds\":{seconds:.5}}}",
        list.join(","),
        number(axis.p_value),
        axis.regressors.len()
    );
    out
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let (Some(step_s), Some(length)) = (
        arguments.get(1).and_then(|a| a.parse::<f64>().ok()),
        arguments.get(2).and_then(|a| a.parse::<usize>().ok()),
    ) else {
        eprintln!("usage: fit_axes STEP_S LENGTH [TERMS] [--temperature]");
        std::process::exit(2);
    };
    let mut options = FitOptions::default();
    let with_temperature = arguments.iter().any(|a| a == "--temperature");
    if let Some(list) = arguments.get(3).filter(|l| *l != "all") {
        options.candidates = Candidates::none();
        for name in list.split(',') {
            options.candidates.allow(match name {
                "Q" => Term::Quantization,
                "N" => Term::White,
                "B" => Term::Flicker,
                "K" => Term::RandomWalk,
                "R" => Term::Ramp,
                "GM" => Term::GaussMarkov,
                _ => Term::Sinusoid,
            });
        }
    }
    let mut input = std::io::stdin().lock();
    let mut output = std::io::stdout().lock();
    let numbers = if with_temperature { 2 * length } else { length };
    let mut bytes = vec![0_u8; 8 * numbers];
    while input.read_exact(&mut bytes).is_ok() {
        let all: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default()))
            .collect();
        let (samples, temperatures) = all.split_at(length);
        let of = |samples| {
            [Segment {
                start_s: 0.0,
                samples,
                filled: &[],
            }]
        };
        let (segments, temperature) = (of(samples), of(temperatures));
        let data = AxisData {
            segments: &segments,
            temperature: with_temperature.then_some(&temperature[..]),
            step_s,
            lsb: None,
        };
        let start = std::time::Instant::now();
        let axis = estimate(&data, &options);
        let seconds = start.elapsed().as_secs_f64();
        if writeln!(output, "{}", line(&axis, seconds)).is_err() {
            return;
        }
        let _ = output.flush();
    }
}
