//! The other pages.

use crate::characterize::{gyro, noise};
use crate::figures::{area, cost, drift, explain, response};
use sagnac_report::html::{
    BudgetRow, CertificatePage, ChartPage, ComparePage, CompareRow, DriftPage, ExplainPage,
    Opening, RandomRow, Reference, ResponsePage, ResponseRow, ResultRow, ResultTable, Rich,
};
use sagnac_report::plots::{Color, CorrelationMap, Histogram, PoseSphere, StationResiduals};
use sagnac_report::text::Estimate;

pub(crate) fn opening(name: &str, subtitle: &str, verdict: &str) -> Opening {
    Opening {
        name: name.to_owned(),
        subtitle: subtitle.to_owned(),
        verdict: Rich::marked(verdict),
        version: "0.1.0".to_owned(),
        command: "sagnac example".to_owned(),
        ..Opening::default()
    }
}

pub(crate) fn results() -> ResultTable {
    let row = |name: &str, unit: &str, cells| ResultRow {
        name: name.to_owned(),
        unit: unit.to_owned(),
        cells,
        ..ResultRow::default()
    };
    let pm = Estimate::plus_minus;
    ResultTable {
        heading: "Accelerometer".to_owned(),
        sensor: "accel".to_owned(),
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

pub(crate) fn residuals() -> StationResiduals {
    StationResiduals {
        sensor: "accel".to_owned(),
        unit: "µg".to_owned(),
        word: "station".to_owned(),
        labels: (1..=24).map(|i| i.to_string()).collect(),
        axes: [0, 100, 200].map(|k| (0..24).map(|i| 110.0 * noise(i + k)).collect()),
        band: 66.0,
        ..StationResiduals::default()
    }
}

pub(crate) fn histograms() -> Vec<Histogram> {
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

/// Parameters of the map of correlations.
pub(crate) const CORRELATED: [&str; 9] = [
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

pub(crate) fn certificate() -> CertificatePage {
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

pub(crate) fn pages() -> Vec<(&'static str, String)> {
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
    let turned = CertificatePage {
        command: "sagnac calibrate multi-position turned.csv -o imu.toml --report report.html"
            .to_owned(),
        poses: Some(PoseSphere {
            poses: (0..31)
                .map(|i| [noise(i), noise(i + 50), noise(i + 99)])
                .collect(),
            next: vec![([-1.0, 0.0, 1.0], "−x+z up".to_owned())],
        }),
        correlation: Some(CorrelationMap {
            names: CORRELATED.iter().map(|&n| n.to_owned()).collect(),
            matrix: (0..9)
                .map(|i| {
                    (0..9)
                        .map(|j| if i == j { 1.0 } else { noise(i * j + 7) * 1.4 })
                        .collect()
                })
                .collect(),
        }),
        ..certificate()
    };
    out.push(("calibration.html", turned.html()));
    out
}
