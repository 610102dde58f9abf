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

/// The technology of gyro or accelerometer, as the chart colors it. Of `FOG + MEMS accel` the first part is the gyro's,
/// the second the accelerometer's; of what is said of the whole unit, an accelerometer takes MEMS alone: it is no gyro.
fn technology_of(model: &Model, sensor: Sensor) -> (&'static str, Color) {
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
    let has = |word: &str| part.contains(word);
    if has("MEMS") {
        ("MEMS", Color::Z)
    } else if sensor == Sensor::Accel || (has("FOG") && has("HRG")) {
        ("other", Color::Other)
    } else if has("FOG") {
        ("FOG", Color::X)
    } else if has("RLG") {
        ("RLG", Color::Y)
    } else {
        ("other", Color::Other)
    }
}

fn color(model: &Model, sensor: Sensor) -> Color {
    technology_of(model, sensor).1
}

fn largest_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    values
        .map(f64::abs)
        .filter(|v| *v > 0.0)
        .max_by(f64::total_cmp)
}

/// Scale-factor figure of a model and what it is: the stability, else the tolerance, else what a note of the catalogue
/// says of it over temperature.
fn scale_factor(model: &Model, sensor: Sensor) -> Option<(f64, &'static str)> {
    let entries = |key: &'static str| (0..3).filter_map(move |a| model.under(sensor, key, a));
    largest_of(entries("scale_factor.stability").filter_map(|e| e.value))
        .map(|v| (v, "stability"))
        .or_else(|| {
            largest_of(entries("scale_factor").filter_map(|e| e.sigma)).map(|v| (v, "tolerance"))
        })
        .or_else(|| over_temperature(model, sensor).map(|v| (v, "over temperature")))
}

/// `gyro scale factor over temperature 0.25 % (…)` among the notes.
fn over_temperature(model: &Model, sensor: Sensor) -> Option<f64> {
    let begin = format!("{} scale factor over temperature ", sensor.name());
    largest_of(
        model
            .catalog()?
            .notes
            .iter()
            .filter_map(|note| note.strip_prefix(&begin))
            .filter_map(|rest| {
                let mut words = rest.split_whitespace();
                let value: f64 = words.next()?.parse().ok()?;
                match words.next()? {
                    "%" => Some(value * 1e-2),
                    "ppm" => Some(value * 1e-6),
                    _ => None,
                }
            }),
    )
}

/// A bias in °/h or µg.
fn in_field_unit(sensor: Sensor, value: f64) -> f64 {
    let unit = if sensor == Sensor::Gyro {
        Unit::DEG_PER_H
    } else {
        Unit::MICRO_G
    };
    unit.from_si(value)
}

/// The bias of a catalogue sensor on the chart, and what it is: run to run, else in run, else the tolerance when new.
fn published_bias(model: &Model, sensor: Sensor) -> Option<(f64, &'static str, Marker)> {
    let run = || bias_of(model, sensor, Bias::RunToRun).map(|v| (v, "run to run", Marker::Filled));
    let in_run = || bias_of(model, sensor, Bias::InRun).map(|v| (v, "in run", Marker::Open));
    let new = || {
        largest_of((0..3).filter_map(|a| model.under(sensor, "bias", a)?.sigma))
            .map(|v| (v, "when new", Marker::Triangle))
    };
    run().or_else(in_run).or_else(new)
}

fn point(model: &Model, sensor: Sensor) -> Option<ScatterPoint> {
    let (value, _, marker) = published_bias(model, sensor)?;
    Some(ScatterPoint {
        name: model.name().to_owned(),
        x: scale_factor(model, sensor)?.0 * 1e6,
        y: in_field_unit(sensor, value),
        color: color(model, sensor),
        marker,
        ..ScatterPoint::default()
    })
}

/// The place of a sensor of the user's own.
fn own_point(model: &Model, sensor: Sensor, bias: Option<Bias>) -> Option<ScatterPoint> {
    let (_, value) = chosen(model, bias)[sensor.index()]?;
    Some(ScatterPoint {
        name: "yours".to_owned(),
        x: scale_factor(model, sensor)?.0 * 1e6,
        y: in_field_unit(sensor, value),
        color: Color::Ink,
        marker: Marker::Diamond,
        ..ScatterPoint::default()
    })
}

/// Every sensor of a chart with its numbers: what finds no room for a label stands here.
fn area_table(catalogue: &Catalogue, sensor: Sensor) -> Result<HtmlTable, Error> {
    let unit = if sensor == Sensor::Gyro {
        "Bias, °/h"
    } else {
        "Bias, µg"
    };
    let name = format!("{}-areas", sensor.key());
    let heading = ["Sensor", "Technology", unit, "Scale factor, ppm"];
    let mut table = HtmlTable::new(&name, &heading, &[2, 3]);
    let mut rows = Vec::new();
    for model in catalogue.models()? {
        let bias = published_bias(&model, sensor);
        if let (Some((value, which, _)), Some((scale, kind))) = (bias, scale_factor(&model, sensor))
        {
            rows.push((value, which, scale, kind, model));
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let number = |v: f64| HtmlCell::number(sagnac_report::text::general(v, 3));
    for (value, which, scale, kind, model) in rows {
        table.row(vec![
            model.name().into(),
            technology_of(&model, sensor).0.into(),
            number(in_field_unit(sensor, value)).with_note(which),
            number(scale * 1e6).with_note(kind),
        ]);
    }
    Ok(table)
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
            .filter_map(|m| point(m, sensor))
            .collect();
        for own in mine {
            if let Some(mut p) = own_point(own, sensor, bias) {
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
        let (class_low, class_high) = class_range(price.class);
        let printed = price.printed_usd();
        // A price is good to a factor of about 1.5 either way; a class is as wide as it is.
        let (low, high) = printed.map_or((class_low, class_high), |(low, high)| {
            let middle = (low * high).sqrt();
            (low.min(middle / 1.5), high.max(middle * 1.5))
        });
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
            name: model.name().to_owned(),
            mark: match printed {
                Some(_) => format!("{}·{}", price.letter().unwrap_or("–"), bias_letter(&model)),
                None => format!("(class) {}", bias_letter(&model)),
            },
            x: (low * high).sqrt(),
            y: Unit::DEG_PER_H.from_si(bias),
            color: color(&model, Sensor::Gyro),
            marker,
            x_range: Some((low, high)),
        });
    }
    let caption_rest = if points.iter().any(|p| p.mark.starts_with("(class)")) {
        ", colored by gyro technology. The pale bar is a factor of 1.5 either way, or the class where only a class is stated: (class). Filled: in-run. Open: run-to-run. Triangle: only the tolerance when new is published."
    } else {
        ", colored by gyro technology. The pale bar is a factor of 1.5 either way. Filled: in-run. Open: run-to-run. Triangle: only the tolerance when new is published."
    };
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
        caption_rest: caption_rest.to_owned(),
        x_title: "price of one, USD, order of magnitude".to_owned(),
        y_title: "gyro bias, °/h".to_owned(),
        plain_x: true,
        points,
        regions: vec![
            region(
                "Commercial: about 10 USD a gyro, 0.1 °/s",
                (5.0, 20.0),
                (200.0, 650.0),
            ),
            region(
                "Tactical: 2000–50 000 USD, 1–10 °/h",
                (2000.0, 50_000.0),
                (1.0, 10.0),
            ),
            region(
                "Navigation: about 100 000 USD, < 0.01 °/h",
                (50_000.0, 200_000.0),
                (2e-3, 1e-2),
            ),
            region("Strategic: about 1 million USD", (5e5, 2e6), (1e-4, 1e-3)),
        ],
    })
}

/// The letter of the gyro bias that the chart shows: `D`, `M`, `S`.
fn bias_letter(model: &Model) -> &'static str {
    let keys = [
        "bias.instability.allan_minimum",
        "bias.instability.coefficient",
        "bias.stability",
        "bias",
    ];
    let source = keys
        .into_iter()
        .find_map(|key| (0..3).find_map(|a| model.under(Sensor::Gyro, key, a)?.source.clone()))
        .unwrap_or_default();
    ["D", "M", "S"]
        .into_iter()
        .find(|letter| source.starts_with(&format!("{letter}:")))
        .unwrap_or("–")
}

/// `about 8000 USD` in a sentence, two digits.
fn about_usd(price: f64) -> String {
    let text = sagnac_report::text::group_thousands(&sagnac_report::text::general(price, 2));
    format!("{text} USD")
}

/// From the cheapest to the dearest sensor of the chart, in decades of price and of bias.
fn cost_verdict(points: &[ScatterPoint]) -> Rich {
    let by_price = |a: &&ScatterPoint, b: &&ScatterPoint| a.x.total_cmp(&b.x);
    let bias = |p: &ScatterPoint| format!("{} °/h", sagnac_report::text::general(p.y, 2));
    let (cheap, dear) = match (
        points.iter().min_by(by_price),
        points.iter().max_by(by_price),
    ) {
        (Some(cheap), Some(dear)) if dear.x > cheap.x => (cheap, dear),
        _ => {
            return Rich::new().bold(match points.len() {
                1 => "One sensor here has a published price and a gyro bias.".to_owned(),
                n => format!("{n} sensors here have a published price and a gyro bias."),
            });
        }
    };
    let decades = |ratio: f64| sagnac_report::text::significant(ratio.log10(), 2);
    let says = match cheap.y / dear.y {
        ratio if ratio > 1.0 => "Price rises as bias falls: ",
        _ => "A higher price buys no smaller bias here: ",
    };
    let mut out = Rich::new().bold(says).plain(format!(
        "from {} at {} ({}) to {} at {} ({})",
        about_usd(cheap.x),
        bias(cheap),
        cheap.name,
        about_usd(dear.x),
        bias(dear),
        dear.name
    ));
    if cheap.y > dear.y {
        out = out.plain(format!(
            ", {} decades of price for {} of bias",
            decades(dear.x / cheap.x),
            decades(cheap.y / dear.y)
        ));
    }
    out = out.plain(".");
    match points.iter().min_by(|a, b| a.y.total_cmp(&b.y)) {
        Some(best) if best.name != dear.name => out.plain(format!(
            " The smallest bias is that of {}: {} at {}.",
            best.name,
            bias(best),
            about_usd(best.x)
        )),
        _ => out,
    }
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
        let new = largest_of((0..3).filter_map(|a| model.under(Sensor::Gyro, "bias", a)?.sigma))
            .map_or("-".to_owned(), |v| {
                sagnac_report::text::general(Unit::DEG_PER_H.from_si(v), 3)
            });
        rows.push((
            price.rank(),
            [
                model.name().to_owned(),
                model.technology(Sensor::Gyro).unwrap_or("-").to_owned(),
                in_run,
                run_to_run,
                new,
                price.class.to_owned(),
                price.evidence.clone(),
            ],
        ));
    }
    rows.sort_by(|a, b| (a.0, &a.1[0]).cmp(&(b.0, &b.1[0])));
    let printed = rows.iter().filter(|(_, r)| r[6] != ESTIMATED).count();
    let mut table = HtmlTable::new(
        "prices",
        &[
            "Sensor",
            "Gyro",
            "In-run, °/h",
            "Run-to-run, °/h",
            "When new, °/h",
            "Price class, USD",
            "Evidence",
        ],
        &[2, 3, 4, 5],
    );
    let total = rows.len();
    for (_, row) in rows {
        table.row(
            row.into_iter()
                .enumerate()
                .map(|(i, text)| match i {
                    2..=5 => HtmlCell::number(text),
                    6 => HtmlCell::from(text).whole_row(),
                    _ => HtmlCell::from(text),
                })
                .collect(),
        );
    }
    let verdict = cost_verdict(&chart.points);
    let regions: Vec<String> = chart.regions.iter().map(|r| r.name.clone()).collect();
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
            .plain(". Letters: evidence of price · of bias; ")
            .bold("D").plain(" data sheet, ").bold("S").plain(" second hand, ").bold("M")
            .plain(" measured by somebody. Prices are project notes, none from a vendor: read them to a factor of three. Euro at 1.1 USD. Regions are ")
            .bold("ours")
            .plain(format!(", from the class figures of El-Sheimy and Youssef (2020), table 1: {}.", regions.join("; "))),
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
///
/// # Errors
/// A model of the catalogue that cannot be read.
pub fn grade_page(
    catalogue: &Catalogue,
    outcomes: &[GradeOutcome],
    charts: [ScatterChart; 2],
    command: &str,
    version: &str,
) -> Result<ChartPage, Error> {
    let verdict = match outcomes {
        [one] => Rich::new()
            .bold(format!("{}: ", one.sensor))
            .plain(one.verdict()),
        all => {
            let grades: Vec<String> = all
                .iter()
                .map(|o| format!("{} {}", o.sensor, o.overall_words()))
                .collect();
            let table = all.first().map_or("the table", |o| o.table.words());
            Rich::new()
                .bold(format!("By {table}: "))
                .plain(format!("{}.", grades.join(", ")))
        }
    };
    let name = match outcomes {
        [one] => format!("{}: where does it belong?", one.sensor),
        _ => "Where do these sensors belong?".to_owned(),
    };
    let is_own = |p: &&ScatterPoint| p.marker == Marker::Diamond;
    let counts = charts
        .each_ref()
        .map(|c| c.points.iter().filter(|p| !is_own(p)).count());
    let without: Vec<String> = charts
        .iter()
        .filter(|chart| chart.points.iter().filter(is_own).count() < outcomes.len())
        .map(|chart| format!("“{}”", chart.caption))
        .collect();
    let absent = (!without.is_empty()).then(|| {
        let who = match outcomes {
            [one] => format!("{} is not", one.sensor),
            _ => "Not every sensor is".to_owned(),
        };
        format!(
            "{who} on the chart {}: a place there needs a bias and a scale_factor.stability.",
            without.join(", ")
        )
    });
    let mut key = ChartPage::area_key(REGION_SOURCES);
    if let Some(sentence) = &absent {
        key = key.plain(" ").bold(sentence.clone());
    }
    let mut tables = Vec::new();
    for outcome in outcomes {
        tables.extend(outcome.tables());
    }
    for (sensor, heading) in Sensor::ALL
        .into_iter()
        .zip(["Gyros on the chart", "Accelerometers on the chart"])
    {
        tables.push((heading.to_owned(), area_table(catalogue, sensor)?));
    }
    Ok(ChartPage {
        opening: Opening {
            name,
            subtitle: format!(
                "Bias stability against scale-factor stability; {} gyros and {} accelerometers of the catalogue that publish both",
                counts[0], counts[1]
            ),
            verdict,
            version: version.to_owned(),
            command: command.to_owned(),
            limits: outcomes
                .iter()
                .flat_map(|o| o.reasons.iter().map(move |r| format!("{}: {r}.", o.sensor)))
                .chain(absent)
                .map(|sentence| Rich::new().plain(sentence))
                .collect(),
            ..Opening::default()
        },
        task: "grade".to_owned(),
        charts: charts.into_iter().collect(),
        key,
        tables,
    })
}
