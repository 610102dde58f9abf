//! Writes every plot and page, with made-up numbers, into a folder: `cargo run --example gallery -- DIR`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::path::Path;

use sagnac_report::plots::{
    AllanPanel, AllanTerm, ChartCurve, Color, CurveChart, IssueBar, IssueTimeline, allan_panels,
};
use sagnac_report::svg::Svg;

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
