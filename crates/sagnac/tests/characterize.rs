//! `characterize` from a log to its page and words, where the noise in the log is known.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac::characterize::{NamedLog, Outcome, PageFacts, Request, candidates, characterize};
use sagnac::info::{InfoRequest, info};
use sagnac::log::{Log, ReadOptions, Source, open};
use sagnac::report::text::Style;

/// A gyro axis at 100 Hz, 200 s of uniform noise of 1 rad/s.
fn outcome(terms: &str) -> Outcome {
    let mut state = 3_u64;
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    for k in 0..20_000 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let y = ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt();
        text += &format!("{},{y}\n", f64::from(k) / 100.0);
    }
    let source = Source::memory("rest.csv", text.into());
    let mut reader = open(source, &ReadOptions::default()).unwrap();
    let log = NamedLog {
        name: "rest.csv".to_owned(),
        log: Log::read(&mut *reader).unwrap(),
    };
    let request = Request {
        candidates: candidates(terms).unwrap(),
        ..Request::default()
    };
    characterize(&[log], &request).unwrap()
}

#[test]
fn the_page_draws_the_spectrum_one_sided() {
    let page = outcome("all").to_page(&PageFacts::default());
    let panel = &page.logs[0].spectrum[0][0];
    assert_eq!(panel.sides, "one-sided");
    // √(2 dt) rad/s/√Hz; 10 000 coefficients, of which the tenth with most power is known to 3 %.
    let level = 0.02_f64.sqrt().to_degrees();
    for curve in [&panel.density, &panel.fit] {
        let mean_square = curve.iter().map(|d| d * d).sum::<f64>() / curve.len() as f64;
        assert!(
            (mean_square.sqrt() / level - 1.0).abs() < 0.05,
            "{mean_square} {level}"
        );
    }
}

#[test]
fn what_was_not_asked_for_is_not_spoken_of() {
    let words = |terms: &str| {
        let text = outcome(terms).document().render(Style::PLAIN);
        text.replace('\n', " ")
    };
    let white = words("angle_random_walk");
    assert!(!white.contains("bounded from above"), "{white}");
    assert!(
        white.starts_with("The gyro is known: white noise to "),
        "{white}"
    );
    let slow = words("bias_instability");
    assert!(!slow.contains("no white noise"), "{slow}");
    let both = words("all");
    assert!(
        both.contains("bias instability and random walk only bounded"),
        "{both}"
    );
}

#[test]
fn every_term_is_listed_once() {
    let error = candidates("foo").unwrap_err().to_string();
    assert_eq!(error.matches("quantization").count(), 1, "{error}");
    assert_eq!(error.matches("bias_instability").count(), 1, "{error}");
}

#[test]
fn a_short_log_is_not_said_to_move() {
    for rows in [3, 6, 63] {
        let mut text = String::from("time [s],gyro_x [rad/s]\n");
        for k in 0..rows {
            text += &format!("{k},{}\n", f64::from(k * 7919 % 101) * 1e-3);
        }
        let source = Source::memory("short.csv", text.into());
        let log = Log::read(&mut *open(source, &ReadOptions::default()).unwrap()).unwrap();
        let outcome = info(&log, &InfoRequest::default()).unwrap();
        assert!(!outcome.is_moving, "{rows} rows");
        assert!(outcome.issues.iter().any(|i| i.kind.name() == "short"));
    }
}
