//! Grades, their page and charts, the catalogue's lists and provenance, to the built program.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{flat, refused, sagnac, said};
use sagnac::grade::{area_charts, cost_chart};
use sagnac::model::Catalogue;
use sagnac::report::plots::{Color, Marker, ScatterChart, ScatterPoint};
use std::fs;
use std::path::Path;

fn write(folder: &Path, name: &str, gyro: &str, accel: &str) {
    let text = format!(
        "name = \"{name}\"\n[gyro.bias]\nstability = \"{gyro}\"\n[accel.bias]\nstability = \"{accel}\"\n"
    );
    fs::write(folder.join(format!("{name}.toml")), text).unwrap();
}

fn stdout(folder: &Path, args: &[&str]) -> String {
    let output = sagnac(folder, args);
    assert!(output.status.success(), "{args:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn point<'a>(chart: &'a ScatterChart, name: &str) -> &'a ScatterPoint {
    let found = chart.points.iter().find(|p| p.name == name);
    found.unwrap_or_else(|| panic!("{name} is not drawn"))
}

#[test]
fn the_verdict_names_what_holds_the_sensor_back() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "mems", "8 deg/h", "1 mg");
    let text = said(folder.path(), &["grade", "mems.toml"]);
    // Both are missed; the gyro by 8.0 holds it back, the position by 6.9.
    assert!(
        text.contains("needs an 8.0 times smaller gyro bias.")
            && text.contains("held back by the gyro bias"),
        "{text}"
    );
    write(folder.path(), "limit", "0.01 deg/h", "50 ug");
    let text = said(
        folder.path(),
        &["grade", "limit.toml", "--table", "el-sheimy"],
    );
    assert!(
        text.contains("needs a gyro bias below 0.01 deg/h."),
        "{text}"
    );
    assert!(text.contains("< 0.01 deg/h a little less"), "{text}");
}

#[test]
fn the_page_holds_the_grade_of_every_sensor_and_every_point() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "bare", "8 deg/h", "1 mg");
    said(
        folder.path(),
        &[
            "grade",
            "bare.toml",
            "catalog:HG9900",
            "--report",
            "page.html",
        ],
    );
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    for part in [
        "data-table=\"grade-bare\"",
        "data-table=\"needed-bare\"",
        "data-table=\"grade-hg9900\"",
        "bare AHRS, HG9900 navigation",
        "held back by",
        // 20 and 16, without HG9900, which is the user's own here.
        "19 gyros and 15 accelerometers",
        "Not every sensor is on the chart",
        "data-table=\"gyro-areas\"",
        "data-table=\"accel-areas\"",
    ] {
        assert!(page.contains(part), "the page lacks {part}");
    }
    let table = page.split("data-table=\"gyro-areas\"").nth(1).unwrap();
    for name in ["ADIS16470", "SCH16T-K01", "ICM-42688-P", "LSM6DSO"] {
        assert!(table.contains(name), "the table of gyros lacks {name}");
    }
}

#[test]
fn a_sensor_with_a_scale_factor_has_its_diamond() {
    let catalogue = Catalogue::embedded();
    let own = [catalogue.find("ADIS16470").unwrap()];
    for chart in area_charts(&catalogue, &own, None).unwrap() {
        let diamonds = chart.points.iter().filter(|p| p.marker == Marker::Diamond);
        assert_eq!(diamonds.count(), 1, "{}", chart.caption);
    }
}

#[test]
fn an_accelerometer_has_a_technology_of_its_own() {
    let [gyro, accel] = area_charts(&Catalogue::embedded(), &[], None).unwrap();
    assert_eq!(point(&gyro, "H-764G").color, Color::Y);
    assert_eq!(point(&accel, "H-764G").color, Color::Other);
    assert_eq!(point(&accel, "Primus 200").color, Color::Other);
    assert_eq!(point(&accel, "LN-200").color, Color::Z, "MEMS beside a FOG");
}

#[test]
fn a_published_price_stands_at_that_price() {
    let chart = cost_chart(&Catalogue::embedded(), None).unwrap();
    let close = |name: &str, usd: f64| {
        let p = point(&chart, name);
        assert!((p.x / usd - 1.0).abs() < 1e-9, "{name} at {}", p.x);
        assert_eq!(p.mark, "S·S", "{name}");
    };
    close("HG4930", 8000.0);
    close("LN-200S", (20_000f64 * 30_000.0).sqrt());
    // A file of the user's own that states a class alone says so.
    let mut catalogue = Catalogue::embedded();
    let text = b"name = \"mine\"\n[gyro.bias]\nstability = \"1 deg/h\"\n[catalog]\nprice_class = \"100-1000\"\n";
    catalogue.add(text, "mine.toml").unwrap();
    let chart = cost_chart(&catalogue, None).unwrap();
    assert!(point(&chart, "mine").mark.starts_with("(class)"));
    assert!(chart.caption_rest.contains("(class)"));
}

#[test]
fn the_cost_page_names_prices() {
    let folder = tempfile::tempdir().unwrap();
    said(folder.path(), &["catalog", "list", "--report", "page.html"]);
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    let verdict = page.split("class=\"verdict\"").nth(1).unwrap();
    let verdict = &verdict[..verdict.find("</").unwrap() + 400];
    assert!(
        verdict.contains("5 USD at 1800 °/h (ICM-42688-P)"),
        "{verdict}"
    );
    assert!(verdict.contains("(HG1700-AG58)"), "{verdict}");
    assert!(page.contains("<td class=\"whole\" data-label=\"Evidence\">"));
}

#[test]
fn coefficient_and_floor_are_one_number() {
    let folder = tempfile::tempdir().unwrap();
    let names = |condition: &str| {
        let args = ["catalog", "list", "--where", condition, "--format", "json"];
        let found: serde_json::Value = serde_json::from_str(&stdout(folder.path(), &args)).unwrap();
        let all = found["sensors"].as_array().unwrap();
        all.iter()
            .map(|s| s["name"].to_string())
            .collect::<Vec<_>>()
    };
    let by_b = names("gyro.bias.instability.coefficient < 0.55 deg/h");
    // 0.55 times 0.66428.
    assert_eq!(
        by_b,
        names("gyro.bias.instability.allan_minimum < 0.365354 deg/h")
    );
    assert_eq!(by_b, names("gyro.bias.instability < 0.365354 deg/h"));
    assert!(by_b.len() > 5, "{by_b:?}");
}

#[test]
fn the_whole_list_is_one_table_with_whole_names() {
    let folder = tempfile::tempdir().unwrap();
    let text = stdout(folder.path(), &["catalog", "list"]);
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    assert_eq!(text.matches("run-to-run").count(), 1, "{text}");
    for name in Catalogue::embedded().names() {
        assert!(text.contains(&name), "{name} is cut");
    }
}

#[test]
fn show_tells_whole_sources_and_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let text = stdout(folder.path(), &["catalog", "show", "ADIS16470"]);
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    let text = flat(&text);
    for part in [
        "ADIS16470 data sheet rev C front page, pdf.datasheet.directory/8bba3343/analog.com/ADIS16470AMLZ.html",
        "printed 8 deg/h; in-run, 1 sigma",
        "D [1]",
    ] {
        assert!(text.contains(part), "lacks {part}: {text}");
    }
}

#[test]
fn names_that_stand_twice_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    for file in ["a.toml", "b.toml"] {
        fs::write(own.join(file), "name = \"twin\"\n").unwrap();
    }
    fs::write(own.join("c.toml"), "name = \"STIM300\"\n").unwrap();
    let text = said(folder.path(), &["catalog", "list", "--catalog", "own"]);
    assert!(
        text.contains("own/a.toml and own/b.toml are both called `twin`"),
        "{text}"
    );
    assert!(
        text.contains("own/c.toml takes the place of STIM300 of the catalogue"),
        "{text}"
    );
}

#[test]
fn errors_of_the_run_name_the_option_and_what_to_write() {
    let folder = tempfile::tempdir().unwrap();
    let drift = |option: &[&str]| {
        refused(
            folder.path(),
            &[&["drift", "catalog:HG9900"], option].concat(),
            2,
        )
    };
    for (option, where_, advice) in [
        (
            ["--latitude", "91deg"],
            "--latitude",
            "write for instance --latitude 45deg",
        ),
        (
            ["--height", "-1000m"],
            "--height",
            "write for instance --height 500m",
        ),
        (
            ["--duration", "0s"],
            "--duration",
            "write for instance --duration 1h",
        ),
        (
            ["--duration", "1e9h"],
            "--duration",
            "write for instance --duration 1h",
        ),
        (
            ["--duration", "0.1ms"],
            "--duration",
            "lengthen --duration, or raise --rate",
        ),
    ] {
        let text = drift(&option);
        assert!(
            text.contains(where_) && text.contains(advice),
            "{option:?}: {text}"
        );
        assert!(!text.contains("--trajectory rest"), "{option:?}: {text}");
    }
    let text = said(
        folder.path(),
        &["budget", "--cep", "1 mm", "--after", "10min"],
    );
    assert!(text.contains("a CEP of 1 mm"), "{text}");
    let text = said(
        folder.path(),
        &["drift", "catalog:HG9900", "--rate", "1e-3Hz"],
    );
    assert!(text.contains("After 1 h 6 min 40 s"), "{text}");
}
