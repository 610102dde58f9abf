//! Application areas (bias against scale-factor stability) and cost against performance.
//!
//! The regions are our own: bias from the tables of Groves and of El-Sheimy and Youssef, scale factor from what
//! calibrated products of each class leave behind ([GROVES13], [ELSHEIMY20]).

use sagnac_core::Sensor;
use sagnac_model::catalogue::{price_class, technology};
use sagnac_model::{Catalogue, Model};
use sagnac_report::html::{ChartPage, HtmlCell, HtmlTable, Opening, Rich};
use sagnac_report::plots::{Color, Marker, Region, ScatterChart, ScatterPoint};
use sagnac_report::text::Unit;

use super::{Bias, GradeOutcome, bias_of, chosen};
use crate::Error;

type Area = (&'static str, &'static str, (f64, f64), (f64, f64));

/// (name, uses, scale factor ppm, gyro bias °/h).
const GYRO: [Area; 5] = [
    (
        "Strategic, marine",
        "submarines, years of navigation",
        (0.5, 5.0),
        (1e-4, 1e-3),
    ),
    (
        "Navigation",
        "aircraft, ships, mapping",
        (5.0, 40.0),
        (1e-3, 0.1),
    ),
    (
        "Tactical",
        "guided flight, mapping with GNSS, AHRS",
        (100.0, 1500.0),
        (0.1, 30.0),
    ),
    (
        "Industrial",
        "drones, robots",
        (1000.0, 5000.0),
        (10.0, 1000.0),
    ),
    (
        "Consumer",
        "phones, games, cars",
        (5000.0, 40_000.0),
        (100.0, 30_000.0),
    ),
];

/// (name, uses, scale factor ppm, accelerometer bias µg).
const ACCEL: [Area; 4] = [
    (
        "Strategic, marine",
        "submarines, gravimetry",
        (0.5, 5.0),
        (0.1, 10.0),
    ),
    (
        "Navigation",
        "aircraft, ships, mapping",
        (5.0, 120.0),
        (10.0, 100.0),
    ),
    (
        "Tactical",
        "guided flight, AHRS",
        (200.0, 5000.0),
        (300.0, 5000.0),
    ),
    (
        "Consumer",
        "phones, airbags, steps",
        (5000.0, 40_000.0),
        (3000.0, 100_000.0),
    ),
];

/// Where the regions come from, for the caption.
const REGION_SOURCES: &str = "bias from Groves (2013) and El-Sheimy and Youssef (2020), scale factor from what calibrated products of each class leave behind; the strategic column has no published scale factor and is drawn by judgement.";

/// The color of a sensor's technology; of `FOG + MEMS accel` the first part is the gyro's, the second the accelerometer's.
fn color(model: &Model, sensor: Sensor) -> Color {
    let name = model
        .technology(sensor)
        .or_else(|| technology(model))
        .unwrap_or_default()
        .to_ascii_uppercase();
    let part = match (name.split_once('+'), sensor) {
        (Some((gyro, _)), Sensor::Gyro) => gyro,
        (Some((_, accel)), Sensor::Accel) => accel,
        (None, _) => &name,
    };
    if part.contains("MEMS") {
        Color::Z
    } else if part.contains("FOG") {
        Color::X
    } else if part.contains("RLG") {
        Color::Y
    } else {
        Color::Other
    }
}

/// Scale-factor figure of a model, the largest of stability, tolerance and what it has otherwise.
fn scale_factor(model: &Model, sensor: Sensor) -> Option<f64> {
    let over = |key: &str, sigma: bool| {
        (0..3)
            .filter_map(|a| model.under(sensor, key, a))
            .filter_map(|e| if sigma { e.sigma } else { e.value })
            .map(f64::abs)
            .filter(|v| *v > 0.0)
            .max_by(f64::total_cmp)
    };
    over("scale_factor.stability", false).or_else(|| over("scale_factor", true))
}

fn point(model: &Model, sensor: Sensor, mine: bool, bias: Option<Bias>) -> Option<ScatterPoint> {
    let (kind, value) = if mine {
        chosen(model, bias)[sensor.index()]?
    } else {
        // Filled: run-to-run; open: only an in-run figure is published.
        bias_of(model, sensor, Bias::RunToRun)
            .map(|v| (Bias::RunToRun, v))
            .or_else(|| bias_of(model, sensor, Bias::InRun).map(|v| (Bias::InRun, v)))?
    };
    let unit = if sensor == Sensor::Gyro {
        Unit::DEG_PER_H
    } else {
        Unit::MICRO_G
    };
    Some(ScatterPoint {
        name: if mine {
            "yours".to_owned()
        } else {
            model.name().to_owned()
        },
        x: scale_factor(model, sensor)? * 1e6,
        y: unit.from_si(value),
        color: if mine {
            Color::Ink
        } else {
            color(model, sensor)
        },
        marker: match (mine, kind) {
            (true, _) => Marker::Diamond,
            (false, Bias::RunToRun) => Marker::Filled,
            (false, Bias::InRun) => Marker::Open,
        },
        x_range: None,
    })
}

/// The charts of gyro and accelerometer: our regions, the catalogue, the user's own sensors.
///
/// # Errors
/// A model of the catalogue that cannot be read.
pub fn area_charts(
    catalogue: &Catalogue,
    mine: &[Model],
    bias: Option<Bias>,
) -> Result<[ScatterChart; 2], Error> {
    let models = catalogue.models()?;
    Ok(Sensor::ALL.map(|sensor| {
        let areas: &[Area] = if sensor == Sensor::Gyro {
            &GYRO
        } else {
            &ACCEL
        };
        let mut points: Vec<ScatterPoint> = models
            .iter()
            .filter(|m| !mine.iter().any(|own| own.name() == m.name()))
            .filter_map(|m| point(m, sensor, false, None))
            .collect();
        for own in mine {
            if let Some(mut p) = point(own, sensor, true, bias) {
                if mine.len() > 1 {
                    own.name().clone_into(&mut p.name);
                }
                points.push(p);
            }
        }
        ScatterChart {
            plot: "application-area".to_owned(),
            axis: sensor.key().to_owned(),
            caption: if sensor == Sensor::Gyro {
                "Gyro"
            } else {
                "Accelerometer"
            }
            .to_owned(),
            caption_rest: String::new(),
            x_title: "scale-factor stability, ppm".to_owned(),
            y_title: if sensor == Sensor::Gyro {
                "bias stability, °/h"
            } else {
                "bias stability, µg"
            }
            .to_owned(),
            plain_x: false,
            points,
            regions: areas
                .iter()
                .map(|(name, uses, x, y)| Region {
                    name: (*name).to_owned(),
                    uses: (*uses).to_owned(),
                    x: *x,
                    y: *y,
                })
                .collect(),
        }
    }))
}

/// Price class against gyro bias by technology; only printed prices.
///
/// `among` names the sensors that are drawn; all where it is `None`.
///
/// # Errors
/// A model of the catalogue that cannot be read.
pub fn cost_chart(catalogue: &Catalogue, among: Option<&[String]>) -> Result<ScatterChart, Error> {
    let mut points = Vec::new();
    for model in catalogue.models()? {
        if among.is_some_and(|names| !names.iter().any(|n| n == model.name())) {
            continue;
        }
        let Some(price) = price_class(&model).filter(|p| p.evidence != ESTIMATED) else {
            continue;
        };
        let (low, high) = class_range(price.class);
        let in_run = bias_of(&model, Sensor::Gyro, Bias::InRun).map(|v| (v, Marker::Filled));
        let run = bias_of(&model, Sensor::Gyro, Bias::RunToRun).map(|v| (v, Marker::Open));
        let tolerance = || {
            (0..3)
                .filter_map(|a| model.under(Sensor::Gyro, "bias", a)?.sigma)
                .max_by(f64::total_cmp)
                .map(|v| (v, Marker::Triangle))
        };
        let Some((bias, marker)) = in_run.or(run).or_else(tolerance) else {
            continue;
        };
        points.push(ScatterPoint {
            name: format!(
                "{} {}",
                model.name(),
                sagnac_model::catalogue::quality(&model).unwrap_or_default()
            ),
            x: (low * high).sqrt(),
            y: Unit::DEG_PER_H.from_si(bias),
            color: color(&model, Sensor::Gyro),
            marker,
            x_range: Some((low, high)),
        });
    }
    let region = |name: &str, x, y| Region {
        name: name.to_owned(),
        uses: String::new(),
        x,
        y,
    };
    Ok(ScatterChart {
        plot: "cost-performance".to_owned(),
        axis: String::new(),
        caption: "Each point is a catalogue sensor with a published price".to_owned(),
        caption_rest: "colored by gyro technology. The pale bar is the price class. Filled: in-run. Open: run-to-run. Triangle: only the tolerance when new is published.".to_owned(),
        x_title: "price of one, USD, order of magnitude".to_owned(),
        y_title: "gyro bias, °/h".to_owned(),
        plain_x: true,
        points,
        regions: vec![
            region("Commercial: about 10 USD a gyro, 0.1 °/s", (5.0, 20.0), (200.0, 650.0)),
            region("Tactical: 2000–50 000 USD, 1–10 °/h", (2000.0, 50_000.0), (1.0, 10.0)),
            region("Navigation: about 100 000 USD, < 0.01 °/h", (50_000.0, 200_000.0), (2e-3, 1e-2)),
            region("Strategic: about 1 million USD", (5e5, 2e6), (1e-4, 1e-3)),
        ],
    })
}

/// The page of cost against performance: the chart, and a table of every sensor with a price class and its evidence.
///
/// # Errors
/// A model of the catalogue that cannot be read.
pub fn cost_page(
    catalogue: &Catalogue,
    among: Option<&[String]>,
    command: &str,
    version: &str,
) -> Result<ChartPage, Error> {
    let chart = cost_chart(catalogue, among)?;
    let mut rows = Vec::new();
    for model in catalogue.models()? {
        if among.is_some_and(|names| !names.iter().any(|n| n == model.name())) {
            continue;
        }
        let Some(price) = price_class(&model) else {
            continue;
        };
        let bias = [Bias::InRun, Bias::RunToRun].map(|kind| {
            bias_of(&model, Sensor::Gyro, kind).map_or("-".to_owned(), |v| {
                sagnac_report::text::general(Unit::DEG_PER_H.from_si(v), 3)
            })
        });
        let [in_run, run_to_run] = bias;
        rows.push((
            price.rank(),
            [
                model.name().to_owned(),
                model.technology(Sensor::Gyro).unwrap_or("-").to_owned(),
                in_run,
                run_to_run,
                price.class.to_owned(),
                price.evidence.clone(),
            ],
        ));
    }
    rows.sort_by(|a, b| (a.0, &a.1[0]).cmp(&(b.0, &b.1[0])));
    let printed = rows.iter().filter(|(_, r)| r[5] != ESTIMATED).count();
    let mut table = HtmlTable::new(
        "prices",
        &[
            "Sensor",
            "Gyro",
            "In-run, °/h",
            "Run-to-run, °/h",
            "Price class, USD",
            "Evidence",
        ],
        &[2, 3, 4],
    );
    let total = rows.len();
    for (_, row) in rows {
        table.row(
            row.into_iter()
                .enumerate()
                .map(|(i, text)| match i {
                    2..=4 => HtmlCell::number(text),
                    _ => HtmlCell::from(text),
                })
                .collect(),
        );
    }
    let verdict = match (
        chart.points.iter().min_by(|a, b| a.x.total_cmp(&b.x)),
        chart.points.iter().max_by(|a, b| a.x.total_cmp(&b.x)),
    ) {
        (Some(cheap), Some(dear)) if dear.x > cheap.x => Rich::new()
            .bold("Price rises about as fast as bias falls: ")
            .plain(format!(
                "from {} at {} °/h to {} at {} °/h.",
                cheap.name,
                sagnac_report::text::general(cheap.y, 2),
                dear.name,
                sagnac_report::text::general(dear.y, 2)
            )),
        _ => Rich::new().bold(format!(
            "{} sensors here have a published price and a gyro bias.",
            chart.points.len()
        )),
    };
    Ok(ChartPage {
        opening: Opening {
            name: "What does performance cost?".to_owned(),
            subtitle: format!(
                "{} sensors with a published price and bias figure; {total} with a price class, {printed} of them printed",
                chart.points.len()
            ),
            verdict,
            version: version.to_owned(),
            command: command.to_owned(),
            ..Opening::default()
        },
        task: "catalog".to_owned(),
        charts: vec![chart],
        key: ChartPage::technologies(Rich::new())
            .plain(". Letter: evidence of the worst number used; ")
            .bold("D").plain(" data sheet, ").bold("S").plain(" second hand, ").bold("M")
            .plain(" measured by somebody. Prices are project notes, none from a vendor: read them to a factor of three. Euro at 1.1 USD. Regions are ")
            .bold("ours")
            .plain(", from the class figures of grades.md §1.2 (El-Sheimy and Youssef 2020, table 1)."),
        tables: vec![("Price class and its evidence".to_owned(), table)],
    })
}

/// Evidence of a price class that nobody printed.
const ESTIMATED: &str = "estimated from gyro bias";

fn class_range(class: &str) -> (f64, f64) {
    match class {
        "<10" => (1.0, 10.0),
        "10-100" => (10.0, 100.0),
        "100-1000" => (100.0, 1000.0),
        "1000-10000" => (1e3, 1e4),
        "10000-100000" => (1e4, 1e5),
        _ => (1e5, 1e6),
    }
}

/// The page of `grade`.
pub fn grade_page(
    outcomes: &[GradeOutcome],
    charts: [ScatterChart; 2],
    command: &str,
    version: &str,
) -> ChartPage {
    let verdict = outcomes
        .first()
        .map_or_else(Rich::new, |o| Rich::new().bold(o.verdict()));
    let name = match outcomes {
        [one] => format!("{}: where does it belong?", one.sensor),
        _ => "Where do these sensors belong?".to_owned(),
    };
    let counts: Vec<usize> = charts.iter().map(|c| c.points.len()).collect();
    let absent = charts.iter().filter_map(|chart| {
        let drawn = |p: &&ScatterPoint| p.marker == Marker::Diamond;
        (chart.points.iter().filter(drawn).count() < outcomes.len()).then(|| {
            let who = match outcomes {
                [one] => format!("{} is not", one.sensor),
                _ => "not every sensor is".to_owned(),
            };
            Rich::new().plain(format!(
                "{who} on the chart \"{}\": a place there needs a bias and a scale_factor.stability",
                chart.caption
            ))
        })
    });
    ChartPage {
        opening: Opening {
            name,
            subtitle: format!(
                "Bias stability against scale-factor stability; {} gyros and {} accelerometers that publish both",
                counts[0], counts[1]
            ),
            verdict,
            version: version.to_owned(),
            command: command.to_owned(),
            limits: outcomes
                .iter()
                .flat_map(|o| o.reasons.iter())
                .map(|r| Rich::new().plain(r.clone()))
                .chain(absent)
                .collect(),
            ..Opening::default()
        },
        task: "grade".to_owned(),
        charts: charts.into_iter().collect(),
        key: ChartPage::area_key(REGION_SOURCES),
        tables: Vec::new(),
    }
}
