//! From the estimates of a log to the page of `characterize`, its verdict and what the log could not tell.
//!
//! The lines of the terms are those of [IEEE952] and [SP1065]: √3 Q/τ, N/√τ, 0.664 B, K √(τ/3), R τ/√2, and the
//! closed forms of a Gauss–Markov process and a sinusoid.

use sagnac_analysis::fit::{AxisEstimate, Estimate, Segment, Status, Term};
use sagnac_analysis::{Curve, Density};
use sagnac_log::Issue;
use sagnac_report::html::{
    CharacterizePage, HtmlTable, Input, LogReport, Overview, ParameterCell, ParameterRow, Rich,
    page_text,
};
use sagnac_report::plots::{
    AllanPanel, AllanTerm, IssueBar, IssueTimeline, SeriesPanel, SpectrumMark, SpectrumPanel,
    axis_title,
};
use sagnac_report::svg::page_number;
use sagnac_report::text::{self, Sensor, Unit, duration, fixed, general, group_thousands};

/// Pieces into which a time series is cut.
pub const PIECES: usize = 360;
/// B times this is the floor of the Allan deviation, √(2 ln 2/π).
const FLOOR: f64 = 0.664_292_6;

/// A time series as min, mean and max of equal pieces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pieces {
    /// Middle of each piece in s.
    pub time_s: Vec<f64>,
    /// Smallest sample; not a number where the piece is empty.
    pub min: Vec<f64>,
    /// Mean.
    pub mean: Vec<f64>,
    /// Largest sample.
    pub max: Vec<f64>,
}

impl Pieces {
    /// The pieces of a log of this length (in s); samples are read once.
    pub fn of(segments: &[Segment<'_>], step_s: f64, duration_s: f64) -> Self {
        let samples: usize = segments.iter().map(|s| s.samples.len()).sum();
        let count = PIECES.min(samples.max(1));
        let length_s = duration_s / count as f64;
        let mut min = vec![f64::INFINITY; count];
        let mut max = vec![f64::NEG_INFINITY; count];
        let mut sum = vec![0.0; count];
        let mut number = vec![0_usize; count];
        for segment in segments {
            for (i, &v) in segment.samples.iter().enumerate() {
                if !v.is_finite() {
                    continue;
                }
                let at = (segment.start_s + i as f64 * step_s) / length_s;
                let piece = (at.max(0.0) as usize).min(count - 1);
                min[piece] = min[piece].min(v);
                max[piece] = max[piece].max(v);
                sum[piece] += v;
                number[piece] += 1;
            }
        }
        let known = |values: Vec<f64>| -> Vec<f64> {
            values
                .into_iter()
                .zip(&number)
                .map(|(v, n)| if *n > 0 { v } else { f64::NAN })
                .collect()
        };
        let mean = sum
            .iter()
            .zip(&number)
            .map(|(s, n)| s / *n as f64)
            .collect();
        Self {
            time_s: (0..count).map(|i| (i as f64 + 0.5) * length_s).collect(),
            min: known(min),
            mean,
            max: known(max),
        }
    }
}

/// What is known of one axis; everything in SI.
#[derive(Debug, Clone, Copy)]
pub struct AxisView<'a> {
    /// Channel: `gyro_x`.
    pub name: &'a str,
    /// The joint estimate.
    pub estimate: &'a AxisEstimate,
    /// Overlapping Allan deviation.
    pub curve: &'a Curve,
    /// Welch's density, one-sided; else the bins of the estimate are drawn.
    pub density: Option<&'a Density>,
    /// Step of the data.
    pub lsb: Option<f64>,
    /// Standard deviation of the samples.
    pub scatter: f64,
    /// The time series.
    pub pieces: &'a Pieces,
}

/// What is known of one log.
#[derive(Debug, Clone)]
pub struct LogView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Samples a channel.
    pub samples: u64,
    /// Rate in Hz.
    pub rate_hz: f64,
    /// How the rate is known: `as given`, `regular`; may be empty.
    pub rate_note: &'a str,
    /// Length in s.
    pub duration_s: f64,
    /// Whether it has a temperature channel.
    pub temperature: bool,
    /// Findings of all kinds.
    pub issues: &'a [Issue],
    /// Its axes, gyro first.
    pub axes: Vec<AxisView<'a>>,
}

/// Everything on the page.
#[derive(Debug, Clone)]
pub struct PageView<'a> {
    /// Heading: the name of the log, or of the sensor where there are several.
    pub name: &'a str,
    /// The logs.
    pub logs: Vec<LogView<'a>>,
    /// The command as it was typed.
    pub command: &'a str,
    /// Version of the program.
    pub version: &'a str,
    /// Inputs with their hashes.
    pub inputs: Vec<Input>,
    /// Whether the logs were pooled as runs of one sensor.
    pub one_sensor: bool,
}

/// The page as one file of HTML.
pub fn characterize_html(view: &PageView<'_>) -> String {
    characterize_page(view).html()
}

/// The page as a struct.
pub fn characterize_page(view: &PageView<'_>) -> CharacterizePage {
    let single = view.logs.len() == 1;
    let first = view.logs.first();
    let subtitle = match first {
        Some(log) if single => format!(
            "At rest, {} at {} Hz",
            duration(log.duration_s),
            general(log.rate_hz, 6)
        ),
        _ => format!("{} logs at rest", view.logs.len()),
    };
    let verdict = match first {
        Some(log) if single => rich_verdict(log),
        _ => {
            let disturbed = view
                .logs
                .iter()
                .filter(|log| log.issues.iter().any(|i| !i.kind.is_note()))
                .count();
            Rich::new()
                .bold(format!("{} logs, one after the other.", view.logs.len()))
                .plain(match disturbed {
                    0 => " None has a warning.".to_owned(),
                    1 => " One has warnings.".to_owned(),
                    n => format!(" {n} have warnings."),
                })
        }
    };
    CharacterizePage {
        name: view.name.to_owned(),
        subtitle,
        verdict,
        facts: match first {
            Some(log) if single => facts(log),
            _ => Vec::new(),
        },
        logs: view
            .logs
            .iter()
            .map(|log| log_report(log, view.one_sensor))
            .collect(),
        overview: (!single).then(|| overview(&view.logs)),
        method: "Overlapping Allan deviation; degrees of freedom by noise type and χ² limits at 95 %. The terms \
                 of an axis are estimated jointly from the likelihood of its cosine transform; intervals are \
                 profile-likelihood intervals. Terms as in IEEE Std 528 and 952."
            .into(),
        command: view.command.to_owned(),
        version: view.version.to_owned(),
        inputs: view.inputs.clone(),
    }
}

fn log_report(log: &LogView<'_>, one_sensor: bool) -> LogReport {
    let sensors: Vec<Vec<&AxisView<'_>>> = [Sensor::Gyro, Sensor::Accel]
        .into_iter()
        .map(|s| of_sensor(log, s))
        .filter(|axes| !axes.is_empty())
        .collect();
    LogReport {
        name: log.name.to_owned(),
        verdict: rich_verdict(log),
        facts: facts(log),
        parameters: parameters(log),
        timeline: timeline(log),
        allan: sensors
            .iter()
            .map(|axes| axes.iter().map(|a| allan_panel(a)).collect())
            .collect(),
        spectrum: sensors
            .iter()
            .map(|axes| axes.iter().map(|a| spectrum_panel(a)).collect())
            .collect(),
        series: sensors
            .iter()
            .map(|axes| axes.iter().map(|a| series_panel(log, a)).collect())
            .collect(),
        limits: limits(log, one_sensor),
    }
}

fn of_sensor<'a, 'b>(log: &'b LogView<'a>, sensor: Sensor) -> Vec<&'b AxisView<'a>> {
    log.axes
        .iter()
        .filter(|a| Sensor::of_axis(a.name) == Some(sensor))
        .collect()
}

fn axis_letter(name: &str) -> &str {
    name.rsplit('_').next().unwrap_or(name)
}

/// The estimate as text and pages show it, still in SI.
fn shown(estimate: &Estimate) -> text::Estimate {
    match estimate.status {
        Status::Detected => match (estimate.value, estimate.lower, estimate.upper) {
            (Some(value), Some(lower), Some(upper)) => {
                text::Estimate::detected(value, lower, upper)
            }
            (Some(value), _, _) => text::Estimate::Value(value),
            _ => text::Estimate::Absent,
        },
        Status::UpperLimit => estimate
            .upper
            .map_or(text::Estimate::Absent, text::Estimate::UpperLimit),
        Status::Absent => text::Estimate::Absent,
    }
}

/// The single terms of an axis: JSON name, letter, estimate.
fn terms(sensor: Sensor, e: &AxisEstimate) -> [(&'static str, &'static str, &Estimate); 5] {
    let gyro = sensor == Sensor::Gyro;
    let name = |g, a| if gyro { g } else { a };
    [
        (
            name("angle_random_walk", "velocity_random_walk"),
            "N",
            &e.white,
        ),
        ("bias_instability", "B", &e.flicker),
        (
            name("rate_random_walk", "acceleration_random_walk"),
            "K",
            &e.random_walk,
        ),
        ("quantization", "Q", &e.quantization),
        (name("rate_ramp", "acceleration_ramp"), "R", &e.ramp),
    ]
}

fn facts(log: &LogView<'_>) -> Vec<(String, String)> {
    let fact = |name: &str, value: String| (name.to_owned(), page_number(&value));
    let mut out = vec![fact("Samples", group_thousands(&log.samples.to_string()))];
    let rate = if log.rate_note.is_empty() {
        format!("{} Hz", general(log.rate_hz, 6))
    } else {
        format!("{} Hz, {}", general(log.rate_hz, 6), log.rate_note)
    };
    out.push(fact("Rate", rate));
    out.push(fact("Duration", text::seconds(log.duration_s)));
    let gyro = of_sensor(log, Sensor::Gyro);
    let accel = of_sensor(log, Sensor::Accel);
    let channels: Vec<String> = [(gyro.len(), "gyro"), (accel.len(), "accel")]
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, name)| format!("{n} {name}"))
        .collect();
    out.push(fact("Channels", channels.join(", ")));
    let range = |axes: &[&AxisView<'_>], unit: Unit| -> Option<String> {
        let most = axes
            .iter()
            .flat_map(|a| a.pieces.min.iter().chain(&a.pieces.max))
            .filter(|v| v.is_finite())
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        (!axes.is_empty()).then(|| format!("±{} {}", general(unit.from_si(most), 3), unit.page))
    };
    let ranges: Vec<String> = [range(&gyro, Unit::DEG_PER_S), range(&accel, Unit::G)]
        .into_iter()
        .flatten()
        .collect();
    out.push(fact("Range used", ranges.join(", ")));
    if let Some(norm) = norm(&accel) {
        out.push(fact(
            "|f| at rest",
            format!("{} g", fixed(Unit::G.from_si(norm), 3)),
        ));
    }
    let temperature = if log.temperature {
        "recorded"
    } else {
        "not recorded"
    };
    out.push(fact("Temperature", temperature.to_owned()));
    let warnings = log.issues.iter().filter(|i| !i.kind.is_note()).count();
    let notes = log.issues.len() - warnings;
    let findings = match (warnings, notes) {
        (0, 0) => "none".to_owned(),
        (w, 0) => plural(w, "warning"),
        (0, n) => plural(n, "note"),
        (w, n) => format!("{}, {}", plural(w, "warning"), plural(n, "note")),
    };
    out.push(fact("Findings", findings));
    out
}

fn plural(count: usize, word: &str) -> String {
    if count == 1 {
        format!("1 {word}")
    } else {
        format!("{count} {word}s")
    }
}

/// Norm of the means of a triad; `None` unless there are three axes.
fn norm(axes: &[&AxisView<'_>]) -> Option<f64> {
    if axes.len() != 3 {
        return None;
    }
    let sum: Option<f64> = axes
        .iter()
        .map(|a| a.estimate.mean.value.map(|v| v * v))
        .sum();
    sum.map(f64::sqrt)
}

fn parameters(log: &LogView<'_>) -> Vec<ParameterRow> {
    let mut rows = Vec::new();
    for sensor in [Sensor::Gyro, Sensor::Accel] {
        let axes = of_sensor(log, sensor);
        if axes.is_empty() {
            continue;
        }
        let at = |letter: &str| axes.iter().find(|a| axis_letter(a.name) == letter).copied();
        let row_of = |cell: &dyn Fn(&AxisView<'_>) -> ParameterCell| -> [ParameterCell; 3] {
            ["x", "y", "z"].map(|l| at(l).map_or(ParameterCell::Absent, cell))
        };
        let Some(any) = axes.first() else { continue };
        for (i, (term, letter, _)) in terms(sensor, any.estimate).into_iter().enumerate() {
            let cells = row_of(&|a| ParameterCell::Estimate(shown(terms(sensor, a.estimate)[i].2)));
            let seen = cells.iter().any(|c| {
                !matches!(
                    c,
                    ParameterCell::Absent | ParameterCell::Estimate(text::Estimate::Absent)
                )
            });
            if seen || matches!(letter, "N" | "B" | "K") {
                rows.push(ParameterRow {
                    cells,
                    ..ParameterRow::estimates(sensor, term, [text::Estimate::Absent; 3])
                });
            }
        }
        process_rows(sensor, &axes, &row_of, &mut rows);
        rows.push(ParameterRow {
            cells: row_of(&|a| ParameterCell::Estimate(mean_of(a))),
            ..ParameterRow::estimates(sensor, "mean", [text::Estimate::Absent; 3])
        });
        if axes.iter().any(|a| a.lsb.is_some()) {
            rows.push(ParameterRow {
                sensor,
                term: "lsb".to_owned(),
                name: "Rounding step seen in the data".to_owned(),
                unit: Some(Unit::of_term(sensor, "lsb")),
                cells: row_of(&|a| {
                    a.lsb
                        .map_or(ParameterCell::Absent, |value| ParameterCell::Number {
                            value,
                            note: format!(
                                "{} of the scatter",
                                text::significant(value / a.scatter, 2)
                            ),
                        })
                }),
            });
        }
        rows.push(ParameterRow {
            sensor,
            term: "fit".to_owned(),
            name: "Do the terms explain the curve?".to_owned(),
            unit: None,
            cells: row_of(&|a| {
                a.estimate.p_value.map_or(ParameterCell::Absent, |p| {
                    let (word, class) = match p {
                        p if p >= 0.05 => ("yes", "good"),
                        p if p >= 0.001 => ("barely", "warn"),
                        _ => ("no", "bad"),
                    };
                    ParameterCell::Word {
                        word: word.to_owned(),
                        class,
                        note: if p < 0.001 {
                            "p < 0.001".to_owned()
                        } else {
                            format!("p = {}", text::significant(p, 2))
                        },
                    }
                })
            }),
        });
    }
    rows
}

/// The mean; from its standard error where it carries no interval.
fn mean_of(axis: &AxisView<'_>) -> text::Estimate {
    let mean = &axis.estimate.mean;
    match (shown(mean), mean.value, mean.sigma) {
        (text::Estimate::Value(_) | text::Estimate::Absent, Some(value), Some(sigma)) => {
            text::Estimate::plus_minus(value, 1.96 * sigma)
        }
        (estimate, _, _) => estimate,
    }
}

type CellOf<'f> = dyn Fn(&dyn Fn(&AxisView<'_>) -> ParameterCell) -> [ParameterCell; 3] + 'f;

/// Rows of Gauss–Markov processes and sinusoids: one a process and number.
fn process_rows(
    sensor: Sensor,
    axes: &[&AxisView<'_>],
    row_of: &CellOf<'_>,
    rows: &mut Vec<ParameterRow>,
) {
    let most = |count: &dyn Fn(&AxisEstimate) -> usize| {
        axes.iter().map(|a| count(a.estimate)).max().unwrap_or(0)
    };
    let cell = |e: Option<&Estimate>| {
        e.map_or(ParameterCell::Absent, |e| ParameterCell::Estimate(shown(e)))
    };
    let mut push = |term: &str, name: String, unit: Unit, cells: [ParameterCell; 3]| {
        rows.push(ParameterRow {
            sensor,
            term: term.to_owned(),
            name,
            unit: Some(unit),
            cells,
        });
    };
    let processes = most(&|e| e.gauss_markov.len());
    for i in 0..processes {
        let number = if processes > 1 {
            format!(" {}", i + 1)
        } else {
            String::new()
        };
        push(
            "gauss_markov",
            format!("Gauss–Markov{number}, σ"),
            Unit::of_term(sensor, "gauss_markov"),
            row_of(&|a| cell(a.estimate.gauss_markov.get(i).map(|g| &g.sigma))),
        );
        let timed = axes.iter().any(|a| {
            a.estimate
                .gauss_markov
                .get(i)
                .is_some_and(|g| g.correlation_time_s.is_detected())
        });
        if timed {
            push(
                "gauss_markov",
                format!("Gauss–Markov{number}, correlation time"),
                Unit::S,
                row_of(&|a| {
                    cell(
                        a.estimate
                            .gauss_markov
                            .get(i)
                            .map(|g| &g.correlation_time_s),
                    )
                }),
            );
        }
    }
    let lines = most(&|e| e.sinusoids.len()).min(4);
    for i in 0..lines {
        let number = if lines > 1 {
            format!(" {}", i + 1)
        } else {
            String::new()
        };
        push(
            "sinusoids",
            format!("Line{number}, amplitude"),
            Unit::of_term(sensor, "sinusoids"),
            row_of(&|a| cell(a.estimate.sinusoids.get(i).map(|s| &s.amplitude))),
        );
        push(
            "sinusoids",
            format!("Line{number}, frequency"),
            Unit::HZ,
            row_of(&|a| cell(a.estimate.sinusoids.get(i).map(|s| &s.frequency_hz))),
        );
    }
}

fn channel_words(channel: Option<&str>) -> String {
    channel.unwrap_or("log").replace('_', " ")
}

fn timeline(log: &LogView<'_>) -> IssueTimeline {
    let mut issues: Vec<&Issue> = log.issues.iter().collect();
    issues.sort_by_key(|i| i.kind.is_note());
    IssueTimeline {
        duration_s: log.duration_s,
        issues: issues
            .into_iter()
            .map(|issue| {
                let whole = issue.end_s - issue.start_s >= 0.98 * log.duration_s;
                IssueBar {
                    channel: channel_words(issue.channel.as_deref()),
                    kind: issue.kind.name().to_owned(),
                    text: page_text(&issue.text),
                    span_s: (!whole).then_some((issue.start_s, issue.end_s)),
                    warning: !issue.kind.is_note(),
                }
            })
            .collect(),
    }
}

/// Label of a term on its line: letter, value, unit, interval.
fn label(letter: &str, estimate: text::Estimate, unit: Unit) -> String {
    let text = estimate.scaled(unit.per_si).text();
    let label = if text.interval.is_empty() {
        format!("{letter} {} {}", text.value, unit.page)
    } else {
        format!("{letter} {} {} {}", text.value, unit.page, text.interval)
    };
    page_number(&label)
}

fn allan_unit(sensor: Sensor) -> Unit {
    match sensor {
        Sensor::Gyro => Unit::DEG_PER_H,
        Sensor::Accel => Unit::MICRO_G,
    }
}

fn allan_panel(axis: &AxisView<'_>) -> AllanPanel {
    let sensor = Sensor::of_axis(axis.name).unwrap_or(Sensor::Gyro);
    let unit = allan_unit(sensor);
    let scale = |v: f64| unit.from_si(v);
    let tau = &axis.curve.tau_s;
    let opt = |values: &[Option<f64>]| -> Vec<f64> {
        values.iter().map(|v| v.map_or(f64::NAN, scale)).collect()
    };
    let mut drawn = Vec::new();
    for (name, letter, estimate) in terms(sensor, axis.estimate) {
        let (value, limit) = match (estimate.status, estimate.value, estimate.upper) {
            (Status::Detected, Some(value), _) => (value, false),
            (Status::UpperLimit, _, Some(upper)) => (upper, true),
            _ => continue,
        };
        let (factor, exponent) = match letter {
            "Q" => (3f64.sqrt(), -1.0),
            "N" => (1.0, -0.5),
            "B" => (FLOOR, 0.0),
            "K" => (1.0 / 3f64.sqrt(), 0.5),
            _ => (0.5f64.sqrt(), 1.0),
        };
        let text = label(letter, shown(estimate), Unit::of_term(sensor, name));
        let term = AllanTerm::power(letter, &text, scale(factor * value.abs()), exponent, tau);
        drawn.push(if limit { term.as_limit() } else { term });
    }
    for (i, &(sigma, time_s)) in axis.estimate.fitted.gauss_markov.iter().enumerate() {
        let of = axis.estimate.gauss_markov.get(i).map(|g| shown(&g.sigma));
        drawn.push(AllanTerm {
            symbol: "GM".to_owned(),
            label: label("GM σ", of.unwrap_or_default(), unit),
            deviation: tau
                .iter()
                .map(|t| scale(gauss_markov_deviation(sigma, time_s, *t)))
                .collect(),
            upper_limit: false,
        });
    }
    let fitted = &axis.estimate.fitted;
    let fit: Vec<f64> = tau
        .iter()
        .map(|t| scale(fitted_deviation(fitted, *t)))
        .collect();
    let known = fit.iter().any(|v| *v > 0.0);
    AllanPanel {
        axis: axis.name.to_owned(),
        unit: unit.page.to_owned(),
        tau_s: tau.clone(),
        deviation: axis.curve.deviation.iter().map(|v| scale(*v)).collect(),
        lower: opt(&axis.curve.lower),
        upper: opt(&axis.curve.upper),
        fit: if known { fit } else { Vec::new() },
        terms: drawn,
        ..AllanPanel::default()
    }
}

/// Allan deviation of a Gauss–Markov process of standard deviation `sigma`.
fn gauss_markov_deviation(sigma: f64, time_s: f64, tau_s: f64) -> f64 {
    let x = tau_s / time_s;
    // Where x is small the closed form cancels: σ²(τ) → (2/3) σ² τ/T.
    let share = if x < 1e-3 {
        2.0 / 3.0 * x
    } else {
        2.0 / x * (1.0 - (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()) / (2.0 * x))
    };
    sigma * share.max(0.0).sqrt()
}

/// Allan deviation of the sum of the fitted terms.
pub fn fitted_deviation(terms: &sagnac_analysis::fit::NoiseTerms, tau_s: f64) -> f64 {
    let mut variance = 3.0 * (terms.quantization / tau_s).powi(2)
        + terms.white.powi(2) / tau_s
        + (FLOOR * terms.flicker).powi(2)
        + terms.random_walk.powi(2) * tau_s / 3.0
        + 0.5 * (terms.ramp * tau_s).powi(2);
    for &(sigma, time_s) in &terms.gauss_markov {
        variance += gauss_markov_deviation(sigma, time_s, tau_s).powi(2);
    }
    for &(amplitude, frequency_hz) in &terms.sinusoids {
        let angle = std::f64::consts::PI * frequency_hz * tau_s;
        if angle > 0.0 {
            variance += (amplitude * angle.sin().powi(2) / angle).powi(2);
        }
    }
    variance.sqrt()
}

fn spectrum_panel(axis: &AxisView<'_>) -> SpectrumPanel {
    let sensor = Sensor::of_axis(axis.name).unwrap_or(Sensor::Gyro);
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S_PER_SQRT_HZ,
        Sensor::Accel => Unit::MICRO_G_PER_SQRT_HZ,
    };
    let lines: Vec<f64> = axis
        .estimate
        .sinusoids
        .iter()
        .filter_map(|s| s.frequency_hz.value)
        .collect();
    let bins = &axis.estimate.spectrum;
    let (frequency_hz, density) = match axis.density {
        Some(welch) => binned(welch, &lines, bins.first().map(|b| b.frequency_hz)),
        None => bins.iter().map(|b| (b.frequency_hz, b.measured)).unzip(),
    };
    let (frequency_hz, density) = match bins.first() {
        // Below the lowest frequency of Welch's pieces the bins of the estimate go on.
        Some(_) if axis.density.is_some() => {
            let start = frequency_hz.first().copied().unwrap_or(f64::INFINITY);
            let mut f: Vec<f64> = Vec::new();
            let mut s: Vec<f64> = Vec::new();
            for b in bins.iter().filter(|b| b.frequency_hz < start) {
                f.push(b.frequency_hz);
                s.push(b.measured);
            }
            f.extend(frequency_hz);
            s.extend(density);
            (f, s)
        }
        _ => (frequency_hz, density),
    };
    let fit = frequency_hz
        .iter()
        .map(|f| unit.from_si(interpolate(bins, *f).sqrt()))
        .collect();
    SpectrumPanel {
        axis: axis.name.to_owned(),
        unit: unit.page.to_owned(),
        sides: "two-sided".to_owned(),
        density: density.iter().map(|s| unit.from_si(s.sqrt())).collect(),
        frequency_hz,
        fit,
        marks: lines
            .iter()
            .map(|f| SpectrumMark {
                frequency_hz: *f,
                text: format!("line at {} Hz", text::significant(*f, 3)),
            })
            .collect(),
    }
}

/// Two-sided density averaged over bins of equal ratio; a bin with a line keeps its largest value.
fn binned(welch: &Density, lines: &[f64], _start: Option<f64>) -> (Vec<f64>, Vec<f64>) {
    const BINS: f64 = 260.0;
    let (Some(&low), Some(&high)) = (welch.frequency_hz.first(), welch.frequency_hz.last()) else {
        return (Vec::new(), Vec::new());
    };
    let ratio = (high / low).powf(1.0 / BINS).max(1.0 + 1e-9);
    let (mut frequency, mut density) = (Vec::new(), Vec::new());
    let mut i = 0;
    while i < welch.frequency_hz.len() {
        let start = welch.frequency_hz[i];
        let mut j = i;
        let (mut sum, mut most, mut log_sum) = (0.0, 0.0_f64, 0.0);
        while j < welch.frequency_hz.len() && welch.frequency_hz[j] <= start * ratio {
            sum += welch.density[j];
            most = most.max(welch.density[j]);
            log_sum += welch.frequency_hz[j].ln();
            j += 1;
        }
        let count = (j - i) as f64;
        let line = lines
            .iter()
            .any(|f| *f >= start / ratio && *f <= start * ratio * ratio);
        frequency.push((log_sum / count).exp());
        density.push(0.5 * if line { most } else { sum / count });
        i = j.max(i + 1);
    }
    (frequency, density)
}

fn interpolate(bins: &[sagnac_analysis::fit::SpectrumBin], frequency_hz: f64) -> f64 {
    let after = bins.partition_point(|b| b.frequency_hz < frequency_hz);
    match (
        after.checked_sub(1).and_then(|i| bins.get(i)),
        bins.get(after),
    ) {
        (Some(a), Some(b))
            if a.fitted > 0.0 && b.fitted > 0.0 && b.frequency_hz > a.frequency_hz =>
        {
            let t = (frequency_hz / a.frequency_hz).ln() / (b.frequency_hz / a.frequency_hz).ln();
            (a.fitted.ln() + t * (b.fitted.ln() - a.fitted.ln())).exp()
        }
        (Some(a), None) => a.fitted,
        (_, Some(b)) => b.fitted,
        _ => f64::NAN,
    }
}

fn series_panel(log: &LogView<'_>, axis: &AxisView<'_>) -> SeriesPanel {
    let sensor = Sensor::of_axis(axis.name).unwrap_or(Sensor::Gyro);
    let unit = match sensor {
        Sensor::Gyro => Unit::DEG_PER_S,
        Sensor::Accel => Unit::MILLI_G,
    };
    let mean = axis.estimate.mean.value.unwrap_or(0.0);
    let spread = axis
        .pieces
        .min
        .iter()
        .chain(&axis.pieces.max)
        .filter(|v| v.is_finite())
        .fold(0.0_f64, |m, v| m.max((v - mean).abs()));
    // Far from zero the axis would show digits, not the signal.
    let (off, shown_unit) = if mean.abs() > 3.0 * spread {
        let off = fixed(
            unit.from_si(mean),
            if unit.from_si(spread) > 3.0 { 0 } else { 2 },
        );
        let number: f64 = off.replace(' ', "").parse().unwrap_or(0.0);
        (
            number,
            format!("{}, less {} {}", unit.page, page_number(&off), unit.page),
        )
    } else {
        (0.0, unit.page.to_owned())
    };
    let scale = |values: &[f64]| values.iter().map(|v| unit.from_si(*v) - off).collect();
    SeriesPanel {
        axis: axis.name.to_owned(),
        unit: shown_unit,
        note: format!(
            "scatter {} {}",
            page_number(&text::significant(unit.from_si(axis.scatter), 3)),
            unit.page
        ),
        duration_s: log.duration_s,
        time_s: axis.pieces.time_s.clone(),
        min: scale(&axis.pieces.min),
        mean: scale(&axis.pieces.mean),
        max: scale(&axis.pieces.max),
        findings_s: log
            .issues
            .iter()
            .filter(|i| !i.kind.is_note())
            .filter(|i| {
                i.channel
                    .as_deref()
                    .is_none_or(|c| c == axis.name || c == sensor.key() || c == "time")
            })
            .filter(|i| i.end_s - i.start_s < 0.9 * log.duration_s)
            .map(|i| (i.start_s, i.end_s))
            .collect(),
    }
}

/// A sentence of a verdict: its bold start and the rest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sentence {
    /// Bold start.
    pub bold: String,
    /// The rest, with its leading space.
    pub rest: String,
}

fn rich_verdict(log: &LogView<'_>) -> Rich {
    let mut rich = Rich::new();
    for (i, sentence) in verdict(log).into_iter().enumerate() {
        if i > 0 {
            rich = rich.plain(" ");
        }
        rich = rich.bold(sentence.bold).plain(sentence.rest);
    }
    rich
}

/// The verdict in words, a sentence or two a sensor; used by the page and by the terminal.
pub fn verdict(log: &LogView<'_>) -> Vec<Sentence> {
    [Sensor::Gyro, Sensor::Accel]
        .into_iter()
        .filter_map(|sensor| {
            let axes = of_sensor(log, sensor);
            (!axes.is_empty()).then(|| verdict_of(log, sensor, &axes))
        })
        .collect()
}

fn verdict_of(log: &LogView<'_>, sensor: Sensor, axes: &[&AxisView<'_>]) -> Sentence {
    let name = match sensor {
        Sensor::Gyro => "gyro",
        Sensor::Accel => "accelerometer",
    };
    let white = precision(axes.iter().map(|a| &a.estimate.white));
    let flicker = precision(axes.iter().map(|a| &a.estimate.flicker));
    let disturbed: Vec<&Issue> = log
        .issues
        .iter()
        .filter(|i| {
            matches!(
                i.kind.name(),
                "motion" | "step" | "warm_up" | "non_stationary" | "saturation" | "stuck" | "nan"
            ) && i
                .channel
                .as_deref()
                .is_some_and(|c| Sensor::of_axis(c) == Some(sensor))
        })
        .collect();
    let all_white = axes.iter().all(|a| a.estimate.white.is_detected());
    let with_flicker: Vec<&str> = axes
        .iter()
        .filter(|a| a.estimate.flicker.is_detected())
        .map(|a| axis_letter(a.name))
        .collect();
    let misfit: Vec<&str> = axes
        .iter()
        .filter(|a| a.estimate.p_value.is_some_and(|p| p < 0.001))
        .map(|a| axis_letter(a.name))
        .collect();
    let mut sentence = if !all_white {
        let missing: Vec<&str> = axes
            .iter()
            .filter(|a| !a.estimate.white.is_detected())
            .map(|a| axis_letter(a.name))
            .collect();
        Sentence {
            bold: format!("The {name} shows no white noise on {}.", listed(&missing)),
            rest: " Something else is larger: look at its curve before using the numbers."
                .to_owned(),
        }
    } else if !disturbed.is_empty() {
        let mut kinds: Vec<String> = disturbed
            .iter()
            .map(|i| i.kind.name().replace('_', " "))
            .collect();
        kinds.sort();
        kinds.dedup();
        Sentence {
            bold: format!("The {name} was disturbed:"),
            rest: format!(
                " {} ({}). Its white noise is known to {}; read its bias instability and random walk as upper \
                 bounds.",
                plural(disturbed.len(), "warning"),
                kinds.join(", "),
                white.text()
            ),
        }
    } else if with_flicker.len() == axes.len() {
        Sentence {
            bold: format!("The {name} is well determined."),
            rest: format!(
                " White noise is known to {}{}, bias instability to {}.",
                white.text(),
                if axes.len() > 1 { " on every axis" } else { "" },
                flicker.text()
            ),
        }
    } else if with_flicker.is_empty() {
        Sentence {
            bold: format!("The {name}’s white noise is known to {}.", white.text()),
            rest: " The log is too short for its bias instability, which is bounded from above."
                .to_owned(),
        }
    } else {
        Sentence {
            bold: format!("The {name}’s white noise is known to {}.", white.text()),
            rest: format!(
                " Bias instability stands out on {} alone; the other terms are bounded from above.",
                listed(&with_flicker)
            ),
        }
    };
    if !misfit.is_empty() {
        sentence.rest += " The terms do not explain the curve of ";
        sentence.rest += &listed(&misfit);
        sentence.rest.push('.');
    }
    sentence
}

fn listed(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// Smallest and largest half width of 95 % intervals over their values.
struct Precision {
    low: f64,
    high: f64,
}

fn precision<'a>(estimates: impl Iterator<Item = &'a Estimate>) -> Precision {
    let mut out = Precision {
        low: f64::INFINITY,
        high: 0.0,
    };
    for e in estimates {
        if let (Some(v), Some(l), Some(u)) = (e.value.filter(|v| *v > 0.0), e.lower, e.upper) {
            let r = 0.5 * (u - l) / v;
            out.low = out.low.min(r);
            out.high = out.high.max(r);
        }
    }
    out
}

impl Precision {
    fn text(&self) -> String {
        let digit = |r: f64| text::significant(100.0 * r, 1);
        let (low, high) = (digit(self.low), digit(self.high));
        if low == high || !self.low.is_finite() {
            format!("{high} %")
        } else {
            format!("{low}–{high} %")
        }
    }
}

/// What this log could not tell, a bold subject and a sentence each.
pub fn limits(log: &LogView<'_>, one_sensor: bool) -> Vec<Rich> {
    let mut out = Vec::new();
    let mut say = |bold: String, rest: String| out.push(Rich::new().bold(bold).plain(rest));
    if !log.temperature {
        say(
            "Temperature.".to_owned(),
            " The log has no temperature channel, so a slow change of temperature would be counted as random \
             walk or bias instability. Record one."
                .to_owned(),
        );
    }
    let gyro = of_sensor(log, Sensor::Gyro);
    let accel = of_sensor(log, Sensor::Accel);
    if let Some(rate) = norm(&gyro) {
        let rate = page_number(&text::significant(Unit::DEG_PER_H.from_si(rate), 3));
        say(
            "Earth rate.".to_owned(),
            format!(
                " The mean rate is {rate} °/h, bias and at most 15 °/h of earth rate, which cannot be told \
                 from it without turning the sensor."
            ),
        );
    }
    let scale = norm(&accel).map_or_else(String::new, |f| {
        let g = Unit::G.from_si(f);
        format!(
            " |f| = {} g says that scale factor or bias is off by about {} % of g, not which.",
            fixed(g, 3),
            text::significant(100.0 * (g - 1.0).abs(), 2)
        )
    });
    say(
        "Scale factor, misalignment, g-sensitivity.".to_owned(),
        format!(" Not observable at rest.{scale}"),
    );
    let rounded: Vec<&str> = log
        .axes
        .iter()
        .filter(|a| a.lsb.is_some() && !a.estimate.quantization.is_detected())
        .map(|a| a.name)
        .collect();
    if !rounded.is_empty() {
        say(
            "Quantization noise.".to_owned(),
            " The sensor rounds its output: that noise is white and is part of N. A separate Q was not seen."
                .to_owned(),
        );
    }
    weak_terms(log, &mut say);
    if !one_sensor {
        out.insert(
            usize::from(!log.temperature),
            Rich::new()
                .bold("Run-to-run bias.")
                .plain(" One run shows one bias. Record five or more switch-ons and add ")
                .code("--one-sensor")
                .plain("."),
        );
    }
    out
}

fn weak_terms(log: &LogView<'_>, say: &mut impl FnMut(String, String)) {
    let mut unseen: Vec<String> = Vec::new();
    for axis in &log.axes {
        let Some(sensor) = Sensor::of_axis(axis.name) else {
            continue;
        };
        let title = axis_title(axis.name).to_lowercase();
        for (term, letter, e) in terms(sensor, axis.estimate) {
            let name = text::term_name(term);
            if matches!(letter, "N" | "B" | "K") && e.status == Status::UpperLimit {
                unseen.push(format!("{} of {title}", name.to_lowercase()));
            }
            if let (Some(v), Some(l), Some(u)) = (e.value, e.lower, e.upper) {
                let r = 0.5 * (u - l) / v.abs().max(1e-300);
                if e.is_detected() && r > 0.6 {
                    say(
                        format!("{name} of {title}"),
                        format!(
                            " is known to ±{} % only. A longer log would narrow it; sagnac plan says by how much.",
                            text::significant(100.0 * r, 2)
                        ),
                    );
                }
            }
        }
        for (a, b) in &axis.estimate.confused {
            say(
                format!("{} and {} of {title}", term_word(*a), term_word(*b)),
                " cannot be told apart in this log.".to_owned(),
            );
        }
    }
    if !unseen.is_empty() {
        say(
            "Not seen:".to_owned(),
            format!(" {}. Their limits stand in the table.", unseen.join(", ")),
        );
    }
}

fn term_word(term: Term) -> &'static str {
    match term {
        Term::Quantization => "Quantization noise",
        Term::White => "White noise",
        Term::Flicker => "Bias instability",
        Term::RandomWalk => "Random walk",
        Term::Ramp => "Ramp",
        Term::GaussMarkov => "Gauss–Markov noise",
        Term::Sinusoid => "A line",
    }
}

fn overview(logs: &[LogView<'_>]) -> Overview {
    let mut table = HtmlTable::new(
        "overview",
        &[
            "Log",
            "Duration",
            "Rate",
            "Findings",
            "Gyro N, °/√h",
            "Accel. N, m/s/√h",
        ],
        &[],
    );
    for log in logs {
        let white = |sensor: Sensor, unit: Unit| -> String {
            let values: Vec<String> = of_sensor(log, sensor)
                .iter()
                .map(|a| {
                    a.estimate
                        .white
                        .value
                        .map_or_else(|| "—".to_owned(), |v| text::significant(unit.from_si(v), 3))
                })
                .collect();
            page_number(&values.join("  "))
        };
        let warnings = log.issues.iter().filter(|i| !i.kind.is_note()).count();
        table.row(vec![
            log.name.into(),
            duration(log.duration_s).into(),
            format!("{} Hz", general(log.rate_hz, 6)).into(),
            plural(warnings, "warning").into(),
            white(Sensor::Gyro, Unit::DEG_PER_SQRT_H).into(),
            white(Sensor::Accel, Unit::M_PER_S_PER_SQRT_H).into(),
        ]);
    }
    Overview {
        lead: "x, y, z of each log side by side.".to_owned(),
        table,
    }
}
