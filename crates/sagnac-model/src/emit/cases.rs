//! The cases that emitted source is tested with: motions inside the range, and what is flagged.

use sagnac_core::{Compensation, Measurement, Reading, Real, Sensor, SensorModel, Truth};

/// A stored case: raw output, the result wanted, and the scale of the allowed error.
pub(super) struct Case<T> {
    pub(super) raw: Reading<T>,
    pub(super) gyro: [T; 3],
    pub(super) accel: [T; 3],
    pub(super) flags: u32,
    /// s of gyro and accelerometer: the largest of truth, output and bias.
    pub(super) scale: [T; 2],
}

/// Numbers between −1 and 1 that look like chance and are always the same.
struct Spread(u64);

impl Spread {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn size<T: Real>(v: [T; 3]) -> T {
    sagnac_core::vector::norm_inf(v)
}

pub(super) fn cases<T: Real>(model: &SensorModel<T>, inverse: &Compensation<T>) -> Vec<Case<T>> {
    let forward = Measurement::new(model);
    let range = |sensor, otherwise: f64| {
        inverse
            .range(sensor)
            .map_or(otherwise, sagnac_core::Real::to_f64)
    };
    let (rate, force) = (range(Sensor::Gyro, 2.0), range(Sensor::Accel, 20.0));
    let [low, high] = model
        .temperature_range_c
        .map_or([-20.0, 60.0], |r| r.map(sagnac_core::Real::to_f64));
    let mut spread = Spread(1);
    let mut cases = Vec::new();
    for i in 0..16 {
        let part = [0.1, 0.3, 0.5, 0.6][i % 4];
        let mut v = |of: f64| [0; 3].map(|_| T::from_f64(of * part * spread.next()));
        let truth = Truth {
            specific_force: v(force),
            angular_rate: v(rate),
            angular_acceleration: v(rate * 5.0),
            temperature_c: T::from_f64(low + (high - low) * (i as f64 + 0.5) / 16.0),
        };
        let raw = forward.corrupt(&truth);
        let back = inverse.correct(&raw);
        let bias = |sensor| size(forward.errors(sensor).bias(truth.temperature_c));
        let scale = |u: [T; 3], y: [T; 3], sensor| size(u).larger(size(y)).larger(bias(sensor));
        let inside = back.flags == 0;
        cases.push(Case {
            raw,
            // Inside, what went in; where flagged, what the library gives.
            gyro: if inside {
                truth.angular_rate
            } else {
                back.gyro
            },
            accel: if inside {
                truth.specific_force
            } else {
                back.accel
            },
            flags: back.flags,
            scale: [
                scale(truth.angular_rate, raw.gyro, Sensor::Gyro),
                scale(truth.specific_force, raw.accel, Sensor::Accel),
            ],
        });
    }
    let still = Truth {
        specific_force: [T::ZERO, T::ZERO, T::from_f64(-9.80665)],
        temperature_c: model.reference_temperature_c,
        ..Truth::default()
    };
    let rest = forward.corrupt(&still);
    let changes: [fn(&mut Reading<T>, f64, f64); 8] = [
        |raw, rate, _| raw.gyro[0] = T::from_f64(rate),
        |raw, _, force| raw.accel[2] = T::from_f64(-force),
        |raw, _, _| raw.temperature_c = T::from_f64(150.0),
        |raw, _, _| raw.gyro[1] = T::NAN,
        |raw, _, _| raw.accel[0] = T::INFINITY,
        |raw, _, _| raw.temperature_c = T::NAN,
        |raw, _, _| raw.gyro[0] = T::from_f64(1e30),
        |raw, _, _| raw.accel[1] = T::from_f64(-1e30),
    ];
    for change in changes {
        let mut raw = rest;
        change(&mut raw, rate, force);
        let back = inverse.correct(&raw);
        let of = |v: [T; 3]| if size(v).is_finite() { size(v) } else { T::ONE };
        cases.push(Case {
            raw,
            gyro: back.gyro,
            accel: back.accel,
            flags: back.flags,
            scale: [
                of(raw.gyro).larger(of(back.gyro)),
                of(raw.accel).larger(of(back.accel)),
            ],
        });
    }
    cases
}
