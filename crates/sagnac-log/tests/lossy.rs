//! Lost samples: what is filled for which use, what is cut, and channels slower than their log.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_log::health::{Health, HealthOptions, check};
use sagnac_log::{IssueKind, Log, ReadOptions, Source, read};

/// Uniform numbers from 0 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// `n` rows at 100 Hz of three gyro axes, `cell` and `row` saying whether there is a value, and a row at all.
fn log(n: usize, mut cell: impl FnMut(usize, usize) -> bool, row: impl Fn(usize) -> bool) -> Log {
    let mut noise = Draw(7);
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n");
    for k in 0..n {
        let values: Vec<String> = (0..3)
            .map(|axis| {
                let y: f64 = (0..12).fold(-6.0, |sum, _| sum + noise.next());
                if cell(k, axis) {
                    format!("{}", 1e-3 * y)
                } else {
                    String::new()
                }
            })
            .collect();
        if row(k) {
            text += &format!("{:.2},{}\n", k as f64 / 100.0, values.join(","));
        }
    }
    let source = Source::memory("a.csv", text.into());
    read(source, &ReadOptions::default()).unwrap()
}

fn kinds(health: &Health<'_>) -> Vec<&'static str> {
    let mut kinds: Vec<&'static str> = health.issues.iter().map(|i| i.kind.name()).collect();
    kinds.dedup();
    kinds
}

#[test]
fn scattered_losses_leave_one_stretch_for_parameters_and_no_false_finding() {
    for share in [0.1, 0.3] {
        let mut draw = Draw(3);
        let log = log(20_000, |_, _| draw.next() >= share, |_| true);
        let health = check(&log, &HealthOptions::default()).unwrap();
        assert_eq!(kinds(&health), ["nan"], "{:?}", health.issues);
        for channel in &health.channels {
            // Deviations do not know what filling does: they are cut where 2 % have been filled.
            assert!(channel.segments.len() > 1000);
            assert_eq!(channel.quiet.len(), 1);
            let quiet = &channel.quiet[0];
            let filled: usize = quiet.filled.iter().map(std::ops::Range::len).sum();
            let is_right = (filled as f64 / 20_000.0 - share).abs() < 0.01;
            assert!(is_right && quiet.range.len() > 19_990, "{filled}");
            assert!(quiet.filled.windows(2).all(|w| w[0].end < w[1].start));
        }
    }
}

#[test]
fn gaps_up_to_twenty_samples_are_filled_for_parameters_and_longer_ones_cut() {
    for (lost, stretches, text) in [
        (3, (1, 1), "filled by a line"),
        (20, (2, 1), "filled by a line for parameters"),
        (21, (2, 2), "cut here"),
    ] {
        let log = log(12_000, |_, _| true, |k| !(6000..6000 + lost).contains(&k));
        let health = check(&log, &HealthOptions::default()).unwrap();
        let own = &health.channels[0];
        assert_eq!((own.segments.len(), own.quiet.len()), stretches, "{lost}");
        let gap = &health.issues[0];
        assert_eq!((gap.kind, gap.count), (IssueKind::Gap, lost as u64));
        assert!(gap.text.ends_with(text), "{}", gap.text);
        if lost == 20 {
            assert_eq!(own.quiet[0].filled.first(), Some(&(6000..6020)));
            assert_eq!(own.segments[1].start_s, 60.2);
        }
    }
}

#[test]
fn no_more_than_seven_tenths_of_a_log_are_filled() {
    let mut draw = Draw(5);
    let log = log(20_000, |_, _| draw.next() >= 0.85, |_| true);
    let health = check(&log, &HealthOptions::default()).unwrap();
    let quiet = &health.channels[0].quiet;
    let runs = || quiet.iter().flat_map(|s| &s.filled);
    assert!(runs().map(std::ops::Range::len).sum::<usize>() <= 14_000);
    // The longest runs cut.
    assert!(quiet.len() > 100, "{}", quiet.len());
}

#[test]
fn a_slower_channel_is_taken_at_its_own_interval() {
    // x in every second row, y in every fifth, z in all; a value of y is lost.
    let cell = |k: usize, axis: usize| match axis {
        0 => k % 2 == 1,
        1 => k % 5 == 3 && k != 5003,
        _ => true,
    };
    let log = log(20_000, cell, |k| k != 9001);
    let health = check(&log, &HealthOptions::default()).unwrap();
    let steps: Vec<f64> = health.channels.iter().map(|c| c.step_s).collect();
    assert_eq!(steps, [0.02, 0.05, 0.01]);
    assert_eq!(health.notes, Vec::<String>::new());
    let nan = health.issues.iter().filter(|i| i.kind == IssueKind::Nan);
    let nan: Vec<_> = nan
        .map(|i| (i.channel.as_deref(), i.count, i.text.as_str()))
        .collect();
    let told = [
        (
            Some("gyro_x"),
            10_000,
            "a value in every 2nd row alone, taken at 50 Hz; 10000 rows have none",
        ),
        (
            Some("gyro_y"),
            15_999,
            "a value in every 5th row alone, taken at 20 Hz; 15999 rows have none",
        ),
        (Some("gyro_y"), 1, "1 sample is no number"),
    ];
    assert_eq!(nan, told);
    for (channel, n) in health.channels.iter().zip([10_000, 4000, 20_000]) {
        assert_eq!(channel.segments.len(), 1, "{}", channel.name);
        assert_eq!(channel.segments[0].range.len(), n);
        assert!((channel.sigma_w / 1e-3 - 1.0).abs() < 0.05);
    }
    assert_eq!(health.channels[1].segments[0].start_s, 0.03);
    assert_eq!(
        health.channels[1].segments[0].filled.first(),
        Some(&(1000..1001))
    );
}

#[test]
fn a_temperature_in_every_tenth_row_is_joined_by_lines() {
    let mut log = log(20_000, |_, _| true, |_| true);
    log.layout.channels[2].name = "temperature".to_owned();
    log.layout.channels[2].quantity = sagnac_log::Quantity::Temperature;
    for (k, t) in log.columns[2].iter_mut().enumerate() {
        *t = if k % 10 == 0 {
            20.0 + 1e-4 * k as f64
        } else {
            f64::NAN
        };
    }
    let health = check(&log, &HealthOptions::default()).unwrap();
    let own = &health.channels[2];
    assert_eq!((own.step_s, own.values.len()), (0.01, 20_000));
    assert!((own.values[12_345] - 21.2345).abs() < 1e-9);
    assert_eq!(own.values[19_999], own.values[19_990]);
    assert_eq!(
        health.notes,
        ["temperature: a value in every 10th row, joined by lines"]
    );
    assert_eq!(kinds(&health), Vec::<&str>::new());
}

#[test]
fn one_absurd_value_moves_no_other_axis() {
    let with = |change: fn(&mut Vec<f64>)| {
        let mut log = log(20_000, |_, _| true, |_| true);
        change(&mut log.columns[0]);
        log
    };
    for (log, quiet) in [
        (with(|x| x[9000] = 1e300), 2),
        (with(|x| x[9000] = -1e30), 2),
        (with(|x| x[9000] = 1e9), 2),
        (
            with(|x| x.iter_mut().for_each(|x| *x = 1e300 * (1.0 + *x))),
            1,
        ),
    ] {
        let health = check(&log, &HealthOptions::default()).unwrap();
        let motion: Vec<_> = health
            .issues
            .iter()
            .filter(|i| i.kind == IssueKind::Motion)
            .map(|i| (i.channel.as_deref(), i.count))
            .collect();
        // Left out where it stands, told of its own axis.
        let own = [(Some("gyro_x"), 1)];
        assert_eq!(motion, own[..quiet - 1], "{:?}", health.issues);
        assert_eq!(health.channels[0].quiet.len(), quiet);
    }
}

#[test]
fn motion_is_seen_among_lost_samples() {
    let mut draw = Draw(3);
    let mut log = log(20_000, |_, _| draw.next() >= 0.1, |_| true);
    for column in &mut log.columns {
        for (k, y) in column[8000..8300].iter_mut().enumerate() {
            *y += 0.3 * (0.2 * k as f64).sin();
        }
    }
    let health = check(&log, &HealthOptions::default()).unwrap();
    let motion = health.issues.iter().find(|i| i.kind == IssueKind::Motion);
    let motion = motion.unwrap();
    assert!((motion.start_s - 80.0).abs() < 0.5 && (motion.end_s - 83.0).abs() < 0.5);
    // No filled sample stands at an end of a stretch.
    for s in &health.channels[0].quiet {
        assert!(
            s.filled
                .iter()
                .all(|r| r.start > 0 && r.end < s.range.len())
        );
    }
}

#[test]
fn rows_that_are_missing_at_equal_distances_are_lost_where_the_rate_is_told() {
    for every in [5, 50, 500] {
        let mut text = String::from("time [s],gyro_x [rad/s]\n");
        let mut noise = Draw(3);
        for k in (0..30_000).filter(|k| k % every != 7 % every) {
            text += &format!("{:.2},{}\n", f64::from(k) / 100.0, noise.next());
        }
        let of = |rate_hz: Option<f64>| {
            let options = ReadOptions {
                rate_hz,
                ..ReadOptions::default()
            };
            read(Source::memory("a.csv", text.clone().into()), &options).unwrap()
        };
        let log = of(Some(100.0));
        let health = check(&log, &HealthOptions::default()).unwrap();
        assert_eq!(health.dt_s, 0.01);
        let lost: u64 = health
            .issues
            .iter()
            .filter(|i| i.kind == IssueKind::Gap)
            .map(|i| i.count)
            .sum();
        // At most a hundred gaps are listed, the last with what is left.
        assert!(lost >= 30_000 / every as u64 / 100, "{every} {lost}");
        assert!(kinds(&health).contains(&"gap"), "{every}");
        assert!(!health.channels[0].quiet[0].filled.is_empty(), "{every}");
        // Told the slower rate, or nothing, they are one sensor's own stamps.
        let slow = 100.0 * f64::from(every - 1) / f64::from(every);
        if every == 50 {
            for rate in [None, Some(slow)] {
                let log = of(rate);
                let health = check(&log, &HealthOptions::default()).unwrap();
                assert!(!kinds(&health).contains(&"gap"), "{rate:?}");
                assert!((health.dt_s * slow - 1.0).abs() < 1e-3, "{rate:?}");
            }
        }
    }
}
