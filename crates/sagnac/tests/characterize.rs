//! `characterize` from a log to its page and words, where the noise in the log is known.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac::characterize::{NamedLog, Outcome, PageFacts, Request, candidates, characterize};
use sagnac::follow::State;
use sagnac::info::{InfoRequest, info};
use sagnac::log::{Log, ReadOptions, Source, open};
use sagnac::report::html::ParameterCell;
use sagnac::report::text::{Estimate as Shown, Style};

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
        let mut log = open(source, &ReadOptions::default()).unwrap();
        let outcome = info(&mut *log, &InfoRequest::default()).unwrap();
        assert!(!outcome.is_moving, "{rows} rows");
        assert!(outcome.issues.iter().any(|i| i.kind.name() == "short"));
    }
}

/// Gyro axes at 100 Hz of uniform noise, its sizes in rad/s by axis, with the rows that `keep` keeps.
fn gyros(seed: u64, sizes: &[f64], rows: usize, keep: impl Fn(usize) -> bool) -> String {
    let mut state = seed;
    let mut text = String::from("time [s]");
    for axis in ["x", "y", "z"].iter().take(sizes.len()) {
        text += &format!(",gyro_{axis} [rad/s]");
    }
    for k in 0..rows {
        let mut row = format!("\n{}", k as f64 / 100.0);
        for size in sizes {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let y = ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * size;
            row += &format!(",{y}");
        }
        if keep(k) {
            text += &row;
        }
    }
    text + "\n"
}

fn named(name: &str, text: String) -> NamedLog {
    let mut reader = open(Source::memory(name, text.into()), &ReadOptions::default()).unwrap();
    NamedLog {
        name: name.to_owned(),
        log: Log::read(&mut *reader).unwrap(),
    }
}

#[test]
fn one_log_that_differs_is_named_once_and_left_out() {
    let run = |k: u64, size: f64| {
        let name = format!("run{k}.csv");
        named(&name, gyros(31 + k, &[size, 1.0, size], 6000, |_| true))
    };
    let logs: Vec<NamedLog> = (0..5)
        .map(|k| run(k, if k == 3 { 2.0 } else { 1.0 }))
        .collect();
    let request = Request {
        one_sensor: true,
        ..Request::default()
    };
    let outcome = characterize(&logs, &request).unwrap();
    let named: Vec<(usize, &str)> = outcome
        .outliers
        .iter()
        .map(|o| (o.log, o.axis.as_str()))
        .collect();
    assert_eq!(named, [(3, "gyro_x"), (3, "gyro_z")]);
    let said = outcome.differences();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("run3.csv: gyro_x, gyro_z differ"),
        "{said:?}"
    );
    // What the others have, which the fifth would draw up by a quarter: uniform noise of 1 rad/s has σ = 1/√12.
    for (axis, runs) in outcome.sensor.unwrap().iter().zip([4, 5, 4]) {
        let white = axis.pooled.white.value.unwrap();
        assert!(
            (white / (0.01_f64 / 12.0).sqrt() - 1.0).abs() < 0.02,
            "{white}"
        );
        assert_eq!(axis.runs, runs);
    }
    // Two that differ have nobody to differ from: both stay.
    let two = characterize(&logs[3..], &request).unwrap();
    assert_eq!(two.differences().len(), 2);
    assert!(two.sensor.unwrap().iter().all(|a| a.runs == 2));
    // Different sensors: the one that differs, once.
    let fleet = characterize(&logs, &Request::default()).unwrap();
    let said = fleet.differences();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("run3.csv: N of gyro_x, gyro_z is "),
        "{said:?}"
    );
}

#[test]
fn the_time_series_leaves_gaps_open() {
    let keep = |k: usize| !(5000..12_000).contains(&k);
    let log = named("gap.csv", gyros(7, &[1.0], 20_000, keep));
    let outcome = characterize(&[log], &Request::default()).unwrap();
    let page = outcome.to_page(&PageFacts::default());
    let panel = &page.logs[0].series[0][0];
    let drawn = |from: f64, to: f64| {
        let times = panel.time_s.iter().zip(&panel.mean);
        times
            .filter(|(t, y)| y.is_finite() && **t > from && **t < to)
            .count()
    };
    assert_eq!(drawn(50.0, 120.0), 0);
    assert!(drawn(0.0, 50.0) > 170 && drawn(120.0, 200.0) > 280);
    let at = panel.time_s.iter().position(|t| *t > 60.0).unwrap();
    assert!(panel.mean[at].is_nan(), "the curve is joined over the gap");
    assert!(panel.time_s.windows(2).all(|w| w[0] < w[1]));
}

#[test]
fn a_gauss_markov_term_is_drawn_beside_the_others() {
    // A random walk that returns in 2 s, of σ = 1 rad/s, under white noise of 0.1 rad/s.
    let mut state = 0.0;
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let noise = gyros(5, &[1.0, 1.0], 40_000, |_| true);
    let keep = (-0.01_f64 / 2.0).exp();
    for line in noise.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        let unit = 12.0_f64.sqrt();
        state = keep * state + (1.0 - keep * keep).sqrt() * unit * cells[1];
        text += &format!("{},{}\n", cells[0], state + 0.1 * unit * cells[2]);
    }
    let outcome = characterize(&[named("gm.csv", text)], &Request::default()).unwrap();
    let page = outcome.to_page(&PageFacts::default());
    let panel = &page.logs[0].allan[0][0];
    let term = panel.terms.iter().find(|t| t.symbol == "GM").unwrap();
    assert!(term.label.contains("T_c"), "{}", term.label);
    // The hump of a Gauss–Markov process is 0.617 σ, at 1.89 T_c.
    let top = term.deviation.iter().copied().fold(0.0, f64::max);
    let sigma = 1.0_f64.to_degrees() * 3600.0;
    assert!((top / (0.617 * sigma) - 1.0).abs() < 0.15, "{top} {sigma}");
}

/// Means, scatters and units of `info` by channel, and its text on one line.
fn told(text: String) -> (serde_json::Value, String) {
    let source = Source::memory("log.csv", text.into());
    let mut log = open(source, &ReadOptions::default()).unwrap();
    let outcome = info(&mut *log, &InfoRequest::default()).unwrap();
    let words = outcome.document().render(Style::PLAIN);
    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
    (outcome.to_json()["channels"].clone(), words)
}

#[test]
fn info_leaves_out_what_it_says_is_left_out() {
    let lines = |spoil: &dyn Fn(usize, &str) -> String| -> String {
        let noise = gyros(3, &[0.01, 0.01, 0.01], 20_000, |_| true);
        let mut lines = noise.lines();
        let mut text = format!("{}\n", lines.next().unwrap());
        for (k, line) in lines.enumerate() {
            let cells: Vec<&str> = line.split(',').collect();
            let y = spoil(k, cells[2]);
            text += &format!("{},{},{y},{}\n", cells[0], cells[1], cells[3]);
        }
        text
    };
    // The y axis sticks at 3 rad/s in the second half.
    let (channels, words) = told(lines(&|k, y| {
        if k < 10_000 { y.to_owned() } else { "3".into() }
    }));
    assert!(
        channels[1]["mean"].as_f64().unwrap().abs() < 1e-3,
        "{channels}"
    );
    assert!(channels[1]["max"].as_f64().unwrap() < 0.006, "{channels}");
    assert!(words.contains("one value for 10 000 samples"), "{words}");
    // It holds no numbers: its unit stays, and nothing is said of |w|.
    let (_, words) = told(lines(&|_, _| "nan".to_owned()));
    assert!(words.contains("gyro_y deg/s - -"), "{words}");
    assert!(!words.contains("|w|"), "{words}");
}

#[test]
fn page_and_text_count_the_same_findings() {
    // 60 gaps of a second each, 3 s apart.
    let log = named("gaps.csv", gyros(11, &[1.0], 24_000, |k| k % 400 < 300));
    let outcome = characterize(&[log], &Request::default()).unwrap();
    let page = outcome.to_page(&PageFacts::default());
    let words = outcome.document().render(Style::PLAIN);
    // The gaps, and that no stretch between them is long.
    assert_eq!(words.matches("warning:").count(), 2, "{words}");
    let (_, findings) = page.facts.iter().find(|f| f.0 == "Findings").unwrap();
    assert_eq!(findings, "2 warnings");
    let bars = page.logs[0].timeline.issues.iter();
    let bars: Vec<_> = bars.filter(|b| b.kind == "gap").collect();
    assert_eq!(bars.len(), 59);
    assert!(
        bars.iter().all(|b| b.text.starts_with("59 times")),
        "{}",
        bars[0].text
    );
}

#[test]
fn a_rounding_step_has_one_size() {
    // A slow swing of 40 steps beside noise of one step.
    let mut text = String::from("time [s],gyro_x [rad/s]\n");
    let noise = gyros(13, &[3.5], 20_000, |_| true);
    for (k, line) in noise.lines().skip(1).enumerate() {
        let y: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        let y = (y + 20.0 * (k as f64 * 3e-4).sin()).round();
        text += &format!("{},{y}\n", k as f64 / 100.0);
    }
    let outcome = characterize(&[named("steps.csv", text)], &Request::default()).unwrap();
    let note = outcome.logs[0]
        .issues
        .iter()
        .find(|i| i.kind.name() == "quantization")
        .unwrap();
    let of_note: f64 = note.text.split(' ').nth(3).unwrap().parse().unwrap();
    let axis = &outcome.logs[0].axes[0];
    let of_table = axis.lsb.unwrap() / axis.noise_scatter;
    assert!(
        (of_note - of_table).abs() < 0.006,
        "{} {of_table}",
        note.text
    );
    assert!(axis.scatter > 5.0 * axis.noise_scatter);
}

#[test]
fn a_model_has_limits_and_the_units_of_the_text() {
    // The x axis has a Gauss–Markov process of T_c = 2 s and σ = 1 rad/s, the y axis white noise alone.
    let mut state = 0.0;
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s]\n");
    let noise = gyros(5, &[1.0, 1.0, 1.0], 40_000, |_| true);
    let keep = (-0.01_f64 / 2.0).exp();
    for line in noise.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        let unit = 12.0_f64.sqrt();
        state = keep * state + (1.0 - keep * keep).sqrt() * unit * cells[1];
        let (x, y) = (state + 0.1 * unit * cells[2], 0.1 * unit * cells[3]);
        text += &format!("{},{x},{y}\n", cells[0]);
    }
    let outcome = characterize(&[named("gm.csv", text)], &Request::default()).unwrap();
    let model = outcome.to_model().unwrap().to_toml();
    let line = model
        .lines()
        .find(|l| l.contains("correlation_time"))
        .unwrap();
    assert!(line.contains("upper_limit"), "{model}");
    assert!(
        sagnac::model::Model::parse(&model, "gm.toml").is_ok(),
        "{model}"
    );
    let quantization = model
        .lines()
        .find(|l| l.starts_with("quantization"))
        .unwrap();
    assert!(
        quantization.contains("arcsec") && !quantization.contains("mrad"),
        "{model}"
    );
}

fn one_sensor() -> Request {
    Request {
        one_sensor: true,
        ..Request::default()
    }
}

fn plain(outcome: &Outcome) -> String {
    let text = outcome.document().render(Style::PLAIN);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn one_sensor_names_what_each_log_shows_and_counts_runs_with_numbers() {
    let short = named("short.csv", gyros(3, &[1.0], 40, |_| true));
    let gap = named(
        "gap.csv",
        gyros(4, &[1.0], 20_000, |k| !(5000..9000).contains(&k)),
    );
    let good = named("good.csv", gyros(5, &[1.0], 20_000, |_| true));
    let stuck: String = gyros(6, &[1.0], 20_000, |_| true)
        .lines()
        .enumerate()
        .map(|(k, l)| {
            let time = l.split(',').next().unwrap_or_default();
            // Zeros of both signs are one value.
            let zero = if k % 2 == 0 { "0" } else { "-0.0" };
            if k == 0 {
                format!("{l}\n")
            } else {
                format!("{time},{zero}\n")
            }
        })
        .collect();
    let stuck = named("stuck.csv", stuck);
    let logs = [gap.clone(), good, short, stuck.clone()];
    let outcome = characterize(&logs, &one_sensor()).unwrap();
    let axis = &outcome.sensor.as_ref().unwrap()[0];
    assert_eq!((axis.runs, axis.used.as_slice()), (2, &[0, 1][..]));
    let words = plain(&outcome);
    for said in [
        "4 logs of one sensor, 2 with numbers;",
        "2 runs know a run-to-run bias to a factor of about 70 only",
        "short.csv: gyro_x left out: 40 samples",
        "stuck.csv: gyro_x left out: one value all the time",
        "gap.csv warning: time gap",
    ] {
        assert!(words.contains(said), "{said}: {words}");
    }
    assert!(!words.contains("The mean's"), "{words}");
    // Nothing to pool is an error, not an agreement.
    let still: String = gyros(6, &[1.0], 15_000, |_| true)
        .lines()
        .map(|l| match l.split_once(',') {
            Some((time, y)) if !y.contains("gyro") => format!("{time},0\n"),
            _ => format!("{l}\n"),
        })
        .collect();
    let two = [stuck, named("still.csv", still)];
    let none = characterize(&two, &one_sensor()).unwrap_err();
    assert_eq!(
        (none.exit_code(), none.what.contains("fewer than two")),
        (1, true)
    );
    let other = named(
        "y.csv",
        gyros(8, &[1.0], 9000, |_| true).replace("gyro_x", "gyro_y"),
    );
    let apart = characterize(&[gap, other], &one_sensor()).unwrap_err();
    assert!(apart.what.contains("no axis in common"), "{apart}");
}

/// A gyro axis with a temperature: noise of 0.01 rad/s about `bias`.
fn warm(seed: u64, celsius: f64, bias: f64) -> NamedLog {
    let noise = gyros(seed, &[0.01, 0.1], 6000, |_| true);
    let mut text = String::from("time [s],gyro_x [rad/s],temperature [degC]\n");
    for line in noise.lines().skip(1) {
        let c: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        text += &format!("{},{},{}\n", c[0], c[1] + bias, c[2] + celsius);
    }
    named(&format!("at{celsius}.csv"), text)
}

#[test]
fn the_runs_temperatures_give_the_bias_of_temperature_to_text_and_model() {
    let bias = |t: f64| 1e-3 * (t - 40.0) + 2e-5 * (t - 40.0_f64).powi(2);
    let logs: Vec<NamedLog> = [10.0, 25.0, 40.0, 55.0, 70.0]
        .iter()
        .zip(1..)
        .map(|(&t, seed)| warm(seed, t, bias(t)))
        .collect();
    let outcome = characterize(&logs, &one_sensor()).unwrap();
    let words = plain(&outcome);
    assert!(words.contains("Bias per K^2"), "{words}");
    assert!(
        words.contains("5 runs, 2 degrees of freedom of which go to the temperature"),
        "{words}"
    );
    let json = outcome.to_json();
    let regressors = json["sensor"]["axes"][0]["regressors"].as_array().unwrap();
    let model = outcome.to_model().unwrap();
    for (power, truth) in [(1, 1e-3), (2, 2e-5)] {
        let entry = model.under(
            sagnac::core::Sensor::Gyro,
            &format!("bias.temperature.{power}"),
            0,
        );
        let entry = entry.unwrap();
        let (value, sigma) = (entry.value.unwrap(), entry.sigma.unwrap());
        assert!(
            (value - truth).abs() < 3.0 * sigma,
            "{power}: {value} {sigma}"
        );
        assert_eq!(regressors[power - 1]["value"].as_f64(), Some(value));
    }
    let toml = model.to_toml();
    let range = toml
        .lines()
        .find(|l| l.starts_with("temperature_range"))
        .unwrap();
    assert!(range.contains("9.9") && range.contains("70.0"), "{range}");
}

#[test]
fn a_log_with_a_term_far_above_the_others_limits_differs() {
    let logs: Vec<NamedLog> = (0..5)
        .map(|k| {
            let mut walk = 0.0;
            let noise = gyros(50 + k, &[1.0, 1.0], 20_000, |_| true);
            let mut text = String::from("time [s],gyro_x [rad/s]\n");
            for line in noise.lines().skip(1) {
                let c: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
                walk += if k == 2 { 0.03 * c[2] } else { 0.0 };
                text += &format!("{},{}\n", c[0], c[1] + walk);
            }
            named(&format!("unit{k}.csv"), text)
        })
        .collect();
    let fleet = characterize(&logs, &Request::default()).unwrap();
    let said = fleet.differences();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("unit2.csv: gyro_x K is more than "),
        "{said:?}"
    );
    assert!(
        characterize(&logs[..2], &Request::default())
            .unwrap()
            .outliers
            .is_empty()
    );
}

#[test]
fn a_bias_that_was_taken_out_is_told_where_the_log_shows_it() {
    let rows = 20_000;
    let cells: Vec<Vec<f64>> = gyros(77, &[1.0, 1.0, 1.0], rows, |_| true)
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|c| c.parse().unwrap()).collect())
        .collect();
    let log = |change: &dyn Fn(usize, usize) -> f64| {
        let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n");
        for (k, row) in cells.iter().enumerate() {
            text += &format!("{}", row[0]);
            for axis in 1..4 {
                text += &format!(",{}", change(k, axis));
            }
            text += "\n";
        }
        characterize(&[named("log.csv", text)], &Request::default()).unwrap()
    };
    let removed = |outcome: &Outcome| -> Vec<(String, f64)> {
        let issues = outcome.logs[0].issues.iter();
        let of = issues.filter(|i| i.kind == sagnac::log::IssueKind::BiasRemoved);
        of.map(|i| {
            (
                i.channel.clone().unwrap_or_default(),
                i.end_s - outcome.logs[0].first_s,
            )
        })
        .collect()
    };
    assert!(removed(&log(&|k, axis| cells[k][axis] + 0.1)).is_empty());
    // The mean of the first 30 s.
    let first = |axis: usize| cells[..3000].iter().map(|r| r[axis]).sum::<f64>() / 3000.0;
    let means = [0.0, first(1), first(2), first(3)];
    let told = removed(&log(&|k, axis| cells[k][axis] - means[axis]));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].0 == "gyro" && (told[0].1 - 30.0).abs() < 0.02,
        "{told:?}"
    );
    // A first-order high-pass at 1 Hz.
    let mut passed = vec![[0.0; 4]; rows];
    for axis in 1..4 {
        let mut low = cells[0][axis];
        for k in 0..rows {
            low += 0.06 * (cells[k][axis] - low);
            passed[k][axis] = cells[k][axis] - low;
        }
    }
    let told = removed(&log(&|k, axis| passed[k][axis]));
    let axes: Vec<&str> = told.iter().map(|t| t.0.as_str()).collect();
    assert_eq!(axes, ["gyro_x", "gyro_y", "gyro_z"]);
    // A remover that shows in one spectrum alone, of a gyro that would see the Earth turn.
    let quiet = |k: usize, axis: usize| {
        1e-5 * if axis == 1 {
            passed[k][1]
        } else {
            cells[k][axis]
        }
    };
    let told = removed(&log(&quiet));
    let axes: Vec<&str> = told.iter().map(|t| t.0.as_str()).collect();
    assert_eq!(axes, ["gyro", "gyro_x"]);
    // With a bias on another axis it is that axis's own matter.
    let told = removed(&log(&|k, axis| {
        quiet(k, axis) + if axis == 3 { 1e-4 } else { 0.0 }
    }));
    assert_eq!(told.len(), 1, "{told:?}");
}

#[test]
fn the_page_shows_what_the_fit_took_out() {
    // 0.5 rad/s/K over 8 K that follow no line in time, a step of 2 rad/s in the middle, under noise of 1/√12 rad/s.
    let noise = gyros(9, &[1.0, 1.0], 40_000, |_| true);
    let mut text = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s],temperature [degC]\n");
    for (k, line) in noise.lines().skip(1).enumerate() {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        let celsius = 25.0 + 4.0 * (k as f64 / 6000.0).sin();
        let x = cells[1] + 0.5 * (celsius - 25.0);
        let y = cells[2] + if k < 20_000 { 0.0 } else { 2.0 };
        text += &format!("{},{x},{y},{celsius}\n", cells[0]);
    }
    let warmed = characterize(&[named("warm.csv", text)], &Request::default()).unwrap();
    let page = warmed.to_page(&PageFacts::default());
    let of = |name: &str| {
        let rows = page.logs[0].parameters.iter();
        rows.clone().find(|r| r.name == name).unwrap()
    };
    let warm = of("Bias per K");
    assert_eq!(warm.per, "/K");
    let within = |cell: &ParameterCell, truth: f64| match cell {
        ParameterCell::Estimate(Shown::Detected { lower, upper, .. }) => {
            (lower..=upper).contains(&&truth)
        }
        _ => false,
    };
    assert!(within(&warm.cells[0], 0.5), "{warm:?}");
    let step = of("Step at 3:20");
    assert!(within(&step.cells[1], 2.0), "{step:?}");
    let html = page.html();
    for words in [
        "°/h/K",
        "rad/s/K",
        "Temperature (gyro x",
        "steps (gyro y) were taken out",
    ] {
        assert!(html.contains(words), "{words}");
    }
    // Where nothing was taken out, nothing is said of it.
    let plain = outcome("all").to_page(&PageFacts::default()).html();
    assert!(
        !plain.contains("taken out by the fit") && !plain.contains("per K"),
        "{plain}"
    );
}

#[test]
fn a_log_that_is_given_twice_does_not_count_twice() {
    let text = gyros(3, &[1.0, 1.0], 2000, |_| true);
    let (a, b) = (named("a.csv", text.clone()), named("b.csv", text));
    let other = named("c.csv", gyros(4, &[1.0, 1.0], 2000, |_| true));
    let same = characterize(&[a.clone(), other.clone(), a.clone()], &one_sensor()).unwrap_err();
    assert_eq!(
        (same.exit_code(), same.what.as_str()),
        (1, "a.csv is given twice: it would count twice")
    );
    let copy = characterize(&[a.clone(), b.clone()], &one_sensor()).unwrap_err();
    assert_eq!(
        copy.what,
        "a.csv and b.csv hold the same samples: they would count twice"
    );
    // Of different sensors each counts for itself.
    assert!(characterize(&[a.clone(), b], &Request::default()).is_ok());
    assert!(characterize(&[a, other], &one_sensor()).is_ok());
}

#[test]
fn axes_that_nothing_waited_for_are_named() {
    // A walk on x alone, that stands clear.
    let mut walk = 0.0;
    let text: String = gyros(3, &[1.0, 1.0, 1.0], 20_000, |_| true)
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if let Ok(x) = cells[1].parse::<f64>() {
                walk += x;
                cells[1] = (walk + x).to_string();
            }
            cells.join(",") + "\n"
        })
        .collect();
    let outcome = characterize(&[named("walk.csv", text)], &Request::default()).unwrap();
    let asked = |list: &[(&str, f64)]| {
        let list: Vec<(String, f64)> = list.iter().map(|(n, p)| ((*n).to_owned(), *p)).collect();
        let state = State::of(&outcome.logs[0], Some(&list));
        let screen = state.document().render(Style::PLAIN);
        (state.is_reached(), state.line(), screen)
    };
    let (is_reached, line, screen) = asked(&[("rate_random_walk", 0.9)]);
    assert!(is_reached, "{line}");
    let words = "not seen and not waited for: K of gyro y, z";
    assert!(line.ends_with(words), "{line}");
    assert!(screen.contains(words), "{screen}");
    // While something is waited for, and where every axis has the term, nothing is said of it.
    let (is_reached, line, _) = asked(&[("rate_random_walk", 1e-6)]);
    assert!(!is_reached && !line.contains("not waited"), "{line}");
    let (is_reached, line, _) = asked(&[("angle_random_walk", 0.9)]);
    assert!(is_reached && !line.contains("not waited"), "{line}");
}

#[test]
fn values_that_a_log_repeats_are_told() {
    let held = |times: usize| {
        let text: String = gyros(3, &[1.0, 1.0], 20_000, |_| true);
        let rows: Vec<&str> = text.lines().skip(1).collect();
        let mut out = String::from("time [s],gyro_x [rad/s],gyro_y [rad/s]\n");
        for k in 0..rows.len() {
            let (time, own) = rows[k].split_once(',').unwrap();
            let x = rows[k - k % times].split(',').nth(1).unwrap();
            let y = own.split(',').nth(1).unwrap();
            out += &format!("{time},{x},{y}\n");
        }
        let outcome = characterize(&[named("held.csv", out)], &Request::default()).unwrap();
        outcome.document().render(Style::PLAIN)
    };
    let text = held(4);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("every value of gyro_x stands for 4 samples: the sensor measures at 25 Hz"),
        "{text}"
    );
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    assert!(!held(1).contains("stands for"));
}
