//! Made-up axes: their curves, findings, spectra and the page of them.

use sagnac_report::html::{CharacterizePage, Input, LogReport, ParameterCell, ParameterRow, Rich};
use sagnac_report::plots::{
    AllanPanel, AllanTerm, ChartCurve, Color, CurveChart, IssueBar, IssueTimeline, SeriesPanel,
    SpectrumMark, SpectrumPanel,
};
use sagnac_report::svg::Svg;
use sagnac_report::text::{Estimate, Sensor, Unit};

pub(crate) fn tau() -> Vec<f64> {
    (0..60)
        .map(|i| 0.01 * 10f64.powf(f64::from(i) * 5.06 / 59.0))
        .collect()
}

pub(crate) fn sum(n: f64, b: f64, k: f64) -> Vec<f64> {
    tau()
        .iter()
        .map(|t| (n * n / t + (0.664 * b).powi(2) + k * k * t / 3.0).sqrt())
        .collect()
}

pub(crate) fn gyro() -> Vec<AllanPanel> {
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

pub(crate) fn chart(sensor: &str) -> Svg {
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

pub(crate) fn issues() -> IssueTimeline {
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
pub(crate) fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545;
    x - x.floor() - 0.5
}

pub(crate) fn spectrum(axis: &str) -> SpectrumPanel {
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

pub(crate) fn series(axis: &str, middle: f64) -> SeriesPanel {
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

pub(crate) fn words(values: [(&str, &'static str, &str); 3]) -> [ParameterCell; 3] {
    values.map(|(word, class, note)| ParameterCell::Word {
        word: word.to_owned(),
        class,
        note: note.to_owned(),
    })
}

pub(crate) fn characterize() -> CharacterizePage {
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
        per: "",
        cells: [step.clone(), step.clone(), step],
    });
    parameters.push(ParameterRow {
        sensor: Sensor::Gyro,
        term: "fit".to_owned(),
        name: "Do the terms explain the curve?".to_owned(),
        unit: None,
        per: "",
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
