//! Motion, gaps in time and their spans on logs whose faults are known to the sample.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_log::health::{Health, HealthOptions, check};
use sagnac_log::{Issue, IssueKind, Log, ReadOptions, Source, read};

const RATE: f64 = 50.0;

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

/// Six axes at rest, `shape(second, axis)` times their noise plus `moved(second, axis)`.
fn log(seconds: f64, scale: impl Fn(f64, usize) -> f64, moved: impl Fn(f64, usize) -> f64) -> Log {
    let mut noise = Noise(7);
    let mut text = String::from(
        "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n",
    );
    for k in 0..(seconds * RATE) as usize {
        let t = k as f64 / RATE;
        text += &format!("{t}");
        for axis in 0..6 {
            let sigma = if axis < 3 { 1e-3 } else { 1e-2 };
            let level = if axis == 5 { 9.8 } else { 0.01 };
            let y = level + sigma * scale(t, axis) * noise.next() + moved(t, axis);
            text += &format!(",{y}");
        }
        text.push('\n');
    }
    read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap()
}

fn motion(log: &Log) -> (Vec<Issue>, Health<'_>) {
    let health = check(log, &HealthOptions::default()).unwrap();
    let found = health
        .issues
        .iter()
        .filter(|i| i.kind == IssueKind::Motion)
        .cloned()
        .collect();
    (found, health)
}

/// Samples of a burst that the estimate would still see.
fn left_in(health: &Health<'_>, start_s: f64, end_s: f64) -> usize {
    let inside = |k: &usize| (start_s..end_s).contains(&(*k as f64 / RATE));
    let quiet = health.channels[0].quiet.iter();
    quiet
        .flat_map(|s| s.range.clone())
        .filter(|k| inside(k))
        .count()
}

#[test]
fn a_burst_of_noise_is_one_finding_with_its_own_edges() {
    for start in [100.0, 100.37, 251.8] {
        let during = |t: f64| (start..start + 3.0).contains(&t);
        let log = log(400.0, |t, _| if during(t) { 10.0 } else { 1.0 }, |_, _| 0.0);
        let (found, health) = motion(&log);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            (found[0].start_s - start).abs() < 0.3 && (found[0].end_s - start - 3.0).abs() < 0.3,
            "{found:?}"
        );
        assert!(
            found[0].text.contains("the scatter bursts to 1"),
            "{}",
            found[0].text
        );
        assert!(left_in(&health, start, start + 3.0) <= 1);
    }
}

#[test]
fn a_strong_shake_is_motion_of_its_span() {
    let shake = |t: f64, a: usize| {
        if (200.4..203.4).contains(&t) {
            5.0 * (6.3 * 5.0 * t + a as f64).sin()
        } else {
            0.0
        }
    };
    let log = log(600.0, |_, _| 1.0, shake);
    let (found, health) = motion(&log);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        (found[0].start_s - 200.4).abs() < 0.3 && (found[0].end_s - 203.4).abs() < 0.3,
        "{found:?}"
    );
    assert!(left_in(&health, 200.4, 203.4) <= 1);
}

/// A jump between two blocks is in neither one's scatter.
#[test]
fn a_violent_jump_names_its_channel_and_size() {
    let moved = |t: f64, axis| if axis == 1 && t >= 150.0 { 2.0 } else { 0.0 };
    let log = log(300.0, |_, _| 1.0, moved);
    let (found, _) = motion(&log);
    assert!(
        found
            .iter()
            .all(|i| i.text.contains("up to 1.414 rad/s on gyro_y")),
        "{found:?}"
    );
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn a_log_that_moves_in_its_second_half_keeps_its_first() {
    let moved = |t: f64, a: usize| {
        if t >= 150.0 {
            (3.0 * t + a as f64).sin() + (7.1 * t).cos()
        } else {
            0.0
        }
    };
    let log = log(300.0, |_, _| 1.0, moved);
    let (found, health) = motion(&log);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        (found[0].start_s - 150.0).abs() < 0.5 && found[0].end_s > 299.5,
        "{found:?}"
    );
    assert_eq!(health.channels[0].quiet.len(), 1);
    assert!(left_in(&health, 0.0, 150.0) > 7400);
}

#[test]
fn time_that_goes_back_never_makes_a_negative_duration() {
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let mut noise = Noise(3);
    for k in 0..2000 {
        // The clock starts anew in the middle, long before where it began.
        let t = if k < 1000 {
            500.0 + f64::from(k) / 10.0
        } else {
            f64::from(k - 1000) / 10.0
        };
        text += &format!("{t},{}\n", noise.next());
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!(
        (health.duration_s - 200.0).abs() < 1e-6,
        "{}",
        health.duration_s
    );
    assert!(health.issues.iter().any(|i| i.kind == IssueKind::Backwards));
    assert!(health.issues.iter().all(|i| i.end_s >= i.start_s));
}

#[test]
fn stamps_that_are_no_numbers_are_told_and_leave_the_duration() {
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let mut noise = Noise(3);
    for k in 0..1000 {
        let t = if k < 3 || k == 999 {
            "nan".to_owned()
        } else {
            format!("{}", f64::from(k) / 10.0)
        };
        text += &format!("{t},{}\n", noise.next());
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!(
        (health.duration_s - 100.0).abs() < 1e-6,
        "{}",
        health.duration_s
    );
    let told: Vec<u64> = health
        .issues
        .iter()
        .filter(|i| i.kind == IssueKind::Nan)
        .map(|i| i.count)
        .collect();
    assert_eq!(told, [3, 1]);
    assert!(
        health
            .issues
            .iter()
            .all(|i| i.start_s.is_finite() && i.end_s.is_finite())
    );
}

/// Six axes of noise with these stamps, as they are written.
fn stamped(stamps: &[String]) -> Log {
    let mut noise = Noise(5);
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s]\n");
    for stamp in stamps {
        text += &format!("{stamp},{},{}\n", noise.next(), noise.next());
    }
    let source = Source::memory("a.csv", text.into());
    read(source, &ReadOptions::default()).unwrap()
}

fn about_time(health: &Health<'_>) -> Vec<(&'static str, u64)> {
    let of_time = |i: &&Issue| i.channel.as_deref() == Some("time");
    let issues = health.issues.iter().filter(of_time);
    issues.map(|i| (i.kind.name(), i.count)).collect()
}

#[test]
fn coarse_stamps_give_the_rate_and_real_gaps_alone() {
    for (rate, grid, decimals) in [
        (100.0, 1.0, 0),
        (100.0, 1.0 / 64.0, 6),
        (100.0, 0.1, 1),
        (1500.0, 1e-3, 3),
        (128.0, 1e-2, 2),
    ] {
        let stamp = |k: u32| {
            let t = (f64::from(k) / rate / grid + 0.37).floor() * grid;
            format!("{t:.decimals$}")
        };
        let whole = stamped(&(0..30_000).map(stamp).collect::<Vec<_>>());
        let health = check(&whole, &HealthOptions::default()).unwrap();
        let long = 30_000.0 / rate;
        assert_eq!(about_time(&health), [], "{rate} {grid}");
        assert!(
            (health.dt_s * rate - 1.0).abs() < grid / long,
            "{rate} {grid}: {}",
            health.dt_s
        );
        assert!((health.stamp_step_s.unwrap() / grid - 1.0).abs() < 1e-4);
        assert!((health.duration_s - long).abs() < 1.5 * grid);
        assert_eq!(health.channels[0].segments.len(), 1);

        let lost = (5.0 * grid * rate).max(8.0).ceil();
        let behind = |k: u32| if k < 15_000 { k } else { k + lost as u32 };
        let with_gap = stamped(&(0..30_000).map(|k| stamp(behind(k))).collect::<Vec<_>>());
        let health = check(&with_gap, &HealthOptions::default()).unwrap();
        let [("gap", found)] = about_time(&health)[..] else {
            panic!("{rate} {grid}: {:?}", about_time(&health))
        };
        assert!(
            (found as f64 - lost).abs() <= 1.0 + 0.1 * grid * rate,
            "{rate} {grid}: {found} of {lost}"
        );
    }
}

#[test]
fn repeats_in_fine_stamps_stay_repeats() {
    let fine = |k: u32| format!("{:.2}", f64::from(k) / 100.0);
    let log = stamped(
        &(0..3000)
            .map(|k| fine(k - u32::from(k == 700)))
            .collect::<Vec<_>>(),
    );
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert_eq!(about_time(&health), [("gap", 1), ("duplicate", 1)]);
    assert_eq!((health.dt_s, health.stamp_step_s), (0.01, None));

    // Every row written twice: the second is dropped, the rate is that of the samples.
    let mut noise = Noise(9);
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    for k in 0..3000 {
        let row = format!("{},{}\n", fine(k), noise.next());
        text += &row;
        text += &row;
    }
    let twice = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&twice, &HealthOptions::default()).unwrap();
    assert_eq!((health.dt_s, health.stamp_step_s), (0.01, None));
    assert_eq!(about_time(&health), [("duplicate", 3000)]);
    assert_eq!(
        health.channels[0]
            .slices()
            .iter()
            .map(|s| s.len())
            .sum::<usize>(),
        3000
    );
}

#[test]
fn a_wrong_stamp_is_told_by_its_row_and_leaves_the_log_whole() {
    for (row, stamp, kind) in [
        (1500, "1e9", "backwards"),
        (1500, "-5", "backwards"),
        (1500, "0", "backwards"),
        (1500, "inf", "nan"),
        (0, "1e9", "backwards"),
        (2999, "1e9", "jitter"),
    ] {
        let mut stamps: Vec<String> = (0..3000)
            .map(|k| format!("{:.2}", f64::from(k) / 100.0))
            .collect();
        stamps[row] = stamp.to_owned();
        let log = stamped(&stamps);
        let health = check(&log, &HealthOptions::default()).unwrap();
        assert_eq!(about_time(&health), [(kind, 1)], "{stamp} in row {row}");
        assert!(
            (health.duration_s - 30.0).abs() < 1e-9,
            "{}",
            health.duration_s
        );
        assert_eq!(health.dt_s, 0.01);
        let at = row as f64 / 100.0;
        let issue = &health.issues[0];
        assert!(
            (issue.start_s - at).abs() < 1e-9 && (issue.end_s - at).abs() < 1e-9,
            "{issue:?}"
        );
        assert!(
            kind == "nan" || issue.text.contains(&format!("row {} ", row + 1)),
            "{}",
            issue.text
        );
        assert_eq!(health.channels[0].slices()[0].len(), 3000);
    }
}

#[test]
fn rate_length_and_lost_samples_of_a_jittering_log_add_up() {
    let mut noise = Noise(2);
    // Samples arrive in bursts of nine, 1 ms apart, and two hundred of them never.
    let stamps: Vec<String> = (0..20_000)
        .map(|k| if k < 9000 { k } else { k + 200 })
        .map(|k| f64::from(k / 9) * 0.09 + f64::from(k % 9) * 1e-3 + 1e-5 * noise.next())
        .map(|t| format!("{t:.7}"))
        .collect();
    let log = stamped(&stamps);
    let health = check(&log, &HealthOptions::default()).unwrap();
    let of_gaps = about_time(&health).into_iter().filter(|i| i.0 == "gap");
    let lost: u64 = of_gaps.map(|i| i.1).sum();
    assert!((190..=210).contains(&lost), "{lost}");
    let counted = health.duration_s / health.dt_s;
    assert!(
        (counted - 20_000.0 - lost as f64).abs() < 10.0,
        "{counted} {lost}"
    );
}

#[test]
fn values_beyond_measure_have_a_mean_and_a_scatter() {
    let mut noise = Noise(4);
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s]\n");
    for k in 0..1000 {
        let x = if k == 500 { 1e308 } else { noise.next() };
        let y = if k % 2 == 0 { 1e308 } else { -1e308 };
        text += &format!("{},{x:e},{y:e}\n", f64::from(k) / 100.0);
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    let [x, y] = &health.channels[..] else {
        panic!()
    };
    assert!((x.mean / 1e305 - 1.0).abs() < 1e-9, "{}", x.mean);
    assert!(
        (x.std / (1e308 / 1000.0_f64.sqrt()) - 1.0).abs() < 1e-3,
        "{}",
        x.std
    );
    assert_eq!(x.lsb, None);
    assert!(
        (y.std / 1e308 - 1.0).abs() < 1e-3 && y.mean.abs() < 1e294,
        "{} {}",
        y.mean,
        y.std
    );
}

#[test]
fn stamps_that_scatter_lose_no_samples_and_keep_the_rate() {
    let mut noise = Noise(12);
    let stamps: Vec<String> = (0..20_000)
        .map(|k| format!("{:.6}", f64::from(k) / 100.0 + 0.0025 * noise.next()))
        .collect();
    let log = stamped(&stamps);
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!((health.dt_s / 0.01 - 1.0).abs() < 1e-4, "{}", health.dt_s);
    assert!(
        (health.duration_s - 200.0).abs() < 0.02,
        "{}",
        health.duration_s
    );
    let found = about_time(&health);
    assert!(
        found.iter().all(|i| i.0 != "gap") && found.iter().any(|i| i.0 == "jitter"),
        "{found:?}"
    );
}

#[test]
fn every_channel_that_loses_numbers_is_named() {
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n");
    for k in 0..40_000 {
        let number = |lost: bool| {
            if lost {
                "nan".to_owned()
            } else {
                format!("0.{}", k * 7919 % 101)
            }
        };
        // A loss every 2 s on x and y, seven in all on z.
        let cells = [k % 200 == 50, k % 200 == 120, k % 5000 == 4000].map(number);
        text += &format!("{},{}\n", f64::from(k) / 100.0, cells.join(","));
    }
    let source = Source::memory("nan.csv", text.into());
    let log = read(source, &ReadOptions::default()).unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    let of = |channel: &str| -> Vec<&Issue> {
        let nan = health.issues.iter().filter(|i| i.kind == IssueKind::Nan);
        nan.filter(|i| i.channel.as_deref() == Some(channel))
            .collect()
    };
    let (x, y, z) = (of("gyro_x"), of("gyro_y"), of("gyro_z"));
    assert_eq!((x.len(), y.len(), z.len()), (46, 46, 8));
    for cut in [x, y] {
        let last = &cut[45].text;
        assert!(
            last.contains("; and 154 more of this kind up to "),
            "{last}"
        );
    }
    assert!(z.iter().all(|i| !i.text.contains("more of this kind")));
}

/// Texts about units of a log with these columns at rest, `absurd` in one cell of row 300.
fn units_of(columns: &[(&str, f64)], absurd: Option<(usize, f64)>) -> Vec<String> {
    let mut noise = Noise(9);
    let names: Vec<String> = columns
        .iter()
        .map(|(name, _)| {
            let unit = if name.starts_with('g') {
                "rad/s"
            } else {
                "m/s^2"
            };
            format!("{name} [{unit}]")
        })
        .collect();
    let mut text = format!("time [s],{}\n", names.join(","));
    for k in 0..3000 {
        text += &format!("{}", f64::from(k) / RATE);
        for (i, (_, level)) in columns.iter().enumerate() {
            let own = level + 1e-3 * noise.next();
            let y = absurd.filter(|a| k == 300 && a.0 == i).map_or(own, |a| a.1);
            text += &format!(",{y}");
        }
        text.push('\n');
    }
    let source = Source::memory("a.csv", text.into());
    let log = read(source, &ReadOptions::default()).unwrap();
    let health = check(&log, &HealthOptions::default()).unwrap();
    let told = health.issues.iter().filter(|i| i.kind == IssueKind::Units);
    told.map(|i| i.text.clone()).collect()
}

#[test]
fn a_gyro_in_a_wrong_unit_is_told_without_a_good_accelerometer() {
    let gyro = |w: f64| [("gyro_x", w), ("gyro_y", 0.0), ("gyro_z", 0.0)];
    let with = |w: f64, z: f64| {
        let accel = [("accel_x", 0.0), ("accel_y", 0.0), ("accel_z", z)];
        [gyro(w).as_slice(), accel.as_slice()].concat()
    };
    let fast = "|w| is 500.0 rad/s, more than gyros measure: look at the unit";
    assert_eq!(units_of(&gyro(500.0), None), [fast]);
    assert_eq!(units_of(&[("gyro_z", -500.0)], None), [fast]);
    let dead = units_of(&with(500.0, 0.0), None);
    let both = |t: &String| t.contains("far from 9.81") && t.ends_with(fast);
    assert!(dead.len() == 1 && dead.iter().all(both), "{dead:?}");
    let slow = "|w| is 20.00 rad/s at rest, as if it were in deg/s";
    assert_eq!(units_of(&with(20.0, 9.8), None), [slow]);
    assert_eq!(units_of(&[("gyro_z", 20.0)], None), [slow]);
    assert!(units_of(&with(20.0, 0.0), None)[0].ends_with(slow));
    assert_eq!(units_of(&with(0.01, 9.8), None), [""; 0]);
}

#[test]
fn one_absurd_sample_is_no_wrong_unit() {
    let columns = [
        ("gyro_x", 0.01),
        ("gyro_y", 0.0),
        ("gyro_z", 0.0),
        ("accel_x", 0.0),
        ("accel_y", 0.0),
        ("accel_z", 9.8),
    ];
    for cell in [0, 5] {
        for value in [1e9, -1e9, 1e300] {
            assert_eq!(units_of(&columns, Some((cell, value))), [""; 0], "{cell}");
        }
    }
}

#[test]
fn repeated_stamps_of_a_part_or_by_count_are_duplicates_and_coarse_ones_are_not() {
    let in_order = |k: u32| format!("{:.2}", f64::from(k) / 100.0);
    // The first 60 % twice; every tenth twice: other values each.
    let part = (0..20_000).flat_map(|k| vec![in_order(k); if k < 12_000 { 2 } else { 1 }]);
    let count = (0..20_000).flat_map(|k| vec![in_order(k); if k % 10 == 3 { 2 } else { 1 }]);
    for (stamps, twice) in [
        (part.collect::<Vec<_>>(), 12_000),
        (count.collect::<Vec<_>>(), 2000),
    ] {
        let log = stamped(&stamps);
        let health = check(&log, &HealthOptions::default()).unwrap();
        assert_eq!((health.dt_s, health.stamp_step_s), (0.01, None));
        assert!(
            about_time(&health).iter().all(|i| i.0 == "duplicate"),
            "{:?}",
            about_time(&health)
        );
        let all: u64 = about_time(&health).iter().map(|i| i.1).sum();
        assert_eq!(all, twice);
    }
    for (rate, grid) in [(3000.0, 1e-3), (1125.0, 1e-3), (104.0, 0.01)] {
        // 20 ppm between the clocks.
        let stamp = |k: u32| (f64::from(k) * 1.000_02 / rate / grid).floor() * grid;
        let log = stamped(
            &(0..60_000)
                .map(|k| format!("{:.3}", stamp(k)))
                .collect::<Vec<_>>(),
        );
        let health = check(&log, &HealthOptions::default()).unwrap();
        assert_eq!(
            health.stamp_step_s.map(|s| (s / grid).round()),
            Some(1.0),
            "{rate}"
        );
        assert!((health.dt_s * rate - 1.0).abs() < 1e-3, "{rate}");
        assert_eq!(about_time(&health), [], "{rate}");
    }
}

#[test]
fn an_infinite_value_is_one_finding() {
    for value in [f64::INFINITY, f64::NEG_INFINITY] {
        let mut log = log(200.0, |_, _| 1.0, |_, _| 0.0);
        log.columns[0][5000] = value;
        let health = check(&log, &HealthOptions::default()).unwrap();
        let found: Vec<_> = health.issues.iter().map(|i| (i.kind, i.count)).collect();
        assert_eq!(found, [(IssueKind::Nan, 1)]);
    }
}

#[test]
fn an_uneven_clock_concerns_every_row() {
    // The rate drifts by ±15 % and no step is off by 20 %.
    let stamp = |k: u32| 0.01 * f64::from(k) + 0.15 * 0.01 * 3000.0 * (f64::from(k) / 3000.0).sin();
    let log = stamped(
        &(0..30_000)
            .map(|k| format!("{:.6}", stamp(k)))
            .collect::<Vec<_>>(),
    );
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert_eq!(about_time(&health), [("jitter", 30_000)]);
}

/// A log at 50 Hz whose clock is `unit` times a counter that passes 2³² after 1000 rows; `jump_s` more at that row.
fn wrapping(unit: f64, jump_s: f64) -> Log {
    let mut noise = Noise(3);
    let turn = unit * 4_294_967_296.0;
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    for k in 0..3000 {
        let mut t = turn - 20.0 + 0.0127 + f64::from(k) / RATE;
        if k >= 1000 {
            t += jump_s;
        }
        text += &format!("{},{}\n", t.rem_euclid(turn), noise.next());
    }
    read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap()
}

fn jumps_back<'a>(health: &'a Health<'_>) -> Vec<&'a Issue> {
    let is_jump = |i: &&Issue| i.kind == IssueKind::Backwards;
    health.issues.iter().filter(is_jump).collect()
}

#[test]
fn a_counter_that_wraps_is_told_in_whatever_unit_it_was_written() {
    for (unit, name) in [(1e-6, "1e-6 s (4294.967296 s)"), (1e-3, "1e-3 s")] {
        let log = wrapping(unit, 0.0);
        let health = check(&log, &HealthOptions::default()).unwrap();
        let back = jumps_back(&health);
        assert_eq!(back.len(), 1, "{:?}", health.issues);
        let text = &back[0].text;
        assert!(text.contains("the counter wraps at 2^32 of "), "{text}");
        assert!(text.contains(name) && text.ends_with("undone"), "{text}");
        let start_s = back[0].start_s - health.first_s;
        assert!((start_s - 19.98).abs() < 0.05, "{start_s}");
        assert!((health.duration_s - 60.0).abs() < 1e-3);
        assert_eq!(health.channels[0].quiet.len(), 1, "one stretch");
    }
}

#[test]
fn a_jump_back_that_is_no_wrap_is_cut() {
    // A tenth of a second besides the turn: not the next sample of a counter.
    let log = wrapping(1e-6, 0.1);
    let health = check(&log, &HealthOptions::default()).unwrap();
    let back = jumps_back(&health);
    assert_eq!(back.len(), 1, "{:?}", health.issues);
    assert!(back[0].text.ends_with("cut here"), "{}", back[0].text);
    assert!((health.duration_s - 60.0).abs() < 0.2);
}
