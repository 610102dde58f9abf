//! The outcome as the page of the report: parameters, findings, Allan deviations, spectra, time series, limits.

use super::page_regressors;
use super::page_words::{facts, file_name, limits, overview, rich_verdict};
use super::text::{findings, probability, shown, shown_sensor};
use super::{AxisOutcome, LogOutcome, Outcome, key_of, levels};
use crate::findings::gathered;
use sagnac_analysis::fit::{Estimate, GaussMarkovEstimate, NoiseTerms, Status, Term};
use sagnac_core::Sensor;
use sagnac_report::html::{
    CharacterizePage, Input, LogReport, ParameterCell, ParameterRow, Rich, page_text,
};
use sagnac_report::plots::{
    AllanPanel, AllanTerm, IssueBar, IssueTimeline, SeriesPanel, SpectrumMark, SpectrumPanel,
};
use sagnac_report::svg::page_number;
use sagnac_report::text::{
    Estimate as Shown, Finding, Unit, duration, fixed, general, is_note, significant,
};

/// What the page says about how it was made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PageFacts {
    /// The command as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Name and SHA-256 of each input.
    pub inputs: Vec<(String, String)>,
}

pub(super) fn page(outcome: &Outcome, facts_of: &PageFacts) -> CharacterizePage {
    let pooled = outcome.sensor.is_some();
    let logs: Vec<LogReport> = outcome.logs.iter().map(|log| report(log, pooled)).collect();
    let name = match outcome.logs.as_slice() {
        [one] => file_name(&one.name).to_owned(),
        many => format!("{} logs", many.len()),
    };
    let subtitle = match outcome.logs.as_slice() {
        [one] => format!(
            "At rest, {}, {} Hz",
            duration(one.duration_s),
            general(one.rate_hz, 5)
        ),
        _ => "At rest".to_owned(),
    };
    CharacterizePage {
        name,
        subtitle,
        verdict: match outcome.logs.as_slice() {
            [one] => rich_verdict(one),
            _ if outcome.outliers.is_empty() => Rich::new().bold("No log differs from the others."),
            _ => {
                Rich::new().plain(format!("{}.", outcome.differences().join(". ")))
            }
        },
        facts: outcome.logs.first().filter(|_| outcome.logs.len() == 1).map(facts).unwrap_or_default(),
        logs,
        overview: (outcome.logs.len() > 1).then(|| overview(&outcome.logs)),
        method: Rich::new().plain(
            "The noise terms of each axis are estimated jointly from the likelihood of the cosine transform of its \
             samples, with the exact spectra of interval means; each term is tested with all others free, intervals \
             come from the likelihood profile. The Allan deviation is the overlapping one, with χ² intervals for \
             the noise type found at each averaging time.",
        ),
        command: facts_of.command.clone(),
        version: facts_of.version.clone(),
        inputs: facts_of
            .inputs
            .iter()
            .map(|(name, sha256)| Input { name: file_name(name).to_owned(), sha256: sha256.clone() })
            .collect(),
        more: Vec::new(),
    }
}

fn report(log: &LogOutcome, pooled: bool) -> LogReport {
    let mut out = LogReport {
        name: file_name(&log.name).to_owned(),
        verdict: rich_verdict(log),
        facts: facts(log),
        timeline: timeline(log),
        allan_note: page_regressors::taken_out(log),
        limits: limits(log, pooled),
        ..LogReport::default()
    };
    for sensor in Sensor::ALL {
        let axes: Vec<&AxisOutcome> = log.axes.iter().filter(|a| a.sensor == sensor).collect();
        if axes.is_empty() {
            continue;
        }
        rows(&axes, sensor, &mut out.parameters);
        out.allan
            .push(axes.iter().filter_map(|a| allan(a, sensor)).collect());
        out.spectrum
            .push(axes.iter().filter_map(|a| spectrum(a, sensor)).collect());
        out.series
            .push(axes.iter().map(|a| series(log, a, sensor)).collect());
    }
    out
}

fn rows(axes: &[&AxisOutcome], sensor: Sensor, out: &mut Vec<ParameterRow>) {
    let as_shown = shown_sensor(sensor);
    let cells = |f: &dyn Fn(&AxisOutcome) -> Shown| -> [Shown; 3] {
        let mut cells = [Shown::Absent; 3];
        for axis in axes {
            cells[axis.index] = f(axis);
        }
        cells
    };
    for term in [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ] {
        let of = |a: &AxisOutcome| {
            a.estimate
                .as_ref()
                .and_then(|e| e.term(term))
                .map_or(Shown::Absent, shown)
        };
        let cells = cells(&of);
        // Rows of N, B and K are always there, others where something was seen.
        let usual = matches!(term, Term::White | Term::Flicker | Term::RandomWalk);
        if usual || cells.iter().any(|c| matches!(c, Shown::Detected { .. })) {
            out.push(ParameterRow::estimates(
                as_shown,
                key_of(sensor, term),
                cells,
            ));
        }
    }
    let markov = |a: &AxisOutcome, time: bool| {
        a.estimate
            .as_ref()
            .and_then(|e| e.gauss_markov.last())
            .map_or(Shown::Absent, |g| {
                shown(if time {
                    &g.correlation_time_s
                } else {
                    &g.sigma
                })
            })
    };
    let sigma = cells(&|a| markov(a, false));
    if sigma.iter().any(|s| matches!(s, Shown::Detected { .. })) {
        out.push(ParameterRow::estimates(as_shown, "gauss_markov", sigma));
        let mut time =
            ParameterRow::estimates(as_shown, "gauss_markov", cells(&|a| markov(a, true)));
        "Gauss–Markov correlation time".clone_into(&mut time.name);
        time.unit = Some(Unit::S);
        out.push(time);
    }
    let mean = cells(&|a| {
        a.estimate
            .as_ref()
            .map_or(Shown::Absent, |e| shown(&levels::mean(e)))
    });
    out.extend(page_regressors::rows(axes, sensor));
    out.push(ParameterRow::estimates(as_shown, "mean", mean));
    if axes.iter().any(|a| a.lsb.is_some()) {
        let mut step = ParameterRow {
            sensor: as_shown,
            term: "lsb".to_owned(),
            name: "Rounding step seen in the data".to_owned(),
            unit: Some(Unit::of_term(as_shown, "lsb")),
            per: "",
            cells: Default::default(),
        };
        for axis in axes {
            if let Some(value) = axis.lsb {
                let note = format!(
                    "{} of the scatter",
                    significant(value / axis.noise_scatter, 2)
                );
                step.cells[axis.index] = ParameterCell::Number { value, note };
            }
        }
        out.push(step);
    }
    let mut fit = ParameterRow {
        sensor: as_shown,
        term: "fit".to_owned(),
        name: "Does the fit explain the curve?".to_owned(),
        unit: None,
        per: "",
        cells: Default::default(),
    };
    for axis in axes {
        if let Some(p) = axis.estimate.as_ref().and_then(|e| e.p_value) {
            fit.cells[axis.index] = ParameterCell::Word {
                word: if p < 0.001 {
                    "no"
                } else if p < 0.05 {
                    "hardly"
                } else {
                    "yes"
                }
                .to_owned(),
                class: if p < 0.001 {
                    "bad"
                } else if p < 0.05 {
                    "warn"
                } else {
                    "good"
                },
                note: match probability(p) {
                    small if small.starts_with('<') => format!("p {small}"),
                    value => format!("p = {value}"),
                },
            };
        }
    }
    out.push(fit);
}

fn timeline(log: &LogOutcome) -> IssueTimeline {
    // Each finding has its bar; what is said beside them is what the text says of all.
    let single = findings(log);
    let mut issues = Vec::with_capacity(single.len());
    for told in gathered(single.clone()) {
        let holds = |f: &&Finding| match (f.span_s, told.span_s) {
            (Some(own), Some(all)) => own.0 >= all.0 && own.1 <= all.1,
            (own, all) => own == all,
        };
        let own = single
            .iter()
            .filter(|f| f.kind == told.kind && f.channel == told.channel);
        issues.extend(own.filter(holds).map(|f| IssueBar {
            channel: f.channel.replace('_', " "),
            warning: !is_note(&f.kind),
            kind: f.kind.clone(),
            text: page_text(&told.text),
            span_s: f.span_s,
        }));
    }
    IssueTimeline {
        duration_s: log.duration_s,
        issues,
    }
}

/// The measured Allan deviation of an axis with its fit and the terms alone.
pub(crate) fn allan(axis: &AxisOutcome, sensor: Sensor) -> Option<AllanPanel> {
    let curve = axis.allan.as_ref()?;
    let unit = Unit::of_term(
        shown_sensor(sensor),
        if sensor == Sensor::Gyro {
            "mean"
        } else {
            "allan"
        },
    );
    let scaled = |v: &[f64]| -> Vec<f64> { v.iter().map(|x| x * unit.per_si).collect() };
    let band = |v: &[Option<f64>]| -> Vec<f64> {
        if v.iter().any(Option::is_none) {
            return Vec::new();
        }
        v.iter().flatten().map(|x| x * unit.per_si).collect()
    };
    let mut terms = Vec::new();
    if let Some(e) = &axis.estimate {
        for term in [
            Term::Quantization,
            Term::White,
            Term::Flicker,
            Term::RandomWalk,
            Term::Ramp,
        ] {
            let Some(estimate) = e.term(term) else {
                continue;
            };
            terms.extend(term_line(sensor, term, estimate, &curve.tau_s, unit));
        }
        let markov = e.gauss_markov.iter();
        terms.extend(markov.filter_map(|g| markov_line(sensor, g, &curve.tau_s, unit)));
    }
    Some(AllanPanel {
        axis: axis.axis.clone(),
        unit: unit.page.to_owned(),
        tau_s: curve.tau_s.clone(),
        deviation: scaled(&curve.deviation),
        lower: band(&curve.lower),
        upper: band(&curve.upper),
        fit: scaled(&axis.fit_deviation),
        fit_name: String::new(),
        terms,
    })
}

/// The Allan deviation of one term alone, a limit where it was not seen (B and K: they bound what is seen).
fn term_line(
    sensor: Sensor,
    term: Term,
    e: &Estimate,
    tau_s: &[f64],
    unit: Unit,
) -> Option<AllanTerm> {
    let limit = e.status == Status::UpperLimit;
    if limit && !matches!(term, Term::Flicker | Term::RandomWalk) {
        return None;
    }
    let value = if limit { e.upper? } else { e.value? };
    let mut alone = NoiseTerms::default();
    match term {
        Term::Quantization => alone.quantization = value,
        Term::White => alone.white = value,
        Term::Flicker => alone.flicker = value,
        Term::RandomWalk => alone.random_walk = value,
        Term::Ramp => alone.ramp = value,
        Term::GaussMarkov | Term::Sinusoid => return None,
    }
    let key = key_of(sensor, term);
    let own = Unit::of_term(shown_sensor(sensor), key);
    let text = shown(e).scaled(own.per_si).text();
    let symbol = term.symbol().to_owned();
    let label = if text.interval.is_empty() {
        format!("{symbol} {} {}", text.value, own.page)
    } else {
        format!("{symbol} {} {} {}", text.value, own.page, text.interval)
    };
    Some(AllanTerm {
        symbol,
        label,
        deviation: tau_s
            .iter()
            .map(|&t| alone.allan_variance(t).sqrt() * unit.per_si)
            .collect(),
        upper_limit: limit,
    })
}

/// The Allan deviation of a Gauss–Markov term that was seen.
fn markov_line(
    sensor: Sensor,
    g: &GaussMarkovEstimate,
    tau_s: &[f64],
    unit: Unit,
) -> Option<AllanTerm> {
    let (sigma, time_s) = (g.sigma.value?, g.correlation_time_s.value?);
    let alone = NoiseTerms {
        gauss_markov: vec![(sigma, time_s)],
        ..NoiseTerms::default()
    };
    let own = Unit::of_term(shown_sensor(sensor), "gauss_markov");
    let value = shown(&g.sigma).scaled(own.per_si).text().value;
    let time = shown(&g.correlation_time_s).text().value;
    Some(AllanTerm {
        symbol: "GM".to_owned(),
        label: format!("σ {value} {}, T_c {time} s", own.page),
        deviation: tau_s
            .iter()
            .map(|&t| alone.allan_variance(t).sqrt() * unit.per_si)
            .collect(),
        upper_limit: false,
    })
}

/// The estimate's spectra are two-sided; what is drawn is one-sided, as `allan --spectrum` is.
const SIDES: f64 = 2.0;

fn spectrum(axis: &AxisOutcome, sensor: Sensor) -> Option<SpectrumPanel> {
    let e = axis.estimate.as_ref().filter(|e| !e.spectrum.is_empty())?;
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S_PER_SQRT_HZ,
        Sensor::Accel => Unit::MICRO_G_PER_SQRT_HZ,
    };
    // Single coefficients scatter by their own size: bins of at least eight are shown.
    let mut frequency_hz = Vec::new();
    let mut density = Vec::new();
    let mut fit = Vec::new();
    let mut sums = [0.0; 4];
    for bin in &e.spectrum {
        sums[0] += bin.count;
        sums[1] += bin.count * bin.frequency_hz.ln();
        sums[2] += bin.count * bin.measured;
        sums[3] += bin.count * bin.fitted;
        if sums[0] >= 8.0 {
            frequency_hz.push((sums[1] / sums[0]).exp());
            density.push((SIDES * sums[2] / sums[0]).sqrt() * unit.per_si);
            fit.push((SIDES * sums[3] / sums[0]).sqrt() * unit.per_si);
            sums = [0.0; 4];
        }
    }
    let marks = e
        .sinusoids
        .iter()
        .filter(|s| s.share_of_white > 0.1)
        .take(3)
        .filter_map(|s| {
            let f = s.frequency_hz.value?;
            Some(SpectrumMark {
                frequency_hz: f,
                text: format!("line at {} Hz", general(f, 3)),
            })
        })
        .collect();
    Some(SpectrumPanel {
        axis: axis.axis.clone(),
        unit: unit.page.to_owned(),
        sides: "one-sided".to_owned(),
        frequency_hz,
        density,
        fit,
        marks,
    })
}

fn series(log: &LogOutcome, axis: &AxisOutcome, sensor: Sensor) -> SeriesPanel {
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S,
        Sensor::Accel => Unit::MILLI_G,
    };
    let (off, unit_text) = offset(axis, unit);
    let column = |k: usize| -> Vec<f64> {
        axis.series
            .iter()
            .map(|p| p[k] * unit.per_si - off)
            .collect()
    };
    SeriesPanel {
        axis: axis.axis.clone(),
        unit: unit_text,
        note: format!(
            "scatter {} {}",
            general(axis.scatter * unit.per_si, 3),
            unit.page
        ),
        duration_s: log.duration_s,
        time_s: axis.series.iter().map(|p| p[0]).collect(),
        min: column(1),
        mean: column(2),
        max: column(3),
        findings_s: log
            .issues
            .iter()
            .filter(|i| {
                i.channel
                    .as_deref()
                    .is_none_or(|c| axis.axis.starts_with(c))
            })
            .map(|i| (i.start_s - log.first_s, i.end_s - log.first_s))
            .filter(|(a, b)| b - a < 0.5 * log.duration_s)
            .collect(),
    }
}

/// What is taken off a time series far from zero, in the unit shown, and the unit that says so.
fn offset(axis: &AxisOutcome, unit: Unit) -> (f64, String) {
    let mean = unit.from_si(
        axis.estimate
            .as_ref()
            .and_then(|e| e.mean.value)
            .unwrap_or(0.0),
    );
    let spread = axis
        .series
        .iter()
        .flat_map(|p| [p[1], p[3]])
        .filter(|v| v.is_finite())
        .fold(0.0_f64, |most, v| most.max((unit.from_si(v) - mean).abs()));
    if mean.abs() <= 3.0 * spread || spread <= 0.0 {
        return (0.0, unit.page.to_owned());
    }
    let decimals = if spread > 3.0 { 0 } else { 2 };
    let scale = 10f64.powi(decimals);
    let off = (mean * scale).round() / scale;
    let text = page_number(&fixed(off, if spread > 3.0 { 0 } else { 2 }));
    (off, format!("{0}, less {text} {0}", unit.page))
}
