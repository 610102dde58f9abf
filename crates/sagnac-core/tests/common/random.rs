//! Random models and motions for the round trip. Seeds are declared, never searched.
#![allow(dead_code, reason = "each test uses its part")]

use sagnac_core::{Compensation, OffDiagonal, Real, SensorModel, TemperatureSpline, Triad, Truth};

/// SplitMix64, enough for tests.
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform between two numbers.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, p: f64) -> bool {
        self.uniform(0.0, 1.0) < p
    }

    fn vector(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| self.uniform(-size, size))
    }
}

fn random_triad(rng: &mut Rng, range: f64, size: f64) -> Triad<f64> {
    let mut t = Triad::default();
    t.range.limit = [range; 3];
    let mut some = |p: f64| {
        if rng.chance(p) {
            size * 10.0_f64.powf(rng.uniform(-2.0, 0.0))
        } else {
            0.0
        }
    };
    let sizes: [f64; 9] = [0.7; 9].map(&mut some);
    t.bias.fixed = rng.vector(0.2 * range * sizes[0]);
    t.scale_factor.fixed = rng.vector(0.15 * sizes[1]);
    t.misalignment.elements =
        OffDiagonal::from_array([0; 6].map(|_| rng.uniform(-0.04, 0.04) * sizes[2]));
    t.cross_axis.elements =
        OffDiagonal::from_array([0; 6].map(|_| rng.uniform(-0.02, 0.02) * sizes[3]));
    t.nonlinearity.quadratic = rng.vector(0.03 * sizes[4] / range);
    t.nonlinearity.cubic = rng.vector(0.02 * sizes[5] / (range * range));
    t.asymmetry.difference = rng.vector(0.05 * sizes[6]);
    let kind = rng.uniform(0.0, 1.0);
    if kind < 0.3 {
        let n = 1 + (rng.next() % 8) as usize;
        for i in 0..n {
            let scale = 60.0_f64.powi(-(i as i32) - 1);
            t.bias.temperature.polynomial[i] = rng.vector(0.03 * range * sizes[7] * scale);
            t.scale_factor.temperature.polynomial[i] = rng.vector(0.02 * sizes[8] * scale);
        }
    } else if kind < 0.5 {
        let knots = [-30.0, 0.0, 22.0, 50.0, 80.0];
        let values = [0; 5].map(|_| rng.vector(0.02 * range * sizes[7]));
        t.bias.temperature.spline = TemperatureSpline::new(&knots, &values).ok();
        let values = [0; 5].map(|_| rng.vector(0.01 * sizes[8]));
        t.scale_factor.temperature.spline = TemperatureSpline::new(&knots, &values).ok();
    }
    t
}

fn sized_model(rng: &mut Rng, size: f64) -> SensorModel<f64> {
    let rate = [2000.0, 450.0, 250.0, 100.0][(rng.next() % 4) as usize] * super::models::DEG_S;
    let force = [16.0, 8.0, 4.0, 40.0][(rng.next() % 4) as usize] * super::models::G;
    let mut m = SensorModel {
        gyro: random_triad(rng, rate, size),
        accel: random_triad(rng, force, size),
        temperature_range_c: Some([-30.0, 80.0]),
        ..SensorModel::default()
    };
    if rng.chance(0.7) {
        m.gyro_g_sensitivity.matrix = [0; 3].map(|_| rng.vector(0.03 * size * rate / force));
    }
    if rng.chance(0.5) {
        m.gyro_g2_sensitivity.matrix = [0; 3]
            .map(|_| [0; 6].map(|_| rng.uniform(-0.004, 0.004) * size * rate / (force * force)));
    }
    if rng.chance(0.7) {
        m.accel_axis_offset.position = [0; 3].map(|_| rng.vector(0.05 * size));
    }
    m
}

/// A model of any kind of part; most are inside the bound.
pub(crate) fn random_model(rng: &mut Rng) -> SensorModel<f64> {
    let size = 10.0_f64.powf(rng.uniform(-1.5, 0.3));
    sized_model(rng, size)
}

/// A model that is mostly far outside.
pub(crate) fn wild_model(rng: &mut Rng) -> SensorModel<f64> {
    let size = rng.uniform(2.0, 10.0);
    sized_model(rng, size)
}

/// Whether the model is inside the bound in both precisions.
pub(crate) fn inside(model: &SensorModel<f64>) -> bool {
    fn one<T: Real>(model: &SensorModel<f64>) -> bool {
        Compensation::new(&model.convert::<T>(), T::from_f64(0.01))
            .is_ok_and(|inverse| inverse.bound().is_some_and(sagnac_core::Bound::is_inside))
    }
    one::<f64>(model) && one::<f32>(model)
}

/// A motion whose output stays within the range.
pub(crate) fn truth_within(rng: &mut Rng, model: &SensorModel<f64>) -> Truth<f64> {
    let forward = sagnac_core::Measurement::new(model);
    let rate = model.gyro.range.largest().unwrap_or(10.0);
    let force = model.accel.range.largest().unwrap_or(100.0);
    let mut share = 10.0_f64.powf(rng.uniform(-3.0, 0.0));
    let mut truth = Truth {
        specific_force: rng.vector(force),
        angular_rate: rng.vector(rate),
        angular_acceleration: rng.vector(10.0 * rate),
        temperature_c: rng.uniform(-30.0, 80.0),
    };
    for _ in 0..60 {
        let scaled = Truth {
            specific_force: truth.specific_force.map(|x| x * share),
            angular_rate: truth.angular_rate.map(|x| x * share),
            angular_acceleration: truth.angular_acceleration.map(|x| x * share),
            ..truth
        };
        let y = forward.corrupt(&scaled);
        let fits = |y: [f64; 3], range: f64| y.iter().all(|x| x.abs() < 0.999 * range);
        if fits(y.gyro, rate) && fits(y.accel, force) {
            return scaled;
        }
        share *= 0.8;
    }
    truth.specific_force = [0.0; 3];
    truth.angular_rate = [0.0; 3];
    truth.angular_acceleration = [0.0; 3];
    truth
}
