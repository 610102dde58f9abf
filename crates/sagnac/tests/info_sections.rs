//! A log that goes by in sections tells what it tells as a whole.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac::info::{InfoOutcome, InfoRequest, info};
use sagnac::log::{IssueKind, ReadOptions, Source, open};

const RATE_HZ: f64 = 100.0;
const ROWS: usize = 40_000;
/// Five of these make the log.
const SECTION: usize = 8_000;

/// Uniform noise of unit variance.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }
}

/// A row: its time in samples, and its values; `None` where it is lost.
type Row = (f64, [f64; 6]);

/// Six axes at rest, spoiled row by row.
fn log(spoil: impl Fn(usize, &mut Row) -> bool) -> String {
    let mut noise = Noise(11);
    let mut text = String::from(
        "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n",
    );
    for k in 0..ROWS {
        let mut row = (k as f64, [0.0; 6]);
        for (axis, y) in row.1.iter_mut().enumerate() {
            let (level, sigma) = if axis < 3 { (0.01, 1e-3) } else { (0.02, 1e-2) };
            *y = level + sigma * noise.next() + if axis == 5 { 9.8 } else { 0.0 };
        }
        if spoil(k, &mut row) {
            let cells = row.1.map(|y| {
                if y.is_nan() {
                    String::new()
                } else {
                    format!("{y:.9}")
                }
            });
            text += &format!("{:.6},{}\n", row.0 / RATE_HZ, cells.join(","));
        }
    }
    text
}

fn told(text: &str, section_rows: Option<usize>) -> InfoOutcome {
    let source = Source::memory("log.csv", text.as_bytes().to_vec());
    let mut reader = open(source, &ReadOptions::default()).unwrap();
    let request = InfoRequest {
        section_rows,
        ..InfoRequest::default()
    };
    info(&mut *reader, &request).unwrap()
}

fn near(a: f64, b: f64, to: f64, what: &str) {
    let is_near = (a - b).abs() <= to * a.abs().max(b.abs()) || a.to_bits() == b.to_bits();
    assert!(is_near, "{what}: {a} {b}");
}

/// Both tell the same; returns what they tell.
fn check(text: &str) -> InfoOutcome {
    let whole = told(text, None);
    let parts = told(text, Some(SECTION));
    let list = |o: &InfoOutcome| -> Vec<String> {
        let one = |i: &sagnac::log::Issue| {
            format!(
                "{} {:?} {:.4} {:.4} {} {}",
                i.kind.name(),
                i.channel,
                i.start_s,
                i.end_s,
                i.count,
                i.text
            )
        };
        // Of a log as long as two sections the fit sees a part, which does not tell that its stretches are short.
        let of_all = |i: &&sagnac::log::Issue| i.kind != IssueKind::Short || i.channel.is_none();
        o.issues.iter().filter(of_all).map(one).collect()
    };
    assert_eq!(list(&whole), list(&parts));
    assert_eq!(whole.samples, parts.samples);
    assert_eq!(whole.is_moving, parts.is_moving);
    assert_eq!(whole.layout, parts.layout);
    assert_eq!(whole.first_s.to_bits(), parts.first_s.to_bits());
    near(whole.rate_hz, parts.rate_hz, 1e-6, "rate");
    near(whole.duration_s, parts.duration_s, 1e-7, "duration");
    let force = |o: &InfoOutcome| o.force_m_s2.unwrap();
    near(force(&whole), force(&parts), 1e-9, "|f|");
    for (a, b) in whole.channels.iter().zip(&parts.channels) {
        near(a.mean, b.mean, 1e-12, &a.name);
        near(a.std, b.std, 1e-12, &a.name);
        assert_eq!((a.min, a.max), (b.min, b.max), "{}", a.name);
        assert_eq!(a.lsb.is_some(), b.lsb.is_some(), "{}", a.name);
        near(a.lsb.unwrap_or(0.0), b.lsb.unwrap_or(0.0), 1e-6, &a.name);
    }
    parts
}

fn count(outcome: &InfoOutcome, kind: IssueKind) -> usize {
    outcome.issues.iter().filter(|i| i.kind == kind).count()
}

/// Inside a section, about a border, and with a border as first or last row.
const PLACES: [usize; 5] = [4_000, 8_000, 15_990, 23_999, 32_001];

#[test]
fn a_clean_log_is_sound() {
    let outcome = check(&log(|_, _| true));
    assert!(outcome.issues.is_empty(), "{:?}", outcome.issues);
}

#[test]
fn a_log_hardly_longer_than_a_section_is_told_to_the_last_bit() {
    let text = log(|_, _| true);
    let whole = told(&text, None).to_json();
    assert_eq!(whole, told(&text, Some(ROWS)).to_json());
    assert_eq!(whole, told(&text, Some(ROWS - ROWS / 20)).to_json());
}

#[test]
fn lost_rows_and_repeats_are_neither_lost_nor_doubled_at_a_border() {
    for lost in [1, 7, 300] {
        let outcome = check(&log(|k, row| {
            row.0 += (lost * PLACES.iter().filter(|p| **p <= k).count()) as f64;
            true
        }));
        assert_eq!(count(&outcome, IssueKind::Gap), PLACES.len());
    }
    let outcome = check(&log(|k, row| {
        row.0 -= PLACES.iter().filter(|p| **p <= k).count() as f64;
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Duplicate), PLACES.len());
}

#[test]
fn time_that_goes_back_cuts_once() {
    for at in [4_000, 8_000, 16_001] {
        let outcome = check(&log(|k, row| {
            row.0 -= if k < at { 0.0 } else { 900.0 };
            true
        }));
        assert_eq!(count(&outcome, IssueKind::Backwards), 1, "{at}");
    }
}

#[test]
fn lost_numbers_are_counted_once() {
    for long in [1, 2, 40, 2_500] {
        let outcome = check(&log(|k, row| {
            if PLACES.iter().any(|p| (*p..p + long).contains(&k)) {
                row.1[1] = f64::NAN;
            }
            true
        }));
        assert_eq!(count(&outcome, IssueKind::Nan), PLACES.len(), "{long}");
    }
}

#[test]
fn a_value_that_sticks_over_a_border_is_one_finding() {
    // Beside a border there are 500 rows: the longest are not seen as a whole by any section.
    for long in [30, 700, 3_000] {
        let outcome = check(&log(|k, row| {
            if PLACES.iter().any(|p| (*p..p + long).contains(&k)) {
                row.1[4] = 0.25;
            }
            true
        }));
        assert_eq!(count(&outcome, IssueKind::Stuck), PLACES.len(), "{long}");
    }
    let outcome = check(&log(|k, row| {
        if k > 10_000 {
            row.1[2] = 0.25;
        }
        row.1[0] = 0.125;
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Stuck), 2);
    let text = &outcome
        .issues
        .iter()
        .find(|i| i.kind == IssueKind::Stuck)
        .unwrap()
        .text;
    assert!(text.contains("all the time"), "{text}");
}

#[test]
fn a_range_that_ends_is_told_by_its_value() {
    for long in [3, 40] {
        let outcome = check(&log(|k, row| {
            if PLACES.iter().any(|p| (*p - 1..p - 1 + long).contains(&k)) {
                row.1[0] = 0.5;
            }
            true
        }));
        assert_eq!(
            count(&outcome, IssueKind::Saturation),
            PLACES.len(),
            "{long}"
        );
    }
    // What a later section passes is no end of a range.
    let outcome = check(&log(|k, row| {
        if (4_000..4_040).contains(&k) {
            row.1[0] = 0.5;
        }
        if k == 30_000 {
            row.1[0] = 0.7;
        }
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Saturation), 0);
}

#[test]
fn motion_over_a_border_is_one_finding() {
    for at in [3_000, 7_900] {
        let text = log(|k, row| {
            if (at..at + 400).contains(&k) {
                row.1[0] += 0.5 * ((k - at) as f64 / 400.0 * std::f64::consts::PI).sin();
            }
            true
        });
        let parts = told(&text, Some(SECTION));
        let whole = told(&text, None);
        let of = |o: &InfoOutcome| -> Vec<(f64, f64)> {
            let motion = o.issues.iter().filter(|i| i.kind == IssueKind::Motion);
            motion.map(|i| (i.start_s, i.end_s)).collect()
        };
        let (a, b) = (of(&whole), of(&parts));
        assert_eq!((a.len(), b.len()), (1, 1), "{a:?} {b:?}");
        // Averages begin where the section does.
        assert!(
            (a[0].0 - b[0].0).abs() < 1.5 && (a[0].1 - b[0].1).abs() < 1.5,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn what_concerns_the_whole_log_is_told_once() {
    // In g read as m/s^2, coarse steps, one axis in every fourth row, an uneven clock.
    let outcome = check(&log(|_, row| {
        for y in &mut row.1[3..] {
            *y /= 9.80665;
        }
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Units), 1);
    let outcome = check(&log(|_, row| {
        row.1[0] = (row.1[0] / 2e-3).round() * 2e-3;
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Quantization), 1);
    let outcome = check(&log(|k, row| {
        if k % 4 != 0 {
            row.1[3] = f64::NAN;
        }
        true
    }));
    assert_eq!(count(&outcome, IssueKind::Nan), 1);
}

#[test]
fn many_findings_are_listed_as_far_as_those_of_a_whole_log() {
    // At uneven distances: else the rate might be lower.
    let is_lost = |k: usize| Noise(k as u64 * 7919).next() > 0.99 * 3.0_f64.sqrt();
    let outcome = check(&log(|k, _| !is_lost(k)));
    assert_eq!(count(&outcome, IssueKind::Gap), 100);
    let last = outcome
        .issues
        .iter()
        .rfind(|i| i.kind == IssueKind::Gap)
        .unwrap();
    assert!(
        last.text.contains("more of this kind up to 39"),
        "{}",
        last.text
    );
}

#[test]
fn a_sensor_that_is_carried_about_is_told_to_be() {
    let text = log(|k, row| {
        let t = k as f64 / RATE_HZ;
        row.1[0] += 2.0 * (3.0 * t).sin();
        row.1[1] += 2.0 * (2.0 * t).cos();
        row.1[4] += 4.0 * (1.7 * t).sin();
        true
    });
    assert!(check(&text).is_moving);
}
