//! `correct` on logs in memory: blocks, gaps, absent channels, flags, NaN, saturated spans.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::cell::RefCell;
use std::rc::Rc;

use sagnac::Error;
use sagnac::core::{Measurement, Truth};
use sagnac::correct::{CorrectOutcome, CorrectRequest, correct};
use sagnac::log::{self, Block, Channel, Layout, LogReader, LogWriter, Stamps};
use sagnac::model::Model;

const DT_S: f64 = 0.01;

const MODEL: &str = r#"
schema = 1
name = "a"
sample_rate = "100 Hz"
temperature_range = ["0 degC", "50 degC"]
[gyro]
range = "450 deg/s"
[gyro.bias]
fixed = ["0.1 rad/s", "-0.2 rad/s", "0 rad/s"]
temperature = [["0.001 rad/s/K", "0 rad/s/K", "0 rad/s/K"]]
[accel]
range = "10 g"
[accel.scale_factor]
fixed = ["1000 ppm", "0 ppm", "-2000 ppm"]
[accel.axis_offset]
x = ["0 m", "0.05 m", "0 m"]
y = ["0.02 m", "0 m", "0.03 m"]
"#;

fn model() -> Model {
    Model::parse(MODEL, "a.toml").unwrap()
}

struct Rows {
    layout: Layout,
    times_s: Vec<f64>,
    columns: Vec<Vec<f64>>,
    at: usize,
    block: usize,
}

impl LogReader for Rows {
    fn layout(&self) -> &Layout {
        &self.layout
    }
    fn read_block(&mut self, block: &mut Block) -> Result<bool, log::Error> {
        let end = (self.at + self.block).min(self.times_s.len());
        block.rows = end - self.at;
        block.stamps = Stamps::Seconds(self.times_s[self.at..end].to_vec());
        block.columns = self
            .columns
            .iter()
            .map(|c| c[self.at..end].to_vec())
            .collect();
        self.at = end;
        Ok(block.rows > 0)
    }
}

type Written = Rc<RefCell<Vec<Vec<f64>>>>;

struct Sink(Written);

impl LogWriter for Sink {
    fn write_block(&mut self, block: &Block) -> Result<(), log::Error> {
        let mut all = self.0.borrow_mut();
        all.resize(block.columns.len(), Vec::new());
        for (all, part) in all.iter_mut().zip(&block.columns) {
            all.extend_from_slice(&part[..block.rows]);
        }
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<Vec<String>, log::Error> {
        Ok(Vec::new())
    }
}

fn rows(times_s: &[f64], columns: &[(&str, Vec<f64>)], block: usize) -> Rows {
    Rows {
        layout: Layout {
            channels: columns
                .iter()
                .map(|(name, _)| Channel::named(name))
                .collect(),
            has_time: true,
            ..Layout::default()
        },
        times_s: times_s.to_vec(),
        columns: columns.iter().map(|(_, values)| values.clone()).collect(),
        at: 0,
        block,
    }
}

fn run(model: &Model, mut rows: Rows, flags: bool) -> (CorrectOutcome, Vec<Vec<f64>>) {
    let written: Written = Rc::default();
    let outcome = correct(
        model,
        &mut rows,
        &mut |_: &Layout| -> Result<Box<dyn LogWriter>, Error> {
            Ok(Box::new(Sink(Rc::clone(&written))))
        },
        CorrectRequest { flags },
    )
    .unwrap();
    let columns = written.borrow().clone();
    (outcome, columns)
}

type Columns = Vec<(&'static str, Vec<f64>)>;

/// Constant angular acceleration: the parabola's slope is exact up to rounding.
fn spin(times_s: &[f64]) -> (Vec<Truth<f64>>, Columns) {
    let forward = Measurement::new(&model().to_core().unwrap());
    let truth: Vec<Truth<f64>> = times_s
        .iter()
        .map(|t| Truth {
            specific_force: [1.0, -2.0, -9.5],
            angular_rate: [0.2 + 0.5 * t, 0.1 - 0.3 * t, 0.8 * t],
            angular_acceleration: [0.5, -0.3, 0.8],
            temperature_c: 30.0,
        })
        .collect();
    let readings: Vec<_> = truth.iter().map(|t| forward.corrupt(t)).collect();
    let of = |k: usize| -> Vec<f64> {
        readings
            .iter()
            .map(|r| if k < 3 { r.gyro[k] } else { r.accel[k - 3] })
            .collect()
    };
    let names = [
        "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z",
    ];
    let mut columns: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(k, name)| (*name, of(k)))
        .collect();
    columns.push(("temperature", vec![30.0; times_s.len()]));
    (truth, columns)
}

fn even(count: usize) -> Vec<f64> {
    (1..=count).map(|k| k as f64 * DT_S).collect()
}

#[test]
fn slope_of_the_parabola_undoes_the_tangential_size_effect_in_any_block() {
    let times_s = even(57);
    let (truth, columns) = spin(&times_s);
    let mut first: Option<Vec<Vec<f64>>> = None;
    for block in [1, 2, 3, 7, 57] {
        let (outcome, out) = run(&model(), rows(&times_s, &columns, block), false);
        assert_eq!(outcome.samples, 57);
        for (k, t) in truth.iter().enumerate() {
            for axis in 0..3 {
                // The first solve leaves the lever's share of ω̇ out, which the gyro does not feel here.
                assert!((out[axis][k] - t.angular_rate[axis]).abs() < 1e-12);
                assert!((out[3 + axis][k] - t.specific_force[axis]).abs() < 1e-10);
            }
        }
        // The interval is that of the first block's stamps, which differ by roundings.
        let same = first.get_or_insert_with(|| out.clone());
        for (a, b) in same.iter().flatten().zip(out.iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "block of {block}: {a} {b}");
        }
    }
}

#[test]
fn rows_on_either_side_of_a_gap_are_not_joined() {
    let mut times_s = even(40);
    for t in &mut times_s[20..] {
        *t += 5.0;
    }
    let (truth, mut columns) = spin(&times_s);
    // The spin jumps over the gap; each stretch by itself still has its own slope.
    let (_, out) = run(&model(), rows(&times_s, &columns, 9), false);
    for k in 0..40 {
        assert!(
            (out[3][k] - truth[k].specific_force[0]).abs() < 1e-10,
            "{k}"
        );
    }
    // A row alone between two gaps has ω̇ = 0.
    times_s.truncate(3);
    times_s[1] += 2.0;
    times_s[2] += 4.0;
    for (_, values) in &mut columns {
        values.truncate(3);
    }
    let (outcome, out) = run(&model(), rows(&times_s, &columns, 3), false);
    assert_eq!(outcome.samples, 3);
    let lost = (out[3][1] - truth[1].specific_force[0]).abs();
    assert!((lost - 0.05 * 0.8).abs() < 1e-3, "{lost}");
}

#[test]
fn absent_channels_are_corrected_without_and_told() {
    let times_s = even(12);
    let (truth, columns) = spin(&times_s);
    let notes = |outcome: &CorrectOutcome| outcome.notes.join("\n");
    let (outcome, out) = run(&model(), rows(&times_s, &columns[..3], 5), false);
    assert_eq!(out.len(), 3);
    assert_eq!(outcome.changes.len(), 3);
    assert!(notes(&outcome).contains("no temperature"));
    // T = T0 in place of 30 degC: 5 K of 0.001 rad/s/K.
    assert!((out[0][0] - truth[0].angular_rate[0] - 0.005).abs() < 1e-12);
    let (outcome, out) = run(&model(), rows(&times_s, &columns[3..], 5), false);
    assert_eq!(outcome.changes.len(), 3);
    assert!(notes(&outcome).contains("no gyro"), "{}", notes(&outcome));
    assert!((out[2][0] + 9.5).abs() < 1e-12);
}

#[test]
fn flags_mark_saturation_temperature_and_numbers_that_are_not() {
    let times_s = even(400);
    let (_, mut columns) = spin(&even(400));
    let range = 450_f64.to_radians();
    for k in 100..110 {
        columns[2].1[k] = range;
    }
    columns[3].1[50] = -98.0665;
    columns[4].1[60] = f64::NAN;
    columns[6].1[70] = 60.0;
    let (outcome, out) = run(&model(), rows(&times_s, &columns, 64), true);
    let flags = out.last().unwrap();
    let flag = |k: usize| flags[k] as u32;
    assert_eq!(flag(0), 0);
    assert_eq!(flag(50) & 2, 2);
    assert_eq!(flag(60) & 16, 16);
    assert!(out[4][60].is_nan() && out[0][60].is_finite());
    assert_eq!(flag(70) & 4, 4);
    assert!((100..110).all(|k| flag(k) & 1 == 1) && flag(110) & 1 == 0);
    assert_eq!(outcome.saturated, 11);
    assert_eq!(outcome.to_json()["saturated"], 11);
    assert!(outcome.outside_validity >= 2);
    assert!(outcome.changes.iter().all(|change| change.mean.is_finite()));
    let text = outcome
        .document()
        .render(sagnac::report::text::Style::PLAIN);
    assert!(text.contains("gyro_z saturated"), "{text}");
    assert!(text.contains("10 samples at 450 deg/s"), "{text}");
}
