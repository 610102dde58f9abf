//! A unit against its sheet: every random term of the sheet has its rows, what is unclear is counted, findings are told.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;

use sagnac::characterize::{NamedLog, Outcome, Request, characterize};
use sagnac::compare::{ComparedTerm, ComparisonOutcome, compare_logs, compare_model};
use sagnac::log::{ReadOptions, Source, read};
use sagnac::model::Model;
use sagnac::report::text::Style;

const DEG: f64 = std::f64::consts::PI / 180.0;
/// 0.3 deg/√h in rad/√s.
const N: f64 = 0.3 * DEG / 60.0;

fn model(body: &str) -> Model {
    Model::parse(
        &format!("schema = 1\nname = \"the sheet\"\n{body}"),
        "sheet.toml",
    )
    .unwrap()
}

/// Three gyro axes of white noise at 50 Hz, rounded to a step where one is given.
fn white(count: usize, density: f64, step: Option<f64>) -> Outcome {
    let mut text = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n".to_owned();
    let mut state = 7_u64;
    let mut noise = || {
        let sum: f64 = (0..12)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum();
        let value = (sum - 6.0) * density / 0.02_f64.sqrt();
        step.map_or(value, |step| (value / step).round() * step)
    };
    for k in 1..=count {
        let _ = writeln!(
            text,
            "{},{},{},{}",
            k as f64 * 0.02,
            noise(),
            noise(),
            noise()
        );
    }
    let log = read(
        Source::memory("log.csv", text.into_bytes()),
        &ReadOptions::default(),
    )
    .unwrap();
    let named = NamedLog {
        name: "log.csv".to_owned(),
        log,
    };
    characterize(&[named], &Request::default()).unwrap()
}

fn term<'a>(outcome: &'a ComparisonOutcome, axis: usize, name: &str) -> &'a ComparedTerm {
    let mut terms = outcome.logs[0].axes[axis].terms.iter();
    terms.find(|t| t.name == name).unwrap()
}

fn text(outcome: &ComparisonOutcome) -> String {
    let text = outcome.document().render(Style::PLAIN);
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_process_of_the_sheet_has_its_rows() {
    let sheet = model(
        "[gyro.noise]\ngauss_markov = [{ sigma = \"3 deg/h\", correlation_time = \"500 s\" }]\n\
         rate_random_walk = \"30 deg/h/sqrt(h)\"\n\
         [gyro.bias.instability]\nprocess = \"gauss_markov\"\nsigma = \"20 deg/h\"\ncorrelation_time = \"50 s\"\n",
    );
    // In another order: the times say which is which.
    let measured = model(
        "[gyro.noise]\nrate_random_walk = { value = \"30 deg/h/sqrt(h)\", sigma = \"1 deg/h/sqrt(h)\" }\n\
         gauss_markov = [\
         { sigma = { value = \"30 deg/h\", sigma = \"1 deg/h\" }, correlation_time = { value = \"45 s\", sigma = \"4 s\" } },\
         { sigma = { value = \"3 deg/h\", sigma = \"0.2 deg/h\" }, correlation_time = { value = \"450 s\", sigma = \"60 s\" } }]\n",
    );
    let outcome = compare_model(&measured, &sheet).unwrap();
    assert_eq!(outcome.logs[0].axes.len(), 3);
    for (name, ratio, verdict) in [
        ("rate_random_walk", 1.0, "within"),
        ("gauss_markov.1.sigma", 1.0, "within"),
        ("gauss_markov.1.correlation_time", 0.9, "within"),
        ("gauss_markov.2.sigma", 1.5, "worse"),
        ("gauss_markov.2.correlation_time", 0.9, "within"),
    ] {
        let row = term(&outcome, 1, name);
        let found = row.result.unwrap();
        assert!(
            (found.ratio.value.unwrap() / ratio - 1.0).abs() < 1e-9,
            "{row:?}"
        );
        assert_eq!(found.verdict.name(), verdict, "{row:?}");
    }
    assert_eq!(
        term(&outcome, 0, "gauss_markov.1.correlation_time").unit,
        "s"
    );
    let said = text(&outcome);
    assert!(said.contains("but for gyro x, y, z GM sigma."), "{said}");
    assert!(said.contains("GM time 45"), "{said}");
}

#[test]
fn a_walk_of_the_bias_instability_is_a_walk() {
    let sheet = model(
        "[gyro.noise]\nrate_random_walk = \"30 deg/h/sqrt(h)\"\n\
         [gyro.bias.instability]\nprocess = \"random_walk\"\nrate_random_walk = \"40 deg/h/sqrt(h)\"\n",
    );
    let measured = model(
        "[gyro.noise]\nrate_random_walk = { value = \"50 deg/h/sqrt(h)\", sigma = \"1 deg/h/sqrt(h)\" }\n",
    );
    let outcome = compare_model(&measured, &sheet).unwrap();
    let ratio = term(&outcome, 0, "rate_random_walk").result.unwrap().ratio;
    assert!((ratio.value.unwrap() - 1.0).abs() < 1e-9, "{ratio:?}");
}

#[test]
fn a_process_that_was_not_seen_is_bounded() {
    let outcome = white(30_000, N, None);
    let sheet = |sigma: &str| {
        model(&format!(
            "[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\n\
             gauss_markov = [{{ sigma = \"{sigma}\", correlation_time = \"50 s\" }}]\n"
        ))
    };
    let far = compare_logs(&outcome, &sheet("2000 deg/h")).unwrap();
    let row = term(&far, 0, "gauss_markov.1.sigma");
    assert!(
        row.measured.upper.is_some() && row.measured.value.is_none(),
        "{row:?}"
    );
    assert_eq!(row.verdict().name(), "better", "{row:?}");
    // Its time cannot be known, and that is no verdict in its favor.
    let time = term(&far, 0, "gauss_markov.1.correlation_time");
    assert_eq!((time.verdict().name(), time.result), ("unclear", None));
    let near = compare_logs(&outcome, &sheet("0.01 deg/h")).unwrap();
    assert_eq!(
        term(&near, 0, "gauss_markov.1.sigma").verdict().name(),
        "unclear"
    );
    assert!(
        text(&near).starts_with("As far as it is told"),
        "{}",
        text(&near)
    );
}

#[test]
fn the_headline_counts_what_is_unclear() {
    let outcome = white(20_000, 2f64.sqrt() * N, None);
    let sheet = model("[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\n");
    let said = text(&compare_logs(&outcome, &sheet).unwrap());
    assert!(
        said.starts_with("Whether the unit is as its sheet says is not told"),
        "{said}"
    );
    // Some unclear, some worse.
    let sheet = model(
        "[gyro.noise]\nangle_random_walk = [\"0.3 deg/sqrt(h)\", \"0.1 deg/sqrt(h)\", \"0.42 deg/sqrt(h)\"]\n",
    );
    let said = text(&compare_logs(&outcome, &sheet).unwrap());
    assert!(
        said.starts_with(
            "The unit is worse than its sheet in gyro y N; 1 of 3 rows are unclear: gyro x N."
        ),
        "{said}"
    );
}

#[test]
fn coarse_steps_decide_nothing_in_a_unit_s_favor() {
    let step = 5.0 * N / 0.02_f64.sqrt();
    let outcome = white(60_000, N, Some(step));
    let sheet = model(
        "[gyro.noise]\nangle_random_walk = \"3 deg/sqrt(h)\"\nrate_random_walk = \"9000 deg/h/sqrt(h)\"\n",
    );
    let compared = compare_logs(&outcome, &sheet).unwrap();
    let rows = || compared.logs[0].axes.iter().flat_map(|a| &a.terms);
    assert!(rows().count() >= 6);
    for row in rows() {
        assert!(
            row.measured.value.is_some() || row.verdict().name() == "unclear",
            "{row:?}"
        );
    }
    let said = text(&compared);
    assert!(said.contains("quantization"), "{said}");
    assert!(
        !said.starts_with("The unit is as its sheet says or better"),
        "{said}"
    );
    // Findings stand in the JSON as they do in that of `characterize`.
    let json = compared.to_json();
    assert_eq!(json["issues"], outcome.to_json()["log"]["issues"]);
    assert!(json["issues"].to_string().contains("quantization"));
}

#[test]
fn a_log_that_tells_nothing_is_no_fault_of_the_sheet() {
    let sheet = model("[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\n");
    let error = compare_logs(&white(40, N, None), &sheet).unwrap_err();
    assert_eq!(
        error.what,
        "the log gives no noise parameters to compare with the sheet"
    );
    assert!(
        error.place.as_deref().unwrap().starts_with("log.csv: "),
        "{error:?}"
    );
    let other = model("[accel.noise]\nvelocity_random_walk = \"0.03 m/s/sqrt(h)\"\n");
    let error = compare_logs(&white(400, N, None), &other).unwrap_err();
    assert_eq!(
        error.what,
        "the log tells of none of the sheet's random terms"
    );
    let empty = model("[gyro.bias]\nfixed = \"1 deg/h\"\n");
    let error = compare_logs(&white(400, N, None), &empty).unwrap_err();
    assert!(error.what.contains("random terms"), "{error:?}");
}
