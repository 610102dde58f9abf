//! Every number of the catalogue is a printed figure of a row of the table of data sheets: the same sensor, source and
//! quantity, and the value that the printed text gives by the rules of the catalogue.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use std::collections::HashMap;
use std::f64::consts::PI;

use sagnac_model::Catalogue;

/// One row: quantity, printed value, unit, condition, source.
type Row = [String; 5];

/// Rows by sensor, or `None` with a message where the table is not there.
fn table() -> Option<HashMap<String, Vec<Row>>> {
    let data = std::env::var_os("SAGNAC_DATA").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        Into::into,
    );
    let path = data.join("../reference/catalogue.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there (set SAGNAC_DATA)", path.display());
        return None;
    };
    let mut rows: HashMap<String, Vec<Row>> = HashMap::new();
    for record in csv::Reader::from_reader(text.as_bytes()).records() {
        let record = record.unwrap();
        let row = [3, 5, 6, 7, 8].map(|column| record[column].to_owned());
        rows.entry(record[0].to_owned()).or_default().push(row);
    }
    Some(rows)
}

/// The quantities that may stand behind a parameter path.
fn quantities(path: &str) -> &'static [&'static str] {
    let has = |word: &str| path.contains(word);
    if has("sample_rate") {
        &["output_rate_max"]
    } else if has("random_walk") && !has("acceleration_random_walk") && !has("rate_random_walk") {
        &["arw", "vrw", "noise_density"]
    } else if has("noise_density") {
        &["noise_density"]
    } else if has("acceleration_random_walk") || has("rate_random_walk") {
        &["bias_random_walk"]
    } else if has("bias.instability") {
        &["bias_instability"]
    } else if has("bias.stability") {
        &["bias_repeatability"]
    } else if has("bias.temperature") {
        &["bias_tempco"]
    } else if has("scale_factor.stability") {
        &["scale_factor_error"]
    } else if has("scale_factor.temperature") {
        &["scale_factor_tempco"]
    } else if has("scale_factor") {
        &["scale_factor_tolerance"]
    } else if has("misalignment") {
        &["misalignment"]
    } else if has("cross_axis") {
        &["cross_axis"]
    } else if has("g_sensitivity") {
        &["g_sensitivity"]
    } else if has("range") {
        &["range"]
    } else if has("bandwidth") {
        &["bandwidth"]
    } else if has("resolution") {
        &["resolution", "sensitivity"]
    } else if has("bias") {
        &["bias_initial_tolerance"]
    } else {
        &[]
    }
}

/// A printed unit in SI, worked out here word by word: `deg/h/sqrt(Hz)`, `mg`, `(deg/s)/(m/s^2)`, `LSB/g` …
fn in_si(unit: &str) -> Option<f64> {
    let degree = PI / 180.0;
    let g = 9.80665;
    let unit = unit.trim_end_matches(" rms");
    Some(match unit {
        "" | "Hz" | "rad/s" | "m/s^2" | "rad/s/sqrt(Hz)" | "m/s^2/sqrt(Hz)" | "m/s^3/sqrt(Hz)"
        | "LSB/(m/s^2)" => 1.0,
        "deg" | "deg/s" | "dps" | "deg/s/sqrt(Hz)" | "deg/s/C" | "deg/s/K" | "dps/C"
        | "(deg/s)/(m/s^2)" | "deg/s/LSB" => degree,
        "LSB/(deg/s)" => 1.0 / degree,
        "mdps/sqrt(Hz)" | "mdps/LSB" | "mdeg/s/C" | "mdeg/s/K" | "mdps" => degree / 1e3,
        "deg/h" | "deg/h/sqrt(Hz)" | "arcsec/pulse" => degree / 3600.0,
        "deg/sqrt(h)" => degree / 60.0,
        "deg/h/g" => degree / 3600.0 / g,
        "deg/s/g" => degree / g,
        "g" => g,
        "LSB/g" => 1.0 / g,
        "mg" | "mg/sqrt(Hz)" | "mg/C" | "mg/K" | "mg/LSB" => g / 1e3,
        "ug" | "ug/sqrt(Hz)" | "ug/C" | "ug/K" => g / 1e6,
        "m/s/sqrt(h)" => 1.0 / 60.0,
        "ft/s/sqrt(h)" => 0.3048 / 60.0,
        "ft/s per count" => 0.3048,
        "ppm" | "urad" | "um/s^2" | "ppm/C" | "ppm/K" => 1e-6,
        "mrad" => 1e-3,
        "%" | "%/C" | "%/K" => 1e-2,
        "mGal" => 1e-5,
        _ => return None,
    })
}

/// The larger end of `1-3`, `1500/1250`, `10..20`; one number is itself, `6.1e-5` too.
fn larger(printed: &str) -> Option<f64> {
    if let Ok(one) = printed.trim().parse() {
        return Some(one);
    }
    printed
        .replace("..", "/")
        .split(['/', '-'])
        .filter_map(|part| part.trim().parse().ok())
        .reduce(f64::max)
}

/// Whether a row gives this number by the rules: as printed, a third of "3 sigma", 1/√2 of a one-sided density, the inverse
/// of a sensitivity.
fn gives(row: &Row, number: f64) -> bool {
    let [quantity, printed, unit, condition, _] = row;
    let (Some(value), Some(factor)) = (larger(printed), in_si(unit)) else {
        return false;
    };
    let mut want = value * factor;
    if unit.starts_with("LSB") {
        want = 1.0 / want;
    }
    if condition.contains("3 sigma") {
        want /= 3.0;
    }
    let halved = quantity.ends_with("noise_density") && condition.contains("one-sided");
    // A derived number is written with twelve digits.
    [want, if halved { want / 2.0_f64.sqrt() } else { want }]
        .iter()
        .any(|want| (number / want - 1.0).abs() < 1e-10)
}

#[test]
fn every_number_is_a_row_of_the_table() {
    let Some(table) = table() else {
        return;
    };
    let (mut traced, mut lost) = (0, Vec::new());
    for model in Catalogue::embedded().models().unwrap() {
        let rows = &table[model.name()];
        for (path, entry) in model.parameters() {
            let path = path.to_string();
            let number = entry.sigma.or(entry.value).filter(|number| *number != 0.0);
            let (Some(number), source) = (number, entry.source.as_deref()) else {
                // The zeros beside the diagonal of a g-sensitivity.
                assert!(path.contains("g_sensitivity"), "{} {path}", model.name());
                continue;
            };
            let found = rows.iter().any(|row| {
                let (sensor, name) = row[0].split_once('_').unwrap_or(("", &row[0]));
                let of_sensor = row[0] == "output_rate_max" || path.starts_with(sensor);
                Some(row[4].as_str()) == source
                    && of_sensor
                    && quantities(&path).iter().any(|q| row[0] == *q || name == *q)
                    && gives(row, number.abs())
            });
            let usable = source.is_some_and(|source| {
                ["D: ", "M: ", "S: "]
                    .iter()
                    .any(|mark| source.starts_with(mark))
            });
            if found && usable {
                traced += 1;
            } else {
                lost.push(format!(
                    "{} {path} = {number} from {source:?}",
                    model.name()
                ));
            }
        }
        if let Some(evidence) = model.catalog().and_then(|c| c.price_evidence.as_ref()) {
            assert!(
                rows.iter().any(|row| row[0] == "price"
                    && evidence.starts_with(&row[1])
                    && evidence.ends_with(&row[4])),
                "{} {evidence}",
                model.name()
            );
        }
    }
    assert!(
        lost.is_empty(),
        "{} numbers without a row:\n{}",
        lost.len(),
        lost.join("\n")
    );
    // 73 sensors with two numbers at least; the figure of today is above a thousand, an axis at a time.
    assert!(traced > 500, "{traced}");
}

#[test]
fn a_wrong_number_is_not_traced() {
    let row = |quantity: &str, value: &str, unit: &str, condition: &str| {
        [quantity, value, unit, condition, "D: sheet"].map(str::to_owned)
    };
    let degree = PI / 180.0;
    assert!(gives(
        &row("gyro_range", "1500/1250", "deg/s", ""),
        1500.0 * degree
    ));
    assert!(!gives(
        &row("gyro_range", "1500/1250", "deg/s", ""),
        1250.0 * degree
    ));
    assert!(gives(
        &row("gyro_misalignment", "0.3", "deg", "3 sigma"),
        0.1 * degree
    ));
    assert!(!gives(
        &row("gyro_arw", "0.3", "deg/sqrt(h)", ""),
        0.3 * degree
    ));
    assert!(gives(
        &row("gyro_sensitivity", "16.4", "LSB/(deg/s)", ""),
        degree / 16.4
    ));
    assert!(!gives(&row("gyro_range", "0.3", "furlong", ""), 0.3));
}
