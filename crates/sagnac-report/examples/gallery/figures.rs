//! The plots of the other pages.

use crate::characterize::noise;
use sagnac_report::plots::{
    Color, CorrelationMap, DriftCloud, DriftGrowth, DriftShare, ExplainPanel, Figure, Histogram,
    Marker, PoseSphere, Region, ResponsePlots, ScatterChart, ScatterPoint, StationResiduals,
    explain_panels,
};

pub(crate) fn explain() -> Vec<ExplainPanel> {
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

pub(crate) fn others() -> Vec<Figure> {
    let mut out = Vec::new();
    out.extend(explain_panels(&explain()).into_iter().take(1));
    out.extend(response_figures());
    out.extend(drift_figures());
    out.extend(calibration_figures());
    out.push(area().figure(540.0));
    out.push(cost().figure(860.0));
    out
}

pub(crate) fn response() -> ResponsePlots {
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

pub(crate) fn response_figures() -> Vec<Figure> {
    let r = response();
    vec![r.residuals(), r.target(), r.line(), r.hysteresis()]
}

pub(crate) fn drift() -> (DriftGrowth, DriftCloud, DriftShare) {
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

pub(crate) fn drift_figures() -> Vec<Figure> {
    let (growth, cloud, share) = drift();
    vec![growth.figure(), cloud.figure(), share.figure()]
}

pub(crate) fn calibration_figures() -> Vec<Figure> {
    let residuals = StationResiduals {
        sensor: "accel".to_owned(),
        unit: "µg".to_owned(),
        word: "station".to_owned(),
        labels: (1..=24).map(|i| i.to_string()).collect(),
        axes: [0, 100, 200].map(|k| (0..24).map(|i| 110.0 * noise(i + k)).collect()),
        band: 66.0,
        ..StationResiduals::default()
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
            names: crate::pages::CORRELATED
                .iter()
                .map(|&n| n.to_owned())
                .collect(),
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

pub(crate) fn area() -> ScatterChart {
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
        ..ScatterPoint::default()
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

pub(crate) fn cost() -> ScatterChart {
    let point = |name: &str, x: f64, y, color, marker| ScatterPoint {
        name: name.to_owned(),
        x,
        y,
        color,
        marker,
        x_range: Some((x / 1.5, x * 1.5)),
        ..ScatterPoint::default()
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
