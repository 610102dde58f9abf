//! Blocks give the bits of single samples, whatever the length and the vectors of the processor.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use common::models;
use common::random::{Rng, random_model, truth_within};
use sagnac_core::{
    Compensation, CorrectedBlock, Measurement, OutputBlock, Reading, ReadingBlock, Real,
    SensorModel, Truth, TruthBlock,
};

fn columns<T: Copy>(rows: &[[T; 3]]) -> [Vec<T>; 3] {
    [0, 1, 2].map(|k| rows.iter().map(|row| row[k]).collect())
}

fn slices<T>(columns: &[Vec<T>; 3]) -> [&[T]; 3] {
    [&columns[0], &columns[1], &columns[2]]
}

fn bits<T: Real>(v: [T; 3]) -> [u64; 3] {
    // All NaN are one: their payload says nothing.
    v.map(|x| {
        if x.to_f64().is_nan() {
            u64::MAX
        } else {
            x.to_f64().to_bits()
        }
    })
}

fn check<T: Real>(model: &SensorModel<f64>, truths: &[Truth<f64>]) {
    let model = model.convert::<T>();
    let forward = Measurement::new(&model);
    let Ok(inverse) = Compensation::new(&model, T::from_f64(0.01)) else {
        return;
    };
    let v = |v: [f64; 3]| v.map(T::from_f64);
    let truths: Vec<Truth<T>> = truths
        .iter()
        .map(|t| Truth {
            specific_force: v(t.specific_force),
            angular_rate: v(t.angular_rate),
            angular_acceleration: v(t.angular_acceleration),
            temperature_c: T::from_f64(t.temperature_c),
        })
        .collect();
    let column =
        |get: fn(&Truth<T>) -> [T; 3]| columns(&truths.iter().map(get).collect::<Vec<_>>());
    let (f, w, wdot) = (
        column(|t| t.specific_force),
        column(|t| t.angular_rate),
        column(|t| t.angular_acceleration),
    );
    let temperature: Vec<T> = truths.iter().map(|t| t.temperature_c).collect();
    let n = truths.len();
    let new = || [0; 3].map(|_| vec![T::ZERO; n]);
    let (mut gyro, mut accel) = (new(), new());
    let ([gx, gy, gz], [ax, ay, az]) = (&mut gyro, &mut accel);
    let done = forward.corrupt_block(
        &TruthBlock {
            specific_force: slices(&f),
            angular_rate: slices(&w),
            angular_acceleration: Some(slices(&wdot)),
            temperature_c: Some(&temperature),
        },
        &mut OutputBlock {
            gyro: [gx, gy, gz],
            accel: [ax, ay, az],
        },
    );
    assert_eq!(done, n);
    let (mut w_back, mut f_back, mut flags) = (new(), new(), vec![0; n]);
    let ([gx, gy, gz], [ax, ay, az]) = (&mut w_back, &mut f_back);
    let done = inverse.correct_block(
        &ReadingBlock {
            gyro: slices(&gyro),
            accel: slices(&accel),
            gyro_rate: Some(slices(&wdot)),
            temperature_c: Some(&temperature),
        },
        &mut CorrectedBlock {
            gyro: [gx, gy, gz],
            accel: [ax, ay, az],
            flags: &mut flags,
        },
    );
    assert_eq!(done, n);
    for (i, truth) in truths.iter().enumerate() {
        let at = |c: &[Vec<T>; 3]| [c[0][i], c[1][i], c[2][i]];
        let raw: Reading<T> = forward.corrupt(truth);
        assert_eq!(bits(raw.gyro), bits(at(&gyro)));
        assert_eq!(bits(raw.accel), bits(at(&accel)));
        let back = inverse.correct(&raw);
        assert_eq!(bits(back.gyro), bits(at(&w_back)));
        assert_eq!(bits(back.accel), bits(at(&f_back)));
        assert_eq!(back.flags, flags[i]);
    }
}

#[test]
fn blocks_equal_single_samples_bit_for_bit() {
    let mut rng = Rng::new(5);
    let mut all = vec![
        models::example(),
        models::consumer(),
        SensorModel::default(),
    ];
    all.extend((0..60).map(|_| random_model(&mut rng)));
    for (m, model) in all.iter().enumerate() {
        // Lengths around the 32 of a piece, and a long one.
        let n = [1, 31, 32, 33, 100, 7][m % 6];
        let mut truths: Vec<_> = (0..n).map(|_| truth_within(&mut rng, model)).collect();
        if n > 5 {
            truths[1].angular_rate[2] = f64::NAN;
            truths[2].specific_force[0] = f64::INFINITY;
            truths[3].temperature_c = 300.0;
            truths[4].temperature_c = f64::NAN;
            truths[5].angular_rate = [500.0; 3];
        }
        check::<f64>(model, &truths);
        check::<f32>(model, &truths);
    }
}

/// What the rounds make of readings far outside is a number, or NaN with its flag, in both forms.
#[test]
fn results_that_are_no_numbers_are_flagged() {
    fn check<T: Real>(model: &SensorModel<f64>, huge: f64) -> u32 {
        let inverse = Compensation::new(&model.convert::<T>(), T::from_f64(0.01)).unwrap();
        let n = 70;
        let mut gyro = [0; 3].map(|_| vec![T::from_f64(0.1); n]);
        let mut accel = [0; 3].map(|_| vec![T::from_f64(1.0); n]);
        gyro[0][40] = T::from_f64(huge);
        accel[2][50] = T::from_f64(-huge);
        let new = || [0; 3].map(|_| vec![T::ZERO; n]);
        let (mut w, mut f, mut flags) = (new(), new(), vec![0; n]);
        let ([gx, gy, gz], [ax, ay, az]) = (&mut w, &mut f);
        inverse.correct_block(
            &ReadingBlock {
                gyro: slices(&gyro),
                accel: slices(&accel),
                gyro_rate: None,
                temperature_c: None,
            },
            &mut CorrectedBlock {
                gyro: [gx, gy, gz],
                accel: [ax, ay, az],
                flags: &mut flags,
            },
        );
        for i in 0..n {
            let at = |c: &[Vec<T>; 3]| [c[0][i], c[1][i], c[2][i]];
            let back = inverse.correct(&Reading {
                gyro: at(&gyro),
                accel: at(&accel),
                gyro_rate: [T::ZERO; 3],
                temperature_c: T::from_f64(model.reference_temperature_c),
            });
            assert_eq!(
                (bits(back.gyro), bits(back.accel), back.flags),
                (bits(at(&w)), bits(at(&f)), flags[i])
            );
            let is_finite = |v: [T; 3]| v.iter().all(|x| x.is_finite());
            for triad in [back.gyro, back.accel] {
                assert!(is_finite(triad) || bits(triad) == [u64::MAX; 3]);
            }
            let is_whole = is_finite(back.gyro) && is_finite(back.accel);
            assert_eq!(is_whole, back.flags & sagnac_core::flags::NOT_FINITE == 0);
        }
        flags[40] & flags[50]
    }
    let mut cubic = SensorModel::default();
    cubic.gyro.nonlinearity.cubic = [1e-4; 3];
    cubic.accel.nonlinearity.cubic = [1e-6; 3];
    assert_eq!(check::<f64>(&cubic, 1e200), 8 | 16);
    assert_eq!(check::<f32>(&cubic, 1e30), 8 | 16);
    let mut rng = Rng::new(8);
    for _ in 0..40 {
        let model = random_model(&mut rng);
        if common::random::inside(&model) {
            check::<f64>(&model, 1e200);
            check::<f32>(&model, 1e30);
        }
    }
}

#[test]
fn the_shortest_channel_counts() {
    let inverse = Compensation::new(&SensorModel::<f64>::default(), 0.01).unwrap();
    let (long, short) = ([1.0; 50], [1.0; 40]);
    let (mut w, mut f) = ([0; 3].map(|_| vec![7.0; 45]), [0; 3].map(|_| vec![7.0; 45]));
    let mut flags = vec![9; 45];
    let ([gx, gy, gz], [ax, ay, az]) = (&mut w, &mut f);
    let n = inverse.correct_block(
        &ReadingBlock {
            gyro: [&long, &long, &short],
            accel: [&long; 3],
            gyro_rate: None,
            temperature_c: None,
        },
        &mut CorrectedBlock {
            gyro: [gx, gy, gz],
            accel: [ax, ay, az],
            flags: &mut flags,
        },
    );
    assert_eq!(n, 40);
    assert_eq!((w[0][39], w[0][40], flags[39], flags[40]), (1.0, 7.0, 0, 9));
}
