//! Writes every plot and page, with made-up numbers, into a folder: `cargo run --example gallery -- DIR`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::path::Path;

use sagnac_report::html::{
    BudgetRow, CalibrationPage, CertificatePage, CharacterizePage, ChartPage, ComparePage,
    CompareRow, DriftPage, ExplainPage, Input, LogReport, Opening, ParameterCell, ParameterRow,
    RandomRow, Reference, ResponsePage, ResponseRow, ResultRow, ResultTable, Rich,
};
use sagnac_report::plots::{
    AllanPanel, AllanTerm, ChartCurve, Color, CurveChart, IssueBar, IssueTimeline, allan_panels,
};
use sagnac_report::plots::{
    CorrelationMap, DriftCloud, DriftGrowth, DriftShare, ExplainPanel, Figure, Histogram, Marker,
    PoseSphere, Region, ResponsePlots, ScatterChart, ScatterPoint, SeriesPanel, SpectrumMark,
    SpectrumPanel, StationResiduals, explain_panels,
};
use sagnac_report::svg::Svg;
use sagnac_report::text::{Estimate, Sensor, Unit};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dir = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "gallery".to_owned());
    let dir = Path::new(&dir);
    std::fs::create_dir_all(dir)?;
    let figures = allan_panels(&gyro());
    let sheet = Svg::sheet(
        "Allan deviation",
        &[figures
            .iter()
            .map(|f| f.svg.captioned(&f.caption, &f.caption_rest))
            .collect()],
    );
    put(dir, "allan-panels", &sheet)?;
    let issues = issues().figure();
    put(dir, "issues", &issues.svg)?;
    if let Some(narrow) = &issues.narrow {
        put(dir, "issues-narrow", narrow)?;
    }
    let charts = Svg::sheet(
        "example: overlapping Allan deviation, 95 % band",
        &[vec![chart("gyro"), chart("accelerometer")]],
    );
    put(dir, "allan-chart", &charts)?;
    std::fs::write(dir.join("characterize.html"), characterize().html())?;
    for (name, html) in pages() {
        std::fs::write(dir.join(name), html)?;
    }
    for figure in others() {
        put(dir, &figure.plot, &figure.svg)?;
        if let Some(narrow) = &figure.narrow {
            put(dir, &format!("{}-narrow", figure.plot), narrow)?;
        }
    }
    Ok(())
}

fn put(dir: &Path, name: &str, svg: &Svg) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::write(dir.join(format!("{name}.svg")), svg.standalone())?;
    std::fs::write(dir.join(format!("{name}.png")), svg.to_png()?)?;
    println!("{name}");
    Ok(())
}

fn tau() -> Vec<f64> {
    (0..60)
        .map(|i| 0.01 * 10f64.powf(f64::from(i) * 5.06 / 59.0))
        .collect()
}

fn sum(n: f64, b: f64, k: f64) -> Vec<f64> {
    tau()
        .iter()
        .map(|t| (n * n / t + (0.664 * b).powi(2) + k * k * t / 3.0).sqrt())
        .collect()
}

fn gyro() -> Vec<AllanPanel> {
    [(144.8, 24.0, 2.5), (152.6, 36.0, 2.8), (136.0, 26.0, 2.5)]
        .iter()
        .zip(["gyro_x", "gyro_y", "gyro_z"])
        .map(|(&(n, b, k), axis)| {
            let tau_s = tau();
            let fit = sum(n, b, k);
            let deviation: Vec<f64> = fit
                .iter()
                .zip(&tau_s)
                .map(|(f, t)| {
                    f * (1.0 + 0.06 * (3.0 * t.ln()).sin() * (t / 1000.0).sqrt().min(1.0))
                })
                .collect();
            let width: Vec<f64> = tau_s.iter().map(|t| (t / 4000.0).sqrt().min(0.8)).collect();
            AllanPanel {
                axis: axis.to_owned(),
                unit: "°/h".to_owned(),
                lower: deviation
                    .iter()
                    .zip(&width)
                    .map(|(d, w)| d * (1.0 - 0.6 * w))
                    .collect(),
                upper: deviation
                    .iter()
                    .zip(&width)
                    .map(|(d, w)| d * (1.0 + w))
                    .collect(),
                terms: vec![
                    AllanTerm::power("N", "N 2.414 °/√h ± 0.021", n, -0.5, &tau_s),
                    AllanTerm::power("B", "B 24 °/h 12 … 32", 0.664 * b, 0.0, &tau_s),
                    AllanTerm::power("K", "K 150 °/h/√h ± 130", k / 3f64.sqrt(), 0.5, &tau_s),
                    AllanTerm::power("Q", "Q < 1.2″", 4.0, -1.0, &tau_s).as_limit(),
                ],
                fit,
                deviation,
                tau_s,
                ..AllanPanel::default()
            }
        })
        .collect()
}

fn chart(sensor: &str) -> Svg {
    let curves = gyro()
        .into_iter()
        .zip(["x", "y", "z"])
        .enumerate()
        .map(|(i, (panel, label))| ChartCurve {
            label: label.to_owned(),
            color: Color::of_index(i),
            x: panel.tau_s,
            y: panel.deviation,
            lower: panel.lower,
            upper: panel.upper,
            ..ChartCurve::default()
        })
        .collect();
    CurveChart::allan(sensor, &format!("{sensor}: Allan deviation, °/h"), curves).draw()
}

fn issues() -> IssueTimeline {
    let bar = |channel: &str, kind: &str, text: &str, span_s, warning| IssueBar {
        channel: channel.to_owned(),
        kind: kind.to_owned(),
        text: text.to_owned(),
        span_s,
        warning,
    };
    IssueTimeline {
        duration_s: 10_000.0,
        issues: vec![
            bar(
                "accel",
                "motion",
                "it was still settling: level changes by up to 36 mm/s² in the first 70 s",
                Some((0.0, 70.0)),
                true,
            ),
            bar(
                "accel",
                "step",
                "step of −20, −14, −13 mm/s² at 33 min 40 s",
                Some((2020.0, 2020.0)),
                true,
            ),
            bar(
                "accel",
                "moved",
                "moved for 40 s and back",
                Some((9600.0, 9640.0)),
                true,
            ),
            bar(
                "accel",
                "line",
                "line at 0.568 Hz, amplitude 10, 5.2 and 7.5 mm/s²",
                None,
                false,
            ),
            bar(
                "gyro z",
                "filtered",
                "not white above 10 Hz: N is taken below 3 Hz",
                None,
                false,
            ),
        ],
    }
}

/// A number that looks like noise, without a generator: the fraction of a large multiple of a sine.
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545;
    x - x.floor() - 0.5
}

fn spectrum(axis: &str) -> SpectrumPanel {
    let frequency_hz: Vec<f64> = (0..160)
        .map(|i| 1e-4 * 10f64.powf(f64::from(i) * 5.7 / 159.0))
        .collect();
    let fit: Vec<f64> = frequency_hz
        .iter()
        .map(|f| (0.04f64.powi(2) + 3e-6 / f + 1e-9 / f / f).sqrt())
        .collect();
    let density = fit
        .iter()
        .enumerate()
        .map(|(i, v)| {
            let spread = 1.6 * (1.0 - i as f64 / 160.0).powi(2);
            let peak = if (120..122).contains(&i) { 4.0 } else { 1.0 };
            v * peak * (spread * noise(i) + 0.04 * noise(3 * i)).exp()
        })
        .collect();
    SpectrumPanel {
        axis: axis.to_owned(),
        unit: "°/s/√Hz".to_owned(),
        sides: "two-sided".to_owned(),
        marks: vec![SpectrumMark {
            frequency_hz: frequency_hz[120],
            text: "line at 2.0 Hz".to_owned(),
        }],
        frequency_hz,
        density,
        fit,
    }
}

fn series(axis: &str, middle: f64) -> SeriesPanel {
    let pieces = 720;
    let mean: Vec<f64> = (0..pieces).map(|i| middle + 0.05 * noise(i)).collect();
    SeriesPanel {
        axis: axis.to_owned(),
        unit: "°/s".to_owned(),
        note: "scatter 0.349 °/s".to_owned(),
        duration_s: 10_000.0,
        time_s: (0..pieces)
            .map(|i| (i as f64 + 0.5) * 10_000.0 / pieces as f64)
            .collect(),
        min: mean
            .iter()
            .enumerate()
            .map(|(i, m)| m - 1.2 + 0.3 * noise(7 * i))
            .collect(),
        max: mean
            .iter()
            .enumerate()
            .map(|(i, m)| m + 1.2 + 0.3 * noise(5 * i))
            .collect(),
        mean,
        findings_s: vec![(0.0, 70.0), (2020.0, 2020.0), (9600.0, 9640.0)],
    }
}

fn words(values: [(&str, &'static str, &str); 3]) -> [ParameterCell; 3] {
    values.map(|(word, class, note)| ParameterCell::Word {
        word: word.to_owned(),
        class,
        note: note.to_owned(),
    })
}

fn characterize() -> CharacterizePage {
    let pm = |v: f64, h: f64, unit: Unit| Estimate::plus_minus(v, h).scaled(1.0 / unit.per_si);
    let (n, b, k) = (
        Unit::DEG_PER_SQRT_H,
        Unit::DEG_PER_H,
        Unit::DEG_PER_H_PER_SQRT_H,
    );
    let step = ParameterCell::Number {
        value: 0.05 / Unit::DEG_PER_S.per_si,
        note: "0.14 of the scatter".to_owned(),
    };
    let mut parameters = vec![
        ParameterRow::estimates(
            Sensor::Gyro,
            "angle_random_walk",
            [
                pm(2.414, 0.021, n),
                pm(2.544, 0.022, n),
                pm(2.267, 0.019, n),
            ],
        ),
        ParameterRow::estimates(
            Sensor::Gyro,
            "bias_instability",
            [
                Estimate::detected(24.0, 12.0, 32.0).scaled(1.0 / b.per_si),
                pm(36.0, 8.0, b),
                Estimate::UpperLimit(11.0 / b.per_si),
            ],
        ),
        ParameterRow::estimates(
            Sensor::Gyro,
            "rate_random_walk",
            [pm(150.0, 130.0, k), Estimate::Absent, pm(150.0, 90.0, k)],
        ),
        ParameterRow::estimates(
            Sensor::Gyro,
            "mean",
            [
                pm(1360.0, 200.0, b),
                pm(-1570.0, 240.0, b),
                pm(-980.0, 210.0, b),
            ],
        ),
    ];
    parameters.push(ParameterRow {
        sensor: Sensor::Gyro,
        term: "lsb".to_owned(),
        name: "Rounding step seen in the data".to_owned(),
        unit: Some(Unit::DEG_PER_H),
        cells: [step.clone(), step.clone(), step],
    });
    parameters.push(ParameterRow {
        sensor: Sensor::Gyro,
        term: "fit".to_owned(),
        name: "Do the terms explain the curve?".to_owned(),
        unit: None,
        cells: words([
            ("barely", "warn", "p = 0.05"),
            ("yes", "good", "p = 0.86"),
            ("yes", "good", "p = 0.26"),
        ]),
    });
    let axes = ["gyro_x", "gyro_y", "gyro_z"];
    CharacterizePage {
        name: "example <b>.csv.gz".to_owned(),
        subtitle: "Example, at rest, 2 h 46 min 40 s at 100 Hz".to_owned(),
        verdict: Rich::marked("**The gyro is well determined.** White noise is known to 1 % on every axis, bias instability to 20–40 %."),
        facts: [("Samples", "1 000 000"), ("Rate", "100 Hz, as given"), ("Duration", "10 000 s"), ("Channels", "3 gyro"),
            ("Range used", "±2.4 °/s"), ("|f| at rest", "1.018 g"), ("Temperature", "not recorded"), ("Findings", "3 warnings, 3 notes")]
            .map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec(),
        logs: vec![LogReport {
            name: "example".to_owned(),
            parameters,
            timeline: issues(),
            allan: vec![gyro()],
            spectrum: vec![axes.iter().map(|a| spectrum(a)).collect()],
            series: vec![axes.iter().zip([0.38, -0.44, -0.27]).map(|(a, m)| series(a, m)).collect()],
            limits: vec![
                Rich::marked("**Temperature.** The log has no temperature channel, so a slow change of temperature would be counted as rate random walk or bias instability. Record one."),
                Rich::marked("**Run-to-run bias.** One run shows one bias. Record five or more switch-ons and add `--one-sensor`."),
            ],
            ..LogReport::default()
        }],
        method: "Overlapping Allan deviation; degrees of freedom per noise type and χ² limits at 95 %. The terms of an axis are estimated jointly from its spectrum.".into(),
        command: "sagnac characterize example.csv.gz --rate 100Hz --columns 'gyro=0,1,2:0.05 deg/s' --report report.html -o example.toml".to_owned(),
        version: "0.1.0".to_owned(),
        inputs: vec![Input { name: "example.csv.gz".to_owned(), sha256: "dc41e164af471012b40cde3dfae089e5e2f586aec8a51b0d203d0dbb6ed35144".to_owned() }],
        ..CharacterizePage::default()
    }
}

fn explain() -> Vec<ExplainPanel> {
    let terms = |list: &[(&str, f64)]| {
        list.iter()
            .map(|(n, v)| ((*n).to_owned(), *v))
            .collect::<Vec<_>>()
    };
    let panel = |axis: &str, note: &str, list: &[(&str, f64)]| ExplainPanel {
        axis: axis.to_owned(),
        note: note.to_owned(),
        unit: "°/h".to_owned(),
        terms: terms(list),
        sum: list.iter().map(|t| t.1).sum(),
    };
    vec![
        panel(
            "gyro_x",
            "input 10, output 10.01000 °/s",
            &[
                ("bias.fixed", 12.0),
                ("scale_factor.fixed", 10.8),
                ("bias.temperature", 6.0),
                ("scale_factor.temperature", 5.4),
                ("misalignment.fixed", 5.4),
                ("resolution", -4.62),
                ("g_sensitivity.matrix", 1.02),
            ],
        ),
        panel(
            "gyro_y",
            "input 0, output 0 °/s",
            &[
                ("misalignment.fixed", 5.4),
                ("bias.fixed", -5.0),
                ("bias.temperature", -3.0),
                ("resolution", 2.6),
            ],
        ),
        panel(
            "gyro_z",
            "input −5, output −5.01000 °/s",
            &[
                ("misalignment.fixed", -14.4),
                ("resolution", -11.97),
                ("g_sensitivity.matrix", -10.0),
                ("bias.fixed", 3.0),
                ("scale_factor.temperature", -2.7),
                ("bias.temperature", 1.5),
                ("scale_factor.fixed", -1.44),
            ],
        ),
    ]
}

fn others() -> Vec<Figure> {
    let mut out = Vec::new();
    out.extend(explain_panels(&explain()).into_iter().take(1));
    out.extend(response_figures());
    out.extend(drift_figures());
    out.extend(calibration_figures());
    out.push(area().figure(540.0));
    out.push(cost().figure(860.0));
    out
}

fn response() -> ResponsePlots {
    let steps: Vec<f64> = (-10..=10).map(|i| f64::from(i) * 10.0).collect();
    let up_mean: Vec<(f64, f64)> = steps
        .iter()
        .map(|x| {
            (
                *x,
                12.0 * (x / 28.0).sin() - 8.0 + 0.0003 * x * x * x / 10.0,
            )
        })
        .collect();
    let down_mean: Vec<(f64, f64)> = up_mean
        .iter()
        .map(|p| (p.0, p.1 + 23.0 * (1.0 - (p.0 / 100.0).powi(2))))
        .collect();
    let spread = |mean: &[(f64, f64)]| -> Vec<(f64, f64)> {
        mean.iter()
            .flat_map(|p| {
                (0..5).map(move |k| (p.0, p.1 + 14.0 * noise(k + (p.0 + 200.0) as usize)))
            })
            .collect()
    };
    ResponsePlots {
        reference_title: "reference rate, °/s".to_owned(),
        output_title: "output, °/s".to_owned(),
        residual_unit: "mdps".to_owned(),
        up: spread(&up_mean),
        down: spread(&down_mean),
        minimax: Some([
            [(-100.0, -22.0), (100.0, -11.0)],
            [(-100.0, 10.0), (100.0, 21.0)],
        ]),
        points: steps.iter().map(|x| (*x, 1.0007 * x)).collect(),
        line: Some([(-100.0, -100.07), (100.0, 100.07)]),
        line_label: "slope 1.00071".to_owned(),
        hysteresis: up_mean
            .iter()
            .zip(&down_mean)
            .map(|(u, d)| (u.0, d.1 - u.1))
            .collect(),
        hysteresis_label: "23.0 at 0 °/s".to_owned(),
        target: (0..30)
            .map(|k| (8.0 + 16.0 * noise(k), 32.0 + 18.0 * noise(k + 99)))
            .collect(),
        target_titles: ("error going up".to_owned(), "error going down".to_owned()),
        up_mean,
        down_mean,
        ..ResponsePlots::default()
    }
}

fn response_figures() -> Vec<Figure> {
    let r = response();
    vec![r.residuals(), r.target(), r.line(), r.hysteresis()]
}

fn drift() -> (DriftGrowth, DriftCloud, DriftShare) {
    let time_s: Vec<f64> = (1..=60).map(|i| f64::from(i) * 2.0).collect();
    let grow = |scale: f64| {
        time_s
            .iter()
            .map(|t| scale * (t / 120.0).powf(2.6))
            .collect::<Vec<f64>>()
    };
    let growth = DriftGrowth {
        unit: "m".to_owned(),
        cep: grow(373.0),
        cep_interval: (grow(349.0), grow(399.0)),
        r95: grow(764.0),
        r95_interval: (grow(721.0), grow(862.0)),
        covariance: (grow(369.0), grow(760.0)),
        time_s: time_s.clone(),
    };
    let angle = |i: usize| std::f64::consts::TAU * (noise(3 * i) + 0.5);
    let radius = |i: usize| 310.0 * (-2.0 * (noise(5 * i + 1) + 0.5).max(1e-3).ln()).sqrt();
    let cloud = DriftCloud {
        unit: "m".to_owned(),
        note: "after 2 min".to_owned(),
        east: (0..500).map(|i| radius(i) * angle(i).cos()).collect(),
        north: (0..500).map(|i| radius(i) * angle(i).sin()).collect(),
        cep: 373.0,
        r95: 764.0,
        labels: ("CEP 373 m".to_owned(), "R95 764 m".to_owned()),
    };
    let gyro: Vec<f64> = time_s
        .iter()
        .map(|t| 0.752 * (t / 120.0).powf(0.8))
        .collect();
    let accel: Vec<f64> = gyro.iter().map(|g| (1.0 - g) * 0.96).collect();
    let rest: Vec<f64> = gyro.iter().zip(&accel).map(|(g, a)| 1.0 - g - a).collect();
    let share = DriftShare {
        time_s,
        terms: vec![
            ("gyro bias, run to run".to_owned(), gyro),
            ("accel bias, run to run".to_owned(), accel),
            ("gyro bias instability".to_owned(), rest),
        ],
    };
    (growth, cloud, share)
}

fn drift_figures() -> Vec<Figure> {
    let (growth, cloud, share) = drift();
    vec![growth.figure(), cloud.figure(), share.figure()]
}

fn calibration_figures() -> Vec<Figure> {
    let residuals = StationResiduals {
        sensor: "accel".to_owned(),
        unit: "µg".to_owned(),
        word: "station".to_owned(),
        labels: (1..=24).map(|i| i.to_string()).collect(),
        axes: [0, 100, 200].map(|k| (0..24).map(|i| 110.0 * noise(i + k)).collect()),
        band: 66.0,
    };
    let histogram =
        |plot: &str, caption: &str, rest: &str, unit: &str, width: f64, color| Histogram {
            plot: plot.to_owned(),
            caption: caption.to_owned(),
            caption_rest: rest.to_owned(),
            x_title: format!("|f| − g, {unit}"),
            values: (0..24).map(|i| width * noise(i * 3)).collect(),
            color,
        };
    let names = [
        "bias.x",
        "bias.y",
        "bias.z",
        "scale_factor.x",
        "scale_factor.y",
        "scale_factor.z",
        "misalignment.xy",
        "misalignment.xz",
        "misalignment.yz",
    ];
    let poses: Vec<[f64; 3]> = (0..31)
        .map(|i| [noise(i), noise(i + 50), noise(i + 99)])
        .collect();
    vec![
        residuals.figure(),
        histogram(
            "calibration-before",
            "Before",
            ": |f| − g, 3.25 mg rms",
            "mg",
            13.0,
            Color::Fit,
        )
        .figure(),
        histogram(
            "calibration-after",
            "After",
            ": |f| − g, 23 µg rms",
            "µg",
            100.0,
            Color::Data,
        )
        .figure(),
        PoseSphere {
            poses,
            next: vec![
                ([-1.0, 0.0, 1.0], "−x+z up".to_owned()),
                ([-1.0, -1.0, 0.0], "−x−y up".to_owned()),
            ],
        }
        .figure(),
        CorrelationMap {
            names: names.iter().map(|&n| n.to_owned()).collect(),
            matrix: (0..9)
                .map(|i| {
                    (0..9)
                        .map(|j| if i == j { 1.0 } else { noise(i * j) * 1.4 })
                        .collect()
                })
                .collect(),
        }
        .figure(),
    ]
}

fn area() -> ScatterChart {
    let region = |name: &str, uses: &str, x, y| Region {
        name: name.to_owned(),
        uses: uses.to_owned(),
        x,
        y,
    };
    let point = |name: &str, x, y, color, marker| ScatterPoint {
        name: name.to_owned(),
        x,
        y,
        color,
        marker,
        x_range: None,
    };
    ScatterChart {
        plot: "application-area".to_owned(),
        axis: "gyro".to_owned(),
        caption: "Gyro".to_owned(),
        x_title: "scale-factor stability, ppm".to_owned(),
        y_title: "bias stability, °/h".to_owned(),
        regions: vec![
            region("Consumer", "phones, games, cars", (5e3, 4e4), (100.0, 3e4)),
            region("Industrial", "drones, robots", (1e3, 5e3), (10.0, 1e3)),
            region(
                "Tactical",
                "guided flight, mapping with GNSS, AHRS",
                (100.0, 1500.0),
                (0.1, 30.0),
            ),
            region(
                "Navigation",
                "aircraft, ships, mapping",
                (5.0, 40.0),
                (1e-3, 0.1),
            ),
            region(
                "Strategic, marine",
                "submarines, years of navigation",
                (0.5, 5.0),
                (1e-4, 1e-3),
            ),
        ],
        points: vec![
            point("ICM-42688-P", 5e3, 1800.0, Color::Z, Marker::Filled),
            point("IIM-42653", 5e3, 1800.0, Color::Z, Marker::Filled),
            point("LSM6DSO", 1e4, 3600.0, Color::Z, Marker::Filled),
            point("3DM-GX3-35", 500.0, 900.0, Color::Z, Marker::Filled),
            point("Pulse-40", 1500.0, 250.0, Color::Z, Marker::Filled),
            point("SiIMU02", 500.0, 100.0, Color::Z, Marker::Filled),
            point("OpenRTK330", 1000.0, 6.0, Color::Z, Marker::Open),
            point("ADIS16470", 2500.0, 8.0, Color::Z, Marker::Open),
            point("LN-200", 500.0, 3.0, Color::X, Marker::Filled),
            point("STIM300", 500.0, 4.0, Color::Z, Marker::Filled),
            point("HG1700-AG71", 150.0, 1.0, Color::Y, Marker::Filled),
            point("SCH16T-K01", 3000.0, 0.5, Color::Z, Marker::Open),
            point("STIM210", 500.0, 0.3, Color::Z, Marker::Open),
            point("STIM377H", 500.0, 0.3, Color::Z, Marker::Open),
            point("HG5700-AA", 40.0, 0.14, Color::Y, Marker::Filled),
            point("HG5700-BA01", 40.0, 0.07, Color::Y, Marker::Filled),
            point("HG5700-CA01", 40.0, 0.035, Color::Y, Marker::Filled),
            point("Primus 200", 10.0, 0.05, Color::Other, Marker::Filled),
            point("HG9900", 5.0, 0.0035, Color::Y, Marker::Filled),
            point("H-764G", 5.0, 0.0035, Color::Y, Marker::Filled),
            point("yours", 100.0, 20.0, Color::Ink, Marker::Diamond),
        ],
        ..ScatterChart::default()
    }
}

fn cost() -> ScatterChart {
    let point = |name: &str, x: f64, y, color, marker| ScatterPoint {
        name: name.to_owned(),
        x,
        y,
        color,
        marker,
        x_range: Some((x / 1.5, x * 1.5)),
    };
    let region = |name: &str, x, y| Region {
        name: name.to_owned(),
        uses: String::new(),
        x,
        y,
    };
    ScatterChart {
        plot: "cost-performance".to_owned(),
        caption: "Each point is a catalogue sensor with a published price".to_owned(),
        caption_rest: ", colored by gyro technology. The pale bar is the price class, a factor 1.5 either way.".to_owned(),
        x_title: "price of one, USD, order of magnitude".to_owned(),
        y_title: "gyro bias, °/h".to_owned(),
        plain_x: true,
        regions: vec![
            region("Commercial: about 10 USD a gyro, 0.1 °/s", (5.0, 20.0), (200.0, 650.0)),
            region("Tactical: 2000–50 000 USD, 1–10 °/h", (2000.0, 5e4), (1.0, 10.0)),
            region("Navigation: about 100 000 USD, < 0.01 °/h", (5e4, 2e5), (0.002, 0.01)),
            region("Strategic: about 1 million USD", (5e5, 2e6), (1e-4, 1e-3)),
        ],
        points: vec![
            point("LSM6DSO S·D", 10.0, 3600.0, Color::Z, Marker::Triangle),
            point("BMI088 S·S", 8.0, 3600.0, Color::Z, Marker::Triangle),
            point("ICM-42688-P S·D", 5.0, 1800.0, Color::Z, Marker::Triangle),
            point("VN-100 S·S", 500.0, 10.0, Color::Z, Marker::Filled),
            point("Xsens MTi-630 S·S", 1100.0, 8.0, Color::Z, Marker::Filled),
            point("LN-200S S·S", 25_000.0, 1.0, Color::X, Marker::Open),
            point("HG1700-AG58 S·S", 90_000.0, 1.0, Color::Y, Marker::Open),
            point("HG4930 S·S", 8000.0, 0.25, Color::Z, Marker::Filled),
            point("1750 IMU S·S", 15_000.0, 0.05, Color::X, Marker::Filled),
        ],
        ..ScatterChart::default()
    }
}

fn opening(name: &str, subtitle: &str, verdict: &str) -> Opening {
    Opening {
        name: name.to_owned(),
        subtitle: subtitle.to_owned(),
        verdict: Rich::marked(verdict),
        version: "0.1.0".to_owned(),
        command: "sagnac example".to_owned(),
        ..Opening::default()
    }
}

fn results() -> ResultTable {
    let row = |name: &str, unit: &str, cells| ResultRow {
        name: name.to_owned(),
        unit: unit.to_owned(),
        cells,
    };
    let pm = Estimate::plus_minus;
    ResultTable {
        heading: "Accelerometer".to_owned(),
        rows: vec![
            row(
                "Bias",
                "µg",
                [pm(2161.0, 21.0), pm(-1501.0, 21.0), pm(3917.0, 21.0)],
            ),
            row(
                "Scale factor error",
                "ppm",
                [pm(1281.0, 25.0), pm(-895.0, 25.0), pm(2106.0, 25.0)],
            ),
            row(
                "Misalignment to x",
                "µrad",
                [Estimate::Absent, pm(-166.0, 26.0), pm(561.0, 25.0)],
            ),
            row(
                "Misalignment to y",
                "µrad",
                [pm(423.0, 25.0), Estimate::Absent, pm(-293.0, 26.0)],
            ),
            row(
                "Misalignment to z",
                "µrad",
                [pm(-715.0, 26.0), pm(363.0, 25.0), Estimate::Absent],
            ),
            row(
                "Quadratic nonlinearity",
                "µg/g²",
                [pm(33.0, 42.0), pm(-13.0, 42.0), pm(67.0, 42.0)],
            ),
        ],
    }
}

fn residuals() -> StationResiduals {
    StationResiduals {
        sensor: "accel".to_owned(),
        unit: "µg".to_owned(),
        word: "station".to_owned(),
        labels: (1..=24).map(|i| i.to_string()).collect(),
        axes: [0, 100, 200].map(|k| (0..24).map(|i| 110.0 * noise(i + k)).collect()),
        band: 66.0,
    }
}

fn histograms() -> Vec<Histogram> {
    let histogram =
        |plot: &str, caption: &str, rest: &str, unit: &str, width: f64, color| Histogram {
            plot: plot.to_owned(),
            caption: caption.to_owned(),
            caption_rest: rest.to_owned(),
            x_title: format!("|f| − g, {unit}"),
            values: (0..24).map(|i| width * noise(i * 3)).collect(),
            color,
        };
    vec![
        histogram(
            "calibration-before",
            "Before",
            ": |f| − g, 3.25 mg rms",
            "mg",
            13.0,
            Color::Fit,
        ),
        histogram(
            "calibration-after",
            "After",
            ": |f| − g, 23 µg rms",
            "µg",
            100.0,
            Color::Data,
        ),
    ]
}

fn certificate() -> CertificatePage {
    CertificatePage {
        title: "Accelerometer triad".to_owned(),
        number: "2026-0117".to_owned(),
        issued: "2026-02-03".to_owned(),
        item: "Example MEMS IMU, serial 0042".to_owned(),
        temperature: "(25.0 ± 0.2) °C".to_owned(),
        calibrated: "2026-02-02".to_owned(),
        place: "46.52° N, 6.57° E, 405 m".to_owned(),
        gravity: "9.80632 m/s², from latitude and height".to_owned(),
        verdict: Rich::marked("**24 stations determine 15 parameters.** |f| − g falls from 3.25 mg to 23 µg rms; the residuals are as large as the noise says (p = 0.95)."),
        method: "24-station tumble test on a dividing head: each axis up and down, tilted 0°, 30°, 60° and 75°; dwell 60 s a station. Weighted least squares of all stations at once, 15 parameters, axis by axis. Terms and signs as in IEEE Std 1293 and 528.".into(),
        references: [("Direction of gravity", "dividing head, certificate 1234", "10 µrad", "10 µg"), ("Size of gravity", "latitude and height, normal gravity", "20 µg", "20 ppm of scale, common to all axes"),
            ("Sensor noise in a dwell", "scatter of the dwell", "33 µg", "33 µg")]
            .map(|(a, b, c, d)| Reference { quantity: a.to_owned(), standard: b.to_owned(), uncertainty: c.to_owned(), in_result: d.to_owned() }).to_vec(),
        results: vec![results()],
        result_note: "± is the expanded uncertainty, k = 2, for a coverage of about 95 %; it covers sensor noise and direction of gravity. The 20 ppm of gravity’s size add to every scale factor alike. Goodness of fit: χ² = 40.5 at 57 degrees of freedom, p = 0.95.".into(),
        residuals: vec![residuals()],
        before_after: histograms(),
        not_determined: "Axis offset (needs rotation: rate table). Temperature coefficients (needs a chamber). Cross-axis response cannot be told from misalignment; the numbers above are their sum.".into(),
        command: "calibrate stations tumble24.csv --latitude 46.52deg --height 405m -o imu-0042.toml --report certificate.html".to_owned(),
        version: "0.1.0".to_owned(),
        ..CertificatePage::default()
    }
}

fn pages() -> Vec<(&'static str, String)> {
    let mut out = vec![("certificate.html", certificate().html())];
    let explain_page = ExplainPage {
        opening: opening(
            "Example MEMS IMU",
            "f = (1, 0, −9.81) m/s², ω = (10, 0, −5) °/s, T = 40 °C",
            "**At this input misalignment is the largest gyro error: −14.4 °/h on z.** Together the terms add 36, 0 and −36 °/h to x, y and z.",
        ),
        gyro: explain(),
        random: [
            vec![RandomRow {
                term: "noise.rate_random_walk, after 1 h".to_owned(),
                sigma: ["1.5", "1.5", "−"].map(str::to_owned),
                unit: "°/h".to_owned(),
            }],
            Vec::new(),
        ],
        ..ExplainPage::default()
    };
    out.push(("explain.html", explain_page.html()));
    let rows = [
        (
            "Accuracy",
            "mean error; holds as far as the reference is true",
            "20.7",
            "mdps",
            "a single reading: −69 … 110 mdps; largest 118",
        ),
        (
            "Precision",
            "repeatability at equal input and direction, 1σ",
            "3.92",
            "mdps",
            "3.54 … 4.39",
        ),
        (
            "Sensitivity",
            "slope of the least-squares line",
            "1.000713",
            "(°/s)/(°/s)",
            "± 0.000030",
        ),
        (
            "Linearity",
            "largest departure of a point’s mean from the line",
            "0.0220",
            "% of full scale",
            "22.0 mdps; minimax 15.9 mdps",
        ),
    ];
    let response_page = ResponsePage {
        opening: opening(
            "Rate table, gyro z, −100 to 100 °/s",
            "210 readings in five cycles, up and down; full scale 100 °/s",
            "**More precise than accurate.** Readings repeat to 3.9 mdps, but are off by 21 mdps in the mean; that offset and the slope can be calibrated away. Hysteresis, 24 mdps, cannot.",
        ),
        rows: rows
            .iter()
            .map(|r| ResponseRow {
                term: r.0.to_owned(),
                what: r.1.to_owned(),
                value: r.2.to_owned(),
                unit: r.3.to_owned(),
                more: r.4.to_owned(),
            })
            .collect(),
        plots: response(),
    };
    out.push(("response.html", response_page.html()));
    let (growth, cloud, share) = drift();
    let budget = [
        ("Gyro bias, run to run", "20 °/h", 0.752, "320 m", "244 m"),
        ("Accel bias, run to run", "2 mg", 0.204, "167 m", "340 m"),
        ("Gyro bias instability", "8 °/h", 0.035, "69 m", "364 m"),
        ("Angle random walk", "0.3 °/√h", 0.009, "35 m", "368 m"),
        (
            "Velocity random walk",
            "0.06 m/s/√h",
            0.0001,
            "0.9 m",
            "369 m",
        ),
    ];
    let drift_page = DriftPage {
        opening: opening(
            "Example MEMS IMU: drift",
            "Drive of 2 min at 20 m/s without GNSS, two right turns; perfect alignment; 500 Monte-Carlo runs and covariance",
            "**After two minutes half of all runs are off by more than 373 m** (349 … 399), one in twenty by more than 764 m (721 … 862). Gyro bias, run to run makes 75 % of it: half of it would bring the CEP to 244 m.",
        ),
        growth,
        cloud: Some(cloud),
        share,
        budget_heading: "Budget after 2 min".to_owned(),
        budget: budget
            .iter()
            .map(|b| BudgetRow {
                term: b.0.to_owned(),
                in_model: b.1.to_owned(),
                share: b.2,
                share_text: sagnac_report::text::percent(b.2),
                alone: b.3.to_owned(),
                halved: b.4.to_owned(),
            })
            .collect(),
        ..DriftPage::default()
    };
    out.push(("drift.html", drift_page.html()));
    let mut accel = area();
    "accel".clone_into(&mut accel.axis);
    "Accelerometer".clone_into(&mut accel.caption);
    "bias stability, µg".clone_into(&mut accel.y_title);
    let grade = ChartPage {
        opening: opening(
            "Where does this sensor belong?",
            "Bias stability against scale-factor stability; 20 gyros and 16 accelerometers of the catalogue that publish both",
            "**On this chart yours is tactical, by gyro and by accelerometer.** The gyro’s run-to-run bias holds it back: 20 °/h, where navigation begins at 0.1 °/h, 200 times less.",
        ),
        task: "grade".to_owned(),
        charts: vec![area(), accel],
        key: ChartPage::area_key(
            "bias from Groves (2013) and El-Sheimy and Youssef (2020), scale factor from what calibrated products of each class leave behind; the strategic column has no published scale factor and is drawn by judgement.",
        ),
        tables: Vec::new(),
    };
    out.push(("grade.html", grade.html()));
    let catalog = ChartPage {
        opening: opening("What does performance cost?", "9 sensors with a published price and bias figure",
            "**Price rises about as fast as bias falls:** from 10 USD at 360 °/h to 100 000 USD at 0.01 °/h, four decades of price for four and a half of bias."),
        task: "catalog".to_owned(),
        charts: vec![cost()],
        key: ChartPage::technologies(Rich::new()).plain(". Letters: evidence for price · bias; D data sheet, S second hand, M measured by somebody."),
        tables: Vec::new(),
    };
    out.push(("catalog.html", catalog.html()));
    let mut allan = gyro();
    for panel in &mut allan {
        panel.terms.clear();
        "the sheet".clone_into(&mut panel.fit_name);
    }
    let compare = ComparePage {
        opening: opening(
            "static.csv with ADIS16470",
            "one unit, 2 h at 100 Hz",
            "**The unit is as its sheet says** but for the accelerometer’s white noise.",
        ),
        rows: vec![CompareRow {
            term: "Gyro x, angle random walk".to_owned(),
            measured: ("0.352".to_owned(), "± 0.004".to_owned()),
            sheet: "0.34".to_owned(),
            unit: "°/√h".to_owned(),
            ratio: ("1.035".to_owned(), "± 0.012".to_owned()),
            verdict: "within".to_owned(),
            text: String::new(),
        }],
        allan: vec![allan],
    };
    out.push(("compare.html", compare.html()));
    let names = [
        "bias.x",
        "bias.y",
        "bias.z",
        "scale_factor.x",
        "scale_factor.y",
        "scale_factor.z",
        "misalignment.xy",
        "misalignment.xz",
        "misalignment.yz",
    ];
    let calibration = CalibrationPage {
        name: "turned.csv".to_owned(),
        subtitle: "31 still poses in 18 min".to_owned(),
        verdict: Rich::marked(
            "**31 still poses determine the accelerometer.** |f| − g falls from 27.4 mg to 0.61 mg rms.",
        ),
        results: vec![results()],
        residuals: vec![residuals()],
        before_after: histograms(),
        poses: Some(PoseSphere {
            poses: (0..31)
                .map(|i| [noise(i), noise(i + 50), noise(i + 99)])
                .collect(),
            next: vec![([-1.0, 0.0, 1.0], "−x+z up".to_owned())],
        }),
        correlation: Some(CorrelationMap {
            names: names.iter().map(|&n| n.to_owned()).collect(),
            matrix: (0..9)
                .map(|i| {
                    (0..9)
                        .map(|j| if i == j { 1.0 } else { noise(i * j + 7) * 1.4 })
                        .collect()
                })
                .collect(),
        }),
        limits: vec![Rich::marked(
            "**g-sensitivity.** Its 95 % limit is 0.04 °/s/g.",
        )],
        command: "sagnac calibrate multi-position turned.csv -o imu.toml --report report.html"
            .to_owned(),
        version: "0.1.0".to_owned(),
        ..CalibrationPage::default()
    };
    out.push(("calibration.html", calibration.html()));
    out
}
